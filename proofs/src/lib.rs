//! What holds of the SaarCOR model: theorems, file by file as in `saarcor-model`, and in [`equal`]
//! the equality of each twin of `saarcor-fast` with its specification.
//!
//! Each theorem is one plain function over a [`source::Source`] of values, judged by three engines:
//! Kani for all values (`cargo kani -p saarcor-proofs`), and those of [`engines`] for every value
//! of a small scope and for values at random.
//!
//! ```
//! let theorem = saarcor_proofs::theorems().find(|theorem| theorem.name == "hit_iff_resident").unwrap();
//! assert_eq!((theorem.unit(), theorem.requirement), ("vm::set", "VM-6"));
//! let judgement = theorem.judge_at_random(1_000);
//! assert!(judgement.holds, "{:?}", judgement.counterexample);
//! ```
//!
//! `README.md` beside this crate says what is proved, what is assumed, and how to add a theorem.

// Kani does not look at what messages show.
#![cfg_attr(kani, allow(unused_variables))]
#![allow(clippy::needless_range_loop, reason = "Kani is fastest with loops over constant indices")]

#[cfg(not(kani))]
pub mod certificates;
mod draw;
#[cfg(not(kani))]
pub mod engines;
#[cfg(not(kani))]
pub mod evidence;
#[cfg(kani)]
#[cfg_attr(kani_stub, allow(dead_code))]
mod kani_source;
#[cfg(not(kani))]
pub mod lists;
#[cfg(any(not(kani), all(kani_stub, test)))]
mod scope;
pub mod source;
#[cfg(kani_stub)]
#[allow(dead_code)]
mod stub;
pub mod theorem;

pub mod equal;
pub mod host;
pub mod rays;
pub mod refinement;
pub mod time;
pub mod vm;

/// All theorems, unit by unit, in the order of SPEC.md, and then those of the twins.
#[cfg(any(not(kani), all(kani_stub, test)))]
pub fn theorems() -> impl Iterator<Item = &'static theorem::Theorem> {
    [
        vm::geometry::THEOREMS,
        vm::entry::THEOREMS,
        vm::hash::THEOREMS,
        vm::set::THEOREMS,
        vm::set::plru::THEOREMS,
        vm::set::wide::THEOREMS,
        vm::memory::THEOREMS,
        vm::directory::THEOREMS,
        vm::virtual_memory::THEOREMS,
        vm::data_set::THEOREMS,
        vm::version_b::THEOREMS,
        vm::version_b::places::THEOREMS,
        vm::first_level::THEOREMS,
        refinement::directory::THEOREMS,
        refinement::memory::THEOREMS,
        refinement::first_level::THEOREMS,
        host::features::THEOREMS,
        host::node::THEOREMS,
        host::list::THEOREMS,
        host::triangle::THEOREMS,
        host::records::THEOREMS,
        host::texture::THEOREMS,
        host::tree::THEOREMS,
        host::layout::THEOREMS,
        rays::ray::THEOREMS,
        rays::camera::THEOREMS,
        rays::interval::THEOREMS,
        rays::traversal::THEOREMS,
        rays::intersection::THEOREMS,
        rays::edges::THEOREMS,
        rays::texel::THEOREMS,
        rays::shading::THEOREMS,
        time::operation::THEOREMS,
        time::config::THEOREMS,
        time::sdram::THEOREMS,
        time::pci::THEOREMS,
        time::loads::THEOREMS,
        time::report::THEOREMS,
        time::chip::THEOREMS,
        time::chip::turn::THEOREMS,
        time::chip::thread::THEOREMS,
        time::chip::first_level::THEOREMS,
        time::chip::stalls::THEOREMS,
        equal::directory::THEOREMS,
        equal::version_b::THEOREMS,
        equal::first_level::THEOREMS,
        equal::stacks::THEOREMS,
        equal::traffic::THEOREMS,
        equal::adaptive::THEOREMS,
        equal::sdram::THEOREMS,
        equal::pci::THEOREMS,
        equal::chip::THEOREMS,
    ]
    .into_iter()
    .flatten()
}
