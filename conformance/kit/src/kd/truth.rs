//! What is true of a ray: which answers are right.
//!
//! With the adaptive test an answer has to be exact. With the others, each triangle has a distance and
//! weights with a derived bound ([`saarcor_oracles::bounded`]), by which it is hit, missed, or in doubt. Right is then
//! a triangle that is not missed, at its distance, if none that is hit is certainly nearer; and no hit, if
//! none is hit.

use super::request::Hit;
use super::scene_memory::LegalScene;
use glam::Vec3;
use saarcor_model::host::Kernel;
use saarcor_model::rays::{
    Candidate, EdgeTriangle, Number, PluckerTriangle, Ray, TriangleTest, WatertightTriangle,
};
use saarcor_oracles::bounded::Bounded;
use saarcor_oracles::exact::rational::nearest_f64;
use saarcor_oracles::exact::{Incidence, closest, judge, solve};

/// Why an answer is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The requirement that it breaks.
    pub requirement: &'static str,
    /// What is wrong, in a sentence.
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

impl Truth {
    /// Of a ray in a scene.
    #[must_use]
    pub fn new(scene: &LegalScene, ray: &Ray) -> Self {
        let triangles = scene.addresses.iter().zip(&scene.corners);
        let candidates = match scene.registers.kernel {
            // The first triangles alone: of those at the same distance the one at the lowest address.
            Kernel::Adaptive => {
                let numbered = (0..).zip(scene.corners.iter().copied());
                let first = closest(ray, numbered).and_then(|closest| closest.triangles.first().copied());
                let triangles = first.into_iter().map(|(place, _)| place as usize);
                let known =
                    |place: usize| PossibleHit::exact(scene.addresses[place], &scene.corners[place], ray);
                triangles.filter_map(known).collect()
            }
            kernel => {
                let known = |(&addr, corners)| PossibleHit::new(kernel, addr, corners, ray);
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
                let says = format!("{name} is {got:e}; {:e} ± {:.1e} is right", right.value, right.error);
                return violates("IS-3", says);
            }
        }
        Ok(())
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

impl PossibleHit {
    /// Of a ray and a triangle by a test; none where it certainly misses the triangle.
    pub(super) fn new(kernel: Kernel, addr: u32, corners: &[Vec3; 3], ray: &Ray) -> Option<Self> {
        match kernel {
            Kernel::Adaptive if judge(ray, corners) == Incidence::Miss => None,
            Kernel::Adaptive => Self::exact(addr, corners, ray),
            Kernel::Plucker => Self::bounded::<PluckerTriangle<Bounded>>(addr, corners, ray),
            Kernel::Watertight => Self::bounded::<WatertightTriangle<Bounded>>(addr, corners, ray),
            Kernel::MollerTrumbore | Kernel::Wald => {
                Self::bounded::<EdgeTriangle<Bounded>>(addr, corners, ray)
            }
        }
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
        let Candidate { t, u, v, .. } = T::new(corners).intersect(&of_ray);
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
