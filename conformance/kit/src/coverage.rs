//! What sessions exercise, of all that can be.

use crate::session::Session;
use std::fmt;

/// Counts the cases that sessions reach.
pub trait Coverage {
    /// Counts a session, if its configuration is one that is covered.
    fn add(&mut self, session: &Session);

    /// A line for each thing that is counted.
    fn counts(&self) -> Vec<CoverageCount>;
}

/// How many cases of something were reached.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct CoverageCount {
    /// Of what.
    pub what: String,
    /// Cases that were reached.
    pub reached: usize,
    /// Cases that there are.
    pub all: usize,
}

impl fmt::Display for CoverageCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} of {}", self.what, self.reached, self.all)
    }
}
