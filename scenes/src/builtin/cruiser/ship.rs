//! The hull, the decks, the houses on them, and the sea: the ship's large plain parts.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};

use super::parts::{house, rivet};
use super::surfaces::Surfaces;
use crate::builtin::mesh::{Mesh, Surface, Vertex, circle};

/// Half the ship's length; the bow lies at +x.
pub const HALF_LENGTH: f32 = 90.0;
/// Radius of the sea and of the dome of the sky.
const HORIZON: f32 = 900.0;
/// How deep the hull is built below the waterline at y = 0.
const DRAUGHT: f32 = 2.0;

/// Height of the deck's edge at a station from -1 (stern) to 1 (bow).
pub fn sheer(station: f32) -> f32 {
    6.5 + 3.5 * libm::powf(station.max(0.0), 2.5) + 0.4 * station.min(0.0).powi(2)
}

/// Half the deck's breadth at a station.
pub fn deck_breadth(station: f32) -> f32 {
    let bow = libm::powf((1.0 - libm::powf(station.max(0.0), 2.6)).max(0.0), 0.75);
    9.5 * bow * (1.0 + 0.2 * station.min(0.0).powi(3))
}

/// A point of the hull at a station, `t` from 0 below the waterline to 1 at the deck's edge.
pub fn hull_point(station: f32, t: f32, side: f32) -> Vec3 {
    let bow = station.max(0.0);
    let y = -DRAUGHT + t * (sheer(station) + DRAUGHT);
    // Full amidships, hollow under the flare of the bow.
    let fullness = libm::powf(0.1 + 0.9 * t, 0.12 + 0.9 * bow.powi(3));
    let rake = 0.7 * (y - 6.5) * bow.powi(8);
    vec3(HALF_LENGTH * station + rake, y, side * deck_breadth(station) * fullness)
}

/// A point on the deck, `across` from -1 at the port edge to 1 at the starboard edge.
pub fn deck_point(station: f32, across: f32) -> Vec3 {
    let edge = hull_point(station, 1.0, 1.0);
    // The deck's camber sheds water.
    let camber = 0.15 * (1.0 - across * across) * (edge.z / 9.5);
    vec3(edge.x, edge.y + camber, edge.z * across)
}

/// Builds hull, decks and houses.
pub fn ship(mesh: &mut Mesh, s: &Surfaces) {
    hull(mesh, s);
    superstructure(mesh, s);
    funnels(mesh, s);
}

/// Builds the sea and the sky.
pub fn surroundings(mesh: &mut Mesh, s: &Surfaces) {
    mesh.patch(s.sea, [192, 96], |u, v| {
        // Cells grow outwards, and the swell is flat where the sea meets the sky.
        let reach = HORIZON * libm::powf(1.0 - v, 2.5);
        let at = circle(u) * reach;
        let height = 0.25 * libm::sinf(at.x * 0.11) * libm::sinf(at.y * 0.07 + at.x * 0.03) * v.min(0.9);
        Vertex { position: vec3(at.x, height, -at.y), along: at }
    });
    mesh.patch(s.sky, [96, 24], |u, v| {
        let rise = circle(v / 4.0);
        let turn = circle(u) * if v == 1.0 { 0.0 } else { rise.x };
        Vertex { position: vec3(turn.x, rise.y, turn.y) * HORIZON, along: vec2(u, v) * HORIZON }
    });
}

fn hull(mesh: &mut Mesh, s: &Surfaces) {
    for side in [-1.0, 1.0] {
        // To port the stations run the other way, so that fronts face outwards.
        mesh.patch(s.hull, [180, 16], |u, v| {
            let position = hull_point(side * (2.0 * u - 1.0), v, side);
            Vertex { position, along: vec2(position.x, position.y) }
        });
        for t in [0.45, 0.62, 0.8, 0.95] {
            seam(mesh, s.hull, t, side);
        }
    }
    let transom = hull_point(-1.0, 1.0, 1.0);
    mesh.patch(s.hull, [12, 16], |u, v| {
        let edge = hull_point(-1.0, v, 1.0);
        let position = edge.with_z(edge.z * (2.0 * u - 1.0));
        Vertex { position, along: vec2(position.z, position.y) }
    });
    mesh.cuboid(s.white, transom + vec3(-0.06, -3.0, -9.0), transom + vec3(-0.02, -2.2, -4.0), 9.0);
    mesh.patch(s.deck, [180, 12], |u, v| {
        let position = deck_point(2.0 * u - 1.0, 1.0 - 2.0 * v);
        Vertex { position, along: vec2(position.x, position.z) }
    });
}

