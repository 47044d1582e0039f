//! Theorems of the directory, version A: which line lies where, over all sets (VM-5, VM-6, VM-8).
//!
//! **One set is enough.** An access is the step of its line's set ([`access_is_the_step_of_its_set`])
//! and changes no other ([`access_changes_one_set`]); the theorems of the set speak of more ways.
//! Two sets of two ways, so that a wrong set shows, with lines of two bytes, so that a wrong offset
//! does.

use crate::draw::{self, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_model::vm::{
    Bytes, CacheConfig, Counters, Directory, Geometry, Hash, HostAddr, LineAddr, Outcome, Set, SetIndex,
};

/// Ways of the card that the theorems of directory and virtual memory speak of.
pub const WAYS: usize = 2;
/// Sets of it.
pub const SETS: usize = 2;
/// Bytes of a line of it.
pub const LINE: usize = 2;

/// Any configuration of a card of that many sets, with the standard hash: that the others name a set too is a
/// theorem of the hash, and what is done with the set is the same.
pub fn config<S: Source, const WAYS: usize, const SETS: usize>(s: &mut S) -> Result<CacheConfig, Stop> {
    s.size("ways", WAYS);
    s.size("sets", SETS);
    s.size("bytes a line", LINE);
    let policy = draw::policy(s);
    match Geometry::new(Bytes((WAYS * SETS * LINE) as u64), Bytes(LINE as u64), WAYS as u32) {
        Ok(geometry) => Ok(CacheConfig { geometry, hash: Hash::AddUpper, policy }),
        Err(_) => Err(Stop::Vacuous),
    }
}

/// Any directory in any legal state: every resident line lies in its own set.
///
/// Small scope: the lines of `small`; three a set are one more than there are ways.
pub fn directory<S: Source, const WAYS: usize, const SETS: usize>(
    s: &mut S,
    small: &'static [u32],
) -> Result<Directory<WAYS>, Stop> {
    let config = config::<S, WAYS, SETS>(s)?;
    let mut directory = Directory::new(config);
    for index in 0..SETS {
        let mut set = Set::empty(config.policy);
        for way in 0..WAYS {
            set.resident[way] = draw::flag(s, "resident");
            if set.resident[way] {
                set.lines[way] = LineAddr(s.value("line of a way", 0..=u32::MAX, small));
                assume!(config.set_of(set.lines[way]) == SetIndex(index as u32));
            }
        }
        set.order = draw::order(s, config.policy);
        assume!(set.is_valid(config.policy));
        directory.metadata.sets[index] = set;
    }
    Ok(directory)
}

/// Whether the directory is legal: its sets are, and each line lies in its own.
fn is_valid(directory: &Directory<WAYS>) -> bool {
    let mut valid = true;
    for (index, set) in directory.sets().iter().enumerate() {
        valid &= set.is_valid(directory.config.policy);
        for way in 0..WAYS {
            let own = directory.config.set_of(set.lines[way]) == SetIndex(index as u32);
            valid &= own | !set.resident[way];
        }
    }
    valid
}

/// An address for a step. Small scope: bytes of lines 0 to 5.
pub fn addr(s: &mut impl Source) -> HostAddr {
    draw::addr(s, &[0, 1, 2, 3, 5, 6, 8, 10])
}

/// Length of a range. Small scope: none, less than a line, more than one, more than the card, all.
pub fn len(s: &mut impl Source) -> u64 {
    s.value("bytes", 0..=u64::MAX, &[0, 1, 3, 9, u64::MAX])
}

theorems! {
    /// An access changes no set but the set of its line.
    #["VM-6", unwind 5, covers ["set 0", "set 1"]]
    fn access_changes_one_set(s) {
        let mut directory = directory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let line = draw::line(s, &WORDS[..7]);
        let before = directory.clone();
        directory.access(line);
        let own = directory.config.set_of(line).0 as usize;
        cover!(s, "set 0", own == 0);
        cover!(s, "set 1", own == 1);
        for set in 0..SETS {
            check!(set == own || directory.sets()[set] == before.sets()[set], "set {set} after access {line:?} to {before:?}");
        }
    }

    /// An access to the cache is one step of the set of its line.
    #["VM-6", unwind 5, covers ["hit", "miss"]]
    fn access_is_the_step_of_its_set(s) {
        let mut directory = directory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let line = draw::line(s, &WORDS[..7]);
        let own = directory.config.set_of(line).0 as usize;
        let expected = directory.sets()[own].access(line, directory.config.policy);
        let before = shown!(directory.clone());
        let outcome = directory.access(line);
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { .. }));
        check_eq!((directory.sets()[own], outcome), expected, "access {line:?} to {before:?}");
    }

    /// After any access and any invalidation all sets are legal and every resident line lies in its own
    /// set: so no line is resident twice, and never more lines than the memory holds.
    #["VM-5", unwind 5, covers ["access", "invalidation"]]
    fn resident_lines_lie_in_their_sets(s) {
        let mut directory = directory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let before = shown!(directory.clone());
        let access = draw::flag(s, "access");
        let (addr, len) = (addr(s), len(s));
        if access {
            directory.access(directory.config.geometry.line_of(addr));
        } else {
            directory.invalidate(addr, len);
        }
        cover!(s, "access", access);
        cover!(s, "invalidation", !access && len > 0);
        check!(is_valid(&directory), "access: {access}, {addr:?}, {len} bytes to {before:?}: {directory:?}");
    }

    /// The counters count each access once, and each miss and each eviction that it causes.
    #["VM-6", unwind 5, covers ["hit", "miss", "eviction"]]
    fn counters_count_each_access(s) {
        let mut directory = directory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let line = draw::line(s, &WORDS[..7]);
        let before = shown!(directory.clone());
        let outcome = directory.access(line);
        let (missed, evicted) = match outcome {
            Outcome::Hit { .. } => (0, 0),
            Outcome::Miss { evicted, .. } => (1, u64::from(evicted.is_some())),
        };
        cover!(s, "hit", missed == 0);
        cover!(s, "miss", missed == 1);
        cover!(s, "eviction", evicted == 1);
        let expected = Counters { accesses: 1, misses: missed, evictions: evicted, invalidated: 0 };
        check_eq!(directory.counters, expected, "access {line:?} to {before:?}");
        check_eq!(directory.counters.hits(), 1 - missed, "hits of access {line:?} to {before:?}");
    }

    /// On a cold cache at least as many lines are loaded as distinct lines are used.
    // Four accesses show the base; that a line which is not resident is loaded, from any state, is
    // `hit_iff_resident`, and carries it to runs of any length.
    #["VM-6", unwind 5, covers ["four distinct lines", "a line twice", "more loads than lines"]]
    fn cold_cache_loads_every_distinct_line(s) {
        let mut directory = Directory::<WAYS>::new(config::<S, WAYS, SETS>(s)?);
        let mut lines = [LineAddr(0); 4];
        let mut distinct = 0;
        for k in 0..4 {
            lines[k] = draw::line(s, &WORDS[..7]);
            let mut new = true;
            for earlier in 0..k {
                new &= lines[earlier] != lines[k];
            }
            distinct += u64::from(new);
            directory.access(lines[k]);
        }
        cover!(s, "four distinct lines", distinct == 4);
        cover!(s, "a line twice", distinct < 4);
        cover!(s, "more loads than lines", directory.counters.misses > distinct);
        let loaded = directory.counters.misses;
        check!(loaded >= distinct, "{:?}: {lines:?} are {distinct} lines, {loaded} loaded", directory.config);
    }

    /// An invalidation of a range of bytes forgets exactly the resident lines that overlap it, counts
    /// them, and changes nothing else.
    #["VM-8", unwind 5, covers ["a line in the range", "a line beside it", "more lines than the cache holds", "none"]]
    fn invalidation_forgets_exactly_the_range(s) {
        let mut directory = directory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let (addr, len) = (addr(s), len(s));
        let before = directory.clone();
        directory.invalidate(addr, len);
        let range = before.config.lines_of(addr, len);
        cover!(s, "more lines than the cache holds", range.end - range.start > 4);
        cover!(s, "none", range.start == range.end);
        let mut forgotten = 0;
        for set in 0..SETS {
            let (was, is) = (before.sets()[set], directory.sets()[set]);
            for way in 0..WAYS {
                let inside = range.contains(&u64::from(was.lines[way].0));
                forgotten += u64::from(was.resident[way] & inside);
                cover!(s, "a line in the range", was.resident[way] && inside);
                cover!(s, "a line beside it", was.resident[way] && !inside);
                let expected = was.resident[way] && !inside;
                check_eq!(is.resident[way], expected, "{len} bytes at {addr:?} of {before:?}: way {way} of set {set} resident");
            }
            check_eq!((is.lines, is.order), (was.lines, was.order), "{len} bytes at {addr:?} of {before:?}: set {set}");
        }
        check_eq!(directory.counters.invalidated, forgotten, "{len} bytes at {addr:?} of {before:?}: lines forgotten");
    }
}
