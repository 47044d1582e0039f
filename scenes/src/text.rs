//! Text files: reading them, and the words and numbers in their lines.

use std::path::Path;

use crate::error::SceneError;

/// What is wrong with a file or a word, without its place: the end of a sentence about the file, or a
/// sentence about the word.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TextError {
    #[error("no such file")]
    NoFile,
    #[error("is a directory, and a file is needed")]
    Folder,
    #[error("is a device or a pipe, and a regular file is needed")]
    Device,
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    #[error("{} is not finite in 32 bits, and must be", quoted(.0))]
    NotFinite(String),
    #[error("{} is not a number", quoted(.0))]
    NoNumber(String),
}

/// Reads a regular file.
///
/// # Errors
///
/// Why it cannot be read.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, TextError> {
    let metadata = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => TextError::NoFile,
        _ => TextError::Unreadable(error),
    })?;
    if metadata.is_dir() {
        return Err(TextError::Folder);
    }
    if !metadata.is_file() {
        return Err(TextError::Device);
    }
    std::fs::read(path).map_err(TextError::Unreadable)
}

/// Reads a text file, without its byte order mark.
///
/// # Errors
///
/// When the file cannot be read or is not UTF-8; the latter with the line.
pub(crate) fn read_text(path: &Path) -> Result<String, SceneError> {
    let bytes = read_bytes(path).map_err(|reason| SceneError::in_file(path, reason.to_string()))?;
    String::from_utf8(bytes).map(without_mark).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|&&byte| byte == b'\n').count();
        SceneError::at_line(path, line, "is not UTF-8: save the file as UTF-8 text")
    })
}

/// The text without its byte order mark.
pub(crate) fn without_mark(mut text: String) -> String {
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    text
}

/// Splits a line of an OBJ or MTL file into its keyword and what follows, both without the space
/// around them; `None` where the line is empty.
pub(crate) fn split_keyword(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    let keyword = line.split_whitespace().next()?;
    Some((keyword, line[keyword.len()..].trim_start()))
}

/// A finite number.
///
/// # Errors
///
/// What is wrong with the word.
pub(crate) fn finite(word: &str) -> Result<f32, TextError> {
    match word.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(TextError::NotFinite(word.to_owned())),
        Err(_) => Err(TextError::NoNumber(word.to_owned())),
    }
}

/// A word of a file as it can stand in a one-line message.
pub(crate) fn quoted(word: &str) -> String {
    /// Characters shown: enough to find the word by.
    const SHOWN: usize = 40;
    match word.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{:?}...", &word[..end]),
        None => format!("{word:?}"),
    }
}
