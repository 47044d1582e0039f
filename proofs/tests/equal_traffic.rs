//! Runs of the twin that counts what accesses cost, `saarcor_fast::traffic`, against the directories step by step: any legal
//! cache and metadata cache, any run of lines with flushes between, handed over in pieces of any length, with and without the
//! vectors of the processor.

use proptest::prelude::*;
use saarcor_fast::directory;
use saarcor_fast::traffic::lanes::Lanes;
use saarcor_fast::traffic::{MetadataCache, Traffic};
use saarcor_fast::version_b::MetadataDecisions;
use saarcor_model::vm::{
    Bytes, CacheConfig, Counters, Directory, Geometry, Hash, LineAddr, MetadataTraffic, Policy,
};

/// Lines to use, and whether all are forgotten afterwards.
type Piece = (Vec<u32>, bool);

/// What a cache counts when `pieces` have been played, step by step.
fn by_steps<const WAYS: usize>(
    config: CacheConfig,
    metadata: Option<MetadataCache>,
    pieces: &[Piece],
) -> (Counters, MetadataTraffic) {
    fn play<const WAYS: usize, M: saarcor_model::vm::Metadata<WAYS>>(
        directory: &mut Directory<WAYS, M>,
        pieces: &[Piece],
    ) {
        for (lines, flush) in pieces {
            for &line in lines {
                directory::access(directory, LineAddr(line));
            }
            if *flush {
                directory.flush();
            }
        }
    }
    let Some(MetadataCache { sets, granule_bytes, policy }) = metadata else {
        let mut directory = Directory::<WAYS>::new(config);
        play(&mut directory, pieces);
        return (directory.counters, MetadataTraffic::default());
    };
    let traffic = MetadataTraffic::default();
    let metadata = MetadataDecisions::<WAYS, 4, _>::new(&config, sets, granule_bytes, policy, traffic);
    let mut directory = Directory::over(config, metadata);
    play(&mut directory, pieces);
    (directory.counters, directory.metadata.observer)
}

fn policy() -> impl Strategy<Value = Policy> {
    prop_oneof![4 => Just(Policy::Lru), 4 => Just(Policy::Fifo), 1 => Just(Policy::Plru)]
}

fn hash() -> impl Strategy<Value = Hash> {
    prop_oneof![Just(Hash::Low), Just(Hash::AddUpper), Just(Hash::AddUpperAll)]
}

/// Caches of up to 2^13 sets, most of them of four ways and small beside the address space as real ones are.
fn cache() -> impl Strategy<Value = CacheConfig> {
    let ways = prop_oneof![6 => Just(2_u32), 1 => 0..=4_u32];
    (ways, 0..=13_u32, 0..=19_u32, hash(), policy()).prop_map(|(ways, sets, line, hash, policy)| {
        let geometry = Geometry::new(Bytes(1 << (ways + sets + line).min(32)), Bytes(1 << line), 1 << ways);
        CacheConfig { geometry: geometry.expect("legal"), hash, policy }
    })
}

fn metadata() -> impl Strategy<Value = MetadataCache> {
    let granule = prop_oneof![6 => (4..=8_u32).prop_map(|bits| 1 << bits), 1 => 1..=300_usize];
    (0..=7_u32, granule, policy()).prop_map(|(sets, granule_bytes, policy)| MetadataCache {
        sets: 1 << sets,
        granule_bytes,
        policy,
    })
}

/// Runs in which lines repeat, follow one another, and come back, in so few sets that these evict.
fn pieces(config: CacheConfig) -> impl Strategy<Value = Vec<Piece>> {
    let all = (1_u64 << 32) / config.geometry.line().0;
    let (sets, few) = (config.geometry.sets(), 1 + config.geometry.sets().min(40));
    let line = (0..few, 0..10_u64).prop_map(move |(low, upper)| ((upper * sets + low) % all) as u32);
    let line = prop_oneof![8 => line, 1 => (0..all).prop_map(|line| line as u32)];
    let run = (line, 1..6_u32, any::<bool>()).prop_map(move |(line, length, same)| {
        let next = move |i| (u64::from(line) + if same { 0 } else { u64::from(i) }) % all;
        (0..length).map(|i| next(i) as u32).collect::<Vec<_>>()
    });
    let lines = prop::collection::vec(run, 0..300).prop_map(|runs| runs.concat());
    prop::collection::vec((lines, prop::bool::weighted(0.2)), 1..4)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    /// Counters and the traffic of the metadata cache are those of the steps, after each piece.
    #[test]
    fn traffic_is_that_of_the_steps(
        (config, pieces) in cache().prop_flat_map(|config| (Just(config), pieces(config))),
        metadata in prop::option::weighted(0.7, metadata()),
        piece_length in 1..700_usize,
    ) {
        let expected = |played: &[Piece]| match config.geometry.ways() {
            1 => by_steps::<1>(config, metadata, played),
            2 => by_steps::<2>(config, metadata, played),
            4 => by_steps::<4>(config, metadata, played),
            8 => by_steps::<8>(config, metadata, played),
            _ => by_steps::<16>(config, metadata, played),
        };
        for lanes in [Lanes::Plain, Lanes::of_processor()] {
            let mut traffic = Traffic::with_lanes(config, metadata, lanes);
            for (i, (lines, flush)) in pieces.iter().enumerate() {
                lines.chunks(piece_length).for_each(|lines| traffic.access(lines));
                let before_flush = [&pieces[..i], &[(lines.clone(), false)]].concat();
                prop_assert_eq!((traffic.counters(), traffic.metadata()), expected(&before_flush), "{:?}", lanes);
                if *flush {
                    traffic.flush();
                }
            }
            prop_assert_eq!((traffic.counters(), traffic.metadata()), expected(&pieces), "{:?}", lanes);
        }
    }
}

#[test]
#[should_panic(expected = "line 0x2000000: lines of 32-bit addresses have numbers below 0x2000000")]
fn no_line_lies_beyond_the_address_space() {
    let geometry = Geometry::new(Bytes(8 << 20), Bytes(128), 4).expect("legal");
    let config = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
    Traffic::of_version_a(config).access(&[0x1ff_ffff, 0x200_0000]);
}
