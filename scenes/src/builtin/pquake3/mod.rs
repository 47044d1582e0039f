//! `pquake3`: a level in the manner of Quake III, walked through at eye height.
//!
//! Seven rooms and corridors lie on a loop: the hall with the pool (open skylights), the east
//! corridor, the works, the stairs up, the chapel with its polished floor and open vault, the
//! stairs down, the laboratory with a pane, a mirror and a gate, and the west corridor back to the
//! hall. The one light stands high above the level, as a sun, and reaches in through the openings.

mod props;
mod surfaces;

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};
use saarcor_model::host::{Light, Scene};

use super::mesh::{Mesh, Surface, Vertex, circle};
use super::palette::Palette;
use super::path::{cameras, evenly};
use props::Item;
use saarcor_random::Random;
use surfaces::{Surfaces, surfaces};

/// Triangles (Table 1, Stated).
const TRIANGLES: usize = 46_356;
/// Frames of the walk: past frame 1046, the last that Table 2 names, and a minute at 20 Hz.
const FRAMES: u32 = 1_200;
/// The longest edge of a wall's or a floor's cell, in metres.
const CELL: f32 = 2.0;
/// The height of the eye above the floor, in metres.
const EYE: f32 = 1.7;

/// Builds the scene, with image textures if `textured`.
#[must_use]
pub fn scene(textured: bool) -> Scene {
    let mut palette = Palette::new(textured);
    let s = surfaces(&mut palette);
    let mut mesh = Mesh::new(textured);
    sky(&mut mesh, &s);
    hall(&mut mesh, &s);
    corridors(&mut mesh, &s);
    works(&mut mesh, &s);
    stairways(&mut mesh, &s);
    chapel(&mut mesh, &s);
    laboratory(&mut mesh, &s);
    rubble(&mut mesh, &s);
    let (triangles, tex_coords) = mesh.into_parts();
    let (materials, textures) = palette.into_parts();
    Scene {
        triangles,
        tex_coords,
        materials,
        textures,
        lights: vec![Light { position: vec3(12.0, 60.0, 36.0), intensity: 1.0 }],
        path: cameras(&evenly(&walk(), FRAMES), FRAMES, 65.0),
        ..Scene::default()
    }
}

/// A side of a room, seen from inside; north is where z is least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    North,
    South,
    West,
    East,
    Floor,
    Ceiling,
}

/// The inside of a box, without the openings in its sides.
struct Room<'a> {
    min: Vec3,
    max: Vec3,
    /// The sides that there are, and of what.
    sides: &'a [(Side, Surface)],
    /// Rectangular holes by their opposite corners; the coordinate across the side is ignored.
    openings: &'a [(Side, Vec3, Vec3)],
}

impl Room<'_> {
    fn build(&self, mesh: &mut Mesh) {
        let (min, size) = (self.min, self.max - self.min);
        let [x, y, z] = [Vec3::X * size, Vec3::Y * size, Vec3::Z * size];
        for &(side, surface) in self.sides {
            let [origin, right, up] = match side {
                Side::North => [min, x, y],
                Side::South => [min + x + z, -x, y],
                Side::West => [min + z, -z, y],
                Side::East => [min + x, z, y],
                Side::Floor => [min + z, x, -z],
                Side::Ceiling => [min + y, x, z],
            };
            let on_side = |p: Vec3| {
                let p = p - origin;
                vec2(p.dot(right.normalize()), p.dot(up.normalize()))
            };
            let holes: Vec<(Vec2, Vec2)> = self
                .openings
                .iter()
                .filter(|opening| opening.0 == side)
                .map(|&(_, a, b)| (on_side(a), on_side(b)))
                .collect();
            mesh.pierced_quad(surface, [origin, right, up], &holes, CELL);
        }
    }
}

/// The four walls of one surface.
fn walls(surface: Surface) -> [(Side, Surface); 4] {
    [Side::North, Side::South, Side::West, Side::East].map(|side| (side, surface))
}

