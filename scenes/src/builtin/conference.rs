//! The conference room of Table 1, after Greg Ward's: a long table with upholstered chairs, rows of
//! light chairs along the walls, windows behind blinds, panelled walls and a suspended ceiling.
//!
//! Most of its triangles are small, and many are slivers: the vanes of blinds, wire, piping, tube.
//! Nothing but a mirror on the wall sends secondary rays, since Table 2's Conference takes the time
//! of one ray a pixel and one more a light.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};
use saarcor_model::host::{Camera, Light, Scene};

use super::building::{
    Opening, ceiling_grid, curtain, door_frame, door_leaf, exit_sign, hang, louvre_lamp, radiator, slab,
    switch, venetian_blind, vertical_blind, wainscot, wall, window,
};
use super::equipment::{
    bin, clock, extinguisher, jug, laptop, lying, mug, notice_board, paper_cup, pen, picture, plant, sheet,
    spiral_pad, telephone, wire_bin,
};
use super::finish::Finish;
use super::furniture::{
    WHOLE, armchair, block, book, bookcase, empty, lectern, meeting_table, placed, side_chair, whiteboard,
};
use super::mesh::{Mesh, rounded_line};
use super::path::{WayPoint, cameras, evenly};
use saarcor_random::Random;

/// Triangles (Table 1, Stated).
pub const TRIANGLES: usize = 282_000;

/// Frames of the walk around the table; the stills "a" and "b" of Table 2 follow it.
pub const WALK_FRAMES: u32 = 400;

const SEED: u64 = 0x0c0f_e2e2;

/// Half the room's extent along x and z, and its height.
const ROOM: Vec3 = vec3(6.0, 2.8, 3.75);

const TABLE_LENGTH: f32 = 7.2;
const TABLE_WIDTH: f32 = 1.6;
const TABLE_TOP: f32 = 0.74;

/// The windows in the wall at +z: where each begins, its width, its sill and its height.
const WINDOWS: [f32; 3] = [-5.2, -1.5, 2.2];
const WINDOW: Vec2 = vec2(3.0, 1.75);
const SILL: f32 = 0.95;

/// The doors in the wall at -z, where each begins.
const DOORS: [f32; 2] = [-5.4, 4.3];
const DOOR: Vec2 = vec2(0.95, 2.1);

/// The window in the wall at +x, with curtains: where it begins along z.
const GARDEN_WINDOW: f32 = -1.2;

/// Builds the room with two lights or, as `Conference-8l`, with eight, of which the first two stand
/// where the two stand.
#[must_use]
pub fn scene(eight_lights: bool) -> Scene {
    let mut random = Random::new(SEED);
    let mut room = empty();
    shell(&mut room);
    openings(&mut room);
    ceiling(&mut room);
    chairs(&mut room, &mut random);
    table(&mut room, &mut random);
    walls(&mut room, &mut random);
    floor(&mut room, &mut random);
    planter(&mut room, &mut random);
    let (mut triangles, _) = room.into_parts();
    let materials = Finish::materials(&mut triangles);
    Scene { triangles, materials, lights: lights(eight_lights), path: path(), ..Scene::default() }
}

fn lights(eight: bool) -> Vec<Light> {
    let places = [
        (-1.8, 0.9),
        (1.8, -0.9),
        (-1.8, -0.9),
        (1.8, 0.9),
        (-4.2, 0.9),
        (4.2, -0.9),
        (-4.2, -0.9),
        (4.2, 0.9),
    ];
    // Together 1: nothing saturates, however many lights a point sees.
    let count = if eight { places.len() } else { 2 };
    let intensity = 1.0 / count as f32;
    places[..count].iter().map(|&(x, z)| Light { position: vec3(x, ROOM.y - 0.18, z), intensity }).collect()
}

