//! The virtual memory of §3.

mod data_set;
mod entry;
mod first_level;
mod geometry;
mod hash;
mod memory;
mod set;
mod units;
mod version_b;
mod virtual_memory;

pub use data_set::*;
pub use entry::*;
pub use first_level::*;
pub use geometry::*;
pub use hash::*;
pub use memory::*;
pub use set::*;
pub use units::*;
pub use version_b::*;
pub use virtual_memory::*;
