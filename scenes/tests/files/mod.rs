//! Scenes in files of their own.

#![allow(dead_code, reason = "each test file takes what it needs")]

use std::fs;
use std::path::Path;

use saarcor_model::host::Scene;
use saarcor_scenes::{LoadOptions, SceneError, load_obj};
use tempfile::TempDir;

/// A square of which two corners have texture coordinates and all have a normal.
pub const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.5\nvn 0 0 1\n";

/// A folder with these files.
pub fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

/// The scene, without anything that would be a warning.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_obj(path, LoadOptions { strict: true, ..LoadOptions::default() }).map(|loaded| loaded.scene)
}

/// The error as `FILE:LINE: message`, without the folder; one line.
#[track_caller]
pub fn message<T: std::fmt::Debug>(result: Result<T, SceneError>) -> String {
    let error = result.unwrap_err();
    let text = error.to_string();
    assert_eq!(text.lines().count(), 1, "{text}");
    let folder = format!("{}/", error.path.parent().unwrap().display());
    text.replace(&folder, "")
}
