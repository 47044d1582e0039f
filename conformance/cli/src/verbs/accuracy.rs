//! `saarcor accuracy`.

use super::simulator::SimulatorArgs;
use crate::args::{SceneName, choice};
use crate::front::{svg, table};
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::Progress;
use crate::status::Status;
use crate::table::{Column, Table};
use anyhow::{Context, Result, ensure};
use glam::Vec3;
use saarcor_model::host::{Edges, Kernel};
use saarcor_oracles::surfaces::{Place, Surface, SurfaceSuite};
use saarcor_studies::StudyError;
use saarcor_studies::accuracy::case::Found;
use saarcor_studies::accuracy::contest::{Contestant, Format};
use saarcor_studies::accuracy::exactly_one::{Counts, ExactlyOneOptions, ExactlyOneRow, exactly_one};
use saarcor_studies::accuracy::front::standings;
use saarcor_studies::accuracy::measure::{AccuracyRow, Fault, MeasureOptions, measure};
use saarcor_studies::accuracy::replay::{self, Record, read, worst};
use saarcor_studies::accuracy::scene::{self, Budget};
use saarcor_studies::accuracy::suites::{OffsetRow, SUITES, Suite, offset_faults, offset_rows};
use saarcor_studies::monitor::Monitor as _;
use saarcor_studies::names::{EDGES, KERNELS, Names, kernel_name, name_of};
use saarcor_studies::world::{World, WorldOptions, open_scene};
use std::path::PathBuf;

/// Cases of a suite, in full and for a quick look.
const FULL: u64 = 1_000_000;
const QUICK: u64 = 10_000;

/// Most cases of a suite: its errors are kept, four bytes a case and contestant.
const MOST: u64 = 100_000_000;

/// Runs of which the fastest counts: the first warms the caches.
const REPEATS: u32 = 2;

