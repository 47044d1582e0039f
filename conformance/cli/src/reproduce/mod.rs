//! The paper's figures, ours beside theirs: the metadata law (§3), Table 1, Figure 3 and Table 2
//! (§4), and what the paper claims.

pub mod figure3;
mod page;
mod plot;
pub mod table1;
pub mod table2;
pub mod verdicts;

use crate::metadata;
use crate::output::{OutFile, Stdout};
use crate::progress::{Progress, Remaining};
use anyhow::{Context, Result, ensure};
use figure3::Graph;
use saarcor_oracles::paper::{self, Table1Row};
use saarcor_studies::metadata::MetadataFacts;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};
use serde::Serialize;
use std::path::{Path, PathBuf};
use table1::SceneRow;
use table2::{HotSpot, Stand, Variation};
use verdicts::Verdict;

/// Size of the pictures of the quick form.
const QUICK_RESOLUTION: (u32, u32) = (256, 192);

/// How thoroughly the paths are walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Extent {
    /// Small pictures, and few frames of the walks.
    Quick,
    /// Some frames of the walks.
    Some,
    /// All frames of the walks.
    All,
}

/// What to reproduce, and how thoroughly.
#[derive(Clone, Debug)]
pub struct Options {
    /// How thoroughly.
    pub extent: Extent,
    /// A folder with the real scenes `oa_dm3` and `conference`, which then stand in for pQuake3
    /// and for Conference, too.
    pub scenes: Option<PathBuf>,
}

/// All figures that were reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// How thoroughly.
    pub extent: Extent,
    /// Pixels a row, and rows, of the pictures.
    pub resolution: (u32, u32),
    /// The examples of §3.
    pub metadata: Vec<MetadataFacts>,
    /// Table 1.
    pub table1: Vec<SceneRow>,
    /// Figure 3's graphs, and those of the other scenes.
    pub figure3: Vec<Graph>,
    /// Table 2.
    pub table2: Vec<HotSpot>,
    /// Some of its hot spots with other virtual memories.
    pub variations: Vec<Variation>,
    /// The paper's claims.
    pub verdicts: Vec<Verdict>,
}

/// A scene of the paper whose path is walked: one frame in so many, of the usual and of the quick
/// form. The paper's Figure 3 has the first and the last.
struct Walk {
    of: &'static str,
    step: usize,
    quick_step: usize,
}

const WALKS: [Walk; 4] = [
    Walk { of: "pQuake3", step: 2, quick_step: 10 },
    Walk { of: "Conference", step: 10, quick_step: 40 },
    Walk { of: "Sodahall", step: 10, quick_step: 60 },
    Walk { of: "Cruiser", step: 20, quick_step: 40 },
];

/// The real scenes, and the families of the paper's scenes for which they stand in.
const REAL_SCENES: [(&str, &str); 2] = [("oa_dm3", "pQuake3"), ("conference", "Conference")];

/// One of our scenes in the place of one of the paper's.
struct Part {
    row: &'static Table1Row,
    /// Name of its graph's files.
    name: String,
    /// Whether it is a real scene.
    real: bool,
    options: WorldOptions,
}

impl Part {
    /// All parts: the built-in scenes, then those of `scenes`.
    fn all(scenes: Option<&Path>) -> Result<Vec<Self>> {
        let built_in = |row: &'static Table1Row| {
            let name = row.scene.to_lowercase();
            Self { row, options: WorldOptions::new(&name), name, real: false }
        };
        let mut parts: Vec<Self> = paper::table1().iter().map(built_in).collect();
        let Some(scenes) = scenes else { return Ok(parts) };
        for (scene, family) in REAL_SCENES {
            let path = scenes.join(scene).join(scene).with_extension("obj");
            ensure!(path.is_file(), "--scenes {}: holds no {scene}/{scene}.obj", scenes.display());
            let file = path.to_str().with_context(|| format!("{}: is no text", path.display()))?;
            let name = format!("real-{scene}");
            for row in paper::table1().iter().filter(|row| paper::family(&row.scene) == family) {
                let options = WorldOptions {
                    lights: Some(row.lights as usize),
                    no_textures: row.textures_mb.is_none(),
                    ..WorldOptions::new(file)
                };
                parts.push(Self { row, name: name.clone(), real: true, options });
            }
        }
        Ok(parts)
    }

    /// Which frames are walked, if any: one in so many.
    fn step(&self, extent: Extent) -> Option<usize> {
        let walk = WALKS.iter().find(|walk| walk.of == self.row.scene)?;
        Some(match extent {
            Extent::Quick => walk.quick_step,
            Extent::Some => walk.step,
            Extent::All => 1,
        })
    }

    /// Roughly how many seconds it takes on two cores, for the estimate of the time left.
    fn seconds(&self, extent: Extent) -> f64 {
        let pixels = if extent == Extent::Quick { 1.0 / 16.0 } else { 1.0 };
        // A walk's frame took 1.4 s for the Cruiser; for the others 0.1 to 0.5 s a ray of a pixel.
        let frame = if self.row.scene == "Cruiser" { 1.4 } else { 0.4 * f64::from(1 + self.row.lights) };
        let frames = self.step(extent).map_or(0.0, |step| 1000.0 / step as f64);
        let hot_spots = paper::table2().iter().filter(|row| row.scene == self.row.scene).count();
        self.row.triangles as f64 * 1e-5 + pixels * frame * (frames + 12.0 * hot_spots as f64)
    }
}

