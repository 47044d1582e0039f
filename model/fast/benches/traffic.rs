//! Accesses a second of the cache alone, beside a loop in the way of Valgrind's cachegrind: 8 MiB, 4 ways, lines of 128 bytes,
//! the paper's hash, LRU. Version A counts hits, misses and evictions; version B what goes through the paper's metadata cache,
//! too. Three runs of addresses: uniform over 32 MiB; Zipf's law (exponent 1) over the lines of 128 MiB; and a walk down a tree
//! of 20 levels in depth-first order, whose leaf then reads three triangles, for rays that drift.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saarcor_fast::traffic::{MetadataCache, Traffic};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
use saarcor_random::Random;
use std::hint::black_box;

const LINE: u64 = 128;
const ACCESSES: usize = 4_000_000;

fn uniform() -> Vec<u32> {
    let mut random = Random::new(1);
    (0..ACCESSES).map(|_| random.below((32 << 20) / LINE) as u32).collect()
}

fn zipf() -> Vec<u32> {
    let mut random = Random::new(2);
    let lines = (128 << 20) / LINE;
    let mut sum = 0.0;
    let sums: Vec<f64> = (1..=lines)
        .map(|rank| {
            sum += 1.0 / rank as f64;
            sum
        })
        .collect();
    let mut of_rank: Vec<u32> = (0..lines as u32).collect();
    for i in (1..of_rank.len()).rev() {
        of_rank.swap(i, random.below(i as u64 + 1) as usize);
    }
    let draw = |_| {
        let at = random.below(1 << 32) as f64 / (1_u64 << 32) as f64 * sum;
        of_rank[sums.partition_point(|sum| *sum <= at)]
    };
    (0..ACCESSES).map(draw).collect()
}

fn tree() -> Vec<u32> {
    const LEVELS: u32 = 20;
    const NODE: u64 = 8;
    const TRIANGLE: u64 = 36;
    let mut random = Random::new(3);
    let mut leaf = 0_u64;
    let mut lines = Vec::with_capacity(ACCESSES + 64);
    while lines.len() < ACCESSES {
        let step = if random.below(100) == 0 { random.below(1 << LEVELS) } else { random.below(9) };
        leaf = (leaf + step) % (1 << LEVELS);
        let mut node = 0;
        for level in (0..LEVELS).rev() {
            lines.push((node * NODE / LINE) as u32);
            // The left child follows its parent, the right one all that is on the left.
            node += if leaf >> level & 1 == 0 { 1 } else { 2 << level };
        }
        let triangles = (1 << LEVELS) * 2 * NODE;
        lines.extend((0..3).map(|i| ((triangles + (leaf + i) * TRIANGLE) / LINE) as u32));
    }
    lines.truncate(ACCESSES);
    lines
}

/// Lines of a set, the one used last first. The first is looked at before the others are searched.
#[inline(never)]
fn cachegrind(sets: &mut [[u32; 4]], lines: &[u32]) -> u64 {
    let (set_bits, mut misses) = (sets.len().ilog2(), 0);
    for &line in lines {
        let set = line.wrapping_add(line >> set_bits) as usize & (sets.len() - 1);
        let set = &mut sets[set];
        let tag = line + 1;
        if set[0] == tag {
            continue;
        }
        let mut place = 1;
        while place < 4 && set[place] != tag {
            place += 1;
        }
        if place == 4 {
            misses += 1;
            place = 3;
        }
        for i in (1..=place).rev() {
            set[i] = set[i - 1];
        }
        set[0] = tag;
    }
    misses
}

fn traffic(c: &mut Criterion) {
    let geometry = Geometry::new(Bytes(8 << 20), Bytes(LINE), 4).expect("legal");
    let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
    for (name, lines) in [("uniform", uniform()), ("zipf", zipf()), ("tree", tree())] {
        let mut group = c.benchmark_group(format!("traffic/{name}"));
        group.throughput(Throughput::Elements(lines.len() as u64));
        // All have played the lines once.
        let mut sets = vec![[0; 4]; geometry.sets() as usize];
        let misses = cachegrind(&mut sets, &lines);
        group.bench_function("cachegrind", |b| b.iter(|| cachegrind(&mut sets, black_box(&lines))));
        let versions = [Traffic::of_version_a(cache), Traffic::of_version_b(cache, MetadataCache::STANDARD)];
        for (version, mut traffic) in ["a", "b"].into_iter().zip(versions) {
            traffic.access(&lines);
            assert_eq!(traffic.counters().misses, misses, "all count the same");
            group.bench_function(version, |b| b.iter(|| traffic.access(black_box(&lines))));
        }
        group.finish();
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = traffic }
criterion_main!(benches);
