//! Output files: never in the place of an input, through links, with their modes and names, and nothing left behind
//! by signals.
#![cfg(unix)]

mod common;

use common::{RoomCopy, refusal, run, saarcor, saarcor_with_signals, stdout_of};
use saarcor_oracles::embree::REQUIREMENTS;
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, symlink};
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const SMALL: [&str; 2] = ["--resolution", "16x16"];

fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

/// A picture of the room at a path.
fn render<'a>(scene: &'a str, out: &'a str) -> Vec<&'a str> {
    [&["render", scene, "-o", out][..], &SMALL].concat()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn inputs_are_not_replaced() {
    let room = RoomCopy::new();
    let scene = room.scene();
    let (hard, soft) = (room.file("hard.out"), room.file("soft.out"));
    fs::hard_link(&scene, &hard).expect("a link");
    symlink("hard.out", &soft).expect("a link");
    let before = names(room.file(".").as_path());
    let bytes = |name: &str| fs::read(room.file(name)).expect("a file");
    let whole = ["room.obj", "room.mtl", "camera.csv", "lights.csv"].map(bytes);
    for out in [&hard, &soft] {
        for format in ["din", "csv"] {
            let record = ["trace", "record", &scene, "--frame", "0", "--format", format, "-o", text(out)];
            let args = [&record[..], &SMALL].concat();
            assert!(refusal(&run(&args), &args).contains("is an input"), "{args:?}");
        }
        let args = render(&scene, text(out));
        assert!(refusal(&run(&args), &args).contains("is an input"), "{args:?}");
        let args = [&["simulate", &scene, "--frame", "0", "-o", text(out)][..], &SMALL].concat();
        assert!(refusal(&run(&args), &args).contains("is an input"), "{args:?}");
    }
    // Their own names are refused by their endings alone.
    for name in ["room.obj", "room.mtl", "camera.csv"] {
        let file = room.file(name);
        let args = render(&scene, text(&file));
        refusal(&run(&args), &args);
    }
    assert_eq!(["room.obj", "room.mtl", "camera.csv", "lights.csv"].map(bytes), whole);
    assert_eq!(names(room.file(".").as_path()), before);
}

#[test]
fn parts_of_a_sweep_are_not_replaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let room = common::room_arg();
    let sweep = ["sweep", &room, "--frame", "0", "--resolution", "8x8", "--over", "ways=1,2"];
    for (name, shard) in [("a", "1/2"), ("b", "2/2")] {
        stdout_of(&[&sweep[..], &["--shard", shard, "-o", text(&file(name))]].concat());
    }
    let (a, b) = (file("a"), file("b"));
    let before = fs::read(&a).expect("a file");
    let args = ["merge", text(&a), text(&b), "-o", text(&a)];
    assert!(refusal(&run(&args), &args).contains("is an input"));
    assert_eq!(fs::read(&a).expect("a file"), before);
    // What is no sweep is not cut to what looks like one.
    let notes = file("notes");
    fs::write(&notes, "one line without an end").expect("written");
    let args = [&sweep[..], &["-o", text(&notes)]].concat();
    assert!(refusal(&run(&args), &args).contains("no result of such a run"));
    assert_eq!(fs::read_to_string(&notes).expect("text"), "one line without an end");
}

#[test]
fn links_are_written_through() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let room = common::room_arg();
    fs::create_dir(file("sub")).expect("a folder");
    symlink("sub/first.png", file("link.png")).expect("a link");
    symlink("link.png", file("further.png")).expect("a link");
    for name in ["link.png", "further.png"] {
        stdout_of(&render(&room, text(&file(name))));
        assert!(file(name).is_symlink() && file("sub/first.png").is_file(), "{name}");
    }
    symlink("no/such/folder.png", file("lost.png")).expect("a link");
    symlink("round.png", file("round.png")).expect("a link");
    for name in ["lost.png", "round.png"] {
        let path = file(name);
        let args = render(&room, text(&path));
        refusal(&run(&args), &args);
        assert!(path.is_symlink());
    }
}

#[test]
fn modes_and_names_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let (a, b) = (folder.path().join("a.png"), folder.path().join("b.png"));
    let room = common::room_arg();
    let mode = |path: &Path| fs::metadata(path).expect("a file").permissions().mode() & 0o777;
    fs::write(&a, "before, and longer than a picture".repeat(1000)).expect("written");
    fs::set_permissions(&a, fs::Permissions::from_mode(0o640)).expect("a mode");
    stdout_of(&render(&room, text(&a)));
    assert_eq!(mode(&a), 0o640);
    let picture = fs::read(&a).expect("a picture");
    fs::write(&a, "before, and longer than a picture".repeat(1000)).expect("written");
    fs::hard_link(&a, &b).expect("a link");
    stdout_of(&render(&room, text(&a)));
    assert_eq!((mode(&a), mode(&b), fs::read(&b).expect("a picture")), (0o640, 0o640, picture));
    assert_eq!(fs::metadata(&a).expect("a file").ino(), fs::metadata(&b).expect("a file").ino());
    assert_eq!(names(folder.path()), ["a.png", "b.png"]);
}

