//! The shape of the on-board cache, and the size of its metadata (§3).

use super::entry::ENTRY_BYTES;
use super::units::{Bytes, CardAddr, HostAddr, LineAddr, SetIndex, Way};
use std::ops::Range;

/// Most ways a set can have (Assumed: twice what caches of the time had).
pub const MAX_WAYS: u32 = 16;

/// Most bytes of on-board memory: what a [`CardAddr`] reaches (Derived).
pub const MAX_MEMORY: Bytes = Bytes(1 << 32);

/// Shape of the on-board cache: `sets × ways` lines of `k` bytes (VM-1).
///
/// All sizes are powers of two, so that a host address splits into line and offset by bits.
/// A value of this type is always legal: [`Geometry::new`] refuses all others.
///
/// ```
/// use saarcor_model::vm::{Bytes, Geometry};
/// let card = Geometry::new(Bytes(16 << 20), Bytes(128), 4)?;
/// assert_eq!((card.lines(), card.sets()), (131_072, 32_768));
/// assert_eq!(card.metadata(), Bytes(640 << 10)); // §3: "640 KB"
/// # Ok::<(), saarcor_model::vm::GeometryError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Geometry {
    memory_bits: u32,
    line_bits: u32,
    way_bits: u32,
}

/// Why sizes do not make a cache. Each names the value found and what would be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeometryError {
    /// The memory is no power of two, or zero.
    #[error("memory of {0} bytes: it must be a power of two, such as {example}", example = example(*.0, "8MiB"))]
    Memory(Bytes),
    /// The memory is larger than [`MAX_MEMORY`].
    #[error("memory of {0} bytes: a card address has 32 bits, so at most {MAX_MEMORY} bytes")]
    MemoryTooLarge(Bytes),
    /// The line is no power of two, or zero.
    #[error("line of {0} bytes: it must be a power of two, such as {example}", example = example(*.0, "128"))]
    Line(Bytes),
    /// The number of ways is no power of two, zero, or over [`MAX_WAYS`].
    #[error("{0} ways: it must be a power of two from 1 to {MAX_WAYS}")]
    Ways(u32),
    /// The memory is smaller than one set.
    #[error(
        "memory of {memory} bytes is smaller than one set of {set} bytes (line × ways): \
         take more memory, shorter lines or fewer ways"
    )]
    NoSet {
        /// Bytes of the memory.
        memory: Bytes,
        /// Bytes of one set: line × ways.
        set: Bytes,
    },
}

/// A legal size close to an illegal one.
fn example(illegal: Bytes, instead_of_zero: &str) -> String {
    match illegal {
        Bytes(0) => instead_of_zero.to_owned(),
        Bytes(n) => nearest_power(n).to_string(),
    }
}

/// The power of two that is nearest to `n > 0`; of two, the lower one.
fn nearest_power(n: u64) -> u64 {
    let below = 1 << n.ilog2();
    if n - below > below / 2 && below < 1 << 63 { below << 1 } else { below }
}

impl Geometry {
    /// The shape with these sizes.
    ///
    /// # Errors
    /// If a size is zero or no power of two, the memory is larger than [`MAX_MEMORY`] or smaller than one
    /// set, or there are more than [`MAX_WAYS`] ways.
    pub fn new(memory: Bytes, line: Bytes, ways: u32) -> Result<Self, GeometryError> {
        if !memory.0.is_power_of_two() {
            return Err(GeometryError::Memory(memory));
        }
        if memory > MAX_MEMORY {
            return Err(GeometryError::MemoryTooLarge(memory));
        }
        if !line.0.is_power_of_two() {
            return Err(GeometryError::Line(line));
        }
        if !ways.is_power_of_two() || ways > MAX_WAYS {
            return Err(GeometryError::Ways(ways));
        }
        let (memory_bits, line_bits, way_bits) =
            (memory.0.trailing_zeros(), line.0.trailing_zeros(), ways.trailing_zeros());
        if line_bits + way_bits > memory_bits {
            // Saturating: a line of 2⁶³ bytes is a legal power of two and an absurd one.
            return Err(GeometryError::NoSet { memory, set: Bytes(line.0.saturating_mul(u64::from(ways))) });
        }
        Ok(Self { memory_bits, line_bits, way_bits })
    }

    /// Size of the on-board memory.
    pub fn memory(self) -> Bytes {
        Bytes(1 << self.memory_bits)
    }

    /// Size `k` of a line.
    pub fn line(self) -> Bytes {
        Bytes(1 << self.line_bits)
    }

    /// Lines a set.
    pub fn ways(self) -> u32 {
        1 << self.way_bits
    }

