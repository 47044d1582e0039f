//! The intersection unit: rays against one triangle (§2).
//!
//! One test a file, each with its rules for contact, triangles without area, rays in the plane, NaN
//! and infinity, and the bound of its error: γ(n) = n·u / (1 - n·u) for n roundings, u the
//! roundoff of the format (Higham 2002, §3.1). Each has one body for all number formats; the chip
//! computes in f32.

mod adaptive;
mod expansion;
mod moller_trumbore;
mod narrow;
mod number;
mod plucker;
mod volumes;
mod wald;
mod watertight;
mod whole;

pub use adaptive::{AdaptiveHit, AdaptiveRay, AdaptiveTriangle};
pub use moller_trumbore::EdgeTriangle;
pub use narrow::{Bf16, F16, F24, Narrow};
pub use number::{Number, Triple};
pub use plucker::PluckerTriangle;
pub use wald::ProjectedTriangle;
pub use watertight::{ShearedRay, WatertightTriangle};

use super::ray::{Hits, KeptTriangle, Packet, Query, Ray};
use crate::host::TRIANGLE_BYTES;
use glam::Vec3;
use std::cmp::Ordering;

/// The triangle test of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Kernel {
    /// Möller and Trumbore 1997, on the three corners: [`EdgeTriangle`].
    #[default]
    MollerTrumbore,
    /// Wald's projection test (Wald 2004, §7.1), on a precomputed triangle: [`ProjectedTriangle`].
    Wald,
    /// By Plücker coordinates, on the three corners: [`PluckerTriangle`].
    Plucker,
    /// Woop, Benthin and Wald 2013, on the three corners: [`WatertightTriangle`].
    Watertight,
    /// Exact where a fast test leaves a doubt, on the three corners: [`AdaptiveTriangle`].
    Adaptive,
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::MollerTrumbore, Self::Wald, Self::Plucker, Self::Watertight, Self::Adaptive];

    /// The two bits that a list entry carries below the triangle's address: the projection axis
    /// of [`Kernel::Wald`], which has no room in the 36 bytes.
    #[must_use]
    pub fn list_tag(self, corners: &[Vec3; 3]) -> u32 {
        match self {
            Self::Wald => ProjectedTriangle::<f32>::new(corners).axis as u32,
            _ => 0,
        }
    }

    /// The nine numbers of a triangle in memory (HI-3): its corners, or its words for
    /// [`Kernel::Wald`].
    #[must_use]
    pub fn record(self, corners: &[Vec3; 3]) -> [f32; 9] {
        match self {
            Self::Wald => ProjectedTriangle::new(corners).words,
            _ => std::array::from_fn(|word| corners[word / 3][word % 3]),
        }
    }
}

/// Where a ray meets a triangle's plane, and whether that is within the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<R = f32> {
    /// Distance along the ray.
    pub t: R,
    /// Barycentric weight of the second corner.
    pub u: R,
    /// Barycentric weight of the third corner.
    pub v: R,
    /// Whether the point belongs to the triangle, by the rule of the test (IS-1).
    pub inside: bool,
}

impl<R: Number> Candidate<R> {
    /// Inside by the weights. NaN and infinity, as with a ray in the triangle's plane, are not.
    #[inline(always)]
    fn within(t: R, u: R, v: R) -> Self {
        Self { t, u, v, inside: (u >= R::ZERO) & (v >= R::ZERO) & (u + v <= R::ONE) }
    }
}

/// Whether a point belongs to the triangle by the signs of the weights of its corners, and their
/// sum: no two signs are opposite, and there is a sum to divide by.
#[inline(always)]
fn same_sign<R: Number>(signs: [i8; 3], sum: R) -> bool {
    let [a, b, c] = signs;
    let opposite = (a * b < 0) | (b * c < 0) | (c * a < 0);
    !opposite & sum.is_finite() & (sum != R::ZERO)
}

