//! Figure 3 (§4): working set and transfers, frame by frame.

use crate::table2::rows_of;
use saarcor_studies::StudyError;
use saarcor_studies::hot_spots::{HotFrame, cuts, hot_spots};
use saarcor_studies::monitor::Monitor;
use saarcor_studies::standard;
use saarcor_studies::trace::TraceOptions;
use saarcor_studies::walk::{FrameRow, Walk, WalkOptions};
use saarcor_studies::world::World;
use serde::Serialize;

/// A graph of Figure 3.
#[derive(Clone, Debug, Serialize)]
pub struct Graph {
    /// Name of the scene, without folders.
    pub name: String,
    /// Size of the on-board memory.
    pub memory_bytes: u64,
    /// Frames of the whole path.
    pub path_frames: usize,
    /// One frame in so many was walked through.
    pub step: usize,
    /// The frames that were walked through.
    pub frames: Vec<FrameRow>,
    /// The hot spots among them, one for each of the paper's of this scene.
    pub hot_spots: Vec<HotFrame>,
    /// The frames of the path before which the camera cuts.
    pub cuts: Vec<usize>,
}

impl Graph {
    /// Walks through each `step`th frame of the world's path, from frame 0 on, with the standard
    /// virtual memory of the paper's scene `of`.
    ///
    /// # Errors
    /// If the standard sizes do not make a cache.
    pub fn new(
        name: &str,
        of: &str,
        world: &World,
        step: usize,
        trace: &TraceOptions,
        monitor: &dyn Monitor,
    ) -> Result<Self, StudyError> {
        let cache = standard::cache(of)?;
        let path_frames = world.path.len();
        let chosen = (0..path_frames).step_by(step);
        let (mut frames, length) = (Vec::new(), chosen.len());
        monitor.during(&format!("{name}: walk of {length} frames"), |report| {
            let options = WalkOptions { cache, cold: false, trace: *trace };
            for row in Walk::new(world, chosen, &options) {
                frames.push(row);
                report(frames.len() as f64 / length as f64);
            }
        });
        Ok(Self {
            name: name.to_owned(),
            memory_bytes: cache.geometry.memory().0,
            path_frames,
            step,
            hot_spots: hot_spots(&frames, &world.path, rows_of(of).count()),
            frames,
            cuts: cuts(&world.path).into_iter().collect(),
        })
    }

    /// The first frame that has the most of something.
    #[must_use]
    pub fn peak(&self, value: fn(&FrameRow) -> u64) -> Option<&FrameRow> {
        self.frames.iter().rev().max_by_key(|row| value(row))
    }
}
