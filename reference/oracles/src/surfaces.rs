//! Rays at the edges and vertices of surfaces, and how many of the triangles around there each of them has to hit (IS-6).
//!
//! The expected number is that of [`crossings`], in rational numbers where anything is in doubt. Most rays meet an edge or a
//! vertex exactly, the others within rounding. The line of a ray is judged, whatever its range.

mod surface;

pub use surface::{Patch, Surface};
use surface::{cube, fan, height_field, needles, scanned, sphere, torus};

use crate::exact::crossings::{Crossings, crossings};
use glam::Vec3;
use saarcor_model::rays::Ray;
use saarcor_random::Random;

/// Rays that are tried for a case until one does not leave through the patch's rim.
const TRIES: u32 = 32;

/// How often a patch is grown whose rim the line meets, as where corners lie in a line.
const RINGS: u32 = 2;

/// A surface somewhere, of some size.
#[derive(Clone, Debug)]
pub struct Place {
    /// The shape, its size and its place.
    pub name: String,
    /// The surface.
    pub surface: Surface,
}

impl Place {
    /// The triangles of a scene.
    #[must_use]
    pub fn new(name: &str, triangles: &[[Vec3; 3]]) -> Self {
        Self { name: name.to_owned(), surface: Surface::new(triangles) }
    }
}

/// A suite of rays at edges and vertices of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceSuite {
    /// From everywhere.
    ExactlyOne,
    /// As in Vulkan's conformance tests of watertightness, rebuilt from their description: parallel rays at closed fans and grids.
    Watertightness,
    /// At edges and vertices that are seen from beside, of meshes of 10⁶ triangles.
    Silhouettes,
}

impl SurfaceSuite {
    /// The suites by their names.
    pub const NAMES: &'static [(&'static str, Self)] = &[
        ("exactly-one", Self::ExactlyOne),
        ("watertightness", Self::Watertightness),
        ("silhouettes", Self::Silhouettes),
    ];

    /// Its idea.
    #[must_use]
    pub fn idea(self) -> &'static str {
        match self {
            Self::ExactlyOne => {
                "rays at edges and vertices of closed meshes, of sizes from 1e-6 to 1e6 and 1e6 away"
            }
            Self::Watertightness => "parallel rays at edges and vertices of fans and grids",
            Self::Silhouettes => "rays at edges and vertices that are seen from beside, of 10^6 triangles",
        }
    }

    /// Its own surfaces.
    #[must_use]
    pub fn places(self) -> Vec<Place> {
        match self {
            Self::ExactlyOne => closed_meshes(),
            Self::Watertightness => {
                let fans = [3, 4, 5, 8, 16, 64, 256].map(|count| (format!("fan of {count}"), fan(count)));
                let grids =
                    [2, 4, 16, 64, 256].map(|cells| (format!("grid of {cells}"), height_field(cells)));
                fans.into_iter().chain(grids).map(|(name, triangles)| Place::new(&name, &triangles)).collect()
            }
            Self::Silhouettes => vec![
                Place::new("sphere", &sphere([1000, 501])),
                Place::new("scanned", &scanned([1000, 501])),
                Place::new("torus", &torus([1000, 500])),
            ],
        }
    }
}

/// Closed shapes, round, noisy, flat and thin, at sizes from 10⁻⁶ to 10⁶ and 10⁶ from the origin.
fn closed_meshes() -> Vec<Place> {
    let shapes = [
        ("sphere", sphere([48, 24])),
        ("scanned", scanned([48, 24])),
        ("torus", torus([48, 24])),
        ("cube", cube(8)),
        ("needles", needles([24, 12])),
    ];
    let sizes =
        [(1.0e-6, 0.0), (1.0e-3, 0.0), (1.0, 0.0), (1.0e3, 0.0), (1.0e6, 0.0), (1.0, 1.0e6), (1.0e3, 1.0e6)];
    let at = |(name, triangles): &(&str, Vec<[Vec3; 3]>), (size, from): (f32, f32)| {
        let offset = Vec3::new(from, -from * 0.75, from * 0.5);
        let moved: Vec<_> =
            triangles.iter().map(|corners| corners.map(|corner| corner * size + offset)).collect();
        let place = if from == 0.0 { String::new() } else { format!(", {from:e} away") };
        Place::new(&format!("{name}, size {size:e}{place}"), &moved)
    };
    shapes.iter().flat_map(|shape| sizes.map(|size| at(shape, size))).collect()
}

/// A ray at an edge or a vertex.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its line.
    pub ray: Ray,
    /// Place of the surface.
    pub place: usize,
    /// The triangles around the edge or the vertex, by their places in the surface; more around them where the line
    /// meets the rim of these.
    pub triangles: Vec<u32>,
    /// What is true of it.
    pub truth: Crossings,
}

