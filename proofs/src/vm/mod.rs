//! Theorems of the virtual memory, in the order of SPEC.md.

pub mod data_set;
pub mod directory;
pub mod entry;
pub mod first_level;
pub mod geometry;
pub mod hash;
pub mod memory;
pub mod set;
pub mod version_b;
pub mod virtual_memory;
