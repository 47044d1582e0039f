//! Closest hits of primary rays, alone and in packets, on one core. `SAARCOR_SCENES` names a
//! folder with real scenes, of which sponza is then measured beside the built-in pquake3.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saarcor_model::rays::{Frame, Packet, Query, Traversal};
use saarcor_model::vm::{Observed, WholeScene};
use saarcor_studies::monitor::Silent;
use saarcor_studies::world::{World, WorldOptions};
use std::hint::black_box;
use std::path::Path;

const RESOLUTION: (u32, u32) = (512, 384);

fn closest_hits<const N: usize>(c: &mut Criterion, name: &str, world: &World) {
    let frame = Frame::new(&world.path[0], RESOLUTION.0, RESOLUTION.1);
    let packets: Vec<Packet<N>> = (0..frame.packets::<N>()).map(|p| frame.primary_packet(p)).collect();
    let mut traversal = Traversal::<N>::default();
    let mut memory = Observed::by_nobody(WholeScene(&world.image.bytes));
    let mut group = c.benchmark_group("closest_hit");
    group.throughput(Throughput::Elements(u64::from(RESOLUTION.0 * RESOLUTION.1)));
    group.bench_function(format!("{name}/{N} rays a packet"), |b| {
        b.iter(|| {
            for packet in &packets {
                let registers = &world.image.registers;
                black_box(traversal.run(&mut memory, registers, packet, Query::Closest));
            }
        });
    });
    group.finish();
}

fn scenes(c: &mut Criterion) {
    let mut scenes = vec![("pquake3-nt", "pquake3-nt".to_owned())];
    if let Some(folder) = std::env::var_os("SAARCOR_SCENES") {
        scenes.push(("sponza", Path::new(&folder).join("sponza/sponza.obj").display().to_string()));
    }
    for (name, scene) in scenes {
        let world = World::open(&WorldOptions::new(&scene), &Silent).expect("scene");
        closest_hits::<1>(c, name, &world);
        closest_hits::<16>(c, name, &world);
        closest_hits::<64>(c, name, &world);
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = scenes }
criterion_main!(benches);
