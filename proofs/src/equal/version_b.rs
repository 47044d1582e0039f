//! The twin of version B that moves no bytes: `saarcor_fast::version_b`.
//!
//! **Corresponding states.** The twin's sets are what the specification's metadata decodes to, wherever
//! it lies; its metadata cache holds the same granules in the same ways, dirty where they are dirty.
//! **Outcomes.** The sets loaded, and every granule used, loaded and written back, in order: an
//! observer on each side keeps them.
//!
//! Metadata that no encoder writes corresponds to nothing: the twin has no bits that could flip.
//!
//! Sets of two ways, whose 10 bytes of metadata straddle granules of 4 and share one, behind metadata
//! caches of one, two and four ways and one and two sets. How a directory meets its metadata is
//! [`fast_directory_meets_any_metadata_alike`](super::directory::fast_directory_meets_any_metadata_alike).

use crate::draw::{self, BYTES, WORDS};
use crate::refinement::directory::Ask;
use crate::refinement::draw as any;
use crate::refinement::machine::{begin, step_from_any};
use crate::refinement::twins::{Fast, TwinOfB, metadata_is_related};
use crate::source::{Holds, Source, Stop};
use crate::vm::version_b::{SETS, WAYS, set};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_fast::version_b::MetadataDecisions;
use saarcor_model::vm::{
    CacheConfig, CachedMetadata, DataSet, Directory, ENTRY_BYTES, Hash, LineAddr, Metadata, MetadataObserver,
    MetadataTraffic, OnChip, Outcome, Policy, Set, SetIndex, WriteBack,
};

const SET_BYTES: usize = WAYS * ENTRY_BYTES;
/// Bytes of whole granules of any size that hold the metadata of all sets.
const MOST_BYTES: usize = SETS * SET_BYTES + 16;
/// Most granules that one step uses: all of each set's, to load and to store each of its lines.
const MOST_EVENTS: usize = 40;

/// Keeps what a metadata cache does, in order: of each granule used, its number, the outcome, and the
/// granule written back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Record {
    events: [Option<(LineAddr, Outcome, Option<LineAddr>)>; MOST_EVENTS],
    count: usize,
    corrupt: usize,
}

impl Record {
    const EMPTY: Self = Self { events: [None; MOST_EVENTS], count: 0, corrupt: 0 };

    /// Whether any granule was found in the cache, any loaded, and any written back.
    fn kinds(&self) -> [bool; 3] {
        let mut kinds = [false; 3];
        for (_, outcome, write_back) in self.events.into_iter().flatten() {
            kinds[0] |= matches!(outcome, Outcome::Hit { .. });
            kinds[1] |= matches!(outcome, Outcome::Miss { .. });
            kinds[2] |= write_back.is_some();
        }
        kinds
    }
}

impl<Contents> MetadataObserver<Contents> for Record {
    fn granule_used(&mut self, granule: LineAddr, outcome: Outcome, write_back: Option<WriteBack<Contents>>) {
        if let Some(event) = self.events.get_mut(self.count) {
            *event = Some((granule, outcome, write_back.map(|back| back.line)));
        }
        self.count += 1;
    }

    fn corrupt(&mut self) {
        self.corrupt += 1;
    }
}

type Spec<const META_WAYS: usize, const GRANULE: usize> = CachedMetadata<WAYS, META_WAYS, GRANULE, Record>;
type Twin<const META_WAYS: usize> = MetadataDecisions<WAYS, META_WAYS, Record>;

