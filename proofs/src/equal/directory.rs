//! The directory's twin, and the set's: `saarcor_fast::directory`.
//!
//! The twin works on the specification's own state: states correspond if they are equal. What it does
//! otherwise: the search for a line, and no step at all for the line that was used last. A directory
//! meets its metadata only by loading and storing sets, so one theorem speaks of every version
//! ([`fast_directory_meets_any_metadata_alike`]): the twin may leave out a store of what was loaded,
//! which changes nothing ([`storing_what_was_loaded_changes_nothing`](super::version_b)).

use crate::draw::{self, EDGES, WORDS, any_ways};
#[cfg(not(kani))]
use crate::engines::Random;
use crate::refinement::directory::Ask;
use crate::refinement::machine::step_from_any;
use crate::refinement::twins::{Fast, TwinOfA};
use crate::source::{Holds, Source};
use crate::vm::directory::{counters, directory};
use crate::vm::version_b::Scripted;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_fast::directory as fast;
use saarcor_model::vm::{Directory, Hash, LineAddr, Outcome, Policy, Set};

/// Any hash. Kani takes none that loops over the groups of a line's bits: both sides call the same hash.
pub fn hash(s: &mut impl Source) -> Hash {
    match cfg!(kani) {
        true if draw::flag(s, "hash (low, add-upper)") => Hash::AddUpper,
        true => Hash::Low,
        false => draw::hash(s),
    }
}

/// Bodies for sets of any number of ways.
mod bodies {
    use super::*;

    pub fn youngest<S: Source, const WAYS: usize>(s: &mut S) -> Holds {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let youngest = fast::way_if_youngest(&before, line, policy);
        cover!(s, "youngest", youngest.is_some());
        cover!(s, "not youngest", youngest.is_none() && before.way_of(line).is_some());
        if let Some(way) = youngest {
            check_eq!(
                before.access(line, policy),
                (before, Outcome::Hit { way }),
                "{policy:?}: access {line:?}"
            );
        }
        Ok(())
    }