/// The sky, as a box around everything and around the light.
fn sky(mesh: &mut Mesh, s: &Surfaces) {
    mesh.cuboid(s.sky, vec3(-55.0, -8.0, -55.0), vec3(75.0, 80.0, 75.0), 32.5);
}

fn hall(mesh: &mut Mesh, s: &Surfaces) {
    let skylight = |x: f32| (Side::Ceiling, vec3(x - 2.0, 9.0, -5.0), vec3(x + 2.0, 9.0, 5.0));
    let [wall_n, wall_s, wall_w, wall_e] = walls(s.hall_wall);
    Room {
        min: vec3(-12.0, 0.0, -9.0),
        max: vec3(12.0, 9.0, 9.0),
        sides: &[
            wall_n,
            wall_s,
            wall_w,
            wall_e,
            (Side::Floor, s.hall_floor),
            (Side::Ceiling, s.hall_ceiling),
        ],
        openings: &[
            (Side::East, vec3(12.0, 0.0, -1.5), vec3(12.0, 4.0, 1.5)),
            (Side::West, vec3(-12.0, 0.0, -1.5), vec3(-12.0, 4.0, 1.5)),
            (Side::Floor, vec3(-4.0, 0.0, -3.0), vec3(4.0, 0.0, 3.0)),
            skylight(-7.5),
            skylight(0.0),
            skylight(7.5),
        ],
    }
    .build(mesh);
    for x in [-12.0, 12.0] {
        props::arch(mesh, s.trim, vec3(x, 4.0, 0.0), Vec3::Z, 3.0, 0.6);
    }
    // The pool: its basin, the water and a rim.
    let [north, south, west, east] = walls(s.pool);
    Room {
        min: vec3(-4.0, -1.4, -3.0),
        max: vec3(4.0, 0.0, 3.0),
        sides: &[north, south, west, east, (Side::Floor, s.pool)],
        openings: &[],
    }
    .build(mesh);
    // The surface rises and falls by a few centimetres, as after a splash in the middle.
    mesh.patch(s.water, [20, 15], |u, v| {
        let flat = vec3(8.0 * u - 4.0, -0.35, 3.0 - 6.0 * v);
        let ripple = 0.03 * libm::sinf(4.0 * vec2(flat.x, flat.z).length());
        Vertex { position: flat + Vec3::Y * ripple, along: vec2(8.0 * u, 6.0 * v) }
    });
    for z in [-3.3, 3.0] {
        mesh.cuboid(s.trim, vec3(-4.3, 0.0, z), vec3(4.3, 0.25, z + 0.3), CELL);
    }
    for x in [-4.3, 4.0] {
        mesh.cuboid(s.trim, vec3(x, 0.0, -3.0), vec3(x + 0.3, 0.25, 3.0), CELL);
    }
    for x in [-8.0, -2.7, 2.7, 8.0] {
        props::pillar(mesh, s, vec3(x, 0.0, 5.2), 9.0, 0.45);
        props::pillar(mesh, s, vec3(x, 0.0, -6.1), 3.8, 0.35);
        props::pillar(mesh, s, vec3(x, 4.1, -6.1), 4.9, 0.35);
    }
    // The gallery, with a balustrade.
    mesh.cuboid(s.gallery_floor, vec3(-11.9, 3.8, -8.9), vec3(11.9, 4.1, -5.6), CELL);
    for i in 0..24 {
        let mut baluster = Mesh::new(mesh.is_textured());
        let profile = [(0.09, 0.0), (0.09, 0.1), (0.05, 0.2), (0.1, 0.4), (0.05, 0.75), (0.08, 0.9)];
        baluster.lathe(s.pillar, &profile.map(|(r, y)| vec2(r, y)), 7);
        let at = vec3(-11.5 + i as f32, 4.1, -5.75);
        mesh.append(&baluster, Affine3A::from_translation(at));
    }
    mesh.cuboid(s.trim, vec3(-11.9, 5.0, -5.85), vec3(11.9, 5.12, -5.65), CELL);
    mesh.quad(s.gallery, vec3(-11.9, 3.3, -5.7), Vec3::X * 23.8, Vec3::Y * 0.5, CELL);
    for x in [-10.0, -5.0, 3.5, 8.5] {
        props::banner(mesh, s, vec3(x, 7.8, 8.95), Vec3::NEG_X * 1.6, 3.5);
    }
    for x in [-3.75, 3.75] {
        props::lamp(mesh, s, vec3(x, 9.0, 0.0), 3.0);
    }
    props::player(mesh, s, s.red_armour, vec3(5.5, 0.0, 3.9), -2.0);
    props::item(mesh, s, Item::Armour, vec3(-6.5, 0.0, 0.0), 0.8);
    props::item(mesh, s, Item::Health, vec3(6.5, 0.0, -4.3), 0.3);
    props::item(mesh, s, Item::Weapon, vec3(0.0, 4.1, -7.4), 1.1);
    props::item(mesh, s, Item::Ammunition, vec3(-10.5, 0.0, -7.5), 0.5);
}

