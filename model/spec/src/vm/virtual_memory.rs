//! The virtual memory in the bus manager (§3): the on-board memory as a cache of host memory.

use super::geometry::Geometry;
use super::hash::Hash;
use super::memory::{HostMemory, Memory, Unit};
use super::set::{Outcome, Policy, Set};
use super::units::{HostAddr, LineAddr, SetIndex};
use std::ops::Range;

/// Everything that a cache's behaviour depends on.
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
    #[inline]
    #[must_use]
    pub fn set_of(&self, line: LineAddr) -> SetIndex {
        self.hash.set_of(line, self.geometry.set_bits())
    }

    /// The lines that `len` bytes at `addr` touch (VM-10), as the numbers of [`LineAddr`].
    ///
    /// Nothing is touched beyond the end of the 32-bit address space.
    #[inline]
    #[must_use]
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

/// What a cache has done since it was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counters {
    /// Accesses: lines touched; an item that straddles two lines is two.
    pub accesses: u64,
    /// Accesses that loaded their line from the host.
    pub misses: u64,
    /// Lines that were evicted by a load.
    pub evictions: u64,
    /// Lines that were forgotten by an invalidation.
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
    #[must_use]
    pub fn hits(&self) -> u64 {
        self.accesses - self.misses
    }
}

/// Where the metadata of the sets is kept: this is all in which the versions of §3 differ.
pub trait Metadata<const WAYS: usize> {
    /// The state of the set `index`.
    fn load(&mut self, index: SetIndex) -> Set<WAYS>;

    /// Replaces the state of the set `index`.
    fn store(&mut self, index: SetIndex, set: &Set<WAYS>);

    /// Forgets all lines.
    fn clear(&mut self);
}

/// Version A: the metadata of all sets lies on the chip (§3).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnChip<const WAYS: usize> {
    policy: Policy,
    /// The sets, in the order of their indices.
    pub sets: Vec<Set<WAYS>>,
}

impl<const WAYS: usize> OnChip<WAYS> {
    /// The metadata of an empty cache.
    #[must_use]
    pub fn new(config: &CacheConfig) -> Self {
        let sets = vec![Set::empty(config.policy); config.geometry.sets() as usize];
        Self { policy: config.policy, sets }
    }
}

impl<const WAYS: usize> Metadata<WAYS> for OnChip<WAYS> {
    #[inline]
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        self.sets[index.0 as usize]
    }

    #[inline]
    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        self.sets[index.0 as usize] = *set;
    }

    fn clear(&mut self) {
        self.sets.fill(Set::empty(self.policy));
    }
}

/// Decides which line lies where.
///
/// The directory decides; [`VirtualMemory`] moves the bytes. A run that needs only the traffic
/// uses the directory alone. The fields are public, so that a proof can start from any state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directory<const WAYS: usize, M = OnChip<WAYS>> {
    /// Everything that it depends on.
    pub config: CacheConfig,
    /// The states of its sets.
    pub metadata: M,
    /// What has happened so far.
    pub counters: Counters,
}

impl<const WAYS: usize> Directory<WAYS> {
    /// The directory of an empty cache of version A.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of `config.geometry`.
    #[must_use]
    pub fn new(config: CacheConfig) -> Self {
        Self::over(config, OnChip::new(&config))
    }

    /// The sets, in the order of their indices.
    #[must_use]
    pub fn sets(&self) -> &[Set<WAYS>] {
        &self.metadata.sets
    }
}

impl<const WAYS: usize, M: Metadata<WAYS>> Directory<WAYS, M> {
    /// A directory that keeps its metadata in `metadata`.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of `config.geometry`.
    #[must_use]
    pub fn over(config: CacheConfig, metadata: M) -> Self {
        assert_eq!(config.geometry.ways() as usize, WAYS, "the type and the geometry name the ways alike");
        Self { config, metadata, counters: Counters::default() }
    }

