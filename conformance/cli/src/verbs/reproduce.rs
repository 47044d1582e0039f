//! `saarcor reproduce`.

use crate::args::SceneName;
use crate::cache::kept_worlds;
use crate::limits::{check_state, check_walk};
use crate::output::{Stdout, json_line};
use crate::progress::{Progress, Remaining};
use crate::reproduce::{Folder, print, sensitivity};
use crate::size::Size;
use anyhow::Result;
use clap::builder::PossibleValuesParser;
use saarcor_model::vm::{Bytes, CacheConfig, Geometry};
use saarcor_paper::MB;
use saarcor_paper::alternatives::most_chips;
use saarcor_paper::reproduction::{Extent, OwnScene, Reproduction, ReproductionOptions};
use saarcor_paper::sensitivity::{NUMBERS, Options, Setting};
use saarcor_studies::sampling::fraction::SampleFraction;
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::standard;
use std::path::{Path, PathBuf};

/// The paper's figures, ours beside theirs: as tables, and as a page with graphs
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Small pictures, and few frames of the walks: for a first look
    #[arg(long)]
    quick: bool,
    /// All frames of the walks: hours, where some of them take a quarter to half an hour
    #[arg(long, conflicts_with = "quick")]
    all_frames: bool,
    /// Folder for the page, the graphs (SVG) and their data (CSV)
    #[arg(short, long, value_name = "DIR", default_value = "target/reproduce")]
    out: PathBuf,
    /// Folder with the real scenes: its oa_dm3 and conference stand in for pQuake3 and Conference too
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,
    /// Instead of the paper's scenes, an OBJ file (or a built-in scene): its walk, hot spots, bytes and the claims
    #[arg(long, value_name = "FILE.obj", conflicts_with_all = ["scenes", "sensitivity"])]
    scene: Option<SceneName>,
    /// The camera's path, in place of the camera.csv beside the scene
    #[arg(long, value_name = "FILE.csv", requires = "scene", conflicts_with_all = ["scenes", "sensitivity"])]
    path: Option<PathBuf>,
    /// On-board memory of the scene [default: the paper's for a built-in scene, else 8MiB]
    #[arg(long, value_name = "SIZE", requires = "scene", conflicts_with_all = ["scenes", "sensitivity"])]
    memory: Option<Size>,
    /// Each hot spot begins with what the N frames before left in the caches, or with "walk" all frames before: hours
    #[arg(long, value_name = "N|walk", default_value_t = WarmUp::ONE, conflicts_with = "sensitivity")]
    warm_up: WarmUp,
    /// Instead of the figures, Table 2 with other values of each Assumed number: hours, but a run goes on where one was
    /// stopped
    ///
    /// The folder gets sensitivity.jsonl, by which a run goes on, sensitivity.json with the result, and a tornado (SVG) of
    /// A / no VM, B / no VM, Mem and PCI. What it holds of a row is taken over by the scene's name: other files of the real scenes
    /// need another folder.
    #[arg(long, conflicts_with = "all_frames")]
    sensitivity: bool,
    /// Varies these numbers alone, and no pairs
    #[arg(long, value_name = "NAME,...", requires = "sensitivity", conflicts_with = "scene", value_delimiter = ',', value_parser = numbers())]
    over: Vec<String>,
    /// Several values at a time, such as "granule=16 B,banks=8"; may be given more than once
    #[arg(long, value_name = "SETTING", requires = "sensitivity", conflicts_with = "scene")]
    combine: Vec<Setting>,
    /// Measures a part of the rows, such as 1/4, evenly drawn from all; a later run without it goes on from there
    #[arg(long, value_name = "F", requires = "sensitivity", conflicts_with = "scene")]
    sample: Option<SampleFraction>,
    /// Prints all figures as one JSON object
    #[arg(long)]
    json: bool,
}

/// Sizes of on-board memory that are compared, in MB.
const MEMORIES: [u64; 7] = [1, 2, 4, 8, 16, 32, 64];

/// The names of the Assumed numbers.
fn numbers() -> PossibleValuesParser {
    PossibleValuesParser::new(NUMBERS.iter().map(|number| number.name))
}

impl Args {
    /// Computes all figures, writes the page and prints the tables.
    pub fn run(self, progress: &Progress) -> Result<()> {
        let extent = match (self.quick, self.all_frames) {
            (true, _) => Extent::Quick,
            (false, false) => Extent::Some,
            (false, true) => Extent::All,
        };
        if self.sensitivity {
            let sample = self.sample.unwrap_or(SampleFraction::one_of(1));
            let options = Options { extent, scenes: self.scenes, sample };
            return sensitivity::run(&self.out, &options, &self.over, &self.combine, self.json, progress);
        }
        let own = self.scene.as_ref().map(|scene| self.own_scene(scene)).transpose()?;
        let folder = Folder::create(&self.out)?;
        let reproduction = if let Some(own) = own {
            Reproduction::of_scene(&own, extent, progress)?
        } else {
            let options = ReproductionOptions {
                extent,
                scenes: self.scenes,
                kept: kept_worlds()?,
                warm_up: self.warm_up,
            };
            let remaining = Remaining::new();
            Reproduction::compute(&options, progress, &mut |part| remaining.say(part, progress))?
        };
        let page = folder.write(&reproduction)?;
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &reproduction)?;
        } else {
            print(&reproduction, &mut out)?;
        }
        progress.say(format_args!("written: {}", page.display()));
        out.finish()
    }

    /// The scene of the user's, with its memory and others to compare.
    fn own_scene(&self, scene: &SceneName) -> Result<OwnScene> {
        let text = scene.text();
        let Size(memory) = self.memory.unwrap_or(Size(standard::memory(&text)));
        let with = |memory: Bytes| -> Result<CacheConfig> {
            let geometry = Geometry::new(memory, standard::LINE, standard::WAYS)?;
            let cache = CacheConfig { geometry, ..standard::cache(&text)? };
            check_state(cache, Bytes(0))?;
            Ok(cache)
        };
        // The chips on which a hot spot is simulated are warmed side by side.
        check_walk(&vec![with(memory)?; most_chips()], Bytes(0))?;
        let mut memories: Vec<u64> = MEMORIES.map(|mb| mb * MB).into_iter().chain([memory.0]).collect();
        memories.sort_unstable();
        memories.dedup();
        let name = Path::new(&*text).file_stem().map_or_else(|| text.clone(), |stem| stem.to_string_lossy());
        Ok(OwnScene {
            world: scene.world()?,
            path: self.path.clone(),
            name: name.into_owned(),
            cache: with(memory)?,
            memories: memories.into_iter().map(|memory| with(Bytes(memory))).collect::<Result<_>>()?,
            warm_up: self.warm_up,
        })
    }
}
