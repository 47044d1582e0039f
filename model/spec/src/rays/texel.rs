//! Sampling of textures: which texels a ray sees, and what their mean is (SH-2, SH-6; the filters are
//! Assumed).

use crate::host::{TexelFormat, TextureRecord};
use crate::vm::{Memory, Observed, Observer, Unit};
use glam::{Vec2, Vec3};

/// Where a texture coordinate lies among the texels of a texture (SH-2).
///
/// The texture tiles; v runs upwards, rows downwards; texels have their values at their centres.
struct Footprint {
    /// Columns and rows of the four texels around the point.
    columns: [u32; 2],
    rows: [u32; 2],
    /// How far the point is from the first of them, to the right and downwards: 0 to 1.
    fraction: Vec2,
}

impl Footprint {
    fn new(texture: TextureRecord, uv: Vec2) -> Self {
        let tile = |place: f32, size: u32| {
            // Rounding can give 1.0 itself, which is the first texel of the next tile.
            let texel = (place - place.floor()) * size as f32 - 0.5;
            let below = texel.floor();
            let first = (below as i64).rem_euclid(i64::from(size)) as u32;
            ([first, (first + 1) % size], texel - below)
        };
        let (columns, right) = tile(uv.x, texture.width);
        let (rows, down) = tile(1.0 - uv.y, texture.height);
        Self { columns, rows, fraction: Vec2::new(right, down) }
    }
}

/// Reads the texel in `column` and `row`.
fn texel<const BYTES: usize>(
    memory: &mut Observed<impl Memory, impl Observer>,
    texture: TextureRecord,
    column: u32,
    row: u32,
) -> [u8; BYTES] {
    memory.fetch(Unit::Shading, texture.texels.offset(texture.place(column, row) * BYTES as u32))
}

/// The colour of a texture at `uv` for a ray that covers `area` of the square of texture coordinates:
/// bilinear interpolation in one level (SH-2, SH-6).
pub fn sample_colour(
    memory: &mut Observed<impl Memory, impl Observer>,
    texture: TextureRecord,
    uv: Vec2,
    area: f32,
) -> Vec3 {
    const BYTES: usize = TexelFormat::Rgba8.texel_bytes() as usize;
    let texture = texture.level(texture.level_seen(area), TexelFormat::Rgba8);
    let Footprint { columns, rows, fraction } = Footprint::new(texture, uv);
    let [top, bottom] = rows.map(|row| {
        let [left, right] = columns.map(|column| {
            let [red, green, blue, _alpha] = texel::<BYTES>(memory, texture, column, row);
            Vec3::new(f32::from(red), f32::from(green), f32::from(blue)) / 255.0
        });
        left.lerp(right, fraction.x)
    });
    top.lerp(bottom, fraction.y)
}

/// The slope, to the right and upwards, of a bump map whose 1.0 is `height` texels high: between
/// the four texels around `uv`, texels being square (SH-2), in the level that a ray sees which
/// covers `area` of the square of texture coordinates (SH-6).
pub fn sample_slope(
    memory: &mut Observed<impl Memory, impl Observer>,
    map: TextureRecord,
    height: f32,
    uv: Vec2,
    area: f32,
) -> Vec2 {
    const BYTES: usize = TexelFormat::Height8.texel_bytes() as usize;
    let level = map.level_seen(area);
    let map = map.level(level, TexelFormat::Height8);
    // A texel of a level is two wide of the one before.
    let height = height / (1_u64 << level) as f32;
    let Footprint { columns, rows, .. } = Footprint::new(map, uv);
    let [[top_left, top_right], [bottom_left, bottom_right]] = rows.map(|row| {
        columns.map(|column| height * f32::from(texel::<BYTES>(memory, map, column, row)[0]) / 255.0)
    });
    let right = (top_right - top_left + bottom_right - bottom_left) / 2.0;
    let upwards = (top_left - bottom_left + top_right - bottom_right) / 2.0;
    Vec2::new(right, upwards)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vm::HostAddr;

    /// A texture of 2 × 2 texels, black, red; green, blue, and their mean, in a memory of its own:
    /// column by column.
    struct Texels;

    const TEXTURE: TextureRecord = TextureRecord { texels: HostAddr(0), width: 2, height: 2 };

    impl Memory for Texels {
        fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
            assert_eq!(unit, Unit::Shading);
            let texels = [0, 0, 0, 255, 0, 255, 0, 255, 255, 0, 0, 255, 0, 0, 255, 255, 51, 51, 51, 255];
            bytes.copy_from_slice(&texels[addr.0 as usize..][..bytes.len()]);
        }
    }

    #[test]
    fn texels_are_met_at_their_centres_with_v_upwards() {
        let at = |u, v| sample_colour(&mut Observed::by_nobody(Texels), TEXTURE, Vec2::new(u, v), 0.0);
        assert_eq!(at(0.25, 0.75), Vec3::ZERO);
        assert_eq!(at(0.75, 0.75), Vec3::X);
        assert_eq!(at(0.25, 0.25), Vec3::Y);
        assert_eq!(at(0.75, 0.25), Vec3::Z);
        assert_eq!(at(0.5, 0.75), Vec3::X / 2.0);
    }

    #[test]
    fn textures_tile() {
        let at = |u, v| sample_colour(&mut Observed::by_nobody(Texels), TEXTURE, Vec2::new(u, v), 0.0);
        assert_eq!(at(-3.75, 5.75), at(0.25, 0.75));
        // Half way between the last column and the first of the next tile.
        assert_eq!(at(1.0, 0.75), Vec3::X / 2.0);
        // Far off, or nowhere: some texel, no panic.
        at(1e30, -1e30);
        at(f32::NAN, f32::INFINITY);
    }

    #[test]
    fn a_wide_ray_sees_a_coarse_level() {
        let at = |area| sample_colour(&mut Observed::by_nobody(Texels), TEXTURE, Vec2::new(0.75, 0.75), area);
        assert_eq!(at(0.49), Vec3::X);
        for wide in [0.5, 1.0, 1e30, f32::INFINITY, f32::NAN] {
            assert_eq!(at(wide), Vec3::splat(0.2));
        }
    }
}
