//! Wald's projection test (Wald 2004, §7.1).

use super::number::{Number, Triple, cross, dominant_axis, dot, sub};
use super::{Candidate, TriangleTest};
use glam::Vec3;

/// A triangle prepared for Wald's projection test: its plane, scaled so that the normal's
/// largest component is 1 and need not be stored, and two lines in the plane of projection.
///
/// * Contact: as in [`EdgeTriangle`](super::EdgeTriangle), by the weights as computed; the words of
///   two triangles that share an edge are rounded apart from each other.
/// * Without area: the words are NaN or infinite, and every ray misses.
/// * A ray in the plane: t and the weights are NaN, infinite or noise.
/// * NaN and infinity: a miss, since both weights are sums with every coordinate.
///
/// Error, with u the roundoff: a word is off by u of itself, a divisor D by γ(4) |D|₊ and a
/// numerator N of t by γ(5) |N|₊, where |·|₊ is the sum of the products without their signs; t by
/// Δt = (γ(5) |N|₊ + |t| γ(4) |D|₊) / (|D| - γ(4) |D|₊) + u |t|; a coordinate x of the point by
/// Δx = |d| Δt + γ(2) (|o| + |t d|), and a weight by |w| (Δx + Δy) + γ(4) (|w x| + |w' y| + |w''|).
/// Far from the origin, the last word cancels the others, and nothing is left of the weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedTriangle<R = f32> {
    /// The axis `k` along which the triangle is projected: 0, 1 or 2.
    pub axis: usize,
    /// With `p`, `q` the axes after `k`: the plane is `x_k + w0 x_p + w1 x_q = w2`; the barycentric
    /// weights of the second and the third corner are `w3 x_p + w4 x_q + w5` and
    /// `w6 x_p + w7 x_q + w8`.
    pub words: [R; 9],
}

impl<R: Number> TriangleTest<R> for ProjectedTriangle<R> {
    type Ray = [Triple<R>; 2];

    /// The driver computes it once, in the wide format, the chip never.
    fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.to_array().map(R::Wide::from_f32));
        let (to_b, to_c) = (sub(b, a), sub(c, a));
        let normal = cross(to_b, to_c);
        let axis = dominant_axis(normal);
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        // The area in projection is the normal's component along the axis.
        let area = normal[axis];
        let plane = normal.map(|component| component / area);
        let words = [
            plane[p],
            plane[q],
            dot(a, plane),
            to_c[q] / area,
            -to_c[p] / area,
            (a[q] * to_c[p] - a[p] * to_c[q]) / area,
            -to_b[q] / area,
            to_b[p] / area,
            (a[p] * to_b[q] - a[q] * to_b[p]) / area,
        ];
        Self { axis, words: words.map(R::from_wide) }
    }

    #[inline(always)]
    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
        [origin.map(R::from_f32), direction.map(R::from_f32)]
    }

    /// Where the ray meets the plane, then the weights of that point in projection.
    #[inline(always)]
    fn intersect(&self, [origin, direction]: &Self::Ray) -> Candidate<R> {
        let (k, p, q) = (self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3);
        let w = &self.words;
        let across = direction[k] + w[0] * direction[p] + w[1] * direction[q];
        let t = (w[2] - origin[k] - w[0] * origin[p] - w[1] * origin[q]) / across;
        let (x, y) = (origin[p] + t * direction[p], origin[q] + t * direction[q]);
        Candidate::within(t, w[3] * x + w[4] * y + w[5], w[6] * x + w[7] * y + w[8])
    }
}
