//! Generic cases that the exact judge decides in a second on one core: nearly all by the filter in front of
//! its rationals.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saarcor_oracles::exact::judge;
use saarcor_studies::accuracy::suites::Suite;
use std::hint::black_box;

/// So few that they stay in the nearest caches.
const CASES: u64 = 512;

fn verdicts(c: &mut Criterion) {
    let suite = Suite::named("generic").expect("there");
    let cases: Vec<_> = (0..CASES).map(|number| suite.case(1, number)).collect();
    let mut group = c.benchmark_group("exact_judge");
    group.throughput(Throughput::Elements(CASES));
    group.bench_function("generic", |b| {
        b.iter(|| {
            for case in &cases {
                black_box(judge(&case.ray, &case.triangles[0]));
            }
        });
    });
    group.finish();
}

criterion_group!(benches, verdicts);
criterion_main!(benches);
