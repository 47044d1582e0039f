//! Wald's projection test (Wald 2004, §7.1).

use super::number::{Number, Triple, add};
use super::triangle_test::{Candidate, TriangleTest};
use crate::host::{Projection, TriangleRecord};
use glam::Vec3;

/// A triangle prepared for Wald's projection test: a [`Projection`], whose words the driver computes in
/// f64, in numbers of the format.
///
/// * Contact: as in Möller and Trumbore's test, by the weights as computed; the words of
///   two triangles that share an edge are rounded apart from each other.
/// * Owned edges: a weight that is computed to be 0 has the sign of its slopes (IS-6) as computed from the words.
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
    /// The axis along which the triangle is projected: 0, 1 or 2.
    pub axis: usize,
    /// Those of [`Projection::words`].
    pub words: [R; 9],
}

impl ProjectedTriangle {
    /// From what the driver stored for the chip.
    pub fn decode(record: &TriangleRecord) -> Self {
        // Three is no axis: the driver never stores it.
        Self { axis: (record.tag % 3) as usize, words: record.words }
    }
}

impl<R: Number> TriangleTest<R> for ProjectedTriangle<R> {
    type Ray = [Triple<R>; 2];

    fn new(corners: &[Vec3; 3]) -> Self {
        let Projection { axis, words } = Projection::new(corners);
        Self { axis: axis as usize, words: words.map(R::from_f64) }
    }

    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
        [origin.map(R::from_f32), direction.map(R::from_f32)]
    }

    /// Where the ray meets the plane, then the weights of that point in projection.
    fn intersect<const OWNED: bool>(&self, [origin, direction]: &Self::Ray) -> Candidate<R> {
        let (k, p, q) = (self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3);
        let w = &self.words;
        let across = direction[k] + w[0] * direction[p] + w[1] * direction[q];
        let t = (w[2] - origin[k] - w[0] * origin[p] - w[1] * origin[q]) / across;
        let (x, y) = (origin[p] + t * direction[p], origin[q] + t * direction[q]);
        let found = Candidate::within(t, w[3] * x + w[4] * y + w[5], w[6] * x + w[7] * y + w[8]);
        if !OWNED {
            return found;
        }
        found.owned(|| {
            // The ray's own move, and that along the ray to the plane again.
            let slopes = |w_x: R, w_y: R| {
                let along = (w_x * direction[p] + w_y * direction[q]) / across;
                let mut slopes = [-along; 3];
                (slopes[p], slopes[q]) = (w_x - w[0] * along, w_y - w[1] * along);
                slopes
            };
            let (u, v) = (slopes(w[3], w[4]), slopes(w[6], w[7]));
            [add(u, v).map(|x| -x), u, v]
        })
    }
}
