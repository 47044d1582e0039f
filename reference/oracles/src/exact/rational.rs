//! The answer in rational numbers.
//!
//! With the corners `A`, `B`, `C` counted from the ray's origin and its direction `d`, the volumes
//! `d · (B × C)`, `d · (C × A)`, `d · (A × B)` are the weights of the three corners at the point
//! where the ray's line meets the plane, times their sum. The ray meets the triangle where none of
//! them has another sign than their sum, which is the direction times the normal; the distance is
//! `A · (B × C)` over that sum (Möller and Trumbore 1997, by Cramer's rule).

use super::{Contact, Incidence};
use dashu_ratio::{RBig, Relaxed};
use glam::Vec3;
use saarcor_model::rays::Ray;
use std::cmp::Ordering;

/// Three coordinates or components.
type Triple = [Relaxed; 3];

/// The same number. `None` for NaN and infinity.
#[must_use]
pub fn number(value: f32) -> Option<Relaxed> {
    Relaxed::try_from(value).ok()
}

/// `None` where a component is NaN or infinite.
fn triple(vector: Vec3) -> Option<Triple> {
    Some([number(vector.x)?, number(vector.y)?, number(vector.z)?])
}

fn sub(a: &Triple, b: &Triple) -> Triple {
    std::array::from_fn(|axis| &a[axis] - &b[axis])
}

fn cross(a: &Triple, b: &Triple) -> Triple {
    std::array::from_fn(|axis| {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        &a[p] * &b[q] - &a[q] * &b[p]
    })
}

