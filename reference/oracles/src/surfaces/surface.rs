//! Surfaces of triangles, by what meets at each edge and vertex.

use glam::Vec3;
use std::collections::{HashMap, HashSet};
use std::f32::consts::{PI, TAU};

/// Triangles of a surface, and where they end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// The triangles, by their places in [`Surface::triangles`], in ascending order.
    pub triangles: Vec<u32>,
    /// Their sides, from vertex to vertex, without pairs of opposite ones: where two triangles that are wound alike meet.
    pub rim: Vec<[u32; 2]>,
}

/// A surface. Corners at the same place are one vertex, and triangles that thereby have no three corners are left out.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Where the vertices are.
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The edges around which the surface is closed, by their ends.
    pub edges: Vec<[u32; 2]>,
    /// The vertices around which it is.
    pub inner: Vec<u32>,
    /// Edges and vertices around which it is not: there is a boundary, or triangles are wound against one another.
    pub open: usize,
    /// The triangles around each vertex.
    around: Vec<Vec<u32>>,
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
        let mut around = vec![Vec::new(); vertices.len()];
        for (corners, number) in triangles.iter().zip(0..) {
            corners.iter().for_each(|&vertex| around[vertex as usize].push(number));
        }
        let mut edges: Vec<_> = triangles.iter().flat_map(sides).map(|[p, q]| [p.min(q), p.max(q)]).collect();
        edges.sort_unstable();
        edges.dedup();
        let (sides, ends) = (edges.len() + vertices.len(), rim(triangles.iter().flat_map(sides)));
        let (mut open_edges, mut is_open) = (HashSet::new(), vec![false; vertices.len()]);
        for [p, q] in ends {
            open_edges.insert([p.min(q), p.max(q)]);
            (is_open[p as usize], is_open[q as usize]) = (true, true);
        }
        edges.retain(|edge| !open_edges.contains(edge));
        let is_inner = |&vertex: &u32| !is_open[vertex as usize] && !around[vertex as usize].is_empty();
        let inner: Vec<u32> = (0..vertices.len() as u32).filter(is_inner).collect();
        let open = sides - edges.len() - inner.len();
        Self { vertices, triangles, edges, inner, open, around }
    }

    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.vertices[vertex as usize])
    }

    /// The triangles that have a vertex.
    #[must_use]
    pub fn around(&self, vertex: u32) -> &[u32] {
        &self.around[vertex as usize]
    }

    /// The triangles around an edge, by its ends, or around a vertex, named twice.
    #[must_use]
    pub fn patch(&self, [p, q]: [u32; 2]) -> Patch {
        let has_both = |triangle: &&u32| self.triangles[**triangle as usize].contains(&q);
        self.of(self.around(p).iter().filter(has_both).copied().collect())
    }

    /// A patch with all triangles that touch it.
    #[must_use]
    pub fn grown(&self, patch: &Patch) -> Patch {
        let corners = patch.triangles.iter().flat_map(|&triangle| self.triangles[triangle as usize]);
        let mut triangles: Vec<u32> = corners.flat_map(|vertex| self.around(vertex)).copied().collect();
        triangles.sort_unstable();
        triangles.dedup();
        self.of(triangles)
    }

    fn of(&self, triangles: Vec<u32>) -> Patch {
        let rim = rim(triangles.iter().flat_map(|&triangle| sides(&self.triangles[triangle as usize])));
        Patch { triangles, rim }
    }
}

/// The sides of a triangle, as it is wound.
fn sides(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// What is left of sides without pairs of opposite ones.
fn rim(sides: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
    let mut sides: Vec<_> = sides.map(|[p, q]| ([p.min(q), p.max(q)], p < q)).collect();
    sides.sort_unstable();
    let of_edge = |sides: &[([u32; 2], bool)]| {
        let ([p, q], forwards) = (sides[0].0, sides.iter().filter(|(_, forwards)| *forwards).count());
        let backwards = sides.len() - forwards;
        let side = if forwards > backwards { [p, q] } else { [q, p] };
        std::iter::repeat_n(side, forwards.abs_diff(backwards))
    };
    sides.chunk_by(|one, other| one.0 == other.0).flat_map(of_edge).collect()
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
            assert_eq!(
                (surface.edges.len(), surface.inner.len(), surface.open),
                (faces * 3 / 2, vertices, 0)
            );
        }
    }

    #[test]
    fn boundaries_and_triangles_wound_against_one_another_are_open() {
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let closed = [[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
        assert_eq!(Surface::new(&closed).open, 0);
        let closed_ones = |triangles: &[[Vec3; 3]]| {
            let Surface { edges, inner, open, .. } = Surface::new(triangles);
            (edges.len(), inner.len(), open)
        };
        assert_eq!(closed_ones(&closed[1..]), (3, 1, 6));
        let [first, rest @ ..] = closed;
        assert_eq!(closed_ones(&[&[[first[1], first[0], first[2]]], &rest[..]].concat()), (3, 1, 6));
        // Two shells that share an edge are closed there, too.
        let far = Vec3::new(1.0, -1.0, -1.0);
        let other = [[a, b, far], [b, a, -d], [b, -d, far], [-d, a, far]];
        assert_eq!(closed_ones(&[closed, other].concat()), (11, 6, 0));
    }

    #[test]
    fn patches_end_at_their_rims() {
        let surface = Surface::new(&cube(2));
        let around = surface.patch([0; 2]);
        assert_eq!(around.rim.len(), around.triangles.len());
        assert!(around.rim.iter().all(|side| !side.contains(&0)));
        let edge = surface.patch(surface.edges[0]);
        assert_eq!((edge.triangles.len(), edge.rim.len()), (2, 4));
        let mut grown = edge;
        for _ in 0..4 {
            grown = surface.grown(&grown);
        }
        assert_eq!((grown.triangles.len(), grown.rim.len()), (surface.triangles.len(), 0));
    }

    #[test]
    fn corners_at_one_place_are_one_vertex() {
        let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let surface = Surface::new(&[[a, b, c], [-a, c, b], [a, a, b]]);
        assert_eq!((surface.vertices.len(), surface.triangles.len(), surface.open), (3, 2, 0));
    }
}
