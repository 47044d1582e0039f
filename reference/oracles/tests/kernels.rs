//! The model's triangle tests against the exact judge.

use glam::Vec3;
use proptest::prelude::*;
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle, FilteredIntersection};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{
    ExactHit, Hits, Intersection, IntersectionUnit, Intervals, Packet, Query, Ray, StoredTriangle,
    TriangleTest, WatertightTriangle, intersect,
};
use saarcor_model::vm::HostAddr;
use saarcor_oracles::exact::rational::nearest_f64;
use saarcor_oracles::exact::{Incidence, closest, is_owned_hit, judge, order, solve};
use saarcor_oracles::formats::{F16, Format};

/// Whole numbers, so small that contact, coplanarity and coincidence are frequent.
fn grid() -> impl Strategy<Value = Vec3> {
    let coordinate = || (-2_i8..=2).prop_map(f32::from);
    (coordinate(), coordinate(), coordinate()).prop_map(Vec3::from)
}

/// Numbers of every magnitude, zeros of both signs and denormals; now and then NaN and infinity.
fn anything() -> impl Strategy<Value = Vec3> {
    use proptest::num::f32::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let number = POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO;
    let none = prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)];
    let coordinate = prop_oneof![60 => number, 1 => none];
    (coordinate.clone(), coordinate.clone(), coordinate).prop_map(Vec3::from)
}

/// Numbers of one magnitude.
fn generic() -> impl Strategy<Value = Vec3> {
    let coordinate = || -1.0_f32..1.0;
    (coordinate(), coordinate(), coordinate()).prop_map(Vec3::from)
}

fn range() -> impl Strategy<Value = (f32, f32)> {
    let t_min = prop_oneof![4 => Just(0.0), 1 => Just(1.0), 1 => Just(f32::NAN)];
    let t_max = prop_oneof![4 => Just(f32::INFINITY), 1 => Just(1.0), 1 => Just(2.0)];
    (t_min, t_max)
}

/// A ray towards a point of one of the triangles: of its inside, an edge or a vertex.
fn aimed(origin: Vec3, [a, b, c]: [Vec3; 3], (u, v): (f32, f32)) -> Vec3 {
    a * (1.0 - u - v) + b * u + c * v - origin
}

/// The adaptive test says what the judge says, and is as near to the true distance as it says: that of
/// the specification, and that of its twin.
fn adaptive_is_exact(ray: &Ray, corners: &[Vec3; 3]) -> Result<(), TestCaseError> {
    let owned = is_owned_hit(ray, corners);
    prop_assert_eq!(ExactHit::new(ray, corners, Edges::Owned).is_some(), owned);
    let specified = ExactHit::new(ray, corners, Edges::Shared);
    prop_assert_eq!(specified.is_some(), judge(ray, corners).is_hit());
    if let Some(found) = specified {
        let solution = solve(ray, corners).expect("hit");
        for (found, right) in found.point().into_iter().zip([&solution.t, &solution.u, &solution.v]) {
            let right = nearest_f64(right);
            prop_assert!(
                (found - right).abs() <= 2.0 * f64::EPSILON * right.abs(),
                "{} is not {}",
                found,
                right
            );
        }
    }
    let triangle = AdaptiveTriangle::new(corners);
    prop_assert_eq!(triangle.intersect(Edges::Owned, &AdaptiveRay::new(ray)).is_some(), owned);
    let found = triangle.intersect(Edges::Shared, &AdaptiveRay::new(ray));
    prop_assert_eq!(found.is_some(), judge(ray, corners).is_hit());
    if let Some(found) = found {
        let true_t = nearest_f64(&solve(ray, corners).expect("hit").t);
        let rounding = f64::EPSILON / 2.0 * true_t.abs();
        prop_assert!(
            (found.t - true_t).abs() <= found.t_error + rounding,
            "{} is not {} to {}",
            found.t,
            true_t,
            found.t_error
        );
    }
    Ok(())
}

/// Of several triangles a packet keeps the one that the judge finds first, at its lower address.
fn adaptive_finds_the_first(ray: &Ray, triangles: &[[Vec3; 3]]) -> Result<(), TestCaseError> {
    let first = closest(ray, (0..).zip(triangles.iter().copied())).map(|it| it.triangles[0].0);
    prop_assert_eq!(first_of(&mut Intersection::default(), ray, triangles), first);
    prop_assert_eq!(first_of(&mut FilteredIntersection::default(), ray, triangles), first);
    Ok(())
}

