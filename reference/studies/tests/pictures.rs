//! Pictures: the same bit for bit, whatever lies between the chip and the host's memory.

use rayon::prelude::*;
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
use saarcor_studies::monitor::Silent;
use saarcor_studies::picture::{through_virtual_memory, through_whole_scene};
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};

/// Memories of 64 KiB, 1 MiB and 8 MiB with each hash and each policy.
fn caches() -> Vec<CacheConfig> {
    let mut caches = Vec::new();
    for memory in [64 << 10, 1 << 20, 8 << 20] {
        let geometry = Geometry::new(Bytes(memory), Bytes(128), 4).expect("legal");
        for hash in [Hash::Low, Hash::AddUpper, Hash::AddUpperAll] {
            for policy in [Policy::Lru, Policy::Fifo, Policy::Plru] {
                caches.push(CacheConfig { geometry, hash, policy });
            }
        }
    }
    caches
}

fn assert_transparent(scene: &str) {
    let world = World::open(&WorldOptions::new(scene), &Silent).expect("a built-in scene");
    let frame = world.path.len() / 3;
    let trace = TraceOptions { resolution: (256, 192), packet: PacketSize::Rays64, max_bounces: 3 };
    let flat = through_whole_scene(&world, frame, &trace);
    let colours: std::collections::BTreeSet<_> = flat.pixels.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 100, "the picture of {scene} shows something: {} colours", colours.len());
    caches().into_par_iter().for_each(|cache| {
        let (picture, counters) = through_virtual_memory(&world, frame, &trace, cache);
        assert!(picture == flat, "{scene} through {cache:?}");
        assert!(counters.misses > 0 && counters.hits() > 0);
    });
}

#[test]
fn pquake3_is_the_same_through_any_memory() {
    assert_transparent("pquake3");
}

#[test]
fn conference_is_the_same_through_any_memory() {
    assert_transparent("conference");
}

#[test]
fn sodahall_is_the_same_through_any_memory() {
    assert_transparent("sodahall");
}

#[test]
#[ignore = "long: the Cruiser takes half a minute and 2 GB to make ready"]
fn cruiser_is_the_same_through_any_memory() {
    assert_transparent("cruiser");
}
