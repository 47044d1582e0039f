//! The tags of version B, written for obviousness: metadata is bytes on the card, some granules of
//! which are in a list on the chip.

use crate::cache::NaiveCache;
use saarcor_model::vm::{CacheConfig, HostAddr, LineAddr, Outcome, Policy, Way};

/// Bytes of an entry (VM-12).
const ENTRY: usize = 5;

/// What an access to a granule did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GranuleEvent {
    /// The granule of this number was in the metadata cache.
    Found(u32),
    /// It was read from the on-board memory.
    Read(u32),
    /// For it, this granule was written back, with these bytes.
    WrittenBack(u32, Vec<u8>),
}

/// Which line lies where, as version B knows it: the judge of the model's `CachedMetadata`.
#[derive(Clone, Debug)]
pub struct NaiveTags {
    config: CacheConfig,
    /// Says which set a line belongs to.
    sets: NaiveCache,
    ways: usize,
    granule: usize,
    cached_ways: usize,
    /// All metadata, in the on-board memory.
    card: Vec<u8>,
    /// The granules of each set of the metadata cache, the one used last at the end.
    cached: Vec<Vec<Granule>>,
}

#[derive(Clone, Debug)]
struct Granule {
    number: usize,
    bytes: Vec<u8>,
    changed: bool,
}

/// The metadata of a line, decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    line: u32,
    resident: bool,
    order: usize,
}

impl Entry {
    /// The 40 bits; each of the last three evens out the bits whose number has its remainder by 3.
    fn bytes(self) -> Vec<u8> {
        let mut bits: Vec<bool> = (0..32).map(|bit| self.line >> bit & 1 == 1).collect();
        bits.push(self.resident);
        bits.extend((0..4).map(|bit| self.order >> bit & 1 == 1));
        for check in 37..40 {
            let ones = (check % 3..37).step_by(3).filter(|&bit| bits[bit]).count();
            bits.push(ones % 2 == 1);
        }
        let byte = |bits: &[bool]| bits.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit));
        bits.chunks(8).map(byte).collect()
    }

    /// The entry; none where the bits of a remainder are not even.
    fn of(bytes: &[u8]) -> Option<Self> {
        let bit = |bit: usize| bytes[bit / 8] >> (bit % 8) & 1 == 1;
        let even = |remainder: usize| (remainder..40).step_by(3).filter(|&place| bit(place)).count() % 2 == 0;
        let number =
            |from: usize, to: usize| (from..to).rev().fold(0, |n, place| n << 1 | usize::from(bit(place)));
        let entry = Self { line: number(0, 32) as u32, resident: bit(32), order: number(33, 37) };
        (even(0) && even(1) && even(2)).then_some(entry)
    }
}

impl NaiveTags {
    /// The tags of an empty cache, with a metadata cache of so many sets of `cached_ways` granules of
    /// `granule` bytes.
    #[must_use]
    pub fn new(config: CacheConfig, granule: usize, cached_sets: usize, cached_ways: usize) -> Self {
        let mut tags = Self {
            config,
            sets: NaiveCache::new(config),
            ways: config.geometry.ways() as usize,
            granule,
            cached_ways,
            card: Vec::new(),
            cached: vec![Vec::new(); cached_sets],
        };
        tags.flush();
        tags
    }

    /// Forgets all lines.
    pub fn flush(&mut self) {
        let lines = self.config.geometry.memory().0 / self.config.geometry.line().0;
        let entries = (0..lines as usize).flat_map(|entry| self.empty()[entry % self.ways].bytes());
        let mut card: Vec<u8> = entries.collect();
        // What is behind the last set's metadata in its granule is that of a set more.
        let unused: Vec<u8> = self.empty().into_iter().flat_map(Entry::bytes).collect();
        let behind = card.len().next_multiple_of(self.granule) - card.len();
        card.extend((0..behind).map(|place| unused[place % unused.len()]));
        self.card = card;
        self.cached.iter_mut().for_each(Vec::clear);
    }

    /// Turns bits of a byte over that lies on the card.
    pub fn flip(&mut self, byte: usize, mask: u8) {
        self.card[byte] ^= mask;
    }

