//! Table 2 (§4): hot spots on the chip without virtual memory, with version A and with version B,
//! ours beside the paper's.

use crate::alternatives::{self, Plan, Start};
use crate::tables::{self, Table2Row, in_mb};
use rayon::prelude::*;
use saarcor_fast::chip::{Caches, simulate_from};
use saarcor_model::time::{ChipConfig, Version};
use saarcor_model::vm::{CacheConfig, Hash};
use saarcor_studies::StudyError;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::simulate::{Recording, TimingRow, WarmUp, record, record_before};
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, TraceOptions};
use saarcor_studies::traffic::{TrafficRow, TrafficWatch};
use saarcor_studies::world::World;
use serde::Serialize;
use std::collections::BTreeMap;

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

    /// The row of a chip with `setting` in the place of the standard one. Versions that were not run with it do not know
    /// what it changes, and stay as they are.
    #[must_use]
    pub fn standing_on(&self, setting: &str) -> Self {
        let row = |standard: &TimingRow, version| self.with(setting, version).unwrap_or(standard).clone();
        Self {
            no_vm: row(&self.no_vm, Version::None),
            version_a: row(&self.version_a, Version::A),
            version_b: row(&self.version_b, Version::B),
            ..self.clone()
        }
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

/// How frames are simulated.
#[derive(Clone, Copy)]
pub struct How<'a> {
    /// What all chips have in place of the standard.
    pub setting: Setting<'a>,
    /// Frames before that warm the caches.
    pub warm_up: WarmUp,
    /// How they are traced.
    pub trace: &'a TraceOptions,
}

/// Simulates the rows of Table 2 in which a scene stands, and the alternatives that tell what a figure hangs on.
/// `frames` are those of our path, one for a row, in the order of the rows; rows for which there is none are left out.
///
/// # Errors
/// If the standard sizes make no chip.
pub fn hot_spots(
    stand: StandIn<'_>,
    world: &World,
    frames: &[usize],
    how: &How<'_>,
    monitor: &dyn Monitor,
) -> Result<Vec<HotSpot>, StudyError> {
    let rows = stand.rows().zip(frames).enumerate();
    rows.map(|(place, (paper, &frame))| Spot { stand, world, place, frame, how, monitor }.simulate(paper))
        .collect()
}

/// A frame that is to be simulated.
struct Spot<'a> {
    stand: StandIn<'a>,
    world: &'a World,
    /// Its place among the frames of the scene.
    place: usize,
    frame: usize,
    how: &'a How<'a>,
    monitor: &'a dyn Monitor,
}

/// A chip on which the frame is simulated: a standard one, or that of a plan.
struct Planned<'a> {
    plan: Option<&'a Plan>,
    config: ChipConfig,
    start: Start,
}

/// A run of the frame.
struct Played {
    config: ChipConfig,
    row: TimingRow,
    /// Of a standard chip, where the bytes go.
    traffic: Option<TrafficRow>,
}

