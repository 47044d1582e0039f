//! Rows of Table 2 on chips, trees and pictures that differ from the standard ones.

use super::numbers::{Change, NUMBERS, Value};
use crate::alternatives::Start;
use crate::error::ReproductionError;
use crate::reproduction::Extent;
use crate::sections::Section;
use crate::table2::{Begun, caches_before, rows_of};
use crate::tables::Table2Row;
use rayon::prelude::*;
use saarcor_fast::chip::{Caches, simulate_from};
use saarcor_model::time::{ChipConfig, Version};
use saarcor_scenes::kdbuild::BuildOptions;
use saarcor_studies::StudyError;
use saarcor_studies::monitor::Monitor;
use saarcor_studies::sampling::fraction::SampleFraction;
use saarcor_studies::simulate::{WarmUp, record};
use saarcor_studies::standard::{self, family};
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
        let mut tracing = Tracing { trace, order: PacketOrder::default(), warm_up: WarmUp::ONE };
        for change in self.changes() {
            match change {
                Change::Trace(change) => change(&mut tracing.trace, &mut tracing.order),
                Change::WarmUp(frames) => tracing.warm_up = WarmUp::frames(frames),
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

    fn start(&self) -> Start {
        let is_cold = self.changes().any(|change| matches!(change, Change::ColdFirstLevel));
        if is_cold { Start::ColdFirstLevel } else { Start::Warm }
    }
}

/// How a frame and those before it are traced.
struct Tracing {
    trace: TraceOptions,
    order: PacketOrder,
    warm_up: WarmUp,
}

impl Tracing {
    /// Distinguishes it from others.
    fn key(&self) -> String {
        let Self { trace, order, warm_up } = self;
        format!("{trace:?} {order:?} {warm_up:?}")
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
    /// The frames of all rows of the scene: the hot spots of its family.
    pub hot_spots: Vec<usize>,
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
    /// Whether the numbers can have been measured: frames take time, and move bytes.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        self.fps.iter().all(|fps| fps.is_finite() && *fps > 0.0)
    }

    /// Whether it is of the pictures of `extent`, by the defaults of this program.
    pub(super) fn is_of(&self, extent: Extent) -> bool {
        self.resolution == extent.trace().resolution && self.defaults == defaults()
    }

    /// A built-in row, of which nothing is known.
    #[cfg(test)]
    pub(super) fn blank(extent: Extent, scene: &str, frame: &str, setting: &str) -> Self {
        Self {
            defaults: defaults(),
            resolution: extent.trace().resolution,
            scene: scene.to_lowercase(),
            real: false,
            of: scene.to_owned(),
            row: frame.to_owned(),
            frame: 0,
            hot_spots: Vec::new(),
            setting: setting.to_owned(),
            fps: [0.0; 3],
            mem_bytes: [0; 3],
            pci_bytes: [0; 2],
        }
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
    /// The part of the rows that is measured.
    pub sample: SampleFraction,
}

impl Options {
    /// Checks that there are rows to measure.
    ///
    /// # Errors
    /// If the sample draws none, or the real scenes are not in their folder.
    pub fn check(&self) -> Result<(), ReproductionError> {
        let is_any = !self.drawn()?.is_empty();
        let none = || Ok(ReproductionError::NoRows { sample: self.sample.to_string(), all: self.rows()? });
        if is_any { Ok(()) } else { none().and_then(Err) }
    }

    /// All rows.
    pub(super) fn rows(&self) -> Result<usize, ReproductionError> {
        let sections = Section::all(self.scenes.as_deref(), None)?;
        Ok(rows_in(&sections, SampleFraction::one_of(1)).len())
    }

    /// The rows that are drawn, as [`Measured::place`] names them.
    pub(super) fn drawn(&self) -> Result<BTreeSet<(bool, &'static str, &'static str)>, ReproductionError> {
        let sections = Section::all(self.scenes.as_deref(), None)?;
        let place = |(section, (_, row)): &(&Section, (usize, &'static Table2Row))| {
            (section.real, row.scene.as_str(), row.frame.as_str())
        };
        Ok(rows_in(&sections, self.sample).iter().map(place).collect())
    }
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
    let sections = Section::all(options.scenes.as_deref(), None)?;
    let rows = rows_in(&sections, options.sample);
    let families: BTreeSet<(&str, bool)> = rows.iter().map(|(section, _)| section.family()).collect();
    let is_left = |section: &Section| rows.iter().any(|(other, _)| std::ptr::eq(*other, section));
    let mut frames_of: BTreeMap<(&str, bool), Vec<usize>> = BTreeMap::new();
    let all: f64 = sections
        .iter()
        .filter(|section| is_left(section))
        .map(|section| section.seconds(options.extent))
        .sum();
    let mut done = 0.0;
    // A family of which no row is drawn needs no walk.
    for section in sections.iter().filter(|section| families.contains(&section.family())) {
        let of_section = rows.iter().filter(|(other, _)| std::ptr::eq(*other, section));
        let rows: Vec<(usize, &Table2Row)> = of_section.map(|(_, row)| *row).collect();
        let work = SectionWork { section, rows: &rows, options, settings, monitor };
        let frames = frames_of.entry(section.family()).or_default();
        work.measure(frames, known, keep)?;
        if is_left(section) {
            done += section.seconds(options.extent);
            report(done / all);
        }
    }
    Ok(())
}

/// The rows of some sections that a sample draws, each with its place among the rows of its section.
fn rows_in<'a>(
    sections: &'a [Section],
    sample: SampleFraction,
) -> Vec<(&'a Section, (usize, &'static Table2Row))> {
    let rows = |section: &'a Section| rows_of(&section.row.scene).enumerate().map(move |row| (section, row));
    let all = sections.iter().flat_map(rows).enumerate();
    all.filter(|(place, _)| sample.draws(*place)).map(|(_, row)| row).collect()
}

struct SectionWork<'a> {
    section: &'a Section,
    /// The rows that are measured, each with its place among the section's.
    rows: &'a [(usize, &'static Table2Row)],
    options: &'a Options,
    settings: &'a [Setting],
    monitor: &'a dyn Monitor,
}

