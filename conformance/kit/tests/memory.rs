//! Failures at the end of the longest sessions, of each kind: they are shrunk in little memory, and while there
//! is time.
#![cfg(target_os = "linux")]

use saarcor_kit::deadline::Deadline;
use saarcor_kit::dut::{ConversationEnd, Dut, InProcess};
use saarcor_kit::error::Error;
use saarcor_kit::implementation::Implementation;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::kinds::KINDS;
use saarcor_kit::plan::{LONG_REQUESTS, Options, PlannedSession, RANDOM_REQUESTS, random_sessions};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict};
use saarcor_kit::run::run;
use saarcor_kit::scoreboard::Scoreboard;
use saarcor_kit::session::Session;
use saarcor_kit::sizes::{Extent, SizedSession};
use std::time::Duration;

/// What a run may take, the implementation beside it.
const MOST_KIB: u64 = 300 << 10;
/// So little that most of the time goes to the session itself.
const LIMIT: Duration = Duration::from_millis(300);

/// An implementation in process with a time limit, as one in a process of its own has it.
struct Limited(InProcess);

impl Dut for Limited {
    fn converse(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        self.0.converse(session, scoreboard, deadline)
    }

    fn time_limit(&self) -> Option<Duration> {
        Some(LIMIT)
    }
}

/// When an answer is wrong.
#[derive(Clone)]
enum When {
    /// After so many requests: nothing before can be left out.
    After(usize),
    /// Behind this request: nearly all can.
    Behind(Vec<u8>),
}

/// The model, but for some answers.
struct Wrong {
    model: Box<dyn Implementation>,
    when: When,
    answered: usize,
    before: Vec<u8>,
}

impl Implementation for Wrong {
    fn observes(&self) -> String {
        self.model.observes()
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        self.model.answer(request, answer)?;
        let is_wrong = match &self.when {
            When::After(requests) => self.answered >= *requests,
            When::Behind(before) => self.before == *before,
        };
        if is_wrong && says_more_than_ok(request) {
            let last = answer.last_mut().expect("an answer");
            *last = match *last {
                b'h' => b'm',
                b'm' => b'h',
                b'0' => b'1',
                _ => b'0',
            };
        }
        self.answered += 1;
        self.before = request.to_vec();
        Ok(())
    }
}

/// Reads, runs, sets and rays.
fn says_more_than_ok(request: &[u8]) -> bool {
    matches!(request[0], b'r' | b's' | b'c' | b'a')
}

fn longest(kind: &dyn Kind) -> (PlannedSession, Session) {
    let planned = random_sessions(0, usize::MAX / 2, 1).next().expect("a session");
    let PlannedSession::Random { seed, requests } = planned else { panic!("not random") };
    (planned, kind.random(seed, requests))
}

fn report(kind: &'static dyn Kind, planned: PlannedSession, when: &When) -> ConformanceReport {
    let when = when.clone();
    let dut = Limited(InProcess::new(Box::new(move |kind, config| {
        let model = kind.oracle(Oracle::Model, config)?;
        let (when, before) = (when.clone(), Vec::new());
        Ok::<Box<dyn Implementation>, Error>(Box::new(Wrong { model, when, answered: 0, before }))
    })));
    run("wrong", &dut, kind, &[planned], &Options::default(), &|_| ()).expect("it runs")
}

/// The most memory since the last reset, in KiB.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux has it");
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.and_then(|peak| peak.trim().split(' ').next()?.parse().ok()).expect("a number")
}

/// The last request whose answer can be wrong, and the one before it.
fn last_of(session: &Session) -> (usize, Vec<u8>) {
    let last = session.requests().enumerate().filter(|(_, request)| says_more_than_ok(request)).last();
    let (last, _) = last.expect("one");
    let before = session.requests().nth(last - 1).expect("one").to_vec();
    (last, before)
}

/// A run of one session that fails when it is said; its report, and the most memory that it took.
fn measured(kind: &'static dyn Kind, planned: PlannedSession, when: &When) -> (ConformanceReport, u64) {
    std::fs::write("/proc/self/clear_refs", "5").expect("the peak is reset");
    let began = std::time::Instant::now();
    let name = planned.name(kind);
    let report = report(kind, planned, when);
    let most = peak();
    assert_eq!(report.verdict, ConformanceVerdict::DoesNotConform, "{name}");
    let failure = &report.failures[0];
    let (minimal, found) = (failure.minimal_requests, failure.found_requests);
    println!("{name}: {most} KiB, {:?}, {minimal} of {found} requests", began.elapsed());
    assert!(most < MOST_KIB, "{name}: {most} KiB");
    (report, most)
}

/// Sessions about sizes of a run of so many requests fail at their ends.
fn sized_sessions_fail_late(requests: usize, among: impl Fn(&SizedSession) -> bool) {
    for kind in KINDS {
        for sized in kind.sizes(&Extent { seed: 0, requests }).into_iter().filter(&among) {
            let (last, before) = last_of(&sized.session());
            for when in [When::After(last), When::Behind(before)] {
                measured(*kind, PlannedSession::Sized(sized.clone()), &when);
            }
        }
    }
}

/// All memory of this process counts: one after the other.
#[test]
fn late_failures_are_shrunk_in_little_memory() {
    for kind in KINDS {
        let (planned, session) = longest(*kind);
        let (last, before) = last_of(&session);
        drop(session);
        for when in [When::After(last), When::Behind(before)] {
            let (report, _) = measured(*kind, planned.clone(), &when);
            let failure = &report.failures[0];
            match when {
                When::After(last) => assert_eq!(failure.minimal_requests, last + 1),
                // On a busy machine the time is over before the session is short.
                When::Behind(_) if failure.cut_short => {}
                When::Behind(_) => assert!(failure.minimal_requests < 200, "{}", failure.text()),
            }
        }
    }
    sized_sessions_fail_late(RANDOM_REQUESTS, |sized| {
        ["vm/sizes/64-mb@policy=lru", "vm/sizes/long", "meta/sizes/long", "kd/sizes/long", "kd/sizes/lists"]
            .contains(&sized.name.as_str())
    });
}

#[test]
#[ignore = "each session about sizes, twice; to be run alone"]
fn late_failures_of_each_size_are_shrunk_in_little_memory() {
    sized_sessions_fail_late(RANDOM_REQUESTS, |_| true);
}

#[test]
#[ignore = "sessions of millions of requests; to be run alone"]
fn late_failures_of_long_sessions_are_shrunk_in_little_memory() {
    sized_sessions_fail_late(LONG_REQUESTS, |sized| {
        sized.name.contains("/sizes/long") || sized.name.contains("/sizes/many-")
    });
}
