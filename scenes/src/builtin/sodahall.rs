//! The building of Table 1, after Berkeley's Soda Hall: seven floors of furnished offices, lecture
//! rooms and corridors around an atrium, with two stairwells. Walls hide nearly all of it from any
//! one place.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use saarcor_model::host::{Camera, Scene};

use super::building::{
    Opening, door_frame, door_leaf, exit_sign, hang, louvre_lamp, radiator, railing, slab, stair_flight,
    switch, venetian_blind, wall, window,
};
use super::equipment::{
    bin, computer, copier, desk_lamp, extinguisher, lying, mug, notice_board, picture, plant, sheet,
    telephone,
};
use super::finish::Finish;
use super::furniture::{
    WHOLE, block, book, bookcase, desk, drawers, empty, lectern, meeting_table, placed, swivel_chair,
    whiteboard, wooden_chair,
};
use super::mesh::Mesh;
use super::path::{cameras, evenly};
use saarcor_random::Random;

/// Triangles (Table 1, Stated).
pub const TRIANGLES: usize = 1_510_322;

/// Frames of the walk.
pub const WALK_FRAMES: u32 = 600;

const SEED: u64 = 0x50da_4a11;

const FLOORS: u32 = 7;
/// From floor to floor, and from a floor to its suspended ceiling.
const STOREY: f32 = 3.6;
const CEILING: f32 = 2.9;
const WALL: f32 = 0.12;

// The plan is symmetric about both axes; these are distances from the middle.
/// The outer walls.
const OUTER: Vec2 = vec2(24.0, 16.0);
/// The corridors' outer sides: behind them lie the offices.
const OFFICES: Vec2 = vec2(20.25, 11.5);
/// The corridors' inner sides: behind them lies the core.
const CORE: Vec2 = vec2(18.05, 9.3);
/// The lecture rooms reach from the core's ends to here, the stairwells and copy rooms further to
/// [`ATRIUM`].
const LECTURE: f32 = 12.0;
/// The atrium's walls.
const ATRIUM: f32 = 7.0;
/// A stairwell's far wall, and the edge of its landing on each floor.
const STAIR_BACK: f32 = 3.3;
const STAIR_LANDING: f32 = 7.3;
/// The middle of a corridor along x, and of one along z.
const NORTH: f32 = 10.4;
const WEST: f32 = -19.15;

/// Offices along x and along z, a side and floor.
const LONG_ROW: u32 = 8;
const SHORT_ROW: u32 = 3;
const DOOR: Vec2 = vec2(0.9, 2.1);
/// Where an office's door begins, from the office's middle to the right as seen from the window.
const DOOR_START: f32 = 0.5;
/// Where a lecture room's door begins, from its wall towards the atrium.
const LECTURE_DOOR: f32 = 2.5;
const EYE: f32 = 1.65;

/// Builds the building.
#[must_use]
pub fn scene() -> Scene {
    let mut random = Random::new(SEED);
    let kit = Kit::new(&mut random);
    let mut building = empty();
    let mut bookcase_places = Vec::new();
    for floor in 0..FLOORS {
        let base = floor as f32 * STOREY;
        let level = Affine3A::from_translation(Vec3::Y * base);
        let mut part = empty();
        slabs(&mut part, floor);
        walls(&mut part, floor);
        stairs(&mut part, floor);
        corridors(&mut part, &kit, &mut random);
        for office in offices() {
            part.append(&office.furnished(&kit, floor, &mut random), office.at);
            bookcase_places.extend(office.bookcase_places().map(|place| level * office.at * place));
        }
        core_rooms(&mut part, &kit, floor, &mut random);
        building.append(&part, level);
    }
    atrium(&mut building, &kit, &mut random);
    fill(&mut building, &kit, &bookcase_places, &mut random);
    let (mut triangles, _) = building.into_parts();
    let materials = Finish::materials(&mut triangles);
    Scene { triangles, materials, path: path(), ..Scene::default() }
}

