//! Theorems of the places of texels (HI-2, HI-6).
//!
//! Kani has textures of up to 16 texels a side, since it takes long over products.

use crate::draw::WORDS;
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::host::{TEXTURE_ALIGNMENT, TexelFormat, Texture, TextureRecord};
use saarcor_model::vm::HostAddr;

/// Most texels a side.
const MOST: u32 = if cfg!(kani) { 16 } else { 1 << 16 };

/// Texels a side around the least, the greatest, and the ends of bands.
static SIDES: [u32; 12] = [1, 2, 3, 4, 5, 7, 8, 0xfffc, 0xfffd, 0xfffe, 0xffff, 0x1_0000];

/// Texels a side of mip maps of few and of many levels.
static LEVELS: [u32; 10] = [1, 2, 3, 4, 5, 7, 8, 9, 0xffff, 0x1_0000];

/// Areas by their bits: numbers around powers of two, denormals, infinity and NaN.
static AREAS: [u32; 16] = [
    0,
    1,
    0x007f_ffff,
    0x0080_0000,
    0x2f7f_ffff,
    0x2f80_0000,
    0x3dff_ffff,
    0x3e00_0000,
    0x3e80_0000,
    0x3f00_0000,
    0x3f7f_ffff,
    0x3f80_0000,
    0x4000_0000,
    0x7f7f_ffff,
    0x7f80_0000,
    0x7fc0_0000,
];

/// An image whose texels all have bytes of their own.
fn image(s: &mut impl Source) -> Texture {
    let (width, height) = (s.value("width", 1..=20, &WORDS[1..8]), s.value("height", 1..=20, &WORDS[1..11]));
    let bump = s.value("format (texture, bump map)", 0..=1, &WORDS[..2]) == 1;
    let format = if bump { TexelFormat::Height8 } else { TexelFormat::Rgba8 };
    let bytes = width * height * if bump { 1 } else { 4 };
    let seed = s.value("seed", 0..=255, &WORDS[..3]);
    // Steps of 167 visit all values of a byte.
    let texels = (0..bytes).map(|byte| (byte.wrapping_mul(167).wrapping_add(seed * 89)) as u8).collect();
    Texture { width, height, format, texels }
}

