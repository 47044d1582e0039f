//! Bad input: status 2, one line that says what is wrong, where, and what would be right; no
//! output.

mod common;

use common::{RoomCopy, refusal, refusal_of, room_arg, saarcor};
use std::path::Path;
use std::process::Stdio;

/// Asserts that a run is refused with a line that has each of `parts`.
#[track_caller]
fn refuses(args: &[&str], parts: &[&str]) {
    let line = refusal_of(args);
    for part in parts {
        assert!(line.contains(part), "'{part}' is not in: {line}");
    }
}

/// Asserts that a scene is refused by all verbs that take one, and leaves no picture.
#[track_caller]
fn refuses_scene(scene: &str, parts: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("picture.png");
    refuses(&["walk", scene], parts);
    refuses(&["trace", "record", scene, "--frame", "0", "--format", "din"], parts);
    refuses(&["simulate", scene, "--frame", "0"], parts);
    refuses(&["render", scene, "-o", picture.to_str().expect("text")], parts);
    assert_is_empty(folder.path());
}

#[track_caller]
fn assert_is_empty(folder: &Path) {
    assert_eq!(folder.read_dir().expect("a folder").count(), 0, "{} is empty", folder.display());
}

#[test]
fn sizes_that_make_no_cache() {
    refuses(&["metadata", "--memory", "3MiB"], &["3145728", "power of two", "2097152"]);
    refuses(&["metadata", "--memory", "0"], &["0 bytes", "8MiB"]);
    refuses(&["metadata", "--line", "0"], &["line of 0 bytes", "128"]);
    refuses(&["metadata", "--line", "100"], &["line of 100 bytes", "128"]);
    refuses(&["metadata", "--memory", "8GiB"], &["4294967296"]);
    refuses(&["metadata", "--line", "32MiB"], &["smaller than one set"]);
    refuses(&["walk", &room_arg(), "--memory", "256", "--line", "128"], &["256", "smaller than one set"]);
    refuses(&["metadata", "--memory", "8MB"], &["8MB", "--memory", "8MiB"]);
    refuses(&["metadata", "--ways", "3"], &["--ways", "1, 2, 4, 8, 16"]);
}

#[test]
fn budgets_that_no_test_can_stay_inside() {
    let room = room_arg();
    let walk = |more: &[&str], parts: &[&str]| refuses(&[&["walk", &room], more].concat(), parts);
    walk(&["--auto=x"], &["x", "--auto", "10,256"]);
    walk(&["--auto=-1"], &["-1", "--auto"]);
    walk(&["--auto", "--kernel", "wald"], &["--auto", "--kernel"]);
    walk(&["--auto=0,0"], &["room.obj", "no triangle test", "--budget"]);
}

#[test]
fn numbers_that_make_no_chip() {
    let room = room_arg();
    let simulate = |more: &[&str], parts: &[&str]| {
        refuses(&[&["simulate", &room, "--frame", "0"], more].concat(), parts);
    };
    simulate(&["--l1-line", "shading=256"], &["256", "at most the line of the virtual memory, 128"]);
    simulate(&["--line", "8"], &["line of a first-level cache of 64", "8"]);
    simulate(&["--threads-per-rtp", "0"], &["threads a pipeline of 0", "1 to 64"]);
    simulate(&["--pipelines", "65"], &["65", "1 to 64"]);
    simulate(&["--mshrs", "0"], &["MSHRs", "1 to 64"]);
    simulate(&["--l1-ports", "0"], &["ports", "1 to 64"]);
    simulate(&["--memory", "256"], &["256", "smaller than one set"]);
    simulate(&["--ways", "3"], &["--ways", "1, 2, 4, 8, 16"]);
    simulate(&["--l1", "list=100"], &["list cache of 100 in lines of 4", "power of two"]);
    simulate(&["--l1", "intersection=64KiB"], &["64KiB in lines of 36", "power of two"]);
    simulate(&["--l1-line", "list=0"], &["lines of 0"]);
    simulate(&["--l1", "node=8KiB"], &["--l1", "shading, traversal, list, intersection"]);
    simulate(&["--l1", "list=8GiB", "--l1-line", "list=8GiB"], &["8589934592", "4294967295"]);
    simulate(&["--variant", "b", "--metadata-cache", "48"], &["metadata cache of 48", "power of two"]);
    simulate(&["--variant", "b", "--granule", "3"], &["granule", "3", "power of two"]);
    simulate(&["--variant", "c"], &["--variant", "none, a, b"]);
    simulate(&["--pci", "33"], &["--pci", "33x32, 66x64"]);
    refuses(&["simulate", &room], &["--frame"]);
    refuses(&["simulate", &room, "--frame", "3"], &["frame 3", "0 to 2"]);
}

