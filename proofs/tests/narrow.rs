//! What the certificates assume and Gappa does not say, over all numbers of small formats: an operation keeps to the standard model, a sum does not
//! underflow, rounding keeps the order of products, so that an edge function has its true sign or is 0; and with that the watertight test in such
//! a format hits exactly one of two triangles at an edge that it owns (IS-6).

use glam::Vec2;
use saarcor_model::rays::{Number as _, TriangleTest as _, WatertightTriangle};
use saarcor_oracles::formats::{Format as _, Narrow};

/// All numbers of the format that are finite and not negative, in ascending order.
fn numbers<const E: u32, const M: u32>() -> Vec<Narrow<E, M>> {
    let least = 2.0 * Narrow::<E, M>::UNDERFLOW;
    let mut numbers = vec![Narrow::round(0.0)];
    while numbers[numbers.len() - 1].to_f64() < Narrow::<E, M>::MAX {
        let last = numbers[numbers.len() - 1].to_f64();
        // The least step that is not rounded away.
        let step = (0..).map(|power| least * f64::from(1_u32 << power));
        let mut next =
            step.map(|step| Narrow::<E, M>::round(last + step)).filter(|next| next.to_f64() > last);
        numbers.push(next.next().expect("a step"));
    }
    assert_eq!(numbers.len(), ((1 << E) - 1) << M, "each finite number");
    numbers
}

/// Each operation on all pairs of numbers of either sign is off by u of the exact result at most, and where it may underflow by half of the
/// least number more: products and quotients, but no sum and no difference.
fn keeps_to_the_standard_model<const E: u32, const M: u32>() {
    let positive = numbers::<E, M>();
    let all = positive.iter().flat_map(|&x| [x, -x]);
    let (unit, tiny) = (Narrow::<E, M>::ROUNDOFF, Narrow::<E, M>::UNDERFLOW);
    let mut underflows = 0;
    for a in all.clone() {
        for b in all.clone() {
            let (x, y) = (a.to_f64(), b.to_f64());
            // A quotient is off by nothing that matters in f64; the others are exact there.
            for (found, right, least) in
                [(a + b, x + y, 0.0), (a - b, x - y, 0.0), (a * b, x * y, tiny), (a / b, x / y, tiny)]
            {
                if !found.is_finite() {
                    // Beyond the greatest number, or by nothing.
                    assert!(y == 0.0 || right.abs() > Narrow::<E, M>::MAX, "{a:?} and {b:?}: {found:?}");
                    continue;
                }
                let error = (found.to_f64() - right).abs();
                assert!(
                    error <= unit * right.abs() * (1.0 + 1e-12) + least,
                    "{a:?} and {b:?}: {found:?}, {right}"
                );
                underflows += u32::from(error > unit * right.abs());
            }
        }
    }
    assert!(underflows > 0);
}

#[test]
fn operations_keep_to_the_standard_model() {
    keeps_to_the_standard_model::<4, 3>();
    keeps_to_the_standard_model::<5, 2>();
}

/// The difference of two products, as computed, has the sign of the exact one or is 0; f64 orders exact products.
fn differences_have_their_signs<const E: u32, const M: u32>() {
    let numbers = numbers::<E, M>();
    let mut products: Vec<(f64, Narrow<E, M>)> = Vec::new();
    for (first, &a) in numbers.iter().enumerate() {
        products.extend(
            numbers[first..].iter().map(|&b| (a.to_f64() * b.to_f64(), a * b)).filter(|(_, p)| p.is_finite()),
        );
    }
    products.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut zeros, mut signs) = (0_u64, 0_u64);
    for (place, &(exact, product)) in products.iter().enumerate() {
        for &(other_exact, other) in &products[place..] {
            let difference = (other - product).to_f64();
            assert!(
                difference >= 0.0 && (difference == 0.0 || other_exact > exact),
                "{exact} and {other_exact}: {difference}"
            );
            zeros += u64::from(difference == 0.0 && other_exact > exact);
            signs += u64::from(difference > 0.0);
        }
    }
    assert!(zeros > 1000 && signs > 1_000_000, "{zeros} differences are lost, {signs} are not");
}

#[test]
fn rounding_keeps_the_order_of_products() {
    differences_have_their_signs::<4, 3>();
    differences_have_their_signs::<5, 2>();
}

/// A ray along z from the origin, and two triangles on either side of each edge between two points of all numbers of 1-3-2 up to 1: more, and
/// sides would overflow.
#[test]
fn watertight_test_of_a_small_format_hits_one_side_of_an_edge() {
    type R = Narrow<3, 2>;
    let positive = numbers::<3, 2>().into_iter().map(|x| x.to_f64() as f32).filter(|x| *x <= 1.0);
    let numbers: Vec<f32> = positive.flat_map(|x| if x == 0.0 { vec![x] } else { vec![x, -x] }).collect();
    let points: Vec<Vec2> =
        numbers.iter().flat_map(|&x| numbers.iter().map(move |&y| Vec2::new(x, y))).collect();
    // What f32 computes exactly of these.
    let side = |p: Vec2, q: Vec2| p.perp_dot(q);
    let ray = WatertightTriangle::<R>::ray([0.0; 3], [0.0, 0.0, 1.0]);
    let hits = |corners: [Vec2; 3]| {
        let test = WatertightTriangle::<R>::new(&corners.map(|corner| corner.extend(1.0)));
        u32::from(test.intersect::<true>(&ray).inside)
    };
    let ends = [
        Vec2::new(2.0, 2.0),
        Vec2::new(-2.0, 1.0),
        Vec2::new(1.5, -2.0),
        Vec2::new(-1.0, -2.0),
        Vec2::new(0.0, 2.0),
    ];
    let (mut inside, mut outside, mut at_edges) = (0, 0, 0);
    for (&p, &q) in points.iter().flat_map(|p| points.iter().map(move |q| (p, q))) {
        for (left, right) in ends.iter().flat_map(|&left| ends.iter().map(move |&right| (left, right))) {
            // Both are seen from the front, and so far from their edges that no sum of sides is rounded to 0.
            if side(q - p, left - p) < 1.0 || side(p - q, right - q) < 1.0 {
                continue;
            }
            let [p_right, right_q, q_left, left_p] =
                [side(p, right), side(right, q), side(q, left), side(left, p)];
            // Where the ray meets the rim, more triangles would have to be looked at.
            if [p_right, right_q, q_left, left_p].contains(&0.0) {
                continue;
            }
            let exact = side(p, q);
            let in_left = exact >= 0.0 && q_left > 0.0 && left_p > 0.0;
            let in_right = exact <= 0.0 && p_right > 0.0 && right_q > 0.0;
            let covered = in_left || in_right;
            assert_eq!(
                hits([p, q, left]) + hits([q, p, right]),
                u32::from(covered),
                "{p} to {q}, {left} and {right}"
            );
            inside += u32::from(covered);
            outside += u32::from(!covered);
            at_edges += u32::from(covered && exact == 0.0);
        }
    }
    assert!(inside > 10_000 && outside > 10_000 && at_edges > 1000, "{inside}, {outside}, {at_edges}");
}
