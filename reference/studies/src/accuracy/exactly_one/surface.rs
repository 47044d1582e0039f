//! Surfaces of triangles, by what meets at each edge and vertex.

use glam::Vec3;
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// What meets at an edge or a vertex that has triangles all around, consistently wound.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// The ends of the edge, or the vertex twice.
    pub at: [u32; 2],
    /// The corners around it, in order.
    pub rim: Vec<u32>,
    /// The triangles, by their places in [`Surface::triangles`].
    pub triangles: Vec<u32>,
}

/// A surface. Corners at the same place are one vertex, and triangles that thereby have no three corners are left out.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Where the vertices are.
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// What meets at the edges and vertices around which the surface is closed.
    pub patches: Vec<Patch>,
    /// Edges and vertices around which it is not: they have a boundary, triangles wound against one another, or more than
    /// two triangles at an edge.
    pub open: usize,
}

impl Surface {
    /// Of triangles by their corners. −0 is 0.
    #[must_use]
    pub fn new(corners: &[[Vec3; 3]]) -> Self {
        let (mut vertices, mut numbers) = (Vec::new(), HashMap::new());
        let mut number = |corner: Vec3| {
            let key = (corner + Vec3::ZERO).to_array().map(f32::to_bits);
            *numbers.entry(key).or_insert_with(|| {
                vertices.push(corner);
                vertices.len() as u32 - 1
            })
        };
        let triangles = corners.iter().map(|corners| corners.map(&mut number));
        let triangles: Vec<_> = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let (patches, open) = patches(vertices.len(), &triangles);
        Self { vertices, triangles, patches, open }
    }

    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.vertices[vertex as usize])
    }
}

/// The patches of all edges, then of all vertices, and the number of edges and vertices that have none.
fn patches(vertices: usize, triangles: &[[u32; 3]]) -> (Vec<Patch>, usize) {
    // The triangle to the left of each edge, and its third corner; none where there are several.
    let mut left: HashMap<[u32; 2], Option<(u32, u32)>> = HashMap::with_capacity(3 * triangles.len());
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); vertices];
    for (&corners, number) in triangles.iter().zip(0..) {
        for first in 0..3 {
            let [from, to, third] = [0, 1, 2].map(|next| corners[(first + next) % 3]);
            left.entry([from, to]).and_modify(|found| *found = None).or_insert(Some((number, third)));
            around[from as usize].push(number);
        }
    }
    let at = |from: u32, to: u32| left.get(&[from, to]).copied().flatten();
    let mut edges: Vec<_> = left.keys().map(|&[from, to]| [from.min(to), from.max(to)]).collect();
    edges.sort_unstable();
    edges.dedup();
    let of_edge = |&[from, to]: &[u32; 2]| {
        let ((one, left), (other, right)) = (at(from, to)?, at(to, from)?);
        Some(Patch { at: [from, to], rim: vec![from, right, to, left], triangles: vec![one, other] })
    };
    let of_vertex = |vertex: u32| {
        let around = &around[vertex as usize];
        let first = triangles[*around.first()? as usize];
        let start = first[(first.iter().position(|&corner| corner == vertex)? + 1) % 3];
        let (mut rim, mut found) = (vec![start], Vec::new());
        while found.len() < around.len() {
            let (triangle, next) = at(vertex, *rim.last()?)?;
            at(*rim.last()?, vertex)?;
            found.push(triangle);
            if next == start {
                break;
            }
            rim.push(next);
        }
        // One fan, and nothing else that touches the vertex.
        let closed = found.len() == around.len() && found.len() == rim.len();
        closed.then_some(Patch { at: [vertex; 2], rim, triangles: found })
    };
    let mut patches: Vec<Patch> = edges.iter().filter_map(of_edge).collect();
    patches.extend((0..vertices as u32).filter_map(of_vertex));
    let open = edges.len() + vertices - patches.len();
    (patches, open)
}

