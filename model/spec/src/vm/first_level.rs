//! The first-level caches (§2, §4): one a type of functional unit, in front of the virtual memory.

use super::data_set::DataSet;
use super::hash::Hash;
use super::memory::{Memory, Unit};
use super::set::{Outcome, Policy};
use super::units::{HostAddr, LineAddr};

/// A first-level cache with lines of `BYTES` bytes, any number: lines of one item by default
/// (L1-1), as §4 caches single triangles and kd-nodes.
///
/// Line `i` begins `i · BYTES` behind `base`, where the region of the unit's items begins. What
/// lies before `base` is read from behind and not cached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct L1<const WAYS: usize, const BYTES: usize> {
    /// First address that is cached.
    pub base: HostAddr,
    /// Replacement.
    pub policy: Policy,
    /// The sets; a power of two of them, indexed by the lower bits of the line (Assumed).
    pub sets: Vec<DataSet<WAYS, BYTES>>,
    /// Lines that were found.
    pub hits: u64,
    /// Lines that were loaded.
    pub misses: u64,
}

impl<const WAYS: usize, const BYTES: usize> L1<WAYS, BYTES> {
    /// An empty cache of `sets` sets.
    ///
    /// # Panics
    /// If `sets` is not a power of two, or a line is of less than two bytes: the number of a line
    /// beyond the address space would need a bit more.
    #[must_use]
    pub fn new(base: HostAddr, sets: usize, policy: Policy) -> Self {
        assert!(
            sets.is_power_of_two() && BYTES > 1,
            "a power of two of sets, and lines of two bytes or more"
        );
        Self { base, policy, sets: vec![DataSet::empty(policy); sets], hits: 0, misses: 0 }
    }

    /// Reads `bytes` at `addr`, line by line, through `unit` of the memory `below` where a line is
    /// not here.
    pub fn read(&mut self, below: &mut impl Memory, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        let Some(place) = addr.0.checked_sub(self.base.0) else {
            below.read(unit, addr, bytes);
            return;
        };
        let (mut line, mut offset) = (LineAddr(place / BYTES as u32), place as usize % BYTES);
        let mut rest = bytes;
        while !rest.is_empty() {
            let (now, later) = rest.split_at_mut((BYTES - offset).min(rest.len()));
            now.copy_from_slice(&self.line(below, unit, line)[offset..][..now.len()]);
            (line, offset, rest) = (LineAddr(line.0 + 1), 0, later);
        }
    }

    /// The step: the bytes of a line, loaded through `unit` of the memory `below` where it is not
    /// here. Bytes beyond the end of the address space are zero.
    #[must_use]
    pub fn line(&mut self, below: &mut impl Memory, unit: Unit, line: LineAddr) -> [u8; BYTES] {
        let set = self.index_of(line);
        let first = Self::first_byte(self.base, line);
        let before = self.sets[set];
        let (next, outcome, _) = before.access(line, self.policy, || match u32::try_from(first) {
            Ok(first) => below.fetch(unit, HostAddr(first)),
            Err(_) => [0; BYTES],
        });
        self.sets[set] = next;
        match outcome {
            Outcome::Hit { .. } => self.hits += 1,
            Outcome::Miss { .. } => self.misses += 1,
        }
        next.bytes[usize::from(outcome.way().0)]
    }

    fn first_byte(base: HostAddr, line: LineAddr) -> u64 {
        u64::from(base.0) + u64::from(line.0) * BYTES as u64
    }

    fn index_of(&self, line: LineAddr) -> usize {
        Hash::Low.set_of(line, self.sets.len().ilog2()).0 as usize
    }

    /// Forgets every line that `len` bytes at `addr` meet.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        let start = u64::from(addr.0);
        let end = start.saturating_add(len);
        for set in &mut self.sets {
            for way in 0..WAYS {
                let line = set.set.lines[way];
                let first = Self::first_byte(self.base, line);
                let meets = start < end && first < end && start < first + BYTES as u64;
                if set.set.resident[way] && meets {
                    *set = set.invalidate(line).0;
                }
            }
        }
    }
}

/// Sets of each first-level cache; all have 4 ways (§2, Stated).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct L1Sizes {
    /// Sets of the shading cache, of lines of 64 bytes (Assumed).
    pub shading: usize,
    /// Sets of the cache of kd-nodes, 8 bytes each.
    pub nodes: usize,
    /// Sets of the cache of list entries, 4 bytes each.
    pub lists: usize,
    /// Sets of the cache of triangles, 36 bytes each.
    pub triangles: usize,
}

impl L1Sizes {
    /// 64 KB, 64 KB, 64 KB and 144 KB (§4, Stated).
    pub const STANDARD: Self = Self { shading: 256, nodes: 2048, lists: 4096, triangles: 1024 };
}

/// The four first-level caches, each behind its unit, in front of one memory.
#[derive(Clone, Debug)]
pub struct FirstLevel<M> {
    /// Materials, shading records, textures.
    pub shading: L1<4, 64>,
    /// kd-nodes.
    pub nodes: L1<4, 8>,
    /// List entries.
    pub lists: L1<4, 4>,
    /// Triangles.
    pub triangles: L1<4, 36>,
    /// The memory behind: the virtual memory.
    pub below: M,
}

impl<M: Memory> FirstLevel<M> {
    /// Empty caches in front of `below`; the triangles begin at `triangles`, all other regions at
    /// multiples of their lines (HI-2).
    #[must_use]
    pub fn new(sizes: L1Sizes, policy: Policy, triangles: HostAddr, below: M) -> Self {
        let base = HostAddr(0);
        Self {
            shading: L1::new(base, sizes.shading, policy),
            nodes: L1::new(base, sizes.nodes, policy),
            lists: L1::new(base, sizes.lists, policy),
            triangles: L1::new(triangles, sizes.triangles, policy),
            below,
        }
    }

    /// Forgets every line that `len` bytes at `addr` meet, for a host that writes there. The
    /// memory behind has to forget first (L1-2): a line that is loaded in between would be old.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        self.shading.invalidate(addr, len);
        self.nodes.invalidate(addr, len);
        self.lists.invalidate(addr, len);
        self.triangles.invalidate(addr, len);
    }
}

impl<M: Memory> Memory for FirstLevel<M> {
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        match unit {
            Unit::Shading => self.shading.read(&mut self.below, unit, addr, bytes),
            Unit::Traversal => self.nodes.read(&mut self.below, unit, addr, bytes),
            Unit::List => self.lists.read(&mut self.below, unit, addr, bytes),
            Unit::Intersection => self.triangles.read(&mut self.below, unit, addr, bytes),
        }
    }
}
