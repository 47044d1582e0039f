//! The walk: through the atrium, up a stairwell, into an office and around the corridors.

use glam::{Vec3, vec2, vec3};
use saarcor_model::host::Camera;

use super::{DOOR, DOOR_START, EYE, NORTH, OFFICES, STOREY, WALK_FRAMES, WEST};
use crate::builtin::path::{cameras, evenly};

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
pub fn path() -> Vec<Camera> {
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
