//! An implementation under test, in whatever form.

use crate::deadline::Deadline;
use crate::error::Error;
use crate::kind::{Kind, Oracle};
use crate::scoreboard::Scoreboard;
use crate::server::{MakeImplementation, Server};
use crate::session::Session;
use std::time::Duration;

/// How a conversation ended, beside what the scoreboard knows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ConversationEnd {
    /// How its time ran out.
    pub timeout: Option<Timeout>,
    /// The end of what the implementation wrote to standard error.
    pub stderr: String,
    /// Whether the process had held other sessions before.
    pub is_used: bool,
}

/// How the time of a conversation ran out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timeout {
    /// At the time limit, without an answer for half of it: it hangs.
    Hung,
    /// At the time limit, while answers still came: too little time for it.
    Slow,
    /// It was stopped before.
    Stopped,
}

/// An implementation under test: the "device".
pub trait Dut: Sync {
    /// Holds the conversation of a session, and hands each answer to the scoreboard, until the deadline.
    ///
    /// # Errors
    /// Why the implementation cannot be started.
    fn converse(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error>;

    /// The same in a process that holds no other session.
    ///
    /// # Errors
    /// Why the implementation cannot be started.
    fn converse_alone(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        self.converse(session, scoreboard, deadline)
    }

    /// Gives sessions a part of their time from now on, as one has hung: there may be many like it.
    fn hurry(&self) {}

    /// Says that no more sessions follow: what waits for them may go.
    fn finish(&self) {}

    /// Time that a session may take; none where nothing can hang.
    fn time_limit(&self) -> Option<Duration> {
        None
    }
}

/// An implementation in this process.
pub struct InProcess {
    make: Box<MakeImplementation>,
}

impl InProcess {
    /// The implementation that `make` makes.
    #[must_use]
    pub fn new(make: Box<MakeImplementation>) -> Self {
        Self { make }
    }

    /// The model or the naive reference.
    #[must_use]
    pub fn oracle(oracle: Oracle) -> Self {
        Self::new(Box::new(move |kind: &dyn Kind, config: &str| kind.oracle(oracle, config)))
    }
}

impl Dut for InProcess {
    fn converse(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        let mut server = Server::new(&*self.make);
        let mut answer = Vec::new();
        let mut at = 0;
        while let Some((line, next)) = session.request_at(at) {
            if deadline.has_come() {
                return Ok(ConversationEnd { timeout: Some(Timeout::Stopped), ..ConversationEnd::default() });
            }
            answer.clear();
            server.answer(line, &mut answer);
            scoreboard.answer(answer.trim_ascii_end(), next);
            if scoreboard.is_done() {
                break;
            }
            at = next;
        }
        Ok(ConversationEnd::default())
    }
}
