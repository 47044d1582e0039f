//! Accesses that somebody recorded, as virtual memories see them: a stream of addresses, frame by frame.
//!
//! A line is an access: `LABEL ADDRESS` in the form din, with the address in hex (labels 0, 1 and 2 alike: what counts is
//! which line is used), or `ADDRESS[,BYTES]`, decimal or hex behind `0x`, under a header if there is one. A line that
//! begins with `#` ends a frame; frames without accesses do not count. Only a part of the stream is in memory.

use crate::caches::{Caches, FrameCounts, Read};
use saarcor_model::vm::HostAddr;
use std::io::{self, BufRead, Read as _};

/// Accesses that are played at a time, unless they have more bytes than [`BATCH_BYTES`].
const BATCH: usize = 1 << 16;
/// Bytes of the accesses that are played at a time, about: they bound the lines that these use.
const BATCH_BYTES: u64 = 1 << 20;
/// Most bytes of an access.
const MAX_BYTES: u64 = 1 << 16;
/// Most bytes of a line.
const MAX_LINE: u64 = 256;

/// Why a trace cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// A line is no access.
    #[error("line {line}: {right}")]
    Line {
        /// Its number, from 1 on.
        line: u64,
        /// What it has, and what would be right.
        right: String,
    },
}

/// A trace that is being read.
pub struct Recorded<R> {
    input: R,
    /// Lines read so far.
    line: u64,
}

impl<R: BufRead> Recorded<R> {
    /// The trace that `input` has from here on.
    pub fn new(input: R) -> Self {
        Self { input, line: 0 }
    }

    /// Plays the next frame to `caches`, which are empty before it if `cold`: what each does. None at the end.
    ///
    /// # Errors
    /// If the input cannot be read, or a line is no access.
    pub fn next_frame(
        &mut self,
        caches: &mut Caches,
        cold: bool,
    ) -> Result<Option<Vec<FrameCounts>>, TraceError> {
        let (mut batch, mut is_begun) = (Vec::new(), false);
        loop {
            let stop = self.fill(&mut batch)?;
            if !batch.is_empty() && !is_begun {
                caches.begin_frame(cold);
                is_begun = true;
            }
            caches.play(batch.iter().copied());
            batch.clear();
            if stop == Stop::Input || stop == Stop::Frame && is_begun {
                return Ok(is_begun.then(|| caches.counts()));
            }
        }
    }

    /// Reads accesses up to the end of the frame, but not too many.
    fn fill(&mut self, batch: &mut Vec<Read>) -> Result<Stop, TraceError> {
        let (mut text, mut bytes) = (Vec::new(), 0);
        while batch.len() < BATCH && bytes < BATCH_BYTES {
            text.clear();
            let read = (&mut self.input).take(MAX_LINE).read_until(b'\n', &mut text)?;
            if read == 0 {
                return Ok(Stop::Input);
            }
            self.line += 1;
            let wrong = |right: &str| {
                let shown: String = String::from_utf8_lossy(&text).trim_end().chars().take(40).collect();
                Err(TraceError::Line { line: self.line, right: format!("'{shown}': {right}") })
            };
            if read as u64 == MAX_LINE && text.last() != Some(&b'\n') {
                return wrong(&format!("an access takes less than {MAX_LINE} bytes"));
            }
            let Ok(line) = std::str::from_utf8(&text) else { return wrong(RIGHT) };
            let line = line.trim();
            if line.starts_with('#') {
                return Ok(Stop::Frame);
            }
            match access(line) {
                Ok(Some(read)) => {
                    bytes += u64::from(read.1);
                    batch.push(read);
                }
                // Nothing, or the header of a table.
                Ok(None) if line.is_empty() || self.line == 1 => {}
                Ok(None) => return wrong(RIGHT),
                Err(right) => return wrong(right),
            }
        }
        Ok(Stop::Batch)
    }
}

/// Where reading stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    Input,
    Frame,
    Batch,
}

const RIGHT: &str =
    "write '0 ADDRESS' with the address in hex, or 'ADDRESS,BYTES'; a line that begins with # ends a frame";