    /// Uses `line`, and says what moved.
    pub fn access(&mut self, line: LineAddr, moved: &mut Vec<GranuleEvent>) -> Outcome {
        let set = self.sets.set_of(line) as usize;
        let mut entries = self.load(set, moved);
        let found = entries.iter().position(|entry| entry.resident && entry.line == line.0);
        let free = entries.iter().position(|entry| !entry.resident);
        let way = found.or(free).unwrap_or_else(|| self.victim(&entries));
        let before = entries[way];
        (entries[way].line, entries[way].resident) = (line.0, true);
        if found.is_none() || self.config.policy != Policy::Fifo {
            self.becomes_youngest(&mut entries, way);
        }
        self.store(set, &entries, moved);
        let evicted = before.resident.then_some(LineAddr(before.line));
        let way = Way(way as u8);
        if found.is_some() { Outcome::Hit { way } } else { Outcome::Miss { way, evicted } }
    }

    /// Forgets every line that `len` bytes at `addr` touch, and says what moved: one after the other; or, where they are as
    /// many as the cache has, those that the ways of the first set name, then those of the second, and so on.
    pub fn invalidate(&mut self, addr: HostAddr, len: u64, moved: &mut Vec<GranuleEvent>) {
        let line_bytes = self.config.geometry.line().0;
        // No address is beyond the 32 bits.
        let end = u64::from(addr.0).saturating_add(len).min(1 << 32);
        let first = u64::from(addr.0) / line_bytes;
        let behind_last = if len > 0 { end.div_ceil(line_bytes) } else { first };
        if behind_last - first < self.config.geometry.lines() {
            (first..behind_last).for_each(|line| self.forget(line as u32, moved));
            return;
        }
        for set in 0..self.config.geometry.sets() as usize {
            for entry in self.load(set, moved) {
                if (first..behind_last).contains(&u64::from(entry.line)) {
                    self.forget(entry.line, moved);
                }
            }
        }
    }

    fn forget(&mut self, line: u32, moved: &mut Vec<GranuleEvent>) {
        let set = self.sets.set_of(LineAddr(line)) as usize;
        let mut entries = self.load(set, moved);
        let found = entries.iter_mut().find(|entry| entry.resident && entry.line == line);
        if let Some(entry) = found {
            entry.resident = false;
            self.store(set, &entries, moved);
        }
    }

    fn empty(&self) -> Vec<Entry> {
        let order = |way| if self.config.policy == Policy::Plru { 0 } else { way };
        (0..self.ways).map(|way| Entry { line: 0, resident: false, order: order(way) }).collect()
    }

    fn victim(&self, entries: &[Entry]) -> usize {
        if self.config.policy != Policy::Plru {
            return entries[self.ways - 1].order;
        }
        let mut node = 1;
        while node < self.ways {
            node = 2 * node + entries[node].order;
        }
        node - self.ways
    }

    fn becomes_youngest(&self, entries: &mut [Entry], way: usize) {
        if self.config.policy == Policy::Plru {
            let mut node = self.ways + way;
            while node > 1 {
                entries[node / 2].order = 1 - node % 2;
                node /= 2;
            }
            return;
        }
        let mut order: Vec<usize> = entries.iter().map(|entry| entry.order).collect();
        order.retain(|&other| other != way);
        order.insert(0, way);
        entries.iter_mut().zip(order).for_each(|(entry, order)| entry.order = order);
    }

    /// Whether entries are those of a set: no line twice, and management bits that can be.
    fn legal(&self, entries: &[Entry]) -> bool {
        let mut lines: Vec<u32> =
            entries.iter().filter(|entry| entry.resident).map(|entry| entry.line).collect();
        let resident = lines.len();
        lines.sort_unstable();
        lines.dedup();
        let mut order: Vec<usize> = entries.iter().map(|entry| entry.order).collect();
        let ordered = if self.config.policy == Policy::Plru {
            order[0] == 0 && order.iter().all(|&bit| bit < 2)
        } else {
            order.sort_unstable();
            order.into_iter().eq(0..self.ways)
        };
        lines.len() == resident && ordered
    }

    /// The granules that hold metadata of a set.
    fn granules(&self, set: usize) -> std::ops::RangeInclusive<usize> {
        let bytes = self.bytes(set);
        bytes.start / self.granule..=(bytes.end - 1) / self.granule
    }

    fn bytes(&self, set: usize) -> std::ops::Range<usize> {
        let size = self.ways * ENTRY;
        set * size..(set + 1) * size
    }

    /// A set's bytes, wherever they lie.
    fn bytes_now(&self, set: usize) -> Vec<u8> {
        let now = |byte: usize| {
            let number = byte / self.granule;
            let cached =
                self.cached[number % self.cached.len()].iter().find(|cached| cached.number == number);
            cached.map_or(self.card[byte], |cached| cached.bytes[byte % self.granule])
        };
        self.bytes(set).map(now).collect()
    }

