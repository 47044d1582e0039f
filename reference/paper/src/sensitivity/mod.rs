//! How far each Assumed number moves the rows of Table 2: every row again with each value that the paper's text admits,
//! one at a time, and with pairs of the four strongest.
//!
//! What is measured of a row is kept as soon as it is known, so that a run which is stopped goes on where it was.

mod measure;
mod numbers;

pub use measure::{Measured, Options, Setting, measure};
pub use numbers::{AssumedNumber, NUMBERS, Value};

use crate::error::ReproductionError;
use crate::fit::{A_OF_NO_VM, B_OF_NO_VM, Compared, MEM_B_OF_A, bootstrap, family_name, percent};
use crate::table2::Shape;
use crate::tables::{LEAST_MEM_MB, LEAST_PCI_MB, Table2Row, in_mb, table2};
use serde::Serialize;
use std::collections::BTreeMap;

/// How many of the strongest numbers are varied in pairs.
const IN_PAIRS: usize = 4;

/// How far rows are off the paper's, in percent: exp(mean |ln(ours / paper)|) − 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Over A / no VM, B / no VM and Mem B / A, as in [`fit`](crate::fit).
    pub relations: f64,
    /// Over A / no VM.
    pub a: f64,
    /// Over B / no VM.
    pub b: f64,
    /// Over Mem B / A.
    pub mem_b_of_a: f64,
    /// Over frames a second without virtual memory.
    pub fps: f64,
    /// Over the bytes that version A moves to and from the on-board memory.
    pub mem: f64,
    /// Over the bytes that version A loads.
    pub pci: f64,
    /// Geometric mean of ours / the paper's frames a second without virtual memory.
    pub fps_ratio: f64,
    /// The same of the bytes that version A moves.
    pub mem_ratio: f64,
    /// The same of the bytes that version A loads.
    pub pci_ratio: f64,
}

/// What a setting does to the rows of some scenes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Effect {
    /// Rows.
    pub rows: usize,
    /// How far they are off with it.
    pub errors: Errors,
    /// How much farther than with the defaults, in points of percent: less than 0 is nearer to the paper.
    pub change: f64,
    /// Interval of 95 % of this change: paired bootstrap over families of scenes.
    pub interval: [f64; 2],
}

/// A setting, and what it does.
#[derive(Clone, Debug, Serialize)]
pub struct Bar {
    /// The setting: `NAME=VALUE`, or several with commas between them.
    pub setting: String,
    /// For built_in scenes, real ones, and all.
    pub effects: BTreeMap<&'static str, Effect>,
    /// How far rows are off with it, family by family.
    pub families: BTreeMap<String, Errors>,
}

/// What a sample of the rows is worth, by the settings that all rows were measured with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SampleFacts {
    /// The part of the rows.
    pub part: String,
    /// Rows of the sample, and all.
    pub rows: (usize, usize),
    /// Settings that all rows were measured with.
    pub settings: usize,
    /// How far the change of the error over the sample is from that over all rows, in points of percent: the root of the
    /// mean square over these settings. None without any.
    pub error: Option<f64>,
    /// Of these settings, those whose change over all rows lies in the sample's interval.
    pub within: usize,
}

/// An Assumed number in the result.
#[derive(Clone, Debug, Serialize)]
pub struct NumberFacts {
    /// Its name.
    pub name: &'static str,
    /// The requirement that assumes it.
    pub id: &'static str,
    /// The value of the standard configuration.
    pub default: &'static str,
    /// What the paper says, by which the other values are admitted.
    pub text: &'static str,
}

/// What all settings do.
#[derive(Clone, Debug, Serialize)]
pub struct Sensitivity {
    /// Pixels a row, and rows, of the pictures.
    pub resolution: (u32, u32),
    /// Settings that were tried, with that of the defaults.
    pub settings: usize,
    /// What the sample is worth; none of all rows.
    pub sample: Option<SampleFacts>,
    /// The numbers that were varied.
    pub numbers: Vec<NumberFacts>,
    /// The defaults, which change nothing.
    pub defaults: Bar,
    /// One number at a time, in the order of the numbers.
    pub bars: Vec<Bar>,
    /// The numbers whose values change the error over all rows the most, the strongest first.
    pub strongest: Vec<&'static str>,
    /// Several at a time.
    pub combinations: Vec<Bar>,
}

