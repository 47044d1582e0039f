//! `saarcor accuracy --simulator`.

use crate::args::{Resolution, SceneName};
use crate::output::{Stdout, json_line};
use crate::progress::Progress;
use crate::table::{Column, Table};
use anyhow::Result;
use saarcor_model::time::Version;
use saarcor_studies::sampling::accuracy::{Accuracy, of_simulate, of_walk};
use saarcor_studies::sampling::plan::{Plan, SampleFraction};
use saarcor_studies::sampling::simulate::SampledFrame;
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::walk::WalkOptions;
use saarcor_studies::world::World;

/// Scenes that are compared where none is named.
const SCENES: [&str; 2] = ["conference", "pquake3"];

/// Denominators of the parts that are compared.
const PARTS: [u32; 6] = [2, 4, 8, 16, 32, 64];

/// What is compared, and how long.
#[derive(Debug, clap::Args)]
pub struct SimulatorArgs {
    /// Instead of triangle tests, sampled simulation (--sample of walk and simulate), from 1/2 to 1/64
    #[arg(long, conflicts_with_all = [
        "kernel", "format", "suite", "cases", "quick", "seed", "out", "replay", "scene", "budget",
    ])]
    pub simulator: bool,
    /// Scenes to walk through and to simulate, in version A; else two built-in ones
    #[arg(value_name = "SCENE", requires = "simulator")]
    scenes: Vec<SceneName>,
    /// Frames of each scene that are compared, spread over its path
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    #[arg(requires = "simulator")]
    frames: u32,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", requires = "simulator")]
    resolution: Option<Resolution>,
}

impl SimulatorArgs {
    /// Compares, and prints a row for each scene, step, part and quantity.
    pub fn run(&self, json: bool, progress: &Progress) -> Result<()> {
        let mut out = Stdout::new();
        let frames = self.frames as usize;
        let (width, height) = standard::RESOLUTION;
        let resolution = self.resolution.map_or((width, height), |it| (it.width, it.height));
        let trace =
            TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES };
        let order = PacketOrder::default();
        let parts = PARTS.map(SampleFraction::one_of);
        for part in parts {
            Plan::new(trace.tiles(), order, part, 0)?;
        }
        let scenes = match self.scenes.is_empty() {
            true => SCENES.map(SceneName::from).into(),
            false => self.scenes.clone(),
        };
        for scene in scenes {
            let world = World::open(&scene.world()?, progress)?;
            let scene = &*scene.text();
            let options = WalkOptions { cache: standard::cache(scene)?, cold: false, trace };
            let walk = progress.during(&format!("{scene}: walk"), |report| {
                of_walk(&world, frames, &parts, &options, report)
            })?;
            print(&walk, json, &mut out)?;
            let chip = standard::chip(scene, Version::A)?;
            let sampled = SampledFrame {
                frame: 0,
                warm_up: WarmUp::ONE,
                trace,
                order,
                part: SampleFraction::one_of(1),
            };
            let simulate = progress.during(&format!("{scene}: simulate"), |report| {
                of_simulate(&world, frames, &parts, &sampled, &chip, report)
            })?;
            print(&simulate, json, &mut out)?;
        }
        out.finish()
    }
}

fn print(rows: &[Accuracy], json: bool, out: &mut Stdout) -> Result<()> {
    if json {
        rows.iter().try_for_each(|row| json_line(out, row))?;
    } else {
        out.line(table(rows))?;
    }
    out.flush()
}

fn table(rows: &[Accuracy]) -> Table {
    let texts = ["scene", "step", "sample", "quantity"].map(Column::text);
    let numbers = ["frames", "coverage %", "error %", "± %", "seconds", "times as fast"].map(Column::number);
    let mut table = Table::new(texts.into_iter().chain(numbers));
    for row in rows {
        table.row([
            row.scene.clone(),
            row.step.to_owned(),
            row.sample.clone(),
            row.quantity.clone(),
            row.frames.to_string(),
            format!("{:.0}", 100.0 * row.coverage),
            format!("{:.2}", 100.0 * row.error),
            format!("{:.2}", 100.0 * row.half_width),
            format!("{:.3}", row.seconds),
            format!("{:.1}", row.speedup),
        ]);
    }
    table
}
