//! The laws of the units of the virtual memory, each in a few lines.

mod support;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use quickcheck::{Arbitrary, Gen, QuickCheck, Testable};
use saarcor_model::geometry::{Geometry, MAX_WAYS};
use saarcor_model::hash::Hash;
use saarcor_model::set::{Outcome, Policy, Set};
use saarcor_model::units::{Bytes, HostAddr, LineAddr, SetIndex, Way};
use saarcor_model::vm::{CacheConfig, Directory};
use std::collections::BTreeSet;
use support::{caches, engine, hashes, policies};

// Geometry and hash: one line each.

/// Judges a law on the same values in every run; `QUICKCHECK_TESTS` asks for more of them.
fn law(law: impl Testable) {
    QuickCheck::new().rng(Gen::from_size_and_seed(100, 2003)).quickcheck(law);
}

/// Any legal geometry, given by the binary logarithms of its sizes.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    way_bits: u32,
    line_bits: u32,
    set_bits: u32,
}

impl Arbitrary for Sizes {
    fn arbitrary(g: &mut Gen) -> Self {
        let mut up_to = |most: u32| u32::arbitrary(g) % (most + 1);
        let way_bits = up_to(MAX_WAYS.ilog2());
        let line_bits = up_to(32 - way_bits);
        let set_bits = up_to(32 - way_bits - line_bits);
        Self { way_bits, line_bits, set_bits }
    }
}

impl Sizes {
    fn geometry(self) -> Geometry {
        let memory = Bytes(1 << (self.way_bits + self.line_bits + self.set_bits));
        Geometry::new(memory, Bytes(1 << self.line_bits), 1 << self.way_bits).expect("legal sizes")
    }
}

#[derive(Clone, Copy, Debug)]
struct AnyHash(Hash);

impl Arbitrary for AnyHash {
    fn arbitrary(g: &mut Gen) -> Self {
        Self(*g.choose(&[Hash::Low, Hash::AddUpper, Hash::AddUpperAll]).expect("not empty"))
    }
}

#[test]
fn geometry_is_what_was_asked_for() {
    law((|s: Sizes| {
        let g = s.geometry();
        (g.ways(), g.line(), g.sets()) == (1 << s.way_bits, Bytes(1 << s.line_bits), 1 << s.set_bits)
            && u128::from(g.memory().0)
                == u128::from(g.sets()) * u128::from(g.ways()) * u128::from(g.line().0)
            && g.lines() == g.sets() * u64::from(g.ways())
    }) as fn(_) -> _);
}

/// Judged for all sizes around powers of two up to beyond the limits.
#[test]
fn geometry_takes_exactly_the_powers_of_two() {
    // 2ⁿ - 1, 2ⁿ and 2ⁿ + 1; the least is 0.
    let sizes = |exponents: u32| (0..exponents).flat_map(|n| (1u64 << n) - 1..=(1 << n) + 1);
    for memory in sizes(35) {
        for line in sizes(35) {
            for ways in sizes(7) {
                let legal = [memory, line, ways].iter().all(|n| n.count_ones() == 1)
                    && memory <= 1 << 32
                    && ways <= u64::from(MAX_WAYS)
                    && line * ways <= memory;
                let geometry = Geometry::new(Bytes(memory), Bytes(line), ways as u32);
                assert_eq!(geometry.is_ok(), legal, "{memory} bytes, lines of {line}, {ways} ways");
            }
        }
    }
}

#[test]
fn metadata_is_five_bytes_a_line() {
    law((|s: Sizes| s.geometry().metadata().0 == 5 * s.geometry().memory().0 / s.geometry().line().0)
        as fn(_) -> _);
}

#[test]
fn metadata_grows_with_the_memory_and_shrinks_with_the_line() {
    law((|s: Sizes| {
        let metadata = |memory: u64, line: u64| {
            Geometry::new(Bytes(memory), Bytes(line), 1).expect("legal sizes").metadata()
        };
        let (memory, line) = (s.geometry().memory().0, s.geometry().line().0);
        (memory == 1 << 32 || metadata(2 * memory, line) > metadata(memory, line))
            && (line == memory || metadata(memory, 2 * line) < metadata(memory, line))
    }) as fn(_) -> _);
}

#[test]
fn line_and_offset_make_the_address() {
    law((|s: Sizes, addr: u32| {
        let (g, addr) = (s.geometry(), HostAddr(addr));
        let (line, offset) = (g.line_of(addr), g.offset_of(addr));
        u64::from(offset) < g.line().0
            && g.first_byte(line).0.checked_add(offset) == Some(addr.0)
            && u64::from(line.0) == u64::from(addr.0) / g.line().0
    }) as fn(_, _) -> _);
}