impl Sensitivity {
    /// What these settings do, from what was measured of the rows of `options`.
    ///
    /// # Errors
    /// If the real scenes are not in their folder.
    pub fn of(
        options: &Options,
        settings: &[Setting],
        measured: &[Measured],
    ) -> Result<Self, ReproductionError> {
        let (drawn, all) = (options.drawn()?, options.rows()?);
        let of_all =
            Rows::of(measured, |one| one.is_of(options.extent) && (!one.real || options.scenes.is_some()));
        let rows = Rows(of_all.0.iter().copied().filter(|one| drawn.contains(&one.place())).collect());
        let (alone, together): (Vec<&Setting>, Vec<&Setting>) =
            settings.iter().partition(|setting| setting.numbers().len() == 1);
        let bars: Vec<Bar> = alone.into_iter().map(|setting| rows.bar(&setting.to_string())).collect();
        let strongest = strongest(&bars);
        let facts = |number: &AssumedNumber| NumberFacts {
            name: number.name,
            id: number.id,
            default: number.default,
            text: number.text,
        };
        let sample = options.sample.to_string();
        Ok(Self {
            resolution: options.extent.trace().resolution,
            settings: settings.len() + 1,
            sample: (drawn.len() < all).then(|| of_all.worth(sample, all, &rows, settings)),
            numbers: NUMBERS.iter().map(facts).collect(),
            defaults: rows.bar(""),
            combinations: together.into_iter().map(|setting| rows.bar(&setting.to_string())).collect(),
            bars,
            strongest,
        })
    }

    /// The strongest numbers two at a time, each with the value that changes the error the most.
    #[must_use]
    pub fn pairs(&self) -> Vec<Setting> {
        let strongest = &self.strongest[..self.strongest.len().min(IN_PAIRS)];
        let of = |name: &str| -> Option<Setting> {
            let bar = self
                .bars
                .iter()
                .filter(|bar| bar.is_of(name))
                .max_by(|a, b| a.change().total_cmp(&b.change()))?;
            bar.setting.parse().ok()
        };
        let values: Vec<Setting> = strongest.iter().filter_map(|name| of(name)).collect();
        let behind = |place: usize| values[place + 1..].iter().map(move |other| (place, other));
        (0..values.len()).flat_map(behind).map(|(place, other)| values[place].and(other)).collect()
    }
}

impl Bar {
    fn is_of(&self, number: &str) -> bool {
        self.setting.split_once('=').is_some_and(|(name, _)| name == number)
    }

    /// How much it changes the error over all rows, up or down.
    fn change(&self) -> f64 {
        self.effects.get("all").map_or(0.0, |effect| effect.change.abs())
    }
}

/// What was measured of some rows, in one order whatever the order in which it was kept.
struct Rows<'a>(Vec<&'a Measured>);

impl<'a> Rows<'a> {
    fn of(measured: &'a [Measured], is_asked_for: impl Fn(&Measured) -> bool) -> Self {
        let mut rows: Vec<&Measured> = measured.iter().filter(|one| is_asked_for(one)).collect();
        rows.sort_by_key(|one| one.place());
        Self(rows)
    }

