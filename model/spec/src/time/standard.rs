//! Every number that the paper states or that the standard configuration assumes, once.
//!
//! Arrays of four hold a value for each type of unit, in the order of [`Unit::ALL`](crate::vm::Unit::ALL):
//! shading, traversal, list, intersection.

use crate::host::{LIST_ENTRY_BYTES, NODE_BYTES, TRIANGLE_BYTES};
use crate::vm::{Bytes, FIRST_LEVEL_WAYS, Policy};

// The chip.

/// Core clock in Hz (§4, Stated).
pub const CORE_HZ: u64 = 533_000_000;
/// Ray tracing pipelines (§4, Stated).
pub const PIPELINES: u32 = 4;
/// Threads a pipeline, each with one packet (§4, Stated).
pub const THREADS: u32 = 16;
/// Rays that a unit takes in a cycle (CH-2, Assumed; 4 and 1 after SaarCOR 2002).
pub const RAYS_A_CYCLE: [u32; 4] = [1, 4, 64, 1];
/// Latencies of the units in cycles (CH-3, Assumed).
pub const UNIT_LATENCY: [u32; 4] = [16, 8, 2, 16];
/// From the bus manager's look-up to the tag, in cycles (CH-3, Assumed).
pub const TAG_LATENCY: u32 = 4;
/// From the last beat of a first-level line to its arrival, in cycles (CH-3, Assumed).
pub const RETURN_LATENCY: u32 = 4;

// The first-level caches and the metadata cache.

/// Ways of each first-level cache (§2, Stated) and of the metadata cache (§4, Stated).
pub const CHIP_CACHE_WAYS: usize = FIRST_LEVEL_WAYS;
/// Bytes of the first-level caches (§4, Stated).
pub const FIRST_LEVEL_BYTES: [u32; 4] = [64 << 10, 64 << 10, 64 << 10, 144 << 10];
/// Bytes of the triangle cache with which the Cruiser was measured (§4, Stated).
pub const CRUISER_TRIANGLE_CACHE_BYTES: u32 = 576 << 10;
/// Bytes of a first-level line: one item (§4, Stated); for shading data Assumed.
pub const FIRST_LEVEL_LINE: [u32; 4] = [64, NODE_BYTES, LIST_ENTRY_BYTES, TRIANGLE_BYTES];
/// Look-ups a cycle of a first-level cache (CH-3, Assumed).
pub const FIRST_LEVEL_PORTS: u32 = 1;
/// Cycles from a look-up to the bytes of a resident line (CH-3, Assumed).
pub const FIRST_LEVEL_LATENCY: u32 = 2;
/// Lines that may be in flight to a first-level cache at a time (CH-3, Assumed).
pub const FIRST_LEVEL_MSHRS: u32 = 16;
/// Bytes of version B's metadata cache (§4, Stated).
pub const METADATA_CACHE_BYTES: u32 = 64 << 10;
/// Bytes of metadata that are read and written back together (CH-17, Assumed: a set of 4 ways takes 20 bytes).
pub const GRANULE: u32 = 32;

/// Sets of the first-level cache of a unit (Derived).
pub const fn first_level_sets(unit: usize) -> u32 {
    FIRST_LEVEL_BYTES[unit] / FIRST_LEVEL_LINE[unit] / CHIP_CACHE_WAYS as u32
}

// The virtual memory.

/// Bytes of a line, found best (§3, Stated).
pub const LINE: Bytes = Bytes(128);
/// Lines a set, found to work well (§3, Stated).
pub const WAYS: u32 = 4;
/// Which line of a full set is evicted (VM-6, Assumed: §3 has "several bits for managing purposes" and names no
/// policy). By FIFO a hit changes no metadata, so that version B writes none back for it.
pub const POLICY: Policy = Policy::Fifo;
/// On-board memory of a scene that is none of the paper's: the least that Table 2 uses (Assumed).
pub const MEMORY: Bytes = Bytes(8 << 20);
/// On-board memory by family of scenes (Table 2's caption, Stated).
pub const MEMORY_OF: [(&str, Bytes); 4] = [
    ("pQuake3", Bytes(8 << 20)),
    ("Sodahall", Bytes(8 << 20)),
    ("Conference", Bytes(32 << 20)),
    ("Cruiser", Bytes(64 << 20)),
];

// The on-board memory chips. Times are in memory clocks.

