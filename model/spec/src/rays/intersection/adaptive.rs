//! The adaptive test: what is hit, and what is hit first, as if nothing were rounded.
//!
//! An implementation need not compute all of it exactly: where a test in floating point with a bound of
//! its error leaves no doubt, it may take that test's word (IS-3).

use super::edges::{first_sign, slopes};
use super::integer::Integer;
use super::number::{Triple, cross, dot, sub};
use crate::host::Edges;
use crate::rays::ray::Ray;
use glam::Vec3;
use std::cmp::Ordering;

/// A hit of the adaptive test, by the volumes that ray and triangle span.
///
/// * Contact: edges and vertices belong to the triangle, exactly. A ray through the edge of two
///   triangles hits both at the same distance, and the one at the lower address is kept (IS-2). Where edges are
///   owned, they belong to one of the triangles, exactly (IS-6).
/// * Without area, or with the ray in the plane: a miss, since they have no one point in common.
/// * NaN and infinity: a miss.
#[derive(Clone, Copy, Debug)]
pub struct ExactHit {
    /// The barycentric weights of the corners, times `sum`.
    weights: [Integer; 3],
    /// The sum of `weights`, positive.
    sum: Integer,
    /// The distance, times `sum`.
    height: Integer,
}

impl ExactHit {
    /// The hit of a ray and a triangle, if there is one within the ray's range (IS-1, IS-2).
    pub fn new(ray: &Ray, corners: &[Vec3; 3], edges: Edges) -> Option<Self> {
        let finite = ray.origin.is_finite() && ray.direction.is_finite();
        if !finite || !corners.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        let [origin, direction] = [ray.origin, ray.direction].map(whole);
        let [a, b, c] = corners.map(|corner| sub(whole(corner), origin));
        let mut weights =
            [dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b))];
        let mut height = dot(a, cross(b, c));
        let mut slopes = slopes(direction, [sub(c, b), sub(a, c), sub(b, a)]);
        // Seen from the other side, all volumes have the other sign.
        if (weights[0] + weights[1] + weights[2]).sign() == Ordering::Less {
            (weights, height) = (weights.map(|weight| -weight), -height);
            slopes = slopes.map(|slope| slope.map(|number| -number));
        }
        let hit = Self { weights, sum: weights[0] + weights[1] + weights[2], height };
        let meets_plane = hit.sum.sign() == Ordering::Greater;
        let inside = hit.weights.iter().zip(slopes).all(|(weight, slope)| match weight.sign() {
            Ordering::Greater => true,
            Ordering::Equal => edges == Edges::Shared || first_sign(slope.map(|number| number.sign())) > 0,
            Ordering::Less => false,
        });
        let starts = matches!(hit.compare_distance(ray.t_min), Some(Ordering::Equal | Ordering::Greater));
        let ends = hit.compare_distance(ray.t_max) == Some(Ordering::Less);
        (meets_plane && inside && starts && ends).then_some(hit)
    }

    /// How the distance compares to `bound`; `None` where that is NaN.
    fn compare_distance(&self, bound: f32) -> Option<Ordering> {
        if !bound.is_finite() {
            // As every other finite number does.
            return 0.0.partial_cmp(&bound);
        }
        // height / sum against bound / 1.
        let [bound, one] = [bound, 1.0].map(Integer::from_f32);
        Some((self.height * one - bound * self.sum).sign())
    }

    /// How the distances of two hits of one ray compare.
    pub fn order(&self, other: &Self) -> Ordering {
        // Both sums are positive.
        (self.height * other.sum - other.height * self.sum).sign()
    }

    /// Distance, and weights of the second and the third corner: numerator, divisor and quotient are
    /// each rounded once.
    pub fn point(&self) -> [f64; 3] {
        let over_sum = |number: Integer| number.nearest() / self.sum.nearest();
        [over_sum(self.height), over_sum(self.weights[1]), over_sum(self.weights[2])]
    }

    /// The same in f32.
    pub fn rounded(&self) -> [f32; 3] {
        self.point().map(|number| number as f32)
    }
}

/// A finite vector in units of 2⁻¹⁴⁹.
fn whole(vector: Vec3) -> Triple<Integer> {
    vector.to_array().map(Integer::from_f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the ends of the range there is room for every volume, and for the order of two hits.
    #[test]
    fn the_largest_numbers_have_room() {
        let large = f32::MAX;
        let ray =
            |t_max| Ray { origin: Vec3::splat(-large), direction: Vec3::splat(large), t_min: 0.0, t_max };
        let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * large);
        let hit = ExactHit::new(&ray(2.0), &corners, Edges::Shared).expect("through the middle");
        assert_eq!(hit.point()[0], 4.0 / 3.0);
        let behind = corners.map(|corner| corner + Vec3::splat(f32::from_bits(1)));
        let other = ExactHit::new(&ray(2.0), &behind, Edges::Shared).expect("through the middle");
        assert_eq!((hit.order(&other), other.order(&hit)), (Ordering::Less, Ordering::Greater));
        assert_eq!(hit.order(&hit), Ordering::Equal);
        assert!(ExactHit::new(&ray(1.333_333_3), &corners, Edges::Shared).is_none());
    }
}