/// The walk and the two stills.
fn path() -> Vec<Camera> {
    const STOPS: u32 = 32;
    // Once around the table, looking across it, with the eye between 1.55 and 1.95.
    let stops: Vec<(Vec3, Vec3)> = (0..=STOPS)
        .map(|i| {
            let turn = Vec2::from_angle(TAU * (0.11 + i as f32 / STOPS as f32));
            let eye = vec3(4.9 * turn.x, 1.75 + 0.2 * (2.0 * turn.x * turn.y), 2.15 * turn.y);
            let ahead = turn.rotate(Vec2::from_angle(TAU * 0.34));
            (eye, vec3(3.4 * ahead.x, 0.75, 2.0 * ahead.y))
        })
        .collect();
    let mut path = cameras(&evenly(&stops, WALK_FRAMES), WALK_FRAMES, 60.0);
    let still = |eye, target, fov| cameras(&[WayPoint { frame: 0.0, eye, target }], 1, fov);
    path.extend(still(vec3(4.6, 1.9, 2.6), vec3(0.2, 0.5, -0.6), 50.0));
    path.extend(still(vec3(-3.3, 1.05, 2.3), vec3(-0.4, 0.55, 0.2), 45.0));
    path
}

fn shell(room: &mut Mesh) {
    let Vec3 { x, y: height, z } = ROOM;
    let corners = [vec2(-x, -z), vec2(x, -z), vec2(x, z), vec2(-x, z)];
    let heights = [0.0, height];
    let opening = |start: f32, width: f32, y: [f32; 2]| Opening { along: [start, start + width], y };
    let doors = DOORS.map(|start| opening(x + start, DOOR.x, [0.0, DOOR.y]));
    // The front wall runs from +x to -x, so its openings are counted from the far end.
    let mut windows = WINDOWS.map(|start| opening(x - start - WINDOW.x, WINDOW.x, [SILL, SILL + WINDOW.y]));
    windows.reverse();
    let garden = [opening(z + GARDEN_WINDOW, 2.4, [SILL, SILL + 1.5])];
    // Walls stand outside of the room: their centre line is half their thickness away.
    const THICK: f32 = 0.2;
    for (i, openings) in [&doors[..], &garden, &windows, &[]].into_iter().enumerate() {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        let outwards = vec2(to.y - from.y, from.x - to.x).normalize() * THICK / 2.0;
        wall(room, Finish::Plaster, [from + outwards, to + outwards], heights, THICK, openings);
    }
    slab(room, Finish::Carpet, vec2(-x, -z), vec2(x, z), 0.0, false, 1.0);
    slab(room, Finish::CeilingTile, vec2(-x, -z), vec2(x, z), height, true, 0.6);
    // Two columns between the windows.
    for start in WINDOWS[..2].iter().map(|start| start + WINDOW.x) {
        let (left, right) = (start + 0.1, start + 0.6);
        let bare = Finish::Plasterboard.surface();
        let (up, depth) = (Vec3::Y * height, 0.25);
        room.quad(bare, vec3(right, 0.0, z - depth), Vec3::NEG_X * (right - left), up, WHOLE);
        room.quad(bare, vec3(left, 0.0, z - depth), Vec3::Z * depth, up, WHOLE);
        room.quad(bare, vec3(right, 0.0, z), Vec3::NEG_Z * depth, up, WHOLE);
    }
}

