//! What is particular to a kind of implementation.

use crate::level::Level;
use crate::serve::{Served, Unsupported};
use crate::session::Session;
use std::fmt;

/// A kind of implementation: its requests, its suites, and how its answers are compared.
pub trait Kind: Sync {
    /// The name, as in the hello: `saarcor-vm`.
    fn name(&self) -> &'static str;

    /// The hello: name and version of the protocol.
    fn hello(&self) -> &'static str;

    /// The name's short form, with which those of its sessions begin: `vm`.
    fn prefix(&self) -> &'static str {
        self.name().trim_start_matches("saarcor-")
    }

    /// The levels at which it is judged, the lowest first.
    fn levels(&self) -> &'static [Level];

    /// Suite files by their names, in an order in which what comes later builds on what came before.
    fn suites(&self) -> &'static [(&'static str, &'static str)];

    /// The random session of a seed.
    fn random(&self, seed: u64, requests: usize) -> Session;

    /// Sessions of recorded frames, each of at most so many of its reads; none where there are no traces.
    fn recorded(&self, _requests: usize) -> Vec<Session> {
        Vec::new()
    }

    /// The session with a tolerance of so many thousandths, where the kind has one.
    fn with_tolerance(&self, session: Session, _tolerance: u32) -> Session {
        session
    }

    /// Whether the session is one of this kind.
    ///
    /// # Errors
    /// What is wrong, and what would be right.
    fn check(&self, session: &Session) -> Result<(), String>;

    /// The model, or the naive reference, of a configuration.
    ///
    /// # Errors
    /// The key whose value is wrong.
    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Served>, Unsupported>;

    /// The keys of a configuration.
    fn keys(&self) -> Vec<&'static str>;

    /// What compares the answers of an implementation with those of the model, one by one, as far as
    /// `observes` goes.
    ///
    /// # Errors
    /// What is wrong with `observes`.
    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, String>;

    /// Configurations that are simpler than one, the boldest first.
    fn simpler_configs(&self, config: &str) -> Vec<String>;

    /// Requests that are simpler than one, the boldest first.
    fn simpler_requests(&self, session: &Session, request: &[u8]) -> Vec<String>;

    /// Sessions that are simpler as a whole, where it takes several requests to say something simpler.
    fn simpler_sessions(&self, _session: &Session) -> Vec<Session> {
        Vec::new()
    }

    /// The model's state before a request, for a person.
    fn state_before(&self, session: &Session, request: usize) -> Vec<String>;

    /// What a session exercises of the model, counted in the small geometry; none where it has another.
    fn coverage(&self) -> Box<dyn Coverage>;
}

/// What sessions are judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oracle {
    /// The specification.
    Model,
    /// The naive reference, which shares none of the model's logic.
    Naive,
}

/// Compares answers one by one.
pub trait Comparison {
    /// The levels that can be judged by what is observed.
    fn observed(&self, level: Level) -> bool;

    /// Compares the answer to the next request with the model's; differences are handed to `found`.
    ///
    /// # Errors
    /// What would be right, where the answer is not in the form of the protocol.
    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), String>;

    /// The model's answer to the request that was compared last.
    fn expected(&self) -> &[u8];
}

/// How an answer differs from the model's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The lowest level that it breaks.
    pub level: Level,
    /// What differs, in a sentence.
    pub says: String,
    /// The requirement that it breaks by all that is known of the session.
    pub requirement: &'static str,
}

/// What sessions exercise, of all that can be.
pub trait Coverage {
    /// Counts a session, if it is of a geometry that is covered.
    fn add(&mut self, session: &Session);

    /// A line for each thing that is counted.
    fn rows(&self) -> Vec<Covered>;
}

/// How much was exercised of what.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Covered {
    /// What.
    pub what: String,
    /// Cases that were exercised.
    pub reached: usize,
    /// Cases that there are.
    pub all: usize,
}

impl fmt::Display for Covered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} of {}", self.what, self.reached, self.all)
    }
}
