//! Exactly one hit (IS-6): rays at the edges and vertices of surfaces, and how many triangles around there each test hits.
//!
//! The rays and what is true of them come from [`surfaces`](saarcor_oracles::surfaces).

use super::contest::{Contestant, Format};
use crate::names::{EDGES, kernel_name, name_of};
use glam::Vec3;
use rayon::prelude::*;
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{
    EdgeTriangle, ExactHit, PluckerTriangle, ProjectedTriangle, Ray, TriangleTest, WatertightTriangle,
};
use saarcor_oracles::exact::crossings::Crossings;
use saarcor_oracles::exact::{is_owned_hit, judge};
use saarcor_oracles::formats::{self, Bf16, Double, F16, F24};
use saarcor_oracles::surfaces::{Case, Place, Surface, SurfaceSuite, case};
use saarcor_random::Random;
use serde::Serialize;
use std::ops::AddAssign;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

/// Cases that are judged and counted together on one thread.
const CHUNK: u64 = 4096;

/// Cases whose triangles are looked at one by one, about; of few cases every fourth.
const LOOKED: u64 = 1 << 14;

/// Triangles of a case that are many to look at.
const MANY: usize = 16;

/// What stands for a kernel in the row of the adaptive test as it is specified.
const SPECIFICATION: &str = "specification";

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
    /// The counts on all surfaces; of the specification, in those cases that are looked at closely.
    #[serde(flatten)]
    pub counts: Counts,
    /// Cases for which no ray was found that the patch decides; on open surfaces, or where all triangles lie in a line.
    pub undecided: u64,
    /// Triangles of a fourth of the cases, but of no more than about 16 384, that were looked at one by one.
    pub looked: u64,
    /// Of these, such that are hit and should not be, or the other way round: where edges are owned, another triangle than the one
    /// that has the edge or the vertex.
    pub others: u64,
    /// Nanoseconds a ray, with all triangles around the edge or the vertex.
    pub ns_per_ray: f64,
    /// Surface by surface.
    pub places: Vec<PlaceCounts>,
}

impl ExactlyOneRow {
    /// Whether nothing may be wrong where edges are owned: of the adaptive test, and as it is specified.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.kernel == kernel_name(Kernel::Adaptive) || self.kernel == SPECIFICATION
    }
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

/// Who is asked, and on which cases.
struct Entrant {
    kernel: &'static str,
    format: &'static str,
    /// By surface.
    counters: Vec<Counter<'static>>,
    /// Only where cases are looked at closely.
    seldom: bool,
}

/// What was counted of an entrant.
#[derive(Clone)]
struct Sum {
    counts: Vec<Counts>,
    seconds: f64,
    looked: u64,
    others: u64,
}

