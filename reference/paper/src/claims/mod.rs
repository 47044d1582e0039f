//! The paper's claims: whether they hold here, and what each hangs on, as a run with one thing changed.

mod chip;
mod memory;
mod walks;

use crate::alternatives::ADMITTED;
use crate::figure3::Graph;
use crate::fit::family_name;
use crate::table1::SceneRow;
use crate::table2::HotSpot;
use saarcor_studies::metadata::MetadataFacts;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Holds {
    /// Everywhere it was looked at.
    Holds,
    /// In some places.
    InPart,
    /// Nowhere.
    DoesNot,
    /// The paper does not say what its figure counts.
    NotComparable,
    /// Nothing that was run decides.
    Undecided,
}

impl Holds {
    /// From the findings in each place.
    fn of(places: impl IntoIterator<Item = bool>) -> Self {
        let (mut some, mut all) = (false, true);
        places.into_iter().for_each(|holds| (some, all) = (some | holds, all & holds));
        match (some, all) {
            (true, true) => Self::Holds,
            (true, false) => Self::InPart,
            (false, false) => Self::DoesNot,
            (false, true) => Self::Undecided,
        }
    }
}

impl fmt::Display for Holds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::InPart => "holds in part",
            Self::DoesNot => "does not hold here",
            Self::NotComparable => "not comparable",
            Self::Undecided => "cannot be decided here",
        })
    }
}

/// A claim of the paper, judged.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// A name for it.
    pub id: &'static str,
    /// Where it stands in the paper.
    pub section: &'static str,
    /// The claim, and how it is judged.
    pub claim: &'static str,
    /// The paper's figures.
    pub paper: String,
    /// Ours.
    pub ours: String,
    /// Whether it holds.
    pub verdict: Holds,
    /// What it hangs on; none where nothing was run that tells.
    pub cause: Option<Cause>,
    /// The numbers that decide it, place by place.
    pub numbers: Vec<String>,
    /// The same with other values of Assumed numbers that the text admits; none of claims that need other runs than those
    /// of Table 2.
    pub admitted: Vec<Admitted>,
    /// What the paper leaves open; empty if nothing.
    pub open: &'static str,
}

/// A claim with another value of one Assumed number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Admitted {
    /// The value.
    pub setting: &'static str,
    /// Whether the claim holds.
    pub verdict: Holds,
    /// The figure of the claim's cause.
    pub figure: Option<f64>,
}

/// A counterfactual: one thing is changed, and the same figure is taken again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// What is changed.
    pub setting: String,
    /// Which figure.
    pub figure: String,
    /// The figure as all else is standard.
    pub standard: f64,
    /// The figure with the setting.
    pub with_setting: f64,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { setting, figure, standard, with_setting } = self;
        let number = |value: f64| format!("{value:.*}", if value < 10.0 { 3 } else { 1 });
        write!(f, "with {setting}: {figure} {}, not {}", number(*with_setting), number(*standard))
    }
}

/// All that claims are judged by.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence<'a> {
    /// The examples of §3.
    pub examples: &'a [MetadataFacts],
    /// Table 1.
    pub scenes: &'a [SceneRow],
    /// The walks.
    pub graphs: &'a [Graph],
    /// The hot spots.
    pub spots: &'a [HotSpot],
    /// Frames after a cut of the camera.
    pub cuts: &'a [HotSpot],
}

/// Judges all claims: those of §3, of the walks, and of the chip. Claims about scenes that are not there are left out.
#[must_use]
pub fn judge(evidence: Evidence<'_>) -> Vec<Claim> {
    let of_memory = memory::claims(evidence);
    let mut claims: Vec<Claim> =
        of_memory.into_iter().chain(walks::claims(evidence)).chain(chip::claims(evidence)).collect();
    for setting in ADMITTED {
        let spots: Vec<HotSpot> = evidence.spots.iter().map(|spot| spot.standing_on(setting)).collect();
        for Claim { id, verdict, cause, .. } in chip::of_rows(&spots) {
            if let Some(claim) = claims.iter_mut().find(|claim| claim.id == id) {
                claim.admitted.push(Admitted { setting, verdict, figure: cause.map(|cause| cause.standard) });
            }
        }
    }
    for claim in &mut claims {
        let said = claim.over_admitted();
        claim.numbers.extend(said);
    }
    claims
}

impl Claim {
    /// The range of its figure over all admitted values, and the values with which the verdict is another.
    fn over_admitted(&self) -> Option<String> {
        let Cause { figure, standard, .. } = self.cause.as_ref()?;
        let figures = self.admitted.iter().filter_map(|other| other.figure);
        let Range { least, most } = Range::of(figures.chain([*standard]));
        let others = self.admitted.iter().filter(|other| other.verdict != self.verdict);
        let others: Vec<_> = others.map(|other| format!("{}: {}", other.setting, other.verdict)).collect();
        let verdict = if others.is_empty() { "the same verdict".to_owned() } else { others.join(", ") };
        (!self.admitted.is_empty()).then(|| {
            format!("over {} admitted settings: {figure} {least:.3} to {most:.3}; {verdict}", ADMITTED.len())
        })
    }
}

