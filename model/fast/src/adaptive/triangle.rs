//! The fast test with a bound of its error, and what decides where that leaves a doubt.
//!
//! Twin of [`saarcor_model::rays::ExactHit`]: the same hits, and the same order of two hits.

use super::bounds::{
    DISTANCE, EXACT_EDGES, MARGIN, MOST_NU, NORMAL, QUOTIENT, ROUNDED_EDGES, ROUNDINGS, UNIT, WORDS,
};
use super::expansion::{two_product, two_sum};
use super::grid::Grid;
use super::volumes::{Signs, Volumes, slope_sign};
use glam::{DVec3, Vec3};
use saarcor_model::host::{Axis, Edges};
use saarcor_model::rays::{Ray, Triple};
use std::cmp::Ordering;

/// A triangle prepared for the adaptive test: Wald's projection test, counted from a corner and
/// computed in f64, with a bound of its error; exact arithmetic only where that leaves a doubt.
///
/// Whether a triangle is hit, whether within the ray's range, and which of two is hit first are so
/// decided as if nothing were rounded:
///
/// * Contact: edges and vertices belong to the triangle, exactly; where they are owned, to one of the
///   triangles (IS-6).
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
/// **Error of a test.** Nothing is divided before the ray is known to meet the triangle: the height
/// of the origin over the plane, the point and its weights are all times `across`, the direction's
/// component across the plane. With S ≥ |o - a|, D the largest component of the direction, and three
/// roundings, γ(3) · 3 ≤ ε: `across` is off by 2.9 ε D (its roundings, and two words), `height` by
/// 3.2 ε S (the differences besides), a coordinate `from · across - height · d` of the point by
/// 7.9 ε S D, since |across| ≤ 3.3 D and |height| ≤ 3.3 S, a weight by 32 L ε S D, where L is the largest
/// word of the weights, and the third one, `across - u - v`, by 69 L ε S D + 3.6 ε D. All are off by
/// E = 70 L ε D (S + 1/(8 L)) at most, which includes the roundings of E. Each of these numbers is one of
/// [`bounds`](super::bounds), with a certificate.
///
/// * Three weights of one sign, beyond E: inside. `across` then exceeds 3 E ≥ 26 ε D.
/// * A weight beyond E of another sign than `across`: outside, whatever the true sign of `across`. If it
///   is not the computed one, then |across| ≤ 2.9 ε D, less than that weight, which the other two have
///   to make up for: two signs are opposite.
///
/// The distance is `height` over `across`: if inside, off by (3.2 ε S + 2.9 ε |t| D) / |across| and
/// two roundings, where |t| itself may be off by a ninth: together less than 5 ε (S + |t| D) / |across|.
///
/// f64 neither overflows nor underflows where it matters: a bound that is NaN or infinite is no
/// certainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveTriangle {
    corners: [Vec3; 3],
    /// The axes in the order of the numbers below. The projection drops the first.
    axes: [u8; 3],
    /// The first corner.
    corner: Triple<f64>,
    /// The plane's slopes along the second and the third axis: the normal is 1 along the first.
    plane: [f64; 2],
    /// Of the second and the third corner, along the second and the third axis.
    weights: [[f64; 2]; 2],
    /// The largest coordinate of the first corner, and 1/(8 L).
    reach: f64,
    /// 70 L ε.
    weight_slack: f64,
    /// 5 ε.
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

