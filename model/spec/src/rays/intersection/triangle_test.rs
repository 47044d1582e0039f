//! What the triangle tests have in common.

use super::edges::moved;
use super::number::{Number, Triple};
use glam::Vec3;

/// Where a ray meets a triangle's plane, and whether that is within the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<R = f32> {
    /// Distance along the ray.
    pub t: R,
    /// Barycentric weight of the second corner.
    pub u: R,
    /// Barycentric weight of the third corner.
    pub v: R,
    /// Whether the point belongs to the triangle, by the rule of the test (IS-1).
    pub inside: bool,
}

impl<R: Number> Candidate<R> {
    /// Inside by the weights. NaN and infinity, as with a ray in the triangle's plane, are not.
    pub(super) fn within(t: R, u: R, v: R) -> Self {
        Self { t, u, v, inside: (u >= R::ZERO) & (v >= R::ZERO) & (u + v <= R::ONE) }
    }

    /// The same where edges are owned, if the weights of the three corners, where they are 0, grow by
    /// `slopes` for a unit along each axis by which the ray moves (IS-6).
    pub(super) fn owned(mut self, slopes: impl FnOnce() -> [Triple<R>; 3]) -> Self {
        let on_edge = [self.u + self.v == R::ONE, self.u == R::ZERO, self.v == R::ZERO];
        if self.inside & on_edge.contains(&true) {
            let slopes = slopes();
            self.inside = (0..3).all(|corner| !on_edge[corner] || moved(slopes[corner]) > 0);
        }
        self
    }
}

/// Whether a point belongs to the triangle by the signs of the weights of its corners, and their
/// sum: no two signs are opposite, and there is a sum to divide by.
pub(super) fn same_sign<R: Number>(signs: [i8; 3], sum: R) -> bool {
    let [a, b, c] = signs;
    let opposite = (a * b < 0) | (b * c < 0) | (c * a < 0);
    !opposite & sum.is_finite() & (sum != R::ZERO)
}

/// A triangle test in numbers of the format `R`.
pub trait TriangleTest<R: Number>: Copy {
    /// What is computed once a ray.
    type Ray: Copy;

    /// From the corners.
    fn new(corners: &[Vec3; 3]) -> Self;

    /// From origin and direction.
    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray;

    /// Where the ray meets the triangle's plane, and whether within the triangle where edges are `OWNED`,
    /// or shared (IS-6).
    fn intersect<const OWNED: bool>(&self, ray: &Self::Ray) -> Candidate<R>;
}
