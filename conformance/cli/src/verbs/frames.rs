//! `saarcor simulate --frames`.

use super::auto::AutoArgs;
use super::simulate::{OnChipArgs, say_what};
use crate::args::FrameRange;
use crate::limits::check_together;
use crate::output::{OutFile, Stdout, check_inputs};
use crate::plot::{accessible, layout};
use crate::progress::Progress;
use crate::results::Results;
use crate::sample;
use crate::status::Status;
use crate::table::{Column, Table};
use anyhow::{Context, Result, ensure};
use kuva::plot::{BandPlot, LinePlot, ScatterPlot};
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_model::time::ChipConfig;
use saarcor_model::vm::Bytes;
use saarcor_studies::frames::{Frames, MOST_TOGETHER, OnChip, WalkedRow};
use saarcor_studies::names::version_name;
use saarcor_studies::sampling::estimate::Estimate;
use saarcor_studies::sampling::fraction::SampleFraction;
use saarcor_studies::sampling::walk::{ErrorBound, EstimatedWalk, Goal, Quantities, quantities};
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
    /// Runs a part of the frames on the chip, such as 1/12, and estimates the others, with intervals of 95 %
    #[arg(long, value_name = "F", conflicts_with_all = ["frame", "out", "error"])]
    sample: Option<SampleFraction>,
    /// Runs frames on the chip until the interval of all cycles is that narrow to each side, such as 1%, and estimates the others
    #[arg(long, value_name = "P%", conflicts_with_all = ["frame", "out"])]
    error: Option<ErrorBound>,
    /// Which frames are drawn by --sample and --error
    #[arg(long, value_name = "N", conflicts_with = "frame")]
    seed: Option<u64>,
    /// Draws frames a second over the walk
    #[arg(long, value_name = "FILE.svg", conflicts_with = "frame")]
    svg: Option<PathBuf>,
}

/// What is shown of a simulated row.
#[derive(Deserialize)]
struct Row {
    frame: usize,
    cycles: u64,
    mem_bytes: u64,
    pci_bytes: u64,
}

/// What is shown of a frame.
struct Shown {
    frame: usize,
    estimated: bool,
    quantities: Vec<(&'static str, Estimate)>,
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
        let goal = self.sample.map(Goal::Part).or(self.error.map(Goal::Error));
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
        if on_chip.warm_up == WarmUp::WALK {
            ensure!(
                goal.is_none(),
                "--warm-up walk: no frames to leave out; name a number of frames with --sample and --error"
            );
        }
        let (shown, lines, sum) = match goal {
            Some(goal) => {
                let walk = EstimatedWalk::new(run, &frames, goal, self.seed.unwrap_or(0), progress)?;
                let lines = (0..frames.len()).map(|place| Ok(walk.row(place)?.to_string()));
                let lines = lines.chain([Ok(walk.sum_row().to_string())]).collect::<Result<_>>()?;
                let of = |place: usize| Shown {
                    frame: frames[place],
                    estimated: !walk.simulated.contains_key(&place),
                    quantities: walk.of(place),
                };
                ((0..frames.len()).map(of).collect(), lines, walk.sum())
            }
            None => self.all(run, &frames, out, at_a_time, progress)?,
        };
        if let Some(file) = svg {
            let title = format!("{scene}, version {}", version_name(config.version));
            let drawing = drawing(&title, &shown);
            file.write(|file| Ok(file.write_all(drawing.as_bytes())?))?;
        }
        let mut out = Stdout::new();
        if json {
            lines.iter().try_for_each(|line| out.line(line))?;
        } else {
            out.line(table(&shown).to_string().trim_end())?;
            let simulated = shown.iter().filter(|row| !row.estimated).count();
            let how = match shown.len() - simulated {
                0 => String::new(),
                _ => format!(", of which {simulated} ran on the chip, and intervals of 95 %"),
            };
            out.line(format_args!("all {} frames{how}:", shown.len()))?;
            for (name, estimate) in sum {
                out.line(format_args!("{name}: {}", sample::text(name, estimate)))?;
            }
        }
        out.finish()?;
        Ok(Status::Holds)
    }

