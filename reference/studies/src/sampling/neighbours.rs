//! What is not known of first-level caches at the edges of a sample: what its neighbours, of which
//! few rays are known, would have left there.
//!
//! A line that a run of the sample's packets touches for the first time is found if an earlier packet
//! has left it. Of the earlier packets most are known with few rays. So a miss may be a hit in truth:
//! few rays touch a part of the lines only; and a hit a miss: all rays evict more. The same is known
//! of traces cut into pieces, whose first references are neither hits nor misses (Wood, Hill, Kessler
//! 1991: "unknown references"). Both are bounded by counts:
//!
//! * at most, each line that a run touches first is missed: no earlier packet left anything;
//! * of the lines that were found, left by neighbours, few rays have seen a share `p`, that share of the
//!   lines of the sample's own blocks that few rays see there. If neighbours are seen no worse, then
//!   for each line found there are `(1 - p) / p` that were missed and would have been found.

use super::estimate::Estimate;
use super::plan::Plan;
use super::trace::{SHRINK, Standing, Traced};
use rayon::prelude::*;
use saarcor_fast::first_level::first_and_last_line;
use saarcor_model::time::{ChipConfig, Operation, Programs};
use std::collections::BTreeMap;

/// First-level lines of the blocks of a sample, by cache.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbours {
    /// For each block, the lines that runs of its packets touch first.
    first: [Vec<f64>; 4],
    /// Of the lines of the sample's blocks, the share that few rays see there.
    seen: [f64; 4],
}

/// How many more or fewer first-level misses of a cache a picture may have than were estimated.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Unknown {
    misses: f64,
    fewer: f64,
    more: f64,
}

/// The number of distinct lines of the sample's blocks, by cache.
#[must_use]
pub fn lines_of_blocks(rough: &Traced, config: &ChipConfig, plan: &Plan) -> [f64; 4] {
    let mut blocks = vec![Vec::new(); plan.blocks()];
    for (standing, program) in rough.packets() {
        if plan.weight_of(standing.block).is_some() {
            blocks[standing.block as usize].push(program);
        }
    }
    let counted: Vec<[usize; 4]> = blocks
        .par_iter()
        .map(|block| lines(block, config, &rough.programs).map(|lines| lines.len()))
        .collect();
    std::array::from_fn(|cache| counted.iter().map(|lines| lines[cache] as f64).sum())
}

impl Neighbours {
    /// Counts the lines of a frame with the sample in full; with few rays its blocks have `few` lines.
    #[must_use]
    pub fn of(few: [f64; 4], fine: &Traced, config: &ChipConfig, plan: &Plan) -> Self {
        let packets: Vec<(&Standing, &[Operation])> = fine.packets().collect();
        let runs = packets.chunk_by(|(a, _), (b, _)| a.block == b.block);
        let runs: Vec<_> = runs.filter(|run| run[0].0.in_full).collect();
        let touched: Vec<[Vec<u32>; 4]> = runs
            .par_iter()
            .map(|run| {
                let programs: Vec<_> = run.iter().map(|(_, program)| *program).collect();
                lines(&programs, config, &fine.programs)
            })
            .collect();
        let mut first: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; plan.blocks()]);
        let mut blocks: BTreeMap<u32, [Vec<u32>; 4]> = BTreeMap::new();
        for (run, touched) in runs.iter().zip(touched) {
            let block = run[0].0.block;
            let all = blocks.entry(block).or_default();
            for (cache, lines) in touched.into_iter().enumerate() {
                first[cache][block as usize] += lines.len() as f64;
                all[cache].extend(lines);
            }
        }
        let distinct = |cache: usize| -> f64 {
            blocks.values_mut().map(|lines| distinct(&mut lines[cache]) as f64).sum()
        };
        let seen = [0, 1, 2, 3].map(distinct);
        let seen = std::array::from_fn(|cache| match seen[cache] {
            0.0 => 1.0,
            all => (few[cache] / all).min(1.0),
        });
        Self { first, seen }
    }

    /// Upper bound on the evictions by the full trace relative to those by the coarse one: a coarse packet
    /// touches a share of the lines, at least the share of the rays that it traces.
    #[must_use]
    pub fn crowding(&self) -> f64 {
        1.0 / self.seen.into_iter().fold(1.0, f64::min).max(1.0 / f64::from(SHRINK * SHRINK))
    }

    /// What is not known of the misses of each cache, of which the sample has so many in each block.
    #[must_use]
    pub fn unknown(&self, plan: &Plan, misses: &[Vec<f64>; 4]) -> [Unknown; 4] {
        let sum = |blocks: &[f64]| -> f64 {
            let weighted = (0..)
                .zip(blocks)
                .filter_map(|(block, value)| Some(f64::from(plan.weight_of(block)?) * value));
            weighted.sum()
        };
        std::array::from_fn(|cache| {
            let (missed, first, seen) = (sum(&misses[cache]), sum(&self.first[cache]), self.seen[cache]);
            let found = (first - missed).max(0.0);
            let fewer = if seen > 0.0 { (found * (1.0 - seen) / seen).min(missed) } else { missed };
            Unknown { misses: missed, fewer, more: found }
        })
    }
}