/// A grid of so many squares that closes in both directions, each square in two triangles.
fn closed_grid([columns, rows]: [u32; 2], vertex: impl Fn(u32, u32) -> Vec3) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for column in 0..columns {
        for row in 0..rows {
            let at = |right: u32, up: u32| vertex((column + right) % columns, row + up);
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// The point of the unit sphere at a place of a grid that goes around, and from pole to pole.
fn on_sphere([columns, rows]: [u32; 2], column: u32, row: u32) -> Vec3 {
    match row {
        0 => Vec3::Y,
        _ if row == rows => Vec3::NEG_Y,
        _ => {
            let (sin, cos) = libm::sincosf(column as f32 / columns as f32 * TAU);
            let (radius, y) = libm::sincosf(row as f32 / rows as f32 * PI);
            Vec3::new(cos * radius, y, sin * radius)
        }
    }
}

/// A sphere of radius 1.
#[must_use]
pub fn sphere(cells: [u32; 2]) -> Vec<[Vec3; 3]> {
    closed_grid(cells, |column, row| on_sphere(cells, column, row))
}

/// A sphere whose radius is off by up to a tenth at each vertex, as from a noisy scan.
#[must_use]
pub fn scanned(cells: [u32; 2]) -> Vec<[Vec3; 3]> {
    closed_grid(cells, |column, row| {
        let column = if row == 0 || row == cells[1] { 0 } else { column };
        let noise = saarcor_random::Random::new(u64::from(column * 1000 + row)).between(0.9, 1.1);
        on_sphere(cells, column, row) * noise
    })
}

/// A torus with a tube of radius 1 around a circle of radius 3.
#[must_use]
pub fn torus([columns, rows]: [u32; 2]) -> Vec<[Vec3; 3]> {
    closed_grid([columns, rows], |column, row| {
        let (sin, cos) = libm::sincosf(column as f32 / columns as f32 * TAU);
        let (y, out) = libm::sincosf((row % rows) as f32 / rows as f32 * TAU);
        Vec3::new(cos * (3.0 + out), y, sin * (3.0 + out))
    })
}

/// A cube from -1 to 1 whose sides are grids of squares, with coordinates of a few bits.
#[must_use]
pub fn cube(cells: u32) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    let place = |number: u32| number as f32 / cells as f32 * 2.0 - 1.0;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            for (column, row) in (0..cells).flat_map(|column| (0..cells).map(move |row| (column, row))) {
                let at = |right: u32, up: u32| {
                    let mut point = [side; 3];
                    (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (place(column + right), place(row + up));
                    Vec3::from(point)
                };
                let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                triangles.extend(if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    triangles
}

/// A closed fan of triangles around a vertex, its rim on a circle at different heights.
#[must_use]
pub fn fan(count: u32) -> Vec<[Vec3; 3]> {
    let rim = |number: u32| {
        let number = number % count;
        let (sin, cos) = libm::sincosf(number as f32 / count as f32 * TAU);
        Vec3::new(cos, sin, saarcor_random::Random::new(number.into()).between(-0.25, 0.25))
    };
    (0..count).map(|number| [Vec3::ZERO, rim(number), rim(number + 1)]).collect()
}

/// A grid of so many squares a side over the unit square, at different heights, its inner vertices moved beside their places.
#[must_use]
pub fn height_field(cells: u32) -> Vec<[Vec3; 3]> {
    let vertex = |column: u32, row: u32| {
        let mut random = saarcor_random::Random::new(u64::from(column) << 32 | u64::from(row));
        let mut place = |number: u32| {
            let inner = number > 0 && number < cells;
            (number as f32 + if inner { random.between(-0.3, 0.3) } else { 0.0 }) / cells as f32
        };
        let (x, y) = (place(column), place(row));
        Vec3::new(x, y, random.between(-0.5, 0.5) / cells as f32)
    };
    let square = |(column, row): (u32, u32)| {
        let at = |right: u32, up: u32| vertex(column + right, row + up);
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..cells).flat_map(|column| (0..cells).map(move |row| (column, row))).flat_map(square).collect()
}

/// Needles: a sphere that is a thousand times longer than wide.
#[must_use]
pub fn needles(cells: [u32; 2]) -> Vec<[Vec3; 3]> {
    sphere(cells).into_iter().map(|corners| corners.map(|p| p * Vec3::new(1.0, 1.0e-3, 1.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_meshes_are_closed() {
        for triangles in [sphere([9, 5]), scanned([9, 5]), torus([8, 7]), cube(3), needles([9, 5])] {
            let surface = Surface::new(&triangles);
            let (vertices, faces) = (surface.vertices.len(), surface.triangles.len());
            assert_eq!((surface.open, surface.patches.len()), (0, faces * 3 / 2 + vertices));
        }
    }

    #[test]
    fn boundaries_and_triangles_wound_against_one_another_are_open() {
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let closed = [[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
        assert_eq!(Surface::new(&closed).open, 0);
        let one_missing = Surface::new(&closed[1..]);
        assert_eq!((one_missing.open, one_missing.patches.len()), (6, 4));
        let [first, rest @ ..] = closed;
        let turned = Surface::new(&[&[[first[1], first[0], first[2]]], &rest[..]].concat());
        assert_eq!((turned.open, turned.patches.len()), (6, 4));
    }

    #[test]
    fn corners_at_one_place_are_one_vertex() {
        let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let surface = Surface::new(&[[a, b, c], [-a, c, b], [a, a, b]]);
        assert_eq!((surface.vertices.len(), surface.triangles.len(), surface.open), (3, 2, 0));
    }
}
