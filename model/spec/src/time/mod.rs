//! The chip in time (§2 to §4).

mod chip;
mod config;
mod operation;
mod pci;
mod sdram;
pub mod standard;
mod tags;

pub use chip::*;
pub use config::*;
pub use operation::*;
pub use pci::*;
pub use sdram::*;
pub use tags::*;
