//! The machinery hall: the densest place of the ship. Two open turbines of some thousand blades,
//! gears, banks of bent tubes, finned generators, valves and cables stand within a few metres.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

use super::parts::{bolt, flange, hand_wheel, rivet_row};
use super::surfaces::Surfaces;
use crate::builtin::mesh::{Mesh, Surface, Vertex, circle};
use saarcor_random::Random;

/// The hall's inside.
pub const MIN: Vec3 = Vec3::new(-45.0, 6.8, -8.0);
/// The hall's inside.
pub const MAX: Vec3 = Vec3::new(-15.0, 15.0, 8.0);
/// How far the lining stands off the outer wall.
const LINING: f32 = 0.2;
/// The turbines' axes lie at this height, at z = ±[`AXIS_Z`].
const AXIS_Y: f32 = 8.8;
const AXIS_Z: f32 = 2.0;

/// Builds the hall and all that stands in it.
pub fn machinery(mesh: &mut Mesh, s: &Surfaces) {
    walls(mesh, s);
    for side in [-1.0, 1.0] {
        turbine(mesh, s, vec3(-40.0, AXIS_Y, side * AXIS_Z));
        generator(mesh, s, vec3(-24.0, AXIS_Y, side * AXIS_Z));
        gears(mesh, s, side);
        tube_bank(mesh, s, vec3(-40.0, 11.2, side * AXIS_Z));
        steam_pipes(mesh, s, side);
        cables(mesh, s, side);
        catwalk(mesh, s, side);
    }
}

/// Outer walls and lining, with a door aft, one to port and an open skylight.
fn walls(mesh: &mut Mesh, s: &Surfaces) {
    for (surface, inset, cell) in [(s.house, 0.0, 2.0), (s.lining, LINING, 1.0)] {
        let min = MIN + vec3(inset, -0.4 + inset, inset);
        let max = MAX - Vec3::splat(inset);
        let size = max - min;
        let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
        let door = |from: f32, to: f32| [(vec2(from, -1.0), vec2(to, 5.6 - inset))];
        let aft = door(5.0 - inset, 11.0 - inset);
        let port = door(21.0 - inset, 28.0 - inset);
        let skylight = [(vec2(2.0 - inset, 1.0 - inset), vec2(28.0 - inset, 15.0 - inset))];
        mesh.pierced_quad(surface, [min, z, y], &aft, cell);
        mesh.pierced_quad(surface, [min + x, y, z], &[], cell);
        mesh.pierced_quad(surface, [min, x, y], &port, cell);
        mesh.pierced_quad(surface, [min + z, x, y], &[], cell);
        mesh.pierced_quad(surface, [min + y, x, z], &skylight, cell);
    }
    let size = MAX - MIN;
    mesh.quad(s.floor, MIN.with_z(MAX.z), Vec3::X * size.x, Vec3::NEG_Z * size.z, 0.5);
    // Rivets along the seams of the outer plates.
    for z in [MIN.z - 0.005, MAX.z + 0.005] {
        let normal = Vec3::Z * z.signum();
        for y in [8.0, 10.0, 12.0, 14.0, 14.9] {
            // The port door reaches higher than the two lower rows.
            let end = if z < 0.0 && y < 12.0 { MIN.x + 21.0 } else { MAX.x };
            let row = [vec3(MIN.x, y, z), vec3(end, y, z)];
            rivet_row(mesh, s.house, row, normal, 0.1, 0.025);
        }
    }
}

