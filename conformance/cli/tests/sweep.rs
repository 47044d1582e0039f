//! `saarcor sweep` and `saarcor merge`.

mod common;

use common::{RoomCopy, refusal_of, room_arg, saarcor, stdout_of};
use serde_json::Value;
use std::fs;
use std::path::Path;

const GRID: [&str; 4] = ["--over", "line=64,128,256", "--over", "ways=1,4"];

fn sweep(more: &[&str]) -> Vec<String> {
    let room = room_arg();
    let common =
        ["sweep", &room, "--frame", "1", "--resolution", "32x24", "--memory", "2KiB", "--warm-up", "0"];
    [&common, more].concat().into_iter().map(str::to_owned).collect()
}

fn output(more: &[&str]) -> String {
    let args = sweep(more);
    stdout_of(&args.iter().map(String::as_str).collect::<Vec<_>>())
}

fn refused(more: &[&str], parts: &[&str]) {
    let args = sweep(more);
    let line = refusal_of(&args.iter().map(String::as_str).collect::<Vec<_>>());
    parts.iter().for_each(|part| assert!(line.contains(part), "'{part}' is not in: {line}"));
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of text")
}

/// A point is what `simulate` says of its chip.
#[test]
fn points_are_simulations() {
    let out = output(&[&GRID[..], &["--json"]].concat());
    let rows: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(rows.len(), 6);
    for (point, row) in rows.iter().enumerate() {
        let (line, ways) = ([64, 128, 256][point / 2].to_string(), [1, 4][point % 2].to_string());
        assert_eq!((&row["point"], &row["points"]), (&point.into(), &6.into()));
        assert_eq!((&row["at"]["line"], &row["at"]["ways"]), (&line.clone().into(), &ways.clone().into()));
        assert_eq!(row["metadata_bytes"], 5 * 2048 / line.parse::<u64>().expect("a number"));
        let room = room_arg();
        let one = ["simulate", &room, "--frame", "1", "--resolution", "32x24", "--memory", "2KiB"];
        let more = ["--warm-up", "0", "--line", &line, "--ways", &ways, "--json"];
        let alone: Value = serde_json::from_str(&stdout_of(&[&one[..], &more].concat())).expect("JSON");
        for (field, value) in alone.as_object().expect("an object") {
            assert_eq!(&row[field], value, "{field} of {line}, {ways}");
        }
    }
}

#[test]
fn best_points_are_named() {
    let out = output(&["--over", "line=64,128,256,512"]);
    let lines: Vec<_> = out.lines().collect();
    let rows =
        lines.iter().filter(|line| line.trim_start().starts_with(|c: char| c.is_ascii_digit())).count();
    assert_eq!(rows, 4, "{out}");
    for best in ["most frames a second: line ", "fewest bytes loaded: line ", "least metadata: line 512"] {
        assert!(lines.iter().any(|line| line.starts_with(best)), "'{best}' is not in: {out}");
    }
}

/// Stopped anywhere, also within a line, a sweep ends with the bytes of one that was not.
#[test]
fn sizes_are_drawn_as_curves() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let (svg, again, results) = (file("line.svg"), file("again.svg"), file("line.jsonl"));
    output(&["--over", "line=64,256,128", "--svg", text(&svg), "-o", text(&results)]);
    let drawing = fs::read_to_string(&svg).expect("text");
    assert!(drawing.starts_with("<svg ") && drawing.contains("Their product is least at "));
    ["64", "128", "256", "metadata"]
        .iter()
        .for_each(|label| assert!(drawing.contains(&format!(">{label}<"))));
    stdout_of(&["merge", text(&results), "--svg", text(&again)]);
    assert_eq!(fs::read_to_string(again).expect("text"), drawing);

    let none = file("none.svg");
    refused(&["--over", "hash", "--svg", text(&none)], &["--svg", "hash low is no size"]);
    refused(&[&GRID[..], &["--svg", text(&none)]].concat(), &["--svg", "2 axes"]);
    assert!(!none.exists());
}

