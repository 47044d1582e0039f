//! `--sample` of `saarcor simulate` and `saarcor walk`, and `saarcor accuracy --simulator`.

mod common;

use common::{refusal_of, room_arg, stdout_of};
use serde_json::Value;

/// A picture of 40 × 30 tiles, of which 1/4 is 11 of 45 blocks.
const PICTURE: [&str; 3] = ["--resolution", "320x240", "--json"];

/// Keys of a row of `simulate` that are estimated; dots lead into objects.
const CHIP: [&str; 18] = [
    "cycles",
    "fps",
    "rays",
    "pci_bytes",
    "mem_bytes",
    "mem_bytes_l1_fill",
    "mem_bytes_vm_fill",
    "mem_bytes_metadata",
    "l2_accesses",
    "l2_hits",
    "l1.shading.accesses",
    "l1.shading.hits",
    "l1.traversal.accesses",
    "l1.traversal.hits",
    "l1.list.accesses",
    "l1.list.hits",
    "l1.intersection.accesses",
    "l1.intersection.hits",
];

/// Keys of a row of `walk` that are estimated.
const WALK: [&str; 11] = [
    "primary_rays",
    "shadow_rays",
    "secondary_rays",
    "accesses",
    "hits",
    "misses",
    "working_set_lines",
    "working_set_bytes",
    "collisions",
    "loaded_lines",
    "loaded_bytes",
];

fn simulate(more: &[&str]) -> Value {
    let out = stdout_of(&[&["simulate", &room_arg(), "--frame", "1"], &PICTURE[..], more].concat());
    serde_json::from_str(&out).expect("one JSON object")
}

fn walk(more: &[&str]) -> Vec<Value> {
    let out = stdout_of(&[&["walk", &room_arg()], &PICTURE[..], more].concat());
    out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

fn at<'a>(row: &'a Value, key: &str) -> &'a Value {
    key.split('.').fold(row, |value, key| &value[key])
}

#[track_caller]
fn number(row: &Value, key: &str) -> f64 {
    at(row, key).as_f64().unwrap_or_else(|| panic!("{key} is not a number"))
}

#[track_caller]
fn interval(row: &Value, key: &str) -> [f64; 2] {
    [0, 1]
        .map(|end| at(&row["interval"], key)[end].as_f64().unwrap_or_else(|| panic!("{key} has no interval")))
}

#[track_caller]
fn is_exactly(row: &Value, truth: &Value, key: &str) {
    assert_eq!(at(row, key), at(truth, key), "{key}");
    assert_eq!(interval(row, key), [number(truth, key); 2], "{key}");
}

fn holds(row: &Value, truth: &Value, key: &str) -> bool {
    let ([low, high], truth) = (interval(row, key), number(truth, key));
    low <= truth && truth <= high
}

#[test]
fn whole_picture_is_the_full_run() {
    for variant in ["none", "a", "b"] {
        let full = simulate(&["--variant", variant]);
        let row = simulate(&["--variant", variant, "--sample", "1"]);
        CHIP.iter().for_each(|key| is_exactly(&row, &full, key));
        assert_eq!(row["sample"], "1");
        ["scene", "frame", "variant"].iter().for_each(|key| assert_eq!(row[key], full[key]));
    }
    let (full, rows) = (walk(&[]), walk(&["--sample", "3/3"]));
    assert_eq!(full.len(), rows.len());
    for (full, row) in full.iter().zip(&rows) {
        WALK.iter().for_each(|key| is_exactly(row, full, key));
    }
}

