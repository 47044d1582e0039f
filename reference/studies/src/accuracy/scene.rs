//! The cheapest contestant that is accurate enough on a scene's own rays.

use super::case::Case;
use super::contest::{Contestant, Format};
use super::measure::{AccuracyRow, measure_cases};
use crate::error::{ParseError, StudyError};
use crate::world::World;
use glam::Vec3;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::{Edges, Kernel, TRIANGLE_BYTES};
use saarcor_model::rays::{Frame, Hits, Packet, Query, Ray, Traversal};
use saarcor_model::vm::{HostAddr, Observed, Observer, Unit, WholeScene};
use saarcor_scenes::Random;
use std::str::FromStr;

/// The picture whose rays are taken, as in the paper.
const PICTURE: (u32, u32) = (1024, 768);

/// How much error is allowed: `WRONG` or `WRONG,ULP`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Wrong answers in a million rays.
    pub wrong_per_million: f64,
    /// Error of the distance, in ulps of f32, that 99.9 % of the right hits stay inside.
    pub t_ulp: f64,
}

impl FromStr for Budget {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let right = "write the wrong answers allowed in a million rays and, after a comma, the ulps that 99.9 % of \
                     the distances may be off, such as 10 or 10,256";
        let number = |text: &str| text.parse::<f64>().ok().filter(|number| *number >= 0.0);
        let (wrong, ulp) = text.split_once(',').unwrap_or((text, "inf"));
        let (wrong_per_million, t_ulp) = number(wrong).zip(number(ulp)).ok_or(ParseError::new(right))?;
        Ok(Self { wrong_per_million, t_ulp })
    }
}

impl Budget {
    /// Whether a contestant's errors stay inside.
    #[must_use]
    pub fn holds(&self, row: &AccuracyRow) -> bool {
        row.wrong() as f64 * 1e6 <= self.wrong_per_million * row.cases as f64 && row.t_ulp_p999 <= self.t_ulp
    }
}

/// Notes the addresses of the triangles that are read.
#[derive(Default)]
struct Triangles(Vec<u32>);

impl Observer for Triangles {
    fn read(&mut self, unit: Unit, addr: HostAddr, _bytes: usize) {
        if unit == Unit::Intersection {
            self.0.push(addr.0);
        }
    }
}

/// Primary rays of the scene's path, each with the triangles that the traversal tests it against:
/// as many as asked for, through random pixels of frames along the path.
///
/// # Errors
/// If the scene has no path.
pub fn cases(world: &World, rays: u64, seed: u64) -> Result<Vec<Case>, StudyError> {
    if world.path.is_empty() {
        return Err(StudyError::NoPath { scene: world.name.clone() });
    }
    let case = |number: u64| {
        let mut random = Random::new(Random::new(seed ^ number).bits());
        let camera = &world.path[(number as usize * world.path.len()) / rays as usize];
        let (x, y) = (random.range(0, PICTURE.0), random.range(0, PICTURE.1));
        let ray = Frame::new(camera, PICTURE.0, PICTURE.1).primary_ray(x, y);
        Case { ray, triangles: tested(world, &ray) }
    };
    Ok((0..rays).into_par_iter().map(case).collect())
}

/// The corners of the triangles that the traversal of `ray` reads, by ascending address.
fn tested(world: &World, ray: &Ray) -> Vec<[Vec3; 3]> {
    let mut memory = Observed { memory: WholeScene(&world.image.bytes), observer: Triangles::default() };
    let packet = Packet::new([Some(*ray)]);
    let _: Hits<1> = Traversal::with(FilteredIntersection::default()).run(
        &mut memory,
        &world.image.registers,
        &packet,
        Query::Closest,
    );
    let mut triangles = std::mem::take(&mut memory.observer.0);
    triangles.sort_unstable();
    triangles.dedup();
    let corners = |&addr: &u32| {
        let bytes: [u8; TRIANGLE_BYTES as usize] = memory.fetch(Unit::Intersection, HostAddr(addr));
        let number = |at: usize| {
            let start = 4 * at;
            f32::from_le_bytes([bytes[start], bytes[start + 1], bytes[start + 2], bytes[start + 3]])
        };
        std::array::from_fn(|corner| Vec3::from_array(std::array::from_fn(|axis| number(3 * corner + axis))))
    };
    triangles.iter().map(corners).collect()
}

/// The kernel that a world must be opened with: its records are the corners, and its traversal
/// loses no ray.
pub const KERNEL: Kernel = Kernel::Adaptive;

/// A row for each contestant on the scene's rays, the cheapest first: fewest bits, then least time.
#[must_use]
pub fn rows(cases: &[Case], contestants: &[Contestant], edges: Edges, repeats: u32) -> Vec<AccuracyRow> {
    let mut rows = measure_cases("scene", cases, contestants, edges, repeats);
    rows.sort_by(|a, b| {
        let bits = |row: &AccuracyRow| row.contestant().format.bits();
        bits(a).cmp(&bits(b)).then(a.ns_per_test.total_cmp(&b.ns_per_test))
    });
    rows
}

/// The triangle tests, the cheapest first: the order in which [`rows`] puts them in f32, where one
/// core took 19, 23, 32, 32 and 35 ns a test on a real conference room. It is fixed, so that
/// the choice does not depend on a clock.
const BY_COST: [Kernel; 5] =
    [Kernel::Wald, Kernel::MollerTrumbore, Kernel::Plucker, Kernel::Watertight, Kernel::Adaptive];

/// Rays by which a test is chosen: of a test that is wrong 30 times in a million, all are right with
/// a probability of 5 % (Hanley and Lippman-Hand 1983).
const RAYS: u64 = 100_000;

/// Which of the same rays each run takes.
const SEED: u64 = 1;

/// The cheapest triangle test that stays inside the budget on the scene's rays, and its row: in
/// f32, the format in which the chip computes (IS-5). The world is one of [`KERNEL`].
///
/// # Errors
/// If there is none, or the scene has no path.
pub fn cheapest(world: &World, budget: Budget) -> Result<(Kernel, AccuracyRow), StudyError> {
    let contestants = BY_COST.map(|kernel| Contestant { kernel, format: Format::F32 });
    let cases = cases(world, RAYS, SEED)?;
    let rows = measure_cases("scene", &cases, &contestants, world.image.registers.edges, 1);
    let mut tests = BY_COST.into_iter().zip(rows);
    let enough = tests.find(|(_, row)| budget.holds(row));
    enough.ok_or_else(|| StudyError::OverBudget { scene: world.name.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_read() {
        let budget = |wrong_per_million, t_ulp| Ok(Budget { wrong_per_million, t_ulp });
        assert_eq!("10".parse(), budget(10.0, f64::INFINITY));
        assert_eq!("0,2.5".parse(), budget(0.0, 2.5));
        for wrong in ["", "-1", "x", "1,", "1,2,3", "NaN"] {
            assert!(wrong.parse::<Budget>().is_err(), "{wrong}");
        }
    }
}
