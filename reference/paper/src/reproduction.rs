//! The paper's figures, ours beside theirs: the metadata law (§3), Table 1, Figure 3 and Table 2
//! (§4), and the paper's claims.

use crate::alternatives::SHALLOW_TREE;
use crate::claims::{Claim, Evidence, judge};
use crate::error::ReproductionError;
use crate::figure3::{Graph, MemoryRow};
use crate::fit::Fits;
use crate::metadata;
use crate::sections::Section;
use crate::table1::SceneRow;
use crate::table2::{self, HotSpot, How, STANDARD, StandIn};
use saarcor_model::time::{ChipConfig, Version};
use saarcor_model::vm::CacheConfig;
use saarcor_scenes::read_cameras;
use saarcor_studies::StudyError;
use saarcor_studies::hot_spots::cuts;
use saarcor_studies::metadata::MetadataFacts;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::walk::WalkOptions;
use saarcor_studies::world::kept::KeptWorlds;
use saarcor_studies::world::{World, WorldOptions};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

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

impl Extent {
    /// How the pictures are traced.
    pub(crate) fn trace(self) -> TraceOptions {
        let resolution = if self == Self::Quick { QUICK_RESOLUTION } else { standard::RESOLUTION };
        TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: standard::MAX_BOUNCES }
    }
}

/// What to reproduce, and how thoroughly.
#[derive(Clone, Debug)]
pub struct ReproductionOptions {
    /// How thoroughly.
    pub extent: Extent,
    /// A folder with the real scenes `oa_dm3` and `conference`, which then stand in for pQuake3
    /// and for Conference, too.
    pub scenes: Option<PathBuf>,
    /// Where worlds are kept from run to run, if they are.
    pub kept: Option<KeptWorlds>,
    /// Frames before each hot spot that warm the caches.
    pub warm_up: WarmUp,
}

/// A scene of the user's, in place of the paper's.
#[derive(Clone, Debug)]
pub struct OwnScene {
    /// How it is opened.
    pub world: WorldOptions,
    /// A file with the camera's path, in place of the one beside the scene.
    pub path: Option<PathBuf>,
    /// Its name, for titles and files.
    pub name: String,
    /// The virtual memory that it is walked through and simulated with.
    pub cache: CacheConfig,
    /// Other sizes of on-board memory, with which it is walked through.
    pub memories: Vec<CacheConfig>,
    /// Frames before each hot spot that warm the caches.
    pub warm_up: WarmUp,
}

/// All figures that were reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
    /// The scene, if it is one of the user's.
    pub scene: Option<String>,
    /// How thoroughly.
    pub extent: Extent,
    /// Pixels a row, and rows, of the pictures.
    pub resolution: (u32, u32),
    /// Frames before each hot spot that warm the caches, as text: a number, or `walk` for all.
    pub warm_up: WarmUp,
    /// The examples of §3.
    pub metadata: Vec<MetadataFacts>,
    /// Table 1.
    pub table1: Vec<SceneRow>,
    /// Figure 3's graphs, and those of the other scenes.
    pub figure3: Vec<Graph>,
    /// The walk of a scene of the user's with other sizes of on-board memory.
    pub memories: Vec<MemoryRow>,
    /// Table 2.
    pub table2: Vec<HotSpot>,
    /// Frames after a cut of the camera in the place of its hot spots: what a cut costs.
    pub cuts: Vec<HotSpot>,
    /// How far Table 2's relations lie from the paper's; none for a scene of the user's.
    pub fit: Option<Fits>,
    /// The paper's claims.
    pub claims: Vec<Claim>,
}

