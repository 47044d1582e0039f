//! A directory of any version is at each of its sets the abstract machine [`OneSet`].
//!
//! **One set, which is any.** The machine is one set of version A. It answers for the lines of this set, and
//! says nothing of others. A directory is related to it if it holds this set, wherever its metadata lies: in
//! version A on the chip, in version B in the metadata cache and on the card. Which set is watched is
//! arbitrary: what holds of it holds of each, and so of all at once. Both versions are the same machine at
//! each set, and the machine leaves nothing open: so version B answers as version A does.

use super::draw::{self, Around};
use super::machine::{Answer, Machine, Request, Simulation, begin, step_from_any};
use crate::draw as parts;
use crate::source::{Holds, Source, Stop};
use crate::{check, cover, theorems};
use saarcor_fast::version_b::MetadataDecisions;
use saarcor_model::vm::{
    CacheConfig, CachedMetadata, Directory, HostAddr, LineAddr, Metadata, MetadataObserver, MetadataTraffic,
    OnChip, Outcome, Policy, Set, SetIndex,
};
use std::marker::PhantomData;

/// What a directory is asked.
#[derive(Clone, Copy, Debug)]
pub enum Ask {
    /// An access to a line.
    Access(LineAddr),
    /// An invalidation: address and number of bytes.
    Invalidate(HostAddr, u64),
    /// A flush.
    Flush,
}

/// The abstract machine: one set of a cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OneSet<const WAYS: usize> {
    /// The cache.
    pub config: CacheConfig,
    /// Which set of it.
    pub index: SetIndex,
    /// Its state.
    pub set: Set<WAYS>,
}

impl<const WAYS: usize> Machine for OneSet<WAYS> {
    type Request = Ask;
    /// The outcome of an access to a line of the set; none for all else.
    type Answer = Option<Outcome>;

    fn step(&mut self, ask: &Ask) -> Option<Outcome> {
        match *ask {
            Ask::Access(line) if self.config.set_of(line) == self.index => {
                let (set, outcome) = self.set.access(line, self.config.policy);
                self.set = set;
                Some(outcome)
            }
            Ask::Access(_) => None,
            Ask::Invalidate(addr, len) => {
                let line_bytes = self.config.geometry.line().0;
                let (begin, end) = (u64::from(addr.0), u64::from(addr.0).saturating_add(len).min(1 << 32));
                for way in 0..WAYS {
                    let first = u64::from(self.set.lines[way].0) * line_bytes;
                    // The line has a byte of the range.
                    if begin < end && first < end && begin < first + line_bytes {
                        self.set.resident[way] = false;
                    }
                }
                None
            }
            Ask::Flush => {
                self.set = Set::empty(self.config.policy);
                None
            }
        }
    }
}

/// Metadata whose sets can be looked at without being used.
pub trait Held<const WAYS: usize>: Metadata<WAYS> {
    /// The set that is held at an index; none if it is not held consistently, or is not legal.
    fn held(&self, index: SetIndex) -> Option<Set<WAYS>>;
}

impl<const WAYS: usize> Held<WAYS> for OnChip<WAYS> {
    fn held(&self, index: SetIndex) -> Option<Set<WAYS>> {
        let set = self.sets[index.0 as usize];
        set.is_valid(self.policy).then_some(set)
    }
}

/// The metadata cache is consistent if its sets are legal, each granule in it lies in the set of its number
/// and exists, and a clean one is the same on the card.
impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize, O: MetadataObserver<[u8; GRANULE]>>
    Held<WAYS> for CachedMetadata<WAYS, META_WAYS, GRANULE, O>
{
    fn held(&self, index: SetIndex) -> Option<Set<WAYS>> {
        let mut consistent = true;
        for (number, cached) in self.cache.iter().enumerate() {
            consistent &= cached.is_valid(self.granules);
            for way in 0..META_WAYS {
                if !cached.set.resident[way] {
                    continue;
                }
                let granule = cached.set.lines[way].0 as usize;
                let on_card = self.card.get(granule * GRANULE..).and_then(|rest| rest.get(..GRANULE));
                consistent &= granule & (self.cache.len() - 1) == number
                    && on_card.is_some_and(|card| cached.dirty[way] || *card == cached.contents[way]);
            }
        }
        if consistent { Set::from_entries(self.entries(index), self.lines).ok() } else { None }
    }
}

impl<const WAYS: usize, const META_WAYS: usize, O: MetadataObserver<()>> Held<WAYS>
    for MetadataDecisions<WAYS, META_WAYS, O>
{
    fn held(&self, index: SetIndex) -> Option<Set<WAYS>> {
        let legal = self.cache.iter().all(|cached| cached.is_valid(self.granules));
        if legal { self.sets.held(index) } else { None }
    }
}

impl<const WAYS: usize, M: Held<WAYS>> Machine for Directory<WAYS, M> {
    type Request = Ask;
    /// The outcome of an access.
    type Answer = Option<Outcome>;

    fn step(&mut self, ask: &Ask) -> Option<Outcome> {
        match *ask {
            Ask::Access(line) => return Some(self.access(line)),
            Ask::Invalidate(addr, len) => self.invalidate(addr, len),
            Ask::Flush => self.flush(),
        }
        None
    }
}

/// A directory of the specification, whose metadata is `M`, is [`OneSet`] at the watched set.
#[derive(Clone, Copy, Debug)]
pub struct AtOneSet<const WAYS: usize, M>(PhantomData<M>);

impl<const WAYS: usize, M: Held<WAYS>> Simulation for AtOneSet<WAYS, M> {
    type Concrete = Directory<WAYS, M>;
    type Abstract = OneSet<WAYS>;

