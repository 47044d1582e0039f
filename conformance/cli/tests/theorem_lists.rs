//! The lists of theorems in README.md and SPEC.md are those of the code.

use saarcor_cli::prove::{readme_list, spec_list};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const BEGIN: &str = "<!-- theorems -->\n";
const END: &str = "<!-- end of theorems -->";

/// Asserts that the list in `file` is `list`; writes it there if `SAARCOR_WRITE_LISTS` is set.
fn assert_current(file: &str, list: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    let text = fs::read_to_string(&path).expect("the document");
    let (before, rest) = text.split_once(BEGIN).expect("where the list begins");
    let (current, after) = rest.split_once(END).expect("where the list ends");
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        fs::write(&path, format!("{before}{BEGIN}{list}{END}{after}")).expect("the document again");
    } else {
        assert!(
            current == list,
            "the list in {file} is old: SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-cli --test theorem_lists"
        );
    }
}

#[test]
fn readme_lists_the_theorems() {
    assert_current("README.md", &readme_list());
}

#[test]
fn specification_names_the_theorems() {
    assert_current("model/SPEC.md", &spec_list());
}

#[test]
fn theorems_have_names_of_their_own_and_requirements_that_exist() {
    let specification = include_str!("../../../model/SPEC.md");
    let mut names = BTreeSet::new();
    for theorem in saarcor_proofs::theorems() {
        assert!(names.insert(theorem.name), "{} is the name of two theorems", theorem.name);
        let row = format!("\n| {} | ", theorem.requirement);
        assert!(specification.contains(&row), "{}: SPEC.md has no {}", theorem.name, theorem.requirement);
        assert!(!theorem.covers.is_empty(), "{} has no covers", theorem.name);
    }
}