/// A turbine along x from `from`, 12 m long: the lower half of its casing, the shaft and its
/// stages of twisted blades.
fn turbine(mesh: &mut Mesh, s: &Surfaces, from: Vec3) {
    const LENGTH: f32 = 12.0;
    const STAGES: u32 = 15;
    const BLADES: u32 = 84;
    const CASING: f32 = 1.55;
    let to = from + Vec3::X * LENGTH;
    mesh.closed_cylinder(s.steel, [(from - Vec3::X * 0.5, 0.35), (to + Vec3::X * 2.0, 0.35)], 48, 60);
    mesh.patch(s.casing, [120, 48], |u, v| {
        let p = circle(0.5 + v / 2.0) * CASING;
        Vertex { position: from + vec3(u * LENGTH, p.y, p.x), along: vec2(u * LENGTH, v * PI * CASING) }
    });
    for side in [-1.0, 1.0] {
        let rim = from + Vec3::Z * side * CASING;
        let half = vec3(0.0, 0.06, 0.15);
        mesh.cuboid(s.casing, rim - half, rim + half + Vec3::X * LENGTH, 0.3);
        for i in 0..96 {
            let at = rim + vec3((i as f32 + 0.5) / 96.0 * LENGTH, half.y, 0.0);
            bolt(mesh, s.steel, at, Vec3::Y, 0.035);
        }
    }
    for stage in 0..STAGES {
        let part = stage as f32 / (STAGES - 1) as f32;
        let hub = from + Vec3::X * (0.5 + part * (LENGTH - 1.0));
        let height = 0.45 + 0.5 * part;
        let disc = Vec3::X * 0.12;
        mesh.closed_cylinder(s.steel, [(hub - disc, 0.5), (hub + disc, 0.5)], BLADES, 1);
        let mut blade = Mesh::new(mesh.is_textured());
        blade_of(&mut blade, s.brass, height);
        for i in 0..BLADES {
            let turn = Quat::from_rotation_x(TAU * i as f32 / BLADES as f32);
            mesh.append(&blade, Affine3A::from_rotation_translation(turn, hub));
        }
    }
}

/// A blade from radius 0.5 outwards along y: a lens-shaped section that turns towards the tip.
fn blade_of(mesh: &mut Mesh, surface: Surface, height: f32) {
    const CHORD: f32 = 0.2;
    mesh.patch(surface, [12, 9], |u, v| {
        let p = circle(u);
        // A lens: the chord along x, a thickness of a tenth, and camber.
        let section = vec2(p.x * 0.5, 0.08 * p.y + 0.15 * (1.0 - p.x * p.x)) * CHORD;
        let turned = Vec2::from_angle(0.4 + 0.7 * v).rotate(section);
        let taper = 1.0 - 0.35 * v;
        let position = vec3(turned.x * taper, 0.5 + v * height, turned.y * taper * 0.5);
        Vertex { position, along: vec2(u * CHORD, v * height) }
    });
}

/// A generator along x: a finned drum between two end shields, with its foot.
fn generator(mesh: &mut Mesh, s: &Surfaces, from: Vec3) {
    const FINS: u32 = 90;
    const LENGTH: f32 = 3.0;
    let mut drum = Mesh::new(mesh.is_textured());
    let mut profile = vec![vec2(0.0, 0.0), vec2(1.2, 0.05)];
    for i in 0..FINS {
        let at = |part: f32| 0.1 + (i as f32 + part) / FINS as f32 * (LENGTH - 0.2);
        profile.extend([(1.25, 0.1), (1.5, 0.3), (1.5, 0.5), (1.25, 0.7)].map(|(r, p)| vec2(r, at(p))));
    }
    profile.extend([vec2(1.2, LENGTH - 0.05), vec2(0.0, LENGTH)]);
    drum.lathe(s.casing, &profile, 84);
    let along_x = Quat::from_rotation_z(-FRAC_PI_2);
    mesh.append(&drum, Affine3A::from_rotation_translation(along_x, from));
    let foot = vec3(from.x + 0.3, MIN.y, from.z - 1.2);
    mesh.cuboid(s.dark, foot, foot + vec3(2.4, 0.8, 2.4), 0.4);
}