/// A triangle test in numbers of the format `R`.
pub trait TriangleTest<R: Number>: Copy {
    /// What is computed once a ray.
    type Ray: Copy;

    /// From the corners.
    fn new(corners: &[Vec3; 3]) -> Self;

    /// From origin and direction.
    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray;

    /// Where the ray meets the triangle's plane.
    fn intersect(&self, ray: &Self::Ray) -> Candidate<R>;
}

/// A triangle as it comes from memory, prepared for the chip's test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prepared {
    /// For [`Kernel::MollerTrumbore`].
    Edges(EdgeTriangle),
    /// For [`Kernel::Wald`].
    Projected(ProjectedTriangle),
    /// For the other tests.
    Other(Robust),
}

/// A triangle prepared for one of the tests that cost more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Robust {
    /// For [`Kernel::Plucker`].
    Plucker(PluckerTriangle),
    /// For [`Kernel::Watertight`].
    Watertight(WatertightTriangle),
    /// For [`Kernel::Adaptive`]: the corners, from which an [`AdaptiveTriangle`] is made once a
    /// packet.
    Adaptive([Vec3; 3]),
}

impl Robust {
    /// [`Prepared::intersect_packet`], in a function of its own: with it, that of the chip's usual
    /// tests would be too large to be inlined into the traversal.
    #[inline(never)]
    fn intersect_packet<const N: usize>(
        &self,
        addr: u32,
        packet: &Packet<N>,
        cell: (&[f32; N], &[f32; N]),
        query: Query,
        hits: &mut Hits<N>,
    ) {
        match self {
            Self::Plucker(triangle) => lanes(addr, packet, cell, query, hits, triangle),
            Self::Watertight(triangle) => lanes(addr, packet, cell, query, hits, triangle),
            Self::Adaptive(corners) => {
                adaptive_lanes(addr, packet, cell, query, hits, &AdaptiveTriangle::new(corners));
            }
        }
    }
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
        if kernel == Kernel::Wald {
            // Three is no axis: a list of the driver's never has it.
            return Self::Projected(ProjectedTriangle { axis: (list_tag % 3) as usize, words });
        }
        Self::new(kernel, &std::array::from_fn(|corner| Vec3::from_slice(&words[3 * corner..])))
    }

    /// From the three corners.
    #[inline]
    #[must_use]
    pub fn new(kernel: Kernel, corners: &[Vec3; 3]) -> Self {
        match kernel {
            Kernel::MollerTrumbore => Self::Edges(EdgeTriangle::new(corners)),
            Kernel::Wald => Self::Projected(ProjectedTriangle::new(corners)),
            Kernel::Plucker => Self::Other(Robust::Plucker(PluckerTriangle::new(corners))),
            Kernel::Watertight => Self::Other(Robust::Watertight(WatertightTriangle::new(corners))),
            Kernel::Adaptive => Self::Other(Robust::Adaptive(*corners)),
        }
    }

    /// Where one ray meets the triangle, if it does within its range.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Candidate> {
        let mut hits = Hits::none(&Packet::new([Some(*ray)]));
        let everywhere = (&[f32::NEG_INFINITY], &[f32::INFINITY]);
        self.intersect_packet(0, &Packet::new([Some(*ray)]), everywhere, Query::Closest, &mut hits);
        hits.is_hit(0).then(|| Candidate { t: hits.t[0], u: hits.u[0], v: hits.v[0], inside: true })
    }

    /// One operation of the intersection unit: the rays of `packet` whose interval `enter ≤ leave`
    /// in the cell is not empty against this triangle, which lies at `addr`.
    #[inline]
    pub fn intersect_packet<const N: usize>(
        &self,
        addr: u32,
        packet: &Packet<N>,
        cell: (&[f32; N], &[f32; N]),
        query: Query,
        hits: &mut Hits<N>,
    ) {
        // The match stands outside of the loop, so that each loop is one stream of arithmetic.
        match *self {
            Self::Edges(t) => lanes(addr, packet, cell, query, hits, &t),
            // A constant axis in each arm: the loop then reads whole rows of the packet.
            Self::Projected(t) => match t.axis {
                0 => lanes(addr, packet, cell, query, hits, &ProjectedTriangle { axis: 0, ..t }),
                1 => lanes(addr, packet, cell, query, hits, &ProjectedTriangle { axis: 1, ..t }),
                _ => lanes(addr, packet, cell, query, hits, &ProjectedTriangle { axis: 2, ..t }),
            },
            Self::Other(triangle) => triangle.intersect_packet(addr, packet, cell, query, hits),
        }
    }
}