/// What the fast test says, and how far it may be off. All but the bounds are times `across`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    across: f64,
    height: f64,
    u: f64,
    v: f64,
    /// The least weight, with the sign that it has over `across`.
    margin: f64,
    weight_error: f64,
    /// Of ray and triangle together: no less than S.
    reach: f64,
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
        let slack = if is_exact(b) && is_exact(c) { EXACT_EDGES * UNIT * UNIT } else { ROUNDED_EDGES * UNIT };
        let minors: [_; 3] = std::array::from_fn(|axis| {
            let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
            let (left, right) = (two_product(to_b[p], to_c[q]), two_product(to_b[q], to_c[p]));
            ((left.0 - right.0) + (left.1 - right.1), left.0.abs() + right.0.abs())
        });
        let normal = minors.map(|(value, _)| value);
        let axis = Axis::of_greatest(normal.map(f64::abs)) as usize;
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = normal[axis];
        let products = minors.iter().fold(0.0, |largest, (_, size)| size.max(largest));
        let weights = [[to_c[q] / area, -to_c[p] / area], [-to_b[q] / area, to_b[p] / area]];
        let largest = weights.as_flattened().iter().fold(0.0, |largest, word| word.abs().max(largest));
        let nu = NORMAL * UNIT + slack * (products / area.abs());
        let epsilon = if nu <= MOST_NU { WORDS * nu + ROUNDINGS * UNIT } else { f64::INFINITY };
        Self {
            corners: *corners,
            axes: [axis, p, q].map(|axis| axis as u8),
            corner: [a[axis], a[p], a[q]],
            plane: [normal[p] / area, normal[q] / area],
            weights,
            reach: DVec3::from_array(a).abs().max_element() + 0.125 / largest,
            weight_slack: MARGIN * largest * epsilon,
            distance_slack: DISTANCE * epsilon,
        }
    }

    /// The fast test.
    #[inline(always)]
    pub(super) fn estimate(&self, ray: &AdaptiveRay) -> Estimate {
        // Component by component: an array would be written before it is read by an index.
        let [k, p, q] = self.axes.map(usize::from);
        let [d_k, d_p, d_q] = [ray.direction[k], ray.direction[p], ray.direction[q]];
        let [a_k, a_p, a_q] = self.corner;
        let [from_k, from_p, from_q] = [ray.origin[k] - a_k, ray.origin[p] - a_p, ray.origin[q] - a_q];
        let across = d_k + (self.plane[0] * d_p + self.plane[1] * d_q);
        let height = from_k + (self.plane[0] * from_p + self.plane[1] * from_q);
        let (x, y) = (from_p * across - height * d_p, from_q * across - height * d_q);
        let [u, v] = self.weights.map(|[w_x, w_y]| w_x * x + w_y * y);
        let over_across = |weight: f64| weight * 1.0_f64.copysign(across);
        let reach = ray.reach + self.reach;
        Estimate {
            across,
            height,
            u,
            v,
            margin: least(over_across(u), over_across(v), over_across(across - u - v)),
            weight_error: self.weight_slack * (ray.size * reach),
            reach,
        }
    }

    /// Whether `ray` hits the triangle within its range, exactly (IS-1, IS-2, IS-6).
    #[inline(always)]
    #[must_use]
    pub fn intersect(&self, edges: Edges, ray: &AdaptiveRay) -> Option<AdaptiveHit<'_>> {
        let found = self.estimate(ray);
        if found.is_outside() {
            return None;
        }
        if found.margin > found.weight_error {
            self.in_range(edges, ray, &found)
        } else {
            self.intersect_exactly(edges, &ray.ray)
        }
    }

    /// The hit at a point that is within the triangle, if it is within the range. Its distance is
    /// known to half a unit in the last place of an f32, so that, rounded, it is off by less than
    /// one: traversal cuts off by it what lies behind (KD-4).
    #[inline(always)]
    fn in_range(&self, edges: Edges, ray: &AdaptiveRay, found: &Estimate) -> Option<AdaptiveHit<'_>> {
        let reciprocal = 1.0 / found.across;
        let t = -found.height * reciprocal;
        let error = self.distance_slack * ((found.reach + t.abs() * ray.size) * reciprocal.abs());
        let (t_min, t_max) = (f64::from(ray.ray.t_min), f64::from(ray.ray.t_max));
        let known = error <= t.abs() * f64::from(f32::EPSILON / 2.0);
        if known & ((t - t_min).abs() > error) & ((t - t_max).abs() > error) {
            let (u, v) = (found.u * reciprocal, found.v * reciprocal);
            let hit = AdaptiveHit { t, u, v, t_error: error, corners: &self.corners };
            ((t > t_min) & (t < t_max)).then_some(hit)
        } else {
            self.intersect_exactly(edges, &ray.ray)
        }
    }

    /// Without rounding, but for that of the numbers in the end.
    #[inline(always)]
    fn intersect_exactly(&self, edges: Edges, ray: &Ray) -> Option<AdaptiveHit<'_>> {
        // The hit is put together here, out of the cold function, so that the usual one stays in registers.
        let [t, u, v] = exact_point(ray, &self.corners, edges)?;
        Some(AdaptiveHit { t, u, v, t_error: exact_error(t), corners: &self.corners })
    }
}

/// Distance and weights where `ray` hits the triangle within its range.
#[cold]
#[inline(never)]
fn exact_point(ray: &Ray, corners: &[Vec3; 3], edges: Edges) -> Option<[f64; 3]> {
    if let Some(volumes) = Grid::new(ray, corners).and_then(|grid| grid.volumes(corners)) {
        if !is_inside(volumes.signs(), ray, corners, edges) {
            return None;
        }
        let point @ [t, ..] = volumes.point();
        let to = |bound| volumes.distance_to(bound, exact_error(t));
        if let Some((starts, ends)) = to(ray.t_min).zip(to(ray.t_max)) {
            return (starts != Ordering::Less && ends == Ordering::Less).then_some(point);
        }
    }
    let volumes = Volumes::new(ray, corners)?;
    if !is_inside(volumes.signs(), ray, corners, edges) {
        return None;
    }
    let starts = volumes.distance_to(ray.t_min)? != Ordering::Less;
    let ends = volumes.distance_to(ray.t_max)? == Ordering::Less;
    (starts && ends).then(|| volumes.point())
}

