//! The chip in time (§2 to §4).

mod config;
mod operation;
mod pci;
mod report;
mod sdram;
pub mod standard;

pub use config::*;
pub use operation::*;
pub use pci::*;
pub use report::*;
pub use sdram::*;
