//! Procedural images: pure functions of a texel, evaluated in parallel, that tile.
//!
//! A pattern takes a point of the tile, both coordinates in [0, 1) and v upwards, and gives colour
//! and height together, so that an image and a bump map made of one pattern fit each other.

use glam::{IVec2, Vec2, Vec3, vec2};
use rayon::prelude::*;
use saarcor_model::host::{TexelFormat, Texture};

/// What a pattern gives at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Linear RGB, 0 to 1.
    pub color: Vec3,
    /// Height, 0 to 1.
    pub height: f32,
}

/// The colours of a pattern as a square image of `size` texels a side.
#[must_use]
pub fn color_image(size: u32, pattern: impl Fn(Vec2) -> Sample + Sync) -> Texture {
    let mut colors = blank(size, TexelFormat::Rgba8);
    colors.texels.par_chunks_exact_mut(size as usize * 4).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.as_chunks_mut().0.iter_mut().enumerate() {
            *texel = to_rgba8(pattern(texel_centre(x, y, size)).color);
        }
    });
    colors
}

/// The colours and the heights of a pattern, as an image and a bump map of `size` texels a side.
#[must_use]
pub fn color_and_height_images(size: u32, pattern: impl Fn(Vec2) -> Sample + Sync) -> (Texture, Texture) {
    let mut colors = blank(size, TexelFormat::Rgba8);
    let mut heights = blank(size, TexelFormat::Height8);
    let color_rows = colors.texels.par_chunks_exact_mut(size as usize * 4);
    let height_rows = heights.texels.par_chunks_exact_mut(size as usize);
    color_rows.zip(height_rows).enumerate().for_each(|(y, (color_row, height_row))| {
        let texels = color_row.as_chunks_mut().0.iter_mut().zip(height_row);
        for (x, (color, height)) in texels.enumerate() {
            let sample = pattern(texel_centre(x, y, size));
            *color = to_rgba8(sample.color);
            *height = to_byte(sample.height);
        }
    });
    (colors, heights)
}

fn blank(size: u32, format: TexelFormat) -> Texture {
    let bytes = size as usize * size as usize * format.texel_bytes() as usize;
    Texture { width: size, height: size, format, texels: vec![0; bytes] }
}

/// The middle of a texel in coordinates of the tile; rows run from the top, v runs upwards.
fn texel_centre(x: usize, y: usize, size: u32) -> Vec2 {
    let at = vec2(x as f32 + 0.5, y as f32 + 0.5) / size as f32;
    vec2(at.x, 1.0 - at.y)
}

fn to_rgba8(color: Vec3) -> [u8; 4] {
    let [r, g, b] = color.to_array().map(to_byte);
    [r, g, b, u8::MAX]
}

fn to_byte(value: f32) -> u8 {
    // A float-to-integer cast saturates, so values outside 0 to 1 are clamped.
    (value * 255.0 + 0.5) as u8
}

/// A random value in [0, 1) for a cell of a grid.
#[must_use]
pub fn cell_noise(cell: IVec2, seed: u32) -> f32 {
    // Weyl steps of the coordinates and one round of a multiplicative hash, whose upper bits are
    // good enough to look at: patterns ask for so many values that more would show in the time.
    let bits = (cell.x as u32).wrapping_mul(0x9e37_79b1)
        ^ (cell.y as u32).wrapping_mul(0x85eb_ca77)
        ^ seed.wrapping_mul(0xc2b2_ae3d);
    let bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// The part behind the point of a value that is not negative.
///
/// Unlike [`f32::fract`] it needs no call of a library function on processors without SSE 4.1.
fn fraction(value: f32) -> f32 {
    value - (value as i32) as f32
}

/// Value noise in [0, 1) with `period` cells over the tile.
#[must_use]
pub fn noise(point: Vec2, period: IVec2, seed: u32) -> f32 {
    let at = point * period.as_vec2();
    let low = at.as_ivec2();
    let f = at - low.as_vec2();
    let f = f * f * (Vec2::splat(3.0) - 2.0 * f);
    // The last cell's far corners are the first cell's near ones, so that the tile repeats.
    let next = low + IVec2::ONE;
    let high = IVec2::select(next.cmplt(period), next, IVec2::ZERO);
    let bottom = mix(cell_noise(low, seed), cell_noise(IVec2::new(high.x, low.y), seed), f.x);
    let top = mix(cell_noise(IVec2::new(low.x, high.y), seed), cell_noise(high, seed), f.x);
    mix(bottom, top, f.y)
}

/// `a` at 0, `b` at 1, a line between them.
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Fractal noise in [0, 1): `octaves` layers of [`noise`], each twice as fine and half as strong.
#[must_use]
pub fn fractal(point: Vec2, period: IVec2, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight, mut period) = (0.0, 0.5, period);
    for octave in 0..octaves {
        sum += weight * noise(point, period, seed + octave);
        weight *= 0.5;
        period *= 2;
    }
    // The weights sum up to 1 - 2^-octaves.
    sum / (1.0 - 2.0 * weight)
}

/// Where a point lies in a bond of `counts` stones over the tile, every second course shifted by
/// `shift` of a stone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// A random value in [0, 1) of the stone.
    pub stone: f32,
    /// Distance to the stone's next edge, in sizes of a course's height.
    pub edge: f32,
    /// The point inside the stone, both coordinates in [0, 1).
    pub inside: Vec2,
}

