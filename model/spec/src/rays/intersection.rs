//! The intersection unit: rays against one triangle (§2).
//!
//! One test a file, each with its rules for contact, triangles without area, rays in the plane, NaN
//! and infinity, and the bound of its error: γ(n) = n·u / (1 - n·u) for n roundings, u the
//! roundoff of the format (Higham 2002, §3.1). Each has one body for all number formats; the chip
//! computes in f32.

mod adaptive;
mod edges;
mod integer;
mod moller_trumbore;
mod number;
mod plucker;
mod triangle_test;
mod wald;
mod watertight;

pub use adaptive::ExactHit;
pub use moller_trumbore::EdgeTriangle;
pub use number::{Number, Triple};
pub use plucker::PluckerTriangle;
pub use triangle_test::{Candidate, TriangleTest};
pub use wald::ProjectedTriangle;
pub use watertight::{ShearedRay, WatertightTriangle};

use super::interval::Intervals;
use super::ray::{Hits, Packet, Query, Ray};
use crate::host::{Edges, Kernel, TriangleRecord};
use crate::vm::HostAddr;
use glam::Vec3;
use std::cmp::Ordering;

/// A triangle in host memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredTriangle {
    /// Where it lies.
    pub addr: HostAddr,
    /// The test for which it is stored.
    pub kernel: Kernel,
    /// Whose its edges and vertices are.
    pub edges: Edges,
    /// What is stored of it.
    pub record: TriangleRecord,
}

impl StoredTriangle {
    /// The triangle as the driver stores it.
    pub fn new(addr: HostAddr, kernel: Kernel, edges: Edges, corners: &[Vec3; 3]) -> Self {
        Self { addr, kernel, edges, record: kernel.record(corners) }
    }
}

/// An intersection unit for packets of `N` rays.
pub trait IntersectionUnit<const N: usize> {
    /// One operation: the rays of `packet` that meet the `cell` against a triangle. `hits` are those of
    /// the operations for this packet so far, by this unit; before the first, [`Hits::none`].
    fn intersect(
        &mut self,
        triangle: &StoredTriangle,
        packet: &Packet<N>,
        cell: &Intervals<N>,
        query: Query,
        hits: &mut Hits<N>,
    );
}

/// The intersection unit of this specification.
#[derive(Clone, Debug)]
pub struct Intersection<const N: usize> {
    /// The corners of the triangle that each ray hits first so far, for the adaptive test, which
    /// compares its distance exactly. Without meaning where nothing was hit.
    nearest: [[Vec3; 3]; N],
}

impl<const N: usize> Default for Intersection<N> {
    fn default() -> Self {
        Self { nearest: [[Vec3::ZERO; 3]; N] }
    }
}

impl<const N: usize> IntersectionUnit<N> for Intersection<N> {
    fn intersect(
        &mut self,
        triangle: &StoredTriangle,
        packet: &Packet<N>,
        cell: &Intervals<N>,
        query: Query,
        hits: &mut Hits<N>,
    ) {
        let StoredTriangle { addr, kernel, edges, record } = *triangle;
        let corners = record.corners();
        let operation = (addr, edges);
        match kernel {
            Kernel::MollerTrumbore => {
                keep_nearest(EdgeTriangle::new(&corners), operation, packet, cell, query, hits)
            }
            Kernel::Wald => {
                keep_nearest(ProjectedTriangle::decode(&record), operation, packet, cell, query, hits)
            }
            Kernel::Plucker => {
                keep_nearest(PluckerTriangle::new(&corners), operation, packet, cell, query, hits)
            }
            Kernel::Watertight => {
                keep_nearest(WatertightTriangle::new(&corners), operation, packet, cell, query, hits)
            }
            Kernel::Adaptive => self.exact(&corners, operation, packet, cell, query, hits),
        }
    }
}

/// An operation with a test that rounds, on the triangle at `addr`: keeps the nearer hit (IS-2), of two
/// hits at the same distance the triangle at the lower address, so that the order of the tests does not
/// matter.
pub fn keep_nearest<const N: usize>(
    triangle: impl TriangleTest<f32>,
    (addr, edges): (HostAddr, Edges),
    packet: &Packet<N>,
    cell: &Intervals<N>,
    query: Query,
    hits: &mut Hits<N>,
) {
    match edges {
        Edges::Shared => keep_nearest_of::<false, N>(triangle, addr, packet, cell, query, hits),
        Edges::Owned => keep_nearest_of::<true, N>(triangle, addr, packet, cell, query, hits),
    }
}

