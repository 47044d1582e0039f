//! `saarcor render`.

use super::auto::AutoArgs;
use crate::args::{CacheArgs, SceneArgs, TraceArgs, describe};
use crate::limits::check_state;
use crate::output::{OutFile, Stdout, json_line, write_png};
use crate::progress::Progress;
use crate::summary;
use anyhow::Result;
use saarcor_model::vm::{Bytes, Counters};
use saarcor_studies::picture::{Picture, through_virtual_memory, through_whole_scene};
use saarcor_studies::summary::Summary;
use serde::Serialize;
use std::path::PathBuf;

/// The picture of a frame, through the virtual memory
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    auto: AutoArgs,
    /// Frame of the scene's path
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: usize,
    /// The picture, a PNG file; '-' is stdout
    #[arg(short, long, value_name = "FILE.png")]
    out: PathBuf,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    cache: CacheArgs,
    /// Reads the scene from flat memory, without the virtual memory
    #[arg(long)]
    flat: bool,
    /// Prints the counters as one JSON object
    #[arg(long)]
    json: bool,
}

/// The rays of a picture, and its traffic.
#[derive(Serialize)]
struct PictureRow {
    frame: usize,
    primary_rays: u64,
    shadow_rays: u64,
    secondary_rays: u64,
    #[serde(flatten)]
    traffic: Option<Traffic>,
}

/// Counters of the virtual memory.
#[derive(Serialize)]
struct Traffic {
    accesses: u64,
    hits: u64,
    misses: u64,
    evictions: u64,
}

impl From<Counters> for Traffic {
    fn from(counters: Counters) -> Self {
        let Counters { accesses, misses, evictions, .. } = counters;
        Self { accesses, hits: counters.hits(), misses, evictions }
    }
}

impl Args {
    /// Writes the picture and prints what it took.
    pub fn run(self, progress: &Progress) -> Result<()> {
        let cache = self.cache.config(&self.scene.scene.text())?;
        let file = if self.json { OutFile::check(&self.out) } else { OutFile::check_or_stdout(&self.out) };
        let file = file?.with_ending(&["png"])?;
        let world = self.auto.open(&self.scene, Some(self.frame), progress)?;
        file.check_inputs(&world.files)?;
        check_state(cache, Bytes(world.image.bytes.len() as u64))?;
        let scene = Summary::of(&world);
        let lines = summary::lines(&scene).into_iter().chain([summary::image_line(&scene)]);
        lines.for_each(|line| progress.say(line));

        let options = self.trace.options();
        let (picture, traffic) = progress.during("picture", |_| {
            if self.flat {
                (through_whole_scene(&world, self.frame, &options), None)
            } else {
                let (picture, counters) = through_virtual_memory(&world, self.frame, &options, cache);
                (picture, Some(Traffic::from(counters)))
            }
        });
        file.write(|out| write_png(&picture.pixels, out))?;
        self.say(&picture, traffic, &describe(&cache), progress)
    }

    fn say(
        &self,
        picture: &Picture,
        traffic: Option<Traffic>,
        cache: &str,
        progress: &Progress,
    ) -> Result<()> {
        let rays = picture.rays;
        progress.say(format_args!(
            "rays: {} primary, {} shadow, {} secondary",
            rays.primary, rays.shadow, rays.secondary
        ));
        match &traffic {
            Some(Traffic { accesses, hits, misses, .. }) => {
                progress.say(cache);
                progress.say(format_args!("accesses: {accesses}; {hits} hits, {misses} misses"));
            }
            None => progress.say("flat memory"),
        }
        if !self.json {
            return Ok(());
        }
        let row = PictureRow {
            frame: self.frame,
            primary_rays: rays.primary,
            shadow_rays: rays.shadow,
            secondary_rays: rays.secondary,
            traffic,
        };
        let mut out = Stdout::new();
        json_line(&mut out, &row)?;
        out.finish()
    }
}
