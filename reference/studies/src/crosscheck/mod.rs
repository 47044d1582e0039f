//! The model, the exact judge and Embree about the same rays: where they differ, and who is right.
//!
//! The exact judge decides every ray, also those on which all agree: they could be wrong together.
//! Besides, some rays are searched among all triangles with the model's own triangle test, so that
//! hits that its kd-tree traversal loses show without the judge's hierarchy (KD-4).

pub mod edges;
pub mod judge;
pub mod kept;
pub mod rays;

use crate::error::StudyError;
use crate::monitor::Monitor;
use crate::world::{Image, World};
use glam::Vec3;
use judge::{Answers, Class, Fault, Judge, JudgedRay};
use rayon::prelude::*;
use rays::{Question, RayKind, hit, traverse};
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::TRIANGLE_BYTES;
use saarcor_model::rays::{Hits, IntersectionUnit, Intervals, Packet, Query, Ray, StoredTriangle};
use saarcor_model::vm::HostAddr;
use saarcor_oracles::embree::{Embree, Hit};
use serde::Serialize;
use std::ops::AddAssign;

/// Triangle tests that the search among all triangles may take: seconds.
const SEARCH_TESTS: usize = 1 << 27;

/// Rays that are searched for together: a triangle is prepared once for all of them.
const SEARCH_PACKET: usize = 64;

/// Cases that one core judges in one go.
const BATCH: usize = 1 << 10;

/// Wrong answers, by how they are wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Faults {
    /// A triangle, where nothing is hit.
    pub wrong_hit: u64,
    /// Nothing, where a triangle is hit.
    pub wrong_miss: u64,
    /// Another triangle, at another distance.
    pub wrong_triangle: u64,
}

impl Faults {
    fn count(&mut self, fault: Option<Fault>) {
        match fault {
            Some(Fault::WrongHit) => self.wrong_hit += 1,
            Some(Fault::WrongMiss) => self.wrong_miss += 1,
            Some(Fault::WrongTriangle) => self.wrong_triangle += 1,
            None => {}
        }
    }
}

impl AddAssign for Faults {
    fn add_assign(&mut self, other: Self) {
        self.wrong_hit += other.wrong_hit;
        self.wrong_miss += other.wrong_miss;
        self.wrong_triangle += other.wrong_triangle;
    }
}

/// Rays by class: the classes add up to `rays`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ClassCounts {
    /// All rays.
    pub rays: u64,
    /// [`Class::Agree`].
    pub agree: u64,
    /// [`Class::Tie`].
    pub tie: u64,
    /// [`Class::Edge`].
    pub edge: u64,
    /// [`Class::WithinBound`].
    pub within_bound: u64,
    /// [`Class::EmbreeWrong`].
    pub embree_wrong: u64,
    /// [`Class::ModelWrong`].
    pub model_wrong: u64,
    /// Embree with its flag for robust intersection.
    pub embree_robust: Faults,
    /// Embree by default.
    pub embree_fast: Faults,
}

impl ClassCounts {
    fn of<'a>(cases: impl IntoIterator<Item = &'a JudgedRay>) -> Self {
        let mut counts = Self::default();
        for case in cases {
            counts.rays += 1;
            *match case.class {
                Class::Agree => &mut counts.agree,
                Class::Tie => &mut counts.tie,
                Class::Edge => &mut counts.edge,
                Class::WithinBound => &mut counts.within_bound,
                Class::EmbreeWrong => &mut counts.embree_wrong,
                Class::ModelWrong => &mut counts.model_wrong,
            } += 1;
            counts.embree_robust.count(case.robust);
            counts.embree_fast.count(case.fast);
        }
        counts
    }
}

/// The result of a cross-check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CrosscheckReport {
    /// The scene, as the user named it.
    pub scene: String,
    /// The model's triangle test.
    pub kernel: &'static str,
    /// All rays together.
    #[serde(flatten)]
    pub all: ClassCounts,
    /// Rays that were searched among all triangles as well. One for which the model's traversal
    /// answers otherwise is among `model_wrong`.
    pub searched: u64,
    #[serde(skip)]
    kinds: [ClassCounts; RayKind::ALL.len()],
}

