//! KD-4: traversal finds the closest triangle, as the search over all triangles does with the
//! same triangle test. 10 000 camera rays and 10 000 random rays a scene, in packets and alone.

use glam::Vec3;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::{Aabb, HostImage, Kernel, Scene};
use saarcor_model::rays::{
    EdgeTriangle, Frame, Hits, Packet, PluckerTriangle, ProjectedTriangle, Query, Ray, Traversal,
    TriangleTest, WatertightTriangle,
};
use saarcor_model::vm::{HostAddr, Observed};
use saarcor_oracles::exact::{self, rational::nearest_f32};
use saarcor_oracles::flat::FlatMemory;
use saarcor_oracles::search::{ClosestHit, closest_hit};
use saarcor_scenes::Random;
use saarcor_scenes::builtin::builtin;
use saarcor_scenes::kdbuild::{BuildOptions, SplitRule, build};
use std::path::PathBuf;

/// Rays a kind, of which there are two a scene.
const RAYS: usize = 10_000;

/// A unit vector, uniform over the sphere.
fn direction(random: &mut Random) -> Vec3 {
    let z = 2.0 * random.unit() - 1.0;
    let (sin, cos) = (random.unit() * std::f32::consts::TAU).sin_cos();
    Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z
}

/// Rays from the cameras of the whole path through random pixels.
fn camera_rays(scene: &Scene, rays: usize) -> Vec<Ray> {
    let mut random = Random::new(1);
    let (width, height) = (1024, 768);
    (0..rays)
        .map(|i| {
            let camera = &scene.path[i * scene.path.len() / rays];
            let (x, y) = (random.unit() * width as f32, random.unit() * height as f32);
            Frame::new(camera, width, height).primary_ray(x as u32, y as u32)
        })
        .collect()
}

/// Rays in all directions from points in the box around the scene.
fn random_rays(bounds: Aabb, rays: usize) -> Vec<Ray> {
    let mut random = Random::new(2);
    (0..rays)
        .map(|_| {
            let place = Vec3::new(random.unit(), random.unit(), random.unit());
            let origin = bounds.min + (bounds.max - bounds.min) * place;
            Ray { origin, direction: direction(&mut random), t_min: 0.0, t_max: f32::INFINITY }
        })
        .collect()
}

/// Distance and triangle, by the scene's index, of each ray's closest hit, from packets of `N`.
fn traverse<const N: usize>(image: &HostImage, rays: &[Ray]) -> Vec<Option<(f32, u32)>> {
    let mut traversal = Traversal::<N, _>::with(FilteredIntersection::default());
    let mut memory = Observed::by_nobody(FlatMemory::new(&image.bytes));
    let mut found = Vec::new();
    for rays in rays.chunks(N) {
        let packet = Packet::new(std::array::from_fn(|lane| rays.get(lane).copied()));
        let hits: Hits<N> = traversal.run(&mut memory, &image.registers, &packet, Query::Closest);
        found.extend((0..rays.len()).map(|lane| {
            let addr = HostAddr(hits.triangle[lane]);
            hits.is_hit(lane).then(|| (hits.t[lane], image.triangle_id(addr)))
        }));
    }
    found
}

/// The first hit, by trying every one of `triangles` with the test `T`.
fn search<T: TriangleTest<f32> + Sync>(
    triangles: &[[Vec3; 3]],
    rays: &[Ray],
) -> Vec<Option<ClosestHit<f32>>> {
    let prepared: Vec<T> = triangles.iter().map(T::new).collect();
    let closest = |ray: &Ray| {
        let from = T::ray(ray.origin.to_array(), ray.direction.to_array());
        closest_hit(&prepared, |triangle| {
            let hit = triangle.intersect::<false>(&from);
            (hit.inside & (hit.t >= ray.t_min) & (hit.t < ray.t_max)).then_some(hit.t)
        })
    };
    rays.par_iter().map(closest).collect()
}

/// The first hit, by trying every one of `triangles` exactly.
fn search_exactly(corners: &[[Vec3; 3]], rays: &[Ray]) -> Vec<Option<ClosestHit<f32>>> {
    let closest = |ray: &Ray| {
        let numbered = (0..).zip(corners.iter().copied());
        let first = exact::closest(ray, numbered)?;
        let triangles: Vec<u32> = first.triangles.iter().map(|(number, _)| *number).collect();
        let point = exact::solve(ray, &corners[first.triangles[0].0 as usize]).expect("hit");
        Some(ClosestHit { t: nearest_f32(&point.t), triangles })
    };
    rays.par_iter().map(closest).collect()
}

