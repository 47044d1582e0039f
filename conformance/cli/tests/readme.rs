//! What the README says holds: its commands run, its table is what they print, its pictures are what the program renders, its code
//! is tested, and its links lead somewhere.
#![cfg(unix)]

mod common;

use common::{room_arg, saarcor, stdout_of};
use image::{RgbImage, imageops};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// The commands in the README's blocks of no language, without their comments.
fn commands(readme: &str) -> Vec<&str> {
    let mut block = None;
    let mut commands = Vec::new();
    for line in readme.lines() {
        if let Some(language) = line.strip_prefix("```") {
            block = if block.is_none() { Some(language) } else { None };
        } else if block == Some("") {
            commands.push(line.split('#').next().unwrap_or_default().trim());
        }
    }
    commands
}

/// How a command of the README is run.
enum How {
    /// With these arguments more, which make it small; with this status.
    Here(&'static str, i32),
    /// Here, as if Kani were absent, since it would take minutes: it says so.
    WithoutKani,
    /// Elsewhere, because it takes minutes: this file has the second text.
    Elsewhere(&'static str, &'static str),
}

use How::{Elsewhere, Here, WithoutKani};

/// All of the README's commands, in its order.
const COMMANDS: &[(&str, How)] = &[
    ("cargo run --release -- reproduce --quick", Elsewhere(".ci/run", "cargo run -- reproduce --quick")),
    ("cargo test --workspace", Elsewhere(".ci/run", "cargo test --workspace\n")),
    ("saarcor prove", Here("hash --cases 100", 0)),
    ("saarcor prove set --engine kani", WithoutKani),
    ("saarcor conform new c my-cache", Here("", 0)),
    ("saarcor conform run my-cache", Here("", 0)),
    ("saarcor conform run my-cache/cache --level data", Here("", 0)),
    ("saarcor scenes", Here("", 0)),
    ("saarcor render path/to/scene.obj -o picture.png", Here("--resolution 64x48", 0)),
    ("saarcor walk pquake3 --frames 140..150", Here("--resolution 64x48", 0)),
    ("saarcor walk pquake3 --frames 140..150 --all --svg sizes.svg", Here("--resolution 64x48", 0)),
    ("saarcor simulate conference --frame 0 --variant b", Here("--resolution 64x48", 0)),
    ("saarcor simulate pquake3 --frames 0..40 --stride 10 --svg fps.svg", Here("--resolution 64x48", 0)),
    (
        "saarcor sweep conference --frame 0 --over line --over ways=1,4 -o rows.jsonl",
        Here("--resolution 64x48", 0),
    ),
    ("saarcor accuracy --quick", Here("--suite vertex", 0)),
    ("saarcor accuracy --suite exactly-one --edges owned --quick", Here("--kernel adaptive", 0)),
    // It makes an environment in Python from the network.
    (
        "saarcor crosscheck path/to/scene.obj",
        Elsewhere("conformance/cli/tests/crosscheck.rs", "\"crosscheck\""),
    ),
];

#[test]
fn every_command_runs() {
    let readme = read("README.md");
    assert_eq!(commands(&readme), COMMANDS.iter().map(|(command, _)| *command).collect::<Vec<_>>());
    let folder = tempfile::tempdir().expect("a folder");
    for (command, how) in COMMANDS {
        match how {
            Here(more, status) => {
                let line = format!("{command} {more}").replace("path/to/scene.obj", &room_arg());
                let args: Vec<_> = line.split_whitespace().skip(1).collect();
                let output = saarcor(&args).current_dir(folder.path()).output().expect("the binary starts");
                let stderr = String::from_utf8_lossy(&output.stderr);
                assert_eq!(output.status.code(), Some(*status), "{line}: {stderr}");
            }
            WithoutKani => {
                let args: Vec<_> = command.split_whitespace().skip(1).collect();
                let output = saarcor(&args).env("PATH", "").output().expect("the binary starts");
                let stdout = String::from_utf8_lossy(&output.stdout);
                assert_eq!(output.status.code(), Some(3), "{command}: {stdout}");
                assert!(stdout.contains("not run"), "{command}: {stdout}");
            }
            Elsewhere(file, text) => assert!(read(file).contains(text), "{command}: {file} does not run it"),
        }
    }
}

/// The JSON objects that a command prints, one a line.
fn rows(command: &str) -> Vec<Value> {
    let args: Vec<_> = command.split_whitespace().skip(1).chain(["--json"]).collect();
    stdout_of(&args).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

/// A value of the only row.
fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} is no number of {row}"))
}

