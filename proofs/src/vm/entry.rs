//! Theorems of the metadata entry (VM-4, VM-12).
//!
//! Loops run over the 3 check bits, the 5 bytes, or the ways.

use crate::draw::{self, BYTES, EDGES, ENDS, WORDS};
use crate::source::{Holds, Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::vm::{Corrupt, ENTRY_BYTES, Entry, LineAddr, Policy, Set};

/// Any entry.
fn entry(s: &mut impl Source, small: &'static [u32]) -> Entry {
    let line = draw::line(s, small);
    let resident = draw::flag(s, "resident");
    Entry { line, resident, order: s.value("order", 0..=15, &BYTES[..16]) }
}

/// An error of one bit, or of two or three neighbouring ones, among the 40: it flips the bits that are 1. `firsts` and `shapes`
/// are the small scope.
pub fn short_error(s: &mut impl Source, firsts: &'static [u8], shapes: &'static [u8]) -> Result<u64, Stop> {
    let (first, shape) = (s.value("bit", 0..=39, firsts), s.value("shape", 0..=3, shapes));
    // Bits 1, 11, 101, 111, from the first on.
    let error = (2 * u64::from(shape) + 1) << first;
    assume!(error < 1 << 40);
    Ok(error)
}

/// The 40 bits with those of `error` flipped.
fn flipped(bits: [u8; ENTRY_BYTES], error: u64) -> [u8; ENTRY_BYTES] {
    let mut flipped = bits;
    for (i, byte) in flipped.iter_mut().enumerate() {
        *byte ^= (error >> (8 * i)) as u8;
    }
    flipped
}

theorems! {
    /// The 40 bits of an entry hold any line address of the 32-bit host space, whether it is
    /// resident, and 4 management bits: decoding gives back what was encoded.
    #["VM-12", unwind 8, covers ["resident", "all 32 bits of the line", "way 15"]]
    fn entry_decodes_to_itself(s) {
        let entry = entry(s, &EDGES);
        cover!(s, "resident", entry.resident);
        cover!(s, "all 32 bits of the line", entry.line == LineAddr(u32::MAX));
        cover!(s, "way 15", entry.order == 15);
        check_eq!(Entry::decode(entry.encode()), Ok(entry), "{:02x?}", entry.encode());
    }

    /// No entry has two encodings: 40 bits that decode to an entry are the 40 bits to which it encodes.
    #["VM-12", unwind 8, covers ["legal", "corrupt"]]
    fn encoding_is_unique(s) {
        let mut bits = [0; ENTRY_BYTES];
        for byte in &mut bits {
            *byte = s.value("byte", 0..=u8::MAX, &[0, 1, 2, 4, 0x12, 0x24, 0x49, 0x80, 0xe0, 0xff]);
        }
        let entry = Entry::decode(bits);
        cover!(s, "legal", entry.is_ok());
        cover!(s, "corrupt", entry.is_err());
        if let Ok(entry) = entry {
            check_eq!(entry.encode(), bits, "{entry:?}");
        }
    }

    /// The check bits detect every error of one bit and of two or three neighbouring bits (two wrong
    /// bits a multiple of 3 apart they do not).
    #["VM-12", unwind 8, covers ["one bit", "three bits", "a check bit"]]
    fn short_errors_are_detected(s) {
        let entry = entry(s, &ENDS);
        let error = short_error(s, &BYTES, &BYTES[..4])?;
        cover!(s, "one bit", error.count_ones() == 1);
        cover!(s, "three bits", error.count_ones() == 3);
        cover!(s, "a check bit", error.trailing_zeros() >= 37);
        let bits = flipped(entry.encode(), error);
        check!(Entry::decode(bits).is_err(), "{entry:?} with the bits {error:#x} flipped is {:?}", Entry::decode(bits));
    }

    /// An error that the check bits of one entry detect is detected among the entries of a set, in whichever way it lies, also
    /// where the way is free: the entries are refused.
    #["VM-14", unwind 8, covers ["of a resident line", "of a free way", "in the last way"]]
    fn errors_are_detected_in_every_way(s) {
        let (policy, set) = draw::set::<S, 4>(s)?;
        let way = s.value("way of the error", 0..=3, draw::words(0, 4)) as usize;
        let error = short_error(s, &[0, 32, 37], &BYTES[2..4])?;
        cover!(s, "of a resident line", set.resident[way]);
        cover!(s, "of a free way", !set.resident[way]);
        cover!(s, "in the last way", way == 3);
        let mut entries = set.to_entries();
        entries[way] = flipped(entries[way], error);
        check_eq!(Set::from_entries(entries, policy), Err(Corrupt), "{policy:?}: {set:?} with the bits {error:#x} of way {way} flipped");
    }

    /// Decoding the entries of a set gives the set back, for every policy and whatever its free ways
    /// still hold.
    #["VM-12", unwind 8, covers ["PLRU", "a free way"]]
    fn set_decodes_to_itself(s) {
        let (policy, set) = draw::set::<S, 4>(s)?;
        cover!(s, "PLRU", policy == Policy::Plru);
        cover!(s, "a free way", !set.resident[3]);
        check_eq!(Set::from_entries(set.to_entries(), policy), Ok(set), "{policy:?}");
    }

    /// Decoding rejects entries that are each legal but together make no legal set: a line in two ways,
    /// or management bits that the policy does not have.
    #["VM-5", unwind 8, covers ["legal", "a line twice", "illegal order"]]
    fn illegal_sets_are_detected(s) {
        let policy = draw::policy(s);
        let entries = [(); 2].map(|()| {
            let line = draw::line(s, &WORDS[..3]);
            let resident = draw::flag(s, "resident");
            Entry { line, resident, order: s.value("order", 0..=15, &BYTES[..4]) }
        });
        let [a, b] = entries;
        let set = Set {
            lines: [a.line, b.line],
            resident: [a.resident, b.resident],
            order: [a.order, b.order],
        };
        let legal = set.is_valid(policy);
        cover!(s, "legal", legal);
        cover!(s, "a line twice", a.resident && b.resident && a.line == b.line);
        cover!(s, "illegal order", a.order == 3);
        let decoded = Set::from_entries(entries.map(Entry::encode), policy);
        check_eq!(decoded.ok(), legal.then_some(set), "{policy:?}: {entries:?}");
    }

    /// Decoding refuses the entries of 4, 8 and 16 ways that make no legal set, each of them legal: a resident line in two
    /// ways, a way twice in the order or not at all, a tree's bit that is none, and a bit above the root.
    // Kani: 8 ways.
    #["VM-5", unwind 10, covers ["a line twice", "a way twice", "no bit", "a bit above the root", "8 ways or more"]]
    fn illegal_wide_sets_are_refused(s) {
        match if cfg!(kani) { 1 } else { s.value("log2 ways, less 2", 0..=2, &WORDS[..3]) } {
            #[cfg(not(kani))]
            0 => refuses::<S, 4>(s)?,
            1 => refuses::<S, 8>(s)?,
            _ => refuses::<S, 16>(s)?,
        }
    }

    /// Decoding the entries of a set of 16 ways gives the set back.
    #["VM-12", not_for_kani "the entries of 16 ways take it more than 120 seconds; those of 4 are `set_decodes_to_itself`", covers ["LRU", "PLRU", "the last way is free"]]
    fn wide_set_decodes_to_itself(s) {
        let (policy, set) = draw::wide_set::<S, 16>(s)?;
        cover!(s, "LRU", policy == Policy::Lru);
        cover!(s, "PLRU", policy == Policy::Plru);
        cover!(s, "the last way is free", !set.resident[15]);
        check_eq!(Set::from_entries(set.to_entries(), policy), Ok(set), "{policy:?}");
    }
}

/// Makes a legal set illegal, and decodes its entries.
fn refuses<S: Source, const WAYS: usize>(s: &mut S) -> Holds {
    let (policy, mut set) = draw::wide_set::<S, WAYS>(s)?;
    let fault = s.value("fault", 0..=3, &BYTES[..4]);
    let [a, b] = [(); 2].map(|()| usize::from(s.value("way", 0..=WAYS as u8 - 1, &BYTES[..WAYS])));
    assume!(a != b);
    match fault {
        0 => {
            (set.resident[a], set.resident[b], set.lines[a]) = (true, true, set.lines[b]);
            cover!(s, "a line twice", true);
        }
        1 => {
            assume!(policy != Policy::Plru);
            set.order[a] = set.order[b];
            cover!(s, "a way twice", true);
        }
        2 => {
            assume!(policy == Policy::Plru);
            set.order[a] = s.value("entry", 2..=15, &BYTES[2..4]);
            cover!(s, "no bit", true);
        }
        _ => {
            assume!(policy == Policy::Plru);
            set.order[0] = 1;
            cover!(s, "a bit above the root", true);
        }
    }
    cover!(s, "8 ways or more", WAYS >= 8);
    let decoded = Set::from_entries(set.to_entries(), policy);
    check_eq!(decoded, Err(Corrupt), "{policy:?}: {set:?}");
    Ok(())
}
