//! The intersection unit with the adaptive test of this crate.
//!
//! Twin of [`saarcor_model::rays::Intersection`]: the same hits.

use super::triangle::{AdaptiveHit, AdaptiveRay, AdaptiveTriangle};
use glam::Vec3;
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{
    Candidate, Hits, Intersection, IntersectionUnit, Intervals, Packet, ProjectedTriangle, Query,
    StoredTriangle, TriangleTest, Triple, keep_nearest,
};
use saarcor_model::vm::HostAddr;
use std::cmp::Ordering;

/// An intersection unit that runs the adaptive test of this crate, Wald's test axis by axis, and the
/// specification's own unit for the other tests.
#[derive(Clone, Debug)]
pub struct FilteredIntersection<const N: usize> {
    specified: Intersection<N>,
    /// What is kept of the triangle that each ray hits first so far. Without meaning where nothing was
    /// hit.
    nearest: [Nearest; N],
}

impl<const N: usize> Default for FilteredIntersection<N> {
    fn default() -> Self {
        let nothing = Nearest { corners: [Vec3::ZERO; 3], t_error: 0.0 };
        Self { specified: Intersection::default(), nearest: [nothing; N] }
    }
}

/// What decides exactly which of two hits is nearer, beside the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Nearest {
    corners: [Vec3; 3],
    /// By how much the distance, as rounded to f32, may be off.
    t_error: f32,
}

impl Nearest {
    fn new(hit: &AdaptiveHit) -> Self {
        let error = hit.t_error + (hit.t - f64::from(hit.t as f32)).abs();
        // Two roundings: of the sum, and to f32.
        Self { corners: *hit.corners, t_error: (error as f32).next_up().next_up() }
    }

    /// The hit again, at the distance that it was rounded to.
    fn hit(&self, t: f32) -> AdaptiveHit<'_> {
        let t_error = f64::from(self.t_error);
        AdaptiveHit { t: f64::from(t), u: 0.0, v: 0.0, t_error, corners: &self.corners }
    }
}

impl<const N: usize> IntersectionUnit<N> for FilteredIntersection<N> {
    fn intersect(
        &mut self,
        triangle: &StoredTriangle,
        packet: &Packet<N>,
        cell: &Intervals<N>,
        query: Query,
        hits: &mut Hits<N>,
    ) {
        let operation = (triangle.addr, triangle.edges);
        match triangle.kernel {
            Kernel::Adaptive => {
                let corners = triangle.record.corners();
                self.adaptive(&AdaptiveTriangle::new(&corners), operation, packet, cell, query, hits);
            }
            Kernel::Wald => {
                let decoded = ProjectedTriangle::decode(&triangle.record);
                match decoded.axis {
                    0 => keep_nearest(Along::<0>(decoded), operation, packet, cell, query, hits),
                    1 => keep_nearest(Along::<1>(decoded), operation, packet, cell, query, hits),
                    _ => keep_nearest(Along::<2>(decoded), operation, packet, cell, query, hits),
                }
            }
            _ => self.specified.intersect(triangle, packet, cell, query, hits),
        }
    }
}

/// Wald's test with a constant axis: so the loop over the rays reads whole rows of the packet.
#[derive(Clone, Copy)]
struct Along<const AXIS: usize>(ProjectedTriangle);

impl<const AXIS: usize> TriangleTest<f32> for Along<AXIS> {
    type Ray = <ProjectedTriangle as TriangleTest<f32>>::Ray;

    fn new(corners: &[Vec3; 3]) -> Self {
        Self(ProjectedTriangle::new(corners))
    }

    #[inline(always)]
    fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
        ProjectedTriangle::<f32>::ray(origin, direction)
    }

    #[inline(always)]
    fn intersect<const OWNED: bool>(&self, ray: &Self::Ray) -> Candidate {
        ProjectedTriangle { axis: AXIS, ..self.0 }.intersect::<OWNED>(ray)
    }
}

impl<const N: usize> FilteredIntersection<N> {
    /// Rejects for all rays at once those that miss for certain; then tests the others one by one.
    #[inline(never)]
    fn adaptive(
        &mut self,
        triangle: &AdaptiveTriangle,
        (addr, edges): (HostAddr, Edges),
        packet: &Packet<N>,
        cell: &Intervals<N>,
        query: Query,
        hits: &mut Hits<N>,
    ) {
        let mut misses = [false; N];
        for (lane, misses) in misses.iter_mut().enumerate() {
            let ray = AdaptiveRay::new(&packet.ray(lane));
            *misses = triangle.estimate(&ray).is_outside();
        }
        for (lane, &misses) in misses.iter().enumerate() {
            let done = matches!(query, Query::Any) & hits.is_hit(lane);
            if misses | done | !cell.meets(lane) {
                continue;
            }
            let ray = packet.ray(lane);
            let Some(found) = triangle.intersect(edges, &AdaptiveRay::new(&ray)) else { continue };
            let nearer = !hits.is_hit(lane)
                || match found.order(&self.nearest[lane].hit(hits.t[lane]), &ray) {
                    Ordering::Less => true,
                    Ordering::Equal => addr.0 < hits.triangle[lane],
                    Ordering::Greater => false,
                };
            if nearer {
                hits.keep(lane, addr, found.rounded(), query);
                self.nearest[lane] = Nearest::new(&found);
            }
        }
    }
}
