//! `saarcor crosscheck`: where there is no Embree, and with Embree on the real scenes.

mod common;

use common::{refusal_of, room_arg, run, saarcor, stdout_of};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Output;

/// The one line of a run that cannot be completed: status 3, nothing on standard output.
#[track_caller]
fn incomplete(output: &Output) -> String {
    let stderr = String::from_utf8(output.stderr.clone()).expect("text");
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(output.stdout.is_empty());
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert!(stderr.starts_with("saarcor: Embree: "), "{stderr}");
    stderr
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of text")
}

#[test]
fn without_python_it_is_incomplete_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let environment = folder.path().join("new/environments");
    let room = room_arg();
    let mut command = saarcor(&["crosscheck", &room, "--environment", text(&environment)]);
    let line = incomplete(&command.env("SAARCOR_PYTHON", "/no/such/python").output().expect("runs"));
    assert!(line.contains("/no/such/python") && line.contains("SAARCOR_PYTHON"), "{line}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 0);
}

#[test]
fn bad_rays_are_refused_before_anything_is_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let (rays, environment) = (folder.path().join("rays"), folder.path().join("environments"));
    std::fs::write(&rays, "tie aimed 0 0 0\n").expect("written");
    let room = room_arg();
    let args = ["crosscheck", &room, "--environment", text(&environment), "--replay"];
    let line = refusal_of(&[&args[..], &[text(&rays)]].concat());
    assert!(line.contains("rays:1: 3 numbers"), "{line}");
    let line = refusal_of(&[&args[..], &[text(&folder.path().join("none"))]].concat());
    assert!(line.contains("none: cannot be read"), "{line}");
    assert!(!environment.exists());
    refusal_of(&["crosscheck", &room, "--rays", "0"]);
}

#[test]
fn a_bad_scene_is_refused_also_without_python() {
    let args = ["crosscheck", "no/such/scene.obj", "--environment", "no/such/environments"];
    let output = saarcor(&args).env("SAARCOR_PYTHON", "/no/such/python").output().expect("runs");
    let stderr = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("no/such/scene.obj"), "{stderr}");
}

/// What is asked of the JSON object.
#[derive(Debug, Deserialize)]
struct Report {
    scene: String,
    kernel: String,
    rays: u64,
    agree: u64,
    tie: u64,
    edge: u64,
    within_bound: u64,
    embree_wrong: u64,
    model_wrong: u64,
    searched: u64,
    embree_robust: Faults,
    embree_fast: Faults,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct Faults {
    wrong_hit: u64,
    wrong_miss: u64,
    wrong_triangle: u64,
}

impl Faults {
    fn all(self) -> u64 {
        self.wrong_hit + self.wrong_miss + self.wrong_triangle
    }
}

/// Where the Python environment is for all tests of this file: one is made, the others find it.
fn environment() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("embree")
}

#[test]
#[ignore = "runs Python, which tries to reach a network"]
fn without_network_it_is_incomplete_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let room = room_arg();
    let mut command = saarcor(&["crosscheck", &room, "--environment", text(&folder.path().join("new"))]);
    // Nobody listens there.
    command.envs([("PIP_INDEX_URL", "http://127.0.0.1:9/simple"), ("PIP_NO_CACHE_DIR", "1")]);
    let line = incomplete(&command.output().expect("runs"));
    assert!(line.contains("its packages cannot be installed") && line.contains("embreex"), "{line}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 0);
}

/// A small sample of each scene. The verb's own run with a million rays is `--rays 1000000`.
#[test]
#[ignore = "needs the real scenes (SAARCOR_SCENES names their folder), Python and, once, a network"]
fn real_crosscheck_finds_the_model_right_and_keeps_what_differs() {
    let folder = PathBuf::from(std::env::var_os("SAARCOR_SCENES").expect("SAARCOR_SCENES names a folder"));
    let kept = tempfile::tempdir().expect("a folder");
    let environment = environment();
    for name in ["oa_dm3", "conference", "conference_raw", "office", "sponza"] {
        let scene = folder.join(name).join(name).with_extension("obj");
        let rays = kept.path().join(name);
        let always = ["crosscheck", text(&scene), "--environment", text(&environment), "--json"];
        let out = ["--rays", "20000", "--out", text(&rays)];
        let json = stdout_of(&[&always[..], &out].concat());
        let report: Report = serde_json::from_str(&json).expect("one object");
        println!("{report:?}");
        assert_eq!((report.model_wrong, report.rays, &report.kernel[..]), (0, 20_000, "adaptive"));
        assert_eq!(report.scene, text(&scene));
        let classes = [report.agree, report.tie, report.edge, report.within_bound, report.embree_wrong];
        assert_eq!(classes.iter().sum::<u64>(), report.rays);
        assert!(report.searched > 300 && report.agree * 2 > report.rays);
        assert!(report.embree_wrong <= report.embree_robust.all() + report.embree_fast.all());

        let replay = stdout_of(&[&always[..], &["--replay", text(&rays)]].concat());
        let lines: Vec<_> = replay.lines().collect();
        let again: Report = serde_json::from_str(lines.last().expect("a line")).expect("an object");
        let most = |count: u64| count.min(1000);
        assert_eq!((again.agree, again.rays as usize), (0, lines.len() - 1));
        let expected = [report.tie, report.edge, report.within_bound, report.embree_wrong].map(most);
        assert_eq!([again.tie, again.edge, again.within_bound, again.embree_wrong], expected);
    }
}

/// A test that is not exact is off somewhere, and the judge sees it.
#[test]
#[ignore = "needs the real scenes (SAARCOR_SCENES names their folder), Python and, once, a network"]
fn real_crosscheck_sees_that_moller_trumbore_is_wrong() {
    let folder = PathBuf::from(std::env::var_os("SAARCOR_SCENES").expect("SAARCOR_SCENES names a folder"));
    let scene = folder.join("sponza/sponza.obj");
    let environment = environment();
    let args = ["crosscheck", text(&scene), "--environment", text(&environment), "--json"];
    let output = run(&[&args[..], &["--kernel", "moller-trumbore", "--rays", "100000"]].concat());
    let report: Report = serde_json::from_slice(&output.stdout).expect("one object");
    println!("{report:?}");
    assert_eq!(output.status.code(), Some(1));
    assert!(report.model_wrong > 0);
}
