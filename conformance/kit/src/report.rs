//! The report: what a run has found.

use crate::coverage::CoverageCount;
use crate::level::Level;
use crate::session::Session;
use crate::shown::{differences, marks, visible};
use serde::Serialize;
use std::ops::Range;

/// Version of the report's form in JSON: raised where a field changes its meaning or goes.
pub const SCHEMA_VERSION: u32 = 2;

/// The report on one implementation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConformanceReport {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// The implementation, as it was named.
    pub dut: String,
    /// Its kind.
    pub kind: String,
    /// The hello of the kind, with the version of the protocol.
    pub protocol: String,
    /// The first seed of the random sessions.
    pub seed: u64,
    /// The verdict.
    pub verdict: ConformanceVerdict,
    /// The highest level that was passed, and so were all below it.
    pub highest: Option<Level>,
    /// The level that the run was to judge; none: all that is observed.
    pub asked: Option<Level>,
    /// By how many thousandths a timing may be off, as the implementation's maker states.
    pub tolerance: u32,
    /// Each level.
    pub levels: Vec<LevelResult>,
    /// What was not judged, though the run was to judge it.
    pub not_judged: Vec<NotJudged>,
    /// Each requirement that sessions are about, in the order of the suites; the random ones last.
    pub requirements: Vec<RequirementResult>,
    /// What fails: for each requirement and level one session, shrunk.
    pub failures: Vec<Failure>,
    /// Configurations that the implementation does not support, by the key that it names.
    pub unsupported: Vec<UnsupportedKey>,
    /// What the sessions exercise of the model.
    pub coverage: Vec<CoverageCount>,
    /// Answers that are right, though they are not the model's, by the requirement that leaves them open.
    pub admitted: Vec<AdmittedAnswers>,
    /// Each session that was planned, in the order of the plan.
    pub outcomes: Vec<SessionOutcome>,
    /// Sessions that were run.
    pub sessions: usize,
    /// Sessions that fail, but for those whose failure does not count.
    pub errors: usize,
    /// Sessions whose failure does not count.
    pub waived: usize,
    /// Requests that were answered.
    pub requests: u64,
    /// Requests of the random sessions that were answered.
    pub random_requests: u64,
    /// Seconds that the random sessions took together.
    pub random_seconds: f64,
    /// Why sessions were left out, if some were.
    pub stopped: Option<String>,
}

/// Answers that are right, though they are not the model's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdmittedAnswers {
    /// The requirement that leaves them open.
    pub requirement: String,
    /// How many there were.
    pub answers: u64,
    /// The first session that has one.
    pub session: String,
    /// What was asked there.
    pub asked: String,
    /// Why the answer is right, in a sentence.
    pub why: String,
}

/// What became of a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionOutcome {
    /// Its name; of a random session it ends with the seed.
    pub session: String,
    /// The row of [`ConformanceReport::requirements`] that counts it.
    pub row: String,
    /// Its configuration; empty where it was left out.
    pub config: String,
    /// Its outcome.
    pub outcome: Outcome,
    /// Requests that were answered.
    pub requests: usize,
    /// Seconds that it took.
    pub seconds: f64,
    /// The requirement that is broken, where it fails.
    pub requirement: Option<String>,
    /// What differs, why that does not count, or what is not supported; empty where it passes.
    pub says: String,
}

/// The outcome of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// All agrees.
    Passed,
    /// Something differs.
    Failed,
    /// Something differs, and that does not count.
    Waived,
    /// Its configuration is not supported.
    NotSupported,
    /// There was too little time to judge it.
    OutOfTime,
    /// It was not run.
    LeftOut,
}

impl Outcome {
    /// The outcome in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Waived => "waived",
            Self::NotSupported => "not supported",
            Self::OutOfTime => "out of time",
            Self::LeftOut => "left out",
        }
    }
}

/// The verdict on an implementation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ConformanceVerdict {
    /// It conforms at the level that the run was to judge.
    Conforms,
    /// It does not.
    DoesNotConform,
    /// Neither can be decided.
    Incomplete,
}

impl ConformanceVerdict {
    /// The verdict in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Conforms => "conforms",
            Self::DoesNotConform => "does not conform",
            Self::Incomplete => "incomplete",
        }
    }
}

