//! Theorems of one set (VM-5 to VM-8), for LRU, FIFO and tree-PLRU.
//!
//! Each speaks of **one step from any legal state**: what holds before and after every step holds
//! for runs of any length. Sets of 1, 2 and 4 ways; the bodies are generic, and the tests of this
//! crate judge them with 8 and 16 ways at random too.
//!
//! A set compares lines for equality and does nothing else with them. So the exhaustive engine
//! need not try all lines, only which are alike: way `w` holds line `w`, a free way still holds
//! any of them, and one more line is in no way. That the whole of a line is compared is a theorem
//! of its own ([`hit_compares_every_bit`]).
//!
//! No loop of a step has more turns than there are ways, and the bodies draw at most 4 lines.

pub mod plru;
pub mod wide;

use crate::draw::{self, BYTES, EDGES, WORDS, any_ways};
#[cfg(not(kani))]
use crate::engines::Random;
use crate::source::{Holds, Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::vm::{LineAddr, Outcome, Policy, Set, Way};

/// Whether way `way` of the set holds `line`.
fn holds<const WAYS: usize>(set: &Set<WAYS>, way: usize, line: LineAddr) -> bool {
    set.resident[way] && set.lines[way] == line
}

/// The number of ways that hold `line`.
fn copies<const WAYS: usize>(set: &Set<WAYS>, line: LineAddr) -> usize {
    let mut copies = 0;
    for way in 0..WAYS {
        copies += usize::from(holds(set, way, line));
    }
    copies
}

/// Uses `MOST` lines after each other, or as many as the policy surely keeps: LRU as many as there are
/// ways, tree-PLRU log2(ways) + 1. All have to be resident then.
fn recent<S: Source, const WAYS: usize, const MOST: usize>(
    s: &mut S,
    before: &Set<WAYS>,
    policy: Policy,
) -> Result<[LineAddr; MOST], Stop> {
    let kept = if policy == Policy::Lru { WAYS } else { WAYS.trailing_zeros() as usize + 1 };
    let mut lines = [LineAddr(0); MOST];
    let mut set = *before;
    for k in 0..MOST {
        if k < kept {
            lines[k] = draw::line_of_set::<WAYS>(s);
            for earlier in 0..k {
                assume!(lines[earlier] != lines[k]);
            }
            set = set.access(lines[k], policy).0;
        }
    }
    for k in 0..MOST {
        let there = k >= kept || copies(&set, lines[k]) == 1;
        check!(there, "{policy:?}: {before:?}, {lines:?} used: {:?} is not in {set:?}", lines[k]);
    }
    Ok(lines)
}

/// Declares theorems whose bodies are generic over the number of ways; the theorem is that they
/// hold for 1, 2 and 4.
macro_rules! set_theorems {
    ($( $(#[doc = $says:literal])+ #[$requirement:literal, $kani:ident $how:literal, covers [$($cover:literal),+]] fn $name:ident($source:ident) $body:block )+) => {
        /// The bodies, for sets of any number of ways.
        pub mod bodies {
            use super::*;
            $(
                $(#[doc = $says])+
                ///
                /// # Errors
                /// Where it does not hold for the values drawn, or does not speak of them.
                pub fn $name<S: Source, const WAYS: usize>($source: &mut S) -> Holds {
                    $body
                    Ok(())
                }
            )+
        }

        /// The same for sets of 8 and 16 ways, for the random engine: name, covers and body.
        #[cfg(not(kani))]
        pub const WIDE: &[(&str, &[&str], fn(&mut Random) -> Holds)] = &[$((
            stringify!($name),
            &[$($cover),+],
            |source| {
                bodies::$name::<Random, 8>(source)?;
                bodies::$name::<Random, 16>(source)
            },
        )),+];

        theorems! { $(
            $(#[doc = $says])+
            #[$requirement, $kani $how, covers [$($cover),+]]
            fn $name($source) {
                any_ways!($source, bodies::$name)
            }
        )+ }
    };
}

set_theorems! {
    /// After any access to any legal set, the set is legal.
    #["VM-5", unwind 8, covers ["hit", "miss, way free", "miss, set full"]]
    fn access_keeps_invariant(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss, way free", matches!(outcome, Outcome::Miss { evicted: None, .. }));
        cover!(s, "miss, set full", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        check!(after.is_valid(policy), "{policy:?}: {before:?}, access {line:?}: illegal {after:?}");
    }

    /// After any invalidation in any legal set, the set is legal.
    #["VM-5", unwind 8, covers ["resident", "not resident"]]
    fn invalidation_keeps_invariant(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (after, way) = before.invalidate(line);
        cover!(s, "resident", way.is_some());
        cover!(s, "not resident", way.is_none());
        check!(after.is_valid(policy), "{policy:?}: {before:?}, invalidate {line:?}: illegal {after:?}");
    }

    /// No line is in two ways.
    #["VM-5", unwind 8, covers ["in one way", "in none"]]
    fn line_is_in_one_way(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let (used, line) = (draw::line_of_set::<WAYS>(s), draw::line_of_set::<WAYS>(s));
        let (after, _) = before.access(used, policy);
        let most = copies(&after, line);
        cover!(s, "in one way", most == 1);
        cover!(s, "in none", most == 0);
        check!(most <= 1, "{policy:?}: {before:?}, access {used:?}: {line:?} {most} times in {after:?}");
    }

    /// An empty set is legal and holds no line.
    #["VM-5", unwind 8, covers ["LRU", "PLRU"]]
    fn empty_set_is_legal(s) {
        let policy = draw::policy(s);
        let line = draw::line(s, &EDGES);
        cover!(s, "LRU", policy == Policy::Lru);
        cover!(s, "PLRU", policy == Policy::Plru);
        let set = Set::<WAYS>::empty(policy);
        check!(set.is_valid(policy), "{policy:?}: {set:?}");
        check_eq!(copies(&set, line), 0, "{policy:?}: {line:?} in an empty set");
    }

    /// An access hits exactly if the line is resident; a line that a free way still holds is not.
    #["VM-6", unwind 8, covers ["resident", "a free way still holds it"]]
    fn hit_iff_resident(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (_, outcome) = before.access(line, policy);
        let resident = copies(&before, line) > 0;
        cover!(s, "resident", resident);
        cover!(s, "a free way still holds it", !resident && before.lines.contains(&line));
        check_eq!(
            matches!(outcome, Outcome::Hit { .. }),
            resident,
            "{policy:?}: {before:?}, access {line:?}: a hit"
        );
    }

    /// A hit compares every bit of the line: lines that differ in one bit are never confused.
    #["VM-4", unwind 8, covers ["a bit of the upper half", "the lowest bit"]]
    fn hit_compares_every_bit(s) {
        let policy = draw::policy(s);
        let line = draw::line(s, &EDGES);
        let bit = s.value("bit", 0..=31, &WORDS[..32]);
        let other = LineAddr(line.0 ^ 1 << bit);
        cover!(s, "a bit of the upper half", bit >= 16);
        cover!(s, "the lowest bit", bit == 0);
        let (set, _) = Set::<WAYS>::empty(policy).access(line, policy);
        let (both, outcome) = set.access(other, policy);
        check!(matches!(outcome, Outcome::Miss { .. }), "{policy:?}: {set:?}, access {other:?}: {outcome:?}");
        let found = (both.way_of(line), both.way_of(other));
        let both_found = found.1.is_some() && found.0 != found.1 && (found.0.is_some() || WAYS == 1);
        check!(both_found, "{policy:?}: {line:?} and {other:?} in {both:?}: {found:?}");
    }

    /// Right after an access its line is resident, in the way that the outcome names.
    #["VM-6", unwind 8, covers ["hit", "miss"]]
    fn accessed_line_is_resident(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        let way = usize::from(outcome.way().0);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        check!(
            way < WAYS && holds(&after, way, line),
            "{policy:?}: {before:?}, access {line:?}: {outcome:?}, {after:?}"
        );
        check_eq!(
            after.way_of(line),
            Some(outcome.way()),
            "{policy:?}: {before:?}, access {line:?}, {after:?}: its way"
        );
    }

    /// A miss takes the free way of the lowest number, and evicts a line only if no way is free.
    #["VM-7", unwind 8, covers ["two ways free", "full"]]
    fn miss_evicts_only_when_full(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (_, outcome) = before.access(line, policy);
        let Outcome::Miss { way, evicted } = outcome else { return Ok(()) };
        let way = usize::from(way.0);
        // The free way of the lowest number.
        let mut free = WAYS;
        for way in (0..WAYS).rev() {
            if !before.resident[way] {
                free = way;
            }
        }
        cover!(s, "two ways free", free + 1 < WAYS && !before.resident[WAYS - 1]);
        cover!(s, "full", free == WAYS);
        let expected = if free < WAYS { None } else { Some(before.lines[way]) };
        check_eq!(evicted, expected, "{policy:?}: {before:?}, access {line:?}: evicted of way {way}");
        check!(
            free == WAYS || way == free,
            "{policy:?}: {before:?}, access {line:?}: way {way}, {free} is free"
        );
    }

    /// Every line except the evicted one stays in its way.
    #["VM-6", unwind 8, covers ["hit", "a line evicted"]]
    fn other_lines_stay(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        let used = usize::from(outcome.way().0);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "a line evicted", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        for way in 0..WAYS {
            if way != used {
                check_eq!(
                    (after.lines[way], after.resident[way]),
                    (before.lines[way], before.resident[way]),
                    "{policy:?}: {before:?}, access {line:?}: way {way}"
                );
            }
        }
    }

    /// The same line again hits and changes nothing.
    #["VM-6", unwind 8, covers ["the first a hit", "the first a miss"]]
    fn same_line_again_changes_nothing(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (once, outcome) = before.access(line, policy);
        cover!(s, "the first a hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "the first a miss", matches!(outcome, Outcome::Miss { .. }));
        let twice = once.access(line, policy);
        check_eq!(
            twice,
            (once, Outcome::Hit { way: outcome.way() }),
            "{policy:?}: {before:?}, {line:?} twice"
        );
    }

    /// With LRU the way that was used last is the first of the order.
    #["VM-6", unwind 8, covers ["hit", "miss"]]
    fn last_used_line_is_youngest(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        assume!(policy == Policy::Lru);
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        check_eq!(after.order[0], outcome.way().0, "{before:?}, access {line:?}: {after:?}");
    }

    /// LRU keeps the ways in the order of their last use, FIFO in the order of their loads: what is
    /// used (loaded) goes to the front, all others stay in their order; a hit changes no FIFO.
    #["VM-6", unwind 8, covers ["FIFO, hit", "LRU, hit", "loaded"]]
    fn order_is_that_of_last_use(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        assume!(policy != Policy::Plru);
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        let used = outcome.way().0;
        if let (Policy::Fifo, Outcome::Hit { .. }) = (policy, outcome) {
            cover!(s, "FIFO, hit", true);
            check_eq!(after, before, "FIFO: access {line:?}");
            return Ok(());
        }
        cover!(s, "LRU, hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "loaded", matches!(outcome, Outcome::Miss { .. }));
        check_eq!(after.order[0], used, "{policy:?}: {before:?}, access {line:?}, {after:?}: the youngest");
        // Places of the others: up to where `used` was they move one back, from there on they stay.
        let mut closed = false;
        for place in 0..WAYS {
            closed |= before.order[place] == used;
            if place + 1 < WAYS {
                let expected = if closed { before.order[place + 1] } else { before.order[place] };
                check_eq!(
                    after.order[place + 1],
                    expected,
                    "{policy:?}: {before:?}, access {line:?}: place {}",
                    place + 1
                );
            }
        }
    }

    /// The victim is the line least recently used (LRU), or loaded first (FIFO).
    #["VM-6", unwind 8, covers ["LRU", "FIFO"]]
    fn victim_is_the_oldest(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        assume!(policy != Policy::Plru);
        let line = draw::line_of_set::<WAYS>(s);
        let (_, outcome) = before.access(line, policy);
        let Outcome::Miss { way, evicted: Some(evicted) } = outcome else { return Ok(()) };
        cover!(s, "LRU", policy == Policy::Lru);
        cover!(s, "FIFO", policy == Policy::Fifo);
        let oldest = before.order[WAYS - 1];
        check_eq!(way.0, oldest, "{policy:?}: {before:?}, access {line:?}: way of the victim");
        check_eq!(
            evicted,
            before.lines[usize::from(oldest)],
            "{policy:?}: {before:?}, access {line:?}: victim"
        );
    }

    /// The victim is never the line that was used last (LRU, tree-PLRU; more than one way).
    #["VM-6", unwind 8, covers ["LRU", "PLRU"]]
    fn most_recent_line_is_no_victim(s) {
        if WAYS == 1 {
            return Ok(());
        }
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        assume!(policy != Policy::Fifo);
        let (first, second) = (draw::line_of_set::<WAYS>(s), draw::line_of_set::<WAYS>(s));
        let (once, _) = before.access(first, policy);
        let (_, outcome) = once.access(second, policy);
        let Outcome::Miss { evicted: Some(evicted), .. } = outcome else { return Ok(()) };
        cover!(s, "LRU", policy == Policy::Lru);
        cover!(s, "PLRU", policy == Policy::Plru);
        check!(
            evicted != first,
            "{policy:?}: {before:?}, {first:?}, then {second:?}: {evicted:?} is evicted"
        );
    }

    /// With LRU, from any state, the lines used last are resident: as many lines as there are ways (up
    /// to four are tried).
    #["VM-6", unwind 8, covers ["none of them before", "all of them before"]]
    fn lru_keeps_the_lines_used_last(s) {
        let before = draw::set_of::<S, WAYS>(s, Policy::Lru)?;
        let lines = recent::<S, WAYS, 4>(s, &before, Policy::Lru)?;
        let mut resident = 0;
        for k in 0..4 {
            resident += usize::from(k < WAYS && copies(&before, lines[k]) == 1);
        }
        cover!(s, "none of them before", WAYS >= 4 && resident == 0);
        cover!(s, "all of them before", WAYS >= 4 && resident == 4);
    }

    /// With tree-PLRU, from any state, the log2(ways) + 1 lines used last are resident (up to three are
    /// tried).
    #["VM-6", unwind 8, covers ["none of them before", "all of them before"]]
    fn plru_keeps_the_lines_used_last(s) {
        let before = draw::set_of::<S, WAYS>(s, Policy::Plru)?;
        let lines = recent::<S, WAYS, 3>(s, &before, Policy::Plru)?;
        let mut resident = 0;
        for k in 0..3 {
            resident += usize::from(copies(&before, lines[k]) == 1);
        }
        cover!(s, "none of them before", WAYS >= 4 && resident == 0);
        cover!(s, "all of them before", WAYS >= 4 && resident == 3);
    }

    /// After the invalidation of a line it is not resident; all other lines stay in their ways and in
    /// their order.
    #["VM-8", unwind 8, covers ["resident", "not resident"]]
    fn invalidation_forgets_one_line(s) {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (after, way) = before.invalidate(line);
        cover!(s, "resident", way.is_some());
        cover!(s, "not resident", way.is_none());
        check_eq!(way, before.way_of(line), "{policy:?}: {before:?}, invalidate {line:?}: its way");
        check_eq!(copies(&after, line), 0, "{policy:?}: {before:?}, invalidate {line:?}: copies left");
        check_eq!(after.order, before.order, "{policy:?}: {before:?}, invalidate {line:?}: order");
        for other in 0..WAYS {
            if way != Some(Way(other as u8)) {
                check_eq!(
                    (after.lines[other], after.resident[other]),
                    (before.lines[other], before.resident[other]),
                    "{policy:?}: {before:?}, invalidate {line:?}: way {other}"
                );
            }
        }
    }

    /// The invariant rejects a line in two ways, a way that is twice or not at all in the order, and a
    /// tree's bit that is neither 0 nor 1.
    #["VM-5", unwind 8, covers ["a line twice", "a way twice", "no such way", "no bit", "a bit above the root"]]
    fn invariant_rejects_illegal_sets(s) {
        let (policy, mut set) = draw::set::<S, WAYS>(s)?;
        let fault = s.value("fault", 0..=3, &BYTES[..4]);
        let a = s.value("way", 0..=(WAYS - 1) as u8, &BYTES[..WAYS]);
        let b = s.value("other way", 0..=(WAYS - 1) as u8, &BYTES[..WAYS]);
        assume!(a != b);
        let (a, b) = (usize::from(a), usize::from(b));
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
                set.order[a] = s.value("entry", WAYS as u8..=u8::MAX, &BYTES[WAYS..WAYS + 2]);
                cover!(s, "no such way", policy == Policy::Lru);
                cover!(s, "no bit", policy == Policy::Plru);
            }
            _ => {
                assume!(policy == Policy::Plru);
                set.order[0] = 1;
                cover!(s, "a bit above the root", true);
            }
        }
        check!(!set.is_valid(policy), "{policy:?}: taken for legal: {set:?}");
    }
}