/// Rivets along the hull's length.
fn seam(mesh: &mut Mesh, surface: Surface, t: f32, side: f32) {
    const RIVETS: u32 = 1_500;
    for i in 0..RIVETS {
        let station = -0.995 + 1.97 * (i as f32 + 0.5) / RIVETS as f32;
        let at = hull_point(station, t, side);
        let [ahead, above] = [hull_point(station + 1e-3, t, side), hull_point(station, t + 1e-2, side)];
        let normal = side * (ahead - at).cross(above - at).normalize();
        rivet(mesh, surface, at, normal, 0.035);
    }
}

/// The houses, with bands of windows.
fn superstructure(mesh: &mut Mesh, s: &Surfaces) {
    const CELL: f32 = 3.0;
    for (min, max, inset) in [
        (vec3(6.0, 6.4, -7.0), vec3(40.0, 11.0, 7.0), 0.4),
        (vec3(16.0, 11.0, -6.4), vec3(36.0, 17.0, 6.4), 0.5),
        (vec3(18.0, 17.0, -5.0), vec3(30.0, 22.0, 5.0), 0.9),
        (vec3(-13.0, 6.4, -6.0), vec3(5.0, 10.0, 6.0), 0.3),
        (vec3(-56.0, 6.4, -5.0), vec3(-46.5, 8.6, 5.0), 0.2),
        (vec3(42.0, 6.4, -4.5), vec3(50.0, 9.8, 4.5), 0.3),
    ] {
        house(mesh, s.house, min, max, inset, CELL);
    }
    // The bridge's windows lean with the wall, 0.5 m on 6 m.
    for i in 0..8 {
        let z = -3.95 + 1.25 * i as f32;
        let foot = vec3(35.70, 14.6, z);
        window(mesh, s, [foot, Vec3::NEG_Z * 1.05, vec3(-0.12, 1.4, 0.0)]);
    }
    for side in [-1.0, 1.0] {
        for i in 0..10 {
            // To port the width runs aft, so that the panes face outwards.
            let start = if side > 0.0 { 18.0 } else { 19.3 };
            let foot = vec3(start + 1.7 * i as f32, 14.6, side * 6.14);
            window(mesh, s, [foot, Vec3::X * side * 1.3, vec3(0.0, 1.4, -side * 0.12)]);
        }
        for i in 0..14 {
            let centre = vec3(8.0 + 2.2 * i as f32, 9.2, side * 6.84);
            porthole(mesh, s, centre, side);
        }
        for i in 0..6 {
            porthole(mesh, s, vec3(-11.0 + 2.6 * i as f32, 8.6, side * 5.86), side);
        }
    }
}

/// A mirroring pane `[foot, width, height]` in a raised frame.
fn window(mesh: &mut Mesh, s: &Surfaces, [foot, width, height]: [Vec3; 3]) {
    let out = width.cross(height).normalize();
    mesh.quad(s.window, foot + out * 0.02, width, height, 10.0);
    let corners = [foot, foot + width, foot + width + height, foot + height];
    for i in 0..4 {
        let ends = [corners[i], corners[(i + 1) % 4]].map(|p| (p + out * 0.02, 0.05));
        mesh.cylinder(s.dark, ends, 8, 6);
    }
}

/// A round window with a brass rim on a wall across z.
fn porthole(mesh: &mut Mesh, s: &Surfaces, centre: Vec3, side: f32) {
    let out = Vec3::Z * side;
    mesh.disc(s.window, centre + out * 0.12, out, 0.3, 24);
    mesh.cylinder(s.brass, [(centre - out * 0.2, 0.34), (centre + out * 0.14, 0.3)], 24, 3);
}

/// Two raked funnels of oval section with their pipes.
fn funnels(mesh: &mut Mesh, s: &Surfaces) {
    for x in [-9.0, 0.5] {
        let wall = |scale: f32| {
            move |u: f32, v: f32| {
                let turn: Vec2 = circle(-u) * vec2(2.6, 1.8) * (1.0 - 0.15 * v) * scale;
                Vertex {
                    position: vec3(x - 1.5 * v + turn.x, 10.0 + 9.0 * v, turn.y),
                    along: vec2(u * TAU * 2.2, 9.0 * v),
                }
            }
        };
        mesh.patch(s.house, [64, 24], wall(1.0));
        mesh.patch(s.dark, [64, 24], |u, v| wall(0.95)(1.0 - u, v));
        for i in 0..6 {
            let turn = circle(i as f32 / 6.0) * vec2(1.5, 1.0);
            let foot = vec3(x + turn.x, 10.2, turn.y);
            mesh.cylinder(s.dark, [(foot, 0.4), (foot + vec3(-1.6, 9.4, 0.0), 0.35)], 24, 12);
        }
    }
}