    fn with(&self, setting: &str) -> Vec<&'a Measured> {
        self.0.iter().copied().filter(|one| one.setting == setting).collect()
    }

    fn bar(&self, setting: &str) -> Bar {
        let (defaults, rows) = (self.with(""), self.with(setting));
        let pairs = paired(&defaults, &rows);
        let mut by_family: BTreeMap<String, Vec<Pair<'_>>> = BTreeMap::new();
        for pair in pairs {
            let (real, family) = pair.row.compared.family();
            by_family.entry(family_name(real, family)).or_default().push(pair);
        }
        Bar {
            setting: setting.to_owned(),
            effects: effects(&defaults, &rows),
            families: by_family.into_iter().map(|(name, pairs)| (name, errors(&pairs))).collect(),
        }
    }

    /// What a sample of these rows is worth, by the settings that `all` rows were measured with.
    fn worth(&self, part: String, all: usize, sample: &Rows<'_>, settings: &[Setting]) -> SampleFacts {
        let names = settings.iter().map(ToString::to_string);
        let both = names.filter(|setting| self.with(setting).len() == all).filter_map(|setting| {
            let (sample, all) = (sample.bar(&setting), self.bar(&setting));
            Some((*sample.effects.get("all")?, all.effects.get("all")?.change))
        });
        let both: Vec<(Effect, f64)> = both.collect();
        let squares = both.iter().map(|(sample, all)| (sample.change - all).powi(2));
        let mean = squares.sum::<f64>() / both.len() as f64;
        let within = |(sample, all): &&(Effect, f64)| (sample.interval[0]..=sample.interval[1]).contains(all);
        SampleFacts {
            part,
            rows: (sample.with("").len(), all),
            settings: both.len(),
            error: (!both.is_empty()).then(|| mean.sqrt()),
            within: both.iter().filter(within).count(),
        }
    }
}

/// The numbers that are varied, by the most that a value of theirs changes the error over all rows.
fn strongest(bars: &[Bar]) -> Vec<&'static str> {
    let most = |number: &AssumedNumber| {
        bars.iter().filter(|bar| bar.is_of(number.name)).map(Bar::change).fold(0.0, f64::max)
    };
    let is_varied = |number: &&AssumedNumber| bars.iter().any(|bar| bar.is_of(number.name));
    let mut numbers: Vec<&AssumedNumber> = NUMBERS.iter().filter(is_varied).collect();
    numbers.sort_by(|a, b| most(b).total_cmp(&most(a)));
    numbers.into_iter().map(|number| number.name).collect()
}

/// A row with a setting and with the defaults.
struct Pair<'a> {
    row: Row<'a>,
    default: Row<'a>,
}

/// What was measured of a row, beside the paper's.
struct Row<'a> {
    compared: Compared<'a>,
    /// Ours / the paper's: frames a second, Mem, PCI.
    absolute: [f64; 3],
}

impl<'a> Row<'a> {
    fn new(measured: &'a Measured) -> Self {
        let paper = printed(measured);
        let Measured { fps, mem_bytes, pci_bytes, .. } = *measured;
        let pci = pci_bytes[0] as f64;
        let ours = Shape::new(fps, mem_bytes.map(|bytes| bytes.max(1) as f64), pci);
        let ratio = |bytes: u64, paper: f64, least: f64| in_mb(bytes).max(least) / paper.max(least);
        let absolute = [
            fps[0] / paper.no_vm.fps,
            ratio(mem_bytes[1], paper.version_a.mem_mb, LEAST_MEM_MB),
            ratio(pci_bytes[0], paper.version_a.pci_mb, LEAST_PCI_MB),
        ];
        let Measured { scene, real, .. } = measured;
        Self { compared: Compared { scene, real: *real, paper, ours }, absolute }
    }

    fn off_by(&self) -> impl Iterator<Item = f64> {
        self.compared.relations().into_iter().map(|relation| relation.off_by())
    }
}

/// The paper's row.
fn printed(measured: &Measured) -> &'static Table2Row {
    let is = |row: &&Table2Row| (&row.scene, &row.frame) == (&measured.of, &measured.row);
    table2().iter().find(is).expect("what is measured stands for a row of the paper")
}

/// The rows that were measured with a setting and with the defaults.
fn paired<'a>(defaults: &[&'a Measured], rows: &[&'a Measured]) -> Vec<Pair<'a>> {
    let by_row: BTreeMap<_, &'a Measured> = rows.iter().map(|row| (row.place(), *row)).collect();
    let pair = |default: &&'a Measured| {
        let row = by_row.get(&default.place())?;
        Some(Pair { row: Row::new(row), default: Row::new(default) })
    };
    defaults.iter().filter_map(pair).collect()
}

