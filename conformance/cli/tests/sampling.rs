//! `saarcor simulate --frames` with `--sample` and `--error`, and `saarcor accuracy --simulator`.

mod common;

use common::{refusal_of, room_arg, stdout_of};
use serde_json::Value;

/// 40 frames of a level, in a picture that takes a moment.
const WALK: [&str; 8] =
    ["simulate", "pquake3-nlnt", "--frames", "140..300", "--stride", "4", "--resolution", "192x144"];

const QUANTITIES: [&str; 4] = ["cycles", "fps", "mem_bytes", "pci_bytes"];

/// The frames' rows, and the sum's.
fn walk(more: &[&str]) -> (Vec<Value>, Value) {
    let out = stdout_of(&[&WALK[..], &["--json"], more].concat());
    let mut rows: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let sum = rows.pop().expect("a row");
    (rows, sum)
}

fn all(more: &[&str]) -> Vec<Value> {
    let out = stdout_of(&[&WALK[..], &["--json"], more].concat());
    out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

/// A number is there if its interval is at most half as wide, and else a word.
#[track_caller]
fn is_number_or_word(row: &Value) {
    let not_known = row["not_known_from_this_sample"].as_array().cloned().unwrap_or_default();
    for key in QUANTITIES {
        match row[key].as_f64() {
            Some(value) => {
                let [low, high] = [0, 1].map(|end| row["interval"][key][end].as_f64().expect("an end"));
                assert!(low <= value && value <= high && high - low <= value / 2.0 + 2.0, "{key}: {row}");
                assert!(!not_known.contains(&key.into()));
            }
            None => {
                assert!(row["interval"][key].is_null() && not_known.contains(&key.into()), "{key}: {row}")
            }
        }
    }
}

#[test]
fn some_frames_run_and_the_others_are_estimated() {
    for variant in ["none", "b"] {
        let full = all(&["--variant", variant]);
        let (rows, sum) = walk(&["--variant", variant, "--sample", "1/4"]);
        assert_eq!((rows.len(), &sum["frames"], &sum["simulated"]), (40, &40.into(), &10.into()));
        assert!(rows.iter().filter(|row| row["estimated"] == false).count() == 10);
        for (row, full) in rows.iter().zip(&full) {
            is_number_or_word(row);
            let keys = ["scene", "frame", "variant"];
            keys.iter().for_each(|key| assert_eq!(row[key], full[key], "{key}"));
            if row["estimated"] == false {
                let fields = full.as_object().expect("an object").iter();
                let fields = fields.filter(|(key, _)| !["sweep", "point", "points"].contains(&key.as_str()));
                fields.for_each(|(key, value)| assert_eq!(&row[key], value, "{key}"));
            }
        }
        is_number_or_word(&sum);
        let truth: u64 = full.iter().map(|row| row["cycles"].as_u64().expect("a number")).sum();
        let [low, high] = [0, 1].map(|end| sum["interval"]["cycles"][end].as_u64().expect("an end"));
        assert!(low <= truth && truth <= high, "{truth}: {sum}");
        let fps = sum["fps"].as_f64().expect("a number");
        assert!((fps * sum["cycles"].as_f64().expect("a number") / (40.0 * 533e6) - 1.0).abs() < 1e-6);
        if variant == "none" {
            assert_eq!((&sum["pci_bytes"], &sum["interval"]["pci_bytes"]), (&0.into(), &vec![0, 0].into()));
        }
    }
}

#[test]
fn whole_walk_is_exact() {
    let (rows, sum) = walk(&["--sample", "1"]);
    for (row, full) in rows.iter().zip(all(&[])) {
        assert_eq!((&row["cycles"], &row["estimated"]), (&full["cycles"], &false.into()));
    }
    assert_eq!(sum["estimated"], false);
    assert_eq!(sum["interval"]["cycles"][0], sum["interval"]["cycles"][1]);
}

#[test]
fn frames_are_added_until_the_interval_is_narrow() {
    let simulated = |bound: f64| {
        let text = format!("{bound}%");
        let (_, sum) = walk(&["--error", &text]);
        let [low, high] = [0, 1].map(|end| sum["interval"]["cycles"][end].as_f64().expect("an end"));
        let half = (high - low) / 2.0 / sum["cycles"].as_f64().expect("a number");
        assert!(100.0 * half <= bound + 0.01, "{bound}: {half}");
        sum["simulated"].as_u64().expect("a number")
    };
    let (wide, narrow) = (simulated(50.0), simulated(0.2));
    assert!(wide == 12 && narrow > wide, "{wide} {narrow}");
}

#[test]
fn estimates_do_not_depend_on_threads_but_on_the_seed() {
    let run = |more: &[&str]| stdout_of(&[&WALK[..], &["--json", "--sample", "1/4"], more].concat());
    let one = run(&["--threads", "1"]);
    assert_eq!(one, run(&["--threads", "3"]));
    assert_ne!(one, run(&["--seed", "1"]));
}

#[test]
fn text_says_what_was_estimated() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("fps.svg");
    let more = ["--sample", "1/4", "--svg", file.to_str().expect("text")];
    let text = stdout_of(&[&WALK[..], &more].concat());
    assert!(text.contains("all 40 frames, of which 10 ran on the chip") && text.contains('±'), "{text}");
    assert_eq!(text.lines().filter(|line| line.ends_with("estimated")).count(), 30, "{text}");
    let drawing = std::fs::read_to_string(&file).expect("a drawing");
    assert!(drawing.contains("intervals of 95 %") && drawing.contains("ran on the chip"));
}