fn corridors(mesh: &mut Mesh, s: &Surfaces) {
    let [north, south, west, east] = walls(s.corridor_wall);
    let lined = [(Side::Floor, s.corridor_floor), (Side::Ceiling, s.corridor_ceiling)];
    // East: from the hall to the works.
    Room {
        min: vec3(12.0, 0.0, -1.5),
        max: vec3(24.0, 4.0, 1.5),
        sides: &[north, south, lined[0], lined[1]],
        openings: &[(Side::Ceiling, vec3(16.0, 4.0, -0.8), vec3(20.0, 4.0, 0.8))],
    }
    .build(mesh);
    props::grate(mesh, s.grate, vec3(16.0, 4.05, -0.8), Vec3::X * 4.0, Vec3::Z * 1.6, 9);
    for (surface, y, z, radius) in [(s.copper, 3.6, 1.2, 0.15), (s.green_pipe, 3.2, 1.3, 0.1)] {
        let line = [vec3(12.4, y, z), vec3(23.6, y, z)];
        props::pipe(mesh, s, surface, &line, radius);
    }
    // West: from the laboratory to the hall, with a bend.
    Room {
        min: vec3(-17.0, 0.0, -1.5),
        max: vec3(-13.0, 4.0, 18.0),
        sides: &[north, west, east, lined[0], lined[1]],
        openings: &[
            (Side::East, vec3(-13.0, 0.0, -1.5), vec3(-13.0, 4.0, 1.5)),
            (Side::Ceiling, vec3(-16.0, 4.0, 3.0), vec3(-14.0, 4.0, 6.0)),
            (Side::Ceiling, vec3(-16.0, 4.0, 10.0), vec3(-14.0, 4.0, 13.0)),
        ],
    }
    .build(mesh);
    Room {
        min: vec3(-13.0, 0.0, -1.5),
        max: vec3(-12.0, 4.0, 1.5),
        sides: &[north, south, lined[0], lined[1]],
        openings: &[],
    }
    .build(mesh);
    for x in [-16.75, -13.25] {
        let line = [vec3(x, 0.1, 16.5), vec3(x, 3.5, 16.5), vec3(x, 3.5, 2.5), vec3(x, 0.1, 2.5)];
        props::pipe(mesh, s, s.copper, &line, 0.12);
    }
    props::container(mesh, s.crate_wood, s.crate_metal, vec3(-16.2, 0.0, 9.0), 1.0, 0.2);
    props::item(mesh, s, Item::Ammunition, vec3(-16.2, 0.0, 0.0), 0.9);
}

