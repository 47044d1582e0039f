//! The exact judge: its rationals against what is known, its filter against its rationals.

use glam::Vec3;
use proptest::prelude::*;
use saarcor_model::rays::Ray;
use saarcor_oracles::exact::filter::Estimate;
use saarcor_oracles::exact::rational::{distance, incidence, nearest_f32, nearest_f64};
use saarcor_oracles::exact::{Contact, Incidence, closest, judge, order, solve};
use std::cmp::Ordering;

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

/// A ray along z that meets the plane z = 0 at distance 1.
fn along_z(x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::new(x, y, -1.0), direction: Vec3::Z, t_min: 0.0, t_max: f32::INFINITY }
}

/// Whole numbers, so small that contact, coplanarity and coincidence are frequent.
fn grid() -> impl Strategy<Value = Vec3> {
    let coordinate = || (-2_i8..=2).prop_map(f32::from);
    (coordinate(), coordinate(), coordinate()).prop_map(Vec3::from)
}

/// Numbers of every magnitude, zeros of both signs and denormals.
fn anything() -> impl Strategy<Value = Vec3> {
    use proptest::num::f32::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let coordinate = || POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO;
    (coordinate(), coordinate(), coordinate()).prop_map(Vec3::from)
}

/// Numbers of one magnitude.
fn generic() -> impl Strategy<Value = Vec3> {
    let coordinate = || -1.0_f32..1.0;
    (coordinate(), coordinate(), coordinate()).prop_map(Vec3::from)
}

/// Rays with corners, whose coordinates `point` gives, and ranges that begin or end near 1.
fn cases<P: Strategy<Value = Vec3>>(point: fn() -> P) -> impl Strategy<Value = (Ray, [Vec3; 3])> {
    let t_min = prop_oneof![Just(0.0), Just(1.0), Just(f32::NEG_INFINITY)];
    let t_max = prop_oneof![Just(f32::INFINITY), Just(1.0), Just(2.0)];
    (point(), point(), t_min, t_max, [point(), point(), point()]).prop_map(
        |(origin, direction, t_min, t_max, corners)| (Ray { origin, direction, t_min, t_max }, corners),
    )
}

