//! Numbers that carry a bound of their own error: running error analysis (Higham 2002, §3.3).

use saarcor_model::rays::Number;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number of the format `N` as it was computed, and by how much it is off at most from what the
/// same operations give without rounding.
///
/// An operation's own error is at most the roundoff times its result, and half the least denormal.
#[derive(Clone, Copy, Debug)]
pub struct Bounded<N> {
    /// As computed.
    pub value: N,
    /// Its error is no larger. Infinite or NaN: no bound.
    pub error: f64,
}

/// The bounds themselves are computed in f64: this makes up for their roundings, which are fewer
/// than 2^10 one after the other.
const SLACK: f64 = 1.0 + 1024.0 * f64::EPSILON;

impl<N: Number> Bounded<N> {
    /// The result of an operation on numbers whose errors make it off by `error`.
    fn rounded(value: N, error: f64) -> Self {
        Self { value, error: (error + N::ROUNDOFF * value.to_f64().abs() + N::UNDERFLOW) * SLACK }
    }

    fn size(self) -> f64 {
        self.value.to_f64().abs()
    }
}

impl<N: Number> Add for Bounded<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error)
    }
}

impl<N: Number> Sub for Bounded<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::rounded(self.value - other.value, self.error + other.error)
    }
}

impl<N: Number> Mul for Bounded<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let error = self.size() * other.error + other.size() * self.error + self.error * other.error;
        Self::rounded(self.value * other.value, error)
    }
}

impl<N: Number> Div for Bounded<N> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        // |a/b - â/b̂| ≤ (Δa + |â/b̂| Δb) / |b|, and |b| ≥ |b̂| - Δb.
        let least = other.size() - other.error;
        let quotient = self.size() / other.size();
        let error = (self.error + quotient * other.error) / least;
        Self::rounded(self.value / other.value, if least > 0.0 { error } else { f64::INFINITY })
    }
}

impl<N: Number> Neg for Bounded<N> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl<N: Number> PartialEq for Bounded<N> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<N: Number> PartialOrd for Bounded<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<N: Number> Number for Bounded<N> {
    type Wide = Bounded<N::Wide>;

    const ZERO: Self = Self { value: N::ZERO, error: 0.0 };
    const ONE: Self = Self { value: N::ONE, error: 0.0 };
    const ROUNDOFF: f64 = N::ROUNDOFF;
    const UNDERFLOW: f64 = N::UNDERFLOW;

    fn from_f32(value: f32) -> Self {
        let rounded = N::from_f32(value);
        Self { value: rounded, error: (rounded.to_f64() - f64::from(value)).abs() }
    }

    fn from_wide(wide: Self::Wide) -> Self {
        let value = N::from_wide(wide.value);
        Self { value, error: (wide.error + (value.to_f64() - wide.value.to_f64()).abs()) * SLACK }
    }

    fn to_f64(self) -> f64 {
        self.value.to_f64()
    }

    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }

    fn sqrt(self) -> Self {
        // |√a - √â| ≤ Δa / √â, since √a + √â ≥ √â.
        let root = self.value.sqrt();
        Self::rounded(root, self.error / root.to_f64())
    }

    fn is_finite(self) -> bool {
        self.value.is_finite()
    }

    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        N::product_order(a.value, b.value, c.value, d.value)
    }
}
