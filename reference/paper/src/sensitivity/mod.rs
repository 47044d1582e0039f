//! How far each Assumed number moves the rows of Table 2: every row again with each value that the paper's text admits,
//! one at a time, and with pairs of the four strongest.
//!
//! What is measured of a row is kept as soon as it is known, so that a run which is stopped goes on where it was.

mod measure;
mod numbers;

pub use measure::{Measured, Options, Setting, measure};
pub use numbers::{AssumedNumber, NUMBERS, Value};

use crate::fit::{A_OF_NO_VM, B_OF_NO_VM, Compared, MEM_B_OF_A, bootstrap, percent};
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
    /// The numbers that were varied.
    pub numbers: Vec<NumberFacts>,
    /// How far rows are off with the defaults.
    pub defaults: BTreeMap<&'static str, Effect>,
    /// One number at a time, in the order of the numbers.
    pub bars: Vec<Bar>,
    /// The numbers whose values change the error over all rows the most, the strongest first.
    pub strongest: Vec<&'static str>,
    /// Several at a time.
    pub combinations: Vec<Bar>,
}

impl Sensitivity {
    /// What these settings do, from what was measured of the rows of `options`.
    #[must_use]
    pub fn of(options: &Options, settings: &[Setting], measured: &[Measured]) -> Self {
        // Whatever was kept: the real scenes count where they are asked for, and rows come in one order.
        let is_asked_for =
            |one: &&Measured| one.is_of(options.extent) && (!one.real || options.scenes.is_some());
        let mut asked_for: Vec<&Measured> = measured.iter().filter(is_asked_for).collect();
        asked_for.sort_by_key(|one| one.place());
        let rows = |setting: &str| -> Vec<&Measured> {
            asked_for.iter().copied().filter(|one| one.setting == setting).collect()
        };
        let defaults = rows("");
        let bar = |setting: &Setting| {
            let setting = setting.to_string();
            Bar { effects: effects(&defaults, &rows(&setting)), setting }
        };
        let (alone, together): (Vec<&Setting>, Vec<&Setting>) =
            settings.iter().partition(|setting| setting.numbers().len() == 1);
        let bars: Vec<Bar> = alone.into_iter().map(bar).collect();
        let strongest = strongest(&bars);
        let facts = |number: &AssumedNumber| NumberFacts {
            name: number.name,
            id: number.id,
            default: number.default,
            text: number.text,
        };
        Self {
            resolution: options.extent.trace().resolution,
            settings: settings.len() + 1,
            numbers: NUMBERS.iter().map(facts).collect(),
            defaults: effects(&defaults, &defaults),
            combinations: together.into_iter().map(bar).collect(),
            bars,
            strongest,
        }
    }

    /// All values of the strongest numbers, two numbers at a time.
    #[must_use]
    pub fn pairs(&self) -> Vec<Setting> {
        let strongest = &self.strongest[..self.strongest.len().min(IN_PAIRS)];
        let of = |name: &str| -> Vec<Setting> {
            Setting::one_at_a_time().into_iter().filter(|one| one.numbers() == [name]).collect()
        };
        let mut pairs = Vec::new();
        for (place, first) in strongest.iter().enumerate() {
            for second in &strongest[place + 1..] {
                for one in of(first) {
                    pairs.extend(of(second).iter().map(|other| one.and(other)));
                }
            }
        }
        pairs
    }
}

/// The numbers by the most that a value of theirs changes the error over all rows.
fn strongest(bars: &[Bar]) -> Vec<&'static str> {
    let most = |number: &AssumedNumber| {
        let of = bars.iter().filter(|bar| bar.setting.starts_with(&format!("{}=", number.name)));
        of.map(|bar| bar.effects["all"].change.abs()).fold(0.0, f64::max)
    };
    let mut numbers: Vec<&AssumedNumber> = NUMBERS.iter().collect();
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
        let ours = Shape::new(fps, mem_bytes.map(|bytes| bytes as f64), pci);
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

/// What a setting does to built-in scenes, real ones, and all.
fn effects<'a>(defaults: &[&'a Measured], rows: &[&'a Measured]) -> BTreeMap<&'static str, Effect> {
    let by_row: BTreeMap<_, &'a Measured> = rows.iter().map(|row| (row.place(), *row)).collect();
    let pairs = |which: &dyn Fn(&Measured) -> bool| -> Vec<Pair<'a>> {
        let chosen = defaults.iter().copied().filter(|default| which(default));
        let pair = |default: &'a Measured| {
            let row = by_row.get(&default.place())?;
            Some(Pair { row: Row::new(row), default: Row::new(default) })
        };
        chosen.filter_map(pair).collect()
    };
    let sets: [(&'static str, Vec<Pair<'a>>); 3] =
        [("built_in", pairs(&|one| !one.real)), ("real", pairs(&|one| one.real)), ("all", pairs(&|_| true))];
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
    let absolute = |place: usize| rows().map(move |row| row.absolute[place].ln());
    let off = |place: usize| percent(absolute(place).map(f64::abs));
    let ratio = |place: usize| (absolute(place).sum::<f64>() / pairs.len() as f64).exp();
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
