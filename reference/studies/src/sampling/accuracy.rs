//! Speed against error of an estimated walk: of many draws of frames, how far the estimates are off, and how often their intervals
//! hold the truth.
//!
//! All frames are simulated once, and counted once; a draw is then a choice among rows that are known. How many times as fast an
//! estimate is, one run of each part says, in processor time of all cores.

use super::choice::Choice;
use super::counts::{Counts, count};
use super::fraction::SampleFraction;
use super::prediction::{Known, Prediction};
use super::walk::{EstimatedWalk, Goal, QUANTITIES, predict, values};
use crate::error::StudyError;
use crate::frames::{Frames, MOST_TOGETHER, OnChip};
use crate::monitor::Monitor;
use crate::names::version_name;
use rayon::prelude::*;
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// Draws of each part.
pub const DRAWS: u64 = 200;

/// What an estimate of each quantity's sum may be off, root mean square (the project's targets).
pub const SUM_TARGET: [f64; 3] = [0.015, 0.03, 0.10];
/// What the median of the frames may be off.
pub const FRAME_TARGET: f64 = 0.05;
/// Of the draws, the share whose intervals hold the truth.
pub const COVERAGE_TARGET: [f64; 2] = [0.90, 0.99];
/// Half of the interval's width, in root mean square errors.
pub const WIDTH_TARGET: f64 = 3.0;
/// Times as fast.
pub const SPEED_TARGET: f64 = 15.0;

/// A quantity of a walk, estimated from a part of its frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// As the user named it.
    pub scene: String,
    /// Version of the virtual memory.
    pub variant: &'static str,
    /// The part of the frames that was simulated.
    pub sample: String,
    /// Frames of the walk, and of these, frames that were simulated.
    pub frames: usize,
    /// See [`Accuracy::frames`].
    pub simulated: usize,
    /// What was estimated.
    pub quantity: &'static str,
    /// Draws of frames.
    pub draws: u64,
    /// Share of the draws from which the sum is not known ([`Estimate::is_known`](super::estimate::Estimate::is_known)).
    pub not_known: f64,
    /// Of the others, root mean square of the sum's error, relative to the sum; none if there are none. So are the next two.
    pub error: Option<f64>,
    /// Mean of half the width of the sum's interval, relative to the sum.
    pub half_width: Option<f64>,
    /// Share of the draws whose interval holds the sum.
    pub coverage: Option<f64>,
    /// Median of the errors of the frames that were not simulated, relative to each; mean over all draws.
    pub frame_error: f64,
    /// Share of these frames whose interval holds the truth.
    pub frame_coverage: f64,
    /// Processor seconds of the whole walk.
    pub seconds: f64,
    /// How many times as fast in processor time one estimate was.
    pub speedup: f64,
}

impl Accuracy {
    /// The targets that it misses, by their names.
    #[must_use]
    pub fn misses(&self) -> Vec<&'static str> {
        let place = QUANTITIES.iter().position(|name| *name == self.quantity).unwrap_or(0);
        let [least, most] = COVERAGE_TARGET;
        let targets = [
            ("error", self.error.is_some_and(|error| error <= SUM_TARGET[place])),
            ("frame", place > 0 || self.frame_error <= FRAME_TARGET),
            ("coverage", self.coverage.is_some_and(|coverage| (least..=most).contains(&coverage))),
            (
                "width",
                self.error.zip(self.half_width).is_some_and(|(error, half)| half <= WIDTH_TARGET * error),
            ),
            ("speed", self.speedup >= SPEED_TARGET),
        ];
        targets.into_iter().filter(|(_, meets)| !meets).map(|(name, _)| name).collect()
    }
}

/// Processor seconds of this process, of all cores together.
fn processor_seconds() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 / 1e9
}

/// What a draw came out to.
struct Draw {
    /// The sum's error, half of its interval's width, and whether that holds the truth; whether it is known.
    error: f64,
    half_width: f64,
    holds: bool,
    known: bool,
    /// Median of the frames' errors, and the share whose intervals hold the truth.
    frame_error: f64,
    frames_held: f64,
}

