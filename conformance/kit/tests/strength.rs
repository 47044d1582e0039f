//! A verdict is as strong as what was judged, and says what was not.

use saarcor_kit::chip::Chip;
use saarcor_kit::dut::InProcess;
use saarcor_kit::error::Error;
use saarcor_kit::implementation::Implementation;
use saarcor_kit::kd::Kd;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::level::Level;
use saarcor_kit::meta::Meta;
use saarcor_kit::plan::{Options, PlannedSession, default_suite};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict, LevelVerdict};
use saarcor_kit::run::run;
use saarcor_kit::scoreboard::check_answers;
use saarcor_kit::server::serve;
use saarcor_kit::session::Session;
use saarcor_kit::vm::Vm;

/// The model, which says that it observes less.
struct Blinder {
    model: Box<dyn Implementation>,
    observes: &'static str,
}

impl Implementation for Blinder {
    fn observes(&self) -> String {
        self.observes.to_owned()
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        self.model.answer(request, answer)
    }
}

/// The model that observes what `observes` says of a configuration; none is supported where that is a key.
fn blinder(observes: fn(&str) -> Result<&'static str, &'static str>) -> InProcess {
    InProcess::new(Box::new(move |kind, config| {
        let observes = observes(config).map_err(|key| Error::Unsupported(key.to_owned()))?;
        let model = kind.oracle(Oracle::Model, config)?;
        Ok::<Box<dyn Implementation>, Error>(Box::new(Blinder { model, observes }))
    }))
}

fn report(
    kind: &dyn Kind,
    level: Option<Level>,
    observes: fn(&str) -> Result<&'static str, &'static str>,
) -> ConformanceReport {
    let options = Options { quick: true, requests: 240, level, ..Options::default() };
    let planned = default_suite(kind, &options).expect("suites");
    run("one", &blinder(observes), kind, &planned, &options, &|_| ()).expect("it runs")
}

#[test]
fn a_level_is_passed_where_it_is_observed_in_every_configuration() {
    let report = report(&Vm, None, |config| {
        Ok(if config.contains("policy=lru") { "data,hit,card,evict" } else { "data" })
    });
    assert_eq!((report.verdict, report.highest), (ConformanceVerdict::Conforms, Some(Level::Data)));
    assert_eq!(
        report.headline(),
        "one (saarcor-vm): conforms; agrees up to level data; not judged: traffic, state with policy=fifo, policy=plru"
    );
    let verdicts: Vec<_> = report.levels.iter().map(|level| level.verdict).collect();
    let (passed, in_part) = (LevelVerdict::Passed, LevelVerdict::ObservedInPart);
    assert_eq!(verdicts, [passed, passed, in_part, in_part]);
}

#[test]
fn a_level_is_passed_where_each_below_it_is_observed() {
    for (kind, observes, level, says) in [
        (&Vm as &dyn Kind, "hit", Level::Protocol, "; not judged: data, traffic, state"),
        (&Vm, "data,card", Level::Data, "; not judged: traffic, state"),
        (&Chip, "cycles", Level::Protocol, "; not judged: traffic, timing"),
        (&Chip, "pci,mem,cycles", Level::Timing, "; not judged: l1, l2"),
        (&Chip, "l1,l2", Level::Protocol, "; not judged: traffic, timing"),
        (&Meta, "hit,meta", Level::Traffic, "; not judged: state, metadata"),
        (&Meta, "hit,card,meta", Level::Metadata, "; not judged: evict, bytes"),
        (&Kd, "touched", Level::Protocol, "; not judged: rays, traversal"),
        (&Kd, "t,touched", Level::Protocol, "; not judged: rays, traversal"),
        (&Kd, "triangle,t", Level::Rays, "; not judged: traversal, uv"),
    ] {
        // A closure of its own for each, as observes stands in no configuration.
        let options = Options { quick: true, requests: 24, ..Options::default() };
        let planned = default_suite(kind, &options).expect("suites");
        let dut = InProcess::new(Box::new(move |kind, config| {
            let model = kind.oracle(Oracle::Model, config)?;
            Ok::<Box<dyn Implementation>, Error>(Box::new(Blinder { model, observes }))
        }));
        let report = run("one", &dut, kind, &planned, &options, &|_| ()).expect("it runs");
        let verdict = if level == Level::Protocol {
            ConformanceVerdict::Incomplete
        } else {
            ConformanceVerdict::Conforms
        };
        assert_eq!((report.verdict, report.highest), (verdict, Some(level)), "{observes}");
        assert!(report.headline().ends_with(&format!("up to level {level}{says}")), "{}", report.headline());
    }
}

