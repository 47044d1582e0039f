//! Which cases of traversal and intersection sessions reach.

use super::oracle::KdOracle;
use super::request::Request;
use super::scene_memory::LegalScene;
use super::walk::{Step, reciprocals, steps};
use crate::coverage::{Coverage, CoverageCount};
use crate::kind::Oracle;
use crate::session::Session;
use saarcor_model::host::{Axis, MAX_DEPTH};
use saarcor_model::rays::{Children, Ray};
use std::collections::BTreeSet;

/// How a ray goes to a plane, by the reciprocal of its direction across it.
const COURSES: [&str; 5] = ["upwards", "downwards", "parallel", "parallel as -0", "without a bound"];
/// The children that a ray may go to. One that goes down goes above first, one without a bound below.
const VISITED: [Children; 4] = [Children::Below, Children::Above, Children::BelowFirst, Children::AboveFirst];
/// What can happen in leaves and with triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum LeafCase {
    /// A leaf without triangles.
    Empty,
    /// A leaf with one.
    OneTriangle,
    /// A leaf with several.
    SeveralTriangles,
    /// A cell from the stack that is visited after a hit.
    VisitedAfterHit,
    /// A cell from the stack that lies behind the hit.
    Culled,
    /// A triangle that is hit first.
    FirstHit,
    /// A triangle that is nearer than the hit so far.
    NearerHit,
    /// A triangle that is no nearer than the hit so far, or missed after a hit.
    NotNearer,
}
/// Cases of [`LeafCase`].
const LEAF_CASES: usize = LeafCase::NotNearer as usize + 1;
/// Children on the stack at once, from one number to below the next: up to its room.
const PUT_OFF: [usize; 5] = [1, 2, 8, MAX_DEPTH, MAX_DEPTH + 1];

/// A case: axis, course and children.
type PlaneCase = (usize, usize, usize);

/// What was reached.
#[derive(Clone, Debug, Default)]
pub struct KdCoverage {
    planes: BTreeSet<PlaneCase>,
    leaves: BTreeSet<LeafCase>,
    put_off: BTreeSet<usize>,
}

/// Which course a reciprocal is.
fn course(reciprocal: f32) -> usize {
    match reciprocal {
        r if r.is_nan() => 4,
        r if r == f32::INFINITY => 2,
        r if r == f32::NEG_INFINITY => 3,
        r => usize::from(r < 0.0),
    }
}

/// Whether a ray of that course can go to those children. Of a ray that is parallel or in the plane,
/// the sign of its zero says which child is first.
fn is_possible(course: usize, visited: Children) -> bool {
    match visited {
        Children::Below | Children::Above => course != 4,
        Children::BelowFirst => matches!(course, 0 | 2 | 4),
        Children::AboveFirst => matches!(course, 1 | 3),
    }
}

impl KdCoverage {
    fn ray(&mut self, memory: &[u8], scene: &LegalScene, ray: &Ray) {
        let reciprocals = reciprocals(scene, ray);
        for step in steps(memory, scene, ray) {
            match step {
                Step::Inner { axis, visited, put_off, .. } => {
                    let place = VISITED.iter().position(|known| *known == visited).unwrap_or_default();
                    self.planes.insert((axis as usize, course(reciprocals[axis as usize]), place));
                    if let Some(place) =
                        PUT_OFF.windows(2).position(|ends| (ends[0]..ends[1]).contains(&put_off))
                    {
                        self.put_off.insert(place);
                    }
                }
                Step::Leaf { count, after_hit, .. } => {
                    self.leaves.insert(match count {
                        0 => LeafCase::Empty,
                        1 => LeafCase::OneTriangle,
                        _ => LeafCase::SeveralTriangles,
                    });
                    self.leaves.extend(after_hit.then_some(LeafCase::VisitedAfterHit));
                }
                Step::Culled => {
                    self.leaves.insert(LeafCase::Culled);
                }
                Step::Test { taken, replaces, .. } => {
                    self.leaves.extend(match (taken, replaces) {
                        (true, false) => Some(LeafCase::FirstHit),
                        (true, true) => Some(LeafCase::NearerHit),
                        (false, true) => Some(LeafCase::NotNearer),
                        (false, false) => None,
                    });
                }
            }
        }
    }
}

impl Coverage for KdCoverage {
    fn add(&mut self, session: &Session) {
        let Ok(mut model) = KdOracle::new(Oracle::Model, session.config()) else { return };
        for request in session.requests().filter_map(|request| Request::parse(request).ok()) {
            let Request::Trace(_, ray) = &request else {
                model.change(&request);
                continue;
            };
            if let Ok((scene, memory)) = model.scene() {
                self.ray(memory, scene, ray);
            }
        }
    }

    fn counts(&self) -> Vec<CoverageCount> {
        let mut rows = Vec::new();
        for (course, name) in COURSES.iter().enumerate() {
            let children = VISITED.iter().filter(|visited| is_possible(course, **visited)).count();
            rows.push(CoverageCount {
                what: format!("axes × children of a ray that goes {name}"),
                reached: self.planes.iter().filter(|(_, known, _)| *known == course).count(),
                all: children * Axis::ALL.len(),
            });
        }
        rows.push(CoverageCount {
            what: "what becomes of leaves and triangles".to_owned(),
            reached: self.leaves.len(),
            all: LEAF_CASES,
        });
        rows.push(CoverageCount {
            what: format!("children put off at once: 1, up to 7, up to {}, {MAX_DEPTH}", MAX_DEPTH - 1),
            reached: self.put_off.len(),
            all: PUT_OFF.len() - 1,
        });
        rows
    }
}