/// The case of a number: it depends on the places, the seed and the number alone. `None` if no ray was found that does
/// not leave through the rim.
#[must_use]
pub fn case(suite: SurfaceSuite, places: &[Place], seed: u64, number: u64) -> Option<Case> {
    let mut random = Random::new(Random::new(seed.rotate_left(32) ^ number).bits());
    let place = (number % places.len() as u64) as usize;
    let surface = &places[place].surface;
    if surface.edges.is_empty() && surface.inner.is_empty() {
        return None;
    }
    for _ in 0..TRIES {
        // Edges and vertices in turn, of which there are fewer.
        let of_edge = random.percent(50) && !surface.edges.is_empty() || surface.inner.is_empty();
        let at = if of_edge { random.pick(&surface.edges) } else { [random.pick(&surface.inner); 2] };
        let mut patch = surface.patch(at);
        let ray = ray(&mut random, surface, at, &patch, suite);
        let mut truth = truth_of(&ray, surface, &patch);
        for _ in 0..RINGS {
            if truth.is_none() {
                patch = surface.grown(&patch);
                truth = truth_of(&ray, surface, &patch);
            }
        }
        if let Some(truth) = truth
            && (suite != SurfaceSuite::Silhouettes || matches!(truth, Crossings::Silhouette(_)))
        {
            return Some(Case { ray, place, triangles: patch.triangles, truth });
        }
    }
    None
}

/// How often the ray's line crosses the patch.
fn truth_of(ray: &Ray, surface: &Surface, patch: &Patch) -> Option<Crossings> {
    let rim = patch.rim.iter().map(|side| side.map(|vertex| surface.vertices[vertex as usize]));
    crossings(ray, rim, patch.triangles.iter().map(|&triangle| surface.corners(triangle)))
}

/// A direction of any kind, about as long as a patch is wide.
fn direction(random: &mut Random, surface: &Surface, at: u32, patch: &Patch, suite: SurfaceSuite) -> Vec3 {
    let vertex = |number: u32| surface.vertices[number as usize];
    let corners = patch.triangles.iter().flat_map(|&triangle| surface.triangles[triangle as usize]);
    let others: Vec<u32> = corners.filter(|&corner| corner != at).collect();
    let mut from_here = || vertex(random.pick(&others)) - vertex(at);
    let [one, other] = [from_here(), from_here()];
    let size = one.abs().max_element().max(other.abs().max_element()).max(f32::MIN_POSITIVE);
    let anywhere = Vec3::from([0, 1, 2].map(|_| random.between(-1.0, 1.0))) * size;
    match suite {
        // Near the tangent plane, and across it within a few degrees.
        SurfaceSuite::Silhouettes => {
            return one * random.between(-1.0, 1.0) + other * random.between(-1.0, 1.0) + anywhere * 0.03;
        }
        SurfaceSuite::Watertightness => return Vec3::NEG_Z,
        SurfaceSuite::ExactlyOne => {}
    }
    match random.range(0, 8) {
        // Along an axis, to either side.
        0 => Vec3::AXES[random.range(0, 3) as usize] * size.copysign(anywhere.x),
        // In the plane of an edge of the patch and an axis.
        1 => one + Vec3::AXES[random.range(0, 3) as usize] * anywhere.y,
        // Along an edge and a diagonal.
        2 => one + other * 2.0,
        3 => one.cross(other).normalize_or(Vec3::Z) * size + one,
        _ => anywhere,
    }
}

/// A ray that meets the edge or the vertex, exactly where its numbers have room for that.
fn ray(random: &mut Random, surface: &Surface, at: [u32; 2], patch: &Patch, suite: SurfaceSuite) -> Ray {
    let [p, q] = at.map(|vertex| surface.vertices[vertex as usize]);
    let line = |origin, direction| Ray { origin, direction, t_min: f32::NEG_INFINITY, t_max: f32::INFINITY };
    let way = direction(random, surface, at[0], patch, suite);
    if random.percent(75) {
        // Twice the point that is met, and from where: for the middle of an edge both are rounded to its grid.
        let (mut origin, mut twice) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            (origin[axis], twice[axis]) =
                through(f64::from(p[axis]) + f64::from(q[axis]), f64::from(way[axis]));
        }
        return line(Vec3::from(origin), Vec3::from(twice));
    }
    let along = if p == q { 0.0 } else { random.between(0.05, 0.95) };
    let target = p + (q - p) * along;
    let origin = target - way;
    line(origin, (target - origin) * random.between(0.5, 2.0))
}

/// A coordinate of an origin, and the component of a direction that is twice the way from there to the half of `doubled`, which
/// is about `way`: both exact, where f32 has room for them.
fn through(doubled: f64, way: f64) -> (f32, f32) {
    let middle = doubled / 2.0;
    if way == 0.0 && f64::from(middle as f32) == middle {
        return (middle as f32, 0.0);
    }
    // The last place of the point, or of the way where that is longer and the point has room for it.
    let last = |number: f64| number.abs().max(1.0e-30) * 2.0_f64.powi(-22);
    let grid = 2.0_f64.powi(ilog2(last(middle).max(last(way))));
    for grid in [grid, 2.0_f64.powi(ilog2(last(middle)))] {
        let origin = ((middle - way) / grid).round() * grid;
        let twice = doubled - 2.0 * origin;
        if f64::from(origin as f32) == origin && f64::from(twice as f32) == twice {
            return (origin as f32, twice as f32);
        }
    }
    // From as near as there is room.
    let least = 2.0_f64.powi(ilog2(last(middle)) - 2);
    let origin = middle - (way.clamp(-middle.abs() / 4.0, middle.abs() / 4.0) / least).round() * least;
    (origin as f32, (doubled - 2.0 * f64::from(origin as f32)) as f32)
}

/// The exponent of the power of two below a number.
fn ilog2(number: f64) -> i32 {
    (number.to_bits() >> 52) as i32 - 1023
}
