//! The theorems find the faults that implementers make: each of `faults.toml` is planted into a
//! copy of the model, and both engines have to tell.

use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(Deserialize)]
struct Faults {
    fault: Vec<Fault>,
}

/// A line of the model, and the fault that takes its place.
#[derive(Deserialize)]
struct Fault {
    name: String,
    file: String,
    from: String,
    to: String,
}

fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

fn faults() -> Vec<Fault> {
    let text = fs::read_to_string(workspace().join("proofs/faults.toml")).expect("the list of faults");
    toml::from_str::<Faults>(&text).expect("a list of faults").fault
}

/// The model's file with the fault in it.
fn planted(fault: &Fault) -> String {
    let source = fs::read_to_string(workspace().join("model/spec/src").join(&fault.file))
        .expect("a file of the model");
    assert_eq!(source.matches(&fault.from).count(), 1, "{}: the line to replace is there once", fault.name);
    source.replace(&fault.from, &fault.to)
}

#[test]
fn every_fault_has_its_line() {
    let faults = faults();
    assert!(faults.len() >= 12);
    faults.iter().for_each(|fault| assert!(planted(fault).contains(&fault.to), "{}", fault.name));
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry").path();
        let target = to.join(entry.file_name().expect("a name"));
        if entry.is_dir() {
            copy(&entry, &target);
        } else {
            fs::copy(&entry, &target).expect("a copy");
        }
    }
}

/// A workspace of the model, the reference and the proofs, apart from this one.
fn copied_workspace() -> PathBuf {
    let copied = Path::new(env!("CARGO_TARGET_TMPDIR")).join("faults");
    let _ = fs::remove_dir_all(&copied);
    for folder in [".cargo", "model", "proofs", "reference"] {
        copy(&workspace().join(folder), &copied.join(folder));
    }
    let manifest = fs::read_to_string(workspace().join("Cargo.toml")).expect("the workspace's manifest");
    let members = r#"members = ["model/spec", "proofs", "reference/oracles"]"#;
    let lines = manifest.lines().map(|line| match line.split(' ').next() {
        Some("members") => members,
        Some("default-members") => "",
        _ => line,
    });
    let manifest =
        lines.collect::<Vec<_>>().join("\n").replace("[profile.release.package.kuva]\nopt-level = 1", "");
    fs::write(copied.join("Cargo.toml"), manifest).expect("a manifest");
    fs::copy(workspace().join("Cargo.lock"), copied.join("Cargo.lock")).expect("a lock file");
    copied
}

const ENGINES: [&str; 2] = ["exhaustive::", "random::"];

/// What the theorems say of the copy by each engine: nothing, or which does not hold, and where.
fn judge(copied: &Path) -> [Option<String>; 2] {
    let output = Command::new(env!("CARGO"))
        .current_dir(copied)
        .args(["test", "--offline", "-p", "saarcor-proofs", "--test", "theorems", "--"])
        .args(ENGINES)
        .env("CARGO_TARGET_DIR", copied.join("target"))
        .env("SAARCOR_FIRST_FAILURE", "1")
        .output()
        .expect("cargo");
    let text = String::from_utf8_lossy(&output.stdout);
    let tests = || text.lines().filter_map(|line| line.strip_prefix("test "));
    ENGINES.map(|engine| {
        let mut units = tests().filter(|test| test.starts_with(engine)).peekable();
        if units.peek().is_some() && units.all(|unit| unit.ends_with("ok")) {
            return None;
        }
        let said = text.split("\n---- ").find_map(|test| {
            let (_, said) = test.strip_prefix(engine)?.split_once("do not hold:\n")?;
            Some(said.lines().take(2).collect::<Vec<_>>().join("\n"))
        });
        // A fault that does not compile, or panics, is none that a theorem has found.
        Some(said.unwrap_or_else(|| {
            panic!("no theorem spoke: {text}\n{}", String::from_utf8_lossy(&output.stderr))
        }))
    })
}

#[test]
#[ignore = "builds the model once for each fault: minutes"]
fn every_fault_is_found_by_both_engines() {
    let copied = copied_workspace();
    let mut missed = Vec::new();
    for fault in faults() {
        let file = copied.join("model/spec/src").join(&fault.file);
        let sound = fs::read_to_string(&file).expect("a file of the model");
        fs::write(&file, planted(&fault)).expect("a planted fault");
        for (engine, said) in ENGINES.iter().zip(judge(&copied)) {
            match said {
                Some(said) => println!("{} | {engine}\n{said}\n", fault.name),
                None => missed.push(format!("{} ({engine})", fault.name)),
            }
        }
        fs::write(&file, sound).expect("the sound file again");
    }
    assert!(missed.is_empty(), "not found: {missed:?}");
}
