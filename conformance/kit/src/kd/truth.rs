//! What is true of a ray: which answers are right.
//!
//! With the adaptive test an answer has to be exact. With the others, each triangle has a distance and
//! weights with a derived bound ([`saarcor_oracles::bounded`]), by which it is hit, missed, or in doubt. Right is then
//! a triangle that is not missed, at its distance, if none that is hit is certainly nearer; and no hit, if
//! none is hit.

use super::request::Hit;
use super::scene_memory::LegalScene;
use glam::Vec3;
use saarcor_model::host::{Edges, Kernel, Registers};
use saarcor_model::rays::{
    Candidate, EdgeTriangle, Number, PluckerTriangle, Query, Ray, TriangleTest, WatertightTriangle,
};
use saarcor_oracles::bounded::Bounded;
use saarcor_oracles::exact::rational::nearest_f64;
use saarcor_oracles::exact::{Incidence, closest, is_owned_hit, judge, solve};

/// Why an answer is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The requirement that it breaks.
    pub requirement: &'static str,
    /// What is wrong, in a sentence.
    pub says: String,
}

/// Why an answer is right though it is not the model's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOpen {
    /// The requirement that leaves it open.
    pub requirement: &'static str,
    /// What leaves it open, in a sentence.
    pub says: String,
}

/// The answer breaks a requirement.
fn violates(requirement: &'static str, says: String) -> Result<(), Violation> {
    Err(Violation { requirement, says })
}

/// What is true of a ray.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Of each triangle of the scene that is not missed.
    candidates: Vec<PossibleHit>,
}

/// What is known of a ray and a triangle that it does not certainly miss.
#[derive(Clone, Copy, Debug)]
pub(super) struct PossibleHit {
    addr: u32,
    corners: [Vec3; 3],
    /// Its distance.
    pub(super) t: Bounded,
    u: Bounded,
    v: Bounded,
    /// It is certainly hit.
    pub(super) hit: bool,
}

/// The triangles that a ray may hit, with their places in the scene: all; where edges are owned, those that own what the
/// ray meets.
pub(super) fn candidates(scene: &LegalScene, ray: &Ray) -> impl Iterator<Item = (u32, [Vec3; 3])> {
    let numbered = (0..).zip(scene.corners.iter().copied());
    numbered.filter(|(_, corners)| scene.registers.edges == Edges::Shared || is_owned_hit(ray, corners))
}

impl Truth {
    /// Of a ray in a scene.
    #[must_use]
    pub fn new(scene: &LegalScene, ray: &Ray) -> Self {
        let triangles = scene.addresses.iter().zip(&scene.corners);
        let candidates = match scene.registers.kernel {
            // The first triangles alone: of those at the same distance the one at the lowest address.
            Kernel::Adaptive => {
                let first = closest(ray, candidates(scene, ray))
                    .and_then(|closest| closest.triangles.first().copied());
                let triangles = first.into_iter().map(|(place, _)| place as usize);
                let known =
                    |place: usize| PossibleHit::exact(scene.addresses[place], &scene.corners[place], ray);
                triangles.filter_map(known).collect()
            }
            _ => {
                let known = |(&addr, corners)| PossibleHit::new(&scene.registers, addr, corners, ray);
                triangles.filter_map(known).collect()
            }
        };
        Self { candidates }
    }