/// What was found at a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LevelResult {
    /// The level.
    pub level: Level,
    /// The verdict.
    pub verdict: LevelVerdict,
}

/// Verdict at a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelVerdict {
    /// All sessions agree, and it and each level below it was observed in every configuration.
    Passed,
    /// Some do not, at this level or below.
    Failed,
    /// What is observed agrees; but in some configurations the level, or one below it, is not observed.
    ObservedInPart,
    /// The implementation does not observe what the level is judged by.
    NotObserved,
    /// The run was not to judge it, or no session of the run is about it.
    NotAsked,
}

impl LevelVerdict {
    /// The verdict in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::ObservedInPart => "observed in part",
            Self::NotObserved => "not observed",
            Self::NotAsked => "not asked for",
        }
    }
}

/// Something that was not judged, though the run was to judge it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotJudged {
    /// A level, a part of an answer, a key of configurations, or the sessions themselves.
    pub what: String,
    /// Why not.
    pub why: NotJudgedReason,
    /// Sessions in which it was not judged.
    pub sessions: usize,
    /// Of so many.
    pub of: usize,
    /// The values, as `KEY=VALUE`, of the configurations in which it was not judged, where these tell them from the
    /// others.
    pub values: Vec<String>,
}

/// Why something was not judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotJudgedReason {
    /// The implementation does not observe it, or for a level, not each level below it.
    NotObserved,
    /// The implementation does not support it.
    NotSupported,
    /// Sessions were left out, or had too little time.
    LeftOut,
    /// They fail, and that is known and does not count.
    Waived,
}

/// Values that are shown.
const SHOWN_VALUES: usize = 4;

impl NotJudged {
    /// The first of the values, in words.
    fn shown_values(&self) -> String {
        let more = self.values.len().saturating_sub(SHOWN_VALUES);
        let shown = self.values.iter().take(SHOWN_VALUES).map(String::as_str);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        shown.collect::<Vec<_>>().join(", ") + &more
    }

    /// What was not judged, in words.
    fn name(&self) -> String {
        match self.why {
            NotJudgedReason::NotSupported => self.shown_values(),
            NotJudgedReason::NotObserved | NotJudgedReason::LeftOut | NotJudgedReason::Waived => {
                self.what.clone()
            }
        }
    }

    /// Where it was not judged, in words; empty for everywhere.
    fn place(&self) -> String {
        let share = format!("{} of {} sessions", self.sessions, self.of);
        match self.why {
            NotJudgedReason::NotObserved if self.sessions == self.of => String::new(),
            NotJudgedReason::NotObserved if self.values.is_empty() => format!(" in {share}"),
            NotJudgedReason::NotObserved => format!(" with {}", self.shown_values()),
            NotJudgedReason::NotSupported => format!(" (not supported; {share})"),
            NotJudgedReason::LeftOut => format!(" ({} of {})", self.sessions, self.of),
            NotJudgedReason::Waived => {
                format!(" that fail and are waived ({} of {})", self.sessions, self.of)
            }
        }
    }
}

impl ConformanceReport {
    /// The verdict in a sentence, with what was not judged.
    #[must_use]
    pub fn headline(&self) -> String {
        let highest = self.highest.map_or("at no level".to_owned(), |level| format!("up to level {level}"));
        let mut text = format!("{} ({}): {}; agrees {highest}", self.dut, self.kind, self.verdict.text());
        let mut rest = &self.not_judged[..];
        while let Some(first) = rest.first() {
            // Those that are not judged at the same place are named together.
            let place = first.place();
            let same =
                rest.iter().take_while(|other| other.why == first.why && other.place() == place).count();
            let names: Vec<_> = rest[..same].iter().map(NotJudged::name).collect();
            let begin = if rest.len() == self.not_judged.len() { "; not judged: " } else { "; " };
            text += &format!("{begin}{}{place}", names.join(", "));
            rest = &rest[same..];
        }
        text
    }
}

/// What was found of a requirement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RequirementResult {
    /// The requirement; `random` for the sessions that are about all.
    pub requirement: String,
    /// Sessions that are about it and were run.
    pub sessions: usize,
    /// Of these, those that fail.
    pub failed: usize,
}

