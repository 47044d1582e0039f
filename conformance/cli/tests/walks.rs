//! `saarcor walk` and `saarcor trace record`.

mod common;

use common::{refusal_of, room_arg, saarcor, stdout_of};
use saarcor_model::time::standard::POLICY;
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr};
use saarcor_oracles::cache::NaiveCache;
use serde_json::Value;
use std::io::Write as _;
use std::process::Stdio;

/// Sizes of the pictures: each test takes a moment.
const SMALL: [&str; 2] = ["--resolution", "64x48"];
/// On-board memory that the room does not fit.
const TIGHT: [&str; 4] = ["--memory", "2KiB", "--line", "64"];

fn walk(args: &[&str]) -> Vec<Value> {
    let out = stdout_of(&[&["walk", &room_arg(), "--json"], &SMALL[..], args].concat());
    out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

fn number(row: &Value, field: &str) -> u64 {
    row[field].as_u64().expect("a number")
}

#[test]
fn rows_have_their_fields_in_order() {
    let out = stdout_of(&[&["walk", &room_arg(), "--json", "--frames", "0..1"], &SMALL[..]].concat());
    let fields = [
        "frame",
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
        "memory_bytes",
        "ways",
        "line_bytes",
        "hash",
        "policy",
    ];
    let places = fields.map(|field| out.find(&format!("\"{field}\":")).expect("the field"));
    assert!(places.is_sorted());
    assert_eq!(out.matches(':').count(), fields.len(), "no other fields");
}

#[test]
fn sums_hold() {
    for args in [&TIGHT[..], &["--cold"], &["--policy", "fifo", "--ways", "1", "--memory", "1KiB"], &[]] {
        for row in walk(args) {
            assert_eq!(number(&row, "primary_rays"), 64 * 48);
            assert_eq!(
                number(&row, "shadow_rays"),
                number(&row, "primary_rays") + number(&row, "secondary_rays")
            );
            assert!(number(&row, "secondary_rays") > 0, "the room has a mirror");
            assert_eq!(number(&row, "hits") + number(&row, "misses"), number(&row, "accesses"));
            assert_eq!(number(&row, "loaded_lines"), number(&row, "misses"));
            // A line has as many bytes, loaded or touched.
            let by = |bytes: &str, lines: &str| number(&row, bytes) * number(&row, lines);
            assert_eq!(by("loaded_bytes", "working_set_lines"), by("working_set_bytes", "loaded_lines"));
        }
    }
}

#[test]
fn memory_that_holds_the_image_has_no_collisions() {
    for row in walk(&["--cold", "--memory", "1MiB"]) {
        assert_eq!(number(&row, "loaded_lines"), number(&row, "working_set_lines"));
        assert_eq!(number(&row, "collisions"), 0);
    }
}

#[test]
fn tight_memory_has_collisions() {
    for row in walk(&[&TIGHT[..], &["--cold"]].concat()) {
        let (loaded, touched) = (number(&row, "loaded_lines"), number(&row, "working_set_lines"));
        assert_eq!(number(&row, "collisions"), loaded - touched, "cold: each further load of a line");
        assert!(loaded > touched);
    }
}

#[test]
fn warm_memory_loads_less() {
    let (warm, cold) = (walk(&[]), walk(&["--cold"]));
    assert_eq!(warm[0], cold[0], "the first frame finds the memory empty");
    assert!(number(&warm[1], "loaded_lines") < number(&cold[1], "loaded_lines"));
    assert_eq!(number(&warm[1], "working_set_lines"), number(&cold[1], "working_set_lines"));
}

#[test]
fn ranges_are_half_open() {
    let frames = |range| walk(&["--cold", "--frames", range]);
    let all = frames("..");
    assert_eq!(all.iter().map(|row| number(row, "frame")).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(frames("1.."), all[1..]);
    assert_eq!(frames("..2"), all[..2]);
    assert_eq!(frames("1..2"), all[1..2]);
}

/// Hot spots, read from the rows alone: of frames 1 and 2, which follow others.
#[test]
fn hot_spots_are_the_last_line() {
    let rows = walk(&[&TIGHT[..], &["--hot-spots", "2"]].concat());
    let [first, second, third, last] = &rows[..] else { panic!("three frames and a line: {rows:?}") };
    assert_eq!(last["cuts"], serde_json::json!([]));
    let hotter = |field: &str| if number(third, field) > number(second, field) { 2 } else { 1 };
    let largest = hotter("working_set_lines");
    let spot = |frame: u64, most: &str| serde_json::json!({ "frame": frame, "most": most });
    let mut spots = [spot(largest, "working_set"), spot(3 - largest, "collisions")];
    spots.sort_by_key(|spot| spot["frame"].as_u64());
    assert_eq!(last["hot_spots"], serde_json::json!(spots));
    assert!(number(first, "collisions") > 0, "it has the most of an empty cache's, and is none");
    assert_eq!(
        walk(&[&TIGHT[..], &["--frames", "0..1", "--hot-spots", "9"]].concat())[1]["hot_spots"][0]["frame"],
        0
    );
}

#[test]
fn results_do_not_depend_on_threads() {
    let scenes = [room_arg(), "pquake3".to_owned()];
    for scene in &scenes {
        let walk = |threads| {
            let args = ["walk", scene, "--frames", "0..2", "--resolution", "160x120", "--threads", threads];
            stdout_of(&[&args[..], &["--json", "--memory", "64KiB"]].concat())
        };
        let one = walk("1");
        assert_eq!(one, walk("2"));
        assert_eq!(one, walk("2"), "twice the same run");
        assert_eq!(one.lines().count(), 2);
    }
}

#[test]
fn packets_share_accesses() {
    let accesses = |packet| number(&walk(&["--packet", packet])[0], "accesses");
    let by_size = ["1", "4", "16", "64"].map(accesses);
    assert!(by_size.is_sorted_by(|one, more| one > more), "{by_size:?}");
}

#[test]
fn scenes_without_lights_have_no_shadow_rays() {
    assert!(walk(&["--lights", "0"]).iter().all(|row| number(row, "shadow_rays") == 0));
    assert!(walk(&["--bounces", "0"]).iter().all(|row| number(row, "secondary_rays") == 0));
}

/// What all virtual memories load at once is what each loads alone.
#[test]
fn all_virtual_memories_at_once_are_each_of_them() {
    let sizes =
        ["--memory", "2KiB..=32KiB", "--ways", "1,4,16", "--line", "32,128", "--hash", "low,add-upper"];
    for policies in ["lru", "fifo,plru"] {
        let args = [&["--all", "--policy", policies, "--frames", "1.."], &sizes[..]].concat();
        let rows = walk(&args);
        assert_eq!(rows.len(), 2 * 5 * 3 * 2 * 2 * policies.split(',').count());
        for (place, row) in rows.iter().enumerate().step_by(7) {
            let text = |field: &str| row[field].to_string().trim_matches('"').to_owned();
            let [memory, ways, line, hash, policy] =
                ["memory_bytes", "ways", "line_bytes", "hash", "policy"].map(text);
            let alone = [
                "--memory", &memory, "--ways", &ways, "--line", &line, "--hash", &hash, "--policy", &policy,
                "--frames", "1..",
            ];
            let frame = (number(row, "frame") - 1) as usize;
            assert_eq!(*row, walk(&alone)[frame], "row {place}");
        }
    }
}

#[test]
fn several_sizes_are_for_all_virtual_memories() {
    for (args, right) in [
        (&["--memory", "1MiB,2MiB"][..], "--memory: 2 values; one without --all"),
        (&["--policy", "lru,fifo"], "--policy: 2 values; one without --all"),
        (&["--all", "--memory", "3MiB..=8MiB"], "write a range from one power of two to a larger one"),
        (&["--all", "--ways", "3"], "3 ways: it must be a power of two from 1 to 16"),
        (&["--all", "--memory", "1KiB"], "take more memory, shorter lines or fewer ways"),
        (&["--all", "--memory", "4GiB", "--line", "1,2", "--ways", "1"], "4 GiB"),
        (&["--svg", "sizes.svg"], "--all"),
    ] {
        let says = refusal_of(&[&["walk", &room_arg()], args].concat());
        assert!(says.contains(right), "{args:?}: {says}");
    }
}

/// The table has a row a line and number of ways, the picture a field a virtual memory.
#[test]
fn all_virtual_memories_make_a_table_and_a_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("sizes.svg").display().to_string();
    let scene = ["walk", "pquake3-nt", "--frames", "150..152", "--resolution", "160x120"];
    let sizes = ["--all", "--memory", "64KiB..=1MiB", "--ways", "1,4", "--line", "64,128", "--svg", &picture];
    let table = stdout_of(&[&scene[..], &sizes].concat());
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "MB loaded by 2 frames");
    assert!(lines[1].contains("64KiB") && lines[1].contains("1MiB"), "{table}");
    let names: Vec<&str> = lines[2..].iter().map(|line| line.split("  ").next().expect("a name")).collect();
    assert_eq!(names, ["64, 1 way", "64, 4 ways", "128, 1 way", "128, 4 ways"]);

    let picture = std::fs::read_to_string(picture).expect("a picture");
    let picture = roxmltree::Document::parse(&picture).expect("SVG");
    let place =
        |node: &roxmltree::Node<'_, '_>, axis| node.attribute(axis).and_then(|at| at.parse::<f64>().ok());
    let texts: Vec<(f64, f64, &str)> = picture
        .descendants()
        .filter_map(|node| Some((place(&node, "x")?, place(&node, "y")?, node.text()?)))
        .collect();
    let of = |text: &str| {
        *texts.iter().find(|found| found.2 == text).unwrap_or_else(|| panic!("no {text}: {texts:?}"))
    };
    // Each number stands to the right of its row's name, and above its column's.
    for (name, line) in names.iter().zip(&lines[2..]) {
        let numbers = line.split_whitespace().rev().take(5);
        for (memory, number) in ["1MiB", "512KiB", "256KiB", "128KiB", "64KiB"].iter().zip(numbers) {
            let (x, y) = (of(memory).0, of(name).1);
            let is_there = |found: &&(f64, f64, &str)| (found.0 - x).abs() < 3.0 && (found.1 - y).abs() < 6.0;
            assert_eq!(texts.iter().find(is_there).map(|found| found.2), Some(number), "{name}, {memory}");
        }
    }
    let values: std::collections::BTreeSet<&str> =
        lines[2..].iter().flat_map(|line| line.split_whitespace()).collect();
    assert!(values.len() > 12, "sizes differ in what they load: {table}");
}

