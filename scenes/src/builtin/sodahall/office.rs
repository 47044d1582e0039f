//! The offices, and the workplaces in them.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use super::kit::{Kit, chance, pick};
use super::{CEILING, CORE, DOOR, DOOR_START, LONG_ROW, OFFICES, OUTER, SHORT_ROW, WALL};
use crate::builtin::building::{hang, window};
use crate::builtin::equipment::lying;
use crate::builtin::finish::Finish;
use crate::builtin::furniture::{block, book, empty, placed};
use crate::builtin::mesh::Mesh;
use saarcor_random::Random;

/// An office. In its own space the corridor lies at +z and the window at -z.
pub struct Office {
    /// From the office's space to its floor's.
    pub at: Affine3A,
    /// Half its width and half its depth.
    half: Vec2,
    /// Which office of its floor.
    index: u32,
}

/// The offices of a floor: the row at +z from -x to +x, then those at -z, -x and +x.
pub fn offices() -> Vec<Office> {
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
    pub fn bookcase_places(&self) -> impl Iterator<Item = Affine3A> {
        let w = self.inner().x - 0.01;
        [(vec3(w, 0.0, 0.15), -0.25), (vec3(-w, 0.0, 1.45), 0.25)]
            .map(|(at, turns)| placed(at, turns))
            .into_iter()
            // The shorter offices have their end of the left wall nearer.
            .take(if self.half.y > 2.0 { 2 } else { 1 })
    }

    pub fn furnished(&self, kit: &Kit, floor: u32, random: &mut Random) -> Mesh {
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
pub fn workplace(kit: &Kit, random: &mut Random) -> Mesh {
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