/// Whether a ray meets a triangle, by the signs of the three weights and of their sum (IS-1, IS-6).
fn is_inside((weights, sum): Signs, ray: &Ray, [a, b, c]: &[Vec3; 3], edges: Edges) -> bool {
    let opposite = [(b, c), (c, a), (a, b)];
    let belongs = |(sign, (from, to)): (Ordering, (&Vec3, &Vec3))| {
        sign == sum
            || sign.is_eq() && (edges == Edges::Shared || slope_sign(ray.direction, *from, *to) == sum)
    };
    sum.is_ne() && weights.into_iter().zip(opposite).all(belongs)
}

/// Which of two triangles that `ray` hits is nearer.
#[cold]
#[inline(never)]
fn exact_order(ray: &Ray, a: &[Vec3; 3], b: &[Vec3; 3]) -> Ordering {
    if a == b {
        return Ordering::Equal;
    }
    let on_grid = || {
        let grid = Grid::new(ray, a.iter().chain(b))?;
        Some(grid.volumes(a)?.order(&grid.volumes(b)?))
    };
    on_grid().unwrap_or_else(|| {
        let volumes = Volumes::new(ray, a).zip(Volumes::new(ray, b));
        volumes.map_or(Ordering::Equal, |(a, b)| a.order(&b))
    })
}

/// By how much a distance may be off as a numerator, a divisor and a quotient that are each rounded once.
fn exact_error(t: f64) -> f64 {
    QUOTIENT * UNIT * t.abs()
}

