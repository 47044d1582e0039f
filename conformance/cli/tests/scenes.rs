//! `saarcor scenes`.

mod common;

use common::{RoomCopy, refusal_of, room_arg, run, stdout_of};
use saarcor_paper::tables as paper;
use serde_json::Value;

/// Table 1, as generated: the paper's triangles and lights, and its textures within 2 %.
#[test]
fn list_is_table_1() {
    let out = stdout_of(&["scenes", "list", "--json"]);
    let rows: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(rows.len(), paper::table1().len());
    for (row, paper) in rows.iter().zip(paper::table1()) {
        assert_eq!(row["scene"], paper.scene.to_lowercase());
        assert_eq!(row["triangles"], paper.triangles, "{row}");
        assert_eq!(row["lights"], paper.lights, "{row}");
        let bytes = row["texture_bytes"].as_f64().expect("a number");
        match paper.textures_mb {
            Some(mb) => assert!((bytes / (mb * paper::MB) as f64 - 1.0).abs() <= 0.02, "{row}"),
            None => assert_eq!(bytes, 0.0, "{row}"),
        }
    }
}

#[test]
fn a_scene_is_shown_by_region() {
    let out = stdout_of(&["scenes", "show", &room_arg(), "--json"]);
    let summary: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(summary["triangles"], 36);
    assert_eq!(summary["frames"], 3);
    assert_eq!(summary["needs"], serde_json::json!(["shadow rays", "highlights", "reflection"]));
    let bytes = |region: usize| summary["regions"][region]["bytes"].as_u64().expect("a number");
    assert_eq!(summary["regions"][2]["region"], "triangles");
    assert_eq!((bytes(2), bytes(4)), (36 * 36, 0));
    assert_eq!(Some(bytes(0)), summary["nodes"].as_u64().map(|nodes| 8 * nodes));
    assert_eq!(Some(bytes(1)), summary["references"].as_u64().map(|entries| 4 * entries));
}

#[test]
fn what_is_exported_walks_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("level.obj");
    let file = file.to_str().expect("text");
    assert_eq!(stdout_of(&["scenes", "export", "pquake3-nt", "--out", file]), "");
    let walk = |scene| stdout_of(&["walk", scene, "--frames", "9..10", "--resolution", "64x48", "--json"]);
    assert_eq!(walk(file), walk("pquake3-nt"));
}

/// Also where the run is quiet; `--strict` refuses the file.
#[test]
fn what_is_assumed_is_said() {
    let copy = RoomCopy::new();
    let obj = std::fs::read_to_string(copy.file("room.obj")).expect("text");
    let (line, usemtl) =
        (1..).zip(obj.lines()).find(|(_, line)| line.starts_with("usemtl")).expect("a material");
    copy.replace("room.obj", usemtl, "usemtl nobody");
    let scene = copy.scene();
    for verb in [&["scenes", "show"][..], &["walk", "--resolution", "16x12"]] {
        let args = [verb, &[&scene]].concat();
        let output = run(&args);
        assert_eq!(output.status.code(), Some(0));
        let stderr = String::from_utf8(output.stderr).expect("text");
        let fault = format!("{scene}:{line}: usemtl: material \"nobody\" is not defined");
        assert!(stderr.starts_with(&format!("saarcor: warning: {fault}")), "{stderr}");
        assert!(stderr.ends_with("; the default material is taken\n"), "{stderr}");
        let refusal = refusal_of(&[&args[..], &["--strict"]].concat());
        assert!(refusal.starts_with(&format!("saarcor: {fault}")), "{refusal}");
    }
}
