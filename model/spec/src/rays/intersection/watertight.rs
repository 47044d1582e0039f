//! The watertight test of Woop, Benthin and Wald (2013).

use super::edges::first_sign;
use super::number::{Number, Triple, sub};
use super::triangle_test::{Candidate, TriangleTest, same_sign};
use crate::host::Axis;
use glam::Vec3;
use std::cmp::Ordering;

/// A triangle's corners, for the watertight test: they are counted from the ray's origin and
/// sheared so that the ray runs along one axis; in the plane across it each edge has the origin to
/// one side, to the other, or goes through it.
///
/// * Contact: edges and vertices belong to the triangle. A sheared corner depends on the ray and
///   the corner alone, and the side of an edge is decided exactly from two of them: rounding keeps
///   the order of the two products that an edge function is the difference of, so that the
///   difference has the true sign or is 0, and then the products decide, in a format that holds
///   them. So no ray slips between triangles that share edges and vertices: watertight, of the
///   corners as sheared. Where edges are owned, a side of 0 is decided as if the ray were moved along the
///   first axis across it by ε, and along the second by ε² (IS-6), which takes comparisons of
///   sheared coordinates alone: exact, so that around an edge or a vertex exactly one triangle is hit.
/// * Without area or with the ray in the plane: the sum of the edge functions is 0, a miss; where
///   shearing moved the corners apart, it may be a false hit.
/// * A direction of zero, NaN, and a sum that is infinite, as by overflow: a miss.
///
/// **No multiplication may be fused with an addition in the edge functions** (IS-4). Fused, one of
/// the two products is not rounded, the sign is no longer the true one or 0, and two triangles
/// that share an edge no longer agree on its side.
///
/// Error, with u the roundoff: a sheared coordinate `x - s z` of a corner is off by γ(4) (|x| + |s z|) (one
/// rounding in each difference and in s, one in the product and one in the subtraction), an edge
/// function by 2 (|x| Δy + |y| Δx) of its corners and γ(2) (|x y'| + |x' y|), a height by γ(2) of
/// itself; quotients as in Möller and Trumbore's test. The shear has no error where the
/// ray runs along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatertightTriangle<R = f32> {
    corners: [Triple<R>; 3],
}

/// A ray, and how space is sheared so that it runs along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearedRay<R> {
    origin: Triple<R>,
    /// The axis along which the direction is longest.
    axis: usize,
    /// The direction's components along the two axes after it, over that along `axis`; and one
    /// over that.
    shear: Triple<R>,
}

/// The components of `vector` along the two axes after `axis`, and along it. Which of two triangles'
/// windings comes out flipped depends on the direction; both count as hits.
fn permuted<R: Number>(vector: Triple<R>, axis: usize) -> Triple<R> {
    [vector[(axis + 1) % 3], vector[(axis + 2) % 3], vector[axis]]
}

impl<R: Number> TriangleTest<R> for WatertightTriangle<R> {
    type Ray = ShearedRay<R>;

    fn new(corners: &[Vec3; 3]) -> Self {
        Self { corners: corners.map(|corner| corner.to_array().map(R::from_f32)) }
    }

    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
        let direction = direction.map(R::from_f32);
        let axis = Axis::of_greatest(direction.map(Number::abs)) as usize;
        let [x, y, z] = permuted(direction, axis);
        ShearedRay { origin: origin.map(R::from_f32), axis, shear: [x / z, y / z, R::ONE / z] }
    }

    fn intersect<const OWNED: bool>(&self, ray: &Self::Ray) -> Candidate<R> {
        let [shear_x, shear_y, scale] = ray.shear;
        let [a, b, c] = self.corners.map(|corner| {
            let [x, y, z] = permuted(sub(corner, ray.origin), ray.axis);
            [x - shear_x * z, y - shear_y * z, scale * z]
        });
        let weights = [edge(c, b), edge(a, c), edge(b, a)];
        let signs = [
            side::<R, OWNED>(weights[0], c, b),
            side::<R, OWNED>(weights[1], a, c),
            side::<R, OWNED>(weights[2], b, a),
        ];
        let sum = weights[0] + weights[1] + weights[2];
        let height = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        let reciprocal = R::ONE / sum;
        Candidate {
            // Not by the reciprocal, which overflows for a triangle that is seen from its edge.
            t: height / sum,
            u: weights[1] * reciprocal,
            v: weights[2] * reciprocal,
            inside: same_sign(signs, sum),
        }
    }
}

/// The edge function of two sheared corners: twice the area that they span with the origin. Two
/// products and a difference, each rounded by itself.
fn edge<R: Number>(p: Triple<R>, q: Triple<R>) -> R {
    p[0] * q[1] - p[1] * q[0]
}

/// The exact sign of the edge function of `p` and `q`, of which `rounded` is what it was rounded to; of 0, where
/// edges are `OWNED`, that of its slopes along the two axes.
fn side<R: Number, const OWNED: bool>(rounded: R, p: Triple<R>, q: Triple<R>) -> i8 {
    if rounded > R::ZERO {
        1
    } else if rounded < R::ZERO {
        -1
    } else {
        match R::product_order(p[0], q[1], p[1], q[0]) {
            Ordering::Greater => 1,
            Ordering::Equal if OWNED => {
                let order = |a: R, b: R| a.partial_cmp(&b).unwrap_or(Ordering::Equal);
                first_sign([order(p[1], q[1]), order(q[0], p[0]), Ordering::Equal])
            }
            Ordering::Equal => 0,
            Ordering::Less => -1,
        }
    }
}
