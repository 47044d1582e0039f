//! Theorems of the chip in time: its programs, its numbers, its loads, its memory chips and its bus.

pub mod chip;
pub mod config;
pub mod loads;
pub mod operation;
pub mod pci;
pub mod report;
pub mod sdram;
