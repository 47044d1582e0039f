//! What is particular to a kind of implementation.

use crate::comparison::Comparison;
use crate::coverage::Coverage;
use crate::error::Error;
use crate::implementation::Implementation;
use crate::level::Level;
use crate::session::Session;
use crate::sizes::{Extent, SizedSession};
use std::borrow::Cow;

/// What shrinking may try, one after the other.
pub type Candidates<'a, T> = Box<dyn Iterator<Item = T> + 'a>;

/// A kind of implementation: its requests, its suites, and how its answers are compared.
pub trait Kind: Sync {
    /// The hello: name and version of the protocol, such as `saarcor-vm 1`.
    fn hello(&self) -> &'static str;

    /// The name, as in the hello: `saarcor-vm`.
    fn name(&self) -> &'static str {
        self.hello().split(' ').next().unwrap_or_default()
    }

    /// The name's short form, with which the names of its sessions begin: `vm`.
    fn prefix(&self) -> &'static str {
        self.name().trim_start_matches("saarcor-")
    }

    /// The levels at which it is judged, the lowest first.
    fn levels(&self) -> &'static [Level];

    /// The names that `observes` may list: parts of an answer, each with the level that it belongs to.
    fn observable(&self) -> &'static [(&'static str, Level)];

    /// Suite files by their names, in an order in which what comes later builds on what came before.
    fn suites(&self) -> &'static [(&'static str, &'static str)];

    /// The keys of a configuration.
    fn keys(&self) -> Vec<&'static str>;

    /// The configuration of the random session of a seed.
    fn random_config(&self, seed: u64) -> Cow<'static, str>;

    /// So many random requests of a seed, each with its newline, for that configuration.
    fn random_requests(&self, config: &str, seed: u64, count: usize) -> Vec<u8>;

    /// The name of the random session of a seed.
    fn random_name(&self, seed: u64) -> String {
        format!("{}/random/{seed}", self.prefix())
    }

    /// The random session of a seed.
    fn random(&self, seed: u64, requests: usize) -> Session {
        let config = self.random_config(seed);
        Session::new(
            &self.random_name(seed),
            self.hello(),
            &config,
            &self.random_requests(&config, seed, requests),
        )
    }

    /// So many seeds in a row, from a multiple of it on, have each configuration of the random sessions that is not drawn.
    fn configurations(&self) -> usize {
        2 * crate::plan::QUICK_SESSIONS
    }

    /// Sessions about the sizes that people build: each is made when it is held.
    fn sizes(&self, _extent: &Extent) -> Vec<SizedSession> {
        Vec::new()
    }

    /// Sessions of recorded frames, each of at most so many of its reads or rays, or operations of each packet.
    fn recorded(&self, _requests: usize) -> Vec<Session> {
        Vec::new()
    }

    /// The session with a tolerance of so many thousandths, where the kind has one.
    fn with_tolerance(&self, session: Session, _tolerance: u32) -> Session {
        session
    }

    /// Checks that the session is one of this kind.
    ///
    /// # Errors
    /// What is wrong with the configuration or with which request, and what would be right.
    fn check(&self, session: &Session) -> Result<(), Error>;

    /// The model, or the naive reference, of a configuration.
    ///
    /// # Errors
    /// The key whose value is wrong.
    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Implementation>, Error>;

    /// What compares the answers of an implementation with those of the model, one by one, as far as
    /// `observes` goes.
    ///
    /// # Errors
    /// What is wrong with `observes`.
    fn comparison<'a>(&self, session: &'a Session, observes: &str)
    -> Result<Box<dyn Comparison + 'a>, Error>;

    /// The requirements whose breach explains the answers to a session's first requests: of each variant of the
    /// model that breaks one of them alone, and gives all of these answers. None where no such variant is known.
    fn explanations(&self, _session: &Session, _observes: &str, _answers: &[&[u8]]) -> Vec<&'static str> {
        Vec::new()
    }

    /// Configurations that are simpler than one, the boldest first.
    fn simpler_configs(&self, _config: &str) -> Vec<String> {
        Vec::new()
    }

    /// Requests that are simpler than one, the boldest first. Each is made when it is asked for.
    fn simpler_requests<'a>(&self, _session: &Session, _request: &'a [u8]) -> Candidates<'a, String> {
        Box::new(std::iter::empty())
    }

    /// Sessions that are simpler as a whole, where one simplification changes several requests. Each is made when
    /// it is asked for: together they would take the square of a session's length.
    fn simpler_sessions<'a>(&self, _session: &'a Session) -> Candidates<'a, Session> {
        Box::new(std::iter::empty())
    }

    /// The model's state before the request of that number, from 0 on, for a person; empty where there is
    /// none to show.
    fn state_before(&self, _session: &Session, _request: usize) -> Vec<String> {
        Vec::new()
    }

    /// What counts the cases that sessions reach in the small geometry.
    fn coverage(&self) -> Box<dyn Coverage>;
}

/// What sessions are judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oracle {
    /// The model: what implementations are compared with. It is the specification, and of the chip in time its
    /// fast twin.
    Model,
    /// The second opinion, which judges the model: naive code that shares none of its logic, and of the chip in
    /// time the specification.
    Naive,
}
