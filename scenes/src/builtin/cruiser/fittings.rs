//! What stands on the decks: guns, launchers, mast and radars, helicopter, chains, boats, rails.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, Quat, Vec3, vec2, vec3};

use super::parts::{bolt, hand_wheel, house, rivet_row, turned};
use super::ship::{HALF_LENGTH, deck_point, hull_point};
use super::surfaces::Surfaces;
use crate::builtin::mesh::{Mesh, Vertex, circle};

/// Builds all fittings.
pub fn fittings(mesh: &mut Mesh, s: &Surfaces) {
    for (x, y, angle) in [(58.0, None, 0.0), (46.0, Some(9.8), 0.15), (-62.0, None, PI)] {
        let deck = deck_point(x / HALF_LENGTH, 0.0);
        turret(mesh, s, vec3(x, y.unwrap_or(deck.y), 0.0), angle);
    }
    launchers(mesh, s);
    mast(mesh, s);
    arrays(mesh, s);
    helicopter(mesh, s, deck_point(-0.85, 0.0));
    for side in [-1.0, 1.0] {
        anchor_chain(mesh, s, side);
        railing(mesh, s, side);
        boats(mesh, s, side);
    }
}

/// A gun house with two barrels that points along x before the turn by `angle`.
fn turret(mesh: &mut Mesh, s: &Surfaces, foot: Vec3, angle: f32) {
    let mut gun = Mesh::new(mesh.is_textured());
    gun.cylinder(s.house, [(Vec3::NEG_Y * 0.3, 2.8), (Vec3::Y * 0.6, 2.8)], 96, 4);
    house(&mut gun, s.house, vec3(-3.2, 0.6, -2.4), vec3(3.0, 3.2, 2.4), 0.5, 0.25);
    for i in 0..96 {
        let turn = circle(i as f32 / 96.0);
        bolt(&mut gun, s.steel, vec3(turn.x * 2.7, 0.6, turn.y * 2.7), Vec3::Y, 0.05);
    }
    for side in [-1.0, 1.0] {
        let wall = |x: f32, y: f32| vec3(x, y, side * (2.4 - 0.5 * (y - 0.6) / 2.6));
        for y in [0.8, 1.4, 2.0, 2.6, 3.0] {
            let row = [wall(-2.6, y), wall(2.5, y)];
            rivet_row(&mut gun, s.house, row, Vec3::Z * side, 0.05, 0.014);
        }
        // A barrel from the breech to the flared muzzle, with its sleeve and rings.
        let mut barrel = Mesh::new(mesh.is_textured());
        let profile: Vec<_> = (0..=120)
            .map(|i| {
                let t = i as f32 / 120.0;
                let sleeve = if t < 0.25 { 0.1 } else { 0.0 };
                let collar = if i % 20 < 2 { 0.02 } else { 0.0 };
                let muzzle = 0.06 * ((t - 0.95) / 0.05).max(0.0);
                vec2(0.22 - 0.08 * t + sleeve + collar + muzzle, 6.5 * t)
            })
            .collect();
        barrel.lathe(s.house, &profile, 48);
        let bore: Vec<_> = (0..=20).map(|i| vec2(0.1, 6.5 - 0.1 * i as f32)).collect();
        barrel.lathe(s.dark, &bore, 32);
        let elevated = Quat::from_rotation_z(0.12 - FRAC_PI_2);
        let trunnion = vec3(2.2, 1.9, side * 0.8);
        gun.append(&barrel, Affine3A::from_rotation_translation(elevated, trunnion));
    }
    gun.torus(s.dark, vec3(-0.5, 3.25, 1.0), Quat::from_rotation_x(FRAC_PI_2), [0.45, 0.08], [48, 12]);
    hand_wheel(&mut gun, s.red, vec3(-0.5, 3.35, 1.0), Quat::from_rotation_x(FRAC_PI_2), 0.3);
    mesh.append(&gun, turned(foot, angle));
}

