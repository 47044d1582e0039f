//! What the cruiser is made of: four huge images with bump maps for hull, deck, superstructure and
//! sea, four small ones for what is inside, and plain paint, glass and mirrors.

use glam::{IVec2, Vec2, Vec3, ivec2, vec3};

use crate::builtin::mesh::Surface;
use crate::builtin::palette::{Palette, glass, glossy, matt, mirror};
use crate::builtin::texture::{Sample, concrete, fractal, noise, plates, step, wood};

/// Texels a side of the four large pairs of image and bump map: 64 MiB and 16 MiB each.
const LARGE: u32 = 4096;
/// Texels a side of the four small pairs: 4 MiB and 1 MiB each. Together they are the 340 MB of
/// Table 1.
const SMALL: u32 = 1024;

/// The surfaces of the ship and the sea.
pub struct Surfaces {
    pub hull: Surface,
    pub deck: Surface,
    pub house: Surface,
    pub sea: Surface,
    pub lining: Surface,
    pub floor: Surface,
    pub casing: Surface,
    pub insulation: Surface,
    pub sky: Surface,
    pub dark: Surface,
    pub white: Surface,
    pub red: Surface,
    pub steel: Surface,
    pub brass: Surface,
    pub copper: Surface,
    pub cable: Surface,
    pub window: Surface,
    pub canopy: Surface,
}

/// Makes the cruiser's surfaces in a palette.
pub fn surfaces(p: &mut Palette) -> Surfaces {
    let navy = vec3(0.4, 0.43, 0.46);
    let pale = vec3(0.52, 0.55, 0.57);
    let teak = vec3(0.55, 0.42, 0.28);
    let water = vec3(0.05, 0.2, 0.26);
    let cream = vec3(0.7, 0.68, 0.58);
    let green = vec3(0.25, 0.42, 0.34);
    let grey = Vec3::splat(0.4);
    Surfaces {
        hull: p.relief(matt(navy), LARGE, 48.0, 4.0, plates(ivec2(12, 24), navy, 0.3, 1)),
        deck: p.relief(matt(teak), LARGE, 24.0, 3.0, wood(96, teak, 20)),
        house: p.relief(matt(pale), LARGE, 32.0, 4.0, plates(ivec2(16, 16), pale, 0.12, 40)),
        sea: p.relief(mirror(water, 0.3), LARGE, 160.0, 6.0, swell(water, 60)),
        lining: p.relief(matt(cream), SMALL, 6.0, 3.0, plates(ivec2(4, 4), cream, 0.2, 80)),
        floor: p.relief(matt(grey), SMALL, 3.0, 3.0, chequer_plate(grey, 90)),
        casing: p.relief(glossy(green), SMALL, 4.0, 2.0, plates(ivec2(6, 6), green, 0.15, 100)),
        insulation: p.relief(matt(cream), SMALL, 2.0, 3.0, concrete(cream, 6, 120)),
        sky: p.plain(matt(vec3(0.45, 0.6, 0.8))),
        dark: p.plain(matt(Vec3::splat(0.2))),
        white: p.plain(glossy(Vec3::splat(0.75))),
        red: p.plain(glossy(vec3(0.65, 0.12, 0.08))),
        steel: p.plain(mirror(Vec3::splat(0.45), 0.25)),
        brass: p.plain(glossy(vec3(0.7, 0.5, 0.2))),
        copper: p.plain(glossy(vec3(0.65, 0.35, 0.2))),
        cable: p.plain(matt(vec3(0.2, 0.2, 0.24))),
        window: p.plain(mirror(vec3(0.2, 0.22, 0.25), 0.6)),
        canopy: p.plain(glass(vec3(0.25, 0.3, 0.35), 0.7, 1.2)),
    }
}

/// Waves of several lengths with foam on the highest.
fn swell(water: Vec3, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let long = fractal(point, ivec2(10, 24), 4, seed);
        let short = noise(point, IVec2::splat(320), seed + 8);
        let height = 0.8 * long + 0.2 * short;
        let foam = step(0.66, 0.82, height);
        let color = water.lerp(water * 1.8, long).lerp(Vec3::splat(0.8), foam);
        Sample { color, height }
    }
}

/// Steel floor plate with raised bars that cross.
fn chequer_plate(color: Vec3, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let at = point * 48.0;
        let cell = at.as_ivec2();
        let inside = at - cell.as_vec2() - Vec2::splat(0.5);
        // Bars lie along one diagonal or the other by turns.
        let (along, across) = if (cell.x + cell.y) % 2 == 0 {
            (inside.x + inside.y, inside.x - inside.y)
        } else {
            (inside.x - inside.y, inside.x + inside.y)
        };
        let bar = (1.0 - step(0.4, 0.5, along.abs())) * (1.0 - step(0.08, 0.16, across.abs()));
        let wear = fractal(point, IVec2::splat(8), 4, seed);
        Sample { color: color * (0.5 + 0.6 * wear + 0.25 * bar), height: 0.3 + 0.7 * bar }
    }
}
