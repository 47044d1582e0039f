//! Frames of a walk on the chip: each as a run of that frame alone has it ([`TimingRow`]), each picture traced once.
//!
//! All cores trace a picture; the chip works on one core, so several frames are simulated side by side. Results are the same
//! for any number of threads.

use crate::error::StudyError;
use crate::simulate::{TimingRow, WarmUp, record};
use crate::sweep::Position;
use crate::trace::{PacketOrder, TraceOptions};
use crate::world::World;
use rayon::prelude::*;
use saarcor_fast::chip::{Caches, simulate_from};
use saarcor_model::time::{ChipConfig, Programs};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most frames that are simulated side by side: their programs are kept in memory together.
pub const MOST_TOGETHER: usize = 16;

/// A chip, and how the frames of a world's path are simulated on it.
#[derive(Clone, Copy, Debug)]
pub struct OnChip<'a> {
    /// The scene and its path.
    pub world: &'a World,
    /// The chip.
    pub config: &'a ChipConfig,
    /// How pictures are traced.
    pub trace: TraceOptions,
    /// In which order packets are handed out.
    pub order: PacketOrder,
    /// Frames before each frame that warm its caches.
    pub warm_up: WarmUp,
}

/// The row of a frame, and where it stands among those that were asked for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WalkedRow {
    /// Where it stands.
    #[serde(flatten)]
    pub position: Position,
    /// What the frame took.
    #[serde(flatten)]
    pub row: TimingRow,
}

/// A traced picture.
#[derive(Clone)]
struct Traced {
    programs: Arc<Programs>,
    rays: u64,
}

/// Simulates frames in the order of the path.
pub struct Frames<'a> {
    run: OnChip<'a>,
    /// The pictures that later frames need, by their numbers.
    traced: BTreeMap<usize, Traced>,
    /// With [`WarmUp::WALK`], the caches after so many frames of the path.
    walked: (usize, Caches),
}

impl<'a> Frames<'a> {
    /// Frames of this chip; nothing is traced yet.
    ///
    /// # Errors
    /// If the configuration makes no chip.
    pub fn new(run: OnChip<'a>) -> Result<Self, StudyError> {
        let empty = Caches::empty(run.world.image.registers.triangles, run.config)?;
        Ok(Self { run, traced: BTreeMap::new(), walked: (0, empty) })
    }

    /// The rows of some frames, simulated side by side; `frames` increase, and follow those asked for before.
    ///
    /// # Errors
    /// If the configuration makes no chip.
    ///
    /// # Panics
    /// If the path does not have one of the frames.
    pub fn rows(&mut self, frames: &[usize]) -> Result<Vec<TimingRow>, StudyError> {
        let OnChip { world, config, warm_up, .. } = self.run;
        let mut begun = Vec::with_capacity(frames.len());
        for &frame in frames {
            let (caches, before) = if warm_up == WarmUp::WALK {
                (self.walked_to(frame), Vec::new())
            } else {
                let first = frame - warm_up.before(frame);
                self.traced.retain(|number, _| *number >= first);
                let before: Vec<Traced> = (first..frame).map(|before| self.traced(before)).collect();
                (Caches::empty(world.image.registers.triangles, config)?, before)
            };
            begun.push((frame, caches, before, self.traced(frame)));
        }
        let row = |(frame, caches, before, picture): (usize, Caches, Vec<Traced>, Traced)| {
            let caches = before.iter().fold(caches, |caches, before| caches.then(&before.programs));
            let report = simulate_from(caches, &picture.programs, &mut ());
            TimingRow::new(&world.name, frame, picture.rays, config, &report)
        };
        Ok(begun.into_par_iter().map(row).collect())
    }

    /// A picture, from memory if it is there.
    fn traced(&mut self, frame: usize) -> Traced {
        let OnChip { world, trace, order, .. } = self.run;
        let trace = || {
            let recording = record(world, frame, &trace, order);
            Traced { programs: Arc::new(recording.programs), rays: recording.picture.rays.total() }
        };
        self.traced.entry(frame).or_insert_with(trace).clone()
    }

    /// The caches after all frames before this one.
    fn walked_to(&mut self, frame: usize) -> Caches {
        while self.walked.0 < frame {
            let next = self.walked.0;
            self.traced.retain(|number, _| *number >= next);
            let picture = self.traced(next);
            let (done, caches) = &mut self.walked;
            *caches = caches.clone().then(&picture.programs);
            *done += 1;
        }
        self.walked.1.clone()
    }
}