fn works(mesh: &mut Mesh, s: &Surfaces) {
    let [north, south, west, east] = walls(s.works_wall);
    Room {
        min: vec3(24.0, 0.0, -8.0),
        max: vec3(40.0, 7.0, 8.0),
        sides: &[north, south, west, east, (Side::Floor, s.works_floor), (Side::Ceiling, s.works_ceiling)],
        openings: &[
            (Side::West, vec3(24.0, 0.0, -1.5), vec3(24.0, 4.0, 1.5)),
            (Side::South, vec3(30.0, 0.0, 8.0), vec3(34.0, 4.0, 8.0)),
            (Side::Ceiling, vec3(27.0, 7.0, -2.0), vec3(37.0, 7.0, 5.0)),
        ],
    }
    .build(mesh);
    props::arch(mesh, s.trim, vec3(24.0, 4.0, 0.0), Vec3::Z, 3.0, 0.6);
    props::arch(mesh, s.trim, vec3(32.0, 4.0, 8.0), Vec3::X, 4.0, 0.6);
    props::grate(mesh, s.grate, vec3(27.0, 7.05, -2.0), Vec3::X * 10.0, Vec3::Z * 7.0, 12);
    for x in [27.5, 31.5, 36.0] {
        props::tank(mesh, s, vec3(x, 0.0, -5.8), 1.3, 4.6);
        let line = [vec3(x, 4.5, -5.8), vec3(x, 5.8, -5.8), vec3(x, 5.8, 7.5), vec3(x, 2.0, 7.5)];
        // The middle one would end in the doorway.
        let line = if x == 31.5 { &line[..3] } else { &line[..] };
        props::pipe(mesh, s, s.green_pipe, line, 0.22);
    }
    // A platform with a railing, its edge striped.
    mesh.cuboid(s.works_floor, vec3(36.5, 0.0, 0.5), vec3(39.9, 1.2, 6.0), CELL);
    mesh.quad(s.panel, vec3(36.48, 0.9, 0.5), Vec3::Z * 5.5, Vec3::Y * 0.3, CELL);
    for i in 0..6 {
        let foot = vec3(36.6, 1.2, 0.7 + 1.0 * i as f32);
        mesh.closed_cylinder(s.steel, [(foot, 0.04), (foot + Vec3::Y, 0.04)], 8, 1);
    }
    for y in [1.7, 2.2] {
        props::pipe(mesh, s, s.steel, &[vec3(36.6, y, 0.6), vec3(36.6, y, 5.8)], 0.04);
    }
    props::player(mesh, s, s.blue_armour, vec3(38.0, 1.2, 3.0), -FRAC_PI_2);
    for (x, y, z, size, angle) in [
        (25.6, 0.0, 5.8, 1.6, 0.1),
        (27.4, 0.0, 6.5, 1.2, 0.5),
        (25.5, 1.6, 5.9, 1.1, 0.7),
        (26.0, 0.0, 3.7, 1.0, 1.1),
        (37.8, 0.0, -1.5, 1.5, 0.3),
        (38.7, 0.0, -3.4, 1.2, 0.0),
        (33.8, 0.0, -3.2, 1.1, 0.6),
    ] {
        props::container(mesh, s.crate_wood, s.crate_metal, vec3(x, y, z), size, angle);
    }
    props::item(mesh, s, Item::Weapon, vec3(29.5, 0.0, -3.0), 0.4);
    props::item(mesh, s, Item::Health, vec3(35.5, 0.0, 6.8), 0.4);
}

