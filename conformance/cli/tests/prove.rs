//! `saarcor prove`.

mod common;

use common::{saarcor, stdout_of};
use serde_json::Value;

fn lines(out: &str) -> Vec<Value> {
    out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn lists_theorems_without_judging_them() {
    let listed = lines(&stdout_of(&["prove", "--list", "--json"]));
    let (certificates, listed): (Vec<_>, Vec<_>) =
        listed.into_iter().partition(|line| line["engine"] == "gappa");
    assert!(certificates.len() >= 12);
    for certificate in &certificates {
        let verdict = certificate["verdict"].as_str().expect("text");
        assert!(["proved", "not run"].contains(&verdict), "{certificate}");
        for key in ["name", "requirement", "says", "file", "step", "slack"] {
            assert!(certificate[key].is_string(), "{key} of {certificate}");
        }
        assert!(certificate["constant"].as_f64() >= certificate["least"].as_f64(), "{certificate}");
    }
    assert!(listed.len() >= 110);
    for theorem in &listed {
        let keys: Vec<_> = theorem.as_object().expect("an object").keys().collect();
        let expected = [
            "covers",
            "engines",
            "evidence",
            "kani_scope",
            "name",
            "not_for_kani",
            "requirement",
            "says",
            "unit",
        ];
        assert_eq!(keys, expected);
        let engines: Vec<_> = theorem["evidence"].as_object().expect("an object").keys().collect();
        assert_eq!(engines, ["exhaustive", "kani", "random"]);
        for known in theorem["evidence"].as_object().expect("an object").values() {
            let state = known["state"].as_str().expect("text");
            assert!(["current", "stale", "not run", "not for Kani"].contains(&state), "{state}");
            assert!(state != "current" || known["scope"].is_string() && known["seconds"].is_number());
        }
        assert_eq!(theorem["kani_scope"].is_null(), !theorem["not_for_kani"].is_null());
    }
    let text = stdout_of(&["prove", "--list", "hash"]);
    let hash = listed.iter().filter(|theorem| theorem["unit"] == "vm::hash").count();
    assert_eq!(text.lines().count(), hash, "a unit by its name");
    assert!(text.contains("VM-3  The hash gives a set"));
}

#[test]
fn certificates_are_not_run_without_gappa() {
    let args = ["prove", "--engine", "gappa", "--json"];
    let output = saarcor(&args).env("PATH", "").output().expect("the binary starts");
    let lines = lines(&String::from_utf8_lossy(&output.stdout));
    assert!(lines.len() >= 12 && lines.iter().all(|line| line["verdict"] == "not run"));
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn results_add_to_what_is_listed() {
    let results = lines(&stdout_of(&["prove", "metadata_of_the_papers_examples", "--json"]));
    let engines: Vec<_> = results.iter().map(|result| result["engine"].as_str().expect("text")).collect();
    assert_eq!(engines, ["exhaustive", "random"]);
    for result in &results {
        assert_eq!(result["verdict"], "held");
        assert_eq!(result["covers"].as_array().expect("labels").len(), 2);
        assert_eq!(result["covers_reached"], 2);
        assert_eq!((&result["vacuous"], &result["counterexample"]), (&Value::from(0), &Value::Null));
        assert!(result["seconds"].is_number());
    }
    assert_eq!(results[0]["cases"], 10);
    assert_eq!(results[0]["scope"], "example 0..=1, log2 ways 0..=4");
    let more = stdout_of(&["prove", "hash_names_a_set", "--engine", "random", "--cases", "300", "--json"]);
    assert_eq!(lines(&more)[0]["cases"], 300);
}

/// What engines speak of comes from the code: the sizes that types have, and the ranges of what is drawn.
#[test]
fn scopes_are_those_of_the_code() {
    let results = lines(&stdout_of(&["prove", "hit_iff_resident", "--json"]));
    let scope = |at: usize| results[at]["scope"].as_str().expect("text");
    assert!(scope(0).starts_with("ways {1, 2, 4}, log2 ways 0..=2, "), "{}", scope(0));
    assert!(scope(1).contains("line any u32"), "{}", scope(1));
    let listed = lines(&stdout_of(&["prove", "hit_iff_resident", "--list", "--json"]));
    let kani = listed[0]["kani_scope"].as_str().expect("text");
    assert!(kani.starts_with("ways 4, ") && kani.contains("line any u32"), "{kani}");
}

#[test]
fn absent_kani_is_not_run_and_incomplete() {
    let args = ["prove", "hash_names_a_set", "--engine", "all", "--json"];
    let output = saarcor(&args).env("PATH", "").output().expect("the binary starts");
    assert_eq!(output.status.code(), Some(3));
    let results = lines(&String::from_utf8(output.stdout).expect("text"));
    let verdicts: Vec<_> = results.iter().map(|result| result["verdict"].as_str().expect("text")).collect();
    assert_eq!(verdicts, ["not run", "held", "held"]);
    assert!(results[0]["scope"].as_str().expect("text").contains("Kani is absent"));
    assert_eq!(results[0]["cases"], Value::Null);
}

/// A Kani that compiles, judges the first theorem that it is asked for, and ends; beside it, the arguments that it had.
#[cfg(unix)]
const ENDS_EARLY: &str = r#"#!/bin/sh
case "$*" in 'kani --version') echo 'cargo-kani 0.67.0'; exit ;; esac
echo "$*" >> "$ASKED"
case "$*" in *--only-codegen*) exit ;; esac
while [ "$1" != --harness ]; do shift; done
mkdir -p target/kani/result_output_dir
printf ' - Status: SUCCESS\nVERIFICATION:- SUCCESSFUL\nVerification Time: 0.1s\n' > "target/kani/result_output_dir/$2"
echo "Thread 0: Checking harness $2..."
echo 'Thread 0: VERIFICATION:- SUCCESSFUL'
"#;

/// Kani begins again with what is left, and judges by the options by which it has compiled: else it compiles once more, within
/// the bounds of a theorem.
#[cfg(unix)]
#[test]
fn kani_that_ends_early_begins_again() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().expect("a folder");
    let (cargo, asked) = (folder.path().join("cargo"), folder.path().join("asked"));
    std::fs::write(&cargo, ENDS_EARLY).expect("written");
    std::fs::set_permissions(&cargo, std::fs::Permissions::from_mode(0o755)).expect("a program");
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").expect("programs"));
    let mut run = saarcor(&["prove", "geometry", "--engine", "kani", "--json"]);
    let output = run.env("PATH", path).env("ASKED", &asked).output().expect("the binary starts");
    let results = lines(&String::from_utf8(output.stdout).expect("text"));
    let judged = |result: &&Value| result["verdict"] != "not for Kani";
    assert!(results.iter().filter(judged).count() > 5, "{results:?}");
    assert!(results.iter().all(|result| result["verdict"] != "not run"), "{results:?}");
    let asked = std::fs::read_to_string(asked).expect("text");
    let asked: Vec<_> = asked.lines().collect();
    for pair in asked.chunks(2) {
        let compiled = pair[0].strip_suffix(" --only-codegen").expect("compiled first");
        assert!(pair[1].starts_with(compiled), "{pair:?}");
    }
}
