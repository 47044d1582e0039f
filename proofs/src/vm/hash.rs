//! Theorems of the index hash (VM-3).

use crate::draw::{self, EDGES, ENDS, WORDS};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::vm::{Hash, LineAddr, SetIndex};

theorems! {
    /// The hash gives a set that exists, for every line and every number of sets up to 2^32.
    // Each turn of `add-upper-all` drops at least one of the 32 bits of a line.
    #["VM-3", unwind 34, covers ["one set", "last set", "upper bits"]]
    fn hash_names_a_set(s) {
        let hash = draw::hash(s);
        let set_bits = s.value("log2 sets", 0..=32, &WORDS[..33]);
        let line = draw::line(s, &EDGES);
        let set = u64::from(hash.set_of(line, set_bits).0);
        cover!(s, "one set", set_bits == 0);
        cover!(s, "last set", set_bits > 0 && set == (1 << set_bits) - 1);
        cover!(s, "upper bits", u64::from(line.0) >> set_bits != 0);
        check!(set < 1 << set_bits, "{hash:?} of {line:?} among 2^{set_bits} sets: {set}");
    }

    /// Without upper bits, the set of a line is the line's own number.
    #["VM-3", unwind 34, covers ["low bits alone"]]
    fn lines_without_upper_bits_keep_their_number(s) {
        let hash = draw::hash(s);
        let set_bits = s.value("log2 sets", 0..=32, &WORDS[..33]);
        let line = draw::line(s, &EDGES);
        assume!(u64::from(line.0) >> set_bits == 0);
        cover!(s, "low bits alone", line.0 > 0);
        check_eq!(hash.set_of(line, set_bits), SetIndex(line.0), "{hash:?} of {line:?} among 2^{set_bits} sets");
    }

    /// The set of a line is its lower bits plus its upper bits, modulo the number of sets:
    /// `low` leaves the upper bits out, `add-upper` adds them once.
    #["VM-3", unwind 34, covers ["a carry dropped", "no carry"]]
    fn add_upper_adds_the_upper_bits_once(s) {
        let set_bits = s.value("log2 sets", 0..=31, &WORDS[..32]);
        let line = draw::line(s, &EDGES);
        let mask = (1_u32 << set_bits) - 1;
        let (low, up) = (line.0 & mask, line.0 >> set_bits);
        cover!(s, "a carry dropped", (low + (up & mask)) >> set_bits != 0);
        cover!(s, "no carry", up != 0 && (low + (up & mask)) >> set_bits == 0);
        check_eq!(Hash::Low.set_of(line, set_bits).0, low, "low bits of {line:?} among 2^{set_bits} sets");
        check_eq!(Hash::AddUpper.set_of(line, set_bits).0, low.wrapping_add(up) & mask, "{line:?} among 2^{set_bits} sets");
    }

    /// The set of a line by `add-upper-all` is the sum of all its groups of log2(sets) bits, modulo the
    /// number of sets.
    #["VM-3", unwind 34, covers ["two groups", "five groups or more", "a carry dropped"]]
    fn add_upper_all_adds_every_group(s) {
        let set_bits = s.value("log2 sets", 1..=31, &WORDS[1..32]);
        let line = draw::line(s, &EDGES);
        let mask = (1_u32 << set_bits) - 1;
        // There are 32 groups at most: of one bit each.
        let (mut rest, mut sum) = (line.0, 0_u32);
        let mut groups = 0;
        for _ in 0..32 {
            groups += u32::from(rest != 0);
            sum = sum.wrapping_add(rest & mask) & mask;
            rest >>= set_bits;
        }
        cover!(s, "two groups", groups == 2);
        cover!(s, "five groups or more", groups >= 5);
        cover!(s, "a carry dropped", (line.0 & mask) > sum);
        check_eq!(Hash::AddUpperAll.set_of(line, set_bits).0, sum, "{line:?} among 2^{set_bits} sets");
    }

    /// Any aligned block of as many lines as there are sets fills every set once: two lines of one
    /// block never share a set.
    // In a finite set no two alike is a bijection.
    #["VM-3", unwind 34, covers ["two lines of a block", "a block above the first"]]
    fn aligned_blocks_fill_every_set_once(s) {
        let hash = draw::hash(s);
        let set_bits = s.value("log2 sets", 0..=31, &WORDS[..32]);
        let (a, b) = (draw::line(s, &EDGES), draw::line(s, &EDGES));
        assume!(a.0 >> set_bits == b.0 >> set_bits && a != b);
        cover!(s, "two lines of a block", true);
        cover!(s, "a block above the first", a.0 >> set_bits > 0);
        let sets = (hash.set_of(a, set_bits), hash.set_of(b, set_bits));
        check!(sets.0 != sets.1, "{hash:?} of {a:?} and {b:?} among 2^{set_bits} sets: both {:?}", sets.0);
    }

    /// Lines that are a multiple of the number of sets apart all collide without the hash; with it the
    /// first `sets` of them go to different sets.
    #["VM-3", unwind 34, covers ["multiples of the number of sets"]]
    fn hash_spreads_strides_of_the_set_count(s) {
        let all_folds = draw::flag(s, "every fold");
        let set_bits = s.value("log2 sets", 1..=16, &WORDS[1..17]);
        let lower = s.value("lower bits", 0..=u32::MAX, &ENDS) & ((1 << set_bits) - 1);
        let multiples = [(); 2].map(|()| s.value("multiple", 0..=u32::MAX, &ENDS) & ((1 << set_bits) - 1));
        assume!(multiples[0] != multiples[1]);
        cover!(s, "multiples of the number of sets", true);
        let hash = if all_folds { Hash::AddUpperAll } else { Hash::AddUpper };
        let lines = multiples.map(|multiple| LineAddr(multiple << set_bits | lower));
        let set = |hash: Hash| lines.map(|line| hash.set_of(line, set_bits));
        let [a, b] = set(Hash::Low);
        check_eq!(a, b, "low bits of {lines:?} among 2^{set_bits} sets");
        let [a, b] = set(hash);
        check!(a != b, "{hash:?} of {lines:?} among 2^{set_bits} sets: both {a:?}");
    }

    /// The hash moves the collisions, it does not remove them: with `add-upper` lines that are one
    /// less than the number of sets apart collide, as long as no carry falls between them.
    #["VM-3", unwind 8, covers ["neighbours on the colliding stride"]]
    fn hash_collides_at_one_less_than_the_set_count(s) {
        let set_bits = s.value("log2 sets", 1..=31, &WORDS[1..32]);
        let line = draw::line(s, &EDGES);
        let sets = 1_u32 << set_bits;
        // One upper more and one lower less: the sum stays, unless there is no lower to take.
        assume!(line.0 & (sets - 1) != 0 && line.0 <= u32::MAX - sets);
        let other = LineAddr(line.0 + sets - 1);
        cover!(s, "neighbours on the colliding stride", true);
        let set = |line| Hash::AddUpper.set_of(line, set_bits);
        check_eq!(set(other), set(line), "{line:?} and {other:?} among 2^{set_bits} sets");
    }
}
