//! By how much an implementation may be off: running error analysis (Higham 2002, §3.3) of a triangle
//! test in a number format, whatever the order of its sums.
//!
//! u is the roundoff of the format. An operation is off by at most u times its result, and half the least
//! number. Sums of three products may be made in three orders: a sum is charged 2u times the sum of the
//! absolute values of its terms, which over the two sums is no less than any order takes. A quotient may
//! be a product with a reciprocal: it is charged 2u. Where all terms are multiples of a power of two and
//! their absolute values add up to at most 1/u times it, nothing is rounded in any order, and nothing is
//! charged: with small whole numbers an implementation has to be exact.

use crate::formats::Format;
use saarcor_model::rays::Number;
use std::cmp::Ordering;
use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Makes up for the roundings of the bounds themselves, which are computed in f64: less than 2⁸ one after
/// the other, each 2⁻⁵³.
const SLACK: f64 = 1.0 + 1.0 / (1 << 20) as f64;

/// A number without rounding, and by how much it may be off as computed.
#[derive(Clone, Copy, Debug)]
pub struct Bounded<F = f32> {
    /// Without rounding, but for that of f64. NaN where it is divided by what is exactly zero.
    pub value: f64,
    /// As computed, it is off by no more. Infinite where there is no bound.
    pub error: f64,
    /// Absolute values of the terms of the sum that it is, added up.
    terms: f64,
    /// The power of two that it is a multiple of, if it is exact: infinite for zero.
    grid: f64,
    /// It is a coordinate, and no result.
    input: bool,
    format: PhantomData<F>,
}

impl<F: Format> Bounded<F> {
    /// Numbers of so many units in a row are numbers of the format.
    const INTEGERS: f64 = 1.0 / F::ROUNDOFF;
    /// The least number of the format.
    const LEAST: f64 = 2.0 * F::UNDERFLOW;
    /// By how much `value` may be off, over `error`.
    const OWN: f64 = f64::EPSILON / 2.0 / F::ROUNDOFF;

    /// A result, of which `charged` is what it is rounded by at most.
    fn result(value: f64, terms: f64, grid: f64, inherited: f64, charged: f64) -> Self {
        let exact = inherited == 0.0 && grid >= Self::LEAST && terms <= Self::INTEGERS * grid;
        let error = if exact { 0.0 } else { (inherited + charged + Self::LEAST / 2.0) * SLACK };
        // A result that is no number of the format has no bound either.
        let bounded = error.is_finite() && value.abs() <= F::GREATEST;
        Self {
            value,
            error: if bounded { error } else { f64::INFINITY },
            terms,
            grid,
            input: false,
            format: PhantomData,
        }
    }

    /// What comes of a quotient by zero, whatever it is combined with.
    fn undefined(self, other: Self) -> Option<Self> {
        let undefined = self.is_undefined() || other.is_undefined();
        (undefined && self.error + other.error < f64::INFINITY).then_some(Self::UNDEFINED)
    }

    const UNDEFINED: Self =
        Self { value: f64::NAN, error: 0.0, terms: 0.0, grid: 0.0, input: false, format: PhantomData };

    /// A true number, which is reported at up to 1 ± 2u times itself, or off by the least one (KD-4).
    #[must_use]
    pub fn nearly(value: f64) -> Self {
        let error = (2.0 * F::ROUNDOFF * value.abs() + Self::LEAST) * SLACK;
        // Beyond the greatest number there is none to report.
        let bounded = value.abs() + error <= F::GREATEST;
        Self {
            value,
            error: if bounded { error } else { f64::INFINITY },
            terms: value.abs(),
            grid: 0.0,
            input: false,
            format: PhantomData,
        }
    }

