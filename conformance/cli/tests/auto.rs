//! `--auto`: the verbs take the triangle test that the scene needs, and say which.

mod common;

use common::{room_arg, stdout_of};
use std::process::Command;

/// What a run prints, and the triangle test that it says to have chosen.
fn chosen(args: &[&str]) -> (String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_saarcor")).args(args).output().expect("the binary starts");
    let stderr = String::from_utf8(output.stderr).expect("text");
    assert!(output.status.success(), "{args:?}: {stderr}");
    let said = stderr.lines().find_map(|line| line.strip_prefix("--auto: the triangle test "));
    let kernel = said.and_then(|said| said.split(' ').next()).expect("it says which").to_owned();
    (String::from_utf8(output.stdout).expect("text"), kernel)
}

/// Asserts that a run with `--auto` prints what it prints with the triangle test that it names.
fn does_as_it_says(args: &[&str], auto: &str) -> String {
    let (printed, kernel) = chosen(&[args, &[auto]].concat());
    assert_eq!(printed, stdout_of(&[args, &["--kernel", &kernel]].concat()), "{args:?} {auto}");
    kernel
}

#[test]
fn scene_decides_which_test_is_enough() {
    let room = room_arg();
    let walk = ["walk", &room, "--frames", "0..2", "--resolution", "64x48", "--json"];
    // Any test will do; half an ulp is what only the adaptive test keeps to.
    assert_eq!(does_as_it_says(&walk, "--auto=1000000"), "wald");
    assert_eq!(does_as_it_says(&walk, "--auto=0,0.5"), "adaptive");
    does_as_it_says(&["simulate", &room, "--frame", "1", "--resolution", "64x48", "--json"], "--auto");
}

#[test]
fn picture_is_that_of_the_test_that_was_chosen() {
    let (room, folder) = (room_arg(), tempfile::tempdir().expect("a folder"));
    let picture = |name: &str, more: &[&str]| {
        let file = folder.path().join(name);
        let render = ["render", &room, "--resolution", "64x48", "-o", file.to_str().expect("text")];
        stdout_of(&[&render, more].concat());
        std::fs::read(file).expect("a picture")
    };
    assert_eq!(picture("auto.png", &["--auto=1000000"]), picture("wald.png", &["--kernel", "wald"]));
}
