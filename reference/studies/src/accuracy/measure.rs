//! Contestants on suites: faults, errors, and time.

use super::case::{Case, Found, Truth, ulp};
use super::contest::Contestant;
use super::suites::Suite;
use crate::names::{EDGES, kernel_name, name_of};
use rayon::prelude::*;
use saarcor_model::host::Edges;
use serde::Serialize;
use std::ops::Range;

/// Cases that are timed together: so few that they stay in a core's caches, and too many for its branch
/// predictor to learn which of them hit, as it does some of the time with 512 of them that run three times.
const CHUNK: u64 = 4096;

/// A wrong answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// A hit where there is none.
    WrongHit,
    /// No hit where there is one.
    WrongMiss,
    /// Another triangle than those that are hit first.
    WrongTriangle,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::WrongHit, Self::WrongMiss, Self::WrongTriangle];

    /// The fault of an answer, if it has one.
    #[must_use]
    pub fn of(found: Option<&Found>, truth: &Truth) -> Option<Self> {
        match found {
            None if truth.0.is_empty() => None,
            None => Some(Self::WrongMiss),
            Some(_) if truth.0.is_empty() => Some(Self::WrongHit),
            Some(found) => truth.of_triangle(found.triangle).is_none().then_some(Self::WrongTriangle),
        }
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WrongHit => "wrong hit",
            Self::WrongMiss => "wrong miss",
            Self::WrongTriangle => "wrong triangle",
        }
    }
}

/// A contestant's results in some cases of a suite.
#[derive(Clone, Debug, Default)]
struct Tally {
    /// By the order of [`Fault::ALL`].
    faults: [u64; 3],
    /// The number of the first case with each.
    first: [Option<u64>; 3],
    /// Error of each right hit's distance, in ulps of f32.
    t_errors: Vec<f32>,
    /// The case of the largest of them.
    worst: Option<u64>,
    weight_error_sum: f64,
    weight_error_max: f64,
    /// Nanoseconds a test, of each chunk.
    times: Vec<f64>,
}

impl Tally {
    fn new(numbers: Range<u64>, truths: &[Truth], found: &[Option<Found>]) -> Self {
        let mut tally = Self::default();
        let mut largest = -1.0;
        for ((number, truth), found) in numbers.zip(truths).zip(found) {
            if let Some(fault) = Fault::of(found.as_ref(), truth) {
                tally.faults[fault as usize] += 1;
                tally.first[fault as usize].get_or_insert(number);
            } else if let Some(found) = found
                && let Some(truth) = truth.of_triangle(found.triangle)
            {
                let error = ((found.t - truth.t).abs() / ulp(truth.t)) as f32;
                tally.t_errors.push(error);
                if error > largest {
                    (largest, tally.worst) = (error, Some(number));
                }
                let weight = |place: usize| (found.weights[place] - truth.weights[place]).abs();
                let error = weight(0).max(weight(1));
                tally.weight_error_sum += error;
                tally.weight_error_max = tally.weight_error_max.max(error);
            }
        }
        tally
    }

    /// Of these cases, and then those of `other`.
    fn and(mut self, other: Self) -> Self {
        let largest = |tally: &Self| tally.t_errors.iter().copied().fold(-1.0, f32::max);
        if largest(&other) > largest(&self) {
            self.worst = other.worst;
        }
        for fault in 0..3 {
            self.faults[fault] += other.faults[fault];
            self.first[fault] = self.first[fault].or(other.first[fault]);
        }
        self.t_errors.extend(other.t_errors);
        self.weight_error_sum += other.weight_error_sum;
        self.weight_error_max = self.weight_error_max.max(other.weight_error_max);
        self.times.extend(other.times);
        self
    }
}

