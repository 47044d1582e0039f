//! Theorems of addresses, geometry and the metadata law (VM-1, VM-2, VM-10, VM-11).
//!
//! Sizes are powers of two, and so the theorems draw their binary logarithms; the first theorem
//! says that nothing else is a geometry. No loop, no bound.

use crate::draw::{self, EDGES, ENDS, WORDS};
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, MAX_WAYS, Policy, SetIndex, Way};

/// Sizes of memories and lines: around powers of two, around the limits, and none.
static SIZES: [u64; 17] = [
    0,
    1,
    2,
    3,
    4,
    5,
    64,
    96,
    128,
    129,
    1 << 16,
    (1 << 32) - 1,
    1 << 32,
    (1 << 32) + 1,
    1 << 33,
    1 << 63,
    u64::MAX,
];

/// Any set and way of a geometry, and where its line begins on the card.
fn place(s: &mut impl Source, geometry: Geometry) -> (u32, u8, u64) {
    // The lower bits of any number are any set, and any way.
    let set = s.value("set", 0..=u32::MAX, &ENDS) & (geometry.sets() - 1) as u32;
    let way = s.value("way", 0..=15, &[0, 1, 3, 7, 15_u8]) & (geometry.ways() - 1) as u8;
    (set, way, u64::from(geometry.card_addr(SetIndex(set), Way(way)).0))
}

