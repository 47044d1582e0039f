//! The theorems find the faults that implementers make: each of `faults.toml` is planted into a copy
//! of the model, and its theorem has to fail on both engines, and its property test where it names one.
//!
//! A copy has no more than the model and the proofs, and of the theorems only the fault's own is
//! judged: so most of the time goes into building the model and the theorems anew, once for each fault.
//! With `SAARCOR_UNIQUE` set, all theorems that rest on the faulty file are judged where no other may find
//! the fault. Two copies take turns at the faults.

use saarcor_proofs::evidence::Evidence;
use saarcor_proofs::theorem::Theorem;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
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
    /// The theorem that has to find it.
    #[serde(default)]
    theorem: String,
    /// A property test, `file::name`, that has to find it: in the theorem's place where it shows at sizes that no theorem has, or
    /// beside it.
    #[serde(default)]
    test: String,
    /// `spec` or `fast`.
    #[serde(rename = "crate")]
    package: String,
    file: String,
    from: String,
    to: String,
    /// Whether no other theorem finds it.
    #[serde(default)]
    unique: bool,
}

impl Fault {
    /// Its file, from the root of a workspace on.
    fn path(&self) -> PathBuf {
        Path::new("model").join(&self.package).join("src").join(&self.file)
    }

    /// The file with the fault in it.
    fn planted(&self) -> String {
        let source = fs::read_to_string(workspace().join(self.path())).expect("a file of the model");
        let places = source.matches(&self.from).count();
        assert_eq!(places, 1, "{}: the line to replace is there once", self.name);
        source.replace(&self.from, &self.to)
    }
}

fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

fn faults() -> Vec<Fault> {
    let text = fs::read_to_string(workspace().join("proofs/faults.toml")).expect("the list of faults");
    toml::from_str::<Faults>(&text).expect("a list of faults").fault
}

#[test]
fn every_fault_has_its_line_and_its_theorem() {
    let faults = faults();
    let theorems: BTreeSet<_> = saarcor_proofs::theorems().map(|theorem| theorem.name).collect();
    for fault in &faults {
        assert!(fault.planted().contains(&fault.to), "{}", fault.name);
        if !fault.theorem.is_empty() || fault.test.is_empty() {
            assert!(theorems.contains(&*fault.theorem), "{}: no theorem {}", fault.name, fault.theorem);
        }
        let Some((file, test)) = fault.test.split_once("::") else { continue };
        let tests =
            fs::read_to_string(workspace().join(format!("proofs/tests/{file}.rs"))).unwrap_or_default();
        let is_there =
            tests.split("#[test]").any(|tests| tests.trim_start().starts_with(&format!("fn {test}(")));
        assert!(is_there, "{}: no test {}", fault.name, fault.test);
    }
    let of_owned_edges =
        faults.iter().filter(|fault| fault.test.starts_with("exactly_one::") && !fault.theorem.is_empty());
    assert!(of_owned_edges.count() >= 10, "faults in the rule that a theorem and the suite find");
    let of_twins = faults.iter().filter(|fault| fault.package == "fast").count();
    assert!(faults.len() >= 40 && of_twins >= 15, "{} faults, {of_twins} of twins", faults.len());
}