/// The access of a line; none where it has no number where an address stands.
fn access(line: &str) -> Result<Option<Read>, &'static str> {
    let hex = |digits: &str| u64::from_str_radix(digits, 16).ok();
    let number = |text: &str| match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => hex(digits),
        None => text.parse().ok(),
    };
    let mut parts =
        line.split(|letter: char| letter == ',' || letter.is_whitespace()).filter(|part| !part.is_empty());
    let (first, second, third) = (parts.next().unwrap_or_default(), parts.next(), parts.next());
    let (addr, bytes) = match second {
        Some(second) if !line.contains(',') => {
            if !["0", "1", "2"].contains(&first) {
                return Ok(None);
            }
            (hex(second.trim_start_matches("0x")), Some(1))
        }
        Some(second) => (number(first), number(second)),
        None => (number(first), Some(1)),
    };
    match (addr, bytes, third) {
        (Some(addr), Some(bytes), None) => {
            let addr = u32::try_from(addr).map_err(|_| "an address has 32 bits")?;
            match (1..=MAX_BYTES).contains(&bytes) && u64::from(addr) + bytes <= 1 << 32 {
                true => Ok(Some((HostAddr(addr), bytes as u32))),
                false => {
                    Err("an access has at least one byte, at most 65536, and none beyond the end of 32 bits")
                }
            }
        }
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};

    /// Counts of each frame: accesses, lines loaded.
    fn frames(text: &str, cold: bool) -> Result<Vec<(u64, u64)>, String> {
        let geometry = Geometry::new(Bytes(256), Bytes(64), 1).expect("legal");
        let config = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        let mut caches = Caches::new(&[config], Bytes(1 << 32));
        let mut recorded = Recorded::new(text.as_bytes());
        let mut all = Vec::new();
        while let Some(counts) = recorded.next_frame(&mut caches, cold).map_err(|error| error.to_string())? {
            all.push((counts[0].accesses, counts[0].loaded));
        }
        Ok(all)
    }

    #[test]
    fn frames_end_at_comments() {
        let din = "# a walk\n0 0\n0 40\r\n\n2 7f\n#\n#\n1 0\n# end\n";
        assert_eq!(frames(din, false), Ok(vec![(3, 2), (1, 0)]));
        assert_eq!(frames(din, true), Ok(vec![(3, 2), (1, 1)]));
        assert_eq!(frames("", false), Ok(vec![]));
        assert_eq!(frames("# nothing\n", false), Ok(vec![]));
    }

    #[test]
    fn accesses_may_have_a_size_and_a_header() {
        assert_eq!(frames("address,bytes\n0x3c,8\n128,1\n0xffffffff\n", false), Ok(vec![(4, 4)]));
        assert_eq!(frames("0x0\n", false), Ok(vec![(1, 1)]));
    }

    #[test]
    fn long_frames_are_played_in_parts() {
        let line = "0 0\n0 40\n";
        assert_eq!(frames(&line.repeat(BATCH), false), Ok(vec![(2 * BATCH as u64, 2)]));
        // Of large accesses few are played at a time: each uses 1024 lines, of which the memory holds 4.
        assert_eq!(frames(&"0,65536\n".repeat(40), false), Ok(vec![(40 << 10, 40 << 10)]));
    }

    #[test]
    fn wrong_lines_are_named() {
        for (text, line, right) in [
            ("0 0\nread 40\n", 2, "'read 40': write '0 ADDRESS'"),
            ("0 0\n0 xyz\n", 2, "write '0 ADDRESS'"),
            ("0 0\n3 40\n", 2, "write '0 ADDRESS'"),
            ("0 100000000\n", 1, "32 bits"),
            ("0,0\n", 1, "at least one byte"),
            ("0xfffffff0,32\n", 1, "none beyond"),
            ("0,65537\n", 1, "at most 65536"),
            ("1,18446744073709551615\n", 1, "at most 65536"),
            ("1,2,3\n1,2,3\n", 2, "write '0 ADDRESS'"),
            (&format!("0 {}\n", "0".repeat(300)), 1, "less than 256 bytes"),
        ] {
            let error = frames(text, false).expect_err(text);
            assert!(error.starts_with(&format!("line {line}: ")) && error.contains(right), "{text}: {error}");
        }
    }
}
