//! How often a line crosses a patch of a surface, whatever the triangles into which it is divided and whatever rule they
//! have for edges: by the winding number of the patch's rim.
//!
//! Where the line meets no point of the rim, the rim winds about it as often as the line crosses the patch from its one
//! side, less how often from the other, whatever triangles the patch has. If all triangles of the patch face the line alike, all crossings are from one
//! side, and a surface without gaps and without overlaps is hit so many times, exactly. If they do not, the line may
//! touch the patch at a silhouette: what is hit there beside is hit from both sides, an even number.

use super::{filter, rational};
use glam::Vec3;
use saarcor_model::rays::Ray;
use std::cmp::Ordering;

/// How often a line crosses a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Crossings {
    /// All triangles face the line alike, or are seen from an edge.
    Exactly(u32),
    /// Some face it from either side: so many, and an even number beside.
    Silhouette(u32),
}

impl Crossings {
    /// Whether so many hits are right.
    #[must_use]
    pub fn allows(self, hits: u32) -> bool {
        match self {
            Self::Exactly(right) => hits == right,
            Self::Silhouette(least) => hits >= least && (hits - least).is_multiple_of(2),
        }
    }
}

/// How often the line of `ray` crosses a patch of triangles that ends at `rim`: all sides of triangles but those that have an opposite
/// one. `None` where the line meets the rim, or may meet it, or has no direction: there the patch alone does not decide.
///
/// ```
/// use glam::Vec3;
/// use saarcor_model::rays::Ray;
/// use saarcor_oracles::exact::crossings::{Crossings, crossings};
/// let ray = |x| Ray { origin: Vec3::new(x, 0.0, -1.0), direction: Vec3::Z, t_min: 0.0, t_max: 2.0 };
/// let [a, b, c, d] = [Vec3::NEG_X, Vec3::NEG_Y, Vec3::X, Vec3::Y];
/// // Through the edge of two triangles, and beside them.
/// let (rim, patch) = ([[a, b], [b, c], [c, d], [d, a]], [[a, b, d], [b, c, d]]);
/// assert_eq!(crossings(&ray(0.0), rim, patch), Some(Crossings::Exactly(1)));
/// assert_eq!(crossings(&ray(3.0), rim, patch), Some(Crossings::Exactly(0)));
/// ```
#[must_use]
pub fn crossings(
    ray: &Ray,
    rim: impl IntoIterator<Item = [Vec3; 2]>,
    patch: impl IntoIterator<Item = [Vec3; 3]>,
) -> Option<Crossings> {
    let winding = winding(ray, rim)?.unsigned_abs();
    let mut faces = [false; 2];
    for [a, b, c] in patch {
        match volume_sign(ray.direction, a, b, c) {
            Ordering::Greater => faces[0] = true,
            Ordering::Less => faces[1] = true,
            Ordering::Equal => {}
        }
    }
    Some(if faces == [true; 2] { Crossings::Silhouette(winding) } else { Crossings::Exactly(winding) })
}

/// How often closed polygons wind about the line: their sides are counted that cross a half-plane which the line
/// bounds (Sunday 2001).
fn winding(ray: &Ray, rim: impl IntoIterator<Item = [Vec3; 2]>) -> Option<i32> {
    let Ray { origin, direction, .. } = *ray;
    if direction == Vec3::ZERO || !direction.is_finite() || !origin.is_finite() {
        return None;
    }
    // The half-plane reaches along the axis along which the direction is shortest.
    let size = direction.abs();
    let axis = if size.x <= size.y.min(size.z) {
        0
    } else if size.y <= size.z {
        1
    } else {
        2
    };
    let side = |point: Vec3| side(direction, axis, point, origin);
    let mut winding = 0;
    for ends in rim {
        let [from, to] = ends.map(|end| (end, side(end)));
        let crosses = from.1.is_gt() != to.1.is_gt();
        if crosses || from.1.is_eq() || to.1.is_eq() {
            match (volume_sign(direction, origin, from.0, to.0), to.1.is_gt()) {
                (Ordering::Equal, _) => return None,
                (Ordering::Greater, true) if crosses => winding += 1,
                (Ordering::Less, false) if crosses => winding -= 1,
                _ => {}
            }
        }
    }
    Some(winding)
}

/// The sign of `direction · ((b - a) × (c - a))`.
fn volume_sign(direction: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Ordering {
    let [to_b, to_c] = [b, c].map(|point| point.as_dvec3() - a.as_dvec3());
    match filter::volume_sign(direction.as_dvec3(), to_b, to_c) {
        0 => rational::volume_sign(direction, a, b, c),
        sign => sign.cmp(&0),
    }
}

/// On which side of the plane through the line along `axis` a point lies.
fn side(direction: Vec3, axis: usize, point: Vec3, origin: Vec3) -> Ordering {
    let along = Vec3::AXES[axis];
    let (way, to_point) = (direction.as_dvec3(), point.as_dvec3() - origin.as_dvec3());
    match filter::volume_sign(way, along.as_dvec3(), to_point) {
        0 => rational::side(direction, along, point, origin),
        sign => sign.cmp(&0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// A roof of four triangles around its top, of a square rim.
    fn roof(height: f32) -> ([[Vec3; 2]; 4], [[Vec3; 3]; 4]) {
        let rim = [
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(-1.0, 1.0, 0.0),
        ];
        let sides = std::array::from_fn(|side| [rim[side], rim[(side + 1) % 4]]);
        (sides, sides.map(|[from, to]| [Vec3::Z * height, from, to]))
    }

    #[test]
    fn what_faces_the_line_alike_is_crossed_once() {
        let (rim, roof) = roof(2.0);
        let down = |x, y| crossings(&ray(Vec3::new(x, y, 9.0), Vec3::NEG_Z), rim, roof);
        assert_eq!(down(0.0, 0.0), Some(Crossings::Exactly(1)));
        assert_eq!(down(0.5, 0.5), Some(Crossings::Exactly(1)));
        assert_eq!(down(0.25, -0.5), Some(Crossings::Exactly(1)));
        assert_eq!(down(1.5, 0.25), Some(Crossings::Exactly(0)));
        assert_eq!(down(1.0, 0.25), None, "the rim itself");
    }

    #[test]
    fn tops_seen_from_beside_are_silhouettes() {
        let (rim, roof) = roof(2.0);
        let level = |z| crossings(&ray(Vec3::new(-9.0, 0.25, z), Vec3::X), rim, roof);
        assert_eq!(level(2.0), Some(Crossings::Silhouette(0)));
        assert_eq!(level(1.0), Some(Crossings::Silhouette(0)), "twice, from both sides");
        let slanted = crossings(&ray(Vec3::new(-9.0, 0.25, 1.0), Vec3::new(9.0, 0.0, -1.0)), rim, roof);
        assert_eq!(slanted, Some(Crossings::Silhouette(1)));
        assert!(Crossings::Silhouette(1).allows(3) && !Crossings::Silhouette(1).allows(2));
        assert!(Crossings::Silhouette(0).allows(2) && !Crossings::Exactly(1).allows(2));
    }

    #[test]
    fn a_line_without_direction_has_no_crossings() {
        let (rim, roof) = roof(2.0);
        assert_eq!(crossings(&ray(Vec3::ZERO, Vec3::ZERO), rim, roof), None);
    }
}
