//! What a loader assumes where a file is not as its format says.

use std::fmt;

use crate::error::SceneError;

/// A fault of a scene's files that others read over, and what is assumed in its place.
///
/// Displays as one line: the first fault of its kind with its place, what is assumed, and how often.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The first fault of this kind.
    pub first: SceneError,
    /// What is assumed; one sentence a kind.
    pub assumed: &'static str,
    /// How many faults there are of this kind.
    pub count: u64,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, assumed, count } = self;
        write!(f, "{first}; {assumed}")?;
        match count {
            1 => Ok(()),
            _ => write!(f, " ({count} times)"),
        }
    }
}

/// The warnings of one load: one a kind.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    strict: bool,
    found: Vec<Warning>,
}

impl Warnings {
    /// None yet. If `strict`, the first becomes an error.
    pub(crate) fn new(strict: bool) -> Self {
        Self { strict, found: Vec::new() }
    }

    /// Notes that `assumed` is assumed in the place of a fault. The kind is that of the sentence: the
    /// fault itself is asked for only if it is the first of it, as there may be millions.
    ///
    /// # Errors
    /// The fault, if faults are to be errors.
    pub(crate) fn note(
        &mut self,
        assumed: &'static str,
        fault: impl FnOnce() -> SceneError,
    ) -> Result<(), SceneError> {
        if self.strict {
            return Err(fault());
        }
        match self.found.iter_mut().find(|warning| warning.assumed == assumed) {
            Some(warning) => warning.count += 1,
            None => self.found.push(Warning { first: fault(), assumed, count: 1 }),
        }
        Ok(())
    }

    /// In the order of their first faults.
    pub(crate) fn found(self) -> Vec<Warning> {
        self.found
    }
}
