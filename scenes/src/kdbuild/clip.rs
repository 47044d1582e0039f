//! Clips a triangle to a box, without ever losing a part of it.

use glam::{DVec3, Vec3};
use saarcor_model::host::Aabb;

/// Bound on the error of clipping, relative to the greatest magnitude `M` of the triangle's
/// coordinates on an axis, with `u = 2^-53`.
///
/// A new corner `a + (b - a) (plane - a.x) / (b.x - a.x)` is computed in f64 with an error of at
/// most `12 u M`: the quotient has three roundings and the difference and the product one each,
/// all relative to `|b - a| <= 2 M`, and the sum has one relative to `M`. Clipping at six planes
/// adds up to `72 u M`, since each plane is pushed outwards by this bound: what earlier rounding
/// moved is still inside, however flat the angle between edge and plane. `128 u` leaves room for
/// the rounding of the pushed plane and for terms of second order.
const ERROR: f64 = 128.0 * (f64::EPSILON / 2.0);

/// A triangle has three corners, and each of the six planes adds at most one.
const MAX_CORNERS: usize = 9;

/// A convex polygon.
struct Polygon {
    corners: [DVec3; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    /// The part where `coordinate <= plane` on `axis`, or `>=` when `above`.
    fn clipped(&self, axis: usize, plane: f64, above: bool) -> Self {
        let outside = |p: DVec3| if above { p[axis] < plane } else { p[axis] > plane };
        let mut part = Self { corners: [DVec3::ZERO; MAX_CORNERS], len: 0 };
        let mut push = |corner| {
            part.corners[part.len] = corner;
            part.len += 1;
        };
        let corners = &self.corners[..self.len];
        let mut from = *corners.last().unwrap_or(&DVec3::ZERO);
        for &to in corners {
            if outside(from) != outside(to) {
                let mut crossing = from + (to - from) * ((plane - from[axis]) / (to[axis] - from[axis]));
                crossing[axis] = plane;
                push(crossing);
            }
            if !outside(to) {
                push(to);
            }
            from = to;
        }
        part
    }
}

/// A box around the part of a triangle inside a box, itself inside that box; `None` when the
/// triangle misses it.
///
/// The exact part lies inside the result. `within` must lie inside the triangle's own box.
pub(super) fn clip(corners: &[Vec3; 3], within: Aabb) -> Option<Aabb> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let error = a.abs().max(b.abs()).max(c.abs()) * ERROR;
    let (min, max) = (within.min.as_dvec3() - error, within.max.as_dvec3() + error);
    let (least, greatest) = (a.min(b).min(c), a.max(b).max(c));

    let mut polygon = Polygon { corners: [DVec3::ZERO; MAX_CORNERS], len: 3 };
    polygon.corners[..3].copy_from_slice(&[a, b, c]);
    for axis in 0..3 {
        if least[axis] < min[axis] {
            polygon = polygon.clipped(axis, min[axis], true);
        }
        if greatest[axis] > max[axis] {
            polygon = polygon.clipped(axis, max[axis], false);
        }
    }

    let (first, rest) = polygon.corners[..polygon.len].split_first()?;
    let (least, greatest) = rest.iter().fold((*first, *first), |(min, max), p| (min.min(*p), max.max(*p)));
    let part = Aabb {
        min: round_down(least - error).max(within.min),
        max: round_up(greatest + error).min(within.max),
    };
    part.min.cmple(part.max).all().then_some(part)
}

/// The greatest f32 that are not above the coordinates.
fn round_down(p: DVec3) -> Vec3 {
    let down = |x: f64| {
        let nearest = x as f32;
        if f64::from(nearest) > x { nearest.next_down() } else { nearest }
    };
    Vec3::new(down(p.x), down(p.y), down(p.z))
}

/// The least f32 that are not below the coordinates.
fn round_up(p: DVec3) -> Vec3 {
    -round_down(-p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Coordinates of very different magnitude, and coincident ones.
    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![
            (-2..=2i8).prop_map(f32::from),
            -1.0..1.0f32,
            (-1.0..1.0f32, -18..=18i32).prop_map(|(x, e)| x * 10f32.powi(e)),
        ]
    }

    fn point() -> impl Strategy<Value = Vec3> {
        [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from_array)
    }

    proptest! {
        #[test]
        fn keeps_every_point_inside(
            corners in [point(), point(), point()],
            sides in [point(), point()],
            weights in prop::collection::vec((0.0..=1.0f64, 0.0..=1.0f64), 32),
        ) {
            let own = Aabb::around(corners);
            let sides = sides.map(|p| p.clamp(own.min, own.max));
            let within = Aabb::around(sides);
            let part = clip(&corners, within);
            if let Some(part) = part {
                prop_assert!(part.min.cmpge(within.min).all() && part.max.cmple(within.max).all());
            }
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            for (u, v) in weights {
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let p = a + (b - a) * u + (c - a) * v;
                // Only points further inside than their own rounding are surely inside.
                let room = a.abs().max(b.abs()).max(c.abs()) * 8.0 * f64::EPSILON;
                let surely = p.cmpge(within.min.as_dvec3() + room).all()
                    && p.cmple(within.max.as_dvec3() - room).all();
                if surely {
                    let part = part.expect("a point of the triangle is inside");
                    prop_assert!(p.cmpge(part.min.as_dvec3() - room).all());
                    prop_assert!(p.cmple(part.max.as_dvec3() + room).all());
                }
            }
        }
    }

    #[test]
    fn bounds_the_part_exactly() {
        let corners = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
        let within = Aabb { min: Vec3::new(3.0, 0.0, 0.0), max: Vec3::new(4.0, 4.0, 0.0) };
        let part = clip(&corners, within).expect("the corner at x = 4 is inside");
        assert_eq!(part.min, within.min);
        assert_eq!(part.max, Vec3::new(4.0, 1.0f32.next_up(), 0.0));
    }

    #[test]
    fn misses_a_box_in_the_corner_of_its_own_box() {
        let corners = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
        let within = Aabb { min: Vec3::new(3.0, 3.0, 0.0), max: Vec3::new(4.0, 4.0, 0.0) };
        assert_eq!(clip(&corners, within), None);
    }
}
