//! Holds the sessions of a run, and gathers what they find, in bounded time.
//!
//! Each session has the implementation's time limit. One that is too slow for a session reaches it in
//! the longest ones; so the first random session is held from the begin on, beside the others, and ends
//! the run at the time limit. From the first failure on, the verdict stands: what else fails is gathered
//! for half of a time limit, and shrunk in what is left of a whole one; for longer, where answers take next
//! to no time.

use crate::dut::{Dut, Ending, Timeout};
use crate::judge::{Finding, Judge};
use crate::kind::Kind;
use crate::level::Level;
use crate::run::{Options, Planned};
use crate::stop::Stop;
use anyhow::Result;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{ScopedJoinHandle, scope};
use std::time::{Duration, Instant};

/// Sessions between two looks at the number of errors. It does not depend on the threads, and so
/// neither does the report.
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

/// What one session gave.
#[derive(Debug)]
pub(crate) struct Held {
    /// Its place in the plan.
    pub place: usize,
    /// Its row of the report.
    pub row: String,
    pub stderr: String,
    pub findings: Vec<Finding>,
    pub unsupported: Option<String>,
    /// Which of the kind's levels could be judged.
    pub observed: Vec<Level>,
    pub answered: usize,
    pub random: bool,
    pub seconds: f64,
    pub timeout: Option<Timeout>,
}

/// What all sessions gave, by their places.
pub(crate) struct Gathered {
    pub held: Vec<Held>,
    /// Why sessions were left out, if some were.
    pub stopped: Option<String>,
    /// Seconds that the random sessions took together.
    pub random_seconds: f64,
    /// When failures are to be shrunk.
    pub shrinking: Stop,
}

/// Rows of the report for sessions that are about no requirement.
const RANDOM: &str = "random";
const GIVEN: &str = "frames, files";

/// Holds all sessions. `progress` is told the part that is done.
pub(crate) fn gather(
    dut: &dyn Dut,
    kind: &dyn Kind,
    planned: &[Planned],
    options: &Options,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Gathered> {
    let (stop, more, done) = (Stop::never(), Stop::never(), AtomicUsize::new(0));
    let gathering = &Gathering { dut, kind, planned, options, progress, stop, more, done };
    scope(|scope| {
        let long = planned.iter().position(|planned| matches!(planned, Planned::Random { .. }));
        let long = long.map(|place| (place, scope.spawn(move || gathering.hold(place))));
        gathering.all(long)
    })
}

/// A random session that is held beside the others, by its place.
type Beside<'scope> = (usize, ScopedJoinHandle<'scope, Result<Option<Held>>>);

struct Gathering<'a> {
    dut: &'a dyn Dut,
    kind: &'a dyn Kind,
    planned: &'a [Planned],
    options: &'a Options,
    progress: &'a (dyn Fn(f64) + Sync),
    /// When all is given up: a time limit after the first failure, and [`START_GRACE`].
    stop: Stop,
    /// When what began after the first failure is: half a time limit after it.
    more: Stop,
    done: AtomicUsize,
}

