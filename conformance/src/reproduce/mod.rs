//! The paper's figures, ours beside theirs: the metadata law (§3), Table 1 and Figure 3 (§4).

pub mod figure3;
mod page;
mod plot;
pub mod table1;

use crate::metadata::{self, MetadataFacts};
use crate::output::{OutFile, Stdout};
use crate::progress::Progress;
use crate::standard;
use crate::walk::{PacketSize, TraceOptions};
use crate::world::{World, WorldOptions};
use anyhow::{Context, Result, ensure};
use figure3::Graph;
use saarcor_reference::paper;
use serde::Serialize;
use std::path::{Path, PathBuf};
use table1::SceneRow;

/// Size of the pictures of the quick form.
const QUICK_RESOLUTION: (u32, u32) = (256, 192);

/// What to reproduce, and how thoroughly.
#[derive(Clone, Debug)]
pub struct Options {
    /// Smaller pictures, and only some frames of the walks.
    pub quick: bool,
    /// A folder with the real scenes, whose level `oa_dm3` is then walked through too.
    pub scenes: Option<PathBuf>,
}

/// All figures that were reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Whether this is the quick form.
    pub quick: bool,
    /// Pixels a row, and rows, of the walks' pictures.
    pub resolution: (u32, u32),
    /// The examples of §3.
    pub metadata: Vec<MetadataFacts>,
    /// Table 1.
    pub table1: Vec<SceneRow>,
    /// Figure 3's graphs.
    pub figure3: Vec<Graph>,
}

/// A scene to be walked through, for a graph of Figure 3.
struct Walk {
    /// Name or path of the scene.
    scene: String,
    /// Name of the graph's files.
    name: &'static str,
    /// The quick form takes one frame in so many.
    quick_step: usize,
}

impl Walk {
    /// Figure 3's graphs.
    fn of_the_paper() -> [Self; 2] {
        let walk = |name: &'static str, quick_step| Self { scene: name.to_owned(), name, quick_step };
        [walk("pquake3", 10), walk("cruiser", 40)]
    }

    /// The level that the scenes' folder holds in the place of pQuake3.
    fn of_the_real_level(scenes: &Path) -> Result<Self> {
        let path = scenes.join("oa_dm3").join("oa_dm3.obj");
        ensure!(path.is_file(), "--scenes {}: holds no oa_dm3/oa_dm3.obj", scenes.display());
        let scene = path.to_str().with_context(|| format!("{}: is no text", path.display()))?;
        Ok(Self { scene: scene.to_owned(), name: "oa_dm3", quick_step: 10 })
    }
}

impl Report {
    /// Computes all figures.
    ///
    /// # Errors
    /// If a scene cannot be made ready.
    pub fn new(options: &Options, progress: &Progress) -> Result<Self> {
        let real = options.scenes.as_deref().map(Walk::of_the_real_level).transpose()?;
        let resolution = if options.quick { QUICK_RESOLUTION } else { standard::RESOLUTION };
        let trace =
            TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES };
        let graph = |walk: &Walk, world: &World| {
            let step = if options.quick { walk.quick_step } else { 1 };
            Graph::new(walk.name, world, step, &trace, progress)
        };

        let (mut table1, mut figure3) = (Vec::new(), Vec::new());
        let walks = Walk::of_the_paper();
        for row in paper::table1() {
            let name = row.scene.to_lowercase();
            // One world at a time: the largest takes a few GB.
            let world = World::open(&WorldOptions::new(&name), progress)?;
            table1.push(SceneRow::new(row, &world));
            if let Some(walk) = walks.iter().find(|walk| walk.scene == name) {
                figure3.push(graph(walk, &world)?);
            }
        }
        if let Some(walk) = real {
            let world = World::open(&WorldOptions::new(&walk.scene), progress)?;
            figure3.push(graph(&walk, &world)?);
        }
        Ok(Self { quick: options.quick, resolution, metadata: metadata::examples(), table1, figure3 })
    }

    /// Prints the figures as tables, and why they differ.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn print(&self, out: &mut Stdout) -> Result<()> {
        for (caption, table) in page::tables(self) {
            out.line(&caption)?;
            out.line("")?;
            out.line(table)?;
            out.line("")?;
        }
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
