//! Any legal state of a cache of any size. What a step can meet is drawn: the watched set, and one other.
//! The sets of a large cache beside these are empty.

use crate::assume;
use crate::draw::{self as parts, BYTES, WORDS};
use crate::source::{Source, Stop};
use crate::vm::directory as small;
use saarcor_model::vm::{
    Bytes, CacheConfig, CachedMetadata, DataSet, ENTRY_BYTES, Geometry, Hash, HostAddr, LineAddr, OnChip,
    Policy, Set, SetIndex,
};

/// The watched set, and the other that is not empty.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    /// The watched set.
    pub own: SetIndex,
    /// The other one; the same if there is one set alone.
    pub other: SetIndex,
}

/// Any cache: Kani, two sets of lines of two bytes, as the small scope has; at random, up to 16 384 sets of
/// lines of up to 4096 bytes, with any hash.
pub fn config<S: Source, const WAYS: usize>(s: &mut S) -> Result<CacheConfig, Stop> {
    if cfg!(kani) {
        return if WAYS == 1 { small::config::<S, 1, 1>(s) } else { small::config::<S, WAYS, 2>(s) };
    }
    s.size("ways", WAYS);
    let sets = s.value("log2 sets", 0..=14, &WORDS[1..2]);
    let line = s.value("log2 line", 0..=12, &WORDS[1..2]);
    let hash = s.value("hash (low, add-upper, add-upper-all)", 0..=2, &BYTES[1..2]);
    let policy = parts::policy(s);
    let hash = [Hash::Low, Hash::AddUpper, Hash::AddUpperAll][usize::from(hash)];
    match Geometry::new(Bytes((WAYS as u64) << (sets + line)), Bytes(1 << line), WAYS as u32) {
        Ok(geometry) => Ok(CacheConfig { geometry, hash, policy }),
        Err(_) => Err(Stop::Vacuous),
    }
}

/// Any set to watch, and any other.
pub fn around<S: Source>(s: &mut S, config: &CacheConfig) -> Around {
    let last = (config.geometry.sets() - 1) as u32;
    let own = SetIndex(s.value("watched set", 0..=last, parts::words(0, last.min(1) as usize + 1)));
    let other = if last < 2 { last - own.0 } else { s.value("other set", 0..=last, parts::words(0, 3)) };
    Around { own, other: SetIndex(other) }
}

/// A line of a set, by its upper bits: all hashes add these to the lower ones.
fn line_in(config: &CacheConfig, index: SetIndex, upper: u32) -> LineAddr {
    let geometry = config.geometry;
    let (line_bits, set_bits) = (geometry.line().0.ilog2(), geometry.set_bits());
    let upper = u64::from(upper) & ((1 << (32 - line_bits - set_bits)) - 1);
    let sum_of_upper = config.set_of(LineAddr((upper << set_bits) as u32));
    let lower = u64::from(index.0.wrapping_sub(sum_of_upper.0)) & (geometry.sets() - 1);
    LineAddr((upper << set_bits | lower) as u32)
}

/// Any address: Kani, of any byte; else a byte of a line of either set, so that lines meet each other.
pub fn addr<S: Source>(s: &mut S, config: &CacheConfig, around: Around) -> HostAddr {
    if cfg!(kani) {
        return parts::addr(s, &[]);
    }
    let index = if parts::flag(s, "in the other set") { around.other } else { around.own };
    addr_in(s, config, index)
}

/// Any address of a byte of a line of that set.
pub fn addr_in<S: Source>(s: &mut S, config: &CacheConfig, index: SetIndex) -> HostAddr {
    let line = line_in(config, index, s.value("upper bits", 0..=u32::MAX, &WORDS[..3]));
    let last = (config.geometry.line().0 - 1) as u32;
    let offset = s.value("offset", 0..=last, parts::words(last.min(1) as usize, 1));
    HostAddr(config.geometry.first_byte(line).0 + offset)
}

/// Any length of a range.
pub fn len(s: &mut impl Source) -> u64 {
    small::len(s)
}

/// Any legal set of lines of its own. Small scope: each way is as `resident` says, with the lines of `uppers`.
fn set_at<S: Source, const WAYS: usize>(
    s: &mut S,
    config: &CacheConfig,
    index: SetIndex,
    resident: &'static [u8],
    uppers: impl Fn(usize) -> &'static [u32],
) -> Result<Set<WAYS>, Stop> {
    let mut set = Set::empty(config.policy);
    for way in 0..WAYS {
        set.resident[way] = s.value("resident", 0..=1, resident) == 1;
        if set.resident[way] {
            let bits = s.value("upper bits of a line", 0..=u32::MAX, uppers(way));
            set.lines[way] = if cfg!(kani) { LineAddr(bits) } else { line_in(config, index, bits) };
            assume!(config.set_of(set.lines[way]) == index);
        }
    }
    set.order = parts::order(s, config.policy);
    assume!(set.is_valid(config.policy));
    Ok(set)
}