impl SectionWork<'_> {
    /// Measures what `known` lacks of the section. `frames` are the hot spots of its family, if they are known: they
    /// stand in what was measured, and else the section that is walked finds them.
    fn measure(
        &self,
        frames: &mut Vec<usize>,
        known: &mut Vec<Measured>,
        keep: &mut dyn FnMut(&Measured) -> std::io::Result<()>,
    ) -> Result<(), ReproductionError> {
        let Self { section, rows, options, settings, monitor } = *self;
        if let Some(one) = known.iter().find(|one| self.is_of_family(one)) {
            frames.clone_from(&one.hot_spots);
        }
        let here: BTreeSet<(String, String)> = known
            .iter()
            .filter(|one| self.is_of_family(one) && one.of == section.row.scene)
            .map(|one| (one.row.clone(), one.setting.clone()))
            .collect();
        let is_lacking =
            |row: &str, setting: &Setting| !here.contains(&(row.to_owned(), setting.to_string()));
        let defaults = Setting::default();
        let all: Vec<&Setting> = std::iter::once(&defaults).chain(settings).collect();
        let lacks = |setting: &&&Setting| rows.iter().any(|(_, row)| is_lacking(&row.frame, setting));
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
        if frames.is_empty() && section.step(options.extent).is_some() {
            let world = World::open(&section.options, monitor)?;
            let graph = section.graph(&world, options.extent, monitor)?;
            let spots = graph.into_iter().flat_map(|graph| graph.hot_spots);
            frames.extend(spots.map(|spot| spot.frame));
        }
        for (world, settings) in worlds {
            let world = World::open(&world, monitor)?;
            for (place, row) in rows {
                let lacking: Vec<&Setting> =
                    settings.iter().filter(|setting| is_lacking(&row.frame, setting)).copied().collect();
                let Some(&frame) = frames.get(*place) else { continue };
                for mut measured in self.row(&row.frame, &world, frame, &lacking)? {
                    measured.hot_spots.clone_from(frames);
                    keep(&measured)?;
                    known.push(measured);
                }
            }
        }
        Ok(())
    }

    /// Whether it was measured of a scene that has the same hot spots.
    fn is_of_family(&self, one: &Measured) -> bool {
        self.section.family() == (family(&one.of), one.real) && one.is_of(self.options.extent)
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
        for (tracing, settings) in tracings {
            let what =
                format!("{} for {}, {row}: {} settings", section.name, section.row.scene, settings.len());
            let played =
                monitor.during(&what, |_| play(&settings, &section.row.scene, world, frame, &tracing))?;
            let line = |(setting, [none, a, b]): (&Setting, [Run; 3])| Measured {
                defaults: defaults(),
                resolution: options.extent.trace().resolution,
                scene: section.name.clone(),
                real: section.real,
                of: section.row.scene.clone(),
                row: row.to_owned(),
                frame,
                hot_spots: Vec::new(),
                setting: setting.to_string(),
                fps: [none.fps, a.fps, b.fps],
                mem_bytes: [none.mem_bytes, a.mem_bytes, b.mem_bytes],
                pci_bytes: [a.pci_bytes, b.pci_bytes],
            };
            measured.extend(settings.into_iter().zip(played).map(line));
        }
        Ok(measured)
    }
}

