//! The intersection unit: rays against one triangle (§2).

use crate::image::TRIANGLE_BYTES;
use crate::ray::{Hits, Packet, Query};
use glam::Vec3;

/// The triangle test of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Kernel {
    /// Möller and Trumbore 1997, on the three corners.
    #[default]
    MollerTrumbore,
    /// Wald's projection test (Wald 2004, §7.1), on a precomputed triangle.
    Wald,
}

impl Kernel {
    /// The two bits that a list entry carries below the triangle's address: the projection axis
    /// of [`Kernel::Wald`], which has no room in the 36 bytes.
    #[must_use]
    pub fn list_tag(self, corners: &[Vec3; 3]) -> u32 {
        match self {
            Self::MollerTrumbore => 0,
            Self::Wald => ProjectedTriangle::new(corners).axis as u32,
        }
    }
}

/// Where a ray meets a triangle's plane, and whether that is within the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Distance along the ray.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}

impl Candidate {
    /// Edges and vertices belong to the triangle (IS-1). False where a number is NaN or infinite,
    /// as with a ray in the triangle's plane.
    #[inline]
    #[must_use]
    pub fn is_inside(self) -> bool {
        (self.u >= 0.0) & (self.v >= 0.0) & (self.u + self.v <= 1.0)
    }
}

/// Three coordinates or components.
type Triple = [f32; 3];

#[inline(always)]
fn sub(a: Triple, b: Triple) -> Triple {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross(a: Triple, b: Triple) -> Triple {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot(a: Triple, b: Triple) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A triangle prepared for the test of Möller and Trumbore.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeTriangle {
    corner: Triple,
    edges: [Triple; 2],
}

impl EdgeTriangle {
    /// From the three corners.
    #[inline]
    #[must_use]
    pub fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.to_array());
        Self { corner: a, edges: [sub(b, a), sub(c, a)] }
    }

    /// Solves `origin + t · direction = a + u · (b - a) + v · (c - a)` by Cramer's rule.
    #[inline(always)]
    #[must_use]
    pub fn intersect(&self, origin: Triple, direction: Triple) -> Candidate {
        let [to_b, to_c] = self.edges;
        let p = cross(direction, to_c);
        let reciprocal = 1.0 / dot(to_b, p);
        let from_a = sub(origin, self.corner);
        let q = cross(from_a, to_b);
        Candidate {
            t: dot(to_c, q) * reciprocal,
            u: dot(from_a, p) * reciprocal,
            v: dot(direction, q) * reciprocal,
        }
    }
}

/// A triangle prepared for Wald's projection test: its plane, scaled so that the normal's
/// largest component is 1 and need not be stored, and two lines in the plane of projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedTriangle {
    /// The axis `k` along which the triangle is projected: 0, 1 or 2.
    pub axis: usize,
    /// With `p`, `q` the axes after `k`: the plane is `x_k + w0 x_p + w1 x_q = w2`; the barycentric
    /// weights of the second and the third corner are `w3 x_p + w4 x_q + w5` and
    /// `w6 x_p + w7 x_q + w8`.
    pub words: [f32; 9],
}

impl ProjectedTriangle {
    /// From the three corners, in f64: the driver computes it once, the chip never.
    #[must_use]
    pub fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (to_b, to_c) = (b - a, c - a);
        let normal = to_b.cross(to_c);
        let axis = normal.abs().max_position();
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let plane = normal / normal[axis];
        // The area in projection is the normal's component along the axis.
        let area = normal[axis];
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
        Self { axis, words: words.map(|word| word as f32) }
    }

    /// Where the ray meets the plane, then the weights of that point in projection.
    #[inline(always)]
    #[must_use]
    pub fn intersect(&self, origin: Triple, direction: Triple) -> Candidate {
        let (k, p, q) = (self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3);
        let w = &self.words;
        let across = direction[k] + w[0] * direction[p] + w[1] * direction[q];
        let t = (w[2] - origin[k] - w[0] * origin[p] - w[1] * origin[q]) / across;
        let (x, y) = (origin[p] + t * direction[p], origin[q] + t * direction[q]);
        Candidate { t, u: w[3] * x + w[4] * y + w[5], v: w[6] * x + w[7] * y + w[8] }
    }
}

