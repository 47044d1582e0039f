//! Runs the `saarcor` binary.

#![allow(dead_code, reason = "each test file takes what it needs")]

use saarcor_cli::cache::FOLDER;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// The binary, which is to be quiet and to keep no worlds.
pub fn saarcor(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_saarcor"));
    command.args(args).arg("--quiet").env(FOLDER, "").stdin(Stdio::null());
    command
}

/// [`saarcor`] where signals end it, also if the tests themselves run with signals ignored, as behind nohup.
pub fn saarcor_with_signals(args: &[&str]) -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal=INT,TERM,HUP", env!("CARGO_BIN_EXE_saarcor")]);
    command.args(args).arg("--quiet").env(FOLDER, "").stdin(Stdio::null());
    command
}

/// What the binary did.
pub fn run(args: &[&str]) -> Output {
    saarcor(args).output().expect("the binary starts")
}

/// The standard output of a run that succeeds and says nothing else.
pub fn stdout_of(args: &[&str]) -> String {
    let Output { status, stdout, stderr } = run(args);
    let stderr = String::from_utf8(stderr).expect("text");
    assert!(status.success() && stderr.is_empty(), "saarcor {args:?}: {status}, {stderr}");
    String::from_utf8(stdout).expect("text")
}

/// The one line on standard error of a run that refuses its input: status 2, nothing on standard
/// output.
#[track_caller]
pub fn refusal_of(args: &[&str]) -> String {
    refusal(&run(args), args)
}

/// See [`refusal_of`].
#[track_caller]
pub fn refusal(output: &Output, args: &[&str]) -> String {
    let stderr = String::from_utf8(output.stderr.clone()).expect("text");
    assert_eq!(output.status.code(), Some(2), "saarcor {args:?}: {stderr}");
    assert!(output.stdout.is_empty(), "saarcor {args:?} writes to standard output");
    assert_eq!(stderr.lines().count(), 1, "saarcor {args:?}: {stderr}");
    assert!(stderr.starts_with("saarcor: ") && stderr.ends_with('\n'), "saarcor {args:?}: {stderr}");
    stderr
}

/// A small scene of three frames: a room with a block, a mirror and a light.
pub fn room() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/room/room.obj")
}

/// The path of the room as an argument.
pub fn room_arg() -> String {
    room().to_str().expect("a path of text").to_owned()
}

/// A copy of the room to spoil, in a folder of its own that goes with the value.
pub struct RoomCopy {
    folder: tempfile::TempDir,
}

impl RoomCopy {
    /// A copy.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for file in ["room.obj", "room.mtl", "camera.csv", "lights.csv"] {
            std::fs::copy(room().with_file_name(file), folder.path().join(file)).expect("a copy");
        }
        Self { folder }
    }

    /// The file of this name.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Replaces the first occurrence of some text in a file.
    pub fn replace(&self, file: &str, from: &str, to: &str) {
        let path = self.file(file);
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.contains(from), "{file} holds {from}");
        std::fs::write(path, text.replacen(from, to, 1)).expect("written");
    }

    /// The scene's path as an argument.
    pub fn scene(&self) -> String {
        self.file("room.obj").to_str().expect("a path of text").to_owned()
    }
}
