//! Estimates of a picture's totals from a sample of its packets.
//!
//! Of *every* packet something rough is known: what it does when few of its rays are traced. Of the
//! packets of the sample both are known, and their ratio carries the rough total over to the
//! picture: double sampling with a ratio estimator (Neyman 1938; Cochran, Sampling Techniques,
//! 3rd ed. 1977, §6.2 and §12.8). Blocks are what is drawn, and so what varies; their residuals
//! give the standard error. That they are one a stratum makes it too large rather than too small.

use super::plan::Plan;

/// An estimate, and its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value to go by.
    pub estimate: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Estimate {
    /// What is known and not estimated.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self { estimate: value, low: value, high: value }
    }

    /// Whether the interval holds a value.
    #[must_use]
    pub fn holds(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The same times a constant that is not negative.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        self.map(|value| value * factor)
    }

    /// The same, with an interval that is longer at its ends, but does not go below 0.
    #[must_use]
    pub fn widened(self, below: f64, above: f64) -> Self {
        Self { low: (self.low - below).max(0.0), high: self.high + above, ..self }
    }

    /// A value that grows with this one.
    fn map(self, grows: impl Fn(f64) -> f64) -> Self {
        Self { estimate: grows(self.estimate), low: grows(self.low), high: grows(self.high) }
    }

    /// A value that falls where this one grows.
    #[must_use]
    pub fn falling(self, falls: impl Fn(f64) -> f64) -> Self {
        Self { estimate: falls(self.estimate), low: falls(self.high), high: falls(self.low) }
    }

    /// The sum, with every value that two values in the intervals have.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let (low, high) = (self.low + other.low, self.high + other.high);
        Self { estimate: self.estimate + other.estimate, low, high }
    }

    /// The product with an independent estimate: relative errors add up by their squares.
    #[must_use]
    pub fn product(self, other: Self) -> Self {
        let estimate = self.estimate * other.estimate;
        let apart = |one: f64, of: f64| if of > 0.0 { one / of - 1.0 } else { 0.0 };
        let below = libm::hypot(apart(self.low, self.estimate), apart(other.low, other.estimate));
        let above = libm::hypot(apart(self.high, self.estimate), apart(other.high, other.estimate));
        Self { estimate, low: (estimate * (1.0 - below)).max(0.0), high: estimate * (1.0 + above) }
    }

    /// The difference, not below 0, with every value that two values in the intervals have.
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        let difference = |whole: f64, part: f64| (whole - part).max(0.0);
        Self {
            estimate: difference(self.estimate, other.estimate),
            low: difference(self.low, other.high),
            high: difference(self.high, other.low),
        }
    }
}

/// Largest coefficient of variation of a sample's rough total for which the ratio is used. So many of
/// its standard errors the ratio's own bias is at most (Cochran §6.8), and a bias of half a standard
/// error leaves 92 % of an interval's 95 % (Cochran §1.8, Table 1.1).
const MAX_VARIATION: f64 = 0.5;

/// Number of events that cannot be excluded, at 95 %, where none was seen (Hanley and Lippman-Hand
/// 1983).
const RULE_OF_THREE: f64 = 3.0;

/// The sum over a picture's blocks of a quantity of which `fine` is known for the blocks of the
/// sample and `rough`, something proportional to it by and large, for all. What `fine` holds elsewhere
/// is not read.
///
/// The interval is that of 95 % by Student's distribution, and wider by what as many packets are worth
/// as can be of a kind that the sample has none of.
#[must_use]
pub fn total(plan: &Plan, fine: &[f64], rough: &[f64]) -> Estimate {
    let ones = vec![1.0; rough.len()];
    let usable = plan.sums(rough, rough).is_some_and(|sums| sums.variation() <= MAX_VARIATION);
    let rough = if usable { rough } else { &ones };
    let all: f64 = rough.iter().sum();
    let Some(sums) = plan.sums(fine, rough) else { return Estimate::exact(0.0) };
    let estimate = sums.ratio() * all;
    let unseen = RULE_OF_THREE / plan.sample.len() as f64 * sums.left_out * estimate;
    let error = student_975(sums.blocks.len() - 1) * sums.standard_error() * all + unseen;
    Estimate { estimate, low: (estimate - error).max(0.0), high: estimate + error }
}