/// Numbers with their digits, and commas between.
fn list(numbers: impl IntoIterator<Item = f64>, digits: usize) -> String {
    numbers.into_iter().map(|number| format!("{number:.digits$}")).collect::<Vec<_>>().join(", ")
}

/// The table of claims is what its commands print.
#[test]
fn claims_are_what_the_commands_print() {
    const MB: f64 = (1 << 20) as f64;
    let readme = read("README.md");
    let mut simulated = Vec::new();
    for variant in ["none", "a", "b"] {
        simulated.extend(rows(&format!("saarcor simulate pquake3 --frame 556 --variant {variant}")));
    }
    let all = |key: &str| simulated.iter().map(|row| number(row, key)).collect::<Vec<_>>();
    let (mem, pci) = (all("mem_bytes"), all("pci_bytes"));
    let walk = rows("saarcor walk pquake3 --frames 556..557");
    let cycles = ["conference-nl", "conference", "conference-8l"].map(|scene| {
        number(&rows(&format!("saarcor simulate {scene} --frame 400 --variant none"))[0], "cycles_a_ray")
    });
    let lines = rows("saarcor sweep pquake3 --frame 556 --over line=64,128,256,1024");
    let metadata = ["128", "1024"]
        .map(|line| number(&rows(&format!("saarcor metadata --line {line}"))[0], "metadata_bytes") / 1024.0);
    for (row, ours) in [
        ("metadata of 16 MB", format!("{} KB, {} KB", metadata[0], metadata[1])),
        ("virtual memory costs", list(all("fps"), 1)),
        ("little moves over the bus", list(pci[1..].iter().map(|bytes| bytes / MB), 2)),
        ("traffic of the on-board memory", list(mem.iter().map(|bytes| bytes / MB), 1)),
        ("each loaded line is written", list([(mem[1] - mem[0]) / pci[1]], 2)),
        ("the memory holds the working set", list([number(&walk[0], "working_set_bytes") / MB], 1)),
        ("speed is linear in rays", list(cycles, 1)),
        ("lines of 128 B are best", list(lines.iter().map(|row| number(row, "fps")), 1)),
    ] {
        let found = readme.lines().find(|line| line.starts_with(&format!("| {row}"))).expect(row);
        let cell = found.split(" | ").nth(2).expect("ours");
        assert!(cell.starts_with(&ours), "{row}: ours is {ours}, and the README says {cell}");
    }
}

/// Each picture is, on its left, what the program renders through 8 MiB, and, on its right, through flat memory.
#[test]
fn pictures_are_what_the_program_renders() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bytes = 0;
    for (scene, frame) in [("pquake3", "556"), ("conference", "400")] {
        let file = root().join(format!("model/pictures/{scene}.png"));
        bytes += fs::metadata(&file).expect("a picture").len();
        let both = image::open(file).expect("a picture").into_rgb8();
        let (width, height) = ((both.width() - 8) / 2, both.height());
        let resolution = format!("{width}x{height}");
        let render = |memory: &[&str]| -> RgbImage {
            let out = folder.path().join("picture.png");
            let out_arg = out.to_str().expect("text");
            let args = ["render", scene, "--frame", frame, "--resolution", &resolution, "-o", out_arg];
            stdout_of(&[&args[..], memory].concat());
            image::open(out).expect("a picture").into_rgb8()
        };
        let (left, right) = (render(&["--memory", "8MiB"]), render(&["--flat"]));
        assert!(left == right, "{scene}");
        assert!(imageops::crop_imm(&both, 0, 0, width, height).to_image() == left, "{scene}: left");
        assert!(imageops::crop_imm(&both, width + 8, 0, width, height).to_image() == right, "{scene}: right");
    }
    assert!(bytes < 300 << 10, "{bytes} bytes of pictures");
}

