//! `saarcor simulate --frames`.

use super::auto::AutoArgs;
use super::simulate::{OnChipArgs, say_what};
use crate::args::FrameRange;
use crate::limits::check_together;
use crate::output::{OutFile, Stdout, check_inputs};
use crate::plot::{accessible, theme};
use crate::progress::Progress;
use crate::results::Results;
use crate::status::Status;
use crate::table::{Column, Table};
use anyhow::{Context, Result, ensure};
use kuva::backend::svg::SvgBackend;
use kuva::plot::LinePlot;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_model::time::ChipConfig;
use saarcor_model::vm::Bytes;
use saarcor_paper::mb;
use saarcor_studies::frames::{Frames, MOST_TOGETHER, OnChip, WalkedRow};
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::sweep::{Position, identity};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Frames of a walk.
#[derive(Debug, clap::Args)]
pub struct FramesArgs {
    /// Frames from A on and before B, each as --frame has it, and a row for each
    #[arg(long, value_name = "A..B")]
    frames: Option<FrameRange>,
    /// One of so many of these frames [default: 1]
    #[arg(long, value_name = "N", conflicts_with = "frame", value_parser = clap::value_parser!(u32).range(1..))]
    stride: Option<u32>,
    /// Draws frames a second over the walk
    #[arg(long, value_name = "FILE.svg", conflicts_with = "frame")]
    svg: Option<PathBuf>,
}

/// What is shown of a row.
#[derive(Deserialize)]
struct Shown {
    frame: usize,
    cycles: u64,
    fps: f64,
    mem_bytes: u64,
    pci_bytes: u64,
}

impl FramesArgs {
    /// Simulates, and prints a row a frame.
    pub fn run(
        &self,
        on_chip: &OnChipArgs,
        auto: &AutoArgs,
        config: &ChipConfig,
        out: Option<&Path>,
        json: bool,
        progress: &Progress,
    ) -> Result<Status> {
        let range = self.frames.context("--frames")?;
        let svg = self.svg.as_deref().map(|path| OutFile::check(path)?.with_ending(&["svg"])).transpose()?;
        let file = out.map(|path| OutFile::check(path)?.with_ending(&["jsonl"])).transpose()?;
        if let (Some(svg), Some(file)) = (&svg, &file) {
            ensure!(svg.path() != file.path(), "--out, --svg: both name {}", svg.path().display());
        }
        if on_chip.warm_up != WarmUp::WALK {
            on_chip.check_kept(usize::MAX)?;
        }
        let world = auto.open(&on_chip.scene, range.last(), progress)?;
        svg.iter().try_for_each(|svg| svg.check_inputs(&world.files))?;
        out.map_or(Ok(()), |out| check_inputs(out, &world.files))?;
        let frames: Vec<usize> = range.of(&world).step_by(self.stride.unwrap_or(1) as usize).collect();
        ensure!(!frames.is_empty(), "--frames: the path has the frames 0 to {}", world.path.len().max(1) - 1);
        let at_a_time = rayon::current_num_threads().min(MOST_TOGETHER).min(frames.len());
        check_together(
            std::iter::repeat_n(config.cache, at_a_time),
            at_a_time,
            Bytes(world.image.bytes.len() as u64),
        )?;
        say_what(&world, config, progress);

        let scene = &*on_chip.scene.scene.text();
        let run = OnChip {
            world: &world,
            config,
            trace: on_chip.trace.options(),
            order: on_chip.chip.order,
            warm_up: on_chip.warm_up,
        };
        let sweep = identity(&world, scene, &(&frames, run.trace, run.order, run.warm_up, config));
        let position = |point| Position { sweep: sweep.clone(), point, points: frames.len() };
        let places: Vec<usize> = (0..frames.len()).collect();
        let expected: Vec<Position> = places.iter().map(|&place| position(place)).collect();
        let mut results = Results::open(out, &expected)?;
        let mut walk = Frames::new(run)?;
        progress.during("frames", |report| {
            let rows = |places: &[usize]| {
                let numbers: Vec<usize> = places.iter().map(|&place| frames[place]).collect();
                let rows = walk.rows(&numbers)?.into_iter().zip(places);
                Ok(rows.map(|(row, &place)| WalkedRow { position: position(place), row }).collect())
            };
            results.complete(&places, at_a_time, rows, report)
        })?;

        let shown = results.lines.iter().map(|line| serde_json::from_str(line).context("result"));
        let shown: Vec<Shown> = shown.collect::<Result<_>>()?;
        if let Some(file) = svg {
            let title = format!("{scene}, version {}", saarcor_studies::names::version_name(config.version));
            let drawing = drawing(&title, &shown);
            file.write(|file| Ok(file.write_all(drawing.as_bytes())?))?;
        }
        let mut out = Stdout::new();
        if json {
            results.lines.iter().try_for_each(|line| out.line(line))?;
        } else {
            out.line(table(&shown).to_string().trim_end())?;
            let cycles = shown.iter().map(|row| row.cycles).sum::<u64>();
            out.line(format_args!(
                "{} frames: {cycles} cycles, {:.1} frames a second over the walk; Mem {} MB, PCI {} MB a frame",
                shown.len(),
                config.fps(cycles) * shown.len() as f64,
                mb(shown.iter().map(|row| row.mem_bytes).sum::<u64>() / shown.len() as u64),
                mb(shown.iter().map(|row| row.pci_bytes).sum::<u64>() / shown.len() as u64),
            ))?;
        }
        out.finish()?;
        Ok(Status::Holds)
    }
}

fn table(rows: &[Shown]) -> Table {
    let mut table =
        Table::new(["frame", "cycles", "frames a second", "Mem MB", "PCI MB"].map(Column::number));
    for row in rows {
        table.row([
            row.frame.to_string(),
            row.cycles.to_string(),
            format!("{:.1}", row.fps),
            mb(row.mem_bytes),
            mb(row.pci_bytes),
        ]);
    }
    table
}

/// Frames a second over the walk as SVG.
fn drawing(title: &str, rows: &[Shown]) -> String {
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (row.frame as f64, row.fps)).collect();
    let line = LinePlot::new().with_data(points).with_color("#2f7fc1").with_stroke_width(1.2);
    let plots = vec![Plot::Line(line)];
    let layout = Layout::auto_from_plots(&plots)
        .with_width(760.0)
        .with_height(320.0)
        .with_x_label("frame")
        .with_y_label("frames a second")
        .with_y_axis_min(0.0)
        .with_grid_line_width(0.4)
        .with_theme(theme());
    let scene = render_multiple(plots, layout);
    let least = rows.iter().map(|row| row.fps).fold(f64::INFINITY, f64::min);
    let description = format!("Frames a second of {} frames; the slowest has {least:.1}.", rows.len());
    let drawn = SvgBackend::new().render_scene(&scene);
    accessible(&drawn, "frames", title, &description, (scene.width, scene.height))
}