/// The parts that stand in many rooms, in a few variants.
struct Kit {
    desks: [Mesh; 3],
    swivel_chairs: [Mesh; 3],
    wooden_chair: Mesh,
    bookcases: Vec<Mesh>,
    cabinets: [Mesh; 2],
    computers: [Mesh; 3],
    telephone: Mesh,
    desk_lamp: Mesh,
    mugs: [Mesh; 3],
    sheet: Mesh,
    bin: Mesh,
    plants: Vec<Mesh>,
    whiteboard: Mesh,
    pictures: Vec<Mesh>,
    notice_boards: Vec<Mesh>,
    blinds: Vec<Mesh>,
    radiator: Mesh,
    lamp: Mesh,
    door_frame: Mesh,
    door_leaf: Mesh,
    switch: Mesh,
    extinguisher: Mesh,
}

impl Kit {
    fn new(random: &mut Random) -> Self {
        Self {
            desks: [(1.5, Finish::Wood), (1.6, Finish::DarkWood), (1.4, Finish::PlasticBeige)]
                .map(|(width, top)| desk(width, 0.8, top)),
            swivel_chairs: [Finish::FabricBlue, Finish::FabricRed, Finish::FabricGrey].map(swivel_chair),
            wooden_chair: wooden_chair(),
            bookcases: (0..8).map(|i| bookcase(0.9, 3 + i % 3, random)).collect(),
            cabinets: [Finish::Steel, Finish::PlasticBeige].map(|front| drawers(0.45, 1.3, 4, front)),
            computers: [false, false, true].map(computer),
            telephone: telephone(),
            desk_lamp: desk_lamp(),
            mugs: [Finish::Porcelain, Finish::BookRed, Finish::BookBlue].map(|finish| mug(finish, 12)),
            sheet: sheet(0.05),
            bin: bin(random),
            plants: [1.1, 1.5, 0.8].into_iter().map(|height| plant(height, 9, random)).collect(),
            whiteboard: whiteboard(1.5, 1.0),
            pictures: [Finish::BookGreen, Finish::BookBlue, Finish::BookOchre]
                .map(|finish| picture(vec2(0.7, 0.5), finish))
                .to_vec(),
            notice_boards: (0..4).map(|_| notice_board(vec2(1.6, 0.9), 6, random)).collect(),
            blinds: [(20, 0.02), (40, 0.06), (56, 0.12)]
                .map(|(slats, tilt)| venetian_blind(2.36, slats, 2, tilt))
                .to_vec(),
            radiator: radiator(6),
            lamp: louvre_lamp(6),
            door_frame: door_frame(DOOR.x, DOOR.y, WALL),
            door_leaf: door_leaf(DOOR.x, DOOR.y, Finish::Wood),
            switch: switch(false),
            extinguisher: extinguisher(),
        }
    }
}

fn pick<'a>(variants: &'a [Mesh], random: &mut Random) -> &'a Mesh {
    &variants[random.range(0, variants.len() as u32) as usize]
}

fn chance(random: &mut Random, percent: u32) -> bool {
    random.range(0, 100) < percent
}

/// An office. In its own space the corridor lies at +z and the window at -z.
struct Office {
    /// From the office's space to its floor's.
    at: Affine3A,
    /// Half its width and half its depth.
    half: Vec2,
    /// Which office of its floor.
    index: u32,
}

