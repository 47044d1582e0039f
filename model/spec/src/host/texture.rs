//! Image textures and bump maps (§2: one of each a surface, Stated; layout and filters are
//! Assumed): where their texels lie, how many of them a ray covers, and what it sees.

use super::scene::{Image, TexelFormat};
use crate::vm::{HostAddr, Memory, Observed, Observer, Unit};
use glam::{Vec2, Vec3};

/// Where an image lies and how large it is, as a material names it. Behind its texels lie those of
/// the coarser levels of its mip map, where the scene has them (HI-6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageRecord {
    /// Address of the first texel.
    pub texels: HostAddr,
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Rows of a band of texels.
const BAND: u32 = 4;

/// Images begin at multiples of so many bytes, those of 4 × 4 texels of a texture, so that these lie
/// in one line of the shading cache (HI-2, Assumed).
pub const IMAGE_ALIGNMENT: u32 = BAND * BAND * TexelFormat::Rgba8.texel_bytes();

impl ImageRecord {
    /// Number of the texel in `column` and `row` in the order of their addresses: by bands of four
    /// rows, in a band by columns. So 4 × 4 texels lie together, and what a filter or the next ray
    /// needs is likely in the same line (after Hakura and Gupta 1997).
    #[must_use]
    pub fn place(&self, column: u32, row: u32) -> u32 {
        let above = row / BAND * BAND;
        above * self.width + column * BAND.min(self.height - above) + row - above
    }

    /// Levels of the image's mip map (Williams 1983): each has half the columns and half the rows
    /// of the one before, at least one, and the last has one texel.
    #[must_use]
    pub fn levels(&self) -> u32 {
        self.width.max(self.height).ilog2() + 1
    }

    /// Texels of the first `levels` levels.
    #[must_use]
    pub fn texels_of_levels(&self, levels: u32) -> u64 {
        let length = |side: u32, level: u32| u64::from((side >> level).max(1));
        (0..levels).map(|level| length(self.width, level) * length(self.height, level)).sum()
    }

    /// A level of the mip map, of texels of `format`.
    #[must_use]
    pub fn level(&self, level: u32, format: TexelFormat) -> Self {
        let before = self.texels_of_levels(level) as u32 * format.texel_bytes();
        let [width, height] = [self.width, self.height].map(|side| (side >> level).max(1));
        Self { texels: self.texels.offset(before), width, height }
    }

    /// The level in which a ray that covers `area` of the square of texture coordinates covers about
    /// one texel, from a half to two (SH-6).
    ///
    /// That is the base-4 logarithm of the texels of the finest level that it covers, rounded, which
    /// the exponent of that number tells: exact, and the same on every machine. Not a number counts
    /// as infinite.
    #[must_use]
    pub fn level_seen(&self, area: f32) -> u32 {
        let texels = area * self.width as f32 * self.height as f32;
        let exponent = (texels.to_bits() >> 23 & 0xFF) as i32 - 127;
        ((exponent + 1) >> 1).clamp(0, self.levels() as i32 - 1) as u32
    }
}