/// Applies the test to each active ray and keeps the nearer hit (IS-2): of two hits at the same
/// distance, the triangle at the lower address, so that the order of the tests does not matter.
#[inline(always)]
fn lanes<const N: usize>(
    addr: u32,
    packet: &Packet<N>,
    (enter, leave): (&[f32; N], &[f32; N]),
    query: Query,
    hits: &mut Hits<N>,
    triangle: &impl TriangleTest<f32>,
) {
    for lane in 0..N {
        let origin = [packet.origin[0][lane], packet.origin[1][lane], packet.origin[2][lane]];
        let direction = [packet.direction[0][lane], packet.direction[1][lane], packet.direction[2][lane]];
        let found = intersect(triangle, origin, direction);
        let nearer = (found.t < hits.t[lane]) | ((found.t == hits.t[lane]) & (addr < hits.triangle[lane]));
        let accepted = (enter[lane] <= leave[lane])
            & (found.t >= packet.t_min[lane])
            & (found.t < packet.t_max[lane])
            & nearer
            & found.inside;
        // A shadow ray needs no more than one hit: nothing is nearer than minus infinity.
        let t = if matches!(query, Query::Any) { f32::NEG_INFINITY } else { found.t };
        hits.t[lane] = if accepted { t } else { hits.t[lane] };
        hits.u[lane] = if accepted { found.u } else { hits.u[lane] };
        hits.v[lane] = if accepted { found.v } else { hits.v[lane] };
        hits.triangle[lane] = if accepted { addr } else { hits.triangle[lane] };
    }
}

#[inline(always)]
fn intersect<T: TriangleTest<f32>>(triangle: &T, origin: Triple<f32>, direction: Triple<f32>) -> Candidate {
    triangle.intersect(&T::ray(origin, direction))
}

