//! Exact volumes of a ray and a triangle, for numbers of any magnitude.
//!
//! Twin of [`saarcor_model::rays::ExactHit`], in expansions of f64.

use super::bounds::{SLOPE, UNIT};
use super::expansion::{self, SIX_FACTORS, THREE_FACTORS};
use glam::Vec3;
use saarcor_model::rays::{Ray, Triple};
use std::cmp::Ordering;

/// A number of up to three factors, exactly.
type Expansion = expansion::Expansion<THREE_FACTORS>;

/// The signs of the three weights and of their sum.
pub(super) type Signs = ([Ordering; 3], Ordering);

/// With the corners counted from the origin: the weights of the corners where the ray's line meets
/// the plane, times their sum.
pub(super) struct Volumes {
    weights: [Expansion; 3],
    sum: Expansion,
    /// The distance, times the sum of the weights.
    height: Expansion,
}

impl Volumes {
    /// `None` where line and plane have not just one point in common, or a number is NaN or
    /// infinite.
    pub(super) fn new(ray: &Ray, corners: &[Vec3; 3]) -> Option<Self> {
        let finite = ray.origin.is_finite() && ray.direction.is_finite();
        if !finite || !corners.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        let [a, b, c] = corners.map(|corner| {
            std::array::from_fn(|axis| {
                Expansion::difference(f64::from(corner[axis]), f64::from(ray.origin[axis]))
            })
        });
        let direction = ray.direction.to_array().map(f64::from);
        let b_c = cross(&b, &c);
        let weights =
            [along(&direction, &b_c), along(&direction, &cross(&c, &a)), along(&direction, &cross(&a, &b))];
        let sum = weights[0].plus(&weights[1]).plus(&weights[2]);
        (sum.sign() != Ordering::Equal).then(|| {
            let [x, y, z] = [0, 1, 2].map(|axis| a[axis].times::<THREE_FACTORS>(&b_c[axis]));
            Self { weights, sum, height: x.plus(&y).plus(&z) }
        })
    }

    /// The signs of the weights and of their sum.
    pub(super) fn signs(&self) -> Signs {
        (self.weights.each_ref().map(Expansion::sign), self.sum.sign())
    }

    /// Distance, and weights of the second and the third corner. Numerator, divisor and quotient are
    /// each rounded once.
    pub(super) fn point(&self) -> [f64; 3] {
        let over_sum = |number: &Expansion| number.nearest() / self.sum.nearest();
        [over_sum(&self.height), over_sum(&self.weights[1]), over_sum(&self.weights[2])]
    }

    /// How the distance compares to `bound`; `None` where that is NaN.
    pub(super) fn distance_to(&self, bound: f32) -> Option<Ordering> {
        if !bound.is_finite() {
            return 0.0.partial_cmp(&bound);
        }
        // Four factors, which need more room than three.
        let wide = |number: &Expansion, factor: f32| {
            let factor = expansion::Expansion::difference(f64::from(factor), 0.0);
            number.times::<SIX_FACTORS>(&factor)
        };
        let order = wide(&self.height, 1.0).minus(&wide(&self.sum, bound)).sign();
        Some(if self.sum.sign() == Ordering::Greater { order } else { order.reverse() })
    }

    /// How the distances compare of two triangles.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        // a.height / a.sum against b.height / b.sum.
        let across = |a: &Self, b: &Self| a.height.times::<SIX_FACTORS>(&b.sum);
        let order = across(self, other).minus(&across(other, self)).sign();
        if self.sum.sign() == other.sum.sign() { order } else { order.reverse() }
    }
}

/// The sign that the weight of 0 of an edge from `from` to `to` takes where edges are owned, if the weights' sum is positive:
/// that of the first component of `direction × (to - from)` that is not 0 (IS-6).
#[cold]
pub(super) fn slope_sign(direction: Vec3, from: Vec3, to: Vec3) -> Ordering {
    let component = |axis: usize| {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let [d_p, d_q] = [p, q].map(|axis| f64::from(direction[axis]));
        let [(to_p, from_p), (to_q, from_q)] =
            [p, q].map(|axis| (f64::from(to[axis]), f64::from(from[axis])));
        let (left, right) = (d_p * (to_q - from_q), d_q * (to_p - from_p));
        // Neither product underflows: where both are 0, nothing is rounded.
        let (difference, size) = (left - right, left.abs() + right.abs());
        if difference.abs() > SLOPE * UNIT * size || size == 0.0 {
            return difference.partial_cmp(&0.0).unwrap_or(Ordering::Equal);
        }
        let left = Expansion::difference(to_q, from_q).scaled(d_p);
        left.minus(&Expansion::difference(to_p, from_p).scaled(d_q)).sign()
    };
    (0..3).map(component).find(|sign| sign.is_ne()).unwrap_or(Ordering::Equal)
}

/// `a × b`.
fn cross(a: &Triple<Expansion>, b: &Triple<Expansion>) -> Triple<Expansion> {
    std::array::from_fn(|axis| {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        a[p].times::<THREE_FACTORS>(&b[q]).minus(&a[q].times(&b[p]))
    })
}

/// The product of a direction and a vector.
fn along(direction: &Triple<f64>, vector: &Triple<Expansion>) -> Expansion {
    let [x, y, z] = [0, 1, 2].map(|axis| vector[axis].scaled(direction[axis]));
    x.plus(&y).plus(&z)
}
