//! Equality of the twins: each file of `saarcor-fast` has here the file of its name, whose theorems
//! say that the twin does what the specification does.
//!
//! A theorem draws a legal state of the specification and the twin's state that corresponds to it,
//! takes one step of both, and checks that the outcomes are the same and that the states correspond
//! again: a simulation relation. With the empty states, which correspond, it follows that every run
//! of the twin is a run of the specification. Where a step is not to be had alone (the chip between
//! events), theorems compare whole runs, of all programs of a counted small scope and of programs at
//! random; they say `not_for_kani` and why.

pub mod adaptive;
pub mod chip;
pub mod directory;
pub mod first_level;
pub mod pci;
pub mod sdram;
pub mod stacks;
pub mod traffic;
pub mod version_b;