/// The offices of a floor: the row at +z from -x to +x, then those at -z, -x and +x.
fn offices() -> Vec<Office> {
    let long = vec2(OUTER.x / LONG_ROW as f32, (OUTER.y - OFFICES.y) / 2.0);
    let short = vec2(CORE.y / SHORT_ROW as f32, (OUTER.x - OFFICES.x) / 2.0);
    let mut places = Vec::new();
    for (side, turns) in [(1.0, 0.5), (-1.0, 0.0)] {
        for i in 0..LONG_ROW {
            let at = vec3(-OUTER.x + long.x * (2 * i + 1) as f32, 0.0, side * (OUTER.y - long.y));
            places.push((placed(at, turns), long));
        }
    }
    for (side, turns) in [(-1.0, 0.25), (1.0, -0.25)] {
        for i in 0..SHORT_ROW {
            let at = vec3(side * (OUTER.x - short.y), 0.0, -CORE.y + short.x * (2 * i + 1) as f32);
            places.push((placed(at, turns), short));
        }
    }
    (0..).zip(places).map(|(index, (at, half))| Office { at, half, index }).collect()
}

impl Office {
    /// The office that the walk enters, by floor and index.
    const VISITED: (u32, u32) = (1, 1);

    /// Where the inner faces of the walls are.
    fn inner(&self) -> Vec2 {
        self.half - WALL / 2.0
    }

    /// Where bookcases can stand besides the first: on the right and further along the left wall.
    fn bookcase_places(&self) -> impl Iterator<Item = Affine3A> {
        let w = self.inner().x - 0.01;
        [(vec3(w, 0.0, 0.15), -0.25), (vec3(-w, 0.0, 1.45), 0.25)]
            .map(|(at, turns)| placed(at, turns))
            .into_iter()
            // The shorter offices have their end of the left wall nearer.
            .take(if self.half.y > 2.0 { 2 } else { 1 })
    }

    fn furnished(&self, kit: &Kit, floor: u32, random: &mut Random) -> Mesh {
        let mut room = empty();
        let Vec2 { x: w, y: d } = self.inner();
        let visited = Self::VISITED == (floor, self.index);

        // Window wall.
        let sash = window(vec2(2.4, 1.5), 2, false);
        room.append(&sash, placed(vec3(-1.2, 0.95, -self.half.y), 0.0));
        room.append(pick(&kit.blinds, random), placed(vec3(-1.18, 2.44, -d + 0.04), 0.0));
        hang(&mut room, &kit.radiator, vec3(0.0, 0.0, -d), Vec3::Z);

        // Corridor wall. The hinge is on the right; open, the leaf stands along -z.
        room.append(&kit.door_frame, placed(vec3(DOOR_START, 0.0, self.half.y), 0.0));
        let angle = if visited || chance(random, 15) {
            0.25
        } else if chance(random, 30) {
            random.between(0.26, 0.45)
        } else {
            0.5
        };
        let hinge = vec3(DOOR_START + DOOR.x, 0.0, self.half.y - 0.03);
        room.append(&kit.door_leaf, placed(hinge, angle));
        hang(&mut room, &kit.switch, vec3(DOOR_START - 0.25, 1.15, d), Vec3::NEG_Z);
        let plate = vec3(DOOR_START - 0.3, 1.5, self.half.y + WALL / 2.0);
        block(&mut room, Finish::Brass, plate - vec3(0.1, 0.05, 0.0), plate + vec3(0.1, 0.05, 0.006));
        for x in [-w / 2.0, w / 2.0] {
            room.append(&kit.lamp, placed(vec3(x, CEILING - 0.085, 0.0), 0.25));
        }

        // Left: a workplace and a bookcase; right: another workplace, or a cabinet and a visitor's chair.
        let work = -d + 1.15;
        room.append(&workplace(kit, random), placed(vec3(-w + 0.45, 0.0, work), 0.25));
        room.append(pick(&kit.bookcases, random), placed(vec3(-w + 0.01, 0.0, 0.45), 0.25));
        hang(&mut room, pick(&kit.pictures, random), vec3(-w, 1.75, work), Vec3::X);
        if chance(random, 6) {
            room.append(&workplace(kit, random), placed(vec3(w - 0.45, 0.0, work), -0.25));
        } else {
            let cabinet = &kit.cabinets[random.range(0, 2) as usize];
            room.append(cabinet, placed(vec3(w - 0.29, 0.0, -d + 0.5), -0.25));

            room.append(
                &kit.wooden_chair,
                placed(vec3(w - 0.5, 0.0, -d + 1.3), random.between(-0.35, -0.15)),
            );
        }
        if self.half.y > 2.0 && chance(random, 40) {
            hang(&mut room, &kit.whiteboard, vec3(w, 0.0, 1.45), Vec3::NEG_X);
        }
        if chance(random, 75) {
            room.append(&kit.bin, placed(vec3(-w + 0.3, 0.0, -d + 0.17), random.unit()));
        }
        if chance(random, 10) {
            let plant = pick(&kit.plants, random);
            room.append(plant, placed(vec3(w - 0.65, 0.0, -d + 2.3), random.unit()));
        }
        room
    }
}

