//! The twin that counts what a run of accesses costs: `saarcor_fast::traffic`.
//!
//! A set of four ways corresponds to a row if the row's words are those of the set's lines, in the order of replacement, and
//! free words behind them. That lines of one set have different tags is
//! [`aligned_blocks_fill_every_set_once`](crate::vm::hash::aligned_blocks_fill_every_set_once). Which bytes of metadata an access
//! changes depends on the set's shape: that is a theorem of its own. What the registers of a processor make of a pair of rows is
//! compared with two steps by the tests of that module, over all pairs. The whole is compared run by run.

#[cfg(not(kani))]
use crate::draw::BYTES;
use crate::draw::{self, words};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_fast::traffic::changes::{Change, Shape};
use saarcor_fast::traffic::rows::{Row, Rows, Step, step};
use saarcor_model::vm::{DataSet, LineAddr, Outcome, Policy, Set};

const WAYS: usize = 4;

/// LRU or FIFO.
fn policy(s: &mut impl Source) -> Policy {
    if draw::flag(s, "FIFO") { Policy::Fifo } else { Policy::Lru }
}

/// Any set that has only been accessed since it was empty: its first ways hold lines below `end`, and are the first in its order.
/// The small scope has line `first + w` in way `w`.
fn accessed_set<S: Source>(s: &mut S, policy: Policy, first: usize, end: u32) -> Result<Set<WAYS>, Stop> {
    let mut set = Set::empty(policy);
    let count = s.value("lines", 0..=WAYS as u32, words(0, WAYS + 1)) as usize;
    for way in 0..WAYS {
        if way < count {
            set.resident[way] = true;
            set.lines[way] = LineAddr(s.value("line of a way", 0..=end - 1, words(first + way, 1)));
        }
    }
    set.order = order(s, count);
    for place in 0..WAYS {
        let way = usize::from(set.order[place]);
        assume!(if place < count { way < count } else { way == place });
    }
    assume!(set.is_valid(policy));
    Ok(set)
}

/// Any order of the first `count` ways, and the others behind them.
#[cfg(not(kani))]
fn order(s: &mut impl Source, count: usize) -> [u8; WAYS] {
    let mut order = std::array::from_fn(|place| place as u8);
    for place in 0..count {
        let later = count - 1 - place;
        order.swap(place, place + usize::from(s.value("exchange", 0..=later as u8, &BYTES[..=later])));
    }
    order
}

/// Any numbers: that they are such an order is assumed with the set.
#[cfg(kani)]
fn order(s: &mut impl Source, _count: usize) -> [u8; WAYS] {
    draw::order(s, Policy::Lru)
}

/// The row of a set of lines; of granules, with those that are dirty marked.
fn row_of<const MARKS: bool>(set: &Set<WAYS>, dirty: [bool; WAYS]) -> Row {
    let mut row = [Rows::<MARKS>::FREE; WAYS];
    for place in 0..WAYS {
        let way = usize::from(set.order[place]);
        if set.resident[way] {
            row[place] = word_of::<MARKS>(set.lines[way], dirty[way]);
        }
    }
    row
}

fn word_of<const MARKS: bool>(line: LineAddr, dirty: bool) -> u16 {
    if MARKS { (line.0 as u16) << 1 | u16::from(dirty) } else { line.0 as u16 }
}

/// As [`Step::found`]: where in its order a set has the line of an outcome.
fn found(before: &Set<WAYS>, outcome: Outcome) -> u8 {
    let mut found = 0;
    for place in 0..WAYS {
        let here = matches!(outcome, Outcome::Hit { way } if way.0 == before.order[place]);
        found |= u8::from(here) << place;
    }
    found
}

