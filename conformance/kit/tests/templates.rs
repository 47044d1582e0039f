//! The templates conform at every level of their kind.
#![cfg(unix)]

use saarcor_kit::chip::Chip;
use saarcor_kit::dut::{Dut, InProcess};
use saarcor_kit::hash::SetHash;
use saarcor_kit::kd::Kd;
use saarcor_kit::kind::Kind;
use saarcor_kit::level::Level;
use saarcor_kit::meta::Meta;
use saarcor_kit::plan::{Options, PlannedSession, default_suite};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict};
use saarcor_kit::run::run;
use saarcor_kit::target::{Target, TargetOptions};
use saarcor_kit::vm::Vm;
use saarcor_kit::vm::cache::CacheAdapter;

#[path = "../../duts/rust/src/lib.rs"]
mod my_cache;

/// The template's folder, copied and built, so that nothing is made in the sources.
fn template(name: &str) -> (tempfile::TempDir, Target) {
    let folder = tempfile::tempdir().expect("a folder");
    let from = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../duts").join(name);
    for file in std::fs::read_dir(from).expect("a template") {
        let file = file.expect("a file");
        if file.path().is_file() {
            std::fs::copy(file.path(), folder.path().join(file.file_name())).expect("copied");
        }
    }
    let target =
        Target::open(folder.path().to_str().expect("text"), &TargetOptions::default()).expect("a template");
    assert!(target.missing.is_empty(), "{name} needs {:?}", target.missing);
    target.build().expect("it builds");
    (folder, target)
}

#[track_caller]
fn conforms(dut: &dyn Dut, planned: &[PlannedSession]) -> ConformanceReport {
    conforms_to(&Vm, dut, planned)
}

#[track_caller]
fn conforms_to(kind: &dyn Kind, dut: &dyn Dut, planned: &[PlannedSession]) -> ConformanceReport {
    let report = run("template", dut, kind, planned, &Options::default(), &|_| ()).expect("it runs");
    let failures: Vec<_> = report.failures.iter().map(|failure| failure.text()).collect();
    assert_eq!(report.verdict, ConformanceVerdict::Conforms, "{}", failures.join("\n"));
    report
}

fn suite(requests: usize) -> Vec<PlannedSession> {
    default_suite(&Vm, &Options { quick: true, requests, ..Options::default() }).expect("suites")
}

fn seeds(count: u64, requests: usize) -> Vec<PlannedSession> {
    (0..count).map(|seed| PlannedSession::Random { seed: 5000 + seed, requests }).collect()
}

#[test]
fn c_conforms_whatever_the_seed() {
    let (_folder, target) = template("c");
    conforms(&*target.dut, &suite(400_000));
    conforms(&*target.dut, &seeds(200, 1000));
}

#[test]
fn rust_conforms_whatever_the_seed() {
    let dut = InProcess::new(Box::new(|_, config| Ok(Box::new(CacheAdapter::new(config, &my_cache::make)?))));
    conforms(&dut, &suite(100_000));
    conforms(&dut, &seeds(200, 1000));
}

#[test]
fn hash_conforms() {
    let (_folder, target) = template("hash");
    let planned = default_suite(&SetHash, &Options { quick: true, requests: 24_000, ..Options::default() })
        .expect("suites");
    let planned: Vec<_> = planned.into_iter().step_by(3).collect();
    conforms_to(&SetHash, &*target.dut, &planned);
}

#[test]
fn kd_c_conforms_whatever_the_seed() {
    let (_folder, target) = template("kd-c");
    let planned =
        default_suite(&Kd, &Options { quick: true, requests: 48_000, ..Options::default() }).expect("suites");
    let report = conforms_to(&Kd, &*target.dut, &planned);
    assert_eq!(report.highest, Some(Level::Traversal));
    assert_eq!(report.unsupported.iter().map(|row| row.key.as_str()).collect::<Vec<_>>(), ["kernel"]);
    conforms_to(&Kd, &*target.dut, &seeds(200, 200));
}

/// One session in ten: starting Python takes most of the time.
#[test]
fn kd_python_conforms_in_some_sessions() {
    let (_folder, target) = template("kd-python");
    let planned =
        default_suite(&Kd, &Options { quick: true, requests: 12_000, ..Options::default() }).expect("suites");
    let planned: Vec<_> = planned.into_iter().step_by(10).collect();
    assert_eq!(conforms_to(&Kd, &*target.dut, &planned).highest, Some(Level::Traversal));
}

#[test]
#[ignore = "starts Python 250 times"]
fn kd_python_conforms_whatever_the_seed() {
    let (_folder, target) = template("kd-python");
    let planned =
        default_suite(&Kd, &Options { quick: true, requests: 12_000, ..Options::default() }).expect("suites");
    conforms_to(&Kd, &*target.dut, &planned);
    conforms_to(&Kd, &*target.dut, &seeds(200, 200));
}

