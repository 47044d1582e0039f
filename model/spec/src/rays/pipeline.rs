//! The ray tracing pipeline (§2): ray generation and shading (RGS) in front of the ray tracing
//! core of traversal, list and intersection.

use super::camera::{Frame, ray_from_surface};
use super::intersection::{Intersection, IntersectionUnit};
use super::ray::{Packet, Query, Ray};
use super::shading::{BACKGROUND, Cones, Surface, surfaces};
use super::traversal::Traversal;
use crate::host::{Features, Light, Registers};
use crate::vm::{Memory, Observed, Observer, Unit};
use glam::Vec3;

/// Rays that were traced, by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct RayCounts {
    /// From the camera.
    pub primary: u64,
    /// Towards lights.
    pub shadow: u64,
    /// Reflected and refracted.
    pub secondary: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.secondary += other.secondary;
    }
}

impl RayCounts {
    /// Rays of all kinds.
    pub fn total(self) -> u64 {
        self.primary + self.shadow + self.secondary
    }
}

/// Least part of a pixel's light for which a secondary ray is sent: one step of an 8-bit colour
/// (RG-6, Assumed).
pub const LEAST_PART: f32 = 1.0 / 256.0;

/// A pipeline for packets of `N` rays.
#[derive(Clone, Debug)]
pub struct Pipeline<const N: usize, I = Intersection<N>> {
    /// Reflections and refractions follow one another up to this many times (RG-4). At the last
    /// surface their part of the light is left to the surface's own colour.
    pub max_bounces: u32,
    /// What was traced so far.
    pub rays: RayCounts,
    traversal: Traversal<N, I>,
}

impl<const N: usize> Pipeline<N> {
    /// Bounces of the standard configuration (Assumed).
    pub const STANDARD_BOUNCES: u32 = 5;

    /// A pipeline that has traced nothing yet.
    pub fn new(max_bounces: u32) -> Self {
        Self::with(Intersection::default(), max_bounces)
    }
}

impl<const N: usize, I: IntersectionUnit<N>> Pipeline<N, I> {
    /// A pipeline with another intersection unit than that of this specification.
    pub fn with(intersection: I, max_bounces: u32) -> Self {
        Self { max_bounces, rays: RayCounts::default(), traversal: Traversal::with(intersection) }
    }

    /// Makes one packet of a picture: the colours of its pixels, in the order of
    /// [`Frame::pixels`].
    pub fn render(
        &mut self,
        memory: &mut Observed<impl Memory, impl Observer>,
        registers: &Registers,
        frame: &Frame,
        packet: u32,
    ) -> [Vec3; N] {
        let packet = frame.primary_packet(packet);
        self.rays.primary += u64::from(packet.active());
        memory.operation(Unit::Shading, packet.active());
        let cones = Cones { spread: frame.pixel_width(), begin: [0.0; N] };
        self.shade(memory, registers, &packet, &cones, &[1.0; N], 0)
    }

    /// The colours that the rays of `packet` see, each of which is a `part` of its pixel's light.
    fn shade(
        &mut self,
        memory: &mut Observed<impl Memory, impl Observer>,
        registers: &Registers,
        packet: &Packet<N>,
        cones: &Cones<N>,
        part: &[f32; N],
        bounces: u32,
    ) -> [Vec3; N] {
        let hits = self.traversal.run(memory, registers, packet, Query::Closest);
        let surfaces = surfaces(memory, registers, packet, &hits, cones);
        let own = self.own_colours(memory, registers, &surfaces);
        let mut colours = own;
        if bounces < self.max_bounces {
            for bounce in Bounce::needed(registers.features) {
                let next_part: [f32; N] = std::array::from_fn(|lane| {
                    surfaces[lane].map_or(0.0, |surface| part[lane] * bounce.part(&surface))
                });
                let next = Packet::new(std::array::from_fn(|lane| {
                    let surface = surfaces[lane].filter(|_| next_part[lane] >= LEAST_PART);
                    surface.map(|surface| bounce.ray(&surface))
                }));
                let rays = next.active();
                if rays == 0 {
                    continue;
                }
                self.rays.secondary += u64::from(rays);
                memory.operation(Unit::Shading, rays);
                let begin = surfaces.map(|surface| surface.map_or(0.0, |surface| surface.distance));
                let cones = Cones { begin, ..*cones };
                let seen = self.shade(memory, registers, &next, &cones, &next_part, bounces + 1);
                for (lane, surface) in surfaces.iter().enumerate() {
                    if let Some(surface) = surface.filter(|_| next.is_active(lane)) {
                        // The surface's own colour gives way to what the new ray sees.
                        colours[lane] += (seen[lane] - own[lane]) * bounce.part(&surface);
                    }
                }
            }
        }
        colours
    }

    /// What the surfaces look like by themselves: unlit, or lit by each light that a shadow ray
    /// reaches. Each hit sends one shadow ray a light (RG-5, Assumed).
    fn own_colours(
        &mut self,
        memory: &mut Observed<impl Memory, impl Observer>,
        registers: &Registers,
        surfaces: &[Option<Surface>; N],
    ) -> [Vec3; N] {
        if registers.lights.is_empty() {
            return surfaces.map(|surface| surface.map_or(BACKGROUND, |s| s.unlit()));
        }
        let mut colours = surfaces.map(|surface| surface.map_or(BACKGROUND, |s| s.ambient()));
        for light in &registers.lights {
            let shadow =
                Packet::new(surfaces.map(|surface| surface.map(|surface| shadow_ray(&surface, light))));
            let rays = shadow.active();
            if rays == 0 {
                return colours;
            }
            self.rays.shadow += u64::from(rays);
            memory.operation(Unit::Shading, rays);
            let hits = self.traversal.run(memory, registers, &shadow, Query::Any);
            for (lane, surface) in surfaces.iter().enumerate() {
                if let Some(surface) = surface.filter(|_| !hits.is_hit(lane)) {
                    colours[lane] += surface.lit(light);
                }
            }
        }
        colours
    }
}

/// The ray from a surface to a light (RG-5). It ends at the light itself, at distance 1.
pub fn shadow_ray(surface: &Surface, light: &Light) -> Ray {
    let Surface { point, scale, plane_normal, .. } = *surface;
    let start = ray_from_surface(point, scale, plane_normal, light.position - point, 1.0);
    // The light, not a point beside it, is where the ray ends.
    Ray { direction: light.position - start.origin, ..start }
}

/// The two kinds of secondary rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bounce {
    Reflection,
    Refraction,
}

impl Bounce {
    /// The kinds that the scene needs.
    fn needed(features: Features) -> impl Iterator<Item = Self> {
        let reflection = features.reflection.then_some(Self::Reflection);
        reflection.into_iter().chain(features.refraction.then_some(Self::Refraction))
    }

    /// The part of the light that arrives by this kind of ray.
    fn part(self, surface: &Surface) -> f32 {
        match self {
            Self::Reflection => surface.material.reflection,
            Self::Refraction => surface.material.refraction,
        }
    }

    /// The new ray.
    fn ray(self, surface: &Surface) -> Ray {
        let direction = match self {
            Self::Reflection => surface.mirrored(),
            Self::Refraction => surface.refracted(),
        };
        let Surface { point, scale, plane_normal, .. } = *surface;
        ray_from_surface(point, scale, plane_normal, direction, f32::INFINITY)
    }
}
