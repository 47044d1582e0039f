//! Theorems of version B: its metadata is A's, wherever it lies (VM-13, VM-14).
//!
//! **A directory asks for a set and stores it.** All that it knows of its metadata is what it loads
//! ([`directory_answers_from_what_it_loads`], [`directory_invalidates_what_it_loads`]). So two
//! versions that load what was stored answer alike, and what is left to show of version B is that it
//! does.
//!
//! **One step from any consistent state.** B's metadata is spread over the metadata cache and the
//! on-board memory in any way that is consistent: a granule in the cache is what counts, and a
//! clean one is the same on the card. From any such state a set is loaded as it is, and a store
//! replaces this set and no other.
//!
//! Two sets of two ways, which have 10 bytes of metadata each, in granules of 4: sets straddle
//! granules and share one. Metadata is moved as bytes, and what they mean is the unit `metadata`: so
//! Kani has one set of one way, whose 5 bytes straddle granules, too, and any bytes beside them. A
//! metadata cache of one way: each granule evicts the one before. More ways, and their
//! replacement, are those of the sets with bytes (`data_set`).

pub mod places;

use super::directory;
use super::entry::short_error;
use crate::draw::{self, BYTES, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_model::vm::{
    Bytes, CacheConfig, CachedMetadata, DataSet, Directory, ENTRY_BYTES, Entry, Geometry, Hash, LineAddr,
    Metadata, MetadataTraffic, Outcome, Policy, Set, SetIndex,
};

pub(crate) const WAYS: usize = if cfg!(kani) { 1 } else { 2 };
pub(crate) const SETS: usize = if cfg!(kani) { 1 } else { 2 };
const META_WAYS: usize = 1;
/// Bytes a granule, less than a set's metadata.
const SMALL: usize = 4;
/// Bytes a granule, more than a set's metadata.
const LARGE: usize = if cfg!(kani) { 8 } else { 16 };
const SET_BYTES: usize = WAYS * ENTRY_BYTES;
/// Bytes of whole granules of any size that hold the metadata of all sets.
const MOST_BYTES: usize = SETS * SET_BYTES + LARGE;

/// Sets, bytes a granule and bytes of metadata where a set's metadata lies in two granules, at any offset in the first:
/// of two ways 10 bytes in granules of 8; to Kani 5 bytes of one way in granules of 4.
const MANY: usize = if cfg!(kani) { 1 } else { 4 };
const HALF: usize = if cfg!(kani) { 4 } else { 8 };
const MANY_BYTES: usize = (MANY * SET_BYTES).next_multiple_of(HALF);

type B<const GRANULE: usize> = CachedMetadata<WAYS, META_WAYS, GRANULE>;

/// Granules of the metadata of all sets.
const fn granules(granule: usize) -> usize {
    (SETS * SET_BYTES).div_ceil(granule)
}

/// Puts the metadata of the set `index` where it belongs among that of all sets.
fn put(truth: &mut [u8; MOST_BYTES], index: usize, set: &Set<WAYS>) {
    let entries = set.to_entries();
    for way in 0..WAYS {
        for i in 0..ENTRY_BYTES {
            truth[index * SET_BYTES + way * ENTRY_BYTES + i] = entries[way][i];
        }
    }
}

/// Version B in any consistent state that holds these bytes.
fn version_b<S: Source, const GRANULE: usize>(
    s: &mut S,
    config: &CacheConfig,
    truth: &[u8; MOST_BYTES],
) -> B<GRANULE> {
    s.size("metadata ways", META_WAYS);
    s.size("metadata sets", 1);
    s.size("bytes a granule", GRANULE);
    let last = granules(GRANULE) - 1;
    let cached = s.value("granule in the cache", 0..=last as u32, draw::words(0, last + 1)) as usize;
    let resident = draw::flag(s, "granule is resident");
    let dirty = resident && draw::flag(s, "dirty");
    let stale = s.value("old byte on the card", 0..=u8::MAX, &BYTES[..1]);
    // Kani likes arrays better than vectors.
    let mut cache = DataSet::empty(Policy::Lru, [0; GRANULE]);
    (cache.set.lines[0], cache.set.resident[0], cache.dirty[0]) = (LineAddr(cached as u32), resident, dirty);
    let mut card = *truth;
    for i in 0..granules(GRANULE) * GRANULE {
        if i / GRANULE == cached {
            cache.contents[0][i % GRANULE] = truth[i];
            card[i] = if dirty { stale } else { truth[i] };
        }
    }
    B {
        lines: config.policy,
        granules: Policy::Lru,
        cache: vec![cache],
        card: card[..granules(GRANULE) * GRANULE].to_vec(),
        observer: MetadataTraffic::default(),
    }
}

/// Whether B holds these bytes and no others, and consistently: a clean granule is the same on the
/// card.
fn holds<const GRANULE: usize>(b: &B<GRANULE>, truth: &[u8; MOST_BYTES]) -> bool {
    let cache = b.cache[0];
    let (resident, cached) = (cache.set.resident[0], cache.set.lines[0].0 as usize);
    let mut card = [0; MOST_BYTES];
    card[..granules(GRANULE) * GRANULE].copy_from_slice(&b.card);
    let mut same = cache.is_valid(b.granules) && (!resident || cached < granules(GRANULE));
    for i in 0..granules(GRANULE) * GRANULE {
        let here = resident && i / GRANULE == cached;
        same &= !here || cache.contents[0][i % GRANULE] == truth[i];
        same &= here && cache.dirty[0] || card[i] == truth[i];
    }
    same
}

/// Any legal set of metadata. Small scope: line `way` in each way.
pub(crate) fn set<S: Source>(s: &mut S, policy: Policy) -> Result<Set<WAYS>, Stop> {
    let mut set = Set::empty(policy);
    for way in 0..WAYS {
        set.resident[way] = draw::flag(s, "resident");
        set.lines[way] = LineAddr(s.value("line of a way", 0..=u32::MAX, draw::words(way, 1)));
    }
    set.order = draw::order(s, policy);
    assume!(set.is_valid(policy));
    Ok(set)
}

/// Any metadata, version B that holds it in any consistent state, and the set that B is asked for,
/// with its number. Small scope: one byte for all that is no byte of that set.
fn any<S: Source, const GRANULE: usize>(
    s: &mut S,
) -> Result<([u8; MOST_BYTES], B<GRANULE>, Set<WAYS>, usize), Stop> {
    let config = directory::config::<S, WAYS, SETS>(s)?;
    // The only set is a constant to Kani, and with it every place of its metadata.
    let own = if SETS == 1 { 0 } else { s.value("set", 0..=SETS as u32 - 1, draw::words(0, SETS)) as usize };
    let set = set(s, config.policy)?;
    let mut truth = [s.value("byte beside the set", 0..=u8::MAX, &BYTES[9..10]); MOST_BYTES];
    put(&mut truth, own, &set);
    let b = version_b::<S, GRANULE>(s, &config, &truth);
    Ok((truth, b, set, own))
}

/// Metadata that loads what it was given, and keeps what was stored.
#[derive(Clone, Debug)]
pub(crate) struct Scripted<const WAYS: usize> {
    pub(crate) load: Set<WAYS>,
    pub(crate) loaded: Option<SetIndex>,
    pub(crate) stored: Option<(SetIndex, Set<WAYS>)>,
}

impl<const WAYS: usize> Metadata<WAYS> for Scripted<WAYS> {
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        self.loaded = Some(index);
        self.load
    }

    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        self.stored = Some((index, *set));
    }

    fn clear(&mut self) {}
}

