//! The adaptive test: exact hits at the cost of a fast test.

use super::Candidate;
use super::expansion::{self, SIX_FACTORS, THREE_FACTORS, two_product, two_sum};
use super::number::{Triple, dominant_axis, sub};
use crate::ray::Ray;
use glam::{DVec3, Vec3};
use std::cmp::Ordering;

/// A number of up to three factors, exactly.
type Expansion = expansion::Expansion<THREE_FACTORS>;

/// The roundoff of f64.
const UNIT: f64 = f64::EPSILON / 2.0;

/// A triangle prepared for the adaptive test: Wald's projection test, counted from a corner and
/// computed in f64, with a bound of its error; exact arithmetic only where that leaves a doubt.
///
/// Whether a triangle is hit, whether within the ray's range, and which of two is hit first are so
/// decided as if nothing were rounded:
///
/// * Contact: edges and vertices belong to the triangle, exactly. A ray through the edge of two
///   triangles hits both at the same distance, and the lower address owns it (IS-2).
/// * Without area, or with the ray in the plane: a miss, since they have no one point in common.
/// * NaN and infinity: a miss.
///
/// **Error of the words.** u = 2⁻⁵³. The edges are off by u of themselves if a difference is not
/// exact, as it is for coordinates within 29 bits. A component of the normal, the difference of two products with
/// their rounding errors added, is off by ν n, where n is the largest component,
/// ν = 3u + σ M / n, M is the largest sum of two such products without their signs, and σ = 4u²,
/// or 4u with inexact edges. Quotients of the plane, which are at most 1, are off by 2ν/(1 - ν) + u,
/// weights by ν/(1 - ν) + 3u of themselves: both by ε = 2.5ν + 2u at most, if ν ≤ 1/16; otherwise
/// nothing is certain.
///
/// **Error of a test.** With S ≥ |o - a|, D the largest component of the direction, R = S + |t| D,
/// r = 1/across and ρ = D r: `across` is off by 3.3 ε D (three roundings, γ(3) · 3 D ≤ ε D, and two
/// words), the distance to the plane by 3.3 ε S, so that t, if 3.3 ε ρ ≤ 1/4, is off by
/// 4/3 · 3.3 ε R r + 3u |t| ≤ 6 ε R r (ρ ≥ 1/3, since |across| ≤ 3 D). A coordinate of the point
/// is off by (5.1 ρ + 0.5) ε R, a weight by 21 L ε ρ R, where L is the largest word of the weights,
/// and the third weight by the sum of both: all by 64 L ε ρ R, which includes the roundings of the
/// bound itself.
/// Where 3.3 ε ρ > 1/4, this bound exceeds 4 L R, which no weight does: so nothing is then certain.
/// f64 neither overflows nor underflows where it matters: a bound that is NaN or infinite is no
/// certainty, and L R is no less than 1/4 where there is an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveTriangle {
    corners: [Vec3; 3],
    /// The first corner.
    corner: Triple<f64>,
    /// Along which the triangle is projected.
    axis: usize,
    /// The plane's slopes along the two axes after it: the normal is 1 along `axis`.
    plane: [f64; 2],
    /// Of the second and the third corner, along the two axes after `axis`.
    weights: [[f64; 2]; 2],
    /// The largest coordinate of the first corner.
    reach: f64,
    /// 64 L ε.
    weight_slack: f64,
    /// 6 ε.
    distance_slack: f64,
}

/// A ray as the adaptive test needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveRay {
    ray: Ray,
    origin: Triple<f64>,
    direction: Triple<f64>,
    /// The largest coordinate of the origin.
    reach: f64,
    /// The largest component of the direction.
    size: f64,
}

impl AdaptiveRay {
    /// The ray itself.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// From a ray.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &Ray) -> Self {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        Self {
            ray: *ray,
            origin: origin.to_array(),
            direction: direction.to_array(),
            reach: origin.abs().max_element(),
            size: direction.abs().max_element(),
        }
    }
}

/// What the fast test says, and how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    t: f64,
    u: f64,
    v: f64,
    /// The least weight.
    margin: f64,
    weight_error: f64,
    distance_error: f64,
}

impl Estimate {
    /// Whether the ray passes the triangle for certain.
    #[inline(always)]
    pub(super) fn is_outside(&self) -> bool {
        self.margin < -self.weight_error
    }
}

/// A hit of the adaptive test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveHit<'a> {
    /// Distance along the ray.
    pub t: f64,
    /// Barycentric weight of the second corner.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
    /// By how much `t` may be off.
    pub t_error: f64,
    /// The corners of the triangle, from which an order of hits that `t` leaves in doubt is decided.
    pub corners: &'a [Vec3; 3],
}

