//! Table 2 (§4): hot spots on the chip without virtual memory, with version A and with version B,
//! ours beside the paper's.

use crate::alternatives::{self, Plan, Start};
use crate::tables::{self, Table2Row, in_mb};
use rayon::prelude::*;
use saarcor_fast::chip::{Caches, simulate_part};
use saarcor_model::time::{ChipConfig, Programs, Version};
use saarcor_model::vm::Hash;
use saarcor_studies::StudyError;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::simulate::{TimingRow, record, record_before};
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, TraceOptions};
use saarcor_studies::traffic::{TrafficRow, TrafficWatch};
use saarcor_studies::world::World;
use serde::Serialize;
use std::collections::BTreeMap;

/// Frames before a hot spot that warm the caches.
pub(crate) const WARM_UP: usize = 1;

/// A frame on the chip in all versions.
#[derive(Clone, Debug, Serialize)]
pub struct HotSpot {
    /// Our scene.
    pub scene: String,
    /// Whether it is one of the real scenes.
    pub real: bool,
    /// Number of the frame in our path.
    pub frame: usize,
    /// The paper's row; none for a scene of the user's.
    pub paper: Option<Table2Row>,
    /// Without virtual memory.
    pub no_vm: TimingRow,
    /// With metadata on the chip.
    pub version_a: TimingRow,
    /// With metadata in the on-board memory.
    pub version_b: TimingRow,
    /// Where the bytes of these three go, by version: none, a, b.
    pub traffic: BTreeMap<&'static str, TrafficRow>,
    /// The frame on chips that differ from these three in one respect.
    pub alternatives: Vec<Alternative>,
}

/// A hot spot on a chip that differs from the standard one in one respect.
#[derive(Clone, Debug, Serialize)]
pub struct Alternative {
    /// In which respect.
    pub setting: String,
    /// Size of a line.
    pub line_bytes: u64,
    /// Lines a set.
    pub ways: u32,
    /// Whether the upper bits of an address are added to the lower ones.
    pub hashed: bool,
    /// Metadata of all lines.
    pub metadata_bytes: u64,
    /// Its time and traffic.
    pub run: TimingRow,
}

impl HotSpot {
    /// The run with `setting` in this version, if there is one.
    #[must_use]
    pub fn with(&self, setting: &str, version: Version) -> Option<&TimingRow> {
        let variant = saarcor_studies::names::version_name(version);
        let of = |one: &&Alternative| one.setting == setting && one.run.variant == variant;
        self.alternatives.iter().find(of).map(|one| &one.run)
    }

    /// Its family among the paper's scenes; a scene of the user's is one by itself.
    #[must_use]
    pub fn family(&self) -> &str {
        standard::family(self.paper.as_ref().map_or(&self.scene, |paper| &paper.scene))
    }

    /// How it is called: our scene and frame.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.scene, self.frame)
    }
}

/// What differs from the standard chip in all runs.
pub type Setting<'a> = &'a (dyn Fn(ChipConfig) -> ChipConfig + Sync);

/// The standard chip.
pub const STANDARD: Setting<'static> = &|config| config;

/// Which of our scenes stands in a row of the paper.
#[derive(Clone, Copy, Debug)]
pub struct StandIn<'a> {
    /// Our scene, as it is printed.
    pub scene: &'a str,
    /// Whether it is one of the real scenes.
    pub real: bool,
    /// The paper's scene in whose place it stands; none for a scene of the user's.
    pub of: Option<&'a str>,
}

impl StandIn<'_> {
    /// The rows of Table 2 in which it stands; of a scene of the user's any number, which the paper does not have.
    fn rows(self) -> Box<dyn Iterator<Item = Option<&'static Table2Row>>> {
        let Some(of) = self.of else { return Box::new(std::iter::repeat(None)) };
        let rows: Vec<_> = rows_of(of).map(Some).collect();
        Box::new(rows.into_iter())
    }
}

/// The rows of Table 2 that stand for a scene of the paper.
pub fn rows_of(scene: &str) -> impl Iterator<Item = &'static Table2Row> {
    tables::table2().iter().filter(move |row| row.scene == scene)
}

