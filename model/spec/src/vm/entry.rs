//! The metadata of a line: 40 bits (§3: the full host address and several management bits, Stated).
//!
//! | bits | field |
//! |---|---|
//! | 0 .. 32 | address of the line |
//! | 32 | whether the line is resident |
//! | 33 .. 37 | one entry of [`Set::order`]: 4 bits name one of 16 ways (LRU, FIFO), PLRU uses 1 |
//! | 37 .. 40 | check bits: bit `c` makes the parity of all bits `b` with `b mod 3 = (37 + c) mod 3` even |
//!
//! The fields are Derived (VM-4, VM-5), their positions and the check bits Assumed. The check bits
//! detect every error of one bit and of up to three neighbouring bits. They do not detect an error of
//! two bits whose distance is a multiple of 3.

use super::set::{Policy, Set};
use super::units::LineAddr;

/// Bytes of metadata a line (§3, Stated).
pub const ENTRY_BYTES: usize = 5;

/// First bit of each field.
const RESIDENT: u32 = 32;
const ORDER: u32 = 33;
const CHECK: u32 = 37;
const END: u32 = 40;

/// Every third bit of an entry, from bit 0 on.
const EVERY_THIRD: u64 = 0x92_4924_9249;

/// The metadata of one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The line. Without meaning where it is not resident.
    pub line: LineAddr,
    /// Whether the line is resident.
    pub resident: bool,
    /// Management bits: one entry of [`Set::order`], under 16.
    pub order: u8,
}

/// Metadata that no encoder writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("corrupt metadata: the check bits are wrong, or the entries make no legal set")]
pub struct Corrupt;

impl Entry {
    /// The 40 bits, least significant byte first (VM-12).
    #[must_use]
    pub fn encode(self) -> [u8; ENTRY_BYTES] {
        let fields = u64::from(self.line.0)
            | u64::from(self.resident) << RESIDENT
            | u64::from(self.order & 0xf) << ORDER;
        let bits = fields | check_bits(fields) << CHECK;
        let [a, b, c, d, e, ..] = bits.to_le_bytes();
        [a, b, c, d, e]
    }

    /// The entry of 40 bits.
    ///
    /// # Errors
    /// If the check bits do not match the other bits.
    pub fn decode([a, b, c, d, e]: [u8; ENTRY_BYTES]) -> Result<Self, Corrupt> {
        let bits = u64::from_le_bytes([a, b, c, d, e, 0, 0, 0]);
        if check_bits(bits) != 0 {
            return Err(Corrupt);
        }
        Ok(Self {
            line: LineAddr(bits as u32),
            resident: bits >> RESIDENT & 1 == 1,
            order: (bits >> ORDER & 0xf) as u8,
        })
    }
}

/// The three parities, in the order of the check bits; all even in an encoded entry.
fn check_bits(bits: u64) -> u64 {
    let mut check = 0;
    for c in 0..END - CHECK {
        let parity = (bits & (EVERY_THIRD << ((CHECK + c) % 3))).count_ones() & 1;
        check |= u64::from(parity) << c;
    }
    check
}

impl<const WAYS: usize> Set<WAYS> {
    /// The encoded entries, way by way.
    #[must_use]
    pub fn to_entries(&self) -> [[u8; ENTRY_BYTES]; WAYS] {
        std::array::from_fn(|way| {
            let (line, resident, order) = (self.lines[way], self.resident[way], self.order[way]);
            Entry { line, resident, order }.encode()
        })
    }

    /// The set whose entries these are, way by way.
    ///
    /// # Errors
    /// If an entry is corrupt, or the entries together make no legal set (VM-5).
    pub fn from_entries(entries: [[u8; ENTRY_BYTES]; WAYS], policy: Policy) -> Result<Self, Corrupt> {
        let mut set = Self::empty(policy);
        for (way, bits) in entries.into_iter().enumerate() {
            let entry = Entry::decode(bits)?;
            set.lines[way] = entry.line;
            set.resident[way] = entry.resident;
            set.order[way] = entry.order;
        }
        if set.is_valid(policy) { Ok(set) } else { Err(Corrupt) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_lie_where_the_table_says() {
        let entry = Entry { line: LineAddr(0x8123_4567), resident: true, order: 0b1010 };
        let [a, b, c, d, e] = entry.encode();
        assert_eq!([a, b, c, d], [0x67, 0x45, 0x23, 0x81]);
        assert_eq!(e & 0b1_1111, 0b1_0101);
        assert_eq!(Entry::decode([a, b, c, d, e]), Ok(entry));
    }

    #[test]
    fn two_errors_three_bits_apart_are_not_detected() {
        let mut bits = Entry { line: LineAddr(0), resident: true, order: 0 }.encode();
        bits[0] ^= 0b1001;
        assert_eq!(Entry::decode(bits), Ok(Entry { line: LineAddr(0b1001), resident: true, order: 0 }));
    }
}
