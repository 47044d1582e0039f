//! The scoreboard of one session: takes the answers of an implementation in their order, compares each with
//! the model's, and keeps what differs.
//!
//! Answers may also be there already: [`check_answers`] is the last of the three filters
//! `generate | implementation | check`.

use crate::comparison::{Admitted, Comparison};
use crate::error::Error;
use crate::kind::Kind;
use crate::level::Level;
use crate::session::Session;
use crate::shown::{shown, shown_beside};
use serde::Serialize;

/// The first difference of a session at a level.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The level that it breaks.
    pub level: Level,
    /// The requirement that it breaks by all that is known of the session.
    pub requirement: &'static str,
    /// Number of the request, from 0 on; none before the first and after the last.
    pub request: Option<usize>,
    /// The request, or the line before the first or behind the last of them.
    pub asked: String,
    /// The model's answer.
    pub expected: String,
    /// The implementation's.
    pub got: String,
    /// What differs, in a sentence.
    pub says: String,
}

impl Finding {
    /// How many of the session's requests lead to it, this one included.
    #[must_use]
    pub fn asked_by_then(&self) -> usize {
        match self.request {
            Some(request) => request + 1,
            // A hello or a configuration comes before all of them, and an end after.
            None if self.asked.starts_with("config ") || self.asked.starts_with("saarcor-") => 0,
            None => usize::MAX,
        }
    }
}

/// What follows the hello in the answer of an implementation that offers several sessions a process.
pub(crate) const SESSIONS: &[u8] = b" sessions";

/// The stage of a conversation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The hello is to be answered.
    Hello,
    /// The configuration is.
    Config,
    /// A request is, or the end.
    Requests,
    /// All was answered.
    Ended,
    /// The implementation does not support the configuration.
    Unsupported,
    /// An answer is not in the form of the protocol: what follows cannot be judged.
    Broken,
}

/// Compares the answers of one session with the model's.
pub struct Scoreboard<'a> {
    kind: &'a dyn Kind,
    session: &'a Session,
    comparison: Option<Box<dyn Comparison + 'a>>,
    stage: Stage,
    /// Place in the session's text behind the last request that was answered.
    at: usize,
    answered: usize,
    findings: Vec<Finding>,
    unsupported: Option<String>,
    /// Whether other sessions may follow in the same process.
    offers_sessions: bool,
    /// Parts of an answer that the implementation does not observe.
    unobserved: Vec<&'static str>,
    /// Nothing above is judged.
    highest: Level,
    /// What the implementation observes, as it said.
    observes: String,
    /// The answers to the first requests, each with a newline, [`KEPT`] bytes at most.
    kept: Vec<u8>,
    /// How many they are.
    kept_answers: usize,
}

/// Answers that are kept to explain what differs, in bytes: those of some ten thousand requests.
const KEPT: usize = 1 << 19;

impl<'a> Scoreboard<'a> {
    /// The scoreboard of a session up to the level `highest`, or that of the session where it is lower.
    #[must_use]
    pub fn new(kind: &'a dyn Kind, session: &'a Session, highest: Level) -> Self {
        Self {
            kind,
            session,
            comparison: None,
            stage: Stage::Hello,
            at: 0,
            answered: 0,
            findings: Vec::new(),
            unsupported: None,
            offers_sessions: false,
            unobserved: Vec::new(),
            highest: session.level.map_or(highest, |level| level.min(highest)),
            observes: String::new(),
            kept: Vec::new(),
            kept_answers: 0,
        }
    }

    /// The stage of the conversation.
    #[inline]
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Whether no further answer is waited for.
    #[inline]
    #[must_use]
    pub fn is_done(&self) -> bool {
        matches!(self.stage, Stage::Ended | Stage::Unsupported | Stage::Broken)
    }

    /// Requests that were answered.
    #[must_use]
    pub fn answered(&self) -> usize {
        self.answered
    }

    /// The first difference at each level, in the order in which they were found.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The key that the implementation does not support.
    #[must_use]
    pub fn unsupported(&self) -> Option<&str> {
        self.unsupported.as_deref()
    }

    /// Whether the implementation offers that other sessions follow in the same process.
    #[must_use]
    pub fn offers_sessions(&self) -> bool {
        self.offers_sessions
    }

