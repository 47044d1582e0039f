//! Rays from the points that other rays hit.

use super::{Suite, at, point, ray, towards, triangle};
use crate::accuracy::case::Case;
use crate::names::kernel_name;
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
        // To the side that was seen, at angles down to a few degrees.
        let direction = |random: &mut Random, normal: Vec3, side: Vec3| {
            super::point(random).cross(normal) + side * random.between(0.05, 1.0)
        };
        Self::on(random, Kernel::default(), floor, seen, 1.0, direction)
    }

    /// Where a ray meets a floor, by a test; a wall of that height stands on the floor's first edge.
    fn on(
        random: &mut Random,
        kernel: Kernel,
        floor: [Vec3; 3],
        seen: Ray,
        height: f32,
        direction: impl Fn(&mut Random, Vec3, Vec3) -> Vec3,
    ) -> Self {
        let t = intersect(kernel, Edges::Shared, &floor, &seen).map_or(1.0, |hit| hit.t);
        let point = seen.origin + seen.direction * t;
        let normal = (floor[1] - floor[0]).cross(floor[2] - floor[0]).normalize_or(Vec3::Z);
        let side = if seen.direction.dot(normal) > 0.0 { -normal } else { normal };
        let direction = direction(random, normal, side);
        let wall = [floor[0], floor[1], floor[0].midpoint(floor[1]) + side * height];
        let scale = seen.origin.abs().max_element().max(point.abs().max_element());
        Self { floor, wall, point, scale, normal, direction }
    }

    /// On a floor of a size, seen at a slope, at 1e-3 of its first edge beside that edge; the ray goes on at that slope to the wall
    /// there. The floor lies so far from the origin as it is large, and the eye as far from it.
    fn beside_a_wall(random: &mut Random, kernel: Kernel, size: f32, slope: f32) -> Self {
        let place = point(random) * size;
        let floor = triangle(random).map(|corner| place + corner * size);
        let [a, b, c] = floor;
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Z);
        let along = random.between(0.2, 0.8);
        let target = at(&floor, along * (1.0 - 1.0e-3), 1.0e-3);
        let from = (super::point(random).cross(normal).normalize_or(Vec3::X) + normal * slope) * size;
        let seen = towards(random, target + from, target);
        let foot = a.lerp(b, along);
        let direction = |_: &mut Random, _: Vec3, side: Vec3| {
            let way = foot - target;
            way * 2.0 + side * (way.length() * slope)
        };
        Self::on(random, kernel, floor, seen, size, direction)
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

/// The rule on rays of one kind.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct OffsetRow {
    /// Name of the test that finds the points.
    pub kernel: &'static str,
    /// Size of the surfaces.
    pub size: f32,
    /// Slope at which a point is seen, and its ray goes on.
    pub slope: f32,
    /// The faults.
    #[serde(flatten)]
    pub faults: OffsetFaults,
}

/// Judges the rule by test, size and slope, at 1e-3 of an edge beside a wall, on as many rays each.
#[must_use]
pub fn offset_rows(seed: u64, rays: u64) -> Vec<OffsetRow> {
    let mut rows = Vec::new();
    for kernel in [Kernel::default(), Kernel::Adaptive] {
        for size in [1.0e-6, 1.0e-3, 1.0, 1.0e3, 1.0e6] {
            for slope in [1.0, 0.1, 0.01, 0.001] {
                let start = |random: &mut Random| Start::beside_a_wall(random, kernel, size, slope);
                let faults = judged(seed, rays, start);
                rows.push(OffsetRow { kernel: kernel_name(kernel), size, slope, faults });
            }
        }
    }
    rows
}

/// Judges the rule on as many rays.
#[must_use]
pub fn offset_faults(seed: u64, rays: u64) -> OffsetFaults {
    judged(seed, rays, Start::new)
}

fn judged(seed: u64, rays: u64, start: impl Fn(&mut Random) -> Start + Sync) -> OffsetFaults {
    let one = |number: u64| {
        let start = start(&mut Random::new(Random::new(seed ^ number).bits()));
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