#[test]
fn caches_too_large_to_simulate() {
    refuses(&["walk", &room_arg(), "--memory", "4GiB", "--line", "1"], &["GiB", "longer lines"]);
}

#[test]
fn usage() {
    refuses(&[], &["walk"]);
    refuses(&["wlak"], &["wlak", "walk"]);
    refuses(&["walk"], &["SCENE"]);
    refuses(&["walk", &room_arg(), "--polcy", "lru"], &["--polcy", "--policy"]);
    refuses(&["walk", &room_arg(), "--policy", "random"], &["random", "lru, fifo, plru"]);
    refuses(&["walk", &room_arg(), "--resolution", "640"], &["640", "1024x768"]);
    refuses(&["walk", &room_arg(), "--threads", "0"], &["--threads"]);
    refuses(&["walk", &room_arg(), "--lights", "2"], &["--lights 2", "1"]);
    refuses(&["prove", "hit_iff_residen"], &["hit_iff_residen", "hit_iff_resident", "--list"]);
    refuses(&["prove", "--engine", "z3"], &["z3", "kani, exhaustive, random, gappa, all"]);
    refuses(&["prove", "--cases", "0"], &["--cases"]);
}

#[test]
fn frames() {
    let room = room_arg();
    refuses(&["walk", &room, "--frames", "0..4"], &["frame 3", "0 to 2"]);
    refuses(&["walk", &room, "--frames", "3.."], &["frame 3", "0 to 2"]);
    refuses(&["walk", &room, "--frames", "2..2"], &["2..2", "--frames"]);
    refuses(&["walk", &room, "--frames", "2..1"], &["2..1"]);
    refuses(&["walk", &room, "--frames", "7"], &["A..B"]);
    refuses(&["trace", "record", &room, "--frame", "3", "--format", "csv"], &["frame 3", "0 to 2"]);
    refuses(
        &["render", &room, "--frame", "18446744073709551615", "-o", "x.png"],
        &["frame 18446744073709551615"],
    );
}

#[test]
fn scenes_that_are_not_there() {
    refuses_scene("pquak3", &["pquak3", "pquake3"]);
    refuses_scene("no/such.obj", &["no/such.obj"]);
    refuses_scene(env!("CARGO_MANIFEST_DIR"), &[env!("CARGO_MANIFEST_DIR")]);
}

#[test]
fn scenes_without_triangles() {
    let copy = RoomCopy::new();
    std::fs::write(copy.file("room.obj"), "").expect("written");
    refuses_scene(&copy.scene(), &["room.obj"]);
}

#[test]
fn broken_geometry() {
    for (number, named) in [("nan", "nan"), ("inf", "inf"), ("1e99", "1e99"), ("two", "two")] {
        let copy = RoomCopy::new();
        copy.replace("room.obj", "v 2 0 -3", &format!("v {number} 0 -3"));
        refuses_scene(&copy.scene(), &["room.obj:4", named]);
    }
    for index in ["99", "0", "-99"] {
        let copy = RoomCopy::new();
        copy.replace("room.obj", "f 2 4 3 1", &format!("f 2 4 3 {index}"));
        refuses_scene(&copy.scene(), &["room.obj:", index]);
    }
}

