//! The twin of the chip in time that goes from event to event: `saarcor_fast::chip`.
//!
//! Whole runs, since the two have no steps in common: the specification goes cycle by cycle. The
//! exhaustive engine takes all programs of two packets, of three and of two operations, out of seven
//! operations whose lines collide in tiny caches, in the three versions, on one pipeline of two threads
//! and on two pipelines of one: over 100 000 runs. All that is counted is compared: cycles, what each
//! unit did in them, what each cache found, and bytes. `tests/equal_chip.rs` goes on with larger chips,
//! and `reference/studies/tests/equal_chip.rs` with the packets of a picture.

use super::sdram::{pick, sdram};
use crate::source::Source;
use crate::{check_eq, cover, theorems};
use saarcor_model::time::{
    ChipConfig, L1Config, MetadataCacheConfig, Operation, PciConfig, Program, Programs, UnitConfig, Version,
    simulate,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};

/// An operation as a number.
const fn code(unit: u32, addr: u32, bytes: u32, rays: u32) -> u32 {
    unit | rays << 2 | bytes << 5 | addr << 10
}

/// Operations that collide: in first-level caches of four lines of 4 bytes, and in sets of two lines of
/// 8 bytes, of which there are four.
pub(crate) const OPERATIONS: [u32; 7] = [
    code(0, 0, 0, 3),
    code(1, 0, 8, 2),
    code(1, 20, 8, 1),
    code(1, 8, 4, 0),
    code(3, 64, 8, 4),
    code(3, 128, 8, 1),
    code(3, 16, 12, 2),
];

pub(crate) fn operation(s: &mut impl Source, small: &'static [u32]) -> Operation {
    let code = s.value("operation", 0..=u32::MAX >> 13, small);
    let (bytes, rays) = (code >> 5 & 31, code >> 2 & 7);
    Operation {
        addr: HostAddr(code >> 10),
        bytes: bytes as u16,
        // Work on no bytes is for some rays.
        rays: if bytes == 0 { rays.max(1) } else { rays } as u8,
        unit: Unit::ALL[(code & 3) as usize],
    }
}

/// The chip of a number; those of 0 and 1 are tiny, of one pipeline and of two.
pub(crate) fn chip(mut code: u64, version: Version) -> ChipConfig {
    let code = &mut code;
    let (pipelines, threads) = pick(code, &[(1, 2), (2, 1), (2, 2)]);
    let (ways, set_bits) = pick(code, &[(2, 2), (1, 3), (4, 0)]);
    let geometry =
        Geometry::new(Bytes((8 * ways) << set_bits), Bytes(8), ways as u32).expect("powers of two");
    let hash = pick(code, &[Hash::Low, Hash::AddUpper, Hash::AddUpperAll]);
    let policy = pick(code, &[Policy::Lru, Policy::Fifo, Policy::Plru]);
    let l1 = L1Config {
        line: pick(code, &[4, 8, 6]),
        sets: pick(code, &[1, 2]),
        ports: pick(code, &[1, 2]),
        latency: pick(code, &[1, 3]),
        mshrs: pick(code, &[1, 2]),
    };
    let granule = pick(code, &[8, 16]);
    ChipConfig {
        pipelines,
        threads,
        units: [UnitConfig { rays_a_cycle: pick(code, &[2, 1]), latency: pick(code, &[1, 0, 3]) }; 4],
        l1: [l1; 4],
        tag_latency: pick(code, &[2, 0, 1]),
        return_latency: pick(code, &[1, 0, 2]),
        metadata_cache: MetadataCacheConfig { bytes: 4 * granule * pick(code, &[1, 2]), granule },
        pci: PciConfig { setup: pick(code, &[1, 5]), beat_bytes: 4, cycles_a_beat: pick(code, &[1, 3]) },
        sdram: sdram(code),
        ..ChipConfig::standard(version, CacheConfig { geometry, hash, policy })
    }
}

theorems! {
    /// The chip between events takes as many cycles as the one that goes cycle by cycle, and counts the same.
    #["CH-5", not_for_kani "whole runs of hundreds of cycles, over queues", covers ["a line from the host", "metadata written back", "a line in flight that another thread asks for", "a wait for a register", "a wait for the port"]]
    fn fast_chip_takes_the_same_time(s) {
        let version = match s.value("version (none, A, B)", 0..=2_u8, &[0, 1, 2]) {
            0 => Version::None,
            1 => Version::A,
            _ => Version::B,
        };
        let config = chip(s.value("chip", 0..=u64::MAX, &[0, 1]), version);
        let packet = |operations: &[Operation]| Program::from(operations);
        let before = operation(s, &OPERATIONS[..1]);
        let first = [operation(s, &OPERATIONS), operation(s, &OPERATIONS), operation(s, &OPERATIONS)];
        let second = [operation(s, &OPERATIONS), operation(s, &OPERATIONS)];
        let programs = Programs { packets: vec![packet(&first), packet(&second)], triangles: HostAddr(0) };
        let before = [Programs { packets: vec![packet(&[before])], triangles: HostAddr(0) }];
        let expected = simulate(&before, &programs, &config);
        if let Ok(report) = &expected {
            cover!(s, "a line from the host", report.pci_bytes > 0);
            cover!(s, "metadata written back", report.metadata_write_back_bytes > 0);
            cover!(s, "a line in flight that another thread asks for", report.l1[1].merged > 0);
            cover!(s, "a wait for a register", report.units.iter().any(|unit| unit.stalls[2] > 0));
            cover!(s, "a wait for the port", report.units.iter().any(|unit| unit.stalls[1] > 0));
        }
        let got = saarcor_fast::chip::simulate(&before, &programs, &config);
        check_eq!(got, expected, "{programs:?} after {before:?} on {config:?}");
    }
}