#[test]
fn stopped_sweeps_go_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("whole.jsonl");
    output(&[&GRID[..], &["-o", text(&file)]].concat());
    let whole = fs::read_to_string(&file).expect("results");
    assert_eq!(whole.lines().count(), 6);
    for stop in [0, 1, whole.find('\n').expect("a line"), whole.len() / 2, whole.len() - 1, whole.len()] {
        let part = folder.path().join("part.jsonl");
        fs::write(&part, &whole[..stop]).expect("written");
        output(&[&GRID[..], &["-o", text(&part), "--json"]].concat());
        assert_eq!(fs::read_to_string(&part).expect("results"), whole, "stopped after {stop} bytes");
    }
    // Killed while it works.
    let killed = folder.path().join("killed.jsonl");
    let args = sweep(&[&GRID[..], &["-o", text(&killed), "--threads", "1"]].concat());
    let mut child =
        saarcor(&args.iter().map(String::as_str).collect::<Vec<_>>()).spawn().expect("the binary starts");
    while !fs::metadata(&killed).is_ok_and(|file| file.len() > 0) {
        if child.try_wait().expect("a child").is_some() {
            break;
        }
        std::thread::yield_now();
    }
    let _ = child.kill();
    child.wait().expect("a child");
    output(&[&GRID[..], &["-o", text(&killed)]].concat());
    assert_eq!(fs::read_to_string(&killed).expect("results"), whole);
}

#[test]
fn parts_merge_to_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let (whole, merged) = (file("whole.jsonl"), file("merged.jsonl"));
    let all = output(&[&GRID[..], &["-o", text(&whole), "--csv", text(&file("whole.csv"))]].concat());
    for shard in ["1/2", "2/2"] {
        let part = file(&shard.replace('/', "of"));
        output(&[&GRID[..], &["-o", text(&part), "--shard", shard]].concat());
    }
    let (one, two) = (file("1of2"), file("2of2"));
    let csv = file("merged.csv");
    let args = ["merge", text(&two), text(&one), "-o", text(&merged), "--csv", text(&csv)];
    assert_eq!(stdout_of(&args), all);
    let read = |name: &str| fs::read_to_string(file(name)).expect("results");
    assert_eq!(read("merged.jsonl"), read("whole.jsonl"));
    assert_eq!(read("merged.csv"), read("whole.csv"));
    assert_eq!(read("merged.csv").lines().count(), 7);
    let line = refusal_of(&["merge", text(&one)]);
    assert!(line.contains("point 1 of 0 to 5"), "{line}");
}

#[test]
fn results_of_another_sweep_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("results.jsonl");
    output(&["--over", "ways=1,2", "-o", text(&file)]);
    let before = fs::read(&file).expect("results");
    refused(&["--over", "ways=1,4", "-o", text(&file)], &["line 1", "another run", "new file"]);
    refused(&["--over", "ways=1,2", "--pci", "66x64", "-o", text(&file)], &["another run"]);
    assert_eq!(fs::read(&file).expect("results"), before, "nothing is lost");
    fs::write(&file, "{}\n").expect("written");
    refused(&["--over", "ways=1,2", "-o", text(&file)], &["line 1", "no result"]);
}

#[test]
fn a_changed_scene_is_another_sweep() {
    let copy = RoomCopy::new();
    let (scene, file) = (copy.scene(), copy.file("results.jsonl"));
    let args =
        ["sweep", &scene, "--frame", "1", "--resolution", "8x8", "--over", "ways=1", "-o", text(&file)];
    let before = stdout_of(&args);
    assert_eq!(stdout_of(&args), before);
    copy.replace("room.obj", "v -2 0 -3", "v -2.5 0 -3");
    assert!(refusal_of(&args).contains("another run"));
    fs::remove_file(&file).expect("a file");
    stdout_of(&args);
    copy.replace("camera.csv", "1,0,1.25", "1,0.1,1.25");
    assert!(refusal_of(&args).contains("another run"));
}

#[test]
fn grids_that_cannot_be_are_refused() {
    refused(&["--over", "colour"], &["colour", "no such axis", "metadata-cache"]);
    refused(&["--over", "line=63"], &["line=63", "power of two", "64"]);
    refused(&["--over", "ways=3"], &["ways=3", "1, 2, 4, 8, 16"]);
    refused(&["--over", "ways=1,1"], &["ways", "twice"]);
    refused(&["--over", "threads=0"], &["threads=0", "1 to 64"]);
    refused(&["--over", "line=32"], &["line=32", "line of a first-level cache"]);
    let large =
        ["--over", "memory=4GiB", "--line", "64", "--over", "hash", "--over", "policy", "--over", "pci"];
    refused(&[&large[..], &["--threads", "1024"]].concat(), &["of 18 points", "GiB", "--threads"]);
    refused(&["--over", "ways", "--shard", "3/2"], &["3/2", "I/N"]);
    refused(&["--over", "ways", "-o", "/dev/full"], &["/dev/full", "no plain file"]);
    refused(&["--over", "ways", "-o", "no/such/folder"], &["no/such/folder", "cannot be written"]);
    let line = refusal_of(&["merge", "no-such-file"]);
    assert!(line.contains("no-such-file"), "{line}");
}
