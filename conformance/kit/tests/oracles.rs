//! The oracles conform at their highest level, and the sessions reach all that they are to reach.

use saarcor_kit::KINDS;
use saarcor_kit::dut::InProcess;
use saarcor_kit::kind::Oracle;
use saarcor_kit::level::Level;
use saarcor_kit::report::{AtLevel, LevelVerdict, Report, Verdict};
use saarcor_kit::run::{Options, Planned, default_suite, random_sessions, run};

fn conforms(oracle: Oracle, options: &Options, planned: Option<Vec<Planned>>) -> Vec<Report> {
    let dut = InProcess::oracle(oracle);
    let reports = KINDS.iter().map(|kind| {
        let planned = planned.clone().unwrap_or_else(|| default_suite(*kind, options).expect("suites"));
        let report = run("oracle", &dut, *kind, &planned, options, &|_| ()).expect("it runs");
        let failures: Vec<_> = report.failures.iter().map(|failure| failure.text()).collect();
        assert_eq!(report.verdict, Verdict::Conforms, "{}", failures.join("\n"));
        // The naive reference does not observe which addresses a ray reads.
        let observed = |row: &&LevelVerdict| row.verdict != AtLevel::NotObserved;
        let highest = report.levels.iter().rfind(observed).map(|row| row.level);
        assert_eq!(report.highest, highest);
        assert!(oracle == Oracle::Naive || highest == kind.levels().last().copied());
        report
    });
    reports.collect()
}

#[test]
fn model_conforms_and_the_default_suite_covers_the_small_geometry() {
    let options = Options { requests: 1_000_000, ..Options::default() };
    for report in conforms(Oracle::Model, &options, None) {
        assert!(report.coverage.iter().all(|row| row.reached == row.all), "{:?}", report.coverage);
    }
}

#[test]
fn naive_reference_conforms() {
    conforms(Oracle::Naive, &Options { requests: 100_000, ..Options::default() }, None);
}

/// No false alarm, whatever the seed.
#[test]
fn naive_reference_passes_200_seeds() {
    let planned = (0..200).map(|seed| Planned::Random { seed: 1000 + seed, requests: 1000 }).collect();
    conforms(Oracle::Naive, &Options::default(), Some(planned));
}

#[test]
fn report_does_not_depend_on_the_threads() {
    let options = Options { requests: 50_000, ..Options::default() };
    let report = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut reports = pool.install(|| conforms(Oracle::Naive, &options, None));
        reports.iter_mut().for_each(|report| report.random_seconds = 0.0);
        reports
    };
    assert_eq!(report(1), report(3));
}

#[test]
fn random_part_has_the_requests_asked_for() {
    for requests in [0, 1, 24, 100, 50_000, 2_000_000] {
        let sessions = random_sessions(0, requests).map(|planned| match planned {
            Planned::Random { requests, .. } => requests,
            Planned::Directed(_) => 0,
        });
        let all: usize = sessions.sum();
        assert!((requests..requests + 100).contains(&all), "{requests}: {all}");
    }
    assert!(Level::Data < Level::State);
}