/// The two flights between the lower rooms and the chapel, 4 m above them.
fn stairways(mesh: &mut Mesh, s: &Surfaces) {
    let [north, south, west, east] = walls(s.stair_wall);
    let ceiling = (Side::Ceiling, s.corridor_ceiling);
    Room {
        min: vec3(30.0, 0.0, 8.0),
        max: vec3(34.0, 8.5, 20.0),
        sides: &[north, west, east, ceiling],
        // The north side only closes what the wall of the works leaves open above it.
        openings: &[
            (Side::North, vec3(30.0, 0.0, 8.0), vec3(34.0, 7.0, 8.0)),
            (Side::Ceiling, vec3(30.8, 8.5, 12.0), vec3(33.2, 8.5, 17.0)),
        ],
    }
    .build(mesh);
    props::stairs(mesh, s, vec3(34.0, 0.0, 8.0), Vec3::Z * 12.0, Vec3::NEG_X * 4.0, 4.0, 20);
    Room {
        min: vec3(-8.0, 0.0, 25.0),
        max: vec3(6.0, 8.5, 29.0),
        sides: &[north, south, west, ceiling],
        // The west side closes what the laboratory's wall leaves open above it.
        openings: &[
            (Side::West, vec3(-8.0, 0.0, 25.0), vec3(-8.0, 6.0, 29.0)),
            (Side::Ceiling, vec3(-4.0, 8.5, 25.8), vec3(2.0, 8.5, 28.2)),
        ],
    }
    .build(mesh);
    props::stairs(mesh, s, vec3(-8.0, 0.0, 25.0), Vec3::X * 14.0, Vec3::Z * 4.0, 4.0, 20);
    for z in [25.4, 28.6] {
        let rail = [vec3(-7.5, 1.1, z), vec3(5.5, 4.9, z)];
        props::pipe(mesh, s, s.gold, &rail, 0.05);
    }
}

fn chapel(mesh: &mut Mesh, s: &Surfaces) {
    const SPRINGING: f32 = 9.0;
    const RADIUS: f32 = 7.0;
    let middle = vec3(0.0, SPRINGING, 27.0);
    let window = |x: f32| (Side::South, vec3(x - 0.8, 5.5, 34.0), vec3(x + 0.8, 8.5, 34.0));
    let windows = [10.0, 16.0, 23.0, 30.0, 36.0];
    let [north, south, west, east] = walls(s.chapel_wall);
    let mut openings = vec![
        (Side::North, vec3(30.0, 4.0, 20.0), vec3(34.0, 8.0, 20.0)),
        (Side::West, vec3(6.0, 4.0, 25.0), vec3(6.0, 8.0, 29.0)),
    ];
    openings.extend(windows.map(window));
    Room {
        min: vec3(6.0, 4.0, 20.0),
        max: vec3(40.0, SPRINGING, 34.0),
        sides: &[north, south, west, east, (Side::Floor, s.chapel_floor)],
        openings: &openings,
    }
    .build(mesh);
    for x in windows {
        props::arch(mesh, s.trim, vec3(x, 8.5, 34.0), Vec3::X, 1.6, 0.5);
        props::grate(mesh, s.trim, vec3(x - 0.8, 5.5, 34.1), Vec3::X * 1.6, Vec3::Y * 3.0, 5);
    }
    // Pews on both sides of the way to the altar, but for the doorway.
    for row in 0..9 {
        let x = 15.0 + 1.9 * row as f32;
        props::pew(mesh, s, vec3(x, 4.0, 29.4), Vec3::Z * 3.2);
        if x < 26.0 {
            props::pew(mesh, s, vec3(x, 4.0, 21.2), Vec3::Z * 3.2);
        }
    }
    props::arch(mesh, s.trim, vec3(32.0, 8.0, 20.0), Vec3::X, 4.0, 0.6);
    props::arch(mesh, s.trim, vec3(6.0, 8.0, 27.0), Vec3::Z, 4.0, 0.6);
    // The vault: two shells that leave a slot open along the crown.
    const SHELL: f32 = 0.2;
    for from in [0.0, 0.5 - SHELL] {
        mesh.patch(s.vault, [8, 20], |u, v| {
            let turns = from + SHELL * u;
            let p = circle(turns) * RADIUS;
            Vertex {
                position: vec3(6.0 + 34.0 * v, SPRINGING + p.y, middle.z + p.x),
                along: vec2(turns * 2.0 * PI * RADIUS, 34.0 * v),
            }
        });
    }
    // The end walls under the vault.
    for x in [6.0, 40.0] {
        mesh.patch(s.chapel_wall, [16, 4], |u, v| {
            let p = circle(u / 2.0) * RADIUS * v;
            Vertex { position: middle.with_x(x) + vec3(0.0, p.y, p.x), along: p }
        });
    }
    // Ribs on wall pillars.
    for i in 0..7 {
        let x = 8.0 + 5.0 * i as f32;
        let arc: Vec<Vec3> = (0..=14)
            .map(|j| {
                let p = circle(j as f32 / 28.0) * (RADIUS - 0.15);
                vec3(x, SPRINGING + p.y, middle.z + p.x)
            })
            .collect();
        mesh.tube(s.trim, &arc, 0.22, 7);
        for z in [20.4, 33.6] {
            let in_doorway = z < 21.0 && (29.0..35.0).contains(&x);
            if !in_doorway {
                props::pillar(mesh, s, vec3(x, 4.0, z), 5.0, 0.25);
            }
        }
    }
    for i in 0..6 {
        let hook = vec3(10.5 + 5.0 * i as f32, SPRINGING + RADIUS - 0.2, middle.z);
        // The lamps hang from rods across the slot.
        let rod = Vec3::Z * 2.6;
        mesh.closed_cylinder(s.steel, [(hook - rod, 0.06), (hook + rod, 0.06)], 8, 1);
        props::lamp(mesh, s, hook, 5.0);
    }
    // The altar, before the east wall.
    for (i, side) in [3.2, 2.6, 2.0].into_iter().enumerate() {
        let y = 4.0 + 0.25 * i as f32;
        let half = vec3(side * 0.7, 0.0, side);
        let foot = vec3(36.8, y, 27.0);
        mesh.cuboid(s.tread, foot - half, foot + half + Vec3::Y * 0.25, CELL);
    }
    let upright = Quat::from_rotation_y(FRAC_PI_2);
    mesh.torus(s.gold, vec3(36.8, 6.6, 27.0), upright, [1.1, 0.16], [36, 10]);
    mesh.sphere(s.looking_glass, vec3(36.8, 6.6, 27.0), 0.6, 24, 14);
    for z in [23.0, 31.0] {
        props::banner(mesh, s, vec3(39.95, 9.0, z - 0.9), Vec3::Z * 1.8, 4.0);
    }
    props::item(mesh, s, Item::Armour, vec3(14.0, 4.0, 23.5), 0.2);
    props::item(mesh, s, Item::Health, vec3(20.0, 4.0, 31.0), 0.7);
    props::item(mesh, s, Item::Weapon, vec3(26.0, 4.0, 22.8), 0.9);
}

