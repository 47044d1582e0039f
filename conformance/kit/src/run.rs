//! A whole run: all sessions with one implementation, and the report.

use crate::deadline::Deadline;
use crate::dut::Dut;
use crate::error::Error;
use crate::execution::{Execution, FRESH, Run, SessionResult};
use crate::kind::Kind;
use crate::kinds::{KINDS, kind_of_hello};
use crate::level::Level;
use crate::plan::{Options, PlannedSession, default_suite};
use crate::report::{ConformanceReport, Failure, shown_lines};
use crate::requirements;
use crate::scoreboard::{Finding, SESSIONS, Scoreboard};
use crate::session::Session;
use crate::shrink::{ShrinkResult, shrink};
use crate::summary::Summary;
use rayon::prelude::*;
use std::sync::Mutex;

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
        let ending = dut.converse_alone(&session, &mut scoreboard, &Deadline::never())?;
        let refused = scoreboard.findings().iter().find(|finding| finding.asked == kind.hello());
        let Some(finding) = refused else { return Ok(Some(*kind)) };
        let got = finding.got.as_bytes();
        if let Some(named) = kind_of_hello(got.strip_suffix(SESSIONS).unwrap_or(got)) {
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
    let run = Run { dut, kind, planned, options, large: &Mutex::new(()) };
    let executed = run.execute(progress);
    dut.finish();
    let Execution { results, stopped, random_seconds, shrinking } = executed?;
    let failures = failures(&run, &results, &shrinking)?;
    Ok(Summary { name, run: &run, results: &results }.report(failures, stopped, random_seconds))
}

/// Failures that are shrunk: of each requirement and level the first, and no more than these.
const SHOWN_FAILURES: usize = 8;

/// Of each requirement and level the first session that fails, shrunk.
fn failures(run: &Run<'_>, results: &[SessionResult], deadline: &Deadline) -> Result<Vec<Failure>, Error> {
    let mut chosen: Vec<(usize, &Finding)> = Vec::new();
    for (place, session) in results.iter().enumerate() {
        let Some(finding) = session.lowest().filter(|_| session.fails()) else { continue };
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
    let _alone = run.alone(result.place);
    let session = run.session(result.place);
    let found_requests = session.requests().count();
    let config = session.config().to_owned();
    let mut trouble = None;
    let mut fails = |session: &Session| {
        let mut scoreboard = Scoreboard::new(kind, session, options.highest());
        if let Err(error) = dut.converse_alone(session, &mut scoreboard, deadline) {
            trouble.get_or_insert(error);
            return None;
        }
        let same =
            |found: &&Finding| found.level == finding.level && found.requirement == finding.requirement;
        scoreboard.findings().iter().find(same).cloned()
    };
    // A long session is not kept beside the one that it is shrunk to.
    let ShrinkResult { session: minimal, finding, cut_short } =
        if !options.shrink || result.timeout.is_some() || finding.requirement == FRESH || deadline.has_come()
        {
            // Each try would take the time limit again, or would pass: only the requests behind the failing one are left out.
            let session = session.with_those(|place| place < finding.asked_by_then());
            ShrinkResult { session, finding: finding.clone(), cut_short: true }
        } else {
            shrink(kind, session, finding, deadline, &mut fails)
        };
    if let Some(error) = trouble {
        return Err(error);
    }
    // The whole session says more of the cause than what is left of it.
    let broken = result.broken.clone().unwrap_or_else(|| finding.requirement.to_owned());
    Ok(Failure {
        demands: requirements::text(&broken).unwrap_or_default().to_owned(),
        requirement: broken,
        level: finding.level,
        session: minimal.name.clone(),
        row: result.row.clone(),
        config,
        again: run.planned[result.place].again(kind, &options.extent()),
        idea: minimal.idea.clone(),
        says: finding.says.clone(),
        minimal: shown_lines(&minimal),
        minimal_requests: minimal.requests().count(),
        found_requests,
        cut_short,
        state_before: finding.request.map(|request| kind.state_before(&minimal, request)).unwrap_or_default(),
        asked: finding.asked.clone(),
        expected: finding.expected.clone(),
        got: finding.got.clone(),
        stderr: result.stderr.clone(),
        suite: minimal,
        replay: None,
    })
}