/// The faults of the twins are found by theorems of equality.
#[test]
fn twins_are_held_to_their_specification() {
    for fault in faults().iter().filter(|fault| fault.package == "fast" && !fault.theorem.is_empty()) {
        let theorem = saarcor_proofs::theorems().find(|theorem| theorem.name == fault.theorem);
        let unit = theorem.map_or("", |theorem| theorem.unit());
        assert!(unit.starts_with("equal"), "{}: {} is of {unit}", fault.name, fault.theorem);
    }
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

/// A workspace of the model and the proofs, apart from this one.
fn copied_workspace(name: &str, with_oracles: bool) -> PathBuf {
    let copied = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let manifest = |of: &str| fs::read_to_string(workspace().join(of)).expect("a manifest");
    for folder in [".cargo", "model", "proofs", "reference/oracles", "reference/random"] {
        let _ = fs::remove_dir_all(copied.join(folder));
        copy(&workspace().join(folder), &copied.join(folder));
    }
    // Without what other tests need.
    let proofs = manifest("proofs/Cargo.toml");
    let (before, rest) = proofs.split_once("[target.'cfg(not(kani))'.dev-dependencies]").expect("its place");
    let (_, after) = rest.split_once("\n[lints]").expect("its end");
    let oracles = if with_oracles { "[dev-dependencies]\nsaarcor-oracles.workspace = true\n" } else { "" };
    fs::write(copied.join("proofs/Cargo.toml"), format!("{before}{oracles}\n[lints]{after}"))
        .expect("a manifest");
    let members = if with_oracles || before.contains("saarcor-oracles") {
        r#"members = ["model/spec", "model/fast", "proofs", "reference/oracles", "reference/random"]"#
    } else {
        r#"members = ["model/spec", "model/fast", "proofs"]"#
    };
    let root = manifest("Cargo.toml");
    let (root, rest) = root.split_once("members = [").expect("its members");
    let (_, rest) = rest.split_once("[workspace.package]").expect("its packages");
    // Profiles are of no use here, and name packages that are not copied.
    let rest = rest.split_once("\n[profile").map_or(rest, |(rest, _)| rest);
    let profile = "[profile.dev]\nopt-level = 1\ndebug = false\n";
    let root = format!("{root}{members}\n\n[workspace.package]{rest}\n{profile}");
    fs::write(copied.join("Cargo.toml"), root).expect("a manifest");
    fs::copy(workspace().join("Cargo.lock"), copied.join("Cargo.lock")).expect("a lock file");
    copied
}

const ENGINES: [&str; 2] = ["exhaustive", "random"];

/// What both engines say of these theorems of the copy.
fn said_of(copied: &Path, theorems: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(copied);
    command.args(["test", "--offline", "-p", "saarcor-proofs", "--test", "theorems", "--"]);
    command.args(ENGINES.map(|engine| format!("{engine}::")));
    command.env("CARGO_TARGET_DIR", copied.join("target"));
    command.env("SAARCOR_THEOREM", theorems.join(","));
    // It is asked which ones fail, and not for the smallest case of each.
    command.env("PROPTEST_MAX_SHRINK_ITERS", "20");
    let output = command.output().expect("cargo");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !text.contains("test result: ") {
        // A fault that does not compile is none that a theorem has found.
        panic!("{theorems:?} were not judged: {text}\n{}", String::from_utf8_lossy(&output.stderr));
    }
    text
}

/// What each engine says against a theorem: nothing, or the case for which it fails.
fn said_against(text: &str, theorem: &str) -> [Option<String>; 2] {
    ENGINES.map(|engine| {
        let mut failures = text.split("\n---- ").filter(|failure| failure.starts_with(engine));
        let claims: String = failures
            .by_ref()
            .filter_map(|said| said.split_once("do not hold:\n"))
            .map(|(_, claims)| claims)
            .collect();
        let fails = claims.lines().any(|line| line.starts_with(&format!("{theorem} (")));
        fails.then(|| {
            let lines: Vec<_> = claims.lines().take_while(|line| !line.starts_with("note:")).collect();
            lines.join("\n")
        })
    })
}

/// The theorems that may find a fault and say what is wrong, as far as they rest on its file: its own, and
/// all others but those of something larger. A fault of the specification makes it differ from its twin too,
/// and their equality does not say which of the two is wrong; nor does the equality of whole chips, or of
/// whole intersection units, say which part differs.
fn resting_on(evidence: &Evidence, fault: &Fault) -> Vec<&'static str> {
    let file = fault.path().to_string_lossy().into_owned();
    let is_of_something_larger = |theorem: &Theorem| match theorem.unit() {
        unit if fault.package == "spec" => unit.starts_with("equal"),
        "equal::chip" => !fault.file.starts_with("chip"),
        "equal::adaptive" => theorem.name.contains("unit") && fault.file != "adaptive/unit.rs",
        _ => false,
    };
    let may_find = |theorem: &&Theorem| {
        theorem.name == fault.theorem
            || (evidence.files(theorem).contains(&file) && !is_of_something_larger(theorem))
    };
    saarcor_proofs::theorems().filter(may_find).map(|theorem| theorem.name).collect()
}

/// Those of the theorems that failed.
fn failing<'a>(text: &str, theorems: &[&'a str]) -> Vec<&'a str> {
    let fails = |name: &&&str| text.lines().any(|line| line.starts_with(&format!("{name} (")));
    theorems.iter().filter(fails).copied().collect()
}

/// Does that with the fault in the copy.
fn with_fault<T>(copied: &Path, fault: &Fault, of: impl FnOnce(&Path) -> T) -> T {
    let file = copied.join(fault.path());
    let sound = fs::read_to_string(&file).expect("a file of the model");
    fs::write(&file, fault.planted()).expect("a planted fault");
    let result = of(copied);
    fs::write(&file, sound).expect("the sound file again");
    result
}

/// What a property test says in the copy: nothing, or where it fails.
fn judge_by_test(copied: &Path, test: &str) -> Option<String> {
    let (file, name) = test.split_once("::").expect("a file and a test");
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(copied).env("CARGO_TARGET_DIR", copied.join("target"));
    command.args(["test", "--offline", "-p", "saarcor-proofs", "--test", file, "--", "--exact", name]);
    let output = command.output().expect("cargo");
    let text = String::from_utf8_lossy(&output.stdout);
    let judged = text.contains("running 1 test");
    assert!(judged, "{test} was not judged: {}", String::from_utf8_lossy(&output.stderr));
    let said = text.split_once(" stdout ----\n")?.1;
    Some(said.trim_start().lines().take(4).collect::<Vec<_>>().join("\n"))
}