impl AdaptiveTriangle {
    /// From the corners.
    #[must_use]
    pub fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3().to_array());
        let (to_b, to_c) = (sub(b, a), sub(c, a));
        let is_exact = |end: Triple<f64>| (0..3).all(|axis| two_sum(end[axis], -a[axis]).1 == 0.0);
        let slack = if is_exact(b) && is_exact(c) { 4.0 * UNIT * UNIT } else { 4.0 * UNIT };
        let minors: [_; 3] = std::array::from_fn(|axis| {
            let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
            let (left, right) = (two_product(to_b[p], to_c[q]), two_product(to_b[q], to_c[p]));
            ((left.0 - right.0) + (left.1 - right.1), left.0.abs() + right.0.abs())
        });
        let normal = minors.map(|(value, _)| value);
        let axis = dominant_axis(normal);
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = normal[axis];
        let products = minors.iter().fold(0.0, |largest, (_, size)| size.max(largest));
        let weights = [[to_c[q] / area, -to_c[p] / area], [-to_b[q] / area, to_b[p] / area]];
        let largest = weights.as_flattened().iter().fold(0.0, |largest, word| word.abs().max(largest));
        let nu = 3.0 * UNIT + slack * (products / area.abs());
        let epsilon = if nu <= 1.0 / 16.0 { 2.5 * nu + 2.0 * UNIT } else { f64::INFINITY };
        Self {
            corners: *corners,
            corner: a,
            axis,
            plane: [normal[p] / area, normal[q] / area],
            weights,
            reach: DVec3::from_array(a).abs().max_element(),
            weight_slack: 64.0 * largest * epsilon,
            distance_slack: 6.0 * epsilon,
        }
    }

    /// The fast test.
    #[inline(always)]
    pub(super) fn estimate(&self, ray: &AdaptiveRay) -> Estimate {
        let (k, p, q) = (self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3);
        // Component by component: an array would be written before it is read by an index.
        let [d_k, d_p, d_q] = [k, p, q].map(|axis| ray.direction[axis]);
        let [from_k, from_p, from_q] = [k, p, q].map(|axis| ray.origin[axis] - self.corner[axis]);
        let across = d_k + self.plane[0] * d_p + self.plane[1] * d_q;
        let reciprocal = 1.0 / across;
        let t = -(from_k + self.plane[0] * from_p + self.plane[1] * from_q) * reciprocal;
        let (x, y) = (from_p + t * d_p, from_q + t * d_q);
        let [u, v] = self.weights.map(|[w_x, w_y]| w_x * x + w_y * y);
        let scale = (ray.reach + self.reach + t.abs() * ray.size) * reciprocal.abs();
        Estimate {
            t,
            u,
            v,
            margin: u.min(v).min(1.0 - u - v),
            weight_error: self.weight_slack * ray.size * scale,
            distance_error: self.distance_slack * scale,
        }
    }

    /// Whether `ray` hits the triangle within its range, exactly (IS-1, IS-2).
    #[inline(always)]
    #[must_use]
    pub fn intersect(&self, ray: &AdaptiveRay) -> Option<AdaptiveHit<'_>> {
        let found = self.estimate(ray);
        if found.is_outside() {
            return None;
        }
        if found.margin > found.weight_error {
            self.in_range(ray, &found)
        } else {
            self.intersect_exactly(&ray.ray)
        }
    }

    /// The hit at a point that is within the triangle, if it is within the range. Its distance is
    /// known to half a unit in the last place of an f32, so that, rounded, it is off by less than
    /// one: traversal cuts off by it what lies behind (KD-4).
    #[inline(always)]
    fn in_range(&self, ray: &AdaptiveRay, found: &Estimate) -> Option<AdaptiveHit<'_>> {
        let Estimate { t, u, v, distance_error: error, .. } = *found;
        let (t_min, t_max) = (f64::from(ray.ray.t_min), f64::from(ray.ray.t_max));
        let known = error <= t.abs() * f64::from(f32::EPSILON / 2.0);
        if known & ((t - t_min).abs() > error) & ((t - t_max).abs() > error) {
            let hit = AdaptiveHit { t, u, v, t_error: error, corners: &self.corners };
            ((t > t_min) & (t < t_max)).then_some(hit)
        } else {
            self.intersect_exactly(&ray.ray)
        }
    }

    /// Without rounding, but for that of the numbers in the end.
    #[cold]
    #[inline(never)]
    fn intersect_exactly(&self, ray: &Ray) -> Option<AdaptiveHit<'_>> {
        let volumes = Volumes::new(ray, &self.corners)?;
        if !volumes.are_inside() {
            return None;
        }
        let height = volumes.height();
        let starts = volumes.distance_to(&height, ray.t_min)? != Ordering::Less;
        let ends = volumes.distance_to(&height, ray.t_max)? == Ordering::Less;
        let sum = volumes.sum.nearest();
        let over_sum = |number: &Expansion| number.nearest() / sum;
        let t = over_sum(&height);
        (starts && ends).then(|| AdaptiveHit {
            t,
            u: over_sum(&volumes.weights[1]),
            v: over_sum(&volumes.weights[2]),
            // Numerator, divisor and quotient are each rounded once.
            t_error: 4.0 * UNIT * t.abs(),
            corners: &self.corners,
        })
    }
}

