//! Closed meshes from inside: every ray must leave through the mesh.
//!
//! Their vertices are a grid that closes in both directions, split into triangles along one diagonal. A ray is
//! aimed at a vertex or an edge of it, and tested against the eight triangles of the four squares around that
//! vertex, one of which it hits in exact arithmetic; and, of a mesh with folds, against what else it passes near:
//! past the edge of a fold it leaves through the mesh behind.

use super::{Suite, towards};
use crate::accuracy::case::Case;
use glam::Vec3;
use saarcor_model::rays::Ray;
use saarcor_scenes::Random;
use std::f32::consts::{PI, TAU};
use std::ops::Range;

/// Squares of the grid around and along.
const CELLS: [i32; 2] = [48, 24];

/// Twice the rounding error of a number of 8 bits at the scan's place.
const NEAR: f64 = 1.0 / 16.0;

/// Aims from `inside` at a vertex or an edge of the mesh whose vertices `vertex` gives, of those
/// whose second coordinate in the grid is in `rows`. Folds reach `folds` squares around and along.
fn through(
    random: &mut Random,
    rows: Range<u32>,
    folds: [i32; 2],
    vertex: impl Fn(i32, i32) -> Vec3,
    inside: impl Fn(&mut Random, i32) -> Vec3,
) -> Case {
    let (i, j) = (random.range(0, CELLS[0] as u32) as i32, random.range(rows.start, rows.end) as i32);
    let square = |(i, j): (i32, i32)| {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let around = [(i, j), (i - 1, j), (i, j - 1), (i - 1, j - 1)];
    // A third at the vertex, the others on an edge from it.
    let (to, along) = ([(1, 0), (0, 1), (1, 1)][random.range(0, 3) as usize], random.between(0.0, 0.9));
    let along = if random.range(0, 3) == 0 { 0.0 } else { along };
    let target = vertex(i, j).lerp(vertex(i + to.0, j + to.1), along);
    let origin = inside(random, i);
    let ray = towards(random, origin, target);

    let columns = i - 1 - folds[0]..=i + folds[0];
    let rows = (j - 1 - folds[1]).max(0)..=(j + folds[1]).min(CELLS[1] - 1);
    let behind = columns.flat_map(|i| rows.clone().map(move |j| (i, j))).filter(|at| !around.contains(at));
    let behind = behind.flat_map(square).filter(|corners| passes_near(&ray, corners));
    Case { triangles: around.into_iter().flat_map(square).chain(behind).collect(), ray }
}

/// Whether a ray passes a triangle, or within [`NEAR`] of its edges.
fn passes_near(ray: &Ray, corners: &[Vec3; 3]) -> bool {
    let along = ray.direction.as_dvec3().normalize();
    let [a, b, c] = corners.map(|corner| (corner - ray.origin).as_dvec3());
    // No more than its distance from the edge, with the sign of its side.
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| along.dot(p.cross(q)) / p.distance(q));
    sides.iter().all(|&side| side >= -NEAR) || sides.iter().all(|&side| side <= NEAR)
}

/// Angle around, of a grid line.
fn turn(i: i32) -> f32 {
    i.rem_euclid(CELLS[0]) as f32 / CELLS[0] as f32 * TAU
}

/// A point of the unit sphere: around the y axis, and from pole to pole.
fn on_sphere(i: i32, j: i32) -> Vec3 {
    let ((sin, cos), (radius, y)) = (libm::sincosf(turn(i)), libm::sincosf(j as f32 / CELLS[1] as f32 * PI));
    Vec3::new(cos * radius, y, sin * radius)
}

fn near_the_centre(random: &mut Random, _: i32) -> Vec3 {
    super::point(random) * 0.2
}

/// A sphere from near its centre, all but the squares at its poles.
pub(super) const SPHERE: Suite = Suite {
    name: "sphere",
    idea: "a closed sphere from inside",
    closed: true,
    degenerate: false,
    generate: |random| through(random, 2..CELLS[1] as u32 - 1, [0; 2], on_sphere, near_the_centre),
};

/// A torus from the circle that its tube goes around.
pub(super) const TORUS: Suite = Suite {
    name: "torus",
    idea: "a closed torus from inside",
    closed: true,
    degenerate: false,
    generate: |random| {
        let on_circle = |i: i32| Vec3::new(libm::cosf(turn(i)), 0.0, libm::sinf(turn(i)));
        let vertex = |i: i32, j: i32| {
            let (sin, cos) = libm::sincosf(j.rem_euclid(CELLS[1]) as f32 / CELLS[1] as f32 * TAU);
            on_circle(i) * (3.0 + cos) + Vec3::Y * sin
        };
        let inside = |random: &mut Random, i: i32| on_circle(i) * 3.0 + super::point(random) * 0.2;
        through(random, 0..CELLS[1] as u32, [0; 2], vertex, inside)
    },
};

/// A sphere whose radius is off by up to a tenth at each vertex, as from a noisy scan, of size and place as of
/// a scan in metres. Rays run up to 20° off its radii, so that folds are up to 0.08 wide: two squares, or
/// four around where the squares are smallest.
pub(super) const SCANNED: Suite = Suite {
    name: "scanned",
    idea: "a closed mesh with the noise of a scan, from inside",
    closed: true,
    degenerate: false,
    generate: |random| {
        let place = Vec3::new(3.7, 1.2, -5.1);
        let vertex = |i: i32, j: i32| {
            // A pole is one vertex.
            let i = if (1..CELLS[1]).contains(&j) { i } else { 0 };
            let number = (i.rem_euclid(CELLS[0]) * CELLS[1] + j) as u64;
            let radius = Random::new(number).between(0.9, 1.1);
            place + on_sphere(i, j) * radius
        };
        let inside = |random: &mut Random, i: i32| place + near_the_centre(random, i);
        through(random, 2..CELLS[1] as u32 - 1, [4, 2], vertex, inside)
    },
};