/// A number of events that are so seldom that the sample may have none, and that few rays see all over
/// the picture: `rough` is what they see, and each of them stands for `each` of all rays. The interval
/// holds those of both: that of a number that was counted (Poisson), and that of the sample.
#[must_use]
pub fn seldom(plan: &Plan, fine: &[f64], rough: &[f64], each: f64) -> Estimate {
    let sampled = total(plan, fine, rough);
    let seen: f64 = rough.iter().sum();
    let error = NORMAL_975 * seen.sqrt() + RULE_OF_THREE;
    let (low, high) = ((seen - error).max(0.0) * each, (seen + error) * each);
    Estimate { estimate: seen * each, low: sampled.low.min(low), high: sampled.high.max(high) }
}

/// Least and most batches: for a standard error, and so that a batch has many packets.
const BATCHES: std::ops::RangeInclusive<usize> = 2..=16;

/// How much of one quantity there is for each of another, from the sums of both over batches of a run
/// that follow one another (batch means: Conway 1963); none from too few batches.
#[must_use]
pub fn rate(batches: &[(f64, f64)]) -> Option<Estimate> {
    let sums = BlockSums { blocks: batches.to_vec(), left_out: 1.0 };
    if !BATCHES.contains(&batches.len()) || sums.rough() <= 0.0 {
        return None;
    }
    let (estimate, error) = (sums.ratio(), student_975(batches.len() - 1) * sums.standard_error());
    Some(Estimate { estimate, low: (estimate - error).max(0.0), high: estimate + error })
}

/// Cuts `0 .. count` into as many batches of at least `least` as [`rate`] takes.
pub fn batches(count: usize, least: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    let batches = (count / least.max(1)).min(*BATCHES.end());
    (0..batches).map(move |batch| batch * count / batches..(batch + 1) * count / batches)
}

/// A number of loads by the virtual memory: of lines that neither an earlier packet nor the picture
/// before has read. From few rays, `rough`, such lines are detected with few rays on both sides of the
/// comparison; it may err either way, and is the estimate. With all rays, `fine`, of packets of the
/// sample alone, what the others read is known in part only, and more lines seem new than are: that
/// is the interval's upper end. Each of them may have been read by what few rays have not seen, so the
/// lower end is 0.
#[must_use]
pub fn loads(plan: &Plan, fine: &[f64], rough: &[f64]) -> Estimate {
    let above = total(plan, fine, rough);
    let estimate: f64 = rough.iter().sum();
    let unseen = RULE_OF_THREE * plan.packets() as f64 / plan.sample.len() as f64;
    Estimate { estimate, low: 0.0, high: above.high.max(estimate).max(unseen) }
}

/// A number of distinct lines: at least those `seen`; at most, by the estimate of `fine`, those that
/// are new to the packets of the sample, to which more lines are new than to all packets. The
/// estimate is the geometric mean of both.
#[must_use]
pub fn distinct(plan: &Plan, fine: &[f64], rough: &[f64], seen: f64) -> Estimate {
    let above = total(plan, fine, rough);
    let high = above.high.max(seen);
    Estimate { estimate: (seen * above.estimate.max(seen)).sqrt(), low: seen, high }
}

/// Sums of a fine and a rough quantity by blocks, weighted by what each block stands for.
struct BlockSums {
    blocks: Vec<(f64, f64)>,
    /// SampleFraction of the picture's blocks that is not in the sample.
    left_out: f64,
}

