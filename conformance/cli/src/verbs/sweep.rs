//! `saarcor sweep` and `saarcor merge`.

use super::simulate::OnChipArgs;
use crate::args::vary;
use crate::curve;
use crate::limits::check_together;
use crate::output::{OutFile, Stdout, check_inputs};
use crate::progress::Progress;
use crate::results::{Results, merged};
use crate::summary;
use crate::table::{Column, Table};
use anyhow::{Context, Result, anyhow, bail, ensure};
use saarcor_model::time::{ChipConfig, Programs};
use saarcor_model::vm::Bytes;
use saarcor_paper::mb;
use saarcor_studies::simulate::{record, record_before};
use saarcor_studies::summary::Summary;
use saarcor_studies::sweep::{Axis, Point, PointCosts, Position, Shard, Sweep, grid, identity};
use saarcor_studies::world::World;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// How results are shown.
#[derive(Debug, clap::Args)]
struct Shown {
    /// Results as a table of comma-separated values
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Bytes loaded and metadata as curves over the sizes of one axis
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Prints the results as lines of JSON
    #[arg(long)]
    json: bool,
}

/// A frame on many chips: one for each point of a grid
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    on_chip: OnChipArgs,
    /// Frame of the scene's path
    #[arg(long, value_name = "N")]
    frame: usize,
    /// What varies: line, ways, hash, memory, policy, pci, threads, metadata-cache, triangle-cache or
    /// variant, with its values if not the usual ones; several make a grid
    #[arg(long, value_name = "AXIS[=VALUE,..]", required = true)]
    over: Vec<Axis>,
    /// Part I of N of the points, for several machines; 'saarcor merge' joins the parts
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Results as lines of JSON; a sweep that was stopped goes on where this file ends
    #[arg(short, long, value_name = "FILE.jsonl")]
    out: Option<PathBuf>,
    #[command(flatten)]
    shown: Shown,
}

impl Args {
    /// Simulates the points that are left, and prints all results.
    pub fn run(self, progress: &Progress) -> Result<()> {
        let (on_chip, frame) = (&self.on_chip, self.frame);
        let all = grid(&self.over);
        let configs = all.iter().map(|point| self.config(point)).collect::<Result<Vec<_>>>()?;
        let shown = Files::check(&self.shown)?;
        if let (true, [axis]) = (shown.svg.is_some(), &self.over[..]) {
            curve::sizes(axis.values.iter().map(String::as_str), &axis.name)?;
        } else if shown.svg.is_some() {
            bail!("--svg: {} axes; curves are drawn over one", self.over.len());
        }
        on_chip.check_kept(frame)?;
        let world = World::open(&on_chip.scene.options(Some(frame))?, progress)?;
        shown.check_inputs(&world.files)?;
        if let Some(out) = &self.out {
            check_inputs(out, &world.files)?;
            shown.check_inputs(&[out])?;
        }
        let how = (frame, &on_chip.trace, on_chip.chip.order, on_chip.warm_up, &configs);
        let sweep = identity(&world, &on_chip.scene.scene.text(), &how);
        let position = |point| Position { sweep: sweep.clone(), point, points: all.len() };
        let mine = (0..all.len()).filter(|&point| self.shard.is_none_or(|shard| shard.has(point)));
        let mine: Vec<usize> = mine.collect();
        let expected: Vec<_> = mine.iter().map(|&point| position(point)).collect();
        let mut results = Results::open(self.out.as_deref(), &expected)?;
        if results.lines.len() < mine.len() {
            let at_a_time = rayon::current_num_threads();
            let caches = configs.iter().map(|config| config.cache);
            check_together(caches, at_a_time, Bytes(world.image.bytes.len() as u64))?;
            progress.say(summary::image_line(&Summary::of(&world)));
            progress.say(format!("{} points, {} left", mine.len(), mine.len() - results.lines.len()));
            let (options, order) = (on_chip.trace.options(), on_chip.chip.order);
            let before: Vec<Programs> = progress.during("trace of the frames before", |report| {
                let count = on_chip.warm_up.before(frame);
                record_before(&world, frame, count, &options, order, report).collect()
            });
            let recording = progress.during("trace", |_| record(&world, frame, &options, order));
            let sweep = Sweep {
                scene: &on_chip.scene.scene.text(),
                frame,
                rays: recording.picture.rays.total(),
                before: &before,
                programs: &recording.programs,
                identity: &sweep,
                points: &all,
                configs: &configs,
            };
            progress.during("points", |report| {
                results.complete(&mine, at_a_time, |points| sweep.rows(points), report)
            })?;
        }
        print(&results.lines, shown)
    }

