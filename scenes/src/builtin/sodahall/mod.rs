//! The building of Table 1, after Berkeley's Soda Hall: seven floors of furnished offices, lecture
//! rooms and corridors around an atrium, with two stairwells. Walls hide nearly all of it from any
//! one place.

mod atrium;
mod core_rooms;
mod kit;
mod office;
mod shell;
mod walk;

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};
use saarcor_model::host::Scene;

use super::finish::Finish;
use super::furniture::{empty, placed};
use super::mesh::Mesh;
use atrium::atrium;
use core_rooms::core_rooms;
use kit::{Kit, pick};
use office::offices;
use saarcor_random::Random;
use shell::{corridors, slabs, stairs, walls};
use walk::path;

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
