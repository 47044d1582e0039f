//! The paper's figures, ours beside theirs: the metadata law (§3), Table 1, Figure 3 and Table 2
//! (§4), and the paper's claims.

use crate::error::ReproductionError;
use crate::figure3::Graph;
use crate::fit::Fits;
use crate::metadata;
use crate::table1::SceneRow;
use crate::table2::{self, HotSpot, HotSpotRuns, STANDARD, StandIn, Variation};
use crate::tables::{self, Table1Row};
use crate::verdicts::{ClaimVerdict, judge};
use saarcor_studies::hot_spots::cuts;
use saarcor_studies::metadata::MetadataFacts;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::standard::{self, family};
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

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
pub struct ReproductionOptions {
    /// How thoroughly.
    pub extent: Extent,
    /// A folder with the real scenes `oa_dm3` and `conference`, which then stand in for pQuake3
    /// and for Conference, too.
    pub scenes: Option<PathBuf>,
}

/// All figures that were reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
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
    /// Frames after a cut of the camera in the place of its hot spots: what a cut costs.
    pub cuts: Vec<HotSpot>,
    /// How far Table 2's relations lie from the paper's.
    pub fit: Fits,
    /// Some of its hot spots with other virtual memories.
    pub variations: Vec<Variation>,
    /// The paper's claims.
    pub verdicts: Vec<ClaimVerdict>,
}

/// A scene of the paper whose path is walked: one frame in so many, of the usual and of the quick
/// form. The paper's Figure 3 has the first and the last.
struct WalkedScene {
    of: &'static str,
    step: usize,
    quick_step: usize,
}

const WALKS: [WalkedScene; 4] = [
    WalkedScene { of: "pQuake3", step: 2, quick_step: 10 },
    WalkedScene { of: "Conference", step: 10, quick_step: 40 },
    WalkedScene { of: "Sodahall", step: 10, quick_step: 60 },
    WalkedScene { of: "Cruiser", step: 20, quick_step: 40 },
];

/// The real scenes, and the families of the paper's scenes for which they stand in.
const REAL_SCENES: [(&str, &str); 2] = [("oa_dm3", "pQuake3"), ("conference", "Conference")];

/// One of our scenes in the place of one of the paper's.
struct Section {
    /// Its place in the tables.
    place: usize,
    row: &'static Table1Row,
    /// Name of its graph's files.
    name: String,
    /// Whether it is a real scene.
    real: bool,
    options: WorldOptions,
}

impl Section {
    /// All sections: of the built-in scenes, then of those of `scenes`. Of each family the walked one is the first, since
    /// the others take their hot spots from it.
    fn all(scenes: Option<&Path>) -> Result<Vec<Self>, ReproductionError> {
        let built_in = |(place, row): (usize, &'static Table1Row)| {
            let name = row.scene.to_lowercase();
            Self { place, row, options: WorldOptions::new(&name), name, real: false }
        };
        let mut sections: Vec<Self> = tables::table1().iter().enumerate().map(built_in).collect();
        for (scene, kind) in REAL_SCENES {
            let Some(scenes) = scenes else { break };
            let path = scenes.join(scene).join(scene).with_extension("obj");
            if !path.is_file() {
                return Err(ReproductionError::NoRealScene { folder: scenes.to_owned(), scene });
            }
            let file = path.to_str().ok_or_else(|| ReproductionError::NotText(path.clone()))?;
            let name = format!("real-{scene}");
            for row in tables::table1().iter().filter(|row| family(&row.scene) == kind) {
                let options = WorldOptions {
                    lights: Some(row.lights as usize),
                    no_textures: row.textures_mb.is_none(),
                    ..WorldOptions::new(file)
                };
                let place = sections.len();
                sections.push(Self { place, row, name: name.clone(), real: true, options });
            }
        }
        sections.sort_by_key(|section| !section.is_walked());
        Ok(sections)
    }