/// The rows of a trace as addresses.
fn trace(format: &str, prefix: &str) -> Vec<HostAddr> {
    let args = ["trace", "record", &room_arg(), "--frame", "1", "--format", format];
    let out = stdout_of(&[&args[..], &SMALL, &TIGHT].concat());
    let rows = out.lines().skip(usize::from(format == "csv"));
    let address =
        |row: &str| u32::from_str_radix(row.strip_prefix(prefix).expect("prefix"), 16).expect("hex");
    rows.map(|row| HostAddr(address(row))).collect()
}

/// The trace, played to a cache that is not the model's, gives what the walk counted.
#[test]
fn traces_hold_all_accesses_in_order() {
    let trace_of_din = trace("din", "0 ");
    assert_eq!(trace_of_din, trace("csv", "0x"));
    let geometry = Geometry::new(Bytes(2 << 10), Bytes(64), 4).expect("legal");
    let config = CacheConfig { geometry, hash: Hash::default(), policy: POLICY };
    let mut cache = NaiveCache::new(config);
    for addr in trace_of_din {
        cache.access(geometry.line_of(addr));
    }
    let row = &walk(&[&TIGHT[..], &["--cold", "--frames", "1..2"]].concat())[0];
    let counters = cache.counters();
    assert_eq!(counters.accesses, number(row, "accesses"));
    assert_eq!((counters.hits(), counters.misses), (number(row, "hits"), number(row, "misses")));
}