    /// Simulates all frames.
    fn all(
        &self,
        run: OnChip<'_>,
        frames: &[usize],
        out: Option<&Path>,
        at_a_time: usize,
        progress: &Progress,
    ) -> Result<(Vec<Shown>, Vec<String>, Quantities)> {
        let OnChip { world, config, trace, order, warm_up } = run;
        let sweep = identity(world, &world.name, &(frames, trace, order, warm_up, config));
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
        let rows = results.lines.iter().map(|line| serde_json::from_str(line).context("result"));
        let rows: Vec<Row> = rows.collect::<Result<_>>()?;
        let of = |values: [u64; 3], frames: usize| {
            quantities(values.map(|value| Estimate::exact(value as f64)), config, frames)
        };
        let shown = |row: &Row| Shown {
            frame: row.frame,
            estimated: false,
            quantities: of([row.cycles, row.mem_bytes, row.pci_bytes], 1),
        };
        let total = |value: fn(&Row) -> u64| rows.iter().map(value).sum::<u64>();
        let sum = [total(|row| row.cycles), total(|row| row.mem_bytes), total(|row| row.pci_bytes)];
        Ok((rows.iter().map(shown).collect(), results.lines, of(sum, rows.len())))
    }
}

fn table(rows: &[Shown]) -> Table {
    let names = rows.first().map(|row| row.quantities.as_slice()).unwrap_or_default();
    let columns = names.iter().map(|(name, _)| Column::number(*name));
    let columns = [Column::number("frame")].into_iter().chain(columns).chain([Column::text("")]);
    let mut table = Table::new(columns);
    for row in rows {
        let numbers = row.quantities.iter().map(|(name, estimate)| sample::text(name, *estimate));
        let how = if row.estimated { "estimated" } else { "" };
        table.row([row.frame.to_string()].into_iter().chain(numbers).chain([how.to_owned()]));
    }
    table
}

/// Frames a second over the walk as SVG, as far as they are known.
fn drawing(title: &str, rows: &[Shown]) -> String {
    let of = |row: &Shown| {
        let (_, fps) =
            *row.quantities.iter().find(|(name, estimate)| *name == "fps" && estimate.is_known())?;
        Some((row.frame as f64, fps, row.estimated))
    };
    let known: Vec<(f64, Estimate, bool)> = rows.iter().filter_map(of).collect();
    let points =
        |of: fn(&Estimate) -> f64| known.iter().map(|(frame, fps, _)| (*frame, of(fps))).collect::<Vec<_>>();
    let line =
        LinePlot::new().with_data(points(|fps| fps.value)).with_color("#2f7fc1").with_stroke_width(1.2);
    let mut plots = vec![Plot::Line(line.with_legend("frames a second"))];
    let simulated =
        known.iter().filter(|(.., estimated)| !estimated).map(|(frame, fps, _)| (*frame, fps.value));
    let simulated: Vec<(f64, f64)> = simulated.collect();
    if simulated.len() < rows.len() {
        let xs: Vec<f64> = known.iter().map(|(frame, ..)| *frame).collect();
        let ends = |of: fn(&Estimate) -> f64| known.iter().map(|(_, fps, _)| of(fps)).collect::<Vec<_>>();
        let band = BandPlot::new(xs, ends(|fps| fps.low), ends(|fps| fps.high))
            .with_color("#2f7fc1")
            .with_opacity(0.25);
        plots.insert(0, Plot::Band(band));
        let ran = ScatterPlot::new().with_data(simulated).with_color("#c8641b").with_size(3.0);
        plots.push(Plot::Scatter(ran.with_legend("ran on the chip")));
    }
    let layout = layout(&plots, 320.0)
        .with_x_label("frame")
        .with_y_label("frames a second, with intervals of 95 %")
        .with_y_axis_min(0.0);
    let scene = render_multiple(plots, layout);
    let least = known.iter().map(|(_, fps, _)| fps.value).fold(f64::INFINITY, f64::min);
    let description = format!("Frames a second of {} frames; the slowest has {least:.1}.", known.len());
    accessible(&scene, "frames", title, &description)
}