/// Simulates the rows of Table 2 in which a scene stands, and the alternatives that tell what a figure hangs on.
/// `frames` are those of our path, one for a row, in the order of the rows; rows for which there is none are left out.
/// All chips have the `setting`.
///
/// # Errors
/// If the standard sizes make no chip.
pub fn hot_spots(
    stand: StandIn<'_>,
    world: &World,
    frames: &[usize],
    setting: Setting<'_>,
    trace: &TraceOptions,
    monitor: &dyn Monitor,
) -> Result<Vec<HotSpot>, StudyError> {
    let rows = stand.rows().zip(frames).enumerate();
    rows.map(|(place, (paper, &frame))| {
        let spot = Spot { stand, world, place, frame, setting, trace, monitor };
        spot.simulate(paper)
    })
    .collect()
}

/// A frame that is to be simulated.
struct Spot<'a> {
    stand: StandIn<'a>,
    world: &'a World,
    /// Its place among the frames of the scene.
    place: usize,
    frame: usize,
    setting: Setting<'a>,
    trace: &'a TraceOptions,
    monitor: &'a dyn Monitor,
}

impl Spot<'_> {
    fn simulate(&self, paper: Option<&Table2Row>) -> Result<HotSpot, StudyError> {
        let Self { stand, world, place, frame, trace, monitor, .. } = *self;
        let what = match paper {
            Some(paper) => format!("{} for {}, {}", stand.scene, paper.scene, paper.frame),
            None => format!("{} {frame}", stand.scene),
        };
        let plans = alternatives::of(stand.of, place);
        let history = plans.iter().map(|plan| plan.start.frames()).max().unwrap_or(0).max(WARM_UP);
        let (before, recording) = monitor.during(&format!("{what}: trace"), |_| {
            let before = record_before(world, frame, history, trace, PacketOrder::default(), &|_| ());
            (before, record(world, frame, trace, PacketOrder::default()))
        });
        let run = Run {
            spot: self,
            before: &before,
            programs: &recording.programs,
            rays: recording.picture.rays.total(),
        };
        let planned: Vec<(&Plan, Version)> =
            plans.iter().flat_map(|plan| plan.versions.iter().map(move |version| (plan, *version))).collect();
        let versions = [Version::None, Version::A, Version::B];
        let (standard, alternatives) = monitor.during(&format!("{what}: chip"), |_| {
            rayon::join(
                || versions.par_iter().map(|version| run.standard(*version)).collect::<Result<Vec<_>, _>>(),
                || planned.par_iter().filter_map(|(plan, version)| run.alternative(plan, *version)).collect(),
            )
        });
        let mut standard = standard?.into_iter();
        let [Some(none), Some(a), Some(b)] = std::array::from_fn(|_| standard.next()) else {
            unreachable!("a run a version")
        };
        let traffic = [&none, &a, &b].map(|(row, traffic)| (row.variant, traffic.clone()));
        Ok(HotSpot {
            scene: stand.scene.to_owned(),
            real: stand.real,
            frame,
            paper: paper.cloned(),
            no_vm: none.0,
            version_a: a.0,
            version_b: b.0,
            traffic: traffic.into_iter().collect(),
            alternatives,
        })
    }
}

/// A traced frame, and the frames before it.
struct Run<'a> {
    spot: &'a Spot<'a>,
    before: &'a [Programs],
    programs: &'a Programs,
    rays: u64,
}

