//! What frames take that were not simulated, from those that were and from what is cheap to count of all.
//!
//! The logarithm of a quantity is a line over the logarithm of the count that is most like it, and to that come three
//! random parts: a ridge regression on all cheap counts (Hoerl and Kennard 1970), something that changes slowly over the walk
//! (exponential covariance), and what is each frame's own. That is universal kriging (Matheron 1969; Cressie, Statistics for Spatial
//! Data, 1993, §3.4), the best linear unbiased prediction of such a model (Goldberger 1962). How large the parts are, restricted
//! maximum likelihood says (Patterson and Thompson 1971), over a grid. A sum over all frames is what the simulated ones took and
//! what is predicted of the others, and its error is theirs together (Valliant, Dorfman and Royall, Finite Population Sampling and
//! Inference: A Prediction Approach, 2000, ch. 2). The mean of a quantity whose logarithm is predicted is above
//! the prediction's exponential by half of the variance (lognormal kriging, Journel 1980).

use super::estimate::{Estimate, student_975};

/// What is known of all frames of a walk.
#[derive(Clone, Debug)]
pub struct Known {
    /// For each frame, each count's logarithm, of mean 0 and variance 1 over the frames. Counts that do not vary are left out.
    counts: Vec<Vec<f64>>,
}

/// What is predicted of a walk.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Each frame; those simulated are exact.
    pub frames: Vec<Estimate>,
    /// The sum over all frames.
    pub sum: Estimate,
}

/// Before its logarithm is taken, so much of their mean is added to each of some numbers, and one: what is next to nothing would
/// else weigh most (started logarithms, Mosteller and Tukey, Data Analysis and Regression, 1977, ch. 5). The part is Assumed.
const START: f64 = 0.3;

fn start(values: &[f64]) -> f64 {
    START * values.iter().sum::<f64>() / values.len().max(1) as f64 + 1.0
}

/// Variances of the random parts of a frame, relative to that of its own, and how far the slow part reaches, in mean distances between
/// the simulated frames: the grid of the likelihood (Assumed).
const RIDGE: [f64; 5] = [0.0, 0.1, 1.0, 10.0, 100.0];
const SLOW: [f64; 4] = [0.0, 1.0, 10.0, 100.0];
const REACH: [f64; 3] = [0.5, 2.0, 8.0];

/// Sizes of the random parts.
#[derive(Clone, Copy, Debug)]
struct Parts {
    ridge: f64,
    slow: f64,
    reach: f64,
}

impl Known {
    /// What is counted of each frame, in the order of the walk: equally many counts of each.
    #[must_use]
    pub fn new(counts: &[Vec<f64>]) -> Self {
        let columns = counts.first().map_or(0, Vec::len);
        let standard = (0..columns).filter_map(|column| {
            standardized(&counts.iter().map(|counts| counts[column]).collect::<Vec<_>>())
        });
        let standard: Vec<Vec<f64>> = standard.collect();
        let of_frame = |frame: usize| standard.iter().map(|column| column[frame]).collect();
        Self { counts: (0..counts.len()).map(of_frame).collect() }
    }

    /// Predicts a quantity. `like` is the count of each frame that is most like it, `simulated` the frames whose `values` are known, in
    /// increasing order; those of `apart` count in the sum, and nothing is learned of them.
    #[must_use]
    pub fn predict(
        &self,
        like: &[f64],
        simulated: &[usize],
        values: &[f64],
        apart: &[(usize, f64)],
    ) -> Prediction {
        let mut frames = vec![Estimate { value: 0.0, low: 0.0, high: f64::INFINITY }; self.counts.len()];
        let known = simulated.iter().copied().zip(values.iter().copied()).chain(apart.iter().copied());
        known.clone().for_each(|(frame, value)| frames[frame] = Estimate::exact(value));
        let exact: f64 = known.map(|(_, value)| value).sum();
        let rest: Vec<usize> = (0..frames.len()).filter(|frame| frames[*frame].high.is_infinite()).collect();
        let mut sum = Estimate::exact(exact);
        if rest.is_empty() {
            return Prediction { frames, sum };
        }
        if let Some(fit) = Fit::new(self, like, simulated, values) {
            let quantile = student_975(simulated.len() - fit.line.len());
            let away: Vec<Away> = rest.iter().map(|&frame| fit.away(frame)).collect();
            for (&frame, away) in rest.iter().zip(&away) {
                let to = |errors: f64| libm::exp(away.mean + errors * away.variance.sqrt()) - fit.start;
                let value = (away.started() - fit.start).max(0.0);
                frames[frame] =
                    Estimate { value, low: to(-quantile).max(0.0), high: to(quantile).max(value) };
            }
            let others: f64 = rest.iter().map(|&frame| frames[frame].value).sum();
            let error = quantile * fit.variance_of_sum(&rest, &away).sqrt();
            sum = Estimate {
                value: exact + others,
                low: exact + (others - error).max(0.0),
                high: exact + others + error,
            };
        } else {
            sum.high = f64::INFINITY;
        }
        Prediction { frames, sum }
    }