/// Compares traversal and search on `scene`, and says how many hits were ties.
fn agrees(name: &str, scene: &Scene, kernel: Kernel, rule: SplitRule, rays: usize) {
    let tree = build(&scene.triangles, &BuildOptions { rule, ..BuildOptions::default() }, &|_| {});
    let image = HostImage::build(scene, &tree, kernel).expect("valid scene");
    // A triangle without area has no hits by definition (HI-4).
    let with_area = |&id: &u32| !scene.triangles[id as usize].is_degenerate();
    let ids: Vec<u32> = (0..scene.triangles.len() as u32).filter(with_area).collect();
    let triangles: Vec<_> = ids.iter().map(|&id| scene.triangles[id as usize].corners).collect();

    for (kind, rays) in [("camera", camera_rays(scene, rays)), ("random", random_rays(tree.bounds, rays))] {
        let alone = traverse::<1>(&image, &rays);
        let in_packets = traverse::<64>(&image, &rays);
        assert_eq!(alone, in_packets, "{name}: {kind} rays alone and in packets");
        let searched = match kernel {
            Kernel::MollerTrumbore => search::<EdgeTriangle>(&triangles, &rays),
            Kernel::Wald => search::<ProjectedTriangle>(&triangles, &rays),
            Kernel::Plucker => search::<PluckerTriangle>(&triangles, &rays),
            Kernel::Watertight => search::<WatertightTriangle>(&triangles, &rays),
            Kernel::Adaptive => search_exactly(&triangles, &rays),
        };
        let (mut hits, mut ties, mut faults) = (0, 0, Vec::new());
        for ((ray, traversed), searched) in rays.iter().zip(&alone).zip(&searched) {
            let same = match (traversed, searched) {
                (None, None) => true,
                (Some((t, triangle)), Some(closest)) => {
                    hits += 1;
                    ties += usize::from(closest.triangles.len() > 1);
                    *t == closest.t && closest.triangles.iter().any(|&i| ids[i as usize] == *triangle)
                }
                _ => false,
            };
            if !same {
                faults.push(format!("{ray:?}: traversal {traversed:?}, search {searched:?}"));
            }
        }
        println!("{name}, {kernel:?}, {rule:?}: {} {kind} rays, {hits} hits, {ties} ties", rays.len());
        assert!(faults.is_empty(), "{name}: {} of the {kind} rays: {faults:#?}", faults.len());
        assert!(hits * 10 > rays.len(), "{name}: nearly all of the {kind} rays miss the scene");
    }
}

fn builtin_agrees(name: &str) {
    let scene = builtin(name).expect("built-in");
    agrees(name, &scene, Kernel::MollerTrumbore, SplitRule::SurfaceArea, RAYS);
}

#[test]
fn pquake3() {
    let scene = builtin("pquake3-nt").expect("built-in");
    agrees("pquake3-nt", &scene, Kernel::MollerTrumbore, SplitRule::SurfaceArea, RAYS);
    agrees("pquake3-nt", &scene, Kernel::Wald, SplitRule::SpatialMedian, RAYS);
}

/// Every test in traversal as in the search. The adaptive one is searched for exactly, and its
/// distance is the true one, rounded.
#[test]
fn every_kernel() {
    let scene = builtin("pquake3-nt").expect("built-in");
    for kernel in [Kernel::Plucker, Kernel::Watertight, Kernel::Adaptive] {
        agrees("pquake3-nt", &scene, kernel, SplitRule::SurfaceArea, RAYS / 20);
    }
}

#[test]
#[ignore = "long: 6·10⁹ triangle tests, half a minute"]
fn rays_of_the_conference() {
    builtin_agrees("conference");
}

#[test]
#[ignore = "long: 3·10¹⁰ triangle tests, minutes"]
fn rays_of_sodahall() {
    builtin_agrees("sodahall");
}

#[test]
#[ignore = "long: 7·10¹⁰ triangle tests, minutes"]
fn rays_of_the_cruiser() {
    builtin_agrees("cruiser-nt");
}

#[test]
#[ignore = "needs the real scenes: SAARCOR_SCENES names their folder"]
fn rays_of_real_scenes() {
    let folder = PathBuf::from(std::env::var_os("SAARCOR_SCENES").expect("SAARCOR_SCENES names a folder"));
    for name in ["oa_dm3", "conference", "conference_raw", "office", "sponza"] {
        let path = folder.join(name).join(name).with_extension("obj");
        let loaded = saarcor_scenes::load_obj(&path, Default::default()).expect("scene");
        agrees(name, &loaded.scene, Kernel::MollerTrumbore, SplitRule::SurfaceArea, RAYS);
    }
}