/// What the filter says, where it says anything, is what the rationals say.
fn filter_agrees(ray: &Ray, corners: &[Vec3; 3]) -> Result<(), TestCaseError> {
    let estimate = Estimate::new(ray, corners);
    if let Some(said) = estimate.incidence() {
        prop_assert_eq!(said, incidence(ray, corners));
    }
    let bounds = estimate.distance();
    if let Some(solution) = solve(ray, corners) {
        let t = nearest_f64(&solution.t);
        prop_assert!(bounds.least <= t && t <= bounds.greatest, "{} outside of {:?}", t, bounds);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn filter_agrees_on_a_grid((ray, corners) in cases(grid)) {
        filter_agrees(&ray, &corners)?;
    }

    #[test]
    fn filter_agrees_on_numbers_of_any_magnitude((ray, corners) in cases(anything)) {
        filter_agrees(&ray, &corners)?;
    }

    #[test]
    fn filter_agrees_near_edges_and_vertices(
        (ray, corners) in cases(generic), u in 0.0_f32..1.0, at in 0..3_usize, vertex in any::<bool>()
    ) {
        let u = if vertex { 0.0 } else { u };
        let aim = corners[at] * (1.0 - u) + corners[(at + 1) % 3] * u;
        filter_agrees(&Ray { direction: aim - ray.origin, ..ray }, &corners)?;
    }

    #[test]
    fn filter_decides_the_generic_case((ray, corners) in cases(generic)) {
        prop_assert!(Estimate::new(&ray, &corners).incidence().is_some());
    }

    /// Turning the corners around, or the ray's line over, changes what they are called only.
    #[test]
    fn order_of_the_corners_does_not_matter((ray, [a, b, c]) in cases(grid)) {
        let turned = match judge(&ray, &[b, c, a]) {
            Incidence::Miss => Incidence::Miss,
            Incidence::Hit(Contact::Interior) => Incidence::Hit(Contact::Interior),
            Incidence::Hit(Contact::Edge(at)) => Incidence::Hit(Contact::Edge((at + 1) % 3)),
            Incidence::Hit(Contact::Vertex(at)) => Incidence::Hit(Contact::Vertex((at + 1) % 3)),
        };
        prop_assert_eq!(judge(&ray, &[a, b, c]), turned);
        prop_assert_eq!(judge(&ray, &[c, b, a]).is_hit(), turned.is_hit());
    }

    /// The first among triangles is what sorting all exact distances finds.
    #[test]
    fn closest_is_the_least_distance(
        (ray, first) in cases(grid), more in proptest::collection::vec([grid(), grid(), grid()], 0..6)
    ) {
        let triangles: Vec<_> = (10..).zip(std::iter::once(first).chain(more)).collect();
        let hit = triangles.iter().filter(|(_, corners)| incidence(&ray, corners).is_hit());
        let hit: Vec<_> = hit.map(|(number, corners)| (*number, distance(&ray, corners))).collect();
        let least = hit.iter().map(|(_, t)| t).min();
        let expected: Vec<u32> = hit.iter().filter(|(_, t)| Some(t) == least).map(|(n, _)| *n).collect();
        let found = closest(&ray, triangles.iter().copied());
        let found = found.map_or_else(Vec::new, |it| it.triangles.iter().map(|(n, _)| *n).collect());
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn order_is_that_of_the_distances((ray, a) in cases(grid), b in [grid(), grid(), grid()]) {
        if let Some((first, second)) = distance(&ray, &a).zip(distance(&ray, &b)) {
            prop_assert_eq!(order(&ray, &a, &b), first.cmp(&second));
        }
    }

    /// No f32 is nearer to a quotient than the one said to be nearest.
    #[test]
    fn rounding_is_to_the_nearest(a in any::<f32>(), b in any::<f32>(), c in any::<f32>()) {
        let rational = |value: f32| dashu_ratio::RBig::try_from(value).ok();
        let (Some(a), Some(b), Some(c)) = (rational(a), rational(b), rational(c)) else { return Ok(()) };
        if b.is_zero() {
            return Ok(());
        }
        let number = a / b * c;
        let nearest = nearest_f32(&number);
        if nearest.is_infinite() {
            return Ok(());
        }
        let off = |value: f32| {
            let off = rational(value).expect("finite") - &number;
            if off < dashu_ratio::RBig::ZERO { -off } else { off }
        };
        for neighbour in [nearest.next_up(), nearest.next_down()].into_iter().filter(|n| n.is_finite()) {
            prop_assert!(off(nearest) <= off(neighbour));
        }
    }
}

#[test]
fn denormals_are_rounded_to_the_nearest() {
    // 1.4e-45 is the least denormal: a third of it is nearer to 0, two thirds to it.
    let tiny = f32::from_bits(1);
    let ray = |direction| Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: f32::INFINITY };
    let corners = |z| [Vec3::new(-1.0, -1.0, z), Vec3::new(3.0, -1.0, z), Vec3::new(-1.0, 3.0, z)];
    let t = |z: f32, d: f32| nearest_f32(&solve(&ray(Vec3::Z * d), &corners(z)).expect("not parallel").t);
    assert_eq!(t(tiny, 3.0), 0.0);
    assert_eq!(t(tiny, 1.5), tiny);
    assert_eq!(t(f32::MAX, 0.5), f32::INFINITY);
}

#[test]
fn edges_and_vertices_belong_to_the_triangle() {
    for (x, y, contact) in [
        (0.25, 0.25, Contact::Interior),
        (0.0, 0.5, Contact::Edge(1)),
        (0.5, 0.0, Contact::Edge(2)),
        (0.5, 0.5, Contact::Edge(0)),
        (0.0, 0.0, Contact::Vertex(0)),
        (-0.0, -0.0, Contact::Vertex(0)),
        (1.0, 0.0, Contact::Vertex(1)),
        (0.0, 1.0, Contact::Vertex(2)),
    ] {
        assert_eq!(judge(&along_z(x, y), &CORNERS), Incidence::Hit(contact));
    }
    let least = f32::from_bits(1);
    for (x, y) in [(-least, 0.5), (0.5, -least), (0.5, 0.5_f32.next_up())] {
        assert_eq!(judge(&along_z(x, y), &CORNERS), Incidence::Miss);
    }
}

#[test]
fn range_holds_its_begin_and_not_its_end() {
    let ray = |t_min, t_max| Ray { t_min, t_max, ..along_z(0.25, 0.25) };
    let hit = |t_min, t_max| judge(&ray(t_min, t_max), &CORNERS).is_hit();
    assert!(hit(1.0, 1.0_f32.next_up()) && hit(f32::NEG_INFINITY, 2.0));
    assert!(!hit(0.0, 1.0) && !hit(1.0_f32.next_up(), 2.0) && !hit(f32::INFINITY, f32::INFINITY));
    assert!(!hit(0.0, f32::NEG_INFINITY) && !hit(f32::NAN, 2.0) && !hit(0.0, f32::NAN));
}

#[test]
fn no_one_point_in_common_is_a_miss() {
    let in_plane = Ray { origin: Vec3::NEG_X, direction: Vec3::X, ..along_z(0.0, 0.0) };
    let still = Ray { direction: Vec3::ZERO, origin: Vec3::new(0.25, 0.25, 0.0), ..in_plane };
    for ray in [in_plane, still] {
        assert_eq!((judge(&ray, &CORNERS), solve(&ray, &CORNERS)), (Incidence::Miss, None));
    }
    for flat in [[Vec3::ZERO; 3], [Vec3::NEG_X, Vec3::ZERO, Vec3::X]] {
        assert_eq!(judge(&along_z(0.0, 0.0), &flat), Incidence::Miss);
    }
}

#[test]
fn numbers_that_are_none_are_misses() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let ray = along_z(0.25, 0.25);
        assert_eq!(judge(&Ray { origin: ray.origin.with_z(bad), ..ray }, &CORNERS), Incidence::Miss);
        assert_eq!(judge(&Ray { direction: ray.direction.with_x(bad), ..ray }, &CORNERS), Incidence::Miss);
        for corner in 0..3 {
            let mut corners = CORNERS;
            corners[corner].z = bad;
            assert_eq!(judge(&ray, &corners), Incidence::Miss);
        }
    }
}

#[test]
fn order_tells_hits_that_no_f32_tells_apart() {
    // Planes through one line, the second turned by less than an f32 shows at the hit.
    let b = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, f32::from_bits(1)), Vec3::new(0.0, 1.0, 0.0)];
    let ray = along_z(0.25, 0.25);
    assert_eq!(order(&ray, &CORNERS, &b), Ordering::Less);
    assert_eq!(order(&ray, &b, &CORNERS), Ordering::Greater);
    assert_eq!(order(&ray, &CORNERS, &CORNERS), Ordering::Equal);
}