theorems! {
    /// The first texel of a texture lies first, and each other one behind the one above it in its band of
    /// four rows; the top of a column lies behind the bottom of the column before, and a band behind the last
    /// texel of the band before: so for textures of one texel, of 65536 a side, and of all sizes between.
    #[
        "HI-2", unwind 6,
        covers ["in a column", "from column to column", "from band to band", "in a last band of one row", "the last texel"]
    ]
    fn texels_follow_one_another(s) {
        let most = if cfg!(kani) { 256 } else { 0x1_0000 };
        let (width, height) = (s.value("width", 1..=most, &SIDES), s.value("height", 1..=most, &SIDES));
        let texture = TextureRecord { texels: HostAddr(0), width, height };
        // The remainder keeps random texels inside. Small scope: around the first ones and the last.
        let near = |place: u32, side: u32| match place {
            _ if cfg!(kani) => place,
            6..12 => (side - 1).saturating_sub(11 - place),
            _ => place % side,
        };
        let column = near(s.value("column", 0..=most - 1, &WORDS[..12]), width);
        let row = near(s.value("row", 0..=most - 1, &WORDS[..12]), height);
        assume!(column < width && row < height);
        let (top, bottom) = (row & !3, if row | 3 < height { row | 3 } else { height - 1 });
        let last_column = column + 1 == width;
        cover!(s, "in a column", row < bottom);
        cover!(s, "from column to column", row == bottom && !last_column);
        cover!(s, "from band to band", row == bottom && last_column && bottom + 1 < height);
        cover!(s, "in a last band of one row", top == bottom && bottom + 1 == height);
        cover!(s, "the last texel", last_column && row + 1 == height);
        let place = texture.place(column, row);
        check_eq!(texture.place(0, 0), 0, "the first texel of {texture:?}");
        if row < bottom {
            check_eq!(texture.place(column, row + 1), place + 1, "below {column}, {row} of {texture:?}");
        } else if !last_column {
            check_eq!(texture.place(column + 1, top), place + 1, "behind column {column} of {texture:?}");
        } else if bottom + 1 < height {
            check_eq!(texture.place(0, bottom + 1), place + 1, "behind band {top} of {texture:?}");
        } else {
            check_eq!(u64::from(place) + 1, u64::from(width) * u64::from(height), "the last texel of {texture:?}");
        }
    }

    /// The driver writes each texel of an image to the place where the chip looks for it.
    #["HI-2", not_for_kani "it allocates", covers ["one texel", "a band of its own", "a bump map"]]
    fn texels_are_written_where_they_are_read(s) {
        let image = image(s);
        let Texture { width, height, format, .. } = image;
        cover!(s, "one texel", width == 1 && height == 1);
        cover!(s, "a band of its own", height % 4 == 1 && height > 4);
        cover!(s, "a bump map", format == TexelFormat::Height8);
        let record = TextureRecord { texels: HostAddr(0), width, height };
        let bytes = format.texel_bytes() as usize;
        check_eq!(bytes, if format == TexelFormat::Height8 { 1 } else { 4 }, "bytes of a texel");
        check_eq!(TEXTURE_ALIGNMENT, 64, "where images begin");
        let written: Vec<&[u8]> = image.in_bands().collect();
        check_eq!(written.len() as u32, width * height, "texels of {width} x {height}");
        for row in 0..height {
            for column in 0..width {
                let texel = &image.texels[(row * width + column) as usize * bytes..][..bytes];
                check_eq!(written[record.place(column, row) as usize], texel, "texel {column}, {row} of {width} x {height}");
            }
        }
    }

    /// Each byte of a texel of the coarser level is the mean of those of 2 x 2 texels, rounded to the nearest
    /// and up from the middle; where there is one row or one column, of that one twice; one texel has no
    /// coarser level.
    #["HI-6", not_for_kani "it allocates", covers ["one texel", "one row", "one column", "odd sides", "rounded up"]]
    fn coarser_level_has_the_means(s) {
        let image = image(s);
        let Texture { width, height, format, .. } = image;
        let bytes = format.texel_bytes();
        cover!(s, "one texel", width == 1 && height == 1);
        cover!(s, "one row", height == 1 && width > 1);
        cover!(s, "one column", width == 1 && height > 1);
        cover!(s, "odd sides", width % 2 == 1 && height % 2 == 1 && width > 1 && height > 1);
        let Some(half) = image.halved() else {
            check!(width == 1 && height == 1, "{width} x {height} texels have no coarser level");
            return Ok(());
        };
        let half_of = |side: u32| if side == 1 { 1 } else { side / 2 };
        check_eq!((half.width, half.height, half.format), (half_of(width), half_of(height), format), "half of {width} x {height}");
        check_eq!(half.texels.len() as u32, half.width * half.height * bytes, "bytes of half of {width} x {height}");
        let mut up = false;
        for row in 0..half.height {
            for column in 0..half.width {
                for byte in 0..bytes {
                    let texel = |x: u32, y: u32| u32::from(image.texels[((y * width + x) * bytes + byte) as usize]);
                    let right = if width == 1 { 0 } else { 2 * column + 1 };
                    let below = if height == 1 { 0 } else { 2 * row + 1 };
                    let sum = texel(2 * column, 2 * row) + texel(right, 2 * row) + texel(2 * column, below) + texel(right, below);
                    up |= sum % 4 == 2;
                    let found = u32::from(half.texels[((row * half.width + column) * bytes + byte) as usize]);
                    // The nearest, of two the greater: 4 m - 2 <= sum < 4 m + 2.
                    check!(sum < 4 * found + 2 && 4 * found <= sum + 2, "{found} for a sum of {sum}: {column}, {row} of half of {width} x {height}");
                }
            }
        }
        cover!(s, "rounded up", up);
    }

    /// A mip map has as many levels as its larger side can be halved, and one more; a ray that covers n texels
    /// of the finest level sees level l where 2^(2 l - 1) <= n < 2^(2 l + 1), or the nearest level that there is.
    #[
        "SH-6", not_for_kani "it multiplies in floating point",
        covers ["the finest level", "between", "the coarsest level", "NaN", "one texel"]
    ]
    fn level_seen_is_the_rounded_logarithm(s) {
        let (width, height) = (s.value("width", 1..=0x1_0000, &SIDES), s.value("height", 1..=0x1_0000, &SIDES));
        let texture = TextureRecord { texels: HostAddr(0), width, height };
        let area = f32::from_bits(s.value("bits of the area", 0..=0x7fff_ffff, &AREAS));
        let larger = if width > height { width } else { height };
        let mut levels = 1;
        while larger >> levels > 0 {
            levels += 1;
        }
        check_eq!(texture.levels(), levels, "levels of {texture:?}");
        let texels = f64::from(area * width as f32 * height as f32);
        let mut level = 0;
        while level + 1 < levels && (texels.is_nan() || texels >= 2.0 * 4.0_f64.powi(level as i32)) {
            level += 1;
        }
        cover!(s, "the finest level", level == 0 && levels > 1);
        cover!(s, "between", level > 0 && level + 1 < levels);
        cover!(s, "the coarsest level", level + 1 == levels && levels > 1);
        cover!(s, "NaN", texels.is_nan());
        cover!(s, "one texel", levels == 1);
        check_eq!(texture.level_seen(area), level, "{texels} texels of {texture:?}");
    }

    /// A level of a mip map begins where the one before it ends, and has half its columns and half its
    /// rows, but at least one of each.
    #["HI-6", unwind 20, covers ["one column left", "halves of odd sides", "bump map"]]
    fn levels_follow_one_another(s) {
        let (width, height) = (s.value("width", 1..=MOST, &LEVELS), s.value("height", 1..=MOST, &LEVELS));
        let texture = TextureRecord { texels: HostAddr(0), width, height };
        assume!(u64::from(width) * u64::from(height) <= 1 << 20);
        let level = s.value("level", 0..=16, &WORDS[..16]);
        assume!(level + 1 < texture.levels());
        let bump = s.value("format (texture, bump map)", 0..=1, &WORDS[..2]) == 1;
        let (format, bytes) = if bump { (TexelFormat::Height8, 1) } else { (TexelFormat::Rgba8, 4) };
        let (this, next) = (texture.level(level, format), texture.level(level + 1, format));
        cover!(s, "one column left", this.width == 1);
        cover!(s, "halves of odd sides", this.width % 2 == 1 && this.height % 2 == 1 && this.width > 1 && this.height > 1);
        cover!(s, "bump map", bump);
        let half = |side: u32| if side > 1 { side / 2 } else { 1 };
        check_eq!((next.width, next.height), (half(this.width), half(this.height)), "level {level} of {texture:?}");
        check_eq!(next.texels.0, this.texels.0 + bytes * this.width * this.height, "level {level} of {texture:?}");
    }
}
