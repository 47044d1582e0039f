//! Every number that the timing of the chip depends on, and which of them make a chip.

use super::pci::PciConfig;
use super::sdram::SdramConfig;
use super::standard::{self, CHIP_CACHE_WAYS};
use crate::vm::{CacheConfig, ENTRY_BYTES};

/// Where the scene and its metadata lie (§3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Version {
    /// No virtual memory: the whole scene lies in on-board memory.
    None,
    /// The metadata of all lines lies on the chip.
    A,
    /// The metadata lies in the on-board memory, behind a cache on the chip.
    B,
}

/// A type of functional unit; each pipeline has one of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitConfig {
    /// Rays that a unit takes in a cycle.
    pub rays_a_cycle: u32,
    /// Cycles from the last ray in to the last result out; the next packet can follow meanwhile.
    pub latency: u32,
}

impl UnitConfig {
    /// Cycles in which the rays of an operation go in (CH-6).
    pub fn cycles(&self, rays: u32) -> u32 {
        rays.div_ceil(self.rays_a_cycle).max(1)
    }
}

/// A first-level cache, of 4 ways (§2, Stated) and LRU, indexed by the lower bits of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct L1Config {
    /// Bytes of a line.
    pub line: u32,
    /// Sets, a power of two.
    pub sets: u32,
    /// Look-ups a cycle.
    pub ports: u32,
    /// Cycles from the look-up to the bytes of a line that is there.
    pub latency: u32,
    /// Lines that can be in flight at a time (miss status holding registers).
    pub mshrs: u32,
}

/// The metadata cache of version B, of 4 ways and LRU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MetadataCacheConfig {
    /// Bytes that it holds.
    pub bytes: u32,
    /// Bytes that are read and written back together.
    pub granule: u32,
}

impl MetadataCacheConfig {
    /// Its sets.
    pub fn sets(&self) -> u32 {
        self.bytes / self.granule / CHIP_CACHE_WAYS as u32
    }
}

/// A chip with its memories and its bus. Times are in core cycles, if nothing else is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChipConfig {
    /// Core clock in Hz.
    pub core_hz: u64,
    /// Ray tracing pipelines.
    pub pipelines: u32,
    /// Threads a pipeline: packets in flight.
    pub threads: u32,
    /// The units, in the order of [`Unit::ALL`](crate::vm::Unit::ALL): shading, traversal,
    /// list, intersection.
    pub units: [UnitConfig; 4],
    /// Their first-level caches, in the same order.
    pub l1: [L1Config; 4],
    /// From the bus manager's look-up to the tag's answer, in versions A and B.
    pub tag_latency: u32,
    /// From the last beat of a first-level line to its arrival at the unit.
    pub return_latency: u32,
    /// Where the scene and its metadata lie.
    pub version: Version,
    /// The on-board memory as a cache; without meaning in version [`Version::None`].
    pub cache: CacheConfig,
    /// The metadata cache of version B.
    pub metadata_cache: MetadataCacheConfig,
    /// The on-board memory.
    pub sdram: SdramConfig,
    /// The bus to the host.
    pub pci: PciConfig,
}

/// A chip that cannot be. Names the number, what it is, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} of {value}: it must be {right}")]
pub struct ConfigError {
    /// What was wrong.
    pub field: &'static str,
    /// Its value.
    pub value: u64,
    /// What would be right.
    pub right: String,
}

/// Longest latency of a unit or a first-level cache, in cycles (Assumed; the model's own limit).
pub const MAX_LATENCY: u32 = 1024;
/// Most pipelines, threads a pipeline, ports and lines in flight (Assumed; the model's own limit).
pub const MAX_COUNT: u32 = 64;
/// Names of the units, in the order of [`Unit::ALL`](crate::vm::Unit::ALL).
pub const UNIT_NAMES: [&str; 4] = ["shading", "traversal", "list", "intersection"];

impl ChipConfig {
    /// The paper's chip (§4) with this virtual memory and the slow bus, by the numbers of [`standard`].
    pub fn standard(version: Version, cache: CacheConfig) -> Self {
        let unit = |unit: usize| UnitConfig {
            rays_a_cycle: standard::RAYS_A_CYCLE[unit],
            latency: standard::UNIT_LATENCY[unit],
        };
        let l1 = |unit: usize| L1Config {
            line: standard::FIRST_LEVEL_LINE[unit],
            sets: standard::first_level_sets(unit),
            ports: standard::FIRST_LEVEL_PORTS,
            latency: standard::FIRST_LEVEL_LATENCY,
            mshrs: standard::FIRST_LEVEL_MSHRS,
        };
        let (bytes, granule) = (standard::METADATA_CACHE_BYTES, standard::GRANULE);
        Self {
            core_hz: standard::CORE_HZ,
            pipelines: standard::PIPELINES,
            threads: standard::THREADS,
            units: [0, 1, 2, 3].map(unit),
            l1: [0, 1, 2, 3].map(l1),
            tag_latency: standard::TAG_LATENCY,
            return_latency: standard::RETURN_LATENCY,
            version,
            cache,
            metadata_cache: MetadataCacheConfig { bytes, granule },
            sdram: SdramConfig::STANDARD,
            pci: PciConfig::BITS_32_AT_33_MHZ,
        }
    }