/// Any version B in any consistent state, the twin's state that corresponds to it, and a set's number.
///
/// Small scope: one other set beside, one stale byte for all on the card that are out of date. Of a metadata cache of 4
/// ways each holds the granule of its number or none, in the order of an empty cache.
fn states<S: Source, const META_WAYS: usize, const GRANULE: usize>(
    s: &mut S,
    config: &CacheConfig,
    meta_sets: usize,
) -> Result<(Spec<META_WAYS, GRANULE>, Twin<META_WAYS>, SetIndex), Stop> {
    s.size("metadata ways", META_WAYS);
    s.size("metadata sets", meta_sets);
    s.size("bytes a granule", GRANULE);
    let policy = config.policy;
    let granules = if META_WAYS == 1 { Policy::Lru } else { draw::policy(s) };
    let own = s.value("set", 0..=SETS as u32 - 1, draw::words(0, SETS)) as usize;
    let mut sets = [Set::<WAYS>::empty(policy); SETS];
    for index in 0..SETS {
        sets[index] = if index == own {
            set(s, policy)?
        } else {
            Set::empty(policy).access(draw::line(s, &WORDS[9..10]), policy).0
        };
    }
    let used = (SETS * SET_BYTES).div_ceil(GRANULE) * GRANULE;
    let mut truth = [s.value("byte beside the sets", 0..=u8::MAX, &BYTES[9..10]); MOST_BYTES];
    for index in 0..SETS {
        let entries = sets[index].to_entries();
        for i in 0..SET_BYTES {
            truth[index * SET_BYTES + i] = entries[i / ENTRY_BYTES][i % ENTRY_BYTES];
        }
    }
    let stale = s.value("old byte on the card", 0..=u8::MAX, &BYTES[..1]);
    let mut card = truth;
    let mut cache = vec![DataSet::<META_WAYS, [u8; GRANULE]>::empty(granules, [0; GRANULE]); meta_sets];
    let mut decisions = vec![DataSet::<META_WAYS, ()>::empty(granules, ()); meta_sets];
    for index in 0..meta_sets {
        let mut cached = DataSet::empty(granules, [0; GRANULE]);
        for way in 0..META_WAYS {
            if !draw::flag(s, "granule is resident") {
                continue;
            }
            let last = used / GRANULE - 1;
            let small = if META_WAYS > 2 { draw::words(way, 1) } else { draw::words(0, last + 1) };
            let granule = s.value("granule in the cache", 0..=last as u32, small);
            assume!(granule as usize % meta_sets == index);
            let dirty = draw::flag(s, "dirty");
            (cached.set.resident[way], cached.set.lines[way], cached.dirty[way]) =
                (true, LineAddr(granule), dirty);
            for i in 0..used {
                if i / GRANULE == granule as usize {
                    cached.contents[way][i % GRANULE] = truth[i];
                    card[i] = if dirty { stale } else { truth[i] };
                }
            }
        }
        if META_WAYS <= 2 || s.value("order (of an empty cache, any)", 0..=1, &BYTES[..1]) == 1 {
            cached.set.order = draw::order(s, granules);
        }
        assume!(cached.is_valid(granules));
        cache[index] = cached;
        (decisions[index].set, decisions[index].dirty) = (cached.set, cached.dirty);
    }
    let spec = Spec { lines: policy, granules, cache, card: card[..used].to_vec(), observer: Record::EMPTY };
    let mut on_chip = OnChip::new(SETS as u64, policy);
    on_chip.sets[..SETS].copy_from_slice(&sets[..SETS]);
    let twin =
        Twin { sets: on_chip, granules, cache: decisions, granule_bytes: GRANULE, observer: Record::EMPTY };
    Ok((spec, twin, SetIndex(own as u32)))
}

/// Whether the states correspond, and both did the same to the metadata cache.
fn correspond<const META_WAYS: usize, const GRANULE: usize>(
    spec: &Spec<META_WAYS, GRANULE>,
    twin: &Twin<META_WAYS>,
) -> bool {
    spec.observer.corrupt == 0
        && spec.observer.count <= MOST_EVENTS
        && metadata_is_related::<WAYS, META_WAYS, GRANULE, Record>(twin, spec)
}

/// Judges a body for granules smaller and larger than the metadata of a set, and metadata caches of
/// several shapes: ways, bytes a granule, sets.
macro_rules! any_cache {
    ($source:expr, $body:ident) => {
        match $source.value("metadata cache", 0..=3, &BYTES[..4]) {
            0 => $body::<S, 1, 4>($source, 1)?,
            1 => $body::<S, 2, 4>($source, 1)?,
            2 => $body::<S, 1, 4>($source, 2)?,
            _ => $body::<S, 1, 16>($source, 1)?,
        }
    };
}

/// The configuration of the lines.
fn config<S: Source>(s: &mut S) -> Result<CacheConfig, Stop> {
    crate::vm::directory::config::<S, WAYS, SETS>(s)
}

fn moves_alike<S: Source, const META_WAYS: usize, const GRANULE: usize>(
    s: &mut S,
    meta_sets: usize,
) -> Holds {
    let config = config(s)?;
    let (mut spec, mut twin, own) = states::<S, META_WAYS, GRANULE>(s, &config, meta_sets)?;
    let before = shown!(spec.clone());
    match s.value("step (load, store, clear)", 0..=2, &BYTES[..3]) {
        0 => {
            let expected = spec.load(own);
            check_eq!(twin.load(own), expected, "{own:?} of {before:?}");
            let [found, loaded, written_back] = spec.observer.kinds();
            cover!(s, "found", found);
            cover!(s, "loaded", loaded);
            cover!(s, "written back for a load", written_back);
        }
        1 => {
            let new = set(s, config.policy)?;
            spec.store(own, &new);
            twin.store(own, &new);
            cover!(s, "nothing to store", spec.observer.count == 0);
            cover!(s, "stored", spec.observer.count == 1);
            cover!(s, "written back for a store", spec.observer.kinds()[2]);
        }
        _ => {
            cover!(s, "a dirty granule forgotten", spec.cache[0].dirty[0]);
            spec.clear();
            twin.clear();
        }
    }
    check!(correspond(&spec, &twin), "a step with {own:?} of {before:?}: {spec:?} and {twin:?}");
    Ok(())
}

