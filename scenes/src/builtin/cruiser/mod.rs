//! `cruiser`: a warship at sea, few plain parts and few very dense ones.
//!
//! Two thirds of the triangles stand in the machinery hall amidships, within a few metres,
//! and most of the others in mast, radars, guns and rivets; hull, decks and sea are coarse and
//! carry huge images and bump maps. The path goes around the ship, up to the mast, through the
//! machinery hall and past the bridge.

mod fittings;
mod machinery;
mod parts;
mod ship;
mod surfaces;

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, Quat, Vec3, vec3};
use saarcor_model::host::{Light, Scene};

use super::mesh::Mesh;
use super::palette::Palette;
use super::path::{WayPoint, cameras};
use saarcor_random::Random;
use surfaces::{Surfaces, surfaces};

/// Triangles (Table 1, Stated).
const TRIANGLES: usize = 3_637_101;
/// Frames of the path: past frame 2080, the last that Table 2 names.
const FRAMES: u32 = 2_300;

/// Builds the scene, with images and bump maps if `textured`.
#[must_use]
pub fn scene(textured: bool) -> Scene {
    let mut palette = Palette::new(textured);
    let s = surfaces(&mut palette);
    let mut mesh = Mesh::new(textured);
    ship::surroundings(&mut mesh, &s);
    ship::ship(&mut mesh, &s);
    fittings::fittings(&mut mesh, &s);
    machinery::machinery(&mut mesh, &s);
    studs(&mut mesh, &s);
    let (triangles, tex_coords) = mesh.into_parts();
    let (materials, textures) = palette.into_parts();
    Scene {
        triangles,
        tex_coords,
        materials,
        textures,
        lights: vec![Light { position: vec3(250.0, 560.0, 280.0), intensity: 1.0 }],
        path: cameras(&flight(), FRAMES, 60.0),
        ..Scene::default()
    }
}

/// Rough weld studs in rows on the lining of the machinery hall's starboard wall, below the cables:
/// as many triangles as the ship still lacks.
fn studs(mesh: &mut Mesh, s: &Surfaces) {
    const PITCH: f32 = 0.07;
    const COLUMNS: u32 = 400;
    let left = TRIANGLES - mesh.len();
    let mut placed = 0;
    mesh.rubble(s.steel, left, &mut Random::new(17), |_| {
        let [column, row] = [placed % COLUMNS, placed / COLUMNS].map(|c| c as f32);
        placed += 1;
        let at = vec3(-44.0 + PITCH * column, 7.0 + PITCH * row, 7.8);
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.05), Quat::from_rotation_x(-FRAC_PI_2), at)
    });
}

/// The way points, by frame.
fn flight() -> Vec<WayPoint> {
    let at = |frame: f32, eye: Vec3, target: Vec3| WayPoint { frame, eye, target };
    vec![
        // From afar off the bow, along the starboard side.
        at(0.0, vec3(135.0, 34.0, 105.0), vec3(25.0, 9.0, 0.0)),
        at(142.0, vec3(92.0, 24.0, 78.0), vec3(18.0, 10.0, 0.0)),
        at(350.0, vec3(62.0, 15.0, 48.0), vec3(30.0, 11.0, 0.0)),
        at(500.0, vec3(28.0, 14.0, 40.0), vec3(10.0, 12.0, 0.0)),
        at(700.0, vec3(-50.0, 16.0, 38.0), vec3(-55.0, 8.0, 0.0)),
        // Around the stern, with the helicopter.
        at(850.0, vec3(-104.0, 15.0, 10.0), vec3(-72.0, 8.5, 0.0)),
        at(1000.0, vec3(-75.0, 20.0, -32.0), vec3(-25.0, 12.0, 0.0)),
        // Up to the mast.
        at(1120.0, vec3(0.0, 26.0, -30.0), vec3(22.0, 24.0, 0.0)),
        at(1220.0, vec3(36.0, 29.0, -10.0), vec3(24.0, 26.0, 0.0)),
        at(1300.0, vec3(14.0, 31.0, 14.0), vec3(22.0, 27.0, 0.0)),
        at(1380.0, vec3(-28.0, 24.0, 26.0), vec3(-42.0, 12.0, 3.0)),
        // Through the door aft into the machinery hall, around the engine, out to port.
        at(1450.0, vec3(-56.0, 13.0, 7.5), vec3(-45.0, 10.0, 1.5)),
        at(1520.0, vec3(-48.0, 10.2, 1.0), vec3(-38.0, 9.4, 0.0)),
        at(1565.0, vec3(-43.2, 9.8, 3.6), vec3(-36.0, 9.4, 1.5)),
        at(1595.0, vec3(-39.0, 10.0, 5.8), vec3(-33.5, 9.4, 1.6)),
        at(1625.0, vec3(-34.5, 10.1, 5.9), vec3(-34.2, 9.3, 1.8)),
        at(1700.0, vec3(-29.5, 10.0, 6.0), vec3(-31.0, 9.4, 1.0)),
        at(1760.0, vec3(-23.5, 9.6, 6.0), vec3(-27.0, 9.2, 0.0)),
        at(1820.0, vec3(-18.0, 9.6, 3.6), vec3(-24.0, 9.2, -1.0)),
        at(1870.0, vec3(-17.6, 9.4, -2.0), vec3(-20.0, 9.2, -6.0)),
        at(1910.0, vec3(-20.2, 9.4, -6.2), vec3(-18.0, 9.6, -11.0)),
        at(1950.0, vec3(-18.5, 10.5, -13.0), vec3(-3.0, 11.0, -10.0)),
        // Past the bridge to the bow.
        at(2010.0, vec3(0.0, 13.0, -21.0), vec3(16.0, 13.0, -6.0)),
        at(2080.0, vec3(40.0, 16.5, -15.0), vec3(30.0, 15.0, 0.0)),
        at(2160.0, vec3(62.0, 17.0, -9.0), vec3(42.0, 13.0, 0.0)),
        at(2230.0, vec3(84.0, 16.0, -4.0), vec3(60.0, 10.0, 0.0)),
        at(2299.0, vec3(112.0, 18.0, 5.0), vec3(60.0, 9.0, 0.0)),
    ]
}
