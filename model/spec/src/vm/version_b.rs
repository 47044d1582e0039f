//! Version B (§3, §4): the metadata lies in the on-board memory, and the chip keeps a part of it
//! in a small write-back cache.
//!
//! The metadata of a set is that of its ways, way by way; the sets follow one another (Assumed).
//! The cache is filled and written back in granules of `GRANULE` bytes, a parameter: the metadata
//! of a set may straddle granules. A [`LineAddr`] here is the number of a granule.

use super::data_set::{DataSet, WriteBack};
use super::directory::CacheConfig;
use super::entry::{Corrupt, ENTRY_BYTES};
use super::hash::Hash;
use super::set::{Outcome, Policy, Set};
use super::units::{LineAddr, SetIndex, Way};
use super::version_a::Metadata;
use std::ops::Range;

/// What watches the metadata cache at work: a counter, or the chip in time, which moves what the
/// cache loads and writes back. `Contents` is what the cache keeps of a granule.
pub trait MetadataObserver<Contents> {
    /// A granule was used. After a miss it was loaded, and then the dirty granule that it evicted, if
    /// any, was written back.
    fn granule_used(&mut self, granule: LineAddr, outcome: Outcome, write_back: Option<WriteBack<Contents>>);

    /// The metadata of a set was corrupt, and the set was taken for empty (VM-14).
    fn corrupt(&mut self);
}

/// Counts what goes through the metadata cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct MetadataTraffic {
    /// Granules used: to read the metadata of a set, and again to write what changed.
    pub accesses: u64,
    /// Granules read from the on-board memory.
    pub loads: u64,
    /// Granules written back to it.
    pub write_backs: u64,
    /// Sets whose metadata was corrupt, and which were taken for empty (VM-14).
    pub corrupt: u64,
}