/// The reduction gear of one side: a wheel on the turbine's shaft, and an idler towards the middle.
fn gears(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    for (z, x, radius, teeth) in
        [(AXIS_Z, -27.4, 1.15, 120), (0.45, -27.4, 0.42, 44), (AXIS_Z, -26.5, 0.8, 84)]
    {
        gear(mesh, s.steel, vec3(x, AXIS_Y, side * z), radius, teeth, side);
    }
}

/// A helical gear about x, 0.7 m wide.
fn gear(mesh: &mut Mesh, surface: Surface, from: Vec3, radius: f32, teeth: u32, hand: f32) {
    const WIDTH: f32 = 0.7;
    const POINTS_A_TOOTH: u32 = 8;
    let points = teeth * POINTS_A_TOOTH;
    // Half the height of a tooth; the flank is a flattened sine.
    let depth = 1.2 * radius / teeth as f32;
    let rim = |u: f32, v: f32| {
        let wave = libm::sinf(TAU * (u * teeth as f32).fract());
        let reach = radius + depth * (2.0 * wave).clamp(-1.0, 1.0);
        let p = circle(u + hand * 0.03 * v) * reach;
        from + vec3(v * WIDTH, p.x, p.y)
    };
    mesh.patch(surface, [points, 10], |u, v| Vertex {
        position: rim(u, v),
        along: vec2(u * TAU * radius, v * WIDTH),
    });
    for end in [0.0, 1.0] {
        let hub = from + Vec3::X * end * WIDTH;
        mesh.patch(surface, [points, 4], |u, v| Vertex {
            position: hub.lerp(rim(u, end), if end == 0.0 { v } else { 1.0 - v }),
            along: vec2(u, v) * radius,
        });
    }
}

/// A bank of serpentine tubes over a turbine, in planes across x.
fn tube_bank(mesh: &mut Mesh, s: &Surfaces, from: Vec3) {
    const PLANES: u32 = 100;
    const PASSES: u32 = 14;
    const BEND_STEPS: u32 = 10;
    const HALF_WIDTH: f32 = 1.45;
    const PITCH: f32 = 0.16;
    const LENGTH: f32 = 5.6;
    const RADIUS: f32 = 0.022;
    let mut line = Vec::new();
    for pass in 0..PASSES {
        let y = pass as f32 * PITCH;
        let side = if pass % 2 == 0 { 1.0 } else { -1.0 };
        line.push(vec3(0.0, y, -side * HALF_WIDTH));
        line.push(vec3(0.0, y, 0.0));
        if pass + 1 < PASSES {
            line.extend((0..BEND_STEPS).map(|i| {
                let p = circle(0.75 + 0.5 * i as f32 / BEND_STEPS as f32) * PITCH / 2.0;
                vec3(0.0, y + PITCH / 2.0 + p.y, side * (HALF_WIDTH + p.x))
            }));
        }
    }
    // An even number of passes ends where it began.
    line.push(vec3(0.0, (PASSES - 1) as f32 * PITCH, -HALF_WIDTH));
    let mut serpentine = Mesh::new(mesh.is_textured());
    // The first point of a pass repeats the last of the bend before it, but for rounding.
    line.dedup_by(|a, b| a.distance(*b) < 1e-3);
    serpentine.tube(s.copper, &line, RADIUS, 12);
    for plane in 0..PLANES {
        let at = from + Vec3::X * LENGTH * plane as f32 / (PLANES - 1) as f32;
        mesh.append(&serpentine, Affine3A::from_translation(at));
    }
    // Headers and end frames.
    for y in [-0.2, (PASSES - 1) as f32 * PITCH + 0.2] {
        let at = from + vec3(0.0, y, -HALF_WIDTH);
        mesh.closed_cylinder(s.insulation, [(at, 0.18), (at + Vec3::X * LENGTH, 0.18)], 32, 60);
    }
    for x in [-0.2, LENGTH + 0.1] {
        for z in [-1.8, 1.7] {
            let foot = vec3(from.x + x, MIN.y, from.z + z);
            mesh.cuboid(s.dark, foot, foot + vec3(0.1, 6.8, 0.1), 0.3);
        }
    }
}

