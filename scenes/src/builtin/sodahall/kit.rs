//! The parts that stand in many rooms.

use glam::vec2;

use super::{DOOR, WALL};
use crate::builtin::building::{door_frame, door_leaf, louvre_lamp, radiator, switch, venetian_blind};
use crate::builtin::equipment::{
    bin, computer, desk_lamp, extinguisher, mug, notice_board, picture, plant, sheet, telephone,
};
use crate::builtin::finish::Finish;
use crate::builtin::furniture::{bookcase, desk, drawers, swivel_chair, whiteboard, wooden_chair};
use crate::builtin::mesh::Mesh;
use saarcor_random::Random;

/// The parts that stand in many rooms, in a few variants.
pub struct Kit {
    pub desks: [Mesh; 3],
    pub swivel_chairs: [Mesh; 3],
    pub wooden_chair: Mesh,
    pub bookcases: Vec<Mesh>,
    pub cabinets: [Mesh; 2],
    pub computers: [Mesh; 3],
    pub telephone: Mesh,
    pub desk_lamp: Mesh,
    pub mugs: [Mesh; 3],
    pub sheet: Mesh,
    pub bin: Mesh,
    pub plants: Vec<Mesh>,
    pub whiteboard: Mesh,
    pub pictures: Vec<Mesh>,
    pub notice_boards: Vec<Mesh>,
    pub blinds: Vec<Mesh>,
    pub radiator: Mesh,
    pub lamp: Mesh,
    pub door_frame: Mesh,
    pub door_leaf: Mesh,
    pub switch: Mesh,
    pub extinguisher: Mesh,
}

impl Kit {
    pub fn new(random: &mut Random) -> Self {
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

pub fn pick<'a>(variants: &'a [Mesh], random: &mut Random) -> &'a Mesh {
    &variants[random.range(0, variants.len() as u32) as usize]
}

pub fn chance(random: &mut Random, percent: u32) -> bool {
    random.range(0, 100) < percent
}
