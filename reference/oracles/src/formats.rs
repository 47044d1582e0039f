//! Number formats in which a triangle test can be computed, beside the f32 of the chip (IS-5), and what
//! an error analysis needs to know of a format.

mod double;
mod narrow;

pub use double::Double;
pub use narrow::{Bf16, F16, F24, Narrow};

use saarcor_model::rays::Number;

/// A number format whose errors can be bounded. All its numbers are f64.
pub trait Format: Number {
    /// Bound of an operation's relative error, where it does not underflow: half the distance
    /// from 1 to the next number.
    const ROUNDOFF: f64;
    /// Bound of the absolute error of an operation that underflows: half the least denormal.
    const UNDERFLOW: f64;
    /// The greatest finite number.
    const GREATEST: f64;

    /// The number itself.
    fn to_f64(self) -> f64;
}

impl Format for f32 {
    const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;
    const UNDERFLOW: f64 = Self::from_bits(1) as f64 / 2.0;
    const GREATEST: f64 = Self::MAX as f64;

    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}