    /// The chip of a point.
    fn config(&self, point: &Point) -> Result<ChipConfig> {
        let mut on_chip = self.on_chip.clone();
        for (axis, value) in point {
            vary(axis, value, &mut on_chip.cache, &mut on_chip.chip)
                .map_err(|right| anyhow!("--over {axis}={value}: {right}"))?;
        }
        on_chip.config().with_context(|| {
            let text: Vec<_> = point.iter().map(|(axis, value)| format!("{axis}={value}")).collect();
            text.join(" ")
        })
    }
}

/// Parts of a sweep as one
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// Results of 'saarcor sweep --shard', all parts
    #[arg(value_name = "FILE.jsonl", required = true)]
    parts: Vec<PathBuf>,
    /// All results as lines of JSON
    #[arg(short, long, value_name = "FILE.jsonl")]
    out: Option<PathBuf>,
    #[command(flatten)]
    shown: Shown,
}

impl MergeArgs {
    /// Merges, and prints all results.
    pub fn run(self) -> Result<()> {
        let read = |path: &PathBuf| {
            let name = path.display().to_string();
            let text = std::fs::read_to_string(path).with_context(|| format!("{name}: cannot be read"))?;
            Ok((name, text))
        };
        let parts = self.parts.iter().map(read).collect::<Result<Vec<_>>>()?;
        let lines = merged(&parts)?;
        let shown = Files::check(&self.shown)?;
        shown.check_inputs(&self.parts)?;
        if let Some(out) = self.out.as_deref().map(OutFile::check).transpose()? {
            out.check_inputs(&self.parts)?;
            shown.check_inputs(&[out.path()])?;
            out.write(|file| Ok(lines.iter().try_for_each(|line| writeln!(file, "{line}"))?))?;
        }
        print(&lines, shown)
    }
}

/// Where results go that can be written there.
struct Files {
    csv: Option<OutFile>,
    svg: Option<OutFile>,
    json: bool,
}

impl Files {
    fn check(shown: &Shown) -> Result<Self> {
        let file = |path: &Option<PathBuf>, ending| {
            path.as_deref().map(|path| OutFile::check(path)?.with_ending(&[ending])).transpose()
        };
        let (csv, svg) = (file(&shown.csv, "csv")?, file(&shown.svg, "svg")?);
        if let (Some(csv), Some(svg)) = (&csv, &svg) {
            ensure!(csv.path() != svg.path(), "--csv, --svg: both name {}", csv.path().display());
        }
        Ok(Self { csv, svg, json: shown.json })
    }

    /// Checks that none of them is one of `inputs`.
    fn check_inputs<P: AsRef<Path> + Clone>(&self, inputs: &[P]) -> Result<()> {
        self.csv.iter().chain(&self.svg).try_for_each(|file| file.check_inputs(inputs))
    }
}

/// Numbers of a result that are shown, by their names in JSON.
const NUMBERS: [&str; 8] = [
    "cycles",
    "fps",
    "pci_bytes",
    "mem_bytes",
    "mem_bytes_metadata",
    "metadata_bytes",
    "l2_accesses",
    "l2_hits",
];

