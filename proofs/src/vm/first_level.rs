//! Theorems of the first-level caches, alone and in front of the virtual memory (L1-1, L1-2).
//!
//! **One witness**, as in [`super::virtual_memory`], and **one step from any consistent state**: a cache of two
//! sets of two ways (Kani: one set, since sets know nothing of each other), with lines of three
//! bytes, so that they are no power of two, as triangles are not. What a set of such a cache does is
//! what the sets of the virtual memory do: it is the same code (`data_set_decides_like_the_set`). A
//! read is made of steps, one a line ([`l1_reads_are_made_of_its_lines`]): there one way of one set is
//! enough.

use super::data_set::data_set;
use super::directory::counters;
use super::memory::unit;
use super::virtual_memory::{self, Watched};
use crate::draw::{self, BYTES, ENDS, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_model::vm::{
    DataSet, FirstLevel, FirstLevelCaches, HostAddr, HostMemory, LineAddr, Memory, Outcome, Policy, Unit, Way,
};

const SETS: usize = if cfg!(kani) { 1 } else { 2 };
/// Bytes a line.
const LINE: usize = 3;

/// The host's memory without a cache.
#[derive(Clone, Debug)]
struct Below(Watched);

impl Memory for Below {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        self.0.read(addr, bytes);
    }
}

/// Line and offset of the watched byte; none before the cached region.
fn place<const WAYS: usize, const LINE: usize>(
    l1: &FirstLevel<WAYS, [u8; LINE]>,
    watched: &Watched,
) -> Option<(LineAddr, usize)> {
    let place = watched.addr.checked_sub(l1.base.0)?;
    Some((LineAddr(place / LINE as u32), place as usize % LINE))
}

/// Any first-level cache from `base` on.
///
/// Small scope: three lines a set.
fn l1<S: Source, const WAYS: usize, const SETS: usize, const LINE: usize>(
    s: &mut S,
    base: HostAddr,
) -> Result<FirstLevel<WAYS, [u8; LINE]>, Stop> {
    s.size("sets", SETS);
    s.size("bytes a line", LINE);
    let policy = draw::policy(s);
    let mut l1 = FirstLevel::<WAYS, [u8; LINE]>::new(base, SETS, policy);
    for index in 0..SETS {
        let mut set: DataSet<WAYS, [u8; LINE]> = data_set::<S, WAYS, LINE>(s, policy)?;
        for way in 0..WAYS {
            // Any line of this set, by its upper bits.
            set.set.lines[way] = LineAddr(set.set.lines[way].0.wrapping_mul(SETS as u32) + index as u32);
            set.dirty[way] = false;
        }
        assume!(set.is_valid(policy));
        l1.sets[index] = set;
    }
    Ok(l1)
}

/// Makes the watched byte, which lies at this place, right wherever it is in the cache.
fn put_right<const WAYS: usize, const LINE: usize>(
    l1: &mut FirstLevel<WAYS, [u8; LINE]>,
    (line, offset): (LineAddr, usize),
    watched: &Watched,
) {
    for index in 0..l1.sets.len() {
        let mut set = l1.sets[index];
        for way in 0..WAYS {
            if set.set.resident[way] && set.set.lines[way] == line {
                set.contents[way][offset] = watched.byte;
            }
        }
        l1.sets[index] = set;
    }
}

/// Whether it is.
fn is_right<const WAYS: usize, const LINE: usize>(
    l1: &FirstLevel<WAYS, [u8; LINE]>,
    (line, offset): (LineAddr, usize),
    watched: &Watched,
) -> bool {
    let mut right = true;
    for index in 0..l1.sets.len() {
        let set = l1.sets[index];
        for way in 0..WAYS {
            let there = set.set.resident[way] && set.set.lines[way] == line;
            right &= !there || set.contents[way][offset] == watched.byte;
        }
    }
    right
}

/// Whether that line is in the cache.
fn holds<const WAYS: usize, const LINE: usize>(l1: &FirstLevel<WAYS, [u8; LINE]>, line: LineAddr) -> bool {
    let mut found = false;
    for index in 0..l1.sets.len() {
        let set = l1.sets[index];
        for way in 0..WAYS {
            found |= set.set.resident[way] && set.set.lines[way] == line;
        }
    }
    found
}