/// A session that fails, shrunk to the shortest that still does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Failure {
    /// The requirement that is broken.
    pub requirement: String,
    /// What it demands, as SPEC.md or PROTOCOL.md has it; empty where it has none.
    pub demands: String,
    /// The lowest level that fails.
    pub level: Level,
    /// The session that was shrunk.
    pub session: String,
    /// The row of [`ConformanceReport::requirements`] that counts the session.
    pub row: String,
    /// Its configuration, before it was shrunk.
    pub config: String,
    /// What 'saarcor conform run' is asked for to hold it again as it was; none where that is its name, or a file's.
    pub again: Option<String>,
    /// Its idea.
    pub idea: String,
    /// What differs, in a sentence.
    pub says: String,
    /// The shortest session that still fails.
    #[serde(skip)]
    pub suite: Session,
    /// Its lines, but for the middle of one that is long.
    pub minimal: Vec<String>,
    /// Its requests.
    pub minimal_requests: usize,
    /// Requests of the session that was shrunk, up to the one that fails.
    pub found_requests: usize,
    /// Whether time, or tries, ran out before it was the shortest.
    pub cut_short: bool,
    /// The request whose answer is wrong.
    pub asked: String,
    /// The model's answer.
    pub expected: String,
    /// The implementation's.
    pub got: String,
    /// The model's state before that request.
    pub state_before: Vec<String>,
    /// The end of what the implementation wrote to standard error.
    pub stderr: String,
    /// The command that runs the shortest session again; none until it has been written to a file.
    pub replay: Option<String>,
}

/// Sessions that were not run to their end, as a key of their configuration is not supported.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct UnsupportedKey {
    /// The key.
    pub key: String,
    /// Sessions.
    pub sessions: usize,
}

/// Lines of a session that are shown from its begin, and as many from its end.
const SHOWN_LINES: usize = 40;

/// The lines of a session, but for the middle of one that is long.
pub(crate) fn shown_lines(session: &Session) -> Vec<String> {
    let text = |line: &[u8]| String::from_utf8_lossy(line).into_owned();
    let count = session.lines().count();
    let more = count.saturating_sub(2 * SHOWN_LINES);
    let begin = session.lines().take(if more > 0 { SHOWN_LINES } else { count });
    let end = session.lines().skip(if more > 0 { count - SHOWN_LINES } else { count });
    let left_out = (more > 0).then(|| format!("# and here {more} lines more"));
    begin.map(text).chain(left_out).chain(end.map(text)).collect()
}

impl Failure {
    /// What shrinking did, in words.
    #[must_use]
    pub fn shrunk(&self) -> String {
        let more = if self.cut_short { "; out of time, there may be a shorter one" } else { "" };
        format!("shrunk from {}{more}", self.found_requests)
    }

    /// Where what came differs from what was expected, in bytes of `got`.
    #[must_use]
    pub fn differences(&self) -> Vec<Range<usize>> {
        differences(&self.expected, &self.got)
    }

    /// The failure for a person, over several lines.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!("{} at level {}: {}\n", self.requirement, self.level, self.says);
        if !self.demands.is_empty() {
            text += &format!("  demands   {}\n", self.demands);
        }
        if !self.idea.is_empty() {
            text += &format!("  idea      {} ({})\n", self.idea, self.session);
        }
        text += &format!("  requests  {} of {}, {}\n", self.minimal_requests, self.session, self.shrunk());
        self.minimal.iter().for_each(|line| text += &format!("    {line}\n"));
        let again = self.again.as_ref().map_or_else(String::new, |again| format!(" ({again})"));
        text += &format!("  found in  {}{again}\n", self.config);
        text +=
            &format!("  asked     {}\n  expected  {}\n  got       {}\n", self.asked, self.expected, self.got);
        if let Some(marks) = marks(&self.got, &self.differences()) {
            text += &format!("            {marks}\n");
        }
        if !self.state_before.is_empty() {
            text += "  before\n";
            self.state_before.iter().for_each(|row| text += &format!("    {row}\n"));
        }
        if !self.stderr.is_empty() {
            text += "  stderr ends with\n";
            self.stderr.lines().for_each(|line| text += &format!("    {}\n", visible(line.as_bytes())));
        }
        if let Some(replay) = &self.replay {
            text += &format!("  again     {replay}\n");
        }
        text
    }
}