    /// Whether a level can be judged by what the implementation observes; not known before it has
    /// said so.
    #[must_use]
    pub fn observed(&self, level: Level) -> bool {
        level == Level::Protocol
            || self.comparison.as_ref().is_some_and(|comparison| comparison.observed(level))
    }

    /// The parts of an answer that the implementation does not observe, by their names in `observes`; not known
    /// before it has said so.
    #[must_use]
    pub fn unobserved(&self) -> &[&'static str] {
        &self.unobserved
    }

    /// What answers so far were right, though they were not the model's.
    #[must_use]
    pub fn admitted(&self) -> &[Admitted] {
        self.comparison.as_ref().map_or(&[], |comparison| comparison.admitted())
    }

    /// The requirements whose breach explains all answers up to the one of a finding; none where it is not known, or
    /// where there were too many answers to keep them.
    #[must_use]
    pub fn explanations(&self, finding: &Finding) -> Vec<&'static str> {
        let Some(request) = finding.request else { return Vec::new() };
        if request >= self.kept_answers {
            return Vec::new();
        }
        let answers: Vec<&[u8]> = self.kept.split(|&byte| byte == b'\n').take(request + 1).collect();
        self.kind.explanations(self.session, &self.observes, &answers)
    }

    /// Judges the next answer, a line without its newline, given how much of the session's text had
    /// been sent when it came.
    #[inline]
    pub fn answer(&mut self, line: &[u8], sent: usize) {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let Some((request, next)) = self.session.request_at(self.at) else {
            return self.broken("P-4", "nothing", line, "an answer after 'end'");
        };
        if next > sent {
            return self.broken("P-4", "no answer yet", line, "an answer before its request was sent");
        }
        match self.stage {
            Stage::Requests if next < self.session.len() => self.request(request, line),
            Stage::Requests if line == b"end" => self.stage = Stage::Ended,
            Stage::Requests => self.broken("P-6", "end", line, "'end' is answered by 'end'"),
            Stage::Hello => self.hello(line),
            Stage::Config => self.config(line),
            Stage::Ended | Stage::Unsupported | Stage::Broken => {
                self.broken("P-4", "nothing", line, "an answer after the last one");
            }
        }
        self.at = next;
    }

    /// Says why the next request has no answer.
    pub fn silent(&mut self, requirement: &'static str, says: &str) {
        self.broken(requirement, "an answer", b"", says);
    }

    /// Says what is wrong behind the last answer, or with the conversation as a whole.
    pub fn misbehaves(&mut self, requirement: &'static str, says: &str) {
        self.at = self.session.len();
        self.broken(requirement, "", b"", says);
    }

    #[inline]
    fn request(&mut self, request: &[u8], line: &[u8]) {
        let Some(comparison) = &mut self.comparison else { return };
        if self.kept_answers == self.answered && self.kept.len() + line.len() < KEPT {
            self.kept.extend_from_slice(line);
            self.kept.push(b'\n');
            self.kept_answers += 1;
        }
        let mut found = None;
        let (findings, highest) = (&self.findings, self.highest);
        let compared = comparison.compare(request, line, &mut |difference| {
            let known = findings.iter().any(|finding| finding.level == difference.level);
            if !known && difference.level <= highest {
                found.get_or_insert_with(Vec::new).push(difference);
            }
        });
        if let Err(right) = compared {
            let (expected, got) = shown_beside(comparison.expected(), line);
            return self.broken_with("P-5", expected, got, right.to_string());
        }
        if let Some(found) = found {
            let (expected, got) = shown_beside(comparison.expected(), line);
            for difference in found {
                self.findings.push(Finding {
                    level: difference.level,
                    requirement: difference.requirement,
                    request: Some(self.answered),
                    asked: shown(request),
                    expected: expected.clone(),
                    got: got.clone(),
                    says: difference.says,
                });
            }
        }
        self.answered += 1;
    }

    fn hello(&mut self, line: &[u8]) {
        let hello = self.session.hello();
        let (name, version) = hello.rsplit_once(' ').unwrap_or((hello, ""));
        let other =
            std::str::from_utf8(line).ok().and_then(|line| line.strip_prefix(name)?.strip_prefix(' '));
        match line.strip_prefix(hello.as_bytes()) {
            Some(rest @ (b"" | SESSIONS)) => {
                self.offers_sessions = rest == SESSIONS;
                self.stage = Stage::Config;
            }
            _ => {
                let says = match other.and_then(|other| other.split(' ').next()?.parse::<u32>().ok()) {
                    Some(other) if other.to_string() != version => {
                        format!(
                            "it speaks version {other} of the protocol, and was asked for version {version}"
                        )
                    }
                    _ => "a hello is answered by the same line".to_owned(),
                };
                self.broken("P-1", hello, line, &says);
            }
        }
    }

    fn config(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line);
        if let Some(key) = text.strip_prefix("unsupported ") {
            let keys = self.kind.keys();
            if !keys.contains(&key) {
                let right = format!("a key that is not supported is one of {}", keys.join(", "));
                return self.broken("P-2", "ok observes=.. or unsupported KEY", line, &right);
            }
            self.unsupported = Some(key.to_owned());
            self.stage = Stage::Unsupported;
            return;
        }
        let right = "a configuration is answered by 'ok observes=LIST' or 'unsupported KEY'";
        let observes = text.strip_prefix("ok observes=").ok_or(Error::from(right));
        let names = || observes.iter().flat_map(|list| list.split(','));
        let all = self.kind.observable().iter().map(|(name, _)| *name);
        self.unobserved = all.filter(|name| !names().any(|observed| observed == *name)).collect();
        let comparison = observes.and_then(|list| Ok((list, self.kind.comparison(self.session, list)?)));
        match comparison {
            Ok((list, comparison)) => {
                self.comparison = Some(comparison);
                self.observes = list.to_owned();
                self.stage = Stage::Requests;
            }
            Err(right) => {
                self.broken("P-2", "ok observes=.. or unsupported KEY", line, &right.to_string());
            }
        }
    }

    fn broken(&mut self, requirement: &'static str, expected: &str, got: &[u8], says: &str) {
        self.broken_with(requirement, expected.to_owned(), shown(got), says.to_owned());
    }

    fn broken_with(&mut self, requirement: &'static str, expected: String, got: String, says: String) {
        let asked = self.session.request_at(self.at).map_or("nothing".to_owned(), |(line, _)| shown(line));
        let in_requests = self.stage == Stage::Requests && asked != "end";
        self.stage = Stage::Broken;
        self.findings.push(Finding {
            level: Level::Protocol,
            requirement,
            request: in_requests.then_some(self.answered),
            asked,
            expected,
            got,
            says,
        });
    }
}