theorems! {
    /// From any LRU or FIFO set of 4 ways and its row, the row finds a line where the set has it in its order, and corresponds
    /// to the set after the access.
    #["VM-6", unwind 10, covers ["hit behind the first", "miss, way free", "eviction"]]
    fn row_steps_as_the_set(s) {
        let policy = policy(s);
        let end = u32::from(Rows::<false>::FREE);
        let set = accessed_set(s, policy, 0, end)?;
        let line = LineAddr(s.value("line", 0..=end - 1, words(0, WAYS + 1)));
        let (after, outcome) = set.access(line, policy);
        let before = row_of::<false>(&set, [false; WAYS]);
        let mut row = before;
        let step = step::<false>(&mut row, line.0 as u16, policy);
        cover!(s, "hit behind the first", step.found > 1);
        cover!(s, "miss, way free", matches!(outcome, Outcome::Miss { evicted: None, .. }));
        cover!(s, "eviction", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        check_eq!(step, Step { found: found(&set, outcome), marked: false }, "{set:?}: access {line:?}");
        check_eq!(row, row_of::<false>(&after, [false; WAYS]), "{set:?}, {before:?}: after {line:?}");
    }

    /// From any set of a metadata cache and its row, in which dirty granules are marked: a granule that is used, and then used
    /// again to be written if it changes, takes one step of the row, whose key is marked if the granule changes. The row says
    /// of a granule that it is marked if there is one dirty granule more, those counted that are written back.
    #["VM-13", unwind 10, covers ["hit", "hit of a dirty one", "write-back", "changes"]]
    fn marked_row_steps_as_the_set_of_granules(s) {
        let policy = policy(s);
        let end = u32::from(Rows::<true>::FREE / 2);
        let set = accessed_set(s, policy, 0, end)?;
        let mut cached = DataSet::<WAYS, ()> { set, ..DataSet::empty(policy, ()) };
        for way in 0..WAYS {
            cached.dirty[way] = cached.set.resident[way] && draw::flag(s, "dirty");
        }
        let granule = LineAddr(s.value("granule", 0..=end - 1, words(0, WAYS + 1)));
        let changes = draw::flag(s, "changes");
        let (mut after, outcome, write_back) = cached.access(granule, policy, || ());
        if changes {
            let (again, hit, none) = after.access(granule, policy, || ());
            check!(matches!(hit, Outcome::Hit { .. }) && none.is_none(), "{cached:?}: {granule:?} used again");
            after = again.write(hit.way(), ());
        }
        let mut row = row_of::<true>(&cached.set, cached.dirty);
        let step = step::<true>(&mut row, word_of::<true>(granule, changes), policy);
        let count = |dirty: [bool; WAYS]| dirty.map(usize::from).iter().sum::<usize>();
        let more = count(after.dirty) + usize::from(write_back.is_some()) - count(cached.dirty);
        cover!(s, "hit", step.found != 0);
        cover!(s, "hit of a dirty one", step.found != 0 && changes && !step.marked);
        cover!(s, "write-back", write_back.is_some());
        cover!(s, "changes", changes);
        check_eq!(step.found, found(&cached.set, outcome), "{cached:?}: {granule:?}");
        check_eq!(usize::from(step.marked), more, "{cached:?}: {granule:?}, changes: {changes}");
        check_eq!(row, row_of::<true>(&after.set, after.dirty), "{cached:?}: after {granule:?}, changes: {changes}");
    }

    /// Which granules an access changes, and the shape of the set after it, depend on the set's shape and on the place of the
    /// line in its order, and on no address: whatever the lines, if a granule that ends behind the address of way 0 alone is
    /// not one of line 0, whose set has no such granule.
    #["VM-13", unwind 22, covers ["way 0 is filled", "hit", "eviction", "one granule of two"]]
    fn changes_depend_on_the_shape_alone(s) {
        let policy = policy(s);
        let set = accessed_set(s, policy, 1, u32::MAX)?;
        let border = s.value("border", 0..=Shape::BORDERS as u32 - 1, words(0, Shape::BORDERS)) as usize;
        // Lines that differ in one byte, wherever it is.
        let line = draw::line(s, &[0, 1, 2, 3, 4, 5, 0x0100_0001, 0x0001_0002]);
        assume!(border != 1 || line.0 != 0);
        let (after, outcome) = set.access(line, policy);
        let shape = Shape::of(&set, border);
        let found = found(&set, outcome);
        let place = (found != 0).then(|| found.trailing_zeros() as usize);
        let change = Change::between(&set, &after, border);
        cover!(s, "way 0 is filled", !set.resident[0] && border == 1);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "eviction", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        cover!(s, "one granule of two", change.dirty == 1 || change.dirty == 1 << 16);
        check_eq!(Change::of(shape, place, policy), change, "{set:?}: {line:?}, border {border}");
    }
}
