//! Theorems of a set with bytes: a first-level cache's, and the metadata cache's of version B.
//!
//! **One witness.** One arbitrary line is watched, and one word remembers what it should hold: the
//! memory behind knows only that line. What holds of an arbitrary line holds of all. Two ways of
//! two bytes: the ways' bookkeeping is the set's, whose theorems speak of more; bytes move as wholes.

use crate::draw::{self, BYTES, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::vm::{DataSet, LineAddr, Outcome, Policy, WriteBack};

/// The bytes of a line.
pub fn bytes<const N: usize>(s: &mut impl Source, name: &'static str, small: &'static [u8]) -> [u8; N] {
    let mut bytes = [0; N];
    for byte in &mut bytes {
        *byte = s.value(name, 0..=u8::MAX, small);
    }
    bytes
}

/// Any legal set with bytes.
pub fn data_set<S: Source, const WAYS: usize, const N: usize>(
    s: &mut S,
    policy: Policy,
) -> Result<DataSet<WAYS, [u8; N]>, Stop> {
    let mut set = DataSet::empty(policy, [0; N]);
    set.set = draw::set_of::<S, WAYS>(s, policy)?;
    for way in 0..WAYS {
        if set.set.resident[way] {
            set.dirty[way] = draw::flag(s, "dirty");
        }
        set.contents[way] = bytes(s, "byte of a way", &BYTES[..1]);
    }
    Ok(set)
}

/// A watched line, what it holds, and the memory behind, of which only that line is known.
#[derive(Clone, Copy, Debug)]
struct Watched {
    line: LineAddr,
    bytes: [u8; 2],
    behind: [u8; 2],
}

/// Any watched line in any legal set: what it holds is what the cache holds, or else the memory
/// behind; clean, both are the same.
fn watched<S: Source>(s: &mut S, policy: Policy) -> Result<(DataSet<2, [u8; 2]>, Watched), Stop> {
    let mut set = data_set::<S, 2, 2>(s, policy)?;
    let line = draw::line(s, &WORDS[..3]);
    let bytes = bytes::<2>(s, "watched byte", &BYTES[1..3]);
    let mut behind = bytes;
    for way in 0..2 {
        if set.set.resident[way] && set.set.lines[way] == line {
            set.contents[way] = bytes;
            if set.dirty[way] {
                behind = self::bytes(s, "byte behind", &BYTES[3..4]);
            }
        }
    }
    Ok((set, Watched { line, bytes, behind }))
}

/// What the cache and the memory behind together hold of the watched line.
fn held(set: &DataSet<2, [u8; 2]>, watched: &Watched) -> [u8; 2] {
    let mut held = watched.behind;
    for way in 0..2 {
        if set.set.resident[way] && set.set.lines[way] == watched.line {
            held = set.contents[way];
        }
    }
    held
}

/// Uses `line`, and writes back what has to be.
fn used(
    set: &DataSet<2, [u8; 2]>,
    policy: Policy,
    line: LineAddr,
    watched: &mut Watched,
    other: [u8; 2],
) -> (DataSet<2, [u8; 2]>, Outcome, bool) {
    let behind = if line == watched.line { watched.behind } else { other };
    let (after, outcome, write_back) = set.access(line, policy, || behind);
    if let Some(WriteBack { line, contents }) = write_back
        && line == watched.line
    {
        watched.behind = contents;
    }
    (after, outcome, write_back.is_some())
}

theorems! {
    /// After any access, write or invalidation a set with bytes is legal: only resident lines are
    /// dirty.
    #["VM-13", unwind 8, covers ["access", "write", "invalidation", "dirty"]]
    fn data_set_keeps_invariant(s) {
        let policy = draw::policy(s);
        let before = data_set::<S, 2, 2>(s, policy)?;
        let line = draw::line_of_set::<2>(s);
        let step = s.value("step (access, write, invalidate)", 0..=2, &BYTES[..3]);
        let (used, outcome, _) = before.access(line, policy, || [0; 2]);
        let after = match step {
            0 => used,
            1 => used.write(outcome.way(), [1; 2]),
            _ => before.invalidate(line).0,
        };
        cover!(s, "access", step == 0);
        cover!(s, "write", step == 1);
        cover!(s, "invalidation", step == 2);
        cover!(s, "dirty", after.dirty[0] && after.dirty[1]);
        check!(after.is_valid(policy), "{policy:?}: {before:?}, step {step} of {line:?}: {after:?}");
    }

    /// The invariant of a set with bytes rejects a free way that is dirty, and an illegal set.
    #["VM-13", unwind 8, covers ["dirty and free", "a line twice"]]
    fn invariant_rejects_dirty_free_ways(s) {
        let policy = draw::policy(s);
        let mut set = data_set::<S, 2, 2>(s, policy)?;
        let way = usize::from(draw::flag(s, "way 1"));
        if draw::flag(s, "dirty and free") {
            (set.set.resident[way], set.dirty[way]) = (false, true);
            cover!(s, "dirty and free", true);
        } else {
            set.set.resident = [true; 2];
            set.set.lines[1 - way] = set.set.lines[way];
            cover!(s, "a line twice", true);
        }
        check!(!set.is_valid(policy), "{policy:?}: taken for legal: {set:?}");
    }

    /// A set with bytes makes the same decisions as the set without them: same hit, way and victim.
    #["L1-1", unwind 8, covers ["hit", "miss"]]
    fn data_set_decides_like_the_set(s) {
        let policy = draw::policy(s);
        let before = data_set::<S, 2, 2>(s, policy)?;
        let line = draw::line_of_set::<2>(s);
        let (after, outcome, _) = before.access(line, policy, || [0; 2]);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        check_eq!((after.set, outcome), before.set.access(line, policy), "{policy:?}: {:?}, access {line:?}", before.set);
        check_eq!(before.invalidate(line).0.set, before.set.invalidate(line).0, "{policy:?}: {:?}, invalidate {line:?}", before.set);
    }

    /// An access changes no line's bytes: a line is loaded as the memory behind holds it, and what was
    /// written to a line is written back when the line is evicted.
    #["VM-13", unwind 8, covers ["loaded", "written back", "kept"]]
    fn access_keeps_every_lines_bytes(s) {
        let policy = draw::policy(s);
        let (before, mut watched) = watched(s, policy)?;
        let line = draw::line_of_set::<2>(s);
        let other = bytes(s, "byte of another line", &BYTES[4..5]);
        let was_dirty = before.set.way_of(watched.line).is_some_and(|way| before.dirty[usize::from(way.0)]);
        let (after, outcome, written) = used(&before, policy, line, &mut watched, other);
        cover!(s, "loaded", line == watched.line && matches!(outcome, Outcome::Miss { .. }));
        cover!(s, "written back", was_dirty && written && after.set.way_of(watched.line).is_none());
        cover!(s, "kept", line != watched.line && after.set.way_of(watched.line).is_some());
        check_eq!(held(&after, &watched), watched.bytes, "{policy:?}: {before:?}, access {line:?}, {after:?}: {:?}", watched.line);
        // A clean line may be dropped at any time.
        let clean = after.set.way_of(watched.line).is_some_and(|way| !after.dirty[usize::from(way.0)]);
        check!(!clean || watched.behind == watched.bytes, "{policy:?}: {before:?}, access {line:?}, {after:?}: clean, but {watched:?}");
    }

    /// After a write a line holds what was written, and no other line has changed.
    #["VM-13", unwind 8, covers ["the line itself", "another line"]]
    fn write_changes_one_line(s) {
        let policy = draw::policy(s);
        let (before, mut watched) = watched(s, policy)?;
        let line = draw::line_of_set::<2>(s);
        let (used, outcome, _) = used(&before, policy, line, &mut watched, [0; 2]);
        let written = bytes::<2>(s, "byte written", &BYTES[5..7]);
        let after = used.write(outcome.way(), written);
        cover!(s, "the line itself", line == watched.line);
        cover!(s, "another line", line != watched.line && after.set.way_of(watched.line).is_some());
        let expected = if line == watched.line { written } else { watched.bytes };
        check_eq!(held(&after, &watched), expected, "{policy:?}: {before:?}, {line:?} written, {after:?}: {:?}", watched.line);
        check!(after.dirty[usize::from(outcome.way().0)], "{policy:?}: {before:?}, {line:?} written, {after:?}: not dirty");
    }

    /// A line is written back exactly if it was dirty and is evicted, and a line that is loaded
    /// is clean.
    #["VM-13", unwind 8, covers ["dirty and evicted", "clean and evicted"]]
    fn only_dirty_lines_are_written_back(s) {
        let policy = draw::policy(s);
        let before = data_set::<S, 2, 2>(s, policy)?;
        let line = draw::line_of_set::<2>(s);
        let (after, outcome, write_back) = before.access(line, policy, || [9; 2]);
        let Outcome::Miss { way, evicted } = outcome else {
            check!(write_back.is_none() && after.dirty == before.dirty, "{policy:?}: {before:?}, hit {line:?}: {write_back:?}, {after:?}");
            return Ok(());
        };
        let way = usize::from(way.0);
        let expected = match evicted {
            Some(line) if before.dirty[way] => Some(WriteBack { line, contents: before.contents[way] }),
            _ => None,
        };
        cover!(s, "dirty and evicted", expected.is_some());
        cover!(s, "clean and evicted", evicted.is_some() && expected.is_none());
        check_eq!(write_back, expected, "{policy:?}: {before:?}, miss {line:?}");
        check!(!after.dirty[way] && after.contents[way] == [9; 2], "{policy:?}: {before:?}, miss {line:?}: {after:?}");
    }

    /// After an invalidation the line is not resident, and its bytes are loaded again from the memory
    /// behind; all other lines stay.
    #["L1-2", unwind 8, covers ["the line itself", "another line"]]
    fn invalidation_drops_one_lines_bytes(s) {
        let policy = draw::policy(s);
        let (before, watched) = watched(s, policy)?;
        let line = draw::line_of_set::<2>(s);
        assume!(before.set.way_of(watched.line).is_some());
        let (after, way) = before.invalidate(line);
        cover!(s, "the line itself", line == watched.line);
        cover!(s, "another line", line != watched.line && way.is_some());
        let expected = if line == watched.line { watched.behind } else { watched.bytes };
        check_eq!(held(&after, &watched), expected, "{policy:?}: {before:?}, invalidate {line:?}, {after:?}: {:?}", watched.line);
        check_eq!(after.set.way_of(line), None, "{policy:?}: {before:?}, invalidate {line:?}: its way");
    }
}
