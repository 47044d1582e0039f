//! Theorems of the places of texels (HI-2, HI-6).
//!
//! Kani has textures of up to 16 texels a side, since it takes long over products.

use crate::draw::WORDS;
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::host::{TexelFormat, TextureRecord};
use saarcor_model::vm::HostAddr;

/// Most texels a side.
const MOST: u32 = if cfg!(kani) { 16 } else { 1 << 16 };

/// Any texture. Small scope: up to 9 texels a side, which are two bands of rows and a part of one.
fn texture(s: &mut impl Source) -> TextureRecord {
    let width = s.value("width", 1..=MOST, &WORDS[1..10]);
    let height = s.value("height", 1..=MOST, &WORDS[1..10]);
    TextureRecord { texels: HostAddr(0), width, height }
}

/// Any texel of a texture.
fn texel<S: Source>(s: &mut S, texture: &TextureRecord) -> (u32, u32) {
    // The remainder keeps random texels inside; the small scope has no others.
    let column = s.value("column", 0..=MOST - 1, &WORDS[..9]);
    let row = s.value("row", 0..=MOST - 1, &WORDS[..9]);
    if cfg!(kani) { (column, row) } else { (column % texture.width, row % texture.height) }
}

theorems! {
    /// Each texel has a place of its own among as many places as there are texels.
    #["HI-2", unwind 5, covers ["one band", "two bands", "in the last row alone"]]
    fn texels_have_places_of_their_own(s) {
        let texture = texture(s);
        assume!(u64::from(texture.width) * u64::from(texture.height) <= 1 << 32);
        let (a, b) = (texel(s, &texture), texel(s, &texture));
        assume!(a.0 < texture.width && a.1 < texture.height && b.0 < texture.width && b.1 < texture.height);
        assume!(a != b);
        cover!(s, "one band", a.1 / 4 == b.1 / 4);
        cover!(s, "two bands", a.1 / 4 != b.1 / 4);
        cover!(s, "in the last row alone", texture.height % 4 == 1 && a.1 + 1 == texture.height);
        let [at, other] = [a, b].map(|(column, row)| texture.place(column, row));
        let texels = u64::from(texture.width) * u64::from(texture.height);
        check!(u64::from(at) < texels, "{texture:?}: texel {a:?} at {at} of {texels}");
        check!(at != other, "{texture:?}: texels {a:?} and {b:?} both at {at}");
    }

    /// Four by four texels lie together: a block of a texture whose height is a multiple of four is 16
    /// places in a row, the texels of a column before those of the next.
    #["HI-2", unwind 5, covers ["the first block", "another block"]]
    fn blocks_of_texels_lie_together(s) {
        let (columns, bands) = (s.value("width / 4", 1..=MOST / 4, &WORDS[1..4]), s.value("height / 4", 1..=MOST / 4, &WORDS[1..4]));
        let texture = TextureRecord { texels: HostAddr(0), width: 4 * columns, height: 4 * bands };
        assume!(u64::from(texture.width) * u64::from(texture.height) <= 1 << 32);
        let (column, row) = texel(s, &texture);
        assume!(column < texture.width && row < texture.height);
        cover!(s, "the first block", column < 4 && row < 4);
        cover!(s, "another block", column >= 4 && row >= 4);
        let block = texture.place(column & !3, row & !3);
        check_eq!(block & 15, 0, "{texture:?}: the block of {column}, {row}");
        check_eq!(texture.place(column, row) - block, 4 * (column & 3) + (row & 3), "{texture:?}: {column}, {row} in its block");
    }

    /// A level of a mip map begins where the one before it ends, and has half its columns and half its
    /// rows, but at least one of each.
    #["HI-6", unwind 20, covers ["one column left", "halves of odd sides", "bump map"]]
    fn levels_follow_one_another(s) {
        let texture = texture(s);
        assume!(u64::from(texture.width) * u64::from(texture.height) <= 1 << 20);
        let level = s.value("level", 0..=16, &WORDS[..4]);
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
