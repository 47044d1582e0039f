//! Twin of [`saarcor_model::vm::CachedMetadata`]: decides which granules of metadata move, without
//! moving their bytes.
//!
//! The state of each set is kept decoded, and of the metadata cache only which granules it holds and
//! which of them are dirty. So nothing is encoded unless a set changes, and metadata cannot be
//! corrupt. Equal by the theorems of `saarcor-proofs`, `equal::version_b`.

use saarcor_model::vm::{
    CacheConfig, DataSet, ENTRY_BYTES, Hash, LineAddr, Metadata, MetadataObserver, OnChip, Policy, Set,
    SetIndex,
};
use std::ops::Range;

/// The metadata of version B without its bytes: `WAYS` ways a set of lines, `META_WAYS` ways a set of
/// granules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MetadataDecisions<const WAYS: usize, const META_WAYS: usize, O> {
    /// What the cached metadata and that in the on-board memory together say.
    pub sets: OnChip<WAYS>,
    /// Replacement of granules.
    pub granules: Policy,
    /// Which granules the metadata cache holds, and which of them are dirty.
    pub cache: Vec<DataSet<META_WAYS, ()>>,
    /// Bytes of a granule.
    pub granule_bytes: usize,
    /// What watches the metadata cache.
    pub observer: O,
}

impl<const WAYS: usize, const META_WAYS: usize, O: MetadataObserver<()>>
    MetadataDecisions<WAYS, META_WAYS, O>
{
    /// Bytes of metadata a set of lines.
    const SET_BYTES: usize = WAYS * ENTRY_BYTES;

    /// The metadata of an empty cache of lines, behind an empty metadata cache of `sets` sets of
    /// granules of `granule_bytes`, watched by `observer`.
    ///
    /// # Panics
    /// If `sets` is not a power of two, a granule has no bytes, or there are more than 2³² granules.
    #[must_use]
    pub fn new(
        config: &CacheConfig,
        sets: usize,
        granule_bytes: usize,
        granules: Policy,
        observer: O,
    ) -> Self {
        assert!(sets.is_power_of_two(), "{sets} sets of metadata: it must be a power of two");
        assert!(granule_bytes > 0, "a granule has at least one byte");
        let count = (config.geometry.sets() as usize * Self::SET_BYTES).div_ceil(granule_bytes);
        assert!(count <= 1 << 32, "granules of {granule_bytes} bytes: their numbers have 32 bits");
        Self {
            sets: OnChip::new(config.geometry.sets(), config.policy),
            granules,
            cache: vec![DataSet::empty(granules, ()); sets],
            granule_bytes,
            observer,
        }
    }

    /// The granules that hold metadata of the set `index`, and which bytes of it each holds.
    #[inline]
    pub fn granules_of(
        &self,
        index: SetIndex,
    ) -> impl Iterator<Item = (LineAddr, Range<usize>)> + use<WAYS, META_WAYS, O> {
        let (begin, granule) = (index.0 as usize * Self::SET_BYTES, self.granule_bytes);
        let end = begin + Self::SET_BYTES;
        (begin / granule..=(end - 1) / granule).map(move |number| {
            let here = begin.max(number * granule)..end.min((number + 1) * granule);
            (LineAddr(number as u32), here.start - begin..here.end - begin)
        })
    }

    #[inline]
    fn use_granule(&mut self, granule: LineAddr, changes: bool) {
        let index = Hash::Low.set_of(granule, self.cache.len().trailing_zeros());
        let cached = &mut self.cache[index.0 as usize];
        let (next, outcome, write_back) = cached.access(granule, self.granules, || ());
        *cached = if changes { next.write(outcome.way(), ()) } else { next };
        self.observer.granule_used(granule, outcome, write_back);
    }
}

impl<const WAYS: usize, const META_WAYS: usize, O: MetadataObserver<()>> Metadata<WAYS>
    for MetadataDecisions<WAYS, META_WAYS, O>
{
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        for (granule, _) in self.granules_of(index) {
            self.use_granule(granule, false);
        }
        self.sets.load(index)
    }

    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        let (old, new) = (self.sets.load(index).to_entries(), set.to_entries());
        for (granule, here) in self.granules_of(index) {
            if old.as_flattened()[here.clone()] != new.as_flattened()[here] {
                self.use_granule(granule, true);
            }
        }
        self.sets.store(index, set);
    }

    fn clear(&mut self) {
        self.sets.clear();
        self.cache.fill(DataSet::empty(self.granules, ()));
    }
}
