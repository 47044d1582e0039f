//! Theorems of where version B's metadata lies, for caches of any size: up to 2^32 lines, 20 GiB of metadata (VM-13).
//!
//! Arithmetic alone, without a state: so it speaks of every set, and of every byte of its metadata.

use crate::draw::{BYTES, EDGES};
use crate::source::{Holds, Source};
use crate::{check, check_eq, cover, theorems};
use saarcor_model::vm::{CachedMetadata, ENTRY_BYTES, LineAddr, MetadataTraffic, SetIndex};

type B<const WAYS: usize, const GRANULE: usize> = CachedMetadata<WAYS, 4, GRANULE, MetadataTraffic>;

/// Any set that a cache of `WAYS` ways may have: it has 2^32 lines at most.
fn any_set<const WAYS: usize>(s: &mut impl Source) -> SetIndex {
    SetIndex(s.value("set", 0..=u32::MAX, &EDGES) >> WAYS.trailing_zeros())
}

/// Any byte of the metadata of a set.
fn any_byte<const WAYS: usize>(s: &mut impl Source) -> usize {
    let last = WAYS * ENTRY_BYTES - 1;
    s.value("byte", 0..=last as u32, &[0, 1, 2, 3, 4][..ENTRY_BYTES.min(last + 1)]) as usize
}

/// Judges a body for sets of 1, 4 and 16 ways in granules of 8 bytes to 4 KB: ways, bytes a granule.
macro_rules! any_sizes {
    ($source:expr, $body:ident) => {
        match $source.value("sizes", 0..=5, &BYTES[..6]) {
            0 => $body::<S, 1, 8>($source)?,
            1 => $body::<S, 4, 16>($source)?,
            2 => $body::<S, 4, 64>($source)?,
            3 => $body::<S, 16, 8>($source)?,
            4 => $body::<S, 16, 4096>($source)?,
            _ => $body::<S, 1, 4096>($source)?,
        }
    };
}

fn byte_lies_where_it_should<S: Source, const WAYS: usize, const GRANULE: usize>(s: &mut S) -> Holds {
    s.size("ways", WAYS);
    s.size("bytes a granule", GRANULE);
    let (set, byte) = (any_set::<WAYS>(s), any_byte::<WAYS>(s));
    let (granule, offset) = B::<WAYS, GRANULE>::location_of(set, byte);
    let place = u64::from(set.0) * (WAYS * ENTRY_BYTES) as u64 + byte as u64;
    cover!(s, "beyond 64 KB", place > 1 << 16);
    cover!(s, "beyond 4 GiB", place > 1 << 32);
    cover!(s, "the first byte of all", place == 0);
    check!(offset < GRANULE, "byte {byte} of {set:?}: offset {offset} in granules of {GRANULE}");
    check_eq!(
        u64::from(granule.0) * GRANULE as u64 + offset as u64,
        place,
        "byte {byte} of {set:?}, {WAYS} ways, granules of {GRANULE}"
    );
    Ok(())
}

fn granules_hold_the_set<S: Source, const WAYS: usize, const GRANULE: usize>(s: &mut S) -> Holds {
    s.size("ways", WAYS);
    s.size("bytes a granule", GRANULE);
    let (set, byte) = (any_set::<WAYS>(s), any_byte::<WAYS>(s));
    let (holder, _) = B::<WAYS, GRANULE>::location_of(set, byte);
    let (first, _) = B::<WAYS, GRANULE>::location_of(set, 0);
    let (last, _) = B::<WAYS, GRANULE>::location_of(set, WAYS * ENTRY_BYTES - 1);
    let k = (holder.0 - first.0) as usize;
    cover!(s, "the second granule", k == 1);
    cover!(s, "a granule beyond 2^24", holder.0 >= 1 << 24);
    check_eq!(B::<WAYS, GRANULE>::granule_of(set, k), Some(holder), "{set:?}, byte {byte}: granule {k}");
    let behind = (last.0 - first.0) as usize + 1;
    cover!(s, "all in one granule", behind == 1);
    check_eq!(B::<WAYS, GRANULE>::granule_of(set, behind), None, "{set:?}: granule {behind}");
    Ok(())
}

fn granule_lies_on_the_card<S: Source, const WAYS: usize, const GRANULE: usize>(s: &mut S) -> Holds {
    s.size("ways", WAYS);
    s.size("bytes a granule", GRANULE);
    let granule = LineAddr(s.value("granule", 0..=u32::MAX, &EDGES));
    let begin = u64::from(granule.0) * GRANULE as u64;
    cover!(s, "beyond 2.5 MB", begin > 5 << 19);
    cover!(s, "the first", begin == 0);
    let place = B::<WAYS, GRANULE>::on_card(granule);
    check_eq!(place, begin as usize..begin as usize + GRANULE, "{granule:?} of {GRANULE} bytes");
    Ok(())
}

theorems! {
    /// The metadata of the sets lies one set after another, byte by byte: byte `i` of a set of `n` ways lies at
    /// 5 · n · set + i, in the granule and at the offset in it that hold this place, for up to 2^32 lines.
    #["VM-13", unwind 6, covers ["the first byte of all", "beyond 64 KB", "beyond 4 GiB"]]
    fn metadata_lies_set_after_set(s) {
        any_sizes!(s, byte_lies_where_it_should);
    }

    /// The granules of a set are those that hold a byte of its metadata, one after another, and none is behind the last.
    #["VM-13", unwind 6, covers ["all in one granule", "the second granule", "a granule beyond 2^24"]]
    fn granules_of_a_set_hold_its_metadata(s) {
        any_sizes!(s, granules_hold_the_set);
    }

    /// A granule lies on the card at its number times its size, whole.
    #["VM-13", unwind 6, covers ["the first", "beyond 2.5 MB"]]
    fn granule_lies_at_its_number_on_the_card(s) {
        any_sizes!(s, granule_lies_on_the_card);
    }
}
