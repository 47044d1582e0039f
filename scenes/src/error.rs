//! What is wrong with a scene's files.

use std::path::{Path, PathBuf};

/// A file of a scene that cannot be read, understood or written.
///
/// Displays as one line, `FILE:LINE: what is wrong, and what would be right`; the line number is
/// left out where the file as a whole is meant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{}: {message}", path.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
pub struct SceneError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1.
    pub line: Option<usize>,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl SceneError {
    /// An error about the file as a whole.
    pub(crate) fn in_file(path: &Path, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line: None, message: message.into() }
    }

    /// An error about a line of the file, counted from 1.
    pub(crate) fn at_line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line: Some(line), message: message.into() }
    }
}
