//! Runs the sessions of a plan, in bounded time.
//!
//! Each session has the implementation's time limit. A slow implementation reaches it in the longest
//! sessions first; so the first random session starts at once, beside the others, and stops the run at the time
//! limit. After the first failure the verdict is known: sessions then run for half of a time limit more, and
//! their failures are shrunk until the end of a whole one, or for longer where answers take next to no time.
//! A session that hangs is one failure of many, where others have been held to their ends: then the rest have a time
//! limit together, and a part of it each.

use crate::comparison::Admitted;
use crate::deadline::Deadline;
use crate::dut::{ConversationEnd, Dut, Timeout};
use crate::error::Error;
use crate::kind::Kind;
use crate::level::Level;
use crate::plan::{Options, PlannedSession};
use crate::scoreboard::{Finding, Scoreboard, Stage};
use crate::session::Session;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{ScopedJoinHandle, scope};
use std::time::{Duration, Instant};

/// Sessions that are awaited for a whole time limit after the first failure, whichever of them fails first: they name
/// the cause.
const FIRST: usize = 16;
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

/// The requirement that a session begins as if it were the first of its process.
pub(crate) const FRESH: &str = "P-9";

/// The result of one session.
#[derive(Debug)]
pub(crate) struct SessionResult {
    /// Its place in the plan.
    pub place: usize,
    /// Its name.
    pub name: String,
    /// The row of the report that counts it.
    pub row: String,
    /// The end of what the implementation wrote to standard error; empty where nothing differs.
    pub stderr: String,
    /// The first difference at each level.
    pub findings: Vec<Finding>,
    /// The requirement that is broken, where something differs.
    pub broken: Option<String>,
    /// Why its failure does not count, where it is known.
    pub waived: Option<String>,
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
    /// Answers that were right, though they were not the model's.
    pub admitted: Vec<Admitted>,
    /// It is a random session.
    pub random: bool,
    /// Seconds that it took.
    pub seconds: f64,
    /// How its time ran out.
    pub timeout: Option<Timeout>,
}

impl SessionResult {
    /// The difference at the lowest level: those above follow from it.
    pub fn lowest(&self) -> Option<&Finding> {
        self.findings.iter().min_by_key(|finding| finding.level)
    }

    /// Whether it fails, and that counts.
    pub fn fails(&self) -> bool {
        !self.findings.is_empty() && self.waived.is_none()
    }
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

/// An implementation, and what it is run with.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub dut: &'a dyn Dut,
    pub kind: &'a dyn Kind,
    pub planned: &'a [PlannedSession],
    pub options: &'a Options,
    /// Held by the one session that takes much memory.
    pub large: &'a Mutex<()>,
}

