//! A picture through 64 KiB of on-board memory: `cargo run -p saarcor-studies --example picture_in_64_kib`.

use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
use saarcor_studies::monitor::Silent;
use saarcor_studies::picture::{through_virtual_memory, through_whole_scene};
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::open(&WorldOptions::new("pquake3"), &Silent)?;
    let options = TraceOptions { resolution: (320, 240), packet: PacketSize::Rays64, max_bounces: 5 };
    let geometry = Geometry::new(Bytes(64 << 10), Bytes(128), 4)?;
    let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };

    let (picture, counters) = through_virtual_memory(&world, 556, &options, cache);
    assert!(picture == through_whole_scene(&world, 556, &options), "every byte is the host's");

    let file = std::env::temp_dir().join("picture_in_64_kib.png");
    picture.pixels.save(&file)?;
    println!("{}: a scene of {} bytes, {counters:?}", file.display(), world.image.bytes.len());
    Ok(())
}
