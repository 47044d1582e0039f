//! Theorems of a set of 16 ways, the most that there are (VM-5 to VM-8).
//!
//! The theorems of the sets of 1, 2 and 4 ways say all this of narrow sets. A set whose loops, or whose management bits, end
//! at some way shows here. The small scope is narrow (`draw::wide_set`); Kani and the random engine take any set.

use crate::draw;
use crate::{assume, check_eq, cover, theorems};
use saarcor_model::vm::{Outcome, Policy, Way};

const WAYS: usize = 16;

theorems! {
    /// A set of 16 ways hits exactly what it holds, in the way that holds it, whichever ways are free.
    #["VM-6", unwind 18, covers ["the last way", "not resident", "with a free way"]]
    fn wide_set_hits_what_it_holds(s) {
        let (policy, before) = draw::wide_set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let mut holder = None;
        for way in 0..WAYS {
            if before.resident[way] && before.lines[way] == line {
                holder = Some(Way(way as u8));
            }
        }
        cover!(s, "the last way", holder == Some(Way(15)));
        cover!(s, "not resident", holder.is_none());
        cover!(s, "with a free way", holder.is_some() && !before.resident[0]);
        let (_, outcome) = before.access(line, policy);
        let hit = if let Outcome::Hit { way } = outcome { Some(way) } else { None };
        check_eq!(hit, holder, "{policy:?}: {before:?}, access {line:?}: a hit");
    }

    /// In a set of 16 ways the free way of the lowest number is taken, and nothing is evicted for it.
    #["VM-7", unwind 18, covers ["the last way alone", "the first way"]]
    fn wide_set_takes_the_lowest_free_way(s) {
        let (policy, before) = draw::wide_set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let mut free = WAYS;
        for way in (0..WAYS).rev() {
            if !before.resident[way] {
                free = way;
            }
        }
        let (_, outcome) = before.access(line, policy);
        let Outcome::Miss { way, evicted } = outcome else { return Ok(()) };
        assume!(free < WAYS);
        cover!(s, "the last way alone", free == 15);
        cover!(s, "the first way", free == 0);
        check_eq!((usize::from(way.0), evicted), (free, None), "{policy:?}: {before:?}, access {line:?}");
    }

    /// In a full set of 16 ways the victim of LRU and FIFO is the last of the order.
    #["VM-6", unwind 18, covers ["LRU", "FIFO"]]
    fn wide_victim_is_the_oldest(s) {
        let (policy, before) = draw::wide_set::<S, WAYS>(s)?;
        assume!(policy != Policy::Plru);
        let line = draw::line_of_set::<WAYS>(s);
        let (_, outcome) = before.access(line, policy);
        let Outcome::Miss { way, evicted: Some(evicted) } = outcome else { return Ok(()) };
        cover!(s, "LRU", policy == Policy::Lru);
        cover!(s, "FIFO", policy == Policy::Fifo);
        check_eq!(way.0, before.order[15], "{policy:?}: {before:?}, access {line:?}: way of the victim");
        check_eq!(evicted, before.lines[usize::from(way.0)], "{policy:?}: {before:?}, access {line:?}: victim");
    }

    /// In a set of 16 ways what is used (FIFO: loaded) goes to the front of the order, and all others stay in their order.
    #["VM-6", unwind 18, covers ["the oldest used", "FIFO, loaded"]]
    fn wide_order_is_that_of_last_use(s) {
        let (policy, before) = draw::wide_set::<S, WAYS>(s)?;
        assume!(policy != Policy::Plru);
        let line = draw::line_of_set::<WAYS>(s);
        let (after, outcome) = before.access(line, policy);
        let used = outcome.way().0;
        if let (Policy::Fifo, Outcome::Hit { .. }) = (policy, outcome) {
            check_eq!(after.order, before.order, "FIFO: {before:?}, hit {line:?}");
            return Ok(());
        }
        cover!(s, "the oldest used", before.order[15] == used && matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "FIFO, loaded", policy == Policy::Fifo);
        check_eq!(after.order[0], used, "{policy:?}: {before:?}, access {line:?}: the youngest");
        let mut closed = false;
        for place in 0..WAYS - 1 {
            closed |= before.order[place] == used;
            let expected = if closed { before.order[place + 1] } else { before.order[place] };
            check_eq!(after.order[place + 1], expected, "{policy:?}: {before:?}, access {line:?}: place {}", place + 1);
        }
    }

    /// In a set of 16 ways a line is loaded, and a line is forgotten, in one way; the other 15 keep what they hold.
    #["VM-8", unwind 18, covers ["loaded into the last way", "forgotten in the last way"]]
    fn wide_set_changes_one_way(s) {
        let (policy, before) = draw::wide_set::<S, WAYS>(s)?;
        let line = draw::line_of_set::<WAYS>(s);
        let forget = draw::flag(s, "forget");
        let (after, changed) = if forget {
            before.invalidate(line)
        } else {
            let (after, outcome) = before.access(line, policy);
            (after, Some(outcome.way()))
        };
        cover!(s, "loaded into the last way", !forget && changed == Some(Way(15)));
        cover!(s, "forgotten in the last way", forget && changed == Some(Way(15)));
        for way in 0..WAYS {
            if changed == Some(Way(way as u8)) {
                check_eq!((after.resident[way], after.lines[way]), (!forget, line), "{policy:?}: {before:?}, {line:?}, forget {forget}: way {way}");
            } else {
                check_eq!((after.resident[way], after.lines[way]), (before.resident[way], before.lines[way]), "{policy:?}: {before:?}, {line:?}, forget {forget}: way {way}");
            }
        }
    }
}
