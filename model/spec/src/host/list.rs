//! Lists of triangle addresses in host memory: those of a leaf follow one another (HI-3).

use crate::vm::HostAddr;

/// Bytes of a list entry (Assumed: a host address).
pub const LIST_ENTRY_BYTES: u32 = 4;

/// An entry of a leaf's list as the chip reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListEntry {
    /// Address of the triangle, a multiple of 4.
    pub triangle: HostAddr,
    /// What the triangle test needs beside the triangle's bytes: [`TriangleRecord::tag`](super::TriangleRecord::tag), 2 bits.
    pub tag: u32,
}

impl ListEntry {
    /// Reads an entry: an address whose two lowest bits are the tag (HI-3, Assumed).
    pub fn decode(bytes: [u8; LIST_ENTRY_BYTES as usize]) -> Self {
        let entry = u32::from_le_bytes(bytes);
        Self { triangle: HostAddr(entry & !3), tag: entry & 3 }
    }

    /// The bytes that [`ListEntry::decode`] reads.
    pub fn encode(self) -> [u8; LIST_ENTRY_BYTES as usize] {
        (self.triangle.0 | self.tag).to_le_bytes()
    }
}