/// A recorded frame, played from a file or from standard input, does what the walk counted, in one virtual memory and in many.
#[test]
fn recorded_accesses_are_walked_through_like_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let of_frame = &walk(&[&TIGHT[..], &["--cold", "--frames", "1..2"]].concat())[0];
    for format in ["din", "csv"] {
        let file = folder.path().join("frames").with_extension(format).display().to_string();
        let args = ["trace", "record", &room_arg(), "--frame", "1", "--format", format];
        let recorded = stdout_of(&[&args[..], &SMALL, &TIGHT].concat());
        let again = recorded.lines().filter(|line| *line != "address").collect::<Vec<_>>().join("\n");
        std::fs::write(&file, format!("{recorded}# the same frame\n{again}\n#\n")).expect("written");
        let played = |more: &[&str]| -> Vec<Value> {
            let out = stdout_of(&[&["walk", "--trace", &file, "--json"], more].concat());
            out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
        };
        let rows = played(&[&TIGHT[..], &["--cold"]].concat());
        assert_eq!(rows.len(), 2, "frames");
        let counts =
            ["accesses", "hits", "misses", "working_set_lines", "collisions", "loaded_bytes", "memory_bytes"];
        for (frame, row) in rows.iter().enumerate() {
            assert_eq!(number(row, "frame"), frame as u64);
            counts.iter().for_each(|count| assert_eq!(row[count], of_frame[count], "{format}: {count}"));
        }
        let all = played(&["--all", "--cold", "--memory", "2KiB..=64KiB", "--line", "64", "--ways", "1..=4"]);
        assert_eq!(all.len(), 2 * 6 * 3);
        assert!(all.contains(&rows[1]), "that of one is among all");
    }
    let mut playing = saarcor(&["walk", "--trace", "-", "--json", "--memory", "1KiB", "--line", "64"]);
    let mut playing = playing.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts");
    playing.stdin.take().expect("a pipe").write_all(b"0 0\n0 40\n0 0\n").expect("written");
    let out = String::from_utf8(playing.wait_with_output().expect("an end").stdout).expect("text");
    let row: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((number(&row, "hits"), number(&row, "misses")), (1, 2));
}

