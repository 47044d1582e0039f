//! The lists of theorems in proofs/THEOREMS.md, README.md and SPEC.md are those of the code.

use saarcor_proofs::evidence::{ENGINES, Evidence, Shown, State};
use saarcor_proofs::lists::{kani_table, spec_list, theorem_list};
use saarcor_proofs::theorem::Theorem;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Once;

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

/// What Kani reads is Rust: it is compiled against a stub of Kani's library, and played, to see what Kani
/// draws of each theorem.
#[test]
fn kanis_side_compiles_and_its_scopes_are_listed() {
    let target = concat!(env!("CARGO_TARGET_TMPDIR"), "/kani_stub");
    let output = Command::new(env!("CARGO"))
        .args(["test", "--offline", "-p", "saarcor-proofs", "--lib", "--target-dir", target])
        .args(["--", "--nocapture", "scopes_of_kani"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("RUSTFLAGS", "--cfg kani --cfg kani_stub -D warnings")
        .output()
        .expect("cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    let scopes: Vec<_> = said.lines().filter_map(|line| line.strip_prefix("scope of ")).collect();
    let for_kani = saarcor_proofs::theorems().filter(|theorem| theorem.not_for_kani.is_none()).count();
    assert_eq!(scopes.len(), for_kani, "{said}");
    let current = fs::read_to_string(path("proofs/kani_scopes.txt")).unwrap_or_default();
    let new = scopes.join("\n") + "\n";
    assert_current("proofs/kani_scopes.txt", current == new, &new);
}

/// The evidence, once Kani's scopes are current in it.
fn evidence() -> Evidence {
    static SCOPES: Once = Once::new();
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        SCOPES.call_once(kanis_side_compiles_and_its_scopes_are_listed);
    }
    Evidence::read(&path("")).expect("the evidence")
}

/// Stale evidence fails nothing: the lists say it, and `saarcor prove --stale --record` renews it.
#[test]
fn stale_evidence_is_said() {
    let evidence = evidence();
    for engine in ENGINES {
        for (state, said) in [(State::Stale, "stale"), (State::Missing, "missing")] {
            let of_state = |theorem: &&Theorem| evidence.state(theorem, engine) == state;
            let names: Vec<_> =
                saarcor_proofs::theorems().filter(of_state).map(|theorem| theorem.name).collect();
            println!("{engine}: the evidence of {} theorems is {said}: {}", names.len(), names.join(" "));
        }
    }
    for theorem in saarcor_proofs::theorems() {
        // What is found to be wrong, or has no answer, is not kept as evidence.
        for engine in ENGINES {
            let shown =
                evidence.of(theorem, engine).filter(|_| evidence.state(theorem, engine) == State::Current);
            let verdict = shown.map_or("not run", |shown| &shown.verdict);
            assert!(shown.is_none_or(Shown::holds), "{} by {engine}: {verdict}", theorem.name);
        }
    }
}

/// A theorem rests on its own file and on the unit of which it speaks, and not on all that its files name.
#[test]
fn theorems_rest_on_what_they_speak_of() {
    let evidence = evidence();
    let named =
        |name: &str| saarcor_proofs::theorems().find(|theorem| theorem.name == name).expect("a theorem");
    let files = |name: &str| evidence.files(named(name));
    let texts = evidence.texts(named("hit_iff_resident"));
    for (text, counts) in [
        ("model/spec/src/vm/set.rs#impl Set", true),
        ("proofs/src/draw.rs#set_of", true),
        ("proofs/src/draw.rs#of_logarithms", false),
        ("proofs/src/vm/set.rs#most_recent_line_is_no_victim", false),
    ] {
        assert_eq!(texts.contains(text), counts, "{text}: {texts:#?}");
    }
    let hit = files("hit_iff_resident");
    for file in
        ["proofs/src/vm/set.rs", "proofs/src/draw.rs", "proofs/src/source.rs", "model/spec/src/vm/set.rs"]
    {
        assert!(hit.contains(file), "{hit:#?}");
    }
    for file in [
        "model/spec/src/vm/geometry.rs",
        "model/spec/src/vm/version_b.rs",
        "model/spec/src/time/sdram.rs",
        "proofs/src/vm/version_b.rs",
    ] {
        assert!(!hit.contains(file), "{hit:#?}");
    }
    let twin = files("fast_version_b_moves_the_same_granules");
    for file in ["model/fast/src/version_b.rs", "model/spec/src/vm/version_b.rs", "model/spec/src/vm/set.rs"]
    {
        assert!(twin.contains(file), "{twin:#?}");
    }
    for theorem in saarcor_proofs::theorems() {
        let files = evidence.files(theorem);
        assert!(files.contains(theorem.file), "{}", theorem.name);
        let of_model = files.iter().any(|file| file.starts_with("model/"));
        assert!(of_model, "{} rests on nothing of the model: {files:#?}", theorem.name);
    }
}

#[test]
fn the_page_of_theorems_is_generated() {
    let current = fs::read_to_string(path("proofs/THEOREMS.md")).unwrap_or_default();
    let list = theorem_list(&evidence());
    assert_current("proofs/THEOREMS.md", without_staleness(&current) == without_staleness(&list), &list);
}

/// A list without what it says of stale evidence: that alone does not make it old.
fn without_staleness(list: &str) -> String {
    let lines = list.lines().filter(|line| !line.starts_with("Kani's evidence: ")).map(|line| {
        let line = line.replace(" (stale)", "").replace(": stale, ", ": ");
        // A row of the table of what Kani has judged.
        let mut cells: Vec<_> = line.split(" | ").collect();
        if cells.len() == 7 {
            cells.remove(2);
        }
        cells.join(" | ")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Asserts that the part of `file` between these marks is the list that is generated.
fn assert_part_is_current(file: &str, [begin, end]: [&str; 2], list: &str) {
    let text = fs::read_to_string(path(file)).expect("the document");
    let (before, rest) = text.split_once(begin).expect("where the list begins");
    let (current, after) = rest.split_once(end).expect("where the list ends");
    let is_current = without_staleness(current) == without_staleness(list);
    assert_current(file, is_current, &format!("{before}{begin}{list}{end}{after}"));
}

#[test]
fn specification_names_the_theorems() {
    assert_part_is_current("model/SPEC.md", [BEGIN, END], &spec_list());
}

#[test]
fn the_table_of_what_kani_has_proved_is_generated() {
    let marks = ["<!-- kani -->\n", "<!-- end of kani -->"];
    assert_part_is_current("proofs/README.md", marks, &kani_table(&evidence()));
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