impl Gathering<'_> {
    fn all(&self, mut long: Option<Beside<'_>>) -> Result<Gathered> {
        let mut held: Vec<Held> = Vec::new();
        let mut random_seconds = 0.0;
        let mut enough = false;
        let places: Vec<usize> = (0..self.planned.len()).collect();
        for batch in places.chunks(BATCH) {
            let started = Instant::now();
            let beside = long.take_if(|(place, _)| batch.contains(place));
            let others =
                batch.par_iter().filter(|&&place| beside.as_ref().is_none_or(|(at, _)| *at != place));
            let mut results: Vec<Option<Held>> =
                others.map(|&place| self.hold(place)).collect::<Result<_>>()?;
            // Threads hold sessions at the same time: the random ones have their part of the time.
            let seconds: f64 = results.iter().flatten().map(|held| held.seconds).sum();
            let random = results.iter().flatten().filter(|held| held.random);
            let random: f64 = random.map(|held| held.seconds).sum();
            if seconds > 0.0 {
                random_seconds += started.elapsed().as_secs_f64() * random / seconds;
            }
            if let Some((_, handle)) = beside {
                let long = joined(handle)?;
                let seconds = long.as_ref().map_or(0.0, |held| held.seconds);
                random_seconds += seconds / rayon::current_num_threads() as f64;
                results.push(long);
            }
            held.extend(results.into_iter().flatten());
            held.sort_unstable_by_key(|held| held.place);
            let mut failing = held.iter().enumerate().filter(|(_, held)| !held.findings.is_empty());
            if let Some((last, _)) = failing.nth(self.options.errors.max(1) - 1) {
                held.truncate(last + 1);
                enough = true;
                break;
            }
            if self.more.has_come() {
                break;
            }
        }
        let time_left = self.stop.left();
        if enough {
            self.stop.within(Duration::ZERO);
            self.more.within(Duration::ZERO);
        }
        if let Some((_, handle)) = long {
            let long = joined(handle)?;
            let alone = !held.iter().any(|held| held.timeout.is_some());
            held.extend(long.filter(|_| !enough && alone));
        }
        let shrinking = Stop::never();
        if let Some(limit) = self.dut.time_limit() {
            let late = held.iter().any(|held| held.timeout.is_some());
            let pace = held.iter().map(|held| held.seconds / (held.answered + GREETINGS) as f64);
            let is_quick = pace.fold(f64::INFINITY, f64::min) * QUICK_ANSWERS < limit.as_secs_f64();
            let longer = if is_quick { QUICK_LIMITS * limit } else { Duration::ZERO };
            shrinking.within(if late { LATE_GRACE } else { time_left.saturating_add(longer) });
        }
        Ok(Gathered { stopped: self.why_stopped(&held, enough), held, random_seconds, shrinking })
    }

    /// Why sessions were left out, if some were; but for those that are too slow for the time limit.
    fn why_stopped(&self, held: &[Held], enough: bool) -> Option<String> {
        let timeouts = || held.iter().filter_map(|held| held.timeout);
        if timeouts().any(|timeout| timeout == Timeout::Hung) {
            Some("the implementation hangs".to_owned())
        } else if held.len() == self.planned.len() || timeouts().next().is_some() {
            None
        } else if enough {
            Some(format!("{} sessions fail", self.options.errors.max(1)))
        } else {
            Some("sessions fail, and half of the time limit has gone since the first did".to_owned())
        }
    }

    /// Holds a session; nothing where it was given up before it found something.
    fn hold(&self, place: usize) -> Result<Option<Held>> {
        // The first ones are awaited, whichever of them fails first: they name the cause.
        let is_more = place >= BATCH && self.more.left() < Duration::MAX;
        let stop = if is_more { &self.more } else { &self.stop };
        if stop.has_come() {
            return Ok(None);
        }
        let planned = &self.planned[place];
        let session = planned.session(self.kind, self.options);
        let mut judge = Judge::new(self.kind, &session, self.options.highest());
        let began = Instant::now();
        let Ending { timeout, stderr } = self.dut.converse(&session, &mut judge, stop)?;
        match (timeout, self.dut.time_limit()) {
            // What has had no time once would take the time limit again and again.
            (Some(Timeout::Hung | Timeout::Slow), _) => {
                self.more.within(LATE_GRACE);
                self.stop.within(LATE_GRACE);
            }
            (_, Some(limit)) if !judge.findings().is_empty() => {
                self.more.within(limit / 2);
                self.stop.within(limit + START_GRACE);
            }
            _ => {}
        }
        if timeout == Some(Timeout::Stopped) && judge.findings().is_empty() {
            return Ok(None);
        }
        (self.progress)((self.done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / self.planned.len() as f64);
        let random = matches!(planned, Planned::Random { .. });
        let observed = self.kind.levels().iter().copied().filter(|&level| judge.observed(level)).collect();
        Ok(Some(Held {
            row: session
                .requirement
                .clone()
                .unwrap_or_else(|| if random { RANDOM } else { GIVEN }.to_owned()),
            place,
            stderr: if judge.findings().is_empty() { String::new() } else { stderr },
            findings: judge.findings().to_vec(),
            unsupported: judge.unsupported().map(str::to_owned),
            observed,
            answered: judge.answered(),
            random,
            seconds: began.elapsed().as_secs_f64(),
            timeout: timeout.filter(|&timeout| timeout != Timeout::Stopped),
        }))
    }
}

/// What a thread made; its panic is this one's.
fn joined(handle: ScopedJoinHandle<'_, Result<Option<Held>>>) -> Result<Option<Held>> {
    handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
