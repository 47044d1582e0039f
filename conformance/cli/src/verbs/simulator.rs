//! `saarcor accuracy --simulator`.

use crate::args::{Resolution, SceneName, choice};
use crate::output::{OutFile, Stdout, json_line};
use crate::plot::{accessible, layout};
use crate::progress::Progress;
use crate::table::{Column, Table};
use anyhow::{Result, ensure};
use kuva::plot::LinePlot;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_model::time::Version;
use saarcor_studies::frames::OnChip;
use saarcor_studies::names::VERSIONS;
use saarcor_studies::sampling::accuracy::{
    Accuracy, COVERAGE_TARGET, FRAME_TARGET, SPEED_TARGET, SUM_TARGET, WIDTH_TARGET, measure,
};
use saarcor_studies::sampling::choice::LEAST_DRAWN;
use saarcor_studies::sampling::fraction::SampleFraction;
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::world::World;
use std::path::PathBuf;

/// Scenes that are compared where none is named.
const SCENES: [&str; 2] = ["conference", "pquake3"];

/// Denominators of the parts that are compared.
const PARTS: [u32; 4] = [6, 12, 24, 48];

/// What is compared, and how long.
#[derive(Debug, clap::Args)]
pub struct SimulatorArgs {
    /// Instead of triangle tests, estimated walks (simulate --frames --sample), from 1/6 to 1/48: all frames once, and 200 draws of each part
    #[arg(long, conflicts_with_all = [
        "kernel", "format", "suite", "cases", "quick", "seed", "out", "replay", "scene", "budget",
    ])]
    pub simulator: bool,
    /// Scenes to simulate; else two built-in ones
    #[arg(value_name = "SCENE", requires = "simulator")]
    scenes: Vec<SceneName>,
    /// Frames of each scene that are compared, spread over its path
    #[arg(long, value_name = "N", default_value_t = 72, value_parser = clap::value_parser!(u32).range(1..))]
    #[arg(requires = "simulator")]
    frames: u32,
    /// Version of the virtual memory: none, a or b [default: all]
    #[arg(long, value_parser = choice(VERSIONS), requires = "simulator")]
    variant: Option<Version>,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", requires = "simulator")]
    resolution: Option<Resolution>,
    /// Draws how many times as fast estimates are, and how far off
    #[arg(long, value_name = "FILE.svg", requires = "simulator")]
    svg: Option<PathBuf>,
}

impl SimulatorArgs {
    /// Compares, and prints a row for each scene, version, part and quantity.
    pub fn run(&self, json: bool, progress: &Progress) -> Result<()> {
        let mut out = Stdout::new();
        let svg = self.svg.as_deref().map(|path| OutFile::check(path)?.with_ending(&["svg"])).transpose()?;
        ensure!(
            self.frames as usize > LEAST_DRAWN,
            "--frames {}: at least {} are needed, of which {LEAST_DRAWN} are drawn",
            self.frames,
            LEAST_DRAWN + 1
        );
        let resolution = self.resolution.map_or(standard::RESOLUTION, |it| (it.width, it.height));
        let trace =
            TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES };
        let scenes = match self.scenes.is_empty() {
            true => SCENES.map(SceneName::from).into(),
            false => self.scenes.clone(),
        };
        let mut all = Vec::new();
        for scene in scenes {
            let world = World::open(&scene.world()?, progress)?;
            svg.iter().try_for_each(|svg| svg.check_inputs(&world.files))?;
            let count = (self.frames as usize).min(world.path.len());
            let frames: Vec<usize> = (0..count).map(|place| place * world.path.len() / count).collect();
            for &(_, version) in
                VERSIONS.iter().filter(|(_, version)| self.variant.is_none_or(|one| one == *version))
            {
                let config = standard::chip(&scene.text(), version)?;
                let (order, warm_up) = (PacketOrder::default(), WarmUp::ONE);
                let run = OnChip { world: &world, config: &config, trace, order, warm_up };
                let rows = measure(run, &frames, &PARTS.map(SampleFraction::one_of), progress)?;
                if json {
                    rows.iter().try_for_each(|row| json_line(&mut out, row))?;
                } else {
                    out.line(table(&rows))?;
                }
                out.flush()?;
                all.extend(rows);
            }
        }
        if !json {
            let [least, most] = COVERAGE_TARGET;
            let [cycles, mem, pci] = SUM_TARGET.map(|target| 100.0 * target);
            out.line(format_args!(
                "targets: error {cycles} % of cycles, {mem} % of mem_bytes, {pci} % of pci_bytes; frames {} % of cycles; coverage \
                 {} to {} %; ± at most {WIDTH_TARGET} errors; {SPEED_TARGET} times as fast",
                100.0 * FRAME_TARGET,
                100.0 * least,
                100.0 * most
            ))?;
        }
        if let Some(file) = svg {
            let drawing = drawing(&all);
            file.write(|file| Ok(file.write_all(drawing.as_bytes())?))?;
        }
        out.finish()
    }
}