#[test]
fn first_byte_is_its_lines() {
    law((|s: Sizes, addr: u32| {
        let g = s.geometry();
        let first = g.first_byte(g.line_of(HostAddr(addr)));
        g.line_of(first) == g.line_of(HostAddr(addr)) && g.offset_of(first) == 0
    }) as fn(_, _) -> _);
}

#[test]
fn lines_on_the_card_do_not_overlap() {
    law((|s: Sizes, a: (u32, u8), b: (u32, u8)| {
        let g = s.geometry();
        let place = |(set, way): (u32, u8)| {
            let (set, way) = (u64::from(set) % g.sets(), u32::from(way) % g.ways());
            (SetIndex(set as u32), Way(way as u8))
        };
        // Neighbours of `a` are the likeliest to overlap it.
        [b, (a.0, b.1), (a.0.wrapping_add(1), b.1), (b.0, a.1)].iter().all(|&b| {
            let (a, b) = (place(a), place(b));
            let (at_a, at_b) = (g.card_addr(a.0, a.1).0, g.card_addr(b.0, b.1).0);
            let apart = u64::from(at_a.abs_diff(at_b)) >= g.line().0;
            (apart || a == b) && u64::from(at_a) + g.line().0 <= g.memory().0
        })
    }) as fn(_, _, _) -> _);
}

#[test]
fn hash_names_a_set() {
    law((|h: AnyHash, line: u32, bits: u32| {
        u64::from(h.0.set_of(LineAddr(line), bits % 33).0) < 1 << (bits % 33)
    }) as fn(_, _, _) -> _);
}

/// Lines that follow one another, from a multiple of the number of sets on, fill all sets evenly.
#[test]
fn hash_is_bijective_on_aligned_blocks() {
    law((|h: AnyHash, block: u32, bits: u32| {
        let bits = bits % 9;
        let first = block >> bits << bits;
        let sets: BTreeSet<_> = (0..1 << bits).map(|i| h.0.set_of(LineAddr(first + i), bits)).collect();
        sets.len() == 1 << bits
    }) as fn(_, _, _) -> _);
}

#[test]
fn hashes_agree_where_there_are_no_upper_bits() {
    law((|h: AnyHash, line: u32, bits: u32| {
        let bits = bits % 32;
        let line = line & ((1 << bits) - 1);
        h.0.set_of(LineAddr(line), bits) == SetIndex(line)
    }) as fn(_, _, _) -> _);
}

// One set: a step from any legal state.

/// What legal states of sets of any number of ways are made of.
#[derive(Clone, Debug)]
struct State {
    policy: Policy,
    ways: usize,
    ages: Vec<u8>,
    bits: Vec<u8>,
    lines: Vec<u32>,
    resident: Vec<bool>,
    /// What a free way still holds of a line that was there.
    left_over: u32,
}

/// The lines in use: more than a set of 16 ways holds.
const LINES: u32 = 24;

fn states() -> impl Strategy<Value = State> {
    let ways = prop_oneof![Just(1usize), Just(2), Just(4), Just(8), Just(16)];
    (policies(), ways).prop_flat_map(|(policy, ways)| {
        (
            Just((0..ways as u8).collect::<Vec<_>>()).prop_shuffle(),
            vec(0..2u8, ways),
            Just((0..LINES.min(2 * ways as u32)).collect::<Vec<_>>()).prop_shuffle(),
            prop_oneof![Just(vec![true; ways]), vec(any::<bool>(), ways)],
            0..LINES,
        )
            .prop_map(move |(ages, mut bits, lines, resident, left_over)| {
                bits[0] = 0;
                State { policy, ways, ages, bits, lines, resident, left_over }
            })
    })
}

/// A line, often one that is in use in a set of that many ways.
fn lines() -> impl Strategy<Value = LineAddr> {
    prop_oneof![4 => 0..4u32, 4 => 0..LINES, 1 => any::<u32>()].prop_map(LineAddr)
}

impl State {
    fn set<const WAYS: usize>(&self) -> Set<WAYS> {
        let set = Set {
            lines: std::array::from_fn(|way| {
                LineAddr(if self.resident[way] { self.lines[way] } else { self.left_over })
            }),
            resident: std::array::from_fn(|way| self.resident[way]),
            order: std::array::from_fn(|way| match self.policy {
                Policy::Lru | Policy::Fifo => self.ages[way],
                Policy::Plru => self.bits[way],
            }),
        };
        assert!(set.is_valid(self.policy), "a legal state is what the strategy makes: {set:?}");
        set
    }
}

