//! The first-level caches (§2, §4): one a type of functional unit, in front of the virtual memory.

use super::data_set::DataSet;
use super::directory::Counters;
use super::hash::Hash;
use super::memory::{Memory, Unit};
use super::set::{Outcome, Policy};
use super::units::{HostAddr, LineAddr, SetIndex};
use std::ops::Range;

/// Ways of each first-level cache (§2, Stated).
pub const FIRST_LEVEL_WAYS: usize = 4;

/// Addresses end here: bytes beyond do not exist.
const END: u64 = 1 << 32;

/// A first-level cache. Its lines have any number of bytes: those of one item (L1-1), as §4 caches
/// single triangles and kd-nodes.
///
/// Line `i` begins `i × line_bytes` behind `base`, the start of the region of the unit's items.
/// Addresses below `base` are not cached. `Line` is what the cache keeps of a line: its bytes, or `()`
/// in the chip in time, where only hits and misses matter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FirstLevel<const WAYS: usize, Line> {
    /// First address that is cached.
    pub base: HostAddr,
    /// Bytes of a line.
    pub line_bytes: u32,
    /// Replacement.
    pub policy: Policy,
    /// The sets; a power of two of them, indexed by the lower bits of the line (Assumed).
    pub sets: Vec<DataSet<WAYS, Line>>,
    /// What has happened so far.
    pub counters: Counters,
}

impl<const WAYS: usize, Line: Copy> FirstLevel<WAYS, Line> {
    fn empty(base: HostAddr, line_bytes: u32, sets: usize, policy: Policy, contents: Line) -> Self {
        assert!(sets.is_power_of_two(), "{sets} sets of a first-level cache: it must be a power of two");
        assert!(line_bytes > 0, "a line of a first-level cache has at least one byte");
        let sets = vec![DataSet::empty(policy, contents); sets];
        Self { base, line_bytes, policy, sets, counters: Counters::default() }
    }

    /// The lines that `len` bytes at `addr` touch, as the numbers of [`LineAddr`]. Bytes below
    /// `base` and beyond the end of the address space touch none.
    pub fn lines_of(&self, addr: HostAddr, len: u64) -> Range<u64> {
        let (base, line_bytes) = (u64::from(self.base.0), u64::from(self.line_bytes));
        let begin = u64::from(addr.0).max(base);
        let end = u64::from(addr.0).saturating_add(len).min(END);
        let first = (begin - base) / line_bytes;
        if end <= begin { first..first } else { first..(end - 1 - base) / line_bytes + 1 }
    }

    /// The addresses of the bytes of a line that begins within the address space: those beyond
    /// its end do not exist.
    pub fn bytes_of(&self, line: LineAddr) -> Range<u64> {
        let begin = u64::from(self.base.0) + u64::from(line.0) * u64::from(self.line_bytes);
        begin..(begin + u64::from(self.line_bytes)).min(END)
    }

    /// The set of a line.
    pub fn set_of(&self, line: LineAddr) -> SetIndex {
        Hash::Low.set_of(line, self.sets.len().ilog2())
    }

    /// Whether the cache holds a line.
    pub fn is_resident(&self, line: LineAddr) -> bool {
        self.sets[self.set_of(line).0 as usize].set.way_of(line).is_some()
    }

    /// The step: uses a line, whose contents are `load`ed if it is not resident.
    pub fn access(&mut self, line: LineAddr, load: impl FnOnce() -> Line) -> Outcome {
        let set = self.set_of(line).0 as usize;
        // Units only read: no line is ever dirty.
        let (next, outcome, _) = self.sets[set].access(line, self.policy, load);
        self.sets[set] = next;
        self.counters.count(outcome);
        outcome
    }

    /// Forgets every line that `len` bytes at `addr` touch.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        let range = self.lines_of(addr, len);
        for set in &mut self.sets {
            for way in 0..WAYS {
                let line = set.set.lines[way];
                if set.set.resident[way] && range.contains(&u64::from(line.0)) {
                    *set = set.invalidate(line).0;
                    self.counters.invalidated += 1;
                }
            }
        }
    }
}

impl<const WAYS: usize> FirstLevel<WAYS, ()> {
    /// An empty cache of `sets` sets that keeps no bytes: the chip in time has these.
    ///
    /// # Panics
    /// If `sets` is not a power of two, or `line_bytes` is 0.
    pub fn new(base: HostAddr, line_bytes: u32, sets: usize, policy: Policy) -> Self {
        Self::empty(base, line_bytes, sets, policy, ())
    }
}

impl<const WAYS: usize, const BYTES: usize> FirstLevel<WAYS, [u8; BYTES]> {
    /// An empty cache of `sets` sets of lines of `BYTES` bytes.
    ///
    /// # Panics
    /// If `sets` is not a power of two, or `BYTES` is 0.
    pub fn new(base: HostAddr, sets: usize, policy: Policy) -> Self {
        Self::empty(base, BYTES as u32, sets, policy, [0; BYTES])
    }

