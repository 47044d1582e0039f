//! Answers that are there already: the last of the three filters `generate | implementation | check`.

use crate::judge::{Finding, Judge, Stage};
use crate::kind::Kind;
use crate::level::Level;
use crate::session::Session;

/// What answers come to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checked {
    /// The first difference at each level.
    pub findings: Vec<Finding>,
    /// Requests that were answered.
    pub answered: usize,
    /// The highest level at which all that is observed agrees.
    pub highest: Option<Level>,
    /// The key that the implementation does not support.
    pub unsupported: Option<String>,
}

/// Compares the answers to a session's requests, up to a level.
#[must_use]
pub fn check(kind: &dyn Kind, session: &Session, answers: &[u8], level: Level) -> Checked {
    let mut judge = Judge::new(kind, session, level);
    let sent = session.text().len();
    let whole = answers.strip_suffix(b"\n").unwrap_or(answers);
    for answer in whole.split(|&byte| byte == b'\n').filter(|_| !answers.is_empty()) {
        if matches!(judge.stage(), Stage::Broken | Stage::Unsupported) {
            break;
        }
        judge.answer(answer, sent);
    }
    if !judge.is_done() {
        judge.silent("P-4", "the answers end before 'end' is answered");
    }
    let failed = judge.findings().iter().map(|finding| finding.level).min();
    let passed = |level: &&Level| judge.observed(**level) && failed.is_none_or(|failed| **level < failed);
    Checked {
        findings: judge.findings().to_vec(),
        answered: judge.answered(),
        highest: kind.levels().iter().take_while(|other| **other <= level).filter(passed).last().copied(),
        unsupported: judge.unsupported().map(str::to_owned),
    }
}
