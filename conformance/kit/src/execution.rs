//! Runs the sessions of a plan, in bounded time.
//!
//! Each session has the implementation's time limit. A slow implementation reaches it in the longest
//! sessions first; so the first random session starts at once, beside the others, and stops the run at the time
//! limit. After the first failure the verdict is known: sessions then run for half of a time limit more, and
//! their failures are shrunk until the end of a whole one, or for longer where answers take next to no time.

use crate::deadline::Deadline;
use crate::dut::{ConversationEnd, Dut, Timeout};
use crate::error::Error;
use crate::kind::Kind;
use crate::level::Level;
use crate::plan::{Options, PlannedSession};
use crate::scoreboard::{Finding, Scoreboard};
use crate::session::Session;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{ScopedJoinHandle, scope};
use std::time::{Duration, Instant};

/// Sessions between two checks of the number of errors. It does not depend on the number of threads, and so the
/// report does not either.
const BATCH: usize = 16;
/// Time for sessions that began together with one that reached its time limit, and then for shrinking:
/// far less than the two seconds in which a verdict is due.
const LATE_GRACE: Duration = Duration::from_millis(250);
/// By how much later than the first session to fail others may have begun that are awaited, each for the
/// time limit of its own: on a busy machine processes take their time to start.
const START_GRACE: Duration = Duration::from_millis(500);

/// Answers in a time limit of an implementation that is quick, its start counted: the verdict on a slow
/// one is what has to be hurried.
const QUICK_ANSWERS: f64 = 2000.0;
/// Answers beside those to requests: to the hello, to the configuration, and to the end.
const GREETINGS: usize = 3;
/// Time limits that the failures of a quick one are shrunk for.
const QUICK_LIMITS: u32 = 3;

/// The result of one session.
#[derive(Debug)]
pub(crate) struct SessionResult {
    /// Its place in the plan.
    pub place: usize,
    /// The row of the report that counts it.
    pub row: String,
    /// The end of what the implementation wrote to standard error; empty where nothing differs.
    pub stderr: String,
    /// The first difference at each level.
    pub findings: Vec<Finding>,
    /// The key that the implementation does not support.
    pub unsupported: Option<String>,
    /// Its configuration.
    pub config: String,
    /// The level up to which the session is judged; none: all.
    pub level: Option<Level>,
    /// Which of the kind's levels are observed.
    pub observed: Vec<Level>,
    /// Parts of an answer that are not.
    pub unobserved: Vec<&'static str>,
    /// Requests that were answered.
    pub answered: usize,
    /// It is a random session.
    pub random: bool,
    /// Seconds that it took.
    pub seconds: f64,
    /// How its time ran out.
    pub timeout: Option<Timeout>,
}

/// The results of all sessions.
pub(crate) struct Execution {
    /// By their places.
    pub results: Vec<SessionResult>,
    /// Why sessions were left out, if some were.
    pub stopped: Option<String>,
    /// Seconds that the random sessions took together.
    pub random_seconds: f64,
    /// When failures are to be shrunk.
    pub shrinking: Deadline,
}

/// Rows of the report for sessions that are about no requirement.
const RANDOM: &str = "random";
const GIVEN: &str = "frames, files";

/// An implementation, and what it is run with.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub dut: &'a dyn Dut,
    pub kind: &'a dyn Kind,
    pub planned: &'a [PlannedSession],
    pub options: &'a Options,
}

impl Run<'_> {
    /// The session at a place of the plan.
    pub fn session(&self, place: usize) -> Session {
        self.planned[place].session(self.kind, self.options)
    }

    /// Runs all sessions. `progress` is given the part that is done, from 0 to 1.
    pub fn execute(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<Execution, Error> {
        let (deadline, extra_deadline) = (Deadline::never(), Deadline::never());
        let executor =
            &Executor { run: *self, progress, deadline, extra_deadline, done: AtomicUsize::new(0) };
        scope(|scope| {
            let is_random = |planned: &PlannedSession| matches!(planned, PlannedSession::Random { .. });
            let long = self.planned.iter().position(is_random);
            let long = long.map(|place| (place, scope.spawn(move || executor.session(place))));
            executor.all(long)
        })
    }
}

/// A random session that runs beside the others, by its place.
type Beside<'scope> = (usize, ScopedJoinHandle<'scope, Result<Option<SessionResult>, Error>>);

struct Executor<'a> {
    run: Run<'a>,
    progress: &'a (dyn Fn(f64) + Sync),
    /// For all sessions: a time limit after the first failure, and [`START_GRACE`].
    deadline: Deadline,
    /// For sessions that start after the first failure: half a time limit after it.
    extra_deadline: Deadline,
    done: AtomicUsize,
}

