//! The chip in time (§2 to §4): what a picture takes, in cycles and bytes. In reading order:
//!
//! 1. `operation`: what a packet does, as the functional run records it (CH-1);
//! 2. [`standard`], `config`: the numbers of the standard chip, and which numbers make a chip (CH-2, CH-3);
//! 3. `sdram`, `pci`: the memory chips and the bus to the host (SD-1 to SD-5, PC-1);
//! 4. `report`: what a run counts (CH-18);
//! 5. `chip`: the eight phases of a cycle (CH-4 to CH-20).

mod chip;
mod config;
mod operation;
mod pci;
mod report;
mod sdram;
pub mod standard;

pub use chip::{
    Answer, CardAccess, Chip, FirstLevelInTime, FunctionalUnit, LineInFlight, LinePart, Load, LoadId, Loads,
    PlacedPart, State, Thread, Turn, simulate,
};
pub use config::{
    ChipConfig, ConfigError, L1Config, MAX_COUNT, MAX_LATENCY, MetadataCacheConfig, UNIT_NAMES, UnitConfig,
    Version,
};
pub use operation::{Operation, Program, Programs, Recorder};
pub use pci::{Pci, PciConfig};
pub use report::{CacheReport, Stall, TimingReport, UnitReport};
pub use sdram::{Bank, Burst, Command, Direction, Job, Sdram, SdramConfig, Span, TransferId};
