//! The lists of theorems that documents show, as Markdown.

use crate::evidence::{ENGINES, Evidence, Shown, State};
use crate::theorem::Theorem;
use crate::theorems;
use std::fmt::Write as _;

/// The list of all theorems by their units, with what was shown of each: `proofs/THEOREMS.md`.
#[must_use]
pub fn theorem_list(evidence: &Evidence) -> String {
    let count = theorems().count();
    let in_state = |state| theorems().filter(|theorem| evidence.state(theorem, "kani") == state).count();
    let mut list = format!(
        "# The theorems\n\n\
         {count} theorems, unit by unit. Every theorem is judged by exhaustion of a small scope (E) and at random (R), and \
         where it can be by Kani (K): see [README.md](README.md).\n\
         This page is generated from the theorems' own comments and from [verdicts.toml](verdicts.toml).\n\n\
         Kani's evidence: {} current, {} stale, since the theorem or what it rests on has changed, {} missing; {} theorems \
         are not for Kani, and say why. `saarcor prove --list` says the same of the code as it is.\n",
        in_state(State::Current),
        in_state(State::Stale),
        in_state(State::Missing),
        in_state(State::NotForKani),
    );
    let mut details = String::new();
    let mut unit = "";
    for theorem in theorems() {
        let Theorem { name, requirement, says, .. } = theorem;
        let file = theorem.file.trim_start_matches("proofs/");
        if unit != theorem.unit() {
            end_unit(&mut list, &mut details);
            unit = theorem.unit();
            let _ = write!(
                list,
                "\n## [`{unit}`]({file})\n\n| | theorem | name | engines |\n|---|---|---|---|\n"
            );
        }
        let kani = match evidence.state(theorem, "kani") {
            State::Current => "K".to_owned(),
            State::Stale => "K (stale)".to_owned(),
            State::Missing => "K (not run)".to_owned(),
            State::NotForKani => format!("not for Kani: {}", theorem.not_for_kani.unwrap_or_default()),
        };
        let _ = writeln!(list, "| {requirement} | {says} | [`{name}`]({file}) | E R {kani} |");
        let _ = writeln!(details, "* `{name}`");
        for engine in ENGINES {
            details += &seen(evidence, theorem, engine);
        }
    }
    end_unit(&mut list, &mut details);
    list
}

/// Below the table of a unit, folded: what each engine has seen.
fn end_unit(list: &mut String, details: &mut String) {
    if !details.is_empty() {
        let _ = write!(
            list,
            "\n<details><summary>What each engine has seen</summary>\n\n{details}\n</details>\n"
        );
        details.clear();
    }
}

/// What an engine has seen of a theorem: a line, or nothing where it cannot judge it.
fn seen(evidence: &Evidence, theorem: &Theorem, engine: &str) -> String {
    let state = evidence.state(theorem, engine);
    let stale = if state == State::Stale { "stale, " } else { "" };
    match evidence.of(theorem, engine) {
        _ if state == State::NotForKani => String::new(),
        None if engine == "kani" => format!("  * kani: not run, of {}\n", evidence.kani_scope(theorem)),
        None => format!("  * {engine}: not recorded\n"),
        Some(Shown { verdict, version, scope, cases, covers: [reached, covers], .. }) => {
            let cases = cases.map_or_else(String::new, |cases| format!(", {cases} cases"));
            format!(
                "  * {engine}: {stale}{verdict} by {version}{cases}, {reached} of {covers} covers: {scope}\n"
            )
        }
    }
}

/// What Kani has proved, group by group: a table for `proofs/README.md`.
#[must_use]
pub fn kani_table(evidence: &Evidence) -> String {
    let mut table =
        "| theorems of | judged | of these stale | not run | not for Kani | seconds | slowest |\n\
         |---|---:|---:|---:|---:|---:|---|\n"
            .to_owned();
    let mut groups: Vec<_> = theorems().map(group).collect();
    groups.dedup();
    for name in groups {
        let of_group = || theorems().filter(|theorem| group(theorem) == name);
        let count = |state| of_group().filter(|theorem| evidence.state(theorem, "kani") == state).count();
        let shown = || of_group().filter_map(|theorem| Some((theorem, evidence.of(theorem, "kani")?)));
        let seconds = shown().map(|(_, shown)| shown.seconds).fold(0.0, |sum, seconds| sum + seconds);
        let slowest = shown().max_by(|(_, a), (_, b)| a.seconds.total_cmp(&b.seconds));
        let slowest = slowest.map_or_else(String::new, |(theorem, shown)| {
            format!("`{}` {:.0} s", theorem.name, shown.seconds)
        });
        let _ = writeln!(
            table,
            "| `{name}` | {} | {} | {} | {} | {seconds:.0} | {slowest} |",
            count(State::Current) + count(State::Stale),
            count(State::Stale),
            count(State::Missing),
            count(State::NotForKani),
        );
    }
    table
}

/// The first part of a theorem's unit.
fn group(theorem: &Theorem) -> &'static str {
    theorem.unit().split("::").next().unwrap_or_default()
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
