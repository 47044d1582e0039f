//! The twins do what the specification does: the relations of which the theorems of `equal` show the step.

use super::directory::{Ask, Held};
use super::machine::{Answer, Machine, Simulation};
use saarcor_fast::directory as fast;
use saarcor_fast::first_level as fast_first_level;
use saarcor_fast::version_b::MetadataDecisions;
use saarcor_model::vm::{
    CachedMetadata, Directory, FirstLevel, LineAddr, MetadataObserver, Outcome, SetIndex,
};
use std::marker::PhantomData;

/// A state on which the twin works, and not the specification.
#[derive(Clone, Debug)]
pub struct Fast<State>(pub State);

impl<const WAYS: usize, M: Held<WAYS>> Machine for Fast<Directory<WAYS, M>> {
    type Request = Ask;
    /// The outcome of an access.
    type Answer = Option<Outcome>;

    fn step(&mut self, ask: &Ask) -> Option<Outcome> {
        match *ask {
            Ask::Access(line) => return Some(fast::access(&mut self.0, line)),
            // The twin has no invalidation and no flush of its own.
            Ask::Invalidate(addr, len) => self.0.invalidate(addr, len),
            Ask::Flush => self.0.flush(),
        }
        None
    }
}

/// The twin of a directory of version A: states are related if they are equal.
#[derive(Clone, Copy, Debug)]
pub struct TwinOfA<const WAYS: usize>;

impl<const WAYS: usize> Simulation for TwinOfA<WAYS> {
    type Concrete = Fast<Directory<WAYS>>;
    type Abstract = Directory<WAYS>;

    fn related(Fast(twin): &Self::Concrete, directory: &Self::Abstract) -> bool {
        twin.config == directory.config
            && twin.counters == directory.counters
            && twin.metadata.policy == directory.metadata.policy
            && twin.metadata.sets.len() == directory.metadata.sets.len()
            && (0..twin.metadata.sets.len())
                .all(|set| twin.metadata.sets[set] == directory.metadata.sets[set])
    }

    fn asked(ask: &Ask, _: &Option<Outcome>, _: &Self::Concrete, _: &Self::Abstract) -> Ask {
        *ask
    }

    fn agree(answer: &Answer<Self::Concrete>, expected: &Answer<Self::Abstract>) -> bool {
        answer == expected
    }
}

/// The twin of a directory of version B: its sets are what the specification's metadata decodes to,
/// wherever it lies; its metadata cache holds the same granules in the same ways, dirty where they are dirty;
/// and both observers saw the same.
#[derive(Clone, Copy, Debug)]
pub struct TwinOfB<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, O>(PhantomData<O>);

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, O> Simulation
    for TwinOfB<WAYS, META_WAYS, GRANULE, O>
where
    O: MetadataObserver<()> + MetadataObserver<[u8; GRANULE]> + PartialEq,
{
    type Concrete = Fast<Directory<WAYS, MetadataDecisions<WAYS, META_WAYS, O>>>;
    type Abstract = Directory<WAYS, CachedMetadata<WAYS, META_WAYS, GRANULE, O>>;

    fn related(Fast(twin): &Self::Concrete, directory: &Self::Abstract) -> bool {
        twin.config == directory.config
            && twin.counters == directory.counters
            && metadata_is_related(&twin.metadata, &directory.metadata)
    }

    fn asked(ask: &Ask, _: &Option<Outcome>, _: &Self::Concrete, _: &Self::Abstract) -> Ask {
        *ask
    }

    fn agree(answer: &Answer<Self::Concrete>, expected: &Answer<Self::Abstract>) -> bool {
        answer == expected
    }
}

/// The relation of [`TwinOfB`], of the metadata alone.
pub fn metadata_is_related<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, O>(
    twin: &MetadataDecisions<WAYS, META_WAYS, O>,
    spec: &CachedMetadata<WAYS, META_WAYS, GRANULE, O>,
) -> bool
where
    O: MetadataObserver<()> + MetadataObserver<[u8; GRANULE]> + PartialEq,
{
    let mut same = twin.observer == spec.observer
        && twin.granule_bytes == GRANULE
        && twin.granules == spec.granules
        && twin.cache.len() == spec.cache.len();
    for index in 0..twin.sets.sets.len() {
        same = same && spec.entries(SetIndex(index as u32)) == twin.sets.sets[index].to_entries();
    }
    for index in 0..twin.cache.len() {
        same = same
            && spec.cache[index].set == twin.cache[index].set
            && spec.cache[index].dirty == twin.cache[index].dirty;
    }
    same
}

impl<const WAYS: usize> Machine for FirstLevel<WAYS, ()> {
    /// The line that is used.
    type Request = LineAddr;
    /// Whether it was resident, and the outcome.
    type Answer = (bool, Outcome);

    fn step(&mut self, line: &LineAddr) -> (bool, Outcome) {
        (self.is_resident(*line), self.access(*line, || ()))
    }
}

impl<const WAYS: usize> Machine for Fast<FirstLevel<WAYS, ()>> {
    type Request = LineAddr;
    /// Whether it was resident, and the outcome.
    type Answer = (bool, Outcome);

    fn step(&mut self, line: &LineAddr) -> (bool, Outcome) {
        (fast_first_level::is_resident(&self.0, *line), fast_first_level::access(&mut self.0, *line))
    }
}

/// The twin of a first-level cache: states are related if they are equal.
#[derive(Clone, Copy, Debug)]
pub struct TwinOfFirstLevel<const WAYS: usize>;

impl<const WAYS: usize> Simulation for TwinOfFirstLevel<WAYS> {
    type Concrete = Fast<FirstLevel<WAYS, ()>>;
    type Abstract = FirstLevel<WAYS, ()>;

    fn related(Fast(twin): &Self::Concrete, cache: &Self::Abstract) -> bool {
        twin == cache
    }

    fn asked(line: &LineAddr, _: &(bool, Outcome), _: &Self::Concrete, _: &Self::Abstract) -> LineAddr {
        *line
    }

    fn agree(answer: &Answer<Self::Concrete>, expected: &Answer<Self::Abstract>) -> bool {
        answer == expected
    }
}
