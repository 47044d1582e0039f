//! `saarcor metadata`.

mod common;

use common::stdout_of;
use serde_json::{Value, json};

fn metadata(args: &[&str]) -> Value {
    let out = stdout_of(&[&["metadata", "--json"], args].concat());
    assert_eq!(out.lines().count(), 1, "one object");
    serde_json::from_str(&out).expect("JSON")
}

#[test]
fn examples_of_the_paper() {
    let expected = json!({
        "memory_bytes": 16_777_216, "line_bytes": 128, "ways": 4, "lines": 131_072, "sets": 32_768,
        "entry_bytes": 5, "metadata_bytes": 655_360, "metadata_percent": 3.90625,
    });
    assert_eq!(metadata(&["--memory", "16MiB", "--line", "128"]), expected);
    assert_eq!(metadata(&[]), expected, "the default is the paper's first example");
    assert_eq!(metadata(&["--line", "1024"])["metadata_bytes"], 81_920);
    assert_eq!(metadata(&["--line", "1KiB"])["metadata_percent"], 0.488_281_25);
}

#[test]
fn sets_are_lines_by_ways() {
    for (ways, sets) in [("1", 131_072), ("2", 65_536), ("8", 16_384), ("16", 8_192)] {
        assert_eq!(metadata(&["--ways", ways])["sets"], sets);
    }
}

#[test]
fn text_shows_the_papers_values_beside_ours() {
    let out = stdout_of(&["metadata"]);
    for part in ["640KiB", "640 KB, 3.9 %", "80KiB", "80 KB, 0.4 %"] {
        assert!(out.contains(part), "'{part}' is not in {out}");
    }
    assert_eq!(out.matches("131072").count(), 1, "the default is one of the examples, and stands once");
    assert!(stdout_of(&["metadata", "--memory", "8MiB"]).contains("8MiB"));
}
