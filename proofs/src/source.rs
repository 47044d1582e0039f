//! Where a theorem's values come from: one body, several engines.
//!
//! A theorem is a plain function over a [`Source`]. It draws arbitrary values, assumes what it is
//! about, and checks what it claims. Kani draws symbols, each of which stands for all values; the
//! exhaustive engine draws the values of a small scope one after another, the random engine draws
//! values at random.

use std::fmt::Display;
use std::ops::RangeInclusive;

/// Why a body ended before its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The values drawn are none that the theorem speaks of.
    Vacuous,
    /// What the theorem claims does not hold: what was expected, and what was got.
    Disproved(String),
}

/// How a body ends.
pub type Holds = Result<(), Stop>;

/// A type of values that can be drawn.
pub trait Value: Copy + PartialOrd + Display + Into<u64> + Sized {
    /// Any value, for Kani.
    #[cfg(kani)]
    fn any() -> Self;
    /// The value `distance` above `from`; in range where it is asked for.
    fn above(from: Self, distance: u64) -> Self;
}

macro_rules! values {
    ($($t:ty),*) => {$(
        impl Value for $t {
            #[cfg(kani)]
            fn any() -> Self {
                #[cfg(kani_stub)]
                use crate::stub as kani;
                kani::any()
            }
            fn above(from: Self, distance: u64) -> Self {
                from.wrapping_add(distance as $t)
            }
        }
    )*};
}

values!(u8, u16, u32, u64);

/// Where values come from.
pub trait Source {
    /// Any value of `full`. The exhaustive engine draws each of `small`, which are some of it.
    fn value<T: Value>(&mut self, name: &'static str, full: RangeInclusive<T>, small: &'static [T]) -> T;

    /// Notes a size that the body's types have, as the ways of a set: part of the scope that is shown.
    fn size(&mut self, _name: &'static str, _value: usize) {}

    /// Notes that a case of interest was reached, so that no theorem holds for want of cases.
    fn cover(&mut self, label: Label, reached: bool);
}

/// A label of a case of interest.
#[derive(Clone, Copy, Debug)]
pub struct Label {
    /// As a person reads it.
    pub text: &'static str,
    /// As Kani compares it, without a loop over letters.
    id: u64,
}

impl Label {
    /// The label of that text.
    #[must_use]
    pub const fn new(text: &'static str) -> Self {
        // FNV-1a.
        let (mut id, mut i) = (0xcbf2_9ce4_8422_2325_u64, 0);
        while i < text.len() {
            id = (id ^ text.as_bytes()[i] as u64).wrapping_mul(0x0100_0000_01b3);
            i += 1;
        }
        Self { text, id }
    }

    /// Whether both are the same.
    #[must_use]
    pub const fn is(self, other: Self) -> bool {
        self.id == other.id
    }
}

/// The theorem speaks only of values for which this holds.
#[macro_export]
macro_rules! assume {
    ($holds:expr) => {
        let holds: bool = $holds;
        #[cfg(all(kani, not(kani_stub)))]
        ::kani::assume(holds);
        #[cfg(any(not(kani), kani_stub))]
        if !holds {
            return Err($crate::source::Stop::Vacuous);
        }
    };
}

/// The theorem claims that this holds; the rest describes the case for a person.
#[macro_export]
macro_rules! check {
    ($holds:expr, $($case:tt)+) => {
        let holds: bool = $holds;
        #[cfg(kani)]
        assert!(holds, "the theorem's claim");
        #[cfg(not(kani))]
        if !holds {
            return Err($crate::source::Stop::Disproved(format!($($case)+)));
        }
    };
}

/// The theorem claims that both are equal.
#[macro_export]
macro_rules! check_eq {
    ($got:expr, $expected:expr, $($case:tt)+) => {
        let (got, expected) = (&$got, &$expected);
        $crate::check!(got == expected, "{}: expected {:?}, got {:?}", format_args!($($case)+), expected, got);
    };
}

/// A value that only messages show: Kani, which shows none, does not make it.
#[macro_export]
macro_rules! shown {
    ($value:expr) => {{
        #[cfg(kani)]
        {}
        #[cfg(not(kani))]
        {
            $value
        }
    }};
}

/// A case of interest, which an engine has to reach.
#[macro_export]
macro_rules! cover {
    ($source:expr, $label:literal, $reached:expr) => {
        $source.cover(const { $crate::source::Label::new($label) }, $reached);
    };
}
