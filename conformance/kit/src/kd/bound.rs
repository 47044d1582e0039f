//! By how much an implementation may be off: running error analysis (Higham 2002, §3.3) of a triangle
//! test in f32, whatever the order of its sums.
//!
//! u = 2⁻²⁴ is the roundoff of f32. An operation is off by at most u times its result, and half the least
//! f32. Sums of three products may be made in three orders: a sum is charged 2u times the sum of the
//! absolute values of its terms, which over the two sums is no less than any order takes. A quotient may
//! be a product with a reciprocal: it is charged 2u. Where all terms are multiples of a power of two and
//! their absolute values add up to at most 2²⁴ times it, nothing is rounded in any order, and nothing is
//! charged: with small whole numbers an implementation has to be exact.

use saarcor_model::rays::Number;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Half the distance from 1 to the next f32.
const UNIT: f64 = <f32 as Number>::ROUNDOFF;
/// Numbers of so many units in a row are f32.
const INTEGERS: f64 = 1.0 / UNIT;
/// The least f32.
const LEAST: f64 = 2.0 * <f32 as Number>::UNDERFLOW;
/// Makes up for the roundings of numbers and bounds themselves, which are computed in f64: less than 2⁸
/// one after the other, each 2⁻⁵³, which is to 2⁻²⁴ as 2⁻²⁹.
const SLACK: f64 = 1.0 + 1.0 / (1 << 20) as f64;

/// A number without rounding, and by how much it may be off as computed.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// Without rounding. NaN where it is divided by what is exactly zero.
    pub value: f64,
    /// As computed, it is off by no more. Infinite where there is no bound.
    pub error: f64,
    /// Absolute values of the terms of the sum that it is, added up.
    terms: f64,
    /// The power of two that it is a multiple of, if it is exact: infinite for zero.
    grid: f64,
    /// It is a coordinate, and no result.
    input: bool,
}

impl Bounded {
    /// A result, of which `charged` is what it is rounded by at most.
    fn result(value: f64, terms: f64, grid: f64, inherited: f64, charged: f64) -> Self {
        let exact = inherited == 0.0 && grid >= LEAST && terms <= INTEGERS * grid;
        let error = if exact { 0.0 } else { (inherited + charged + LEAST / 2.0) * SLACK };
        // A result that is no f32 has no bound either.
        let bounded = error.is_finite() && value.abs() <= f64::from(f32::MAX);
        Self { value, error: if bounded { error } else { f64::INFINITY }, terms, grid, input: false }
    }

    /// What comes of a quotient by zero, whatever it is combined with.
    fn undefined(self, other: Self) -> Option<Self> {
        let undefined = self.is_undefined() || other.is_undefined();
        (undefined && self.error + other.error < f64::INFINITY).then_some(Self::UNDEFINED)
    }

    const UNDEFINED: Self = Self { value: f64::NAN, error: 0.0, terms: 0.0, grid: 0.0, input: false };

    /// A true number, which is reported at up to 1 ± 2u times itself, or off by the least f32 (KD-4).
    #[must_use]
    pub fn nearly(value: f64) -> Self {
        let error = (2.0 * UNIT * value.abs() + LEAST) * SLACK;
        // Beyond the greatest f32 there is no number to report.
        let bounded = value.abs() + error <= f64::from(f32::MAX);
        Self {
            value,
            error: if bounded { error } else { f64::INFINITY },
            terms: value.abs(),
            grid: 0.0,
            input: false,
        }
    }

    /// Whether it is zero in every implementation.
    fn is_exact_zero(self) -> bool {
        self.value == 0.0 && self.error == 0.0
    }

    /// Whether it is the quotient by what is exactly zero.
    #[must_use]
    pub fn is_undefined(self) -> bool {
        self.value.is_nan() && self.error == 0.0
    }

    /// Whether it is certainly less than `bound`.
    #[must_use]
    pub fn is_below(self, bound: f64) -> bool {
        self.value + self.error < bound
    }

    /// Whether it is certainly `bound` or more.
    #[must_use]
    pub fn is_at_least(self, bound: f64) -> bool {
        self.value - self.error >= bound
    }

    /// Whether an implementation may have computed `number`.
    #[must_use]
    pub fn allows(self, number: f32) -> bool {
        (f64::from(number) - self.value).abs() <= self.error || self.error.is_infinite()
    }
}

/// The greatest power of two that `value` is a multiple of.
fn grid_of(value: f32) -> f64 {
    if value == 0.0 {
        return f64::INFINITY;
    }
    let bits = value.to_bits();
    let (exponent, mantissa) = ((bits >> 23 & 0xFF).max(1), bits & 0x7F_FFFF);
    let significand = if bits >> 23 & 0xFF == 0 { mantissa } else { mantissa | 1 << 23 };
    LEAST * 2.0_f64.powi((exponent - 1 + significand.trailing_zeros()) as i32)
}

impl Add for Bounded {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        if let Some(undefined) = self.undefined(other) {
            return undefined;
        }
        let value = self.value + other.value;
        let (inherited, grid) = (self.error + other.error, self.grid.min(other.grid));
        // A difference of coordinates is no part of a longer sum: it is rounded once.
        if self.input && other.input {
            return Self::result(value, value.abs(), grid, inherited, UNIT * value.abs());
        }
        let terms = self.terms + other.terms;
        Self::result(value, terms, grid, inherited, 2.0 * UNIT * terms)
    }
}

