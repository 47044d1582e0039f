//! Pictures: the same bit for bit, whatever lies between the chip and the host's memory.

mod common;

use common::{room_arg, run, stdout_of};
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

/// The verb writes the same file either way, and prints what the virtual memory did.
#[test]
fn files_are_the_same_with_flat_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = |name: &str, args: &[&str]| {
        let file = folder.path().join(name);
        let file_arg = file.to_str().expect("text");
        let all =
            ["render", &room_arg(), "--resolution", "160x120", "--frame", "1", "-o", file_arg, "--json"];
        let out = stdout_of(&[&all[..], args].concat());
        (std::fs::read(file).expect("a file"), serde_json::from_str::<serde_json::Value>(&out).expect("JSON"))
    };
    let (flat, without) = render("flat.png", &["--flat"]);
    let (cached, with) = render("cached.png", &["--memory", "2KiB", "--line", "64"]);
    assert_eq!(flat, cached);
    assert_eq!(without.get("accesses"), None);
    assert_eq!(
        with["hits"].as_u64().zip(with["misses"].as_u64()).map(|(a, b)| a + b),
        with["accesses"].as_u64()
    );
    assert_eq!(without["shadow_rays"], with["shadow_rays"]);
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 2, "no temporary file is left");
    let picture = image::load_from_memory(&flat).expect("PNG");
    assert_eq!((picture.width(), picture.height()), (160, 120));
}

/// Single rays and packets see the same.
#[test]
fn packets_do_not_change_the_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = |packet: &str| {
        let file = folder.path().join(packet);
        let file_arg = file.to_str().expect("text");
        let args = ["render", &room_arg(), "--resolution", "70x50", "-o", file_arg, "--packet", packet];
        assert!(run(&args).status.success());
        std::fs::read(file).expect("a file")
    };
    let single = render("1");
    assert!(["4", "16", "64"].iter().all(|packet| render(packet) == single));
}
