//! KD-4 on the hard suites: kd-tree traversal returns what the search over all triangles returns with
//! the same test.
//!
//! Cases of a suite are put into one scene, and each ray goes through its kd-tree and to all of its triangles:
//! the rays of the cases, and rays from the origin of one to what another is aimed at. With the adaptive test
//! both answers are the same, to the last bit. The other tests may report hits beside their triangles, in
//! cells that the ray does not meet: there each hit that is one, at a distance within 2u of the true one, has to be found.

use rayon::prelude::*;
use saarcor_model::host::{HostImage, Kernel, Material, Scene, Triangle};
use saarcor_model::rays::{Query, Ray};
use saarcor_oracles::embree::Hit;
use saarcor_oracles::exact::rational::nearest_f64;
use saarcor_oracles::exact::{judge, solve};
use saarcor_scenes::Random;
use saarcor_scenes::kdbuild::{BuildOptions, build};
use saarcor_studies::accuracy::suites::{SUITES, Suite};
use saarcor_studies::crosscheck::rays::traverse;
use saarcor_studies::crosscheck::search;
use std::ops::Add;

/// Cases in a scene, and rays through it.
const CASES: u64 = 32;
const RAYS: u64 = 2048;

/// Of all scenes of a suite.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: u64,
    hits: u64,
    /// Hits beside the triangle, or at a wrong distance, of the tests that round.
    beside: u64,
}

impl Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            beside: self.beside + other.beside,
        }
    }
}

/// The triangles of some cases as one scene, and rays through it.
fn scene(suite: &Suite, number: u64) -> (Scene, Vec<Ray>) {
    let cases: Vec<_> = (number * CASES..(number + 1) * CASES).map(|case| suite.case(4, case)).collect();
    let corners = cases.iter().flat_map(|case| &case.triangles);
    let triangles = corners.map(|&corners| Triangle { corners, material: 0 }).collect();
    let mut random = Random::new(number);
    let ray = |place: u64| {
        let own = cases[(place % CASES) as usize].ray;
        if place < CASES {
            return own;
        }
        let other = cases[random.range(0, CASES as u32) as usize].ray;
        Ray { direction: other.origin + other.direction - own.origin, ..own }
    };
    let rays = (0..RAYS).map(ray).collect();
    (Scene { triangles, materials: vec![Material::default()], ..Scene::default() }, rays)
}

/// Whether a hit is one, at a distance within 2u of the true one, and the least f32.
fn is_right(ray: &Ray, triangle: &Triangle, hit: &Hit) -> bool {
    let is_hit = judge(ray, &triangle.corners).is_hit();
    is_hit
        && solve(ray, &triangle.corners).is_some_and(|point| {
            let t = nearest_f64(&point.t);
            (f64::from(hit.t) - t).abs() <= t.abs() * f64::from(f32::EPSILON) + f64::from(f32::from_bits(1))
        })
}

/// Compares traversal and search in one scene, with the adaptive test and with another one.
fn loses_nothing(suite: &Suite, number: u64) -> Tally {
    let (scene, rays) = scene(suite, number);
    let tree = build(&scene.triangles, &BuildOptions::default(), &|_| {});
    let corners: Vec<_> = scene.triangles.iter().map(|triangle| triangle.corners).collect();
    let mut tally = Tally { rays: rays.len() as u64, ..Tally::default() };
    for kernel in [Kernel::Adaptive, Kernel::ALL[number as usize % (Kernel::ALL.len() - 1)]] {
        let image = HostImage::build(&scene, &tree, kernel).expect("a valid tree").into();
        let traversed = traverse(&image, &rays, Query::Closest);
        let searched = search(&image, &corners, &rays);
        for ((ray, traversed), searched) in rays.iter().zip(&traversed).zip(&searched) {
            if traversed == searched {
                tally.hits += u64::from(kernel == Kernel::Adaptive && traversed.is_some());
                continue;
            }
            let hit = searched.expect("search tries what traversal does");
            let right =
                kernel == Kernel::Adaptive || is_right(ray, &scene.triangles[hit.triangle as usize], &hit);
            assert!(
                !right,
                "{} {number}, {kernel:?}: {ray:?}: traversal {traversed:?}, search {hit:?}",
                suite.name
            );
            tally.beside += 1;
        }
        if kernel == Kernel::Adaptive {
            let any = traverse(&image, &rays, Query::Any);
            assert!(
                any.iter().zip(&searched).all(|(any, first)| any.is_some() == first.is_some()),
                "{}",
                suite.name
            );
        }
    }
    tally
}

fn suites_lose_nothing(scenes: u64) -> u64 {
    let mut rays = 0;
    for suite in &SUITES {
        let one = |number| loses_nothing(suite, number);
        let tally = (0..scenes).into_par_iter().map(one).reduce(Tally::default, Tally::add);
        println!("{}: {tally:?}", suite.name);
        assert!(tally.hits > 0, "{}: no hit to lose", suite.name);
        rays += tally.rays;
    }
    rays
}

#[test]
fn no_hit_of_the_suites_is_lost() {
    suites_lose_nothing(4);
}

#[test]
#[ignore = "long: minutes"]
fn no_hit_is_lost_in_ten_million_rays() {
    let scenes = 10_000_000_u64.div_ceil(RAYS * SUITES.len() as u64);
    assert!(suites_lose_nothing(scenes) >= 10_000_000);
}
