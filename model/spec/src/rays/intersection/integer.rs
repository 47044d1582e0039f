//! Whole numbers of up to 1727 bits and a sign.
//!
//! In units of 2⁻¹⁴⁹, the least f32, every finite f32 is a whole number of at most 277 bits. So what the
//! adaptive test computes from coordinates by additions and multiplications is computed without rounding.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

/// Words of 64 bits: the greatest number that the adaptive test needs has 1675 bits.
const WORDS: usize = 27;

/// A whole number in two's complement, the lowest word first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Integer([u64; WORDS]);

impl Integer {
    const ZERO: Self = Self([0; WORDS]);

    /// `value` in units of 2⁻¹⁴⁹. `value` is finite.
    pub(super) fn from_f32(value: f32) -> Self {
        let (exponent, fraction) = (value.to_bits() >> 23 & 0xFF, value.to_bits() & 0x7F_FFFF);
        // Denormals have the exponent of the least normal number, and no hidden bit.
        let significand = if exponent == 0 { fraction } else { fraction | 1 << 23 };
        let shift = exponent.max(1) - 1;
        let bits = u128::from(significand) << (shift % 64);
        let mut magnitude = Self::ZERO;
        let word = (shift / 64) as usize;
        magnitude.0[word] = bits as u64;
        magnitude.0[word + 1] = (bits >> 64) as u64;
        if value < 0.0 { -magnitude } else { magnitude }
    }

    fn is_negative(&self) -> bool {
        self.0[WORDS - 1] >> 63 == 1
    }

    /// How the number compares to 0.
    pub(super) fn sign(&self) -> Ordering {
        if self.is_negative() {
            Ordering::Less
        } else if *self == Self::ZERO {
            Ordering::Equal
        } else {
            Ordering::Greater
        }
    }

    /// The nearest f64, of two the even one. The number has fewer than 1024 bits.
    pub(super) fn nearest(&self) -> f64 {
        if self.is_negative() {
            return -(-*self).nearest();
        }
        let Some(highest) = self.0.iter().rposition(|&word| word != 0) else { return 0.0 };
        let below = |by: usize| highest.checked_sub(by).map_or(0, |word| self.0[word]);
        let zeros = self.0[highest].leading_zeros();
        // The upper 65 bits or more; all bits below them count as one, which is enough to round by.
        let upper = (u128::from(below(0)) << 64 | u128::from(below(1))) << zeros;
        let rest = highest >= 2 && self.0[..highest - 1].iter().any(|&word| word != 0);
        let exponent = 64 * (highest as i32 - 1) - zeros as i32;
        (upper | u128::from(rest)) as f64 * 2.0_f64.powi(exponent)
    }
}

impl Add for Integer {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let mut carry = 0;
        Self(std::array::from_fn(|word| {
            let sum = u128::from(self.0[word]) + u128::from(other.0[word]) + carry;
            carry = sum >> 64;
            sum as u64
        }))
    }
}

impl Neg for Integer {
    type Output = Self;

    fn neg(self) -> Self {
        let mut one = Self::ZERO;
        one.0[0] = 1;
        Self(self.0.map(|word| !word)) + one
    }
}

impl Sub for Integer {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Integer {
    type Output = Self;

    /// Modulo 2¹⁷²⁸, as two's complement is: right for every product that there is room for.
    fn mul(self, other: Self) -> Self {
        let magnitude = if self.is_negative() { -self } else { self };
        let mut product = Self::ZERO;
        for (low, &a) in magnitude.0.iter().enumerate().filter(|(_, a)| **a != 0) {
            let mut carry = 0;
            for (word, &b) in product.0[low..].iter_mut().zip(&other.0) {
                let sum = u128::from(a) * u128::from(b) + u128::from(*word) + carry;
                *word = sum as u64;
                carry = sum >> 64;
            }
        }
        if self.is_negative() { -product } else { product }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_f32_is_a_whole_number() {
        let unit = f64::from(f32::from_bits(1));
        for value in [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 1.0, -1.5, 3.0e8, f32::MAX, f32::MIN] {
            assert_eq!(Integer::from_f32(value).nearest() * unit, f64::from(value), "{value:e}");
        }
    }

    #[test]
    fn sums_and_products_are_exact() {
        let [large, small] = [f32::MAX, f32::from_bits(1)].map(Integer::from_f32);
        assert_eq!(large + small - large, small);
        // (a + b)² - a² - b² = 2ab, of which the terms differ by 277 bits.
        let square = (large + small) * (large + small) - large * large - small * small;
        assert_eq!(square, large * small + small * large);
        assert_eq!((-large) * large, -(large * large));
        assert_eq!(((-large) * (-small)).sign(), Ordering::Greater);
        let sixth = large * large * large * large * large * large;
        assert_eq!((sixth.sign(), (-sixth).sign()), (Ordering::Greater, Ordering::Less));
        assert_eq!((sixth - sixth).sign(), Ordering::Equal);
    }

    #[test]
    fn rounding_is_to_nearest_even() {
        let power = |exponent: i32| Integer::from_f32(2.0_f32.powi(exponent - 149));
        let rounded = |number: Integer| number.nearest();
        let (large, half) = (2.0_f64.powi(100), power(47));
        assert_eq!(rounded(power(100) + half), large);
        assert_eq!(rounded(power(100) + half + power(0)), large + 2.0_f64.powi(48));
        assert_eq!(rounded(power(100) + power(48) + half), large + 2.0_f64.powi(49));
        assert_eq!(rounded(-(power(100) + half + power(0))), -large - 2.0_f64.powi(48));
    }
}
