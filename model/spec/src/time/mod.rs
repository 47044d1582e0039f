//! The chip in time (§2 to §4): what a picture takes, in cycles and bytes.

mod chip;
mod config;
mod operation;
mod pci;
mod report;
mod sdram;
pub mod standard;

pub use chip::simulate;
pub use config::*;
pub use operation::*;
pub use pci::*;
pub use report::*;
pub use sdram::*;
