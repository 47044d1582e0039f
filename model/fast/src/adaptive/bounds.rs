//! The numbers of the bounds that the adaptive test's filter has of its errors.
//!
//! Twin of nothing: the specification rounds nothing. Each number has a certificate by Gappa in `proofs/certificates`, which names the
//! least one that is proved; why a number is larger than that stands here.

/// The roundoff of f64, u.
pub const UNIT: f64 = f64::EPSILON / 2.0;

/// In u: error of a component of the normal, of the component itself.
pub const NORMAL: f64 = 3.0;

/// In u²: error of a component of the normal where the edges are exact, of the sum of the two products without signs. One more than
/// is proved: a power of two takes no rounding.
pub const EXACT_EDGES: f64 = 4.0;

/// In u: the same where the edges are rounded. One more than is proved, for the same reason.
pub const ROUNDED_EDGES: f64 = 4.0;

/// ν up to which anything is certain.
pub const MOST_NU: f64 = 1.0 / 16.0;

/// In ν: error of a word, ε, beside [`ROUNDINGS`].
pub const WORDS: f64 = 2.5;

/// In u: what makes ε no less than three times three roundings.
pub const ROUNDINGS: f64 = 2.0;

/// In ε D: error of `across`.
pub const ACROSS: f64 = 2.9;

/// In ε S: error of the height.
pub const HEIGHT: f64 = 3.2;

/// In ε S D: error of a coordinate of the point.
pub const POINT: f64 = 7.9;

/// In L ε S D: error of a weight.
pub const WEIGHT: f64 = 32.0;

/// In L ε S D: error of the third weight, beside [`THIRD_ACROSS`].
pub const THIRD: f64 = 69.0;

/// In ε D: what `across` adds to that.
pub const THIRD_ACROSS: f64 = 3.6;

/// In L ε D (S + 1/(8 L)): the error of every weight, E, with the roundings of E itself.
pub const MARGIN: f64 = 70.0;

/// In ε (S + |t| D) / |across|: error of the distance.
pub const DISTANCE: f64 = 5.0;

/// In u: error of a quotient of two rounded numbers, of itself.
pub const QUOTIENT: f64 = 4.0;

/// In u: error of the slope of a weight, of the sum of its two products without signs.
pub const SLOPE: f64 = 4.0;