/// A cost of a result.
type Cost<'a> = &'a dyn Fn(&Value) -> u128;

fn print(lines: &[String], Files { csv, svg, json }: Files) -> Result<()> {
    let rows = lines.iter().map(|line| serde_json::from_str(line).context("result"));
    let rows = rows.collect::<Result<Vec<Value>>>()?;
    let axes: Vec<&String> = rows
        .first()
        .and_then(|row| row["at"].as_object())
        .into_iter()
        .flatten()
        .map(|(name, _)| name)
        .collect();
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    if let Some(csv) = csv {
        csv.write(|file| {
            let header: Vec<_> = axes.iter().map(|axis| axis.as_str()).chain(NUMBERS).collect();
            writeln!(file, "{}", header.join(","))?;
            for row in &rows {
                let at = axes.iter().map(|axis| text(&row["at"][axis.as_str()]));
                let cells: Vec<_> = at.chain(NUMBERS.map(|number| text(&row[number]))).collect();
                writeln!(file, "{}", cells.join(","))?;
            }
            Ok(())
        })?;
    }
    let number = |row: &Value, name: &str| row[name].as_u64().unwrap_or(0);
    let one = |field: &'static str| move |row: &Value| u128::from(number(row, field));
    let both = |row: &Value| one("pci_bytes")(row) * one("metadata_bytes")(row);
    if let Some(svg) = svg {
        let [axis] = axes[..] else { bail!("--svg: {} axes; curves are drawn over one", axes.len()) };
        let sizes = curve::sizes(rows.iter().filter_map(|row| row["at"][axis.as_str()].as_str()), axis)?;
        let at = |(size, row)| PointCosts {
            size,
            loaded: number(row, "pci_bytes"),
            metadata: number(row, "metadata_bytes"),
        };
        let costs: Vec<_> = sizes.into_iter().zip(&rows).map(at).collect();
        let frame = rows.first().map(|row| format!("{}, frame {}", text(&row["scene"]), row["frame"]));
        let drawing = curve::svg(axis, &frame.unwrap_or_default(), &costs)?;
        svg.write(|file| Ok(file.write_all(drawing.as_bytes())?))?;
    }
    let mut out = Stdout::new();
    if json {
        lines.iter().try_for_each(|line| out.line(line))?;
        return out.finish();
    }
    let numbers = ["fps", "loaded MB", "Mem MB", "metadata KiB", "misses %"].map(Column::number);
    let mut table = Table::new(axes.iter().map(|axis| Column::text(axis.as_str())).chain(numbers));
    for row in &rows {
        let at = axes.iter().map(|axis| text(&row["at"][axis.as_str()]));
        let misses = number(row, "l2_accesses") - number(row, "l2_hits");
        let cells = [
            format!("{:.1}", row["fps"].as_f64().unwrap_or(0.0)),
            mb(number(row, "pci_bytes")),
            mb(number(row, "mem_bytes")),
            format!("{:.1}", number(row, "metadata_bytes") as f64 / 1024.0),
            format!("{:.2}", 100.0 * misses as f64 / number(row, "l2_accesses").max(1) as f64),
        ];
        table.row(at.chain(cells));
    }
    out.line(table.to_string().trim_end())?;
    let costs: [(&str, Cost<'_>); 4] = [
        ("most frames a second", &one("cycles")),
        ("fewest bytes loaded", &one("pci_bytes")),
        ("least metadata", &one("metadata_bytes")),
        ("best of both, the least product of bytes loaded and metadata", &both),
    ];
    for (name, cost) in costs {
        // Of equals the first.
        if let Some(row) = rows.iter().min_by_key(|row| cost(row)) {
            let at: Vec<_> =
                axes.iter().map(|axis| format!("{axis} {}", text(&row["at"][axis.as_str()]))).collect();
            out.line(format!("{name}: {}", at.join(", ")))?;
        }
    }
    out.finish()
}