fn laboratory(mesh: &mut Mesh, s: &Surfaces) {
    let [north, south, west, east] = walls(s.lab_wall);
    Room {
        min: vec3(-22.0, 0.0, 18.0),
        max: vec3(-8.0, 6.0, 34.0),
        sides: &[north, south, west, east, (Side::Floor, s.lab_floor), (Side::Ceiling, s.lab_ceiling)],
        openings: &[
            (Side::East, vec3(-8.0, 0.0, 25.0), vec3(-8.0, 4.0, 29.0)),
            (Side::North, vec3(-17.0, 0.0, 18.0), vec3(-13.0, 4.0, 18.0)),
            (Side::Ceiling, vec3(-18.0, 6.0, 24.0), vec3(-11.0, 6.0, 31.0)),
        ],
    }
    .build(mesh);
    props::arch(mesh, s.trim, vec3(-15.0, 4.0, 18.0), Vec3::X, 4.0, 0.6);
    props::arch(mesh, s.trim, vec3(-8.0, 4.0, 27.0), Vec3::Z, 4.0, 0.6);
    // A pane in a frame across a part of the room.
    let pane = vec3(-18.5, 0.3, 21.5);
    mesh.cuboid(s.pane, pane, pane + vec3(0.06, 2.6, 5.0), CELL);
    mesh.cuboid(s.trim, pane.with_y(0.0) - vec3(0.1, 0.0, 0.1), pane + vec3(0.16, 0.0, 5.1), CELL);
    mesh.cuboid(s.trim, pane + vec3(-0.1, 2.6, -0.1), pane + vec3(0.16, 2.8, 5.1), CELL);
    for z in [-0.1, 5.0] {
        mesh.cuboid(s.trim, pane + vec3(-0.1, 0.0, z), pane + vec3(0.16, 2.6, z + 0.1), CELL);
    }
    // A mirror on the south wall.
    mesh.quad(s.looking_glass, vec3(-11.0, 0.8, 33.9), Vec3::NEG_X * 6.0, Vec3::Y * 3.2, CELL);
    for y in [0.6, 4.0] {
        mesh.cuboid(s.gold, vec3(-17.2, y, 33.8), vec3(-10.8, y + 0.2, 34.0), CELL);
    }
    // The gate.
    let gate = vec3(-12.0, 2.0, 21.0);
    let turn = Quat::from_rotation_y(-0.6);
    mesh.torus(s.steel, gate, turn, [1.6, 0.25], [40, 12]);
    for i in 0..12 {
        let p = circle(i as f32 / 12.0) * 1.6;
        mesh.sphere(s.yellow_item, gate + turn * p.extend(0.25), 0.12, 10, 6);
    }
    mesh.closed_cylinder(s.trim, [(gate.with_y(0.0), 1.8), (gate.with_y(0.25), 1.6)], 28, 1);
    for (x, z) in [(-20.5, 31.0), (-20.5, 28.5)] {
        props::tank(mesh, s, vec3(x, 0.0, z), 0.8, 3.4);
        let line = [vec3(x, 3.3, z), vec3(x, 5.4, z), vec3(-8.5, 5.4, z)];
        props::pipe(mesh, s, s.copper, &line, 0.14);
    }
    for (x, z, size, angle) in [(-20.8, 20.0, 1.4, 0.2), (-20.4, 22.2, 1.0, 0.9), (-9.2, 32.6, 1.3, 0.4)] {
        props::container(mesh, s.crate_metal, s.steel, vec3(x, 0.0, z), size, angle);
    }
    props::item(mesh, s, Item::Health, vec3(-20.3, 0.0, 25.3), 0.2);
    props::item(mesh, s, Item::Armour, vec3(-10.0, 0.0, 30.5), 0.6);
    props::item(mesh, s, Item::Weapon, vec3(-17.0, 0.0, 31.0), 0.6);
    props::item(mesh, s, Item::Ammunition, vec3(-9.0, 0.0, 19.2), 0.6);
}