impl Unknown {
    /// Of all caches, each miss as so many.
    #[must_use]
    pub fn sum(caches: &[Self; 4], worth: [f64; 4]) -> Self {
        let sum =
            |of: fn(&Self) -> f64| caches.iter().zip(worth).map(|(cache, worth)| of(cache) * worth).sum();
        Self { misses: sum(|it| it.misses), fewer: sum(|it| it.fewer), more: sum(|it| it.more) }
    }

    /// The interval of something proportional to the misses.
    #[must_use]
    pub fn widen(self, estimate: Estimate) -> Estimate {
        if self.misses <= 0.0 {
            return estimate;
        }
        let each = estimate.estimate / self.misses;
        estimate.widened(self.fewer * each, self.more * each)
    }
}

/// The distinct first-level lines that packets read, by cache.
fn lines(packets: &[&[Operation]], config: &ChipConfig, programs: &Programs) -> [Vec<u32>; 4] {
    let mut lines: [Vec<u32>; 4] = Default::default();
    for operation in packets.iter().copied().flatten().filter(|operation| operation.bytes > 0) {
        let cache = operation.unit as usize;
        let (first, last) = first_and_last_line(
            programs.first_level_base(operation.unit),
            config.l1[cache].line,
            operation.addr,
            operation.bytes,
        );
        lines[cache].extend(first..=last);
    }
    lines.iter_mut().for_each(|lines| {
        distinct(lines);
    });
    lines
}

/// Leaves each line once; how many that are.
fn distinct(lines: &mut Vec<u32>) -> usize {
    lines.sort_unstable();
    lines.dedup();
    lines.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::plan::SampleFraction;
    use crate::trace::PacketOrder;

    fn unknown(first: f64, misses: f64, seen: f64) -> Unknown {
        let plan = Plan::new((16, 2), PacketOrder::Scan, SampleFraction::one_of(1), 0).expect("a plan");
        let of_all = |value: f64| std::array::from_fn(|_| vec![value]);
        Neighbours { first: of_all(first), seen: [seen; 4] }.unknown(&plan, &of_all(misses))[0]
    }

    #[test]
    fn lines_that_few_rays_see_are_known() {
        assert_eq!(unknown(100.0, 60.0, 1.0), Unknown { misses: 60.0, fewer: 0.0, more: 40.0 });
    }

    #[test]
    fn as_many_are_missed_for_each_found_as_are_not_seen_for_each_seen() {
        assert_eq!(unknown(100.0, 60.0, 0.8).fewer.round(), 10.0);
        assert_eq!(unknown(100.0, 60.0, 0.1).fewer, 60.0);
        assert_eq!(unknown(100.0, 60.0, 0.0).fewer, 60.0);
    }

    #[test]
    fn nothing_is_found_where_more_is_missed_than_touched_first() {
        assert_eq!(unknown(50.0, 60.0, 0.5), Unknown { misses: 60.0, fewer: 0.0, more: 0.0 });
    }

    #[test]
    fn intervals_are_widened_by_what_is_not_known() {
        let estimate = Estimate { estimate: 120.0, low: 110.0, high: 130.0 };
        let unknown = Unknown { misses: 60.0, fewer: 10.0, more: 20.0 };
        assert_eq!(unknown.widen(estimate), Estimate { estimate: 120.0, low: 90.0, high: 170.0 });
    }
}
