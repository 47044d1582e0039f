//! The on-board cache, written for obviousness.
//!
//! A set is a list of slots and a list of their numbers in the order in which they give up their
//! lines. Addresses are taken apart by `/` and `%`.

use saarcor_model::vm::{CacheConfig, Counters, Hash, HostAddr, LineAddr, Outcome, Policy, Way};
use std::collections::HashMap;

/// One past the last host address: addresses have 32 bits.
const END_OF_ADDRESSES: u64 = 1 << 32;

/// Which line lies where: the judge of the model's `Directory`.
#[derive(Clone, Debug)]
pub struct NaiveCache {
    line_bytes: u64,
    ways: usize,
    sets: u64,
    hash: Hash,
    policy: Policy,
    /// The sets that have been used.
    contents: HashMap<u64, NaiveSet>,
    counters: Counters,
}

#[derive(Clone, Debug)]
struct NaiveSet {
    /// The line in each way.
    slots: Vec<Option<LineAddr>>,
    /// The ways that hold a line. FIFO: in order of loading. LRU and PLRU: in order of last use.
    order: Vec<usize>,
}

impl NaiveCache {
    /// An empty cache.
    #[must_use]
    pub fn new(config: CacheConfig) -> Self {
        let line_bytes = config.geometry.line().0;
        let ways = config.geometry.ways();
        Self {
            line_bytes,
            ways: ways as usize,
            sets: config.geometry.memory().0 / line_bytes / u64::from(ways),
            hash: config.hash,
            policy: config.policy,
            contents: HashMap::new(),
            counters: Counters::default(),
        }
    }

    /// What has happened so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// The number of the set that `line` belongs to.
    ///
    /// To take "the lower bits" is to take the remainder by the number of sets, and "the upper
    /// bits" are the quotient (§3).
    #[must_use]
    pub fn set_of(&self, line: LineAddr) -> u64 {
        let line = u64::from(line.0);
        match self.hash {
            Hash::Low => line % self.sets,
            Hash::AddUpper => (line / self.sets + line % self.sets) % self.sets,
            Hash::AddUpperAll => digits(line, self.sets).iter().sum::<u64>() % self.sets,
        }
    }

    /// The line in each way of the set of that number; all free where it has not been used.
    #[must_use]
    pub fn slots(&self, set: u64) -> Vec<Option<LineAddr>> {
        self.contents.get(&set).map_or_else(|| vec![None; self.ways], |set| set.slots.clone())
    }

    /// Uses `line`.
    pub fn access(&mut self, line: LineAddr) -> Outcome {
        let (index, ways) = (self.set_of(line), self.ways);
        let set = self
            .contents
            .entry(index)
            .or_insert_with(|| NaiveSet { slots: vec![None; ways], order: Vec::new() });
        self.counters.accesses += 1;

        if let Some(way) = set.slots.iter().position(|&slot| slot == Some(line)) {
            if self.policy != Policy::Fifo {
                set.order.retain(|&other| other != way);
                set.order.push(way);
            }
            return Outcome::Hit { way: Way(way as u8) };
        }

        self.counters.misses += 1;
        let way = match set.slots.iter().position(Option::is_none) {
            Some(free) => free,
            None if self.policy == Policy::Plru => plru_victim(&set.order, 0, ways),
            None => set.order[0],
        };
        let evicted = set.slots[way].replace(line);
        self.counters.evictions += u64::from(evicted.is_some());
        set.order.retain(|&other| other != way);
        set.order.push(way);
        Outcome::Miss { way: Way(way as u8), evicted }
    }

    /// Forgets every line that `len` bytes at `addr` touch: of all lines that there are, those of
    /// which a byte lies in the range.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        let (first, line_bytes) = (u64::from(addr.0), self.line_bytes);
        let touched = |line: LineAddr| {
            let begin = u64::from(line.0) * line_bytes;
            len > 0 && begin < first.saturating_add(len) && first < begin + line_bytes
        };
        for set in self.contents.values_mut() {
            for way in 0..self.ways {
                if set.slots[way].is_some_and(touched) {
                    set.slots[way] = None;
                    set.order.retain(|&other| other != way);
                    self.counters.invalidated += 1;
                }
            }
        }
    }

    /// Forgets all lines; the counters go on.
    pub fn flush(&mut self) {
        self.contents.clear();
    }
}

