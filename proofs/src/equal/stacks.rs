//! The twin of LRU directories of all numbers of ways: `saarcor_fast::stacks`.
//!
//! A set of `WAYS` ways corresponds to a stack if its resident lines, the one used last first, are the topmost lines of the
//! stack, `WAYS` of them or as many as there are. The stack goes on below: with what it holds there it corresponds to sets of
//! more ways at the same time.

use crate::draw::{self, WORDS, words};
use crate::source::{Holds, Source};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_fast::stacks::Stacks;
use saarcor_model::vm::{Hash, LineAddr, Outcome, Policy, Set, SetIndex};

/// Most lines of a stack here.
const DEPTH: usize = 4;

/// The resident lines of an LRU set, the one used last first.
fn in_order<const WAYS: usize>(set: &Set<WAYS>) -> ([LineAddr; WAYS], usize) {
    let (mut lines, mut count) = ([LineAddr(0); WAYS], 0);
    for way in set.order.map(usize::from) {
        if set.resident[way] {
            lines[count] = set.lines[way];
            count += 1;
        }
    }
    (lines, count)
}

/// Whether a set corresponds to a stack.
fn correspond<const WAYS: usize>(set: &Set<WAYS>, stack: &[LineAddr]) -> bool {
    let (lines, count) = in_order(set);
    count == stack.len().min(WAYS) && lines[..count] == stack[..count]
}

/// From any set of `WAYS` ways and any stack that corresponds to it.
fn steps_alike<S: Source, const WAYS: usize>(s: &mut S) -> Holds {
    let set = draw::set_of::<S, WAYS>(s, Policy::Lru)?;
    let (top, count) = in_order(&set);
    let mut before = Stacks::new(Hash::Low, 0, DEPTH as u8);
    before.lines[..count].copy_from_slice(&top[..count]);
    let mut held = count;
    for place in WAYS..DEPTH {
        // Below what the set holds, if it is full.
        if held == place && draw::flag(s, "line below") {
            before.lines[place] = LineAddr(s.value("line of the stack", 0..=u32::MAX, words(place, 1)));
            assume!(!before.lines[..place].contains(&before.lines[place]));
            held += 1;
        }
    }
    before.held[0] = held as u8;

    let line = draw::line_of_set::<DEPTH>(s);
    let (after, outcome) = set.access(line, Policy::Lru);
    let mut twin = before.clone();
    let above = twin.access(line);
    let hits = matches!(outcome, Outcome::Hit { .. });
    cover!(s, "hit", hits);
    cover!(s, "miss, way free", matches!(outcome, Outcome::Miss { evicted: None, .. }));
    cover!(s, "eviction", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
    check_eq!(above.is_some_and(|above| above < WAYS), hits, "{set:?}, {before:?}: access {line:?}");
    check!(correspond(&after, twin.stack(SetIndex(0))), "{after:?}, {twin:?}: after {line:?}");
    check_eq!(before.is_on_top(line), above == Some(0), "{before:?}: {line:?} on top");
    check!(above != Some(0) || twin == before, "{before:?}: {line:?} on top changes nothing");
    Ok(())
}

theorems! {
    /// From any stack, and any LRU set of 1, 2 or 4 ways that corresponds to it, the set hits if and only if fewer lines than it
    /// has ways lie above the line, and both correspond after the access. The line on top changes nothing.
    #["VM-6", unwind 6, covers ["hit", "miss, way free", "eviction"]]
    fn stack_is_the_lru_set_of_any_ways(s) {
        match draw::log2_ways(s) {
            #[cfg(not(kani))]
            0 => steps_alike::<S, 1>(s)?,
            #[cfg(not(kani))]
            2 => steps_alike::<S, 4>(s)?,
            _ => steps_alike::<S, 2>(s)?,
        }
    }

    /// An access changes the stack of the set that the hash names and no other, whatever the numbers of sets and of ways;
    /// a flush empties all.
    #["VM-3", not_for_kani "its solver has no end of stacks of sizes that are drawn; of one set it proves the step", covers ["another set", "512 sets of 16 ways"]]
    fn stacks_of_sets_lie_apart(s) {
        let (hash, set_bits) = (draw::hash(s), s.value("log2 sets", 0..=9, &WORDS[..10]));
        let ways = s.value("ways", 1..=16_u8, &[1, 3, 16]);
        let mut stacks = Stacks::new(hash, set_bits, ways);
        let mut lines = [LineAddr(0); 3];
        for place in 0..lines.len() {
            lines[place] = draw::line(s, &[0, 1, 8, u32::MAX]);
            let before = stacks.clone();
            stacks.access(lines[place]);
            let own = hash.set_of(lines[place], set_bits);
            check_eq!(stacks.stack(own).first(), Some(&lines[place]), "{lines:?}: {hash:?}, 2^{set_bits} sets");
            for set in (0..1 << set_bits).map(SetIndex).filter(|set| *set != own) {
                check_eq!(stacks.stack(set), before.stack(set), "{lines:?}: {hash:?}, 2^{set_bits} sets, {set:?}");
            }
        }
        cover!(s, "another set", stacks.set_of(lines[0]) != stacks.set_of(lines[1]));
        cover!(s, "512 sets of 16 ways", set_bits == 9 && ways == 16);
        stacks.flush();
        check!((0..1 << set_bits).all(|set| stacks.stack(SetIndex(set)).is_empty()), "{lines:?} after a flush");
    }
}
