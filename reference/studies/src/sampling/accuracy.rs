//! Speed against error of sampled simulation, and how often its intervals hold the truth.

use super::plan::SampleFraction;
use super::row::{Quantity, SampleRow};
use super::simulate::{SampledFrame, simulate_sample};
use super::walk::walk_sample;
use crate::error::StudyError;
use crate::walk::WalkOptions;
use crate::world::World;
use saarcor_model::time::ChipConfig;
use serde::Serialize;
use std::time::Instant;

/// Frames of a walk: caches are warm from the second on.
const WALK_FRAMES: usize = 5;

/// One quantity of one step, from one part of the packets, over some frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// As the user named it.
    pub scene: String,
    /// The verb: walk or simulate.
    pub step: &'static str,
    /// The part of the packets that was worked on in full.
    pub sample: String,
    /// What was estimated.
    pub quantity: String,
    /// Frames that were compared.
    pub frames: usize,
    /// SampleFraction of the frames whose true value lies in the interval.
    pub coverage: f64,
    /// Mean distance of the estimate from the true value, relative to it. (Frames in which the true
    /// value is 0 are left out, here and below.)
    pub error: f64,
    /// Mean of half the interval's length, relative to the true value.
    pub half_width: f64,
    /// Seconds a frame, without what makes the scene ready.
    pub seconds: f64,
    /// How many times as fast as working on all packets.
    pub speedup: f64,
}

/// Compares estimates with the truth, quantity by quantity.
#[derive(Default)]
struct Comparison {
    quantities: Vec<Compared>,
    seconds: f64,
}

#[derive(Default)]
struct Compared {
    name: String,
    frames: usize,
    held: usize,
    /// Frames whose true value is not 0, and sums over them.
    measured: usize,
    error: f64,
    half_width: f64,
}

impl Comparison {
    fn frame(&mut self, estimated: &[Quantity], truth: &[Quantity]) {
        for (place, (Quantity { name, estimate }, truth)) in estimated.iter().zip(truth).enumerate() {
            if place == self.quantities.len() {
                self.quantities.push(Compared { name: name.clone(), ..Compared::default() });
            }
            let (compared, truth) = (&mut self.quantities[place], truth.estimate.estimate);
            compared.frames += 1;
            compared.held += usize::from(estimate.holds(truth));
            if truth != 0.0 {
                compared.measured += 1;
                compared.error += (estimate.estimate / truth - 1.0).abs();
                compared.half_width += (estimate.high - estimate.low) / (2.0 * truth);
            }
        }
    }

    fn rows(self, scene: &str, step: &'static str, part: SampleFraction, full_seconds: f64) -> Vec<Accuracy> {
        let row = |compared: Compared| {
            let measured = compared.measured.max(1) as f64;
            Accuracy {
                scene: scene.to_owned(),
                step,
                sample: part.to_string(),
                quantity: compared.name,
                frames: compared.frames,
                coverage: compared.held as f64 / compared.frames as f64,
                error: compared.error / measured,
                half_width: compared.half_width / measured,
                seconds: self.seconds / compared.frames as f64,
                speedup: full_seconds / self.seconds,
            }
        };
        self.quantities.into_iter().map(row).collect()
    }
}

/// The frames of a path of `all` frames, so many spread over it.
fn spread(all: usize, count: usize) -> impl Iterator<Item = usize> {
    let count = count.min(all);
    (0..count).map(move |place| place * all / count)
}

/// Compares `simulate --sample` of each part with the whole run, on `frames` frames spread over the
/// path. `sampled` says the rest; its frame and part do not count.
///
/// # Errors
/// Those of [`simulate_sample`].
pub fn of_simulate(
    world: &World,
    frames: usize,
    parts: &[SampleFraction],
    sampled: &SampledFrame,
    config: &ChipConfig,
    report: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Accuracy>, StudyError> {
    let run = |frame, part| -> Result<(SampleRow, f64), StudyError> {
        let started = Instant::now();
        let row = simulate_sample(world, &SampledFrame { frame, part, ..*sampled }, config, &|_| ())?;
        Ok((row, started.elapsed().as_secs_f64()))
    };
    let mut comparisons: Vec<_> = parts.iter().map(|_| Comparison::default()).collect();
    let mut full_seconds = 0.0;
    for (done, frame) in spread(world.path.len(), frames).enumerate() {
        let (truth, seconds) = run(frame, SampleFraction::one_of(1))?;
        full_seconds += seconds;
        for (&part, comparison) in parts.iter().zip(&mut comparisons) {
            let (row, seconds) = run(frame, part)?;
            comparison.frame(&row.quantities, &truth.quantities);
            comparison.seconds += seconds;
        }
        report((done + 1) as f64 / frames as f64);
    }
    Ok(rows(world, "simulate", parts, comparisons, full_seconds))
}

/// Compares `walk --sample` of each part with the whole walk, in walks of five frames
/// spread over the path, `frames` in all.
///
/// # Errors
/// Those of [`walk_sample`].
pub fn of_walk(
    world: &World,
    frames: usize,
    parts: &[SampleFraction],
    options: &WalkOptions,
    report: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Accuracy>, StudyError> {
    let run = |first: usize, part| -> Result<(Vec<SampleRow>, f64), StudyError> {
        let (started, mut rows) = (Instant::now(), Vec::new());
        let frames = first..(first + WALK_FRAMES).min(world.path.len());
        walk_sample(world, frames, options, part, &mut |row| {
            rows.push(row.clone());
            Ok::<_, StudyError>(())
        })?;
        Ok((rows, started.elapsed().as_secs_f64()))
    };
    let mut comparisons: Vec<_> = parts.iter().map(|_| Comparison::default()).collect();
    let walks = frames.div_ceil(WALK_FRAMES);
    let last = world.path.len().saturating_sub(WALK_FRAMES) + 1;
    let mut full_seconds = 0.0;
    for (done, first) in spread(last, walks).enumerate() {
        let (truth, seconds) = run(first, SampleFraction::one_of(1))?;
        full_seconds += seconds;
        for (&part, comparison) in parts.iter().zip(&mut comparisons) {
            let (rows, seconds) = run(first, part)?;
            for (row, truth) in rows.iter().zip(&truth) {
                comparison.frame(&row.quantities, &truth.quantities);
            }
            comparison.seconds += seconds;
        }
        report((done + 1) as f64 / walks as f64);
    }
    Ok(rows(world, "walk", parts, comparisons, full_seconds))
}

fn rows(
    world: &World,
    step: &'static str,
    parts: &[SampleFraction],
    comparisons: Vec<Comparison>,
    full_seconds: f64,
) -> Vec<Accuracy> {
    let of_part = |(&part, comparison): (&SampleFraction, Comparison)| {
        comparison.rows(&world.name, step, part, full_seconds)
    };
    parts.iter().zip(comparisons).flat_map(of_part).collect()
}