/// What fills the openings: windows and their blinds and curtains, and doors.
fn openings(room: &mut Mesh) {
    let Vec3 { x, y: height, z } = ROOM;
    let (pane, blind) = (window(WINDOW, 3, true), vertical_blind(WINDOW.x + 0.08, WINDOW.y + 0.02, 0.11));
    for start in WINDOWS {
        hang(room, &pane, vec3(start + WINDOW.x, SILL, z + 0.12), Vec3::NEG_Z);
        hang(room, &blind, vec3(start + WINDOW.x + 0.04, SILL + WINDOW.y + 0.05, z - 0.08), Vec3::NEG_Z);
        let ledge = [
            vec3(start - 0.05, SILL - 0.03, z - 0.02),
            vec3(start + WINDOW.x + 0.05, SILL - 0.001, z - 0.001),
        ];
        block(room, Finish::DarkWood, ledge[0], ledge[1]);
    }
    let garden = vec2(2.4, 1.5);
    hang(room, &window(garden, 2, true), vec3(x + 0.12, SILL, GARDEN_WINDOW), Vec3::NEG_X);
    let slats = venetian_blind(garden.x - 0.02, 40, 4, 0.07);
    hang(room, &slats, vec3(x + 0.04, SILL + garden.y - 0.001, GARDEN_WINDOW + 0.01), Vec3::NEG_X);
    let drape = curtain(0.75, 2.3, 9);
    for from in [-0.8, garden.x + 0.05] {
        hang(room, &drape, vec3(x - 0.11, height - 0.25, GARDEN_WINDOW + from), Vec3::NEG_X);
    }
    let (frame, leaf) = (door_frame(DOOR.x, DOOR.y, 0.2), door_leaf(DOOR.x, DOOR.y, Finish::Wood));
    for start in DOORS {
        room.append(&frame, placed(vec3(start, 0.0, -z - 0.1), 0.0));
        room.append(&leaf, placed(vec3(start, 0.0, -z - 0.05), 0.0));
        hang(room, &exit_sign(), vec3(start + DOOR.x / 2.0, DOOR.y + 0.25, -z), Vec3::Z);
    }
}

fn ceiling(room: &mut Mesh) {
    let (half, height) = (vec2(ROOM.x, ROOM.z), ROOM.y);
    ceiling_grid(room, -half, half, height, vec2(1.2, 1.2));
    let lamp = louvre_lamp(16);
    for x in [-4.2, -1.8, 1.8, 4.2] {
        for z in [-2.55, -0.9, 0.9, 2.55] {
            room.append(&lamp, placed(vec3(x, height - 0.095, z), 0.0));
        }
    }
    // Smoke detectors and sprinklers.
    for x in [-3.0, 0.0, 3.0] {
        let at = |z: f32, y: f32| vec3(x, height - y, z);
        room.closed_cylinder(
            Finish::Porcelain.surface(),
            [(at(0.0, 0.05), 0.05), (at(0.0, 0.013), 0.06)],
            32,
            1,
        );
        room.cylinder(Finish::Steel.surface(), [(at(1.7, 0.05), 0.010), (at(1.7, 0.001), 0.015)], 16, 1);
        room.closed_cylinder(
            Finish::Steel.surface(),
            [(at(1.7, 0.056), 0.025), (at(1.7, 0.052), 0.025)],
            24,
            1,
        );
    }
}

/// Sixteen armchairs around the table, and light chairs along the walls.
fn chairs(room: &mut Mesh, random: &mut Random) {
    let jitter = |random: &mut Random| vec3(random.between(-0.05, 0.05), 0.0, random.between(-0.05, 0.05));
    let seats = [Finish::FabricBlue, Finish::FabricGrey].map(armchair);
    let mut sit = |at: Vec3, turns: f32, random: &mut Random| {
        let chair = &seats[random.range(0, 2) as usize];
        room.append(chair, placed(at + jitter(random), turns + random.between(-0.03, 0.03)));
    };
    for i in 0..7 {
        let x = -2.7 + 0.9 * i as f32;
        sit(vec3(x, 0.0, TABLE_WIDTH / 2.0 + 0.26), 0.5, random);
        sit(vec3(x, 0.0, -TABLE_WIDTH / 2.0 - 0.26), 0.0, random);
    }
    sit(vec3(TABLE_LENGTH / 2.0 + 0.25, 0.0, 0.0), -0.25, random);
    sit(vec3(-TABLE_LENGTH / 2.0 - 0.25, 0.0, 0.0), 0.25, random);
    let light = [side_chair(Finish::FabricRed, true), side_chair(Finish::FabricRed, false)];
    for i in 0..15 {
        let chair = &light[usize::from(i % 5 == 4)];
        let x = -4.85 + 0.7 * i as f32;
        room.append(chair, placed(vec3(x, 0.0, ROOM.z - 0.62), 0.5 + random.between(-0.02, 0.02)));
    }
    for i in 0..12 {
        let x = -3.63 + 0.66 * i as f32;
        room.append(&light[0], placed(vec3(x, 0.0, -ROOM.z + 0.42), random.between(-0.02, 0.02)));
    }
}

