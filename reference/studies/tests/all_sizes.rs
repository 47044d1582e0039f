//! Many virtual memories that see the same reads: each counts what it would alone, and what a naive cache says.

use proptest::collection::vec;
use proptest::prelude::*;
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, LineAddr, Outcome, Policy};
use saarcor_oracles::cache::NaiveCache;
use saarcor_studies::caches::{Caches, FrameCounts};
use saarcor_studies::monitor::Silent;
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::walk::{Walk, WalkOptions};
use saarcor_studies::world::{World, WorldOptions};
use std::collections::BTreeSet;

fn config(memory: u64, line: u64, ways: u32, hash: Hash, policy: Policy) -> CacheConfig {
    CacheConfig { geometry: Geometry::new(Bytes(memory), Bytes(line), ways).expect("legal"), hash, policy }
}

/// The sizes that `saarcor walk --all` plays, by a policy.
fn all(policy: Policy) -> Vec<CacheConfig> {
    let mut configs = Vec::new();
    for line in [64, 128, 256] {
        for ways in [1, 2, 4, 8, 16] {
            for log2 in 20..=26 {
                configs.push(config(1 << log2, line, ways, Hash::AddUpper, policy));
            }
        }
    }
    configs
}

/// Two frames of a real scene, by LRU and by FIFO: 105 caches at once, 24 of them alone.
#[test]
fn real_frames_load_in_all_sizes_what_they_load_in_each() {
    let world = World::open(&WorldOptions::new("pquake3-nt"), &Silent).expect("built-in");
    let trace = TraceOptions { resolution: (320, 240), packet: PacketSize::Rays64, max_bounces: 3 };
    for policy in [Policy::Lru, Policy::Fifo] {
        let configs = all(policy);
        let options = |cache| WalkOptions { cache, cold: false, trace };
        let frames = || [150, 151].into_iter();
        let mut walk = Walk::with_others(&world, frames(), &options(configs[0]), &configs[1..]);
        let rows: Vec<_> = std::iter::from_fn(|| walk.next_of_each()).collect();
        for place in (0..configs.len()).step_by(9) {
            let alone: Vec<_> = Walk::new(&world, frames(), &options(configs[place])).collect();
            let at_once: Vec<_> = rows.iter().map(|rows| rows[place]).collect();
            assert_eq!(at_once, alone, "{:?}", configs[place]);
        }
        let loads: BTreeSet<_> = rows[0].iter().map(|row| row.loaded_bytes).collect();
        assert!(loads.len() > 5, "sizes differ in what they load: {loads:?}");
    }
}

/// What a naive cache does in frames; that of the line it is asked for was resident is looked up in its sets.
fn naive(config: CacheConfig, frames: &[(bool, Vec<(u32, u32)>)]) -> Vec<FrameCounts> {
    let mut cache = NaiveCache::new(config);
    let mut counts = Vec::new();
    for (cold, reads) in frames {
        if *cold {
            cache.flush();
        }
        let sets = 0..config.geometry.sets();
        let mut resident: BTreeSet<LineAddr> = sets.flat_map(|set| cache.slots(set)).flatten().collect();
        let (mut touched, mut count) = (BTreeSet::new(), FrameCounts::default());
        for &(addr, bytes) in reads {
            let line_bytes = config.geometry.line().0 as u32;
            for line in addr / line_bytes..=(addr + bytes - 1) / line_bytes {
                let line = LineAddr(line);
                count.accesses += 1;
                touched.insert(line);
                if let Outcome::Miss { .. } = cache.access(line) {
                    count.loaded += 1;
                    count.collisions += u64::from(!resident.insert(line));
                }
            }
        }
        count.working_set = touched.len() as u64;
        counts.push(count);
    }
    counts
}

/// Bytes of the host here.
const HOST: u32 = 4096;

prop_compose! {
    fn any_config()(
        line in 0..=6_u32, ways in 0..=4_u32, sets in 0..=4_u32,
        hash in prop_oneof![Just(Hash::Low), Just(Hash::AddUpper), Just(Hash::AddUpperAll)],
        // Most of them LRU: those share their stacks.
        policy in prop_oneof![4 => Just(Policy::Lru), 1 => Just(Policy::Fifo), 1 => Just(Policy::Plru)],
    ) -> CacheConfig {
        config(1 << (line + ways + sets), 1 << line, 1 << ways, hash, policy)
    }
}

prop_compose! {
    /// Reads of which many lie near each other.
    fn any_reads()(near in 0..HOST / 2, reads in vec((any::<bool>(), 0..HOST - 80, 1..=72_u32), 0..200)) -> Vec<(u32, u32)> {
        reads.into_iter().map(|(is_near, addr, bytes)| (if is_near { near + addr % 256 } else { addr }, bytes)).collect()
    }
}

proptest! {
    #[test]
    fn caches_that_see_the_same_reads_are_naive_caches(
        configs in vec(any_config(), 1..12),
        frames in vec((proptest::bool::weighted(0.2), any_reads()), 1..4),
    ) {
        let mut caches = Caches::new(&configs, Bytes(HOST.into()));
        let mut counts = Vec::new();
        for (cold, reads) in &frames {
            caches.begin_frame(*cold);
            // In two parts, as batches are.
            let (first, second) = reads.split_at(reads.len() / 2);
            for part in [first, second] {
                caches.play(part.iter().map(|&(addr, bytes)| (HostAddr(addr), bytes)));
            }
            counts.push(caches.counts());
        }
        for (place, config) in configs.iter().enumerate() {
            let of_one: Vec<FrameCounts> = counts.iter().map(|counts| counts[place]).collect();
            prop_assert_eq!(of_one, naive(*config, &frames), "{:?}", config);
        }
    }
}