impl CrosscheckReport {
    /// The rays of each kind.
    pub fn by_kind(&self) -> impl Iterator<Item = (RayKind, &ClassCounts)> {
        RayKind::ALL.into_iter().zip(&self.kinds)
    }
}

/// Asks model, judge and Embree about `questions`, and classifies each.
///
/// # Errors
/// If Embree does not run.
pub fn crosscheck(
    world: &World,
    kernel: &'static str,
    triangles: &[[Vec3; 3]],
    questions: &[Question],
    embree: &Embree,
    monitor: &dyn Monitor,
) -> Result<(CrosscheckReport, Vec<JudgedRay>), StudyError> {
    let rays: Vec<Ray> = questions.iter().map(|question| question.ray).collect();
    let name = |what: &str| format!("{}: {what}", world.name);
    let theirs = monitor.during(&name("Embree"), |_| embree.intersect(triangles, &rays))?;
    let [closest, any] = monitor.during(&name("model"), |_| {
        [Query::Closest, Query::Any].map(|query| traverse(&world.image, &rays, query))
    });
    let mut cases: Vec<JudgedRay> = monitor.during(&name("exact judge"), |_| {
        let judge = Judge::new(triangles, &world.image);
        let case = |place: usize| {
            let (model, any) = (closest[place], any[place].is_some());
            let answers = Answers { model, any, robust: theirs.robust[place], fast: theirs.fast[place] };
            judge.judged(questions[place], answers)
        };
        (0..questions.len()).into_par_iter().with_min_len(BATCH).map(case).collect()
    });
    // Spread over all rays, and so over all kinds.
    let sampled = (SEARCH_TESTS / triangles.len().max(1)).clamp(1, rays.len().max(1));
    let places: Vec<usize> = (0..rays.len()).step_by(rays.len().div_ceil(sampled).max(1)).collect();
    let found = monitor.during(&name("search among all triangles"), |_| {
        let rays: Vec<Ray> = places.iter().map(|&place| rays[place]).collect();
        search(&world.image, triangles, &rays)
    });
    for (&place, found) in places.iter().zip(&found) {
        if *found != closest[place] {
            cases[place].class = Class::ModelWrong;
        }
    }
    let of_kind = |kind| ClassCounts::of(cases.iter().filter(|case| case.question.kind == kind));
    let report = CrosscheckReport {
        scene: world.name.clone(),
        kernel,
        all: ClassCounts::of(&cases),
        searched: places.len() as u64,
        kinds: RayKind::ALL.map(of_kind),
    };
    Ok((report, cases))
}

/// The first hits by the model's triangle test among all triangles of the image, without a tree.
#[must_use]
pub fn search(image: &Image, triangles: &[[Vec3; 3]], rays: &[Ray]) -> Vec<Option<Hit>> {
    let first = image.registers.triangles.0;
    let stored = (first..).step_by(TRIANGLE_BYTES as usize).zip(image.triangle_ids()).map(|(addr, id)| {
        StoredTriangle::new(
            HostAddr(addr),
            image.registers.kernel,
            image.registers.edges,
            &triangles[id as usize],
        )
    });
    let stored: Vec<StoredTriangle> = stored.collect();
    let found = rays.par_chunks(SEARCH_PACKET).flat_map_iter(|rays| {
        let packet: Packet<SEARCH_PACKET> = Packet::new(std::array::from_fn(|lane| rays.get(lane).copied()));
        let (mut unit, mut hits) = (FilteredIntersection::default(), Hits::none(&packet));
        let everywhere = Intervals { enter: packet.t_min, leave: packet.t_max };
        for triangle in &stored {
            unit.intersect(triangle, &packet, &everywhere, Query::Closest, &mut hits);
        }
        (0..rays.len()).map(move |lane| hit(image, &hits, lane))
    });
    found.collect()
}