/// A frame on a chip.
#[derive(Clone, Copy)]
struct Run {
    fps: f64,
    mem_bytes: u64,
    pci_bytes: u64,
}

/// A frame on the chips of some settings: without virtual memory, version A, version B. Chips that are the same for what a
/// version has are simulated once.
fn play(
    settings: &[&Setting],
    of: &str,
    world: &World,
    frame: usize,
    tracing: &Tracing,
) -> Result<Vec<[Run; 3]>, StudyError> {
    let begun = |setting: &Setting, version| -> Result<Begun, StudyError> {
        Ok((with_what_it_has(setting.chip(of, version)?, of)?, setting.start()))
    };
    let mut chips: Vec<Begun> = Vec::new();
    let mut places: Vec<[usize; 3]> = Vec::new();
    for setting in settings {
        let mut place = |version| -> Result<usize, StudyError> {
            let chip = begun(setting, version)?;
            Ok(chips.iter().position(|other| *other == chip).unwrap_or_else(|| {
                chips.push(chip);
                chips.len() - 1
            }))
        };
        places.push([place(Version::None)?, place(Version::A)?, place(Version::B)?]);
    }
    let Tracing { trace, order, warm_up } = tracing;
    let caches = caches_before(world, frame, &chips, *warm_up, trace, *order, &|_| ())?;
    let programs = record(world, frame, trace, *order).programs;
    let run = |(caches, (config, _)): (Caches, &Begun)| {
        let report = simulate_from(caches, &programs, &mut ());
        Run { fps: config.fps(report.cycles), mem_bytes: report.memory_bytes(), pci_bytes: report.pci_bytes }
    };
    let runs: Vec<Run> = caches.into_par_iter().zip(&chips).map(run).collect();
    Ok(places.into_iter().map(|versions| versions.map(|place| runs[place])).collect())
}

/// The chip, with the standard numbers of what its version does not have.
fn with_what_it_has(chip: ChipConfig, of: &str) -> Result<ChipConfig, StudyError> {
    let standard = standard::chip(of, chip.version)?;
    Ok(match chip.version {
        Version::None => ChipConfig {
            cache: standard.cache,
            metadata_cache: standard.metadata_cache,
            pci: standard.pci,
            ..chip
        },
        Version::A => ChipConfig { metadata_cache: standard.metadata_cache, ..chip },
        Version::B => chip,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::time::Programs;

    /// What chips of a version do not have changes nothing: simulating such chips once is exact.
    #[test]
    fn versions_know_only_what_they_have() {
        use saarcor_model::time::Operation;
        use saarcor_model::vm::{HostAddr, Unit};
        let read = |packet: u32, place: u32| Operation {
            unit: Unit::ALL[(place % 4) as usize],
            rays: 64,
            addr: HostAddr(packet * 4096 + place * 131_072),
            bytes: 36,
        };
        let packet = |number: u32| (0..64).map(|place| read(number, place)).collect();
        let programs = Programs { packets: (0..80).map(packet).collect(), triangles: HostAddr(0) };
        let cycles = |config: &ChipConfig| {
            let caches = Caches::empty(HostAddr(0), config).expect("a chip").then(&programs);
            simulate_from(caches, &programs, &mut ()).cycles
        };
        for version in [Version::None, Version::A] {
            for setting in Setting::one_at_a_time() {
                let chip = setting.chip("pQuake3", version).expect("a chip");
                let reduced = with_what_it_has(chip, "pQuake3").expect("a chip");
                assert_eq!(cycles(&reduced), cycles(&chip), "{setting}, {version:?}");
            }
        }
    }

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
