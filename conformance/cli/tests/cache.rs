//! Kept scenes: what `saarcor cache` shows and removes, and what its limit does.

mod common;

use common::{refusal, run, saarcor};
use saarcor_cli::cache::{FOLDER, LIMIT};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

/// A scene that is kept: it has 46 356 triangles.
const SCENE: &str = "pquake3-nlnt";
const WALK: [&str; 6] = ["walk", SCENE, "--frames", "100..101", "--resolution", "64x48"];

/// What the binary does that keeps scenes in `folder`, as much as `limit` says.
fn keeping(folder: &Path, limit: Option<&str>, args: &[&str]) -> Output {
    let mut command = saarcor(args);
    command.env(FOLDER, folder);
    if let Some(limit) = limit {
        command.env(LIMIT, limit);
    }
    command.output().expect("the binary starts")
}

fn rows(output: &Output) -> Vec<Value> {
    let stdout = String::from_utf8_lossy(&output.stdout);
    stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn kept_scenes_are_listed_verified_and_removed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().join("kept");
    let saarcor = |args: &[&str]| keeping(&folder, None, args);
    let first = saarcor(&WALK);
    assert!(first.status.success());
    assert_eq!(saarcor(&WALK).stdout, first.stdout);
    assert_eq!(run(&WALK).stdout, first.stdout);

    let listed = saarcor(&["cache", "--json"]);
    let [row] = &rows(&listed)[..] else { panic!("{listed:?}") };
    assert_eq!(
        (&row["scene"], &row["state"], &row["triangles"]),
        (&SCENE.into(), &"ready".into(), &46_356.into())
    );
    let files = || fs::read_dir(&folder).expect("a folder").map(|file| file.expect("an entry"));
    let bytes: u64 = files().map(|file| file.metadata().expect("a file").len()).sum();
    assert_eq!(row["bytes"], bytes);
    let text = String::from_utf8(saarcor(&["cache"]).stdout).expect("text");
    assert!(
        text.contains(SCENE) && text.contains("ready") && text.contains("MB of at most 4GiB in"),
        "{text}"
    );

    let verify = || saarcor(&["cache", "list", "--verify", "--json"]);
    assert!(verify().status.success());
    let image = files().map(|file| file.path()).find(|file| file.extension() == Some("image".as_ref()));
    let image = image.expect("an image");
    let mut spoilt = fs::read(&image).expect("a file");
    spoilt[4096] ^= 1;
    fs::write(&image, spoilt).expect("written");
    let found = verify();
    assert_eq!((found.status.code(), &rows(&found)[0]["state"]), (Some(1), &"damaged".into()));
    assert!(saarcor(&["cache", "--json"]).stdout.is_empty());

    assert_eq!(saarcor(&WALK).stdout, first.stdout);
    fs::write(folder.join("notes"), "somebody's").expect("written");
    assert_eq!(
        rows(&saarcor(&["cache", "empty", "--json"])),
        [serde_json::json!({ "scenes": 1, "bytes": bytes })]
    );
    assert_eq!(files().map(|file| file.file_name()).collect::<Vec<_>>(), ["notes"]);
}

#[test]
fn limit_is_a_size() {
    let folder = tempfile::tempdir().expect("a folder");
    for args in [&WALK[..], &["cache"], &["cache", "empty"]] {
        let output = keeping(folder.path(), Some("4GB"), args);
        let line = refusal(&output, args);
        assert!(line.contains("SAARCOR_CACHE_LIMIT=4GB") && line.contains("8MiB"), "{line}");
    }
    assert!(keeping(folder.path(), Some("1MiB"), &WALK).status.success());
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    let text = keeping(folder.path(), Some("1MiB"), &["cache"]).stdout;
    assert!(String::from_utf8_lossy(&text).starts_with("0.00 MB of at most 1MiB in "));
}

#[test]
fn without_a_folder_nothing_is_kept() {
    for args in [&["cache"][..], &["cache", "empty"], &["cache", "--verify"]] {
        let output = run(args);
        assert!(output.status.success());
        assert_eq!(String::from_utf8_lossy(&output.stdout), "no scenes are kept: SAARCOR_CACHE is empty\n");
    }
    assert!(run(&["cache", "--json"]).stdout.is_empty());
}