impl AdaptiveHit<'_> {
    /// Which of two hits of `ray` is nearer, exactly.
    #[inline(always)]
    #[must_use]
    pub fn order(&self, other: &AdaptiveHit, ray: &Ray) -> Ordering {
        let (difference, error) = (self.t - other.t, self.t_error + other.t_error);
        // The difference is itself rounded: by less than the bounds leave unused.
        if difference.abs() > error {
            if difference < 0.0 { Ordering::Less } else { Ordering::Greater }
        } else {
            self.order_exactly(other, ray)
        }
    }

    #[cold]
    #[inline(never)]
    fn order_exactly(&self, other: &AdaptiveHit, ray: &Ray) -> Ordering {
        let volumes = Volumes::new(ray, self.corners).zip(Volumes::new(ray, other.corners));
        let Some((a, b)) = volumes else { return Ordering::Equal };
        // a.height / a.sum against b.height / b.sum.
        let across = |height: Expansion, sum: &Expansion| height.times::<SIX_FACTORS>(sum);
        let order = across(a.height(), &b.sum).minus(&across(b.height(), &a.sum)).sign();
        if a.sum.sign() == b.sum.sign() { order } else { order.reverse() }
    }

    /// As a candidate in f32.
    #[inline]
    #[must_use]
    pub fn rounded(&self) -> Candidate {
        Candidate { t: self.t as f32, u: self.u as f32, v: self.v as f32, inside: true }
    }
}

/// With the corners counted from the origin: the weights of the corners where the ray's line meets
/// the plane, times their sum.
struct Volumes {
    weights: [Expansion; 3],
    sum: Expansion,
    corner: Triple<Expansion>,
    /// The cross product of the other two corners.
    others: Triple<Expansion>,
}

impl Volumes {
    /// `None` where line and plane have not just one point in common, or a number is NaN or
    /// infinite.
    fn new(ray: &Ray, corners: &[Vec3; 3]) -> Option<Self> {
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
        (sum.sign() != Ordering::Equal).then_some(Self { weights, sum, corner: a, others: b_c })
    }

    /// The distance, times the sum of the weights.
    fn height(&self) -> Expansion {
        let [x, y, z] = [0, 1, 2].map(|axis| self.corner[axis].times::<THREE_FACTORS>(&self.others[axis]));
        x.plus(&y).plus(&z)
    }

    /// Whether no weight has another sign than their sum.
    fn are_inside(&self) -> bool {
        self.weights.iter().all(|weight| weight.sign() != self.sum.sign().reverse())
    }

    /// How the distance, of this height, compares to `bound`; `None` where that is NaN.
    fn distance_to(&self, height: &Expansion, bound: f32) -> Option<Ordering> {
        if !bound.is_finite() {
            return 0.0.partial_cmp(&bound);
        }
        // Four factors, which need more room than three.
        let wide = |number: &Expansion, factor: f32| {
            let factor = expansion::Expansion::difference(f64::from(factor), 0.0);
            number.times::<SIX_FACTORS>(&factor)
        };
        let order = wide(height, 1.0).minus(&wide(&self.sum, bound)).sign();
        Some(if self.sum.sign() == Ordering::Greater { order } else { order.reverse() })
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Far from the origin of the coordinates the fast test knows a small distance badly.
    #[test]
    fn distances_are_known_to_an_f32() {
        let origin = Vec3::new(4096.0, -8192.0, 1024.0);
        let ahead = 2.0_f32.powi(-11);
        let corners =
            [[ahead, -1.0, -1.0], [ahead, 2.0, -1.0], [ahead, 0.0, 2.0]].map(|p| origin + Vec3::from(p));
        let triangle = AdaptiveTriangle::new(&corners);
        let direction = Vec3::new(1.0, 0.25, 0.125);
        let ray = AdaptiveRay::new(&Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY });
        let known = |t: f64| t * f64::from(f32::EPSILON / 2.0);
        let fast = triangle.estimate(&ray);
        assert!(fast.margin > fast.weight_error && fast.distance_error > known(fast.t), "{fast:?}");
        let hit = triangle.intersect(&ray).expect("inside");
        assert!(hit.t == f64::from(ahead) && hit.t_error <= known(hit.t), "{hit:?}");
    }
}
