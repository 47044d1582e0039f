//! The filter: the same volumes as in [`super::rational`], in f64 with an error bound.
//!
//! Every f32 is an f64, so that a difference of two coordinates takes one rounding, and a volume
//! of three factors at most eight: the two differences, their products, the difference of these,
//! the product with the third factor (for the height a difference too), and two sums. The computed
//! volume is then off by at most γ(8) = 8u / (1 - 8u), u = 2⁻⁵³, times the sum of the absolute
//! values of its products (Higham 2002, §3.1), which is computed in as many roundings:
//! γ(8) · (1 + γ(8)) < 10u. Neither overflow nor underflow is possible: f32 lie between 2⁻¹⁴⁹ and
//! 2¹²⁸, so that products of four of them lie between 2⁻⁵⁹⁶ and 2⁵¹⁶.

use super::{Contact, Incidence};
use glam::{DVec3, Vec3};
use saarcor_model::rays::Ray;

/// Half the distance from 1 to the next f64.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Relative to the sum of absolute products: the bound of a volume's error, see above.
const VOLUME_ERROR: f64 = 10.0 * UNIT;

/// A number and by how much it may be off. Where the true number is NaN or infinite, so is one of
/// the two, and every comparison fails.
#[derive(Clone, Copy, Debug)]
struct Approximate {
    value: f64,
    error: f64,
}

impl Approximate {
    /// `a · (b × c)`.
    #[inline]
    fn volume(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let value =
            a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
        let [a, b, c] = [a.abs(), b.abs(), c.abs()];
        let size =
            a.x * (b.y * c.z + b.z * c.y) + a.y * (b.z * c.x + b.x * c.z) + a.z * (b.x * c.y + b.y * c.x);
        Self { value, error: VOLUME_ERROR * size }
    }

    /// 1 or −1 where the sign is certain, 0 where it is not.
    #[inline]
    fn sign(self) -> i32 {
        i32::from(self.value > self.error) - i32::from(self.value < -self.error)
    }
}

/// The sign of `a · (b × c)` where it is certain, else 0; each coordinate of these may be off by a rounding.
#[inline]
pub(super) fn volume_sign(a: DVec3, b: DVec3, c: DVec3) -> i32 {
    Approximate::volume(a, b, c).sign()
}

/// Where a distance lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// No more than the distance.
    pub least: f64,
    /// No less than the distance.
    pub greatest: f64,
}

/// The volumes of a ray and a triangle, estimated.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    weights: [Approximate; 3],
    sum: Approximate,
    height: Approximate,
    range: (f64, f64),
}

impl Estimate {
    /// Of `ray` and the triangle with these corners.
    #[inline]
    #[must_use]
    pub fn new(ray: &Ray, corners: &[Vec3; 3]) -> Self {
        let (origin, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (to_b, to_c) = (b - a, c - a);
        let (a, b, c) = (a - origin, b - origin, c - origin);
        Self {
            weights: [
                Approximate::volume(d, b, c),
                Approximate::volume(d, c, a),
                Approximate::volume(d, a, b),
            ],
            // From the edges, not from the weights: their products are smaller where the triangle is.
            sum: Approximate::volume(d, to_b, to_c),
            height: Approximate::volume(a, to_b, to_c),
            range: (f64::from(ray.t_min), f64::from(ray.t_max)),
        }
    }

    /// What is certain of the ray and the triangle; `None` where nothing is. Contact with an edge
    /// or a vertex is never certain.
    #[inline]
    #[must_use]
    pub fn incidence(&self) -> Option<Incidence> {
        let [a, b, c] = self.weights.map(Approximate::sign);
        // Weights of both signs, or all of one.
        if (a * b < 0) | (b * c < 0) | (c * a < 0) {
            // NaN and infinite coordinates do not come here: no sign is certain beside them.
            return Some(Incidence::Miss);
        }
        if a + b + c != 3 * a || a == 0 {
            return None;
        }
        let side = self.sum.sign();
        let (t_min, t_max) = self.range;
        match (side * self.beyond(t_min), side * self.beyond(t_max)) {
            (-1, _) | (_, 1) => Some(Incidence::Miss),
            (1, -1) => Some(Incidence::Hit(Contact::Interior)),
            _ => None,
        }
    }

    /// The sign of `height - bound · sum` where it is certain, else 0.
    #[inline]
    fn beyond(&self, bound: f64) -> i32 {
        if bound.is_infinite() {
            return if bound > 0.0 { -self.sum.sign() } else { self.sum.sign() };
        }
        let product = bound * self.sum.value;
        // The errors of both, and the roundings of the product and the difference.
        let error = self.height.error
            + bound.abs() * self.sum.error
            + 2.0 * UNIT * (self.height.value.abs() + 2.0 * product.abs());
        // The error itself takes less than six roundings.
        Approximate { value: self.height.value - product, error: error * (1.0 + 8.0 * UNIT) }.sign()
    }

    /// Where the distance lies: anywhere, if the sign of the sum is not certain.
    #[inline]
    #[must_use]
    pub fn distance(&self) -> Distance {
        let (height, sum) = (self.height, self.sum);
        let quotient = height.value / sum.value;
        // |height/sum - quotient| ≤ (Δheight + |quotient| Δsum) / |true sum| + u |quotient|; all
        // of it takes less than ten roundings.
        let slack = (height.error + quotient.abs() * sum.error) / (sum.value.abs() - sum.error);
        let slack = (slack + 2.0 * UNIT * quotient.abs()) * (1.0 + 16.0 * UNIT);
        if sum.sign() == 0 || !slack.is_finite() {
            return Distance { least: f64::NEG_INFINITY, greatest: f64::INFINITY };
        }
        let rounding = UNIT * (quotient.abs() + slack) * 2.0;
        Distance { least: quotient - slack - rounding, greatest: quotient + slack + rounding }
    }
}
