//! Triangles in host memory: 36 bytes, whose meaning depends on the chip's triangle test (HI-3).

use super::tree::Axis;
use glam::Vec3;

/// Bytes of a triangle (Derived: 144 KB of cache are 4096 of them).
pub const TRIANGLE_BYTES: u32 = 36;

/// The triangle test of the chip (IS-3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Kernel {
    /// Möller and Trumbore 1997, on the three corners.
    #[default]
    MollerTrumbore,
    /// Wald's projection test (Wald 2004, §7.1), on a precomputed triangle.
    Wald,
    /// By Plücker coordinates, on the three corners.
    Plucker,
    /// Woop, Benthin and Wald 2013, on the three corners.
    Watertight,
    /// Exact, on the three corners.
    Adaptive,
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::MollerTrumbore, Self::Wald, Self::Plucker, Self::Watertight, Self::Adaptive];

    /// What the driver stores of a triangle for this test.
    pub fn record(self, corners: &[Vec3; 3]) -> TriangleRecord {
        match self {
            Self::Wald => {
                let Projection { axis, words } = Projection::new(corners);
                TriangleRecord { words: words.map(|word| word as f32), tag: axis as u32 }
            }
            _ => TriangleRecord { words: std::array::from_fn(|word| corners[word / 3][word % 3]), tag: 0 },
        }
    }
}

/// Which triangles a ray hits at an edge or a vertex that several of them have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Edges {
    /// All of them: an edge belongs to both triangles.
    #[default]
    Shared,
    /// Those that the ray hits once it is moved by (ε, ε², ε³), where ε > 0 is less than any number that
    /// differences of coordinates make (simulation of simplicity: Edelsbrunner and Mücke 1990). The moved
    /// ray meets no edge and no vertex, unless it is parallel to the triangle: so of the triangles
    /// around an edge or a vertex it hits exactly one where they lie around the ray, each on a side of its own,
    /// and an even number at a silhouette edge. The distance is that of the ray itself.
    ///
    /// A weight is linear in the place of the ray, so that the sign of a weight of 0 is that of the
    /// first of its slopes along x, y and z that is not 0. That of the edge from `P` to `Q` has the
    /// slopes `d × (Q - P)`: seen from the other triangle, which has the edge from `Q` to `P`, all of
    /// them have the other sign. Where all are 0 the edge is parallel to the ray, and the triangle is
    /// a miss.
    Owned,
}

/// A triangle as the chip reads it: nine numbers from its own bytes, and two bits from the list entry
/// that names it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleRecord {
    /// The three corners; or, for [`Kernel::Wald`], the words of a [`Projection`].
    pub words: [f32; 9],
    /// 0; or, for [`Kernel::Wald`], the axis of the [`Projection`], which has no room in the 36 bytes.
    pub tag: u32,
}

impl TriangleRecord {
    /// Reads a triangle, of whose list entry `tag` are the two lowest bits.
    pub fn decode(bytes: [u8; TRIANGLE_BYTES as usize], tag: u32) -> Self {
        let (words, _) = bytes.as_chunks();
        Self { words: std::array::from_fn(|word| f32::from_le_bytes(words[word])), tag }
    }

    /// The triangle's own bytes, which [`TriangleRecord::decode`] reads.
    pub fn encode(&self) -> [u8; TRIANGLE_BYTES as usize] {
        let bytes = self.words.map(f32::to_le_bytes);
        std::array::from_fn(|byte| bytes[byte / 4][byte % 4])
    }

    /// The corners, of a record that holds them.
    pub fn corners(&self) -> [Vec3; 3] {
        std::array::from_fn(|corner| Vec3::from_slice(&self.words[3 * corner..]))
    }
}

/// A triangle for Wald's projection test, as the driver computes it: its plane, scaled so that the
/// normal's largest component is 1 and need not be stored, and two lines in the plane of projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The axis `k` along which the triangle is projected.
    pub axis: Axis,
    /// With `p`, `q` the axes after `k`: the plane is `x_k + w0 x_p + w1 x_q = w2`; the barycentric
    /// weights of the second and the third corner are `w3 x_p + w4 x_q + w5` and
    /// `w6 x_p + w7 x_q + w8`.
    pub words: [f64; 9],
}

impl Projection {
    /// The projection of a triangle along the axis of its normal's largest component, of several the
    /// first. A triangle without area has words that are NaN or infinite.
    pub fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (to_b, to_c) = (b - a, c - a);
        let normal = to_b.cross(to_c);
        let axis = Axis::of_greatest(normal.abs().to_array());
        let (k, p, q) = (axis as usize, (axis as usize + 1) % 3, (axis as usize + 2) % 3);
        // The area in projection is the normal's component along the axis.
        let area = normal[k];
        let plane = normal / area;
        let words = [
            plane[p],
            plane[q],
            a.dot(plane),
            to_c[q] / area,
            -to_c[p] / area,
            (a[q] * to_c[p] - a[p] * to_c[q]) / area,
            -to_b[q] / area,
            to_b[p] / area,
            (a[p] * to_b[q] - a[q] * to_b[p]) / area,
        ];
        Self { axis, words }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::new(1.0, 2.0, 5.0), Vec3::new(4.0, 2.5, 6.0), Vec3::new(2.0, 5.0, 4.0)];

    #[test]
    fn triangles_read_as_written() {
        for kernel in Kernel::ALL {
            let record = kernel.record(&CORNERS);
            assert_eq!(TriangleRecord::decode(record.encode(), record.tag), record, "{kernel:?}");
        }
        assert_eq!(Kernel::Adaptive.record(&CORNERS).corners(), CORNERS);
    }

    #[test]
    fn corners_lie_in_the_plane_and_have_a_weight_of_one() {
        let Projection { axis, words: w } = Projection::new(&CORNERS);
        let k = axis as usize;
        for (corner, weights) in CORNERS.iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            let [z, x, y] = [0, 1, 2].map(|next| f64::from(corner[(k + next) % 3]));
            assert!((z + w[0] * x + w[1] * y - w[2]).abs() < 1e-12);
            let found = [w[3] * x + w[4] * y + w[5], w[6] * x + w[7] * y + w[8]];
            assert!(found.iter().zip(weights).all(|(found, weight)| (found - weight).abs() < 1e-12));
        }
    }
}