/// Two fields of launch cells: hatches with frames, hinges and bolts.
fn launchers(mesh: &mut Mesh, s: &Surfaces) {
    let mut hatch = Mesh::new(mesh.is_textured());
    house(&mut hatch, s.house, vec3(-0.42, 0.0, -0.42), vec3(0.42, 0.12, 0.42), 0.04, 0.3);
    for side in [-1.0, 1.0] {
        let at = vec3(-0.45, 0.08, side * 0.25);
        let half = Vec3::Z * 0.1;
        hatch.closed_cylinder(s.steel, [(at - half, 0.05), (at + half, 0.05)], 12, 1);
        for x in [-0.3, 0.0, 0.3] {
            bolt(&mut hatch, s.steel, vec3(x, 0.12, side * 0.32), Vec3::Y, 0.03);
        }
    }
    for (x, y, rows) in [(66.0, None, 8), (-54.5, Some(8.6), 8)] {
        for row in 0..rows {
            for column in 0..8 {
                let at_x = x + row as f32;
                let deck = deck_point(at_x / HALF_LENGTH, 0.0).y;
                let z = -3.5 + column as f32;
                let at = vec3(at_x, y.unwrap_or(deck - 0.02), z);
                mesh.append(&hatch, Affine3A::from_translation(at));
            }
        }
    }
}

/// The lattice mast with platforms, rotating dishes and aerials.
fn mast(mesh: &mut Mesh, s: &Surfaces) {
    const FOOT: Vec3 = Vec3::new(23.0, 22.0, 0.0);
    const LEVELS: u32 = 24;
    const HEIGHT: f32 = 18.0;
    let corner = |level: f32, i: usize| {
        let half = 1.8 - 1.4 * level / LEVELS as f32;
        let [x, z] = [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]][i % 4];
        FOOT + vec3(x * half, HEIGHT * level / LEVELS as f32, z * half)
    };
    let mut strut = |from: Vec3, to: Vec3, radius: f32| {
        mesh.cylinder(s.white, [(from, radius), (to, radius)], 10, 6);
    };
    for level in 0..LEVELS {
        let [low, high] = [level as f32, (level + 1) as f32];
        for i in 0..4 {
            strut(corner(low, i), corner(high, i), 0.09);
            strut(corner(high, i), corner(high, i + 1), 0.05);
            strut(corner(low, i), corner(high, i + 1), 0.04);
            strut(corner(low, i + 1), corner(high, i), 0.04);
        }
    }
    for level in 0..LEVELS {
        for i in 0..4 {
            for j in 0..4 {
                let turn = circle(j as f32 / 4.0) * 0.12;
                let at = corner(level as f32, i) + vec3(turn.x, 0.0, turn.y);
                bolt(mesh, s.steel, at, Vec3::Y, 0.03);
            }
        }
    }
    for (level, radius) in [(8.0, 2.4), (16.0, 1.8), (24.0, 1.2)] {
        let centre = FOOT + Vec3::Y * HEIGHT * level / LEVELS as f32;
        let ends = [(centre, radius), (centre + Vec3::Y * 0.1, radius)];
        mesh.closed_cylinder(s.house, ends, 48, 1);
        for i in 0..32 {
            let turn = circle(i as f32 / 32.0) * radius * 0.97;
            let post = centre + vec3(turn.x, 0.1, turn.y);
            mesh.cylinder(s.white, [(post, 0.02), (post + Vec3::Y * 0.9, 0.02)], 8, 3);
        }
        let flat = Quat::from_rotation_x(FRAC_PI_2);
        for rail in [0.55, 1.0] {
            mesh.torus(s.white, centre + Vec3::Y * rail, flat, [radius * 0.97, 0.025], [64, 8]);
        }
    }
    for (level, side) in [(9.5, 1.0), (17.5, -1.0)] {
        let centre = FOOT + vec3(1.2, HEIGHT * level / LEVELS as f32 + 0.6, side * 1.2);
        dish(mesh, s, centre, side * 0.6);
    }
    for i in 0..10 {
        let turn = circle(i as f32 / 10.0);
        let foot = FOOT + vec3(turn.x, HEIGHT, turn.y);
        mesh.cylinder(s.white, [(foot, 0.03), (foot + vec3(turn.x, 4.0, turn.y) * 0.8, 0.008)], 8, 24);
    }
}

