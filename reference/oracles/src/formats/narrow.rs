//! Narrow floats of hardware.

use super::Format;
use saarcor_model::rays::Number;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A float of one sign bit, `EXPONENT` exponent bits and `MANTISSA` stored mantissa bits, as IEEE
/// 754 has them: a hidden leading bit, the exponent's bias 2^(EXPONENT - 1) - 1, denormals,
/// infinities and NaN.
///
/// An operation is done in f64 and its result rounded once more, to this format. That is the exact
/// result rounded once: for +, −, ×, ÷ and √ a result of p bits does not depend on a rounding to
/// q ≥ 2p + 2 bits before (Figueroa 1995), and f64 has q = 53, where the widest format here has
/// p = 17. It holds for denormals too: sums of numbers of the format are multiples of its least
/// denormal, products are exact in f64, and a quotient that is not half-way between two numbers of
/// at most p bits differs from that point by 2^−(2p + 1) of itself or more. The exponents of f64
/// hold every result: those here have 8 bits or fewer.
///
/// Overflow gives infinity, underflow a denormal or a zero with the sign of the result.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub struct Narrow<const EXPONENT: u32, const MANTISSA: u32>(f64);

/// 24 bits, 1-7-16: the format of SaarCOR's later prototype (Schmittler et al. 2004; that
/// it has denormals is Assumed, since the paper does not say).
pub type F24 = Narrow<7, 16>;

/// bfloat16, 1-8-7.
pub type Bf16 = Narrow<8, 7>;

/// IEEE 754 binary16, 1-5-10.
pub type F16 = Narrow<5, 10>;

/// 2^exponent, for exponents of normal f64.
const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

impl<const EXPONENT: u32, const MANTISSA: u32> Narrow<EXPONENT, MANTISSA> {
    const MAX_EXPONENT: i32 = (1 << (EXPONENT - 1)) - 1;

    /// The least normal number.
    pub const MIN_POSITIVE: f64 = power_of_two(1 - Self::MAX_EXPONENT);

    /// The greatest finite number.
    pub const MAX: f64 = power_of_two(Self::MAX_EXPONENT) * (2.0 - power_of_two(-(MANTISSA as i32)));

    /// The number of this format nearest to `value`, of two the even one.
    #[inline]
    #[must_use]
    pub fn round(value: f64) -> Self {
        const EXPONENT_BITS: u64 = 0x7FF << 52;
        if !value.is_finite() {
            return Self(value);
        }
        // The power of two below the value, and from it the distance of neighbouring numbers. The
        // sum with 1.5 · 2^52 such distances is a multiple of them, by f64's own rounding.
        let below = f64::from_bits(value.to_bits() & EXPONENT_BITS).max(Self::MIN_POSITIVE);
        let shift = below * const { 1.5 * power_of_two(52 - MANTISSA as i32) };
        let rounded = ((value + shift) - shift).copysign(value);
        Self(if rounded.abs() > Self::MAX { f64::INFINITY.copysign(value) } else { rounded })
    }

    /// The square root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self::round(self.0.sqrt())
    }
}

impl<const EXPONENT: u32, const MANTISSA: u32> fmt::Debug for Narrow<EXPONENT, MANTISSA> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

macro_rules! operations {
    ($($operation:ident :: $function:ident),*) => {$(
        impl<const EXPONENT: u32, const MANTISSA: u32> $operation for Narrow<EXPONENT, MANTISSA> {
            type Output = Self;

            #[inline]
            fn $function(self, other: Self) -> Self {
                Self::round(self.0.$function(other.0))
            }
        }
    )*};
}

operations!(Add::add, Sub::sub, Mul::mul, Div::div);

impl<const EXPONENT: u32, const MANTISSA: u32> Neg for Narrow<EXPONENT, MANTISSA> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<const EXPONENT: u32, const MANTISSA: u32> Number for Narrow<EXPONENT, MANTISSA> {
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    #[inline]
    fn from_f32(value: f32) -> Self {
        Self::round(f64::from(value))
    }

    #[inline]
    fn from_f64(value: f64) -> Self {
        Self::round(value)
    }

    #[inline]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline]
    fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    #[inline]
    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        // Two significands of 17 bits or fewer: f64 holds the products.
        (a.0 * b.0).partial_cmp(&(c.0 * d.0)).unwrap_or(Ordering::Equal)
    }
}

impl<const EXPONENT: u32, const MANTISSA: u32> Format for Narrow<EXPONENT, MANTISSA> {
    const ROUNDOFF: f64 = power_of_two(-(MANTISSA as i32) - 1);
    const UNDERFLOW: f64 = Self::MIN_POSITIVE * Self::ROUNDOFF;
    const GREATEST: f64 = Self::MAX;

    #[inline]
    fn to_f64(self) -> f64 {
        self.0
    }
}
