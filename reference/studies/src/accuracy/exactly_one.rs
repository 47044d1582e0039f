//! Exactly one hit (IS-6): rays at the edges and vertices of surfaces, and how many triangles around there each test hits.
//!
//! The expected number is that of [`crossings`], in rational numbers where anything is in doubt. Most rays meet an edge or a
//! vertex exactly, the others within rounding. The line of a ray is judged, whatever its range.

mod surface;

pub use surface::{Patch, Surface};
use surface::{cube, fan, height_field, needles, scanned, sphere, torus};

use super::contest::{Contestant, Format};
use crate::names::{EDGES, Names, kernel_name, name_of};
use glam::Vec3;
use rayon::prelude::*;
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{
    EdgeTriangle, PluckerTriangle, ProjectedTriangle, Ray, TriangleTest, WatertightTriangle,
};
use saarcor_oracles::exact::crossings::{Crossings, crossings};
use saarcor_oracles::formats::{self, Bf16, Double, F16, F24};
use saarcor_scenes::Random;
use serde::Serialize;
use std::ops::AddAssign;
use std::time::Instant;

/// Cases that are judged and counted together on one thread.
const CHUNK: u64 = 4096;

/// Rays that are tried for a case until one does not leave through the patch's rim.
const TRIES: u32 = 32;

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
    pub const NAMES: Names<Self> = &[
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
    /// Place of the patch in the surface.
    pub patch: usize,
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
    let count = surface.patches.len() as u64;
    if count == 0 {
        return None;
    }
    for _ in 0..TRIES {
        // Edges and vertices in turn, of which there are fewer.
        let edges = surface.patches.partition_point(|patch| patch.at[0] != patch.at[1]) as u64;
        let of_edge = random.percent(50) && edges > 0 || edges == count;
        let number = if of_edge { random.below(edges) } else { edges + random.below(count - edges) };
        let patch = &surface.patches[number as usize];
        let ray = ray(&mut random, surface, patch, suite);
        let rim: Vec<Vec3> = patch.rim.iter().map(|&vertex| surface.vertices[vertex as usize]).collect();
        let triangles = patch.triangles.iter().map(|&triangle| surface.corners(triangle));
        if let Some(truth) = crossings(&ray, &rim, triangles)
            && (suite != SurfaceSuite::Silhouettes || matches!(truth, Crossings::Silhouette(_)))
        {
            return Some(Case { ray, place, patch: number as usize, truth });
        }
    }
    None
}

/// A direction of any kind, about as long as a patch is wide.
fn direction(random: &mut Random, surface: &Surface, patch: &Patch, suite: SurfaceSuite) -> Vec3 {
    let vertex = |number: u32| surface.vertices[number as usize];
    let at = vertex(patch.at[0]);
    let [one, other] = [0, 1].map(|_| vertex(random.pick(&patch.rim)) - at);
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
fn ray(random: &mut Random, surface: &Surface, patch: &Patch, suite: SurfaceSuite) -> Ray {
    let [p, q] = patch.at.map(|vertex| surface.vertices[vertex as usize]);
    let line = |origin, direction| Ray { origin, direction, t_min: f32::NEG_INFINITY, t_max: f32::INFINITY };
    let way = direction(random, surface, patch, suite);
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

/// How many of some triangles of a surface a line hits.
pub(crate) type Counter<'a> = Box<dyn Fn(&Ray, &[u32]) -> u32 + Sync + 'a>;

/// The counter of a contestant on a surface.
pub(crate) fn counter(contestant: Contestant, edges: Edges, surface: &Surface) -> Counter<'static> {
    match contestant.format {
        _ if contestant.kernel == Kernel::Adaptive => {
            let prepare = |number: u32| AdaptiveTriangle::new(&surface.corners(number));
            let tests: Vec<_> = (0..surface.triangles.len() as u32).map(prepare).collect();
            Box::new(move |ray, triangles| {
                let ray = AdaptiveRay::new(ray);
                let hit = |&&number: &&u32| tests[number as usize].intersect(edges, &ray).is_some();
                triangles.iter().filter(hit).count() as u32
            })
        }
        Format::F64 => of_kernel::<Double>(contestant.kernel, edges, surface),
        Format::F32 => of_kernel::<f32>(contestant.kernel, edges, surface),
        Format::F24 => of_kernel::<F24>(contestant.kernel, edges, surface),
        Format::Bf16 => of_kernel::<Bf16>(contestant.kernel, edges, surface),
        Format::F16 => of_kernel::<F16>(contestant.kernel, edges, surface),
    }
}

fn of_kernel<R: formats::Format + Send + Sync + 'static>(
    kernel: Kernel,
    edges: Edges,
    surface: &Surface,
) -> Counter<'static> {
    match kernel {
        Kernel::MollerTrumbore | Kernel::Adaptive => of_test::<R, EdgeTriangle<R>>(edges, surface),
        Kernel::Wald => of_test::<R, ProjectedTriangle<R>>(edges, surface),
        Kernel::Plucker => of_test::<R, PluckerTriangle<R>>(edges, surface),
        Kernel::Watertight => of_test::<R, WatertightTriangle<R>>(edges, surface),
    }
}

fn of_test<R: formats::Format, T: TriangleTest<R> + Send + Sync + 'static>(
    edges: Edges,
    surface: &Surface,
) -> Counter<'static> {
    let tests: Vec<T> =
        (0..surface.triangles.len() as u32).map(|number| T::new(&surface.corners(number))).collect();
    Box::new(move |ray, triangles| {
        let ray = T::ray(ray.origin.to_array(), ray.direction.to_array());
        let hit = |&&number: &&u32| match edges {
            Edges::Shared => tests[number as usize].intersect::<false>(&ray).inside,
            Edges::Owned => tests[number as usize].intersect::<true>(&ray).inside,
        };
        triangles.iter().filter(hit).count() as u32
    })
}

