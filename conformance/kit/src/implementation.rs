//! An implementation in process, as requests and answers.

use crate::error::Error;

/// A configured implementation: requests in, answers out, both lines without their newlines.
pub trait Implementation: Send {
    /// The list after `observes=`.
    fn observes(&self) -> String;

    /// Appends the answer to a request.
    ///
    /// # Errors
    /// What would be right, where the line is no request.
    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error>;
}