impl Image {
    /// The next level of the mip map: means of 2 × 2 texels. None behind one texel.
    #[must_use]
    pub fn halved(&self) -> Option<Self> {
        if self.width.max(self.height) <= 1 {
            return None;
        }
        let [width, height] = [self.width, self.height].map(|side| (side / 2).max(1));
        let bytes = self.format.texel_bytes();
        let mean = |x: u32, y: u32, byte: u32| {
            let texel = |dx: u32, dy: u32| {
                let (x, y) = ((2 * x + dx).min(self.width - 1), (2 * y + dy).min(self.height - 1));
                u32::from(self.texels[((y * self.width + x) * bytes + byte) as usize])
            };
            ((texel(0, 0) + texel(1, 0) + texel(0, 1) + texel(1, 1) + 2) / 4) as u8
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texels = places.flat_map(|(x, y)| (0..bytes).map(move |byte| mean(x, y, byte))).collect();
        Some(Self { width, height, format: self.format, texels })
    }

    /// The texels in the order of their addresses ([`ImageRecord::place`]).
    pub fn in_bands(&self) -> impl Iterator<Item = &[u8]> {
        let texel = self.format.texel_bytes() as usize;
        let row = self.width as usize * texel;
        self.texels.chunks(BAND as usize * row).flat_map(move |band| {
            (0..row)
                .step_by(texel)
                .flat_map(move |column| band.chunks(row).map(move |row| &row[column..column + texel]))
        })
    }
}

/// Where a texture coordinate lies among the texels of an image (SH-2).
///
/// The image tiles; v runs upwards, rows downwards; texels have their values at their centres.
struct Footprint {
    /// Columns and rows of the four texels around the point.
    columns: [u32; 2],
    rows: [u32; 2],
    /// How far the point is from the first of them, to the right and downwards: 0 to 1.
    fraction: Vec2,
}

impl Footprint {
    fn new(image: ImageRecord, uv: Vec2) -> Self {
        let tile = |place: f32, size: u32| {
            // Rounding can give 1.0 itself, which is the first texel of the next tile.
            let texel = (place - place.floor()) * size as f32 - 0.5;
            let below = texel.floor();
            let first = (below as i64).rem_euclid(i64::from(size)) as u32;
            ([first, (first + 1) % size], texel - below)
        };
        let (columns, right) = tile(uv.x, image.width);
        let (rows, down) = tile(1.0 - uv.y, image.height);
        Self { columns, rows, fraction: Vec2::new(right, down) }
    }
}

/// Reads the texel in `column` and `row`.
fn texel<const BYTES: usize>(
    memory: &mut Observed<impl Memory, impl Observer>,
    image: ImageRecord,
    column: u32,
    row: u32,
) -> [u8; BYTES] {
    memory.fetch(Unit::Shading, image.texels.offset(image.place(column, row) * BYTES as u32))
}

/// The colour of a texture at `uv` for a ray that covers `area` of the square of texture coordinates:
/// bilinear interpolation in one level (SH-2, SH-6).
pub fn sample_colour(
    memory: &mut Observed<impl Memory, impl Observer>,
    image: ImageRecord,
    uv: Vec2,
    area: f32,
) -> Vec3 {
    const BYTES: usize = TexelFormat::Rgba8.texel_bytes() as usize;
    let image = image.level(image.level_seen(area), TexelFormat::Rgba8);
    let Footprint { columns, rows, fraction } = Footprint::new(image, uv);
    let [top, bottom] = rows.map(|row| {
        let [left, right] = columns.map(|column| {
            let [red, green, blue, _alpha] = texel::<BYTES>(memory, image, column, row);
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
    map: ImageRecord,
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

    /// An image of 2 × 2 texels, black, red; green, blue, and their mean, in a memory of its own:
    /// column by column.
    struct Texels;

    const IMAGE: ImageRecord = ImageRecord { texels: HostAddr(0), width: 2, height: 2 };

    impl Memory for Texels {
        fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
            assert_eq!(unit, Unit::Shading);
            let texels = [0, 0, 0, 255, 0, 255, 0, 255, 255, 0, 0, 255, 0, 0, 255, 255, 51, 51, 51, 255];
            bytes.copy_from_slice(&texels[addr.0 as usize..][..bytes.len()]);
        }
    }

    #[test]
    fn texels_are_met_at_their_centres_with_v_upwards() {
        let at = |u, v| sample_colour(&mut Observed::by_nobody(Texels), IMAGE, Vec2::new(u, v), 0.0);
        assert_eq!(at(0.25, 0.75), Vec3::ZERO);
        assert_eq!(at(0.75, 0.75), Vec3::X);
        assert_eq!(at(0.25, 0.25), Vec3::Y);
        assert_eq!(at(0.75, 0.25), Vec3::Z);
        assert_eq!(at(0.5, 0.75), Vec3::X / 2.0);
    }

    #[test]
    fn images_tile() {
        let at = |u, v| sample_colour(&mut Observed::by_nobody(Texels), IMAGE, Vec2::new(u, v), 0.0);
        assert_eq!(at(-3.75, 5.75), at(0.25, 0.75));
        // Half way between the last column and the first of the next tile.
        assert_eq!(at(1.0, 0.75), Vec3::X / 2.0);
        // Far off, or nowhere: some texel, no panic.
        at(1e30, -1e30);
        at(f32::NAN, f32::INFINITY);
    }

    #[test]
    fn a_wide_ray_sees_a_coarse_level() {
        let at = |area| sample_colour(&mut Observed::by_nobody(Texels), IMAGE, Vec2::new(0.75, 0.75), area);
        assert_eq!(at(0.49), Vec3::X);
        for wide in [0.5, 1.0, 1e30, f32::INFINITY, f32::NAN] {
            assert_eq!(at(wide), Vec3::splat(0.2));
        }
    }

    #[test]
    fn the_level_is_the_rounded_logarithm_of_the_texels_covered() {
        let image = ImageRecord { texels: HostAddr(0), width: 256, height: 64 };
        assert_eq!(image.levels(), 9);
        for (texels, level) in
            [(0.0, 0), (1e-40, 0), (1.0, 0), (1.99, 0), (2.0, 1), (7.99, 1), (8.0, 2), (1e30, 8)]
        {
            assert_eq!(image.level_seen(texels / (256.0 * 64.0)), level, "{texels}");
        }
    }

    #[test]
    fn levels_lie_one_behind_the_other() {
        let image = ImageRecord { texels: HostAddr(100), width: 5, height: 3 };
        let level = |level| {
            let ImageRecord { texels, width, height } = image.level(level, TexelFormat::Rgba8);
            (texels.0, width, height)
        };
        assert_eq!([0, 1, 2].map(level), [(100, 5, 3), (160, 2, 1), (168, 1, 1)]);
        assert_eq!((image.levels(), image.texels_of_levels(3)), (3, 18));
    }

    #[test]
    fn a_coarser_level_has_the_means_of_the_finer_one() {
        let image =
            Image { width: 3, height: 2, format: TexelFormat::Height8, texels: vec![0, 10, 99, 20, 31, 99] };
        let half = image.halved().expect("six texels");
        assert_eq!((half.width, half.height, &half.texels[..]), (1, 1, &[15][..]));
        assert_eq!(half.halved(), None);
    }

    #[test]
    fn neighbouring_texels_lie_together() {
        let image = ImageRecord { texels: HostAddr(0), width: 8, height: 6 };
        let places = |columns: std::ops::Range<u32>, rows: std::ops::Range<u32>| -> Vec<u32> {
            let mut places: Vec<u32> =
                rows.flat_map(|row| columns.clone().map(move |column| image.place(column, row))).collect();
            places.sort_unstable();
            places
        };
        assert_eq!(places(0..8, 0..6), (0..48).collect::<Vec<_>>(), "each texel has a place of its own");
        assert_eq!(places(4..8, 0..4), (16..32).collect::<Vec<_>>());
        assert_eq!(places(0..4, 4..6), (32..40).collect::<Vec<_>>(), "the last band has two rows");
    }
}
