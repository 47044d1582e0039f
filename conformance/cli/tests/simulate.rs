//! `saarcor simulate`.

mod common;

use common::{refusal_of, room_arg, stdout_of};
use saarcor_oracles::memory_protocol::{Checker, Command, PC133, Timing, commands};
use serde_json::Value;

/// The room's second frame, in a picture that takes a moment.
fn args<'a>(room: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["simulate", room, "--frame", "1", "--resolution", "64x48"], more].concat()
}

/// On-board memory that the room does not fit.
const TIGHT: [&str; 4] = ["--memory", "2KiB", "--line", "64"];

fn simulate(more: &[&str]) -> Value {
    let out = stdout_of(&args(&room_arg(), &[more, &["--json"]].concat()));
    assert_eq!(out.lines().count(), 1, "one object");
    serde_json::from_str(&out).expect("JSON")
}

#[track_caller]
fn number(row: &Value, field: &str) -> u64 {
    row[field].as_u64().expect("a number")
}

const UNITS: [&str; 4] = ["shading", "traversal", "list", "intersection"];

#[test]
fn sums_hold() {
    for variant in ["none", "a", "b"] {
        for sizes in [&[][..], &TIGHT, &["--pci", "66x64", "--threads-per-rtp", "3", "--pipelines", "2"]] {
            let row = simulate(&[&["--warm-up", "0", "--variant", variant], sizes].concat());
            assert_eq!(row["variant"], variant);
            let cycles = number(&row, "cycles");
            let fps = row["fps"].as_f64().expect("a number");
            assert!((fps * cycles as f64 / 533e6 - 1.0).abs() < 1e-12);
            let pipelines = if sizes.contains(&"--pipelines") { 2 } else { 4 };
            for name in UNITS {
                let unit = &row["units"][name];
                let all = ["busy", "stalled", "idle"].map(|field| number(unit, field));
                assert_eq!(all.iter().sum::<u64>(), cycles * pipelines, "{name}");
                let stalls = unit["stalls"].as_object().expect("causes").values();
                assert_eq!(stalls.map(|stall| stall.as_u64().expect("a number")).sum::<u64>(), all[1]);
                let l1 = &row["l1"][name];
                assert!(number(l1, "hits") + number(l1, "merged") <= number(l1, "accesses"));
            }
            let line = if sizes == TIGHT { 64 } else { 128 };
            let misses = number(&row, "l2_accesses") - number(&row, "l2_hits");
            assert_eq!(number(&row, "pci_bytes"), misses * line);
            assert_eq!(number(&row, "mem_bytes_vm_fill"), number(&row, "pci_bytes"));
            let parts = ["mem_bytes_l1_fill", "mem_bytes_vm_fill", "mem_bytes_metadata"];
            let parts = parts.map(|field| number(&row, field));
            assert_eq!(number(&row, "mem_bytes"), parts.iter().sum::<u64>());
            assert_eq!((parts[1] == 0, parts[2] == 0), (variant == "none", variant != "b"));
        }
    }
}

#[test]
fn rays_are_those_of_the_walk() {
    let walk = ["walk", &room_arg(), "--frames", "1..2", "--resolution", "64x48", "--json"];
    let walk: Value = serde_json::from_str(&stdout_of(&walk)).expect("JSON");
    let rays = ["primary_rays", "shadow_rays", "secondary_rays"].map(|field| number(&walk, field));
    assert_eq!(number(&simulate(&[]), "rays"), rays.iter().sum::<u64>());
}

#[test]
fn results_do_not_depend_on_threads() {
    let room = room_arg();
    let run = |threads| {
        let more = ["--variant", "b", "--json", "--threads", threads, TIGHT[0], TIGHT[1]];
        stdout_of(&args(&room, &more))
    };
    let one = run("1");
    assert_eq!(one, run("2"));
    assert_eq!(one, run("2"), "twice the same run");
}

#[test]
fn picture_is_that_of_the_functional_run() {
    let (room, folder) = (room_arg(), tempfile::tempdir().expect("a folder"));
    let file = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    let (timed, flat) = (file("timed.png"), file("flat.png"));
    stdout_of(&["render", &room, "--frame", "1", "--resolution", "64x48", "--flat", "-o", &flat]);
    for order in ["scan", "morton"] {
        stdout_of(&args(&room, &["-o", &timed, "--order", order]));
        assert!(std::fs::read(&timed).expect("a picture") == std::fs::read(&flat).expect("a picture"));
    }
}

