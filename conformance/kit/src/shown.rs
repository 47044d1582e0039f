//! Lines of a conversation as a person sees them: whatever is invisible shows, and what differs is marked.

use std::ops::Range;

/// Most bytes of a line that are shown.
const SHOWN: usize = 200;
/// Bytes that are shown before the first difference of a line that is longer.
const BEFORE: usize = 100;

/// A line: what cannot be seen is written as `\\x20`, `\\t` or `\\u{feff}`, and a backslash twice. Of a long line the begin.
pub(crate) fn shown(line: &[u8]) -> String {
    cut(line, 0)
}

/// Two lines, each from shortly before the first difference on, where that is not near the begin.
pub(crate) fn shown_beside(line: &[u8], other: &[u8]) -> (String, String) {
    let same = line.iter().zip(other).take_while(|(byte, other)| byte == other).count();
    let begin = if same > SHOWN - BEFORE / 2 { same - BEFORE } else { 0 };
    (cut(line, begin), cut(other, begin))
}

fn cut(line: &[u8], begin: usize) -> String {
    let end = line.len().min(begin + SHOWN);
    let mut text = if begin > 0 { "…".to_owned() } else { String::new() };
    text += &visible(&line[begin..end]);
    if end < line.len() {
        text += &format!("… ({} bytes)", line.len());
    }
    text
}

/// Bytes as text in which everything shows.
pub(crate) fn visible(bytes: &[u8]) -> String {
    let mut text = String::new();
    let mut at = 0;
    for chunk in bytes.utf8_chunks() {
        for (place, c) in chunk.valid().char_indices() {
            let place = at + place;
            let is_hidden_space = place == 0 || place + 1 == bytes.len() || bytes[place - 1] == b' ';
            match c {
                ' ' if is_hidden_space => text += "\\x20",
                '\'' | '"' => text.push(c),
                _ => text.extend(c.escape_debug()),
            }
        }
        chunk.invalid().iter().for_each(|byte| text += &format!("\\x{byte:02x}"));
        at += chunk.valid().len() + chunk.invalid().len();
    }
    text
}

/// Where the words of `got` differ from those of `expected`, in bytes of `got`. Numbers with leading zeros or in
/// another case are equal, and what is not observed (`-`) does not differ.
#[must_use]
pub fn differences(expected: &str, got: &str) -> Vec<Range<usize>> {
    let bare = |word: &str| word.trim_start_matches('0').to_ascii_lowercase();
    let mut differences = Vec::new();
    let mut begin = 0;
    let mut right = expected.split(' ');
    for word in got.split(' ') {
        let right = right.next().unwrap_or_default();
        if word != "-" && bare(word) != bare(right) {
            differences.push(difference(right, word, begin));
        }
        begin += word.len() + 1;
    }
    differences
}

/// The part of a word that begins at `begin` in which it differs: all of it, where it has another length.
fn difference(right: &str, word: &str, begin: usize) -> Range<usize> {
    if right.len() != word.len() {
        return begin..begin + word.len();
    }
    let places = || word.char_indices().zip(right.chars()).filter(|((_, c), right)| c != right);
    let first = places().next().map_or(0, |((place, _), _)| place);
    let last = places().last().map_or(word.len(), |((place, c), _)| place + c.len_utf8());
    begin + first..begin + last
}

/// A line that marks those parts of `text` with `^`; none where there are none.
#[must_use]
pub fn marks(text: &str, parts: &[Range<usize>]) -> Option<String> {
    let is_marked = |place| parts.iter().any(|part| part.contains(&place));
    let marks: String =
        text.char_indices().map(|(place, _)| if is_marked(place) { '^' } else { ' ' }).collect();
    marks.contains('^').then(|| marks.trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_invisible_shows() {
        for (line, text) in [
            (&b"h 0 - 00"[..], "h 0 - 00"),
            (b"ok ", "ok\\x20"),
            (b" m  0", "\\x20m \\x200"),
            (b"o\tk\0", "o\\tk\\0"),
            (b"\\x20", "\\\\x20"),
            (
                "\u{feff}ok\u{200b}\u{a0}\u{fffe}\u{ffff}".as_bytes(),
                "\\u{feff}ok\\u{200b}\\u{a0}\\u{fffe}\\u{ffff}",
            ),
            // A lone surrogate is no text.
            (b"\xed\xa0\x80", "\\xed\\xa0\\x80"),
            (b"\xff'\"", "\\xff'\""),
        ] {
            assert_eq!(shown(line), text);
        }
    }

    #[test]
    fn long_lines_are_shown_where_they_differ() {
        let right = [b"h 0 - ".as_slice(), &b"0".repeat(1000)].concat();
        let mut wrong = right.clone();
        wrong[900] = b'1';
        let (right, wrong) = shown_beside(&right, &wrong);
        assert!(
            right != wrong && wrong.starts_with('…') && wrong.contains("001") && wrong.len() < 300,
            "{wrong}"
        );
        assert!(shown(&b"0".repeat(1000)).ends_with("0… (1000 bytes)"));
    }

    #[test]
    fn words_that_differ_are_marked() {
        let marked = |expected: &str, got: &str| marks(got, &differences(expected, got));
        assert_eq!(marked("h 0 - 0a", "h 00 - 0A"), None);
        assert_eq!(marked("m 80 none 0000", "m 90 - 0010").as_deref(), Some("  ^      ^"));
        assert_eq!(marked("m 0", "h 0 1").as_deref(), Some("^   ^"));
        assert_eq!(marked("ok", "").as_deref(), None);
    }
}
