//! Contact with edges and vertices, and rays and triangles that have no one point in common.

use super::{Suite, at, point, ray, towards, triangle};
use crate::accuracy::case::Case;
use glam::Vec3;
use saarcor_scenes::Random;

/// Two triangles that share an edge, which a ray is aimed at: it passes within rounding of the edge.
/// The second triangle's corners are named in a random order.
pub(super) const SHARED_EDGE: Suite = Suite {
    name: "shared-edge",
    idea: "through the edge of two triangles",
    closed: false,
    degenerate: false,
    generate: |random| {
        let first @ [a, b, _] = triangle(random);
        let other = point(random);
        let second = [[a, other, b], [b, a, other], [other, a, b]][random.range(0, 3) as usize];
        let (origin, along) = (point(random), random.between(0.05, 0.95));
        Case { ray: towards(random, origin, at(&first, along, 0.0)), triangles: vec![first, second] }
    },
};

/// Six triangles around a vertex, which a ray is aimed at: it passes within rounding of the vertex.
pub(super) const VERTEX: Suite = Suite {
    name: "vertex",
    idea: "through the vertex of six triangles",
    closed: true,
    degenerate: false,
    generate: |random| {
        let (vertex, tilt) = (point(random), point(random) * 0.5);
        let rim: [Vec3; 6] = std::array::from_fn(|corner| {
            let angle = corner as f32 / 6.0 * std::f32::consts::TAU;
            let (x, y) =
                (libm::cosf(angle) * random.between(0.5, 1.5), libm::sinf(angle) * random.between(0.5, 1.5));
            vertex + Vec3::new(x, y, x * tilt.x + y * tilt.y)
        });
        let triangles = (0..6).map(|i| [vertex, rim[i], rim[(i + 1) % 6]]).collect();
        let origin = vertex + Vec3::new(tilt.x, tilt.y, random.between(1.0, 2.0));
        Case { ray: towards(random, origin, vertex), triangles }
    },
};

/// A point of a grid of whole numbers around the origin.
fn grid(random: &mut Random) -> Vec3 {
    let mut coordinate = || random.range(0, 9) as f32 - 4.0;
    Vec3::new(coordinate(), coordinate(), coordinate())
}

/// Corners, origins and directions are whole numbers, and the ray goes through a corner or the middle
/// of an edge of one of two triangles that share an edge: an edge function is exactly zero, or two.
pub(super) const EXACT: Suite = Suite {
    name: "exact-contact",
    idea: "exactly through edges and vertices, on a grid",
    closed: false,
    degenerate: true,
    generate: |random| {
        let (a, b, c, other, origin) = (grid(random), grid(random), grid(random), grid(random), grid(random));
        let ends = [[a, b], [b, c], [a, a], [a, c]][random.range(0, 4) as usize];
        // Twice the middle of the edge, as seen from the origin: no rounding.
        let direction = (ends[0] - origin) + (ends[1] - origin);
        Case { ray: ray(origin, direction), triangles: vec![[a, b, c], [b, a, other]] }
    },
};

/// Corners and ray on a grid in one plane, straight or slanted, that both lie in exactly.
pub(super) const IN_PLANE: Suite = Suite {
    name: "in-plane",
    idea: "rays in the plane of the triangle",
    closed: false,
    degenerate: true,
    generate: |random| {
        let (first, second) = (grid(random), grid(random));
        let flat = |random: &mut Random| {
            let (x, y) = (random.range(0, 9) as f32 - 4.0, random.range(0, 9) as f32 - 4.0);
            first * x + second * y
        };
        let corners = [flat(random), flat(random), flat(random)];
        Case { ray: ray(flat(random), flat(random)), triangles: vec![corners] }
    },
};

/// Triangles that are a point or a line, and one with an area twice, all met by the ray, in a random
/// order.
pub(super) const ZERO_AREA: Suite = Suite {
    name: "zero-area",
    idea: "triangles without area, and the same one twice",
    closed: false,
    degenerate: true,
    generate: |random| {
        let corners @ [a, b, c] = triangle(random);
        let along = random.unit();
        let target = at(&corners, along * 0.5, 0.3);
        let line = [a, b, a.midpoint(b)];
        let mut triangles = vec![corners, [b, c, a], [target; 3], line, [target, c, target]];
        triangles.rotate_left(random.range(0, 5) as usize);
        let origin = point(random);
        Case { ray: towards(random, origin, target), triangles }
    },
};

/// A wall of squares of size 1, each of two triangles, in a plane of the grid, and rays within planes
/// of the grid across it or through the points of the grid: where a kd-tree splits, and cells meet.
pub(super) const SPLIT_PLANES: Suite = Suite {
    name: "split-planes",
    idea: "rays in split planes and through corners of cells",
    closed: false,
    degenerate: true,
    generate: |random| {
        let axis = random.range(0, 3) as usize;
        // Along the axis, and in the plane across it.
        let place = |depth: f32, x: f32, y: f32| {
            let mut place = [0.0; 3];
            (place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3]) = (depth, x, y);
            Vec3::from(place)
        };
        let mut triangles = Vec::new();
        for (x, y) in [(0.0, 0.0), (-1.0, 0.0), (0.0, -1.0), (-1.0, -1.0)] {
            let corner = |right: f32, up: f32| place(4.0, x + right, y + up);
            triangles.push([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)]);
            triangles.push([corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
        }
        let (x, y) = (random.between(-0.9, 0.9), random.between(-0.9, 0.9));
        let slope = random.range(0, 5) as f32 / 8.0 - 0.25;
        // In the plane x = 0, in y = 0, through the grid's point along the axis, or slanted to it.
        let (origin, direction) = match random.range(0, 4) {
            0 => (place(0.0, 0.0, y), place(1.0, 0.0, 0.0)),
            1 => (place(0.0, x, -0.0), place(1.0, -0.0, 0.0)),
            2 => (place(0.0, 0.0, 0.0), place(2.0, -0.0, 0.0)),
            _ => (place(0.0, -4.0 * slope, 4.0 * slope), place(1.0, slope, -slope)),
        };
        Case { ray: ray(origin, direction), triangles }
    },
};