/// The [`Bond`] at a point. For the tile to repeat, `counts.y` must be even where there is a shift.
#[must_use]
pub fn bond(point: Vec2, counts: IVec2, shift: f32, seed: u32) -> Bond {
    let mut at = point * counts.as_vec2();
    if at.y as i32 % 2 == 1 {
        at.x += shift;
    }
    let mut cell = at.as_ivec2();
    let inside = at - cell.as_vec2();
    if cell.x >= counts.x {
        cell.x -= counts.x;
    }
    let to_edge = inside.min(Vec2::ONE - inside);
    let aspect = counts.y as f32 / counts.x as f32;
    Bond { stone: cell_noise(cell, seed), edge: (to_edge.x * aspect).min(to_edge.y), inside }
}

/// 0 below `low`, 1 above `high`, smooth between them.
#[must_use]
pub fn step(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Stones in mortar: bricks, blocks or tiles. `stones` and `mortar` are colours, `joint` is half a
/// joint's width in sizes of a course's height.
pub fn masonry(
    counts: IVec2,
    shift: f32,
    joint: f32,
    stones: [Vec3; 2],
    mortar: Vec3,
    seed: u32,
) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let bond = bond(point, counts, shift, seed);
        let grain = fractal(point, counts * 4, 3, seed + 1);
        let face = step(joint, joint * 1.8, bond.edge + (grain - 0.5) * joint);
        let stone = stones[0].lerp(stones[1], bond.stone) * (0.7 + 0.5 * grain);
        let mortar = mortar * (0.8 + 0.4 * grain);
        Sample { color: mortar.lerp(stone, face), height: face * (0.7 + 0.3 * grain) }
    }
}

/// Cast concrete or plaster: stains, pores and the seams of `seams` boards of the form.
pub fn concrete(color: Vec3, seams: i32, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let stain = fractal(point, IVec2::splat(3), 5, seed);
        let pore = step(0.82, 0.92, noise(point, IVec2::splat(96), seed + 9));
        let board = fraction(point.y * seams as f32);
        let seam = 1.0 - step(0.0, 0.03, board.min(1.0 - board));
        let shade = 0.65 + 0.6 * stain - 0.3 * pore - 0.25 * seam;
        Sample { color: color * shade, height: 0.8 + 0.2 * stain - 0.4 * pore - 0.4 * seam }
    }
}

/// Riveted metal plates, `counts` of them over the tile, with `rust` from 0 to 1.
pub fn plates(counts: IVec2, color: Vec3, rust: f32, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    const RUST: Vec3 = Vec3::new(0.33, 0.13, 0.05);
    // Rivets stand in a row along each edge of a plate, in parts of the plate's height.
    const RIVETS: f32 = 8.0;
    const RIVET_INSET: f32 = 0.06;
    move |point| {
        let plate = bond(point, counts, 0.0, seed);
        let brushed = noise(point, counts * IVec2::new(4, 64), seed + 1);
        let stain = fractal(point, counts * 3, 3, seed + 2);
        let seam = 1.0 - step(0.008, 0.02, plate.edge);
        let slot = (plate.inside * RIVETS).map(fraction) - Vec2::splat(0.5);
        let along = if plate.inside.x.min(1.0 - plate.inside.x) < plate.inside.y.min(1.0 - plate.inside.y) {
            slot.y
        } else {
            slot.x
        };
        let rivet_radius = vec2(along / RIVETS, plate.edge - RIVET_INSET).length();
        let rivet = 1.0 - step(0.012, 0.022, rivet_radius);
        let rusty = step(1.0 - rust, 1.25 - rust, stain + 0.3 * seam);
        let metal = color * (0.75 + 0.2 * plate.stone + 0.2 * brushed);
        let shade = 1.0 - 0.6 * seam + 0.25 * rivet;
        let color = metal.lerp(RUST * (0.5 + stain), rusty) * shade;
        Sample { color, height: 0.5 - 0.4 * seam + 0.4 * rivet + 0.1 * rusty * stain }
    }
}

/// Boards of wood, `boards` of them side by side, the grain along v.
pub fn wood(boards: i32, color: Vec3, seed: u32) -> impl Fn(Vec2) -> Sample + Sync {
    move |point| {
        let board = bond(point, IVec2::new(boards, 1), 0.0, seed);
        let wave = fractal(point, IVec2::new(boards * 2, 2), 3, seed + 1);
        // A whole number of rings over the tile; the wave bends them.
        let rings = fraction(point.x * (boards * 5) as f32 + 4.0 * wave + 7.0 * board.stone);
        let ring = step(0.0, 0.7, rings) - step(0.7, 1.0, rings);
        let fibre = noise(point, IVec2::new(boards * 48, 8), seed + 5);
        let gap = 1.0 - step(0.0, 0.03, board.inside.x.min(1.0 - board.inside.x));
        let shade = (0.6 + 0.25 * ring + 0.2 * fibre + 0.25 * board.stone) * (1.0 - 0.7 * gap);
        Sample { color: color * shade, height: 0.7 + 0.15 * ring + 0.1 * fibre - 0.6 * gap }
    }
}
