//! What the level is made of: forty tiling images of game-like resolution, water, glass and a
//! mirror.

use glam::{IVec2, Vec2, Vec3, ivec2, vec3};

use crate::builtin::mesh::Surface;
use crate::builtin::palette::{Palette, glass, glossy, matt, mirror};
use crate::builtin::texture::{Sample, bond, concrete, fractal, masonry, plates, step, wood};

/// Texels a side of the images of walls and floors: 24 images of 1 MiB.
const LARGE: u32 = 512;
/// Texels a side of the images of things: 16 images of 256 KiB. Together they are the 28 MB of
/// Table 1.
const SMALL: u32 = 256;

/// The surfaces of the level, by what they are for.
pub struct Surfaces {
    pub hall_wall: Surface,
    pub hall_floor: Surface,
    pub hall_ceiling: Surface,
    pub pillar: Surface,
    pub gallery: Surface,
    pub gallery_floor: Surface,
    pub pool: Surface,
    pub corridor_wall: Surface,
    pub corridor_floor: Surface,
    pub corridor_ceiling: Surface,
    pub works_wall: Surface,
    pub works_floor: Surface,
    pub works_ceiling: Surface,
    pub machine: Surface,
    pub stair_wall: Surface,
    pub tread: Surface,
    pub chapel_wall: Surface,
    pub chapel_floor: Surface,
    pub vault: Surface,
    pub lab_wall: Surface,
    pub lab_floor: Surface,
    pub lab_ceiling: Surface,
    pub sky: Surface,
    pub banner: Surface,
    pub crate_wood: Surface,
    pub crate_metal: Surface,
    pub copper: Surface,
    pub green_pipe: Surface,
    pub grate: Surface,
    pub gold: Surface,
    pub steel: Surface,
    pub trim: Surface,
    pub skin: Surface,
    pub red_armour: Surface,
    pub blue_armour: Surface,
    pub green_item: Surface,
    pub yellow_item: Surface,
    pub weapon: Surface,
    pub panel: Surface,
    pub rubble: Surface,
    pub water: Surface,
    pub pane: Surface,
    pub looking_glass: Surface,
}

/// Makes the level's surfaces in a palette.
pub fn surfaces(p: &mut Palette) -> Surfaces {
    let red = vec3(0.45, 0.2, 0.13);
    let blue = vec3(0.16, 0.24, 0.5);
    let green = vec3(0.2, 0.42, 0.2);
    let yellow = vec3(0.7, 0.55, 0.12);
    let sand = vec3(0.66, 0.55, 0.38);
    let pale = vec3(0.72, 0.7, 0.64);
    let grey = Vec3::splat(0.45);
    let dark = Vec3::splat(0.24);
    let steel = vec3(0.44, 0.46, 0.5);
    let brown = vec3(0.45, 0.28, 0.14);
    let square = IVec2::splat;
    let bricks = |color: Vec3, seed| masonry(ivec2(6, 16), 0.5, 0.06, [color * 0.8, color * 1.3], grey, seed);
    let blocks =
        |color: Vec3, seed| masonry(ivec2(3, 4), 0.5, 0.025, [color * 0.8, color * 1.15], color * 0.4, seed);
    let tiles = |colors: [Vec3; 2], seed| masonry(square(8), 0.0, 0.03, colors, dark, seed);
    Surfaces {
        hall_wall: p.image(matt(sand), LARGE, 4.0, blocks(sand, 10)),
        hall_floor: p.image(matt(pale), LARGE, 4.0, tiles([pale, sand * 0.8], 20)),
        hall_ceiling: p.image(matt(grey), LARGE, 4.0, concrete(grey, 4, 30)),
        pillar: p.image(matt(pale), LARGE, 2.0, marble(pale, 40)),
        gallery: p.image(matt(red), LARGE, 3.0, bricks(red, 50)),
        gallery_floor: p.image(matt(brown), LARGE, 2.5, wood(6, brown, 60)),
        pool: p.image(matt(blue), LARGE, 2.0, tiles([blue, blue * 1.6], 70)),
        corridor_wall: p.image(matt(grey), LARGE, 3.0, bricks(grey, 80)),
        corridor_floor: p.image(matt(dark), LARGE, 2.0, plates(square(2), dark, 0.3, 90)),
        corridor_ceiling: p.image(matt(dark), LARGE, 4.0, concrete(dark, 3, 100)),
        works_wall: p.image(matt(steel), LARGE, 4.0, plates(ivec2(2, 3), steel, 0.35, 110)),
        works_floor: p.image(matt(steel), LARGE, 3.0, plates(square(3), steel * 0.8, 0.2, 120)),
        works_ceiling: p.image(matt(brown), LARGE, 4.0, plates(square(2), brown, 0.6, 130)),
        machine: p.image(glossy(green), LARGE, 2.5, plates(square(2), green, 0.25, 140)),
        stair_wall: p.image(matt(pale), LARGE, 4.0, concrete(pale, 5, 150)),
        tread: p.image(matt(grey), LARGE, 2.0, blocks(grey, 160)),
        chapel_wall: p.image(matt(pale), LARGE, 3.5, blocks(pale, 170)),
        chapel_floor: p.image(mirror(grey, 0.3), LARGE, 4.0, checker(180)),
        vault: p.image(matt(sand), LARGE, 4.0, bricks(sand, 190)),
        lab_wall: p.image(matt(blue), LARGE, 3.0, plates(ivec2(3, 2), steel * 1.3, 0.1, 200)),
        lab_floor: p.image(matt(grey), LARGE, 3.0, tiles([grey, grey * 1.5], 210)),
        lab_ceiling: p.image(matt(steel), LARGE, 3.0, plates(square(2), pale, 0.15, 220)),
        sky: p.image(matt(vec3(0.5, 0.6, 0.8)), LARGE, 130.0, clouds(230)),
        banner: p.image(matt(red), LARGE, 2.0, cloth(red, yellow, 240)),
        crate_wood: p.image(matt(brown), SMALL, 1.2, wood(5, brown * 1.4, 250)),
        crate_metal: p.image(matt(steel), SMALL, 1.2, plates(square(1), steel, 0.4, 260)),
        copper: p.image(glossy(brown), SMALL, 1.0, concrete(vec3(0.6, 0.32, 0.18), 2, 270)),
        green_pipe: p.image(glossy(green), SMALL, 1.0, concrete(green, 1, 280)),
        grate: p.image(matt(dark), SMALL, 0.5, plates(square(1), dark * 1.5, 0.5, 290)),
        gold: p.image(mirror(yellow, 0.2), SMALL, 0.5, concrete(yellow, 1, 300)),
        steel: p.image(glossy(steel), SMALL, 1.0, plates(square(2), steel * 1.2, 0.1, 310)),
        trim: p.image(matt(dark), SMALL, 1.0, blocks(dark * 1.4, 320)),
        skin: p.image(matt(sand), SMALL, 0.6, concrete(vec3(0.75, 0.5, 0.38), 1, 330)),
        red_armour: p.image(glossy(red), SMALL, 0.4, plates(square(1), red * 1.3, 0.1, 340)),
        blue_armour: p.image(glossy(blue), SMALL, 0.4, plates(square(1), blue * 1.5, 0.1, 350)),
        green_item: p.image(glossy(green), SMALL, 0.4, marble(green * 1.5, 360)),
        yellow_item: p.image(glossy(yellow), SMALL, 0.4, marble(yellow, 370)),
        weapon: p.image(glossy(dark), SMALL, 0.3, plates(ivec2(1, 2), dark * 1.6, 0.15, 380)),
        panel: p.image(matt(yellow), SMALL, 1.0, stripes(yellow, dark * 0.4, 390)),
        rubble: p.image(matt(grey), SMALL, 0.5, concrete(pale, 1, 400)),
        water: p.plain(glass(vec3(0.2, 0.35, 0.4), 0.7, 1.33)),
        pane: p.plain(glass(vec3(0.3, 0.4, 0.35), 0.8, 1.1)),
        looking_glass: p.plain(mirror(Vec3::splat(0.2), 0.8)),
    }
}

