//! `saarcor simulate`.

use super::auto::AutoArgs;
use super::frames::FramesArgs;
use crate::args::{CacheArgs, ChipArgs, SceneArgs, TraceArgs, describe};
use crate::limits::check_state;
use crate::output::{OutFile, Stdout, json_line, write_png};
use crate::progress::Progress;
use crate::status::Status;
use crate::summary;
use crate::table::{Column, Table};
use anyhow::{Result, ensure};
use clap::ArgGroup;
use saarcor_fast::chip::{Caches, ChipObserver, simulate_from};
use saarcor_model::time::{ChipConfig, TimingReport, UNIT_NAMES, Version};
use saarcor_model::vm::Bytes;
use saarcor_oracles::card::CardShadow;
use saarcor_oracles::memory_protocol::HEADER;
use saarcor_paper::mb;
use saarcor_studies::simulate::{Recording, TimingRow, WarmUp, Watch, command_line, record, record_before};
use saarcor_studies::summary::Summary;
use saarcor_studies::world::World;
use serde::Serialize;
use std::io::Write as _;
use std::path::PathBuf;

/// Frames whose programs are kept in memory together: so many, that it stays bounded.
const MOST_KEPT: usize = 16;

/// A scene, and the chip that its frames are simulated on.
#[derive(Clone, Debug, clap::Args)]
pub struct OnChipArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub chip: ChipArgs,
    #[command(flatten)]
    pub trace: TraceArgs,
    #[command(flatten)]
    pub cache: CacheArgs,
    /// A frame begins with what the N frames before left in the caches, or with "walk" all frames before
    #[arg(long, value_name = "N|walk", default_value_t = WarmUp::ONE)]
    pub warm_up: WarmUp,
}

impl OnChipArgs {
    /// The chip.
    ///
    /// # Errors
    /// If the numbers make none.
    pub fn config(&self) -> Result<ChipConfig> {
        let cache = self.cache.config(&self.scene.scene.text())?;
        let config = self.chip.config(&self.scene.scene.text(), cache)?;
        config.check()?;
        Ok(config)
    }

    /// Refuses more frames before than are kept in memory together, where they are needed more than once.
    ///
    /// # Errors
    /// If there are more.
    pub fn check_kept(&self, frame: usize) -> Result<()> {
        let kept = self.warm_up.before(frame);
        ensure!(
            kept <= MOST_KEPT,
            "--warm-up: {kept} frames before are kept in memory here; at most {MOST_KEPT}"
        );
        Ok(())
    }

    /// Traces the frame, and plays it on a chip whose caches the frames before have warmed, one after the other.
    fn play(
        &self,
        frame: usize,
        world: &World,
        config: &ChipConfig,
        observer: &mut impl ChipObserver,
        progress: &Progress,
    ) -> Result<(Recording, TimingReport)> {
        let (options, order) = (self.trace.options(), self.chip.order);
        let empty = Caches::empty(world.image.registers.triangles, config)?;
        let caches = progress.during("trace of the frames before", |report| {
            let before = record_before(world, frame, self.warm_up.before(frame), &options, order, report);
            before.fold(empty, |caches, picture| caches.then_observed(&picture, observer))
        });
        let recording = progress.during("trace", |_| record(world, frame, &options, order));
        let report = progress.during("chip", |_| simulate_from(caches, &recording.programs, observer));
        Ok((recording, report))
    }
}

/// Step two of the paper's §4: frames on the whole chip, cycle by cycle
#[derive(Debug, clap::Args)]
#[command(group(ArgGroup::new("which").required(true).args(["frame", "frames"])))]
pub struct Args {
    #[command(flatten)]
    on_chip: OnChipArgs,
    #[command(flatten)]
    auto: AutoArgs,
    /// Frame of the scene's path
    #[arg(long, value_name = "N")]
    frame: Option<usize>,
    #[command(flatten)]
    walk: FramesArgs,
    /// The picture, a PNG file; of --frames the rows as lines of JSON, by which a run that was stopped goes on
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Compares each part of a line that the chip reads from the card with the bytes of the host
    ///
    /// The run carries a shadow of the card's contents. It says how many parts were compared; the
    /// first that differs is named on standard error, and the exit status is 1.
    #[arg(long, conflicts_with = "frames")]
    check_bytes: bool,
    /// Writes each command of the memory chips, a CSV file
    ///
    /// Columns: clock,command,bank,row,column,beats. Clocks are those of the memory, and increase; commands are
    /// ACT, RD, WR, PRE and REF; the bank is `all` where all are meant; what a command does not have is empty.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "frames")]
    sdram_commands: Option<PathBuf>,
    /// Prints one JSON object a frame
    #[arg(long)]
    json: bool,
}

/// A row, and what a comparison with the host's bytes found.
#[derive(Debug, Serialize)]
struct CheckedRow<'a> {
    #[serde(flatten)]
    row: &'a TimingRow,
    /// Parts that were compared with the bytes of the host.
    parts_checked: u64,
    /// Parts that differ.
    parts_wrong: u64,
}