/// A parabolic dish of wire mesh that looks forward before the turn by `angle`.
fn dish(mesh: &mut Mesh, s: &Surfaces, centre: Vec3, angle: f32) {
    let mut dish = Mesh::new(mesh.is_textured());
    let bowl = |u: f32, v: f32| {
        let p = circle(u) * 1.3 * v;
        vec3(0.35 * p.length_squared(), p.x, p.y * 1.4)
    };
    for i in 0..64 {
        let u = i as f32 / 64.0;
        let rib: Vec<Vec3> = (1..=20).map(|j| bowl(u, j as f32 / 20.0)).collect();
        dish.tube(s.steel, &rib, 0.008, 6);
    }
    for i in 1..=20 {
        let hoop: Vec<Vec3> = (0..=96).map(|j| bowl(j as f32 / 96.0, i as f32 / 20.0)).collect();
        dish.tube(s.steel, &hoop, 0.008, 6);
    }
    for i in 0..3 {
        let rim = bowl(i as f32 / 3.0, 1.0);
        dish.cylinder(s.white, [(rim, 0.03), (vec3(1.4, 0.0, 0.0), 0.03)], 10, 8);
    }
    dish.sphere(s.red, vec3(1.4, 0.0, 0.0), 0.15, 24, 16);
    dish.closed_cylinder(s.house, [(vec3(-0.1, -1.2, 0.0), 0.3), (vec3(-0.1, 0.0, 0.0), 0.2)], 24, 6);
    mesh.append(&dish, turned(centre, angle));
}

/// The phased arrays: a panel of small horns on each wall of the upper house.
fn arrays(mesh: &mut Mesh, s: &Surfaces) {
    const ROWS: u32 = 44;
    const PITCH: f32 = 0.075;
    let mut panel = Mesh::new(mesh.is_textured());
    let half = ROWS as f32 * PITCH / 2.0;
    let frame = vec3(half + 0.15, half + 0.15, 0.03);
    panel.cuboid(s.dark, -frame, frame, 0.5);
    for i in 0..ROWS * ROWS {
        let [column, row] = [i % ROWS, i / ROWS].map(|c| (c as f32 + 0.5) * PITCH - half);
        // Cut the corners, so that the array is an octagon.
        if column.abs() + row.abs() < 1.5 * half {
            let foot = vec3(column, row, 0.03);
            let ends = [(foot, 0.02), (foot + Vec3::Z * 0.05, 0.034)];
            panel.cylinder(s.copper, ends, 8, 1);
            panel.cylinder(s.steel, [(foot, 0.006), (foot + Vec3::Z * 0.07, 0.006)], 5, 1);
        }
    }
    for (centre, angle) in [
        (vec3(29.75, 19.4, 0.0), FRAC_PI_2),
        (vec3(18.25, 19.4, 0.0), -FRAC_PI_2),
        (vec3(24.0, 19.4, 4.75), 0.0),
        (vec3(24.0, 19.4, -4.75), PI),
    ] {
        let lean = Quat::from_rotation_y(angle) * Quat::from_rotation_x(-0.18);
        mesh.append(&panel, Affine3A::from_rotation_translation(lean, centre));
    }
}

