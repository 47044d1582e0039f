//! What holds of the SaarCOR model: a twin of `saarcor-model`, file for file.
//!
//! Each theorem is one plain function over a [`source::Source`] of values, judged by three engines:
//! Kani for all values (`cargo kani -p saarcor-proofs`), and those of [`engines`] for every value
//! of a small scope and for values at random. `README.md` beside this crate says what is proved,
//! what is assumed, and how to add a theorem.

mod draw;
#[cfg(not(kani))]
pub mod engines;
#[cfg(kani)]
mod kani_source;
pub mod source;
#[cfg(kani_stub)]
mod stub;

pub mod geometry;

/// All theorems, unit by unit, in the order of SPEC.md.
#[cfg(not(kani))]
pub fn theorems() -> impl Iterator<Item = &'static source::Theorem> {
    [geometry::THEOREMS].into_iter().flatten()
}