/// Memory clock in Hz (§4, Stated): a quarter of the core's.
pub const SDRAM_HZ: u64 = 133_000_000;
/// Width of the memory bus in bits (§4, Stated).
pub const SDRAM_BUS_BITS: u32 = 128;
/// Banks (SD-2, Assumed).
pub const BANKS: u32 = 4;
/// Bytes of a row of a bank (SD-2, Assumed).
pub const ROW_BYTES: u32 = 4 << 10;
/// From a read command to its first beat, CL (SD-3, Assumed: PC133).
pub const CAS: u32 = 3;
/// From the opening of a row to the first command, tRCD (SD-3, Assumed: PC133).
pub const RAS_TO_CAS: u32 = 3;
/// To close a row, tRP (SD-3, Assumed: PC133).
pub const PRECHARGE: u32 = 3;
/// From the opening of a row to its closing, tRAS (SD-3, Assumed: PC133).
pub const ROW_ACTIVE: u32 = 6;
/// From one opening in a bank to the next, tRC (SD-3, Assumed: PC133).
pub const ROW_CYCLE: u32 = 9;
/// From one opening to the next in any bank, tRRD (SD-3, Assumed: PC133).
pub const ROW_TO_ROW: u32 = 2;
/// From the last beat of a write to the closing of its row, tWR (SD-3, Assumed: PC133).
pub const WRITE_RECOVERY: u32 = 2;
/// Clocks between two refreshes (SD-5, Assumed: 15.6 µs).
pub const REFRESH_INTERVAL: u32 = 2083;
/// From a refresh to the next opening or refresh, tRFC (SD-5, Assumed).
pub const REFRESH: u32 = 9;

// The buses to the host.

/// Width of the bus to the host in bits (§4, Stated).
pub const PCI_BUS_BITS: u32 = 32;
/// Its clock in Hz (§4, Stated).
pub const PCI_HZ: u64 = 33_000_000;
/// Core cycles in which it loads a line of 128 bytes: "about 550" (§4, Stated).
pub const PCI_LINE_CYCLES: u32 = 550;
/// Width of the fast bus in bits (§4, Stated).
pub const FAST_PCI_BUS_BITS: u32 = 64;
/// Clock of the fast bus in Hz (§4, Stated).
pub const FAST_PCI_HZ: u64 = 66_000_000;

// The picture.

/// Pixels a row and rows (Assumed: the paper names none).
pub const RESOLUTION: (u32, u32) = (1024, 768);
/// Rays of a packet (RG-2; packets: §2, Stated; 64: Assumed, after SaarCOR 2002).
pub const PACKET_RAYS: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::{PciConfig, SdramConfig};

    /// §4 prints the sum of the first-level caches as 336 KB, and the Cruiser's triangle cache as four
    /// times the standard one.
    #[test]
    fn first_level_caches_sum_up() {
        assert_eq!(FIRST_LEVEL_BYTES.iter().sum::<u32>(), 336 << 10);
        assert_eq!(CRUISER_TRIANGLE_CACHE_BYTES, 4 * FIRST_LEVEL_BYTES[3]);
        assert_eq!([0, 1, 2, 3].map(first_level_sets), [256, 2048, 4096, 1024]);
    }

    #[test]
    fn sizes_of_memories_are_the_stated_and_the_assumed_ones() {
        let (kilobyte, megabyte) = (1024, 1_048_576);
        assert_eq!(MEMORY, Bytes(8 * megabyte));
        let of_families = MEMORY_OF.map(|(family, memory)| (family, memory.0 / megabyte));
        assert_eq!(of_families, [("pQuake3", 8), ("Sodahall", 8), ("Conference", 32), ("Cruiser", 64)]);
        assert_eq!((METADATA_CACHE_BYTES, ROW_BYTES), (64 * kilobyte, 4 * kilobyte));
    }

    /// §4 prints the bandwidth of the on-board memory as 2 GB/s.
    #[test]
    fn memory_bandwidth_is_the_printed_one() {
        assert_eq!(u64::from(SDRAM_BUS_BITS / 8) * SDRAM_HZ / 1_000_000_000, 2);
    }

    #[test]
    fn clocks_divide_the_core_clock() {
        assert_eq!((SdramConfig::STANDARD.cycles_a_clock, SdramConfig::STANDARD.beat_bytes), (4, 16));
        let slow = PciConfig { setup: 38, beat_bytes: 4, cycles_a_beat: 16 };
        assert_eq!(PciConfig::BITS_32_AT_33_MHZ, slow);
        assert_eq!(PciConfig::BITS_64_AT_66_MHZ, PciConfig { setup: 38, beat_bytes: 8, cycles_a_beat: 8 });
    }
}
