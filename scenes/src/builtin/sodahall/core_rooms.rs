//! The rooms between the corridors: lecture rooms, laboratories, libraries, seminar rooms and copy rooms.

use glam::{Vec3, vec2, vec3};

use super::kit::{Kit, chance, pick};
use super::office::workplace;
use super::{ATRIUM, CEILING, CORE, DOOR, LECTURE, LECTURE_DOOR, WALL};
use crate::builtin::building::hang;
use crate::builtin::equipment::copier;
use crate::builtin::finish::Finish;
use crate::builtin::furniture::{empty, lectern, meeting_table, placed};
use crate::builtin::mesh::Mesh;
use saarcor_random::Random;

/// The rooms of the core of a storey: four large ones in turn, and two for copiers.
pub fn core_rooms(part: &mut Mesh, kit: &Kit, floor: u32, random: &mut Random) {
    let half = vec2((CORE.x - LECTURE) / 2.0, CORE.y / 2.0);
    for (i, (x, z)) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].into_iter().enumerate() {
        // In its own space, a room's corridor lies at +z.
        let at = placed(vec3(x * (LECTURE + half.x), 0.0, z * half.y), if z > 0.0 { 0.0 } else { 0.5 });
        let mut room = match (floor as usize + i) % 4 {
            0 => lecture_room(kit, random),
            1 => laboratory(kit, random),
            2 => library(kit, random),
            _ => seminar_room(kit, random),
        };
        for (x, z) in [(-1.6, -2.6), (1.6, -2.6), (-1.6, 0.0), (1.6, 0.0), (-1.6, 2.6), (1.6, 2.6)] {
            room.append(&kit.lamp, placed(vec3(x, CEILING - 0.085, z), 0.0));
        }
        part.append(&room, at);
        let door = x * (LECTURE + LECTURE_DOOR) - if x > 0.0 { 0.0 } else { DOOR.x };
        part.append(&kit.door_frame, placed(vec3(door, 0.0, z * CORE.y), 0.0));
        // The leaf opens into the room.
        let angle = if chance(random, 50) { 0.0 } else { random.between(0.15, 0.24) };
        part.append(&kit.door_leaf, placed(vec3(door, 0.0, z * (CORE.y - 0.03)), z * angle));
    }
    for side in [-1.0, 1.0] {
        let at = |x: f32, z: f32| vec3(side * (ATRIUM + x), 0.0, z);
        part.append(&copier(), placed(at(1.2, -1.0), random.between(-0.01, 0.01)));
        for i in 0..2 {
            let to_side = if side > 0.0 { 0.25 } else { -0.25 };
            let place = placed(at(0.08, -8.0 + 1.2 * i as f32), to_side);
            part.append(pick(&kit.bookcases, random), place);
        }
        part.append(&kit.door_frame, placed(at(2.5, -CORE.y) - Vec3::X * DOOR.x / 2.0, 0.0));
        part.append(&kit.bin, placed(at(2.2, -1.0), random.unit()));
    }
}

/// Rows of chairs before a lectern and a board.
fn lecture_room(kit: &Kit, random: &mut Random) -> Mesh {
    let mut room = empty();
    hang(&mut room, &kit.whiteboard, BOARD, Vec3::Z);
    room.append(&lectern(), placed(vec3(-1.6, 0.0, BOARD.z + 1.3), 0.0));
    for row in 0..5 {
        for seat in 0..7 {
            let at = vec3(-2.1 + 0.7 * seat as f32, 0.0, -1.8 + 0.95 * row as f32);
            room.append(&kit.wooden_chair, placed(at, 0.5 + random.between(-0.01, 0.01)));
        }
    }
    room
}

/// Where a board hangs in a large room's own space: on the wall opposite the door.
const BOARD: Vec3 = vec3(0.0, 0.1, WALL / 2.0 - CORE.y / 2.0);

/// Workplaces back to back.
fn laboratory(kit: &Kit, random: &mut Random) -> Mesh {
    let mut room = empty();
    for (x, z) in [(0.0, -1.8), (0.0, 1.8)] {
        room.append(&workplace(kit, random), placed(vec3(x, 0.0, z + 0.41), 0.0));
        room.append(&workplace(kit, random), placed(vec3(x, 0.0, z - 0.41), 0.5));
    }
    hang(&mut room, &kit.whiteboard, BOARD, Vec3::Z);
    room
}

/// Rows of bookcases back to back, and a reading table.
fn library(kit: &Kit, random: &mut Random) -> Mesh {
    let mut room = empty();
    for z in [-2.6, -0.4] {
        for x in [-2.4, -1.48, -0.56] {
            for (side, turns) in [(0.005, 0.0), (-0.005, 0.5)] {
                room.append(pick(&kit.bookcases, random), placed(vec3(x, 0.0, z + side), turns));
            }
        }
    }
    room.append(&meeting_table(2.4, 1.0, Finish::Wood), placed(vec3(-0.8, 0.0, 2.5), 0.0));
    for x in [-1.4, -0.2] {
        room.append(&kit.wooden_chair, placed(vec3(x, 0.0, 3.3), 0.5));
        room.append(&kit.wooden_chair, placed(vec3(x, 0.0, 1.7), 0.0));
    }
    room
}

/// A long table and its chairs.
fn seminar_room(kit: &Kit, random: &mut Random) -> Mesh {
    let mut room = empty();
    room.append(&meeting_table(5.0, 1.4, Finish::DarkWood), placed(vec3(0.0, 0.0, -0.4), 0.25));
    for i in 0..4 {
        let z = -1.75 + 0.9 * i as f32;
        for (x, turns) in [(1.1, -0.25), (-1.1, 0.25)] {
            let chair = pick(&kit.swivel_chairs, random);
            room.append(chair, placed(vec3(x, 0.0, z), turns + random.between(-0.05, 0.05)));
        }
        room.append(&kit.sheet, placed(vec3(0.4, 0.7405, z), 0.25 + random.between(-0.1, 0.1)));
    }
    hang(&mut room, &kit.whiteboard, BOARD, Vec3::Z);
    room
}
