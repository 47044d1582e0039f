//! IEEE 754 binary64.

use super::Format;
use saarcor_model::rays::Number;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An f64 as a number format of triangle tests.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Double(pub f64);

macro_rules! operations {
    ($($operation:ident :: $function:ident),*) => {$(
        impl $operation for Double {
            type Output = Self;

            #[inline]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

operations!(Add::add, Sub::sub, Mul::mul, Div::div);

impl Neg for Double {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Number for Double {
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    #[inline]
    fn from_f32(value: f32) -> Self {
        Self(f64::from(value))
    }

    #[inline]
    fn from_f64(value: f64) -> Self {
        Self(value)
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
        // Rounding keeps the order, so that only equal products hide one: then their errors decide,
        // which are f64 for a product that is neither tiny nor huge.
        let product = |a: f64, b: f64| (a * b, a.mul_add(b, -(a * b)));
        product(a.0, b.0).partial_cmp(&product(c.0, d.0)).unwrap_or(Ordering::Equal)
    }
}

impl Format for Double {
    const ROUNDOFF: f64 = f64::EPSILON / 2.0;
    /// Less than any f64; a bound computed with it is then at least the least denormal.
    const UNDERFLOW: f64 = f64::from_bits(1);
    const GREATEST: f64 = f64::MAX;

    #[inline]
    fn to_f64(self) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_products_are_ordered_by_their_errors() {
        let [above, below] = [1.0 + f64::EPSILON, 1.0 - f64::EPSILON].map(Double);
        // 1 - ε², which rounds to 1.
        assert_eq!(above * below, Double::ONE);
        assert_eq!(Double::product_order(above, below, Double::ONE, Double::ONE), Ordering::Less);
        assert_eq!(Double::product_order(above, below, below, above), Ordering::Equal);
    }
}