fn table(rows: &[Accuracy]) -> Table {
    let texts = ["scene", "version", "sample", "quantity"].map(Column::text);
    let numbers = [
        "frames",
        "on chip",
        "not known %",
        "error %",
        "± %",
        "coverage %",
        "frame error %",
        "frame coverage %",
        "times as fast",
    ]
    .map(Column::number);
    let mut table = Table::new(texts.into_iter().chain(numbers).chain([Column::text("misses")]));
    for row in rows {
        table.row([
            row.scene.clone(),
            row.variant.to_owned(),
            row.sample.clone(),
            row.quantity.to_owned(),
            row.frames.to_string(),
            row.simulated.to_string(),
            format!("{:.0}", 100.0 * row.not_known),
            percent(row.error, 2),
            percent(row.half_width, 2),
            percent(row.coverage, 0),
            format!("{:.1}", 100.0 * row.frame_error),
            format!("{:.0}", 100.0 * row.frame_coverage),
            format!("{:.1}", row.speedup),
            row.misses().join(", "),
        ]);
    }
    table
}

/// A share in percent; a dash for none.
fn percent(share: Option<f64>, digits: usize) -> String {
    share.map_or_else(|| "–".to_owned(), |share| format!("{:.digits$}", 100.0 * share))
}

/// Errors of the sum of cycles over how many times as fast the estimates are, a line a scene and version.
fn drawing(rows: &[Accuracy]) -> String {
    const COLOURS: [&str; 6] = ["#2f7fc1", "#c8641b", "#9a5fc0", "#3a9a5f", "#b0892f", "#7a7a7a"];
    let mut lines: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for row in rows.iter().filter(|row| row.quantity == "cycles") {
        let Some(error) = row.error else { continue };
        let name = format!("{}, {}", row.scene, row.variant);
        match lines.last_mut() {
            Some((last, points)) if *last == name => points.push((row.speedup, 100.0 * error)),
            _ => lines.push((name, vec![(row.speedup, 100.0 * error)])),
        }
    }
    let plots: Vec<Plot> = lines
        .into_iter()
        .zip(COLOURS.into_iter().cycle())
        .map(|((name, points), colour)| {
            let line = LinePlot::new().with_data(points).with_color(colour).with_stroke_width(1.6);
            Plot::Line(line.with_legend(name))
        })
        .collect();
    let layout = layout(&plots, 360.0)
        .with_x_label("times as fast, in processor time")
        .with_y_label("error of the cycles of a walk (%)")
        .with_y_axis_min(0.0);
    let scene = render_multiple(plots, layout);
    let description = "Root mean square error of the estimated cycles of a walk, over how many times as fast the estimate is.";
    accessible(&scene, "simulator", "Speed against error of estimated walks", description)
}
