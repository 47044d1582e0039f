//! Exact sums and products of f64, as expansions (Shewchuk 1997).
//!
//! Twin of the whole numbers of [`saarcor_model::rays::ExactHit`].
//!
//! An expansion is the sum of its terms, which do not overlap: each is at most half of the last
//! bit of the next larger one. So a number that is a multiple of 2^a and less than 2^b has at most
//! (b - a) / 53 + 1 terms. All numbers here come from f32 by at most six multiplications: they are
//! multiples of 2⁻⁸⁹⁴ = (2⁻¹⁴⁹)⁶ and less than 2⁷⁹⁰ (of three factors: multiples of 2⁻⁴⁴⁷ and less
//! than 2³⁹⁰), so that nothing overflows or underflows, nor does the error of any operation.

use std::cmp::Ordering;

/// Room for a number of three factors: it has up to (390 + 447) / 53 + 1 = 16 terms, and twice that
/// before it is renormalised.
pub(super) const THREE_FACTORS: usize = 32;

/// Room for a number of six factors: it has up to (790 + 894) / 53 + 1 = 32 terms, and twice that
/// before it is renormalised.
pub(super) const SIX_FACTORS: usize = 64;

/// `a + b` rounded, and the error of that: their sum is exact (Knuth 1969).
#[inline(always)]
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

/// [`two_sum`] where `a` is not less than `b` in magnitude (Dekker 1971).
#[inline(always)]
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// The upper 26 bits and the rest (Veltkamp 1968).
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    // 2^27 + 1: half of the 53 bits, rounded up.
    let shifted = 134_217_729.0 * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

/// `a · b` rounded, and the error of that: their sum is exact (Dekker 1971).
#[inline(always)]
pub(super) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
    (product, error)
}

/// A number without rounding, with room for `ROOM` terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion<const ROOM: usize> {
    /// The least first.
    terms: [f64; ROOM],
    len: usize,
}

impl<const ROOM: usize> Expansion<ROOM> {
    const ZERO: Self = Self { terms: [0.0; ROOM], len: 0 };

    /// The number `a - b`.
    pub(super) fn difference(a: f64, b: f64) -> Self {
        let mut out = Self::ZERO;
        let (difference, error) = two_sum(a, -b);
        out.push(error);
        out.push(difference);
        out
    }

    /// Appends a term that is larger than all others, unless it is 0.
    #[inline(always)]
    fn push(&mut self, term: f64) {
        if term != 0.0 {
            self.terms[self.len] = term;
            self.len += 1;
        }
    }

    fn terms(&self) -> &[f64] {
        &self.terms[..self.len]
    }

    /// Adds one f64, of any magnitude. Terms stay free of overlap, but may leave gaps.
    #[inline]
    fn add_term(&mut self, term: f64) {
        let (mut sum, len) = (term, self.len);
        self.len = 0;
        for at in 0..len {
            let error;
            (sum, error) = two_sum(sum, self.terms[at]);
            self.push(error);
        }
        self.push(sum);
    }

    /// Adds the product of two f64.
    fn add_product(&mut self, a: f64, b: f64) {
        let (product, error) = two_product(a, b);
        self.add_term(error);
        self.add_term(product);
    }

    /// Leaves the same number in the fewest terms.
    fn renormalise(&mut self) {
        if self.len < 2 {
            return;
        }
        // Downwards, each term takes up what it can of those below; the rests are in order.
        let last = self.len - 1;
        let (mut sum, mut bottom) = (self.terms[last], last);
        for at in (0..last).rev() {
            let (upper, rest) = fast_two_sum(sum, self.terms[at]);
            sum = upper;
            if rest != 0.0 {
                (self.terms[bottom], sum) = (upper, rest);
                bottom -= 1;
            }
        }
        self.terms[bottom] = sum;
        // Upwards, what was left is taken up from below.
        self.len = 0;
        for at in bottom + 1..=last {
            let (upper, rest) = fast_two_sum(self.terms[at], sum);
            self.push(rest);
            sum = upper;
        }
        self.push(sum);
    }

    /// The number and `other` added.
    pub(super) fn plus(mut self, other: &Self) -> Self {
        other.terms().iter().for_each(|&term| self.add_term(term));
        self.renormalise();
        self
    }

    /// `other` taken away from the number.
    pub(super) fn minus(mut self, other: &Self) -> Self {
        other.terms().iter().for_each(|&term| self.add_term(-term));
        self.renormalise();
        self
    }

    /// The number times an f64.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let mut out = Self::ZERO;
        self.terms().iter().for_each(|&term| out.add_product(term, factor));
        out.renormalise();
        out
    }

    /// The number times `other`, where there is room for it.
    pub(super) fn times<const MORE: usize>(&self, other: &Self) -> Expansion<MORE> {
        let mut out = Expansion::ZERO;
        for &factor in other.terms() {
            self.terms().iter().for_each(|&term| out.add_product(term, factor));
            out.renormalise();
        }
        out
    }

    /// How the number compares to 0: its largest term decides.
    pub(super) fn sign(&self) -> Ordering {
        self.nearest().partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }

    /// The f64 nearest to the number: the largest term, of which the rest is at most half a bit.
    pub(super) fn nearest(&self) -> f64 {
        self.terms().last().copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f32) -> Expansion<SIX_FACTORS> {
        Expansion::difference(f64::from(value), 0.0)
    }

    #[test]
    fn what_f64_drops_is_kept() {
        let tiny = f64::from(f32::from_bits(1));
        let sum = Expansion::<SIX_FACTORS>::difference(1.0, -tiny);
        assert_eq!(sum.nearest(), 1.0);
        assert_eq!(sum.minus(&number(1.0)).nearest(), tiny);
        assert_eq!(sum.minus(&sum).sign(), Ordering::Equal);
        // (1 + e)² - 1 - 2e = e²
        let square =
            sum.times::<SIX_FACTORS>(&sum).minus(&number(1.0)).minus(&Expansion::difference(tiny, -tiny));
        assert_eq!(square.nearest(), tiny * tiny);
    }

    #[test]
    fn six_factors_of_any_magnitude_have_room() {
        // A sum of the least and the greatest number and of all powers of two between them that
        // a term of its own needs.
        let mut wide = number(0.0);
        for exponent in (-149..128).step_by(24) {
            wide = wide.plus(&number(2.0_f32.powi(exponent) * 1.999_999));
        }
        let cube: Expansion<SIX_FACTORS> = wide.times::<SIX_FACTORS>(&wide).times(&wide);
        let sixth: Expansion<SIX_FACTORS> = cube.times(&cube);
        assert!(cube.len <= THREE_FACTORS / 2 && sixth.len <= SIX_FACTORS / 2);
        assert!(sixth.nearest().is_finite());
        let turned: Expansion<SIX_FACTORS> =
            wide.times::<SIX_FACTORS>(&cube).times::<SIX_FACTORS>(&wide).times(&wide);
        assert_eq!(sixth.minus(&turned).sign(), Ordering::Equal);
    }

    #[test]
    fn products_are_exact() {
        let (a, b) = (1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        // 1 - ε², which rounds to 1.
        assert_eq!(two_product(a, b), (1.0, -f64::EPSILON * f64::EPSILON));
    }
}
