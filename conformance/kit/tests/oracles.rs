//! The oracles conform at their highest level, and the sessions reach all that they are to reach.

use saarcor_kit::chip::Chip;
use saarcor_kit::dut::InProcess;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::kinds::KINDS;
use saarcor_kit::level::Level;
use saarcor_kit::plan::{Options, PlannedSession, default_suite, random_sessions};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict, LevelResult, LevelVerdict};
use saarcor_kit::run::run;

/// The chip has one request where other kinds have so many: its requests are packets, which the specification
/// plays cycle by cycle.
const CHIP_PART: usize = 20;

fn requests_of(kind: &dyn Kind, requests: usize) -> usize {
    if kind.name() == Chip.name() { requests.div_ceil(CHIP_PART) } else { requests }
}

fn conforms(oracle: Oracle, options: &Options, seeds: Option<(u64, usize)>) -> Vec<ConformanceReport> {
    let dut = InProcess::oracle(oracle);
    let reports = KINDS.iter().map(|kind| {
        let planned = match seeds {
            Some((seeds, requests)) => {
                let requests = requests_of(*kind, requests);
                (0..seeds).map(|seed| PlannedSession::Random { seed: 1000 + seed, requests }).collect()
            }
            None => {
                let options = Options { requests: requests_of(*kind, options.requests), ..options.clone() };
                default_suite(*kind, &options).expect("suites")
            }
        };
        let report = run("oracle", &dut, *kind, &planned, options, &|_| ()).expect("it runs");
        let failures: Vec<_> = report.failures.iter().map(|failure| failure.text()).collect();
        assert_eq!(report.verdict, ConformanceVerdict::Conforms, "{}", failures.join("\n"));
        // The naive reference does not observe which addresses a ray reads.
        let observed = |row: &&LevelResult| row.verdict != LevelVerdict::NotObserved;
        let highest = report.levels.iter().rfind(observed).map(|row| row.level);
        assert_eq!(report.highest, highest);
        assert!(oracle == Oracle::Naive || highest == kind.levels().last().copied());
        report
    });
    reports.collect()
}

#[test]
fn model_conforms_and_the_default_suite_covers_the_small_geometry() {
    let options = Options { quick: true, requests: 1_000_000, ..Options::default() };
    for report in conforms(Oracle::Model, &options, None) {
        assert!(report.coverage.iter().all(|row| row.reached == row.all), "{:?}", report.coverage);
    }
}

#[test]
fn naive_reference_conforms() {
    conforms(Oracle::Naive, &Options { quick: true, requests: 100_000, ..Options::default() }, None);
}

/// No false alarm, whatever the seed.
#[test]
fn naive_reference_passes_200_seeds() {
    conforms(Oracle::Naive, &Options::default(), Some((200, 1000)));
}

#[test]
fn report_does_not_depend_on_the_threads() {
    let options = Options { quick: true, requests: 50_000, ..Options::default() };
    let report = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut reports = pool.install(|| conforms(Oracle::Naive, &options, None));
        for report in &mut reports {
            // Times differ.
            report.random_seconds = 0.0;
            report.outcomes.iter_mut().for_each(|outcome| outcome.seconds = 0.0);
        }
        reports
    };
    assert_eq!(report(1), report(3));
}

#[test]
fn random_part_has_the_requests_asked_for() {
    for requests in [0, 1, 24, 100, 50_000, 2_000_000] {
        let sessions = random_sessions(0, requests, 24).map(|planned| match planned {
            PlannedSession::Random { requests, .. } => requests,
            PlannedSession::Directed(_) | PlannedSession::Sized(_) => 0,
        });
        let all: usize = sessions.sum();
        assert!((requests..requests + 100).contains(&all), "{requests}: {all}");
    }
    assert!(Level::Data < Level::State);
}
