//! Proofs of the templates in Verilog, of their faults, and of what cannot be judged.
#![cfg(unix)]

use saarcor_kit::error::Error;
use saarcor_kit::kind::Kind as _;
use saarcor_kit::plan::{Options, PlannedSession};
use saarcor_kit::prove::driver::{Asked, prove};
use saarcor_kit::prove::report::{ProofReport, ProofVerdict, Trace};
use saarcor_kit::prove::tools::Tools;
use saarcor_kit::report::ConformanceVerdict;
use saarcor_kit::run::run;
use saarcor_kit::session::Session;
use saarcor_kit::target::{DutFile, Target, TargetOptions};
use saarcor_kit::templates::{Fault, TEMPLATES, Template, faults};
use saarcor_kit::vm::Vm;
use std::path::Path;
use std::time::Duration;

fn template(name: &str) -> &'static Template {
    TEMPLATES.iter().find(|template| template.name == name).expect("a template")
}

/// A template's files, each edited.
fn edited(name: &str, edit: impl Fn(&str) -> String) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in template(name).files() {
        std::fs::write(folder.path().join(name), edit(&text)).expect("written");
    }
    folder
}

/// A template in which each of these texts is another.
fn with(name: &str, edits: &[(&str, &str)]) -> tempfile::TempDir {
    let before: String = template(name).files().into_iter().map(|(_, text)| text).collect();
    for (from, _) in edits {
        assert!(before.contains(from), "{from}");
    }
    edited(name, |text| edits.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to)))
}

/// What a proof of a folder finds. The programs have to be there: a test without them is no test.
fn proved(folder: &Path, from_ports: bool) -> Result<ProofReport, Error> {
    proved_within(600, folder, from_ports)
}

/// The same with a limit in seconds.
fn proved_within(limit: u64, folder: &Path, from_ports: bool) -> Result<ProofReport, Error> {
    let tools = Tools::find().expect("Yosys, ABC and a solver are there");
    let file = DutFile::read(folder)?;
    let work = tempfile::tempdir().expect("a folder");
    let asked = Asked {
        name: "template".to_owned(),
        kind: &file.kind,
        folder,
        config: file.prove.as_ref().expect("a table [prove]"),
        work: work.path(),
        limit: Duration::from_secs(limit),
        from_ports,
    };
    prove(&asked, tools, &|_| ())
}

#[track_caller]
fn is_proved(folder: &Path, from_ports: bool) {
    let report = proved(folder, from_ports).expect("it can be judged");
    assert_eq!(report.verdict, ProofVerdict::Proved, "{report:#?}");
    assert!(report.covers.len() >= 6 && report.planted.len() >= 5, "{report:#?}");
}

#[track_caller]
fn is_refuted(folder: &Path, what: &str) -> Trace {
    let report = proved(folder, false).expect("it can be judged");
    assert_eq!(report.verdict, ProofVerdict::Refuted, "{what}: {report:#?}");
    report.trace.expect("a trace")
}

/// Whether the simulation conforms in the session of a trace.
fn replayed(folder: &Path, trace: &Trace) -> ConformanceVerdict {
    let options = TargetOptions { time_limit: Some(600.0), ..TargetOptions::default() };
    let target = Target::open(folder.as_os_str(), &options).expect("a folder");
    let text = String::from_utf8(trace.suite.clone()).expect("text");
    let sessions = Session::parse("trace", &text).expect("a suite");
    let planned: Vec<_> =
        sessions.into_iter().map(|session| PlannedSession::Directed(Box::new(session))).collect();
    let options = Options { shrink: false, ..Options::default() };
    run(Vm.name(), &*target.dut, &Vm, &planned, &options, &|_| ()).expect("it runs").verdict
}

/// At the paper's 8 MB and 64 MB.
#[test]
#[ignore = "needs Yosys and a solver, and takes minutes"]
fn verilog_is_proved() {
    is_proved(edited("verilog", str::to_owned).path(), false);
    is_proved(with("verilog", &[("lines=65536", "lines=524288")]).path(), false);
}

#[test]
#[ignore = "needs Yosys and a solver, and takes minutes"]
fn verilog_pipelined_is_proved() {
    is_proved(with("verilog-pipelined", &[("lines=65536", "lines=524288")]).path(), false);
}

/// By FIFO the pipeline keeps a list of ways: no claim about what it shows says that each is in it once.
#[test]
#[ignore = "needs Yosys and a solver, and takes a minute"]
fn verilog_pipelined_with_fifo_is_proved() {
    let edits = [("lines=65536", "lines=524288"), ("policy=plru", "policy=fifo")];
    is_proved(with("verilog-pipelined", &edits).path(), false);
}

/// From the ports alone, at 8 MB.
#[test]
#[ignore = "needs Yosys and a solver, and takes minutes"]
fn verilog_is_proved_from_its_ports() {
    is_proved(edited("verilog", str::to_owned).path(), true);
    is_proved(edited("verilog-pipelined", str::to_owned).path(), true);
}