/// The digits of `number` to that base, the lowest first. To base 1 there is only the digit 0.
fn digits(mut number: u64, base: u64) -> Vec<u64> {
    let mut digits = vec![number % base];
    while base > 1 && number >= base {
        number /= base;
        digits.push(number % base);
    }
    digits
}

/// The way, of `from .. to`, that tree-PLRU gives up: of the two halves the one without the way
/// used last, and so on within that half.
///
/// `order` holds the ways in order of last use, all of them: only a full set has a victim.
fn plru_victim(order: &[usize], from: usize, to: usize) -> usize {
    if to - from == 1 {
        return from;
    }
    let middle = (from + to) / 2;
    let used_last = order.iter().rfind(|&&way| from <= way && way < to);
    match used_last {
        Some(&way) if way < middle => plru_victim(order, middle, to),
        _ => plru_victim(order, from, middle),
    }
}

/// A cache that keeps a copy of each resident line: the judge of the model's `VirtualMemory`.
#[derive(Clone, Debug)]
pub struct NaiveVirtualMemory {
    cache: NaiveCache,
    /// Each line's bytes as they were when it was last loaded.
    copies: HashMap<LineAddr, Vec<u8>>,
}

impl NaiveVirtualMemory {
    /// An empty cache.
    #[must_use]
    pub fn new(config: CacheConfig) -> Self {
        Self { cache: NaiveCache::new(config), copies: HashMap::new() }
    }

    /// Which line lies where.
    #[must_use]
    pub fn cache(&self) -> &NaiveCache {
        &self.cache
    }

    /// Forgets every line that `len` bytes at `addr` touch.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        self.cache.invalidate(addr, len);
    }

    /// Forgets all lines.
    pub fn flush(&mut self) {
        self.cache.flush();
    }

    /// Reads `len` bytes at `addr`, one by one: each is its line's, and a line is used once for
    /// all of its bytes. Bytes beyond the end of `host` and of the address space are zero.
    pub fn read(&mut self, host: &[u8], addr: HostAddr, len: usize) -> Vec<u8> {
        let line_bytes = self.cache.line_bytes;
        let mut in_use = None;
        let mut bytes = Vec::new();
        for byte in (u64::from(addr.0)..).take(len) {
            if byte >= END_OF_ADDRESSES {
                bytes.push(0);
                continue;
            }
            let line = LineAddr((byte / line_bytes) as u32);
            if in_use != Some(line) {
                in_use = Some(line);
                if let Outcome::Miss { .. } = self.cache.access(line) {
                    self.copies.insert(line, copy_of(host, line, line_bytes));
                }
            }
            bytes.push(self.copies[&line][(byte % line_bytes) as usize]);
        }
        bytes
    }
}

