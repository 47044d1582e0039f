//! Theorems of the tree of bits by which tree-PLRU finds its victim, at every width of a set (VM-6).
//!
//! Node 1 is the root, node `i` has the children `2 i` and `2 i + 1`, and the leaf of way `w` is node
//! `WAYS + w`. So the theorems go from a leaf up, where the code goes from the root down.

use crate::draw::{self, WORDS};
use crate::source::{Source, Stop};
use crate::{check_eq, cover, theorems};
use saarcor_model::vm::{LineAddr, Outcome, Policy, Set};

/// Any full set of `WAYS` ways: way `w` holds line `w`. What the tree does does not depend on lines.
fn full_set<S: Source, const WAYS: usize>(s: &mut S) -> Set<WAYS> {
    let mut set = Set::empty(Policy::Plru);
    for way in 0..WAYS {
        set.lines[way] = LineAddr(way as u32);
        set.resident[way] = true;
    }
    for node in 1..WAYS {
        set.order[node] = u8::from(draw::flag(s, "bit of the tree"));
    }
    set
}

fn victim<S: Source, const WAYS: usize>(s: &mut S) -> Result<(usize, usize), Stop> {
    s.size("ways", WAYS);
    let before = full_set::<S, WAYS>(s);
    let (_, outcome) = before.access(LineAddr(WAYS as u32), Policy::Plru);
    let Outcome::Miss { way, evicted } = outcome else { return Err(Stop::Vacuous) };
    let way = usize::from(way.0);
    check_eq!(evicted, Some(LineAddr(way as u32)), "victim of {before:?}");
    let mut node = WAYS + way;
    for _ in 0..WAYS.ilog2() {
        check_eq!(usize::from(before.order[node / 2]), node % 2, "bit of node {} of {before:?}", node / 2);
        node /= 2;
    }
    Ok((way, WAYS))
}

fn use_of_a_way<S: Source, const WAYS: usize>(s: &mut S) -> Result<(usize, usize), Stop> {
    s.size("ways", WAYS);
    let before = full_set::<S, WAYS>(s);
    let way = s.value("way", 0..=WAYS as u32 - 1, draw::words(0, WAYS)) as usize;
    let (after, _) = before.access(LineAddr(way as u32), Policy::Plru);
    let mut expected = before;
    let mut node = WAYS + way;
    for _ in 0..WAYS.ilog2() {
        expected.order[node / 2] = 1 - (node % 2) as u8;
        node /= 2;
    }
    check_eq!(after, expected, "way {way} of {before:?} used");
    Ok((way, WAYS))
}

/// Judges a body for sets of 2, 4, 8 and 16 ways; Kani, of 16.
macro_rules! wide {
    ($source:expr, $body:ident) => {
        match if cfg!(kani) { 3 } else { $source.value("log2 ways", 1..=4, &WORDS[1..5]) - 1 } {
            #[cfg(not(kani))]
            0 => $body::<S, 2>($source)?,
            #[cfg(not(kani))]
            1 => $body::<S, 4>($source)?,
            #[cfg(not(kani))]
            2 => $body::<S, 8>($source)?,
            _ => $body::<S, 16>($source)?,
        }
    };
}

theorems! {
    /// With tree-PLRU, every bit on the path from the root to the victim points to the victim.
    #["VM-6", unwind 18, covers ["the lowest way", "the highest way of 16"]]
    fn plru_victim_is_where_the_tree_points(s) {
        let (way, ways) = wide!(s, victim);
        cover!(s, "the lowest way", way == 0);
        cover!(s, "the highest way of 16", way == 15 && ways == 16);
    }

    /// With tree-PLRU, a use turns every bit on the path to the used way away from it, and changes
    /// no other bit.
    #["VM-6", unwind 18, covers ["the lowest way", "the highest way of 16"]]
    fn plru_use_turns_its_path_away(s) {
        let (way, ways) = wide!(s, use_of_a_way);
        cover!(s, "the lowest way", way == 0);
        cover!(s, "the highest way of 16", way == 15 && ways == 16);
    }
}
