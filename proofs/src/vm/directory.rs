//! Theorems of the directory, version A: which line lies where, over all sets (VM-5, VM-6, VM-8).
//!
//! **One set is enough.** An access is the step of its line's set and changes no other: `refinement::directory`.
//! The theorems of the set speak of more ways.
//! Two sets of two ways, so that a wrong set shows, with lines of two bytes, so that a wrong offset
//! does.

use crate::draw::{self, EDGES, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_model::vm::{
    Bytes, CacheConfig, Counters, Directory, Geometry, Hash, HostAddr, LineAddr, Metadata, Outcome, Policy,
    Set, SetIndex,
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

/// Any counts of what has happened before, far from the largest.
pub fn counters(s: &mut impl Source) -> Counters {
    let mut count = || s.value("count before", 0..=u64::MAX >> 1, &COUNTS);
    Counters { accesses: count(), misses: count(), evictions: count(), invalidated: count() }
}

/// Before any carry from the lower bits into the upper.
static COUNTS: [u64; 1] = [u64::MAX >> 2];

/// An address for a step. Small scope: bytes of lines 0 to 5.
pub fn addr(s: &mut impl Source) -> HostAddr {
    draw::addr(s, &[0, 1, 2, 3, 5, 6, 8, 10])
}

/// Length of a range. Small scope: none, less than a line, more than one, more than the card, all.
pub fn len(s: &mut impl Source) -> u64 {
    s.value("bytes", 0..=u64::MAX, &[0, 1, 3, 9, u64::MAX])
}

theorems! {
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

    /// The counters count each access once, and each miss and each eviction that it causes, whatever they have counted
    /// before.
    #["VM-6", unwind 5, covers ["hit", "miss", "eviction"]]
    fn counters_count_each_access(s) {
        let mut directory = directory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let line = draw::line(s, &WORDS[..7]);
        directory.counters = counters(s);
        let was = directory.counters;
        let before = shown!(directory.clone());
        let outcome = directory.access(line);
        let (missed, evicted) = match outcome {
            Outcome::Hit { .. } => (0, 0),
            Outcome::Miss { evicted, .. } => (1, u64::from(evicted.is_some())),
        };
        cover!(s, "hit", missed == 0);
        cover!(s, "miss", missed == 1);
        cover!(s, "eviction", evicted == 1);
        let expected = Counters {
            accesses: was.accesses + 1,
            misses: was.misses + missed,
            evictions: was.evictions + evicted,
            invalidated: was.invalidated,
        };
        check_eq!(directory.counters, expected, "access {line:?} to {before:?}");
        let mut counters = Counters::default();
        counters.count(outcome);
        check_eq!(counters.hits(), 1 - missed, "hits of access {line:?} to {before:?}");
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
        directory.counters = counters(s);
        let mut counters = directory.counters;
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
        counters.invalidated += forgotten;
        check_eq!(directory.counters, counters, "{len} bytes at {addr:?} of {before:?}: lines forgotten");
    }

    /// In a cache of any size, up to 2^32 sets, an access loads and stores the set that the hash names for its line, and no
    /// other.
    #["VM-6", unwind 6, covers ["2^32 sets", "one set", "upper bits"]]
    fn access_meets_the_set_that_the_hash_names(s) {
        let (config, sets) = any_size(s)?;
        let line = draw::line(s, &EDGES);
        let mut directory = Directory::over(config, Asked::default());
        directory.access(line);
        cover!(s, "2^32 sets", sets == 32);
        cover!(s, "one set", sets == 0);
        cover!(s, "upper bits", u64::from(line.0) >> sets != 0);
        let own = Some(config.hash.set_of(line, sets));
        check_eq!(directory.metadata.loaded, [own, None, None, None], "{config:?}: {line:?} loads");
        check_eq!(directory.metadata.stored, own, "{config:?}: {line:?} stores");
    }

    /// In a cache of any size, the invalidation of a range of up to three lines looks for each of its lines in the line's own
    /// set, in order, and nowhere else.
    #["VM-8", unwind 6, covers ["three lines", "the last line of all", "a cache of 2^31 lines or more"]]
    fn invalidation_meets_the_set_of_each_line(s) {
        let (config, sets) = any_size(s)?;
        let addr = draw::addr(s, &EDGES);
        let len = s.value("bytes", 0..=u64::from(u32::MAX), &[0, 1, 2, 3, 129, 0x1_0001]);
        let lines = config.lines_of(addr, len);
        let count = lines.end - lines.start;
        // With as many lines as the cache it would go through the sets instead.
        assume!(count <= 3 && count < 1 << sets);
        let mut directory = Directory::over(config, Asked::default());
        directory.invalidate(addr, len);
        cover!(s, "three lines", count == 3);
        cover!(s, "the last line of all", count > 0 && lines.end << (config.geometry.line().0.trailing_zeros()) == 1 << 32);
        cover!(s, "a cache of 2^31 lines or more", count > 0 && sets >= 31);
        for k in 0..4 {
            let own = config.hash.set_of(LineAddr((lines.start + k as u64) as u32), sets);
            let expected = if (k as u64) < count { Some(own) } else { None };
            check_eq!(directory.metadata.loaded[k], expected, "{config:?}: {len} bytes at {addr:?}: set {k} looked at");
        }
        check_eq!(directory.metadata.stored, None, "{config:?}: {len} bytes at {addr:?}: stored");
    }
}

/// Metadata of any number of empty sets, which keeps the numbers of those that it is asked for.
#[derive(Clone, Debug, Default)]
struct Asked {
    loaded: [Option<SetIndex>; 4],
    count: usize,
    stored: Option<SetIndex>,
}

impl Metadata<1> for Asked {
    fn load(&mut self, index: SetIndex) -> Set<1> {
        for k in 0..4 {
            if k == self.count {
                self.loaded[k] = Some(index);
            }
        }
        self.count += 1;
        Set::empty(Policy::Lru)
    }

    fn store(&mut self, index: SetIndex, _: &Set<1>) {
        self.stored = Some(index);
    }

    fn clear(&mut self) {}
}

/// Any configuration of a cache of one way, and the binary logarithm of its sets.
// Kani: no hash that loops over the groups of a line's bits. Both sides call the same hash.
fn any_size<S: Source>(s: &mut S) -> Result<(CacheConfig, u32), Stop> {
    let line = s.value("log2 line", 0..=32, &WORDS[..33]);
    let sets = s.value("log2 sets", 0..=32, &WORDS[..33]);
    assume!(line + sets <= 32);
    let geometry = draw::of_logarithms(0, line, sets)?;
    Ok((CacheConfig { geometry, hash: crate::equal::directory::hash(s), policy: Policy::Lru }, sets))
}