    /// A number that is known to `error`, rounded to the format.
    #[must_use]
    pub fn within(value: f64, error: f64) -> Self {
        let rounding = (F::from_f64(value).to_f64() - value).abs() + F::ROUNDOFF * error;
        Self {
            value,
            error: (error + rounding) * SLACK,
            terms: value.abs(),
            grid: 0.0,
            input: false,
            format: PhantomData,
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
    pub fn allows(self, number: F) -> bool {
        (number.to_f64() - self.value).abs() <= self.error || self.error.is_infinite()
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
    f64::from(f32::from_bits(1)) * 2.0_f64.powi((exponent - 1 + significand.trailing_zeros()) as i32)
}

impl<F: Format> Add for Bounded<F> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        if let Some(undefined) = self.undefined(other) {
            return undefined;
        }
        let value = self.value + other.value;
        let (inherited, grid) = (self.error + other.error, self.grid.min(other.grid));
        // A difference of coordinates is no part of a longer sum: it is rounded once.
        if self.input && other.input {
            let charged = F::ROUNDOFF * (value.abs() + inherited);
            return Self::result(value, value.abs(), grid, inherited, charged);
        }
        let terms = self.terms + other.terms;
        Self::result(value, terms, grid, inherited, 2.0 * F::ROUNDOFF * (terms + inherited))
    }
}

impl<F: Format> Sub for Bounded<F> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<F: Format> Mul for Bounded<F> {
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
            _ => a * other.error + b * self.error + (1.0 + 2.0 * Self::OWN) * self.error * other.error,
        };
        let size = value.abs() + inherited;
        // Of an inexact factor there is no grid, that is 0.
        let grid = if inherited == 0.0 { self.grid * other.grid } else { 0.0 };
        Self::result(value, size, grid, inherited, F::ROUNDOFF * size)
    }
}

impl<F: Format> Div for Bounded<F> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        if let Some(undefined) = self.undefined(other) {
            return undefined;
        }
        if other.is_exact_zero() {
            return Self::UNDEFINED;
        }
        let value = self.value / other.value;
        let least = other.value.abs() - (1.0 + Self::OWN) * other.error;
        if least <= 0.0 || least.is_nan() {
            return Self::result(value, 0.0, 0.0, f64::INFINITY, 0.0);
        }
        // |a/b - â/b̂| ≤ (Δa + |a/b| Δb) / |b̂|.
        let of_quotient = |quotient: f64| (self.error + quotient * other.error) / least;
        let inherited = of_quotient(value.abs() + Self::OWN * of_quotient(value.abs()));
        // Only what is divided by a power of two keeps its grid.
        let power = other.error == 0.0 && other.value.abs() == other.grid;
        let grid = if power && inherited == 0.0 { self.grid / other.grid } else { 0.0 };
        let size = value.abs() + inherited;
        Self::result(value, size, grid, inherited, 2.0 * F::ROUNDOFF * size)
    }
}

impl<F: Format> Neg for Bounded<F> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl<F: Format> PartialEq for Bounded<F> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<F: Format> PartialOrd for Bounded<F> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<F: Format> Number for Bounded<F> {
    const ZERO: Self =
        Self { value: 0.0, error: 0.0, terms: 0.0, grid: f64::INFINITY, input: true, format: PhantomData };
    const ONE: Self =
        Self { value: 1.0, error: 0.0, terms: 1.0, grid: 1.0, input: true, format: PhantomData };

    fn from_f32(value: f32) -> Self {
        let (number, error) = (f64::from(value), (F::from_f32(value).to_f64() - f64::from(value)).abs());
        let grid = if error == 0.0 { grid_of(value) } else { 0.0 };
        Self { value: number, error, terms: number.abs(), grid, input: true, format: PhantomData }
    }

    fn from_f64(value: f64) -> Self {
        Self::within(value, 0.0)
    }

    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
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

    const LEAST: f64 = 1.0 / (1_u128 << 127) as f64 / (1 << 22) as f64;

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
        let undefined = <Bounded>::ONE / zero;
        assert!(undefined.is_undefined() && (number(3.0) * undefined).is_undefined());
        let noise = number(0.1) * number(0.3) - number(0.3) * number(0.1);
        let unbounded = <Bounded>::ONE / noise;
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