fn stores_nothing_new<S: Source, const META_WAYS: usize, const GRANULE: usize>(
    s: &mut S,
    meta_sets: usize,
) -> Holds {
    let config = config(s)?;
    let (mut spec, _, own) = states::<S, META_WAYS, GRANULE>(s, &config, meta_sets)?;
    let loaded = spec.load(own);
    let before = spec.clone();
    let [found, _, written_back] = spec.observer.kinds();
    cover!(s, "found", found);
    cover!(s, "written back", written_back);
    spec.store(own, &loaded);
    check!(spec == before, "{loaded:?} loaded and stored as {own:?} of {before:?}: {spec:?}");
    Ok(())
}

fn runs_alike<S: Source, const META_WAYS: usize, const GRANULE: usize>(s: &mut S, meta_sets: usize) -> Holds {
    let mut config = config(s)?;
    config.hash = super::directory::hash(s);
    let (spec, twin, _) = states::<S, META_WAYS, GRANULE>(s, &config, meta_sets)?;
    let (mut spec, mut twin) = (Directory::over(config, spec), Fast(Directory::over(config, twin)));
    let ask = match s.value("step (access, invalidate, flush)", 0..=2, &BYTES[..3]) {
        0 => Ask::Access(config.geometry.line_of(draw::addr(s, &[0, 2, 4, 6]))),
        1 => Ask::Invalidate(draw::addr(s, &[0, 3]), s.value("bytes", 0..=u64::MAX, &[0, 1, 3, u64::MAX])),
        _ => Ask::Flush,
    };
    let outcome = step_from_any::<TwinOfB<WAYS, META_WAYS, GRANULE, Record>>(&mut twin, &mut spec, &ask)?;
    cover!(s, "hit", matches!(outcome, Some(Outcome::Hit { .. })));
    cover!(s, "miss", matches!(outcome, Some(Outcome::Miss { .. })));
    cover!(s, "invalidated", spec.counters.invalidated > 0);
    cover!(s, "flushed", matches!(ask, Ask::Flush));
    let Record { corrupt, count, .. } = spec.metadata.observer;
    check!(corrupt == 0 && count <= MOST_EVENTS, "{ask:?}: {corrupt} corrupt, {count} granules used");
    Ok(())
}