/// The quantile of `values` at `part`, 0 to 1; 0 where there are none.
pub(super) fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let place = ((values.len() as f64 * part).ceil() as usize).clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// A contestant's results on a suite.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccuracyRow {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Name of the format.
    pub format: &'static str,
    /// Name of the rule for edges and vertices.
    pub edges: &'static str,
    /// Name of the suite.
    pub suite: &'static str,
    /// Cases.
    pub cases: u64,
    /// Tests of a ray and a triangle.
    pub tests: u64,
    /// Hits where there is none.
    pub wrong_hit: u64,
    /// No hits where there is one.
    pub wrong_miss: u64,
    /// Hits of another triangle than the first.
    pub wrong_triangle: u64,
    /// Wrong misses where the surface is closed around the ray.
    pub leaks: u64,
    /// Error of the distance of right hits, in ulps of f32 there: mean.
    pub t_ulp_mean: f64,
    /// What 99.9 % of these errors do not exceed.
    pub t_ulp_p999: f64,
    /// The largest.
    pub t_ulp_max: f64,
    /// Error of the barycentric weights of right hits: mean of the larger of both.
    pub weight_error_mean: f64,
    /// The largest.
    pub weight_error_max: f64,
    /// Nanoseconds a test: median over the chunks of cases, of each the faster of some runs.
    pub ns_per_test: f64,
    #[serde(skip)]
    contestant: Contestant,
    /// Numbers of the cases that show the contestant's faults best.
    #[serde(skip)]
    pub worst: Worst,
}

impl AccuracyRow {
    /// Which contestant.
    #[must_use]
    pub fn contestant(&self) -> Contestant {
        self.contestant
    }

    /// Wrong answers of all kinds.
    #[must_use]
    pub fn wrong(&self) -> u64 {
        self.wrong_hit + self.wrong_miss + self.wrong_triangle
    }
}

/// Numbers of the cases that show a contestant's faults best.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Worst {
    /// The first case with each fault, by the order of [`Fault::ALL`].
    pub faults: [Option<u64>; 3],
    /// The case with the largest error of the distance.
    pub distance: Option<u64>,
}

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub struct MeasureOptions {
    /// Of the cases.
    pub seed: u64,
    /// Cases a suite.
    pub cases: u64,
    /// Runs of which the fastest counts.
    pub repeats: u32,
    /// The rule for edges and vertices.
    pub edges: Edges,
}

/// A row for each contestant on a suite. `report` learns the part that is done, 0 to 1.
///
/// Chunks of cases go to the threads; each is judged and then given to one contestant after the
/// other on the same thread.
#[must_use]
pub fn measure(
    suite: &'static Suite,
    contestants: &[Contestant],
    extent: MeasureOptions,
    report: &(dyn Fn(f64) + Sync),
) -> Vec<AccuracyRow> {
    let done = std::sync::atomic::AtomicU64::new(0);
    let chunks: Vec<_> = (0..extent.cases.div_ceil(CHUNK)).collect();
    let chunk = |&chunk: &u64| {
        let numbers = chunk * CHUNK..extent.cases.min((chunk + 1) * CHUNK);
        let cases: Vec<_> = numbers.clone().map(|number| suite.case(extent.seed, number)).collect();
        let tallies = tallies(numbers, &cases, contestants, extent.edges, extent.repeats);
        let before = done.fetch_add(cases.len() as u64, std::sync::atomic::Ordering::Relaxed);
        report((before + cases.len() as u64) as f64 / extent.cases as f64);
        (tests(&cases), tallies)
    };
    let chunks: Vec<(u64, Vec<Tally>)> = chunks.par_iter().map(chunk).collect();
    rows(contestants, extent.cases, extent.edges, (suite.name, suite.closed), chunks)
}

/// A row for each contestant on the cases of a scene's own rays, `name`d after it.
#[must_use]
pub fn measure_cases(
    name: &'static str,
    cases: &[Case],
    contestants: &[Contestant],
    edges: Edges,
    repeats: u32,
) -> Vec<AccuracyRow> {
    let chunk = |(place, cases): (usize, &[Case])| {
        let first = place as u64 * CHUNK;
        (tests(cases), tallies(first..first + cases.len() as u64, cases, contestants, edges, repeats))
    };
    let chunks: Vec<_> = cases.par_chunks(CHUNK as usize).enumerate().map(chunk).collect();
    rows(contestants, cases.len() as u64, edges, (name, false), chunks)
}