    /// Uses `line`: one step of its set (VM-6).
    // A call would cost more than the step that it makes: half of the throughput, measured.
    #[inline(always)]
    pub fn access(&mut self, line: LineAddr) -> Outcome {
        self.counters.accesses += 1;
        let index = self.config.set_of(line);
        let set = self.metadata.load(index);
        if let Some(way) = set.way_if_youngest(line, self.config.policy) {
            return Outcome::Hit { way };
        }
        let (next, outcome) = set.access(line, self.config.policy);
        self.metadata.store(index, &next);
        if let Outcome::Miss { evicted, .. } = outcome {
            self.counters.misses += 1;
            self.counters.evictions += u64::from(evicted.is_some());
        }
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
            // The range has more lines than the cache: ask each line of the cache instead.
            for set in 0..self.config.geometry.sets() as u32 {
                for line in self.metadata.load(SetIndex(set)).lines {
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

    /// Forgets all lines; the counters go on.
    pub fn flush(&mut self) {
        self.metadata.clear();
    }
}

/// The virtual memory: the on-board memory, its directory, and the bus to host memory.
///
/// The fields are public, so that a proof can start from any state. What is written to `host` has
/// then to be invalidated.
#[derive(Clone, Debug)]
pub struct VirtualMemory<H, const WAYS: usize, M = OnChip<WAYS>> {
    /// Which line lies where.
    pub directory: Directory<WAYS, M>,
    /// The lines on the card, at their card addresses.
    pub card: Vec<u8>,
    /// The host's memory.
    pub host: H,
}

impl<H: HostMemory, const WAYS: usize, M: Metadata<WAYS>> VirtualMemory<H, WAYS, M> {
    /// The cache that `directory` keeps in front of `host`.
    ///
    /// # Panics
    /// If the directory is not empty: its lines would not be on the card.
    #[must_use]
    pub fn new(directory: Directory<WAYS, M>, host: H) -> Self {
        assert_eq!(directory.counters.accesses, 0, "an empty card needs an empty directory");
        let card = vec![0; directory.config.geometry.memory().0 as usize];
        Self { directory, card, host }
    }

    /// Forgets every line that `len` bytes at `addr` touch (VM-8).
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        self.directory.invalidate(addr, len);
    }

    /// Forgets all lines.
    pub fn flush(&mut self) {
        self.directory.flush();
    }

    /// Reads bytes that lie within one line. A miss loads the whole line from the host first.
    ///
    /// # Panics
    /// If the bytes do not lie within one line.
    pub fn read_in_line(&mut self, addr: HostAddr, bytes: &mut [u8]) -> Outcome {
        let config = self.directory.config;
        let geometry = config.geometry;
        let line = geometry.line_of(addr);
        let outcome = self.directory.access(line);
        let start = geometry.card_addr(config.set_of(line), outcome.way()).0 as usize;
        let line_on_card = &mut self.card[start..][..geometry.line().0 as usize];
        if let Outcome::Miss { .. } = outcome {
            self.host.read(geometry.first_byte(line), line_on_card);
        }
        bytes.copy_from_slice(&line_on_card[geometry.offset_of(addr) as usize..][..bytes.len()]);
        outcome
    }
}

impl<H: HostMemory, const WAYS: usize, M: Metadata<WAYS>> Memory for VirtualMemory<H, WAYS, M> {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        let geometry = self.directory.config.geometry;
        let (mut addr, mut rest) = (addr, bytes);
        while !rest.is_empty() {
            let room = geometry.line().0 - u64::from(geometry.offset_of(addr));
            let here = room.min(rest.len() as u64) as usize;
            let (now, later) = rest.split_at_mut(here);
            self.read_in_line(addr, now);
            rest = later;
            let Some(next) = addr.0.checked_add(here as u32) else {
                // The end of the address space: no memory has bytes beyond it.
                rest.fill(0);
                return;
            };
            addr = HostAddr(next);
        }
    }
}
