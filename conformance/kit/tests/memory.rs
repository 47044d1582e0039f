//! Failures at the end of the longest session, of each kind: they are shrunk in little memory, and while there
//! is time.
#![cfg(target_os = "linux")]

use saarcor_kit::deadline::Deadline;
use saarcor_kit::dut::{ConversationEnd, Dut, InProcess};
use saarcor_kit::error::Error;
use saarcor_kit::implementation::Implementation;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::kinds::KINDS;
use saarcor_kit::plan::{Options, PlannedSession, random_sessions};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict};
use saarcor_kit::run::run;
use saarcor_kit::scoreboard::Scoreboard;
use saarcor_kit::session::Session;
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

#[test]
fn late_failures_are_shrunk_in_little_memory() {
    for kind in KINDS {
        let (planned, session) = longest(*kind);
        let requests: Vec<&[u8]> = session.requests().collect();
        let last = requests.iter().rposition(|request| says_more_than_ok(request)).expect("one");
        let behind = When::Behind(requests[last - 1].to_vec());
        drop(session);
        for when in [When::After(last), behind] {
            std::fs::write("/proc/self/clear_refs", "5").expect("the peak is reset");
            let began = std::time::Instant::now();
            let report = report(*kind, planned.clone(), &when);
            let most = peak();
            assert_eq!(report.verdict, ConformanceVerdict::DoesNotConform);
            let failure = &report.failures[0];
            println!(
                "{}: {most} KiB, {:?}, {} of {} requests",
                kind.name(),
                began.elapsed(),
                failure.minimal_requests,
                failure.found_requests
            );
            assert!(most < MOST_KIB, "{}: {most} KiB", kind.name());
            match when {
                When::After(last) => assert_eq!(failure.minimal_requests, last + 1),
                // On a busy machine the time is over before the session is short.
                When::Behind(_) if failure.cut_short => {}
                When::Behind(_) => assert!(failure.minimal_requests < 200, "{}", failure.text()),
            }
        }
    }
}
