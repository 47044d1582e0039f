//! The chip in time: cycles worked out by hand, and what is conserved.

use saarcor_model::time::{
    ChipConfig, Operation, Programs, SdramConfig, TimingReport, UNIT_NAMES, Version, simulate,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};

fn cache(memory: u64, line: u64, ways: u32) -> CacheConfig {
    let geometry = Geometry::new(Bytes(memory), Bytes(line), ways).expect("legal");
    CacheConfig { geometry, hash: Hash::default(), policy: Policy::default() }
}

fn standard(version: Version) -> ChipConfig {
    ChipConfig::standard(version, cache(8 << 20, 128, 4))
}

fn operation(unit: Unit, addr: u32, bytes: u16, rays: u8) -> Operation {
    Operation { addr: HostAddr(addr), bytes, rays, unit }
}

/// Numbers that look random: Knuth's linear congruential generator (MMIX).
fn numbers(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |below| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    }
}

#[track_caller]
fn sums_hold(report: &TimingReport, config: &ChipConfig) {
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
fn scattered(packets: usize, reads: usize, unit: Unit, item: u32) -> Programs {
    let mut number = numbers(2);
    let mut read = || operation(unit, item * number((64 << 20) / u64::from(item)) as u32, item as u16, 1);
    let packet = |_| (0..reads).map(|_| read()).collect();
    Programs { packets: (0..packets).map(packet).collect(), triangles: HostAddr(0) }
}

fn programs(packets: &[&[Operation]]) -> Programs {
    Programs { packets: packets.iter().map(|packet| (*packet).into()).collect(), triangles: HostAddr(0) }
}

/// One thread of one pipeline: each operation takes its look-up, its bytes and its unit.
#[test]
fn one_packet_takes_the_sum_of_its_operations() {
    let program = [
        operation(Unit::Shading, 0, 0, 64),
        operation(Unit::Traversal, 0, 8, 64),
        operation(Unit::Traversal, 0, 8, 13),
        operation(Unit::List, 4096, 4, 13),
        operation(Unit::Intersection, 16 * 36, 36, 13),
    ];
    let quiet = SdramConfig { refresh_interval: 0, ..SdramConfig::STANDARD };
    for version in [Version::None, Version::A] {
        let config = ChipConfig { pipelines: 1, threads: 1, sdram: quiet, ..standard(version) };
        let report = simulate(&[], &programs(&[&program]), &config).expect("a chip");
        let [shading, traversal, list, intersection] = config.units.map(|unit| u64::from(unit.latency));
        let (hit, back) = (u64::from(config.l1[1].latency), u64::from(config.return_latency));
        let read = |cycle: u64, clocks: u64| cycle.next_multiple_of(4) + 4 * clocks + back;
        // A tag, a row opened in so many clocks, CL, and the beats. With virtual memory the line comes
        // over the bus first, and its 8 beats are written to the row in place of CL; without, the tag
        // takes a cycle all the same, as it is acted upon in the next.
        let fetch = |cycle: u64, opened: u64, beats: u64| match version {
            Version::None => read(cycle + 1, opened + 3 + beats),
            _ => read(cycle + 4 + 550, opened + 8 + beats),
        };
        let mut cycle = 64 + shading;
        // Without, the rows at 0 of bank 0 and at 4096 of bank 1, which the triangle finds open or not.
        // With, the sets 0, 32 and 4 of 512 bytes: rows 0, 4 and 0 of bank 0, each time another one.
        let opened = if version == Version::None { [3, 3, 0] } else { [3, 6, 6] };
        cycle = fetch(cycle, opened[0], 1) + 16 + traversal;
        cycle += hit + 4 + traversal;
        cycle = fetch(cycle, opened[1], 1) + 1 + list;
        cycle = fetch(cycle, opened[2], 3) + 13 + intersection;
        assert_eq!(report.cycles, cycle, "{version:?}");
        sums_hold(&report, &config);
    }
}

/// Each line that comes from the host is written to the card once, and nothing else changes.
#[test]
fn version_a_adds_what_it_loads() {
    let programs = scattered(32, 20, Unit::Intersection, 36);
    let reports =
        [Version::None, Version::A, Version::B].map(|version| simulate(&[], &programs, &standard(version)));
    let [none, a, b] = reports.map(|report| report.expect("a chip"));
    assert_eq!(a.l1_fill_bytes, none.l1_fill_bytes);
    assert_eq!(a.memory_bytes(), none.memory_bytes() + a.pci_bytes);
    assert_eq!((b.l2, b.pci_bytes), (a.l2, a.pci_bytes));
    assert!(b.metadata_read_bytes > 0 && b.cycles >= a.cycles);
}

#[test]
fn pictures_before_warm_the_caches() {
    let programs = scattered(8, 10, Unit::Traversal, 8);
    let config = standard(Version::A);
    let cold = simulate(&[], &programs, &config).expect("a chip");
    let warm = simulate(std::slice::from_ref(&programs), &programs, &config).expect("a chip");
    assert!(cold.pci_bytes > 0 && warm.cycles < cold.cycles);
    assert_eq!((warm.pci_bytes, warm.l1[1].misses), (0, 0));
}

#[test]
fn nothing_to_do_takes_no_time() {
    let config = standard(Version::B);
    assert_eq!(simulate(&[], &Programs::default(), &config), Ok(TimingReport::default()));
}

#[test]
fn chips_that_cannot_be_are_refused() {
    let refused = |change: &dyn Fn(&mut ChipConfig)| {
        let mut config = standard(Version::B);
        change(&mut config);
        config.check().expect_err("no chip").to_string()
    };
    let message = refused(&|config| config.l1[3].line = 256);
    assert_eq!(
        message,
        "line of a first-level cache of 256: it must be at most the line of the virtual memory, 128"
    );
    assert!(refused(&|config| config.threads = 0).starts_with("number of threads a pipeline of 0"));
    assert!(refused(&|config| config.pipelines = 65).contains("1 to 64"));
    assert!(refused(&|config| config.units[1].rays_a_cycle = 0).contains("at least 1"));
    assert!(refused(&|config| config.l1[0].sets = 3).contains("power of two"));
    assert!(refused(&|config| config.l1[0].latency = 0).contains("1 to 1024"));
    assert!(refused(&|config| config.sdram.refresh_interval = 12).contains("more than the 12"));
    assert!(refused(&|config| config.sdram.beat_bytes = 256).contains("at least a beat"));
    assert!(refused(&|config| config.metadata_cache.bytes = 48).contains("power of two"));
    assert!(refused(&|config| config.pci.beat_bytes = 0).contains("at least 1"));
    standard(Version::None).check().expect("a chip");
}