/// Whether the metadata of a set is detected to be corrupt. Which errors are is a theorem of the entry
/// (`short_errors_are_detected`); Kani does without this, and takes all that are listed.
fn is_detected(bytes: &[u8], policy: Policy) -> bool {
    cfg!(kani) || {
        let entries = std::array::from_fn(|way| std::array::from_fn(|i| bytes[way * ENTRY_BYTES + i]));
        Set::<WAYS>::from_entries(entries, policy).is_err()
    }
}

/// Stores a full set as one of eight, in granules of so many bytes, and loads it again; returns how many granules it
/// takes.
fn keeps_its_set<const WAYS: usize, const GRANULE: usize>(own: u32, first_line: u32) -> Result<u64, Stop> {
    let geometry = Geometry::new(Bytes(8 * WAYS as u64), Bytes(1), WAYS as u32);
    let geometry = geometry.map_err(|error| Stop::Disproved(error.to_string()))?;
    let config = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
    let mut b = CachedMetadata::<WAYS, 1, GRANULE>::new(&config, 1, Policy::Lru);
    let mut set = Set::<WAYS>::empty(Policy::Lru);
    for way in 0..WAYS as u32 {
        set = set.access(LineAddr(first_line + way), Policy::Lru).0;
    }
    let bytes = WAYS * ENTRY_BYTES;
    let begin = own as usize * bytes;
    let used = ((begin + bytes - 1) / GRANULE - begin / GRANULE + 1) as u64;
    b.store(SetIndex(own), &set);
    // Each granule has changed.
    check_eq!(
        b.observer.accesses,
        used,
        "{set:?} stored as set {own} in granules of {GRANULE} bytes: granules used"
    );
    b.observer = MetadataTraffic::default();
    check_eq!(b.load(SetIndex(own)), set, "set {own} in granules of {GRANULE} bytes");
    check_eq!(
        b.observer.accesses,
        used,
        "{set:?} loaded as set {own} from granules of {GRANULE} bytes: granules used"
    );
    Ok(used)
}

