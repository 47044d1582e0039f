//! `saarcor simulate --frames`.

mod common;

use common::{refusal_of, room_arg, stdout_of};
use serde_json::Value;

/// The room's three frames, in a picture that takes a moment.
fn frames(more: &[&str]) -> String {
    let room = room_arg();
    stdout_of(&[&["simulate", &room, "--frames", "..", "--resolution", "64x48"], more].concat())
}

fn rows(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

/// A row without where it stands.
fn row(mut of: Value) -> Value {
    let fields = of.as_object_mut().expect("an object");
    ["sweep", "point", "points"].iter().for_each(|key| drop(fields.remove(*key).expect(key)));
    of
}

#[test]
fn each_frame_is_that_of_its_own_run() {
    let room = room_arg();
    for more in [
        &[][..],
        &["--variant", "b", "--memory", "2KiB", "--line", "64"],
        &["--warm-up", "walk"],
        &["--warm-up", "2"],
    ] {
        let all = rows(&frames(&[more, &["--json"]].concat()));
        assert_eq!(all.len(), 3);
        for (frame, one) in all.into_iter().enumerate() {
            let number = frame.to_string();
            let args = ["simulate", &room, "--frame", &number, "--resolution", "64x48", "--json"];
            let alone: Value = serde_json::from_str(&stdout_of(&[&args[..], more].concat())).expect("JSON");
            assert_eq!(row(one), alone, "{more:?}");
        }
    }
    let every_other = rows(&frames(&["--stride", "2", "--json"]));
    let numbers: Vec<_> = every_other.iter().map(|row| row["frame"].as_u64()).collect();
    assert_eq!(numbers, [Some(0), Some(2)]);
}

#[test]
fn results_do_not_depend_on_threads() {
    for more in [&["--json"][..], &["--json", "--warm-up", "walk"]] {
        let run = |threads| frames(&[more, &["--threads", threads]].concat());
        assert_eq!(run("1"), run("3"));
    }
}

#[test]
fn a_walk_goes_on_where_it_was_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("rows.jsonl");
    let path = file.to_str().expect("text");
    let whole = frames(&["--json", "-o", path]);
    assert_eq!(std::fs::read_to_string(&file).expect("rows"), whole);
    let first = &whole[..whole.find('\n').expect("a line") + 20];
    std::fs::write(&file, first).expect("cut off");
    assert_eq!(frames(&["--json", "-o", path]), whole);
    assert_eq!(std::fs::read_to_string(&file).expect("rows"), whole);
    let room = room_arg();
    let args = ["simulate", &room, "--frames", "..", "--resolution", "32x24", "-o", path];
    assert!(refusal_of(&args).contains("another run"));
}

#[test]
fn walks_are_drawn_and_summed() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("fps.svg");
    let text = frames(&["--svg", file.to_str().expect("text")]);
    let all = rows(&frames(&["--json"]));
    let cycles: u64 = all.iter().map(|row| row["cycles"].as_u64().expect("a number")).sum();
    assert!(text.contains("all 3 frames:") && text.contains(&format!("cycles: {cycles}\n")), "{text}");
    let drawing = std::fs::read_to_string(&file).expect("a drawing");
    assert!(drawing.contains("frames a second") && drawing.starts_with("<svg"));
}

#[test]
fn what_makes_no_walk_is_refused() {
    let room = room_arg();
    let refused = |more: &[&str], why: &[&str]| {
        let text = refusal_of(&[&["simulate", &room], more].concat());
        assert!(why.iter().all(|why| text.contains(why)), "{more:?}: {text}");
    };
    refused(&["--frames", "0..2", "--frame", "1"], &["--frame"]);
    refused(&["--frames", "0..9"], &["frame 8", "0 to 2"]);
    refused(&["--frames", "..", "--stride", "0"], &["--stride"]);
    refused(&["--frame", "0", "--stride", "2"], &["--stride", "--frame"]);
    refused(&["--frames", "..", "--check-bytes"], &["--check-bytes"]);
    refused(&["--frames", "..", "-o", "rows.png"], &["jsonl"]);
    refused(&["--frames", "..", "--warm-up", "17"], &["--warm-up", "at most 16"]);
}
