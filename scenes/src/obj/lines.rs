//! The text of OBJ and MTL files, in whatever encoding, and its lines, however they end.

use std::path::Path;

use memchr::{memchr_iter, memchr2};

use crate::error::SceneError;
use crate::text::{read_bytes, without_mark};
use crate::warning::Warnings;

/// Reads an OBJ or MTL file that is UTF-8, UTF-16 with a byte order mark, or else taken for Latin-1.
/// `recognise` says whether the content is of another format, which is refused.
///
/// # Errors
/// When the file cannot be read or is of another format.
pub(crate) fn read(
    path: &Path,
    recognise: impl FnOnce(&[u8]) -> Option<String>,
    warnings: &mut Warnings,
) -> Result<String, SceneError> {
    let bytes = read_bytes(path).map_err(|reason| SceneError::in_file(path, reason.to_string()))?;
    if let Some(reason) = recognise(&bytes) {
        return Err(SceneError::in_file(path, reason));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => without_mark(text),
        Err(error) => {
            let valid = error.utf8_error().valid_up_to();
            let bytes = error.into_bytes();
            let line = 1 + memchr_iter(b'\n', &bytes[..valid]).count();
            let fault = || SceneError::at_line(path, line, "is not UTF-8: save the file as UTF-8 text");
            match utf_16(&bytes) {
                Some(text) => {
                    warnings.note("its byte order mark says UTF-16", fault)?;
                    text
                }
                None => {
                    warnings.note("it is taken for Latin-1", fault)?;
                    bytes.into_iter().map(char::from).collect()
                }
            }
        }
    };
    let bytes = text.as_bytes();
    let alone = memchr_iter(b'\r', bytes).find(|&at| bytes.get(at + 1).is_some_and(|&next| next != b'\n'));
    if let Some(at) = alone {
        let line = 1 + memchr_iter(b'\n', &bytes[..at]).count();
        warnings.note("the line ends there", || {
            SceneError::at_line(path, line, "a carriage return without a line feed: save the file as text")
        })?;
    }
    Ok(text)
}

/// The text of UTF-16 that begins with a byte order mark.
fn utf_16(bytes: &[u8]) -> Option<String> {
    let (mark, rest) = bytes.split_first_chunk()?;
    let unit: fn([u8; 2]) -> u16 = match mark {
        [0xff, 0xfe] => u16::from_le_bytes,
        [0xfe, 0xff] => u16::from_be_bytes,
        _ => return None,
    };
    let units = rest.as_chunks().0.iter().map(|&pair| unit(pair));
    Some(char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect())
}

/// A line: its number, counted from 1, where in the text it begins, and what it says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    pub(crate) number: usize,
    pub(crate) begin: usize,
    pub(crate) text: &'a str,
}

/// The lines of a text, which end with a line feed, a carriage return or both.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    text: &'a str,
    number: usize,
    begin: usize,
}

impl<'a> Lines<'a> {
    /// The lines of `text`.
    pub(crate) fn new(text: &'a str) -> Self {
        Self { text, number: 0, begin: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let begin = self.begin;
        let rest = self.text.get(begin..).filter(|rest| !rest.is_empty())?;
        let length = memchr2(b'\n', b'\r', rest.as_bytes()).unwrap_or(rest.len());
        let ends_with_both = rest.as_bytes()[length..].starts_with(b"\r\n");
        self.begin = begin + length + if ends_with_both { 2 } else { 1 };
        self.number += 1;
        Some(Line { number: self.number, begin, text: &rest[..length] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let text = "a\nb\r\nc\rd\r\r\n\ne";
        let lines: Vec<_> = Lines::new(text).map(|line| (line.number, line.text)).collect();
        assert_eq!(lines, [(1, "a"), (2, "b"), (3, "c"), (4, "d"), (5, ""), (6, ""), (7, "e")]);
        assert!(Lines::new(text).all(|line| text[line.begin..].starts_with(line.text)));
        assert_eq!(Lines::new("").count(), 0);
    }

    #[test]
    fn utf_16_has_a_mark() {
        let bytes = |units: &[u16]| units.iter().flat_map(|unit| unit.to_be_bytes()).collect::<Vec<_>>();
        let units: Vec<u16> = "\u{feff}v 0 é".encode_utf16().collect();
        assert_eq!(utf_16(&bytes(&units)).as_deref(), Some("v 0 é"));
        let swapped: Vec<u16> = units.iter().map(|unit| unit.swap_bytes()).collect();
        assert_eq!(utf_16(&bytes(&swapped)).as_deref(), Some("v 0 é"));
        assert_eq!(utf_16(&bytes(&[0xfeff, 0xd800])).as_deref(), Some("\u{fffd}"));
        assert_eq!(utf_16(b"v 0"), None);
    }
}
