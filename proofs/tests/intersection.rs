//! The exact test is exact: it says what rational arithmetic says, of every ray and triangle on a small grid and of any
//! at random (IS-1 to IS-3). The theorems of the other tests and of the twin are judged by it.

mod support;

use glam::Vec3;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use saarcor_model::host::Edges;
use saarcor_model::rays::{ExactHit, Ray};
use saarcor_oracles::exact::rational::{incidence, nearest_f64};
use saarcor_oracles::exact::{Contact, Incidence, is_owned_hit, order, solve};
use support::engine;

/// Hit or not, where, and how the distance compares to that of another triangle.
fn is_exact(ray: &Ray, corners: &[Vec3; 3], other: &[Vec3; 3]) -> Result<Incidence, TestCaseError> {
    let right = incidence(ray, corners);
    let found = ExactHit::new(ray, corners, Edges::Shared);
    let owned = ExactHit::new(ray, corners, Edges::Owned);
    prop_assert_eq!(owned.is_some(), is_owned_hit(ray, corners), "owned, {:?} and {:?}", ray, corners);
    prop_assert_eq!(found.is_some(), right.is_hit(), "{:?} and {:?}: {:?}", ray, corners, right);
    let Some(found) = found else { return Ok(right) };
    let solution = solve(ray, corners).expect("a hit");
    for (found, right) in found.point().into_iter().zip([&solution.t, &solution.u, &solution.v]) {
        let right = nearest_f64(right);
        prop_assert!((found - right).abs() <= 2.0 * f64::EPSILON * right.abs(), "{} is not {}", found, right);
    }
    if let Some(other_hit) = ExactHit::new(ray, other, Edges::Shared) {
        prop_assert_eq!(
            found.order(&other_hit),
            order(ray, corners, other),
            "{:?}: {:?} and {:?}",
            ray,
            corners,
            other
        );
        prop_assert_eq!(other_hit.order(&found), order(ray, other, corners));
    }
    Ok(right)
}

/// Triangles with corners of 0, 1 and 2, of either winding, rays from two points to all of a finer grid, and ranges that
/// begin or end where triangles are hit.
#[test]
fn exact_on_a_grid() {
    let origins = [Vec3::new(0.0, 1.0, -2.0), Vec3::new(1.0, -0.0, 2.0)];
    let (mut hits, mut edges, mut vertices, mut misses) = (0, 0, 0, 0);
    let corner =
        |number: u32| Vec3::new((number % 3) as f32, (number / 3 % 3) as f32, (number / 9 % 2) as f32);
    let mut last = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for number in 0..18_u32 * 18 * 18 {
        let corners = [corner(number % 18), corner(number / 18 % 18), corner(number / 324)];
        for origin in origins {
            // Each triangle meets one of the directions, which come in turn.
            let turn = number.wrapping_mul(7).wrapping_add(origin.z as u32 & 3);
            let target =
                Vec3::new((turn % 5) as f32 / 2.0, (turn / 5 % 5) as f32 / 2.0, (turn / 25 % 3) as f32 - 0.5);
            for (t_min, t_max) in [(0.0, f32::INFINITY), (1.0, 2.0), (0.0, 1.0)] {
                let ray = Ray { origin, direction: target - origin, t_min, t_max };
                match is_exact(&ray, &corners, &last).expect("exact") {
                    Incidence::Miss => misses += 1,
                    Incidence::Hit(Contact::Interior) => hits += 1,
                    Incidence::Hit(Contact::Edge(_)) => edges += 1,
                    Incidence::Hit(Contact::Vertex(_)) => vertices += 1,
                }
            }
        }
        last = corners;
    }
    println!("{hits} inside, {edges} on edges, {vertices} at vertices, {misses} missed");
    assert!(hits > 100 && edges > 100 && vertices > 100 && misses > 1000);
}

/// Numbers of every magnitude, zeros of both signs and denormals; now and then NaN and infinity.
fn number() -> impl Strategy<Value = f32> {
    use proptest::num::f32::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let whole = (-3_i8..=3).prop_map(f32::from);
    let none = prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)];
    prop_oneof![30 => POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO, 30 => whole, 1 => none]
}

fn point() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from)
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn exact_for_any_numbers(
        corners in [point(), point(), point()],
        other in [point(), point(), point()],
        origin in point(),
        direction in point(),
        (u, v) in prop_oneof![Just((0.0, 0.0)), Just((0.5, 0.5)), Just((0.25, 0.25)), (-0.1..1.1_f32, -0.1..1.1_f32)],
        aimed in any::<bool>(),
        (t_min, t_max) in prop_oneof![3 => Just((0.0, f32::INFINITY)), 1 => Just((1.0, 2.0)), 1 => Just((f32::NAN, 1.0)), 1 => Just((0.0, f32::NAN))],
    ) {
        let [a, b, c] = corners;
        let direction = if aimed { a * (1.0 - u - v) + b * u + c * v - origin } else { direction };
        is_exact(&Ray { origin, direction, t_min, t_max }, &corners, &other)?;
    }
}