/// Frames of the walk through a scene of the user's, about: by the extent.
const OWN_FRAMES: [usize; 2] = [15, 60];
/// Hot spots of a scene of the user's.
const OWN_HOT_SPOTS: usize = 3;

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
        let ReproductionOptions { extent, warm_up, .. } = *options;
        let sections = Section::all(options.scenes.as_deref(), options.kept.as_ref())?;
        let trace = extent.trace();
        let how = How { setting: STANDARD, warm_up, trace: &trace };

        let all: f64 = sections.iter().map(|section| section.seconds(extent)).sum();
        let mut done = 0.0;
        let (mut table1, mut figure3) = (BTreeMap::new(), BTreeMap::new());
        let (mut table2, mut after_cuts) = (BTreeMap::new(), Vec::new());
        let mut frames_of: BTreeMap<(&str, bool), Vec<usize>> = BTreeMap::new();
        for section in &sections {
            let Section { place, row, name, real, options } = section;
            // One world at a time: the largest takes a few GB.
            let world = World::open(options, monitor)?;
            if !real {
                table1.insert(place, SceneRow::new(row, &world));
            }
            if let Some(mut graph) = section.graph(&world, extent, monitor)? {
                graph.add_fps(&world, &standard::chip(&row.scene, Version::A)?, trace, monitor)?;
                let frames = graph.hot_spots.iter().map(|spot| spot.frame).collect();
                frames_of.insert(section.family(), frames);
                figure3.insert(place, graph);
            }
            let stand_in = StandIn { scene: name, real: *real, of: Some(&row.scene) };
            let simulate = |frames: &[usize]| table2::hot_spots(stand_in, &world, frames, &how, monitor);
            let mut spots = simulate(frames_of.get(&section.family()).map_or(&[][..], Vec::as_slice))?;
            if section.is_first() {
                after_cuts.extend(simulate(&cuts(&world.path).into_iter().collect::<Vec<_>>())?);
            }
            drop(world);
            if section.family().0 == "Cruiser" {
                with_shallow_tree(section, &mut spots, &how, monitor)?;
            }
            table2.insert(place, spots);
            done += section.seconds(extent);
            report(done / all);
        }
        let reproduction = Self {
            scene: None,
            extent,
            resolution: trace.resolution,
            warm_up,
            metadata: metadata::examples(),
            table1: table1.into_values().collect(),
            figure3: figure3.into_values().collect(),
            memories: Vec::new(),
            table2: table2.into_values().flatten().collect(),
            cuts: after_cuts,
            fit: None,
            claims: Vec::new(),
        };
        let fit = Some(Fits::of(&reproduction.table2));
        Ok(Self { fit, ..reproduction }.judged())
    }

    /// The same figures of a scene of the user's: its walk, also with other sizes of on-board memory, and its hot spots.
    ///
    /// # Errors
    /// If the scene cannot be made ready.
    pub fn of_scene(
        scene: &OwnScene,
        extent: Extent,
        monitor: &dyn Monitor,
    ) -> Result<Self, ReproductionError> {
        let OwnScene { world, path, name, cache, memories, warm_up } = scene;
        let warm_up = *warm_up;
        // A wrong path is found before the kd-tree is built.
        let path = path.as_deref().map(read_cameras).transpose().map_err(StudyError::from)?;
        let (trace, mut world) = (extent.trace(), World::open(world, monitor)?);
        world.path = path.unwrap_or(world.path);
        let step = match extent {
            Extent::Quick => world.path.len().div_ceil(OWN_FRAMES[0]),
            Extent::Some => world.path.len().div_ceil(OWN_FRAMES[1]),
            Extent::All => 1,
        };
        let options = WalkOptions { cache: *cache, cold: false, trace };
        let (mut graph, memories) =
            Graph::with_memories(name, &world, &options, memories, step.max(1), OWN_HOT_SPOTS, monitor);
        let stand_in = StandIn { scene: name, real: false, of: None };
        // A built-in scene has the first-level caches that it has in Table 2.
        let l1 = standard::chip(&scene.world.scene, Version::None)?.l1;
        let with_cache = |config| ChipConfig { cache: *cache, l1, ..config };
        let chip = with_cache(ChipConfig::standard(Version::A, *cache));
        graph.add_fps(&world, &chip, trace, monitor)?;
        let how = How { setting: &with_cache, warm_up, trace: &trace };
        let simulate = |frames: &[usize]| table2::hot_spots(stand_in, &world, frames, &how, monitor);
        let frames: Vec<usize> = graph.hot_spots.iter().map(|spot| spot.frame).collect();
        let after_cuts: Vec<usize> = graph.cuts.iter().copied().take(OWN_HOT_SPOTS).collect();
        let reproduction = Self {
            scene: Some(name.clone()),
            extent,
            resolution: trace.resolution,
            warm_up,
            metadata: Vec::new(),
            table1: Vec::new(),
            table2: simulate(&frames)?,
            cuts: simulate(&after_cuts)?,
            figure3: vec![graph],
            memories,
            fit: None,
            claims: Vec::new(),
        };
        Ok(reproduction.judged())
    }

    /// With the paper's claims, judged by all else.
    fn judged(self) -> Self {
        let Self { metadata, table1, figure3, table2, cuts, .. } = &self;
        let claims =
            judge(Evidence { examples: metadata, scenes: table1, graphs: figure3, spots: table2, cuts });
        Self { claims, ..self }
    }
}

/// Adds to the hot spot whose triangle cache hits least what it would be with a kd-tree that is cut off early.
fn with_shallow_tree(
    section: &Section,
    spots: &mut [HotSpot],
    how: &How<'_>,
    monitor: &dyn Monitor,
) -> Result<(), ReproductionError> {
    let rate = |spot: &&mut HotSpot| spot.no_vm.hit_rate("intersection");
    let Some(spot) = spots.iter_mut().min_by(|a, b| rate(a).total_cmp(&rate(b))) else { return Ok(()) };
    let mut options = section.options.clone();
    options.tree.max_depth = Some(section.row.triangles.ilog2() + 2);
    let world = World::open(&options, monitor)?;
    let stand_in = StandIn { scene: &section.name, real: section.real, of: Some(&section.row.scene) };
    let tree = table2::with_other_tree(stand_in, &world, spot.frame, SHALLOW_TREE, how, monitor)?;
    spot.alternatives.push(tree);
    Ok(())
}
