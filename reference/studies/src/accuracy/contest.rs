//! Kernels in number formats: their answers, and their time.

use super::case::{Case, Found};
use crate::names::{Names, name_of};
use saarcor_fast::adaptive::{AdaptiveHit, AdaptiveRay, AdaptiveTriangle};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{
    Candidate, EdgeTriangle, PluckerTriangle, ProjectedTriangle, Ray, TriangleTest, WatertightTriangle,
};
use saarcor_oracles::formats::{self, Bf16, Double, F16, F24};
use std::cmp::Ordering;
use std::hint::black_box;
use std::time::Instant;

/// A number format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// IEEE 754 binary64.
    F64,
    /// IEEE 754 binary32.
    F32,
    /// 1-7-16.
    F24,
    /// bfloat16.
    Bf16,
    /// IEEE 754 binary16.
    F16,
}

impl Format {
    /// All of them, the widest first.
    pub const ALL: [Self; 5] = [Self::F64, Self::F32, Self::F24, Self::Bf16, Self::F16];

    /// The formats by their names.
    pub const NAMES: Names<Self> = &[
        ("f64", Self::F64),
        ("f32", Self::F32),
        ("f24", Self::F24),
        ("bf16", Self::Bf16),
        ("f16", Self::F16),
    ];

    /// Bits of a number.
    #[must_use]
    pub fn bits(self) -> u32 {
        match self {
            Self::F64 => 64,
            Self::F32 => 32,
            Self::F24 => 24,
            Self::Bf16 | Self::F16 => 16,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        name_of(Self::NAMES, &self)
    }
}

/// A kernel in a number format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Contestant {
    /// The triangle test.
    pub kernel: Kernel,
    /// The format that it computes in. The adaptive test has f32 alone.
    pub format: Format,
}

impl Contestant {
    /// All of them.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let formats = |kernel| Format::ALL.map(|format| Self { kernel, format });
        let exists = |it: &Self| it.kernel != Kernel::Adaptive || it.format == Format::F32;
        Kernel::ALL.into_iter().flat_map(formats).filter(exists).collect()
    }

    /// The contestant's answer to each case by the rule for edges, and the seconds of one thread for all: the least of
    /// `repeats` runs, without the preparation of rays and triangles.
    #[must_use]
    pub fn run(self, cases: &[Case], edges: Edges, repeats: u32) -> (Vec<Option<Found>>, f64) {
        match self.format {
            _ if self.kernel == Kernel::Adaptive => run_adaptive(cases, edges, repeats),
            Format::F64 => run_kernel::<Double>(self.kernel, cases, edges, repeats),
            Format::F32 => run_kernel::<f32>(self.kernel, cases, edges, repeats),
            Format::F24 => run_kernel::<F24>(self.kernel, cases, edges, repeats),
            Format::Bf16 => run_kernel::<Bf16>(self.kernel, cases, edges, repeats),
            Format::F16 => run_kernel::<F16>(self.kernel, cases, edges, repeats),
        }
    }
}

fn run_kernel<R: formats::Format>(
    kernel: Kernel,
    cases: &[Case],
    edges: Edges,
    repeats: u32,
) -> (Vec<Option<Found>>, f64) {
    match kernel {
        Kernel::MollerTrumbore => run_test::<R, EdgeTriangle<R>>(cases, edges, repeats),
        Kernel::Wald => run_test::<R, ProjectedTriangle<R>>(cases, edges, repeats),
        Kernel::Plucker => run_test::<R, PluckerTriangle<R>>(cases, edges, repeats),
        Kernel::Watertight => run_test::<R, WatertightTriangle<R>>(cases, edges, repeats),
        Kernel::Adaptive => run_adaptive(cases, edges, repeats),
    }
}

/// Cases with rays and triangles prepared, and room for the answers.
struct Prepared<P, T, H> {
    /// Each ray with the number of its triangles.
    rays: Vec<(P, usize)>,
    triangles: Vec<T>,
    found: Vec<Option<(u32, H)>>,
}