fn copy_of(host: &[u8], line: LineAddr, line_bytes: u64) -> Vec<u8> {
    let first = u64::from(line.0) * line_bytes;
    (first..first + line_bytes).map(|byte| host.get(byte as usize).copied().unwrap_or(0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::vm::{Bytes, Geometry};

    fn config(sets: u64, ways: u32, line: u64, hash: Hash, policy: Policy) -> CacheConfig {
        let memory = Bytes(sets * u64::from(ways) * line);
        CacheConfig { geometry: Geometry::new(memory, Bytes(line), ways).expect("legal"), hash, policy }
    }

    /// The lines that one set of four gives up.
    fn victims(policy: Policy, lines: &[u32]) -> Vec<u32> {
        let mut cache = NaiveCache::new(config(1, 4, 16, Hash::Low, policy));
        let evicted = lines.iter().filter_map(|&line| match cache.access(LineAddr(line)) {
            Outcome::Miss { evicted, .. } => evicted.map(|line| line.0),
            Outcome::Hit { .. } => None,
        });
        evicted.collect()
    }

    #[test]
    fn victims_by_hand() {
        let lines = [0, 1, 2, 3, 0, 1, 10, 11, 12];
        assert_eq!(victims(Policy::Lru, &lines), [2, 3, 0]);
        assert_eq!(victims(Policy::Fifo, &lines), [0, 1, 2]);
        // 1 was used last, so the upper half is due, and of it the way that 3 is not in. Then the
        // lower half is, and of it the way that 1 is not in.
        assert_eq!(victims(Policy::Plru, &lines), [2, 0, 3]);
    }

    /// Belady, Nelson and Shedler (1969): FIFO faults 10 times on this string with four frames
    /// (9 times with three), LRU 8 times.
    #[test]
    fn beladys_string() {
        let string = [1, 2, 3, 4, 1, 2, 5, 1, 2, 3, 4, 5];
        let misses = |policy| {
            let mut cache = NaiveCache::new(config(1, 4, 16, Hash::Low, policy));
            for line in string {
                cache.access(LineAddr(line));
            }
            cache.counters().misses
        };
        assert_eq!((misses(Policy::Fifo), misses(Policy::Lru)), (10, 8));
    }

    #[test]
    fn sets_by_hand() {
        let set_of = |hash, line| NaiveCache::new(config(16, 1, 1, hash, Policy::Lru)).set_of(LineAddr(line));
        assert_eq!(set_of(Hash::Low, 0x321), 0x1);
        assert_eq!(set_of(Hash::AddUpper, 0x321), 0x3);
        assert_eq!(set_of(Hash::AddUpperAll, 0x321), 0x6);
        assert_eq!(set_of(Hash::AddUpperAll, 0xf02), 0x1);
    }

    #[test]
    fn one_set_has_number_zero() {
        for hash in [Hash::Low, Hash::AddUpper, Hash::AddUpperAll] {
            assert_eq!(NaiveCache::new(config(1, 1, 1, hash, Policy::Lru)).set_of(LineAddr(u32::MAX)), 0);
        }
    }

    #[test]
    fn freed_way_is_filled_first() {
        let mut cache = NaiveCache::new(config(1, 4, 16, Hash::Low, Policy::Lru));
        for line in 0..4 {
            cache.access(LineAddr(line));
        }
        cache.invalidate(HostAddr(31), 2);
        assert_eq!(cache.slots(0), [Some(LineAddr(0)), None, None, Some(LineAddr(3))]);
        assert_eq!(cache.access(LineAddr(9)), Outcome::Miss { way: Way(1), evicted: None });
        let expected = Counters { accesses: 5, misses: 5, evictions: 0, invalidated: 2 };
        assert_eq!(cache.counters(), expected);
    }

    #[test]
    fn invalidation_stops_at_the_end_of_the_addresses() {
        let mut cache = NaiveCache::new(config(4, 1, 16, Hash::Low, Policy::Lru));
        cache.access(LineAddr(0));
        cache.invalidate(HostAddr(u32::MAX), 100);
        assert_eq!(cache.counters().invalidated, 0);
    }

    #[test]
    fn resident_line_keeps_its_bytes_until_it_is_invalidated() {
        let mut memory = NaiveVirtualMemory::new(config(1, 2, 4, Hash::Low, Policy::Lru));
        assert_eq!(memory.read(&[1, 2, 3, 4, 5], HostAddr(2), 4), [3, 4, 5, 0]);
        assert_eq!(memory.read(&[9; 8], HostAddr(2), 4), [3, 4, 5, 0]);
        memory.invalidate(HostAddr(4), 1);
        assert_eq!(memory.read(&[9; 8], HostAddr(2), 4), [3, 4, 9, 9]);
        assert_eq!(memory.cache().counters().accesses, 6);
    }

    #[test]
    fn flush_forgets_lines_and_keeps_counters() {
        let mut memory = NaiveVirtualMemory::new(config(1, 2, 4, Hash::Low, Policy::Lru));
        memory.read(&[1], HostAddr(0), 1);
        memory.flush();
        assert_eq!(memory.read(&[2], HostAddr(0), 1), [2]);
        assert_eq!(memory.cache().counters().misses, 2);
    }
}