/// A triangle as it comes from memory, prepared for the chip's test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prepared {
    /// For [`Kernel::MollerTrumbore`].
    Edges(EdgeTriangle),
    /// For [`Kernel::Wald`].
    Projected(ProjectedTriangle),
}

impl Prepared {
    /// Reads the triangle's 36 bytes and the two bits of its list entry.
    #[inline]
    #[must_use]
    pub fn decode(kernel: Kernel, list_tag: u32, bytes: [u8; TRIANGLE_BYTES as usize]) -> Self {
        let mut words = [0.0; 9];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = f32::from_le_bytes(*bytes);
        }
        match kernel {
            Kernel::MollerTrumbore => {
                let [a, b, c] = std::array::from_fn(|corner| Vec3::from_slice(&words[3 * corner..]));
                Self::Edges(EdgeTriangle::new(&[a, b, c]))
            }
            // Three is no axis: a list of the driver's never has it.
            Kernel::Wald => Self::Projected(ProjectedTriangle { axis: (list_tag % 3) as usize, words }),
        }
    }

    /// From the three corners.
    #[must_use]
    pub fn new(kernel: Kernel, corners: &[Vec3; 3]) -> Self {
        match kernel {
            Kernel::MollerTrumbore => Self::Edges(EdgeTriangle::new(corners)),
            Kernel::Wald => Self::Projected(ProjectedTriangle::new(corners)),
        }
    }

    /// Where one ray meets the triangle's plane.
    #[must_use]
    pub fn intersect(&self, origin: Vec3, direction: Vec3) -> Candidate {
        let (origin, direction) = (origin.to_array(), direction.to_array());
        match self {
            Self::Edges(triangle) => triangle.intersect(origin, direction),
            Self::Projected(triangle) => triangle.intersect(origin, direction),
        }
    }

    /// One operation of the intersection unit: the rays of `packet` whose cell interval
    /// `enter ≤ leave` is not empty against this triangle, which lies at `addr`.
    #[inline]
    pub fn intersect_packet<const N: usize>(
        &self,
        addr: u32,
        packet: &Packet<N>,
        (enter, leave): (&[f32; N], &[f32; N]),
        query: Query,
        hits: &mut Hits<N>,
    ) {
        // The match stands outside of the loop, so that each loop is one stream of arithmetic.
        match *self {
            Self::Edges(t) => lanes(addr, packet, enter, leave, query, hits, |o, d| t.intersect(o, d)),
            Self::Projected(t) => match t.axis {
                // A constant axis in each arm: the loop then reads whole rows of the packet.
                0 => lanes(addr, packet, enter, leave, query, hits, |o, d| {
                    ProjectedTriangle { axis: 0, ..t }.intersect(o, d)
                }),
                1 => lanes(addr, packet, enter, leave, query, hits, |o, d| {
                    ProjectedTriangle { axis: 1, ..t }.intersect(o, d)
                }),
                _ => lanes(addr, packet, enter, leave, query, hits, |o, d| {
                    ProjectedTriangle { axis: 2, ..t }.intersect(o, d)
                }),
            },
        }
    }
}