/// What a setting does to built-in scenes, real ones, and all.
fn effects(defaults: &[&Measured], rows: &[&Measured]) -> BTreeMap<&'static str, Effect> {
    let pairs = |which: fn(&Measured) -> bool| {
        let chosen: Vec<&Measured> = defaults.iter().copied().filter(|default| which(default)).collect();
        paired(&chosen, rows)
    };
    let sets =
        [("built_in", pairs(|one| !one.real)), ("real", pairs(|one| one.real)), ("all", pairs(|_| true))];
    sets.into_iter()
        .filter(|(_, pairs)| !pairs.is_empty())
        .map(|(name, pairs)| (name, effect(&pairs)))
        .collect()
}

fn effect(pairs: &[Pair<'_>]) -> Effect {
    let change = |pairs: &[&Pair<'_>]| {
        percent(pairs.iter().flat_map(|pair| pair.row.off_by()))
            - percent(pairs.iter().flat_map(|pair| pair.default.off_by()))
    };
    let mut by_family: BTreeMap<_, Vec<&Pair<'_>>> = BTreeMap::new();
    pairs.iter().for_each(|pair| by_family.entry(pair.row.compared.family()).or_default().push(pair));
    let groups: Vec<Vec<&Pair<'_>>> = by_family.into_values().collect();
    let all: Vec<&Pair<'_>> = pairs.iter().collect();
    Effect {
        rows: pairs.len(),
        errors: errors(pairs),
        change: change(&all),
        interval: bootstrap(&groups, |pairs| change(&pairs.iter().copied().copied().collect::<Vec<_>>())),
    }
}

fn errors(pairs: &[Pair<'_>]) -> Errors {
    let rows = || pairs.iter().map(|pair| &pair.row);
    let relation = |name: &str| {
        let relations = rows().flat_map(|row| row.compared.relations());
        percent(relations.filter(|one| one.relation == name).map(|one| one.off_by()))
    };
    let absolute = |place: usize| rows().map(move |row| libm::log(row.absolute[place]));
    let off = |place: usize| percent(absolute(place).map(f64::abs));
    let ratio = |place: usize| libm::exp(absolute(place).sum::<f64>() / pairs.len() as f64);
    Errors {
        relations: percent(rows().flat_map(Row::off_by)),
        a: relation(A_OF_NO_VM),
        b: relation(B_OF_NO_VM),
        mem_b_of_a: relation(MEM_B_OF_A),
        fps: off(0),
        mem: off(1),
        pci: off(2),
        fps_ratio: ratio(0),
        mem_ratio: ratio(1),
        pci_ratio: ratio(2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduction::Extent;
    use crate::tables::MB;

    fn options(sample: &str) -> Options {
        Options { extent: Extent::Some, scenes: None, sample: sample.parse().expect("a part") }
    }

    /// The paper's rows as printed, but for A / no VM, which is off by `percent`.
    fn measured(setting: &str, percent: impl Fn(usize) -> f64) -> Vec<Measured> {
        let row = |(place, row): (usize, &'static Table2Row)| {
            let Table2Row { no_vm, version_a: a, version_b: b, .. } = row;
            let mb = |mb: f64| (mb * MB as f64) as u64;
            Measured {
                hot_spots: vec![1, 2, 3, 4],
                fps: [no_vm.fps, a.fps * (1.0 + percent(place) / 100.0), b.fps],
                mem_bytes: [no_vm.mem_mb, a.mem_mb, b.mem_mb].map(mb),
                pci_bytes: [a.pci_mb, b.pci_mb].map(mb),
                ..Measured::blank(Extent::Some, &row.scene, &row.frame, setting)
            }
        };
        table2().iter().enumerate().map(row).collect()
    }

    fn settings() -> Vec<Setting> {
        ["granule=16 B", "granule=64 B", "banks=8"].map(|text| text.parse().expect("a setting")).to_vec()
    }

    fn all() -> Vec<Measured> {
        let of = [("", 0.0), ("granule=16 B", 3.0), ("granule=64 B", 6.0), ("banks=8", 5.0)];
        of.into_iter().flat_map(|(setting, percent)| measured(setting, move |_| percent)).collect()
    }

    #[test]
    fn result_does_not_hang_on_the_order_of_what_was_measured() {
        let text = |measured: &[Measured]| {
            format!("{:?}", Sensitivity::of(&options("1"), &settings(), measured).expect("rows"))
        };
        let mut backwards = all();
        backwards.reverse();
        assert_eq!(text(&all()), text(&backwards));
    }

    /// A run that goes on has the numbers of one that was not stopped.
    #[test]
    fn what_is_kept_reads_back_to_the_bit() {
        for bits in (0..2000_u64).map(|n| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 12) + (0x409_u64 << 52)) {
            let fps = [f64::from_bits(bits); 3];
            let row = Measured { fps, ..Measured::blank(Extent::Some, "Sodahall", "152", "") };
            let line = serde_json::to_string(&row).expect("JSON");
            assert_eq!(serde_json::from_str::<Measured>(&line).expect(&line), row);
            assert!(row.is_possible());
        }
        assert!(!Measured::blank(Extent::Some, "Sodahall", "152", "").is_possible(), "no frames a second");
    }

    #[test]
    fn strongest_numbers_are_paired_with_their_strongest_values() {
        let result = Sensitivity::of(&options("1"), &settings(), &all()).expect("rows");
        assert_eq!(result.strongest[..2], ["granule", "banks"]);
        let pairs: Vec<_> = result.pairs().iter().map(ToString::to_string).collect();
        assert_eq!(pairs[0], "granule=64 B,banks=8");
        assert_eq!(result.sample, None);
        let effect = &result.bars[1].effects["all"];
        assert!((effect.errors.a - 6.0).abs() < 1e-9 && effect.change > 1.0 && effect.rows == 25);
        assert_eq!(result.bars[1].families.len(), 4);
    }

    #[test]
    fn sample_is_judged_by_the_settings_that_have_all_rows() {
        let varied = |setting| measured(setting, |place| (place % 4) as f64);
        let rows: Vec<Measured> = measured("", |_| 0.0).into_iter().chain(varied("banks=8")).collect();
        let result = Sensitivity::of(&options("1/4"), &settings(), &rows).expect("rows");
        let sample = result.sample.expect("a sample");
        assert_eq!((sample.rows, sample.settings), ((6, 25), 1), "granules were not measured");
        assert!(sample.error.is_some_and(|error| error > 0.01), "{sample:?}");
        // Without any such setting nothing is said of it.
        let result = Sensitivity::of(&options("1/4"), &settings(), &rows[..25]).expect("rows");
        assert_eq!(result.sample.map(|sample| (sample.settings, sample.error)), Some((0, None)));
    }

    /// As where first-level caches hold all that a frame reads.
    #[test]
    fn frames_that_move_nothing_are_compared() {
        let mut rows = all();
        rows.iter_mut().filter(|row| row.setting == "banks=8").for_each(|row| row.mem_bytes = [0; 3]);
        let result = Sensitivity::of(&options("1"), &settings(), &rows).expect("rows");
        let Errors { relations, mem_b_of_a, mem, .. } = result.bars[2].effects["all"].errors;
        assert!([relations, mem_b_of_a, mem].into_iter().all(f64::is_finite));
    }

    #[test]
    fn quarter_of_the_rows_has_each_family() {
        let drawn = options("1/4").drawn().expect("rows");
        let families: std::collections::BTreeSet<_> =
            drawn.iter().map(|(_, scene, _)| saarcor_studies::standard::family(scene)).collect();
        assert_eq!((drawn.len(), families.len()), (6, 4));
    }
}
