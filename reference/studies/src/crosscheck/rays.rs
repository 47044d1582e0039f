//! The rays of a cross-check.

use crate::standard::RESOLUTION;
use crate::world::{Image, World};
use glam::Vec3;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::Aabb;
use saarcor_model::rays::{Cones, Frame, Hits, Packet, Query, Ray, Traversal, shadow_ray, surfaces};
use saarcor_model::vm::{HostAddr, Observed, WholeScene};
use saarcor_oracles::embree::Hit;
use saarcor_scenes::Random;
use serde::Serialize;

/// Where a ray comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RayKind {
    /// From a camera of the path through the centre of a pixel.
    Primary,
    /// From a surface that a primary ray hits to a light.
    Shadow,
    /// From anywhere in the scene's box in any direction.
    Random,
    /// To a vertex or to a point of an edge, also along an axis or from another vertex.
    Aimed,
}

impl RayKind {
    /// All kinds, in the order in which they are asked.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Shadow, Self::Random, Self::Aimed];

    /// As it is printed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Random => "random",
            Self::Aimed => "aimed",
        }
    }
}

/// A ray that all are asked. It begins at distance 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Where the ray comes from.
    pub kind: RayKind,
    /// The ray.
    pub ray: Ray,
}

/// Rays that follow one another through the traversal unit as one packet.
const PACKET: usize = 4;
/// Rays that one core traces in one go.
const BATCH: usize = 1 << 12;

/// `count` rays: a quarter of each kind. Where there is no camera, no light or no triangle, random
/// rays take the place of those that need one. The same for the same `seed`.
#[must_use]
pub fn questions(world: &World, triangles: &[[Vec3; 3]], count: usize, seed: u64) -> Vec<Question> {
    let mut random = Random::new(seed);
    let quarter = count / RayKind::ALL.len();
    let primary = primary_rays(world, &mut random, quarter);
    let shadow = shadow_rays(world, &primary, &mut random);
    let aimed: Vec<Ray> = match triangles {
        [] => Vec::new(),
        triangles => (0..quarter).map(|place| aimed_ray(world, triangles, place, &mut random)).collect(),
    };
    let rest = count - primary.len() - shadow.len() - aimed.len();
    let arbitrary = (0..rest).map(|_| random_ray(world, &mut random)).collect();
    let kinds = RayKind::ALL.into_iter().zip([primary, shadow, arbitrary, aimed]);
    kinds.flat_map(|(kind, rays)| rays.into_iter().map(move |ray| Question { kind, ray })).collect()
}

