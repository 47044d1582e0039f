//! Laws of long runs, which no single step shows: those of LRU, of the hash, and of version B.

mod support;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use quickcheck::{Gen, QuickCheck};
use saarcor_model::vm::{
    Bytes, CacheConfig, CachedMetadata, Directory, Geometry, Hash, HostAddr, LineAddr, Outcome, Policy,
    SetIndex,
};
use saarcor_oracles::cache::NaiveCache;
use std::collections::BTreeSet;
use support::{engine, hashes, policies};

/// Runs of accesses that collide in few sets.
fn runs() -> impl Strategy<Value = Vec<LineAddr>> {
    vec((0..64u32).prop_map(LineAddr), 0..300)
}

fn config(ways: usize, set_bits: u32, hash: Hash, policy: Policy) -> CacheConfig {
    let geometry = Geometry::new(Bytes((ways as u64) << set_bits), Bytes(1), ways as u32).expect("legal");
    CacheConfig { geometry, hash, policy }
}

/// Mattson's inclusion property (1970): of caches with the same sets, the one with more ways holds
/// all that the other holds.
fn more_ways_never_miss_more<const FEW: usize, const MANY: usize>(
    set_bits: u32,
    hash: Hash,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let mut few = Directory::<FEW>::new(config(FEW, set_bits, hash, Policy::Lru));
    let mut many = Directory::<MANY>::new(config(MANY, set_bits, hash, Policy::Lru));
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

/// Stack distance of each access (Mattson 1970): how many other lines of its set were used since
/// its own last use; none at its first.
fn stack_distances(set_of: impl Fn(LineAddr) -> SetIndex, run: &[LineAddr]) -> Vec<Option<usize>> {
    let distance = |now: usize| {
        let before = run[..now].iter().rposition(|&line| line == run[now])?;
        let since = run[before + 1..now].iter().filter(|&&line| set_of(line) == set_of(run[now]));
        Some(since.collect::<BTreeSet<_>>().len())
    };
    (0..run.len()).map(distance).collect()
}

/// LRU hits exactly where the stack distance is less than the number of ways.
fn lru_hits_within_its_ways<const WAYS: usize>(
    set_bits: u32,
    hash: Hash,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let config = config(WAYS, set_bits, hash, Policy::Lru);
    let mut directory = Directory::<WAYS>::new(config);
    for (&line, distance) in run.iter().zip(stack_distances(|line| config.set_of(line), run)) {
        let hit = matches!(directory.access(line), Outcome::Hit { .. });
        prop_assert_eq!(
            hit,
            distance.is_some_and(|distance| distance < WAYS),
            "{:?} at {:?}",
            line,
            distance
        );
    }
    Ok(())
}

/// What happens to a directory.
#[derive(Clone, Copy, Debug)]
enum Use {
    Access(LineAddr),
    Invalidate(HostAddr, u64),
    Flush,
}

fn uses() -> impl Strategy<Value = Vec<Use>> {
    let one = prop_oneof![
        60 => (0..200u32).prop_map(|line| Use::Access(LineAddr(line))),
        3 => (0..200u32, prop_oneof![0..9u64, Just(u64::MAX)]).prop_map(|(a, len)| Use::Invalidate(HostAddr(a), len)),
        1 => Just(Use::Flush),
    ];
    vec(one, 0..600)
}

/// Version B, with a metadata cache of `META_WAYS` ways, against version A, over a whole run.
fn b_is_a<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize>(
    set_bits: u32,
    meta_sets: usize,
    [lines, granules]: [Policy; 2],
    hash: Hash,
    uses: &[Use],
) -> Result<(), TestCaseError> {
    let config = config(WAYS, set_bits, hash, lines);
    let mut a = Directory::<WAYS>::new(config);
    let metadata = CachedMetadata::<WAYS, META_WAYS, GRANULE>::new(&config, meta_sets, granules);
    let mut b = Directory::over(config, metadata);
    for &one in uses {
        match one {
            Use::Access(line) => prop_assert_eq!(a.access(line), b.access(line), "{:?}", line),
            Use::Invalidate(addr, len) => {
                a.invalidate(addr, len);
                b.invalidate(addr, len);
            }
            Use::Flush => {
                a.flush();
                b.flush();
            }
        }
        prop_assert_eq!(a.counters, b.counters, "after {:?}", one);
    }
    for (index, set) in (0..).zip(a.sets()) {
        prop_assert_eq!(b.metadata.entries(SetIndex(index)), set.to_entries(), "set {}", index);
    }
    prop_assert_eq!(b.metadata.observer.corrupt, 0);
    Ok(())
}

/// The metadata cache loads what a naive cache of granules loads: those of the set that is read,
/// then those that change.
fn metadata_traffic_is_the_naive_caches<const GRANULE: usize>(
    set_bits: u32,
    run: &[LineAddr],
) -> Result<(), TestCaseError> {
    let config = config(4, set_bits, Hash::AddUpper, Policy::Lru);
    let mut a = Directory::<4>::new(config);
    let mut b = Directory::over(config, CachedMetadata::<4, 4, GRANULE>::new(&config, 2, Policy::Lru));
    let geometry = Geometry::new(Bytes(8 * GRANULE as u64), Bytes(GRANULE as u64), 4).expect("legal");
    let mut naive = NaiveCache::new(CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru });
    for &line in run {
        let set = config.set_of(line).0 as usize;
        let before = a.sets()[set].to_entries();
        a.access(line);
        b.access(line);
        let after = a.sets()[set].to_entries();
        let byte_granules = |i: usize| ((set * 20 + i) / GRANULE) as u32;
        let read: BTreeSet<_> = (0..20).map(byte_granules).collect();
        let differs = |i: &usize| before.as_flattened()[*i] != after.as_flattened()[*i];
        let written: BTreeSet<_> = (0..20).filter(differs).map(byte_granules).collect();
        for granule in read.into_iter().chain(written) {
            naive.access(LineAddr(granule));
        }
        let (traffic, expected) = (b.metadata.observer, naive.counters());
        prop_assert_eq!(
            (traffic.accesses, traffic.loads),
            (expected.accesses, expected.misses),
            "{:?}",
            line
        );
        prop_assert!(traffic.write_backs <= expected.evictions);
    }
    Ok(())
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn lru_has_the_inclusion_property(set_bits in 0..=3u32, hash in hashes(), run in runs()) {
        more_ways_never_miss_more::<1, 2>(set_bits, hash, &run)?;
        more_ways_never_miss_more::<2, 4>(set_bits, hash, &run)?;
        more_ways_never_miss_more::<4, 8>(set_bits, hash, &run)?;
        more_ways_never_miss_more::<8, 16>(set_bits, hash, &run)?;
    }

    #[test]
    fn lru_hits_by_stack_distance(set_bits in 0..=3u32, hash in hashes(), run in runs()) {
        lru_hits_within_its_ways::<1>(set_bits, hash, &run)?;
        lru_hits_within_its_ways::<4>(set_bits, hash, &run)?;
        lru_hits_within_its_ways::<16>(set_bits, hash, &run)?;
    }

    #[test]
    fn version_b_is_version_a(
        set_bits in 0..=4u32,
        meta_sets in prop_oneof![Just(1usize), Just(2), Just(8)],
        policies in [policies(), policies()],
        hash in hashes(),
        uses in uses(),
    ) {
        b_is_a::<4, 4, 16>(set_bits, meta_sets, policies, hash, &uses)?;
        b_is_a::<4, 1, 8>(set_bits, meta_sets, policies, hash, &uses)?;
        b_is_a::<8, 2, 64>(set_bits, meta_sets, policies, hash, &uses)?;
        b_is_a::<1, 2, 4>(set_bits, meta_sets, policies, hash, &uses)?;
    }

    #[test]
    fn metadata_traffic_is_that_of_a_naive_cache(set_bits in 0..=5u32, run in runs()) {
        metadata_traffic_is_the_naive_caches::<16>(set_bits, &run)?;
        metadata_traffic_is_the_naive_caches::<32>(set_bits, &run)?;
    }
}

/// A block of as many lines as there are sets, a power of two apart: without the hash they share
/// `sets / stride` of the sets, with it they have one each.
#[test]
fn hash_spreads_power_of_two_strides() {
    fn spreads(bits: u8, stride: u8) -> bool {
        let bits = u32::from(bits) % 13;
        let stride_bits = u32::from(stride) % (bits + 1);
        let used = |hash: Hash| {
            let lines = (0..1_u32 << bits).map(|i| LineAddr(i << stride_bits));
            lines.map(|line| hash.set_of(line, bits)).collect::<BTreeSet<_>>().len()
        };
        used(Hash::Low) == 1 << (bits - stride_bits)
            && used(Hash::AddUpper) == 1 << bits
            && used(Hash::AddUpperAll) == 1 << bits
    }
    QuickCheck::new().rng(Gen::from_size_and_seed(100, 2003)).quickcheck(spreads as fn(u8, u8) -> bool);
}