#[test]
fn what_is_no_part_is_refused() {
    let room = room_arg();
    let refused = |more: &[&str], why: &[&str]| {
        let text = refusal_of(&[&["simulate", &room, "--frames", ".."], more].concat());
        assert!(why.iter().all(|why| text.contains(why)), "{more:?}: {text}");
    };
    for part in ["0", "2/1", "1/0", "x", "0.5"] {
        refused(&["--sample", part], &[part, "such as 1/8"]);
    }
    for bound in ["1", "0%", "x%", "99%", "nan%"] {
        refused(&["--error", bound], &[bound, "such as 1%"]);
    }
    refused(&["--sample", "1/3"], &["sample of 1/3", "3/3 is enough"]);
    refused(&["--sample", "1/3", "--error", "1%"], &["--error"]);
    refused(&["--sample", "1/3", "-o", "rows.jsonl"], &["--out"]);
    refused(&["--sample", "1", "--warm-up", "walk"], &["--warm-up walk"]);
    let text = refusal_of(&["accuracy", "--simulator", &room, "--frames", "2"]);
    assert!(text.contains("--frames 2"), "{text}");
}

#[test]
fn accuracy_has_a_row_for_each_part_and_quantity() {
    let args = ["accuracy", "--simulator", "pquake3-nlnt", "--frames", "50", "--resolution", "128x96"];
    let out = stdout_of(&[&args[..], &["--json"]].concat());
    let rows: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    // A part of 1/12 would be four frames.
    assert_eq!(rows.len(), 3 * 3);
    for (place, row) in rows.iter().enumerate() {
        assert_eq!((&row["variant"], &row["sample"]), (&["none", "a", "b"][place / 3].into(), &"1/6".into()));
        assert_eq!((&row["draws"], &row["frames"], &row["simulated"]), (&200.into(), &50.into(), &8.into()));
        let not_known = row["not_known"].as_f64().expect("a number");
        assert!((0.0..=1.0).contains(&not_known) && row["error"].is_null() == (not_known == 1.0), "{row}");
        // What is known is so to a quarter.
        assert!(row["half_width"].as_f64().is_none_or(|half| half < 0.5), "{row}");
    }
}

/// Of the real conference and oa_dm3, 48 frames spread over each path: estimates from a quarter of them.
#[test]
#[ignore = "needs the real scenes; minutes"]
fn real_walks_are_estimated() {
    let scenes = std::env::var("SAARCOR_SCENES").expect("SAARCOR_SCENES names the folder of the real scenes");
    for (name, stride) in [("conference", "8"), ("oa_dm3", "23")] {
        let scene = format!("{scenes}/{name}/{name}.obj");
        let args =
            ["simulate", &scene, "--frames", "..", "--stride", stride, "--resolution", "256x192", "--json"];
        let rows = |more: &[&str]| -> Vec<Value> {
            let out = stdout_of(&[&args[..], more].concat());
            out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
        };
        let truth: f64 = rows(&[]).iter().map(|row| row["cycles"].as_f64().expect("a number")).sum();
        let estimated = rows(&["--sample", "1/4"]);
        let sum = estimated.last().expect("the sum");
        let error = sum["cycles"].as_f64().expect("a number") / truth - 1.0;
        assert!(error.abs() < 0.05, "{name}: {error}");
    }
}