impl<P, T, H: Copy> Prepared<P, T, H> {
    fn new(cases: &[Case], ray: impl Fn(&Ray) -> P, triangle: impl Fn(&[glam::Vec3; 3]) -> T) -> Self {
        Self {
            rays: cases.iter().map(|case| (ray(&case.ray), case.triangles.len())).collect(),
            triangles: cases.iter().flat_map(|case| case.triangles.iter().map(&triangle)).collect(),
            found: vec![None; cases.len()],
        }
    }

    /// Runs `closest` on each case, and returns the seconds.
    #[inline(always)]
    fn timed(&mut self, repeats: u32, closest: impl Fn(&P, &[T]) -> Option<(u32, H)>) -> f64 {
        let mut least = f64::INFINITY;
        for _ in 0..repeats {
            let started = Instant::now();
            let mut triangles = black_box(&self.triangles[..]);
            for ((ray, count), found) in self.rays.iter().zip(&mut self.found) {
                let (own, rest) = triangles.split_at(*count);
                *found = closest(ray, own);
                triangles = rest;
            }
            black_box(&self.found);
            least = least.min(started.elapsed().as_secs_f64());
        }
        least
    }
}

/// The nearest hit within the ray's range; of two at the same distance the first (IS-2).
fn run_test<R: formats::Format, T: TriangleTest<R>>(
    cases: &[Case],
    edges: Edges,
    repeats: u32,
) -> (Vec<Option<Found>>, f64) {
    match edges {
        Edges::Shared => run_test_of::<R, T, false>(cases, repeats),
        Edges::Owned => run_test_of::<R, T, true>(cases, repeats),
    }
}

fn run_test_of<R: formats::Format, T: TriangleTest<R>, const OWNED: bool>(
    cases: &[Case],
    repeats: u32,
) -> (Vec<Option<Found>>, f64) {
    let ray = |ray: &Ray| {
        let from = T::ray(ray.origin.to_array(), ray.direction.to_array());
        (from, R::from_f32(ray.t_min), R::from_f32(ray.t_max))
    };
    let mut prepared = Prepared::new(cases, ray, T::new);
    let seconds = prepared.timed(repeats, |(ray, t_min, t_max), triangles| {
        let mut nearest: Option<(u32, Candidate<R>)> = None;
        for (place, triangle) in (0..).zip(triangles) {
            let found = triangle.intersect::<OWNED>(ray);
            let hit = found.inside & (found.t >= *t_min) & (found.t < *t_max);
            if hit && nearest.is_none_or(|(_, nearest)| found.t < nearest.t) {
                nearest = Some((place, found));
            }
        }
        nearest
    });
    let found = |hit: Option<(u32, Candidate<R>)>| {
        hit.map(|(triangle, found)| Found {
            triangle,
            t: found.t.to_f64(),
            weights: [found.u.to_f64(), found.v.to_f64()],
        })
    };
    (prepared.found.into_iter().map(found).collect(), seconds)
}

/// [`run_test`] by the adaptive test, which decides the order of hits itself.
fn run_adaptive(cases: &[Case], edges: Edges, repeats: u32) -> (Vec<Option<Found>>, f64) {
    let mut prepared = Prepared::new(cases, AdaptiveRay::new, AdaptiveTriangle::new);
    let seconds = prepared.timed(repeats, |ray, triangles| {
        let mut nearest: Option<(u32, AdaptiveHit)> = None;
        for (place, triangle) in (0..).zip(triangles) {
            let Some(hit) = triangle.intersect(edges, ray) else { continue };
            let nearer = |(_, nearest): &(u32, AdaptiveHit)| hit.order(nearest, ray.ray()) == Ordering::Less;
            if nearest.as_ref().is_none_or(nearer) {
                nearest = Some((place, hit));
            }
        }
        nearest.map(|(place, hit)| (place, hit.rounded()))
    });
    let found = |hit: Option<(u32, [f32; 3])>| {
        hit.map(|(triangle, [t, u, v])| Found {
            triangle,
            t: f64::from(t),
            weights: [f64::from(u), f64::from(v)],
        })
    };
    (prepared.found.into_iter().map(found).collect(), seconds)
}