impl Spot<'_> {
    fn simulate(&self, paper: Option<&Table2Row>) -> Result<HotSpot, StudyError> {
        let Self { stand, place, frame, .. } = *self;
        let what = match paper {
            Some(paper) => format!("{} for {}, {}", stand.scene, paper.scene, paper.frame),
            None => format!("{} {frame}", stand.scene),
        };
        let plans = alternatives::of(stand.of, place);
        let standard = [Version::None, Version::A, Version::B].map(|version| self.chip(version));
        let standard = standard.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter();
        let standard = standard.map(|config| Planned { plan: None, config, start: Start::Warm });
        let of_plan = |plan| self.planned(plan);
        let chips: Vec<Planned<'_>> = standard.chain(plans.iter().flat_map(of_plan)).collect();
        let mut played = self.play(&what, &chips)?.into_iter();
        let [Some(none), Some(a), Some(b)] = std::array::from_fn(|_| played.next()) else {
            unreachable!("a run a version")
        };
        let settings = chips.iter().filter_map(|chip| chip.plan);
        let traffic = [&none, &a, &b].map(|run| (run.row.variant, run.traffic.clone()));
        Ok(HotSpot {
            scene: stand.scene.to_owned(),
            real: stand.real,
            frame,
            paper: paper.cloned(),
            alternatives: settings
                .zip(played)
                .map(|(plan, played)| played.alternative(&plan.setting))
                .collect(),
            no_vm: none.row,
            version_a: a.row,
            version_b: b.row,
            traffic: traffic.into_iter().filter_map(|(version, row)| Some((version, row?))).collect(),
        })
    }

    fn chip(&self, version: Version) -> Result<ChipConfig, StudyError> {
        let Self { stand, how, .. } = self;
        Ok((how.setting)(standard::chip(stand.of.unwrap_or_default(), version)?))
    }

    /// The chips of a plan; those that the numbers make none are left out.
    fn planned<'a>(&self, plan: &'a Plan) -> impl Iterator<Item = Planned<'a>> {
        let chips = plan.versions.iter().filter_map(|version| (plan.change)(self.chip(*version).ok()?));
        let start = plan.start;
        chips.map(move |config| Planned { plan: Some(plan), config, start }).collect::<Vec<_>>().into_iter()
    }

    /// The frame on each of the chips.
    fn play(&self, what: &str, chips: &[Planned<'_>]) -> Result<Vec<Played>, StudyError> {
        let Self { world, frame, how, monitor, .. } = *self;
        let order = PacketOrder::default();
        let begun: Vec<Begun> = chips.iter().map(|chip| (chip.config, chip.start)).collect();
        let (caches, recording) = monitor.during(&format!("{what}: trace"), |report| {
            let caches = caches_before(world, frame, &begun, how.warm_up, how.trace, order, report)?;
            Ok::<_, StudyError>((caches, record(world, frame, how.trace, order)))
        })?;
        Ok(monitor.during(&format!("{what}: chip"), |_| {
            let each = caches.into_par_iter().zip(chips);
            each.map(|(caches, chip)| self.played(caches, chip, &recording)).collect()
        }))
    }

    fn played(&self, caches: Caches, chip: &Planned<'_>, recording: &Recording) -> Played {
        let Planned { plan, config, .. } = *chip;
        let programs = &recording.programs;
        let (report, traffic) = match plan {
            None => {
                let mut watch = TrafficWatch::new(&self.world.image, &config);
                let report = simulate_from(caches, programs, &mut watch);
                let traffic = watch.row(&report);
                (report, Some(traffic))
            }
            Some(_) => (simulate_from(caches, programs, &mut ()), None),
        };
        let rays = recording.picture.rays.total();
        Played { config, row: TimingRow::new(self.stand.scene, self.frame, rays, &config, &report), traffic }
    }
}

/// A chip, and in what state its caches begin.
pub(crate) type Begun = (ChipConfig, Start);

/// The caches of chips when a frame begins. The frames before it are traced one by one, and warm the caches of all chips.
///
/// # Errors
/// If the configuration of one makes no chip.
pub(crate) fn caches_before(
    world: &World,
    frame: usize,
    chips: &[Begun],
    usual: WarmUp,
    trace: &TraceOptions,
    order: PacketOrder,
    report: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Caches>, StudyError> {
    let frames = |start: Start| start.warm_up(usual).before(frame);
    let history = chips.iter().map(|(_, start)| frames(*start)).max().unwrap_or(0);
    let triangles = world.image.registers.triangles;
    let empty = chips.iter().map(|(config, _)| Caches::empty(triangles, config));
    let mut all: Vec<Caches> = empty.collect::<Result<_, _>>()?;
    for (ago, picture) in (1..=history).rev().zip(record_before(world, frame, history, trace, order, report))
    {
        let each = all.into_par_iter().zip(chips);
        let warmed = each
            .map(|(caches, (_, start))| if ago <= frames(*start) { caches.then(&picture) } else { caches });
        all = warmed.collect();
    }
    let begin = |(caches, (_, start)): (Caches, &Begun)| match start {
        Start::ColdFirstLevel => caches.with_cold_first_level(),
        Start::Warm | Start::Empty | Start::TenFrames => caches,
    };
    Ok(all.into_iter().zip(chips).map(begin).collect())
}

impl Played {
    fn alternative(self, setting: &str) -> Alternative {
        let CacheConfig { geometry, hash, .. } = self.config.cache;
        Alternative {
            setting: setting.to_owned(),
            line_bytes: geometry.line().0,
            ways: geometry.ways(),
            hashed: hash != Hash::Low,
            metadata_bytes: geometry.metadata().0,
            run: self.row,
        }
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
    how: &How<'_>,
    monitor: &dyn Monitor,
) -> Result<Alternative, StudyError> {
    let spot = Spot { stand, world, place: 0, frame, how, monitor };
    let chip = Planned { plan: None, config: spot.chip(Version::None)?, start: Start::Warm };
    let mut played = spot.play(&format!("{}: {setting}", stand.scene), &[chip])?;
    Ok(played.remove(0).alternative(setting))
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
        // First-level caches may hold all that a frame reads.
        let mem = [no_vm, a, b].map(|run| in_mb(run.mem_bytes.max(1)));
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
