//! Rays from the points that other rays hit.

use super::{Suite, at, point, ray, towards, triangle};
use crate::accuracy::case::Case;
use glam::Vec3;
use rayon::prelude::*;
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{Ray, intersect, ray_from_surface};
use saarcor_oracles::exact::judge;
use saarcor_scenes::Random;

/// A hit as the chip computes it, and a direction on from there.
struct Start {
    floor: [Vec3; 3],
    wall: [Vec3; 3],
    point: Vec3,
    /// The largest coordinate that the point was computed from.
    scale: f32,
    normal: Vec3,
    direction: Vec3,
}

impl Start {
    fn new(random: &mut Random) -> Self {
        let floor = triangle(random);
        let (u, v) = (random.between(0.01, 0.49), random.between(0.01, 0.49));
        let eye = point(random);
        let seen = towards(random, eye, at(&floor, u, v));
        let t = intersect(Kernel::default(), Edges::Shared, &floor, &seen).map_or(1.0, |hit| hit.t);
        let point = seen.origin + seen.direction * t;
        let normal = (floor[1] - floor[0]).cross(floor[2] - floor[0]).normalize_or(Vec3::Z);
        // To the side that was seen, at angles down to a few degrees.
        let side = if seen.direction.dot(normal) > 0.0 { -normal } else { normal };
        let direction = super::point(random).cross(normal) + side * random.between(0.05, 1.0);
        // A wall on an edge of the floor.
        let wall = [floor[0], floor[1], floor[0].midpoint(floor[1]) + side];
        let scale = eye.abs().max_element().max(point.abs().max_element());
        Self { floor, wall, point, scale, normal, direction }
    }

    fn ray(&self) -> Ray {
        ray_from_surface(self.point, self.scale, self.normal, self.direction, f32::INFINITY)
    }
}

/// A ray from a hit on a floor, off it by the chip's rule (RG-3), against the floor and a wall on the
/// floor's edge.
pub(super) const SHADOW: Suite = Suite {
    name: "shadow",
    idea: "rays from hit points, off the surface by the chip's rule",
    closed: false,
    degenerate: false,
    generate: |random| {
        let start = Start::new(random);
        Case { ray: start.ray(), triangles: vec![start.floor, start.wall] }
    },
};

/// Faults of the rule for the begin of such rays (RG-3), whatever the kernel: judged exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct OffsetFaults {
    /// Rays.
    pub rays: u64,
    /// Rays that hit the surface that they begin on.
    pub self_hits: u64,
    /// Rays that would hit it without the offset.
    pub self_hits_without: u64,
    /// Rays that pass the wall which they hit without the offset.
    pub gaps: u64,
}

impl std::ops::Add for OffsetFaults {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            self_hits: self.self_hits + other.self_hits,
            self_hits_without: self.self_hits_without + other.self_hits_without,
            gaps: self.gaps + other.gaps,
        }
    }
}

/// Judges the rule on as many rays.
#[must_use]
pub fn offset_faults(seed: u64, rays: u64) -> OffsetFaults {
    let one = |number: u64| {
        let start = Start::new(&mut Random::new(Random::new(seed ^ number).bits()));
        let (off, on) = (start.ray(), ray(start.point, start.direction));
        let hits = |ray: &Ray, corners: &[Vec3; 3]| judge(ray, corners).is_hit();
        OffsetFaults {
            rays: 1,
            self_hits: hits(&off, &start.floor).into(),
            self_hits_without: hits(&on, &start.floor).into(),
            gaps: (hits(&on, &start.wall) && !hits(&off, &start.wall)).into(),
        }
    };
    (0..rays).into_par_iter().map(one).reduce(OffsetFaults::default, |a, b| a + b)
}
