//! Rows of Table 2 on chips, trees and pictures that differ from the standard ones.

use super::numbers::{Change, NUMBERS, Value};
use crate::error::ReproductionError;
use crate::reproduction::Extent;
use crate::sections::Section;
use crate::table2::rows_of;
use rayon::prelude::*;
use saarcor_fast::chip::{Caches, simulate_part};
use saarcor_model::time::{ChipConfig, Programs, Version};
use saarcor_scenes::kdbuild::BuildOptions;
use saarcor_studies::StudyError;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::simulate::{record, record_before};
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::PathBuf;
use xxhash_rust::xxh3::xxh3_64;

/// Values of some Assumed numbers; the others are the standard ones.
#[derive(Clone, Debug, Default)]
pub struct Setting(Vec<(&'static str, Value)>);

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<_> = self.0.iter().map(|(name, value)| format!("{name}={}", value.value)).collect();
        f.write_str(&values.join(","))
    }
}

impl std::str::FromStr for Setting {
    type Err = ReproductionError;

    fn from_str(text: &str) -> Result<Self, ReproductionError> {
        let one = |part: &str| {
            let found = Self::one_at_a_time().into_iter().find(|one| one.to_string() == part);
            found.ok_or_else(|| ReproductionError::NoSetting(part.to_owned()))
        };
        let parts = text.split(',').map(one).collect::<Result<Vec<_>, _>>()?;
        let all = parts.iter().fold(Self::default(), |all, part| all.and(part));
        let names: BTreeSet<_> = all.numbers().into_iter().collect();
        let once = names.len() == all.0.len();
        once.then_some(all).ok_or_else(|| ReproductionError::NoSetting(text.to_owned()))
    }
}

impl Setting {
    /// Each value of each number, by itself.
    #[must_use]
    pub fn one_at_a_time() -> Vec<Self> {
        let of = |number: &'static super::AssumedNumber| {
            number.values.iter().map(|value| Self(vec![(number.name, *value)]))
        };
        NUMBERS.iter().flat_map(of).collect()
    }

    /// The numbers that it names.
    #[must_use]
    pub fn numbers(&self) -> Vec<&'static str> {
        self.0.iter().map(|(name, _)| *name).collect()
    }

    /// The values of both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self(self.0.iter().chain(&other.0).copied().collect())
    }

    fn changes(&self) -> impl Iterator<Item = Change> {
        self.0.iter().map(|(_, value)| value.change)
    }

    /// What it makes of the image: settings that make the same are measured on one world.
    fn world(&self, options: &WorldOptions, triangles: u64) -> WorldOptions {
        let mut options = options.clone();
        for change in self.changes() {
            if let Change::World(change) = change {
                change(&mut options, triangles);
            }
        }
        options
    }

    fn tracing(&self, trace: TraceOptions) -> Tracing {
        let mut tracing = Tracing { trace, order: PacketOrder::default(), warm_up: crate::table2::WARM_UP };
        for change in self.changes() {
            match change {
                Change::Trace(change) => change(&mut tracing.trace, &mut tracing.order),
                Change::WarmUp(frames) => tracing.warm_up = frames,
                Change::Chip(_) | Change::ColdFirstLevel | Change::World(..) => {}
            }
        }
        tracing
    }

    fn chip(&self, of: &str, version: Version) -> Result<ChipConfig, StudyError> {
        let mut chip = standard::chip(of, version)?;
        for change in self.changes() {
            if let Change::Chip(change) = change {
                change(&mut chip);
            }
        }
        Ok(chip)
    }

    fn is_cold(&self) -> bool {
        self.changes().any(|change| matches!(change, Change::ColdFirstLevel))
    }
}

/// How a frame and those before it are traced.
struct Tracing {
    trace: TraceOptions,
    order: PacketOrder,
    warm_up: usize,
}

impl Tracing {
    /// Distinguishes it from others.
    fn key(&self) -> String {
        let Self { trace, order, warm_up } = self;
        format!("{trace:?} {order:?} {warm_up}")
    }
}

/// A row of Table 2 with a setting: a line of what is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Distinguishes the defaults from those of other versions of the program.
    pub defaults: String,
    /// Pixels a row, and rows, of the pictures with the defaults.
    pub resolution: (u32, u32),
    /// Our scene.
    pub scene: String,
    /// Whether it is one of the real scenes.
    pub real: bool,
    /// The paper's scene in whose place it stands, and the frame of its row.
    pub of: String,
    /// See [`Measured::of`].
    pub row: String,
    /// Number of the frame in our path.
    pub frame: usize,
    /// The setting; empty for the defaults.
    pub setting: String,
    /// Frames a second without virtual memory, in version A and in B.
    pub fps: [f64; 3],
    /// Bytes moved to and from the on-board memory, likewise.
    pub mem_bytes: [u64; 3],
    /// Bytes loaded in version A and in B.
    pub pci_bytes: [u64; 2],
}