/// Speed against error of triangle tests and number formats, on hard cases, judged exactly
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only this triangle test; several may be named
    #[arg(long, value_parser = choice(KERNELS))]
    kernel: Vec<Kernel>,
    /// Only this number format; several may be named
    #[arg(long, value_parser = choice(Format::NAMES))]
    format: Vec<Format>,
    /// Only this suite of cases; several may be named
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(suite_names()))]
    suite: Vec<String>,
    /// Cases a suite
    #[arg(long, value_name = "N", default_value_t = FULL)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=MOST))]
    cases: u64,
    /// 10000 cases a suite: under a minute
    #[arg(long, conflicts_with = "cases")]
    quick: bool,
    /// Other cases of the same suites
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// A folder for the rows, the graph of speed against error and the worst cases
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cases that '--out' wrote, to be looked at one by one
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["suite", "cases", "quick", "out", "json"])]
    replay: Option<PathBuf>,
    /// Instead of the suites, primary rays of this scene: what does it need? With a suite of edges and vertices, those of this
    /// scene
    #[arg(long, value_name = "SCENE", conflicts_with_all = ["out", "replay"])]
    scene: Option<SceneName>,
    /// Error that is allowed on the scene's rays: wrong answers in a million, and ulps that 99.9 % of
    /// the distances may be off
    #[arg(long, value_name = "WRONG[,ULP]", requires = "scene", conflicts_with = "suite")]
    budget: Option<Budget>,
    /// Whose an edge or a vertex is that several triangles have
    #[arg(long, value_parser = choice(EDGES), default_value = name_of(EDGES, &Edges::Shared))]
    edges: Edges,
    #[command(flatten)]
    simulator: SimulatorArgs,
    /// Prints the rows as lines of JSON
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Measures and prints what was asked for.
    ///
    /// # Errors
    /// What is wrong with the arguments or the files that they name.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        if self.simulator.simulator {
            return self.simulator.run(self.json, progress).map(|()| Status::Holds);
        }
        let contestants = self.contestants()?;
        let cases = if self.quick { QUICK } else { self.cases };
        let of_surfaces = |name: &String| {
            SurfaceSuite::NAMES.iter().find(|(known, _)| known == name).map(|&(_, suite)| suite)
        };
        let surfaces: Vec<SurfaceSuite> = self.suite.iter().filter_map(of_surfaces).collect();
        if !surfaces.is_empty() {
            ensure!(
                surfaces.len() == self.suite.len() && self.out.is_none() && self.replay.is_none(),
                "the suites of edges and vertices ({}) have rows of their own: ask for them alone, without --out and --replay",
                name_list(SurfaceSuite::NAMES)
            );
            return self.surfaces(&surfaces, &contestants, cases, progress);
        }
        ensure!(
            self.scene.is_none() || self.suite.is_empty(),
            "a suite has cases of its own: leave out --scene, or ask for one of {}",
            name_list(SurfaceSuite::NAMES)
        );
        self.hard_cases(&contestants, cases, progress).map(|()| Status::Holds)
    }

    /// Rays at edges and vertices of surfaces. It does not hold if an exact test is wrong where edges are owned.
    fn surfaces(
        &self,
        suites: &[SurfaceSuite],
        contestants: &[Contestant],
        cases: u64,
        progress: &Progress,
    ) -> Result<Status> {
        let options = ExactlyOneOptions { seed: self.seed, cases, edges: self.edges };
        let mut status = Status::Holds;
        let mut scene = None;
        if let Some(name) = &self.scene {
            let loaded = open_scene(&name.world()?, progress)?;
            let triangles: Vec<_> = loaded.triangles.iter().map(|triangle| triangle.corners).collect();
            let place;
            (place, status) = surface_of(&name.to_string(), &triangles, progress)?;
            scene = Some(place);
        }
        let mut out = Stdout::new();
        for &suite in suites {
            let name = name_of(SurfaceSuite::NAMES, &suite);
            let places = scene.clone().map_or_else(|| suite.places(), |scene| vec![scene]);
            let rows = progress.during(&format!("{name}: {cases} rays"), |report| {
                exactly_one(suite, &places, contestants, options, report)
            });
            if self.json {
                rows.iter().try_for_each(|row| json_line(&mut out, row))?;
            } else {
                out.line(format_args!("{name}: {}", suite.idea()))?;
                out.line(hits_table(&rows))?;
                out.line("")?;
            }
            out.flush()?;
            let is_wrong = |row: &ExactlyOneRow| row.is_exact() && row.counts.wrong() + row.others > 0;
            let is_undecided = suite != SurfaceSuite::Silhouettes && rows.iter().any(|row| row.undecided > 0);
            if self.edges == Edges::Owned && rows.iter().any(is_wrong) {
                status = Status::Disproved;
            } else if is_undecided && status == Status::Holds {
                status = Status::Incomplete;
            }
        }
        out.finish().map(|()| status)
    }

    /// The suites of hard cases, their replay, or the rays of a scene.
    fn hard_cases(self, contestants: &[Contestant], cases: u64, progress: &Progress) -> Result<()> {
        if let Some(file) = &self.replay {
            return replay_file(file, contestants, self.edges);
        }
        if let Some(scene) = &self.scene {
            let budget =
                self.budget.context("--scene needs the error that is allowed: --budget WRONG[,ULP]")?;
            return self.needs(scene, budget, contestants, cases, progress);
        }
        let files = self.out.as_deref().map(Files::check).transpose()?;
        let extent = MeasureOptions { seed: self.seed, cases, repeats: REPEATS, edges: self.edges };
        let suites: Vec<&Suite> = SUITES.iter().filter(|suite| self.asks_for(suite)).collect();
        let mut rows = Vec::new();
        let mut out = Stdout::new();
        let owned = if self.edges == Edges::Owned { ", with owned edges" } else { "" };
        for suite in &suites {
            let suite_rows = progress.during(&format!("{}: {cases} cases", suite.name), |report| {
                measure(suite, contestants, extent, report)
            });
            if self.json {
                suite_rows.iter().try_for_each(|row| json_line(&mut out, row))?;
                out.flush()?;
            } else {
                out.line(format_args!("{}: {}{owned}", suite.name, suite.idea))?;
                out.line(rows_table(&suite_rows))?;
                out.line("")?;
                out.flush()?;
            }
            rows.extend(suite_rows);
        }
        let standings = standings(&rows);
        if !self.json {
            out.line("all suites: median time, all wrong answers")?;
            out.line(table(&standings))?;
            if suites.iter().any(|suite| suite.name == "shadow") {
                let faults = offset_faults(self.seed, cases);
                out.line("")?;
                out.line(format_args!(
                    "rule for rays from surfaces (RG-3), exactly: {} of {} hit their own surface (without the offset {}), \
                     {} pass a wall that they start beside",
                    faults.self_hits, faults.rays, faults.self_hits_without, faults.gaps
                ))?;
                out.line(offsets_table(&offset_rows(self.seed, cases.div_ceil(40))))?;
            }
        }
        if let Some(files) = files {
            files.write(&rows, &suites, self.seed, &svg(&standings))?;
        }
        out.finish()
    }

    /// The cheapest contestant that stays inside the budget on a scene's rays.
    fn needs(
        &self,
        scene: &SceneName,
        budget: Budget,
        contestants: &[Contestant],
        rays: u64,
        progress: &Progress,
    ) -> Result<()> {
        let options = WorldOptions { kernel: scene::KERNEL, edges: self.edges, ..scene.world()? };
        let world = World::open(&options, progress)?;
        let rows = progress.during(&format!("{scene}: {rays} rays"), |_| {
            let cases = scene::cases(&world, rays, self.seed)?;
            Ok::<_, StudyError>(scene::rows(&cases, contestants, self.edges, REPEATS))
        })?;
        let mut out = Stdout::new();
        if self.json {
            rows.iter().try_for_each(|row| json_line(&mut out, row))?;
            return out.finish();
        }
        out.line(format_args!(
            "{scene}: {rays} primary rays, the cheapest first: fewest bits, then least time"
        ))?;
        out.line(rows_table(&rows))?;
        let name = |row: &AccuracyRow| format!("{} {}", row.kernel, row.format);
        match rows.iter().find(|row| budget.holds(row)) {
            Some(row) => {
                let bits = row.contestant().format.bits();
                // Of those as accurate as can be, the one that costs the least.
                let exact = rows.iter().filter(|row| row.wrong() == 0);
                let exact = exact.min_by(|a, b| a.ns_per_test.total_cmp(&b.ns_per_test));
                let saving = exact.map_or_else(String::new, |exact| {
                    format!(
                        ": {bits} bits and {:.1} ns a test, where the fastest without a wrong answer, {}, \
                         takes {} bits and {:.1} ns",
                        row.ns_per_test,
                        name(exact),
                        exact.contestant().format.bits(),
                        exact.ns_per_test
                    )
                });
                out.line(format_args!("enough: {}{saving}", name(row)))?;
            }
            None => out.line("enough: none of these")?,
        }
        out.finish()
    }

    fn contestants(&self) -> Result<Vec<Contestant>> {
        let is_asked_for = |it: &Contestant| {
            (self.kernel.is_empty() || self.kernel.contains(&it.kernel))
                && (self.format.is_empty() || self.format.contains(&it.format))
        };
        let contestants: Vec<_> = Contestant::all().into_iter().filter(is_asked_for).collect();
        ensure!(!contestants.is_empty(), "the adaptive test has the format f32 alone");
        Ok(contestants)
    }

    fn asks_for(&self, suite: &Suite) -> bool {
        self.suite.is_empty() || self.suite.iter().any(|name| name == suite.name)
    }
}

