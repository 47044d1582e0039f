//! How far our rows of Table 2 lie from the paper's, in one number, and how sure that is.
//!
//! The error is exp(mean |ln(ours / paper)|) − 1 over three relations of each row: 10 % says that a relation is off by
//! a tenth on the geometric mean, up or down. Absolute figures depend on the scene; these relations say what the virtual
//! memory costs.

use crate::table2::{HotSpot, Shape};
use crate::tables::Table2Row;
use saarcor_random::Random;
use saarcor_studies::standard::family;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rows in which version A moves less than this are printed with one digit: their Mem B / A says nothing.
const LEAST_MEM_MB: f64 = 0.6;
/// Draws of the bootstrap, and its seed.
const DRAWS: usize = 4000;
const SEED: u64 = 2003;

/// A row of ours in the place of one of the paper's.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// Our scene.
    pub scene: &'a str,
    /// Whether it is one of the real scenes.
    pub real: bool,
    /// The paper's row.
    pub paper: &'a Table2Row,
    /// Our relations.
    pub ours: Shape,
}

impl<'a> Compared<'a> {
    /// A hot spot that stands for a row of the paper.
    #[must_use]
    pub fn of(spot: &'a HotSpot) -> Option<Self> {
        let HotSpot { scene, real, paper, .. } = spot;
        Some(Self { scene, real: *real, paper: paper.as_ref()?, ours: Shape::ours(spot) })
    }

    /// Rows of a family depend on each other: they have the geometry of one scene.
    #[must_use]
    pub fn family(&self) -> (bool, &str) {
        (self.real, family(&self.paper.scene))
    }

    /// The relations of the row that count.
    #[must_use]
    pub fn relations(&self) -> Vec<Relation> {
        let (ours, paper) = (self.ours, Shape::printed(self.paper));
        let mut all =
            vec![(A_OF_NO_VM, ours.speed_a, paper.speed_a), (B_OF_NO_VM, ours.speed_b, paper.speed_b)];
        if self.paper.version_a.mem_mb >= LEAST_MEM_MB {
            all.push((MEM_B_OF_A, ours.memory_b, paper.memory_b));
        }
        let relation = |(relation, ours, paper)| Relation {
            scene: self.scene.to_owned(),
            row: format!("{} {}", self.paper.scene, self.paper.frame),
            relation,
            ours,
            paper,
        };
        all.into_iter().map(relation).collect()
    }
}

/// How a family is called: those of the real scenes stand apart.
pub(crate) fn family_name(real: bool, family: &str) -> String {
    if real { format!("{family} (real scene)") } else { family.to_owned() }
}

/// Names of the relations.
pub const A_OF_NO_VM: &str = "A / no VM";
/// See [`A_OF_NO_VM`].
pub const B_OF_NO_VM: &str = "B / no VM";
/// See [`A_OF_NO_VM`].
pub const MEM_B_OF_A: &str = "Mem B / A";

/// A relation within a row, ours and the paper's.
#[derive(Clone, Debug, Serialize)]
pub struct Relation {
    /// Our scene.
    pub scene: String,
    /// The paper's scene and frame.
    pub row: String,
    /// Which relation.
    pub relation: &'static str,
    /// Ours.
    pub ours: f64,
    /// The paper's.
    pub paper: f64,
}

impl Relation {
    /// |ln(ours / paper)|.
    #[must_use]
    pub fn off_by(&self) -> f64 {
        libm::log(self.ours / self.paper).abs()
    }
}

/// How far some rows lie from the paper's.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Rows.
    pub rows: usize,
    /// Relations of these rows.
    pub numbers: usize,
    /// The error in percent.
    pub error_percent: f64,
    /// Interval of 95 % of the error in percent: bootstrap over the families of scenes, as rows of a family depend on
    /// each other. Of one family it is a point, and says nothing.
    pub interval: [f64; 2],
    /// The same over single rows: too narrow, for comparison.
    pub interval_by_rows: [f64; 2],
    /// Relations within 10 % of the paper's, up or down.
    pub within_10_percent: usize,
    /// The relation that is off the most.
    pub worst: Option<Relation>,
    /// The error of each relation in percent.
    pub by_relation: BTreeMap<&'static str, f64>,
}

/// The fit of the built-in scenes, of the real ones, and of both.
#[derive(Clone, Debug, Serialize)]
pub struct Fits {
    /// Of the built-in scenes.
    pub built_in: Fit,
    /// Of the real scenes, if there are any.
    pub real: Option<Fit>,
    /// Of both.
    pub all: Fit,
}