#[test]
fn dash_is_standard_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let room = common::room_arg();
    let out = |args: &[&str]| saarcor(args).current_dir(folder.path()).output().expect("it starts");
    assert!(out(&render(&room, "-")).stdout.starts_with(b"\x89PNG"));
    let record = [&["trace", "record", &room, "--frame", "0", "--format", "din"][..], &SMALL].concat();
    let dash = out(&[&record[..], &["-o", "-"]].concat());
    assert!(dash.status.success() && dash.stdout.starts_with(b"0 ") && dash.stdout == out(&record).stdout);
    for args in [
        [&render(&room, "-")[..], &["--json"]].concat(),
        [&["simulate", &room, "--frame", "0", "-o", "-"][..], &SMALL].concat(),
        vec!["conform", "run", "model", "--requests", "0", "--junit", "-"],
    ] {
        assert!(refusal(&out(&args), &args).contains("standard output"), "{args:?}");
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn names_of_other_formats_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let room = common::room_arg();
    for name in ["a.jpg", "a.JPEG", "a.webp", "a.csv", "a.html"] {
        let path = folder.path().join(name);
        let args = render(&room, text(&path));
        assert!(refusal(&run(&args), &args).contains("write .png"), "{name}");
    }
    let path = folder.path().join("a.xml");
    let args = ["conform", "run", "model", "--requests", "0", "--html", text(&path)];
    assert!(refusal(&run(&args), &args).contains("write .html"));
    for name in ["a.PNG", "picture", "a.2"] {
        stdout_of(&render(&room, text(&folder.path().join(name))));
    }
    assert_eq!(names(folder.path()), ["a.2", "a.PNG", "picture"]);
}

#[test]
fn signals_leave_nothing() {
    for (signal, number) in SIGNALS {
        let folder = tempfile::tempdir().expect("a folder");
        let room = common::room_arg();
        let record = ["trace", "record", &room, "--frame", "0", "--format", "din", "-o", "t.din"];
        let run = saarcor_with_signals(&[&record[..], &["--resolution", "16384x16384"]].concat());
        let bytes = |folder: &Path| {
            let entries = fs::read_dir(folder).expect("a folder").flatten();
            entries.map(|entry| entry.metadata().map_or(0, |found| found.len())).sum::<u64>()
        };
        leaves_nothing(run, folder.path(), (signal, number), |folder| bytes(folder) >= 100_000);
    }
}

/// An environment whose Python never answers.
#[test]
fn signals_leave_no_questions_to_embree() {
    let place = tempfile::tempdir().expect("a folder");
    let python =
        place.path().join(REQUIREMENTS.trim().replace("==", "-").replace('\n', "-")).join("bin/python");
    fs::create_dir_all(python.parent().expect("a folder")).expect("made");
    fs::write(&python, "#!/bin/sh\nexec sleep 3\n").expect("written");
    fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).expect("a program");
    for signal in SIGNALS {
        let folder = tempfile::tempdir().expect("a folder");
        let room = common::room_arg();
        let ask = ["crosscheck", &room, "--rays", "10", "--environment", text(place.path())];
        let mut run = saarcor_with_signals(&ask);
        run.env("TMPDIR", folder.path());
        leaves_nothing(run, folder.path(), signal, |folder| !names(folder).is_empty());
    }
}

const SIGNALS: [(&str, i32); 3] = [("INT", 2), ("TERM", 15), ("HUP", 1)];

/// Ends a run in `folder` by a signal as soon as it has `begun`: nothing is left there.
#[track_caller]
fn leaves_nothing(
    mut run: Command,
    folder: &Path,
    (signal, number): (&str, i32),
    begun: impl Fn(&Path) -> bool,
) {
    let mut child = run.current_dir(folder).spawn().expect("it starts");
    let began = Instant::now();
    while !begun(folder) {
        assert!(began.elapsed() < Duration::from_secs(120), "nothing is written");
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
    assert!(kill.expect("it starts").success());
    assert_eq!(child.wait().expect("a child").signal(), Some(number));
    assert_eq!(names(folder), Vec::<String>::new(), "{signal}");
}

#[test]
fn paths_need_not_be_text() {
    let room = RoomCopy::new();
    let name = |bytes: &[u8]| room.file(".").join(OsStr::from_bytes(bytes));
    let (scene, out) = (name(b"r\xff.obj"), name(b"p\xff.png"));
    fs::rename(room.scene(), &scene).expect("renamed");
    let mut run = saarcor(&["render"]);
    let output = run.arg(&scene).arg("-o").arg(&out).args(SMALL).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(fs::read(&out).expect("a picture").starts_with(b"\x89PNG"));
    let dut = name(b"d\xff");
    fs::create_dir(&dut).expect("a folder");
    fs::write(dut.join("dut.toml"), "kind = \"saarcor-vm\"\ncommand = 'exit 3'\n").expect("written");
    let mut run = saarcor(&["conform", "run"]);
    let output =
        run.arg(&dut).args(["--errors", "1"]).current_dir(room.file(".")).output().expect("it starts");
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));

    let suite = name(b"s\xff.txt");
    fs::write(&suite, "#: P-6 protocol An end.\nsaarcor-hash 1\nconfig sets=2 hash=low\nend\n")
        .expect("written");
    let output = saarcor(&["conform", "generate"]).arg(&suite).output().expect("it starts");
    assert!(output.stdout.starts_with(b"saarcor-hash 1\n"), "{}", String::from_utf8_lossy(&output.stderr));
    let mut run = saarcor(&["conform", "run"]);
    let output = run.arg(&dut).arg("--suite").arg(&suite).output().expect("it starts");
    let says = String::from_utf8_lossy(&output.stderr);
    assert!(says.contains("a suite of saarcor-hash"), "{says}");

    let budget = ["--budget", "1000000", "--cases", "10", "--kernel", "moller-trumbore", "--format", "f32"];
    let mut run = saarcor(&["accuracy"]);
    let output = run.args(budget).arg("--scene").arg(&scene).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn exports_need_no_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = saarcor(&["scenes", "export", "pquake3-nt", "-o", "x.obj"]);
    let output = run.current_dir(folder.path()).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["camera.csv", "lights.csv", "x.mtl", "x.obj"]);
}