/// The table and what lies on it.
fn table(room: &mut Mesh, random: &mut Random) {
    room.append(&meeting_table(TABLE_LENGTH, TABLE_WIDTH, Finish::PolishedWood), placed(Vec3::ZERO, 0.0));
    let on_top = |x: f32, z: f32| vec3(x, TABLE_TOP + 0.0005, z);
    let (disposable, cup, paper) = (paper_cup(), mug(Finish::Porcelain, 24), sheet(0.05));
    let (pad, computer) = (spiral_pad(24), laptop());
    let pens = [Finish::BookBlue, Finish::SignalRed, Finish::PlasticBlack].map(pen);
    for i in 0..14 {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let turns = if side > 0.0 { 0.0 } else { 0.5 };
        // A place for one sitter: +z towards the chair.
        let mut place = empty();
        place.append(&disposable, placed(vec3(0.22, 0.0, -0.12), 0.0));
        if i % 3 != 0 {
            place.append(&cup, placed(vec3(0.23, 0.0, 0.03), random.unit()));
        }
        if i % 4 == 1 {
            place.append(&computer, placed(vec3(-0.05, 0.0, -0.04), random.between(-0.03, 0.03)));
        } else {
            place.append(&pad, placed(vec3(-0.04, 0.0, 0.0), random.between(-0.06, 0.06)));
            place.append(&pens[i % 3], placed(vec3(-0.03, 0.0125, 0.03), random.unit()));
            place.append(&paper, placed(vec3(-0.30, 0.0, -0.02), random.between(-0.1, 0.1)));
        }
        let x = -2.7 + 0.9 * (i / 2) as f32;
        room.append(&place, placed(on_top(x, side * (TABLE_WIDTH / 2.0 - 0.22)), turns));
    }
    for x in [-2.2, 0.7, 2.5] {
        room.append(&jug(), placed(on_top(x, 0.0), random.unit()));
    }
    room.append(&telephone(), placed(on_top(-0.4, 0.05), 0.6));
    for stack in [-1.3, 1.7] {
        let mut y = 0.0;
        for _ in 0..4 {
            let size =
                vec3(random.between(0.02, 0.04), random.between(0.22, 0.28), random.between(0.16, 0.19));
            let cover = Finish::BOOKS[random.range(0, 6) as usize];
            let flat = lying(&book(size, cover), size.x);
            room.append(&flat, placed(on_top(stack, 0.0) + Vec3::Y * y, random.between(-0.05, 0.05)));
            y += size.x + 0.001;
        }
    }
}