/// Stone with dark veins.
fn marble(color: Vec3, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let bend = fractal(point, IVec2::splat(3), 5, seed);
        // Whole waves over the tile, so that it repeats.
        let vein = ((point.x + point.y) * 4.0 + 3.0 * bend).fract();
        let vein = (2.0 * vein - 1.0).abs().powi(6);
        let cloud = fractal(point, IVec2::splat(6), 4, seed + 7);
        Sample { color: color * (0.7 + 0.5 * cloud) * (1.0 - 0.6 * vein), height: 0.9 - 0.1 * vein }
    }
}

/// Polished slabs, light and dark by turns.
fn checker(seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    let slabs = IVec2::splat(4);
    let [light, dark] = [marble(Vec3::splat(0.75), seed), marble(vec3(0.25, 0.1, 0.08), seed + 20)];
    move |point| {
        let cell = (point * slabs.as_vec2()).as_ivec2();
        let slab = if (cell.x + cell.y) % 2 == 0 { light(point) } else { dark(point) };
        let joint = step(0.0, 0.015, bond(point, slabs, 0.0, seed).edge);
        Sample { color: slab.color * (0.3 + 0.7 * joint), height: slab.height * joint }
    }
}

/// Warning stripes, worn.
fn stripes(light: Vec3, dark: Vec3, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let stripe = ((point.x + point.y) * 4.0).fract();
        let paint = step(0.0, 0.05, stripe) - step(0.5, 0.55, stripe);
        let wear = fractal(point, IVec2::splat(8), 4, seed);
        Sample { color: dark.lerp(light, paint) * (0.5 + 0.7 * wear), height: 0.5 }
    }
}

/// Woven cloth with a broad border and a lozenge.
fn cloth(color: Vec3, figure: Vec3, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let from_middle = (point - Vec2::splat(0.5)).abs();
        let border = step(0.4, 0.41, from_middle.max_element()) - step(0.46, 0.47, from_middle.max_element());
        let lozenge = 1.0 - step(0.24, 0.25, from_middle.x + from_middle.y);
        let thread = (point * 128.0).fract() - Vec2::splat(0.5);
        let weave = 1.0 - 0.8 * thread.length_squared();
        let stain = fractal(point, IVec2::splat(5), 4, seed);
        let dye = color.lerp(figure, border.max(lozenge));
        Sample { color: dye * weave * (0.6 + 0.6 * stain), height: weave }
    }
}

/// Clouds before a blue sky.
fn clouds(seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let cloud = step(0.4, 0.75, fractal(point, IVec2::splat(5), 6, seed));
        Sample { color: vec3(0.3, 0.45, 0.75).lerp(Vec3::splat(0.95), cloud), height: cloud }
    }
}