/// Steam pipes from each header down to the turbine's side, with flanges, bolts and hand wheels.
fn steam_pipes(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    const PIPES: u32 = 14;
    const RADIUS: f32 = 0.12;
    for i in 0..PIPES {
        let x = -39.8 + 0.4 * i as f32;
        let line: Vec<Vec3> = (0..=40)
            .map(|j| {
                let t = j as f32 / 40.0;
                let z = 3.95 + 0.35 * libm::sinf(PI * t);
                vec3(x, 13.2 - 4.9 * t, side * z)
            })
            .collect();
        mesh.tube(s.insulation, &line, RADIUS, 20);
        for j in [6, 14, 22, 30] {
            let dir = (line[j + 1] - line[j]).normalize();
            flange(mesh, [s.steel, s.brass], line[j], dir, RADIUS);
        }
        let turn = Quat::from_rotation_y(if side > 0.0 { 0.0 } else { PI });
        hand_wheel(mesh, s.red, line[18] + Vec3::Z * side * 0.3, turn, 0.17);
    }
}

/// Cables that sag between trays along the side wall.
fn cables(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    const CABLES: u32 = 66;
    const POINTS: u32 = 260;
    // To port the bundle ends before the door.
    let length = if side > 0.0 { 29.0 } else { 20.0 };
    let mut random = Random::new(if side > 0.0 { 11 } else { 12 });
    for i in 0..CABLES {
        let y = 10.2 + 0.07 * (i % 33) as f32;
        let z = side * (7.6 - 0.09 * (i / 33) as f32);
        let [phase, sag] = [random.unit(), random.between(0.02, 0.1)];
        let line: Vec<Vec3> = (0..=POINTS)
            .map(|j| {
                let t = j as f32 / POINTS as f32;
                let hang = libm::sinf(PI * 10.0 * t).abs();
                let wave = 0.02 * libm::sinf(TAU * (7.0 * t + phase));
                vec3(MIN.x + 0.4 + length * t, y - sag * hang + wave, z + wave)
            })
            .collect();
        let surface = if i % 9 == 0 { s.red } else { s.cable };
        mesh.tube(surface, &line, 0.03, 7);
    }
    for i in 0..=10 {
        let x = MIN.x + 0.4 + length * i as f32 / 10.0;
        let near = side * 7.4;
        let far = side * 7.75;
        let (low, high) = (near.min(far), near.max(far));
        for y in [10.0, 12.6] {
            mesh.cuboid(s.dark, vec3(x - 0.04, y, low), vec3(x + 0.04, y + 0.05, high), 0.2);
        }
    }
}

/// A grated walkway beside the engine, with a railing.
fn catwalk(mesh: &mut Mesh, s: &Surfaces, side: f32) {
    const BARS: u32 = 420;
    let (inner, outer) = (side * 4.7, side * 6.9);
    let (low, high) = (inner.min(outer), inner.max(outer));
    for i in 0..BARS {
        let x = -42.0 + 22.0 * i as f32 / BARS as f32;
        mesh.cuboid(s.dark, vec3(x, 7.3, low), vec3(x + 0.012, 7.36, high), 10.0);
    }
    for i in 0..12 {
        let z = low + (high - low) * (i as f32 + 0.5) / 12.0;
        mesh.cuboid(s.dark, vec3(-42.0, 7.27, z), vec3(-20.0, 7.3, z + 0.012), 30.0);
    }
    for i in 0..=22 {
        let foot = vec3(-42.0 + i as f32, 7.3, inner);
        mesh.closed_cylinder(s.brass, [(foot, 0.02), (foot + Vec3::Y * 0.9, 0.02)], 10, 4);
    }
    for y in [7.8, 8.2] {
        let ends = [(vec3(-42.0, y, inner), 0.02), (vec3(-20.0, y, inner), 0.02)];
        mesh.closed_cylinder(s.brass, ends, 10, 44);
    }
}
