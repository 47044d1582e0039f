//! `saarcor walk`.

use super::auto::AutoArgs;
use crate::args::{CacheArgs, FrameRange, SceneArgs, TraceArgs, describe};
use crate::limits::check_state;
use crate::output::{Stdout, json_line};
use crate::progress::Progress;
use crate::size::Size;
use crate::table::{Column, aligned};
use crate::{sample, summary};
use anyhow::Result;
use saarcor_model::vm::{Bytes, Geometry};
use saarcor_paper::mb;
use saarcor_studies::sampling::plan::SampleFraction;
use saarcor_studies::sampling::walk::walk_sample;
use saarcor_studies::summary::Summary;
use saarcor_studies::walk::{FrameRow, Walk, WalkOptions, WalkTotals};
use std::collections::BTreeSet;
use std::io::{IsTerminal, stdout};

/// Step one of the paper's §4: rays, traffic and working set of each frame of a walk
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    auto: AutoArgs,
    /// Frames from A on and before B [default: the whole path]
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true)]
    frames: FrameRange,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    cache: CacheArgs,
    /// Empties the virtual memory before each frame
    #[arg(long)]
    cold: bool,
    /// Works on a part of the packets in full, such as 1/8, and prints estimates with intervals of 95 %
    #[arg(long, value_name = "F")]
    sample: Option<SampleFraction>,
    /// Prints one JSON object a frame
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Walks, and prints a row a frame.
    pub fn run(self, progress: &Progress) -> Result<()> {
        let cache = self.cache.config(&self.scene.scene.text())?;
        let world = self.auto.open(&self.scene, self.frames.last(), progress)?;
        let frames = self.frames.of(&world);
        check_state(cache, Bytes(world.image.bytes.len() as u64))?;
        let scene = Summary::of(&world);
        let lines = summary::lines(&scene).into_iter();
        let lines = lines.chain([summary::image_line(&scene), describe(&cache)]);
        lines.for_each(|line| progress.say(line));

        let options = WalkOptions { cache, cold: self.cold, trace: self.trace.options() };
        let length = frames.len();
        // Rows on a terminal show how far the walk is.
        let bar = if stdout().is_terminal() { Progress::new(true) } else { *progress };
        let mut out = Stdout::new();
        if let Some(part) = self.sample {
            let frame = frames.start;
            bar.during("sample", |report| {
                let mut done = 0;
                walk_sample(&world, frames, &options, part, &mut |row| {
                    if self.json {
                        json_line(&mut out, row)?;
                    } else {
                        out.line(format_args!("frame {}: {}", frame + done, sample::heading(row)))?;
                        out.line(sample::table(row))?;
                    }
                    done += 1;
                    report(done as f64 / length as f64);
                    out.flush()
                })
            })?;
            return out.finish();
        }
        if !self.json {
            out.line(header())?;
        }
        let mut peaks = Peaks::default();
        let mut walk = Walk::new(&world, frames, &options);
        bar.during("walk", |report| -> Result<()> {
            for (done, row) in walk.by_ref().enumerate() {
                if self.json {
                    json_line(&mut out, &row)?;
                } else {
                    out.line(text(&row))?;
                }
                peaks.see(&row);
                report((done + 1) as f64 / length as f64);
                out.flush()?;
            }
            Ok(())
        })?;
        peaks.say(cache.geometry, progress);
        say_speed(&walk.totals(), progress);
        out.finish()
    }
}

/// Columns of the printed rows, and their widths.
const COLUMNS: [(&str, usize); 11] = [
    ("frame", 5),
    ("primary", 8),
    ("shadow", 8),
    ("secondary", 9),
    ("accesses", 11),
    ("hits", 11),
    ("misses", 9),
    ("working set", 11),
    ("MB", 7),
    ("collisions", 10),
    ("loaded MB", 9),
];

fn line(cells: &[String; COLUMNS.len()]) -> String {
    let columns = COLUMNS.map(|(name, _)| Column::number(name));
    aligned(&columns, &COLUMNS.map(|(_, width)| width), cells)
}

fn header() -> String {
    line(&COLUMNS.map(|(name, _)| name.to_owned()))
}

fn text(row: &FrameRow) -> String {
    line(&[
        row.frame.to_string(),
        row.primary_rays.to_string(),
        row.shadow_rays.to_string(),
        row.secondary_rays.to_string(),
        row.accesses.to_string(),
        row.hits.to_string(),
        row.misses.to_string(),
        row.working_set_lines.to_string(),
        mb(row.working_set_bytes),
        row.collisions.to_string(),
        mb(row.loaded_bytes),
    ])
}

/// The extremes of a walk: the hot spots of §4.
#[derive(Default)]
struct Peaks {
    working_set: Option<FrameRow>,
    collisions: Option<FrameRow>,
    loaded: Option<FrameRow>,
    loaded_bytes: u64,
}

impl Peaks {
    fn see(&mut self, row: &FrameRow) {
        let exceeds = |peak: &Option<FrameRow>, value: fn(&FrameRow) -> u64| {
            peak.as_ref().is_none_or(|peak| value(row) > value(peak))
        };
        if exceeds(&self.working_set, |row| row.working_set_lines) {
            self.working_set = Some(*row);
        }
        if exceeds(&self.collisions, |row| row.collisions) {
            self.collisions = Some(*row);
        }
        if exceeds(&self.loaded, |row| row.loaded_bytes) {
            self.loaded = Some(*row);
        }
        self.loaded_bytes += row.loaded_bytes;
    }

    fn say(&self, geometry: Geometry, progress: &Progress) {
        if let Some(row) = &self.working_set {
            let least = geometry.line().0 * u64::from(geometry.ways());
            let memory = Size(Bytes(row.working_set_bytes.next_power_of_two().max(least)));
            let (frame, peak) = (row.frame, mb(row.working_set_bytes));
            progress.say(format_args!(
                "largest working set: {peak} MB in frame {frame}; the least memory that holds it is {memory}"
            ));
        }
        match &self.collisions {
            Some(row) if row.collisions > 0 => {
                progress.say(format_args!("most collisions: {} in frame {}", row.collisions, row.frame))
            }
            _ => progress.say("no collisions"),
        }
        if let Some(row) = &self.loaded {
            progress.say(format_args!("most loaded: {} MB in frame {}", mb(row.loaded_bytes), row.frame));
        }
        progress.say(format_args!("loaded in all: {} MB", mb(self.loaded_bytes)));
        let collisions = self.collisions.filter(|row| row.collisions > 0);
        let spots = [self.working_set, collisions, self.loaded].into_iter().flatten();
        let spots: BTreeSet<_> = spots.map(|row| row.frame).collect();
        let spots: Vec<_> = spots.iter().map(u64::to_string).collect();
        progress
            .say(format_args!("hot spots, to be run with 'saarcor simulate --frame': {}", spots.join(", ")));
    }
}

fn say_speed(totals: &WalkTotals, progress: &Progress) {
    let millions = |count: u64, seconds: f64| count as f64 / seconds.max(f64::MIN_POSITIVE) / 1e6;
    progress.say(format_args!(
        "{:.1} s: {:.2} million rays/s, {:.1} million accesses/s; the cache alone {:.1} million accesses/s",
        totals.seconds,
        millions(totals.rays, totals.seconds),
        millions(totals.accesses, totals.seconds),
        millions(totals.accesses, totals.cache_seconds)
    ));
}