/// Whether a line begins where there are bytes.
fn begins_within_the_address_space<const WAYS: usize, Line: Copy>(
    l1: &FirstLevel<WAYS, Line>,
    line: LineAddr,
) -> bool {
    u64::from(l1.base.0) + u64::from(line.0) * u64::from(l1.line_bytes) < 1 << 32
}

/// Where the cached region begins. Small scope: address 0 or 1.
fn base(s: &mut impl Source) -> HostAddr {
    HostAddr(s.value("base", 0..=u32::MAX, &WORDS[..2]))
}

/// Any watched byte. Small scope: bytes of lines 0 to 4.
fn watched(s: &mut impl Source) -> Watched {
    let mut watched = virtual_memory::watched(s);
    watched.addr = s.value("watched address", 0..=u32::MAX, &[0, 1, 3, 5, 7, 13]);
    watched
}

theorems! {
    /// In any consistent state a first-level cache returns a line as the memory behind holds it, stays
    /// consistent, and counts the access as a hit or a miss.
    #["L1-1", unwind 6, covers ["found", "loaded", "another line", "evicted"]]
    fn l1_lines_are_what_lies_behind(s) {
        let watched = watched(s);
        let base = base(s);
        let mut l1 = l1::<S, 2, SETS, LINE>(s, base)?;
        let Some(place) = place(&l1, &watched) else { return Ok(()) };
        put_right(&mut l1, place, &watched);
        let line = draw::line(s, &WORDS[..6]);
        assume!(begins_within_the_address_space(&l1, line));
        let (hit, was_there) = (holds(&l1, line), holds(&l1, place.0));
        cover!(s, "found", hit && line == place.0);
        cover!(s, "loaded", !hit && line == place.0);
        cover!(s, "another line", line != place.0 && was_there);
        let state = shown!(l1.clone());
        let bytes = l1.line(&mut Below(watched.clone()), Unit::Intersection, line);
        cover!(s, "evicted", was_there && !holds(&l1, place.0));
        if line == place.0 {
            check_eq!(bytes[place.1], watched.byte, "byte {} of {line:?} through {state:?}", place.1);
        }
        check!(is_right(&l1, place, &watched), "{line:?} used in {state:?}: byte {} of {:?} in {l1:?}", place.1, place.0);
        check_eq!((l1.counters.hits(), l1.counters.misses), (u64::from(hit), u64::from(!hit)), "{line:?} used in {state:?}");
        for index in 0..SETS {
            check!(l1.sets[index].is_valid(l1.policy), "{line:?} used in {state:?}: {l1:?}");
        }
    }

    /// A read through a first-level cache returns the bytes of the memory behind, even across lines and
    /// before the cached region.
    // Four bytes meet up to three lines, of three bytes as of two. Kani takes two: over a division by
    // three its solver sits for a minute.
    #["L1-1", unwind 6, covers ["in the cache before", "before the region", "in the second line"]]
    fn l1_reads_are_made_of_its_lines(s) {
        const LINE: usize = if cfg!(kani) { 2 } else { self::LINE };
        let watched = watched(s);
        let base = base(s);
        let mut l1 = l1::<S, 1, 1, LINE>(s, base)?;
        let place = place(&l1, &watched);
        let there = place.is_some_and(|place| holds(&l1, place.0));
        if let Some(place) = place {
            put_right(&mut l1, place, &watched);
        }
        let back = s.value("bytes before", 0..=3, &WORDS[..4]);
        assume!(watched.addr >= back && watched.addr - back <= u32::MAX - 4);
        let start = HostAddr(watched.addr - back);
        cover!(s, "in the cache before", there && start.0 >= l1.base.0);
        cover!(s, "before the region", place.is_none());
        cover!(s, "in the second line", start.0 >= l1.base.0 && place.is_some_and(|place| place.1 < back as usize));
        let state = shown!(l1.clone());
        let mut bytes = [0xff; 4];
        l1.read(&mut Below(watched.clone()), Unit::Intersection, start, &mut bytes);
        check_eq!(bytes[back as usize], watched.byte, "byte {back} of 4 at {start:?} through {state:?}");
    }

    /// The lines of a read are exactly those of which it has a byte, up to the last byte of the address
    /// space, with lines of up to 64 KB.
    // Lines of one byte have the most numbers. Kani takes 4096 bytes beside.
    #["L1-1", unwind 5, covers ["a line of the read", "another line", "the end of the address space", "bytes below the base"]]
    fn l1_lines_of_a_read_are_those_that_it_meets(s) {
        let base = base(s);
        let (addr, len) = (draw::addr(s, &ENDS), s.value("bytes", 0..=u64::MAX, &[0, 1, 2, 5, u64::MAX]));
        let (start, end) = (u64::from(addr.0), u64::from(addr.0).saturating_add(len).min(1 << 32));
        let line = draw::line(s, &[0, 1, 2, u32::MAX / 3, u32::MAX - 1, u32::MAX]);
        let any = if cfg!(kani) { 4096 } else { s.value("bytes a line", 1..=1 << 16, &[3, 36, 0x8000, 1 << 16]) };
        s.size("least bytes a line", 1);
        for line_bytes in [1, any] {
            let l1 = FirstLevel::<1, ()>::new(base, line_bytes, 1, Policy::Lru);
            if begins_within_the_address_space(&l1, line) {
                let first = u64::from(base.0) + u64::from(line.0) * u64::from(line_bytes);
                let last = (first + u64::from(line_bytes) - 1).min(u64::from(u32::MAX));
                let meets = start < end && first < end && start <= last;
                cover!(s, "a line of the read", meets);
                cover!(s, "another line", !meets);
                cover!(s, "the end of the address space", meets && last == u64::from(u32::MAX));
                cover!(s, "bytes below the base", meets && addr.0 < base.0);
                let lines = l1.lines_of(addr, len);
                check_eq!(lines.contains(&u64::from(line.0)), meets, "{line:?} of {line_bytes} bytes from {base:?}, {len} bytes at {addr:?}: in {lines:?}");
            }
        }
    }

    /// The first-level cache of the chip in time, which keeps no bytes, does what the one with bytes
    /// does: same outcome, same lines, same counters.
    #["L1-1", unwind 6, covers ["hit", "miss", "invalidated"]]
    fn l1_without_bytes_decides_like_the_one_with_bytes(s) {
        let base = base(s);
        let mut with = l1::<S, 2, SETS, LINE>(s, base)?;
        let mut without = FirstLevel::<2, ()>::new(base, LINE as u32, SETS, with.policy);
        for index in 0..SETS {
            without.sets[index].set = with.sets[index].set;
        }
        let line = draw::line(s, &WORDS[..6]);
        let state = shown!(with.clone());
        check_eq!(without.is_resident(line), holds(&with, line), "{line:?} resident in {state:?}");
        if draw::flag(s, "access") {
            let outcome = with.access(line, || [7; LINE]);
            cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
            cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
            check_eq!(without.access(line, || ()), outcome, "{line:?} used in {state:?}");
        } else {
            let (addr, len) = (draw::addr(s, &[0, 1, 3, 5, 8]), s.value("bytes", 0..=u64::MAX, &[0, 1, 3, 4, u64::MAX]));
            with.invalidate(addr, len);
            without.invalidate(addr, len);
            cover!(s, "invalidated", with.counters.invalidated > 0);
        }
        check_eq!(without.counters, with.counters, "{line:?} in {state:?}");
        for index in 0..SETS {
            check_eq!(without.sets[index].set, with.sets[index].set, "{line:?} in {state:?}: set {index}");
        }
    }

    /// An invalidation of a range forgets exactly the lines of a first-level cache that overlap it.
    #["L1-2", unwind 5, covers ["in the range", "beside it", "before the region"]]
    fn l1_invalidation_forgets_exactly_the_range(s) {
        const LINE: usize = if cfg!(kani) { 2 } else { self::LINE };
        let base = base(s);
        let mut l1 = l1::<S, 2, SETS, LINE>(s, base)?;
        let (addr, len) = (draw::addr(s, &[0, 1, 3, 5, 8]), s.value("bytes", 0..=u64::MAX, &[0, 1, 3, 4, u64::MAX]));
        l1.counters = counters(s);
        let (state, mut counters) = (l1.clone(), l1.counters);
        l1.invalidate(addr, len);
        cover!(s, "before the region", addr.0 < l1.base.0);
        let (start, end) = (u64::from(addr.0), u64::from(addr.0).saturating_add(len));
        for set in 0..SETS {
            for way in 0..2 {
                let (was, is) = (state.sets[set].set, l1.sets[set].set);
                let first = u64::from(l1.base.0) + u64::from(was.lines[way].0) * LINE as u64;
                let meets = start < end && first < end && start < first + LINE as u64;
                assume!(!was.resident[way] || begins_within_the_address_space(&state, was.lines[way]));
                cover!(s, "in the range", was.resident[way] && meets);
                cover!(s, "beside it", was.resident[way] && !meets);
                check_eq!(is.resident[way], was.resident[way] && !meets, "{len} bytes at {addr:?} of {state:?}: set {set} way {way}");
                check_eq!((is.lines[way], is.order), (was.lines[way], was.order), "{len} bytes at {addr:?} of {state:?}: set {set}");
                counters.invalidated += u64::from(was.resident[way] && meets);
            }
        }
        check_eq!(l1.counters, counters, "{len} bytes at {addr:?} of {state:?}: lines forgotten");
    }

    /// After the host has written a byte, and the virtual memory and then the first-level cache have
    /// forgotten it, the next read through both returns the new byte.
    #["L1-2", unwind 3, covers ["in both", "in one alone"]]
    fn l1_over_virtual_memory_is_transparent(s) {
        let mut memory = virtual_memory::memory::<S, 1, 1>(s, &WORDS[..2])?;
        // Lines of two bytes, as the virtual memory has.
        let mut l1 = l1::<S, 1, 1, 2>(s, HostAddr(0))?;
        let addr = HostAddr(memory.host.addr);
        let place = (LineAddr(addr.0 / 2), addr.0 as usize % 2);
        put_right(&mut l1, place, &memory.host);
        let in_l1 = holds(&l1, place.0);
        let in_l2 = memory.directory.sets()[0].way_of(place.0).is_some();
        cover!(s, "in both", in_l1 && in_l2);
        cover!(s, "in one alone", in_l1 != in_l2);
        memory.host.byte = s.value("byte written", 0..=u8::MAX, &BYTES[2..3]);
        memory.invalidate(addr, 1);
        l1.invalidate(addr, 1);
        let state = shown!((l1.clone(), memory.clone()));
        check!(!holds(&l1, place.0), "{addr:?} written: {l1:?}");
        let bytes = l1.line(&mut memory, Unit::Shading, place.0);
        check_eq!(bytes[place.1], memory.host.byte, "{addr:?} written, through {state:?}");
    }

    /// Each type of unit reads through a first-level cache of its own: it gets the byte of the memory
    /// behind, and the other three caches stay as they are.
    #["L1-1", not_for_kani "lines of 64 bytes take it too long", covers ["shading", "traversal", "list", "intersection"]]
    fn units_read_through_caches_of_their_own(s) {
        let (mut caches, watched, unit) = caches_of_a_chip(s);
        let before = caches.clone();
        let bytes = caches.fetch::<1>(unit, HostAddr(watched.addr));
        check_eq!(bytes[0], watched.byte, "byte {} read by {unit:?}", watched.addr);
        cover!(s, "shading", unit == Unit::Shading);
        cover!(s, "traversal", unit == Unit::Traversal);
        cover!(s, "list", unit == Unit::List);
        cover!(s, "intersection", unit == Unit::Intersection);
        let accesses = [
            caches.shading.counters.accesses,
            caches.nodes.counters.accesses,
            caches.lists.counters.accesses,
            caches.triangles.counters.accesses,
        ];
        for other in 0..4 {
            check_eq!(accesses[other], u64::from(other == unit as usize), "accesses of cache {other}, {unit:?} read {}", watched.addr);
        }
        check!(unit == Unit::Shading || caches.shading == before.shading, "the shading cache, {unit:?} read {}", watched.addr);
        check!(unit == Unit::Traversal || caches.nodes == before.nodes, "the cache of kd-nodes, {unit:?} read {}", watched.addr);
        check!(unit == Unit::List || caches.lists == before.lists, "the cache of lists, {unit:?} read {}", watched.addr);
        check!(unit == Unit::Intersection || caches.triangles == before.triangles, "the cache of triangles, {unit:?} read {}", watched.addr);
    }

    /// In a first-level cache of up to 512 sets a line lies in the set that its lower bits name, and an invalidation forgets
    /// it wherever that is.
    #["L1-2", not_for_kani "hundreds of sets are too many for it; what a set does is a theorem of its own", covers ["the last of 512 sets", "one set"]]
    fn l1_forgets_in_every_set(s) {
        let sets = 1 << s.value("log2 sets", 0..=9, &WORDS[..10]);
        let mut l1 = FirstLevel::<2, ()>::new(HostAddr(0), 4, sets, Policy::Lru);
        // Lines of 4 bytes.
        let line = LineAddr(s.value("line", 0..=u32::MAX >> 2, &L1_LINES));
        l1.access(line, || ());
        let own = line.0 as usize & (sets - 1);
        cover!(s, "the last of 512 sets", own == 511);
        cover!(s, "one set", sets == 1);
        check_eq!(l1.sets[own].set.way_of(line), Some(Way(0)), "{line:?} in set {own} of {sets}");
        l1.invalidate(HostAddr(line.0 * 4 + 3), 1);
        check_eq!(l1.sets[own].set.way_of(line), None, "{line:?} forgotten in set {own} of {sets}");
        check_eq!(l1.counters.invalidated, 1, "{line:?} forgotten in set {own} of {sets}: lines forgotten");
    }

    /// The bytes of a line of a first-level cache are as many as it has, up to 64 KB, from where it begins; fewer where the
    /// address space ends within it.
    // Kani: the chip's lines whose bytes are a power of two, and 4096.
    #["L1-1", unwind 6, covers ["4 bytes", "4096 bytes", "the end of the address space"]]
    fn l1_lines_have_all_their_bytes(s) {
        let base = HostAddr(s.value("base", 0..=u32::MAX, &ENDS));
        let line = draw::line(s, &ENDS);
        let any = if cfg!(kani) { 4096 } else { s.value("bytes a line", 1..=1 << 16, &[36, 64, 96, 4096, 1 << 16]) };
        for line_bytes in [4, 8, 64, any] {
            s.size("bytes a line", line_bytes as usize);
            let l1 = FirstLevel::<1, ()>::new(base, line_bytes, 1, Policy::Lru);
            if begins_within_the_address_space(&l1, line) {
                let first = u64::from(base.0) + u64::from(line.0) * u64::from(line_bytes);
                let bytes = l1.bytes_of(line);
                cover!(s, "4 bytes", line_bytes == 4);
                cover!(s, "4096 bytes", line_bytes == 4096);
                cover!(s, "the end of the address space", bytes.end - bytes.start < u64::from(line_bytes));
                check_eq!(bytes, first..(first + u64::from(line_bytes)).min(1 << 32), "{line:?} of {line_bytes} bytes from {base:?}");
            }
        }
    }
}

/// Lines of the first set, of the last of 64, 256 and 512, and of others.
static L1_LINES: [u32; 10] = [0, 1, 63, 64, 127, 255, 256, 511, 0x2000_00ff, u32::MAX >> 2];

/// The four first-level caches of a chip, empty, in front of a host of which one byte is watched; and
/// any unit. Triangles begin at address 36.
fn caches_of_a_chip(s: &mut impl Source) -> (FirstLevelCaches<Below>, Watched, Unit) {
    let mut watched = virtual_memory::watched(s);
    watched.addr = s.value("watched address", 36..=u32::MAX, &[36, 40, 63, 64, 71, 72, 100, u32::MAX]);
    let caches = FirstLevelCaches::new([1, 2, 1, 2], Policy::Lru, HostAddr(36), Below(watched.clone()));
    (caches, watched, unit(s))
}
