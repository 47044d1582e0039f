//! A triangle's part inside a cell, as the builder carries it from cell to cell.

use super::clip::clip;
use super::plane::{Plane, Side};
use saarcor_model::host::{Aabb, Triangle};

/// A triangle that meets a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Index of the triangle.
    pub triangle: u32,
    /// A box around the triangle's part inside the cell.
    pub bounds: Aabb,
}

impl Reference {
    /// The whole of a triangle; `None` when it is degenerate or not finite.
    pub fn of(index: usize, triangle: &Triangle) -> Option<Self> {
        let usable = triangle.corners.iter().all(|c| c.is_finite()) && !triangle.is_degenerate();
        usable.then(|| Self {
            triangle: u32::try_from(index).expect("indices of triangles have 32 bits"),
            bounds: Aabb::around(triangle.corners),
        })
    }

    /// The parts below and above a plane. Both are missing only where clipping, which rounds
    /// outwards, had kept a triangle that misses the cell.
    pub fn cut(&self, plane: &Plane, triangles: &[Triangle]) -> (Option<Self>, Option<Self>) {
        match plane.side(&self.bounds) {
            Side::Below => (Some(*self), None),
            Side::Above => (None, Some(*self)),
            Side::Both => {
                let (below, above) = plane.halves(&self.bounds);
                let corners = &triangles[self.triangle as usize].corners;
                let part = |half| clip(corners, half).map(|bounds| Self { bounds, ..*self });
                (part(below), part(above))
            }
        }
    }
}