impl Plan {
    /// None where the rough quantity is nowhere.
    fn sums(&self, fine: &[f64], rough: &[f64]) -> Option<BlockSums> {
        let mut blocks = Vec::with_capacity(self.stands_for.len());
        for (block, (fine, rough)) in (0..).zip(fine.iter().zip(rough)) {
            if let Some(weight) = self.weight_of(block) {
                blocks.push((f64::from(weight) * fine, f64::from(weight) * rough));
            }
        }
        let left_out = 1.0 - blocks.len() as f64 / self.blocks() as f64;
        (blocks.iter().map(|(_, rough)| rough).sum::<f64>() > 0.0).then_some(BlockSums { blocks, left_out })
    }
}

impl BlockSums {
    fn rough(&self) -> f64 {
        self.blocks.iter().map(|(_, rough)| rough).sum()
    }

    fn ratio(&self) -> f64 {
        self.blocks.iter().map(|(fine, _)| fine).sum::<f64>() / self.rough()
    }

    /// Of the ratio (Cochran §6.4), with the correction for a finite picture.
    fn standard_error(&self) -> f64 {
        let ratio = self.ratio();
        let squares = self.blocks.iter().map(|(fine, rough)| (fine - ratio * rough).powi(2)).sum::<f64>();
        self.deviation(squares) / self.rough()
    }

    /// Coefficient of variation of the rough quantity's sum.
    fn variation(&self) -> f64 {
        let mean = self.rough() / self.blocks.len() as f64;
        let squares = self.blocks.iter().map(|(_, rough)| (rough - mean).powi(2)).sum::<f64>();
        self.deviation(squares) / self.rough()
    }

    /// Standard deviation of a sum over the blocks, whose squared deviations add up to `squares`.
    fn deviation(&self, squares: f64) -> f64 {
        let blocks = self.blocks.len() as f64;
        (squares * blocks / (blocks - 1.0).max(1.0) * self.left_out).sqrt()
    }
}

/// The 97.5 % quantile of the normal distribution.
const NORMAL_975: f64 = 1.959_964;

