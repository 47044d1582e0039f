//! A whole run: all sessions with one implementation, and the report.

use crate::coverage::CoverageCount;
use crate::deadline::Deadline;
use crate::dut::{Dut, Timeout};
use crate::error::Error;
use crate::execution::{Execution, SessionResult, execute};
use crate::kind::Kind;
use crate::kinds::{KINDS, kind_of_hello};
use crate::level::Level;
use crate::plan::{Options, PlannedSession, default_suite};
use crate::report::{
    ConformanceReport, ConformanceVerdict, Failure, LevelResult, LevelVerdict, RequirementResult,
    SCHEMA_VERSION, UnsupportedKey, shown_lines,
};
use crate::scoreboard::{Finding, Scoreboard};
use crate::session::Session;
use crate::shrink::{ShrinkResult, shrink};
use rayon::prelude::*;

/// The kind of an implementation, by the hello that it answers; none where it answers none.
///
/// # Errors
/// Where it cannot be started.
pub fn kind_of(dut: &dyn Dut) -> Result<Option<&'static dyn Kind>, Error> {
    for kind in KINDS {
        let options = Options { requests: 0, ..Options::default() };
        let session = default_suite(*kind, &options)?;
        let session = session.first().ok_or("a kind has sessions")?.session(*kind, &options);
        let mut scoreboard = Scoreboard::new(*kind, &session, Level::Protocol);
        let ending = dut.converse(&session, &mut scoreboard, &Deadline::never())?;
        let refused = scoreboard.findings().iter().find(|finding| finding.asked == kind.hello());
        let Some(finding) = refused else { return Ok(Some(*kind)) };
        if let Some(named) = kind_of_hello(finding.got.as_bytes()) {
            return Ok(Some(named));
        }
        if ending.timeout.is_some() {
            break;
        }
    }
    Ok(None)
}

/// Runs all sessions, and says what was found. `progress` is given the part that is done, from 0 to 1.
///
/// # Errors
/// Where the implementation cannot be started.
pub fn run(
    name: &str,
    dut: &dyn Dut,
    kind: &dyn Kind,
    planned: &[PlannedSession],
    options: &Options,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ConformanceReport, Error> {
    let Execution { results, stopped, random_seconds, shrinking } =
        execute(dut, kind, planned, options, progress)?;
    let failures = failures(dut, kind, planned, &results, (options, &shrinking))?;
    Ok(Summary { name, kind, planned, results: &results, options }.report(failures, stopped, random_seconds))
}

/// Failures that are shrunk: of each requirement and level the first, and no more than these.
const SHOWN_FAILURES: usize = 8;

/// Of each requirement and level the first session that fails, shrunk.
fn failures(
    dut: &dyn Dut,
    kind: &dyn Kind,
    planned: &[PlannedSession],
    results: &[SessionResult],
    how: (&Options, &Deadline),
) -> Result<Vec<Failure>, Error> {
    let mut chosen: Vec<(usize, &Finding)> = Vec::new();
    for (place, session) in results.iter().enumerate() {
        // The lowest level: those above follow from it.
        let Some(finding) = session.findings.iter().min_by_key(|finding| finding.level) else { continue };
        let same = |&(other, known): &(usize, &Finding)| {
            let row = &results[other].row;
            row == &session.row && known.level == finding.level && known.requirement == finding.requirement
        };
        if !chosen.iter().any(same) {
            chosen.push((place, finding));
        }
    }
    chosen.truncate(SHOWN_FAILURES);
    let of = |&(place, finding): &(usize, &Finding)| {
        let session = planned[results[place].place].session(kind, how.0);
        failure(dut, kind, &session, finding, &results[place], how)
    };
    chosen.par_iter().map(of).collect()
}

fn failure(
    dut: &dyn Dut,
    kind: &dyn Kind,
    session: &Session,
    finding: &Finding,
    result: &SessionResult,
    (options, deadline): (&Options, &Deadline),
) -> Result<Failure, Error> {
    let mut trouble = None;
    let mut fails = |session: &Session| {
        let mut scoreboard = Scoreboard::new(kind, session, options.highest());
        if let Err(error) = dut.converse(session, &mut scoreboard, deadline) {
            trouble.get_or_insert(error);
            return None;
        }
        let same =
            |found: &&Finding| found.level == finding.level && found.requirement == finding.requirement;
        scoreboard.findings().iter().find(same).cloned()
    };
    let ShrinkResult { session: minimal, finding, cut_short } =
        if result.timeout.is_some() || deadline.has_come() {
            // Each try would take the time limit again: only the requests behind the failing one are left out.
            let session = session.with_requests(session.requests().take(finding.asked_by_then()));
            ShrinkResult { session, finding: finding.clone(), cut_short: true }
        } else {
            shrink(kind, session, finding, deadline, &mut fails)
        };
    if let Some(error) = trouble {
        return Err(error);
    }
    let requirement = requirement(session, &finding);
    Ok(Failure {
        requirement,
        level: finding.level,
        session: session.name.clone(),
        row: result.row.clone(),
        idea: session.idea.clone(),
        says: finding.says.clone(),
        suite: minimal.to_suite(),
        minimal: shown_lines(minimal.text()),
        minimal_requests: minimal.requests().count(),
        found_requests: session.requests().count(),
        cut_short,
        state_before: finding.request.map(|request| kind.state_before(&minimal, request)).unwrap_or_default(),
        asked: finding.asked.clone(),
        expected: finding.expected.clone(),
        got: finding.got.clone(),
        stderr: result.stderr.clone(),
        replay: None,
    })
}

/// The requirement that a session fails for. A directed session fails for its own, whatever differs, with these
/// exceptions: wrong bytes, unless it is about bytes; a conversation that breaks off, unless it is about answers
/// and their form; and the bytes of an entry of metadata.
fn requirement(session: &Session, finding: &Finding) -> String {
    let own = finding.requirement.to_owned();
    let Some(about) = session.requirement.clone() else { return own };
    let of_bytes = finding.level == Level::Data && session.level != Some(Level::Data);
    let breaks_off = finding.level == Level::Protocol && !(about.starts_with("P-") && own == "P-5");
    if breaks_off || of_bytes || own == ENTRY_BYTES { own } else { about }
}

/// The requirement of what an entry of metadata consists of.
const ENTRY_BYTES: &str = "VM-12";

/// What a report is made of.
struct Summary<'a> {
    name: &'a str,
    kind: &'a dyn Kind,
    planned: &'a [PlannedSession],
    results: &'a [SessionResult],
    options: &'a Options,
}