/// What stands against the walls and hangs on them.
fn walls(room: &mut Mesh, random: &mut Random) {
    let Vec3 { x, z, .. } = ROOM;
    // Wainscot between the doors, under the windows and at the two ends.
    let (left, right) = (DOORS[0] + DOOR.x + 0.08, DOORS[1] - 0.08);
    hang(room, &wainscot(right - left), vec3(left, 0.0, -z), Vec3::Z);
    hang(room, &wainscot(2.0 * z), vec3(-x, 0.0, z), Vec3::X);
    for (from, to) in [(-x, -2.1), (-1.6, 1.6), (2.1, x)] {
        let panels = wainscot(to - from);
        let short = panels.bent(|p| vec3(p.x, p.y * 0.95, p.z));
        hang(room, &short, vec3(to, 0.0, z), Vec3::NEG_Z);
    }
    hang(room, &whiteboard(3.2, 1.3), vec3(-x, 0.12, -0.6), Vec3::X);
    room.append(&lectern(), placed(vec3(-x + 0.65, 0.0, 2.2), 0.25));
    hang(room, &clock(), vec3(-1.5, 2.3, -z), Vec3::Z);
    for (i, at) in [-3.4, -0.2, 1.6, 3.2].into_iter().enumerate() {
        let size = vec2(random.between(0.5, 0.9), random.between(0.5, 0.8));
        let finish = [Finish::BookGreen, Finish::BookOchre, Finish::BookBlue, Finish::BookRed][i];
        hang(room, &picture(size, finish), vec3(at, 1.65, -z), Vec3::Z);
    }
    hang(room, &notice_board(vec2(1.2, 0.8), 5, random), vec3(x, 1.6, -z + 0.95), Vec3::NEG_X);
    hang(room, &extinguisher(), vec3(DOORS[1] - 0.35, 0.6, -z + 0.04), Vec3::Z);
    for start in DOORS {
        hang(room, &switch(false), vec3(start - 0.2, 1.15, -z), Vec3::Z);
    }
    for along in [-3.0, -1.0, 1.0, 3.0] {
        hang(room, &switch(true), vec3(along, 0.16, -z + 0.02), Vec3::Z);
    }
    // A mirror in a frame.
    let (low, high) = (vec3(x - 0.012, 1.2, 2.05), vec3(x - 0.002, 2.1, 2.75));
    block(room, Finish::Mirror, low, high);
    hang(room, &radiator(30), vec3(x, 0.0, 0.0), Vec3::NEG_X);
    let case = bookcase(1.4, 5, random);
    hang(room, &case, vec3(x - 0.01, 0.0, 2.4 - 5.6), Vec3::NEG_X);
}

/// What lies and stands on the floor.
fn floor(room: &mut Mesh, random: &mut Random) {
    let Vec3 { x, z, .. } = ROOM;
    // A border woven into the carpet.
    for (min, max) in [
        (vec2(-5.4, -3.0), vec2(5.4, -2.85)),
        (vec2(-5.4, 2.35), vec2(5.4, 2.5)),
        (vec2(-5.4, -2.85), vec2(-5.25, 2.35)),
        (vec2(5.25, -2.85), vec2(5.4, 2.35)),
    ] {
        slab(room, Finish::CarpetBorder, min, max, 0.003, false, 1.0);
    }
    for (z, side) in [(0.6, 1.0), (-2.6, -1.0)] {
        // Past the table's first foot to its middle.
        let y = 0.008;
        let cable = [
            vec3(-4.4, y, z),
            vec3(-3.7, y, 0.55 * side),
            vec3(-2.4, y, 0.45 * side),
            vec3(-1.0, y, 0.2 * side),
            vec3(-0.5, y, 0.12 * side),
        ];
        room.tube(Finish::PlasticBlack.surface(), &rounded_line(&cable, 0.6, 24), 0.005, 8);
    }
    room.append(&bin(random), placed(vec3(-5.6, 0.0, -2.6), 0.0));
    room.append(&wire_bin(), placed(vec3(5.6, 0.0, -1.55), 0.0));
    for (at, height) in
        [(vec3(-5.35, 0.0, 3.1), 1.5), (vec3(5.4, 0.0, 3.15), 1.2), (vec3(x - 0.55, 0.0, -z + 0.5), 0.9)]
    {
        room.append(&plant(height, 26, random), placed(at, random.unit()));
    }
}

/// A trough of pebbles under the clock, which brings the room to its exact size.
fn planter(room: &mut Mesh, random: &mut Random) {
    let mut trough = empty();
    trough.rounded_cuboid(
        Finish::Terracotta.surface(),
        [vec3(-0.5, 0.0, -0.12), vec3(0.5, 0.12, 0.12)],
        0.02,
        3,
        [2, 1, 2],
    );
    room.append(&trough, placed(vec3(0.0, 0.96, -ROOM.z + 0.15), 0.0));
    let left = TRIANGLES.saturating_sub(room.len());
    room.rubble(Finish::Concrete.surface(), left, random, |random| {
        let at = vec3(random.between(-0.46, 0.46), 1.08, random.between(-0.09, 0.09) - ROOM.z + 0.15);
        placed(at, random.unit()) * glam::Affine3A::from_scale(Vec3::splat(random.between(0.015, 0.03)))
    });
}
