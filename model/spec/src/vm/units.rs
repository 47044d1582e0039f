//! Addresses and units. Each is a type of its own, so that mixing them is a type error.

use std::fmt;

/// Number of bytes. 64 bits: host and card memory of 2³² bytes each are legal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Address of a byte in the memory of the host.
///
/// 32 bits (Derived: §3 stores "the full host address of the cache line together with several
/// bits" in 5 bytes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct HostAddr(pub u32);

impl HostAddr {
    /// The address `bytes` further on.
    ///
    /// # Panics
    /// If the sum leaves the host's 32-bit address space: no record of a valid image does.
    pub fn offset(self, bytes: u32) -> Self {
        Self(self.0.checked_add(bytes).expect("an address inside the host's address space"))
    }
}

/// Address of a byte in the memory on the graphics card.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct CardAddr(pub u32);

/// A host address in units of lines: the host address without its offset bits. The tag of §3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LineAddr(pub u32);

/// Index of a set of the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct SetIndex(pub u32);

/// Number of a way of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Way(pub u8);