/// The rule for rays from surfaces, by test, size and slope.
fn offsets_table(rows: &[OffsetRow]) -> Table {
    let numbers = ["size", "slope", "rays", "hit their own", "without the offset", "pass the wall"];
    let mut table = Table::new([Column::text("test")].into_iter().chain(numbers.map(Column::number)));
    for OffsetRow { kernel, size, slope, faults } in rows {
        let numbers = [faults.rays, faults.self_hits, faults.self_hits_without, faults.gaps];
        let kind = [(*kernel).to_owned(), format!("{size:e}"), format!("{slope}")];
        table.row(kind.into_iter().chain(numbers.map(|number| number.to_string())));
    }
    table
}

/// The suites of hard cases, and those of edges and vertices.
fn suite_names() -> Vec<&'static str> {
    let of_surfaces = SurfaceSuite::NAMES.iter().map(|(name, _)| *name);
    SUITES.iter().map(|suite| suite.name).chain(of_surfaces).collect()
}

/// Names, with commas between them.
fn name_list<T>(names: Names<T>) -> String {
    names.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// The surface of a scene, and how far its rays can be judged.
///
/// # Errors
/// If it is open everywhere.
pub(super) fn surface_of(
    name: &str,
    triangles: &[[Vec3; 3]],
    progress: &Progress,
) -> Result<(Place, Status)> {
    let place = Place::new(name, triangles);
    let Surface { edges, inner, open, .. } = &place.surface;
    let closed = edges.len() + inner.len();
    ensure!(closed > 0, "{name}: no edge and no vertex has triangles all around that are wound alike");
    if *open == 0 {
        return Ok((place, Status::Holds));
    }
    progress.warn(&format!(
        "{name}: not closed: {open} edges and vertices have a boundary, or triangles wound against one another, and are not judged; \
         the other {closed} are"
    ));
    Ok((place, Status::Incomplete))
}

/// The rows of a suite of edges and vertices.
fn hits_table(rows: &[ExactlyOneRow]) -> Table {
    let numbers = ["rays", "none", "two", "silhouettes", "wrong there", "undecided", "others", "ns a ray"]
        .map(Column::number);
    let mut table = Table::new(["kernel", "format", "edges"].map(Column::text).into_iter().chain(numbers));
    for row in rows {
        let Counts { cases, none, two, silhouette, silhouette_wrong } = row.counts;
        let numbers = [cases, none, two, silhouette, silhouette_wrong, row.undecided, row.others]
            .map(|number| number.to_string());
        let names = [row.kernel, row.format, row.edges].map(str::to_owned);
        table.row(names.into_iter().chain(numbers).chain([format!("{:.0}", row.ns_per_ray)]));
    }
    table
}

/// The rows of a suite.
fn rows_table(rows: &[AccuracyRow]) -> Table {
    let numbers =
        ["wrong hits", "misses", "triangles", "leaks", "t ulp mean", "p99.9", "max", "weights max", "ns"];
    let names = ["kernel", "format"].map(Column::text);
    let mut table = Table::new(names.into_iter().chain(numbers.map(Column::number)));
    for row in rows {
        let short = |number: f64| if number < 1e4 { format!("{number:.3}") } else { format!("{number:.2e}") };
        table.row([
            row.kernel.to_owned(),
            row.format.to_owned(),
            row.wrong_hit.to_string(),
            row.wrong_miss.to_string(),
            row.wrong_triangle.to_string(),
            row.leaks.to_string(),
            short(row.t_ulp_mean),
            short(row.t_ulp_p999),
            short(row.t_ulp_max),
            format!("{:.1e}", row.weight_error_max),
            format!("{:.1}", row.ns_per_test),
        ]);
    }
    table
}

/// The files of a folder.
struct Files {
    rows: OutFile,
    graph: OutFile,
    worst: OutFile,
}

impl Files {
    fn check(folder: &std::path::Path) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
        let file = |name: &str| OutFile::check(&folder.join(name));
        Ok(Self { rows: file("accuracy.jsonl")?, graph: file("accuracy.svg")?, worst: file("worst.jsonl")? })
    }

    fn write(&self, rows: &[AccuracyRow], suites: &[&Suite], seed: u64, graph: &str) -> Result<()> {
        self.rows.write(|out| {
            rows.iter().try_for_each(|row| Ok(writeln!(out, "{}", serde_json::to_string(row)?)?))
        })?;
        self.graph.write(|out| Ok(out.write_all(graph.as_bytes())?))?;
        self.worst.write(|out| {
            for row in rows {
                let suite = suites.iter().find(|suite| suite.name == row.suite);
                for record in suite.iter().flat_map(|suite| worst(row, suite, seed)) {
                    writeln!(out, "{}", serde_json::to_string(&record)?)?;
                }
            }
            Ok(())
        })
    }
}