/// A desk with what stands on it, and its chair. The sitter is at +z.
fn workplace(kit: &Kit, random: &mut Random) -> Mesh {
    const TOP: f32 = 0.7405;
    let mut place = empty();
    place.append(pick(&kit.desks, random), Affine3A::IDENTITY);
    let on_top = |x: f32, z: f32, turns: f32| placed(vec3(x, TOP, z), turns);
    place.append(pick(&kit.computers, random), on_top(-0.05, -0.1, random.between(-0.02, 0.02)));
    if chance(random, 45) {
        place.append(&kit.telephone, on_top(0.52, -0.05, random.between(-0.1, 0.05)));
    }
    if chance(random, 30) {
        place.append(&kit.desk_lamp, on_top(0.52, -0.29, random.between(-0.2, 0.2)));
    }
    for i in 0..random.range(0, 3) {
        let at = on_top(0.53 + 0.02 * i as f32, 0.24, random.between(-0.08, 0.08));
        place.append(&kit.sheet, Affine3A::from_translation(Vec3::Y * 0.004 * i as f32) * at);
    }
    if chance(random, 35) {
        place.append(pick(&kit.mugs, random), on_top(-0.40, 0.28, random.unit()));
    }
    let mut y = TOP;
    for _ in 0..random.range(0, 4) {
        let size = vec3(random.between(0.02, 0.05), random.between(0.22, 0.28), random.between(0.15, 0.19));
        let cover = Finish::BOOKS[random.range(0, Finish::BOOKS.len() as u32) as usize];
        let turns = 0.25 + random.between(-0.04, 0.04);
        place.append(&lying(&book(size, cover), size.x), placed(vec3(0.36, y, -0.25), turns));
        y += size.x + 0.001;
    }
    let chair = vec3(random.between(-0.2, 0.1), 0.0, random.between(0.6, 0.85));
    place.append(pick(&kit.swivel_chairs, random), placed(chair, 0.5 + random.between(-0.12, 0.12)));
    place
}