#[test]
fn traces_that_are_none_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("trace.din").display().to_string();
    for (text, right) in [
        ("0 0\nread 40\n", "line 2: 'read 40': write '0 ADDRESS'"),
        ("0 100000000\n", "line 1: '0 100000000': an address has 32 bits"),
        ("", "no accesses"),
    ] {
        std::fs::write(&file, text).expect("written");
        let says = refusal_of(&["walk", "--trace", &file, "--all", "--json", "--memory", "8MiB"]);
        assert!(says.contains(&file) && says.contains(right), "{text}: {says}");
    }
    assert!(refusal_of(&["walk", "--trace", "none.din"]).contains("none.din: cannot be read"));
    assert!(refusal_of(&["walk", "--trace", &file, "--frames", "0..1"]).contains("--frames"));
    assert!(refusal_of(&["walk", "--trace", &file, "--memory", "3MiB"]).contains("power of two"));
}

/// The committed trace is that of a frame, and a walk counts what pycachesim made of it.
#[test]
fn walk_counts_what_another_simulator_does() {
    let scene = ["pquake3-nt", "--resolution", "64x48", "--hash", "low"];
    let trace = stdout_of(&[&["trace", "record", "--frame", "150", "--format", "din"], &scene[..]].concat());
    assert!(
        trace == include_str!("../../../reference/oracles/traces/pquake3-nt-150.din"),
        "the trace has changed"
    );
    let simulated: toml::Table =
        include_str!("../../../reference/oracles/traces/pquake3-nt-150-lru.toml").parse().expect("TOML");
    let runs = simulated["cold"].as_array().expect("runs");
    assert!(runs.len() > 2);
    for run in runs {
        let value = |field: &str| run[field].as_integer().expect("a number") as u64;
        let memory = value("memory_bytes").to_string();
        let walk =
            ["walk", "--frames", "150..151", "--cold", "--json", "--policy", "lru", "--memory", &memory];
        let row: Value = serde_json::from_str(&stdout_of(&[&walk, &scene[..]].concat())).expect("JSON");
        assert_eq!((number(&row, "hits"), number(&row, "misses")), (value("hits"), value("misses")));
    }
}

#[test]
fn traces_go_to_files_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("frame.din");
    let args = ["trace", "record", &room_arg(), "--frame", "0", "--format", "din", SMALL[0], SMALL[1]];
    assert_eq!(stdout_of(&[&args[..], &["-o", file.to_str().expect("text")]].concat()), "");
    assert_eq!(std::fs::read_to_string(file).expect("text"), stdout_of(&args));
}

/// Rows of the text form are the rows of the JSON form.
#[test]
fn text_is_aligned_under_a_header() {
    let out = stdout_of(&[&["walk", &room_arg()], &SMALL[..]].concat());
    let lines: Vec<_> = out.lines().collect();
    assert_eq!(lines.len(), 4);
    assert!(lines.iter().all(|line| line.chars().count() == lines[0].chars().count()), "{out}");
    let accesses = walk(&[])[2]["accesses"].to_string();
    assert!(lines[3].split_whitespace().any(|cell| cell == accesses));
}
