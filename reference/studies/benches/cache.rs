//! One access of the virtual memory's directory (version A): hit, miss, and the recorded accesses
//! of a frame, which mix both as a picture does.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saarcor_fast::directory::access;
use saarcor_model::vm::{Bytes, CacheConfig, Directory, Geometry, Hash, LineAddr, Policy};
use saarcor_studies::monitor::Silent;
use saarcor_studies::world::{World, WorldOptions};
use saarcor_studies::{
    trace::{PacketSize, TraceOptions},
    walk::{WalkOptions, record_frame},
};
use std::hint::black_box;

fn config(policy: Policy) -> CacheConfig {
    let geometry = Geometry::new(Bytes(8 << 20), Bytes(128), 4).expect("legal");
    CacheConfig { geometry, hash: Hash::AddUpper, policy }
}

fn accesses(c: &mut Criterion) {
    let mut group = c.benchmark_group("l2_access");
    let capacity = config(Policy::Lru).geometry.lines() as u32;
    for (name, policy) in [("lru", Policy::Lru), ("fifo", Policy::Fifo), ("plru", Policy::Plru)] {
        // As many lines as the cache holds: all hit from the second round on. Twice as many, in
        // turn: with LRU and FIFO none ever does.
        for (kind, lines) in [("hit", capacity), ("miss", 2 * capacity)] {
            group.throughput(Throughput::Elements(u64::from(lines)));
            let mut directory = Directory::<4>::new(config(policy));
            group.bench_function(format!("{kind}/{name}"), |b| {
                b.iter(|| {
                    for line in 0..lines {
                        black_box(access(&mut directory, LineAddr(line)));
                    }
                });
            });
        }
    }
    group.finish();
}

fn recorded_frame(c: &mut Criterion) {
    let world = World::open(&WorldOptions::new("pquake3-nt"), &Silent).expect("built-in");
    let cache = config(Policy::Lru);
    let trace = TraceOptions { resolution: (1024, 768), packet: PacketSize::Rays64, max_bounces: 3 };
    let mut lines = Vec::new();
    let options = WalkOptions { cache, cold: true, trace };
    record_frame(&world, 150, &options, &mut |addr| {
        lines.push(cache.geometry.line_of(addr));
        Ok::<_, std::convert::Infallible>(())
    })
    .expect("recorded");
    let mut group = c.benchmark_group("l2_access");
    group.throughput(Throughput::Elements(lines.len() as u64));
    group.bench_function("recorded frame/lru", |b| {
        b.iter(|| {
            let mut directory = Directory::<4>::new(cache);
            for &line in &lines {
                access(&mut directory, line);
            }
            directory.counters
        });
    });
    group.finish();
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = accesses, recorded_frame }
criterion_main!(benches);
