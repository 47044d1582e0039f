//! A walk in time of which some frames run on the chip, and all others are estimated.

use super::choice::{Choice, LEAST_DRAWN};
use super::counts::{Counts, count};
use super::estimate::Estimate;
use super::fraction::SampleFraction;
use super::prediction::{Known, Prediction};
use crate::error::{ParseError, StudyError};
use crate::frames::{Frames, MOST_TOGETHER, OnChip};
use crate::monitor::Monitor;
use crate::names::version_name;
use crate::simulate::TimingRow;
use saarcor_model::time::{ChipConfig, Version};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// What is estimated: keys of a frame's row.
pub const QUANTITIES: [&str; 3] = ["cycles", "mem_bytes", "pci_bytes"];

/// The place of what a chip without virtual memory does not have.
const PCI: usize = 2;

/// The quantities of a row.
#[must_use]
pub fn values(row: &TimingRow) -> [f64; 3] {
    [row.cycles, row.mem_bytes, row.pci_bytes].map(|count| count as f64)
}

/// Quantities and their names: [`QUANTITIES`], and frames a second.
pub type Quantities = Vec<(&'static str, Estimate)>;

/// These quantities of so many frames on this chip, and frames a second.
#[must_use]
pub fn quantities(of: [Estimate; 3], config: &ChipConfig, frames: usize) -> Quantities {
    let fps = of[0].dividing(config.core_hz as f64 * frames as f64);
    QUANTITIES.into_iter().zip(of).chain([("fps", fps)]).collect()
}

/// A bound on half of an interval's width, relative to the value: `1%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBound(f64);

impl ErrorBound {
    /// So many percent.
    #[must_use]
    pub const fn percent(percent: f64) -> Self {
        Self(percent / 100.0)
    }
}

impl FromStr for ErrorBound {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let percent = text.strip_suffix('%').and_then(|number| number.parse::<f64>().ok());
        let percent = percent.filter(|percent| (0.01..=50.0).contains(percent));
        percent
            .map(Self::percent)
            .ok_or_else(|| ParseError::new("write a percentage from 0.01% to 50%, such as 1%"))
    }
}

impl fmt::Display for ErrorBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}%", 100.0 * self.0)
    }
}

/// How many frames run on the chip.
#[derive(Clone, Copy, Debug)]
pub enum Goal {
    /// A part of them.
    Part(SampleFraction),
    /// Until the interval of the sum of cycles is at most so wide to each side, half as many again each time (sequential estimation,
    /// Chow and Robbins 1965).
    Error(ErrorBound),
}

/// A walk in time, estimated.
#[derive(Clone, Debug)]
pub struct EstimatedWalk {
    scene: String,
    config: ChipConfig,
    /// The frames, in their order.
    pub frames: Vec<usize>,
    /// The rows of those that ran on the chip, by their places.
    pub simulated: BTreeMap<usize, TimingRow>,
    /// The quantities, in the order of [`QUANTITIES`].
    pub predictions: [Prediction; 3],
}

/// Predicts all quantities from the cheap counts of all frames and the `values` of those chosen, by their places.
#[must_use]
pub fn predict(
    known: &Known,
    counts: &[Counts],
    choice: &Choice,
    config: &ChipConfig,
    values: &dyn Fn(usize) -> [f64; 3],
) -> [Prediction; 3] {
    let drawn: Vec<usize> = choice.drawn.iter().copied().collect();
    std::array::from_fn(|quantity| {
        if quantity == PCI && config.version == Version::None {
            let nothing = Estimate::exact(0.0);
            return Prediction { frames: vec![nothing; counts.len()], sum: nothing };
        }
        let like: Vec<f64> = counts.iter().map(|counts| counts.like(config)[quantity]).collect();
        let of = |place: &usize| values(*place)[quantity];
        let of_drawn: Vec<f64> = drawn.iter().map(of).collect();
        let apart: Vec<(usize, f64)> = choice.certain.iter().map(|place| (*place, of(place))).collect();
        known.predict(&like, &drawn, &of_drawn, &apart)
    })
}

