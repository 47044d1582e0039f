//! A ray against triangles without any rounding: the judge of every triangle test.
//!
//! Corners, origin, direction and range are f32, and so rational numbers. The answer is computed
//! from them in rationals ([`rational`]); no tolerance stands anywhere. Most questions are answered
//! by a filter in front ([`filter`]), which computes in f64 and says nothing where its error bound
//! leaves a doubt.
//!
//! Rules where the geometry alone does not decide (IS-1, IS-2):
//!
//! * Edges and vertices belong to the triangle; where they are owned, to one of those that have them
//!   ([`is_owned_hit`]).
//! * A hit counts if `t_min ≤ t < t_max`.
//! * A ray in the triangle's plane, a triangle without area and a ray without direction are misses:
//!   they have no one point in common.
//! * NaN or infinity in origin, direction or corners is a miss. An infinite end of the range is no
//!   end; one that is NaN is a miss.
//! * −0.0 is 0.

pub mod crossings;
pub mod filter;
pub mod rational;

pub use rational::{Solution, solve};

use filter::{Distance, Estimate};
use glam::Vec3;
use saarcor_model::rays::Ray;
use std::cmp::Ordering;

/// Which part of a triangle a ray meets. Corners count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Contact {
    /// Neither an edge nor a vertex.
    Interior,
    /// The edge opposite to this corner, and no vertex.
    Edge(usize),
    /// This corner.
    Vertex(usize),
}

/// What is true of a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Incidence {
    /// They have no point in common within the ray's range.
    Miss,
    /// They have one.
    Hit(Contact),
}

impl Incidence {
    /// Whether the triangle is hit, wherever.
    #[must_use]
    pub fn is_hit(self) -> bool {
        self != Self::Miss
    }
}

/// Whether `ray` hits the triangle with these corners, and where.
///
/// ```
/// use glam::Vec3;
/// use saarcor_model::rays::Ray;
/// use saarcor_oracles::exact::{Contact, Incidence, judge};
/// let ray = |x, y| Ray { origin: Vec3::new(x, y, -1.0), direction: Vec3::Z, t_min: 0.0, t_max: 2.0 };
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// assert_eq!(judge(&ray(0.25, 0.25), &corners), Incidence::Hit(Contact::Interior));
/// assert_eq!(judge(&ray(0.5, 0.5), &corners), Incidence::Hit(Contact::Edge(0)));
/// assert_eq!(judge(&ray(0.0, 1.0), &corners), Incidence::Hit(Contact::Vertex(2)));
/// assert_eq!(judge(&ray(0.5, 0.5 + f32::EPSILON), &corners), Incidence::Miss);
/// ```
#[must_use]
pub fn judge(ray: &Ray, corners: &[Vec3; 3]) -> Incidence {
    Estimate::new(ray, corners).incidence().unwrap_or_else(|| rational::incidence(ray, corners))
}

/// Whether `ray` hits the triangle where edges are owned (IS-6), so that of the triangles around an edge or a vertex one
/// has it.
///
/// ```
/// use glam::Vec3;
/// use saarcor_model::rays::Ray;
/// use saarcor_oracles::exact::is_owned_hit;
/// let ray = |x, y| Ray { origin: Vec3::new(x, y, -1.0), direction: Vec3::Z, t_min: 0.0, t_max: 2.0 };
/// let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE.with_z(0.0)];
/// // Moved along x, the ray passes from the one to the other.
/// assert!(!is_owned_hit(&ray(0.5, 0.5), &[a, b, c]) && is_owned_hit(&ray(0.5, 0.5), &[b, d, c]));
/// ```
#[must_use]
pub fn is_owned_hit(ray: &Ray, corners: &[Vec3; 3]) -> bool {
    match judge(ray, corners) {
        Incidence::Miss => false,
        Incidence::Hit(Contact::Interior) => true,
        Incidence::Hit(_) => rational::owns(ray, corners),
    }
}

/// What a ray hits first among triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closest {
    /// The triangles hit at the least distance, by ascending number, with the part that is hit:
    /// any of them is a right answer.
    pub triangles: Vec<(u32, Contact)>,
}

impl Closest {
    /// Whether the triangle of this number is among those that are hit first.
    #[must_use]
    pub fn contains(&self, number: u32) -> bool {
        self.triangles.iter().any(|(triangle, _)| *triangle == number)
    }
}

/// A triangle that may be the first one hit.
struct Candidate {
    number: u32,
    corners: [Vec3; 3],
    contact: Contact,
    distance: Distance,
}

/// The first of `triangles` that `ray` hits, with all that it hits at the very same distance;
/// `None` where it hits nothing. Each triangle comes with a number of the caller's.
///
/// ```
/// use glam::Vec3;
/// use saarcor_model::rays::Ray;
/// use saarcor_oracles::exact::closest;
/// let ray = Ray { origin: Vec3::NEG_Z, direction: Vec3::Z, t_min: 0.0, t_max: f32::INFINITY };
/// let at = |z| [Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)];
/// let first = closest(&ray, [(7, at(2.0)), (8, at(1.0)), (9, at(1.0))]).expect("hit");
/// assert!(!first.contains(7) && first.contains(8) && first.contains(9));
/// ```
pub fn closest(ray: &Ray, triangles: impl IntoIterator<Item = (u32, [Vec3; 3])>) -> Option<Closest> {
    let mut candidates: Vec<Candidate> = Vec::new();
    // No less than the least distance.
    let mut nearest = f64::INFINITY;
    for (number, corners) in triangles {
        let estimate = Estimate::new(ray, &corners);
        let incidence = estimate.incidence().unwrap_or_else(|| rational::incidence(ray, &corners));
        let Incidence::Hit(contact) = incidence else { continue };
        let distance = estimate.distance();
        if distance.least <= nearest {
            nearest = nearest.min(distance.greatest);
            candidates.push(Candidate { number, corners, contact, distance });
        }
    }
    candidates.retain(|candidate| candidate.distance.least <= nearest);
    if candidates.len() > 1 {
        keep_nearest(ray, &mut candidates);
    }
    let mut triangles: Vec<_> = candidates.iter().map(|it| (it.number, it.contact)).collect();
    triangles.sort_unstable_by_key(|(number, _)| *number);
    (!triangles.is_empty()).then_some(Closest { triangles })
}

/// Leaves the candidates of the least distance.
fn keep_nearest(ray: &Ray, candidates: &mut Vec<Candidate>) {
    let distances: Vec<_> = candidates.iter().map(|it| rational::distance(ray, &it.corners)).collect();
    let least = distances.iter().flatten().min().cloned();
    let mut distances = distances.iter();
    candidates.retain(|_| distances.next().is_some_and(|distance| *distance == least));
}

/// Which of two triangles that `ray` hits it hits first; `Equal` where they are hit at the very
/// same distance, or where either has no one point in common with the ray's line.
#[must_use]
pub fn order(ray: &Ray, a: &[Vec3; 3], b: &[Vec3; 3]) -> Ordering {
    let (first, second) = (Estimate::new(ray, a).distance(), Estimate::new(ray, b).distance());
    if first.greatest < second.least {
        Ordering::Less
    } else if second.greatest < first.least {
        Ordering::Greater
    } else {
        let distances = rational::distance(ray, a).zip(rational::distance(ray, b));
        distances.map_or(Ordering::Equal, |(a, b)| a.cmp(&b))
    }
}
