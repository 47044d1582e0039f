//! The test by Plücker coordinates.

use super::edges::{moved, slopes};
use super::number::{Number, Triple, add, cross, dot, sub};
use super::triangle_test::{Candidate, TriangleTest, same_sign};
use glam::Vec3;

/// A triangle's corners, for the test by Plücker coordinates: on which side of each edge's line the
/// ray's line passes (Shevtsov et al. 2007). The corners are counted from the ray's origin, through
/// which the ray's line then passes, so that its moment vanishes and the test of an edge is the
/// moment of the edge times the direction.
///
/// * Contact: where none of the three sides has another sign than their sum, so that an edge or a
///   vertex belongs to the triangle. Two triangles that share an edge compute the same side for it
///   but for the sign, since `(b - a) × (a + b)` only changes sign if a and b change places: no
///   ray slips between them there. At a vertex the sides of its edges are rounded apart. Where edges are
///   owned, a side that is computed to be 0 has the sign of its slopes as computed (IS-6), which change
///   sign with it.
/// * Without area or with the ray in the plane: the sum is 0, a miss, or rounding noise, which may
///   be a false hit.
/// * NaN, or an infinite sum, as by overflow: a miss.
///
/// Error, with u the roundoff and |·|₊ the sum of the products without their signs: a side is off by
/// γ(10) of its |·|₊ (two roundings in each coordinate of an edge and of a sum of corners, three in
/// the cross product, three in the dot product), their sum by these errors and γ(2) of the sides,
/// the height and its divisor by γ(10) of their |·|₊; quotients as in
/// Möller and Trumbore's test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PluckerTriangle<R = f32> {
    corners: [Triple<R>; 3],
}

impl<R: Number> TriangleTest<R> for PluckerTriangle<R> {
    type Ray = [Triple<R>; 2];

    fn new(corners: &[Vec3; 3]) -> Self {
        Self { corners: corners.map(|corner| corner.to_array().map(R::from_f32)) }
    }

    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
        [origin.map(R::from_f32), direction.map(R::from_f32)]
    }

    fn intersect<const OWNED: bool>(&self, &[origin, direction]: &Self::Ray) -> Candidate<R> {
        let [a, b, c] = self.corners.map(|corner| sub(corner, origin));
        let (a_c, b_a, c_b) = (sub(c, a), sub(a, b), sub(b, c));
        // Twice the weights of the corners times their sum: each is the side of the opposite edge.
        let weights = [
            dot(cross(c_b, add(b, c)), direction),
            dot(cross(a_c, add(c, a)), direction),
            dot(cross(b_a, add(a, b)), direction),
        ];
        let sum = weights[0] + weights[1] + weights[2];
        let normal = cross(c_b, b_a);
        let height = dot(a, normal);
        let across = dot(normal, direction);
        let mut signs = weights.map(|w| i8::from(w > R::ZERO) - i8::from(w < R::ZERO));
        if OWNED & signs.contains(&0) {
            let slopes = slopes(direction, [c_b, a_c, b_a].map(|edge| edge.map(|x| -x)));
            signs = std::array::from_fn(|corner| match signs[corner] {
                0 => moved(slopes[corner]),
                sign => sign,
            });
        }
        Candidate {
            t: height / across,
            u: weights[1] / sum,
            v: weights[2] / sum,
            inside: same_sign(signs, sum),
        }
    }
}