impl Run<'_> {
    fn chip(&self, version: Version) -> Result<ChipConfig, StudyError> {
        let Spot { stand, setting, .. } = self.spot;
        Ok(setting(standard::chip(stand.of.unwrap_or_default(), version)?))
    }

    /// The caches of a chip when the frame begins.
    fn caches(&self, config: &ChipConfig, start: Start) -> Result<Caches, StudyError> {
        let before = &self.before[self.before.len().saturating_sub(start.frames())..];
        let caches = Caches::after(before, self.programs.triangles, config)?;
        Ok(if start == Start::ColdFirstLevel { caches.with_cold_first_level() } else { caches })
    }

    fn standard(&self, version: Version) -> Result<(TimingRow, TrafficRow), StudyError> {
        let config = self.chip(version)?;
        let mut watch = TrafficWatch::new(&self.spot.world.image, &config);
        let all = vec![true; self.programs.packets.len()];
        let report = simulate_part(self.caches(&config, Start::Warm)?, self.programs, &all, &mut watch);
        let Spot { stand, frame, .. } = self.spot;
        Ok((TimingRow::new(stand.scene, *frame, self.rays, &config, &report), watch.row(&report)))
    }

    /// The frame on another chip; none where the numbers make no chip.
    fn alternative(&self, plan: &Plan, version: Version) -> Option<Alternative> {
        let config = (plan.change)(self.chip(version).ok()?)?;
        self.played(&plan.setting, &config, plan.start).ok()
    }

    fn played(&self, setting: &str, config: &ChipConfig, start: Start) -> Result<Alternative, StudyError> {
        let all = vec![true; self.programs.packets.len()];
        let report = simulate_part(self.caches(config, start)?, self.programs, &all, &mut ());
        let Spot { stand, frame, .. } = self.spot;
        let geometry = config.cache.geometry;
        Ok(Alternative {
            setting: setting.to_owned(),
            line_bytes: geometry.line().0,
            ways: geometry.ways(),
            hashed: config.cache.hash != Hash::Low,
            metadata_bytes: geometry.metadata().0,
            run: TimingRow::new(stand.scene, *frame, self.rays, config, &report),
        })
    }
}

/// A frame without virtual memory on the standard chip, of a world whose kd-tree is another, as the alternative `setting`.
///
/// # Errors
/// If the standard sizes make no chip.
pub(crate) fn with_other_tree(
    stand: StandIn<'_>,
    world: &World,
    frame: usize,
    setting: &str,
    trace: &TraceOptions,
    monitor: &dyn Monitor,
) -> Result<Alternative, StudyError> {
    let spot = Spot { stand, world, place: 0, frame, setting: STANDARD, trace, monitor };
    monitor.during(&format!("{}: {setting}", stand.scene), |_| {
        let before = record_before(world, frame, WARM_UP, trace, PacketOrder::default(), &|_| ());
        let recording = record(world, frame, trace, PacketOrder::default());
        let rays = recording.picture.rays.total();
        let run = Run { spot: &spot, before: &before, programs: &recording.programs, rays };
        run.played(setting, &run.chip(Version::None)?, Start::Warm)
    })
}

/// The four relations within a row that matter more than its digits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shape {
    /// fps(A) / fps(no VM).
    pub speed_a: f64,
    /// fps(B) / fps(no VM).
    pub speed_b: f64,
    /// Mem(B) / Mem(A).
    pub memory_b: f64,
    /// (Mem(A) − Mem(no VM)) / PCI(A): bytes that reach the on-board memory for each byte loaded.
    pub filled: f64,
}

impl Shape {
    /// From frames a second, bytes moved to and from the on-board memory without virtual memory, in version A and in
    /// B, and bytes loaded in version A. Bytes are in any unit.
    #[must_use]
    pub fn new(fps: [f64; 3], [no_vm, a, b]: [f64; 3], pci: f64) -> Self {
        Self {
            speed_a: fps[1] / fps[0],
            speed_b: fps[2] / fps[0],
            memory_b: b / a,
            filled: (a - no_vm) / pci,
        }
    }

    /// Of the paper's row.
    #[must_use]
    pub fn printed(row: &Table2Row) -> Self {
        let Table2Row { no_vm, version_a: a, version_b: b, .. } = row;
        Self::new([no_vm.fps, a.fps, b.fps], [no_vm.mem_mb, a.mem_mb, b.mem_mb], a.pci_mb)
    }

    /// Of ours.
    #[must_use]
    pub fn ours(spot: &HotSpot) -> Self {
        let HotSpot { no_vm, version_a: a, version_b: b, .. } = spot;
        let mem = [no_vm, a, b].map(|run| in_mb(run.mem_bytes));
        Self::new([no_vm.fps, a.fps, b.fps], mem, in_mb(a.pci_bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relations_of_the_paper_are_those_of_its_digits() {
        let row = tables::table2().iter().find(|row| row.scene == "Conference").expect("a row");
        let shape = Shape::printed(row);
        assert!((shape.speed_a - 31.6 / 33.0).abs() < 1e-12 && (shape.speed_b - 29.7 / 33.0).abs() < 1e-12);
        assert!((shape.memory_b - 25.2 / 19.1).abs() < 1e-12 && (shape.filled - 1.0 / 0.78).abs() < 1e-9);
    }
}