/// [`lanes`] for the adaptive test, which decides the order of hits exactly: first whom the fast
/// test lets pass, in one stream of arithmetic, then the other rays one by one.
fn adaptive_lanes<const N: usize>(
    addr: u32,
    packet: &Packet<N>,
    (enter, leave): (&[f32; N], &[f32; N]),
    query: Query,
    hits: &mut Hits<N>,
    triangle: &AdaptiveTriangle,
) {
    let mut passes = [false; N];
    for (lane, passes) in passes.iter_mut().enumerate() {
        let ray = AdaptiveRay::new(&packet.ray(lane));
        *passes = triangle.estimate(&ray).is_outside();
    }
    for lane in 0..N {
        let done = matches!(query, Query::Any) & hits.is_hit(lane);
        let active = enter[lane] <= leave[lane];
        if passes[lane] | done | !active {
            continue;
        }
        let ray = packet.ray(lane);
        let Some(found) = triangle.intersect(&AdaptiveRay::new(&ray)) else { continue };
        let nearer = !hits.is_hit(lane)
            || match found.order(&hits.kept[lane].hit(hits.t[lane]), &ray) {
                Ordering::Less => true,
                Ordering::Equal => addr < hits.triangle[lane],
                Ordering::Greater => false,
            };
        if nearer {
            let Candidate { t, u, v, .. } = found.rounded();
            hits.t[lane] = if matches!(query, Query::Any) { f32::NEG_INFINITY } else { t };
            (hits.u[lane], hits.v[lane], hits.triangle[lane]) = (u, v, addr);
            hits.kept[lane] = KeptTriangle::new(&found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const CORNERS: [Vec3; 3] = [Vec3::new(1.0, 2.0, 5.0), Vec3::new(4.0, 2.5, 6.0), Vec3::new(2.0, 5.0, 4.0)];

    fn along_z(origin: Vec3) -> Ray {
        Ray { origin, direction: Vec3::Z, t_min: 0.0, t_max: f32::INFINITY }
    }

    fn towards(u: f32, v: f32) -> Vec3 {
        CORNERS[0] * (1.0 - u - v) + CORNERS[1] * u + CORNERS[2] * v
    }

    #[test]
    fn kernels_find_the_point_aimed_at() {
        for kernel in Kernel::ALL {
            for (u, v) in [(0.25, 0.25), (0.1, 0.7), (0.7, 0.1), (-0.2, 0.5), (0.8, 0.9)] {
                let origin = Vec3::new(0.5, -1.0, 0.25);
                let ray = Ray { direction: (towards(u, v) - origin) / 2.0, ..along_z(origin) };
                let found = Prepared::new(kernel, &CORNERS).intersect(&ray);
                assert_eq!(found.is_some(), u >= 0.0 && v >= 0.0 && u + v <= 1.0);
                if let Some(found) = found {
                    assert_relative_eq!(found.t, 2.0, max_relative = 1e-5);
                    assert_relative_eq!(found.u, u, epsilon = 1e-5);
                    assert_relative_eq!(found.v, v, epsilon = 1e-5);
                }
            }
        }
    }

    #[test]
    fn rays_in_the_plane_and_nan_are_no_hits() {
        let in_plane = Ray { direction: Vec3::X, ..along_z(Vec3::new(-1.0, 0.25, 0.0)) };
        let still = Ray { direction: Vec3::ZERO, ..along_z(Vec3::NEG_Z) };
        for kernel in Kernel::ALL {
            let triangle = Prepared::new(kernel, &[Vec3::ZERO, Vec3::X, Vec3::Y]);
            for ray in [in_plane, along_z(Vec3::NAN), still] {
                assert_eq!(triangle.intersect(&ray), None, "{kernel:?}");
            }
        }
    }

    /// A packet of two rays along z towards the point (0.25, 0.25, 0), of which the second ends
    /// before it.
    fn packet() -> Packet<2> {
        let ray = along_z(Vec3::new(0.25, 0.25, -2.0));
        Packet::new([Some(ray), Some(Ray { t_max: 2.0, ..ray })])
    }

    #[test]
    fn range_is_half_open_and_ties_go_to_the_lower_address() {
        let packet = packet();
        let all = (&packet.t_min, &packet.t_max);
        for kernel in Kernel::ALL {
            let triangle = Prepared::new(kernel, &[Vec3::ZERO, Vec3::X, Vec3::Y]);
            let mut hits = Hits::none(&packet);
            for addr in [72, 36, 108] {
                triangle.intersect_packet(addr, &packet, all, Query::Closest, &mut hits);
            }
            assert_eq!((hits.t[0], hits.triangle[0]), (2.0, 36), "{kernel:?}");
            assert!(!hits.is_hit(1));
        }
    }

    #[test]
    fn rays_outside_of_the_cell_are_masked() {
        let packet = packet();
        for kernel in Kernel::ALL {
            let mut hits = Hits::none(&packet);
            let triangle = Prepared::new(kernel, &[Vec3::ZERO, Vec3::X, Vec3::Y]);
            triangle.intersect_packet(36, &packet, (&[1.0; 2], &[0.5; 2]), Query::Closest, &mut hits);
            assert_eq!(hits, Hits::none(&packet));
        }
    }
}
