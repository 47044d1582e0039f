//! Triangles a second that the kd-tree builder takes.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use saarcor_model::host::Triangle;
use saarcor_scenes::kdbuild::{BuildOptions, SplitRule, build};
use std::f32::consts::TAU;

/// Columns of spheres on a floor: 25 spheres of 4 000 triangles and two large triangles below.
fn spheres() -> Vec<Triangle> {
    const RINGS: u8 = 40;
    const SECTORS: u8 = 50;
    let on_sphere = |ring: u8, sector: u8| {
        let polar = TAU / 2.0 * f32::from(ring) / f32::from(RINGS);
        let around = TAU * f32::from(sector) / f32::from(SECTORS);
        Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin())
    };
    let corners_on_floor =
        [[0.0, 0.0], [15.0, 0.0], [0.0, 15.0], [15.0, 15.0]].map(|[x, z]| Vec3::new(x, -1.0, z));
    let mut corners = vec![
        [corners_on_floor[0], corners_on_floor[1], corners_on_floor[2]],
        [corners_on_floor[3], corners_on_floor[2], corners_on_floor[1]],
    ];
    for (x, z) in (0..5u8).flat_map(|x| (0..5u8).map(move |z| (x, z))) {
        let centre = Vec3::new(f32::from(x), 0.0, f32::from(z)) * 3.0 + 1.5;
        for (ring, sector) in (0..RINGS).flat_map(|r| (0..SECTORS).map(move |s| (r, s))) {
            let at = |r, s| centre + on_sphere(ring + r, sector + s);
            corners.push([at(0, 0), at(1, 0), at(0, 1)]);
            corners.push([at(1, 1), at(0, 1), at(1, 0)]);
        }
    }
    corners.into_iter().map(|corners| Triangle { corners, material: 0 }).collect()
}

fn kdbuild(criterion: &mut Criterion) {
    let triangles = spheres();
    let mut group = criterion.benchmark_group("kdbuild");
    group.throughput(Throughput::Elements(triangles.len() as u64));
    group.sample_size(10);
    for (name, rule) in
        [("surface_area", SplitRule::SurfaceArea), ("spatial_median", SplitRule::SpatialMedian)]
    {
        let options = BuildOptions { rule, ..BuildOptions::default() };
        group.bench_function(name, |bencher| {
            bencher.iter(|| build(&triangles, &options, &|_| ()));
        });
    }
    group.finish();
}

criterion_group!(benches, kdbuild);
criterion_main!(benches);