/// The files of a cache of `tests/verilog`, with a text in the place of another.
fn cache_of(name: &str, from: &str, to: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/verilog").join(name);
    let read = |file: &str| std::fs::read_to_string(own.join(file)).expect("it is there");
    let text = read("cache.v");
    assert!(text.contains(from), "{from}");
    std::fs::write(folder.path().join("cache.v"), text.replace(from, to)).expect("written");
    std::fs::write(folder.path().join("dut.toml"), read("dut.toml")).expect("written");
    folder
}

/// It takes three clocks to an answer, and nothing says in which of them a request changes the state.
#[test]
#[ignore = "needs Yosys and a solver, and takes minutes"]
fn verilog_in_three_clocks_is_proved_from_its_ports() {
    is_proved(cache_of("multi_cycle", "", "").path(), false);
    for (from, to) in
        [("e0[T-1:0] == line", "e0[T-2:0] == line[T-2:0]"), ("if (inv) begin", "if (inv && fw != 0) begin")]
    {
        let report = proved(cache_of("multi_cycle", from, to).path(), false).expect("it can be judged");
        assert_eq!(report.verdict, ProofVerdict::Refuted, "{to}: {report:#?}");
    }
}

/// It has the bytes of its lines: each byte that is read is the one that was loaded, at its stated size and with nothing shown.
#[test]
#[ignore = "needs Yosys and a solver, and takes minutes"]
fn verilog_with_its_memory_is_proved_to_the_byte() {
    let report = proved(cache_of("with_memory", "", "").path(), false).expect("it can be judged");
    assert_eq!(report.verdict, ProofVerdict::Proved, "{report:#?}");
    assert!(report.stages.iter().any(|stage| stage.config == report.config), "{report:#?}");
    assert!(!report.not_claimed.iter().any(|what| what.contains("bytes")), "{report:#?}");
    for (from, to, claim) in [
        // What is wrong with the bytes shows nowhere else.
        ("host[LINE_BITS-1:2]}]", "host[LINE_BITS-1:2] & ~1}]", "data"),
        (
            "memory[{set, way, beat}] <= fill_data;",
            "memory[{set, way, beat}] <= fill_data & 32'hff7fffff;",
            "data",
        ),
        ("way <= use; beat <= 0;", "way <= 0; beat <= 0;", "data"),
        ("FILL: if (fill) begin", "FILL: if (fill || host[31]) begin", "data"),
        ("load_address = {host[31:LINE_BITS]", "load_address = {host[31:LINE_BITS+1], 1'b0", "loaded"),
        ("state <= found ? READ : LOAD;", "state <= found && free ? READ : LOAD;", "loaded"),
    ] {
        let report = proved(cache_of("with_memory", from, to).path(), false).expect("it can be judged");
        let found = report.trace.as_ref().map(|trace| trace.claim.as_str());
        assert_eq!(found, Some(claim), "{to}: {report:#?}");
    }
}

/// The configuration in which a fault shows.
fn config_of(fault: &Fault) -> (&'static str, &'static str) {
    let policy = if fault.name.contains("fifo") { "policy=fifo" } else { "policy=plru" };
    let name = &fault.name;
    let hash = if name.contains("fold") || name.contains("hash-without") {
        "hash=add-upper-all"
    } else {
        "hash=add-upper"
    };
    (policy, hash)
}

/// A fault whose trace does not replay: it needs values before the first reset that a simulation does not have.
const NOT_REPLAYED: [&str; 1] = ["verilog-hit-without-the-resident-bit"];

/// All, or those that `SAARCOR_FAULTS_PART=K/N` names, each Kth of N, or `SAARCOR_FAULTS`, by their names.
#[test]
#[ignore = "needs Yosys, a solver and Icarus Verilog, and takes half an hour"]
fn verilog_faults_are_refuted() {
    let part = std::env::var("SAARCOR_FAULTS_PART").unwrap_or("0/1".to_owned());
    let (part, parts) = part.split_once('/').expect("K/N");
    let (part, parts): (usize, usize) = (part.parse().expect("K"), parts.parse().expect("N"));
    let faults = faults().expect("a list");
    let names = std::env::var("SAARCOR_FAULTS");
    let is_named = |name: &str| names.as_ref().is_ok_and(|names| names.split(',').any(|own| own == name));
    let is_asked =
        |fault: &&Fault| fault.template.starts_with("verilog") && (names.is_err() || is_named(&fault.name));
    let faults = faults.iter().filter(is_asked);
    let mut wrong = Vec::new();
    for fault in faults.skip(part).step_by(parts) {
        let files = template(&fault.template).with_fault(fault).expect("its line is there");
        let folder = tempfile::tempdir().expect("a folder");
        let (policy, hash) = config_of(fault);
        for (name, text) in files {
            let text = text.replace("policy=plru", policy).replace("hash=add-upper ", &format!("{hash} "));
            std::fs::write(folder.path().join(name), text).expect("written");
        }
        let trace = is_refuted(folder.path(), &fault.name);
        let verdict = replayed(folder.path(), &trace);
        println!(
            "{}: {} after {} clocks, {} requests: {verdict:?}",
            fault.name,
            trace.claim,
            trace.clocks,
            trace.requests.len()
        );
        if verdict != ConformanceVerdict::DoesNotConform && !NOT_REPLAYED.contains(&fault.name.as_str()) {
            wrong.push(format!("{}: {:?}", fault.name, trace.requests));
        }
    }
    assert!(wrong.is_empty(), "traces that do not replay: {wrong:#?}");
}