impl EstimatedWalk {
    /// Counts what is cheap of `frames`, which increase, simulates some, and estimates the others. `seed` decides which are drawn.
    ///
    /// # Errors
    /// If the configuration makes no chip, or the part is too small.
    pub fn new(
        run: OnChip<'_>,
        frames: &[usize],
        goal: Goal,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<Self, StudyError> {
        let mut choice = Choice::new(run.world, frames, seed);
        let mut stretches = match goal {
            Goal::Part(part) => choice.of_part(part)?,
            Goal::Error(_) => 2 * LEAST_DRAWN,
        };
        let counts = monitor.during("small pictures of all frames", |report| count(&run, frames, report))?;
        let known = Known::new(&counts.iter().map(Counts::all).collect::<Vec<_>>());
        let mut simulated = BTreeMap::new();
        loop {
            choice.draw(stretches);
            let left: Vec<usize> =
                choice.all().into_iter().filter(|place| !simulated.contains_key(place)).collect();
            monitor.during(&format!("{} frames on the chip", left.len()), |report| {
                let (mut walk, all) = (Frames::new(run)?, simulated.len() + left.len());
                let together = rayon::current_num_threads().min(MOST_TOGETHER);
                for places in left.chunks(together) {
                    let numbers: Vec<usize> = places.iter().map(|&place| frames[place]).collect();
                    simulated.extend(places.iter().copied().zip(walk.rows(&numbers)?));
                    report(simulated.len() as f64 / all as f64);
                }
                Ok::<_, StudyError>(())
            })?;
            let predictions =
                predict(&known, &counts, &choice, run.config, &|place| values(&simulated[&place]));
            let is_enough = match goal {
                Goal::Part(_) => true,
                Goal::Error(bound) => predictions[0].sum.half_width() <= bound.0,
            };
            if is_enough || choice.is_all() {
                let (scene, config, frames) = (run.world.name.clone(), *run.config, frames.to_vec());
                return Ok(Self { scene, config, frames, simulated, predictions });
            }
            stretches += stretches / 2;
        }
    }

    /// The quantities of a frame by its place.
    #[must_use]
    pub fn of(&self, place: usize) -> Quantities {
        quantities(self.predictions.each_ref().map(|prediction| prediction.frames[place]), &self.config, 1)
    }

    /// The quantities of all frames together.
    #[must_use]
    pub fn sum(&self) -> Quantities {
        let sums = self.predictions.each_ref().map(|prediction| prediction.sum);
        quantities(sums, &self.config, self.frames.len())
    }

    /// The row of a frame by its place, as JSON: that of a run of the frame alone if it ran on the chip, and else its estimates under the
    /// same keys.
    ///
    /// # Errors
    /// Those of JSON.
    pub fn row(&self, place: usize) -> serde_json::Result<Value> {
        let of = match self.simulated.get(&place) {
            Some(row) => serde_json::to_value(row)?,
            None => json!({ "frame": self.frames[place] }),
        };
        let estimated = !self.simulated.contains_key(&place);
        Ok(self.json(of, estimated, &self.of(place)))
    }

    /// The row of the sum, as JSON.
    #[must_use]
    pub fn sum_row(&self) -> Value {
        let (frames, simulated) = (self.frames.len(), self.simulated.len());
        let of = json!({ "frames": frames, "simulated": simulated });
        self.json(of, simulated < frames, &self.sum())
    }

    fn json(&self, of: Value, estimated: bool, estimates: &[(&'static str, Estimate)]) -> Value {
        let mut row = match of {
            Value::Object(row) => row,
            _ => Map::new(),
        };
        row.insert("scene".to_owned(), self.scene.clone().into());
        row.insert("variant".to_owned(), version_name(self.config.version).into());
        row.insert("estimated".to_owned(), estimated.into());
        let (mut interval, mut not_known) = (Map::new(), Vec::new());
        for (name, estimate) in estimates {
            let is_count = *name != "fps";
            let number = |value: f64, round: fn(f64) -> f64| match is_count {
                true => Value::from(round(value) as u64),
                false => Value::from(value),
            };
            let Estimate { value, low, high } = *estimate;
            let known = estimate.is_known();
            let ends = [number(low, f64::floor), number(high, f64::ceil)];
            row.insert((*name).to_owned(), if known { number(value, f64::round) } else { Value::Null });
            interval.insert((*name).to_owned(), if known { ends.to_vec().into() } else { Value::Null });
            if !known {
                not_known.push(*name);
            }
        }
        row.insert("interval".to_owned(), interval.into());
        if !not_known.is_empty() {
            row.insert("not_known_from_this_sample".to_owned(), not_known.into());
        }
        row.into()
    }
}