/// A helicopter that stands on the deck at `foot`, its nose to the bow.
fn helicopter(mesh: &mut Mesh, s: &Surfaces, foot: Vec3) {
    let mut craft = Mesh::new(mesh.is_textured());
    // The fuselage: a body of revolution about x, blunt before, drawn out to the tail boom.
    let radius = |v: f32| {
        let nose = (1.0 - (1.0 - v / 0.25).max(0.0).powi(2)).max(0.0).sqrt();
        let tail = if v > 0.5 { 0.18 + 0.82 * (1.0 - (v - 0.5) / 0.25).max(0.0).powi(2) } else { 1.0 };
        1.15 * nose * tail
    };
    let body = |u: f32, v: f32| {
        let p = circle(u) * radius(v);
        let position = vec3(4.0 - 12.0 * v, 1.9 + p.y + 0.6 * (v - 0.5).max(0.0), p.x);
        Vertex { position, along: vec2(12.0 * v, u * 7.0) }
    };
    // Glass before, paint behind.
    const COCKPIT: f32 = 0.14;
    craft.patch(s.canopy, [96, 20], |u, v| body(u, 0.002 + v * (COCKPIT - 0.002)));
    craft.patch(s.white, [96, 140], |u, v| body(u, COCKPIT + v * (1.0 - COCKPIT)));
    for z in [-0.4, 0.4] {
        craft.sphere(s.red, vec3(3.0, 1.7, z), 0.3, 24, 16);
        craft.sphere(s.dark, vec3(3.0, 2.15, z), 0.18, 24, 16);
    }
    let hub = vec3(0.0, 3.5, 0.0);
    craft.closed_cylinder(s.steel, [(hub - Vec3::Y * 0.7, 0.2), (hub, 0.15)], 32, 8);
    let blade = |mesh: &mut Mesh, hub: Vec3, turn: Quat, length: f32, chord: f32| {
        mesh.patch(s.dark, [24, 60], |u, v| {
            let p = circle(u) * vec2(0.5 * chord, 0.05 * chord);
            let droop = -0.06 * length * v * v;
            let position = hub + turn * vec3(0.15 + v * length, p.y + droop, p.x);
            Vertex { position, along: vec2(v * length, u * chord) }
        });
    };
    for i in 0..5 {
        let turn = Quat::from_rotation_y(0.3 + i as f32 * 0.4 * PI);
        blade(&mut craft, hub, turn, 6.0, 0.45);
    }
    let tail = vec3(-7.7, 2.6, 0.35);
    for i in 0..4 {
        let turn = Quat::from_rotation_z(0.4 + i as f32 * FRAC_PI_2) * Quat::from_rotation_x(FRAC_PI_2);
        blade(&mut craft, tail, turn, 1.2, 0.2);
    }
    for z in [-0.9, 0.9] {
        craft.tube(s.steel, &[vec3(1.0, 1.3, z * 0.8), vec3(1.0, 0.4, z)], 0.06, 12);
        craft.torus(s.dark, vec3(1.0, 0.3, z), Quat::IDENTITY, [0.2, 0.1], [36, 16]);
    }
    mesh.append(&craft, Affine3A::from_translation(foot));
}

/// An anchor chain from the winch over the foredeck to the hawse, its links by turns upright and
/// flat.
fn anchor_chain(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    const LINKS: u32 = 110;
    let mut link = Mesh::new(mesh.is_textured());
    link.patch(s.dark, [32, 12], |u, v| {
        // A stadium-shaped ring.
        let around = circle(u);
        let centre = vec3(around.x * 0.075 + around.x.signum() * 0.07, 0.0, around.y * 0.075);
        let out = vec3(around.x, 0.0, around.y);
        let p = circle(v) * 0.03;
        Vertex { position: centre + out * p.x + Vec3::Y * p.y, along: vec2(u, v) * 0.5 }
    });
    let first = 0.835;
    for i in 0..LINKS {
        let station = first + 0.19 / HALF_LENGTH * i as f32 * 0.55;
        let across = side * 0.35;
        let at = deck_point(station, across) + Vec3::Y * 0.12;
        let roll = Quat::from_rotation_x(if i % 2 == 0 { 0.0 } else { FRAC_PI_2 });
        let scale = Vec3::splat(0.8);
        mesh.append(&link, Affine3A::from_scale_rotation_translation(scale, roll, at));
    }
    let winch = deck_point(first - 0.008, side * 0.35);
    let mut drum = Mesh::new(mesh.is_textured());
    let profile =
        [(0.6, 0.0), (0.6, 0.15), (0.35, 0.3), (0.3, 0.5), (0.35, 0.7), (0.55, 0.8), (0.5, 0.95), (0.0, 1.0)];
    drum.lathe(s.house, &profile.map(|(r, y)| vec2(r, y)), 72);
    mesh.append(&drum, Affine3A::from_translation(winch - Vec3::Y * 0.05));
}