theorems! {
    /// From corresponding states, the twin of version B answers a load, a store of any set and a flush as the
    /// specification does: it uses, loads and writes back the same granules in the same order, of a store those that
    /// change and no others, and the states correspond again.
    #["VM-13", not_for_kani "a store takes it more than 2 GiB", covers [
        "found", "loaded", "written back for a load", "nothing to store", "stored", "written back for a store", "a dirty granule forgotten"
    ]]
    fn fast_version_b_moves_the_same_granules(s) {
        match s.value("metadata ways (as below, 4)", 0..=1, &BYTES[..2]) {
            0 => any_cache!(s, moves_alike),
            _ => moves_alike::<S, 4, 4>(s, 1)?,
        }
    }

    /// A store of the set that was just loaded uses no granule and changes nothing: a directory may
    /// leave it out.
    #["VM-13", not_for_kani "a load and a store take it more than 120 seconds or 2 GiB", covers ["found", "written back"]]
    fn storing_what_was_loaded_changes_nothing(s) {
        any_cache!(s, stores_nothing_new);
    }

    /// From corresponding states, an access, an invalidation of any range or a flush of version B's
    /// directory gives the same outcome and counters on both sides, moves the same granules in the
    /// same order, and leaves corresponding states.
    #["VM-13", not_for_kani "a step is made of loads and stores, and a store alone takes it more than 2 GiB", covers ["hit", "miss", "invalidated", "flushed"]]
    fn fast_version_b_steps_alike(s) {
        any_cache!(s, runs_alike);
    }

    /// The twin finds, for each set of a cache of any size, the granules that hold its metadata, as the specification does,
    /// in order, and of each byte the granule at its place.
    #["VM-13", unwind 6, covers ["one granule", "two granules", "beyond 64 KB", "beyond 4 GiB"]]
    fn fast_version_b_finds_the_same_granules(s) {
        match s.value("bytes of a granule", 0..=2, &BYTES[..3]) {
            0 => same_granules::<S, 16>(s)?,
            1 => same_granules::<S, 64>(s)?,
            _ => same_granules::<S, 4096>(s)?,
        }
    }

    /// The twin of a metadata cache of up to 64 sets uses each of them: a granule lies in the set that its lower bits name, as
    /// in the specification.
    #["VM-13", not_for_kani "many sets are too many for it; which set the lower bits name is a theorem of the hash", covers ["64 sets", "one set", "a set beyond the eighth"]]
    fn fast_version_b_uses_every_metadata_set(s) {
        let sets = 1 << s.value("log2 sets of the metadata cache", 0..=6, &WORDS[..7]);
        let geometry = draw::of_logarithms(0, 0, 8)?;
        let config = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        let mut twin = MetadataDecisions::<1, 1, Record>::new(&config, sets, 4, Policy::Lru, Record::EMPTY);
        let own = SetIndex(s.value("set", 0..=255, &[0, 1, 6, 7, 8, 15, 31, 49, 50, 51, 52, 255]));
        twin.load(own);
        cover!(s, "64 sets", sets == 64);
        cover!(s, "one set", sets == 1);
        for (index, cached) in twin.cache.iter().enumerate() {
            let number = cached.set.lines[0].0 as usize;
            cover!(s, "a set beyond the eighth", index >= 8 && cached.set.resident[0]);
            check!(!cached.set.resident[0] || number % sets == index, "{own:?}: granule {number} in set {index} of {sets}");
        }
    }

    /// The twin of version B begins as version B does, with no line in any set and no granule in the metadata
    /// cache.
    #["VM-13", unwind 13, covers ["one policy", "two policies"]]
    fn twin_of_version_b_begins_as_the_specification(s) {
        let config = any::config::<S, 1>(s)?;
        let granules = draw::policy(s);
        let twin = MetadataDecisions::<1, 2, _>::new(&config, 2, 8, granules, MetadataTraffic::default());
        let spec = CachedMetadata::<1, 2, 8>::new(&config, 2, granules);
        cover!(s, "one policy", config.policy == granules);
        cover!(s, "two policies", config.policy != granules);
        let (twin, spec) = (Fast(Directory::over(config, twin)), Directory::over(config, spec));
        begin::<TwinOfB<1, 2, 8, MetadataTraffic>>(&twin, &spec)?;
    }
}

/// The granules of any set of 4 ways, of the twin and by their places.
fn same_granules<S: Source, const GRANULE: usize>(s: &mut S) -> Holds {
    s.size("bytes a granule", GRANULE);
    const BYTES_OF_A_SET: u64 = 4 * ENTRY_BYTES as u64;
    let twin = MetadataDecisions::<4, 4, Record> {
        sets: OnChip { policy: Policy::Lru, sets: Vec::new() },
        granules: Policy::Lru,
        cache: Vec::new(),
        granule_bytes: GRANULE,
        observer: Record::EMPTY,
    };
    // Four ways: 2^30 sets at most.
    let set = SetIndex(s.value("set", 0..=u32::MAX >> 2, &SETS_OF_ANY_CACHE));
    let begin = u64::from(set.0) * BYTES_OF_A_SET;
    let mut found = twin.granules_of(set);
    let (mut count, mut bytes) = (0, 0);
    // 20 bytes in granules of 16 lie in three at most.
    for k in 0..4 {
        let Some((granule, here)) = found.next() else { break };
        check_eq!(here.start, bytes, "{set:?}, granules of {GRANULE}: first byte in granule {k}");
        check!(here.end > here.start, "{set:?}, granules of {GRANULE}: {here:?} in granule {k}");
        let place = |byte: usize| (begin + byte as u64) / GRANULE as u64;
        let holders = (place(here.start), place(here.end - 1));
        let number = u64::from(granule.0);
        check_eq!(holders, (number, number), "{set:?}, granules of {GRANULE}: {here:?} in {granule:?}");
        (count, bytes) = (count + 1, here.end);
    }
    check_eq!(bytes as u64, BYTES_OF_A_SET, "{set:?}, granules of {GRANULE}: bytes found");
    cover!(s, "one granule", count == 1);
    cover!(s, "two granules", count == 2);
    cover!(s, "beyond 64 KB", begin > 1 << 16);
    cover!(s, "beyond 4 GiB", begin > 1 << 32);
    Ok(())
}

/// Sets at both ends, and around powers of two.
static SETS_OF_ANY_CACHE: [u32; 12] =
    [0, 1, 2, 3, 4, 3276, 3277, 0xffff, 0x1_0000, 0x1_ffff, 0x1000_0001, u32::MAX >> 2];
