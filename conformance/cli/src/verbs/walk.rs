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
use saarcor_studies::hot_spots::{Extreme, HotFrame, cuts, hot_spots};
use saarcor_studies::sampling::plan::SampleFraction;
use saarcor_studies::sampling::walk::walk_sample;
use saarcor_studies::summary::Summary;
use saarcor_studies::walk::{FrameRow, Walk, WalkOptions, WalkTotals};
use serde::Serialize;
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
    /// Finds so many hot spots, and cuts of the camera; with --json they are the last line [default: 3, without --json]
    #[arg(long, value_name = "N", conflicts_with = "sample", value_parser = clap::value_parser!(u16).range(1..))]
    hot_spots: Option<u16>,
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
        let mut rows = Vec::new();
        let mut walk = Walk::new(&world, frames, &options);
        bar.during("walk", |report| -> Result<()> {
            for (done, row) in walk.by_ref().enumerate() {
                if self.json {
                    json_line(&mut out, &row)?;
                } else {
                    out.line(text(&row))?;
                }
                rows.push(row);
                report((done + 1) as f64 / length as f64);
                out.flush()?;
            }
            Ok(())
        })?;
        say_peaks(&rows, cache.geometry, progress);
        let count = self.hot_spots.unwrap_or(3);
        let found = HotSpots {
            hot_spots: hot_spots(&rows, &world.path, count.into()),
            cuts: cuts(&world.path).into_iter().collect(),
        };
        found.say(progress);
        if self.json && self.hot_spots.is_some() {
            json_line(&mut out, &found)?;
        }
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

/// Says the extremes of a walk.
fn say_peaks(rows: &[FrameRow], geometry: Geometry, progress: &Progress) {
    // The first of several.
    let peak = |value: fn(&FrameRow) -> u64| rows.iter().rev().max_by_key(|row| value(row));
    if let Some(row) = peak(|row| row.working_set_lines) {
        let least = geometry.line().0 * u64::from(geometry.ways());
        let memory = Size(Bytes(row.working_set_bytes.next_power_of_two().max(least)));
        let (frame, peak) = (row.frame, mb(row.working_set_bytes));
        progress.say(format_args!(
            "largest working set: {peak} MB in frame {frame}; the least memory that holds it is {memory}"
        ));
    }
    match peak(|row| row.collisions) {
        Some(row) if row.collisions > 0 => {
            progress.say(format_args!("most collisions: {} in frame {}", row.collisions, row.frame))
        }
        _ => progress.say("no collisions"),
    }
    if let Some(row) = peak(|row| row.loaded_bytes) {
        progress.say(format_args!("most loaded: {} MB in frame {}", mb(row.loaded_bytes), row.frame));
    }
    let loaded = rows.iter().map(|row| row.loaded_bytes).sum();
    progress.say(format_args!("loaded in all: {} MB", mb(loaded)));
}

/// The hot spots of a walk, and the cuts of its path.
#[derive(Serialize)]
struct HotSpots {
    hot_spots: Vec<HotFrame>,
    cuts: Vec<usize>,
}

impl HotSpots {
    fn say(&self, progress: &Progress) {
        let list = |frames: &mut dyn Iterator<Item = String>| frames.collect::<Vec<_>>().join(", ");
        let most = |extreme| match extreme {
            Extreme::WorkingSet => "working set",
            Extreme::Collisions => "collisions",
        };
        let spots = self.hot_spots.iter().map(|spot| format!("{} ({})", spot.frame, most(spot.most)));
        let spots = list(&mut spots.into_iter());
        progress.say(format_args!("hot spots, to be run with 'saarcor simulate --frame': {spots}"));
        if !self.cuts.is_empty() {
            let cuts = list(&mut self.cuts.iter().map(usize::to_string));
            progress.say(format_args!("the camera cuts before frame {cuts}: no hot spots"));
        }
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