#[test]
fn broken_textures() {
    let copy = RoomCopy::new();
    copy.replace("room.mtl", "Kd 0.8 0.8 0.7", "Kd 1 1 1\nmap_Kd wall.png");
    copy.replace("room.obj", "f 2 4 3 1", "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 2/1 4/2 3/3 1/4");
    refuses(&["walk", &copy.scene(), "--strict"], &["room.mtl", "wall.png", "no such file"]);
    std::fs::write(copy.file("wall.png"), "no picture").expect("written");
    refuses_scene(&copy.scene(), &["wall.png"]);
}

#[test]
fn files_of_other_formats() {
    let copy = RoomCopy::new();
    for (content, format) in [("ply\nformat ascii 1.0\n", "PLY"), ("solid a\nfacet normal 0 0 1\n", "STL")] {
        std::fs::write(copy.file("room.obj"), content).expect("written");
        refuses_scene(&copy.scene(), &["room.obj", "is no OBJ file", format]);
    }
}

#[test]
fn broken_paths() {
    for (from, to) in [("0,-0.5,", "0,left,"), ("0,-0.5,", "0,nan,"), ("0,1,0,60", "60"), (",60", ",180")] {
        let copy = RoomCopy::new();
        copy.replace("camera.csv", from, to);
        refuses_scene(&copy.scene(), &["camera.csv:2"]);
    }
}

#[test]
fn places_that_cannot_be_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    std::fs::write(at("file"), "kept").expect("written");
    let record = |file: &str| {
        refusal_of(&["trace", "record", &room_arg(), "--frame", "0", "--format", "din", "-o", file]);
    };
    for place in [at(""), at("no/such/file"), at("file/below")] {
        // A scene that takes long to make: the place is found wrong before.
        assert!(
            refusal_of(&["render", "cruiser", "-o", &place]).contains(folder.path().to_str().expect("text"))
        );
        record(&place);
    }
    refusal_of(&["reproduce", "--quick", "--out", &at("file")]);
    refusal_of(&["scenes", "export", "cruiser", "--out", &at("no/such.obj")]);
    assert_eq!(std::fs::read_to_string(at("file")).expect("text"), "kept");
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 1);
}

#[test]
fn export_of_what_is_no_built_in_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("scene.obj");
    refuses(&["scenes", "export", "pquake", "--out", out.to_str().expect("text")], &["pquake3"]);
    assert_is_empty(folder.path());
}

#[test]
fn reproduction_without_the_real_scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("text");
    let out = folder.path().join("out");
    refuses(
        &["reproduce", "--quick", "--scenes", path, "--out", out.to_str().expect("text")],
        &["--scenes", "oa_dm3"],
    );
    assert_is_empty(&out);
}

#[test]
fn reproduction_of_a_scene_that_is_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
    let (out, room) = (at("out"), room_arg());
    let of = |scene: &str, more: &[&str], parts: &[&str]| {
        refuses(&[&["reproduce", "--quick", "--scene", scene, "--out", &out], more].concat(), parts);
    };
    of(&at("none.obj"), &[], &["none.obj"]);
    of("pquake", &[], &["pquake3"]);
    of(&room, &["--path", &at("none.csv")], &["none.csv"]);
    of(&room, &["--memory", "3MiB"], &["3145728", "power of two"]);
    of(&room, &["--memory", "4GiB"], &["virtual memories", "less memory"]);
    of(&room, &["--memory", "4GiB", "--scenes", "."], &["--scenes", "--scene"]);
    refuses(&["reproduce", "--memory", "8MiB"], &["--scene"]);
    // An option that another one takes the place of is not passed over.
    for other in [&["--sample", "1/2"][..], &["--over", "hash"], &["--combine", "banks=8"]] {
        of(&room, other, &[other[0], "--scene"]);
    }
    for other in ["--path", "--memory"] {
        refuses(&["reproduce", "--scenes", ".", other, "8MiB"], &[other, "--scenes"]);
        refuses(&["reproduce", "--sensitivity", other, "8MiB"], &[other, "--sensitivity"]);
    }
    assert!(!Path::new(&out).exists() || Path::new(&out).read_dir().expect("a folder").count() == 0);
}