/// Stones along the foot of the walls: as many triangles as the level still lacks.
fn rubble(mesh: &mut Mesh, s: &Surfaces) {
    // Strips along walls that the walk does not touch: opposite corners on the floor.
    const STRIPS: [(Vec3, Vec3); 6] = [
        (Vec3::new(-11.5, 0.0, -8.6), Vec3::new(11.5, 0.0, -7.0)),
        (Vec3::new(-11.7, 0.0, 8.2), Vec3::new(11.7, 0.0, 8.8)),
        (Vec3::new(24.3, 0.0, -7.7), Vec3::new(39.7, 0.0, -6.9)),
        (Vec3::new(39.2, 0.0, -7.7), Vec3::new(39.8, 0.0, 0.3)),
        (Vec3::new(9.0, 4.0, 32.6), Vec3::new(35.0, 4.0, 33.7)),
        (Vec3::new(-21.8, 0.0, 23.0), Vec3::new(-21.2, 0.0, 33.0)),
    ];
    let left = TRIANGLES - mesh.len();
    mesh.rubble(s.rubble, left, &mut Random::new(3), |random| {
        let (from, to) = STRIPS[random.range(0, STRIPS.len() as u32) as usize];
        let at = from + (to - from) * vec3(random.unit(), 0.0, random.unit());
        let size = random.between(0.05, 0.3);
        Affine3A::from_scale_rotation_translation(
            vec3(size, size * random.between(0.6, 1.2), size),
            Quat::from_rotation_y(random.between(0.0, 2.0 * PI)),
            at,
        )
    });
}

