//! Theorems of triangles as bytes, and of the projection that Wald's test stores (HI-3).

use super::PLANES;
use crate::draw::WORDS;
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use glam::Vec3;
use saarcor_model::host::{Axis, Kernel, Projection, TRIANGLE_BYTES, Triangle, TriangleRecord};

/// A corner on a small grid.
fn corner(s: &mut impl Source, small: [&'static [u32]; 3]) -> [i32; 3] {
    let mut corner = [0; 3];
    for axis in 0..3 {
        corner[axis] = s.value("coordinate + 2", 0..=8, small[axis]) as i32 - 2;
    }
    corner
}

theorems! {
    /// A triangle is without area exactly if its corners lie on one line, however small or large it is.
    #["HI-4", not_for_kani "it is arithmetic in floating point", covers ["on a line", "with an area", "among the least numbers", "among the greatest numbers"]]
    fn without_area_are_corners_on_a_line(s) {
        let axes: [&'static [u32]; 3] = [&WORDS[1..4], &WORDS[2..4], &WORDS[2..4]];
        let corners = [corner(s, axes), corner(s, axes), corner(s, axes)];
        let [b, c] = [1, 2].map(|at| -> [i32; 3] { std::array::from_fn(|axis| corners[at][axis] - corners[0][axis]) });
        let on_a_line = (0..3).all(|axis| {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            b[i] * c[j] == b[j] * c[i]
        });
        let exponent = s.value("exponent + 149", 0..=273, &[0, 60, 75, 100, 149, 212, 273_u16]);
        let unit = 2.0_f64.powi(i32::from(exponent) - 149);
        let corners = corners.map(|corner| Vec3::from(corner.map(|x| (f64::from(x) * unit) as f32)));
        cover!(s, "on a line", on_a_line);
        cover!(s, "with an area", !on_a_line);
        cover!(s, "among the least numbers", exponent == 0);
        cover!(s, "among the greatest numbers", exponent > 250);
        check_eq!(Triangle { corners, material: 0 }.is_degenerate(), on_a_line, "{corners:?}");
    }

    /// A triangle's 36 bytes are its nine words, each the lowest byte first, and every bit of them is read
    /// as it was written, together with the two bits of the list entry.
    #["HI-3", unwind 37, covers ["a word that is NaN", "minus zero", "tagged"]]
    fn triangle_is_read_as_written(s) {
        let mut words = [0; 9];
        // In the small scope one word differs from the others.
        let at = s.value("a word", 0..=8, &WORDS[..9]) as usize;
        let other = s.value("bits of the others", 0..=u32::MAX, &PLANES);
        for word in 0..9 {
            words[word] = if word == at { s.value("bits of that word", 0..=u32::MAX, &PLANES) } else { other };
        }
        let tag = s.value("tag", 0..=3, &WORDS[..4]);
        cover!(s, "a word that is NaN", f32::from_bits(words[at]).is_nan());
        cover!(s, "minus zero", words[at] == 1 << 31);
        cover!(s, "tagged", tag > 0);
        let bytes = TriangleRecord { words: words.map(f32::from_bits), tag }.encode();
        let bytes: [u8; TRIANGLE_BYTES as usize] = bytes;
        for word in 0..9 {
            let stored = [bytes[4 * word], bytes[4 * word + 1], bytes[4 * word + 2], bytes[4 * word + 3]];
            check_eq!(u32::from_le_bytes(stored), words[word], "word {word}");
        }
        let read = TriangleRecord::decode(bytes, tag);
        for word in 0..9 {
            check_eq!(read.words[word].to_bits(), words[word], "word {word}");
        }
        check_eq!(read.tag, tag, "the tag");
    }

    /// The driver stores the corners themselves, x, y and z of one after another, for every test but Wald's.
    #["HI-3", unwind 10, covers ["a corner beside the others"]]
    fn corners_are_stored_one_after_another(s) {
        let kernel = match s.value("test", 0..=3, &WORDS[..4]) {
            0 => Kernel::MollerTrumbore,
            1 => Kernel::Plucker,
            2 => Kernel::Watertight,
            _ => Kernel::Adaptive,
        };
        let at = s.value("a coordinate", 0..=8, &WORDS[..9]) as usize;
        let bits = s.value("its bits", 0..=u32::MAX, &PLANES);
        let mut corners = [[1.0_f32; 3]; 3];
        corners[at / 3][at % 3] = f32::from_bits(bits);
        cover!(s, "a corner beside the others", bits != 1.0_f32.to_bits());
        let record = kernel.record(&[corners[0].into(), corners[1].into(), corners[2].into()]);
        let again = record.corners();
        for word in 0..9 {
            let expected = if word == at { bits } else { 1.0_f32.to_bits() };
            check_eq!(record.words[word].to_bits(), expected, "word {word} for {kernel:?}");
            check_eq!(again[word / 3][word % 3].to_bits(), expected, "word {word} as a coordinate");
        }
        check_eq!(record.tag, 0, "the tag");
    }

    /// Wald's test projects along the axis of the normal's largest component, of several the first; all
    /// three corners lie in the plane that is stored, and the weights that are stored are 1 at their own
    /// corner and 0 at the two others.
    #[
        "HI-3", not_for_kani "it divides in floating point",
        covers ["x", "y", "z", "x before y", "x before z", "y before z", "all three alike"]
    ]
    fn projection_is_the_triangle(s) {
        let few: &'static [u32] = &WORDS[1..4];
        let a = corner(s, [&WORDS[2..4], &WORDS[2..3], &WORDS[1..3]]);
        let b = corner(s, [few, few, few]);
        let c = corner(s, [few, few, few]);
        let edge = |end: [i32; 3], axis: usize| end[axis] - a[axis];
        let normal = [0, 1, 2].map(|axis| {
            let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
            edge(b, p) * edge(c, q) - edge(b, q) * edge(c, p)
        });
        let magnitudes = normal.map(i32::unsigned_abs);
        let [x, y, z] = magnitudes;
        let largest = x.max(y).max(z);
        // By a power of two nothing is rounded.
        assume!(largest.is_power_of_two());
        let axis = if x == largest { 0 } else if y == largest { 1 } else { 2 };
        cover!(s, "x", axis == 0);
        cover!(s, "y", axis == 1);
        cover!(s, "z", axis == 2);
        cover!(s, "x before y", x == y && x > z);
        cover!(s, "x before z", x == z && x > y);
        cover!(s, "y before z", y == z && y > x);
        cover!(s, "all three alike", x == y && y == z);
        let corners = [a, b, c].map(|corner| corner.map(|number| number as f32));
        let found = Projection::new(&corners.map(Into::into));
        check_eq!(found.axis, Axis::ALL[axis], "{corners:?}");
        let w = found.words;
        for (number, corner) in corners.iter().enumerate() {
            let [k, p, q] = [0, 1, 2].map(|next| f64::from(corner[(axis + next) % 3]));
            check_eq!(k + w[0] * p + w[1] * q, w[2], "corner {number} of {corners:?}");
            let weights = [w[3] * p + w[4] * q + w[5], w[6] * p + w[7] * q + w[8]];
            check_eq!(weights, [f64::from(number == 1), f64::from(number == 2)], "corner {number} of {corners:?}");
        }
        // What the chip reads are these words rounded once, and the axis beside them.
        let record = Kernel::Wald.record(&corners.map(Into::into));
        check!(record.words == w.map(|word| word as f32) && record.tag == axis as u32, "{record:?} of {found:?}");
    }
}