/// `a - b`.
#[inline(always)]
fn sub(a: Triple<f64>, b: Triple<f64>) -> Triple<f64> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The least of three numbers, NaN if the last is.
#[inline(always)]
fn least(a: f64, b: f64, c: f64) -> f64 {
    let least = if a < b { a } else { b };
    if least < c { least } else { c }
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
            // The corners alone: to pass a hit by reference would keep it in memory.
            exact_order(ray, self.corners, other.corners)
        }
    }

    /// Distance and weights in f32.
    #[inline]
    #[must_use]
    pub fn rounded(&self) -> [f32; 3] {
        [self.t, self.u, self.v].map(|number| number as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_by_the_roundoff_at_most() {
        assert!(1.0 + UNIT == 1.0 && 1.0 + UNIT.next_up() > 1.0);
    }

    #[test]
    fn a_ray_far_beside_a_triangle_passes_it_for_certain() {
        let triangle = AdaptiveTriangle::new(&[Vec3::ZERO, Vec3::X, Vec3::Y]);
        let at = |x, y| {
            let origin = Vec3::new(x, y, -1.0);
            let ray = Ray { origin, direction: Vec3::Z, t_min: 0.0, t_max: f32::INFINITY };
            triangle.estimate(&AdaptiveRay::new(&ray))
        };
        assert!([(-1.0, 0.5), (0.5, -1.0), (1.0, 1.0)].iter().all(|&(x, y)| at(x, y).is_outside()));
        // Within, and at an edge.
        assert!(!at(0.25, 0.25).is_outside() && !at(0.5, 0.5).is_outside());
    }

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
        let error = triangle.distance_slack * fast.reach / fast.across.abs();
        assert!(fast.margin > fast.weight_error && error > known(f64::from(ahead)), "{fast:?}");
        let hit = triangle.intersect(Edges::Shared, &ray).expect("inside");
        assert!(hit.t == f64::from(ahead) && hit.t_error <= known(hit.t), "{hit:?}");
    }

    /// So it is on both sides of where the fast test begins to know it well enough.
    #[test]
    fn every_distance_of_a_hit_is_known_to_half_of_the_last_place() {
        let origin = Vec3::new(4096.0, -8192.0, 1024.0);
        let (mut fast, mut exactly) = (0, 0);
        for step in 0..200 {
            let ahead = 2.0_f32.powi(-20 + step / 10) * (1.0 + 0.1 * (step % 10) as f32);
            let corners = [[ahead, -9.0, -9.0], [ahead, 18.0, -9.0], [ahead, 0.0, 18.0]];
            let triangle = AdaptiveTriangle::new(&corners.map(|p| origin + Vec3::from(p)));
            let direction = Vec3::new(1.0, 0.25, 0.125);
            let ray = AdaptiveRay::new(&Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY });
            let Some(hit) = triangle.intersect(Edges::Shared, &ray) else { continue };
            assert!(hit.t_error <= hit.t * f64::from(f32::EPSILON / 2.0), "{hit:?}");
            if hit.t_error <= exact_error(hit.t) { exactly += 1 } else { fast += 1 }
        }
        assert!(fast > 20 && exactly > 20, "{fast} by the fast test, {exactly} exactly");
    }

    /// Numbers from -1 to 1 that look random: Knuth's linear congruential generator (MMIX).
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 * 2.0_f32.powi(-23) - 1.0
        }
    }

    /// Along a sliver, which a ray meets at a small angle and far from its first corner, and with directions short and
    /// long, a distance is off by much more than it would be otherwise.
    #[test]
    fn no_distance_is_off_by_more_than_its_bound() {
        let mut number = numbers();
        let mut point = |size: f32| Vec3::new(number(), number(), number()) * size;
        let (mut fast, mut worst) = (0, 0.0_f64);
        for round in 0..20_000 {
            let a = point(1.0);
            let corners = [a, a + point(1.0), a + point(1.0e4)];
            let aim = corners[0] * 0.3 + corners[1] * 0.1 + corners[2] * 0.6;
            let origin = a + point(1.0);
            let direction = (aim - origin) * 2.0_f32.powi([-20, -10, 0, 10, 20][round % 5]);
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            let triangle = AdaptiveTriangle::new(&corners);
            let Some(hit) = triangle.intersect(Edges::Shared, &AdaptiveRay::new(&ray)) else { continue };
            let volumes = Volumes::new(&ray, &corners).expect("a hit");
            let [t, ..] = volumes.point();
            // What is taken for the truth is rounded, too.
            let allowed = hit.t_error + exact_error(t);
            assert!((hit.t - t).abs() <= allowed, "{ray:?} and {corners:?}: {t}, {hit:?}");
            fast += i32::from(hit.t_error > exact_error(hit.t));
            worst = worst.max((hit.t - t).abs() / t / f64::EPSILON);
        }
        assert!(fast > 1000 && worst > 100.0, "{fast} by the fast test, off by up to {worst} units");
    }

    /// Two triangles meet at an edge, and a ray goes through its middle: computed from each of them, the distance is
    /// rounded otherwise.
    #[test]
    fn triangles_that_share_an_edge_are_hit_there_at_the_same_distance() {
        let mut number = numbers();
        let mut point = || (Vec3::new(number(), number(), number()) * 2.0_f32.powi(19)).round() * 2.0;
        let mut differ = 0;
        for round in 0..2_000 {
            let [p, q, c, d, from] = std::array::from_fn(|_| point());
            let middle = (p + q) / 2.0;
            // At a third of a power of two, or at 0.
            let step = 2.0_f32.powi([-10, 0, 10][round % 3]);
            let origin = if round % 4 == 0 { middle } else { from };
            let direction = (middle - from) * 3.0 / step;
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            let triangles = [[p, q, c], [d, p, q]].map(|corners| AdaptiveTriangle::new(&corners));
            let ray_at_hand = AdaptiveRay::new(&ray);
            let [a, b] = [0, 1].map(|number| {
                triangles[number].intersect(Edges::Shared, &ray_at_hand).expect("through the edge")
            });
            assert_eq!(
                (a.order(&b, &ray), b.order(&a, &ray)),
                (Ordering::Equal, Ordering::Equal),
                "{a:?}, {b:?}"
            );
            differ += i32::from(a.t != b.t);
        }
        assert!(differ > 100, "{differ} pairs are rounded otherwise");
    }

    #[test]
    fn the_nearer_of_two_triangles_is_hit_first() {
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, t_min: 0.0, t_max: f32::INFINITY };
        let at = |distance: f32| {
            let corner = |x, y| Vec3::new(x, y, distance);
            AdaptiveTriangle::new(&[corner(-1.0, -1.0), corner(2.0, -1.0), corner(0.0, 2.0)])
        };
        // One unit in the last place apart, and far apart.
        for (near, far) in [(1.0, 1.0_f32.next_up()), (0.5, 1.0), (3.0, 1000.0)] {
            let (near, far) = (at(near), at(far));
            let [near, far] =
                [&near, &far].map(|it| it.intersect(Edges::Shared, &AdaptiveRay::new(&ray)).expect("inside"));
            assert_eq!((near.order(&far, &ray), far.order(&near, &ray)), (Ordering::Less, Ordering::Greater));
        }
    }
}
