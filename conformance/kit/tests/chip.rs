//! `saarcor-chip`: sums by hand, tolerances, what shrinking leaves, and the recorded frame.

use saarcor_kit::chip::Chip;
use saarcor_kit::chip::request::{Answer, Observes, Request};
use saarcor_kit::dut::InProcess;
use saarcor_kit::error::Error;
use saarcor_kit::implementation::Implementation;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::level::Level;
use saarcor_kit::plan::{Options, default_suite, sessions_named};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict};
use saarcor_kit::run::run;
use saarcor_kit::server::serve;
use saarcor_kit::session::Session;
use saarcor_kit::sizes::Extent;

/// The sums of a suite's comments, `# 17 cycles: ..`, by the runs that they stand before.
fn sums(text: &str) -> Vec<Option<u64>> {
    let mut sums = Vec::new();
    let mut sum = None;
    for line in text.lines() {
        let number = line.strip_prefix("# ").and_then(|line| line.split_once(" cycles"));
        sum = number.and_then(|(number, _)| number.parse().ok()).or(sum);
        if line == "run" {
            sums.push(sum.take());
        }
    }
    sums
}

/// The answers to the runs of a session.
fn runs(session: &Session, oracle: Oracle) -> Vec<Answer> {
    let make = move |kind: &dyn Kind, config: &str| kind.oracle(oracle, config);
    let mut answers = Vec::new();
    serve(&make, &*session.text(), &mut answers).expect("memory can be written");
    let lines = answers.split(|&byte| byte == b'\n').filter(|line| line.starts_with(b"c "));
    lines.map(|line| Answer::parse(line, Observes::ALL).expect("the form is right")).collect()
}

#[test]
fn sums_by_hand_are_the_models() {
    let mut checked = 0;
    for (name, text) in Chip.suites() {
        let session = Session::parse(name, text).expect("a suite").remove(0);
        let cycles: Vec<_> = runs(&session, Oracle::Model).iter().map(|answer| answer.cycles).collect();
        let sums = sums(text);
        assert_eq!(cycles.len(), sums.len(), "{name}");
        for (cycles, sum) in cycles.into_iter().zip(sums).filter(|(_, sum)| sum.is_some()) {
            assert_eq!(cycles, sum, "{name}");
            checked += 1;
        }
    }
    assert!(checked > 40, "{checked}");
}

/// The model whose runs take a part more cycles, and bytes if it is to.
struct Slower {
    model: Box<dyn Implementation>,
    thousandths: u64,
}

impl Implementation for Slower {
    fn observes(&self) -> String {
        self.model.observes()
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let mut right = Vec::new();
        self.model.answer(request, &mut right)?;
        match Answer::parse(&right, Observes::ALL).ok().and_then(|answer| answer.cycles) {
            Some(cycles) => {
                let late = cycles + cycles * self.thousandths / 1000;
                let right = String::from_utf8_lossy(&right);
                let rest = right.trim_start_matches(&format!("c {cycles:x}"));
                answer.extend_from_slice(format!("c {late:x}{rest}").as_bytes());
            }
            None => answer.extend_from_slice(&right),
        }
        Ok(())
    }
}

fn slower(thousandths: u64, tolerance: u32) -> ConformanceReport {
    let dut = InProcess::new(Box::new(move |kind, config| {
        let model = kind.oracle(Oracle::Model, config)?;
        Ok::<Box<dyn Implementation>, Error>(Box::new(Slower { model, thousandths }))
    }));
    let options = Options { quick: true, requests: 2400, tolerance, ..Options::default() };
    let planned = default_suite(&Chip, &options).expect("suites");
    run("slower", &dut, &Chip, &planned, &options, &|_| ()).expect("it runs")
}

#[test]
fn timing_is_right_within_the_stated_tolerance() {
    let report = slower(20, 20);
    assert_eq!((report.verdict, report.highest), (ConformanceVerdict::Conforms, Some(Level::Timing)));
    assert_eq!(report.tolerance, 20);
    for (thousandths, tolerance) in [(20, 0), (20, 10)] {
        let report = slower(thousandths, tolerance);
        assert_eq!(report.verdict, ConformanceVerdict::DoesNotConform);
        let failure = &report.failures[0];
        assert_eq!(failure.level, Level::Timing);
        // What runs the shortest again has the tolerance in it.
        let config = failure.minimal[1].contains("tolerance=10");
        assert_eq!(config, tolerance == 10, "{}", failure.text());
        assert!(failure.minimal_requests <= 3, "{}", failure.text());
    }
}

/// On each chip of a recorded frame what is there saves time, and a small memory has to load lines again.
#[test]
fn recorded_frame_has_long_packets_and_evicts() {
    let sessions = Chip.recorded(usize::MAX);
    // Its name stands for all of them.
    let extent = Extent { seed: 0, requests: 0 };
    assert_eq!(sessions_named("chip/frame/pquake3-nt-150", &extent).expect("a frame").1, sessions);
    let [large, small, none] = &sessions[..] else { panic!("{} sessions", sessions.len()) };
    for session in &sessions {
        Chip.check(session).expect("legal");
        let packets: Vec<_> =
            session.requests().map(|line| Request::parse(line).expect("legal").operations().len()).collect();
        assert!(packets.iter().filter(|count| **count >= 300).count() >= 10, "{packets:?}");
        let answers = runs(session, Oracle::Model);
        assert!(answers.len() == 2 && answers[1].cycles < answers[0].cycles, "{answers:?}");
        assert_eq!(answers, runs(session, Oracle::Naive));
    }
    let loaded = |session| runs(session, Oracle::Model).iter().map(|answer| answer.pci).collect::<Vec<_>>();
    let [large, small] = [loaded(large), loaded(small)];
    assert!(small.iter().zip(&large).all(|(small, large)| small > large), "{small:?}, {large:?}");
    assert_eq!(loaded(none), [Some(0), Some(0)]);
    let lengths: Vec<usize> = sessions.iter().map(Session::len).collect();
    for (cut, length) in Chip.recorded(7).iter().zip(lengths) {
        let longest =
            cut.requests().map(|line| Request::parse(line).expect("legal").operations().len()).max();
        assert!(longest == Some(7) && cut.len() < length && runs(cut, Oracle::Model).len() == 2);
    }
}