#[test]
fn meta_conforms_in_some_sessions() {
    let (_folder, target) = template("meta");
    let options = Options { quick: true, requests: 24_000, ..Options::default() };
    let planned: Vec<_> = default_suite(&Meta, &options).expect("suites").into_iter().step_by(3).collect();
    let report = conforms_to(&Meta, &*target.dut, &planned);
    assert_eq!(report.highest, Some(Level::Metadata));
}

/// One session in ten: starting Python takes most of the time.
#[test]
fn chip_python_conforms_in_some_sessions() {
    let (_folder, target) = template("chip-python");
    let planned =
        default_suite(&Chip, &Options { quick: true, requests: 1200, ..Options::default() }).expect("suites");
    let planned: Vec<_> = planned.into_iter().step_by(10).collect();
    assert_eq!(conforms_to(&Chip, &*target.dut, &planned).highest, Some(Level::Timing));
}

#[test]
#[ignore = "starts Python 350 times"]
fn chip_python_conforms_whatever_the_seed() {
    let (_folder, target) = template("chip-python");
    let planned =
        default_suite(&Chip, &Options { quick: true, requests: 2400, ..Options::default() }).expect("suites");
    let report = conforms_to(&Chip, &*target.dut, &planned);
    assert!(report.unsupported.is_empty(), "{:?}", report.unsupported);
    conforms_to(&Chip, &*target.dut, &seeds(200, 60));
}

/// One session in ten: starting Python takes most of the time.
#[test]
fn python_conforms_in_some_sessions() {
    let (_folder, target) = template("python");
    let planned: Vec<_> = suite(24_000).into_iter().step_by(10).collect();
    conforms(&*target.dut, &planned);
}

#[track_caller]
fn verilog_conforms(name: &str) {
    let (_folder, target) = template(name);
    let report = conforms(&*target.dut, &suite(24_000));
    assert_eq!(report.highest, Some(Level::State));
    assert_eq!(
        report.unsupported.iter().map(|row| row.key.as_str()).collect::<Vec<_>>(),
        ["lines", "policy"]
    );
    conforms(&*target.dut, &seeds(200, 100));
}

#[test]
#[ignore = "needs Icarus Verilog, and takes a minute"]
fn verilog_conforms_whatever_the_seed() {
    verilog_conforms("verilog");
}

#[test]
#[ignore = "needs Icarus Verilog, and takes a minute"]
fn verilog_pipelined_conforms_whatever_the_seed() {
    verilog_conforms("verilog-pipelined");
}

#[test]
#[ignore = "starts Python 600 times"]
fn hash_and_meta_conform_whatever_the_seed() {
    for (name, kind) in [("hash", &SetHash as &dyn Kind), ("meta", &Meta)] {
        let (_folder, target) = template(name);
        let options = Options { quick: true, requests: 48_000, ..Options::default() };
        conforms_to(kind, &*target.dut, &default_suite(kind, &options).expect("suites"));
        conforms_to(kind, &*target.dut, &seeds(200, 500));
    }
}

#[test]
#[ignore = "starts Python 400 times"]
fn python_conforms_whatever_the_seed() {
    let (_folder, target) = template("python");
    conforms(&*target.dut, &suite(24_000));
    conforms(&*target.dut, &seeds(200, 500));
}

#[track_caller]
fn can_be_synthesized(script: &str) {
    let output = std::process::Command::new("yosys")
        .args(["-q", "-p", script])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../duts"))
        .output()
        .expect("Yosys is there");
    let said = String::from_utf8_lossy(&output.stderr);
    let is_clean = !said.contains("latch") && !said.contains("Warning");
    assert!(output.status.success() && is_clean, "{script}: {said}");
}

#[test]
#[ignore = "needs Yosys"]
fn verilog_can_be_synthesized() {
    can_be_synthesized("read_verilog verilog/cache.v; synth -top cache; check -assert");
}

/// With either policy, and with one way and one set, where no vector may be empty.
#[test]
#[ignore = "needs Yosys"]
fn verilog_pipelined_can_be_synthesized() {
    for sizes in
        ["-set POLICY 0", "-set POLICY 1", "-set POLICY 0 -set WAY_BITS 0", "-set SET_BITS 0 -set WAY_BITS 3"]
    {
        can_be_synthesized(&format!(
            "read_verilog -sv verilog-pipelined/cache.v verilog-pipelined/order.v; \
             chparam {sizes} pipelined_cache; synth -top pipelined_cache; check -assert"
        ));
    }
}