    /// The covariance of two frames' random parts but for what is their own, relative to that.
    fn covariance(&self, Parts { ridge, slow, reach }: Parts, a: usize, b: usize) -> f64 {
        let [one, other] = [&self.counts[a], &self.counts[b]];
        let product: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
        let apart = a.abs_diff(b) as f64;
        ridge * product / one.len().max(1) as f64 + slow * libm::exp(-apart / reach)
    }
}

/// The logarithms, of mean 0 and variance 1; none if they do not vary.
fn standardized(counts: &[f64]) -> Option<Vec<f64>> {
    let start = start(counts);
    let logarithms: Vec<f64> = counts.iter().map(|count| libm::log(count + start)).collect();
    let number = counts.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / number;
    let variance = logarithms.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / number;
    (variance > 1e-12).then(|| logarithms.iter().map(|value| (value - mean) / variance.sqrt()).collect())
}

/// The model, fitted to the simulated frames.
struct Fit<'a> {
    known: &'a Known,
    simulated: &'a [usize],
    parts: Parts,
    /// For each frame, what the line is a sum of: one, and the count that is most like the quantity.
    drift: Vec<Vec<f64>>,
    /// Cholesky's factor of the simulated frames' covariance, and by it the drift and what is above the line.
    factor: Vec<Vec<f64>>,
    drift_of_simulated: Vec<Vec<f64>>,
    above: Vec<f64>,
    /// The line's coefficients, and Cholesky's factor of their precision.
    line: Vec<f64>,
    precision: Vec<Vec<f64>>,
    /// Variance of what is a frame's own.
    own: f64,
    /// What was added before the logarithm.
    start: f64,
    likelihood: f64,
}

/// A frame that was not simulated.
struct Away {
    mean: f64,
    variance: f64,
    /// By the factors: its covariance with the simulated frames, and how the line's error shows in it.
    with_simulated: Vec<f64>,
    off_line: Vec<f64>,
}

impl Away {
    /// The mean of the quantity, and what was added to it.
    fn started(&self) -> f64 {
        libm::exp(self.mean + self.variance / 2.0)
    }
}

impl<'a> Fit<'a> {
    /// The likeliest model; none if the values do not vary or are too few.
    fn new(known: &'a Known, like: &[f64], simulated: &'a [usize], values: &[f64]) -> Option<Self> {
        let start = start(values);
        let logarithms: Vec<f64> = values.iter().map(|value| libm::log(value + start)).collect();
        let slope = standardized(like);
        let drift: Vec<Vec<f64>> = (0..known.counts.len())
            .map(|frame| std::iter::once(1.0).chain(slope.as_ref().map(|slope| slope[frame])).collect())
            .collect();
        let distance = known.counts.len() as f64 / simulated.len().max(1) as f64;
        let slow = SLOW.iter().flat_map(|&slow| {
            let reaches = if slow > 0.0 { &REACH[..] } else { &REACH[..1] };
            reaches.iter().map(move |reach| (slow, reach * distance))
        });
        let parts = slow.flat_map(|(slow, reach)| RIDGE.map(|ridge| Parts { ridge, slow, reach }));
        let fits = parts.filter_map(|parts| Self::with(known, &drift, simulated, &logarithms, parts));
        fits.max_by(|a, b| a.likelihood.total_cmp(&b.likelihood)).map(|fit| Self { start, ..fit })
    }