#[test]
fn intervals_hold_the_full_run() {
    for variant in ["none", "a", "b"] {
        let full = simulate(&["--variant", variant]);
        let row = simulate(&["--variant", variant, "--sample", "1/4"]);
        assert!(number(&row, "packets_in_full") < number(&row, "packets") / 2.0);
        for key in CHIP {
            let [low, high] = interval(&row, key);
            assert!(low <= number(&row, key) && number(&row, key) <= high, "{key}");
        }
        for key in ["cycles", "fps", "rays", "pci_bytes", "mem_bytes", "l2_accesses"] {
            assert!(holds(&row, &full, key), "{variant}: {key}");
        }
    }
    for (full, row) in walk(&[]).iter().zip(&walk(&["--sample", "1/4"])) {
        is_exactly(row, full, "primary_rays");
        for key in ["shadow_rays", "accesses", "misses", "working_set_lines", "loaded_bytes"] {
            assert!(holds(row, full, key), "{key}");
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let runs: Vec<_> = ["1", "2", "3"]
        .iter()
        .map(|threads| {
            let more = ["--sample", "1/3", "--threads", threads];
            (simulate(&more), walk(&more))
        })
        .collect();
    assert!(runs.windows(2).all(|two| two[0] == two[1]));
}

#[test]
fn packets_of_few_rays_are_sampled_too() {
    for packet in ["4", "16", "64"] {
        let scene = room_arg();
        let more = ["--resolution", "160x120", "--packet", packet, "--sample", "1/3", "--json"];
        let out = stdout_of(&[&["simulate", &scene, "--frame", "0"], &more[..]].concat());
        let row: Value = serde_json::from_str(&out).expect("JSON");
        let [low, high] = interval(&row, "cycles");
        assert!(0.0 < low && low < high, "{low} {high}");
    }
}

#[test]
fn what_is_no_part_is_refused() {
    let room = room_arg();
    for verb in [&["simulate", &room, "--frame", "0"][..], &["walk", &room]] {
        for part in ["0", "2/1", "1/0", "x", "0.5"] {
            let refusal = refusal_of(&[verb, &["--sample", part]].concat());
            assert!(refusal.contains(part) && refusal.contains("such as 1/8"), "{refusal}");
        }
        let refusal = refusal_of(&[verb, &["--sample", "1/100000"]].concat());
        assert!(refusal.contains("at least 1/192 is enough"), "{refusal}");
        let refusal = refusal_of(&[verb, &["--sample", "1/8", "--packet", "1"]].concat());
        assert!(refusal.contains("packets of 4, 16 or 64 rays"), "{refusal}");
    }
    let refusal = refusal_of(&["simulate", &room, "--frame", "0", "--sample", "1/8", "-o", "picture.png"]);
    assert!(refusal.contains("--out"), "{refusal}");
    let refusal = refusal_of(&["accuracy", "--simulator", &room, "--resolution", "8x8"]);
    assert!(refusal.contains("sample of 1/4") && refusal.contains("blocks"), "{refusal}");
}

#[test]
fn accuracy_has_a_row_for_each_part_and_quantity() {
    let scene = room_arg();
    let args = ["accuracy", "--simulator", &scene, "--frames", "2", "--resolution", "512x384"];
    let out = stdout_of(&[&args[..], &["--json"]].concat());
    let rows: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    for part in ["1/2", "1/4", "1/8", "1/16", "1/32", "1/64"] {
        for (step, keys) in [("walk", &WALK[..]), ("simulate", &CHIP)] {
            for key in keys {
                let mut found = rows
                    .iter()
                    .filter(|row| row["sample"] == part && row["step"] == step && row["quantity"] == *key);
                let row = found.next().expect("a row");
                assert!((0.0..=1.0).contains(&number(row, "coverage")) && number(row, "speedup") > 0.0);
                // A walk goes on through the three frames of the path.
                assert_eq!(number(row, "frames"), if step == "walk" { 3.0 } else { 2.0 });
            }
        }
    }
}

/// Of the real conference, 6 frames spread over its path, each version.
#[test]
#[ignore = "needs the real scenes; two minutes"]
fn real_conference_is_held_by_the_intervals() {
    let scenes = std::env::var("SAARCOR_SCENES").expect("SAARCOR_SCENES names the folder of the real scenes");
    let scene = format!("{scenes}/conference/conference.obj");
    let (mut held, mut all) = (0, 0);
    for (place, frame) in (8..400).step_by(72).enumerate() {
        let frame = frame.to_string();
        let variant = ["none", "a", "b"][place % 3];
        let args = ["simulate", &scene, "--frame", &frame, "--variant", variant, "--json"];
        let of = |args: &[&str]| -> Value { serde_json::from_str(&stdout_of(args)).expect("JSON") };
        let (truth, row) = (of(&args), of(&[&args[..], &["--sample", "1/8"]].concat()));
        for key in CHIP {
            all += 1;
            held += usize::from(holds(&row, &truth, key));
        }
    }
    assert!(10 * held >= 9 * all, "{held} of {all}");
}
