//! `saarcor walk`.

use super::auto::AutoArgs;
use crate::args::{CachesArgs, FrameRange, SceneArgs, TraceArgs, describe};
use crate::limits::check_walk;
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::Progress;
use crate::size::Size;
use crate::summary;
use crate::surface::{self, Loaded};
use crate::table::{Column, aligned};
use anyhow::{Context, Result, ensure};
use saarcor_kit::vm::config::{HASHES, POLICIES};
use saarcor_model::rays::RayCounts;
use saarcor_model::vm::{Bytes, CacheConfig, Geometry};
use saarcor_paper::mb;
use saarcor_studies::caches::{Caches, FrameCounts};
use saarcor_studies::hot_spots::{Extreme, HotFrame, cuts, hot_spots};
use saarcor_studies::names::name_of;
use saarcor_studies::recorded::Recorded;
use saarcor_studies::summary::Summary;
use saarcor_studies::walk::{FrameRow, Walk, WalkOptions, WalkTotals};
use serde::Serialize;
use std::fs::File;
use std::io::{BufRead, BufReader, IsTerminal, stdin, stdout};
use std::path::{Path, PathBuf};

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
    caches: CachesArgs,
    /// Draws what all virtual memories load, over their sizes
    #[arg(long, value_name = "FILE.svg", requires = "all")]
    svg: Option<PathBuf>,
    /// SCENE is a trace in place of a scene: accesses as din or as CSV of address and bytes ('-' is stdin), whose frames end at lines
    /// that begin with #
    #[arg(long = "trace", conflicts_with_all = [
        "frames", "hot_spots", "auto", "lights", "no_textures", "strict", "no_mip_maps", "tree", "kernel", "resolution",
        "packet", "bounces",
    ])]
    recorded: bool,
    /// Empties the virtual memory before each frame
    #[arg(long)]
    cold: bool,
    /// Finds so many hot spots, and cuts of the camera; with --json they are the last line [default: 3, without --json]
    #[arg(long, value_name = "N", conflicts_with = "all", value_parser = clap::value_parser!(u16).range(1..))]
    hot_spots: Option<u16>,
    /// Prints one JSON object a frame
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Walks, and prints a row a frame.
    pub fn run(self, progress: &Progress) -> Result<()> {
        let configs = self.caches.configs(&self.scene.scene.text())?;
        check_walk(&configs, Bytes(0))?;
        let svg = self.svg.as_deref().map(|path| OutFile::check(path)?.with_ending(&["svg"])).transpose()?;
        if self.recorded {
            return self.play(&configs, svg, progress);
        }
        let world = self.auto.open(&self.scene, self.frames.last(), progress)?;
        svg.iter().try_for_each(|svg| svg.check_inputs(&world.files))?;
        let frames = self.frames.of(&world);
        check_walk(&configs, Bytes(world.image.bytes.len() as u64))?;
        let scene = Summary::of(&world);
        let lines = summary::lines(&scene).into_iter().chain([summary::image_line(&scene)]);
        lines.for_each(|line| progress.say(line));
        let cache = configs[0];
        let options = WalkOptions { cache, cold: self.cold, trace: self.trace.options() };
        if self.caches.all {
            let mut walk = Walk::with_others(&world, frames.clone(), &options, &configs[1..]);
            let mut done = 0;
            progress.during("walk", |report| {
                self.all(&configs, svg, progress, &mut || {
                    report(done as f64 / frames.len() as f64);
                    done += 1;
                    Ok(walk.next_of_each())
                })
            })?;
            say_speed(&walk.totals(), progress);
            return Ok(());
        }
        progress.say(describe(&cache));
        let length = frames.len();
        // Rows on a terminal show how far the walk is.
        let bar = if stdout().is_terminal() { Progress::new(true) } else { *progress };
        let mut out = Stdout::new();
        if !self.json {
            out.line(header())?;
        }
        let mut rows = Vec::new();
        let mut walk = Walk::new(&world, frames, &options);
        bar.during("walk", |report| -> Result<()> {
            for (done, row) in walk.by_ref().enumerate() {
                self.row(&mut out, row, &cache)?;
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

    /// Prints the row of a frame.
    fn row(&self, out: &mut Stdout, row: FrameRow, cache: &CacheConfig) -> Result<()> {
        if self.json { json_line(out, &CacheRow::new(row, cache)) } else { out.line(text(&row)) }
    }

    /// Plays a trace to the virtual memories, and prints a row a frame, or of all what each loads.
    fn play(&self, configs: &[CacheConfig], svg: Option<OutFile>, progress: &Progress) -> Result<()> {
        // Which lines are touched and resident is known of the whole address space.
        let host = Bytes(1 << 32);
        check_walk(configs, host)?;
        let (path, name) = (self.scene.scene.path(), self.scene.scene.text());
        if path != Path::new(STDIN) {
            svg.iter().try_for_each(|svg| svg.check_inputs([&path]))?;
        }
        let input: Box<dyn BufRead> = match path == Path::new(STDIN) {
            true => Box::new(stdin().lock()),
            false => Box::new(BufReader::new(
                File::open(&path).with_context(|| format!("{name}: cannot be read"))?,
            )),
        };
        let (mut trace, mut caches) = (Recorded::new(input), Caches::new(configs, host));
        let mut frame = 0;
        let mut next = || -> Result<Option<Vec<FrameRow>>> {
            let counts = trace.next_frame(&mut caches, self.cold).with_context(|| name.to_string())?;
            let row = |(counts, config): (FrameCounts, &CacheConfig)| {
                FrameRow::new(frame, RayCounts::default(), counts, config.geometry.line())
            };
            let rows = counts.map(|counts| counts.into_iter().zip(configs).map(row).collect());
            frame += 1;
            Ok(rows)
        };
        if self.caches.all {
            return self.all(configs, svg, progress, &mut next);
        }
        progress.say(describe(&configs[0]));
        let (mut out, mut all) = (Stdout::new(), Vec::new());
        while let Some(rows) = next()? {
            if !self.json && all.is_empty() {
                out.line(header())?;
            }
            for row in rows {
                self.row(&mut out, row, &configs[0])?;
                all.push(row);
            }
            out.flush()?;
        }
        ensure!(!all.is_empty(), "{name}: no accesses");
        say_peaks(&all, configs[0].geometry, progress);
        out.finish()
    }

    /// Prints what all virtual memories load in the frames of `next`; with JSON a row a frame and virtual memory.
    fn all(
        &self,
        configs: &[CacheConfig],
        svg: Option<OutFile>,
        progress: &Progress,
        next: &mut dyn FnMut() -> Result<Option<Vec<FrameRow>>>,
    ) -> Result<()> {
        progress.say(format_args!("{} virtual memories", configs.len()));
        let (mut frames, mut out) = (0, Stdout::new());
        let mut loaded = vec![0; configs.len()];
        while let Some(rows) = next()? {
            for ((row, config), loaded) in rows.into_iter().zip(configs).zip(&mut loaded) {
                *loaded += row.loaded_bytes;
                if self.json {
                    json_line(&mut out, &CacheRow::new(row, config))?;
                }
            }
            frames += 1;
            out.flush()?;
        }
        let name = self.scene.scene.text();
        ensure!(frames > 0, "{name}: no accesses");
        let loaded: Vec<_> =
            configs.iter().zip(loaded).map(|(&config, bytes)| Loaded { config, bytes }).collect();
        if !self.json {
            out.line(format_args!("MB loaded by {}", surface::frames_in_words(frames)))?;
            out.line(surface::table(&loaded))?;
        }
        if let Some(svg) = svg {
            let drawing = surface::svg(&loaded, "surface", &name, frames)?;
            svg.write(|file| Ok(file.write_all(drawing.as_bytes())?))?;
        }
        out.finish()
    }
}

/// The name that stands for standard input.
const STDIN: &str = "-";

/// A row of a walk, and the virtual memory whose row it is.
#[derive(Serialize)]
struct CacheRow {
    #[serde(flatten)]
    row: FrameRow,
    memory_bytes: u64,
    ways: u32,
    line_bytes: u64,
    hash: &'static str,
    policy: &'static str,
}

impl CacheRow {
    fn new(row: FrameRow, CacheConfig { geometry, hash, policy }: &CacheConfig) -> Self {
        Self {
            row,
            memory_bytes: geometry.memory().0,
            ways: geometry.ways(),
            line_bytes: geometry.line().0,
            hash: name_of(HASHES, hash),
            policy: name_of(POLICIES, policy),
        }
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