impl Measured {
    /// Whether it is of the pictures of `extent`, by the defaults of this program.
    pub(super) fn is_of(&self, extent: Extent) -> bool {
        self.resolution == extent.trace().resolution && self.defaults == defaults()
    }

    /// The row that it stands for.
    pub(super) fn place(&self) -> (bool, &str, &str) {
        (self.real, &self.of, &self.row)
    }
}

/// Checksum of all that is standard.
fn defaults() -> String {
    let chips = standard::MEMORY_OF.map(|(of, _)| standard::chip(of, Version::B));
    let all = format!("{} {chips:?} {:?}", env!("CARGO_PKG_VERSION"), BuildOptions::default());
    format!("{:016x}", xxh3_64(all.as_bytes()))
}

/// Which rows are measured.
#[derive(Clone, Debug)]
pub struct Options {
    /// How large the pictures are, and how many frames of a walk are looked at for its hot spots.
    pub extent: Extent,
    /// A folder with the real scenes.
    pub scenes: Option<PathBuf>,
}

/// Measures all rows with all settings that `known` lacks, those of the defaults before all others, and adds them.
/// `keep` gets each as soon as it is known, `report` the part that is done, 0 to 1.
///
/// # Errors
/// If a scene cannot be made ready, and those of `keep`.
pub fn measure(
    options: &Options,
    settings: &[Setting],
    known: &mut Vec<Measured>,
    keep: &mut dyn FnMut(&Measured) -> std::io::Result<()>,
    monitor: &dyn Monitor,
    report: &mut dyn FnMut(f64),
) -> Result<(), ReproductionError> {
    let sections = Section::all(options.scenes.as_deref())?;
    let mut frames_of: BTreeMap<(&str, bool), Vec<usize>> = BTreeMap::new();
    let all: f64 = sections.iter().map(|section| section.seconds(options.extent)).sum();
    let mut done = 0.0;
    for section in &sections {
        let work = SectionWork { section, options, settings, monitor };
        let frames = frames_of.entry(section.family()).or_default();
        work.measure(frames, known, keep)?;
        done += section.seconds(options.extent);
        report(done / all);
    }
    Ok(())
}

struct SectionWork<'a> {
    section: &'a Section,
    options: &'a Options,
    settings: &'a [Setting],
    monitor: &'a dyn Monitor,
}

