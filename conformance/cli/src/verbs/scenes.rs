//! `saarcor scenes`.

use crate::args::SceneArgs;
use crate::output::{OutFile, Stdout, folder_of, json_line, temporaries};
use crate::progress::Progress;
use crate::summary::{self, listed};
use crate::table::{Column, Table};
use anyhow::{Context as _, Result};
use clap::Subcommand;
use saarcor_model::host::{Features, Scene, features};
use saarcor_paper::mb;
use saarcor_scenes::builtin::TABLE_1;
use saarcor_scenes::export_obj;
use saarcor_studies::summary::{Summary, needs};
use saarcor_studies::world::{World, WorldOptions, open_scene};
use serde::Serialize;
use std::path::PathBuf;

/// What can be rendered: lists, shows or exports scenes
#[derive(Debug, clap::Args)]
// Without a verb, the list is meant: `scenes --json`.
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(flatten)]
    list: ListArgs,
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    List(ListArgs),
    Show(ShowArgs),
    Export(ExportArgs),
}

/// The built-in scenes
#[derive(Debug, clap::Args)]
struct ListArgs {
    /// Prints one JSON object a scene
    #[arg(long)]
    json: bool,
}

/// What one scene needs of the chip, and the bytes of its image
#[derive(Debug, clap::Args)]
struct ShowArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Writes a built-in scene as OBJ, with its materials, images, camera path and lights beside it
#[derive(Debug, clap::Args)]
struct ExportArgs {
    /// The scene
    #[arg(value_name = "NAME")]
    scene: String,
    /// The file; the others lie beside it
    #[arg(short, long, value_name = "FILE.obj")]
    out: PathBuf,
}

impl Args {
    /// Prints or writes what was asked for.
    pub fn run(self, progress: &Progress) -> Result<()> {
        match self.verb.unwrap_or(Verb::List(self.list)) {
            Verb::List(args) => args.run(progress),
            Verb::Show(args) => args.run(progress),
            Verb::Export(args) => args.run(progress),
        }
    }
}

/// A scene of the list.
#[derive(Serialize)]
struct SceneRow {
    scene: &'static str,
    triangles: usize,
    lights: usize,
    texture_bytes: u64,
    frames: usize,
    needs: Vec<&'static str>,
    #[serde(skip)]
    features: Features,
}

impl SceneRow {
    fn of(name: &'static str, scene: &Scene) -> Self {
        let features = features(scene);
        let needs = needs(features).into_iter().filter(|need| need.1);
        Self {
            scene: name,
            triangles: scene.triangles.len(),
            lights: scene.lights.len(),
            texture_bytes: scene.textures.iter().map(|image| image.texels.len() as u64).sum(),
            frames: scene.path.len(),
            needs: needs.map(|need| need.0).collect(),
            features,
        }
    }
}

impl ListArgs {
    fn run(self, progress: &Progress) -> Result<()> {
        let mut out = Stdout::new();
        let mut table = Table::new([
            Column::text("scene"),
            Column::number("triangles"),
            Column::number("lights"),
            Column::number("textures MB"),
            Column::number("frames"),
            Column::text("needs"),
        ]);
        for name in TABLE_1 {
            let row = SceneRow::of(name, &generated(name, progress)?);
            if self.json {
                json_line(&mut out, &row)?;
                out.flush()?;
                continue;
            }
            table.row([
                row.scene.to_owned(),
                row.triangles.to_string(),
                row.lights.to_string(),
                mb(row.texture_bytes),
                row.frames.to_string(),
                listed(row.features, true),
            ]);
        }
        if !self.json {
            out.line(table)?;
        }
        out.finish()
    }
}

impl ShowArgs {
    fn run(self, progress: &Progress) -> Result<()> {
        // Its seconds are those of making it.
        let world = World::open(&WorldOptions { kept: None, ..self.scene.options(None)? }, progress)?;
        let scene = Summary::of(&world);
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &scene)?;
        } else {
            summary::lines(&scene).into_iter().try_for_each(|line| out.line(line))?;
            out.line("")?;
            out.line(summary::image_table(&scene))?;
        }
        progress.say(summary::seconds_line(&scene));
        out.finish()
    }
}

impl ExportArgs {
    fn run(self, progress: &Progress) -> Result<()> {
        let file = OutFile::check(&self.out)?;
        temporaries::watch(folder_of(file.path())).context("signals cannot be waited for")?;
        let scene = generated(&self.scene, progress)?;
        progress.during(&format!("{}: export", self.scene), |_| export_obj(&scene, &self.out))?;
        Ok(())
    }
}

/// The scene of this name, without a kd-tree.
fn generated(name: &str, progress: &Progress) -> Result<Scene> {
    progress.during(&format!("{name}: scene"), |_| Ok(open_scene(&WorldOptions::new(name), progress)?))
}
