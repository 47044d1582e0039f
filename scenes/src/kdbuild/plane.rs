//! Planes that cut a cell, and the spatial median.

use saarcor_model::host::{Aabb, Axis};

/// Where a triangle's part lies, seen from a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Nowhere above the plane, or in the plane and counted as below.
    Below,
    /// Nowhere below the plane, or in the plane and counted as above.
    Above,
    /// On both sides.
    Both,
}

/// A plane that cuts a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// The axis that the plane is perpendicular to.
    pub axis: Axis,
    /// The plane's coordinate, strictly inside the cell.
    pub at: f32,
    /// Triangles in the plane belong to the side below, otherwise to the one above.
    pub flat_below: bool,
    /// The number of references with a part below, and with one above.
    pub counts: [usize; 2],
}

impl Plane {
    /// Where a triangle's part with the given box lies.
    pub fn side(&self, bounds: &Aabb) -> Side {
        let axis = self.axis as usize;
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        if min < self.at && max > self.at {
            Side::Both
        } else if min < self.at || (max == self.at && min == self.at && self.flat_below) {
            Side::Below
        } else {
            Side::Above
        }
    }

    /// The number of boxes with a part below, and with one above.
    pub fn count<'a>(&self, boxes: impl Iterator<Item = &'a Aabb>) -> [usize; 2] {
        boxes.map(|bounds| self.side(bounds)).fold([0, 0], |[below, above], side| {
            [below + usize::from(side != Side::Above), above + usize::from(side != Side::Below)]
        })
    }

    /// The parts of a box below and above the plane, which cuts it.
    pub fn halves(&self, bounds: &Aabb) -> (Aabb, Aabb) {
        let (mut below, mut above) = (*bounds, *bounds);
        below.max[self.axis as usize] = self.at;
        above.min[self.axis as usize] = self.at;
        (below, above)
    }
}

/// The middle of the cell's longest side; triangles in it belong to the side below. `None` when
/// no f32 lies inside that side.
pub(super) fn spatial_median<'a>(cell: &Aabb, boxes: impl Iterator<Item = &'a Aabb>) -> Option<Plane> {
    let (min, max) = (cell.min.as_dvec3(), cell.max.as_dvec3());
    let axis = Axis::ALL[(max - min).max_position()];
    let at = ((min[axis as usize] + max[axis as usize]) / 2.0) as f32;
    if at <= cell.min[axis as usize] || at >= cell.max[axis as usize] {
        return None;
    }
    let mut plane = Plane { axis, at, flat_below: true, counts: [0; 2] };
    plane.counts = plane.count(boxes);
    Some(plane)
}