impl Run<'_> {
    /// Waits until no other session is held that takes much memory, where the one at this place does.
    pub fn alone(&self, place: usize) -> Option<MutexGuard<'_, ()>> {
        let is_large = matches!(&self.planned[place], PlannedSession::Sized(sized) if sized.is_large);
        is_large.then(|| self.large.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The session at a place of the plan.
    pub fn session(&self, place: usize) -> Session {
        self.planned[place].session(self.kind, self.options)
    }

    /// Runs all sessions. `progress` is given the part that is done, from 0 to 1.
    pub fn execute(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<Execution, Error> {
        let (deadline, extra_deadline) = (Deadline::never(), Deadline::never());
        let (done, has_ended) = (AtomicUsize::new(0), AtomicBool::new(false));
        let executor = &Executor { run: *self, progress, deadline, extra_deadline, done, has_ended };
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
    /// Whether a session was held to its end.
    has_ended: AtomicBool,
}

impl Executor<'_> {
    fn all(&self, long: Option<Beside<'_>>) -> Result<Execution, Error> {
        let started = Instant::now();
        let mut results = self.in_order(long.as_ref().map(|(place, _)| *place))?;
        let seconds = |results: &[SessionResult], is_counted: fn(&SessionResult) -> bool| -> f64 {
            results.iter().filter(|result| is_counted(result)).map(|result| result.seconds).sum()
        };
        // Threads run sessions at the same time: the random ones take their share of it.
        let (all, random) = (seconds(&results, |_| true), seconds(&results, |result| result.random));
        let share = if all > 0.0 { random / all } else { 0.0 };
        let mut random_seconds = started.elapsed().as_secs_f64() * share;
        let mut is_enough = self.cut(&mut results);
        let mut time_left = self.deadline.left();
        if let Some((place, handle)) = long {
            let is_behind = is_enough && results.last().is_none_or(|last| last.place < place);
            if is_behind {
                self.deadline.within(Duration::ZERO);
                self.extra_deadline.within(Duration::ZERO);
            }
            let long = joined(handle)?;
            if !is_behind {
                // It may be the first that fails.
                time_left = self.deadline.left();
            }
            let alone = !results.iter().any(|result| result.timeout == Some(Timeout::Slow));
            if let Some(long) = long.filter(|_| !is_behind && alone) {
                random_seconds += long.seconds / rayon::current_num_threads() as f64;
                results.push(long);
                is_enough = self.cut(&mut results);
            }
        }
        let shrinking = Deadline::never();
        if let Some(limit) = self.run.dut.time_limit() {
            // What hangs is not shrunk.
            let is_shrunk = |result: &SessionResult| result.timeout.is_none() && result.fails();
            let is_slow = results.iter().any(|result| result.timeout == Some(Timeout::Slow));
            let late = is_slow || !results.iter().any(is_shrunk);
            let pace = results.iter().map(|result| result.seconds / (result.answered + GREETINGS) as f64);
            let is_quick = pace.fold(f64::INFINITY, f64::min) * QUICK_ANSWERS < limit.as_secs_f64();
            let longer = if is_quick { QUICK_LIMITS * limit } else { Duration::ZERO };
            shrinking.within(if late { LATE_GRACE } else { time_left.saturating_add(longer) });
        }
        Ok(Execution { stopped: self.why_stopped(&results, is_enough), results, random_seconds, shrinking })
    }

    /// Runs the sessions but the one at `beside`, each begun in the order of the plan, until enough have failed.
    fn in_order(&self, beside: Option<usize>) -> Result<Vec<SessionResult>, Error> {
        let (next, failing) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let of_thread = |_: usize| {
            let mut results = Vec::new();
            while failing.load(Ordering::Relaxed) < self.errors() {
                let place = next.fetch_add(1, Ordering::Relaxed);
                if place >= self.run.planned.len() {
                    break;
                }
                if Some(place) == beside {
                    continue;
                }
                match self.session(place) {
                    Ok(Some(result)) => {
                        failing.fetch_add(usize::from(result.fails()), Ordering::Relaxed);
                        results.push(result);
                    }
                    Ok(None) => {}
                    Err(error) => {
                        // Nothing more is begun.
                        failing.store(self.errors(), Ordering::Relaxed);
                        return Err(error);
                    }
                }
            }
            Ok(results)
        };
        // This thread begins at once, whatever the others do.
        let threads = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1);
        let of_threads = threads.map(of_thread).collect::<Result<Vec<_>, Error>>()?;
        Ok(of_threads.into_iter().flatten().collect())
    }

    /// Sessions that fail before a run is stopped.
    fn errors(&self) -> usize {
        self.run.options.errors.max(1)
    }

    /// Orders the results, and leaves out those behind the last failure that is asked for: all before it are there,
    /// whatever the number of threads. Returns whether so many fail.
    fn cut(&self, results: &mut Vec<SessionResult>) -> bool {
        results.sort_unstable_by_key(|result| result.place);
        let mut failing = results.iter().enumerate().filter(|(_, result)| result.fails());
        let last = failing.nth(self.errors() - 1).map(|(last, _)| last);
        results.truncate(last.map_or(results.len(), |last| last + 1));
        last.is_some()
    }

    /// Why sessions were left out, if some were; but for those that are too slow for the time limit.
    fn why_stopped(&self, results: &[SessionResult], is_enough: bool) -> Option<String> {
        let is_any = |timeout| results.iter().any(|result| result.timeout == Some(timeout));
        if results.len() == self.run.planned.len() {
            None
        } else if is_enough {
            Some(format!("{} sessions fail", self.errors()))
        } else if is_any(Timeout::Hung) {
            Some("the implementation hangs".to_owned())
        } else if is_any(Timeout::Slow) {
            None
        } else {
            Some("sessions fail, and half of the time limit has gone since the first did".to_owned())
        }
    }

    /// Runs a session; none where it was stopped before anything differed.
    fn session(&self, place: usize) -> Result<Option<SessionResult>, Error> {
        let is_more = place >= FIRST && self.extra_deadline.left() < Duration::MAX;
        let deadline = if is_more { &self.extra_deadline } else { &self.deadline };
        if deadline.has_come() {
            return Ok(None);
        }
        let Run { dut, kind, planned, options, .. } = self.run;
        let _alone = self.run.alone(place);
        let session = self.run.session(place);
        let mut scoreboard = Scoreboard::new(kind, &session, options.highest());
        let began = Instant::now();
        let mut end = dut.converse(&session, &mut scoreboard, deadline)?;
        if end.is_used && !scoreboard.findings().is_empty() {
            // Is it the session, or those before it in the same process?
            scoreboard = Scoreboard::new(kind, &session, options.highest());
            end = dut.converse_alone(&session, &mut scoreboard, deadline)?;
            if end.timeout.is_none() && scoreboard.findings().is_empty() {
                scoreboard
                    .misbehaves(FRESH, "the session fails behind others in one process, and passes alone");
            }
        }
        let ConversationEnd { timeout, stderr, .. } = end;
        let lowest = scoreboard.findings().iter().min_by_key(|finding| finding.level);
        let explanations = lowest.map(|finding| scoreboard.explanations(finding)).unwrap_or_default();
        let broken = requirement(&session, scoreboard.findings(), &explanations);
        let waiver = broken.as_ref().and_then(|broken| options.waivers.find(&session.name, broken));
        let waived = waiver.map(|waiver| waiver.reason.clone());
        if scoreboard.stage() == Stage::Ended && timeout.is_none() {
            self.has_ended.store(true, Ordering::Relaxed);
        }
        match (timeout, dut.time_limit()) {
            (Some(Timeout::Hung), Some(limit)) if self.has_ended.load(Ordering::Relaxed) => {
                dut.hurry();
                self.extra_deadline.within(limit);
                self.deadline.within(limit + START_GRACE);
            }
            // What has had no time once would take the time limit again and again.
            (Some(Timeout::Hung | Timeout::Slow), _) => {
                self.extra_deadline.within(LATE_GRACE);
                self.deadline.within(LATE_GRACE);
            }
            (_, Some(limit)) if lowest.is_some() && waived.is_none() => {
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
            row: planned[place].row().to_owned(),
            place,
            name: session.name.clone(),
            broken,
            waived,
            stderr: if scoreboard.findings().is_empty() { String::new() } else { stderr },
            findings: scoreboard.findings().to_vec(),
            unsupported: scoreboard.unsupported().map(str::to_owned),
            config: session.config().to_owned(),
            level: session.level,
            observed,
            unobserved: scoreboard.unobserved().to_vec(),
            answered: scoreboard.answered(),
            admitted: scoreboard.admitted().to_vec(),
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

/// The requirement that a session fails for. A directed session fails for its own, whatever differs, with these
/// exceptions: wrong bytes, unless it is about bytes; a conversation that breaks off, unless it is about answers
/// and their form; the bytes of an entry of metadata; the order of free ways; and where it is about replacement, free
/// ways or invalidation, and a breach of another of these alone explains all answers. A random session fails for what alone explains all.
fn requirement(session: &Session, findings: &[Finding], explanations: &[&'static str]) -> Option<String> {
    let lowest = findings.iter().min_by_key(|finding| finding.level)?;
    let own = cause(findings, lowest).requirement;
    let about = session.requirement.as_deref().unwrap_or(own);
    let of_bytes = lowest.level == Level::Data && session.level != Some(Level::Data);
    let breaks_off = lowest.level == Level::Protocol && !(about.starts_with("P-") && own == "P-5");
    if breaks_off || of_bytes || own == ENTRY_BYTES {
        return Some(own.to_owned());
    }
    let named = if own == FREE_WAYS { own } else { about };
    let explained = match explanations {
        _ if lowest.level <= Level::Data || explanations.contains(&named) => None,
        _ if explanations.contains(&own) => Some(own),
        [first, others @ ..] if others.iter().all(|other| other == first) => Some(*first),
        _ => None,
    };
    // Directed sessions are short: more than one thing explains what they show, and each is about the likeliest. Only
    // which line leaves, which free way is filled and what an invalidation forgets show in each other's sessions.
    let neighbours = [REPLACEMENT, FREE_WAYS, INVALIDATION];
    let is_open = |explained: &&str| {
        session.requirement.is_none() || neighbours.contains(&named) && neighbours.contains(explained)
    };
    Some(explained.filter(is_open).unwrap_or(named).to_owned())
}

/// The finding that others follow from: a line in a wrong set or way, or a wrong victim, comes before the wrong hits
/// that it leads to.
fn cause<'a>(findings: &'a [Finding], lowest: &'a Finding) -> &'a Finding {
    let leads_to_hits = |finding: &&Finding| (Level::Traffic..=Level::State).contains(&finding.level);
    match lowest.level {
        Level::Traffic => {
            let first = findings.iter().filter(leads_to_hits).min_by_key(|finding| finding.request);
            first.unwrap_or(lowest)
        }
        _ => lowest,
    }
}

/// The requirement of what an entry of metadata consists of.
const ENTRY_BYTES: &str = "VM-12";

/// The requirement of what an invalidation forgets.
const INVALIDATION: &str = "VM-8";

/// The requirement of which line is evicted.
const REPLACEMENT: &str = "VM-6";

/// The requirement of which free way is filled.
const FREE_WAYS: &str = "VM-7";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_fails_for_what_explains_its_answers() {
        let mut session = Session::new("x", "saarcor-vm 1", "", b"");
        let finding = Finding {
            level: Level::Traffic,
            requirement: "VM-6",
            request: Some(0),
            asked: String::new(),
            expected: String::new(),
            got: String::new(),
            says: String::new(),
        };
        let broken = |session: &Session, finding: &Finding, explanations: &[&'static str]| {
            requirement(session, std::slice::from_ref(finding), explanations).expect("it fails")
        };
        assert_eq!(broken(&session, &finding, &["VM-7"]), "VM-7");
        // A line in a wrong set leads to wrong hits.
        let wrong_hit = Finding { request: Some(1), ..finding.clone() };
        let wrong_set = Finding { level: Level::State, requirement: "VM-3", ..finding.clone() };
        assert_eq!(requirement(&session, &[wrong_set, wrong_hit], &[]).as_deref(), Some("VM-3"));
        session.requirement = Some("VM-6".to_owned());
        assert_eq!(broken(&session, &finding, &["VM-8"]), "VM-8");
        assert_eq!(broken(&session, &finding, &["VM-3"]), "VM-6");
        session.requirement = Some("VM-8".to_owned());
        for (explanations, named) in [
            (&[][..], "VM-8"),
            (&["VM-7", "VM-7"][..], "VM-7"),
            (&["VM-7", "VM-6"][..], "VM-6"),
            (&["VM-7", "VM-8"][..], "VM-8"),
            // Either may be the cause.
            (&["VM-7", "VM-3"][..], "VM-8"),
        ] {
            assert_eq!(broken(&session, &finding, explanations), named, "{explanations:?}");
        }
        // Of a hit that should miss sizes are no likelier cause.
        assert_eq!(broken(&session, &finding, &["VM-1"]), "VM-8");
        // Bytes and the conversation say by themselves what is broken.
        let bytes = Finding { level: Level::Data, requirement: "VM-9", ..finding };
        assert_eq!(broken(&session, &bytes, &["VM-7"]), "VM-9");
    }
}
