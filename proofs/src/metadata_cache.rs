//! Theorems of version B: its metadata is A's, wherever it lies (VM-13, VM-14).
//!
//! **One step from any consistent state.** A and B start from the same sets. B's are spread over
//! the metadata cache and the on-board memory in any way that is consistent: a granule in the
//! cache is what counts, and a clean one is the same on the card. Two sets of two ways have 20
//! bytes of metadata; in granules of 16 bytes the second set straddles two, and in a metadata
//! cache of one way each pushes the other out.

use crate::data_set::data_set;
use crate::draw::{self, BYTES, WORDS};
use crate::source::{Source, Stop};
use crate::vm::{self, WAYS};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_model::metadata_cache::{CachedMetadata, MetadataTraffic};
use saarcor_model::set::{Outcome, Policy, Set};
use saarcor_model::units::{LineAddr, SetIndex};
use saarcor_model::vm::{Directory, Metadata};

const META_WAYS: usize = 1;
const GRANULE: usize = 16;
/// Granules of the 20 bytes of two sets.
const GRANULES: usize = 2;

type B = CachedMetadata<WAYS, META_WAYS, GRANULE>;

/// The metadata of `sets` as the on-board memory would hold it: whole granules.
fn encoded(sets: &[Set<WAYS>]) -> [u8; GRANULES * GRANULE] {
    let mut bytes = [0; GRANULES * GRANULE];
    for (index, set) in sets.iter().enumerate() {
        let entries = set.to_entries();
        for (i, byte) in entries.as_flattened().iter().enumerate() {
            bytes[index * 10 + i] = *byte;
        }
    }
    bytes
}

/// Any consistent state of version B that holds `sets`.
fn version_b<S: Source>(s: &mut S, a: &Directory<WAYS>) -> Result<B, Stop> {
    let granules = if draw::flag(s, "metadata cache: fifo") { Policy::Fifo } else { Policy::Lru };
    let mut metadata = CachedMetadata::new(&a.config, 1, granules);
    let truth = encoded(a.sets());
    metadata.card.copy_from_slice(&truth);
    let mut cached = data_set::<S, META_WAYS, GRANULE>(s, granules)?;
    let stale = s.value("old byte on the card", 0..=u8::MAX, &BYTES[..1]);
    for way in 0..META_WAYS {
        if cached.set.resident[way] {
            let granule = cached.set.lines[way].0 as usize;
            assume!(granule < GRANULES);
            for i in 0..GRANULE {
                cached.bytes[way][i] = truth[granule * GRANULE + i];
                if cached.dirty[way] {
                    metadata.card[granule * GRANULE + i] = stale;
                }
            }
        }
    }
    metadata.cache[0] = cached;
    Ok(metadata)
}

/// Whether B holds `sets`, and consistently: clean granules are the same on the card.
fn holds(metadata: &B, sets: &[Set<WAYS>]) -> bool {
    let mut same = metadata.cache[0].is_valid(metadata.granules);
    for (index, set) in sets.iter().enumerate() {
        same &= metadata.entries(SetIndex(index as u32)) == set.to_entries();
    }
    let cached = &metadata.cache[0];
    for way in 0..META_WAYS {
        if cached.set.resident[way] && !cached.dirty[way] {
            let granule = cached.set.lines[way].0 as usize;
            for i in 0..GRANULE {
                same &= metadata.card[granule * GRANULE + i] == cached.bytes[way][i];
            }
        }
    }
    same
}

/// A and B in any state, B holding what A holds.
fn both<S: Source>(s: &mut S) -> Result<(Directory<WAYS>, Directory<WAYS, B>), Stop> {
    let a = vm::directory(s)?;
    let b = Directory::over(a.config, version_b(s, &a)?);
    Ok((a, b))
}

