//! The chip in Python, written from SPEC.md alone, counts what the specification counts: on random small
//! chips the whole report is compared, also what the protocol leaves out (what units do in their cycles,
//! CH-18, and how long the bus is taken).
#![cfg(unix)]

use saarcor_kit::chip::{Chip, config, request::Request};
use saarcor_kit::kind::Kind;
use saarcor_kit::session::Session;
use saarcor_model::time::{Programs, TimingReport, simulate};
use std::io::Write;
use std::process::{Command, Stdio};

/// Random sessions that are compared, and requests in each.
const SESSIONS: u64 = 40;
const REQUESTS: usize = 30;

/// What the program answers.
fn python(input: &[u8]) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../duts/chip-python");
    let mut child = Command::new("python3")
        .args(["chip.py", "--work"])
        .current_dir(folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3");
    child.stdin.take().expect("a pipe").write_all(input).expect("it reads");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success());
    String::from_utf8(output.stdout).expect("text")
}

/// The answer that has all of a report.
fn answer(report: &TimingReport) -> String {
    let caches = report.l1.iter().chain([&report.l2]);
    let caches: Vec<_> =
        caches.map(|cache| format!("{:x}/{:x}/{:x}", cache.accesses, cache.merged, cache.misses)).collect();
    let units = report.units.map(|unit| {
        let [look_up, port, register, memory, host] = unit.stalls;
        let counts =
            [unit.busy, look_up, port, register, memory, host, unit.idle, unit.operations, unit.rays];
        counts.map(|count| format!("{count:x}")).join("/")
    });
    format!(
        "c {:x} {:x} {:x},{:x},{:x},{:x} {} {} {} {:x}",
        report.cycles,
        report.pci_bytes,
        report.l1_fill_bytes,
        report.vm_fill_bytes,
        report.metadata_read_bytes,
        report.metadata_write_back_bytes,
        caches[..4].join(","),
        caches[4],
        units.join(","),
        report.pci_busy
    )
}

/// The answers of the specification to the runs of a session.
fn specified(session: &Session, total: &mut TimingReport) -> Vec<String> {
    let setting = config::parse(session.config()).expect("a configuration");
    let mut before = Programs { packets: Vec::new(), triangles: setting.triangles };
    let mut programs = before.clone();
    let mut answers = Vec::new();
    for request in session.requests() {
        match Request::parse(request).expect("a request") {
            Request::Before(operations) => before.packets.push(operations.into()),
            Request::Packet(operations) => programs.packets.push(operations.into()),
            Request::Flush => {
                before.packets.clear();
                programs.packets.clear();
            }
            Request::Run => {
                let before = std::slice::from_ref(&before);
                let report = simulate(before, &programs, &setting.chip).expect("a chip");
                for (sum, unit) in total.units.iter_mut().zip(report.units) {
                    sum.busy += unit.busy;
                    sum.idle += unit.idle;
                    sum.stalls.iter_mut().zip(unit.stalls).for_each(|(sum, one)| *sum += one);
                }
                total.l2.merged += report.l2.merged;
                total.metadata_write_back_bytes += report.metadata_write_back_bytes;
                answers.push(answer(&report));
            }
        }
    }
    answers
}

#[test]
fn python_counts_what_the_specification_counts() {
    let (mut total, mut runs) = (TimingReport::default(), 0);
    for seed in 0..SESSIONS {
        let text = Chip.random_config(seed);
        let requests = Chip.random_requests(&text, seed, REQUESTS);
        let session = Session::new("random", Chip.hello(), &text, &requests);
        let answers = python(&session.text());
        let got: Vec<_> = answers.lines().filter(|line| line.starts_with("c ")).collect();
        let expected = specified(&session, &mut total);
        assert_eq!(got, expected, "{}", String::from_utf8_lossy(&session.text()));
        runs += expected.len();
    }
    // Each unit is busy, idle and stalled by each cause; lines are merged, metadata is written back.
    assert!(runs as u64 > SESSIONS, "{runs} runs");
    for unit in total.units {
        assert!(unit.busy > 0 && unit.idle > 0 && unit.stalls.iter().all(|&stall| stall > 0), "{unit:?}");
    }
    assert!(total.l2.merged > 0 && total.metadata_write_back_bytes > 0);
}