/// The result of comparing the answers to a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CheckedAnswers {
    /// The first difference at each level.
    pub findings: Vec<Finding>,
    /// Requests that were answered.
    pub answered: usize,
    /// The highest level at which all agrees: it and each one below it is observed.
    pub highest: Option<Level>,
    /// Levels that the session is about and that are not judged, as they or some below them are not observed.
    pub not_judged: Vec<Level>,
    /// The key that the implementation does not support.
    pub unsupported: Option<String>,
}

/// Compares the answers to a session's requests, up to a level.
#[must_use]
pub fn check_answers(kind: &dyn Kind, session: &Session, answers: &[u8], level: Level) -> CheckedAnswers {
    let mut scoreboard = Scoreboard::new(kind, session, level);
    let sent = session.len();
    let whole = answers.strip_suffix(b"\n").unwrap_or(answers);
    for answer in whole.split(|&byte| byte == b'\n').filter(|_| !answers.is_empty()) {
        if matches!(scoreboard.stage(), Stage::Broken | Stage::Unsupported) {
            break;
        }
        scoreboard.answer(answer, sent);
    }
    if !scoreboard.is_done() {
        scoreboard.silent("P-4", "the answers end before 'end' is answered");
    }
    let failed = scoreboard.findings().iter().map(|finding| finding.level).min();
    let judged = |other: &&Level| **other <= level && session.level.is_none_or(|own| **other <= own);
    let open = |level: &&Level| failed.is_none_or(|failed| **level < failed);
    let levels: Vec<Level> = kind.levels().iter().filter(judged).filter(open).copied().collect();
    let passed = levels.iter().take_while(|level| scoreboard.observed(**level)).count();
    CheckedAnswers {
        findings: scoreboard.findings().to_vec(),
        answered: scoreboard.answered(),
        highest: levels[..passed].last().copied(),
        not_judged: levels[passed..].to_vec(),
        unsupported: scoreboard.unsupported().map(str::to_owned),
    }
}