    /// What is wrong with an answer to what is hit first.
    ///
    /// # Errors
    /// The requirement that it breaks, and a sentence.
    pub fn check_closest(&self, answer: Option<&Hit>) -> Result<(), Violation> {
        let certain = || self.candidates.iter().filter(|known| known.hit);
        let Some(Hit { triangle: Some(addr), t, uv }) = answer.copied() else {
            return self.check_any(answer.is_some());
        };
        let Some(known) = self.candidates.iter().find(|known| known.addr == addr) else {
            let says = match certain().next() {
                Some(other) => {
                    format!("the triangle at {addr:x} is not hit first; the one at {:x} is", other.addr)
                }
                None => format!("the triangle at {addr:x} is not hit"),
            };
            return violates("KD-4", says);
        };
        let PossibleHit { t: distance, u, v, corners, .. } = known;
        if let Some(nearer) = certain().find(|other| other.t.is_below(distance.value - distance.error)) {
            let nearer = nearer.addr;
            let says = format!("the triangle at {addr:x} is not hit first; the one at {nearer:x} is nearer");
            return violates("KD-4", says);
        }
        // The same corners, or numbers that are not rounded, give the same distance in any implementation.
        let ties = |other: &&PossibleHit| {
            let exact = other.t.error == 0.0 && distance.error == 0.0 && other.t.value == distance.value;
            other.addr < addr && other.hit && (exact || other.corners == *corners)
        };
        if let Some(lower) = certain().find(ties) {
            return violates("IS-2", format!("the triangle at {:x} is hit at the same distance", lower.addr));
        }
        let [got_u, got_v] = [0, 1].map(|place| uv.map(|uv| uv[place]));
        for (name, right, got) in [("t", distance, t), ("u", u, got_u), ("v", v, got_v)] {
            if let Some(got) = got.filter(|&got| !right.allows(got)) {
                let says = format!("{name} is {got:e}; {} is right", within(right));
                return violates("IS-3", says);
            }
        }
        Ok(())
    }

    /// What leaves open that an answer that is right is not the model's; none where it says the same.
    #[must_use]
    pub fn left_open(&self, query: Query, got: Option<&Hit>, model: Option<&Hit>) -> Option<LeftOpen> {
        let of = |addr: Option<u32>| self.candidates.iter().find(|known| Some(known.addr) == addr);
        let (requirement, says) = match (query, got, model) {
            (Query::Closest, Some(got), Some(model)) if got.triangle == model.triangle => {
                let known = of(model.triangle)?;
                let [got_uv, model_uv] = [got, model].map(|hit| hit.uv.unwrap_or_default());
                let numbers = [
                    ("t", got.t, model.t, &known.t),
                    ("u", got.uv.map(|_| got_uv[0]), Some(model_uv[0]), &known.u),
                    ("v", got.uv.map(|_| got_uv[1]), Some(model_uv[1]), &known.v),
                ];
                let differ = numbers.into_iter().find(|(_, got, model, _)| got.is_some() && got != model);
                let (name, got, model, right) = differ?;
                let (got, model) = (got.unwrap_or_default(), model.unwrap_or_default());
                ("IS-3", format!("{name} is {got:e}, the model's {model:e}; {} is right", within(right)))
            }
            (Query::Closest, Some(got), Some(model)) => {
                let (other, known) = (of(got.triangle)?, of(model.triangle)?);
                let says = format!(
                    "the triangle at {:x} is hit at {}, the model's at {:x} at {}: neither is certainly nearer",
                    other.addr,
                    within(&other.t),
                    known.addr,
                    within(&known.t)
                );
                ("KD-4", says)
            }
            (Query::Any, Some(_), Some(_)) | (_, None, None) => return None,
            _ => {
                let says = self.candidates.iter().find(|known| !known.hit).map(PossibleHit::text)?;
                ("IS-1", format!("whether anything is hit is left open: {says}"))
            }
        };
        Some(LeftOpen { requirement, says })
    }

    /// What is known of the nearest triangles that are not certainly missed, a row each, for a person.
    #[must_use]
    pub fn rows(&self) -> Vec<String> {
        let mut nearest: Vec<&PossibleHit> = self.candidates.iter().collect();
        nearest.sort_by(|a, b| a.t.value.total_cmp(&b.t.value));
        let rows = nearest.iter().take(SHOWN_HITS).map(|known| format!("right: {}", known.text()));
        match nearest.is_empty() {
            true => vec!["right: no hit; every triangle is certainly missed".to_owned()],
            false => rows.collect(),
        }
    }

