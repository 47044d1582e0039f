//! `saarcor crosscheck`.

use super::accuracy::surface_of;
use crate::args::SceneArgs;
use crate::output::{OutFile, Stdout, json_line, temporaries};
use crate::progress::Progress;
use crate::status::Status;
use crate::table::{Column, Table};
use anyhow::{Context, Result, ensure};
use glam::Vec3;
use saarcor_model::host::{Edges, Kernel};
use saarcor_oracles::embree::{ENVIRONMENTS, Embree};
use saarcor_oracles::surfaces::Place;
use saarcor_studies::accuracy::exactly_one::Counts;
use saarcor_studies::crosscheck::edges::hits_at_edges;
use saarcor_studies::crosscheck::judge::RayRow;
use saarcor_studies::crosscheck::rays::{Question, questions};
use saarcor_studies::crosscheck::{ClassCounts, CrosscheckReport, Faults, crosscheck, kept};
use saarcor_studies::names::kernel_name;
use saarcor_studies::world::World;
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
        let mut options = self.scene.options(None)?;
        options.kernel = self.scene.kernel.unwrap_or(Kernel::Adaptive);
        // Errors of the scene come first, also where there is no Embree.
        let (world, scene) = World::open_with_scene(&options, progress)?;
        out.iter().try_for_each(|out| out.check_inputs(&world.files))?;
        for folder in [&*std::env::temp_dir(), &self.environment] {
            temporaries::watch(folder).context("signals cannot be waited for")?;
        }
        let triangles: Vec<[Vec3; 3]> = scene.triangles.iter().map(|triangle| triangle.corners).collect();
        let owned = (self.scene.edges == Edges::Owned)
            .then(|| surface_of(&world.name, &triangles, progress))
            .transpose()?;
        let embree = open_embree(&self.environment, progress)?;
        if let Some((place, judged)) = owned {
            return self.at_edges(&place, judged, &embree, progress);
        }
        let asked = match &replayed {
            Some(replayed) => replayed.clone(),
            None => questions(&world, &triangles, self.rays as usize, self.seed),
        };
        let kernel = kernel_name(options.kernel);
        let (report, cases) = crosscheck(&world, kernel, &triangles, &asked, &embree, progress)?;

        let mut stdout = Stdout::new();
        for case in cases.iter().filter(|_| replayed.is_some()) {
            if self.json { json_line(&mut stdout, &case.row())? } else { stdout.line(text(&case.row()))? }
        }
        if self.json {
            json_line(&mut stdout, &report)?;
        } else {
            stdout.line(table(&report))?;
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

impl Args {
    /// Counts the triangles that rays at edges and vertices hit.
    fn at_edges(
        &self,
        place: &Place,
        judged: Status,
        embree: &Embree,
        progress: &Progress,
    ) -> Result<Status> {
        ensure!(
            self.replay.is_none() && self.out.is_none(),
            "--edges owned counts hits at edges and vertices: it keeps and replays no rays"
        );
        let report = progress.during(&format!("{}: rays at edges and vertices", place.name), |_| {
            hits_at_edges(place, self.rays.into(), self.seed, embree)
        })?;
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &report)?;
        } else {
            let numbers = ["rays", "none", "two"].map(Column::number);
            let mut table =
                Table::new([Column::text("hits at edges and vertices")].into_iter().chain(numbers));
            let rows = [
                ("adaptive, owned edges", report.model),
                ("Embree, robust", report.embree_robust),
                ("Embree", report.embree_fast),
            ];
            for (name, Counts { cases, none, two, .. }) in rows {
                table.row([name.to_owned(), cases.to_string(), none.to_string(), two.to_string()]);
            }
            out.line(table)?;
        }
        out.finish()?;
        progress.say(format_args!(
            "{} of {} rays are left out: at silhouettes, behind other triangles, or at vertices of many triangles",
            report.left_out, report.rays
        ));
        Ok(if report.model.wrong() == 0 { judged } else { Status::Disproved })
    }
}

/// The environment with Embree, which is made if it is not there yet.
fn open_embree(folder: &Path, progress: &Progress) -> Result<Embree> {
    if let Some(embree) = Embree::find(folder)? {
        return Ok(embree);
    }
    Ok(progress.during("Embree: its Python environment", |_| Embree::make(folder))?)
}

/// A row a kind of ray, and one for all.
fn table(report: &CrosscheckReport) -> Table {
    let numbers = [
        "rays",
        "agree",
        "tie",
        "edge",
        "within bound",
        "Embree wrong",
        "model wrong",
        "robust: hit",
        "miss",
        "triangle",
        "fast: hit",
        "miss",
        "triangle",
    ];
    let columns = [Column::text("kind")].into_iter().chain(numbers.map(Column::number));
    let mut table = Table::new(columns);
    let kinds = report.by_kind().map(|(kind, counts)| (kind.name(), counts));
    for (name, counts) in kinds.chain([("all", &report.all)]) {
        let numbers = numbers_of(counts).map(|number| number.to_string());
        table.row([name.to_owned()].into_iter().chain(numbers));
    }
    table
}

/// The counts in the order of the table's columns.
fn numbers_of(counts: &ClassCounts) -> [u64; 13] {
    let Faults { wrong_hit: a, wrong_miss: b, wrong_triangle: c } = counts.embree_robust;
    let Faults { wrong_hit: d, wrong_miss: e, wrong_triangle: f } = counts.embree_fast;
    let ClassCounts { rays, agree, tie, edge, within_bound, embree_wrong, model_wrong, .. } = *counts;
    [rays, agree, tie, edge, within_bound, embree_wrong, model_wrong, a, b, c, d, e, f]
}

fn read(path: &Path) -> Result<Vec<Question>> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("{name}: cannot be read"))?;
    Ok(kept::from_text(&text, &name)?)
}

/// A case as a line of text.
fn text(case: &RayRow) -> String {
    let answer = |answer: &Option<(u32, f32)>| match answer {
        Some((triangle, t)) => format!("{triangle} at {t}"),
        None => "nothing".to_owned(),
    };
    let exact: Vec<_> = case.exact.iter().map(u32::to_string).collect();
    format!(
        "{} {}: hit first {}; model {}; robust {}; fast {}",
        case.class.name(),
        case.kind.name(),
        if exact.is_empty() { "nothing".to_owned() } else { exact.join(", ") },
        answer(&case.model),
        answer(&case.robust),
        answer(&case.fast)
    )
}