fn tests(cases: &[Case]) -> u64 {
    cases.iter().map(|case| case.triangles.len() as u64).sum()
}

/// The results of each contestant on the cases of these numbers.
fn tallies(
    numbers: Range<u64>,
    cases: &[Case],
    contestants: &[Contestant],
    edges: Edges,
    repeats: u32,
) -> Vec<Tally> {
    let truths: Vec<_> = cases.iter().map(|case| Truth::of(case, edges)).collect();
    let tests = tests(cases).max(1) as f64;
    let tally = |contestant: &Contestant| {
        let (found, seconds) = contestant.run(cases, edges, repeats);
        let mut tally = Tally::new(numbers.clone(), &truths, &found);
        tally.times.push(seconds * 1e9 / tests);
        tally
    };
    contestants.iter().map(tally).collect()
}

/// The tallies of all chunks, in their order, as rows.
fn rows(
    contestants: &[Contestant],
    cases: u64,
    edges: Edges,
    (suite, closed): (&'static str, bool),
    chunks: Vec<(u64, Vec<Tally>)>,
) -> Vec<AccuracyRow> {
    let tests = chunks.iter().map(|(tests, _)| tests).sum();
    let mut totals: Vec<Tally> = vec![Tally::default(); contestants.len()];
    for (_, tallies) in chunks {
        totals = totals.into_iter().zip(tallies).map(|(total, tally)| total.and(tally)).collect();
    }
    let row = |(&contestant, mut tally): (&Contestant, Tally)| {
        let [wrong_hit, wrong_miss, wrong_triangle] = tally.faults;
        let mut errors: Vec<f64> = tally.t_errors.iter().map(|&error| f64::from(error)).collect();
        let right = errors.len().max(1) as f64;
        AccuracyRow {
            kernel: kernel_name(contestant.kernel),
            format: contestant.format.name(),
            edges: name_of(EDGES, &edges),
            suite,
            cases,
            tests,
            wrong_hit,
            wrong_miss,
            wrong_triangle,
            leaks: if closed { wrong_miss } else { 0 },
            // Not the sum of none, which is -0.
            t_ulp_mean: errors.iter().fold(0.0, |sum, error| sum + error) / right,
            t_ulp_p999: quantile(&mut errors, 0.999),
            t_ulp_max: quantile(&mut errors, 1.0),
            weight_error_mean: tally.weight_error_sum / right,
            weight_error_max: tally.weight_error_max,
            ns_per_test: quantile(&mut tally.times, 0.5),
            contestant,
            worst: Worst { faults: tally.first, distance: tally.worst },
        }
    };
    contestants.iter().zip(totals).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values() {
        let mut values: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        assert_eq!(quantile(&mut values, 0.999), 999.0);
        assert_eq!(quantile(&mut values, 0.5), 500.0);
        assert_eq!(quantile(&mut values, 1.0), 1000.0);
        assert_eq!(quantile(&mut [], 0.5), 0.0);
    }

    #[test]
    fn faults_are_distinguished() {
        let found = |triangle| Found { triangle, t: 1.0, weights: [0.0; 2] };
        let truth = Truth(vec![found(1), found(3)]);
        assert_eq!(Fault::of(Some(&found(3)), &truth), None);
        assert_eq!(Fault::of(Some(&found(0)), &truth), Some(Fault::WrongTriangle));
        assert_eq!(Fault::of(None, &truth), Some(Fault::WrongMiss));
        assert_eq!(Fault::of(Some(&found(0)), &Truth(vec![])), Some(Fault::WrongHit));
        assert_eq!(Fault::of(None, &Truth(vec![])), None);
    }
}