    /// What is wrong with an answer to whether anything is hit.
    ///
    /// # Errors
    /// The requirement that it breaks, and a sentence.
    pub fn check_any(&self, is_hit: bool) -> Result<(), Violation> {
        match self.candidates.iter().find(|known| known.hit) {
            Some(known) if !is_hit => violates("KD-4", format!("the triangle at {:x} is hit", known.addr)),
            None if is_hit && self.candidates.is_empty() => violates("KD-4", "nothing is hit".to_owned()),
            _ => Ok(()),
        }
    }
}

/// Triangles that are shown of a ray.
const SHOWN_HITS: usize = 4;

/// A number and its bound.
fn within(number: &Bounded) -> String {
    format!("{:e} ± {:.1e}", number.value, number.error)
}

impl PossibleHit {
    /// What is known, in words.
    fn text(&self) -> String {
        let Self { addr, t, u, v, hit, .. } = self;
        let (t, u, v) = (within(t), within(u), within(v));
        match hit {
            true => format!("the triangle at {addr:x} is hit, t = {t}, u = {u}, v = {v}"),
            false => format!(
                "the triangle at {addr:x} may be hit or missed, as t = {t}, u = {u} and v = {v} come within their bounds \
                 of its edges or of the ray's ends"
            ),
        }
    }

    /// Of a ray and a triangle by a test; none where it certainly misses the triangle.
    pub(super) fn new(registers: &Registers, addr: u32, corners: &[Vec3; 3], ray: &Ray) -> Option<Self> {
        let Registers { kernel, edges, .. } = *registers;
        let found = match kernel {
            Kernel::Adaptive if judge(ray, corners) == Incidence::Miss => None,
            Kernel::Adaptive if edges == Edges::Owned && !is_owned_hit(ray, corners) => None,
            Kernel::Adaptive => Self::exact(addr, corners, ray),
            Kernel::Plucker => Self::bounded::<PluckerTriangle<Bounded>>(addr, corners, ray),
            Kernel::Watertight => Self::bounded::<WatertightTriangle<Bounded>>(addr, corners, ray),
            Kernel::MollerTrumbore | Kernel::Wald => {
                Self::bounded::<EdgeTriangle<Bounded>>(addr, corners, ray)
            }
        }?;
        // A test that rounds may find a weight of 0, which is another's, where none is certainly more.
        let above = |weight: Bounded| weight.value - weight.error > 0.0;
        let owns = kernel == Kernel::Adaptive || edges == Edges::Shared;
        let hit = found.hit
            && (owns || [found.u, found.v, <Bounded>::ONE - (found.u + found.v)].into_iter().all(above));
        Some(Self { hit, ..found })
    }

    /// Of a triangle that the ray hits, in exact numbers.
    fn exact(addr: u32, corners: &[Vec3; 3], ray: &Ray) -> Option<Self> {
        let point = solve(ray, corners)?;
        let [t, u, v] = [point.t, point.u, point.v].map(|number| <Bounded>::nearly(nearest_f64(&number)));
        Some(Self { addr, corners: *corners, t, u, v, hit: true })
    }

    /// By what the test gives (IS-1, IS-2).
    fn bounded<T: TriangleTest<Bounded>>(addr: u32, corners: &[Vec3; 3], ray: &Ray) -> Option<Self> {
        let of_ray = T::ray(ray.origin.to_array(), ray.direction.to_array());
        let Candidate { t, u, v, .. } = T::new(corners).intersect::<false>(&of_ray);
        if t.is_undefined() {
            return None;
        }
        let weights = [u, v, <Bounded>::ONE - (u + v)];
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let outside = weights.iter().any(|weight| weight.is_below(0.0));
        if outside || t.is_below(t_min) || t.is_at_least(t_max) {
            return None;
        }
        let inside = weights.iter().all(|weight| weight.is_at_least(0.0));
        let hit = inside && t.is_at_least(t_min) && t.is_below(t_max);
        Some(Self { addr, corners: *corners, t, u, v, hit })
    }
}