/// Eyes and targets around the loop.
fn walk() -> Vec<(Vec3, Vec3)> {
    let low = |x: f32, z: f32| vec3(x, EYE, z);
    let high = |x: f32, z: f32| vec3(x, 4.0 + EYE, z);
    vec![
        // The hall, behind the pillars, with a look at the gallery.
        (low(-10.0, 7.2), vec3(0.0, 1.5, -1.0)),
        (low(-5.5, 7.0), vec3(2.0, 2.5, -5.0)),
        (low(0.0, 7.0), vec3(4.5, 1.1, 2.0)),
        (low(5.4, 7.3), vec3(6.0, 1.2, 0.0)),
        (low(10.0, 5.5), vec3(9.0, 2.5, -2.0)),
        (low(10.3, 1.5), vec3(13.5, 1.8, -0.3)),
        // East corridor.
        (low(13.5, 0.0), vec3(18.0, 1.9, 0.0)),
        (low(18.0, -0.2), vec3(24.0, 1.8, -0.5)),
        (low(23.0, 0.0), vec3(29.0, 2.2, -3.0)),
        // The works.
        (low(27.0, -0.6), vec3(31.0, 2.0, -5.0)),
        (low(31.0, -1.4), vec3(37.0, 2.0, -1.0)),
        (low(34.0, -0.4), vec3(38.0, 2.2, 3.0)),
        (low(34.3, 3.0), vec3(31.0, 1.6, 6.0)),
        (low(32.0, 6.0), vec3(32.0, 2.2, 11.0)),
        // Up the stairs: the flight rises 4 m on 12 m.
        (low(32.0, 8.2), vec3(32.0, 3.5, 15.0)),
        (vec3(32.0, 2.2 + EYE, 14.0), vec3(32.0, 5.4, 19.0)),
        (vec3(32.0, 4.1 + EYE, 20.0), vec3(30.0, 6.2, 25.0)),
        // The chapel.
        (high(31.5, 23.5), vec3(36.0, 6.5, 27.5)),
        (high(29.0, 26.0), vec3(34.0, 6.6, 28.0)),
        (high(25.5, 28.0), vec3(22.0, 7.5, 30.0)),
        (high(20.5, 28.0), vec3(14.0, 7.5, 26.5)),
        (high(14.0, 27.0), vec3(8.0, 6.0, 27.0)),
        (high(8.0, 27.0), vec3(2.0, 4.8, 27.0)),
        // Down the stairs.
        (vec3(5.2, 4.0 + EYE, 27.0), vec3(-1.0, 3.6, 27.0)),
        (vec3(-1.0, 2.2 + EYE, 27.0), vec3(-8.0, 2.0, 27.0)),
        (vec3(-6.8, 0.6 + EYE, 27.0), vec3(-13.0, 1.5, 26.5)),
        // The laboratory: the pane, the mirror, the gate.
        (low(-10.5, 27.2), vec3(-16.0, 1.5, 26.0)),
        (low(-13.5, 28.3), vec3(-15.5, 1.6, 33.0)),
        (low(-15.6, 28.0), vec3(-20.0, 1.6, 27.0)),
        (low(-16.2, 25.0), vec3(-19.5, 1.5, 22.5)),
        (low(-15.8, 23.0), vec3(-13.0, 1.7, 20.5)),
        (low(-15.0, 20.5), vec3(-15.0, 1.7, 15.0)),
        // West corridor.
        (low(-15.0, 15.0), vec3(-15.0, 1.7, 8.0)),
        (low(-14.7, 7.0), vec3(-15.0, 1.6, 1.0)),
        (low(-15.0, 2.0), vec3(-12.5, 1.7, -0.5)),
        (low(-13.6, 0.1), vec3(-8.0, 1.7, 0.0)),
        // Back in the hall, along the pool's north side under the gallery.
        (low(-10.0, -0.3), vec3(-4.0, 1.2, -2.0)),
        (low(-7.5, -4.0), vec3(-1.0, 2.0, -1.0)),
        (low(-2.0, -4.4), vec3(2.0, 1.6, 0.5)),
        (low(2.0, -4.4), vec3(-3.0, 1.5, 3.0)),
    ]
}
