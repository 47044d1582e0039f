//! Text in lines, parts of which are repeated: what is long is in memory once.

use memchr::memchr;
use std::ops::Range;

/// Lines, in parts that follow one another, each a number of times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Script {
    bytes: Vec<u8>,
    parts: Vec<Part>,
    len: usize,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    /// Its bytes, which end with a line.
    bytes: Range<usize>,
    times: usize,
    /// Where it begins in the text.
    begin: usize,
}

impl Script {
    /// With room for so many bytes, not counting what is repeated.
    pub fn with_capacity(bytes: usize) -> Self {
        Self { bytes: Vec::with_capacity(bytes), ..Self::default() }
    }

    /// Bytes of the text.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Appends lines, so many times.
    pub fn push(&mut self, lines: &[u8], times: usize) {
        self.push_with(times, |bytes| bytes.extend_from_slice(lines));
    }

    /// Appends, so many times, the lines that `push` appends.
    pub fn push_with(&mut self, times: usize, push: impl FnOnce(&mut Vec<u8>)) {
        let begin = self.bytes.len();
        push(&mut self.bytes);
        let bytes = begin..self.bytes.len();
        if bytes.is_empty() || times == 0 {
            return self.bytes.truncate(begin);
        }
        self.len += times * bytes.len();
        match self.parts.last_mut() {
            Some(last) if self.bytes[last.bytes.clone()] == self.bytes[bytes.clone()] => {
                last.times += times;
                self.bytes.truncate(begin);
            }
            _ => self.parts.push(Part { begin: self.len - times * bytes.len(), bytes, times }),
        }
    }

    /// Appends another text, of whose lines `edit` makes others, or none.
    pub fn push_edited<'a>(&mut self, other: &'a Self, mut edit: impl FnMut(&'a [u8]) -> Option<&'a [u8]>) {
        for part in &other.parts {
            let lines = &other.bytes[part.bytes.clone()];
            for _ in 0..part.times {
                self.push_with(1, |bytes| {
                    for line in Lines(lines).filter_map(&mut edit) {
                        bytes.extend_from_slice(line);
                        bytes.push(b'\n');
                    }
                });
            }
        }
    }

    /// Gives back the room that is not needed.
    pub fn shrink_to_fit(&mut self) {
        self.bytes.shrink_to_fit();
    }

    /// What stands at a place of the text, at least to the end of its line; empty at the end.
    #[inline]
    pub fn at(&self, place: usize) -> &[u8] {
        let later = self.parts.partition_point(|part| part.begin <= place);
        let Some(part) = later.checked_sub(1).map(|last| &self.parts[last]) else { return &[] };
        if place >= self.len {
            return &[];
        }
        let within = (place - part.begin) % part.bytes.len();
        &self.bytes[part.bytes.start + within..part.bytes.end]
    }

    /// The lines, without their newlines.
    pub fn lines(&self) -> impl Iterator<Item = &[u8]> {
        let repeated = |part: &Part| std::iter::repeat_n(&self.bytes[part.bytes.clone()], part.times);
        self.parts.iter().flat_map(repeated).flat_map(Lines)
    }
}

/// The lines of text, without their newlines.
struct Lines<'a>(&'a [u8]);

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        if self.0.is_empty() {
            return None;
        }
        let end = memchr(b'\n', self.0).unwrap_or(self.0.len());
        let line = &self.0[..end];
        self.0 = self.0.get(end + 1..).unwrap_or_default();
        Some(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(script: &Script) -> Vec<u8> {
        let mut text = Vec::new();
        while text.len() < script.len() {
            text.extend_from_slice(script.at(text.len()));
        }
        assert!(script.at(text.len()).is_empty());
        let lines: Vec<u8> = script.lines().flat_map(|line| [line, b"\n"].concat()).collect();
        assert_eq!(lines, text);
        text
    }

    #[test]
    fn what_is_repeated_is_in_memory_once() {
        let mut script = Script::default();
        script.push(b"a\n", 1);
        script.push(b"b\nc\n", 3);
        script.push(b"", 5);
        script.push(b"b\nc\n", 2);
        script.push(b"d\n", 0);
        script.push(b"d\n", 1);
        assert_eq!(whole(&script), b"a\nb\nc\nb\nc\nb\nc\nb\nc\nb\nc\nd\n");
        assert_eq!((script.bytes.len(), script.parts.len()), (8, 3));
        assert_eq!((script.at(4), script.at(5)), (&b"c\n"[..], &b"\n"[..]));
    }

    /// Leaving out some lines of a text that is repeated leaves it repeated.
    #[test]
    fn what_is_edited_stays_repeated() {
        let mut script = Script::default();
        script.push(b"a\nb\n", 100);
        let mut place = 0;
        let mut edited = Script::default();
        edited.push_edited(&script, |line| {
            place += 1;
            match place {
                20..=59 => None,
                100 => Some(b"c"),
                _ => Some(line),
            }
        });
        let text = [&b"a\nb\n".repeat(9)[..], b"a\nb\n", &b"a\nb\n".repeat(19), b"a\nc\n"].concat();
        let text = [text, b"a\nb\n".repeat(50)].concat();
        assert!(whole(&edited) == text);
        assert!(edited.bytes.len() <= 20, "{}", edited.bytes.len());
    }
}