    fn with(
        known: &'a Known,
        drift: &[Vec<f64>],
        simulated: &'a [usize],
        logarithms: &[f64],
        parts: Parts,
    ) -> Option<Self> {
        let count = simulated.len();
        let covariance = |a: usize, b: usize| {
            known.covariance(parts, simulated[a], simulated[b]) + f64::from(u8::from(a == b))
        };
        let factor = cholesky(count, covariance)?;
        let columns = drift.first()?.len();
        if count <= columns {
            return None;
        }
        let solved: Vec<Vec<f64>> = (0..columns)
            .map(|column| solve(&factor, simulated.iter().map(|&frame| drift[frame][column])))
            .collect();
        let logarithms = solve(&factor, logarithms.iter().copied());
        let precision = cholesky(columns, |a, b| dot(&solved[a], &solved[b]))?;
        let half = solve(&precision, solved.iter().map(|column| dot(column, &logarithms)));
        let line = solve_transposed(&precision, &half);
        let off = |place: usize| {
            logarithms[place] - (0..columns).map(|column| solved[column][place] * line[column]).sum::<f64>()
        };
        let above: Vec<f64> = (0..count).map(off).collect();
        let degrees = (count - columns) as f64;
        let own = dot(&above, &above) / degrees;
        let determinant =
            |factor: &[Vec<f64>]| (0..factor.len()).map(|i| libm::log(factor[i][i])).sum::<f64>();
        let likelihood = -degrees / 2.0 * libm::log(own) - determinant(&factor) - determinant(&precision);
        (own > 1e-24).then(|| Self {
            known,
            simulated,
            parts,
            drift: drift.to_vec(),
            factor,
            drift_of_simulated: solved,
            above,
            line,
            precision,
            own,
            start: 0.0,
            likelihood,
        })
    }

    fn away(&self, frame: usize) -> Away {
        let covariances = self.simulated.iter().map(|&other| self.known.covariance(self.parts, frame, other));
        let with_simulated = solve(&self.factor, covariances);
        let drift = &self.drift[frame];
        let missing =
            drift.iter().zip(&self.drift_of_simulated).map(|(one, of)| one - dot(of, &with_simulated));
        let off_line = solve(&self.precision, missing);
        let mean = dot(drift, &self.line) + dot(&with_simulated, &self.above);
        let variance = self.known.covariance(self.parts, frame, frame) + 1.0
            - dot(&with_simulated, &with_simulated)
            + dot(&off_line, &off_line);
        Away { mean, variance: self.own * variance, with_simulated, off_line }
    }