/// [`keep_nearest`] where edges are `OWNED`, or shared.
fn keep_nearest_of<const OWNED: bool, const N: usize>(
    triangle: impl TriangleTest<f32>,
    addr: HostAddr,
    packet: &Packet<N>,
    cell: &Intervals<N>,
    query: Query,
    hits: &mut Hits<N>,
) {
    for lane in 0..N {
        let found = test::<_, OWNED, N>(&triangle, packet, lane);
        let nearer = (found.t < hits.t[lane]) | ((found.t == hits.t[lane]) & (addr.0 < hits.triangle[lane]));
        let in_range = (found.t >= packet.t_min[lane]) & (found.t < packet.t_max[lane]);
        let keeps = cell.meets(lane) & found.inside & in_range & nearer;
        // A shadow ray needs no more than one hit: nothing is nearer than minus infinity.
        let t = if query == Query::Any { f32::NEG_INFINITY } else { found.t };
        hits.t[lane] = if keeps { t } else { hits.t[lane] };
        hits.u[lane] = if keeps { found.u } else { hits.u[lane] };
        hits.v[lane] = if keeps { found.v } else { hits.v[lane] };
        hits.triangle[lane] = if keeps { addr.0 } else { hits.triangle[lane] };
    }
}

/// Where the ray in `lane` meets the triangle's plane.
fn test<T: TriangleTest<f32>, const OWNED: bool, const N: usize>(
    triangle: &T,
    packet: &Packet<N>,
    lane: usize,
) -> Candidate {
    let origin = [packet.origin[0][lane], packet.origin[1][lane], packet.origin[2][lane]];
    let direction = [packet.direction[0][lane], packet.direction[1][lane], packet.direction[2][lane]];
    triangle.intersect::<OWNED>(&T::ray(origin, direction))
}

impl<const N: usize> Intersection<N> {
    /// An operation with the adaptive test, which decides exactly what is hit first.
    fn exact(
        &mut self,
        corners: &[Vec3; 3],
        (addr, edges): (HostAddr, Edges),
        packet: &Packet<N>,
        cell: &Intervals<N>,
        query: Query,
        hits: &mut Hits<N>,
    ) {
        for lane in 0..N {
            // A shadow ray needs no more than one hit.
            let done = query == Query::Any && hits.is_hit(lane);
            if done || !cell.meets(lane) {
                continue;
            }
            let ray = packet.ray(lane);
            let Some(found) = ExactHit::new(&ray, corners, edges) else { continue };
            let nearest = &self.nearest[lane];
            let before = if hits.is_hit(lane) { ExactHit::new(&ray, nearest, Edges::Shared) } else { None };
            let nearer = before.is_none_or(|before| match found.order(&before) {
                Ordering::Less => true,
                Ordering::Equal => addr.0 < hits.triangle[lane],
                Ordering::Greater => false,
            });
            if nearer {
                hits.keep(lane, addr, found.rounded(), query);
                self.nearest[lane] = *corners;
            }
        }
    }
}

/// Where one ray hits one triangle, if it does within its range.
pub fn intersect(kernel: Kernel, edges: Edges, corners: &[Vec3; 3], ray: &Ray) -> Option<Candidate> {
    let packet = Packet::new([Some(*ray)]);
    let mut hits = Hits::none(&packet);
    let triangle = StoredTriangle::new(HostAddr(0), kernel, edges, corners);
    let mut unit = Intersection::<1>::default();
    unit.intersect(&triangle, &packet, &Intervals::EVERYWHERE, Query::Closest, &mut hits);
    hits.is_hit(0).then(|| Candidate { t: hits.t[0], u: hits.u[0], v: hits.v[0], inside: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const CORNERS: [Vec3; 3] = [Vec3::new(1.0, 2.0, 5.0), Vec3::new(4.0, 2.5, 6.0), Vec3::new(2.0, 5.0, 4.0)];

    const UNIT: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

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
                let found = intersect(kernel, Edges::Shared, &CORNERS, &ray);
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
            for ray in [in_plane, along_z(Vec3::NAN), still] {
                assert_eq!(intersect(kernel, Edges::Shared, &UNIT, &ray), None, "{kernel:?}");
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
        for kernel in Kernel::ALL {
            let (mut unit, mut hits) = (Intersection::default(), Hits::none(&packet));
            for addr in [72, 36, 108] {
                let triangle = StoredTriangle::new(HostAddr(addr), kernel, Edges::Shared, &UNIT);
                unit.intersect(&triangle, &packet, &Intervals::EVERYWHERE, Query::Closest, &mut hits);
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
            let triangle = StoredTriangle::new(HostAddr(36), kernel, Edges::Shared, &UNIT);
            Intersection::default().intersect(
                &triangle,
                &packet,
                &Intervals::EMPTY,
                Query::Closest,
                &mut hits,
            );
            assert_eq!(hits, Hits::none(&packet));
        }
    }
}