/// What stands in the place of a figure that there is none of.
const NOTHING: &str = "–";

/// Ranges of ratios in words.
fn times(ranges: &[String], what: &str) -> String {
    if ranges.is_empty() { NOTHING.to_owned() } else { format!("{} times {what}", ranges.join("; ")) }
}

/// How many times `of` a number is; none of nothing.
fn ratio(number: f64, of: f64) -> Option<f64> {
    (of > 0.0).then(|| number / of)
}

/// A range of values; of none if its least is more than its most.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    least: f64,
    most: f64,
}

impl Range {
    fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let none = Self { least: f64::INFINITY, most: f64::NEG_INFINITY };
        values
            .into_iter()
            .fold(none, |range, value| Self { least: range.least.min(value), most: range.most.max(value) })
    }

    /// Both ends moved outwards by a quarter of their distance from 1: values so near to the paper's rows
    /// count as the same.
    fn widened(self) -> Self {
        let quarter = |end: f64| (end - 1.0).abs() / 4.0;
        Self { least: self.least - quarter(self.least), most: self.most + quarter(self.most) }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.least > self.most {
            return f.write_str(NOTHING);
        }
        let (least, most) = (format!("{:.2}", self.least), format!("{:.2}", self.most));
        if least == most { f.write_str(&least) } else { write!(f, "{least} to {most}") }
    }
}

/// The hot spots by families, those of the real scenes apart.
fn families<'a>(spots: impl IntoIterator<Item = &'a HotSpot>) -> BTreeMap<String, Vec<&'a HotSpot>> {
    let mut families: BTreeMap<String, Vec<&HotSpot>> = BTreeMap::new();
    for spot in spots {
        families.entry(family_name(spot.real, spot.family())).or_default().push(spot);
    }
    families
}

/// Ranges of a number of each row, family by family.
fn ranges<'a>(
    spots: impl IntoIterator<Item = &'a HotSpot>,
    number: impl Fn(&HotSpot) -> Option<f64>,
) -> Vec<String> {
    let range = |(name, spots): (String, Vec<&HotSpot>)| {
        let range = Range::of(spots.iter().filter_map(|spot| number(spot)));
        range.least.is_finite().then(|| format!("{name} {range}"))
    };
    families(spots).into_iter().filter_map(range).collect()
}

/// The geometric mean; none of nothing.
fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let logs: Vec<f64> = values.into_iter().filter(|value| *value > 0.0).map(f64::ln).collect();
    (!logs.is_empty()).then(|| libm::exp(logs.iter().sum::<f64>() / logs.len() as f64))
}

/// A figure of the rows that have it with and without a setting: its geometric mean over those in which both are more
/// than 0; where there are none, the arithmetic mean.
fn cause<'a>(
    setting: &str,
    figure: &str,
    spots: impl IntoIterator<Item = &'a HotSpot>,
    both: impl Fn(&HotSpot) -> Option<(f64, f64)>,
) -> Option<Cause> {
    let all: Vec<(f64, f64)> = spots.into_iter().filter_map(both).collect();
    let (standard, changed): (Vec<f64>, Vec<f64>) =
        all.iter().copied().filter(|(standard, changed)| *standard > 0.0 && *changed > 0.0).unzip();
    let geometric = mean(standard).zip(mean(changed));
    let count = all.len() as f64;
    let sums = all.iter().fold((0.0, 0.0), |sums, both| (sums.0 + both.0, sums.1 + both.1));
    let arithmetic = (!all.is_empty()).then_some((sums.0 / count, sums.1 / count));
    let (standard, with_setting) = geometric.or(arithmetic)?;
    Some(Cause { setting: setting.to_owned(), figure: figure.to_owned(), standard, with_setting })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_holds_everywhere_somewhere_or_nowhere() {
        assert_eq!(Holds::of([true, true]), Holds::Holds);
        assert_eq!(Holds::of([true, false]), Holds::InPart);
        assert_eq!(Holds::of([false]), Holds::DoesNot);
        assert_eq!(Holds::of([]), Holds::Undecided, "of nothing, nothing is shown");
    }

    #[test]
    fn ranges_widen_away_from_one() {
        let widened = Range::of([0.88, 0.96]).widened();
        assert!((widened.least - 0.85).abs() < 1e-12 && (widened.most - 0.97).abs() < 1e-12);
        let widened = Range::of([1.32, 1.2]).widened();
        assert!((widened.least - 1.15).abs() < 1e-12 && (widened.most - 1.4).abs() < 1e-12);
    }

    #[test]
    fn means_are_geometric() {
        assert!((mean([1.0, 4.0]).expect("two") - 2.0).abs() < 1e-12);
        assert_eq!(mean([0.0]), None);
    }
}
