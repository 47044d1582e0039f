//! The adaptive test: exact hits at the cost of a fast test.
//!
//! Twin of [`saarcor_model::rays::ExactHit`], and of the intersection unit around it: a test in f64
//! with a bound of its error (`triangle`) decides nearly all rays; where it leaves a doubt, volumes in
//! whole numbers of 128 bits do (`grid`), or in expansions of f64 (`volumes`, `expansion`).

pub mod bounds;
mod expansion;
mod grid;
mod triangle;
mod unit;
mod volumes;

pub use triangle::{AdaptiveHit, AdaptiveRay, AdaptiveTriangle};
pub use unit::FilteredIntersection;
