//! The shell of a storey: floor and ceiling, walls, stairs, and what hangs in its corridors.

use glam::{Vec2, Vec3, vec2, vec3};

use super::kit::{Kit, pick};
use super::{
    ATRIUM, CEILING, CORE, DOOR, DOOR_START, FLOORS, LECTURE, LECTURE_DOOR, LONG_ROW, NORTH, OFFICES, OUTER,
    SHORT_ROW, STAIR_BACK, STAIR_LANDING, STOREY, WALL, WEST,
};
use crate::builtin::building::{Opening, exit_sign, hang, railing, stair_flight, wall};
use crate::builtin::finish::Finish;
use crate::builtin::furniture::{WHOLE, block, placed};
use crate::builtin::mesh::Mesh;
use saarcor_random::Random;

/// The floor and the suspended ceiling of a storey, with holes where atrium and stairs pass.
pub fn slabs(part: &mut Mesh, floor: u32) {
    let hole = |min: Vec2, max: Vec2| (min + OUTER, max + OUTER);
    let (west, east) = (vec2(-LECTURE, STAIR_BACK), vec2(ATRIUM, STAIR_BACK));
    let stair = vec2(LECTURE - ATRIUM, STAIR_LANDING - STAIR_BACK);
    let wells = [hole(west, west + stair), hole(east, east + stair)];
    let atrium = hole(vec2(-ATRIUM, -CORE.y), vec2(ATRIUM, CORE.y));
    let (x, z) = (Vec3::X * 2.0 * OUTER.x, Vec3::Z * 2.0 * OUTER.y);
    let corner = |y: f32| vec3(-OUTER.x, y, -OUTER.y);
    let mirrored =
        |(min, max): (Vec2, Vec2)| (vec2(min.x, 2.0 * OUTER.y - min.y), vec2(max.x, 2.0 * OUTER.y - max.y));
    let floor_holes: Vec<_> = if floor == 0 {
        Vec::new()
    } else {
        [wells[0], wells[1], atrium].into_iter().map(mirrored).collect()
    };
    part.pierced_quad(Finish::Linoleum.surface(), [corner(0.0) + z, x, -z], &floor_holes, 6.0);
    let mut ceiling_holes = vec![atrium];
    if floor + 1 < FLOORS {
        ceiling_holes.extend(wells);
    }
    part.pierced_quad(Finish::CeilingTile.surface(), [corner(CEILING), x, z], &ceiling_holes, 3.0);
    // The slab's edges towards the atrium, from the ceiling to the floor above.
    let up = Vec3::Y * (STOREY - CEILING);
    let along = Vec3::X * 2.0 * ATRIUM;
    let edge = Finish::Concrete.surface();
    part.quad(edge, vec3(-ATRIUM, CEILING, -CORE.y), along, up, WHOLE);
    part.quad(edge, vec3(ATRIUM, CEILING, CORE.y), -along, up, WHOLE);
}

fn opening(start: f32, width: f32, y: [f32; 2]) -> Opening {
    Opening { along: [start, start + width], y }
}

/// The walls of a storey.
pub fn walls(part: &mut Mesh, floor: u32) {
    let y = [0.0, STOREY];
    let door = |start: f32| opening(start, DOOR.x, [0.0, DOOR.y]);
    let sill = [0.95, 2.45];
    let mut add = |finish: Finish, from: Vec2, to: Vec2, openings: &[Opening]| {
        wall(part, finish, [from, to], y, WALL, openings);
    };
    let middles = |count: u32, half: f32| -> Vec<f32> {
        (0..count).map(|i| half * (2 * i + 1) as f32 / count as f32).collect()
    };
    let (long, short) = (middles(LONG_ROW, OUTER.x), middles(SHORT_ROW, CORE.y));
    for side in [-1.0, 1.0] {
        // Outer walls: a window an office, and one at each corridor's end.
        let lid = Vec2::X * WALL / 2.0;
        let windows: Vec<_> = long.iter().map(|x| opening(x - 1.2, 2.4, sill)).collect();
        let z = side * OUTER.y;
        add(Finish::Concrete, vec2(-OUTER.x, z) - lid, vec2(OUTER.x, z) + lid, &windows);
        let x = side * OUTER.x;
        let mut windows: Vec<_> =
            short.iter().map(|z| opening(OUTER.y - CORE.y + z - 1.2, 2.4, sill)).collect();
        windows.extend([-NORTH, NORTH].map(|z| opening(OUTER.y + z - 0.6, 1.2, sill)));
        add(Finish::Concrete, vec2(x, -OUTER.y), vec2(x, OUTER.y), &windows);

        // Between corridors and offices: doors, which lie to the right as seen from the window.
        let z = side * OFFICES.y;
        let from = if side > 0.0 { -DOOR_START - DOOR.x } else { DOOR_START };
        let doors: Vec<_> = long.iter().map(|x| door(x + from)).collect();
        add(Finish::Plaster, vec2(-OUTER.x, z), vec2(OUTER.x, z), &doors);
        let x = side * OFFICES.x;
        let from = if side < 0.0 { -DOOR_START - DOOR.x } else { DOOR_START };
        let doors: Vec<_> = short.iter().map(|z| door(z + from)).collect();
        add(Finish::Plaster, vec2(x, -CORE.y), vec2(x, CORE.y), &doors);

        // Between offices.
        for i in 1..LONG_ROW {
            let x = -OUTER.x + 2.0 * OUTER.x * i as f32 / LONG_ROW as f32;
            add(Finish::Plasterboard, vec2(x, side * OFFICES.y), vec2(x, side * OUTER.y), &[]);
        }
        for i in 0..=SHORT_ROW {
            let z = -CORE.y + 2.0 * CORE.y * i as f32 / SHORT_ROW as f32;
            add(Finish::Plasterboard, vec2(side * OFFICES.x, z), vec2(side * OUTER.x, z), &[]);
        }

        // The core: lecture rooms, stairwells and copy rooms.
        let x = side * CORE.x;
        add(Finish::Plaster, vec2(x, -CORE.y), vec2(x, CORE.y), &[]);
        let x = side * LECTURE;
        add(Finish::Plaster, vec2(x, -CORE.y), vec2(x, CORE.y), &[]);
        add(Finish::Plasterboard, vec2(side * LECTURE, 0.0), vec2(side * CORE.x, 0.0), &[]);
        let x = side * ATRIUM;
        let inner = [opening(1.5, 2.0, sill), opening(5.0, 2.0, sill)];
        add(Finish::Concrete, vec2(x, -CORE.y), vec2(x, CORE.y), if floor > 0 { &inner } else { &[] });
        add(Finish::Plaster, vec2(side * LECTURE, STAIR_BACK), vec2(side * ATRIUM, STAIR_BACK), &[]);
        for front in [-1.0, 1.0] {
            let width = if front > 0.0 { 1.6 } else { DOOR.x };
            let middle = LECTURE - ATRIUM;
            let doors = [opening((middle - width) / 2.0, width, [0.0, DOOR.y]), door(middle + LECTURE_DOOR)];
            let z = front * CORE.y;
            add(Finish::Plaster, vec2(side * ATRIUM, z), vec2(side * CORE.x, z), &doors);
        }
    }
}

