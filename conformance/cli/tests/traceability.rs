//! model/TRACEABILITY.md is what theorems, sessions and planted faults say: of each requirement, what is about it.
//! `SAARCOR_WRITE_LISTS=1` writes it.

mod common;

use common::stdout_of;
use saarcor_kit::requirements::{Covered, coverage};
use saarcor_kit::templates;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// A file from the root of the workspace on.
fn path(of: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(of)
}

#[derive(Deserialize)]
struct Faults {
    fault: Vec<Fault>,
}

/// A fault planted in the model: what finds it is a theorem, or a property test, which speaks of no one requirement.
#[derive(Deserialize)]
struct Fault {
    #[serde(default)]
    theorem: String,
}

/// Names in a cell of a table.
fn cell(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" · ")
}

fn document() -> String {
    let mut theorems: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let mut of_theorem = BTreeMap::new();
    for theorem in saarcor_proofs::theorems() {
        theorems.entry(theorem.requirement).or_default().push(theorem.name.to_owned());
        of_theorem.insert(theorem.name, theorem.requirement);
    }
    let mut in_model: BTreeMap<&str, usize> = BTreeMap::new();
    let planted = fs::read_to_string(path("proofs/faults.toml")).expect("a list of faults");
    for fault in toml::from_str::<Faults>(&planted).expect("a list of faults").fault {
        if let Some(requirement) = of_theorem.get(&*fault.theorem) {
            *in_model.entry(requirement).or_default() += 1;
        }
    }
    let mut in_implementations: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for fault in templates::faults().expect("a list of faults") {
        in_implementations.entry(fault.requirement).or_default().push(fault.name);
    }
    let mut text = String::from(
        "# Requirements, and what is about each\n\n\
         Generated from the code (`SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-cli --test traceability`). Requirements are those of \
         [SPEC.md](SPEC.md)\nand of [PROTOCOL.md](../conformance/PROTOCOL.md) (P-1 to P-9). Theorems are those of \
         [`proofs`](../proofs/THEOREMS.md), sessions those of `saarcor conform list`. Faults\nof the model are planted in \
         [`proofs/faults.toml`](../proofs/faults.toml), each for the theorem that finds it; faults of implementations in\n\
         [`conformance/duts/broken`](../conformance/duts/broken/faults.toml), each for the requirement that it breaks.\n\n\
         | id | theorems | faults of the model | sessions | faults of implementations |\n|---|---|---:|---|---|\n",
    );
    for Covered { id, sessions, reason } in coverage().expect("the suites") {
        let sessions = match reason {
            Some(reason) => format!("none: {reason}"),
            None => cell(&Vec::from_iter(sessions)),
        };
        let theorems = cell(theorems.get(id).map_or(&[], Vec::as_slice));
        let in_model = in_model.get(id).map_or_else(String::new, usize::to_string);
        let broken = cell(in_implementations.get(id).map_or(&[], Vec::as_slice));
        let _ = writeln!(text, "| {id} | {theorems} | {in_model} | {sessions} | {broken} |");
    }
    text
}

#[test]
fn traceability_is_current() {
    let file = path("model/TRACEABILITY.md");
    let expected = document();
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        fs::write(&file, &expected).expect("the document");
    }
    let current = fs::read_to_string(file).unwrap_or_default();
    assert!(
        current == expected,
        "model/TRACEABILITY.md is not current: SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-cli --test traceability writes it"
    );
}

/// Each requirement of the specification has a theorem, a session or a reason why it has none.
#[test]
fn coverage_is_listed() {
    let listed = stdout_of(&["conform", "list", "--coverage"]);
    let line =
        |id: &str| listed.lines().find(|line| line.starts_with(&format!("{id} "))).expect(id).to_owned();
    assert!(line("VM-7").contains(" vm/"), "{}", line("VM-7"));
    assert!(line("SH-3").contains("none: no kind generates rays"), "{}", line("SH-3"));
}