#[test]
fn frames_before_warm_the_caches() {
    let pci = |frames| number(&simulate(&["--warm-up", frames]), "pci_bytes");
    assert!(pci("1") < pci("0"));
    assert_eq!(pci("1"), pci("9"), "there is one frame before");
    assert_eq!(pci("1"), pci("walk"));
    let long = ["sweep", "pquake3-nlnt", "--frame", "100", "--warm-up", "walk", "--over", "line"];
    assert!(refusal_of(&long).contains("--warm-up: 100 frames before are kept in memory here; at most 16"));
}

#[test]
fn sizes_of_the_chip_matter() {
    let cold = |more: &[&str]| simulate(&[&["--warm-up", "0"], more].concat());
    let cycles = |more: &[&str]| number(&cold(more), "cycles");
    let standard = cycles(&[]);
    assert!(cycles(&["--threads-per-rtp", "1"]) > standard);
    assert!(cycles(&["--pci", "66x64"]) < standard);
    assert!(cycles(&["--l1", "intersection=144", "--l1", "traversal=32"]) > standard);
    assert_ne!(cycles(&["--l1-line", "traversal=64"]), standard);
    assert_ne!(cycles(&["--l1-ports", "4"]), standard);
    assert!(cycles(&["--mshrs", "1"]) > standard);
    assert_ne!(cycles(&["--order", "morton"]), standard);
    assert_eq!(number(&cold(&["--order", "morton"]), "rays"), number(&cold(&[]), "rays"));
    let metadata = |more: &[&str]| number(&cold(&[&["--variant", "b"], more].concat()), "mem_bytes_metadata");
    assert!(metadata(&["--metadata-cache", "128"]) > metadata(&[]));
    assert_ne!(metadata(&["--granule", "64"]), metadata(&[]));
}

#[test]
fn text_says_what_the_json_says() {
    let (text, row) = (stdout_of(&args(&room_arg(), &[])), simulate(&[]));
    for part in ["version a", "frames a second", "PCI:", "Mem:", "virtual memory", "intersection"] {
        assert!(text.contains(part), "'{part}' is not in: {text}");
    }
    assert!(text.contains(&format!("{} cycles", row["cycles"])));
    assert!(text.contains(&row["l1"]["list"]["accesses"].to_string()));
}

#[test]
fn parts_are_compared_with_the_hosts_bytes() {
    for variant in ["none", "a", "b"] {
        for sizes in [&[][..], &TIGHT] {
            let args = [&["--variant", variant], sizes].concat();
            let mut checked = simulate(&[&args[..], &["--check-bytes"]].concat());
            let fields = checked.as_object_mut().expect("an object");
            let parts = fields.remove("parts_checked").and_then(|parts| parts.as_u64()).expect("a number");
            assert_eq!(fields.remove("parts_wrong"), Some(0.into()));
            let row = simulate(&args);
            assert_eq!(checked, row, "the run is the same");
            assert_eq!(parts, number(&row, "l2_accesses"), "each look-up is of a part that is read");
        }
    }
    let text = stdout_of(&args(&room_arg(), &["--check-bytes"]));
    assert!(text.contains(" parts compared with the bytes of the host, 0 differ"), "{text}");
}

/// The commands of the memory chips are ones that the data sheet allows, and move all bytes that are counted.
#[test]
fn commands_of_the_memory_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    for variant in ["none", "a", "b"] {
        for sizes in [&[][..], &TIGHT] {
            let file = folder.path().join("commands.csv");
            let path = file.to_str().expect("UTF-8");
            let args = [&["--variant", variant], sizes].concat();
            let row = simulate(&[&args[..], &["--sdram-commands", path]].concat());
            assert_eq!(row, simulate(&args), "the run is the same");
            let text = std::fs::read(&file).expect("it was written");
            // SD-4: a burst moves all its beats.
            let mut checker = Checker::new(Timing { burst_cut: 0, ..PC133 });
            let mut beats = 0;
            for command in commands(&text[..]) {
                let (clock, command) = command.expect("of the form");
                assert_eq!(checker.check(clock, command), Ok(()));
                if let Command::Read(burst) | Command::Write(burst) = command {
                    beats += burst.beats;
                }
            }
            assert_eq!(checker.finish(number(&row, "cycles") / 4), Ok(()));
            // Metadata may still be written back when the last packet ends.
            let moved = number(&row, "mem_bytes") / 16;
            assert!(beats <= moved && moved - beats < 64, "{variant}: {beats} beats, {moved} counted");
            assert!(variant == "b" || beats == moved, "{variant}: {beats} beats, {moved} counted");
        }
    }
    let refused = |path: &str, why: &str| {
        let text = refusal_of(&args(&room_arg(), &["--sdram-commands", path]));
        assert!(text.contains(why), "{path}: {text}");
    };
    refused("commands.png", "csv");
    refused("no/such/folder/commands.csv", "no such folder");
}
