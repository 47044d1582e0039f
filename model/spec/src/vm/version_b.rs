//! Version B (§3, §4): the metadata lies in the on-board memory, and the chip keeps a part of it
//! in a small write-back cache.
//!
//! The metadata of a set is that of its ways, way by way; the sets follow one another (Assumed).
//! The cache is filled and written back in granules of `GRANULE` bytes, a parameter: the metadata
//! of a set may straddle granules.

use super::data_set::{DataSet, WriteBack};
use super::entry::{Corrupt, ENTRY_BYTES};
use super::hash::Hash;
use super::set::{Outcome, Policy, Set};
use super::units::{LineAddr, SetIndex, Way};
use super::virtual_memory::{CacheConfig, Metadata};

/// Is told what goes through the metadata cache.
pub trait Watch<const GRANULE: usize> {
    /// A granule was asked for; for it another one may have been written back.
    fn granule(&mut self, granule: LineAddr, outcome: Outcome, write_back: Option<WriteBack<[u8; GRANULE]>>);

    /// The metadata of a set was corrupt, and the set was taken for empty (VM-14).
    fn corrupt(&mut self);
}

/// Counts what went through the metadata cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct MetadataTraffic {
    /// Granules asked for: to read the metadata of a set, and again to write what changed.
    pub accesses: u64,
    /// Granules read from the on-board memory.
    pub loads: u64,
    /// Granules written back to it.
    pub write_backs: u64,
    /// Sets whose metadata was corrupt, and which were taken for empty (VM-14).
    pub corrupt: u64,
}

impl<const GRANULE: usize> Watch<GRANULE> for MetadataTraffic {
    fn granule(&mut self, _: LineAddr, outcome: Outcome, write_back: Option<WriteBack<[u8; GRANULE]>>) {
        self.accesses += 1;
        self.loads += u64::from(matches!(outcome, Outcome::Miss { .. }));
        self.write_backs += u64::from(write_back.is_some());
    }

    fn corrupt(&mut self) {
        self.corrupt += 1;
    }
}

/// The metadata of version B: `WAYS` ways a set of lines, `META_WAYS` ways a set of granules (4 in
/// the paper: §4, Stated).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CachedMetadata<
    const WAYS: usize,
    const META_WAYS: usize,
    const GRANULE: usize,
    W = MetadataTraffic,