/// The triangle that an intersection unit finds first; the last one comes first.
fn first_of(unit: &mut impl IntersectionUnit<1>, ray: &Ray, triangles: &[[Vec3; 3]]) -> Option<u32> {
    let packet = Packet::new([Some(*ray)]);
    let mut hits = Hits::none(&packet);
    for (addr, corners) in (0..).zip(triangles).collect::<Vec<_>>().into_iter().rev() {
        let triangle = StoredTriangle::new(HostAddr(addr), Kernel::Adaptive, Edges::Shared, corners);
        unit.intersect(&triangle, &packet, &Intervals::EVERYWHERE, Query::Closest, &mut hits);
    }
    hits.is_hit(0).then(|| hits.triangle[0])
}

/// Of a mesh that is seen from inside, such a triangle may be the only one that a ray leaves through.
#[test]
fn small_triangles_have_a_distance_in_the_watertight_test() {
    let e = 2.0_f32.powi(-9);
    let corners = [Vec3::new(-e, -e, 1.0), Vec3::new(e, -e, 1.0), Vec3::new(0.0, e, 1.0)];
    let ray = WatertightTriangle::<F16>::ray([0.0; 3], [0.0, 0.0, 1.0]);
    let found = WatertightTriangle::<F16>::new(&corners).intersect::<false>(&ray);
    assert!(found.inside && found.t.to_f64() == 1.0, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn adaptive_is_exact_on_a_grid(
        origin in grid(), direction in grid(), (t_min, t_max) in range(), corners in [grid(), grid(), grid()]
    ) {
        adaptive_is_exact(&Ray { origin, direction, t_min, t_max }, &corners)?;
    }

    #[test]
    fn adaptive_is_exact_on_numbers_of_any_magnitude(
        origin in anything(), direction in anything(), (t_min, t_max) in range(),
        corners in [anything(), anything(), anything()]
    ) {
        adaptive_is_exact(&Ray { origin, direction, t_min, t_max }, &corners)?;
    }

    #[test]
    fn adaptive_is_exact_where_it_is_aimed(
        origin in generic(), corners in [generic(), generic(), generic()], u in 0.0_f32..1.0,
        kind in 0..4, flat in prop_oneof![Just(1.0), Just(1e-4), Just(1e-8), Just(0.0)], (t_min, t_max) in range()
    ) {
        let squeeze = |p: Vec3| p * Vec3::new(1.0, 1.0, flat);
        let (origin, corners) = (squeeze(origin), corners.map(squeeze));
        let point = match kind {
            0 => (u, 0.0),
            1 => (u, 1.0 - u),
            2 => (0.0, 0.0),
            _ => (u / 2.0, 0.25),
        };
        let direction = aimed(origin, corners, point);
        adaptive_is_exact(&Ray { origin, direction, t_min, t_max }, &corners)?;
    }

    #[test]
    fn adaptive_finds_the_first_on_a_grid(
        origin in grid(), direction in grid(), triangles in proptest::collection::vec([grid(), grid(), grid()], 1..5)
    ) {
        adaptive_finds_the_first(&Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }, &triangles)?;
    }

    /// Planes through a common point that the ray is aimed at: their distances differ by roundings.
    #[test]
    fn adaptive_finds_the_first_of_planes_through_a_point(
        origin in generic(), shared in generic(), others in proptest::collection::vec([generic(), generic()], 2..5),
        tilt in prop_oneof![Just(1.0_f32), Just(1e-3), Just(1e-7)]
    ) {
        let [b, c] = others[0];
        let triangles: Vec<_> =
            others.iter().map(|&[p, q]| [shared, b.lerp(p, tilt), c.lerp(q, tilt)]).collect();
        let direction = aimed(origin, triangles[0], (1e-6, 1e-6));
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        adaptive_finds_the_first(&ray, &triangles)?;
        // The same as two by two.
        let prepared: Vec<_> = triangles.iter().map(AdaptiveTriangle::new).collect();
        let hits: Vec<_> =
            prepared.iter().filter_map(|triangle| triangle.intersect(Edges::Shared, &AdaptiveRay::new(&ray))).collect();
        for a in &hits {
            for b in &hits {
                prop_assert_eq!(a.order(b, &ray), order(&ray, a.corners, b.corners));
            }
        }
    }

    /// Far from edges, and not grazing, every test is right.
    #[test]
    fn every_kernel_is_right_where_there_is_no_doubt(
        origin in generic(), corners in [generic(), generic(), generic()], u in 0.1_f32..0.4, v in 0.1_f32..0.4
    ) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let direction = aimed(origin, corners, (u, v));
        prop_assume!(normal.length() > 0.1 && direction.length() > 0.1);
        prop_assume!(normal.dot(direction).abs() > 0.1 * normal.length() * direction.length());
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        prop_assert!(judge(&ray, &corners) != Incidence::Miss);
        let t = nearest_f64(&solve(&ray, &corners).expect("hit").t);
        for kernel in Kernel::ALL {
            let found = intersect(kernel, Edges::Shared, &corners, &ray);
            prop_assert!(found.is_some_and(|found| (f64::from(found.t) - t).abs() < 1e-4), "{:?}", kernel);
        }
    }
}
