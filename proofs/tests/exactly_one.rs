//! Rays at edges and vertices of surfaces hit as many of the triangles there as they cross, and of these the ones that they hit once they
//! are moved, where edges are owned (IS-6): the suite `exactly-one`, in the small, for the specification, for its twin, and for the
//! watertight test with parallel rays.

use glam::{Vec2, Vec3};
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle};
use saarcor_model::host::Edges;
use saarcor_model::rays::{ExactHit, Ray, TriangleTest as _, WatertightTriangle};
use saarcor_oracles::exact::is_owned_hit;
use saarcor_oracles::surfaces::{SurfaceSuite, case};

/// By whether a triangle is hit, and whether the ray that is moved hits it.
fn are_hit_once(suite: SurfaceSuite, cases: u64, hit: impl Fn(&Ray, &[Vec3; 3]) -> [bool; 2]) {
    let places = suite.places();
    for number in 0..cases {
        let case = case(suite, &places, 7, number).expect("a ray that the patch decides");
        let place = &places[case.place];
        let corners = case.triangles.iter().map(|&triangle| place.surface.corners(triangle));
        let hits: Vec<_> = corners.map(|corners| (hit(&case.ray, &corners), corners)).collect();
        let count = hits.iter().filter(|([hit, _], _)| *hit).count() as u32;
        let right = case.truth.allows(count) && hits.iter().all(|([hit, owned], _)| hit == owned);
        assert!(right, "case {number}, {}: {:?} of {:?}: {hits:#?}", place.name, case.truth, case.ray);
    }
}

#[test]
fn by_the_adaptive_test() {
    are_hit_once(SurfaceSuite::ExactlyOne, 7000, |ray, corners| {
        [ExactHit::new(ray, corners, Edges::Owned).is_some(), is_owned_hit(ray, corners)]
    });
}

#[test]
fn by_its_twin() {
    are_hit_once(SurfaceSuite::ExactlyOne, 7000, |ray, corners| {
        let hit = AdaptiveTriangle::new(corners).intersect(Edges::Owned, &AdaptiveRay::new(ray)).is_some();
        [hit, is_owned_hit(ray, corners)]
    });
}

/// Rays along z are not sheared: there the one is hit that the rule says, of corners as they are counted from the ray's origin.
#[test]
fn by_the_watertight_test() {
    are_hit_once(SurfaceSuite::Watertightness, 2400, |ray, corners| {
        let sheared = WatertightTriangle::<f32>::ray(ray.origin.to_array(), ray.direction.to_array());
        let hit = WatertightTriangle::new(corners).intersect::<true>(&sheared).inside;
        let from_zero = Ray { origin: Vec3::ZERO, ..*ray };
        let is_along_z = ray.direction.truncate() == Vec2::ZERO;
        let owned = || is_owned_hit(&from_zero, &corners.map(|corner| corner - ray.origin));
        [hit, if is_along_z { owned() } else { hit }]
    });
}