/// Prints each case of a file with the exact answer and those of the contestants.
fn replay_file(file: &std::path::Path, contestants: &[Contestant], edges: Edges) -> Result<()> {
    let text =
        std::fs::read_to_string(file).with_context(|| format!("{}: cannot be read", file.display()))?;
    let records = read(&text).with_context(|| file.display().to_string())?;
    let mut out = Stdout::new();
    for record in records {
        lines(&record, contestants, edges).iter().try_for_each(|line| out.line(line))?;
    }
    out.finish()
}

/// A record, the exact answer, and that of each contestant, a line each.
fn lines(record: &Record, contestants: &[Contestant], edges: Edges) -> Vec<String> {
    let replayed = replay::replay(record, contestants, edges);
    let exact: Vec<_> = replayed.truth.0.iter().map(place).collect();
    let exact = if exact.is_empty() { "nothing".to_owned() } else { exact.join(", ") };
    let answers = replayed.answers.iter().map(|(contestant, found, fault)| {
        let said = found.as_ref().map_or("nothing".to_owned(), place);
        let fault = fault.map_or("", Fault::name);
        let name = format!("{} {}", kernel_name(contestant.kernel), contestant.format.name());
        format!("  {name:<22}{said:<34}{fault}").trim_end().to_owned()
    });
    let head = [record.shows.clone(), format!("  {:<22}{exact}", "exactly")];
    head.into_iter().chain(answers).collect()
}

/// A triangle and its distance.
fn place(found: &Found) -> String {
    format!("triangle {} at {:e}", found.triangle, found.t)
}