impl Fits {
    /// Those of these rows.
    #[must_use]
    pub fn of(spots: &[HotSpot]) -> Self {
        let of = |which: fn(&HotSpot) -> bool| {
            let rows: Vec<Compared<'_>> =
                spots.iter().filter(|spot| which(spot)).filter_map(Compared::of).collect();
            Fit::of(&rows)
        };
        Self {
            built_in: of(|spot| !spot.real),
            real: spots.iter().any(|spot| spot.real).then(|| of(|spot| spot.real)),
            all: of(|_| true),
        }
    }
}

impl Fit {
    /// That of these rows.
    #[must_use]
    pub fn of(rows: &[Compared<'_>]) -> Self {
        let all: Vec<Relation> = rows.iter().flat_map(Compared::relations).collect();
        let off = |rows: &[&Compared<'_>]| -> Vec<f64> {
            rows.iter().flat_map(|row| row.relations()).map(|relation| relation.off_by()).collect()
        };
        let percent_of = |off: &[&f64]| percent(off.iter().copied().copied());
        let by_family: Vec<_> = families(rows).values().map(|rows| off(rows)).collect();
        let by_row: Vec<_> = rows.iter().map(|row| off(&[row])).collect();
        let mut by_relation: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
        all.iter().for_each(|one| by_relation.entry(one.relation).or_default().push(one.off_by()));
        Self {
            rows: rows.len(),
            numbers: all.len(),
            error_percent: percent(all.iter().map(Relation::off_by)),
            interval: bootstrap(&by_family, percent_of),
            interval_by_rows: bootstrap(&by_row, percent_of),
            within_10_percent: all.iter().filter(|one| one.off_by() <= libm::log(1.1_f64)).count(),
            worst: all.iter().max_by(|a, b| a.off_by().total_cmp(&b.off_by())).cloned(),
            by_relation: by_relation
                .into_iter()
                .map(|(name, off)| (name, percent(off.into_iter())))
                .collect(),
        }
    }
}

/// Rows by families of scenes.
#[must_use]
pub fn families<'a, 'b>(rows: &'b [Compared<'a>]) -> BTreeMap<(bool, &'b str), Vec<&'b Compared<'a>>> {
    let mut families: BTreeMap<_, Vec<_>> = BTreeMap::new();
    rows.iter().for_each(|row| families.entry(row.family()).or_default().push(row));
    families
}

/// exp(mean) − 1 in percent; of nothing 0.
pub(crate) fn percent(off: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = off.fold((0.0, 0_usize), |(sum, count), one| (sum + one, count + 1));
    (libm::exp(sum / count.max(1) as f64) - 1.0) * 100.0
}

/// The interval of 95 % of a statistic when groups are drawn with replacement, as many as there are (Efron 1979).
pub(crate) fn bootstrap<T>(groups: &[Vec<T>], statistic: impl Fn(&[&T]) -> f64) -> [f64; 2] {
    if groups.is_empty() {
        return [0.0; 2];
    }
    let mut random = Random::new(SEED);
    let mut drawn: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let group = |_| &groups[random.below(groups.len() as u64) as usize];
            let drawn: Vec<&T> = (0..groups.len()).flat_map(group).collect();
            statistic(&drawn)
        })
        .collect();
    drawn.sort_unstable_by(f64::total_cmp);
    [drawn[DRAWS / 40], drawn[DRAWS - 1 - DRAWS / 40]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_is_a_factor_up_or_down() {
        let off = [libm::log(1.1_f64), libm::log(1.0 / 1.1_f64).abs(), 0.0, 0.0];
        assert!((percent(off.into_iter()) - (1.1_f64.sqrt() - 1.0) * 100.0).abs() < 1e-9);
        assert!(percent(std::iter::empty()).abs() < 1e-12);
    }

    #[test]
    fn interval_holds_the_error_and_narrows_with_more_groups() {
        let group = |number: usize| vec![0.01 * (number % 5) as f64; 3];
        let interval = |groups: usize| {
            let groups: Vec<_> = (0..groups).map(group).collect();
            bootstrap(&groups, |off| percent(off.iter().copied().copied()))
        };
        let ([few_low, few_high], [low, high]) = (interval(5), interval(50));
        let error = (libm::exp(0.02_f64) - 1.0) * 100.0;
        assert!(few_low < low && low < error && error < high && high < few_high);
        assert_eq!(interval(5), interval(5), "the same draws in each run");
        assert_eq!(interval(1)[0], interval(1)[1]);
    }
}
