//! A whole run: all sessions with one implementation, and the report.

use crate::deadline::Deadline;
use crate::dut::Dut;
use crate::error::Error;
use crate::execution::{Execution, Run, SessionResult};
use crate::kind::Kind;
use crate::kinds::{KINDS, kind_of_hello};
use crate::level::Level;
use crate::plan::{Options, PlannedSession, default_suite};
use crate::report::{ConformanceReport, Failure, shown_lines};
use crate::scoreboard::{Finding, Scoreboard};
use crate::session::Session;
use crate::shrink::{ShrinkResult, shrink};
use crate::summary::Summary;
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
    let run = Run { dut, kind, planned, options };
    let Execution { results, stopped, random_seconds, shrinking } = run.execute(progress)?;
    let failures = failures(&run, &results, &shrinking)?;
    Ok(Summary { name, run: &run, results: &results }.report(failures, stopped, random_seconds))
}

/// Failures that are shrunk: of each requirement and level the first, and no more than these.
const SHOWN_FAILURES: usize = 8;

/// Of each requirement and level the first session that fails, shrunk.
fn failures(run: &Run<'_>, results: &[SessionResult], deadline: &Deadline) -> Result<Vec<Failure>, Error> {
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
    let shrunk = |&(place, finding): &(usize, &Finding)| failure(run, &results[place], finding, deadline);
    chosen.par_iter().map(shrunk).collect()
}

/// A session that fails, shrunk until the deadline.
fn failure(
    run: &Run<'_>,
    result: &SessionResult,
    finding: &Finding,
    deadline: &Deadline,
) -> Result<Failure, Error> {
    let &Run { dut, kind, options, .. } = run;
    let session = run.session(result.place);
    let found_requests = session.requests().count();
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
    // A long session is not kept beside the one that it is shrunk to.
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
    Ok(Failure {
        requirement: requirement(&minimal, &finding),
        level: finding.level,
        session: minimal.name.clone(),
        row: result.row.clone(),
        idea: minimal.idea.clone(),
        says: finding.says.clone(),
        suite: minimal.to_suite(),
        minimal: shown_lines(minimal.text()),
        minimal_requests: minimal.requests().count(),
        found_requests,
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
