//! Figure 3 (§4): working set and transfers, frame by frame.

use crate::progress::Progress;
use crate::size::Size;
use crate::table::{Column, Table, mb};
use anyhow::Result;
use saarcor_model::vm::Bytes;
use saarcor_studies::standard;
use saarcor_studies::trace::TraceOptions;
use saarcor_studies::walk::{FrameRow, Walk, WalkOptions};
use saarcor_studies::world::World;
use serde::Serialize;
use std::fmt::Write as _;

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
}

/// Name and value of a column of the CSV file.
type CsvColumn = (&'static str, fn(&FrameRow) -> u64);

const CSV: [CsvColumn; 12] = [
    ("frame", |row| row.frame),
    ("primary_rays", |row| row.primary_rays),
    ("shadow_rays", |row| row.shadow_rays),
    ("secondary_rays", |row| row.secondary_rays),
    ("accesses", |row| row.accesses),
    ("hits", |row| row.hits),
    ("misses", |row| row.misses),
    ("working_set_lines", |row| row.working_set_lines),
    ("working_set_bytes", |row| row.working_set_bytes),
    ("collisions", |row| row.collisions),
    ("loaded_lines", |row| row.loaded_lines),
    ("loaded_bytes", |row| row.loaded_bytes),
];

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
        progress: &Progress,
    ) -> Result<Self> {
        let cache = standard::cache(of)?;
        let path_frames = world.path.len();
        let chosen = (0..path_frames).step_by(step);
        let (mut frames, length) = (Vec::new(), chosen.len());
        progress.during(&format!("{name}: walk of {length} frames"), |report| {
            let options = WalkOptions { cache, cold: false, trace: *trace };
            for row in Walk::new(world, chosen, &options) {
                frames.push(row);
                report(frames.len() as f64 / length as f64);
            }
        });
        Ok(Self { name: name.to_owned(), memory_bytes: cache.geometry.memory().0, path_frames, step, frames })
    }

    /// The frames as comma-separated values, under a header.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut csv = CSV.map(|(name, _)| name).join(",");
        for row in &self.frames {
            let _ = write!(csv, "\n{}", CSV.map(|(_, value)| value(row).to_string()).join(","));
        }
        csv.push('\n');
        csv
    }

    /// On-board memory, as the user writes it.
    #[must_use]
    pub fn memory(&self) -> Size {
        Size(Bytes(self.memory_bytes))
    }

    /// The first frame that has the most of something.
    pub(super) fn peak(&self, value: fn(&FrameRow) -> u64) -> Option<&FrameRow> {
        self.frames.iter().rev().max_by_key(|row| value(row))
    }
}

/// The extremes of the graphs.
#[must_use]
pub fn extremes(graphs: &[Graph]) -> Table {
    let numbers = [
        "on-board MB",
        "frames",
        "largest working set MB",
        "in frame",
        "most transferred MB",
        "in frame",
        "most collisions",
        "in frame",
        "transferred MB a frame",
    ];
    let mut table = Table::new(std::iter::once(Column::text("scene")).chain(numbers.map(Column::number)));
    for graph in graphs {
        let cells = |peak: Option<&FrameRow>, value: &dyn Fn(&FrameRow) -> String| match peak {
            Some(row) => [value(row), row.frame.to_string()],
            None => ["–".to_owned(), "–".to_owned()],
        };
        let all: u64 = graph.frames.iter().map(|row| row.loaded_bytes).sum();
        let working_set = cells(graph.peak(|row| row.working_set_bytes), &|row| mb(row.working_set_bytes));
        let loaded = cells(graph.peak(|row| row.loaded_bytes), &|row| mb(row.loaded_bytes));
        let collisions = cells(graph.peak(|row| row.collisions), &|row| row.collisions.to_string());
        let first = [graph.name.clone(), mb(graph.memory_bytes), graph.frames.len().to_string()];
        let last = mb(all / graph.frames.len().max(1) as u64);
        table.row(first.into_iter().chain(working_set).chain(loaded).chain(collisions).chain([last]));
    }
    table
}
