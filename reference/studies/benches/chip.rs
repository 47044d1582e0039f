//! A recorded frame on the chip, by version, on one core: operations of packets a second, and those
//! of a frame before that warms the caches. `SAARCOR_SCENES` names a folder with real scenes, of which
//! conference is then measured beside the built-in pquake3.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saarcor_fast::chip::simulate;
use saarcor_model::time::Version;
use saarcor_studies::monitor::Silent;
use saarcor_studies::names::version_name;
use saarcor_studies::simulate::record;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};
use std::hint::black_box;
use std::path::Path;

const OPTIONS: TraceOptions =
    TraceOptions { resolution: (512, 384), packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES };

fn frame(c: &mut Criterion, name: &str, scene: &str) {
    let world = World::open(&WorldOptions::new(scene), &Silent).expect("scene");
    let programs = record(&world, 150, &OPTIONS, PacketOrder::default()).programs;
    let mut group = c.benchmark_group("chip");
    group.throughput(Throughput::Elements(programs.in_order().count() as u64));
    for version in [Version::None, Version::A, Version::B] {
        let config = standard::chip(name, version).expect("legal");
        for (frames, before) in [("cold", &[][..]), ("warm", std::slice::from_ref(&programs))] {
            group.bench_function(format!("{name}/{}/{frames}", version_name(version)), |b| {
                b.iter(|| black_box(simulate(before, &programs, &config)));
            });
        }
    }
    group.finish();
}

fn scenes(c: &mut Criterion) {
    frame(c, "pquake3-nt", "pquake3-nt");
    if let Some(folder) = std::env::var_os("SAARCOR_SCENES") {
        let conference = Path::new(&folder).join("conference/conference.obj");
        frame(c, "conference", &conference.display().to_string());
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = scenes }
criterion_main!(benches);
