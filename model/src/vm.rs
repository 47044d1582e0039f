//! The virtual memory in the bus manager (§3): the on-board memory as a cache of host memory.

use crate::geometry::Geometry;
use crate::hash::Hash;
use crate::memory::{HostMemory, Memory, Port};
use crate::set::{Outcome, Policy, Set};
use crate::units::{HostAddr, LineAddr, SetIndex};
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
    /// Lines that were pushed out by a load.
    pub evictions: u64,
    /// Lines that were forgotten by an invalidation.
    pub invalidated: u64,
}

impl Counters {
    /// Accesses that found their line resident.
    #[must_use]
    pub fn hits(&self) -> u64 {
        self.accesses - self.misses
    }
}

/// The metadata of all lines: which line lies where. Version A keeps it on the chip (§3).
///
/// The directory decides; [`VirtualMemory`] moves the bytes. A run that needs only the traffic
/// uses the directory alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directory<const WAYS: usize> {
    config: CacheConfig,
    sets: Vec<Set<WAYS>>,
    counters: Counters,
}

impl<const WAYS: usize> Directory<WAYS> {
    /// The directory of an empty cache.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of `config.geometry`.
    #[must_use]
    pub fn new(config: CacheConfig) -> Self {
        assert_eq!(config.geometry.ways() as usize, WAYS, "the type and the geometry name the ways alike");
        let sets = vec![Set::empty(config.policy); config.geometry.sets() as usize];
        Self { config, sets, counters: Counters::default() }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &CacheConfig {
        &self.config
    }

    /// The sets, in the order of their indices.
    #[must_use]
    pub fn sets(&self) -> &[Set<WAYS>] {
        &self.sets
    }

    /// What has happened so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Uses `line`: one step of its set (VM-6).
    // A call would cost more than the step that it makes: half of the throughput, measured.
    #[inline(always)]
    pub fn access(&mut self, line: LineAddr) -> Outcome {
        self.counters.accesses += 1;
        let set = &mut self.sets[self.config.set_of(line).0 as usize];
        if let Some(way) = set.way_if_youngest(line, self.config.policy) {
            return Outcome::Hit { way };
        }
        let (next, outcome) = set.access(line, self.config.policy);
        *set = next;
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
            for set in 0..self.sets.len() {
                for line in self.sets[set].lines {
                    if lines.contains(&u64::from(line.0)) {
                        self.invalidate_line(line);
                    }
                }
            }
        }
    }

    fn invalidate_line(&mut self, line: LineAddr) {
        let set = &mut self.sets[self.config.set_of(line).0 as usize];
        let (next, way) = set.invalidate(line);
        *set = next;
        self.counters.invalidated += u64::from(way.is_some());
    }

    /// Forgets all lines; the counters go on.
    pub fn flush(&mut self) {
        self.sets.fill(Set::empty(self.config.policy));
    }
}

/// The virtual memory: the on-board memory, its directory, and the bus to host memory.
#[derive(Clone, Debug)]
pub struct VirtualMemory<H, const WAYS: usize> {
    directory: Directory<WAYS>,
    card: Vec<u8>,
    host: H,
}

impl<H: HostMemory, const WAYS: usize> VirtualMemory<H, WAYS> {
    /// An empty cache in front of `host`.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of `config.geometry`.
    #[must_use]
    pub fn new(config: CacheConfig, host: H) -> Self {
        let card = vec![0; config.geometry.memory().0 as usize];
        Self { directory: Directory::new(config), card, host }
    }

    /// Which line lies where.
    #[must_use]
    pub fn directory(&self) -> &Directory<WAYS> {
        &self.directory
    }

    /// The host's memory, to write to it; what is written has then to be invalidated.
    pub fn host_mut(&mut self) -> &mut H {
        &mut self.host
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
        let CacheConfig { geometry, .. } = *self.directory.config();
        let line = geometry.line_of(addr);
        let outcome = self.directory.access(line);
        let set = self.directory.config().set_of(line);
        let start = geometry.card_addr(set, outcome.way()).0 as usize;
        let line_on_card = &mut self.card[start..][..geometry.line().0 as usize];
        if let Outcome::Miss { .. } = outcome {
            self.host.read(geometry.first_byte(line), line_on_card);
        }
        bytes.copy_from_slice(&line_on_card[geometry.offset_of(addr) as usize..][..bytes.len()]);
        outcome
    }
}

impl<H: HostMemory, const WAYS: usize> Memory for VirtualMemory<H, WAYS> {
    fn read(&mut self, _port: Port, addr: HostAddr, bytes: &mut [u8]) {
        let geometry = self.directory.config().geometry;
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
