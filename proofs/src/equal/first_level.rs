//! The twin of the first-level caches that keep no bytes: `saarcor_fast::first_level`.
//!
//! The twin works on the specification's own state: states correspond if they are equal.

use crate::draw::{self, ENDS, WORDS};
use crate::refinement::machine::step_from_any;
use crate::refinement::twins::{Fast, TwinOfFirstLevel};
use crate::source::{Source, Stop};
use crate::vm::directory::counters;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_fast::first_level as fast;
use saarcor_model::vm::{FirstLevel, HostAddr, Outcome, Policy};

const SETS: usize = if cfg!(kani) { 1 } else { 2 };

/// Any legal cache of two ways, without a dirty line: units only read.
fn cache<S: Source>(s: &mut S) -> Result<FirstLevel<2, ()>, Stop> {
    s.size("sets", SETS);
    let policy = draw::policy(s);
    let mut cache = FirstLevel::<2, ()>::new(HostAddr(0), 1, SETS, policy);
    for index in 0..SETS {
        cache.sets[index].set = draw::set_of::<S, 2>(s, policy)?;
    }
    Ok(cache)
}

theorems! {
    /// The first and the last line of a read are those of the specification, with lines of any size, up to
    /// the last byte of the address space.
    // Kani takes lines of 1 and of 8 bytes: its solver has no end of divisions by other numbers.
    #["L1-1", unwind 6, covers ["one line", "two lines", "the end of the address space"]]
    fn fast_first_level_reads_the_same_lines(s) {
        let base = HostAddr(s.value("base", 0..=u32::MAX, &ENDS));
        let addr = draw::addr(s, &ENDS);
        let bytes = s.value("bytes", 1..=u16::MAX, &[1, 2, 3, 36, u16::MAX]);
        let end = u64::from(addr.0) + u64::from(bytes);
        assume!(base <= addr && end <= 1 << 32);
        let any = if cfg!(kani) { 8 } else { s.value("bytes a line", 1..=1 << 16, &[1, 2, 3, 8, 36, 1 << 16]) };
        for line_bytes in [1, any] {
            s.size("bytes a line", line_bytes as usize);
            let lines = FirstLevel::<1, ()>::new(base, line_bytes, 1, Policy::Lru).lines_of(addr, u64::from(bytes));
            let count = lines.end - lines.start;
            cover!(s, "one line", count == 1);
            cover!(s, "two lines", count == 2);
            cover!(s, "the end of the address space", end == 1 << 32);
            let (first, last) = fast::first_and_last_line(base, line_bytes, addr, bytes);
            check_eq!(u64::from(first)..u64::from(last) + 1, lines, "{bytes} bytes at {addr:?}, lines of {line_bytes} from {base:?}");
        }
    }

    /// From any legal first-level cache the twin's look-up and access give the specification's outcome
    /// and leave the specification's sets and counters.
    #["L1-1", unwind 6, covers ["hit", "miss", "eviction"]]
    fn fast_first_level_step_is_the_caches(s) {
        let mut expected = cache(s)?;
        expected.counters = counters(s);
        let mut got = Fast(expected.clone());
        let line = draw::line(s, &WORDS[..4]);
        let (_, outcome) = step_from_any::<TwinOfFirstLevel<2>>(&mut got, &mut expected, &line)?;
        cover!(s, "hit", matches!(outcome, Outcome::Hit { .. }));
        cover!(s, "miss", matches!(outcome, Outcome::Miss { evicted: None, .. }));
        cover!(s, "eviction", matches!(outcome, Outcome::Miss { evicted: Some(_), .. }));
        check!(expected.sets[0].is_valid(expected.policy), "{line:?} used: {expected:?}");
    }

    /// In a first-level cache of up to 512 sets the twin has, and finds, each line in the set that its lower bits name, as
    /// the specification has.
    #["L1-1", not_for_kani "hundreds of sets are too many for it; which set the lower bits name is a theorem of the hash", covers ["the last of 512 sets", "one set"]]
    fn fast_first_level_uses_every_set(s) {
        let sets = 1 << s.value("log2 sets", 0..=9, &WORDS[..10]);
        let mut twin = FirstLevel::<2, ()>::new(HostAddr(0), 4, sets, Policy::Lru);
        let line = draw::line(s, &[0, 1, 63, 64, 127, 255, 256, 511, 0x2000_00ff, u32::MAX]);
        let own = line.0 as usize & (sets - 1);
        cover!(s, "the last of 512 sets", own == 511);
        cover!(s, "one set", sets == 1);
        fast::access(&mut twin, line);
        check!(twin.sets[own].set.way_of(line).is_some(), "{line:?} in set {own} of {sets}");
        check!(fast::is_resident(&twin, line), "{line:?} found in set {own} of {sets}");
    }
}
