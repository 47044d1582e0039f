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
    assert!(listed.len() >= 110);
    for theorem in &listed {
        let keys: Vec<_> = theorem.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["covers", "engines", "name", "not_for_kani", "requirement", "says", "unit"]);
    }
    let text = stdout_of(&["prove", "--list", "hash"]);
    let hash = listed.iter().filter(|theorem| theorem["unit"] == "vm::hash").count();
    assert_eq!(text.lines().count(), hash, "a unit by its name");
    assert!(text.contains("VM-3  The hash gives a set"));
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
