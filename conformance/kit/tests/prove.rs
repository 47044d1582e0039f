//! Proofs of the Verilog template, of its faults, and of what cannot be judged.
#![cfg(unix)]

use saarcor_kit::error::Error;
use saarcor_kit::prove::driver::{Asked, prove};
use saarcor_kit::prove::report::{ProofReport, ProofVerdict};
use saarcor_kit::prove::tools::Tools;
use saarcor_kit::target::DutFile;
use saarcor_kit::templates::{TEMPLATES, faults};
use std::time::Duration;

/// The template's files, each edited.
fn edited(edit: impl Fn(&str, String) -> String) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let template = TEMPLATES.iter().find(|template| template.name == "verilog").expect("a template");
    for (name, text) in template.files() {
        std::fs::write(folder.path().join(name), edit(name, text)).expect("written");
    }
    folder
}

/// What a proof of a folder finds. The programs have to be there: a test without them is no test.
fn proved(folder: &std::path::Path, from_ports: bool) -> Result<ProofReport, Error> {
    let tools = Tools::find().expect("Yosys, ABC and a solver are there");
    let file = DutFile::read(folder)?;
    let work = tempfile::tempdir().expect("a folder");
    let asked = Asked {
        name: "template".to_owned(),
        kind: &file.kind,
        folder,
        config: file.prove.as_ref().expect("a table [prove]"),
        work: work.path(),
        limit: Duration::from_secs(120),
        from_ports,
    };
    prove(&asked, tools, &|_| ())
}

/// At the paper's 8 MB and 64 MB, and from the ports alone.
#[test]
#[ignore = "needs Yosys and a solver, and takes a minute"]
fn verilog_is_proved() {
    for lines in [65_536, 524_288] {
        let folder = edited(|_, text| text.replace("lines=65536", &format!("lines={lines}")));
        let report = proved(folder.path(), false).expect("it can be judged");
        println!("{report:#?}");
        assert_eq!(report.verdict, ProofVerdict::Proved, "{report:#?}");
        assert!(report.covers.len() >= 7 && report.planted.len() >= 3);
    }
    let report = proved(edited(|_, text| text).path(), true).expect("it can be judged");
    println!("{report:#?}");
    assert_eq!(report.verdict, ProofVerdict::Proved, "{report:#?}");
}

#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_faults_are_refuted() {
    let template = TEMPLATES.iter().find(|template| template.name == "verilog").expect("a template");
    for fault in faults().expect("a list").iter().filter(|fault| fault.template == "verilog") {
        let files = template.with_fault(fault).expect("its line is there");
        // Folds are of the hash that has several.
        let hash = |text: &str| {
            if fault.requirement == "VM-3" {
                text.replace("hash=add-upper ", "hash=add-upper-all ")
            } else {
                text.to_owned()
            }
        };
        let folder = edited(|name, _| {
            files.iter().find(|(file, _)| *file == name).map(|(_, text)| hash(text)).unwrap_or_default()
        });
        let report = proved(folder.path(), false).expect("it can be judged");
        println!("{}\n{report:#?}", fault.name);
        assert_eq!(report.verdict, ProofVerdict::Refuted, "{}: {report:#?}", fault.name);
        let trace = report.trace.expect("a trace");
        assert!(!trace.requests.is_empty() && trace.requests.len() < trace.clocks as usize);
    }
}

/// Faults that are no template's: in the top bit of a tag, in the last way, in an update, behind a reset.
#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_faults_that_hide_are_refuted() {
    for (from, to) in [
        (
            "set_tags[i*TAG_BITS +: TAG_BITS] == line)",
            "set_tags[i*TAG_BITS +: TAG_BITS - 1] == line[TAG_BITS-2:0])",
        ),
        ("ages[set] <= next_ages;", "if (!found || found_way != WAYS - 1) ages[set] <= next_ages;"),
        (
            "if (found) resident[set][found_way] <= 0;",
            "if (found && found_way != WAYS - 1) resident[set][found_way] <= 0;",
        ),
        ("done <= start && !reset;", "done <= start && !reset && !(forget && found);"),
        ("evicts <= !found && !free;", "evicts <= !found && !free && way != 3;"),
    ] {
        let folder = edited(|_, text| text.replace(from, to));
        let report = proved(folder.path(), false).expect("it can be judged");
        println!("{to}\n{report:#?}");
        assert_eq!(report.verdict, ProofVerdict::Refuted, "{to}: {report:#?}");
    }
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
    ] {
        let folder = edited(|_, text| text.replace(from, to));
        match proved(folder.path(), false) {
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains(says) && error.lines().count() == 1, "{to}: {error}");
            }
            Ok(report) => panic!("{to}: {report:#?}"),
        }
    }
}

/// Nothing is proved of what stands still, nor under an assumption that never holds.
#[test]
#[ignore = "needs Yosys and a solver"]
fn verilog_proofs_are_not_empty() {
    for (from, to) in [
        ("always @(posedge clock) begin\n        done", "always @(posedge (clock & 0)) begin\n        done"),
        ("probe_resident = resident[probe]", "probe_resident = ~resident[probe]"),
    ] {
        let folder = edited(|_, text| text.replace(from, to));
        let verdict = proved(folder.path(), false).map(|report| report.verdict);
        assert!(!matches!(verdict, Ok(ProofVerdict::Proved)), "{to}");
    }
    // An assumption of its own is taken away.
    let folder =
        edited(|_, text| text.replace("    integer s, w;", "    always @* assume(0);\n    integer s, w;"));
    let report = proved(folder.path(), false).expect("it can be judged");
    assert_eq!(report.verdict, ProofVerdict::Proved, "{report:#?}");
}