/// The resident lines, and the way of each.
fn contents<const WAYS: usize>(set: &Set<WAYS>) -> BTreeSet<(LineAddr, usize)> {
    (0..WAYS).filter(|&way| set.resident[way]).map(|way| (set.lines[way], way)).collect()
}

fn holds<const WAYS: usize>(set: &Set<WAYS>, line: LineAddr) -> bool {
    contents(set).iter().any(|&(resident, _)| resident == line)
}

fn access_keeps_invariant<const WAYS: usize>(state: &State, line: LineAddr) -> Result<(), TestCaseError> {
    let (after, _) = state.set::<WAYS>().access(line, state.policy);
    prop_assert!(after.is_valid(state.policy), "{:?}", after);
    Ok(())
}

fn invalidation_keeps_invariant<const WAYS: usize>(
    state: &State,
    line: LineAddr,
) -> Result<(), TestCaseError> {
    let (after, _) = state.set::<WAYS>().invalidate(line);
    prop_assert!(after.is_valid(state.policy), "{:?}", after);
    Ok(())
}

/// What breaks the invariant is told from what keeps it.
fn invariant_rejects_illegal_states<const WAYS: usize>(
    state: &State,
    line: LineAddr,
) -> Result<(), TestCaseError> {
    let way = line.0 as usize % WAYS;
    let other = (way + 1) % WAYS;
    let broken = |edit: &dyn Fn(&mut Set<WAYS>)| {
        let mut set = state.set::<WAYS>();
        edit(&mut set);
        !set.is_valid(state.policy)
    };
    let twice = |set: &mut Set<WAYS>| {
        set.lines[other] = set.lines[way];
        (set.resident[way], set.resident[other]) = (true, true);
    };
    prop_assert!(WAYS == 1 || broken(&twice), "a line resident twice");
    if state.policy == Policy::Plru {
        prop_assert!(broken(&|set| set.order[0] = 1), "a node above the root");
        prop_assert!(broken(&|set| set.order[way] = 2), "a bit of 2");
    } else {
        prop_assert!(WAYS == 1 || broken(&|set| set.order[other] = set.order[way]), "a way twice");
        prop_assert!(broken(&|set| set.order[way] = WAYS as u8), "a way that is none");
    }
    Ok(())
}

fn hit_iff_resident<const WAYS: usize>(state: &State, line: LineAddr) -> Result<(), TestCaseError> {
    let before = state.set::<WAYS>();
    let (_, outcome) = before.access(line, state.policy);
    prop_assert_eq!(matches!(outcome, Outcome::Hit { .. }), holds(&before, line));
    Ok(())
}

fn accessed_line_is_resident<const WAYS: usize>(state: &State, line: LineAddr) -> Result<(), TestCaseError> {
    let (after, outcome) = state.set::<WAYS>().access(line, state.policy);
    let way = usize::from(outcome.way().0);
    prop_assert_eq!((after.resident[way], after.lines[way]), (true, line));
    prop_assert_eq!(after.way_of(line), Some(outcome.way()));
    Ok(())
}

fn same_line_again_hits_and_changes_nothing<const WAYS: usize>(
    state: &State,
    line: LineAddr,
) -> Result<(), TestCaseError> {
    let (after, outcome) = state.set::<WAYS>().access(line, state.policy);
    prop_assert_eq!(after.access(line, state.policy), (after, Outcome::Hit { way: outcome.way() }));
    Ok(())
}

fn other_lines_stay<const WAYS: usize>(state: &State, line: LineAddr) -> Result<(), TestCaseError> {
    let before = state.set::<WAYS>();
    let (after, outcome) = before.access(line, state.policy);
    let mut expected = contents(&before);
    let way = usize::from(outcome.way().0);
    if let Outcome::Miss { evicted, .. } = outcome {
        if let Some(evicted) = evicted {
            prop_assert!(expected.remove(&(evicted, way)), "{:?} was not in {:?}", evicted, way);
        }
        expected.insert((line, way));
    }
    prop_assert_eq!(contents(&after), expected);
    Ok(())
}

fn free_way_before_victim<const WAYS: usize>(state: &State, line: LineAddr) -> Result<(), TestCaseError> {
    let before = state.set::<WAYS>();
    if let (_, Outcome::Miss { way, evicted }) = before.access(line, state.policy) {
        let free = before.resident.iter().position(|resident| !resident);
        prop_assert_eq!(evicted.is_none(), free.is_some());
        prop_assert!(free.is_none_or(|free| free == usize::from(way.0)));
    }
    Ok(())
}

