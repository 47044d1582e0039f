//! What the tests of the chip in time share, here and of its twin.

use saarcor_model::time::standard::POLICY;
use saarcor_model::time::{ChipConfig, Operation, Programs, TimingReport, UNIT_NAMES, Version};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Unit};

pub fn cache(memory: u64, line: u64, ways: u32) -> CacheConfig {
    let geometry = Geometry::new(Bytes(memory), Bytes(line), ways).expect("legal");
    CacheConfig { geometry, hash: Hash::default(), policy: POLICY }
}

pub fn standard(version: Version) -> ChipConfig {
    ChipConfig::standard(version, cache(8 << 20, 128, 4))
}

pub fn operation(unit: Unit, addr: u32, bytes: u16, rays: u8) -> Operation {
    Operation { addr: HostAddr(addr), bytes, rays, unit }
}

/// Numbers that look random: Knuth's linear congruential generator (MMIX).
pub fn numbers(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |below| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    }
}

#[track_caller]
pub fn sums_hold(report: &TimingReport, config: &ChipConfig) {
    for (unit, name) in report.units.iter().zip(UNIT_NAMES) {
        let all = unit.busy + unit.stalled() + unit.idle;
        assert_eq!(all, report.cycles * u64::from(config.pipelines), "{name}");
    }
    assert_eq!(report.pci_bytes, report.l2.misses * config.cache.geometry.line().0);
    if config.version == Version::None {
        assert_eq!(report.pci_bytes, 0);
    }
}

/// Packets of random reads all over 64 MB: nearly nothing is in a cache.
pub fn scattered(packets: usize, reads: usize, unit: Unit, item: u32) -> Programs {
    let mut number = numbers(2);
    let mut read = || operation(unit, item * number((64 << 20) / u64::from(item)) as u32, item as u16, 1);
    let packet = |_| (0..reads).map(|_| read()).collect();
    Programs { packets: (0..packets).map(packet).collect(), triangles: HostAddr(0) }
}
