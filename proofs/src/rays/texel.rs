//! Theorems of the sampling of textures (SH-2, SH-6).
//!
//! Each byte of memory is 0 or 255 by its address. Positions are quarters of texels: then nothing is rounded where the
//! sides are powers of two, and every texel shows by its weight.

use super::noise;
use crate::draw::{self, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use glam::Vec2;
use saarcor_model::host::{TexelFormat, TextureRecord};
use saarcor_model::rays::{sample_colour, sample_slope};
use saarcor_model::vm::{HostAddr, Memory, Observed, Observer, Unit};

/// Memory in which each byte is 0 or 255.
struct Bits;

/// The byte at an address.
fn byte_at(addr: u32) -> u8 {
    if noise(addr) & 1 == 0 { 0 } else { 255 }
}

impl Memory for Bits {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        for (byte, addr) in bytes.iter_mut().zip(addr.0..) {
            *byte = byte_at(addr);
        }
    }
}

/// Where it is read.
#[derive(Default)]
struct Reads {
    count: u32,
    least: u32,
    greatest: u32,
}

impl Observer for Reads {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: usize) {
        let last = addr.0 + (bytes as u32 - 1);
        self.least = if self.count == 0 { addr.0 } else { self.least.min(addr.0) };
        self.greatest = self.greatest.max(last);
        self.count += 1;
    }
}

/// A level of a texture anywhere in memory, and a place in it.
struct Case {
    texture: TextureRecord,
    level: u32,
    /// The level itself.
    of_level: TextureRecord,
    uv: Vec2,
    area: f32,
    /// The four texels, their columns and rows, and the weights of the second ones, in quarters.
    columns: [u32; 2],
    rows: [u32; 2],
    right: u32,
    down: u32,
    /// By how much the result may be off.
    slack: f32,
}

/// Sides of textures: one texel, powers of two and others.
static SIDES: [u32; 6] = [1, 2, 3, 8, 5, 0x1_0000];

/// Where textures begin, over 64: behind the root, and around the upper bits of an address.
static STARTS: [u32; 4] = [1, 0x3fff, 0x200_0000, 0x3ff_fff0];

fn case<S: Source>(s: &mut S, format: TexelFormat) -> Result<Case, Stop> {
    let texels = HostAddr(s.value("address / 64", 1..=0x3ff_ffff, &STARTS) << 6);
    let (width, height) =
        (s.value("width", 1..=0x1_0000, &SIDES), s.value("height", 1..=0x1_0000, &SIDES[..4]));
    let texture = TextureRecord { texels, width, height };
    let bytes = texture.texels_of_levels(texture.levels()) * u64::from(format.texel_bytes());
    assume!(u64::from(texels.0) + bytes <= 1 << 32);
    let level = s.value("level", 0..=16, &WORDS[..3]) % texture.levels();
    let of_level = texture.level(level, format);
    // From two tiles before the first texel to two behind.
    let place = |s: &mut S, name, side: u32| {
        let quarters = i64::from(s.value(name, 0..=0xf_ffff, &WORDS[..12]));
        let quarters = quarters % (16 * i64::from(side)) - 8 * i64::from(side);
        // Not at a texel's end where that would be rounded to either side.
        if side.is_power_of_two() { quarters } else { quarters | 1 }
    };
    let (right, up) =
        (place(s, "column, in quarters", of_level.width), place(s, "row, in quarters", of_level.height));
    let down = 4 * i64::from(of_level.height) - up;
    let texels = |quarters: i64, side: u32| {
        let first = (quarters - 2).div_euclid(4);
        let number = |texel: i64| texel.rem_euclid(i64::from(side)) as u32;
        ([number(first), number(first + 1)], (quarters - 2).rem_euclid(4) as u32)
    };
    let ((columns, right_part), (rows, down_part)) =
        (texels(right, of_level.width), texels(down, of_level.height));
    let over = |quarters: i64, side: u32| quarters as f32 / (4 * side) as f32;
    let exact = of_level.width.is_power_of_two() && of_level.height.is_power_of_two();
    Ok(Case {
        texture,
        level,
        of_level,
        uv: Vec2::new(over(right, of_level.width), over(up, of_level.height)),
        area: 4.0_f32.powi(level as i32) / (width as f32 * height as f32),
        columns,
        rows,
        right: right_part,
        down: down_part,
        slack: if exact { 0.0 } else { 0.05 },
    })
}