/// The victim is the oldest, and what is loaded the youngest; a hit makes its line the youngest
/// with LRU, and changes nothing with FIFO.
fn ages_are_those_of_the_policy<const WAYS: usize>(
    state: &State,
    line: LineAddr,
) -> Result<(), TestCaseError> {
    let before = state.set::<WAYS>();
    let (after, outcome) = before.access(line, state.policy);
    let age = |set: &Set<WAYS>| set.order.iter().position(|&way| way == outcome.way().0).expect("legal");
    match (state.policy, outcome) {
        (Policy::Plru, _) => {}
        (Policy::Fifo, Outcome::Hit { .. }) => prop_assert_eq!(after, before),
        (_, Outcome::Miss { evicted: Some(_), .. }) => {
            prop_assert_eq!((age(&before), age(&after)), (WAYS - 1, 0));
        }
        _ => prop_assert_eq!(age(&after), 0),
    }
    // All others keep their order among each other.
    if state.policy != Policy::Plru {
        let others = |set: &Set<WAYS>| {
            set.order.iter().copied().filter(|&way| way != outcome.way().0).collect::<Vec<_>>()
        };
        prop_assert_eq!(others(&after), others(&before));
    }
    Ok(())
}

/// Tree-PLRU is not LRU, but it never gives up what was used last.
fn plru_keeps_the_last_used<const WAYS: usize>(state: &State, line: LineAddr) -> Result<(), TestCaseError> {
    if state.policy != Policy::Plru {
        return Ok(());
    }
    let (after, _) = state.set::<WAYS>().access(line, Policy::Plru);
    let (_, next) = after.access(LineAddr(!line.0), Policy::Plru);
    if let Outcome::Miss { evicted: Some(evicted), .. } = next {
        prop_assert!(WAYS == 1 || evicted != line);
    }
    Ok(())
}

fn invalidation_forgets_one_line<const WAYS: usize>(
    state: &State,
    line: LineAddr,
) -> Result<(), TestCaseError> {
    let before = state.set::<WAYS>();
    let (after, way) = before.invalidate(line);
    prop_assert_eq!(way, before.way_of(line));
    prop_assert_eq!(after.way_of(line), None);
    let mut expected = contents(&before);
    expected.retain(|&(resident, _)| resident != line);
    prop_assert_eq!(contents(&after), expected);
    prop_assert_eq!(after.order, before.order);
    Ok(())
}

/// Makes a test of each law of a step.
macro_rules! step_laws {
    ($($law:ident),* $(,)?) => {
        mod step {
            use super::{engine, lines, states};
            use proptest::prelude::*;
            proptest! {
                #![proptest_config(engine())]
                $(
                    #[test]
                    fn $law(state in states(), line in lines()) {
                        use super::$law as law;
                        crate::with_ways!(state.ways, law(&state, line))?;
                    }
                )*
            }
        }
    };
}

step_laws!(
    invariant_rejects_illegal_states,
    access_keeps_invariant,
    invalidation_keeps_invariant,
    hit_iff_resident,
    accessed_line_is_resident,
    same_line_again_hits_and_changes_nothing,
    other_lines_stay,
    free_way_before_victim,
    ages_are_those_of_the_policy,
    plru_keeps_the_last_used,
    invalidation_forgets_one_line,
);

// The whole directory: any run.

/// Runs of accesses that collide in few sets.
fn runs() -> impl Strategy<Value = Vec<LineAddr>> {
    vec((0..64u32).prop_map(LineAddr), 0..300)
}

fn counters_are_consistent<const WAYS: usize>(
    config: CacheConfig,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let mut directory = Directory::<WAYS>::new(config);
    for (i, &line) in run.iter().enumerate() {
        directory.access(line);
        if i % 17 == 16 {
            directory.invalidate(config.geometry.first_byte(run[i / 2]), 1);
        }
    }
    let counters = directory.counters;
    let resident: usize = directory.sets().iter().map(|set| contents(set).len()).sum();
    prop_assert_eq!(counters.accesses, run.len() as u64);
    prop_assert_eq!(counters.misses, counters.evictions + counters.invalidated + resident as u64);
    Ok(())
}

fn access_changes_its_own_set<const WAYS: usize>(
    config: CacheConfig,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let mut directory = Directory::<WAYS>::new(config);
    for &line in run {
        let before = directory.sets().to_vec();
        directory.access(line);
        let own = config.set_of(line).0 as usize;
        for (index, (before, after)) in before.iter().zip(directory.sets()).enumerate() {
            prop_assert!(index == own || before == after, "set {} of line {:?}", index, line);
        }
    }
    Ok(())
}