theorems! { "metadata_cache";
    /// Version B answers every access as version A does: same hit, way and victim, same counters.
    #["VM-13", unwind 34, covers ["hit", "miss", "metadata from the card", "metadata written back"]]
    fn version_b_answers_what_a_answers(s) {
        let (mut a, mut b) = both(s)?;
        let line = draw::line(s, &WORDS[..7]);
        let state = shown!(b.clone());
        let (in_a, in_b) = (a.access(line), b.access(line));
        cover!(s, "hit", matches!(in_a, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(in_a, Outcome::Miss { .. }));
        cover!(s, "metadata from the card", b.metadata.traffic.loads > 0);
        cover!(s, "metadata written back", b.metadata.traffic.write_backs > 0);
        check_eq!(in_b, in_a, "{line:?}, sets {:?}, B {:?}", a.sets(), state.metadata);
        check_eq!(b.counters, a.counters, "{line:?}, B {:?}", state.metadata);
    }

    /// After every access version B holds what version A holds: no update of residence or order is
    /// lost, whatever granules are loaded, pushed out and written back on the way.
    #["VM-13", unwind 34, covers ["changed", "unchanged", "straddling granules"]]
    fn version_b_loses_no_update(s) {
        let (mut a, mut b) = both(s)?;
        let line = draw::line(s, &WORDS[..7]);
        let state = shown!(b.clone());
        let before = a.clone();
        a.access(line);
        b.access(line);
        cover!(s, "changed", a.metadata != before.metadata);
        cover!(s, "unchanged", a.metadata == before.metadata);
        cover!(s, "straddling granules", b.metadata.traffic.accesses > 2);
        check!(holds(&b.metadata, a.sets()), "{line:?}: A {:?}, B was {:?}, is {:?}", a.sets(), state.metadata, b.metadata);
    }

    /// After every invalidation and every flush version B holds what version A holds.
    #["VM-13", unwind 34, covers ["lines forgotten", "flush"]]
    fn version_b_forgets_what_a_forgets(s) {
        let (mut a, mut b) = both(s)?;
        let addr = draw::addr(s, &[0, 2, 5, 8]);
        let len = s.value("bytes", 0..=u64::MAX, &[1, 3, 9]);
        let flush = draw::flag(s, "flush");
        let state = shown!(b.clone());
        if flush {
            a.flush();
            b.flush();
        } else {
            a.invalidate(addr, len);
            b.invalidate(addr, len);
        }
        cover!(s, "lines forgotten", a.counters.invalidated > 0);
        cover!(s, "flush", flush);
        check_eq!(b.counters, a.counters, "{len} bytes at {addr:?}, B {:?}", state.metadata);
        check!(holds(&b.metadata, a.sets()), "{len} bytes at {addr:?}: A {:?}, B was {:?}, is {:?}", a.sets(), state.metadata, b.metadata);
    }

    /// A granule becomes dirty, and so costs a write-back, only if the set's metadata changes.
    #["VM-13", unwind 34, covers ["changed", "unchanged"]]
    fn unchanged_metadata_is_not_written(s) {
        let (mut a, mut b) = both(s)?;
        assume!(!b.metadata.cache[0].dirty[0]);
        let line = draw::line(s, &WORDS[..7]);
        let before = a.clone();
        let state = shown!(b.clone());
        a.access(line);
        b.access(line);
        let changed = a.metadata != before.metadata;
        cover!(s, "changed", changed);
        cover!(s, "unchanged", !changed);
        let written = b.metadata.cache[0].dirty[0] || b.metadata.traffic.write_backs > 0;
        check_eq!(written, changed, "{line:?}: A {:?}, B was {:?}, is {:?}", a.sets(), state.metadata, b.metadata);
    }

    /// A set whose metadata is told to be corrupt is taken for empty: its next access misses, and
    /// is counted.
    #["VM-14", unwind 34, covers ["set 0", "set 1"]]
    fn corrupt_metadata_makes_an_empty_set(s) {
        let config = vm::config(s)?;
        let mut b = Directory::over(config, CachedMetadata::<WAYS, META_WAYS, GRANULE>::new(&config, 1, Policy::Lru));
        let line = LineAddr(s.value("line", 0..=u32::MAX, &WORDS[..4]));
        let set = config.set_of(line);
        b.access(line);
        let bit = s.value("bit", 0..=79, &[0, 1, 7, 32, 39, 40, 79_u32]) as usize;
        // Turned over where it lies: in the metadata cache, and on the card.
        let byte = set.0 as usize * 10 + bit / 8;
        let cached = &mut b.metadata.cache[0];
        if cached.set.lines[0] == LineAddr((byte / GRANULE) as u32) {
            cached.bytes[0][byte % GRANULE] ^= 1 << (bit % 8);
        } else {
            b.metadata.card[byte] ^= 1 << (bit % 8);
        }
        let state = shown!(b.clone());
        let outcome = b.access(line);
        cover!(s, "set 0", set.0 == 0);
        cover!(s, "set 1", set.0 == 1);
        check!(matches!(outcome, Outcome::Miss { evicted: None, .. }), "bit {bit} of {set:?} in {state:?}: {outcome:?}");
        check_eq!(b.metadata.traffic.corrupt, 1, "bit {bit} of {set:?} in {state:?}: sets told to be corrupt");
        let again = b.access(line);
        check!(matches!(again, Outcome::Hit { .. }) && b.metadata.traffic.corrupt == 1, "bit {bit} of {set:?}, {line:?} twice: {again:?}");
    }

    /// The traffic is what it says: a set's metadata is asked for granule by granule, and what is
    /// not in the metadata cache is loaded.
    #["VM-13", unwind 34, covers ["one granule", "two granules", "from the cache"]]
    fn metadata_traffic_counts_granules(s) {
        let (a, b) = both(s)?;
        let index = s.value("set", 0..=1, &WORDS[..2]);
        let mut metadata = b.metadata;
        let before = metadata.clone();
        let held = metadata.cache[0].set;
        let granules = if index == 0 { 1 } else { 2 };
        // In a cache of one granule, the first of two is pushed out by the second.
        let found = held.resident[0] && held.lines[0].0 == 0;
        let dropped = u64::from(held.resident[0] && held.lines[0].0 != 0 && before.cache[0].dirty[0])
            + u64::from(granules == 2 && found && before.cache[0].dirty[0]);
        cover!(s, "one granule", granules == 1);
        cover!(s, "two granules", granules == 2);
        cover!(s, "from the cache", found);
        check_eq!(metadata.load(SetIndex(index)), a.sets()[index as usize], "set {index} of {before:?}");
        let expected = MetadataTraffic { accesses: granules, loads: granules - u64::from(found), write_backs: dropped, corrupt: 0 };
        check_eq!(metadata.traffic, expected, "set {index} of {before:?}");
    }
}