/// The example of the README is the one that the front page of `saarcor-model` runs.
#[test]
fn library_example_is_tested() {
    let readme = read("README.md");
    let shown =
        readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let page = read("model/spec/src/lib.rs");
    let tested = page.split("//! ```\n").nth(1).expect("an example");
    let tested: String = tested
        .lines()
        .map(|line| line.strip_prefix("//!").expect("a line of the page"))
        .map(|line| line.strip_prefix(' ').unwrap_or(line))
        .filter(|line| !line.starts_with("# "))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(shown, tested);
}

/// The text behind each `](` up to the `)`.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

#[test]
fn links_lead_somewhere() {
    for page in [
        "README.md",
        "CONTRIBUTING.md",
        "model/SPEC.md",
        "proofs/README.md",
        "reference/README.md",
        "scenes/README.md",
        "conformance/README.md",
        "conformance/PROTOCOL.md",
    ] {
        let text = read(page);
        let folder = root().join(page).parent().expect("a folder").to_owned();
        for link in links(&text).filter(|link| !link.starts_with("http")) {
            let (file, section) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { root().join(page) } else { folder.join(file) };
            assert!(target.exists(), "{page}: {link}");
            if !section.is_empty() {
                let text = fs::read_to_string(target).expect("a page");
                let anchor = |title: &str| -> String {
                    let kept = title.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
                    kept.collect::<String>().to_lowercase().replace(' ', "-")
                };
                let mut titles = text.lines().filter_map(|line| line.strip_prefix("##"));
                assert!(
                    titles.any(|title| anchor(title.trim_start_matches('#')) == section),
                    "{page}: {link}"
                );
            }
        }
    }
}

/// The last column of SPEC.md's tables of requirements names files of the specification.
#[test]
fn requirements_name_files_that_exist() {
    let specification = read("model/SPEC.md");
    let sources = root().join("model/spec/src");
    let mut named = 0;
    let rows = specification.lines().filter(|line| line.starts_with("| ") && line.ends_with("` |"));
    let has_id = |row: &&str| {
        let id = row.trim_start_matches("| ").split(" | ").next().and_then(|id| id.split_once('-'));
        id.is_some_and(|(_, number)| number.bytes().all(|digit| digit.is_ascii_digit()))
    };
    for row in rows.filter(has_id).filter(|row| row.matches(" | ").count() == 3) {
        let files = row.rsplit(" | ").next().expect("a column").trim_end_matches(" |");
        for file in files.split(", ").map(|file| file.trim_matches('`')) {
            let exists = sources.join(format!("{file}.rs")).exists() || sources.join(file).is_dir();
            assert!(exists, "{file}: {row}");
            named += 1;
        }
    }
    assert!(named > 70, "{named} files are named");
}

/// The examples that the README names are there.
#[test]
fn examples_exist() {
    let readme = read("README.md");
    let all: Vec<_> = ["model", "reference", "conformance"]
        .iter()
        .flat_map(|folder| fs::read_dir(root().join(folder)).expect("a folder"))
        .map(|entry| entry.expect("an entry").path().join("examples"))
        .collect();
    let names: Vec<_> =
        readme.split("--example ").skip(1).filter_map(|rest| rest.split('`').next()).collect();
    assert!(names.len() >= 4);
    for name in names {
        assert!(
            all.iter().any(|folder| folder.join(format!("{name}.rs")).exists()),
            "there is no example {name}"
        );
    }
}