    fn related(directory: &Self::Concrete, one: &Self::Abstract) -> bool {
        directory.config == one.config && directory.metadata.held(one.index) == Some(one.set)
    }

    fn asked(ask: &Ask, _: &Option<Outcome>, _: &Self::Concrete, _: &OneSet<WAYS>) -> Ask {
        *ask
    }

    fn agree(answer: &Answer<Self::Concrete>, expected: &Answer<Self::Abstract>) -> bool {
        expected.is_none() || answer == expected
    }
}

/// The abstract machine's state for a directory, at a set.
///
/// # Errors
/// If a directory that was drawn to be legal and consistent is not.
fn at<const WAYS: usize, M: Held<WAYS>>(
    directory: &Directory<WAYS, M>,
    index: SetIndex,
) -> Result<OneSet<WAYS>, Stop> {
    let (config, held) = (directory.config, directory.metadata.held(index));
    check!(held.is_some(), "{config:?}: {index:?} of a legal state is not held");
    held.map(|set| OneSet { config, index, set }).ok_or(Stop::Vacuous)
}

/// Any request: an access, an invalidation or a flush, around the watched set.
pub(super) fn ask(s: &mut impl Source, config: &CacheConfig, around: Around) -> Request<OneSet<1>> {
    match s.value("request (access, invalidate, flush)", 0..=2, &parts::BYTES[..3]) {
        0 => Ask::Access(config.geometry.line_of(draw::addr(s, config, around))),
        1 => Ask::Invalidate(draw::addr(s, config, around), draw::len(s)),
        _ => Ask::Flush,
    }
}

fn version_b_step<S: Source, const WAYS: usize, const META_WAYS: usize, const GRANULE: usize>(
    s: &mut S,
    meta_sets: usize,
) -> Holds {
    let config = draw::config::<S, WAYS>(s)?;
    let around = draw::around(s, &config);
    let metadata = draw::version_b::<S, WAYS, META_WAYS, GRANULE>(s, &config, around, meta_sets)?;
    let mut b = Directory::over(config, metadata);
    let mut one = at(&b, around.own)?;
    let ask = ask(s, &config, around);
    let outcome = step_from_any::<AtOneSet<WAYS, _>>(&mut b, &mut one, &ask)?;
    let traffic: MetadataTraffic = b.metadata.observer;
    cover!(s, "hit", matches!(outcome, Some(Outcome::Hit { .. })));
    cover!(s, "miss", matches!(outcome, Some(Outcome::Miss { .. })));
    cover!(s, "invalidated", b.counters.invalidated > 0);
    cover!(s, "flushed", matches!(ask, Ask::Flush));
    cover!(s, "metadata written back", traffic.write_backs > 0);
    Ok(())
}

theorems! {
    /// An access is one step of its line's set, and leaves every other set as it was.
    #["VM-6", unwind 5, covers ["hit", "miss", "another set"]]
    fn access_is_the_step_of_its_set(s) {
        let config = draw::config::<S, 2>(s)?;
        let around = draw::around(s, &config);
        let mut a = Directory::over(config, draw::version_a::<S, 2>(s, &config, around)?);
        let mut one = at(&a, around.own)?;
        let line = config.geometry.line_of(draw::addr(s, &config, around));
        let outcome = step_from_any::<AtOneSet<2, _>>(&mut a, &mut one, &Ask::Access(line))?;
        cover!(s, "hit", matches!(outcome, Some(Outcome::Hit { .. })));
        cover!(s, "miss", matches!(outcome, Some(Outcome::Miss { .. })));
        cover!(s, "another set", config.set_of(line) != around.own);
    }

    /// From any consistent state, version B answers an access, an invalidation and a flush as version A
    /// does: at every set it is the same one set, wherever the granules of its metadata lie.
    #["VM-13", not_for_kani "a whole step takes it more than 120 seconds or 2 GiB; its load and its store are theorems of their own", covers ["hit", "miss", "invalidated", "flushed", "metadata written back"]]
    fn version_b_steps_as_version_a(s) {
        match if cfg!(kani) { 0 } else { s.value("metadata cache", 0..=3, &parts::BYTES[..4]) } {
            #[cfg(kani)]
            0 => version_b_step::<S, 1, 1, 4>(s, 1)?,
            #[cfg(not(kani))]
            0 => version_b_step::<S, 2, 1, 4>(s, 1)?,
            #[cfg(not(kani))]
            1 => version_b_step::<S, 2, 4, 4>(s, 1)?,
            #[cfg(not(kani))]
            2 => version_b_step::<S, 1, 2, 16>(s, 4)?,
            _ => version_b_step::<S, 1, 1, 8>(s, 2)?,
        }
    }

    /// A new directory, of version A or B, holds no line in any set: where every run begins, each set is
    /// an empty set of version A.
    #["VM-13", unwind 13, covers ["version A", "version B"]]
    fn runs_begin_with_empty_sets(s) {
        let config = draw::config::<S, 2>(s)?;
        let index = draw::around(s, &config).own;
        let one = OneSet { config, index, set: Set::empty(config.policy) };
        if parts::flag(s, "version B") {
            let metadata = CachedMetadata::<2, 1, 8>::new(&config, 1, Policy::Lru);
            begin::<AtOneSet<2, _>>(&Directory::over(config, metadata), &one)?;
            cover!(s, "version B", true);
        } else {
            begin::<AtOneSet<2, _>>(&Directory::new(config), &one)?;
            cover!(s, "version A", true);
        }
    }
}
