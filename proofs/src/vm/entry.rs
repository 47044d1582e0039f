//! Theorems of the metadata entry (VM-4, VM-12).
//!
//! Loops run over the 3 check bits, the 5 bytes, or the ways.

use crate::draw::{self, BYTES, EDGES, ENDS, WORDS};
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::vm::{ENTRY_BYTES, Entry, LineAddr, Policy, Set};

/// Any entry.
fn entry(s: &mut impl Source, small: &'static [u32]) -> Entry {
    let line = draw::line(s, small);
    let resident = draw::flag(s, "resident");
    Entry { line, resident, order: s.value("order", 0..=15, &BYTES[..16]) }
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
        let (first, shape) = (s.value("bit", 0..=39, &WORDS), s.value("shape", 0..=3, &BYTES[..4]));
        // Bits 1, 11, 101, 111: those of up to three neighbours, from the first on.
        let error = (2 * u64::from(shape) + 1) << first;
        assume!(error < 1 << 40);
        cover!(s, "one bit", shape == 0);
        cover!(s, "three bits", shape == 3);
        cover!(s, "a check bit", first >= 37);
        let bits = flipped(entry.encode(), error);
        check!(Entry::decode(bits).is_err(), "{entry:?} with the bits {error:#x} flipped is {:?}", Entry::decode(bits));
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
}
