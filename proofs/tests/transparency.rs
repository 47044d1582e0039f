//! The virtual memory is transparent (VM-9): whatever is read, in whatever order, through whatever
//! cache, the bytes are the host's. And it is the cache that it says it is: outcomes, places and
//! counters are the naive cache's.

mod support;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{TestCaseError, TestRunner};
use saarcor_model::vm::{
    Bytes, CacheConfig, CachedMetadata, Counters, Directory, FirstLevelCaches, Geometry, HostAddr, LineAddr,
    Memory, Policy, Unit, VirtualMemory,
};
use saarcor_oracles::cache::{NaiveCache, NaiveVirtualMemory};
use saarcor_oracles::flat::FlatMemory;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use support::{engine, hashes, policies};

/// Caches of 1 to 16 ways and lines of 1 to 4096 bytes, with the given binary logarithms of the
/// number of sets.
fn caches(set_bits: RangeInclusive<u32>) -> impl Strategy<Value = CacheConfig> {
    (0..=4u32, 0..=12u32, set_bits, hashes(), policies()).prop_map(|(ways, line, sets, hash, policy)| {
        let geometry = Geometry::new(Bytes(1 << (ways + line + sets)), Bytes(1 << line), 1 << ways)
            .expect("powers of two, and at least one set");
        CacheConfig { geometry, hash, policy }
    })
}

/// Calls a function that is generic over the number of ways: `with_ways!(4, f(a, b))` is
/// `f::<4>(a, b)`.
macro_rules! with_ways {
    ($ways:expr, $function:ident($($argument:expr),*)) => {
        match $ways {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            4 => $function::<4>($($argument),*),
            8 => $function::<8>($($argument),*),
            16 => $function::<16>($($argument),*),
            ways => unreachable!("no cache has {ways} ways"),
        }
    };
}

/// An address by what is special about it; which one it is depends on the cache and the image.
#[derive(Clone, Debug)]
enum Place {
    /// In line `multiple × stride + neighbour`.
    Aliasing { stride: Stride, multiple: u32, neighbour: u32, offset: u32 },
    /// Around the end of the image.
    AroundTheEnd { before: u32, after: u32 },
    /// At the end of the address space.
    AtTheTop { below: u32 },
    /// Anywhere.
    Anywhere { addr: u32 },
}

/// Distances of lines that share a set.
#[derive(Clone, Copy, Debug)]
enum Stride {
    /// The number of sets: lines that the lower bits do not distinguish.
    Sets,
    /// One less: lines whose lower and upper bits have the same sum.
    SetsLessOne,
}

impl Place {
    fn line(&self, config: &CacheConfig, image_len: usize) -> LineAddr {
        LineAddr((u64::from(self.addr(config, image_len).0) / config.geometry.line().0) as u32)
    }

    fn addr(&self, config: &CacheConfig, image_len: usize) -> HostAddr {
        let (sets, line_bytes) = (config.geometry.sets() as u32, config.geometry.line().0 as u32);
        HostAddr(match *self {
            Self::Aliasing { stride, multiple, neighbour, offset } => {
                let stride = match stride {
                    Stride::Sets => sets,
                    Stride::SetsLessOne => sets - 1,
                };
                (multiple * stride + neighbour) * line_bytes + offset % line_bytes
            }
            Self::AroundTheEnd { before, after } => (image_len as u32).saturating_sub(before) + after,
            Self::AtTheTop { below } => u32::MAX - below,
            Self::Anywhere { addr } => addr,
        })
    }
}

fn places() -> impl Strategy<Value = Place> {
    let strides = prop_oneof![Just(Stride::Sets), Just(Stride::SetsLessOne)];
    prop_oneof![
        // More multiples than a set has ways, so that sets of 16 overflow too.
        12 => (strides, 0..24u32, 0..2u32, 0..4096u32)
            .prop_map(|(stride, multiple, neighbour, offset)| Place::Aliasing { stride, multiple, neighbour, offset }),
        3 => (0..300u32, 0..300u32).prop_map(|(before, after)| Place::AroundTheEnd { before, after }),
        1 => (0..300u32).prop_map(|below| Place::AtTheTop { below }),
        1 => any::<u32>().prop_map(|addr| Place::Anywhere { addr }),
    ]
}

/// What happens to a virtual memory.
#[derive(Clone, Debug)]
enum Step {
    /// A unit reads.
    Read { place: Place, len: usize, unit: Unit },
    /// The application writes to host memory and says so.
    Write { place: Place, bytes: Vec<u8> },
    /// The application writes to host memory and does not say so.
    SilentWrite { place: Place, bytes: Vec<u8> },
    /// The application says that it wrote, and did not.
    Invalidate { place: Place, len: u64 },
}