fn dot(a: &Triple, b: &Triple) -> Relaxed {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// What a ray's line and a triangle's plane have in common.
struct Volumes {
    /// The weights of the corners, times `sum`.
    weights: [Relaxed; 3],
    /// Not zero.
    sum: Relaxed,
    /// The distance, times `sum`.
    height: Relaxed,
}

impl Volumes {
    /// `None` where line and plane have not just one point in common, or a number is none.
    fn new(ray: &Ray, corners: &[Vec3; 3]) -> Option<Self> {
        Self::from(&triple(ray.origin)?, ray.direction, corners)
    }

    /// Of the ray from `origin` along `direction`.
    fn from(origin: &Triple, direction: Vec3, corners: &[Vec3; 3]) -> Option<Self> {
        let direction = triple(direction)?;
        let [a, b, c] = corners.map(triple);
        let (a, b, c) = (sub(&a?, origin), sub(&b?, origin), sub(&c?, origin));
        let b_c = cross(&b, &c);
        let weights =
            [dot(&direction, &b_c), dot(&direction, &cross(&c, &a)), dot(&direction, &cross(&a, &b))];
        let sum = &weights[0] + &weights[1] + &weights[2];
        (!sum.is_zero()).then(|| Self { weights, sum, height: dot(&a, &b_c) })
    }

    /// The sign of a number, as seen from that of the sum.
    fn sign(&self, number: &Relaxed) -> Ordering {
        let sign = number.cmp(&Relaxed::ZERO);
        if self.sum > Relaxed::ZERO { sign } else { sign.reverse() }
    }

    /// How the distance compares to `bound`; `None` where that is NaN.
    fn distance_to(&self, bound: f32) -> Option<Ordering> {
        match number(bound) {
            Some(bound) => Some(self.sign(&(&self.height - bound * &self.sum))),
            None if bound.is_nan() => None,
            None if bound > 0.0 => Some(Ordering::Less),
            None => Some(Ordering::Greater),
        }
    }
}

/// Whether `ray` hits the triangle, and where: [`super::judge`] without its filter.
#[must_use]
pub fn incidence(ray: &Ray, corners: &[Vec3; 3]) -> Incidence {
    let Some(volumes) = Volumes::new(ray, corners) else { return Incidence::Miss };
    let signs: [_; 3] = std::array::from_fn(|corner| volumes.sign(&volumes.weights[corner]));
    let in_range = matches!(volumes.distance_to(ray.t_min), Some(Ordering::Greater | Ordering::Equal))
        && matches!(volumes.distance_to(ray.t_max), Some(Ordering::Less));
    if !in_range || signs.contains(&Ordering::Less) {
        return Incidence::Miss;
    }
    let zero: Vec<usize> = (0..3).filter(|&corner| signs[corner] == Ordering::Equal).collect();
    Incidence::Hit(match zero[..] {
        [] => Contact::Interior,
        [corner] => Contact::Edge(corner),
        // The weights add up to one, so that not all are zero: the third corner is the one met.
        [a, b, ..] => Contact::Vertex(3 - a - b),
    })
}

/// The sign of `direction · ((b - a) × (c - a))`; `Equal` where a number is none.
pub(super) fn volume_sign(direction: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Ordering {
    side_of(direction, b, a, c, a).unwrap_or(Ordering::Equal)
}

/// The sign of `direction · (along × (point - origin))`; `Equal` where a number is none.
pub(super) fn side(direction: Vec3, along: Vec3, point: Vec3, origin: Vec3) -> Ordering {
    side_of(direction, along, Vec3::ZERO, point, origin).unwrap_or(Ordering::Equal)
}

/// The sign of `direction · ((p - from_p) × (q - from_q))`.
fn side_of(direction: Vec3, p: Vec3, from_p: Vec3, q: Vec3, from_q: Vec3) -> Option<Ordering> {
    let (p, q) = (sub(&triple(p)?, &triple(from_p)?), sub(&triple(q)?, &triple(from_q)?));
    Some(dot(&triple(direction)?, &cross(&p, &q)).cmp(&Relaxed::ZERO))
}

/// Whether a triangle that `ray` hits is one that it hits where edges are owned (IS-6): once its origin is moved by
/// (ε, ε², ε³), where ε > 0 is as small as may be.
///
/// A weight is linear in the origin: it grows by ε times by how much it is more at an origin that lies 1 further along
/// x, and by ε² and ε³ times those along y and z. Where it is 0, the first of these that is not 0 decides.
#[must_use]
pub fn owns(ray: &Ray, corners: &[Vec3; 3]) -> bool {
    let at = |axis: Option<usize>| {
        let mut origin = triple(ray.origin)?;
        if let Some(axis) = axis {
            origin[axis] += Relaxed::ONE;
        }
        let volumes = Volumes::from(&origin, ray.direction, corners)?;
        Some(std::array::from_fn::<_, 3, _>(|corner| volumes.sign(&volumes.weights[corner])))
    };
    let (Some(here), Some(x), Some(y), Some(z)) = (at(None), at(Some(0)), at(Some(1)), at(Some(2))) else {
        return false;
    };
    let moved = |corner: usize| here[corner].then(x[corner]).then(y[corner]).then(z[corner]);
    (0..3).all(|corner| moved(corner).is_gt())
}

/// The point where a ray's line meets a triangle's plane, whether within triangle and range or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Solution {
    /// Distance along the ray, in lengths of its direction.
    pub t: RBig,
    /// Barycentric weight of the second corner.
    pub u: RBig,
    /// Barycentric weight of the third corner.
    pub v: RBig,
}

/// The point where the line of `ray` meets the plane of the triangle. `None` where they have not
/// just one point in common, or a number is NaN or infinite.
///
/// ```
/// use glam::Vec3;
/// use saarcor_model::rays::Ray;
/// use saarcor_oracles::exact::{rational::nearest_f32, solve};
/// let ray = Ray { origin: Vec3::NEG_Z, direction: Vec3::Z * 3.0, t_min: 0.0, t_max: f32::INFINITY };
/// let point = solve(&ray, &[Vec3::ZERO, Vec3::X, Vec3::Y]).expect("not parallel");
/// assert_eq!(point.t, dashu_ratio::RBig::from_parts(1.into(), 3u8.into()));
/// assert_eq!(nearest_f32(&point.t), 1.0 / 3.0);
/// ```
#[must_use]
pub fn solve(ray: &Ray, corners: &[Vec3; 3]) -> Option<Solution> {
    let Volumes { weights: [_, u, v], sum, height } = Volumes::new(ray, corners)?;
    let over_sum = |number: Relaxed| (number / &sum).canonicalize();
    Some(Solution { t: over_sum(height), u: over_sum(u), v: over_sum(v) })
}

/// The distance of [`solve`] alone.
#[must_use]
pub fn distance(ray: &Ray, corners: &[Vec3; 3]) -> Option<Relaxed> {
    let Volumes { sum, height, .. } = Volumes::new(ray, corners)?;
    Some(height / sum)
}

/// The f32 nearest to `number`; of two, the even one. Infinite where it is beyond all of them.
#[must_use]
pub fn nearest_f32(number: &RBig) -> f32 {
    number.to_f32().value()
}

/// The f64 nearest to `number`; of two, the even one. Infinite where it is beyond all of them.
#[must_use]
pub fn nearest_f64(number: &RBig) -> f64 {
    number.to_f64().value()
}