fn invalidation_forgets_the_range<const WAYS: usize>(
    config: CacheConfig,
    run: &[LineAddr],
    addr: HostAddr,
    len: u64,
) -> Result<(), TestCaseError> {
    let mut directory = Directory::<WAYS>::new(config);
    for &line in run {
        directory.access(line);
    }
    let before = resident_lines(&directory);
    directory.invalidate(addr, len);
    let range = config.lines_of(addr, len);
    let (gone, kept): (Vec<_>, _) = before.into_iter().partition(|line| range.contains(&u64::from(line.0)));
    prop_assert_eq!(resident_lines(&directory), kept);
    prop_assert_eq!(directory.counters.invalidated, gone.len() as u64);
    Ok(())
}

/// All lines that a cache holds, set by set.
fn resident_lines<const WAYS: usize>(directory: &Directory<WAYS>) -> Vec<LineAddr> {
    directory.sets().iter().flat_map(contents).map(|(line, _)| line).collect()
}

fn flush_makes_a_new_directory<const WAYS: usize>(
    config: CacheConfig,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let mut directory = Directory::<WAYS>::new(config);
    for &line in run {
        directory.access(line);
    }
    let counters = directory.counters;
    directory.flush();
    prop_assert_eq!(directory.counters, counters);
    let new = Directory::<WAYS>::new(config);
    prop_assert_eq!(directory.sets(), new.sets());
    Ok(())
}

/// Mattson's inclusion property (1970): of caches with the same sets, the one with more ways holds
/// all that the other holds.
fn more_ways_never_miss_more<const FEW: usize, const MANY: usize>(
    set_bits: u32,
    hash: Hash,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let config = |ways: usize| CacheConfig {
        geometry: Geometry::new(Bytes((ways as u64) << set_bits), Bytes(1), ways as u32).expect("legal"),
        hash,
        policy: Policy::Lru,
    };
    let mut few = Directory::<FEW>::new(config(FEW));
    let mut many = Directory::<MANY>::new(config(MANY));
    for &line in run {
        let (few, many) = (few.access(line), many.access(line));
        if let Outcome::Hit { .. } = few {
            prop_assert!(
                matches!(many, Outcome::Hit { .. }),
                "{} ways hit {:?}, {} miss it",
                FEW,
                line,
                MANY
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn counters_add_up(config in caches(0..=4), run in runs()) {
        with_ways!(config.geometry.ways(), counters_are_consistent(config, &run))?;
    }

    #[test]
    fn access_leaves_other_sets_alone(config in caches(0..=4), run in runs()) {
        with_ways!(config.geometry.ways(), access_changes_its_own_set(config, &run))?;
    }

    #[test]
    fn invalidated_ranges_are_gone(
        config in caches(0..=4),
        run in runs(),
        addr in 0..20_000u32,
        len in prop_oneof![0..2_000u64, Just(u64::from(u32::MAX)), Just(u64::MAX)],
    ) {
        let addr = HostAddr(addr);
        with_ways!(config.geometry.ways(), invalidation_forgets_the_range(config, &run, addr, len))?;
    }

    #[test]
    fn flushed_is_new(config in caches(0..=4), run in runs()) {
        with_ways!(config.geometry.ways(), flush_makes_a_new_directory(config, &run))?;
    }

    #[test]
    fn lru_has_the_inclusion_property(set_bits in 0..=3u32, hash in hashes(), run in runs()) {
        more_ways_never_miss_more::<1, 2>(set_bits, hash, &run)?;
        more_ways_never_miss_more::<2, 4>(set_bits, hash, &run)?;
        more_ways_never_miss_more::<4, 8>(set_bits, hash, &run)?;
        more_ways_never_miss_more::<8, 16>(set_bits, hash, &run)?;
    }

    /// The lines of a range are those of its bytes.
    #[test]
    fn lines_of_a_range_are_those_of_its_bytes(
        config in caches(0..=0),
        addr in prop_oneof![0..10_000u32, (0..300u32).prop_map(|below| u32::MAX - below)],
        len in 0..500u64,
    ) {
        let bytes = (u64::from(addr)..).take(len as usize).filter_map(|byte| u32::try_from(byte).ok());
        let line_of = |byte| u64::from(config.geometry.line_of(HostAddr(byte)).0);
        let expected: BTreeSet<_> = bytes.map(line_of).collect();
        let lines: Vec<_> = config.lines_of(HostAddr(addr), len).collect();
        prop_assert_eq!(lines, expected.into_iter().collect::<Vec<_>>());
    }
}