impl Sub for Bounded {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Bounded {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if let Some(undefined) = self.undefined(other) {
            return undefined;
        }
        let finite = self.error + other.error < f64::INFINITY;
        if finite && (self.is_exact_zero() || other.is_exact_zero()) {
            return Self { input: false, ..Self::ZERO };
        }
        let value = self.value * other.value;
        let (a, b) = (self.value.abs(), other.value.abs());
        let inherited = match self.error + other.error {
            0.0 => 0.0,
            _ => a * other.error + b * self.error + self.error * other.error,
        };
        let size = value.abs() + inherited;
        // Of an inexact factor there is no grid, that is 0.
        let grid = if inherited == 0.0 { self.grid * other.grid } else { 0.0 };
        Self::result(value, size, grid, inherited, UNIT * size)
    }
}

impl Div for Bounded {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        if let Some(undefined) = self.undefined(other) {
            return undefined;
        }
        if other.is_exact_zero() {
            return Self::UNDEFINED;
        }
        let value = self.value / other.value;
        let least = other.value.abs() - other.error;
        if least <= 0.0 || least.is_nan() {
            return Self::result(value, 0.0, 0.0, f64::INFINITY, 0.0);
        }
        // |a/b - â/b̂| ≤ (Δa + |â/b̂| Δb) / |b̂ - Δb|.
        let inherited = (self.error + value.abs() * other.error) / least;
        // Only what is divided by a power of two keeps its grid.
        let power = other.error == 0.0 && other.value.abs() == other.grid;
        let grid = if power && inherited == 0.0 { self.grid / other.grid } else { 0.0 };
        let size = value.abs() + inherited;
        Self::result(value, size, grid, inherited, 2.0 * UNIT * size)
    }
}

impl Neg for Bounded {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl PartialEq for Bounded {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Bounded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl Number for Bounded {
    type Wide = Self;

    const ZERO: Self = Self { value: 0.0, error: 0.0, terms: 0.0, grid: f64::INFINITY, input: true };
    const ONE: Self = Self { value: 1.0, error: 0.0, terms: 1.0, grid: 1.0, input: true };
    const ROUNDOFF: f64 = UNIT;
    const UNDERFLOW: f64 = LEAST / 2.0;

    fn from_f32(value: f32) -> Self {
        let number = f64::from(value);
        Self { value: number, error: 0.0, terms: number.abs(), grid: grid_of(value), input: true }
    }

    fn from_wide(wide: Self) -> Self {
        wide
    }

    fn to_f64(self) -> f64 {
        self.value
    }

    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }

    fn sqrt(self) -> Self {
        // |√a - √â| ≤ Δa / √â, since √a + √â ≥ √â.
        let root = self.value.sqrt();
        Self::result(root, root, 0.0, self.error / root, UNIT * root)
    }

    fn is_finite(self) -> bool {
        self.value.is_finite()
    }

    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        (a.value * b.value).partial_cmp(&(c.value * d.value)).unwrap_or(Ordering::Equal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f32) -> Bounded {
        Bounded::from_f32(value)
    }

    #[test]
    fn grids_are_the_lowest_bits() {
        for (value, grid) in [(1.0, 1.0), (6.0, 2.0), (-0.75, 0.25), (f32::from_bits(6), 2.0 * LEAST)] {
            assert_eq!(grid_of(value), grid, "{value}");
        }
        assert_eq!(grid_of(f32::MIN_POSITIVE), f64::from(f32::MIN_POSITIVE));
        assert_eq!(grid_of(0.0), f64::INFINITY);
    }

    #[test]
    fn small_whole_numbers_are_exact() {
        let volume = number(3.0) * number(5.0) - number(7.0) * number(2.0) + number(-4.0) * number(0.5);
        assert_eq!((volume.value, volume.error), (-1.0, 0.0));
        let quotient = volume / number(8.0);
        assert_eq!((quotient.value, quotient.error), (-0.125, 0.0));
        assert!((volume / number(3.0)).error > 0.0);
        assert!((number(16_777_216.0) + number(1.0)).error >= 1.0);
    }

    #[test]
    fn quotients_by_zero_are_undefined_and_by_noise_unbounded() {
        let zero = number(2.0) - number(2.0);
        let undefined = Bounded::ONE / zero;
        assert!(undefined.is_undefined() && (number(3.0) * undefined).is_undefined());
        let noise = number(0.1) * number(0.3) - number(0.3) * number(0.1);
        let unbounded = Bounded::ONE / noise;
        assert!(!unbounded.is_undefined() && unbounded.allows(1.0) && unbounded.allows(-1e30));
    }

    /// Each order of the sums, and both quotients, of random volumes stay inside.
    #[test]
    fn bounds_hold_in_every_order() {
        let mut random = saarcor_random::Random::new(1);
        let mut value = || random.bits() as u16 as f32 / 3.0 - 10_000.0;
        for _ in 0..10_000 {
            let [a, b, c, d, e, f, g] = std::array::from_fn(|_| value());
            let sum = number(a) * number(b) + number(c) * number(d) + number(e) * number(f);
            let quotient = sum / number(g);
            let (p, q, r) = (a * b, c * d, e * f);
            for computed in [(p + q) + r, p + (q + r), (p + r) + q, e.mul_add(f, a.mul_add(b, q))] {
                assert!(sum.allows(computed), "{a} {b} {c} {d} {e} {f}");
                assert!(quotient.allows(computed / g) && quotient.allows(computed * (1.0 / g)));
            }
        }
    }
}