impl Executor<'_> {
    fn all(&self, mut long: Option<Beside<'_>>) -> Result<Execution, Error> {
        let mut results: Vec<SessionResult> = Vec::new();
        let mut random_seconds = 0.0;
        let mut enough = false;
        let places: Vec<usize> = (0..self.run.planned.len()).collect();
        for batch in places.chunks(BATCH) {
            let started = Instant::now();
            let beside = long.take_if(|(place, _)| batch.contains(place));
            let others =
                batch.par_iter().filter(|&&place| beside.as_ref().is_none_or(|(at, _)| *at != place));
            let mut of_batch: Vec<Option<SessionResult>> =
                others.map(|&place| self.session(place)).collect::<Result<_, Error>>()?;
            // Threads run sessions at the same time: the random ones take their share of it.
            let seconds: f64 = of_batch.iter().flatten().map(|result| result.seconds).sum();
            let random = of_batch.iter().flatten().filter(|result| result.random);
            let random: f64 = random.map(|result| result.seconds).sum();
            if seconds > 0.0 {
                random_seconds += started.elapsed().as_secs_f64() * random / seconds;
            }
            if let Some((_, handle)) = beside {
                let long = joined(handle)?;
                let seconds = long.as_ref().map_or(0.0, |result| result.seconds);
                random_seconds += seconds / rayon::current_num_threads() as f64;
                of_batch.push(long);
            }
            results.extend(of_batch.into_iter().flatten());
            results.sort_unstable_by_key(|result| result.place);
            let mut failing = results.iter().enumerate().filter(|(_, result)| !result.findings.is_empty());
            if let Some((last, _)) = failing.nth(self.run.options.errors.max(1) - 1) {
                results.truncate(last + 1);
                enough = true;
                break;
            }
            if self.extra_deadline.has_come() {
                break;
            }
        }
        let time_left = self.deadline.left();
        if enough {
            self.deadline.within(Duration::ZERO);
            self.extra_deadline.within(Duration::ZERO);
        }
        if let Some((_, handle)) = long {
            let long = joined(handle)?;
            let alone = !results.iter().any(|result| result.timeout.is_some());
            results.extend(long.filter(|_| !enough && alone));
        }
        let shrinking = Deadline::never();
        if let Some(limit) = self.run.dut.time_limit() {
            let late = results.iter().any(|result| result.timeout.is_some());
            let pace = results.iter().map(|result| result.seconds / (result.answered + GREETINGS) as f64);
            let is_quick = pace.fold(f64::INFINITY, f64::min) * QUICK_ANSWERS < limit.as_secs_f64();
            let longer = if is_quick { QUICK_LIMITS * limit } else { Duration::ZERO };
            shrinking.within(if late { LATE_GRACE } else { time_left.saturating_add(longer) });
        }
        Ok(Execution { stopped: self.why_stopped(&results, enough), results, random_seconds, shrinking })
    }

    /// Why sessions were left out, if some were; but for those that are too slow for the time limit.
    fn why_stopped(&self, results: &[SessionResult], enough: bool) -> Option<String> {
        let timeouts = || results.iter().filter_map(|result| result.timeout);
        if timeouts().any(|timeout| timeout == Timeout::Hung) {
            Some("the implementation hangs".to_owned())
        } else if results.len() == self.run.planned.len() || timeouts().next().is_some() {
            None
        } else if enough {
            Some(format!("{} sessions fail", self.run.options.errors.max(1)))
        } else {
            Some("sessions fail, and half of the time limit has gone since the first did".to_owned())
        }
    }

    /// Runs a session; none where it was stopped before anything differed.
    fn session(&self, place: usize) -> Result<Option<SessionResult>, Error> {
        // The first ones are awaited, whichever of them fails first: they name the cause.
        let is_more = place >= BATCH && self.extra_deadline.left() < Duration::MAX;
        let deadline = if is_more { &self.extra_deadline } else { &self.deadline };
        if deadline.has_come() {
            return Ok(None);
        }
        let Run { dut, kind, planned, options } = self.run;
        let session = self.run.session(place);
        let mut scoreboard = Scoreboard::new(kind, &session, options.highest());
        let began = Instant::now();
        let ConversationEnd { timeout, stderr } = dut.converse(&session, &mut scoreboard, deadline)?;
        match (timeout, dut.time_limit()) {
            // What has had no time once would take the time limit again and again.
            (Some(Timeout::Hung | Timeout::Slow), _) => {
                self.extra_deadline.within(LATE_GRACE);
                self.deadline.within(LATE_GRACE);
            }
            (_, Some(limit)) if !scoreboard.findings().is_empty() => {
                self.extra_deadline.within(limit / 2);
                self.deadline.within(limit + START_GRACE);
            }
            _ => {}
        }
        if timeout == Some(Timeout::Stopped) && scoreboard.findings().is_empty() {
            return Ok(None);
        }
        (self.progress)((self.done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / planned.len() as f64);
        let random = matches!(planned[place], PlannedSession::Random { .. });
        let observed = kind.levels().iter().copied().filter(|&level| scoreboard.observed(level)).collect();
        Ok(Some(SessionResult {
            row: session
                .requirement
                .clone()
                .unwrap_or_else(|| if random { RANDOM } else { GIVEN }.to_owned()),
            place,
            stderr: if scoreboard.findings().is_empty() { String::new() } else { stderr },
            findings: scoreboard.findings().to_vec(),
            unsupported: scoreboard.unsupported().map(str::to_owned),
            config: session.config().to_owned(),
            level: session.level,
            observed,
            unobserved: scoreboard.unobserved().to_vec(),
            answered: scoreboard.answered(),
            random,
            seconds: began.elapsed().as_secs_f64(),
            timeout: timeout.filter(|&timeout| timeout != Timeout::Stopped),
        }))
    }
}

/// The result of a thread; its panic becomes this one's.
fn joined(
    handle: ScopedJoinHandle<'_, Result<Option<SessionResult>, Error>>,
) -> Result<Option<SessionResult>, Error> {
    handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