impl Draw {
    fn new(prediction: &Prediction, truth: &[f64], choice: &Choice) -> Self {
        let sum: f64 = truth.iter().sum();
        let is_estimated = |place: &usize| !choice.certain.contains(place) && !choice.drawn.contains(place);
        let rest: Vec<usize> = (0..truth.len()).filter(is_estimated).collect();
        let apart = |place: &usize| (prediction.frames[*place].value / truth[*place].max(1.0) - 1.0).abs();
        let mut errors: Vec<f64> = rest.iter().map(apart).collect();
        errors.sort_unstable_by(f64::total_cmp);
        let held = rest.iter().filter(|place| prediction.frames[**place].holds(truth[**place])).count();
        let relative = |value: f64| if sum > 0.0 { value / sum } else { 0.0 };
        Self {
            error: relative(prediction.sum.value - sum),
            half_width: relative((prediction.sum.high - prediction.sum.low) / 2.0),
            holds: prediction.sum.holds(sum),
            known: prediction.sum.is_known(),
            frame_error: errors.get(errors.len() / 2).copied().unwrap_or(0.0),
            frames_held: held as f64 / rest.len().max(1) as f64,
        }
    }
}

/// Simulates `frames`, which increase, and compares with them estimates from `parts` of them; parts of too few frames are left out.
///
/// # Errors
/// If the configuration makes no chip.
pub fn measure(
    run: OnChip<'_>,
    frames: &[usize],
    parts: &[SampleFraction],
    monitor: &dyn Monitor,
) -> Result<Vec<Accuracy>, StudyError> {
    let started = processor_seconds();
    let rows = monitor.during("all frames on the chip", |report| {
        let (mut walk, mut rows) = (Frames::new(run)?, Vec::with_capacity(frames.len()));
        for together in frames.chunks(rayon::current_num_threads().min(MOST_TOGETHER)) {
            rows.extend(walk.rows(together)?);
            report(rows.len() as f64 / frames.len() as f64);
        }
        Ok::<_, StudyError>(rows)
    })?;
    let seconds = processor_seconds() - started;
    let truth: Vec<[f64; 3]> = rows.iter().map(values).collect();
    let counts = monitor.during("small pictures of all frames", |report| count(&run, frames, report))?;
    let known = Known::new(&counts.iter().map(Counts::all).collect::<Vec<_>>());
    let mut found = Vec::new();
    for &part in parts {
        let Ok(stretches) = Choice::new(run.world, frames, 0).of_part(part) else { continue };
        let started = processor_seconds();
        let one = EstimatedWalk::new(run, frames, Goal::Part(part), 0, monitor)?;
        let speedup = seconds / (processor_seconds() - started);
        let draw = |seed: u64| -> [Draw; 3] {
            let mut choice = Choice::new(run.world, frames, seed);
            choice.draw(stretches);
            let predictions = predict(&known, &counts, &choice, run.config, &|place| truth[place]);
            std::array::from_fn(|quantity| {
                let truth: Vec<f64> = truth.iter().map(|values| values[quantity]).collect();
                Draw::new(&predictions[quantity], &truth, &choice)
            })
        };
        let draws: Vec<[Draw; 3]> = monitor
            .during(&format!("{DRAWS} draws of {part}"), |_| (0..DRAWS).into_par_iter().map(draw).collect());
        for (place, quantity) in QUANTITIES.into_iter().enumerate() {
            let mean = |of: &dyn Fn(&Draw) -> f64| {
                draws.iter().map(|draw| of(&draw[place])).sum::<f64>() / DRAWS as f64
            };
            let known: Vec<&Draw> = draws.iter().map(|draw| &draw[place]).filter(|draw| draw.known).collect();
            let of_known = |of: &dyn Fn(&Draw) -> f64| {
                let sum: f64 = known.iter().map(|draw| of(draw)).sum();
                (!known.is_empty()).then(|| sum / known.len() as f64)
            };
            found.push(Accuracy {
                scene: run.world.name.clone(),
                variant: version_name(run.config.version),
                sample: part.to_string(),
                frames: frames.len(),
                simulated: one.simulated.len(),
                quantity,
                draws: DRAWS,
                not_known: 1.0 - known.len() as f64 / DRAWS as f64,
                error: of_known(&|draw| draw.error.powi(2)).map(f64::sqrt),
                half_width: of_known(&|draw| draw.half_width),
                coverage: of_known(&|draw| f64::from(u8::from(draw.holds))),
                frame_error: mean(&|draw| draw.frame_error),
                frame_coverage: mean(&|draw| draw.frames_held),
                seconds,
                speedup,
            });
        }
    }
    Ok(found)
}