theorems! {
    /// With metadata of any version, an access loads the set of its line, answers as one step of this
    /// set does, and stores the set after the step.
    #["VM-13", unwind 5, covers ["hit", "miss"]]
    fn directory_answers_from_what_it_loads(s) {
        let config = directory::config::<S, 2, 2>(s)?;
        let set = draw::set_of::<S, 2>(s, config.policy)?;
        let mut directory = Directory::over(config, Scripted { load: set, loaded: None, stored: None });
        let line = draw::line(s, &WORDS[..4]);
        let (next, expected) = set.access(line, config.policy);
        let outcome = directory.access(line);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        let own = config.set_of(line);
        check_eq!((outcome, directory.metadata.loaded), (expected, Some(own)), "{line:?}, {set:?}");
        check_eq!(directory.metadata.stored, Some((own, next)), "{line:?}, {set:?}: set stored");
    }

    /// With metadata of any version, an invalidation of a line loads its set, and stores the set
    /// without the line if the line was resident.
    #["VM-13", unwind 5, covers ["forgotten", "not there"]]
    fn directory_invalidates_what_it_loads(s) {
        let config = directory::config::<S, 2, 2>(s)?;
        let set = draw::set_of::<S, 2>(s, config.policy)?;
        let mut directory = Directory::over(config, Scripted { load: set, loaded: None, stored: None });
        let addr = draw::addr(s, &[0, 1, 2, 3, 4, 7]);
        let line = config.geometry.line_of(addr);
        let (next, way) = set.invalidate(line);
        directory.invalidate(addr, 1);
        cover!(s, "forgotten", way.is_some());
        cover!(s, "not there", way.is_none());
        let own = config.set_of(line);
        let expected = way.map(|_| (own, next));
        check_eq!((directory.metadata.loaded, directory.metadata.stored), (Some(own), expected), "{addr:?}, {set:?}");
    }

    /// Version B loads the metadata of a set as it was stored, whichever granules it has to load, evict
    /// and write back for that, and stays consistent.
    #["VM-13", unwind 13, covers ["from the cache", "from the card", "written back"]]
    fn version_b_loads_what_it_holds(s) {
        let (truth, mut b, set, own) = any::<S, SMALL>(s)?;
        let before = shown!(b.clone());
        check_eq!(b.load(SetIndex(own as u32)), set, "set {own} of {before:?}");
        cover!(s, "from the cache", b.observer.loads < b.observer.accesses);
        cover!(s, "from the card", b.observer.loads == b.observer.accesses);
        cover!(s, "written back", b.observer.write_backs > 0);
        check!(holds(&b, &truth), "set {own} of {before:?}: {b:?}");
    }

    /// A store replaces the metadata of one set and no other byte; a granule becomes dirty, and so
    /// costs a write-back, only if it changes.
    #["VM-13", unwind 13, covers ["changed", "unchanged", "written back"]]
    fn version_b_stores_one_set(s) {
        let (mut truth, mut b, was, own) = any::<S, SMALL>(s)?;
        let new = set(s, b.lines)?;
        let before = shown!(b.clone());
        let was_dirty = b.cache[0].dirty[0];
        let changed = new != was;
        put(&mut truth, own, &new);
        b.store(SetIndex(own as u32), &new);
        cover!(s, "changed", changed);
        cover!(s, "unchanged", !changed && !was_dirty);
        cover!(s, "written back", b.observer.write_backs > 0);
        check!(holds(&b, &truth), "{new:?} stored as set {own} of {before:?}: {b:?}");
        let written = b.cache[0].dirty[0] || b.observer.write_backs > 0;
        check_eq!(written, changed || was_dirty, "{new:?} stored as set {own} of {before:?}: written");
    }

    /// After a flush version B holds what a new version A holds, whatever was in its cache.
    #["VM-13", unwind 14, covers ["a dirty granule"]]
    fn version_b_forgets_all(s) {
        let (mut truth, mut b, ..) = any::<S, SMALL>(s)?;
        let before = shown!(b.clone());
        cover!(s, "a dirty granule", b.cache[0].dirty[0]);
        b.clear();
        let empty = Set::<WAYS>::empty(b.lines).to_entries();
        for i in 0..MOST_BYTES {
            truth[i] = empty[i / ENTRY_BYTES % WAYS][i % ENTRY_BYTES];
        }
        check!(holds(&b, &truth), "{before:?}: {b:?}");
    }

    /// A set whose metadata is detected to be corrupt counts as empty and is reported; the metadata
    /// stored next is intact again.
    #["VM-14", unwind 10, covers ["in the metadata cache", "on the card"]]
    fn corrupt_metadata_makes_an_empty_set(s) {
        // The whole set in one granule: what is wrong in the cache is not evicted before it is
        // looked at.
        let (mut truth, mut b, _, own) = any::<S, LARGE>(s)?;
        assume!(own == 0);
        let last = 8 * SET_BYTES as u32 - 1;
        let small: &[u32] = if cfg!(kani) { &[] } else { &[0, 1, 7, 32, 39, 40, 79] };
        let bit = s.value("bit", 0..=last, small) as usize;
        let cache = &mut b.cache[0];
        let in_cache = cache.set.resident[0] && cache.set.lines[0].0 == 0;
        let place = if in_cache { &mut cache.contents[0][..] } else { &mut b.card[..LARGE] };
        place[bit / 8] ^= 1 << (bit % 8);
        assume!(is_detected(&place[..SET_BYTES], b.lines));
        cover!(s, "in the metadata cache", in_cache);
        cover!(s, "on the card", !in_cache);
        let before = shown!(b.clone());
        check_eq!(b.load(SetIndex(0)), Set::empty(b.lines), "bit {bit} of {before:?}");
        check_eq!(b.observer.corrupt, 1, "bit {bit} of {before:?}: sets detected to be corrupt");
        let new = set(s, b.lines)?;
        put(&mut truth, 0, &new);
        b.store(SetIndex(0), &new);
        check!(holds(&b, &truth), "bit {bit} of {before:?}, then {new:?} stored: {b:?}");
    }

    /// The metadata of a set is asked for granule by granule, and exactly the granules that are not in
    /// the metadata cache are loaded.
    #["VM-13", unwind 13, covers ["from the cache", "written back"]]
    fn metadata_traffic_counts_granules(s) {
        let (_, mut b, _, own) = any::<S, SMALL>(s)?;
        let (first, last) = (own * SET_BYTES / SMALL, ((own + 1) * SET_BYTES - 1) / SMALL);
        let before = shown!(b.clone());
        // In a cache of one granule each evicts the one before.
        let found = b.cache[0].set.resident[0] && b.cache[0].set.lines[0].0 as usize == first;
        let dirty = b.cache[0].dirty[0];
        let [accesses, loads, write_backs] = [(); 3].map(|()| s.value("count before", 0..=u64::MAX >> 1, &[u64::MAX >> 2]));
        b.observer = MetadataTraffic { accesses, loads, write_backs, corrupt: 0 };
        cover!(s, "from the cache", found);
        cover!(s, "written back", dirty);
        b.load(SetIndex(own as u32));
        let used = (last - first + 1) as u64;
        let expected = MetadataTraffic {
            accesses: accesses + used,
            loads: loads + used - u64::from(found),
            write_backs: write_backs + u64::from(dirty),
            corrupt: 0,
        };
        check_eq!(b.observer, expected, "set {own} of {before:?}");
    }

    /// A set whose metadata has an error that is detected, in the bits of an entry or because the entries make no legal set,
    /// counts as empty, whichever set it is, wherever the error lies, in the metadata cache alone or on the card too; and after the next store version B holds the new metadata, and loses it
    /// with no granule.
    #["VM-14", unwind 14, covers ["on the card", "in the cache alone", "in both", "in a dirty granule", "the error stored", "no legal set"]]
    fn corruption_in_any_set_makes_it_empty(s) {
        let config = directory::config::<S, WAYS, SETS>(s)?;
        s.size("bytes a granule", HALF);
        let own = if cfg!(kani) { 0 } else { s.value("set", 0..=MANY as u32 - 1, draw::words(0, MANY)) as usize };
        let was = set(s, config.policy)?;
        let way = s.value("way", 0..=WAYS as u32 - 1, draw::words(0, WAYS)) as usize;
        // An entry with an error that its check bits detect; or one that is right, but has the management bits of another
        // way. To Kani the set has one way.
        let exchanged = !cfg!(kani) && draw::flag(s, "management bits of another way");
        let error = if exchanged {
            let entry = |order| Entry { line: was.lines[way], resident: was.resident[way], order }.encode();
            let [right, wrong] = [way, (way + 1) % WAYS].map(|way| entry(was.order[way]));
            let bits = std::array::from_fn(|i| if i < ENTRY_BYTES { right[i] ^ wrong[i] } else { 0 });
            u64::from_le_bytes(bits)
        } else {
            short_error(s, &[0, 7, 31, 36, 39], &BYTES[..4])?
        };
        let other = s.value("byte beside the set", 0..=u8::MAX, &BYTES[9..10]);
        let mut right = [other; MANY_BYTES];
        for (i, byte) in was.to_entries().as_flattened().iter().enumerate() {
            right[own * SET_BYTES + i] = *byte;
        }
        let mut wrong = right;
        for i in 0..ENTRY_BYTES {
            wrong[own * SET_BYTES + way * ENTRY_BYTES + i] ^= (error >> (8 * i)) as u8;
        }
        assume!(is_detected(&wrong[own * SET_BYTES..][..SET_BYTES], config.policy));
        // Where the error is: on the card, in a clean cache alone, in both, in a dirty cache.
        let place = s.value("place (card, cache, both, dirty cache)", 0..=3, &BYTES[..4]);
        let mut b = CachedMetadata::<WAYS, 2, HALF, MetadataTraffic> {
            lines: config.policy,
            granules: Policy::Lru,
            cache: vec![DataSet::empty(Policy::Lru, [0; HALF])],
            card: if place == 1 { right.to_vec() } else { wrong.to_vec() },
            observer: MetadataTraffic::default(),
        };
        if place > 0 {
            // A metadata cache of one set that holds all granules of the set of lines, so that none is evicted before it is
            // looked at.
            for k in 0..2 {
                if let Some(granule) = CachedMetadata::<WAYS, 2, HALF, MetadataTraffic>::granule_of(SetIndex(own as u32), k) {
                    let cache = &mut b.cache[0];
                    (cache.set.lines[k], cache.set.resident[k], cache.dirty[k]) = (granule, true, place == 3);
                    for i in 0..HALF {
                        cache.contents[k][i] = wrong[granule.0 as usize * HALF + i];
                    }
                }
            }
        }
        cover!(s, "on the card", place == 0);
        cover!(s, "in the cache alone", place == 1);
        cover!(s, "in both", place == 2);
        cover!(s, "in a dirty granule", place == 3);
        // Of no error in one entry.
        cover!(s, "no legal set", cfg!(kani) || exchanged);
        let before = shown!(b.clone());
        check_eq!(b.load(SetIndex(own as u32)), Set::empty(b.lines), "set {own}, bits {error:#x} of way {way}: {before:?}");
        check_eq!(b.observer.corrupt, 1, "set {own}, bits {error:#x} of way {way}: sets detected to be corrupt in {before:?}");
        // The line that the wrong bits name may be the one that is stored.
        let as_wrong = draw::flag(s, "the error is stored");
        let mut new = was;
        if as_wrong {
            new.lines[way] = LineAddr(new.lines[way].0 ^ error as u32);
            assume!(new.is_valid(config.policy));
        } else {
            new = set(s, config.policy)?;
        }
        cover!(s, "the error stored", as_wrong);
        b.store(SetIndex(own as u32), &new);
        for (i, byte) in new.to_entries().as_flattened().iter().enumerate() {
            right[own * SET_BYTES + i] = *byte;
        }
        let cache = b.cache[0];
        for i in 0..MANY_BYTES {
            let mut holder = None;
            for k in 0..2 {
                if cache.set.resident[k] && cache.set.lines[k].0 as usize == i / HALF {
                    holder = Some(k);
                }
            }
            // A granule that is not dirty may be dropped at any time.
            let (now, safe) = match holder {
                Some(k) => (cache.contents[k][i % HALF], cache.dirty[k] || b.card[i] == cache.contents[k][i % HALF]),
                None => (b.card[i], true),
            };
            check!(now == right[i] && safe, "set {own}, bits {error:#x} of way {way}, then {new:?} stored in {before:?}: byte {i} of {b:?}");
        }
    }

    /// What version B says of a set's metadata is what its metadata cache of 4 ways holds, in whichever way, and else what
    /// the card holds, granule by granule.
    #["VM-13", unwind 22, covers ["all in the cache", "all on the card", "some of both"]]
    fn entries_are_those_in_the_cache_or_on_the_card(s) {
        // The set's 5 bytes (one way) lie in granules 1 and 2 of 4 bytes, or in granules 0 and 1.
        let own = s.value("set", 0..=1, draw::words(0, 2)) as usize;
        let mut cache = DataSet::<4, [u8; 4]>::empty(Policy::Lru, [0; 4]);
        let mut ways = [4; 3];
        for granule in 0..3 {
            let way = s.value("way of a granule, 4 for none", 0..=4, &BYTES[..5]);
            ways[granule] = usize::from(way);
            for earlier in 0..granule {
                assume!(way == 4 || usize::from(way) != ways[earlier]);
            }
            for slot in 0..4 {
                if slot == usize::from(way) {
                    (cache.set.lines[slot], cache.set.resident[slot]) = (LineAddr(granule as u32), true);
                    cache.contents[slot] = [100 + granule as u8; 4];
                    cache.dirty[slot] = granule == 1;
                }
            }
        }
        let card: [u8; 12] = std::array::from_fn(|i| i as u8);
        let b = CachedMetadata::<1, 4, 4, MetadataTraffic> {
            lines: Policy::Lru,
            granules: Policy::Lru,
            cache: vec![cache],
            card: card.to_vec(),
            observer: MetadataTraffic::default(),
        };
        let [entry] = b.entries(SetIndex(own as u32));
        let mut cached = 0;
        for i in 0..ENTRY_BYTES {
            let at = own * ENTRY_BYTES + i;
            let in_cache = ways[at / 4] < 4;
            cached += usize::from(in_cache);
            let expected = if in_cache { 100 + (at / 4) as u8 } else { at as u8 };
            check_eq!(entry[i], expected, "byte {i} of set {own} of {b:?}");
        }
        cover!(s, "all in the cache", cached == ENTRY_BYTES);
        cover!(s, "all on the card", cached == 0);
        cover!(s, "some of both", cached > 0 && cached < ENTRY_BYTES);
    }

    /// Each granule of a set is used by one step of its set of the metadata cache, with the replacement that this cache has: LRU,
    /// FIFO or PLRU.
    #["VM-13", unwind 10, covers ["LRU", "FIFO", "PLRU", "hit", "miss"]]
    fn granules_are_replaced_as_their_cache_says(s) {
        let policy = draw::policy(s);
        let mut cache = DataSet::<2, [u8; 8]>::empty(policy, [0; 8]);
        let (full, order) = (draw::flag(s, "full"), draw::order(s, policy));
        for way in 0..2 {
            cache.set.resident[way] = full || draw::flag(s, "resident");
            cache.set.lines[way] = LineAddr(s.value("granule of a way", 0..=4, draw::words(way, 2)));
        }
        cache.set.order = order;
        assume!(cache.is_valid(policy));
        let mut b = CachedMetadata::<1, 2, 8, MetadataTraffic> {
            lines: Policy::Lru,
            granules: policy,
            cache: vec![cache],
            card: vec![0; 40],
            observer: MetadataTraffic::default(),
        };
        // Of the sets of one way, those whose 5 bytes lie in one granule.
        let own = [0, 2, 5, 7][s.value("set (0, 2, 5, 7)", 0..=3, &BYTES[..4]) as usize];
        let granule = LineAddr((own * ENTRY_BYTES / 8) as u32);
        let (next, outcome) = cache.set.access(granule, policy);
        cover!(s, "LRU", policy == Policy::Lru);
        cover!(s, "FIFO", policy == Policy::Fifo);
        cover!(s, "PLRU", policy == Policy::Plru);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        b.load(SetIndex(own as u32));
        check_eq!(b.cache[0].set, next, "{granule:?} used, {policy:?}: {cache:?}");
    }

    /// A set of 8 or 16 ways, whose metadata is up to 80 bytes in up to 21 granules, is stored whole and loaded as it was
    /// stored, granule by granule.
    #["VM-13", not_for_kani "the entries of 16 ways take it more than 120 seconds", covers ["8 ways", "16 ways", "more than 8 granules", "more than 16 granules"]]
    fn wide_sets_are_kept_in_all_their_granules(s) {
        let ways = if draw::flag(s, "16 ways") { 16 } else { 8 };
        let granule = s.value("log2 granule", 2..=4, &BYTES[2..5]);
        let own = s.value("set", 0..=7, &WORDS[..4]);
        let first_line = s.value("first line", 0..=u32::MAX - 16, &WORDS[3..5]);
        cover!(s, "8 ways", ways == 8);
        cover!(s, "16 ways", ways == 16);
        let used = match (ways, granule) {
            (8, 2) => keeps_its_set::<8, 4>(own, first_line)?,
            (8, 3) => keeps_its_set::<8, 8>(own, first_line)?,
            (8, _) => keeps_its_set::<8, 16>(own, first_line)?,
            (_, 2) => keeps_its_set::<16, 4>(own, first_line)?,
            (_, 3) => keeps_its_set::<16, 8>(own, first_line)?,
            _ => keeps_its_set::<16, 16>(own, first_line)?,
        };
        cover!(s, "more than 8 granules", used > 8);
        cover!(s, "more than 16 granules", used > 16);
    }

    /// A metadata cache of up to 64 sets uses each of them: a granule lies in the set that its lower bits name.
    #["VM-13", not_for_kani "many sets are too many for it; which set the lower bits name is a theorem of the hash", covers ["64 sets", "one set", "a set beyond the eighth"]]
    fn granules_use_every_set_of_the_metadata_cache(s) {
        let log2 = s.value("log2 sets of the metadata cache", 0..=6, &WORDS[..7]);
        let geometry = draw::of_logarithms(0, 0, 8)?;
        let config = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        let sets = 1 << log2;
        let mut b = CachedMetadata::<1, 1, SMALL>::new(&config, sets, Policy::Lru);
        let own = SetIndex(s.value("set", 0..=255, &[0, 1, 6, 7, 8, 15, 31, 49, 50, 51, 52, 255]));
        b.load(own);
        cover!(s, "64 sets", sets == 64);
        cover!(s, "one set", sets == 1);
        for (index, cached) in b.cache.iter().enumerate() {
            let number = cached.set.lines[0].0 as usize;
            cover!(s, "a set beyond the eighth", index >= 8 && cached.set.resident[0]);
            check!(!cached.set.resident[0] || number % sets == index, "{own:?}: granule {number} in set {index} of {sets}");
        }
    }
}