#[test]
fn configurations_that_are_not_supported_are_named() {
    let observes: fn(&str) -> Result<&'static str, &'static str> =
        |config| if config.contains("policy=plru") { Err("policy") } else { Ok("data,hit,card,evict") };
    let all = report(&Vm, None, observes);
    let not_judged = &all.not_judged[0];
    assert_eq!((all.verdict, all.highest), (ConformanceVerdict::Conforms, Some(Level::State)));
    assert_eq!(
        (not_judged.what.as_str(), &not_judged.values[..]),
        ("policy", &["policy=plru".to_owned()][..])
    );
    let places = format!(
        "not judged: policy=plru (not supported; {} of {} sessions)",
        not_judged.sessions, all.sessions
    );
    assert!(all.headline().ends_with(&places), "{}", all.headline());
    // What the run was not to judge is not missed.
    let data = report(&Vm, Some(Level::Data), |_| Ok("data"));
    assert_eq!((data.verdict, data.not_judged), (ConformanceVerdict::Conforms, vec![]));
    let state = report(&Vm, Some(Level::State), |_| Ok("data"));
    assert_eq!(state.verdict, ConformanceVerdict::Incomplete);
}

/// A session that is about the conversation, or in which nothing is requested, shows nothing more.
#[test]
fn a_run_shows_what_its_sessions_are_about() {
    let held = |text: &str| {
        let session = Session::parse("vm/x", text).expect("a suite").remove(0);
        let planned = [PlannedSession::Directed(Box::new(session))];
        let dut = InProcess::oracle(Oracle::Model);
        run("model", &dut, &Vm, &planned, &Options::default(), &|_| ()).expect("it runs")
    };
    let config = "saarcor-vm 1\nconfig line=16 lines=2 ways=2 hash=low policy=lru\n";
    let protocol = held(&format!("#: P-1 protocol Hello.\n{config}end\n"));
    assert_eq!((protocol.verdict, protocol.highest), (ConformanceVerdict::Conforms, Some(Level::Protocol)));
    let nothing = held(&format!("{config}end\n"));
    assert_eq!((nothing.verdict, nothing.highest), (ConformanceVerdict::Incomplete, Some(Level::Protocol)));
    assert!(nothing.headline().ends_with("; not judged: data, traffic, state"), "{}", nothing.headline());
    let something = held(&format!("{config}r 0 1\nend\n"));
    assert_eq!((something.verdict, something.highest), (ConformanceVerdict::Conforms, Some(Level::State)));
}

#[test]
fn answers_that_are_checked_agree_up_to_what_was_observed() {
    let session = Vm.random(17, 100);
    let make = |kind: &dyn Kind, config: &str| {
        let model = kind.oracle(Oracle::Model, config)?;
        Ok::<Box<dyn Implementation>, Error>(Box::new(Blinder { model, observes: "hit" }))
    };
    let mut answers = Vec::new();
    serve(&make, &*session.text(), &mut answers).expect("memory can be written");
    let checked = check_answers(&Vm, &session, &answers, Level::HIGHEST);
    assert_eq!(checked.highest, Some(Level::Protocol));
    assert_eq!(checked.not_judged, [Level::Data, Level::Traffic, Level::State]);
}

/// Exact answers differ from the model's within the bound, and the report says why they are right; the model's own
/// differ nowhere.
#[test]
fn answers_that_are_right_though_not_the_models_are_explained() {
    let options = Options::default();
    let planned: Vec<_> = (0..3).map(|seed| PlannedSession::Random { seed, requests: 5000 }).collect();
    let report = |oracle| {
        let dut = InProcess::oracle(oracle);
        run("oracle", &dut, &Kd, &planned, &options, &|_| ()).expect("it runs")
    };
    assert_eq!(report(Oracle::Model).admitted, []);
    let exact = report(Oracle::Naive);
    assert_eq!(exact.verdict, ConformanceVerdict::Conforms);
    let within = exact.admitted.iter().find(|row| row.requirement == "IS-3").expect("some are rounded");
    assert!(within.answers > 10 && within.why.contains("the model's") && within.why.ends_with("is right"));
    assert!(within.session.starts_with("kd/random/") && within.asked.starts_with("c "), "{within:?}");
}

/// Where an answer is wrong, the report says which are right, and within which bounds.
#[test]
fn wrong_hits_are_shown_beside_the_right_ones() {
    struct Nothing(Box<dyn Implementation>);

    impl Implementation for Nothing {
        fn observes(&self) -> String {
            "triangle,t".to_owned()
        }

        fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
            self.0.answer(request, answer)?;
            if request.starts_with(b"c ") {
                answer.splice(.., *b"m -");
            }
            Ok(())
        }
    }

    let dut = InProcess::new(Box::new(|kind, config| {
        Ok::<Box<dyn Implementation>, Error>(Box::new(Nothing(kind.oracle(Oracle::Model, config)?)))
    }));
    let planned = [PlannedSession::Random { seed: 0, requests: 1000 }];
    let report = run("nothing", &dut, &Kd, &planned, &Options::default(), &|_| ()).expect("it runs");
    let failure = &report.failures[0];
    let right = failure.state_before.iter().find(|row| row.starts_with("right: the triangle at "));
    assert!(
        right.is_some_and(|row| row.contains("is hit, t = ") && row.contains(" ± ")),
        "{}",
        failure.text()
    );
    assert_eq!(failure.config, "kernel=moller-trumbore");
    assert_eq!(failure.again.as_deref(), Some("--suite kd/random/0 --requests 1000"));
}
