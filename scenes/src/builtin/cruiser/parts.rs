//! Parts that recur all over the ship.

use glam::{Affine3A, Quat, Vec3, vec2, vec3};

use crate::builtin::mesh::{Mesh, Surface, Vertex, circle};

/// A rivet's head at `at`: a dome on the surface that faces along the unit vector `normal`.
pub fn rivet(mesh: &mut Mesh, surface: Surface, at: Vec3, normal: Vec3, radius: f32) {
    let (right, front) = normal.any_orthonormal_pair();
    mesh.patch(surface, [6, 2], |u, v| {
        let rise = circle(v / 4.0);
        let turn = circle(u) * if v == 1.0 { 0.0 } else { rise.x };
        let position = at + (right * turn.x + front * turn.y + normal * rise.y) * radius;
        Vertex { position, along: turn * radius }
    });
}

/// Rivets every `pitch` along the line from `from` to `to`.
pub fn rivet_row(
    mesh: &mut Mesh,
    surface: Surface,
    [from, to]: [Vec3; 2],
    normal: Vec3,
    pitch: f32,
    radius: f32,
) {
    let count = (from.distance(to) / pitch) as u32;
    for i in 0..count {
        let at = from.lerp(to, (i as f32 + 0.5) / count as f32);
        rivet(mesh, surface, at, normal, radius);
    }
}

/// A hexagonal bolt: a head on `at` and the round end of its thread.
pub fn bolt(mesh: &mut Mesh, surface: Surface, at: Vec3, normal: Vec3, radius: f32) {
    let top = at + normal * radius;
    mesh.closed_cylinder(surface, [(at, radius), (top, radius)], 6, 1);
    rivet(mesh, surface, top, normal, 0.6 * radius);
}

/// A pipe's flange at `at`, across the unit vector `dir`, with its bolts.
pub fn flange(mesh: &mut Mesh, [disc, bolts]: [Surface; 2], at: Vec3, dir: Vec3, radius: f32) {
    const BOLTS: u32 = 12;
    let half = dir * 0.25 * radius;
    mesh.closed_cylinder(disc, [(at - half, 1.6 * radius), (at + half, 1.6 * radius)], 24, 1);
    let (right, front) = dir.any_orthonormal_pair();
    for i in 0..BOLTS {
        let turn = circle(i as f32 / BOLTS as f32) * 1.3 * radius;
        let foot = at + half + right * turn.x + front * turn.y;
        bolt(mesh, bolts, foot, dir, 0.14 * radius);
    }
}

/// A hand wheel with five spokes and a spindle, about the z axis of `turn`.
pub fn hand_wheel(mesh: &mut Mesh, surface: Surface, centre: Vec3, turn: Quat, radius: f32) {
    const SPOKES: u32 = 5;
    mesh.torus(surface, centre, turn, [radius, 0.1 * radius], [40, 10]);
    for i in 0..SPOKES {
        let end = circle(i as f32 / SPOKES as f32).extend(0.0) * radius;
        let ends = [(centre, 0.08 * radius), (centre + turn * end, 0.06 * radius)];
        mesh.cylinder(surface, ends, 8, 2);
    }
    let spindle = turn * Vec3::Z * 0.5 * radius;
    let ends = [(centre - spindle, 0.12 * radius), (centre + spindle, 0.12 * radius)];
    mesh.closed_cylinder(surface, ends, 12, 1);
}

/// A box whose top is `inset` smaller on each side than its foot, without a floor.
pub fn house(mesh: &mut Mesh, surface: Surface, min: Vec3, max: Vec3, inset: f32, cell: f32) {
    let foot = [vec3(min.x, min.y, max.z), vec3(max.x, min.y, max.z), vec3(max.x, min.y, min.z), min];
    let middle = (min + max) / 2.0;
    let top = foot.map(|p| {
        let inwards = (middle - p).signum() * inset;
        vec3(p.x + inwards.x, max.y, p.z + inwards.z)
    });
    let cells = |length: f32| ((length / cell).ceil() as u32).max(1);
    let height = max.y - min.y;
    for i in 0..4 {
        let j = (i + 1) % 4;
        let width = foot[i].distance(foot[j]);
        mesh.patch(surface, [cells(width), cells(height)], |u, v| Vertex {
            position: foot[i].lerp(foot[j], u).lerp(top[i].lerp(top[j], u), v),
            along: vec2(u * width, v * height),
        });
    }
    mesh.quad(surface, top[0], top[1] - top[0], top[3] - top[0], cell);
}

/// A move to `foot` after a turn by `angle` about the y axis.
pub fn turned(foot: Vec3, angle: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), foot)
}
