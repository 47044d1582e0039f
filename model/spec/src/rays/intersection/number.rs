//! What a triangle test computes with: a number format, so that each test has one body for all. The
//! chip computes in f32 (IS-5).

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
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;

    /// The nearest number.
    fn from_f32(value: f32) -> Self;

    /// The nearest number.
    fn from_f64(value: f64) -> Self;

    /// Without the sign.
    fn abs(self) -> Self;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// How `a · b` compares to `c · d`, exactly. `Equal` where a number is NaN.
    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering;
}

impl Number for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    fn from_f32(value: f32) -> Self {
        value
    }

    fn from_f64(value: f64) -> Self {
        value as Self
    }

    fn abs(self) -> Self {
        Self::abs(self)
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        // Two significands of 24 bits make one of 48: f64 holds the products.
        let (left, right) = (f64::from(a) * f64::from(b), f64::from(c) * f64::from(d));
        left.partial_cmp(&right).unwrap_or(Ordering::Equal)
    }
}

/// Three coordinates or components.
pub type Triple<R> = [R; 3];

// What follows serves the whole numbers of the adaptive test, too, which are no `Number`.

/// `a - b`.
pub(super) fn sub<R: Copy + Sub<Output = R>>(a: Triple<R>, b: Triple<R>) -> Triple<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + b`.
pub(super) fn add<R: Copy + Add<Output = R>>(a: Triple<R>, b: Triple<R>) -> Triple<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a × b`.
pub(super) fn cross<R>(a: Triple<R>, b: Triple<R>) -> Triple<R>
where
    R: Copy + Sub<Output = R> + Mul<Output = R>,
{
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a · b`.
pub(super) fn dot<R: Copy + Add<Output = R> + Mul<Output = R>>(a: Triple<R>, b: Triple<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
