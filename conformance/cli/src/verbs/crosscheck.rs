//! `saarcor crosscheck`.

use crate::args::{SceneArgs, kernel_name};
use crate::cli::Status;
use crate::crosscheck::judge::Case;
use crate::crosscheck::rays::{Question, questions};
use crate::crosscheck::{crosscheck, kept};
use crate::embree::{ENVIRONMENTS, Embree};
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::Progress;
use crate::world::World;
use anyhow::{Context, Result};
use glam::Vec3;
use saarcor_model::rays::Kernel;
use std::path::{Path, PathBuf};

/// The model, exact arithmetic and Embree, ray by ray: where they differ, and who is right
///
/// Every ray is decided exactly. The model has to be right with its adaptive triangle test; with
/// another one it may be off by the bound that Embree is granted. Needs Python 3.10 to 3.13, and once
/// a network, for the Python environment with Embree; without, the exit status is 3.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Rays to ask about: from cameras, to lights, at random, and aimed at edges and vertices
    #[arg(long, value_name = "N", default_value_t = 100_000,
          value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    rays: u32,
    /// Chooses other rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Asks about the rays of a file that '--out' wrote, and says of each who answers what
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rays", "seed", "out"])]
    replay: Option<PathBuf>,
    /// Keeps rays on which not all agree, the first of each class, for '--replay'
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Rays of a class to keep at most
    #[arg(long, value_name = "N", default_value_t = 1000, requires = "out")]
    keep: usize,
    /// Where the Python environment with Embree is, or is made
    #[arg(long, value_name = "DIR", default_value = ENVIRONMENTS)]
    environment: PathBuf,
    /// Prints one JSON object; with '--replay', one a ray before it
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Asks all, and prints what became of the rays.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        let replayed = self.replay.as_deref().map(read).transpose()?;
        let out = self.out.as_deref().map(OutFile::check).transpose()?;
        let mut options = self.scene.options(None);
        options.kernel = self.scene.kernel.unwrap_or(Kernel::Adaptive);
        // What is wrong with the scene is said first, also where there is no Embree.
        let (world, scene) = World::open_with_scene(&options, progress)?;
        let embree = Embree::open(&self.environment, progress)?;
        let triangles: Vec<[Vec3; 3]> = scene.triangles.iter().map(|triangle| triangle.corners).collect();
        let asked = match &replayed {
            Some(replayed) => replayed.clone(),
            None => questions(&world, &triangles, self.rays as usize, self.seed),
        };
        let kernel = kernel_name(options.kernel);
        let (report, cases) = crosscheck(&world, kernel, &triangles, &asked, &embree, progress)?;

        let mut stdout = Stdout::new();
        for case in cases.iter().filter(|_| replayed.is_some()) {
            if self.json { json_line(&mut stdout, &case.told())? } else { stdout.line(said(case))? }
        }
        if self.json {
            json_line(&mut stdout, &report)?;
        } else {
            stdout.line(report.table())?;
        }
        stdout.finish()?;
        progress.say(format_args!(
            "{} rays judged exactly, {} of them also searched among all triangles",
            report.all.rays, report.searched
        ));
        if let Some(out) = out {
            let command = format!("saarcor crosscheck {} --kernel {kernel} --replay THIS", world.name);
            let text = kept::to_text(&cases, self.keep, &command);
            out.write(|file| Ok(file.write_all(text.as_bytes())?))?;
            progress.say(format_args!("{}: rays to replay", out.path().display()));
        }
        Ok(if report.all.model_wrong == 0 { Status::Holds } else { Status::Disproved })
    }
}

fn read(path: &Path) -> Result<Vec<Question>> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("{name}: cannot be read"))?;
    kept::from_text(&text, &name)
}

/// A case as a line of text.
fn said(case: &Case) -> String {
    let told = case.told();
    let answer = |answer: &Option<(u32, f32)>| match answer {
        Some((triangle, t)) => format!("{triangle} at {t}"),
        None => "nothing".to_owned(),
    };
    let exact: Vec<_> = told.exact.iter().map(u32::to_string).collect();
    format!(
        "{} {}: hit first {}; model {}; robust {}; fast {}",
        told.class.name(),
        told.kind.name(),
        if exact.is_empty() { "nothing".to_owned() } else { exact.join(", ") },
        answer(&told.model),
        answer(&told.robust),
        answer(&told.fast)
    )
}