    /// Lines that the memory holds.
    pub fn lines(self) -> u64 {
        1 << (self.memory_bits - self.line_bits)
    }

    /// Number of sets.
    pub fn sets(self) -> u64 {
        1 << self.set_bits()
    }

    /// All sets, in order, as the numbers of [`SetIndex`]. There may be 2³² of them, and that many does not fit
    /// into 32 bits.
    pub fn set_numbers(self) -> Range<u64> {
        0..self.sets()
    }

    /// Binary logarithm of the number of sets.
    pub fn set_bits(self) -> u32 {
        self.memory_bits - self.line_bits - self.way_bits
    }

    /// Size of the metadata: 5 bytes × memory / k (VM-2; §3, Stated).
    pub fn metadata(self) -> Bytes {
        Bytes(ENTRY_BYTES as u64 * self.lines())
    }

    /// The line that holds the byte at `addr`.
    pub fn line_of(self, addr: HostAddr) -> LineAddr {
        // A line of 2³² bytes has all 32 address bits as its offset.
        LineAddr((u64::from(addr.0) >> self.line_bits) as u32)
    }

    /// The offset of the byte at `addr` within its line.
    pub fn offset_of(self, addr: HostAddr) -> u32 {
        addr.0 & ((1u64 << self.line_bits) - 1) as u32
    }

    /// How many of `len` bytes from `addr` on lie in the line of `addr`, and where the next line begins; none where
    /// the address space ends.
    pub fn split_at_line_end(self, addr: HostAddr, len: u64) -> (u64, Option<HostAddr>) {
        let room = self.line().0 - u64::from(self.offset_of(addr));
        (room.min(len), u32::try_from(u64::from(addr.0) + room).ok().map(HostAddr))
    }

    /// Address of the first byte of `line`.
    pub fn first_byte(self, line: LineAddr) -> HostAddr {
        HostAddr((u64::from(line.0) << self.line_bits) as u32)
    }

    /// The card address of the first byte of the line in `way` of `set`: the ways of a set follow one
    /// another (Assumed).
    pub fn card_addr(self, set: SetIndex, way: Way) -> CardAddr {
        let slot = u64::from(set.0) << self.way_bits | u64::from(way.0);
        CardAddr((slot << self.line_bits) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_examples_of_metadata() {
        let at = |k| Geometry::new(Bytes(16 << 20), Bytes(k), 4).map(Geometry::metadata);
        assert_eq!(at(128), Ok(Bytes(655_360)));
        assert_eq!(at(1024), Ok(Bytes(81_920)));
    }

    #[test]
    fn constructor_is_total() {
        let interesting = [0, 1, 2, 3, 127, 128, 1 << 20, 1 << 32, 1 << 33, 1 << 63, u64::MAX];
        for memory in interesting {
            for line in interesting {
                for ways in [0, 1, 3, 4, 16, 32, u32::MAX] {
                    if let Err(e) = Geometry::new(Bytes(memory), Bytes(line), ways) {
                        assert!(!e.to_string().is_empty());
                    }
                }
            }
        }
    }

    #[test]
    fn refusals_name_the_nearest_power() {
        for (size, nearest) in [(3, 2), (5, 4), (6, 4), (7, 8), (100, 128), (3 << 61, 1 << 62)] {
            assert_eq!(nearest_power(size), nearest, "{size}");
        }
        assert_eq!(nearest_power((3 << 61) + 1), 1 << 63);
        assert_eq!(nearest_power(u64::MAX), 1 << 63);
    }

    #[test]
    fn messages_name_the_size_and_a_legal_one_close_to_it() {
        let message =
            |memory, line| Geometry::new(Bytes(memory), Bytes(line), 4).expect_err("illegal").to_string();
        assert_eq!(message(100, 128), "memory of 100 bytes: it must be a power of two, such as 128");
        assert_eq!(message(0, 128), "memory of 0 bytes: it must be a power of two, such as 8MiB");
        assert_eq!(message(1 << 20, 36), "line of 36 bytes: it must be a power of two, such as 32");
        assert_eq!(message(1 << 20, 0), "line of 0 bytes: it must be a power of two, such as 128");
    }

    #[test]
    fn one_line_may_span_the_whole_address_space() {
        let g = Geometry::new(Bytes(1 << 32), Bytes(1 << 32), 1).expect("legal");
        assert_eq!(g.line_of(HostAddr(u32::MAX)), LineAddr(0));
        assert_eq!(g.offset_of(HostAddr(u32::MAX)), u32::MAX);
        assert_eq!(g.first_byte(LineAddr(0)), HostAddr(0));
    }
}
