//! The atrium, and the roof.

use glam::{vec2, vec3};

use super::kit::{Kit, pick};
use super::{ATRIUM, CORE, FLOORS, OUTER, STOREY, WALL};
use crate::builtin::building::{railing, slab};
use crate::builtin::equipment::plant;
use crate::builtin::finish::Finish;
use crate::builtin::furniture::{block, placed};
use crate::builtin::mesh::Mesh;
use saarcor_random::Random;

/// The atrium over all storeys: railings along the galleries, two bridges, benches, a bed of trees
/// and the beams of the roof.
pub fn atrium(building: &mut Mesh, kit: &Kit, random: &mut Random) {
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