/// The floor and the suspended ceiling of a storey, with holes where atrium and stairs pass.
fn slabs(part: &mut Mesh, floor: u32) {
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
fn walls(part: &mut Mesh, floor: u32) {
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
fn stairs(part: &mut Mesh, floor: u32) {
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
fn corridors(part: &mut Mesh, kit: &Kit, random: &mut Random) {
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

/// The rooms of the core of a storey: four large ones in turn, and two for copiers.
fn core_rooms(part: &mut Mesh, kit: &Kit, floor: u32, random: &mut Random) {
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

/// The atrium over all storeys: railings along the galleries, two bridges, benches, a bed of trees
/// and the beams of the roof.
fn atrium(building: &mut Mesh, kit: &Kit, random: &mut Random) {
    let gallery = railing(2.0 * ATRIUM - WALL);
    for floor in 1..FLOORS {
        let y = floor as f32 * STOREY;
        let bridged = floor % 3 == 2;
        for z in [-CORE.y - 0.05, CORE.y + 0.05] {
            if bridged {
                let side = railing(ATRIUM - 1.0 - WALL / 2.0);
                building.append(&side, placed(vec3(-ATRIUM + WALL / 2.0, y, z), 0.0));
                building.append(&side, placed(vec3(1.0, y, z), 0.0));
            } else {
                building.append(&gallery, placed(vec3(-ATRIUM + WALL / 2.0, y, z), 0.0));
            }
        }
        if bridged {
            let (min, max) = (vec3(-1.0, y - 0.3, -CORE.y + 0.001), vec3(1.0, y - 0.001, CORE.y - 0.001));
            block(building, Finish::Concrete, min, max);
            for x in [-0.95, 0.95] {
                building.append(&railing(2.0 * CORE.y), placed(vec3(x, y, CORE.y), 0.25));
            }
        }
    }
    let roof = FLOORS as f32 * STOREY;
    for i in 0..7 {
        let z = -CORE.y + CORE.y * (i as f32 + 0.5) / 3.5;
        let (min, max) = (vec3(-ATRIUM, roof - 0.5, z - 0.08), vec3(ATRIUM, roof - 0.1, z + 0.08));
        block(building, Finish::Steel, min, max);
    }
    slab(building, Finish::Concrete, -OUTER, vec2(OUTER.x, -CORE.y), roof, false, 10.0);
    slab(building, Finish::Concrete, vec2(-OUTER.x, CORE.y), OUTER, roof, false, 10.0);
    for (left, right) in [(-OUTER.x, -ATRIUM), (ATRIUM, OUTER.x)] {
        slab(building, Finish::Concrete, vec2(left, -CORE.y), vec2(right, CORE.y), roof, false, 10.0);
    }
    for (x, z) in [(-5.5, -3.0), (-5.5, 3.0), (5.5, -3.0), (5.5, 3.0)] {
        let (min, max) = (vec3(x - 0.25, 0.40, z - 1.2), vec3(x + 0.25, 0.45, z + 1.2));
        building.rounded_cuboid(Finish::Wood.surface(), [min, max], 0.02, 2, [1, 1, 3]);
        for end in [-1.0, 0.95] {
            let (min, max) = (vec3(x - 0.2, 0.0, z + end), vec3(x + 0.2, 0.399, z + end + 0.05));
            block(building, Finish::Steel, min, max);
        }
    }
    for (x, z) in BED {
        building.append(&plant(3.2, 60, random), placed(vec3(x, 0.0, z), random.unit()));
        building.append(pick(&kit.plants, random), placed(vec3(x + 0.6, 0.0, z + 0.4), random.unit()));
    }
}

/// The plants of the bed in the middle of the atrium.
const BED: [(f32, f32); 4] = [(-1.2, -3.6), (1.2, -4.6), (-0.8, -6.0), (1.0, -6.8)];

/// Brings the building to its exact size: bookcases wherever there is room, then pebbles in the bed.
fn fill(building: &mut Mesh, kit: &Kit, places: &[Affine3A], random: &mut Random) {
    // Every seventh place first, so that no floor is fuller than another.
    const STRIDE: usize = 7;
    /// Triangles that stay for the pebbles.
    const PEBBLES: usize = 2000;
    let order = (0..STRIDE).flat_map(|first| places.iter().skip(first).step_by(STRIDE));
    for place in order {
        let case = pick(&kit.bookcases, random);
        if building.len() + case.len() + PEBBLES > TRIANGLES {
            break;
        }
        building.append(case, *place);
    }
    let left = TRIANGLES.saturating_sub(building.len());
    building.rubble(Finish::Concrete.surface(), left, random, |random| {
        let at = vec3(random.between(-2.5, 2.5), 0.0, random.between(-7.5, -2.8));
        placed(at, random.unit()) * Affine3A::from_scale(Vec3::splat(random.between(0.05, 0.16)))
    });
}

/// Pairs each eye with where it will soon be, and the last ones with `end`.
fn looking_ahead(eyes: &[Vec3], end: Vec3) -> Vec<(Vec3, Vec3)> {
    /// Nearer places would turn the view too fast.
    const AHEAD: f32 = 1.8;
    (0..eyes.len())
        .map(|i| {
            let ahead = eyes[i + 1..].iter().find(|place| place.distance(eyes[i]) > AHEAD);
            (eyes[i], *ahead.unwrap_or(&end))
        })
        .collect()
}

/// The walk.
fn path() -> Vec<Camera> {
    let up = |floor: f32| floor * STOREY + EYE;
    // The middles of the western stairs' two flights.
    let (first, second, well) = (-10.77, -8.23, -9.5);
    let visited = vec2(-15.0 - DOOR_START - DOOR.x / 2.0, OFFICES.y);
    let door = vec3(visited.x, up(1.0), NORTH + 0.6);
    let corridor = [
        vec3(22.5, up(0.0), NORTH),
        vec3(15.0, up(0.0), NORTH),
        vec3(7.0, up(0.0), NORTH),
        vec3(5.0, up(0.0), 9.6),
    ];
    // Into the atrium, with a look up its galleries.
    let galleries = vec3(0.0, up(0.8), -8.0);
    let atrium = [vec3(3.0, up(0.0), 7.0), vec3(0.5, up(0.0), 4.5), vec3(-2.5, up(0.0), 6.0)];
    let upstairs = [
        vec3(-5.5, up(0.0), NORTH),
        vec3(-8.3, up(0.0), NORTH + 0.2),
        vec3(well, up(0.0), 9.6),
        vec3(-9.9, up(0.0), 8.4),
        vec3(first, up(0.0), 7.5),
        vec3(first, up(0.25), 5.9),
        vec3(first, up(0.5), 4.3),
        vec3(-10.2, up(0.5), 3.95),
        vec3(-8.8, up(0.5), 3.95),
        vec3(second, up(0.5), 4.3),
        vec3(second, up(0.75), 5.9),
        vec3(second, up(1.0), 7.5),
        vec3(-9.1, up(1.0), 8.4),
        vec3(well, up(1.0), 9.6),
        vec3(-11.5, up(1.0), NORTH),
        vec3(-14.6, up(1.0), NORTH),
        door,
    ];
    // Into an office, with a look at its desk and then at its other side.
    let (desk, cabinet) = (vec3(-13.0, up(1.0) - 0.6, 14.6), vec3(-17.0, up(1.0) - 0.5, 15.2));
    let office = [
        (vec3(visited.x, up(1.0), visited.y + 0.4), desk),
        (vec3(visited.x + 0.3, up(1.0), visited.y + 1.4), desk),
        (vec3(visited.x + 0.6, up(1.0), visited.y + 1.9), cabinet),
    ];
    // Out and around the corner, along the western corridor and the southern one, to the gallery.
    let around = [
        vec3(visited.x + 0.1, up(1.0), visited.y + 1.2),
        vec3(visited.x, up(1.0), visited.y + 0.2),
        vec3(visited.x - 0.6, up(1.0), NORTH),
        vec3(WEST + 0.3, up(1.0), NORTH - 0.3),
        vec3(WEST, up(1.0), 7.0),
        vec3(WEST, up(1.0), 0.0),
        vec3(WEST, up(1.0), -7.0),
        vec3(WEST + 0.3, up(1.0), 0.3 - NORTH),
        vec3(-16.0, up(1.0), -NORTH),
        vec3(-12.0, up(1.0), -NORTH),
        vec3(-5.0, up(1.0), -NORTH),
        vec3(-1.0, up(1.0), 0.3 - NORTH),
    ];
    let mut stops = looking_ahead(&corridor, vec3(0.0, up(0.2), 2.0));
    stops.extend(atrium.map(|eye| (eye, galleries)));
    stops.extend(looking_ahead(&upstairs, desk));
    stops.extend(office);
    stops.extend(looking_ahead(&around, vec3(3.0, up(1.5), 9.0)));
    cameras(&evenly(&stops, WALK_FRAMES), WALK_FRAMES, 60.0)
}
