//! The directory: which line lies in which set and way of the on-board memory (§3).

use super::geometry::Geometry;
use super::hash::Hash;
use super::set::{Outcome, Policy, Set};
use super::units::{HostAddr, LineAddr, SetIndex};
use super::version_a::{Metadata, OnChip};
use std::ops::Range;

/// Everything that decides how a cache behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CacheConfig {
    /// Sizes.
    pub geometry: Geometry,
    /// Index hash.
    pub hash: Hash,
    /// Replacement.
    pub policy: Policy,
}

impl CacheConfig {
    /// The set of `line`.
    pub fn set_of(&self, line: LineAddr) -> SetIndex {
        self.hash.set_of(line, self.geometry.set_bits())
    }

    /// The lines that `len` bytes at `addr` touch (VM-10), as the numbers of [`LineAddr`].
    ///
    /// Nothing is touched beyond the end of the 32-bit address space.
    pub fn lines_of(&self, addr: HostAddr, len: u64) -> Range<u64> {
        let line_of = |addr| u64::from(self.geometry.line_of(addr).0);
        let first = line_of(addr);
        if len == 0 {
            return first..first;
        }
        let last = u64::from(addr.0).saturating_add(len - 1).min(u64::from(u32::MAX));
        first..line_of(HostAddr(last as u32)) + 1
    }
}

/// Counts of what has happened in a cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counters {
    /// Accesses: lines touched; an item that straddles two lines is two.
    pub accesses: u64,
    /// Accesses that loaded their line from the host.
    pub misses: u64,
    /// Lines that a load evicted.
    pub evictions: u64,
    /// Lines that an invalidation forgot.
    pub invalidated: u64,
}

impl Counters {
    /// Counts one access.
    pub fn count(&mut self, outcome: Outcome) {
        self.accesses += 1;
        if let Outcome::Miss { evicted, .. } = outcome {
            self.misses += 1;
            self.evictions += u64::from(evicted.is_some());
        }
    }

    /// Accesses that found their line resident.
    pub fn hits(&self) -> u64 {
        self.accesses - self.misses
    }
}

/// Decides which line lies where.
///
/// The directory decides; [`VirtualMemory`](super::VirtualMemory) moves the bytes. A run that needs only
/// the traffic uses the directory alone. The fields are public, so that a proof can start from any state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directory<const WAYS: usize, M = OnChip<WAYS>> {
    /// Sizes, hash and replacement.
    pub config: CacheConfig,
    /// Where the states of the sets are kept.
    pub metadata: M,
    /// What has happened so far.
    pub counters: Counters,
}

impl<const WAYS: usize> Directory<WAYS> {
    /// The directory of an empty cache of version A.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of `config.geometry`.
    pub fn new(config: CacheConfig) -> Self {
        Self::over(config, OnChip::new(config.geometry.sets(), config.policy))
    }

    /// The sets, in the order of their indices.
    pub fn sets(&self) -> &[Set<WAYS>] {
        &self.metadata.sets
    }
}

impl<const WAYS: usize, M: Metadata<WAYS>> Directory<WAYS, M> {
    /// A directory that keeps its metadata in `metadata`.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of `config.geometry`.
    pub fn over(config: CacheConfig, metadata: M) -> Self {
        assert_eq!(config.geometry.ways() as usize, WAYS, "the ways of the type are those of the geometry");
        Self { config, metadata, counters: Counters::default() }
    }

    /// Uses `line`: one step of its set (VM-6).
    pub fn access(&mut self, line: LineAddr) -> Outcome {
        let index = self.config.set_of(line);
        let (next, outcome) = self.metadata.load(index).access(line, self.config.policy);
        self.metadata.store(index, &next);
        self.counters.count(outcome);
        outcome
    }

    /// Forgets every line that `len` bytes at `addr` touch, for a host that writes there (VM-8).
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        let lines = self.config.lines_of(addr, len);
        if lines.end - lines.start < self.config.geometry.lines() {
            for line in lines {
                self.invalidate_line(LineAddr(line as u32));
            }
        } else {
            // The range has more lines than the cache: go through the lines of the cache instead.
            for set in self.config.geometry.set_numbers() {
                for line in self.metadata.load(SetIndex(set as u32)).lines {
                    if lines.contains(&u64::from(line.0)) {
                        self.invalidate_line(line);
                    }
                }
            }
        }
    }

    fn invalidate_line(&mut self, line: LineAddr) {
        let index = self.config.set_of(line);
        let (next, way) = self.metadata.load(index).invalidate(line);
        if way.is_some() {
            self.metadata.store(index, &next);
            self.counters.invalidated += 1;
        }
    }

    /// Forgets all lines; the counters keep their values.
    pub fn flush(&mut self) {
        self.metadata.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vm::Bytes;

    /// Metadata of any number of sets, which has no memory for it: it ends the test at the first set that is
    /// asked for.
    struct NoMemory;

    impl Metadata<1> for NoMemory {
        fn load(&mut self, index: SetIndex) -> Set<1> {
            panic!("{index:?} is looked at")
        }

        fn store(&mut self, _: SetIndex, _: &Set<1>) {}

        fn clear(&mut self) {}
    }

    #[test]
    #[should_panic(expected = "SetIndex(0) is looked at")]
    fn all_addresses_are_invalidated_among_the_most_sets_that_there_can_be() {
        let geometry = Geometry::new(Bytes(1 << 32), Bytes(1), 1).expect("legal");
        let config = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        Directory::over(config, NoMemory).invalidate(HostAddr(0), u64::MAX);
    }
}