/// Numbers of hits that are not the right ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Rays.
    pub cases: u64,
    /// Of those at edges and vertices whose triangles face the ray alike: fewer hits than there are crossings, of which there is
    /// one, or none where the ray passes beside.
    pub none: u64,
    /// More hits than there are crossings.
    pub two: u64,
    /// Rays at silhouettes.
    pub silhouette: u64,
    /// Of these, such with an odd number of hits where it is even, or even where it is odd.
    pub silhouette_wrong: u64,
}

impl Counts {
    /// Of one ray.
    #[must_use]
    pub fn of(truth: Crossings, hits: u32) -> Self {
        let wrong = u64::from(!truth.allows(hits));
        match truth {
            Crossings::Exactly(right) => Self {
                cases: 1,
                none: u64::from(hits < right),
                two: u64::from(hits > right),
                ..Self::default()
            },
            Crossings::Silhouette(_) => {
                Self { cases: 1, silhouette: 1, silhouette_wrong: wrong, ..Self::default() }
            }
        }
    }

    /// Rays with a wrong number of hits.
    #[must_use]
    pub fn wrong(&self) -> u64 {
        self.none + self.two + self.silhouette_wrong
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.cases += other.cases;
        self.none += other.none;
        self.two += other.two;
        self.silhouette += other.silhouette;
        self.silhouette_wrong += other.silhouette_wrong;
    }
}

/// The counts on one surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceCounts {
    /// Which one.
    pub place: String,
    /// The counts.
    #[serde(flatten)]
    pub counts: Counts,
}

/// A contestant's counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExactlyOneRow {
    /// Name of the suite.
    pub suite: &'static str,
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Name of the format.
    pub format: &'static str,
    /// Name of the rule for edges.
    pub edges: &'static str,
    /// The counts on all surfaces.
    #[serde(flatten)]
    pub counts: Counts,
    /// Cases for which no ray was found that the patch decides; on open surfaces, or where all triangles lie in a line.
    pub undecided: u64,
    /// Nanoseconds a ray, with all triangles around the edge or the vertex.
    pub ns_per_ray: f64,
    /// Surface by surface.
    pub places: Vec<PlaceCounts>,
}

/// What is measured.
#[derive(Clone, Copy, Debug)]
pub struct ExactlyOneOptions {
    /// Of the cases.
    pub seed: u64,
    /// How many.
    pub cases: u64,
    /// The rule for edges.
    pub edges: Edges,
}

/// A row for each contestant. `report` learns the part that is done, 0 to 1.
#[must_use]
pub fn exactly_one(
    suite: SurfaceSuite,
    places: &[Place],
    contestants: &[Contestant],
    options: ExactlyOneOptions,
    report: &(dyn Fn(f64) + Sync),
) -> Vec<ExactlyOneRow> {
    let counters = |contestant: &Contestant| -> Vec<Counter<'_>> {
        places.iter().map(|place| counter(*contestant, options.edges, &place.surface)).collect()
    };
    let counters: Vec<Vec<Counter<'_>>> = contestants.iter().map(counters).collect();
    let done = std::sync::atomic::AtomicU64::new(0);
    let none = || (0, vec![(vec![Counts::default(); places.len()], 0.0); contestants.len()]);
    let chunk = |mut sum: (u64, Vec<(Vec<Counts>, f64)>), chunk: u64| {
        let numbers = chunk * CHUNK..options.cases.min((chunk + 1) * CHUNK);
        let asked = numbers.end - numbers.start;
        let cases: Vec<Case> =
            numbers.filter_map(|number| case(suite, places, options.seed, number)).collect();
        sum.0 += asked - cases.len() as u64;
        for ((counts, seconds), counters) in sum.1.iter_mut().zip(&counters) {
            let started = Instant::now();
            for case in &cases {
                let triangles = &places[case.place].surface.patches[case.patch].triangles;
                counts[case.place] += Counts::of(case.truth, counters[case.place](&case.ray, triangles));
            }
            *seconds += started.elapsed().as_secs_f64();
        }
        let before = done.fetch_add(asked, std::sync::atomic::Ordering::Relaxed);
        report((before + asked) as f64 / options.cases as f64);
        sum
    };
    let both = |mut a: (u64, Vec<(Vec<Counts>, f64)>), b: (u64, Vec<(Vec<Counts>, f64)>)| {
        a.0 += b.0;
        for ((counts, seconds), (more, further)) in a.1.iter_mut().zip(b.1) {
            counts.iter_mut().zip(more).for_each(|(counts, more)| *counts += more);
            *seconds += further;
        }
        a
    };
    let (undecided, sums) =
        (0..options.cases.div_ceil(CHUNK)).into_par_iter().fold(none, chunk).reduce(none, both);
    let row = |(contestant, (counts, seconds)): (&Contestant, (Vec<Counts>, f64))| {
        let mut all = Counts::default();
        counts.iter().for_each(|counts| all += *counts);
        ExactlyOneRow {
            suite: name_of(SurfaceSuite::NAMES, &suite),
            kernel: kernel_name(contestant.kernel),
            format: contestant.format.name(),
            edges: name_of(EDGES, &options.edges),
            counts: all,
            undecided,
            ns_per_ray: seconds * 1e9 / all.cases.max(1) as f64,
            places: places
                .iter()
                .zip(counts)
                .map(|(place, counts)| PlaceCounts { place: place.name.clone(), counts })
                .collect(),
        }
    };
    contestants.iter().zip(sums).map(row).collect()
}
