//! What lies on the card in a run of the chip in time, and whether parts read the host's bytes.

use saarcor_model::time::{ChipConfig, Load, Version};
use saarcor_model::vm::{HostAddr, LineAddr};
use std::fmt;

/// A shadow of the card's contents. It is given the writes of lines and the reads of parts of a run, in
/// the order in which the memory chips serve them, and compares each part with the bytes of the host.
#[derive(Clone, Debug)]
pub struct CardShadow<'a> {
    host: &'a [u8],
    /// Bytes of a line; 0 without virtual memory, where bytes lie on the card where they lie in the host.
    line_bytes: u64,
    /// The bytes on the card, and for each place the line that was written to it last.
    card: Vec<u8>,
    places: Vec<Option<LineAddr>>,
    /// Parts that were compared.
    pub parts: u64,
    /// Parts that differ, and the first of them.
    pub wrong: u64,
    /// The first part that differs.
    pub first: Option<Difference>,
}

/// A part that does not read the bytes of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The cycle of the read.
    pub cycle: u64,
    /// The part: its first byte in the host, and its bytes.
    pub addr: HostAddr,
    /// Its bytes.
    pub bytes: u64,
    /// Where on the card it is read.
    pub card: u64,
    /// The line in which it lies.
    pub expected: LineAddr,
    /// The line that lies there; none if none was written there.
    pub found: Option<LineAddr>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cycle, addr, bytes, card, expected, found } = self;
        write!(
            f,
            "cycle {cycle}: the part of {bytes} bytes at {:#x} of the host is read at {card:#x} of the card, ",
            addr.0
        )?;
        write!(f, "where line {:#x} is expected and ", expected.0)?;
        match found {
            Some(line) => write!(f, "line {:#x} is found", line.0),
            None => f.write_str("nothing was written"),
        }
    }
}

impl<'a> CardShadow<'a> {
    /// The shadow of an empty card, of a chip whose host memory begins with the bytes `host` and goes on
    /// with zeros.
    #[must_use]
    pub fn new(host: &'a [u8], config: &ChipConfig) -> Self {
        let geometry = config.cache.geometry;
        let (line_bytes, memory) = match config.version {
            Version::None => (0, 0),
            Version::A | Version::B => (geometry.line().0, geometry.memory().0),
        };
        let places = memory.checked_div(line_bytes).unwrap_or(0);
        Self {
            host,
            line_bytes,
            card: vec![0; memory as usize],
            places: vec![None; places as usize],
            parts: 0,
            wrong: 0,
            first: None,
        }
    }

    /// The byte of the host at an address.
    fn host_byte(&self, addr: u64) -> u8 {
        self.host.get(addr as usize).copied().unwrap_or(0)
    }

    /// A line of the host is written to its place.
    ///
    /// # Panics
    /// If its place is none of the card's.
    pub fn write(&mut self, Load { line, card }: Load) {
        let begin = u64::from(line.0) * self.line_bytes;
        for byte in 0..self.line_bytes {
            self.card[(card + byte) as usize] = self.host_byte(begin + byte);
        }
        self.places[(card / self.line_bytes) as usize] = Some(line);
    }

    /// A part is read in a cycle: `bytes` of the host from `addr` on, at address `card` of the card.
    pub fn read(&mut self, cycle: u64, addr: HostAddr, bytes: u64, card: u64) {
        self.parts += 1;
        let begin = u64::from(addr.0);
        let (is_right, expected, found) = if let Some(line) = begin.checked_div(self.line_bytes) {
            let expected = LineAddr(line as u32);
            let found = self.places.get((card / self.line_bytes) as usize).copied().flatten();
            let is_byte = |byte| self.card.get((card + byte) as usize) == Some(&self.host_byte(begin + byte));
            (found == Some(expected) && (0..bytes).all(is_byte), expected, found)
        } else {
            (card == begin, LineAddr(addr.0), Some(LineAddr(card as u32)))
        };
        if !is_right {
            self.wrong += 1;
            self.first.get_or_insert(Difference { cycle, addr, bytes, card, expected, found });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};

    #[test]
    fn differences_are_named() {
        let geometry = Geometry::new(Bytes(32), Bytes(8), 2).expect("legal");
        let cache = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        let host: Vec<u8> = (0..20).collect();
        let mut shadow = CardShadow::new(&host, &ChipConfig::standard(Version::A, cache));
        shadow.write(Load { line: LineAddr(2), card: 8 });
        shadow.read(3, HostAddr(18), 4, 10);
        assert_eq!((shadow.parts, shadow.wrong), (1, 0));
        shadow.read(4, HostAddr(3), 4, 11);
        shadow.read(5, HostAddr(18), 4, 18);
        assert_eq!((shadow.parts, shadow.wrong), (3, 2));
        let first = shadow.first.expect("a difference").to_string();
        let says = "cycle 4: the part of 4 bytes at 0x3 of the host is read at 0xb of the card, where line 0x0 \
                    is expected and line 0x2 is found";
        assert_eq!(first, says);
    }
}