    pub fn same_step<S: Source, const WAYS: usize>(s: &mut S) -> Holds {
        let (policy, before) = draw::set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss, way free", matches!(outcome, Outcome::Miss { evicted: None, .. }));
        cover!(s, "miss, set full", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        check_eq!(
            fast::access_set(&before, line, policy),
            (after, outcome),
            "{policy:?}: {before:?}, access {line:?}"
        );
        Ok(())
    }
}

/// The same for sets of 8 and 16 ways, for the random engine: name, covers and body.
#[cfg(not(kani))]
#[allow(clippy::type_complexity, reason = "a list of three columns")]
pub const WIDE: &[(&str, &[&str], fn(&mut Random) -> Holds)] = &[
    ("youngest_line_needs_no_step", &["youngest", "not youngest"], |source| {
        bodies::youngest::<Random, 8>(source)?;
        bodies::youngest::<Random, 16>(source)
    }),
    ("fast_set_step_is_the_sets", &["hit", "miss, way free", "miss, set full"], |source| {
        bodies::same_step::<Random, 8>(source)?;
        bodies::same_step::<Random, 16>(source)
    }),
];

theorems! {
    /// An access to the line that was used last hits and changes nothing, so that it needs no step.
    #["VM-6", unwind 8, covers ["youngest", "not youngest"]]
    fn youngest_line_needs_no_step(s) {
        any_ways!(s, bodies::youngest);
    }

    /// With LRU the line of the last access is recognised as the one used last: what repeats takes the
    /// short way.
    #["VM-6", unwind 8, covers ["hit", "miss"]]
    fn repeated_line_is_the_youngest(s) {
        let (policy, before) = draw::set::<S, 4>(s)?;
        assume!(policy == Policy::Lru);
        let line = draw::line_of_set::<4>(s);
        let (after, outcome) = before.access(line, policy);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        check_eq!(fast::way_if_youngest(&after, line, policy), Some(outcome.way()), "{before:?}, access {line:?}");
    }

    /// From any legal set the twin's step gives the specification's outcome and the specification's set.
    #["VM-6", unwind 8, covers ["hit", "miss, way free", "miss, set full"]]
    fn fast_set_step_is_the_sets(s) {
        any_ways!(s, bodies::same_step);
    }

    /// From any legal directory of version A, with any hash and policy, the twin's access gives the
    /// specification's outcome and leaves the specification's sets and counters.
    #["VM-6", unwind 5, covers ["hit", "miss", "eviction"]]
    fn fast_directory_step_is_the_directorys(s) {
        let mut expected = directory::<S, 2, 2>(s, &WORDS[..6])?;
        // Lines lie where another hash puts them, too: a step of a set does not ask.
        expected.config.hash = hash(s);
        expected.counters = counters(s);
        let mut got = Fast(expected.clone());
        let line = draw::line(s, &WORDS[..7]);
        let outcome = step_from_any::<TwinOfA<2>>(&mut got, &mut expected, &Ask::Access(line))?;
        cover!(s, "hit", matches!(outcome, Some(Outcome::Hit { .. })));
        cover!(s, "miss", matches!(outcome, Some(Outcome::Miss { evicted: None, .. })));
        cover!(s, "eviction", matches!(outcome, Some(Outcome::Miss { evicted: Some(_), .. })));
    }

    /// Whatever its metadata loads, in whatever version, the twin's access loads the set that the
    /// specification loads, gives its outcome and counts, and stores its set; what it does not store
    /// is what it loaded.
    #["VM-13", unwind 5, covers ["hit", "miss", "nothing stored"]]
    fn fast_directory_meets_any_metadata_alike(s) {
        let mut config = crate::vm::directory::config::<S, 4, 2>(s)?;
        config.hash = hash(s);
        let load = draw::set_of::<S, 4>(s, config.policy)?;
        let mut expected = Directory::over(config, Scripted { load, loaded: None, stored: None });
        let mut got = expected.clone();
        let line = draw::line(s, &WORDS[..5]);
        let outcome = expected.access(line);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        check_eq!(fast::access(&mut got, line), outcome, "{line:?}, {load:?}");
        cover!(s, "nothing stored", got.metadata.stored.is_none());
        let Some(index) = expected.metadata.loaded else { return Ok(()) };
        check_eq!(got.metadata.loaded, Some(index), "{line:?}, {load:?}: set loaded");
        check_eq!(got.metadata.stored.unwrap_or((index, load)), expected.metadata.stored.unwrap_or((index, load)), "{line:?}, {load:?}: set stored");
        check_eq!(got.counters, expected.counters, "{line:?}, {load:?}");
        check!(matches!(outcome, Outcome::Hit { .. }) || got.metadata.stored.is_some(), "{line:?}, {load:?}: a miss is stored");
    }

    /// From any legal set of 8 ways the twin's step gives the specification's outcome and the specification's set.
    #["VM-6", unwind 10, covers ["hit", "miss, way free", "miss, set full"]]
    fn fast_wide_set_step_is_the_sets(s) {
        let (policy, before) = draw::wide_set::<S, 8>(s)?;
        let line = draw::line_of_set::<8>(s);
        let (after, outcome) = before.access(line, policy);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss, way free", matches!(outcome, Outcome::Miss { evicted: None, .. }));
        cover!(s, "miss, set full", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        check_eq!(fast::access_set(&before, line, policy), (after, outcome), "{policy:?}: {before:?}, access {line:?}");
    }

    /// The search without branches compares every bit of a line: it does not find a line in a set that holds one which differs
    /// in one bit, nor takes it for the one used last.
    #["VM-4", unwind 8, covers ["the lowest bit", "the highest bit"]]
    fn fast_search_compares_every_bit(s) {
        let (line, bit) = (draw::line(s, &EDGES), s.value("bit", 0..=31, &WORDS[..32]));
        let (set, _) = Set::<4>::empty(Policy::Lru).access(line, Policy::Lru);
        let other = LineAddr(line.0 ^ 1 << bit);
        cover!(s, "the lowest bit", bit == 0);
        cover!(s, "the highest bit", bit == 31);
        check_eq!(fast::way_of(&set, other), None, "{other:?} in {set:?}");
        check_eq!(fast::way_if_youngest(&set, other, Policy::Lru), None, "{other:?} used last in {set:?}");
    }
}
