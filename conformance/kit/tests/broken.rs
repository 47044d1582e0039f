//! Every faulty implementation is rejected, for the requirement that its fault breaks, with requests
//! that are short.
#![cfg(unix)]

use rayon::prelude::*;
use saarcor_kit::chip::Chip;
use saarcor_kit::deadline::Deadline;
use saarcor_kit::dut::Dut;
use saarcor_kit::hash::SetHash;
use saarcor_kit::kd::Kd;
use saarcor_kit::kind::Kind;
use saarcor_kit::level::Level;
use saarcor_kit::meta::Meta;
use saarcor_kit::plan::{Options, PlannedSession, RANDOM_REQUESTS, default_suite};
use saarcor_kit::report::{ConformanceVerdict, Failure};
use saarcor_kit::run::run;
use saarcor_kit::scoreboard::Scoreboard;
use saarcor_kit::session::Session;
use saarcor_kit::sizes::Extent;
use saarcor_kit::target::{Target, TargetOptions};
use saarcor_kit::templates::{Fault, TEMPLATES, faults};
use saarcor_kit::vm::{Vm, config};
use saarcor_model::vm::CacheConfig;
use std::collections::BTreeSet;

/// A template with a fault in it, built, and the folder that it lies in.
fn planted(fault: &Fault) -> (tempfile::TempDir, Target) {
    let folder = tempfile::tempdir().expect("a folder");
    let template = TEMPLATES.iter().find(|template| template.name == fault.template).expect("a template");
    for (name, text) in template.with_fault(fault).expect("its line") {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    // None of these faults hangs, and a machine that has much else to do ends no session by its time limit.
    let options = TargetOptions { time_limit: Some(600.0), ..TargetOptions::default() };
    let target = Target::open(folder.path().to_str().expect("text"), &options).expect("a folder");
    assert!(target.missing.is_empty(), "needs {:?}", target.missing);
    target.build().expect("it compiles");
    (folder, target)
}

/// The first failure of the default suite.
fn first_failure(fault: &Fault, dut: &dyn Dut, kind: &dyn Kind) -> Option<Failure> {
    let options = Options { quick: true, requests: 24_000, errors: 1, ..Options::default() };
    let planned = default_suite(kind, &options).expect("suites");
    let report = run(&fault.name, dut, kind, &planned, &options, &|_| ()).expect("it runs");
    assert_eq!(report.verdict == ConformanceVerdict::DoesNotConform, !report.failures.is_empty());
    report.failures.into_iter().next()
}

/// Requests that exhaustive search combines: each line of twice the memory, and what invalidates them.
/// For sets alone, the first lines; for the chip, the packets that fail, and such of one operation.
fn alphabet(failure: &Session) -> Vec<String> {
    let config = failure.config();
    if failure.hello() == Chip.hello() {
        let own = failure.requests().map(|line| String::from_utf8_lossy(line).into_owned());
        let others = ["run", "flush", "p", "p s,0,0,1", "p n,0,8,1", "b n,0,8,1"].map(str::to_owned);
        return own.chain(others).collect::<BTreeSet<_>>().into_iter().collect();
    }
    if let Ok(meta) = saarcor_kit::meta::config::parse(config) {
        let geometry = meta.cache.geometry;
        let lines = 0..2 * geometry.lines().min(4);
        let mut requests: Vec<_> = lines.map(|n| format!("r {:x}", n * geometry.line().0)).collect();
        requests.extend(["i 0 1".into(), "flush".into()]);
        requests.extend(meta.faults.then(|| "x 0 1".into()));
        return requests;
    }
    let Ok(CacheConfig { geometry, .. }) = config::parse(config) else {
        return (0..16).map(|line| format!("s {line:x}")).collect();
    };
    let (line, lines) = (geometry.line().0, geometry.lines());
    let mut requests: Vec<_> = (0..2 * lines.min(4)).map(|n| format!("r {:x} 1", n * line)).collect();
    requests.extend([format!("r {:x} 1", line - 1), "w 0 01".into(), "i 0 1".into(), "flush".into()]);
    requests
}

/// Sessions that are tried of a length: of longer ones there are too many.
const MOST_TRIED: usize = 2500;

/// Whether any session of `length` requests fails, as far as that can be tried.
fn some_fail(dut: &dyn Dut, kind: &dyn Kind, failure: &Session, length: usize) -> bool {
    let alphabet = alphabet(failure);
    if alphabet.len().pow(length as u32) > MOST_TRIED {
        return false;
    }
    let requests_of = |mut number: usize| -> Vec<&[u8]> {
        let digits = (0..length).map(|_| {
            let request = alphabet[number % alphabet.len()].as_bytes();
            number /= alphabet.len();
            request
        });
        digits.collect()
    };
    let numbers = 0..alphabet.len().pow(length as u32);
    let tried: Vec<_> = numbers.map(requests_of).collect();
    let is_legal =
        |requests: &&Vec<&[u8]>| kind.check(&failure.with_requests(requests.iter().copied())).is_ok();
    let tried: Vec<_> = tried.iter().filter(is_legal).collect();
    let first_wrong = |session: &Session| {
        let mut scoreboard = Scoreboard::new(kind, session, Level::HIGHEST);
        dut.converse(session, &mut scoreboard, &Deadline::never()).expect("it runs");
        scoreboard.findings().first().map(|finding| finding.request)
    };
    let fails = |requests: &[&[u8]]| first_wrong(&failure.with_requests(requests.iter().copied())).is_some();
    // Starting a program takes most of the time. So all are first requested in one conversation, each
    // behind a flush, which begins anew; sets have nothing to begin anew with.
    let between: &[&[u8]] = if kind.name() == SetHash.name() { &[] } else { &[b"flush"] };
    let all = tried.iter().flat_map(|requests| between.iter().chain(requests.iter()).copied());
    let Some(wrong) = first_wrong(&failure.with_requests(all)) else { return false };
    let suspect = wrong.and_then(|request| tried.get(request / (between.len() + length)));
    suspect.is_some_and(|requests| fails(requests)) || tried.iter().any(|requests| fails(requests))
}

/// The templates that are programs of Python: starting it takes most of the time.
const IN_PYTHON: [&str; 5] = ["python", "hash", "meta", "kd-python", "chip-python"];

/// The templates that need a simulator of Verilog.
const IN_VERILOG: [&str; 2] = ["verilog", "verilog-pipelined"];

/// Sessions about sizes, by name; and random ones with the hash and sets that it takes.
fn session_named(kind: &dyn Kind, name: &str, requests: usize) -> PlannedSession {
    let seed = name.split_once("/random/").and_then(|(_, seed)| seed.parse().ok());
    if let Some(seed) = seed {
        return PlannedSession::Random { seed, requests: 2000 };
    }
    let sized = kind.sizes(&Extent { seed: 0, requests });
    PlannedSession::Sized(sized.into_iter().find(|sized| sized.name == name).expect(name))
}

/// Which faults that need a session about sizes are judged, by template and session.
fn all_are_found_by_their_sessions(whole: bool, among: impl Fn(&Fault, bool) -> bool + Sync) {
    let wrong: Vec<String> = faults()
        .expect("a list")
        .par_iter()
        .filter_map(|fault| {
            let name = fault.session.as_ref()?;
            let kind = kind_of_template(&fault.template);
            let planned = session_named(kind, name, RANDOM_REQUESTS);
            let is_large = matches!(&planned, PlannedSession::Sized(sized) if sized.is_large);
            if !among(fault, is_large) {
                return None;
            }
            let (_folder, target) = planted(fault);
            let requests = target.requests.unwrap_or(RANDOM_REQUESTS);
            let options = Options { requests, errors: 1, shrink: false, ..Options::default() };
            let planned = match whole {
                true => default_suite(kind, &options).expect("suites"),
                false => vec![session_named(kind, name, requests)],
            };
            let report = run(&fault.name, &*target.dut, kind, &planned, &options, &|_| ()).expect("it runs");
            let Some(failure) = report.failures.first() else {
                return Some(format!("{}: conforms", fault.name));
            };
            println!("{:>2} requests: {} by {}", failure.minimal_requests, fault.name, failure.session);
            let is_right = whole
                || (&failure.requirement, failure.level.name()) == (&fault.requirement, fault.level.as_str());
            (!is_right).then(|| format!("{}: {} at level {}", fault.name, failure.requirement, failure.level))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn kind_of_template(template: &str) -> &'static dyn Kind {
    match template {
        "hash" => &SetHash,
        "meta" => &Meta,
        "kd-c" | "kd-python" => &Kd,
        "chip-python" => &Chip,
        _ => &Vm,
    }
}

#[test]
fn faults_of_sizes_are_found_for_their_requirements_by_their_sessions() {
    all_are_found_by_their_sessions(false, |fault, is_large| {
        !is_large && !IN_PYTHON.contains(&&*fault.template) && !IN_VERILOG.contains(&&*fault.template)
    });
}

#[test]
#[ignore = "large memories, long sessions, and Python"]
fn faults_of_large_sizes_are_found_for_their_requirements_by_their_sessions() {
    all_are_found_by_their_sessions(false, |fault, is_large| {
        (is_large || IN_PYTHON.contains(&&*fault.template)) && !IN_VERILOG.contains(&&*fault.template)
    });
}

#[test]
#[ignore = "needs Icarus Verilog"]
fn verilog_faults_of_sizes_are_found_for_their_requirements_by_their_sessions() {
    all_are_found_by_their_sessions(false, |fault, _| IN_VERILOG.contains(&&*fault.template));
}

#[test]
#[ignore = "holds the whole default suite with each of some seventy faults"]
fn faults_of_sizes_are_found_by_the_default_suite() {
    all_are_found_by_their_sessions(true, |_, _| true);
}

#[test]
fn every_fault_is_found_for_its_requirement_by_few_requests() {
    all_are_found(|fault| {
        !IN_PYTHON.contains(&fault.template.as_str()) && !IN_VERILOG.contains(&fault.template.as_str())
    });
}

#[test]
#[ignore = "starts Python thousands of times"]
fn every_fault_in_python_is_found_for_its_requirement_by_few_requests() {
    all_are_found(|fault| IN_PYTHON.contains(&fault.template.as_str()));
}

#[test]
#[ignore = "needs Icarus Verilog"]
fn verilog_faults_are_found_for_their_requirements_by_few_requests() {
    all_are_found(|fault| IN_VERILOG.contains(&fault.template.as_str()));
}

fn all_are_found(among: impl Fn(&Fault) -> bool + Sync) {
    let wrong: Vec<String> = faults()
        .expect("a list")
        .par_iter()
        .filter(|fault| fault.session.is_none() && among(fault))
        .filter_map(|fault| {
            let (_folder, target) = planted(fault);
            let kind = target.kind.expect("dut.toml names it");
            let Some(failure) = first_failure(fault, &*target.dut, kind) else {
                return Some(format!("{}: conforms", fault.name));
            };
            println!("{:>2} requests: {}", failure.minimal_requests, fault.name);
            let Failure { requirement, level, .. } = &failure;
            if (requirement, level.name()) != (&fault.requirement, fault.level.as_str()) {
                return Some(format!("{}: {requirement} at level {level}\n{}", fault.name, failure.text()));
            }
            // A ray has a scene: at least a box, a node, a list and a triangle.
            if kind.name() == Kd.name() {
                let long = failure.minimal_requests > 3 * 5 && level.name() != "protocol";
                return long.then(|| format!("{}: long\n{}", fault.name, failure.text()));
            }
            // At most three times as many as the shortest: none of a third fails.
            let session = failure.suite.clone();
            let third = failure.minimal_requests.saturating_sub(1) / 3;
            let shorter =
                (0..=third).find(|&length| third > 0 && some_fail(&*target.dut, kind, &session, length));
            shorter.map(|length| format!("{}: {length} requests are enough\n{}", fault.name, failure.text()))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