/// Applies `test` to each active ray and keeps the nearer hit (IS-2): of two hits at the same
/// distance, the triangle at the lower address, so that the order of the tests does not matter.
#[inline(always)]
fn lanes<const N: usize>(
    addr: u32,
    packet: &Packet<N>,
    enter: &[f32; N],
    leave: &[f32; N],
    query: Query,
    hits: &mut Hits<N>,
    test: impl Fn(Triple, Triple) -> Candidate,
) {
    for lane in 0..N {
        let origin = [packet.origin[0][lane], packet.origin[1][lane], packet.origin[2][lane]];
        let direction = [packet.direction[0][lane], packet.direction[1][lane], packet.direction[2][lane]];
        let found = test(origin, direction);
        let nearer = (found.t < hits.t[lane]) | ((found.t == hits.t[lane]) & (addr < hits.triangle[lane]));
        let accepted = (enter[lane] <= leave[lane])
            & (found.t >= packet.t_min[lane])
            & (found.t < packet.t_max[lane])
            & nearer
            & found.is_inside();
        // A shadow ray needs no more than one hit: nothing is nearer than minus infinity.
        let t = if matches!(query, Query::Any) { f32::NEG_INFINITY } else { found.t };
        hits.t[lane] = if accepted { t } else { hits.t[lane] };
        hits.u[lane] = if accepted { found.u } else { hits.u[lane] };
        hits.v[lane] = if accepted { found.v } else { hits.v[lane] };
        hits.triangle[lane] = if accepted { addr } else { hits.triangle[lane] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const CORNERS: [Vec3; 3] = [Vec3::new(1.0, 2.0, 5.0), Vec3::new(4.0, 2.5, 6.0), Vec3::new(2.0, 5.0, 4.0)];

    fn towards(u: f32, v: f32) -> Vec3 {
        CORNERS[0] * (1.0 - u - v) + CORNERS[1] * u + CORNERS[2] * v
    }

    #[test]
    fn kernels_find_the_point_aimed_at() {
        for kernel in [Kernel::MollerTrumbore, Kernel::Wald] {
            for (u, v) in [(0.25, 0.25), (0.1, 0.7), (0.7, 0.1), (-0.2, 0.5), (0.8, 0.9)] {
                let origin = Vec3::new(0.5, -1.0, 0.25);
                let found = Prepared::new(kernel, &CORNERS).intersect(origin, (towards(u, v) - origin) / 2.0);
                assert_relative_eq!(found.t, 2.0, max_relative = 1e-5);
                assert_relative_eq!(found.u, u, epsilon = 1e-5);
                assert_relative_eq!(found.v, v, epsilon = 1e-5);
                assert_eq!(found.is_inside(), u >= 0.0 && v >= 0.0 && u + v <= 1.0);
            }
        }
    }

    #[test]
    fn rays_in_the_plane_and_nan_are_no_hits() {
        for kernel in [Kernel::MollerTrumbore, Kernel::Wald] {
            let triangle = Prepared::new(kernel, &[Vec3::ZERO, Vec3::X, Vec3::Y]);
            assert!(!triangle.intersect(Vec3::new(-1.0, 0.25, 0.0), Vec3::X).is_inside());
            assert!(!triangle.intersect(Vec3::NAN, Vec3::Z).is_inside());
            assert!(!triangle.intersect(Vec3::NEG_Z, Vec3::ZERO).is_inside());
        }
    }

    /// A packet of two rays along z towards the point (0.25, 0.25, 0), of which the second ends
    /// before it.
    fn packet() -> Packet<2> {
        let ray = crate::ray::Ray {
            origin: Vec3::new(0.25, 0.25, -2.0),
            direction: Vec3::Z,
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        Packet::new([Some(ray), Some(crate::ray::Ray { t_max: 2.0, ..ray })])
    }

    #[test]
    fn range_is_half_open_and_ties_go_to_the_lower_address() {
        let packet = packet();
        let all = (&packet.t_min, &packet.t_max);
        let triangle = Prepared::new(Kernel::MollerTrumbore, &[Vec3::ZERO, Vec3::X, Vec3::Y]);
        let mut hits = Hits::none(&packet);
        for addr in [72, 36, 108] {
            triangle.intersect_packet(addr, &packet, all, Query::Closest, &mut hits);
        }
        assert_eq!((hits.t[0], hits.triangle[0]), (2.0, 36));
        assert!(!hits.is_hit(1));
    }

    #[test]
    fn rays_outside_of_the_cell_are_masked() {
        let packet = packet();
        let mut hits = Hits::none(&packet);
        let triangle = Prepared::new(Kernel::MollerTrumbore, &[Vec3::ZERO, Vec3::X, Vec3::Y]);
        triangle.intersect_packet(36, &packet, (&[1.0; 2], &[0.5; 2]), Query::Closest, &mut hits);
        assert_eq!(hits, Hits::none(&packet));
    }
}