    /// Reads `bytes` at `addr`, line by line, through `unit` of the memory `below` where a line is
    /// not resident. A read that begins below `base` goes past the cache. Bytes beyond the end of the
    /// address space are zero.
    pub fn read(&mut self, below: &mut impl Memory, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        if addr < self.base {
            below.read(unit, addr, bytes);
            return;
        }
        let mut at = u64::from(addr.0);
        let lines = self.lines_of(addr, bytes.len() as u64);
        let mut rest = bytes;
        for number in lines {
            let line = LineAddr(number as u32);
            let of_line = self.bytes_of(line);
            let here = (of_line.end - at).min(rest.len() as u64) as usize;
            let (now, later) = rest.split_at_mut(here);
            let offset = (at - of_line.start) as usize;
            now.copy_from_slice(&self.line(below, unit, line)[offset..][..here]);
            at = of_line.end;
            rest = later;
        }
        rest.fill(0);
    }

    /// The bytes of a line that begins within the address space, loaded through `unit` of the memory
    /// `below` if it is not resident.
    pub fn line(&mut self, below: &mut impl Memory, unit: Unit, line: LineAddr) -> [u8; BYTES] {
        let first = HostAddr(self.bytes_of(line).start as u32);
        let outcome = self.access(line, || below.fetch(unit, first));
        self.sets[self.set_of(line).0 as usize].contents[usize::from(outcome.way().0)]
    }
}

/// The four first-level caches, each behind its unit, in front of one memory.
#[derive(Clone, Debug)]
pub struct FirstLevelCaches<M> {
    /// Materials, shading records, textures: lines of 64 bytes (Assumed).
    pub shading: FirstLevel<FIRST_LEVEL_WAYS, [u8; 64]>,
    /// kd-nodes, 8 bytes each.
    pub nodes: FirstLevel<FIRST_LEVEL_WAYS, [u8; 8]>,
    /// List entries, 4 bytes each.
    pub lists: FirstLevel<FIRST_LEVEL_WAYS, [u8; 4]>,
    /// Triangles, 36 bytes each.
    pub triangles: FirstLevel<FIRST_LEVEL_WAYS, [u8; 36]>,
    /// The memory behind: the virtual memory.
    pub below: M,
}

impl<M: Memory> FirstLevelCaches<M> {
    /// Empty caches in front of `below`, of so many `sets` each, in the order of [`Unit::ALL`]. The
    /// triangles begin at `triangles`, all other regions at multiples of their lines (HI-2).
    ///
    /// # Panics
    /// If a number of sets is not a power of two.
    pub fn new(sets: [usize; 4], policy: Policy, triangles: HostAddr, below: M) -> Self {
        let base = HostAddr(0);
        Self {
            shading: FirstLevel::<_, [u8; 64]>::new(base, sets[0], policy),
            nodes: FirstLevel::<_, [u8; 8]>::new(base, sets[1], policy),
            lists: FirstLevel::<_, [u8; 4]>::new(base, sets[2], policy),
            triangles: FirstLevel::<_, [u8; 36]>::new(triangles, sets[3], policy),
            below,
        }
    }

    /// Forgets every line that `len` bytes at `addr` touch, for a host that writes there. The
    /// memory behind has to forget first (L1-2): a line that is loaded in between would be old.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        self.shading.invalidate(addr, len);
        self.nodes.invalidate(addr, len);
        self.lists.invalidate(addr, len);
        self.triangles.invalidate(addr, len);
    }
}

impl<M: Memory> Memory for FirstLevelCaches<M> {
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        match unit {
            Unit::Shading => self.shading.read(&mut self.below, unit, addr, bytes),
            Unit::Traversal => self.nodes.read(&mut self.below, unit, addr, bytes),
            Unit::List => self.lists.read(&mut self.below, unit, addr, bytes),
            Unit::Intersection => self.triangles.read(&mut self.below, unit, addr, bytes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vm::Way;

    #[test]
    fn lines_of_one_byte_reach_the_end_of_the_address_space() {
        let mut cache = FirstLevel::<4, ()>::new(HostAddr(0), 1, 2, Policy::Lru);
        let lines = cache.lines_of(HostAddr(u32::MAX - 1), 5);
        assert_eq!(lines, (1 << 32) - 2..1 << 32);
        let last = LineAddr(u32::MAX);
        assert_eq!(cache.bytes_of(last), (1 << 32) - 1..1 << 32);
        assert_eq!(cache.access(last, || ()), Outcome::Miss { way: Way(0), evicted: None });
        assert!(cache.is_resident(last) && !cache.is_resident(LineAddr(0)));
        cache.invalidate(HostAddr(u32::MAX), 1);
        assert!(!cache.is_resident(last));
    }

    #[test]
    fn lines_are_counted_from_the_base() {
        let cache = FirstLevel::<4, ()>::new(HostAddr(100), 36, 1, Policy::Lru);
        assert_eq!(cache.lines_of(HostAddr(100), 36), 0..1);
        assert_eq!(cache.lines_of(HostAddr(135), 2), 0..2);
        assert_eq!(cache.lines_of(HostAddr(90), 10), 0..0);
        assert_eq!(cache.lines_of(HostAddr(90), 11), 0..1);
        assert_eq!(cache.lines_of(HostAddr(140), 0), 1..1);
        assert_eq!(cache.bytes_of(LineAddr(1)), 136..172);
    }
}
