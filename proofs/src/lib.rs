//! What holds of the SaarCOR model: a twin of `saarcor-model`, file for file.
//!
//! Each theorem is one plain function over a [`source::Source`] of values, judged by three engines:
//! Kani for all values (`cargo kani -p saarcor-proofs`), and those of [`engines`] for every value
//! of a small scope and for values at random. `README.md` beside this crate says what is proved,
//! what is assumed, and how to add a theorem.

// Kani does not look at what messages show.
#![cfg_attr(kani, allow(unused_variables))]
#![allow(clippy::needless_range_loop, reason = "Kani is fastest with loops over constant indices")]

mod draw;
#[cfg(not(kani))]
pub mod engines;
#[cfg(kani)]
#[cfg_attr(kani_stub, allow(dead_code))]
mod kani_source;
pub mod source;
#[cfg(kani_stub)]
#[allow(dead_code)]
mod stub;

pub mod data_set;
pub mod geometry;
pub mod hash;
pub mod kdtree;
pub mod l1;
pub mod metadata;
pub mod metadata_cache;
pub mod set;
pub mod traversal;
pub mod vm;

/// All theorems, unit by unit, in the order of SPEC.md.
#[cfg(not(kani))]
pub fn theorems() -> impl Iterator<Item = &'static source::Theorem> {
    [
        geometry::THEOREMS,
        metadata::THEOREMS,
        hash::THEOREMS,
        set::THEOREMS,
        vm::THEOREMS,
        data_set::THEOREMS,
        metadata_cache::THEOREMS,
        l1::THEOREMS,
        kdtree::THEOREMS,
        traversal::THEOREMS,
    ]
    .into_iter()
    .flatten()
}
