//! What had to be written otherwise to be fast: each module is the twin of one of `saarcor-model`, and
//! `saarcor-proofs` shows that one step of it gives what the specification's step gives, and leaves
//! corresponding states.

pub mod chip;
pub mod directory;
pub mod first_level;
pub mod pci;
pub mod sdram;
pub mod version_b;