theorems! {
    /// Sizes make a cache exactly if memory, line and ways are powers of two, the memory has at
    /// most 4 GiB, there are at most 16 ways, and the memory holds at least one set.
    #["VM-1", unwind 8, covers ["legal", "memory no power of two", "line too long", "too many ways"]]
    fn geometry_is_exactly_the_legal_sizes(s) {
        let memory = s.value("memory", 0..=u64::MAX, &SIZES);
        let line = s.value("line", 0..=u64::MAX, &SIZES);
        let ways = s.value("ways", 0..=u32::MAX, &[0, 1, 2, 3, 4, 8, 16, 17, 32, u32::MAX]);
        let powers = memory.is_power_of_two() && line.is_power_of_two() && ways.is_power_of_two();
        let fits = line.trailing_zeros() + ways.trailing_zeros() <= memory.trailing_zeros();
        let legal = powers && fits && memory <= 1 << 32 && ways <= MAX_WAYS;
        cover!(s, "legal", legal);
        cover!(s, "memory no power of two", !memory.is_power_of_two());
        cover!(s, "line too long", powers && !fits);
        cover!(s, "too many ways", ways > MAX_WAYS);
        let geometry = Geometry::new(Bytes(memory), Bytes(line), ways);
        check_eq!(geometry.is_ok(), legal, "{memory} bytes in lines of {line}, {ways} ways");
    }

    /// A cache has the size, the line and the ways asked for, and as many lines and sets as these make.
    #["VM-1", unwind 8, covers ["many sets", "one set", "4 GiB"]]
    fn geometry_has_the_sizes_asked_for(s) {
        let (ways, line, sets) = draw::logarithms(s)?;
        let geometry = draw::of_logarithms(ways, line, sets)?;
        cover!(s, "many sets", sets > 0);
        cover!(s, "one set", sets == 0);
        cover!(s, "4 GiB", ways + line + sets == 32);
        check_eq!(geometry.memory(), Bytes(1 << (ways + line + sets)), "memory of {geometry:?}");
        check_eq!((geometry.line(), geometry.ways()), (Bytes(1 << line), 1 << ways), "line and ways of {geometry:?}");
        check_eq!((geometry.lines(), geometry.sets()), (1 << (ways + sets), 1 << sets), "lines and sets of {geometry:?}");
        check_eq!(geometry.set_bits(), sets, "logarithm of the sets of {geometry:?}");
    }

    /// The line and the offset of an address together give the address back.
    #["VM-1", unwind 8, covers ["inside a line", "first byte of a line"]]
    fn split_and_join_are_inverse(s) {
        let (geometry, addr) = (draw::geometry(s)?, draw::addr(s, &EDGES));
        let (line, offset) = (geometry.line_of(addr), geometry.offset_of(addr));
        cover!(s, "inside a line", offset > 0);
        cover!(s, "first byte of a line", offset == 0);
        check_eq!(geometry.first_byte(line).0.checked_add(offset), Some(addr.0), "{geometry:?}, {line:?}, offset {offset}");
    }

    /// The offset of an address is less than the line's size, and the first byte of a line has
    /// offset 0 and belongs to it.
    #["VM-1", unwind 8, covers ["last byte of a line", "line of 4 GiB"]]
    fn offset_stays_in_the_line(s) {
        let (geometry, addr) = (draw::geometry(s)?, draw::addr(s, &EDGES));
        let (line, offset) = (geometry.line_of(addr), geometry.offset_of(addr));
        let first = geometry.first_byte(line);
        cover!(s, "last byte of a line", u64::from(offset) == geometry.line().0 - 1);
        cover!(s, "line of 4 GiB", geometry.line().0 == 1 << 32);
        check!(u64::from(offset) < geometry.line().0, "{geometry:?}: offset {offset} of {addr:?}");
        check_eq!((geometry.line_of(first), geometry.offset_of(first)), (line, 0), "{geometry:?}: first byte of {line:?}");
    }

    /// Two addresses belong to one line exactly if no multiple of the line size lies between them.
    #["VM-1", unwind 8, covers ["one line", "neighbours in two lines"]]
    fn lines_are_aligned_runs_of_bytes(s) {
        let (geometry, a, b) = (draw::geometry(s)?, draw::addr(s, &EDGES), draw::addr(s, &ENDS));
        // The highest bit in which they differ decides; a line of 2^32 bytes has all of them.
        let one_line = u64::from(a.0 ^ b.0) < geometry.line().0;
        cover!(s, "one line", one_line && a != b);
        cover!(s, "neighbours in two lines", !one_line && a.0.abs_diff(b.0) == 1);
        check_eq!(geometry.line_of(a) == geometry.line_of(b), one_line, "{geometry:?}: {a:?} and {b:?}");
    }

    /// Lines in two different places (set and way) do not overlap on the card.
    #["VM-11", unwind 8, covers ["two ways of a set", "two sets", "4 GiB"]]
    fn card_addresses_do_not_overlap(s) {
        let geometry = draw::geometry(s)?;
        let (set_a, way_a, a) = place(s, geometry);
        let (set_b, way_b, b) = place(s, geometry);
        assume!((set_a, way_a) != (set_b, way_b));
        cover!(s, "two ways of a set", set_a == set_b);
        cover!(s, "two sets", set_a != set_b);
        cover!(s, "4 GiB", geometry.memory().0 == 1 << 32);
        check!(
            a.abs_diff(b) >= geometry.line().0,
            "{geometry:?}: set {set_a} way {way_a} at {a}, set {set_b} way {way_b} at {b}"
        );
    }

    /// Every line on the card lies inside the on-board memory, at a multiple of its size.
    #["VM-11", unwind 8, covers ["last line", "first line"]]
    fn card_addresses_stay_in_the_memory(s) {
        let geometry = draw::geometry(s)?;
        let (set, way, at) = place(s, geometry);
        let end = at + geometry.line().0;
        cover!(s, "last line", end == geometry.memory().0);
        cover!(s, "first line", at == 0);
        check!(end <= geometry.memory().0, "{geometry:?}: set {set} way {way} ends at {end}");
        check!(at & (geometry.line().0 - 1) == 0, "{geometry:?}: set {set} way {way} at {at}");
    }

    /// A byte of a line lies on the card at (set · ways + way) · line + offset, in a card of any size up to 4 GiB.
    #["VM-11", unwind 8, covers ["not the first way", "not the first set", "beyond 2 GiB"]]
    fn card_address_is_that_of_its_set_and_way(s) {
        let geometry = draw::geometry(s)?;
        let (set, way, at) = place(s, geometry);
        cover!(s, "not the first way", way > 0);
        cover!(s, "not the first set", set > 0);
        cover!(s, "beyond 2 GiB", at > 1 << 31);
        // By shifts: ways and lines are powers of two.
        let slot = (u64::from(set) << geometry.ways().trailing_zeros()) + u64::from(way);
        check_eq!(at, slot << geometry.line().0.trailing_zeros(), "{geometry:?}: set {set} way {way}");
    }

    /// Whoever goes through all sets meets each number of a set once, up to the last of 2^32.
    #["VM-8", unwind 8, covers ["one set", "2^32 sets", "the last set"]]
    fn every_set_has_a_number(s) {
        let (ways, line, sets) = draw::logarithms(s)?;
        let geometry = draw::of_logarithms(ways, line, sets)?;
        let set = u64::from(s.value("set", 0..=u32::MAX, &ENDS));
        cover!(s, "one set", sets == 0);
        cover!(s, "2^32 sets", sets == 32);
        cover!(s, "the last set", sets > 0 && set == (1 << sets) - 1);
        let numbers = geometry.set_numbers();
        check_eq!(numbers.contains(&set), set < 1 << sets, "{geometry:?}: set {set} among {numbers:?}");
        check_eq!(numbers.end - numbers.start, 1 << sets, "{geometry:?}: how many there are of {numbers:?}");
    }

    /// A read is cut at the ends of lines: what is read at once lies in one line, and what is left begins where the next
    /// line does, with lines of any size.
    #["VM-10", unwind 8, covers ["all in one line", "more lines", "the end of the address space", "a line of 1 MiB"]]
    fn reads_are_cut_at_the_ends_of_lines(s) {
        let (geometry, addr) = (draw::geometry(s)?, draw::addr(s, &EDGES));
        let len = s.value("bytes", 1..=u64::MAX, &[1, 2, 127, 128, 1 << 16, (1 << 16) + 1, 1 << 32, u64::MAX]);
        let (here, next) = geometry.split_at_line_end(addr, len);
        cover!(s, "all in one line", here == len);
        cover!(s, "more lines", here < len && next.is_some());
        cover!(s, "the end of the address space", next.is_none());
        cover!(s, "a line of 1 MiB", geometry.line().0 == 1 << 20 && here > 1 << 16);
        let end = u64::from(addr.0) + here;
        check!(here > 0 && here <= len && end <= 1 << 32, "{geometry:?}: {here} of {len} bytes at {addr:?}");
        let last = HostAddr((end - 1) as u32);
        check_eq!(geometry.line_of(last), geometry.line_of(addr), "{geometry:?}: {here} of {len} bytes at {addr:?}: line of the last");
        if here < len {
            let expected = if end < 1 << 32 { Some(HostAddr(end as u32)) } else { None };
            check_eq!(next, expected, "{geometry:?}: behind {here} of {len} bytes at {addr:?}");
        }
        if let Some(next) = next {
            check_eq!(geometry.offset_of(next), 0, "{geometry:?}: {next:?} behind {len} bytes at {addr:?}");
        }
    }

    /// The lines of a range of bytes are exactly those that share a byte with it, up to the end of
    /// the address space.
    #["VM-10", unwind 8, covers ["a line of the range", "a line beside it", "an empty range", "beyond the end"]]
    fn lines_of_a_range_are_those_it_meets(s) {
        let (geometry, addr) = (draw::geometry(s)?, draw::addr(s, &ENDS));
        let len = s.value("bytes", 0..=u64::MAX, &[0, 1, 2, 127, 128, 129, 1 << 20, 1 << 32, u64::MAX]);
        let line = s.value("a line", 0..=u32::MAX, &ENDS);
        let first = u64::from(line) << geometry.line().0.trailing_zeros();
        assume!(first < 1 << 32);
        let (start, end) = (u64::from(addr.0), u64::from(addr.0).saturating_add(len).min(1 << 32));
        let meets = start < end && first < end && start < first + geometry.line().0;
        let config = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        cover!(s, "a line of the range", meets);
        cover!(s, "a line beside it", !meets && len > 0);
        cover!(s, "an empty range", len == 0);
        cover!(s, "beyond the end", u64::from(addr.0).saturating_add(len) > 1 << 32);
        let lines = config.lines_of(addr, len);
        check_eq!(lines.contains(&u64::from(line)), meets, "{geometry:?}: {lines:?} of {len} bytes at {addr:?}, line {line}");
    }

    /// The metadata takes 5 bytes for each line that the memory holds.
    #["VM-2", unwind 8, covers ["one line", "4 GiB"]]
    fn metadata_is_five_bytes_a_line(s) {
        let (ways, line, sets) = draw::logarithms(s)?;
        let geometry = draw::of_logarithms(ways, line, sets)?;
        cover!(s, "one line", ways + sets == 0);
        cover!(s, "4 GiB", ways + line + sets == 32);
        // 5 · memory / line, by shifts.
        check_eq!(geometry.metadata().0, (5 << (ways + line + sets)) >> line, "metadata of {geometry:?}");
    }

    /// 16 MB of memory have 640 KB of metadata in lines of 128 bytes, and 80 KB in lines of 1024.
    #["VM-2", unwind 8, covers ["128 bytes", "1024 bytes"]]
    fn metadata_of_the_papers_examples(s) {
        let example = s.value("example", 0..=1, &draw::BYTES[..2]);
        let way_bits = s.value("log2 ways", 0..=4, &WORDS[..5]);
        let (line_bits, metadata) = if example == 0 { (7, 640 << 10) } else { (10, 80 << 10) };
        let geometry = draw::of_logarithms(way_bits, line_bits, 24 - line_bits - way_bits)?;
        cover!(s, "128 bytes", example == 0);
        cover!(s, "1024 bytes", example == 1);
        check_eq!(geometry.metadata(), Bytes(metadata), "metadata of {geometry:?}");
    }

    /// More memory has more metadata at the same line size; longer lines have less at the same
    /// memory.
    #["VM-2", unwind 8, covers ["twice the memory", "twice the line"]]
    fn metadata_grows_with_memory_and_shrinks_with_lines(s) {
        let (ways, line, sets) = draw::logarithms(s)?;
        let metadata = draw::of_logarithms(ways, line, sets)?.metadata();
        if ways + line + sets < 32 {
            cover!(s, "twice the memory", true);
            check!(draw::of_logarithms(ways, line, sets + 1)?.metadata() > metadata, "twice the memory of 2^({ways} + {line} + {sets})");
        }
        if sets > 0 {
            cover!(s, "twice the line", true);
            check!(draw::of_logarithms(ways, line + 1, sets - 1)?.metadata() < metadata, "twice the line of 2^{line}");
        }
    }
}