/// Faults that are in no list: in the top bit of a tag, in the last way, in an update, of large memories alone.
#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_faults_that_hide_are_refuted() {
    for (name, from, to) in [
        (
            "verilog",
            "set_tags[i*TAG_BITS +: TAG_BITS] == line)",
            "set_tags[i*TAG_BITS +: TAG_BITS - 1] == line[TAG_BITS-2:0])",
        ),
        (
            "verilog",
            "ages[set] <= next_ages;",
            "if (!found || found_way != WAYS - 1) ages[set] <= next_ages;",
        ),
        ("verilog", "wire [31:0] set = set_of(line);", "wire [31:0] set = set_of(line) & 32'h1fff;"),
        ("verilog-pipelined", "reg [SET_WIDTH-1:0] set;", "reg [(SET_WIDTH < 13 ? SET_WIDTH : 13)-1:0] set;"),
        ("verilog-pipelined", "if (reset) waiting <= 0;", "if (reset && waiting !== 1'b1) waiting <= 0;"),
    ] {
        let report = proved_within(240, with(name, &[(from, to)]).path(), false).expect("it can be judged");
        assert_eq!(report.verdict, ProofVerdict::Refuted, "{to}: {report:#?}");
    }
}

/// A register of another use has the value of its reset in a trace of a large memory too: this one never gets as far.
#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_that_is_right_is_not_refuted_from_a_state_without_reset() {
    let edits = [
        ("integer s;", "reg [23:0] beats;\n    integer s;"),
        (
            "done <= start && !reset;",
            "done <= start && !reset;\n        beats <= reset || beats == 9999999 ? 0 : beats + start;",
        ),
        ("hit <= found;", "hit <= found ^ (beats == 16777000);"),
    ];
    let report = proved_within(40, with("verilog", &edits).path(), false).expect("it can be judged");
    assert_ne!(report.verdict, ProofVerdict::Refuted, "{report:#?}");
}

/// What cannot be judged is one clear line, and never proved.
#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_that_cannot_be_judged_is_an_error() {
    for (from, to, says) in [
        ("wire [31:0] set = set_of(line);", "wire [31:0] set = set_of(line;", "cache.v"),
        ("module cache ", "module cash ", "cache"),
        (
            "output reg [31:0] card ",
            "output reg [30:0] card ",
            "it is an output of 31; it has to be an output of 32 bits",
        ),
        ("wire [31:0] set = set_of(line);", "wire [31:0] set; blackbox box(line, set);", "blackbox"),
        ("wire [31:0] set = set_of(line);", "wire [31:0] set = set_of(line) ^ (set & nothing);", "nothing"),
        ("wire [31:0] set = set_of(line);", "wire [31:0] set = set_of(line) + (set & 1);", "loop"),
        (
            "wire [31:0] set = set_of(line);",
            "wire [31:0] none; wire [31:0] set = set_of(line) | (none & 1);",
            "no driver",
        ),
        ("probe_tags\"", "probe_tag\"", "there is none"),
        ("probe_resident = resident[probe]", "probe_resident = memory[probe]", "memory"),
        ("hit <= found;", "hit <= found ? 1'b1 : 1'bx;", "port 'hit' has a value x"),
        ("hit <= found;", "hit <= 1'bx;", "port 'hit' has a value x"),
        (
            "always @(posedge clock) begin\n        done",
            "always @(posedge (clock & 1'b0)) begin\n        done",
            "another clock",
        ),
        (
            "always @(posedge clock) begin\n        done",
            "always @(negedge clock) begin\n        done",
            "falling edge",
        ),
    ] {
        let folder = with("verilog", &[(from, to)]);
        match proved(folder.path(), false) {
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains(says) && error.lines().count() == 1, "{to}: {error}");
            }
            Ok(report) => panic!("{to}: {report:#?}"),
        }
    }
}

/// Nothing is proved of another set than the one that is shown, nor under an assumption that never holds: the sources' own are
/// not taken.
#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_proofs_are_not_empty() {
    for (from, to) in [
        ("probe_resident = resident[probe]", "probe_resident = ~resident[probe]"),
        ("hit <= found;", "assume(0); hit <= !found;"),
    ] {
        let folder = with("verilog", &[(from, to)]);
        let verdict = proved_within(30, folder.path(), false).map(|report| report.verdict);
        assert!(!matches!(verdict, Ok(ProofVerdict::Proved)), "{to}: {verdict:?}");
    }
}