impl Summary<'_> {
    fn report(
        &self,
        failures: Vec<Failure>,
        stopped: Option<String>,
        random_seconds: f64,
    ) -> ConformanceReport {
        let levels = self.levels();
        let passed = |level: &&LevelResult| level.verdict == LevelVerdict::Passed;
        let before_failed = levels.iter().take_while(|level| level.verdict != LevelVerdict::Failed);
        let highest = before_failed.filter(passed).map(|level| level.level).last();
        let errors = self.results.iter().filter(|result| !result.findings.is_empty()).count();
        let at_asked = levels.iter().find(|level| Some(level.level) == self.options.level);
        let slow = self.results.iter().any(|result| result.timeout == Some(Timeout::Slow));
        let judged = self.results.iter().any(|result| result.unsupported.is_none());
        let passed = at_asked.is_none_or(|level| level.verdict == LevelVerdict::Passed);
        let decided = judged && !slow && passed;
        let decided = decided && highest.is_some_and(|highest| highest > Level::Protocol);
        let verdict = match (errors, decided) {
            (0, true) => ConformanceVerdict::Conforms,
            (0, false) => ConformanceVerdict::Incomplete,
            _ => ConformanceVerdict::DoesNotConform,
        };
        let random = || self.results.iter().filter(|result| result.random);
        ConformanceReport {
            schema_version: SCHEMA_VERSION,
            dut: self.name.to_owned(),
            kind: self.kind.name().to_owned(),
            verdict,
            highest,
            asked: self.options.level,
            tolerance: self.options.tolerance,
            levels,
            requirements: self.requirements(),
            failures,
            unsupported: self.unsupported(),
            coverage: self.coverage(),
            sessions: self.results.len(),
            errors,
            requests: self.results.iter().map(|result| result.answered as u64).sum(),
            random_requests: random().map(|result| result.answered as u64).sum(),
            random_seconds,
            stopped: stopped.or_else(|| {
                slow.then(|| {
                    "sessions reached the time limit: take fewer requests, or a longer limit".to_owned()
                })
            }),
        }
    }

    fn levels(&self) -> Vec<LevelResult> {
        let lowest_failed =
            self.results.iter().flat_map(|result| &result.findings).map(|finding| finding.level).min();
        let verdict = |&level: &Level| {
            let verdict = if level > self.options.highest() {
                LevelVerdict::NotAsked
            } else if lowest_failed.is_some_and(|failed| failed <= level) {
                LevelVerdict::Failed
            } else if self
                .results
                .iter()
                .any(|result| result.observed.contains(&level) && result.unsupported.is_none())
            {
                LevelVerdict::Passed
            } else {
                LevelVerdict::NotObserved
            };
            LevelResult { level, verdict }
        };
        self.kind.levels().iter().map(verdict).collect()
    }

    fn requirements(&self) -> Vec<RequirementResult> {
        let mut rows: Vec<RequirementResult> = Vec::new();
        for result in self.results.iter().filter(|result| result.unsupported.is_none()) {
            let place = rows.iter().position(|row| row.requirement == result.row).unwrap_or_else(|| {
                rows.push(RequirementResult { requirement: result.row.clone(), sessions: 0, failed: 0 });
                rows.len() - 1
            });
            rows[place].sessions += 1;
            rows[place].failed += usize::from(!result.findings.is_empty());
        }
        rows
    }

    fn unsupported(&self) -> Vec<UnsupportedKey> {
        let mut rows: Vec<UnsupportedKey> = Vec::new();
        for key in self.results.iter().filter_map(|result| result.unsupported.as_deref()) {
            match rows.iter_mut().find(|row| row.key == key) {
                Some(row) => row.sessions += 1,
                None => rows.push(UnsupportedKey { key: key.to_owned(), sessions: 1 }),
            }
        }
        rows.sort_unstable_by(|a, b| a.key.cmp(&b.key));
        rows
    }

    /// What the sessions exercise that ran to their ends.
    fn coverage(&self) -> Vec<CoverageCount> {
        let mut coverage = self.kind.coverage();
        for result in self.results {
            if result.findings.is_empty() && result.unsupported.is_none() && result.timeout.is_none() {
                coverage.add(&self.planned[result.place].session(self.kind, self.options));
            }
        }
        coverage.counts()
    }
}
