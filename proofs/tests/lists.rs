//! The lists of theorems in proofs/THEOREMS.md, README.md and SPEC.md are those of the code.

use saarcor_proofs::lists::{spec_list, theorem_list};
use saarcor_proofs::theorem::Theorem;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const BEGIN: &str = "<!-- theorems -->\n";
const END: &str = "<!-- end of theorems -->";

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file)
}

/// Asserts that the list in `file` is the one that is generated; writes `new` there if
/// `SAARCOR_WRITE_LISTS` is set.
fn assert_current(file: &str, is_current: bool, new: &str) {
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        fs::write(path(file), new).expect("the document again");
    } else {
        assert!(
            is_current,
            "the list in {file} is old: SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-proofs --test lists"
        );
    }
}

#[test]
fn the_page_of_theorems_is_generated() {
    let current = fs::read_to_string(path("proofs/THEOREMS.md")).unwrap_or_default();
    let list = theorem_list();
    assert_current("proofs/THEOREMS.md", current == list, &list);
}

#[test]
fn specification_names_the_theorems() {
    let text = fs::read_to_string(path("model/SPEC.md")).expect("the specification");
    let (before, rest) = text.split_once(BEGIN).expect("where the list begins");
    let (current, after) = rest.split_once(END).expect("where the list ends");
    let list = spec_list();
    assert_current("model/SPEC.md", current == list, &format!("{before}{BEGIN}{list}{END}{after}"));
}

/// README.md shows some theorems in rows of a table: requirement, sentence, name with a link.
#[test]
fn readme_cites_theorems_as_they_are() {
    let text = fs::read_to_string(path("README.md")).expect("the README");
    let mut cited = BTreeSet::new();
    let rows = text.lines().map(|row| {
        if !row.starts_with('|') || !row.contains("](proofs/src/") {
            return row.to_owned();
        }
        let Theorem { name, file, requirement, says, .. } = saarcor_proofs::theorems()
            .find(|theorem| row.contains(&format!("[`{}`]", theorem.name)))
            .unwrap_or_else(|| panic!("README.md: no theorem has the name in {row}"));
        cited.insert(*name);
        format!("| {requirement} | {says} | [`{name}`]({file}) |")
    });
    let new = rows.collect::<Vec<_>>().join("\n") + "\n";
    assert_current("README.md", text == new, &new);
    assert!(cited.len() >= 8, "README.md cites {} theorems", cited.len());
}

#[test]
fn theorems_have_names_of_their_own_and_requirements_that_exist() {
    let specification = include_str!("../../model/SPEC.md");
    let mut names = BTreeSet::new();
    for theorem in saarcor_proofs::theorems() {
        assert!(names.insert(theorem.name), "{} is the name of two theorems", theorem.name);
        let row = format!("\n| {} | ", theorem.requirement);
        assert!(specification.contains(&row), "{}: SPEC.md has no {}", theorem.name, theorem.requirement);
        assert!(!theorem.covers.is_empty(), "{} has no covers", theorem.name);
    }
}
