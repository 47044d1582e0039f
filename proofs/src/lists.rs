//! The lists of theorems that documents show, as Markdown.

use crate::theorem::Theorem;
use crate::theorems;
use std::fmt::Write as _;

/// The list of all theorems by their units: `proofs/THEOREMS.md`.
#[must_use]
pub fn theorem_list() -> String {
    let count = theorems().count();
    let for_kani = theorems().filter(|theorem| theorem.not_for_kani.is_none()).count();
    let mut list = format!(
        "# The theorems\n\n\
         {count} theorems, unit by unit, of which Kani can judge {for_kani}; where it cannot, the last column says why.\n\
         Every theorem is judged by exhaustion of a small scope (E) and at random (R), and where it can be by Kani (K):\n\
         see [README.md](README.md). This page is generated from the theorems' own comments.\n"
    );
    let mut unit = "";
    for theorem in theorems() {
        let Theorem { name, requirement, says, not_for_kani, .. } = theorem;
        let file = theorem.file.trim_start_matches("proofs/");
        if unit != theorem.unit() {
            unit = theorem.unit();
            let _ = write!(
                list,
                "\n## [`{unit}`]({file})\n\n| | theorem | name | engines |\n|---|---|---|---|\n"
            );
        }
        let engines = match not_for_kani {
            None => "K E R".to_owned(),
            Some(why) => format!("E R; not for Kani: {why}"),
        };
        let _ = writeln!(list, "| {requirement} | {says} | [`{name}`]({file}) | {engines} |");
    }
    list
}

/// The names of all theorems by their requirements, as SPEC.md shows them: a table in Markdown.
#[must_use]
pub fn spec_list() -> String {
    let mut requirements: Vec<_> = theorems().map(|theorem| theorem.requirement).collect();
    // VM-2 before VM-10.
    requirements.sort_by_key(|id| id.split_once('-').map(|(part, number)| (part, number.len(), number)));
    requirements.dedup();
    let mut list = "| id | theorems |\n|---|---|\n".to_owned();
    for id in requirements {
        let names = theorems().filter(|theorem| theorem.requirement == id);
        let names: Vec<_> = names.map(|theorem| format!("`{}`", theorem.name)).collect();
        let _ = writeln!(list, "| {id} | {} |", names.join(" · "));
    }
    list
}