/// Posts and three wires along one edge of the deck.
fn railing(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    const POSTS: u32 = 120;
    let at = |part: f32, height: f32| {
        let station = -0.99 + 1.95 * part;
        let edge = hull_point(station, 1.0, side);
        edge + vec3(0.0, height, -side * 0.12 * (edge.z.abs() / 2.0).min(1.0))
    };
    for i in 0..=POSTS {
        let part = i as f32 / POSTS as f32;
        let ends = [(at(part, -0.02), 0.03), (at(part, 1.1), 0.025)];
        mesh.cylinder(s.white, ends, 10, 4);
    }
    for height in [0.4, 0.75, 1.1] {
        let wire: Vec<Vec3> = (0..=4 * POSTS)
            .map(|i| {
                let sag = if i % 4 == 0 {
                    0.0
                } else if i % 4 == 2 {
                    0.03
                } else {
                    0.02
                };
                at(i as f32 / (4 * POSTS) as f32, height - sag)
            })
            .collect();
        mesh.tube(s.white, &wire, 0.012, 6);
    }
}

/// Life rafts in cradles along the mid house, and a boat under its davits.
fn boats(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    for i in 0..7 {
        let at = vec3(-11.5 + 2.3 * i as f32, 10.8, side * 4.8);
        let half = Vec3::X * 0.6;
        mesh.cylinder(s.white, [(at - half, 0.4), (at + half, 0.4)], 32, 12);
        for end in [-1.0, 1.0] {
            mesh.sphere(s.white, at + half * end, 0.4, 32, 20);
            let cradle = at + half * 0.6 * end;
            let turn = Quat::from_rotation_y(FRAC_PI_2);
            mesh.torus(s.dark, cradle, turn, [0.41, 0.03], [32, 8]);
            let foot = cradle - vec3(0.05, 0.85, 0.3);
            mesh.cuboid(s.dark, foot, foot + vec3(0.1, 0.5, 0.6), 1.0);
        }
    }
    // The hull of the boat: half an ellipsoid, open above.
    let centre = vec3(11.0, 12.6, side * 5.6);
    for (surface, scale) in [(s.red, 1.0), (s.white, 0.96)] {
        mesh.patch(surface, [64, 24], |u, v| {
            let [turn, rise] = [circle(u), circle(0.75 + v / 4.0)];
            let around = if v == 0.0 { 0.0 } else { rise.x };
            let shape = vec3(turn.x * around * 2.8, rise.y * 0.9, turn.y * around * 0.9);
            Vertex { position: centre + shape * scale, along: vec2(u * 9.0, v * 2.0) }
        });
    }
    for x in [9.4, 12.6] {
        let davit: Vec<Vec3> = (0..=24)
            .map(|i| {
                let p = circle(i as f32 / 48.0);
                vec3(x, 11.0 + 3.6 * p.y, side * (4.6 + 1.0 * (1.0 - p.x)))
            })
            .take(18)
            .collect();
        mesh.tube(s.dark, &davit, 0.1, 14);
    }
}