impl Report {
    /// Computes all figures.
    ///
    /// # Errors
    /// If a scene cannot be made ready.
    pub fn new(options: &Options, progress: &Progress) -> Result<Self> {
        let extent = options.extent;
        let parts = Part::all(options.scenes.as_deref())?;
        let resolution = if extent == Extent::Quick { QUICK_RESOLUTION } else { standard::RESOLUTION };
        let trace =
            TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES };

        let mut remaining = Remaining::new(parts.iter().map(|part| part.seconds(extent)).sum());
        let (mut table1, mut figure3, mut runs) = (Vec::new(), Vec::new(), (Vec::new(), Vec::new()));
        for part in &parts {
            // One world at a time: the largest takes a few GB.
            let world = World::open(&part.options, progress)?;
            if !part.real {
                table1.push(SceneRow::new(part.row, &world));
            }
            if let Some(step) = part.step(extent) {
                figure3.push(Graph::new(&part.name, &part.row.scene, &world, step, &trace, progress)?);
            }
            let stand = Stand { scene: &part.name, real: part.real, of: &part.row.scene };
            table2::hot_spots(stand, &world, &trace, progress, &mut runs)?;
            remaining.done(part.seconds(extent), progress);
        }
        let (table2, variations) = runs;
        let metadata = metadata::examples();
        let mut report =
            Self { extent, resolution, metadata, table1, figure3, table2, variations, verdicts: Vec::new() };
        report.verdicts = verdicts::judge(&report);
        Ok(report)
    }

    /// Prints the figures as tables, and why they differ.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn print(&self, out: &mut Stdout) -> Result<()> {
        for (caption, table) in page::tables(self).into_iter().flatten() {
            out.line(&caption)?;
            out.line("")?;
            out.line(table)?;
            out.line("")?;
        }
        out.line("What the paper claims")?;
        out.line("")?;
        for Verdict { claim, verdict, numbers } in &self.verdicts {
            out.line(format_args!("{claim}: {verdict}"))?;
            for number in numbers {
                out.line(format_args!("    {number}"))?;
            }
        }
        out.line("")?;
        out.line("What differs, and why")?;
        out.line("")?;
        for (what, why) in page::DIFFERENCES {
            out.line(format_args!("{what} {why}"))?;
        }
        Ok(())
    }
}

/// The files of a reproduction, in one folder.
pub struct Folder {
    path: PathBuf,
    page: OutFile,
}

impl Folder {
    /// Makes the folder, and checks that it can be written to.
    ///
    /// # Errors
    /// If it cannot.
    pub fn create(path: &Path) -> Result<Self> {
        std::fs::create_dir_all(path)
            .with_context(|| format!("{}: the folder cannot be made", path.display()))?;
        Ok(Self { path: path.to_owned(), page: OutFile::check(&path.join("index.html"))? })
    }

    /// Writes a graph as SVG and CSV a figure, and the page with all of it.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, report: &Report) -> Result<PathBuf> {
        for graph in &report.figure3 {
            let file = |kind| OutFile::check(&self.path.join(format!("figure3-{}.{kind}", graph.name)));
            file("svg")?.write(|out| Ok(out.write_all(plot::svg(graph).as_bytes())?))?;
            file("csv")?.write(|out| Ok(out.write_all(graph.csv().as_bytes())?))?;
        }
        // The page comes last: where it stands, the others do.
        self.page.write(|out| Ok(out.write_all(page::html(report).as_bytes())?))?;
        Ok(self.path.join("index.html"))
    }
}