/// The 97.5 % quantile of Student's distribution: the first ten from a table, above by Fisher's
/// expansion about the normal distribution's (Abramowitz and Stegun 1964, 26.7.5), to 0.001.
fn student_975(degrees: usize) -> f64 {
    const TABLE: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    match degrees {
        0 => f64::INFINITY,
        1..=10 => TABLE[degrees - 1],
        _ => {
            let (z, n) = (NORMAL_975, degrees as f64);
            z + (z.powi(3) + z) / (4.0 * n)
                + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n.powi(2))
                + (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / (384.0 * n.powi(3))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::plan::SampleFraction;
    use crate::trace::PacketOrder;

    /// 20 × 45 blocks.
    const TILES: (u32, u32) = (320, 90);

    /// Values in 0 to 1 that look random.
    fn noise(number: usize) -> f64 {
        let mixed = (number as u64 ^ 0x5851_f42d).wrapping_mul(0x2545_f491_4f6c_dd1d);
        ((mixed ^ mixed >> 29).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / (1_u64 << 24) as f64
    }

    /// A picture of smooth hills with noise, and something rough that follows it.
    fn picture() -> (Vec<f64>, Vec<f64>) {
        let block = |block: usize| {
            let (x, y) = ((block % 20) as f64 / 3.0, (block / 20) as f64 / 6.0);
            10.0 + 6.0 * libm::sin(x) * libm::cos(y) + 3.0 * noise(block)
        };
        let fine: Vec<f64> = (0..plan(8, 0).blocks()).map(block).collect();
        let rough = fine.iter().enumerate().map(|(i, fine)| fine * (0.3 + 0.1 * noise(i + 77_777)));
        let rough = rough.collect();
        (fine, rough)
    }

    fn plan(part: u32, seed: u64) -> Plan {
        Plan::new(TILES, PacketOrder::Scan, SampleFraction::one_of(part), seed).expect("a plan")
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let (fine, rough) = picture();
        let (truth, ones) = (fine.iter().sum::<f64>(), vec![1.0; fine.len()]);
        for part in [8, 32] {
            for rough in [&rough, &ones] {
                let held =
                    (0..400).filter(|&seed| total(&plan(part, seed), &fine, rough).holds(truth)).count();
                // 95 % of 400 with three standard deviations of a binomial below.
                assert!(held >= 367, "1/{part}: {held} of 400");
            }
        }
    }

    #[test]
    fn rough_knowledge_makes_intervals_narrow() {
        let (fine, rough) = picture();
        let ones = vec![1.0; fine.len()];
        let width = |rough: &[f64]| {
            let width = |seed| total(&plan(8, seed), &fine, rough);
            (0..20).map(width).map(|estimate| estimate.high - estimate.low).sum::<f64>()
        };
        assert!(width(&rough) < width(&ones) / 2.0);
    }

    #[test]
    fn whole_picture_is_exact() {
        let (fine, rough) = picture();
        let estimate = total(&plan(1, 0), &fine, &rough);
        let truth: f64 = fine.iter().sum();
        assert!((estimate.estimate / truth - 1.0).abs() < 1e-12);
        assert!(estimate.low <= estimate.estimate && estimate.estimate <= estimate.high);
    }

    #[test]
    fn what_is_proportional_is_known_but_for_what_was_not_seen() {
        let (fine, _) = picture();
        let rough: Vec<f64> = fine.iter().map(|fine| fine / 7.0).collect();
        let estimate = total(&plan(16, 3), &fine, &rough);
        let packets = plan(16, 3).sample.len() as f64;
        assert!((estimate.high / estimate.estimate - 1.0 - 3.0 / packets * 15.0 / 16.0).abs() < 1e-4);
    }

    #[test]
    fn rough_nothing_is_not_divided_by() {
        let (fine, _) = picture();
        let estimate = total(&plan(16, 3), &fine, &vec![0.0; fine.len()]);
        assert!(estimate.estimate > 0.0 && estimate.high.is_finite());
    }

    #[test]
    fn nothing_seen_is_not_nothing() {
        let zeros = vec![0.0; plan(8, 3).blocks()];
        let estimate = loads(&plan(8, 3), &zeros, &zeros);
        assert_eq!((estimate.estimate, estimate.low), (0.0, 0.0));
        assert!((20.0..28.0).contains(&estimate.high), "{estimate:?}");
    }

    #[test]
    fn what_is_seldom_is_counted_all_over_the_picture() {
        // One block of 900 has all, and a sixteenth of it is seen.
        let (mut fine, mut rough) = (vec![0.0; 900], vec![0.0; 900]);
        (fine[444], rough[444]) = (200.0, 10.0);
        for seed in 0..20 {
            let estimate = seldom(&plan(16, seed), &fine, &rough, 16.0);
            assert!(estimate.estimate == 160.0 && estimate.holds(200.0), "{estimate:?}");
        }
        let nothing = seldom(&plan(16, 0), &vec![0.0; 900], &vec![0.0; 900], 16.0);
        assert_eq!(nothing, Estimate { estimate: 0.0, low: 0.0, high: 48.0 });
    }

    #[test]
    fn loads_and_lines_lie_between_what_each_side_knows() {
        let (fine, rough) = picture();
        let all: f64 = rough.iter().sum();
        let found = loads(&plan(8, 3), &fine, &rough);
        assert_eq!(found.estimate, all);
        assert!(found.low == 0.0 && found.high > all);
        let lines = distinct(&plan(8, 3), &fine, &rough, all);
        assert_eq!((lines.low, lines.high), (all, found.high));
    }

    #[test]
    fn differences_have_every_value_that_two_intervals_allow() {
        let whole = Estimate { estimate: 20.0, low: 10.0, high: 25.0 };
        let part = Estimate { estimate: 5.0, low: 0.0, high: 30.0 };
        assert_eq!(whole.minus(part), Estimate { estimate: 15.0, low: 0.0, high: 25.0 });
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (degrees, quantile) in
            [(1, 12.706), (4, 2.776), (10, 2.228), (11, 2.201), (30, 2.042), (1000, 1.962)]
        {
            assert!((student_975(degrees) - quantile).abs() < 1e-3, "{degrees}");
        }
    }
}