/// The stairs from a storey to the next, twice; on the last one a railing instead.
pub fn stairs(part: &mut Mesh, floor: u32) {
    const WIDTH: f32 = 2.3;
    const HALFWAY: f32 = 4.5;
    const STEPS: u32 = 10;
    for west in [-LECTURE, ATRIUM] {
        let (left, right) = (west + WALL / 2.0 + 0.02, west + LECTURE - ATRIUM - WALL / 2.0 - 0.02);
        if floor + 1 == FLOORS {
            part.append(&railing(WIDTH), placed(vec3(left, 0.0, STAIR_LANDING), 0.0));
            continue;
        }
        let half = STOREY / 2.0;
        let flight = stair_flight(WIDTH, STAIR_LANDING - HALFWAY, half, STEPS);
        part.append(&flight, placed(vec3(left + WIDTH, 0.0, STAIR_LANDING), 0.5));
        part.append(&flight, placed(vec3(right - WIDTH, half, HALFWAY), 0.0));
        block(
            part,
            Finish::Concrete,
            vec3(left, half - 0.2, STAIR_BACK + WALL / 2.0 + 0.001),
            vec3(right, half - 0.001, HALFWAY - 0.001),
        );
    }
}

/// Lamps, notice boards and extinguishers in the corridors of a storey, and the galleries' railings.
pub fn corridors(part: &mut Mesh, kit: &Kit, random: &mut Random) {
    let lamp_y = CEILING - 0.085;
    let face = WALL / 2.0;
    for side in [-1.0, 1.0] {
        for i in 0..13 {
            let x = -21.9 + 3.65 * i as f32;
            part.append(&kit.lamp, placed(vec3(x, lamp_y, side * NORTH), 0.0));
        }
        for i in 0..5 {
            let z = -7.4 + 3.7 * i as f32;
            part.append(&kit.lamp, placed(vec3(side * -WEST, lamp_y, z), 0.25));
        }
        let towards_core = Vec3::NEG_Z * side;
        for i in 0..LONG_ROW {
            let x = -OUTER.x + 6.0 * i as f32 + 4.8 - 3.6 * f32::from(side < 0.0);
            let at = vec3(x, 1.5, side * (OFFICES.y - face));
            match i % 3 {
                0 => hang(part, pick(&kit.notice_boards, random), at, towards_core),
                1 => hang(part, pick(&kit.pictures, random), at, towards_core),
                _ => hang(part, &kit.extinguisher, at - Vec3::Y * 1.1, towards_core),
            }
        }
        for z in [-6.0, 0.5, 5.5] {
            let at = vec3(side * (CORE.x + face), 1.5, z);
            hang(part, pick(&kit.notice_boards, random), at, Vec3::X * side);
        }
        let stair_door = vec3(side * (LECTURE + ATRIUM) / 2.0, 2.35, CORE.y + face);
        hang(part, &exit_sign(), stair_door, Vec3::Z);
        for x in [-ATRIUM - 0.9, ATRIUM + 0.9] {
            let at = vec3(x, 0.0, side * (CORE.y + face + 0.48));
            part.append(&kit.plants[2], placed(at, random.unit()));
        }
    }
}