    /// Of the sum over frames that were not simulated: errors of the logarithms, to first order.
    fn variance_of_sum(&self, rest: &[usize], away: &[Away]) -> f64 {
        let mut sum = 0.0;
        let mut with_simulated = vec![0.0; self.simulated.len()];
        let mut off_line = vec![0.0; self.line.len()];
        for (place, (&frame, one)) in rest.iter().zip(away).enumerate() {
            let value = one.started();
            let before = rest[..place].iter().zip(away);
            let shared = before
                .map(|(&other, away)| away.started() * self.known.covariance(self.parts, frame, other))
                .sum::<f64>();
            sum += value * (value * (self.known.covariance(self.parts, frame, frame) + 1.0) + 2.0 * shared);
            let add = |sums: &mut [f64], of: &[f64]| {
                sums.iter_mut().zip(of).for_each(|(sum, one)| *sum += value * one);
            };
            add(&mut with_simulated, &one.with_simulated);
            add(&mut off_line, &one.off_line);
        }
        let variance = sum - dot(&with_simulated, &with_simulated) + dot(&off_line, &off_line);
        self.own * variance.max(0.0)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The lower triangle whose product with its transpose is a symmetric matrix (Golub and Van Loan, Matrix Computations, §4.2); none
/// if that is not positive definite.
fn cholesky(size: usize, matrix: impl Fn(usize, usize) -> f64) -> Option<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(size);
    for row in 0..size {
        let mut of_row: Vec<f64> = Vec::with_capacity(row + 1);
        for (column, other) in factor.iter().enumerate() {
            of_row.push((matrix(row, column) - dot(&of_row, &other[..column])) / other[column]);
        }
        let square = matrix(row, row) - dot(&of_row, &of_row);
        of_row.push((square > 0.0).then(|| square.sqrt())?);
        factor.push(of_row);
    }
    Some(factor)
}

/// What a lower triangle times it is `right`.
fn solve(factor: &[Vec<f64>], right: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut solved: Vec<f64> = Vec::with_capacity(factor.len());
    for (row, right) in factor.iter().zip(right) {
        let place = solved.len();
        solved.push((right - dot(&row[..place], &solved)) / row[place]);
    }
    solved
}

/// What the transpose of a lower triangle times it is `right`.
fn solve_transposed(factor: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut solved = right.to_vec();
    for place in (0..factor.len()).rev() {
        let later: f64 = (place + 1..factor.len()).map(|row| factor[row][place] * solved[row]).sum();
        solved[place] = (solved[place] - later) / factor[place][place];
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_random::Random;

    /// Numbers of about a normal distribution.
    fn noise(random: &mut Random) -> f64 {
        (0..12).map(|_| random.below(1 << 20) as f64 / f64::from(1 << 20)).sum::<f64>() - 6.0
    }

    /// A walk of 200 frames: counts, the one most like the quantity, and the quantity.
    fn walk(random: &mut Random) -> (Known, Vec<f64>, Vec<f64>) {
        let (mut counts, mut quantity, mut slow) = (Vec::new(), Vec::new(), 0.0);
        for frame in 0..200 {
            slow = 0.95 * slow + 0.03 * noise(random);
            let place = f64::from(frame) / 20.0;
            let of =
                [2.0 + libm::sin(place), 1.0 + libm::cos(0.7 * place)].map(|of| of + 0.05 * noise(random));
            counts.push(of.map(|of| 1000.0 * libm::exp(of)).to_vec());
            let of = 8.0 + 0.8 * of[0] + 0.3 * of[1] + slow + 0.03 * noise(random);
            quantity.push(libm::exp(of));
        }
        let like = counts.iter().map(|counts| counts[0]).collect();
        (Known::new(&counts), like, quantity)
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut random = Random::new(7);
        let (mut sums, mut frames, mut all, mut errors, mut widths) = (0, 0, 0, 0.0, 0.0);
        for _ in 0..100 {
            let (known, like, truth) = walk(&mut random);
            let simulated: Vec<usize> =
                (0..20).map(|stretch| 10 * stretch + random.below(10) as usize).collect();
            let values: Vec<f64> = simulated.iter().map(|&frame| truth[frame]).collect();
            let found = known.predict(&like, &simulated, &values, &[]);
            let sum: f64 = truth.iter().sum();
            sums += usize::from(found.sum.holds(sum));
            errors += (found.sum.value / sum - 1.0).powi(2);
            widths += found.sum.half_width();
            let rest = (0..200).filter(|frame| !simulated.contains(frame));
            for frame in rest {
                all += 1;
                frames += usize::from(found.frames[frame].holds(truth[frame]));
            }
        }
        let (error, width) = ((errors / 100.0).sqrt(), widths / 100.0);
        // 95 % with three standard deviations of a binomial.
        assert!((89..=100).contains(&sums), "{sums} of 100 sums");
        assert!((0.92..=0.98).contains(&(frames as f64 / f64::from(all))), "{frames} of {all} frames");
        assert!(error < 0.02 && width < 3.0 * error, "{error} {width}");
    }

    #[test]
    fn simulated_frames_are_exact_and_those_apart_teach_nothing() {
        let (known, like, truth) = walk(&mut Random::new(3));
        let simulated: Vec<usize> = (0..20).map(|stretch| 10 * stretch + 4).collect();
        let values: Vec<f64> = simulated.iter().map(|&frame| truth[frame]).collect();
        let plain = known.predict(&like, &simulated, &values, &[]);
        let apart = known.predict(&like, &simulated, &values, &[(0, 1e9)]);
        assert_eq!(plain.frames[4], Estimate::exact(truth[4]));
        assert_eq!((plain.frames[1], apart.frames[0]), (apart.frames[1], Estimate::exact(1e9)));
        let all: Vec<usize> = (0..200).collect();
        let sum = known.predict(&like, &all, &truth, &[]).sum;
        assert_eq!((sum.low, sum.high), (sum.value, sum.value));
    }

    #[test]
    fn what_never_varies_is_not_known() {
        let (known, like, _) = walk(&mut Random::new(3));
        let found = known.predict(&like, &[3, 50, 100, 150], &[0.0; 4], &[]);
        assert!(!found.sum.is_known() && !found.frames[0].is_known());
    }

    #[test]
    fn triangles_are_solved() {
        let matrix = [[4.0, 2.0, 0.6], [2.0, 5.0, 1.0], [0.6, 1.0, 3.0]];
        let factor = cholesky(3, |a, b| matrix[a][b]).expect("positive definite");
        let half = solve(&factor, [1.0, 2.0, 3.0].into_iter());
        let solved = solve_transposed(&factor, &half);
        for (row, right) in matrix.iter().zip([1.0, 2.0, 3.0]) {
            assert!((dot(row, &solved) - right).abs() < 1e-12);
        }
        assert!(cholesky(2, |_, _| 1.0).is_none());
    }
}
