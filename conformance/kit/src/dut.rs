//! An implementation under test, in whatever form.

use crate::judge::Judge;
use crate::kind::{Kind, Oracle};
use crate::serve::{MakeServed, Server};
use crate::session::Session;
use crate::stop::Stop;
use std::time::Duration;

/// How a conversation ended, beside what the judge knows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ending {
    /// Its time was over.
    pub timeout: Option<Timeout>,
    /// The end of what the implementation wrote to standard error.
    pub stderr: String,
}

/// How the time of a conversation came to its end.
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
    /// Holds the conversation of a session, and hands each answer to the judge, until `stop` comes.
    ///
    /// # Errors
    /// Why the implementation cannot be started.
    fn converse(&self, session: &Session, judge: &mut Judge<'_>, stop: &Stop) -> anyhow::Result<Ending>;

    /// Time that a session may take; none where nothing can hang.
    fn time_limit(&self) -> Option<Duration> {
        None
    }
}

/// An implementation in this process.
pub struct InProcess {
    make: Box<MakeServed>,
}

impl InProcess {
    /// The implementation that `make` makes.
    #[must_use]
    pub fn new(make: Box<MakeServed>) -> Self {
        Self { make }
    }

    /// The model or the naive reference.
    #[must_use]
    pub fn oracle(oracle: Oracle) -> Self {
        Self::new(Box::new(move |kind: &dyn Kind, config: &str| kind.oracle(oracle, config)))
    }
}

impl Dut for InProcess {
    fn converse(&self, session: &Session, judge: &mut Judge<'_>, _: &Stop) -> anyhow::Result<Ending> {
        let mut server = Server::new(&*self.make);
        let mut answer = Vec::new();
        let mut at = 0;
        while let Some((line, next)) = session.request_at(at) {
            answer.clear();
            server.answer(line, &mut answer);
            judge.answer(answer.trim_ascii_end(), next);
            if judge.is_done() {
                break;
            }
            at = next;
        }
        Ok(Ending::default())
    }
}