    /// The scenes that have its hot spots: those of its family, built-in or real.
    fn family(&self) -> (&'static str, bool) {
        (family(&self.row.scene), self.real)
    }

    fn walk(&self) -> Option<&'static WalkedScene> {
        WALKS.iter().find(|walk| walk.of == self.row.scene)
    }

    fn is_walked(&self) -> bool {
        self.walk().is_some()
    }

    /// Whether it is the first of its family in the paper's tables: it shows what a cut of the camera costs.
    fn is_first(&self) -> bool {
        let mut rows = tables::table1().iter();
        rows.find(|row| family(&row.scene) == self.family().0).is_some_and(|row| row.scene == self.row.scene)
    }

    /// Which frames are walked, if any: one in so many.
    fn step(&self, extent: Extent) -> Option<usize> {
        let walk = self.walk()?;
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
        let hot_spots = table2::rows_of(&self.row.scene).count();
        self.row.triangles as f64 * 1e-5 + pixels * frame * (frames + 12.0 * hot_spots as f64)
    }
}

impl Reproduction {
    /// Computes all figures. `report` learns the part of the work that is done, 0 to 1, when a scene is.
    ///
    /// # Errors
    /// If a scene cannot be made ready.
    pub fn compute(
        options: &ReproductionOptions,
        monitor: &dyn Monitor,
        report: &mut dyn FnMut(f64),
    ) -> Result<Self, ReproductionError> {
        let extent = options.extent;
        let sections = Section::all(options.scenes.as_deref())?;
        let resolution = if extent == Extent::Quick { QUICK_RESOLUTION } else { standard::RESOLUTION };
        let trace =
            TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES };

        let all: f64 = sections.iter().map(|section| section.seconds(extent)).sum();
        let mut done = 0.0;
        let (mut table1, mut figure3) = (BTreeMap::new(), BTreeMap::new());
        let (mut runs, mut after_cuts) = (BTreeMap::new(), Vec::new());
        let mut frames_of: BTreeMap<(&str, bool), Vec<usize>> = BTreeMap::new();
        for section in &sections {
            let Section { place, row, name, real, options } = section;
            // One world at a time: the largest takes a few GB.
            let world = World::open(options, monitor)?;
            if !real {
                table1.insert(place, SceneRow::new(row, &world));
            }
            if let Some(step) = section.step(extent) {
                let graph = Graph::new(name, &row.scene, &world, step, &trace, monitor)?;
                let frames = graph.hot_spots.iter().map(|spot| spot.frame).collect();
                frames_of.insert(section.family(), frames);
                figure3.insert(place, graph);
            }
            let stand_in = StandIn { scene: name, real: *real, of: &row.scene };
            let frames = frames_of.get(&section.family()).map_or(&[][..], Vec::as_slice);
            runs.insert(place, table2::hot_spots(stand_in, &world, frames, STANDARD, &trace, monitor)?);
            if section.is_first() {
                let cuts: Vec<usize> = cuts(&world.path).into_iter().collect();
                after_cuts
                    .extend(table2::hot_spots(stand_in, &world, &cuts, STANDARD, &trace, monitor)?.spots);
            }
            done += section.seconds(extent);
            report(done / all);
        }
        let (mut table2, mut variations) = (Vec::new(), Vec::new());
        for HotSpotRuns { spots, variations: varied } in runs.into_values() {
            table2.extend(spots);
            variations.extend(varied);
        }
        let (table1, figure3) = (table1.into_values().collect(), figure3.into_values().collect::<Vec<_>>());
        let metadata = metadata::examples();
        let verdicts = judge(&metadata, &figure3, &table2, &variations);
        let fit = Fits::of(&table2);
        Ok(Self {
            extent,
            resolution,
            metadata,
            table1,
            figure3,
            table2,
            cuts: after_cuts,
            fit,
            variations,
            verdicts,
        })
    }
}
