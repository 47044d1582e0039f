//! Which contestants are worth their time: the front of speed against error.

use super::contest::Contestant;
use super::measure::{AccuracyRow, quantile};
use crate::names::kernel_name;

/// A contestant over all suites.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Which one.
    pub contestant: Contestant,
    /// Nanoseconds a test: median over the suites.
    pub ns: f64,
    /// Wrong answers in a million cases.
    pub wrong_per_million: f64,
    /// Leaks.
    pub leaks: u64,
    /// What 99.9 % of the distances' errors do not exceed, in ulps, in the median suite.
    pub t_ulp_p999: f64,
    /// No other contestant is both faster and less often wrong.
    pub on_front: bool,
}

impl Standing {
    /// Kernel and format.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", kernel_name(self.contestant.kernel), self.contestant.format.name())
    }
}

/// The standing of each contestant in `rows`, the fastest first.
#[must_use]
pub fn standings(rows: &[AccuracyRow]) -> Vec<Standing> {
    let mut standings: Vec<Standing> = Vec::new();
    for row in rows {
        let contestant = row.contestant();
        if standings.iter().any(|known| known.contestant == contestant) {
            continue;
        }
        let own: Vec<&AccuracyRow> = rows.iter().filter(|row| row.contestant() == contestant).collect();
        let median = |number: fn(&AccuracyRow) -> f64| {
            quantile(&mut own.iter().map(|r| number(r)).collect::<Vec<_>>(), 0.5)
        };
        let sum = |number: fn(&AccuracyRow) -> u64| own.iter().map(|row| number(row)).sum::<u64>();
        standings.push(Standing {
            contestant,
            ns: median(|row| row.ns_per_test),
            wrong_per_million: sum(AccuracyRow::wrong) as f64 * 1e6 / sum(|row| row.cases).max(1) as f64,
            leaks: sum(|row| row.leaks),
            t_ulp_p999: median(|row| row.t_ulp_p999),
            on_front: false,
        });
    }
    standings.sort_by(|a, b| a.ns.total_cmp(&b.ns));
    let mut least_wrong = f64::INFINITY;
    for standing in &mut standings {
        standing.on_front = standing.wrong_per_million < least_wrong;
        least_wrong = least_wrong.min(standing.wrong_per_million);
    }
    standings
}
