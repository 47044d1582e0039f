//! What a triangle test computes with: a number format, so that each test has one body for all.

use std::cmp::Ordering;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number format. Each operation rounds by itself, to the nearest number, of two to the even
/// one; overflow gives infinity, underflow a denormal or zero.
pub trait Number:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// What the driver computes with, once a triangle.
    type Wide: Number<Wide = Self::Wide>;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Bound of an operation's relative error, where it does not underflow: half the distance
    /// from 1 to the next number.
    const ROUNDOFF: f64;
    /// Bound of the absolute error of an operation that underflows: half the least denormal.
    const UNDERFLOW: f64;

    /// The nearest number.
    fn from_f32(value: f32) -> Self;

    /// The nearest number.
    fn from_wide(value: Self::Wide) -> Self;

    /// The number itself: all formats are parts of f64.
    fn to_f64(self) -> f64;

    /// Without the sign.
    #[must_use]
    fn abs(self) -> Self;

    /// The square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// How `a · b` compares to `c · d`, exactly. `Equal` where a number is NaN.
    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering;
}

impl Number for f32 {
    type Wide = f64;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;
    const UNDERFLOW: f64 = Self::from_bits(1) as f64 / 2.0;

    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn from_wide(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    #[inline(always)]
    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        // Two significands of 24 bits make one of 48: f64 holds the products.
        let (left, right) = (f64::from(a) * f64::from(b), f64::from(c) * f64::from(d));
        left.partial_cmp(&right).unwrap_or(Ordering::Equal)
    }
}

impl Number for f64 {
    type Wide = Self;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const ROUNDOFF: f64 = Self::EPSILON / 2.0;
    /// Less than any f64; the computed bound is then at least the least denormal.
    const UNDERFLOW: f64 = Self::from_bits(1);

    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        Self::from(value)
    }

    #[inline(always)]
    fn from_wide(value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    #[inline]
    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        // Rounding keeps the order, so that only equal products hide one: then their errors, which
        // are f64, tell it. A product that is neither tiny nor huge has such an error.
        let (left, right) = (super::expansion::two_product(a, b), super::expansion::two_product(c, d));
        left.partial_cmp(&right).unwrap_or(Ordering::Equal)
    }
}

/// Three coordinates or components.
pub type Triple<R> = [R; 3];

/// `a - b`.
#[inline(always)]
pub(super) fn sub<R: Number>(a: Triple<R>, b: Triple<R>) -> Triple<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + b`.
#[inline(always)]
pub(super) fn add<R: Number>(a: Triple<R>, b: Triple<R>) -> Triple<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a × b`.
#[inline(always)]
pub(super) fn cross<R: Number>(a: Triple<R>, b: Triple<R>) -> Triple<R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a · b`.
#[inline(always)]
pub(super) fn dot<R: Number>(a: Triple<R>, b: Triple<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The axis of the component of greatest magnitude, of several the first.
#[inline(always)]
pub(super) fn dominant_axis<R: Number>(vector: Triple<R>) -> usize {
    let [x, y, z] = vector.map(Number::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// The component along `axis`, by comparison: an index would keep a loop from being vectorised.
#[inline(always)]
pub(super) fn component<R: Number>(vector: Triple<R>, axis: usize) -> R {
    if axis == 0 {
        vector[0]
    } else if axis == 1 {
        vector[1]
    } else {
        vector[2]
    }
}
