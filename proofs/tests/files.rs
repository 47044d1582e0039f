//! The proofs follow the model: each file of the specification that decides something has its file
//! here, and each twin has its theorems of equality.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Files of the specification, or folders, without a file of theorems, and why.
const WITHOUT_THEOREMS: &[(&str, &str)] = &[
    ("vm/units.rs", "types of numbers: they decide nothing"),
    ("vm/version_a.rs", "loads what was stored: part of `vm/directory.rs`"),
    ("host/scene.rs", "types; what has no area: tests of the model"),
    (
        "rays/intersection",
        "one test a file: parts of `rays/intersection.rs`, judged there by the exact test, and that by rationals",
    ),
    ("rays/pipeline.rs", "drives the units: `tests/pictures.rs`"),
    ("time/standard.rs", "numbers: they decide nothing"),
    ("time/chip/bus_manager.rs", "part of `time/chip/mod.rs`"),
    ("time/chip/loads.rs", "its theorems are in `time/loads.rs`"),
    ("time/chip/tags.rs", "the decisions of the directory: `vm/directory.rs`"),
];

fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The Rust files below a folder, by their paths from there on.
fn files(folder: &str) -> BTreeSet<String> {
    let root = workspace().join(folder);
    let (mut found, mut folders) = (BTreeSet::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path: PathBuf = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(&root).expect("below the folder");
                found.insert(name.to_str().expect("a name").to_owned());
            }
        }
    }
    found
}

/// The files of theorems that have at least one, by their paths from `proofs/src` on.
fn files_of_theorems() -> BTreeSet<&'static str> {
    saarcor_proofs::theorems().filter_map(|theorem| theorem.file.strip_prefix("proofs/src/")).collect()
}

#[test]
fn each_file_of_the_specification_that_decides_has_theorems() {
    let ours = files_of_theorems();
    for file in files("model/spec/src") {
        let is_list = file.ends_with("mod.rs") && !file.contains("chip") || file == "lib.rs";
        let excepted = WITHOUT_THEOREMS.iter().any(|(name, _)| {
            file == *name || file.strip_prefix(name).is_some_and(|rest| rest.starts_with('/'))
        });
        assert!(
            is_list || excepted || ours.contains(&*file),
            "model/spec/src/{file}: no theorem in proofs/src/{file}, and no reason why"
        );
    }
}

/// The parts of a folder, as `chip/`, count as one twin.
#[test]
fn each_twin_names_its_specification_and_is_proved_equal() {
    let ours = files_of_theorems();
    let mut twins = BTreeSet::new();
    for file in files("model/fast/src") {
        if file == "lib.rs" {
            continue;
        }
        let twin = file.split_once('/').map_or(file.trim_end_matches(".rs"), |(folder, _)| folder);
        twins.insert(twin.to_owned());
        let is_part = file.contains('/') && !file.ends_with("mod.rs");
        let text = fs::read_to_string(workspace().join("model/fast/src").join(&file)).expect("a file");
        let names = text.lines().any(|line| line.starts_with("//!") && line.contains("win of"));
        assert!(is_part || names, "model/fast/src/{file} does not say whose twin it is");
    }
    for twin in twins {
        let places = [format!("equal/{twin}.rs"), format!("equal/{twin}/mod.rs")];
        let inside = ours.iter().any(|file| file.starts_with(&format!("equal/{twin}/")));
        assert!(
            inside || places.iter().any(|place| ours.contains(&**place)),
            "the twin {twin} of model/fast has no theorem in proofs/src/equal"
        );
    }
}

#[test]
fn there_are_enough_theorems() {
    let count = saarcor_proofs::theorems().count();
    assert!(count >= 110, "{count} theorems");
}
