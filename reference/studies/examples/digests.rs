//! Digests of a small frame, a walk and a run of `accuracy`: the same on every machine, and of every build.
//! `cargo run -p saarcor-studies --example digests`, with `RUSTFLAGS="-C target-cpu=..."` or a profile of its own.

use saarcor_model::host::{Edges, Kernel};
use saarcor_oracles::surfaces::SurfaceSuite;
use saarcor_studies::accuracy::contest::{Contestant, Format};
use saarcor_studies::accuracy::exactly_one::{ExactlyOneOptions, exactly_one};
use saarcor_studies::accuracy::measure::{MeasureOptions, measure};
use saarcor_studies::accuracy::suites::SUITES;
use saarcor_studies::monitor::Silent;
use saarcor_studies::picture::through_whole_scene;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::walk::{Walk, WalkOptions};
use saarcor_studies::world::{World, WorldOptions};
use xxhash_rust::xxh3::xxh3_64;

const TRACE: TraceOptions = TraceOptions { resolution: (96, 72), packet: PacketSize::Rays64, max_bounces: 5 };

/// The digests by their names.
pub fn digests() -> Result<[(&'static str, u64); 4], Box<dyn std::error::Error>> {
    let scene = "conference";
    let world = World::open(&WorldOptions { kernel: Kernel::Adaptive, ..WorldOptions::new(scene) }, &Silent)?;
    let picture = through_whole_scene(&world, 400, &TRACE);
    let options = WalkOptions { cache: standard::cache(scene)?, cold: false, trace: TRACE };
    let mut walk = Walk::new(&world, [0, 400, 401], &options);
    let mut rows = String::new();
    while let Some(frame) = walk.next_of_each() {
        rows += &serde_json::to_string(&frame)?;
    }
    Ok([
        ("scene", xxh3_64(&world.image.bytes)),
        ("frame", xxh3_64(picture.pixels.as_raw())),
        ("walk", xxh3_64(rows.as_bytes())),
        ("accuracy", xxh3_64(accuracy()?.as_bytes())),
    ])
}

/// The rows of all suites and contestants, without times.
fn accuracy() -> Result<String, serde_json::Error> {
    let extent = MeasureOptions { seed: 1, cases: 400, repeats: 1, edges: Edges::Shared };
    let mut text = String::new();
    for suite in &SUITES {
        for mut row in measure(suite, &Contestant::all(), extent, &|_| ()) {
            row.ns_per_test = 0.0;
            text += &serde_json::to_string(&row)?;
        }
    }
    let suite = SurfaceSuite::ExactlyOne;
    let options = ExactlyOneOptions { seed: 1, cases: 3500, edges: Edges::Owned };
    let contestants = Kernel::ALL.map(|kernel| Contestant { kernel, format: Format::F32 });
    for mut row in exactly_one(suite, &suite.places(), &contestants, options, &|_| ()) {
        row.ns_per_ray = 0.0;
        text += &serde_json::to_string(&row)?;
    }
    Ok(text)
}

#[allow(dead_code, reason = "a test reads this file, too")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (name, digest) in digests()? {
        println!("{name:<10}{digest:016x}");
    }
    Ok(())
}