#[test]
fn sensitivity_to_what_is_no_assumed_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let out = out.to_str().expect("text");
    let of = |more: &[&str], parts: &[&str]| {
        refuses(&[&["reproduce", "--quick", "--sensitivity", "--out", out], more].concat(), parts);
    };
    of(&["--over", "granules"], &["granules", "granule"]);
    of(&["--combine", "granule=17 B"], &["granule=17 B", "banks=8"]);
    of(&["--sample", "3/2"], &["3/2", "1/8"]);
    of(&["--sample", "1/1000"], &["--sample 1/1000", "25 rows", "larger"]);
    refuses(&["reproduce", "--over", "granule"], &["--sensitivity"]);
    refuses(&["reproduce", "--sample", "1/4"], &["--sensitivity"]);
    refuses(&["reproduce", "--warm-up", "all"], &["--warm-up", "walk"]);
    let sweep = ["sweep", "pquake3-nlnt", "--frame", "100", "--warm-up", "17", "--over", "ways"];
    refuses(&sweep, &["--warm-up", "17 frames", "16"]);
    assert_is_empty(folder.path());
    std::fs::create_dir(out).expect("a folder");
    let kept = Path::new(out).join("sensitivity.jsonl");
    let row = |fps: &str| {
        format!(
            "{{\"defaults\":\"0\",\"resolution\":[256,192],\"scene\":\"sodahall\",\"real\":false,\"of\":\"Sodahall\",\"row\":\"152\",\
             \"frame\":1,\"hot_spots\":[1],\"setting\":\"\",\"fps\":{fps},\"mem_bytes\":[1,1,1],\"pci_bytes\":[1,1]}}\n"
        )
    };
    let (negative, one_row) = (row("[0.0,-5.0,1e300]"), "{\"result\":1}".to_owned());
    for other in ["frame,cycles\n".to_owned(), negative, one_row, format!("{}?", row("[1.0,1.0,1.0]"))] {
        std::fs::write(&kept, &other).expect("written");
        of(&[], &["sensitivity.jsonl", "another folder"]);
        assert_eq!(std::fs::read_to_string(&kept).expect("text"), other, "nothing is lost");
    }
}

/// A reader that goes away early, as `head -1` does, has seen enough.
#[cfg(unix)]
#[test]
fn closed_standard_output_is_no_failure() {
    let room = room_arg();
    let verbs: [&[&str]; 4] = [
        &["--help"],
        &["metadata"],
        &["walk", &room, "--resolution", "64x48", "--json"],
        &["trace", "record", &room, "--frame", "0", "--format", "din"],
    ];
    for args in verbs {
        let mut child =
            saarcor(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        assert!(output.status.success(), "saarcor {args:?}: {}", output.status);
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "saarcor {args:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk() {
    let room = room_arg();
    let full = || std::fs::File::options().write(true).open("/dev/full").expect("Linux has it");
    let verbs: [&[&str]; 3] = [
        &["metadata"],
        &["walk", &room, "--resolution", "64x48"],
        &["trace", "record", &room, "--frame", "0", "--format", "csv"],
    ];
    for args in verbs {
        let output = saarcor(args).stdout(full()).output().expect("the binary starts");
        assert!(refusal(&output, args).contains("standard output"));
    }
    refuses(&["render", &room, "--resolution", "64x48", "-o", "/dev/full"], &["/dev/full"]);
}