fn steps(silent_writes: u32) -> impl Strategy<Value = Vec<Step>> {
    let bytes = || vec(any::<u8>(), 1..64);
    let ports =
        prop_oneof![Just(Unit::Shading), Just(Unit::Traversal), Just(Unit::List), Just(Unit::Intersection)];
    let step = prop_oneof![
        20 => (places(), 1..=300usize, ports).prop_map(|(place, len, unit)| Step::Read { place, len, unit }),
        2 => (places(), bytes()).prop_map(|(place, bytes)| Step::Write { place, bytes }),
        2 => (places(), 0..10_000u64).prop_map(|(place, len)| Step::Invalidate { place, len }),
        silent_writes => (places(), bytes()).prop_map(|(place, bytes)| Step::SilentWrite { place, bytes }),
    ];
    vec(step, 0..120)
}

/// Images of any length: none, odd ones, and ones that a small cache holds a part of.
fn images() -> impl Strategy<Value = Vec<u8>> {
    (prop_oneof![Just(0..1usize), Just(1..600), Just(600..70_000)], any::<u64>()).prop_flat_map(
        |(lengths, seed)| {
            lengths.prop_map(move |len| {
                // Multiplication by an odd number spreads the seed over all bytes of the image: no
                // two neighbouring lines are alike.
                (0..len as u64)
                    .map(|i| ((i ^ seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as u8)
                    .collect()
            })
        },
    )
}

/// Writes as much of `bytes` as falls into the image.
fn write(image: &mut [u8], addr: HostAddr, bytes: &[u8]) {
    for (slot, byte) in image.iter_mut().skip(addr.0 as usize).zip(bytes) {
        *slot = *byte;
    }
}

/// Plays `steps` on the model, on flat memory and on the naive virtual memory.
fn play<const WAYS: usize>(
    config: CacheConfig,
    image: &[u8],
    steps: &[Step],
) -> Result<Counters, TestCaseError> {
    let mut host = image.to_vec();
    let mut memory = VirtualMemory::new(Directory::<WAYS>::new(config), image.to_vec());
    let mut naive = NaiveVirtualMemory::new(config);
    // The whole of it: first-level caches of a few sets, over version B with a small metadata cache.
    let version_b = CachedMetadata::<WAYS, 4, 16>::new(&config, 2, Policy::Lru);
    let below = VirtualMemory::new(Directory::over(config, version_b), image.to_vec());
    let mut hierarchy = FirstLevelCaches::new([1, 4, 2, 2], config.policy, HostAddr(50), below);
    let mut coherent = true;
    for step in steps {
        let (Step::Read { place, .. }
        | Step::Write { place, .. }
        | Step::SilentWrite { place, .. }
        | Step::Invalidate { place, .. }) = step;
        let addr = place.addr(&config, image.len());
        match step {
            Step::Read { len, unit, .. } => {
                // Not zero beforehand: bytes beyond the end have to be written too.
                let mut bytes = vec![0xa5; *len];
                memory.read(*unit, addr, &mut bytes);
                if coherent {
                    let mut flat = vec![0x5a; *len];
                    FlatMemory::new(&host).read(*unit, addr, &mut flat);
                    prop_assert_eq!(&bytes, &flat, "at {:?}", addr);
                    let mut through_l1 = vec![0x3c; *len];
                    hierarchy.read(*unit, addr, &mut through_l1);
                    prop_assert_eq!(&through_l1, &flat, "{:?} at {:?} through all caches", unit, addr);
                }
                prop_assert_eq!(bytes, naive.read(&host, addr, *len), "at {:?}", addr);
            }
            Step::Write { bytes, .. } => {
                write(&mut host, addr, bytes);
                write(&mut memory.host, addr, bytes);
                memory.invalidate(addr, bytes.len() as u64);
                naive.invalidate(addr, bytes.len() as u64);
                write(&mut hierarchy.below.host, addr, bytes);
                hierarchy.below.invalidate(addr, bytes.len() as u64);
                hierarchy.invalidate(addr, bytes.len() as u64);
            }
            Step::SilentWrite { bytes, .. } => {
                write(&mut host, addr, bytes);
                write(&mut memory.host, addr, bytes);
                coherent = false;
            }
            Step::Invalidate { len, .. } => {
                memory.invalidate(addr, *len);
                naive.invalidate(addr, *len);
                hierarchy.below.invalidate(addr, *len);
                hierarchy.invalidate(addr, *len);
            }
        }
        prop_assert_eq!(memory.directory.counters, naive.cache().counters(), "after {:?}", step);
    }
    same_contents(&memory.directory, naive.cache())?;
    Ok(memory.directory.counters)
}

/// Every set holds the same lines in the same ways.
fn same_contents<const WAYS: usize>(
    directory: &Directory<WAYS>,
    naive: &NaiveCache,
) -> Result<(), TestCaseError> {
    for (index, set) in (0..).zip(directory.sets()) {
        let slots: Vec<_> = (0..WAYS).map(|way| set.resident[way].then_some(set.lines[way])).collect();
        prop_assert_eq!(slots, naive.slots(index), "set {}", index);
    }
    Ok(())
}

/// What happens to a directory.
#[derive(Clone, Debug)]
enum Use {
    Access { place: Place },
    Invalidate { place: Place, len: u64 },
    Flush,
}

fn uses() -> impl Strategy<Value = Vec<Use>> {
    let one = prop_oneof![
        60 => places().prop_map(|place| Use::Access { place }),
        4 => (places(), 0..10_000u64).prop_map(|(place, len)| Use::Invalidate { place, len }),
        1 => Just(Use::Flush),
    ];
    vec(one, 0..300)
}

/// Plays `uses` on the model's directory and on the naive cache.
fn use_directory<const WAYS: usize>(config: CacheConfig, uses: &[Use]) -> Result<Counters, TestCaseError> {
    let mut directory = Directory::<WAYS>::new(config);
    let mut naive = NaiveCache::new(config);
    for one in uses {
        match one {
            Use::Access { place } => {
                let line = place.line(&config, 0);
                prop_assert_eq!(directory.access(line), naive.access(line), "{:?}", line);
            }
            Use::Invalidate { place, len } => {
                let addr = place.addr(&config, 0);
                directory.invalidate(addr, *len);
                naive.invalidate(addr, *len);
            }
            Use::Flush => {
                directory.flush();
                naive.flush();
            }
        }
        prop_assert_eq!(directory.counters, naive.counters(), "after {:?}", one);
    }
    same_contents(&directory, &naive)?;
    Ok(directory.counters)
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn bytes_are_the_hosts(config in caches(0..=5), image in images(), steps in steps(0)) {
        with_ways!(config.geometry.ways(), play(config, &image, &steps))?;
    }

    /// A resident line is not read again: what the application does not announce is not seen.
    #[test]
    fn bytes_are_as_of_the_load(config in caches(0..=5), image in images(), steps in steps(3)) {
        with_ways!(config.geometry.ways(), play(config, &image, &steps))?;
    }

    #[test]
    fn outcomes_are_the_naive_caches(config in caches(0..=9), uses in uses()) {
        with_ways!(config.geometry.ways(), use_directory(config, &uses))?;
    }
}

/// The strategies above reach what they are for: with every number of ways lines are hit, loaded,
/// evicted and forgotten.
#[test]
fn strategies_reach_every_outcome() {
    let mut runner = TestRunner::new(engine());
    let strategy = (caches(0..=5), images(), steps(0), uses());
    let mut reached = BTreeMap::<u32, [Counters; 2]>::new();
    for _ in 0..engine().cases {
        let (config, image, steps, uses) =
            strategy.new_tree(&mut runner).expect("nothing is rejected").current();
        let ways = config.geometry.ways();
        let [played, used] = reached.entry(ways).or_default();
        add(played, with_ways!(ways, play(config, &image, &steps)).expect("transparent"));
        add(used, with_ways!(ways, use_directory(config, &uses)).expect("like the naive cache"));
    }
    assert_eq!(reached.keys().copied().collect::<Vec<_>>(), [1, 2, 4, 8, 16]);
    for (ways, counters) in reached.iter().flat_map(|(ways, both)| both.iter().map(move |one| (ways, one))) {
        let Counters { accesses: _, misses, evictions, invalidated } = *counters;
        assert!(
            [counters.hits(), misses, evictions, invalidated].iter().all(|&n| n > 100),
            "{ways} ways: {counters:?}"
        );
    }
}

fn add(sum: &mut Counters, counters: Counters) {
    sum.accesses += counters.accesses;
    sum.misses += counters.misses;
    sum.evictions += counters.evictions;
    sum.invalidated += counters.invalidated;
}