theorems! {
    /// The colour of a texture of any size, one texel included, anywhere in memory, is the mean of the four texels
    /// around the point, weighted by how near their centres are; columns go to the right, rows downwards, beyond an
    /// edge the texture begins again, and a ray that covers four texels of a level sees the next level; no byte
    /// outside of the texture is read.
    #[
        "SH-2", not_for_kani "it is arithmetic in floating point",
        covers ["one texel", "across the edge", "before the first texel", "at a centre", "between four", "a coarser level", "65536 columns"]
    ]
    fn colour_is_the_mean_of_the_texels_around(s) {
        let case = case(s, TexelFormat::Rgba8)?;
        let Case { texture, level, of_level, uv, columns, rows, .. } = case;
        let mut memory = Observed { memory: Bits, observer: Reads::default() };
        let found = sample_colour(&mut memory, texture, uv, case.area);
        cover!(s, "one texel", of_level.width == 1 && of_level.height == 1 && level == 0);
        cover!(s, "across the edge", columns[1] == 0 && of_level.width > 1);
        cover!(s, "before the first texel", uv.x < 0.0 && uv.y < 0.0);
        cover!(s, "at a centre", case.right == 0 && case.down == 0);
        cover!(s, "between four", case.right == 2 && case.down == 1);
        cover!(s, "a coarser level", level > 0);
        cover!(s, "65536 columns", of_level.width == 0x1_0000);
        for channel in 0..3 {
            let texel = |column: usize, row: usize| {
                let place = of_level.place(columns[column], rows[row]);
                if byte_at(of_level.texels.0 + 4 * place + channel) == 255 { 1.0 } else { 0.0 }
            };
            let [x, y] = [case.right, case.down].map(|quarters| quarters as f32 / 4.0);
            let top = texel(0, 0) * (1.0 - x) + texel(1, 0) * x;
            let bottom = texel(0, 1) * (1.0 - x) + texel(1, 1) * x;
            let expected = top * (1.0 - y) + bottom * y;
            let off = (found[channel as usize] - expected).abs();
            check!(off <= case.slack, "{uv} of level {level} of {texture:?}: channel {channel} of {found}, not {expected}");
        }
        let Reads { count, least, greatest } = memory.observer;
        let first = of_level.texels.0;
        let last = first + (4 * of_level.width * of_level.height - 1);
        check_eq!(count, 4, "texels that are read");
        check!(first <= least && greatest <= last, "{least:#x} .. {greatest:#x} of {first:#x} .. {last:#x}");
    }

    /// The slope of a bump map of any size is that between the four texels around the point, to the right and
    /// upwards, times the height of its 1.0 in texels of the level that is seen; beyond an edge the map begins again.
    #[
        "SH-2", not_for_kani "it is arithmetic in floating point",
        covers ["one texel", "to the right", "upwards", "downwards", "a coarser level", "across the edge"]
    ]
    fn slope_is_that_between_the_texels_around(s) {
        let case = case(s, TexelFormat::Height8)?;
        let Case { texture, level, of_level, uv, columns, rows, .. } = case;
        let height = [0.5_f32, -2.0][usize::from(draw::flag(s, "downwards"))];
        let found = sample_slope(&mut Observed::by_nobody(Bits), texture, height, uv, case.area);
        let texel = |column: usize, row: usize| {
            let place = of_level.place(columns[column], rows[row]);
            if byte_at(of_level.texels.0 + place) == 255 { 1.0_f32 } else { 0.0 }
        };
        let [a, b, c, d] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
        let of_level_height = height / 2.0_f32.powi(level as i32);
        let expected = Vec2::new((b - a + d - c) / 2.0, (a - c + b - d) / 2.0) * of_level_height;
        cover!(s, "one texel", of_level.width == 1 && of_level.height == 1 && level == 0);
        cover!(s, "to the right", expected.x > 0.0 && expected.y == 0.0);
        cover!(s, "upwards", expected.x == 0.0 && expected.y > 0.0);
        cover!(s, "downwards", expected.x == 0.0 && expected.y < 0.0);
        cover!(s, "a coarser level", level > 0);
        cover!(s, "across the edge", rows[1] == 0 && of_level.height > 1);
        check_eq!(found, expected, "{uv} of level {level} of {texture:?}");
    }
}
