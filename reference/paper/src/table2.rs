//! Table 2 (§4): hot spots on the chip without virtual memory, with version A and with version B,
//! ours beside the paper's.

use crate::tables::{self, MB, Table2Row};
use rayon::prelude::*;
use saarcor_fast::chip::simulate;
use saarcor_model::time::{ChipConfig, PciConfig, Version};
use saarcor_model::vm::{Bytes, Geometry, Hash};
use saarcor_studies::StudyError;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::simulate::{TimingRow, record, record_before};
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, TraceOptions};
use saarcor_studies::world::World;
use serde::Serialize;

/// Frames before a hot spot that warm the caches.
const WARM_UP: usize = 1;

/// A frame on the chip in all versions.
#[derive(Clone, Debug, Serialize)]
pub struct HotSpot {
    /// Our scene.
    pub scene: String,
    /// Whether it is one of the real scenes.
    pub real: bool,
    /// Number of the frame in our path.
    pub frame: usize,
    /// The paper's row.
    pub paper: Table2Row,
    /// Without virtual memory.
    pub no_vm: TimingRow,
    /// Without virtual memory, and with an on-board memory that is twice as fast in all that it does.
    pub no_vm_fast_memory: TimingRow,
    /// With metadata on the chip.
    pub version_a: TimingRow,
    /// With metadata in the on-board memory.
    pub version_b: TimingRow,
    /// Version A on the faster bus.
    pub version_a_fast_pci: TimingRow,
}

/// A hot spot on a chip that differs from version A in one respect.
#[derive(Clone, Debug, Serialize)]
pub struct Variation {
    /// The scene.
    pub scene: String,
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

/// What differs from the standard chip in all runs.
pub type Setting<'a> = &'a dyn Fn(ChipConfig) -> ChipConfig;

/// The standard chip.
pub const STANDARD: Setting<'static> = &|config| config;

/// Hot spots, and some of them with other virtual memories.
#[derive(Clone, Debug, Default)]
pub struct HotSpotRuns {
    /// The hot spots.
    pub spots: Vec<HotSpot>,
    /// Some of them on other chips.
    pub variations: Vec<Variation>,
}

/// Which of our scenes stands in a row of the paper.
#[derive(Clone, Copy, Debug)]
pub struct StandIn<'a> {
    /// Our scene, as it is printed.
    pub scene: &'a str,
    /// Whether it is one of the real scenes.
    pub real: bool,
    /// The paper's scene in whose place it stands.
    pub of: &'a str,
}

/// The rows of Table 2 that stand for a scene of the paper.
pub fn rows_of(scene: &str) -> impl Iterator<Item = &'static Table2Row> {
    tables::table2().iter().filter(move |row| row.scene == scene)
}

/// Simulates the rows of Table 2 in which a scene stands, and for some the variations of the
/// virtual memory of which §3 speaks. `frames` are those of our path, one for a row, in the order of the rows; rows for
/// which there is none are left out. All chips have the `setting`.
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
) -> Result<HotSpotRuns, StudyError> {
    let mut runs = HotSpotRuns::default();
    for (place, (paper, &frame)) in rows_of(stand.of).zip(frames).enumerate() {
        let what = format!("{} for {}, {}", stand.scene, stand.of, paper.frame);
        let order = PacketOrder::default();
        let (before, recording) = monitor.during(&format!("{what}: trace"), |_| {
            let before = record_before(world, frame, WARM_UP, trace, order, &|_| ());
            (before, record(world, frame, trace, order))
        });
        let rays = recording.picture.rays.total();
        let chip = |version| standard::chip(stand.of, version).map(setting);
        let mut configs = vec![chip(Version::None)?, chip(Version::A)?, chip(Version::B)?];
        configs.push(ChipConfig { pci: PciConfig::BITS_64_AT_66_MHZ, ..chip(Version::A)? });
        configs.push(with_fast_memory(chip(Version::None)?));
        // One scene of each kind that has reason to differ: with shadow rays, and with textures.
        let varied = if place == 0 && ["Conference", "pQuake3"].contains(&stand.of) {
            variations(&chip(Version::A)?)?
        } else {
            Vec::new()
        };
        configs.extend(&varied);
        let played = monitor.during(&format!("{what}: chip"), |_| {
            configs
                .par_iter()
                .map(|config| {
                    let report = simulate(&before, &recording.programs, config)?;
                    Ok(TimingRow::new(stand.scene, frame, rays, config, &report))
                })
                .collect::<Result<Vec<TimingRow>, StudyError>>()
        })?;
        let mut played = played.into_iter();
        let [
            Some(no_vm),
            Some(version_a),
            Some(version_b),
            Some(version_a_fast_pci),
            Some(no_vm_fast_memory),
        ] = std::array::from_fn(|_| played.next())
        else {
            unreachable!("a run a chip")
        };
        runs.spots.push(HotSpot {
            scene: stand.scene.to_owned(),
            real: stand.real,
            frame,
            paper: paper.clone(),
            no_vm,
            no_vm_fast_memory,
            version_a,
            version_b,
            version_a_fast_pci,
        });
        runs.variations.extend(played.zip(varied).map(|(run, config)| {
            let geometry = config.cache.geometry;
            Variation {
                scene: stand.scene.to_owned(),
                line_bytes: geometry.line().0,
                ways: geometry.ways(),
                hashed: config.cache.hash != Hash::Low,
                metadata_bytes: geometry.metadata().0,
                run,
            }
        }));
    }
    Ok(runs)
}

/// The chip with a memory whose clock is twice as fast.
fn with_fast_memory(mut config: ChipConfig) -> ChipConfig {
    config.sdram.cycles_a_clock /= 2;
    config
}

/// Sizes of lines that are compared.
const LINES: [u64; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

/// The chip with other lines, and with fewer ways and without hash.
fn variations(standard: &ChipConfig) -> Result<Vec<ChipConfig>, StudyError> {
    let memory = standard.cache.geometry.memory();
    let with = |line: u64, ways: u32, hash: Hash| -> Result<ChipConfig, StudyError> {
        let mut config = *standard;
        config.cache.geometry = Geometry::new(memory, Bytes(line), ways)?;
        config.cache.hash = hash;
        Ok(config)
    };
    let lines = LINES.into_iter().map(|line| with(line, standard::WAYS, Hash::default()));
    let sets = [1, 2, 4].into_iter().flat_map(|ways| {
        [Hash::Low, Hash::AddUpper]
            .into_iter()
            .filter(move |&hash| (ways, hash) != (standard::WAYS, Hash::default()))
            .map(move |hash| with(standard::LINE.0, ways, hash))
    });
    lines.chain(sets).collect()
}

/// A number of bytes in [`MB`].
fn in_mb(bytes: u64) -> f64 {
    bytes as f64 / MB as f64
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
    fn new(fps: [f64; 3], [no_vm, a, b]: [f64; 3], pci: f64) -> Self {
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

    #[test]
    fn each_way_of_finding_a_line_is_tried_once() {
        let standard = standard::chip("conference", Version::A).expect("a chip");
        let tried = variations(&standard).expect("chips");
        assert_eq!(tried.len(), LINES.len() + 5);
        for (place, one) in tried.iter().enumerate() {
            assert!(one.check().is_ok() && !tried[..place].contains(one));
        }
    }
}