/// All faults; with `SAARCOR_FAULTS` set, those alone whose crate, theorem or name has that text, or one of
/// several with commas between them; of these, with `SAARCOR_FAULTS_PART=K/N` set, each `N`th from the `K`th on.
fn asked() -> Vec<Fault> {
    let asked = std::env::var("SAARCOR_FAULTS").unwrap_or_default();
    let mut faults = faults();
    faults.retain(|fault| {
        let texts = [&fault.package, &fault.theorem, &fault.test, &fault.name];
        asked.split(',').any(|asked| texts.iter().any(|text| text.contains(asked)))
    });
    let (first, step) = part();
    faults.into_iter().skip(first).step_by(step).collect()
}

/// The part of the faults that is asked for: all, if `SAARCOR_FAULTS_PART` is not set.
fn part() -> (usize, usize) {
    let Ok(part) = std::env::var("SAARCOR_FAULTS_PART") else { return (0, 1) };
    let part = part.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    part.filter(|&(k, n): &(usize, usize)| k < n).expect("SAARCOR_FAULTS_PART: K/N, K below N")
}

/// Plants every other fault, from the `first` on.
fn faults_are_found(first: usize) {
    let asked = asked();
    let with_oracles = asked.iter().any(|fault| !fault.test.is_empty());
    let copied = copied_workspace(&format!("faults_{first}"), with_oracles);
    let evidence = Evidence::read(workspace()).expect("the evidence");
    let all = std::env::var_os("SAARCOR_UNIQUE").is_some();
    let mut missed = Vec::new();
    for fault in asked.iter().skip(first).step_by(2) {
        let start = std::time::Instant::now();
        if !fault.test.is_empty() {
            match with_fault(&copied, fault, |copied| judge_by_test(copied, &fault.test)) {
                Some(said) => println!("{} | {:.1} s\n{said}\n", fault.name, start.elapsed().as_secs_f64()),
                None => missed.push(format!("not found: {} ({})", fault.name, fault.test)),
            }
        }
        if fault.theorem.is_empty() {
            continue;
        }
        let theorem = &*fault.theorem;
        let judged = if fault.unique && all { resting_on(&evidence, fault) } else { vec![theorem] };
        let text = with_fault(&copied, fault, |copied| said_of(copied, &judged));
        for (engine, said) in ENGINES.iter().zip(said_against(&text, theorem)) {
            match said {
                Some(said) => {
                    println!("{} | {engine} | {:.1} s\n{said}\n", fault.name, start.elapsed().as_secs_f64())
                }
                None => missed.push(format!("not found: {} ({theorem}, {engine})", fault.name)),
            }
        }
        let others = failing(&text, &judged).into_iter().filter(|name| *name != theorem);
        missed.extend(others.map(|name| format!("not unique: {} is found by {name} too", fault.name)));
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
#[ignore = "builds the model once for each fault: minutes"]
fn every_other_fault_is_found_by_both_engines() {
    faults_are_found(0);
}

#[test]
#[ignore = "builds the model once for each fault: minutes"]
fn the_others_are_found_by_both_engines() {
    faults_are_found(1);
}

/// Which theorems find which fault: a line for each into the file that `SAARCOR_MATRIX` names, its name
/// and the theorems that fail. A run that was cut off goes on with the faults that have no line yet; parts
/// (`SAARCOR_FAULTS_PART`) may run side by side.
#[test]
#[ignore = "builds the model and judges all theorems once for each fault: hours"]
fn the_matrix_of_faults_and_theorems() {
    let Some(path) = std::env::var_os("SAARCOR_MATRIX") else {
        println!("no file to write: SAARCOR_MATRIX=FILE names it");
        return;
    };
    let known = fs::read_to_string(&path).unwrap_or_default();
    let is_known = |fault: &&Fault| known.lines().any(|line| line.split('\t').next() == Some(&*fault.name));
    let mut file = fs::OpenOptions::new().create(true).append(true).open(&path).expect("the matrix");
    let copied = copied_workspace(&format!("faults_matrix_{}", part().0), false);
    let evidence = Evidence::read(workspace()).expect("the evidence");
    for fault in asked().iter().filter(|fault| !fault.theorem.is_empty() && !is_known(fault)) {
        let judged = resting_on(&evidence, fault);
        let text = with_fault(&copied, fault, |copied| said_of(copied, &judged));
        let names = failing(&text, &judged).join(" ");
        writeln!(file, "{}\t{}\t{names}", fault.name, fault.theorem).expect("the matrix");
    }
}