fn endless(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

fn primary_rays(world: &World, random: &mut Random, count: usize) -> Vec<Ray> {
    let (width, height) = RESOLUTION;
    let frames: Vec<_> = world.path.iter().map(|camera| Frame::new(camera, width, height)).collect();
    let count = if frames.is_empty() { 0 } else { count };
    // Frame after frame, so that neighbours in the list are neighbours in space.
    let ray = |place: usize| {
        let (x, y) = (below(random, width as usize), below(random, height as usize));
        frames[place * frames.len() / count].primary_ray(x as u32, y as u32)
    };
    (0..count).map(ray).collect()
}

/// A ray to a light from each surface that a primary ray hits.
fn shadow_rays(world: &World, primary: &[Ray], random: &mut Random) -> Vec<Ray> {
    let registers = &world.image.registers;
    if registers.lights.is_empty() {
        return Vec::new();
    }
    // Shadow rays do not depend on textures.
    let thin = Cones { spread: 0.0, begin: [0.0; PACKET] };
    let seen: Vec<_> = primary
        .par_chunks(BATCH)
        .flat_map_iter(|rays| {
            let mut memory = Observed::by_nobody(WholeScene(&world.image.bytes));
            let mut traversal = Traversal::<PACKET, _>::with(FilteredIntersection::default());
            let surfaces = rays.chunks(PACKET).map(move |rays| {
                let packet = packet(rays);
                let hits = traversal.run(&mut memory, registers, &packet, Query::Closest);
                surfaces(&mut memory, registers, &packet, &hits, &thin)
            });
            surfaces.collect::<Vec<_>>().into_iter().flatten().flatten()
        })
        .collect();
    seen.iter()
        .map(|surface| shadow_ray(surface, &registers.lights[below(random, registers.lights.len())]))
        .collect()
}

fn random_ray(world: &World, random: &mut Random) -> Ray {
    let bounds = world.image.registers.bounds;
    endless(point(random, bounds), direction(random))
}

/// A ray aimed at a vertex or an edge: of eight, three at a vertex and three at a point of an edge,
/// which rounding leaves a little beside it; one at a vertex along an axis, which meets it exactly,
/// with zeros of either sign in its direction; and one from one vertex to another.
fn aimed_ray(world: &World, triangles: &[[Vec3; 3]], place: usize, random: &mut Random) -> Ray {
    let bounds = world.image.registers.bounds;
    let triangle = triangles[below(random, triangles.len())];
    let corner = below(random, 3);
    let (vertex, next) = (triangle[corner], triangle[(corner + 1) % 3]);
    let origin = point(random, bounds);
    let towards = |origin: Vec3, target: Vec3| {
        let direction = target - origin;
        // Where they coincide any direction starts at the target.
        endless(origin, if direction == Vec3::ZERO { Vec3::X } else { direction })
    };
    match place % 8 {
        0..3 => towards(origin, vertex),
        3..6 => towards(origin, vertex + (next - vertex) * random.unit()),
        6 => {
            let axis = below(random, 3);
            let (mut start, mut direction) =
                (vertex, if below(random, 2) == 0 { Vec3::ZERO } else { -Vec3::ZERO });
            start[axis] = origin[axis];
            direction[axis] = if vertex[axis] < start[axis] { -1.0 } else { 1.0 };
            endless(start, direction)
        }
        _ => towards(triangles[below(random, triangles.len())][below(random, 3)], vertex),
    }
}

/// A place in a list of so many.
fn below(random: &mut Random, end: usize) -> usize {
    random.range(0, end as u32) as usize
}

/// A point of the box.
fn point(random: &mut Random, bounds: Aabb) -> Vec3 {
    let [x, y, z] = std::array::from_fn(|axis| random.between(bounds.min[axis], bounds.max[axis]));
    Vec3::new(x, y, z)
}

/// A direction of about unit length, all of them alike.
fn direction(random: &mut Random) -> Vec3 {
    let z = random.between(-1.0, 1.0);
    let (sin, cos) = libm::sincosf(random.between(0.0, std::f32::consts::TAU));
    Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z
}

fn packet(rays: &[Ray]) -> Packet<PACKET> {
    Packet::new(std::array::from_fn(|lane| rays.get(lane).copied()))
}

/// The chip's answer to each question: its pipeline on the image, without a cache.
#[must_use]
pub fn traverse(image: &Image, rays: &[Ray], query: Query) -> Vec<Option<Hit>> {
    rays.par_chunks(BATCH)
        .flat_map_iter(|rays| {
            let mut memory = Observed::by_nobody(WholeScene(&image.bytes));
            let mut traversal = Traversal::<PACKET, _>::with(FilteredIntersection::default());
            let answers = rays.chunks(PACKET).flat_map(move |rays| {
                let hits = traversal.run(&mut memory, &image.registers, &packet(rays), query);
                (0..rays.len()).map(move |lane| hit(image, &hits, lane))
            });
            answers.collect::<Vec<_>>()
        })
        .collect()
}

/// The hit of the ray in `lane`, with the scene's number of the triangle.
pub(super) fn hit<const N: usize>(image: &Image, hits: &Hits<N>, lane: usize) -> Option<Hit> {
    hits.is_hit(lane).then(|| Hit {
        triangle: image.triangle_id(HostAddr(hits.triangle[lane])),
        t: hits.t[lane],
        u: hits.u[lane],
        v: hits.v[lane],
    })
}