impl Args {
    /// Simulates, and prints what the frame took.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        let config = self.on_chip.config()?;
        let Some(frame) = self.frame else {
            let out = self.out.as_deref();
            return self.walk.run(&self.on_chip, &self.auto, &config, out, self.json, progress);
        };
        let file = self.out.as_deref().map(|path| OutFile::check(path)?.with_ending(&["png"])).transpose()?;
        let commands = self.sdram_commands.as_deref();
        let commands = commands.map(|path| OutFile::check(path)?.with_ending(&["csv"])).transpose()?;
        let world = self.auto.open(&self.on_chip.scene, Some(frame), progress)?;
        file.iter().chain(&commands).try_for_each(|file| file.check_inputs(&world.files))?;
        check_state(config.cache, Bytes(world.image.bytes.len() as u64))?;
        say_what(&world, &config, progress);
        let mut out = Stdout::new();
        let mut shadow = self.check_bytes.then(|| CardShadow::new(&world.image.bytes, &config));
        let (recording, report) = match (&mut shadow, commands) {
            (None, None) => self.on_chip.play(frame, &world, &config, &mut (), progress)?,
            (shadow, commands) => {
                let play =
                    |watch: &mut Watch<'_, '_>| self.on_chip.play(frame, &world, &config, watch, progress);
                watched(play, shadow.as_mut(), commands)?
            }
        };
        if let Some(file) = file {
            file.write(|out| write_png(&recording.picture.pixels, out))?;
        }
        let scene = self.on_chip.scene.scene.text();
        let row = TimingRow::new(&scene, frame, recording.picture.rays.total(), &config, &report);
        match (&shadow, self.json) {
            (None, true) => json_line(&mut out, &row)?,
            (Some(CardShadow { parts, wrong, .. }), true) => {
                let row = CheckedRow { row: &row, parts_checked: *parts, parts_wrong: *wrong };
                json_line(&mut out, &row)?;
            }
            (_, false) => {
                for part in text(&row) {
                    out.line(part)?;
                }
                if let Some(CardShadow { parts, wrong, .. }) = &shadow {
                    out.line(format_args!(
                        "{parts} parts compared with the bytes of the host, {wrong} differ"
                    ))?;
                }
            }
        }
        out.finish()?;
        let Some(difference) = shadow.and_then(|shadow| shadow.first) else { return Ok(Status::Holds) };
        // Where standard error is closed, the status has to do.
        let _ = writeln!(std::io::stderr(), "saarcor: not the bytes of the host: {difference}");
        Ok(Status::Disproved)
    }
}

/// Says what is simulated.
pub fn say_what(world: &World, config: &ChipConfig, progress: &Progress) {
    let scene = Summary::of(world);
    let lines = summary::lines(&scene).into_iter().chain([summary::image_line(&scene)]);
    lines.for_each(|line| progress.say(line));
    if config.version != Version::None {
        progress.say(describe(&config.cache));
    }
}

/// A run that keeps a shadow of the card, and writes the commands of the memory chips to a file.
fn watched<T>(
    play: impl FnOnce(&mut Watch<'_, '_>) -> Result<T>,
    shadow: Option<&mut CardShadow<'_>>,
    file: Option<OutFile>,
) -> Result<T> {
    let Some(file) = file else { return play(&mut Watch { shadow, commands: None }) };
    file.write(|out| {
        let mut written = writeln!(out, "{HEADER}");
        let mut write = |clock, command| {
            if written.is_ok() {
                written = writeln!(out, "{}", command_line(clock, command));
            }
        };
        let played = play(&mut Watch { shadow, commands: Some(&mut write) })?;
        written?;
        Ok(played)
    })
}

fn percent(part: u64, whole: u64) -> String {
    format!("{:.1}", 100.0 * part as f64 / whole.max(1) as f64)
}

/// A run for a person to read.
fn text(row: &TimingRow) -> Vec<String> {
    let mut units = Table::new(
        ["unit"].map(Column::text).into_iter().chain(
            [
                "busy %",
                "stalled %",
                "idle %",
                "look-up %",
                "port %",
                "MSHR %",
                "memory %",
                "host %",
                "rays a packet",
            ]
            .map(Column::number),
        ),
    );
    let mut caches = Table::new(
        ["cache"]
            .map(Column::text)
            .into_iter()
            .chain(["accesses", "hits", "hit rate %", "in flight", "misses"].map(Column::number)),
    );
    let mut cache = |name: &str, accesses: u64, hits: u64, merged: u64| {
        let misses = accesses - hits - merged;
        let numbers = [accesses.to_string(), hits.to_string(), percent(hits, accesses), merged.to_string()];
        caches.row([name.to_owned()].into_iter().chain(numbers).chain([misses.to_string()]));
    };
    for name in UNIT_NAMES {
        let (unit, l1) = (&row.units[name], row.l1[name]);
        let all = unit.busy + unit.stalled + unit.idle;
        let stalls = ["look_up", "port", "mshr", "memory", "host"].map(|stall| unit.stalls[stall]);
        let parts = [unit.busy, unit.stalled, unit.idle].into_iter().chain(stalls);
        let rays = format!("{:.1}", unit.rays as f64 / unit.operations.max(1) as f64);
        units.row([name.to_owned()].into_iter().chain(parts.map(|part| percent(part, all))).chain([rays]));
        cache(name, l1.accesses, l1.hits, l1.merged);
    }
    if row.variant != "none" {
        cache("virtual memory", row.l2_accesses, row.l2_hits - row.l2_merged, row.l2_merged);
    }
    vec![
        format!(
            "{}, frame {}, version {}: {} cycles, {:.1} frames a second",
            row.scene, row.frame, row.variant, row.cycles, row.fps
        ),
        format!("{} rays: {:.1} core cycles a ray and pipeline", row.rays, row.cycles_a_ray),
        format!("PCI: {} MB, {:.1} % of the time", mb(row.pci_bytes), 100.0 * row.pci_use),
        format!(
            "Mem: {} MB, {:.1} % of the peak (L1 fills {}, lines from the host {}, metadata read {}, written back {})",
            mb(row.mem_bytes),
            100.0 * row.mem_use,
            mb(row.mem_bytes_l1_fill),
            mb(row.mem_bytes_vm_fill),
            mb(row.mem_bytes_metadata_read),
            mb(row.mem_bytes_metadata_write_back)
        ),
        units.to_string(),
        caches.to_string(),
    ]
}