    /// Bytes of a first-level cache.
    pub fn l1_bytes(&self, unit: usize) -> u64 {
        u64::from(self.l1[unit].line) * u64::from(self.l1[unit].sets) * CHIP_CACHE_WAYS as u64
    }

    /// Frames a second of pictures that take `cycles`.
    pub fn fps(&self, cycles: u64) -> f64 {
        self.core_hz as f64 / cycles as f64
    }

    /// Whether these numbers make a chip.
    ///
    /// # Errors
    /// The first number that does not.
    pub fn check(&self) -> Result<(), ConfigError> {
        let count = |field, value: u32| within(field, value, 1, MAX_COUNT);
        count("number of pipelines", self.pipelines)?;
        count("number of threads a pipeline", self.threads)?;
        at_least_one("core clock", self.core_hz)?;
        for unit in self.units {
            at_least_one("rays a cycle of a unit", unit.rays_a_cycle.into())?;
            within("latency of a unit", unit.latency, 0, MAX_LATENCY)?;
        }
        let line = self.cache.geometry.line().0;
        for l1 in self.l1 {
            at_least_one("line of a first-level cache", l1.line.into())?;
            let fits = self.version == Version::None || u64::from(l1.line) <= line;
            demand(fits, "line of a first-level cache", l1.line.into(), || {
                format!("at most the line of the virtual memory, {line}")
            })?;
            within("line of a first-level cache", l1.line, 1, 1 << 16)?;
            power_of_two("number of sets of a first-level cache", l1.sets, 1, 1 << 24)?;
            count("number of ports of a first-level cache", l1.ports)?;
            count("number of MSHRs of a first-level cache", l1.mshrs)?;
            within("latency of a first-level cache", l1.latency, 1, MAX_LATENCY)?;
        }
        self.check_memories()
    }

    fn check_memories(&self) -> Result<(), ConfigError> {
        let sdram = self.sdram;
        at_least_one("core cycles a memory clock", sdram.cycles_a_clock.into())?;
        power_of_two("beat of the on-board memory", sdram.beat_bytes, 1, 1 << 12)?;
        power_of_two("number of banks", sdram.banks, 1, 1 << 12)?;
        power_of_two("row of the on-board memory", sdram.row_bytes, sdram.beat_bytes, 1 << 24)?;
        // Each command takes a clock, however short the time that follows.
        let busy = sdram.precharge.max(1).saturating_add(sdram.refresh.max(1));
        let rests = sdram.refresh_interval == 0 || sdram.refresh_interval > busy;
        demand(rests, "clocks between refreshes", sdram.refresh_interval.into(), || {
            format!("0 for never, or more than the {busy} that a refresh takes")
        })?;
        at_least_one("beat of the bus", self.pci.beat_bytes.into())?;
        at_least_one("cycles a beat of the bus", self.pci.cycles_a_beat.into())?;
        if self.version == Version::None {
            return Ok(());
        }
        let line = self.cache.geometry.line().0;
        demand(line >= u64::from(sdram.beat_bytes), "line of the virtual memory", line, || {
            format!("at least a beat of the on-board memory, {}", sdram.beat_bytes)
        })?;
        if self.version == Version::B {
            let MetadataCacheConfig { bytes, granule } = self.metadata_cache;
            power_of_two("granule of the metadata cache", granule, ENTRY_BYTES as u32, 1 << 12)?;
            power_of_two("size of the metadata cache", bytes, granule * CHIP_CACHE_WAYS as u32, 1 << 26)?;
        }
        Ok(())
    }
}

/// The error that says what is `right`, unless the number `holds`.
fn demand(
    holds: bool,
    field: &'static str,
    value: u64,
    right: impl FnOnce() -> String,
) -> Result<(), ConfigError> {
    if holds { Ok(()) } else { Err(ConfigError { field, value, right: right() }) }
}

fn within(field: &'static str, value: u32, least: u32, most: u32) -> Result<(), ConfigError> {
    demand((least..=most).contains(&value), field, value.into(), || format!("{least} to {most}"))
}

fn at_least_one(field: &'static str, value: u64) -> Result<(), ConfigError> {
    demand(value > 0, field, value, || "at least 1".to_owned())
}

fn power_of_two(field: &'static str, value: u32, least: u32, most: u32) -> Result<(), ConfigError> {
    let holds = value.is_power_of_two() && (least..=most).contains(&value);
    demand(holds, field, value.into(), || format!("a power of two, {least} to {most}"))
}