impl<Contents> MetadataObserver<Contents> for MetadataTraffic {
    fn granule_used(&mut self, _: LineAddr, outcome: Outcome, write_back: Option<WriteBack<Contents>>) {
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
    O = MetadataTraffic,
> {
    /// Replacement of lines: says which metadata is legal.
    pub lines: Policy,
    /// Replacement of granules (LRU Assumed).
    pub granules: Policy,
    /// The metadata cache; a power of two of sets, indexed by the granule's lower bits (Assumed).
    pub cache: Vec<DataSet<META_WAYS, [u8; GRANULE]>>,
    /// The metadata in the on-board memory: whole granules.
    pub card: Vec<u8>,
    /// What watches the metadata cache.
    pub observer: O,
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize>
    CachedMetadata<WAYS, META_WAYS, GRANULE>
{
    /// The metadata of an empty cache of lines, behind an empty metadata cache of `sets` sets.
    ///
    /// # Panics
    /// If `sets` is not a power of two, or there are more than 2³² granules.
    pub fn new(config: &CacheConfig, sets: usize, granules: Policy) -> Self {
        Self::observed(config, sets, granules, MetadataTraffic::default())
    }
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, O: MetadataObserver<[u8; GRANULE]>>
    CachedMetadata<WAYS, META_WAYS, GRANULE, O>
{
    /// Bytes of metadata a set of lines.
    const SET_BYTES: usize = WAYS * ENTRY_BYTES;
    /// Most granules that hold metadata of one set.
    const MOST_GRANULES: usize = (Self::SET_BYTES - 1).div_ceil(GRANULE) + 1;

    /// The same, watched by `observer`.
    ///
    /// # Panics
    /// If `sets` is not a power of two, or there are more than 2³² granules.
    pub fn observed(config: &CacheConfig, sets: usize, granules: Policy, observer: O) -> Self {
        assert!(sets.is_power_of_two(), "{sets} sets of metadata: it must be a power of two");
        let bytes = config.geometry.sets() as usize * Self::SET_BYTES;
        assert!(
            bytes.div_ceil(GRANULE) <= 1 << 32,
            "granules of {GRANULE} bytes: their numbers have 32 bits"
        );
        let mut new = Self {
            lines: config.policy,
            granules,
            cache: vec![DataSet::empty(granules, [0; GRANULE]); sets],
            card: vec![0; bytes.next_multiple_of(GRANULE)],
            observer,
        };
        new.clear();
        new
    }

    /// The granule that holds byte `i` of the metadata of the set `index`, and the byte's offset in it.
    pub fn location_of(index: SetIndex, i: usize) -> (LineAddr, usize) {
        let byte = index.0 as usize * Self::SET_BYTES + i;
        (LineAddr((byte / GRANULE) as u32), byte % GRANULE)
    }

    /// Granule number `k` of those that hold metadata of the set `index`; none behind the last.
    pub fn granule_of(index: SetIndex, k: usize) -> Option<LineAddr> {
        let (first, _) = Self::location_of(index, 0);
        let (last, _) = Self::location_of(index, Self::SET_BYTES - 1);
        // In 64 bits: the first may have the highest number that there is.
        let granule = u64::from(first.0) + k as u64;
        (granule <= last.0.into()).then_some(LineAddr(granule as u32))
    }

    /// Where a granule lies in the on-board memory.
    pub fn on_card(granule: LineAddr) -> Range<usize> {
        let begin = granule.0 as usize * GRANULE;
        begin..begin + GRANULE
    }

    /// The set of the metadata cache that a granule belongs to.
    fn cache_set_of(&self, granule: LineAddr) -> usize {
        Hash::Low.set_of(granule, self.cache.len().ilog2()).0 as usize
    }

    /// The metadata of a set as the cache and the on-board memory together hold it (VM-13).
    pub fn entries(&self, index: SetIndex) -> [[u8; ENTRY_BYTES]; WAYS] {
        let mut entries = [[0; ENTRY_BYTES]; WAYS];
        for k in 0..Self::MOST_GRANULES {
            let Some(granule) = Self::granule_of(index, k) else { break };
            let cached = self.cache[self.cache_set_of(granule)];
            let mut bytes = [0; GRANULE];
            match cached.set.way_of(granule) {
                Some(way) => bytes = cached.contents[usize::from(way.0)],
                None => bytes.copy_from_slice(&self.card[Self::on_card(granule)]),
            }
            for (i, byte) in entries.as_flattened_mut().iter_mut().enumerate() {
                let (holder, offset) = Self::location_of(index, i);
                if holder == granule {
                    *byte = bytes[offset];
                }
            }
        }
        entries
    }

    /// Uses a granule: afterwards it lies in the metadata cache, in the set and the way returned.
    fn use_granule(&mut self, granule: LineAddr) -> (usize, Way) {
        let set = self.cache_set_of(granule);
        let before = self.cache[set];
        let (next, outcome, write_back) = before.access(granule, self.granules, || {
            let mut bytes = [0; GRANULE];
            bytes.copy_from_slice(&self.card[Self::on_card(granule)]);
            bytes
        });
        self.cache[set] = next;
        if let Some(WriteBack { line: evicted, contents }) = write_back {
            self.card[Self::on_card(evicted)].copy_from_slice(&contents);
        }
        self.observer.granule_used(granule, outcome, write_back);
        (set, outcome.way())
    }
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, O: MetadataObserver<[u8; GRANULE]>>
    Metadata<WAYS> for CachedMetadata<WAYS, META_WAYS, GRANULE, O>
{
    /// Corrupt metadata makes an empty set (VM-14): the host still has every line that is lost.
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        for k in 0..Self::MOST_GRANULES {
            if let Some(granule) = Self::granule_of(index, k) {
                self.use_granule(granule);
            }
        }
        Set::from_entries(self.entries(index), self.lines).unwrap_or_else(|Corrupt| {
            self.observer.corrupt();
            Set::empty(self.lines)
        })
    }

    /// A granule is written, and so becomes dirty, only if it changes.
    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        let (old, new) = (self.entries(index), set.to_entries());
        // If the metadata is corrupt, every granule is written: clean bytes in the cache may differ
        // from those on the card.
        let corrupt = Set::from_entries(old, self.lines) == Err(Corrupt);
        let (old, new) = (old.as_flattened(), new.as_flattened());
        for k in 0..Self::MOST_GRANULES {
            let Some(granule) = Self::granule_of(index, k) else { return };
            let mut changes = corrupt;
            // The new bytes of the granule; none where it holds metadata of another set.
            let mut stored = [None; GRANULE];
            for (i, byte) in new.iter().enumerate() {
                let (holder, offset) = Self::location_of(index, i);
                if holder == granule {
                    stored[offset] = Some(*byte);
                    changes |= old[i] != *byte;
                }
            }
            if changes {
                let (set, way) = self.use_granule(granule);
                let before = self.cache[set];
                let bytes = before.contents[usize::from(way.0)];
                let bytes = std::array::from_fn(|i| stored[i].unwrap_or(bytes[i]));
                self.cache[set] = before.write(way, bytes);
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