    fn decoded(&self, bytes: &[u8]) -> Option<Vec<Entry>> {
        let entries: Vec<Entry> = bytes.chunks(ENTRY).map(Entry::of).collect::<Option<_>>()?;
        self.legal(&entries).then_some(entries)
    }

    fn load(&mut self, set: usize, moved: &mut Vec<GranuleEvent>) -> Vec<Entry> {
        for granule in self.granules(set) {
            self.touch(granule, moved);
        }
        self.decoded(&self.bytes_now(set)).unwrap_or_else(|| self.empty())
    }

    /// Writes to the granules in which something changes; to all where the old bytes are corrupt.
    fn store(&mut self, set: usize, entries: &[Entry], moved: &mut Vec<GranuleEvent>) {
        let (place, old) = (self.bytes(set), self.bytes_now(set));
        let new: Vec<u8> = entries.iter().flat_map(|entry| entry.bytes()).collect();
        let corrupt = self.decoded(&old).is_none();
        for number in self.granules(set) {
            let of_set: Vec<usize> = place.clone().filter(|byte| byte / self.granule == number).collect();
            if corrupt || of_set.iter().any(|byte| old[byte - place.start] != new[byte - place.start]) {
                let size = self.granule;
                let granule = self.touch(number, moved);
                granule.changed = true;
                of_set.iter().for_each(|byte| granule.bytes[byte % size] = new[byte - place.start]);
            }
        }
    }

    /// Brings a granule into the metadata cache.
    fn touch(&mut self, number: usize, moved: &mut Vec<GranuleEvent>) -> &mut Granule {
        let sets = self.cached.len();
        let set = &mut self.cached[number % sets];
        let granule = match set.iter().position(|cached| cached.number == number) {
            Some(place) => {
                moved.push(GranuleEvent::Found(number as u32));
                set.remove(place)
            }
            None => {
                moved.push(GranuleEvent::Read(number as u32));
                let bytes = self.card[number * self.granule..][..self.granule].to_vec();
                if set.len() == self.cached_ways {
                    let oldest = set.remove(0);
                    if oldest.changed {
                        self.card[oldest.number * self.granule..][..self.granule]
                            .copy_from_slice(&oldest.bytes);
                        moved.push(GranuleEvent::WrittenBack(oldest.number as u32, oldest.bytes));
                    }
                }
                Granule { number, bytes, changed: false }
            }
        };
        set.push(granule);
        let last = set.len() - 1;
        &mut set[last]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::vm::{Bytes, Geometry, Hash};

    fn tags() -> NaiveTags {
        let geometry = Geometry::new(Bytes(8 * 16), Bytes(16), 4).expect("legal");
        NaiveTags::new(CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru }, 16, 1, 2)
    }

    #[test]
    fn entries_by_hand() {
        // Of 0x8123_4567 and the resident bit, 4, 4 and 5 ones have the remainders 0, 1 and 2.
        let entry = Entry { line: 0x8123_4567, resident: true, order: 0b1010 };
        assert_eq!(entry.bytes()[..4], [0x67, 0x45, 0x23, 0x81]);
        assert_eq!(Entry::of(&entry.bytes()), Some(entry));
        let mut bytes = entry.bytes();
        bytes[2] ^= 4;
        assert_eq!(Entry::of(&bytes), None);
    }

    #[test]
    fn granules_move_as_by_hand() {
        let (mut tags, mut moved) = (tags(), Vec::new());
        tags.access(LineAddr(0), &mut moved);
        // 20 bytes of metadata: granules 0 and 1. The first line's entry is in granule 0 alone.
        assert_eq!(moved, [GranuleEvent::Read(0), GranuleEvent::Read(1), GranuleEvent::Found(0)]);
        moved.clear();
        tags.access(LineAddr(1), &mut moved);
        assert_eq!(moved[..2], [GranuleEvent::Found(1), GranuleEvent::Read(2)]);
        // Line 0 is resident, bit 32, and 38 is the check bit of that remainder.
        assert!(matches!(&moved[2], GranuleEvent::WrittenBack(0, bytes) if bytes[..5] == [0, 0, 0, 0, 0x41]));
    }

    #[test]
    fn corrupt_metadata_makes_an_empty_set() {
        let (mut tags, mut moved) = (tags(), Vec::new());
        tags.access(LineAddr(0), &mut moved);
        for line in [1, 3] {
            tags.access(LineAddr(line), &mut moved);
        }
        tags.flip(1, 1);
        let miss = Outcome::Miss { way: Way(0), evicted: None };
        assert_eq!(tags.access(LineAddr(2), &mut moved), miss);
    }
}
