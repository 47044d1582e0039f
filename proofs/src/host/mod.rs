//! Theorems of what lies in host memory: what a scene needs, its items as bytes, and their addresses.

pub mod features;
pub mod layout;
pub mod list;
pub mod node;
pub mod records;
pub mod texture;
pub mod tree;
pub mod triangle;

/// Bits of split planes: finite ones of all magnitudes, infinities and NaN.
static PLANES: [u32; 10] = [
    0,
    1,
    0x3f80_0000,
    0x7f7f_ffff,
    0x7f80_0000,
    0x7f80_0001,
    0x7fc0_0000,
    0x8000_0000,
    0xff7f_ffff,
    0xff80_0000,
];
