//! Rays, and packets of them (§2: rays are worked on in packets, by all units).

use crate::vm::HostAddr;
use glam::Vec3;

/// A ray: the points `origin + t · direction` with `t_min ≤ t < t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is 0.
    pub origin: Vec3,
    /// Any length.
    pub direction: Vec3,
    /// Least distance of a hit, at least 0.
    pub t_min: f32,
    /// Distance that a hit stays below.
    pub t_max: f32,
}

/// Up to `N` rays that go through the units together. A field holds one value a ray.
///
/// A ray takes part where `t_min ≤ t_max`; [`Packet::EMPTY`] has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packet<const N: usize> {
    /// x, y and z of the origins.
    pub origin: [[f32; N]; 3],
    /// x, y and z of the directions.
    pub direction: [[f32; N]; 3],
    /// Least distances of a hit.
    pub t_min: [f32; N],
    /// Distances that a hit stays below.
    pub t_max: [f32; N],
}

impl<const N: usize> Packet<N> {
    /// A packet in which no ray takes part.
    pub const EMPTY: Self = Self {
        origin: [[0.0; N]; 3],
        direction: [[0.0; N]; 3],
        t_min: [f32::INFINITY; N],
        t_max: [f32::NEG_INFINITY; N],
    };

    /// The packet of those rays that are there.
    pub fn new(rays: [Option<Ray>; N]) -> Self {
        let mut packet = Self::EMPTY;
        for (lane, ray) in rays.iter().enumerate() {
            if let Some(ray) = ray {
                for axis in 0..3 {
                    packet.origin[axis][lane] = ray.origin[axis];
                    packet.direction[axis][lane] = ray.direction[axis];
                }
                packet.t_min[lane] = ray.t_min;
                packet.t_max[lane] = ray.t_max;
            }
        }
        packet
    }

    /// Whether the ray in `lane` takes part.
    pub fn is_active(&self, lane: usize) -> bool {
        self.t_min[lane] <= self.t_max[lane]
    }

    /// Number of rays that take part.
    pub fn active(&self) -> u32 {
        (0..N).filter(|&lane| self.is_active(lane)).count() as u32
    }

    /// The ray in `lane`.
    pub fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: self.origin(lane),
            direction: self.direction(lane),
            t_min: self.t_min[lane],
            t_max: self.t_max[lane],
        }
    }

    /// The origin of the ray in `lane`.
    pub fn origin(&self, lane: usize) -> Vec3 {
        Vec3::new(self.origin[0][lane], self.origin[1][lane], self.origin[2][lane])
    }

    /// The direction of the ray in `lane`.
    pub fn direction(&self, lane: usize) -> Vec3 {
        Vec3::new(self.direction[0][lane], self.direction[1][lane], self.direction[2][lane])
    }
}

/// What the rays of a packet hit. A field holds one value a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hits<const N: usize> {
    /// Distance of the nearest hit so far; the ray's `t_max` where there is none.
    pub t: [f32; N],
    /// Barycentric weight of the triangle's second corner.
    pub u: [f32; N],
    /// Barycentric weight of the triangle's third corner.
    pub v: [f32; N],
    /// Host address of the triangle; [`Hits::NOTHING`] where nothing was hit.
    pub triangle: [u32; N],
}

impl<const N: usize> Hits<N> {
    /// In place of an address, says that nothing was hit. Above all addresses of triangles.
    pub const NOTHING: u32 = u32::MAX;

    /// No hits yet for the rays of `packet`.
    pub fn none(packet: &Packet<N>) -> Self {
        Self { t: packet.t_max, u: [0.0; N], v: [0.0; N], triangle: [Self::NOTHING; N] }
    }

    /// Whether the ray in `lane` hit something.
    pub fn is_hit(&self, lane: usize) -> bool {
        self.triangle[lane] != Self::NOTHING
    }

    /// Keeps a hit of the ray in `lane`, on the triangle at `addr`. For [`Query::Any`] it is at minus
    /// infinity: nothing is nearer, so that the ray needs no other.
    pub fn keep(&mut self, lane: usize, addr: HostAddr, [t, u, v]: [f32; 3], query: Query) {
        self.t[lane] = if query == Query::Any { f32::NEG_INFINITY } else { t };
        (self.u[lane], self.v[lane], self.triangle[lane]) = (u, v, addr.0);
    }
}

/// What a packet of rays asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit.
    Closest,
    /// Whether there is any hit: shadow rays.
    Any,
}