/// The metadata of version A in any legal state.
pub fn version_a<S: Source, const WAYS: usize>(
    s: &mut S,
    config: &CacheConfig,
    around: Around,
) -> Result<OnChip<WAYS>, Stop> {
    let mut on_chip = OnChip::new(config.geometry.sets(), config.policy);
    if cfg!(kani) {
        // Constant indices.
        for index in 0..on_chip.sets.len() {
            on_chip.sets[index] = set_at(s, config, SetIndex(index as u32), &[], |_| &[])?;
        }
    } else {
        on_chip.sets[around.other.0 as usize] =
            set_at(s, config, around.other, &BYTES[..2], |_| &WORDS[..2])?;
        on_chip.sets[around.own.0 as usize] = set_at(s, config, around.own, &BYTES[..2], |_| &WORDS[..3])?;
    }
    Ok(on_chip)
}

/// The metadata of version B in any consistent state.
///
/// Small scope: each way of the watched set holds one line or none, each of the other a line; of the granules of the watched set and one more, each
/// is in the cache or not, dirty or not.
pub fn version_b<S: Source, const WAYS: usize, const META_WAYS: usize, const GRANULE: usize>(
    s: &mut S,
    config: &CacheConfig,
    around: Around,
    meta_sets: usize,
) -> Result<CachedMetadata<WAYS, META_WAYS, GRANULE>, Stop> {
    s.size("metadata ways", META_WAYS);
    s.size("metadata sets", meta_sets);
    s.size("bytes a granule", GRANULE);
    let set_bytes = WAYS * ENTRY_BYTES;
    // Of one granule there is one order, and those of four are too many for the small scope.
    let granules = if META_WAYS == 2 { parts::policy(s) } else { Policy::Lru };
    let mut b = CachedMetadata::<WAYS, META_WAYS, GRANULE>::new(config, meta_sets, granules);
    for index in [around.other, around.own] {
        let resident = if index == around.own { &BYTES[..2] } else { &BYTES[1..2] };
        let set = set_at::<S, WAYS>(s, config, index, resident, |way| parts::words(way, 1))?;
        let begin = index.0 as usize * set_bytes;
        let entries = set.to_entries();
        for way in 0..WAYS {
            for i in 0..ENTRY_BYTES {
                b.card[begin + way * ENTRY_BYTES + i] = entries[way][i];
            }
        }
        if around.own == around.other {
            break;
        }
    }
    let stale = s.value("old byte on the card", 0..=u8::MAX, &BYTES[..1]);
    let turn =
        if META_WAYS == 1 { 0 } else { s.value("first way", 0..=META_WAYS as u8 - 1, &BYTES[..META_WAYS]) };
    let begin = around.own.0 as usize * set_bytes;
    let (first, last) = (begin / GRANULE, (begin + set_bytes - 1) / GRANULE);
    let end = b.card.len() / GRANULE - 1;
    let another = if cfg!(kani) {
        last
    } else {
        s.value("another granule", 0..=end as u32, parts::words(0, 1)) as usize
    };
    for granule in (first..=last).chain([another]) {
        if !parts::flag(s, "granule is resident") {
            continue;
        }
        let cached: &mut DataSet<META_WAYS, [u8; GRANULE]> = &mut b.cache[granule & (meta_sets - 1)];
        let taken = cached.set.resident.iter().filter(|resident| **resident).count();
        let way = (usize::from(turn) + taken) % META_WAYS;
        let line = LineAddr(granule as u32);
        if cached.set.resident[way] || cached.set.way_of(line).is_some() {
            continue;
        }
        (cached.set.lines[way], cached.set.resident[way]) = (line, true);
        cached.dirty[way] = parts::flag(s, "dirty");
        let card = &mut b.card[granule * GRANULE..][..GRANULE];
        cached.contents[way].copy_from_slice(card);
        if cached.dirty[way] {
            card.fill(stale);
        }
    }
    for cached in &mut b.cache {
        if META_WAYS <= 2 && cached.set.resident.contains(&true) {
            cached.set.order = parts::order(s, granules);
        }
        assume!(cached.is_valid(granules));
    }
    Ok(b)
}