/// A row for each contestant, and with the adaptive test one for the specification. `report` learns the part that is
/// done, 0 to 1.
#[must_use]
pub fn exactly_one(
    suite: SurfaceSuite,
    places: &[Place],
    contestants: &[Contestant],
    options: ExactlyOneOptions,
    report: &(dyn Fn(f64) + Sync),
) -> Vec<ExactlyOneRow> {
    let entrants = entrants(places, contestants, options.edges);
    let done = AtomicU64::new(0);
    let nothing = Sum { counts: vec![Counts::default(); places.len()], seconds: 0.0, looked: 0, others: 0 };
    let none = || (0, vec![nothing.clone(); entrants.len()]);
    let stride = options.cases.div_ceil(LOOKED).max(4);
    let chunk = |(mut undecided, mut sums): (u64, Vec<Sum>), chunk: u64| {
        let numbers = chunk * CHUNK..options.cases.min((chunk + 1) * CHUNK);
        let asked = numbers.end - numbers.start;
        let cases: Vec<(bool, Case)> = numbers
            .filter_map(|number| {
                let case = case(suite, places, options.seed, number)?;
                // The more triangles, the seldomer.
                let stride = stride * case.triangles.len().div_ceil(MANY) as u64;
                Some((Random::new(!number).below(stride) == 0, case))
            })
            .collect();
        undecided += asked - cases.len() as u64;
        for (sum, entrant) in sums.iter_mut().zip(&entrants) {
            let started = Instant::now();
            for (_, case) in cases.iter().filter(|(looks, _)| *looks || !entrant.seldom) {
                sum.counts[case.place] +=
                    Counts::of(case.truth, entrant.counters[case.place](&case.ray, &case.triangles));
            }
            sum.seconds += started.elapsed().as_secs_f64();
        }
        for (_, case) in cases.iter().filter(|(looks, _)| *looks) {
            for &triangle in &case.triangles {
                let right = is_hit(&case.ray, &places[case.place].surface.corners(triangle), options.edges);
                for (sum, entrant) in sums.iter_mut().zip(&entrants) {
                    let found = entrant.counters[case.place](&case.ray, &[triangle]) == 1;
                    sum.looked += 1;
                    sum.others += u64::from(found != right);
                }
            }
        }
        let before = done.fetch_add(asked, Relaxed);
        report((before + asked) as f64 / options.cases as f64);
        (undecided, sums)
    };
    let both = |mut a: (u64, Vec<Sum>), b: (u64, Vec<Sum>)| {
        a.0 += b.0;
        for (sum, more) in a.1.iter_mut().zip(b.1) {
            sum.counts.iter_mut().zip(more.counts).for_each(|(counts, more)| *counts += more);
            sum.seconds += more.seconds;
            sum.looked += more.looked;
            sum.others += more.others;
        }
        a
    };
    let (undecided, sums) =
        (0..options.cases.div_ceil(CHUNK)).into_par_iter().fold(none, chunk).reduce(none, both);
    let row = |(entrant, sum): (&Entrant, Sum)| {
        let mut all = Counts::default();
        sum.counts.iter().for_each(|counts| all += *counts);
        let of_place = |(place, counts): (&Place, Counts)| PlaceCounts { place: place.name.clone(), counts };
        ExactlyOneRow {
            suite: name_of(SurfaceSuite::NAMES, &suite),
            kernel: entrant.kernel,
            format: entrant.format,
            edges: name_of(EDGES, &options.edges),
            counts: all,
            undecided,
            looked: sum.looked,
            others: sum.others,
            ns_per_ray: sum.seconds * 1e9 / all.cases.max(1) as f64,
            places: places.iter().zip(sum.counts).map(of_place).collect(),
        }
    };
    entrants.iter().zip(sums).map(row).collect()
}

/// The contestants, and the specification beside its twin.
fn entrants(places: &[Place], contestants: &[Contestant], edges: Edges) -> Vec<Entrant> {
    let entrant = |contestant: &Contestant| Entrant {
        kernel: kernel_name(contestant.kernel),
        format: contestant.format.name(),
        counters: places.iter().map(|place| counter(*contestant, edges, &place.surface)).collect(),
        seldom: false,
    };
    let mut entrants: Vec<Entrant> = contestants.iter().map(entrant).collect();
    if contestants.iter().any(|contestant| contestant.kernel == Kernel::Adaptive) {
        let counters = places.iter().map(|place| specification(edges, &place.surface)).collect();
        entrants.push(Entrant { kernel: SPECIFICATION, format: "integer", counters, seldom: true });
    }
    entrants
}

/// The counter of the adaptive test as it is specified.
fn specification(edges: Edges, surface: &Surface) -> Counter<'static> {
    let corners: Vec<_> = (0..surface.triangles.len() as u32).map(|number| surface.corners(number)).collect();
    Box::new(move |ray, triangles| {
        let hit = |&&number: &&u32| ExactHit::new(ray, &corners[number as usize], edges).is_some();
        triangles.iter().filter(hit).count() as u32
    })
}

/// Whether a ray hits a triangle, in rational numbers where anything is in doubt.
fn is_hit(ray: &Ray, corners: &[Vec3; 3], edges: Edges) -> bool {
    match edges {
        Edges::Shared => judge(ray, corners).is_hit(),
        Edges::Owned => is_owned_hit(ray, corners),
    }
}
