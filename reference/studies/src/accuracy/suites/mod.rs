//! Hard cases. Each suite is one idea, described in one comment; a case depends on the suite, the
//! seed and its number alone.

mod basic;
mod contact;
mod meshes;
mod numbers;
mod order;
mod shadow;

pub use shadow::{OffsetFaults, OffsetRow, offset_faults, offset_rows};

use super::case::Case;
use glam::Vec3;
use saarcor_model::rays::Ray;
use saarcor_scenes::Random;

/// A generator of cases.
#[derive(Clone, Copy, Debug)]
pub struct Suite {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its idea.
    pub idea: &'static str,
    /// The surface is closed around the ray: a ray that is lost there leaks.
    pub closed: bool,
    /// The cases are built on exact coincidence, which only exact arithmetic decides.
    pub degenerate: bool,
    generate: fn(&mut Random) -> Case,
}

/// All suites.
pub const SUITES: [Suite; 19] = [
    basic::GENERIC,
    contact::SHARED_EDGE,
    contact::VERTEX,
    contact::EXACT,
    basic::SLIVERS,
    basic::GRAZING,
    numbers::FAR,
    numbers::SCALES,
    numbers::ZERO_COMPONENTS,
    numbers::DENORMAL,
    contact::IN_PLANE,
    contact::ZERO_AREA,
    order::RANGE_ENDS,
    order::COPLANAR_PAIRS,
    contact::SPLIT_PLANES,
    meshes::SPHERE,
    meshes::TORUS,
    meshes::SCANNED,
    shadow::SHADOW,
];

impl Suite {
    /// The suite of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        SUITES.iter().find(|suite| suite.name == name)
    }

    /// One case.
    #[must_use]
    pub fn case(&self, seed: u64, number: u64) -> Case {
        // Each suite draws from sequences of its own, and each case from one of its own.
        let suite = self.name.bytes().fold(seed, |hash, byte| Random::new(hash ^ u64::from(byte)).bits());
        (self.generate)(&mut Random::new(Random::new(suite ^ number).bits()))
    }
}

/// A point of the cube around the origin that reaches from -1 to 1.
fn point(random: &mut Random) -> Vec3 {
    Vec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0))
}

/// Three of them.
fn triangle(random: &mut Random) -> [Vec3; 3] {
    [point(random), point(random), point(random)]
}

/// 10 to the power of a number between two exponents.
fn power_of_ten(random: &mut Random, low: f32, high: f32) -> f32 {
    libm::powf(10.0_f32, random.between(low, high))
}

/// The point of a triangle with these weights of the second and the third corner.
fn at([a, b, c]: &[Vec3; 3], u: f32, v: f32) -> Vec3 {
    *a * (1.0 - u - v) + *b * u + *c * v
}

/// A ray of any distance.
fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// A ray from `origin` through `point`, of random length.
fn towards(random: &mut Random, origin: Vec3, point: Vec3) -> Ray {
    ray(origin, (point - origin) * random.between(0.5, 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::case::Truth;
    use saarcor_model::host::Edges;
    use std::collections::BTreeSet;

    #[test]
    fn names_are_different() {
        let names: BTreeSet<_> = SUITES.iter().map(|suite| suite.name).collect();
        assert_eq!(names.len(), SUITES.len());
    }

    #[test]
    fn cases_depend_on_seed_and_number_alone() {
        for suite in &SUITES {
            assert_eq!(suite.case(1, 7), suite.case(1, 7));
            assert!((0..20).any(|number| suite.case(1, number) != suite.case(2, number)), "{}", suite.name);
        }
    }

    #[test]
    fn every_suite_has_hits_and_closed_ones_nothing_else() {
        for suite in &SUITES {
            let hits = (0..500)
                .filter(|&number| !Truth::of(&suite.case(3, number), Edges::Shared).0.is_empty())
                .count();
            assert!(hits > 25 || suite.name == "in-plane", "{}: {hits} hits of 500", suite.name);
            assert!(hits == 500 || !suite.closed, "{}: {hits} hits of 500", suite.name);
        }
    }
}