> {
    /// Replacement of lines: says which metadata is legal.
    pub lines: Policy,
    /// Replacement of granules (LRU Assumed).
    pub granules: Policy,
    /// The metadata cache; a power of two of sets, indexed by the granule's lower bits (Assumed).
    pub cache: Vec<DataSet<META_WAYS, [u8; GRANULE]>>,
    /// The metadata in the on-board memory: whole granules.
    pub card: Vec<u8>,
    /// What went through the metadata cache.
    pub traffic: W,
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize>
    CachedMetadata<WAYS, META_WAYS, GRANULE>
{
    /// The metadata of an empty cache of lines, behind an empty metadata cache of `sets` sets.
    ///
    /// # Panics
    /// If `sets` is not a power of two.
    #[must_use]
    pub fn new(config: &CacheConfig, sets: usize, granules: Policy) -> Self {
        Self::watched(config, sets, granules, MetadataTraffic::default())
    }
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, W: Watch<GRANULE>>
    CachedMetadata<WAYS, META_WAYS, GRANULE, W>
{
    /// Bytes of metadata a set of lines.
    const SET_BYTES: usize = WAYS * ENTRY_BYTES;
    /// Granules that a set meets at most.
    const MOST_GRANULES: usize = (Self::SET_BYTES - 1).div_ceil(GRANULE) + 1;

    /// The same, of which `watch` is told what goes through the metadata cache.
    ///
    /// # Panics
    /// If `sets` is not a power of two.
    #[must_use]
    pub fn watched(config: &CacheConfig, sets: usize, granules: Policy, watch: W) -> Self {
        assert!(sets.is_power_of_two(), "{sets} sets of metadata: it must be a power of two");
        let bytes = config.geometry.sets() as usize * Self::SET_BYTES;
        let mut new = Self {
            lines: config.policy,
            granules,
            cache: vec![DataSet::empty(granules, [0; GRANULE]); sets],
            card: vec![0; bytes.next_multiple_of(GRANULE)],
            traffic: watch,
        };
        new.clear();
        new
    }

    /// Granule and offset of byte `i` of the metadata of the set `index`.
    fn place(index: SetIndex, i: usize) -> (LineAddr, usize) {
        let byte = index.0 as usize * Self::SET_BYTES + i;
        (LineAddr((byte / GRANULE) as u32), byte % GRANULE)
    }

    /// The granules that hold metadata of the set `index`, one after another; none for a `k` beyond.
    fn granule(index: SetIndex, k: usize) -> Option<LineAddr> {
        let (first, last) = (Self::place(index, 0).0, Self::place(index, Self::SET_BYTES - 1).0);
        let granule = LineAddr(first.0 + k as u32);
        (granule.0 <= last.0).then_some(granule)
    }

    fn cached(&self, granule: LineAddr) -> usize {
        Hash::Low.set_of(granule, self.cache.len().ilog2()).0 as usize
    }

    /// The metadata of a set as the cache and the on-board memory together hold it (VM-13).
    #[must_use]
    pub fn entries(&self, index: SetIndex) -> [[u8; ENTRY_BYTES]; WAYS] {
        let mut entries = [[0; ENTRY_BYTES]; WAYS];
        for k in 0..Self::MOST_GRANULES {
            let Some(granule) = Self::granule(index, k) else { break };
            let cached = self.cache[self.cached(granule)];
            let mut bytes = [0; GRANULE];
            match cached.set.way_of(granule) {
                Some(way) => bytes = cached.contents[usize::from(way.0)],
                None => bytes.copy_from_slice(&self.card[granule.0 as usize * GRANULE..][..GRANULE]),
            }
            for (i, byte) in entries.as_flattened_mut().iter_mut().enumerate() {
                let (there, offset) = Self::place(index, i);
                if there == granule {
                    *byte = bytes[offset];
                }
            }
        }
        entries
    }

    /// Brings a granule into the cache: the set and the way where it is.
    fn bring(&mut self, granule: LineAddr) -> (usize, Way) {
        let cached = self.cached(granule);
        let before = self.cache[cached];
        let (next, outcome, write_back) = before.access(granule, self.granules, || {
            let mut bytes = [0; GRANULE];
            bytes.copy_from_slice(&self.card[granule.0 as usize * GRANULE..][..GRANULE]);
            bytes
        });
        self.cache[cached] = next;
        if let Some(WriteBack { line, contents }) = write_back {
            self.card[line.0 as usize * GRANULE..][..GRANULE].copy_from_slice(&contents);
        }
        self.traffic.granule(granule, outcome, write_back);
        (cached, outcome.way())
    }
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, W: Watch<GRANULE>> Metadata<WAYS>
    for CachedMetadata<WAYS, META_WAYS, GRANULE, W>
{
    /// Corrupt metadata makes an empty set (VM-14): all that is lost is what the host has too.
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        for k in 0..Self::MOST_GRANULES {
            if let Some(granule) = Self::granule(index, k) {
                self.bring(granule);
            }
        }
        Set::from_entries(self.entries(index), self.lines).unwrap_or_else(|Corrupt| {
            self.traffic.corrupt();
            Set::empty(self.lines)
        })
    }

    /// A granule is written, and so becomes dirty, only where it changes.
    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        let (old, new) = (self.entries(index), set.to_entries());
        // Of corrupt metadata all: what a clean granule in the cache holds may not be what is on the
        // card.
        let all = Set::from_entries(old, self.lines) == Err(Corrupt);
        let (old, new) = (old.as_flattened(), new.as_flattened());
        for k in 0..Self::MOST_GRANULES {
            let Some(granule) = Self::granule(index, k) else { return };
            let mut needed = all;
            let mut changed = [None; GRANULE];
            for (i, byte) in new.iter().enumerate() {
                let (there, offset) = Self::place(index, i);
                if there == granule {
                    changed[offset] = Some(*byte);
                    needed |= old[i] != *byte;
                }
            }
            if needed {
                let (cached, way) = self.bring(granule);
                let before = self.cache[cached];
                let old = before.contents[usize::from(way.0)];
                let bytes = std::array::from_fn(|i| changed[i].unwrap_or(old[i]));
                self.cache[cached] = before.write(way, bytes);
            }
        }
    }

    fn clear(&mut self) {
        self.cache.fill(DataSet::empty(self.granules, [0; GRANULE]));
        let empty = Set::<WAYS>::empty(self.lines).to_entries();
        for set in self.card.chunks_mut(Self::SET_BYTES) {
            set.copy_from_slice(&empty.as_flattened()[..set.len()]);
        }
    }
}