impl SectionWork<'_> {
    /// Measures what `known` lacks of the section. `frames` are the hot spots of its family: the section that is walked
    /// fills them.
    fn measure(
        &self,
        frames: &mut Vec<usize>,
        known: &mut Vec<Measured>,
        keep: &mut dyn FnMut(&Measured) -> std::io::Result<()>,
    ) -> Result<(), ReproductionError> {
        let Self { section, options, settings, monitor } = *self;
        let rows: Vec<_> = rows_of(&section.row.scene).collect();
        let here: Vec<Measured> = known.iter().filter(|one| self.is_here(one)).cloned().collect();
        let of_defaults = |row: &str| here.iter().find(|one| one.row == row && one.setting.is_empty());
        let kept: Option<Vec<usize>> =
            rows.iter().map(|row| of_defaults(&row.frame).map(|one| one.frame)).collect();
        if let (true, Some(kept)) = (frames.is_empty(), &kept) {
            frames.clone_from(kept);
        }
        let is_lacking = |row: &str, setting: &Setting| {
            !here.iter().any(|one| one.row == row && one.setting == setting.to_string())
        };
        let defaults = Setting::default();
        let all: Vec<&Setting> = std::iter::once(&defaults).chain(settings).collect();
        let lacks = |setting: &&&Setting| rows.iter().any(|row| is_lacking(&row.frame, setting));
        // Settings on one world follow one another: it is opened once.
        let mut worlds: Vec<(WorldOptions, Vec<&Setting>)> = Vec::new();
        for setting in all.iter().filter(lacks) {
            let world = setting.world(&section.options, section.row.triangles);
            let same = worlds.iter_mut().find(|(other, _)| format!("{other:?}") == format!("{world:?}"));
            match same {
                Some((_, settings)) => settings.push(setting),
                None => worlds.push((world, vec![setting])),
            }
        }
        for (world, settings) in worlds {
            let world = World::open(&world, monitor)?;
            if frames.is_empty() {
                let graph = section.graph(&world, options.extent, monitor)?;
                let spots = graph.into_iter().flat_map(|graph| graph.hot_spots);
                frames.extend(spots.map(|spot| spot.frame));
            }
            for (row, &frame) in rows.iter().zip(frames.iter()) {
                let lacking: Vec<&Setting> =
                    settings.iter().filter(|setting| is_lacking(&row.frame, setting)).copied().collect();
                for measured in self.row(&row.frame, &world, frame, &lacking)? {
                    keep(&measured)?;
                    known.push(measured);
                }
            }
        }
        Ok(())
    }

    fn is_here(&self, one: &Measured) -> bool {
        let Self { section, options, .. } = self;
        (section.real, &section.row.scene) == (one.real, &one.of) && one.is_of(options.extent)
    }

    /// A row with each of the settings, which are on one world.
    fn row(
        &self,
        row: &str,
        world: &World,
        frame: usize,
        settings: &[&Setting],
    ) -> Result<Vec<Measured>, ReproductionError> {
        let Self { section, options, monitor, .. } = *self;
        let trace = options.extent.trace();
        let mut tracings: Vec<(Tracing, Vec<&Setting>)> = Vec::new();
        for setting in settings {
            let tracing = setting.tracing(trace);
            match tracings.iter_mut().find(|(other, _)| other.key() == tracing.key()) {
                Some((_, settings)) => settings.push(setting),
                None => tracings.push((tracing, vec![setting])),
            }
        }
        let mut measured = Vec::new();
        for (Tracing { trace, order, warm_up }, settings) in tracings {
            let what =
                format!("{} for {}, {row}: {} settings", section.name, section.row.scene, settings.len());
            let played = monitor.during(&what, |_| {
                let before = record_before(world, frame, warm_up, &trace, order, &|_| ());
                let programs = record(world, frame, &trace, order).programs;
                let of = &section.row.scene;
                settings
                    .par_iter()
                    .map(|setting| play(setting, of, &before, &programs))
                    .collect::<Result<Vec<_>, _>>()
            })?;
            let line = |(setting, Played { fps, mem_bytes, pci_bytes }): (&Setting, Played)| Measured {
                defaults: defaults(),
                resolution: options.extent.trace().resolution,
                scene: section.name.clone(),
                real: section.real,
                of: section.row.scene.clone(),
                row: row.to_owned(),
                frame,
                setting: setting.to_string(),
                fps,
                mem_bytes,
                pci_bytes,
            };
            measured.extend(settings.into_iter().zip(played).map(line));
        }
        Ok(measured)
    }
}

/// What was measured with a setting.
struct Played {
    fps: [f64; 3],
    mem_bytes: [u64; 3],
    pci_bytes: [u64; 2],
}

/// A frame on the chips of a setting: without virtual memory, version A, version B.
fn play(setting: &Setting, of: &str, before: &[Programs], programs: &Programs) -> Result<Played, StudyError> {
    let versions = [Version::None, Version::A, Version::B].into_par_iter();
    let runs = versions.map(|version| {
        let config = setting.chip(of, version)?;
        let caches = Caches::after(before, programs.triangles, &config)?;
        let caches = if setting.is_cold() { caches.with_cold_first_level() } else { caches };
        let report = simulate_part(caches, programs, &vec![true; programs.packets.len()], &mut ());
        Ok((config.fps(report.cycles), report.memory_bytes(), report.pci_bytes))
    });
    let runs: Vec<(f64, u64, u64)> = runs.collect::<Result<_, StudyError>>()?;
    let [none, a, b] = [runs[0], runs[1], runs[2]];
    Ok(Played { fps: [none.0, a.0, b.0], mem_bytes: [none.1, a.1, b.1], pci_bytes: [a.2, b.2] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_read_as_they_are_written() {
        let both: Setting = "granule=16 B,banks=8".parse().expect("a setting");
        assert_eq!(both.to_string(), "granule=16 B,banks=8");
        assert_eq!(both.numbers(), ["granule", "banks"]);
        let chip = both.chip("conference", Version::B).expect("a chip");
        assert_eq!((chip.metadata_cache.granule, chip.sdram.banks), (16, 8));
        for wrong in ["", "granule", "granule=33 B", "banks=8,banks=16", "banks=8,"] {
            let said = wrong.parse::<Setting>().expect_err("refused").to_string();
            assert!(said.contains("granule=16 B,banks=8"), "{said}");
        }
    }
}
