//! The test of Möller and Trumbore (1997).

use super::edges::slopes;
use super::number::{Number, Triple, cross, dot, sub};
use super::triangle_test::{Candidate, TriangleTest};
use glam::Vec3;

/// A triangle prepared for the test of Möller and Trumbore: a corner and two edges.
///
/// Solves `origin + t · direction = a + u · (b - a) + v · (c - a)` by Cramer's rule.
///
/// * Contact: an edge or a vertex belongs to the triangle where u ≥ 0, v ≥ 0 and u + v ≤ 1 as
///   computed. Each triangle computes them from its own edges, so that a ray may slip between two
///   that share an edge, or hit both. Where edges are owned, a weight that is computed to be 0 has the sign
///   of its slopes as computed (IS-6).
/// * Without area, or with the ray in the plane: the divisor is 0 or rounding noise, and u and v
///   are NaN, infinite or noise; noise may be a false hit.
/// * NaN: a miss. Infinity makes NaN of infinity times zero, or a weight beyond 1.
///
/// Error: a difference of edges takes one rounding, a component of a cross product three, a dot
/// product with it three more, the reciprocal and its product two. With u the roundoff, a numerator
/// N of t, u, v, made of two vectors that are differences, is off by γ(8) |N|₊, where |N|₊ is the
/// sum of its products without their signs, the divisor D by γ(8) |D|₊, and their quotient by
/// (γ(8) |N|₊ + |N/D| γ(8) |D|₊) / (|D| - γ(8) |D|₊) + γ(2) |N/D|: without bound where the ray
/// grazes the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeTriangle<R = f32> {
    corner: Triple<R>,
    edges: [Triple<R>; 2],
}

impl<R: Number> TriangleTest<R> for EdgeTriangle<R> {
    type Ray = [Triple<R>; 2];

    fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.to_array().map(R::from_f32));
        Self { corner: a, edges: [sub(b, a), sub(c, a)] }
    }

    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
        [origin.map(R::from_f32), direction.map(R::from_f32)]
    }

    fn intersect<const OWNED: bool>(&self, &[origin, direction]: &Self::Ray) -> Candidate<R> {
        let [to_b, to_c] = self.edges;
        let p = cross(direction, to_c);
        let reciprocal = R::ONE / dot(to_b, p);
        let from_a = sub(origin, self.corner);
        let q = cross(from_a, to_b);
        let found = Candidate::within(
            dot(to_c, q) * reciprocal,
            dot(from_a, p) * reciprocal,
            dot(direction, q) * reciprocal,
        );
        if !OWNED {
            return found;
        }
        found.owned(|| {
            // The divisor is the sum of the weights but for the sign.
            let edges = [sub(to_b, to_c), to_c, to_b.map(|x| -x)];
            slopes(direction, edges).map(|slope| slope.map(|x| x * reciprocal))
        })
    }
}
