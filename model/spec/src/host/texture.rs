//! Image textures and bump maps (§2: one of each a surface, Stated; layout and filters are
//! Assumed): where their texels lie, how many of them a ray covers, and what it sees.

use super::scene::{TexelFormat, Texture};
use crate::vm::HostAddr;

/// Where a texture lies and how large it is, as a material names it. Behind its texels lie those of
/// the coarser levels of its mip map, where the scene has them (HI-6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureRecord {
    /// Address of the first texel.
    pub texels: HostAddr,
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Rows of a band of texels.
const BAND: u32 = 4;

/// Textures begin at multiples of so many bytes, those of 4 × 4 texels of a texture, so that these lie
/// in one line of the shading cache (HI-2, Assumed).
pub const TEXTURE_ALIGNMENT: u32 = BAND * BAND * TexelFormat::Rgba8.texel_bytes();

impl TextureRecord {
    /// Number of the texel in `column` and `row` in the order of their addresses: by bands of four
    /// rows, in a band by columns. So 4 × 4 texels lie together, and what a filter or the next ray
    /// needs is likely in the same line (after Hakura and Gupta 1997).
    pub fn place(&self, column: u32, row: u32) -> u32 {
        let above = row / BAND * BAND;
        above * self.width + column * BAND.min(self.height - above) + (row - above)
    }

    /// Levels of the texture's mip map (Williams 1983): each has half the columns and half the rows
    /// of the one before, at least one, and the last has one texel.
    pub fn levels(&self) -> u32 {
        self.width.max(self.height).ilog2() + 1
    }

    /// Texels of the first `levels` levels.
    pub fn texels_of_levels(&self, levels: u32) -> u64 {
        let length = |side: u32, level: u32| u64::from((side >> level).max(1));
        (0..levels).map(|level| length(self.width, level) * length(self.height, level)).sum()
    }

    /// A level of the mip map, of texels of `format`.
    pub fn level(&self, level: u32, format: TexelFormat) -> Self {
        let before = self.texels_of_levels(level) as u32 * format.texel_bytes();
        let [width, height] = [self.width, self.height].map(|side| (side >> level).max(1));
        Self { texels: self.texels.offset(before), width, height }
    }

    /// The level in which a ray that covers `area` of the square of texture coordinates covers about
    /// one texel, from a half to two (SH-6).
    ///
    /// That is the rounded base-4 logarithm of the number of texels of the finest level that it covers.
    /// The exponent of that number gives it exactly, and the same on every machine. NaN counts as
    /// infinite.
    pub fn level_seen(&self, area: f32) -> u32 {
        let texels = area * self.width as f32 * self.height as f32;
        let exponent = (texels.to_bits() >> 23 & 0xFF) as i32 - 127;
        ((exponent + 1) >> 1).clamp(0, self.levels() as i32 - 1) as u32
    }
}

impl Texture {
    /// The next level of the mip map: means of 2 × 2 texels. None behind one texel.
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

    /// The texels in the order of their addresses ([`TextureRecord::place`]).
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_is_the_rounded_logarithm_of_the_texels_covered() {
        let texture = TextureRecord { texels: HostAddr(0), width: 256, height: 64 };
        assert_eq!(texture.levels(), 9);
        for (texels, level) in
            [(0.0, 0), (1e-40, 0), (1.0, 0), (1.99, 0), (2.0, 1), (7.99, 1), (8.0, 2), (1e30, 8)]
        {
            assert_eq!(texture.level_seen(texels / (256.0 * 64.0)), level, "{texels}");
        }
    }

    #[test]
    fn levels_lie_one_behind_the_other() {
        let texture = TextureRecord { texels: HostAddr(100), width: 5, height: 3 };
        let level = |level| {
            let TextureRecord { texels, width, height } = texture.level(level, TexelFormat::Rgba8);
            (texels.0, width, height)
        };
        assert_eq!([0, 1, 2].map(level), [(100, 5, 3), (160, 2, 1), (168, 1, 1)]);
        assert_eq!((texture.levels(), texture.texels_of_levels(3)), (3, 18));
    }

    #[test]
    fn a_coarser_level_has_the_means_of_the_finer_one() {
        let texture = Texture {
            width: 3,
            height: 2,
            format: TexelFormat::Height8,
            texels: vec![0, 10, 99, 20, 31, 99],
        };
        let half = texture.halved().expect("six texels");
        assert_eq!((half.width, half.height, &half.texels[..]), (1, 1, &[15][..]));
        assert_eq!(half.halved(), None);
    }

    #[test]
    fn neighbouring_texels_lie_together() {
        let texture = TextureRecord { texels: HostAddr(0), width: 8, height: 6 };
        let places = |columns: std::ops::Range<u32>, rows: std::ops::Range<u32>| -> Vec<u32> {
            let mut places: Vec<u32> =
                rows.flat_map(|row| columns.clone().map(move |column| texture.place(column, row))).collect();
            places.sort_unstable();
            places
        };
        assert_eq!(places(0..8, 0..6), (0..48).collect::<Vec<_>>(), "each texel has a place of its own");
        assert_eq!(places(4..8, 0..4), (16..32).collect::<Vec<_>>());
        assert_eq!(places(0..4, 4..6), (32..40).collect::<Vec<_>>(), "the last band has two rows");
    }
}
