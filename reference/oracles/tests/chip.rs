//! The chip in time: closed forms, ceilings, and the model against the naive stepping of the same
//! rules.

use proptest::prelude::*;
use saarcor_fast::chip::{
    Cache, Caches, ChipObserver, Found, Traffic, simulate, simulate_observed, simulate_part,
};
use saarcor_fast::sdram::Span;
use saarcor_model::time::{
    CacheReport, ChipConfig, L1Config, MetadataCacheConfig, Operation, PciConfig, Program, Programs,
    SdramConfig, TimingReport, UNIT_NAMES, UnitConfig, Version,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};
use saarcor_oracles::chip::naive_simulate;

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

fn programs(packets: &[&[Operation]]) -> Programs {
    Programs { packets: packets.iter().map(|packet| (*packet).into()).collect(), triangles: HostAddr(0) }
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
        assert_eq!(report, naive_simulate(&[], &programs(&[&program]), &config));
    }
}

/// Packets whose bytes are in the first-level caches after a moment: the busiest unit decides.
#[test]
fn unlimited_memory_leaves_the_busiest_unit() {
    let mut number = numbers(1);
    let mut packets = Vec::new();
    for _ in 0..4000 {
        let steps = (0..40).flat_map(|_| {
            let rays = 33 + number(32) as u8;
            let node = operation(Unit::Traversal, 8 * number(64) as u32, 8, rays);
            let triangle = operation(Unit::Intersection, 36 * number(64) as u32, 36, rays / 5);
            [node, triangle]
        });
        packets.push(steps.collect::<Program>());
    }
    let programs = Programs { packets, triangles: HostAddr(0) };
    let config = standard(Version::A);
    let report = simulate(&[], &programs, &config).expect("a chip");
    let work = report.units.map(|unit| unit.busy).into_iter().max().expect("four units");
    let least = work / u64::from(config.pipelines);
    assert!(
        (least..least + least / 50).contains(&report.cycles),
        "{} cycles, {least} of work",
        report.cycles
    );
    sums_hold(&report, &config);
}

/// Every transfer, in the order of its bus.
#[derive(Default)]
struct Transfers {
    pci: Vec<(Span, u64)>,
    memory: Vec<(Span, u64)>,
}

impl ChipObserver for Transfers {
    fn transfer(&mut self, _: u32, traffic: Traffic, span: Span, bytes: u64) {
        let bus = if traffic == Traffic::Pci { &mut self.pci } else { &mut self.memory };
        bus.push((span, bytes));
    }
}

/// Bytes of the busiest window of so many cycles: one that begins with a transfer, or ends with
/// one. A transfer's bytes move evenly from its begin to its end.
fn busiest(transfers: &[(Span, u64)], window: u64) -> f64 {
    let within = |from: u64, to: u64| {
        let first = transfers.partition_point(|(span, _)| span.end <= from);
        let met = transfers[first..].iter().take_while(|(span, _)| span.begin < to);
        let part = |(span, bytes): &(Span, u64)| {
            let overlap = span.end.min(to) - span.begin.max(from);
            *bytes as f64 * overlap as f64 / (span.end - span.begin) as f64
        };
        met.map(part).sum::<f64>()
    };
    let windows = transfers.iter().flat_map(|(span, _)| {
        [within(span.begin, span.begin + window), within(span.end.saturating_sub(window), span.end)]
    });
    windows.fold(0.0, f64::max)
}

/// Packets of random reads all over 64 MB: nearly nothing is in a cache.
fn scattered(packets: usize, reads: usize, unit: Unit, item: u32) -> Programs {
    let mut number = numbers(2);
    let mut read = || operation(unit, item * number((64 << 20) / u64::from(item)) as u32, item as u16, 1);
    let packet = |_| (0..reads).map(|_| read()).collect();
    Programs { packets: (0..packets).map(packet).collect(), triangles: HostAddr(0) }
}

#[test]
fn no_window_exceeds_a_bus() {
    let programs = scattered(64, 40, Unit::Intersection, 36);
    for (version, pci, pci_peak) in [
        (Version::A, PciConfig::BITS_32_AT_33_MHZ, 124.1e6),
        (Version::B, PciConfig::BITS_64_AT_66_MHZ, 411.0e6),
        (Version::None, PciConfig::BITS_32_AT_33_MHZ, 1.0),
    ] {
        let config = ChipConfig { pci, ..standard(version) };
        let mut transfers = Transfers::default();
        let report = simulate_observed(&[], &programs, &config, &mut transfers).expect("a chip");
        let rate = |bytes: f64, cycles: f64| bytes / cycles * config.core_hz as f64;
        assert!(rate(busiest(&transfers.pci, 10_000), 10_000.0) < pci_peak, "{version:?}");
        assert!(rate(busiest(&transfers.memory, 10_000), 10_000.0) <= 2.133e9, "{version:?}");
        let moved = |transfers: &[(Span, u64)]| transfers.iter().map(|transfer| transfer.1).sum::<u64>();
        assert_eq!(moved(&transfers.pci), report.pci_bytes);
        assert_eq!(moved(&transfers.memory), report.memory_bytes());
        // A miss of almost every access: the bus to the host is what limits.
        if version == Version::A {
            assert!(rate(report.pci_bytes as f64, report.cycles as f64) > 0.98 * 124.0e6);
        }
        sums_hold(&report, &config);
    }
}

/// What packets are told to do, summed up.
#[derive(Default)]
struct Sums {
    l1: [CacheReport; 4],
    l2: CacheReport,
    bytes: u64,
    begun: Vec<u32>,
}

impl ChipObserver for Sums {
    fn transfer(&mut self, _: u32, traffic: Traffic, _: Span, bytes: u64) {
        self.bytes += if traffic == Traffic::Pci { 0 } else { bytes };
    }

    fn look_up(&mut self, _: u32, cache: Cache, found: Found) {
        let report = match cache {
            Cache::L1(unit) => &mut self.l1[unit],
            Cache::L2 => &mut self.l2,
        };
        report.accesses += 1;
        report.merged += u64::from(found == Found::InFlight);
        report.misses += u64::from(found == Found::Missing);
    }

    fn begin(&mut self, packet: u32, _: u64) {
        self.begun.push(packet);
    }
}

#[test]
fn what_packets_do_adds_up_to_the_report() {
    let programs = scattered(90, 40, Unit::Intersection, 36);
    for version in [Version::None, Version::A, Version::B] {
        let config = standard(version);
        let mut sums = Sums::default();
        let report = simulate_observed(&[], &programs, &config, &mut sums).expect("a chip");
        assert_eq!((sums.l1, sums.l2), (report.l1, report.l2));
        assert_eq!(sums.bytes, report.memory_bytes());
        assert_eq!(sums.begun, (0..90).collect::<Vec<_>>());
    }
}

fn empty(config: &ChipConfig) -> Caches {
    Caches::after(&[], HostAddr(0), config).expect("a chip")
}

#[test]
fn packets_out_of_time_only_warm_the_caches() {
    let programs = scattered(90, 40, Unit::Intersection, 36);
    for version in [Version::None, Version::A, Version::B] {
        let config = standard(version);
        let run = |in_time: &[bool]| {
            let mut sums = Sums::default();
            let report = simulate_part(empty(&config), &programs, in_time, &mut sums);
            (report, sums.begun)
        };
        let last_50: Vec<_> = (0..90).map(|packet| packet >= 40).collect();
        let part = |packets: std::ops::Range<usize>| Programs {
            packets: programs.packets[packets].to_vec(),
            triangles: programs.triangles,
        };
        let (begin, end) = (part(0..40), part(40..90));
        let (report, begun) = run(&last_50);
        assert_eq!(report, simulate(&[begin], &end, &config).expect("a chip"));
        assert_eq!(begun, (40..90).collect::<Vec<_>>());
        assert_eq!(run(&[false; 90]), (TimingReport::default(), Vec::new()));
    }
}

/// With one thread the order of look-ups is that of the packets, in time or not; then only what is on
/// its way differs, of which a single thread has nothing.
#[test]
fn look_ups_without_time_are_those_of_one_thread() {
    let programs = scattered(20, 40, Unit::Intersection, 36);
    for version in [Version::None, Version::A, Version::B] {
        let config = ChipConfig { pipelines: 1, threads: 1, ..standard(version) };
        let mut sums = Sums::default();
        let _ = simulate_part(empty(&config), &programs, &[false; 20], &mut sums);
        let report = simulate(&[], &programs, &config).expect("a chip");
        assert_eq!(sums.l1, report.l1);
        assert_eq!(
            (sums.l2.accesses, sums.l2.misses),
            (report.l2.accesses, report.l2.misses + report.l2.merged)
        );
        assert_eq!(sums.bytes + report.vm_fill_bytes, report.memory_bytes());
    }
}

/// The whole chip without virtual memory meets the plateau of its memory chips.
#[test]
fn random_triangles_saturate_the_memory() {
    let config = standard(Version::None);
    let report = simulate(&[], &scattered(500, 100, Unit::Intersection, 36), &config).expect("a chip");
    let part = (report.memory_bytes() / 4) as f64 / report.cycles as f64;
    assert!((0.55..0.75).contains(&part), "{part} of the peak");
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

fn any_operation() -> impl Strategy<Value = Operation> {
    let unit = prop::sample::select(Unit::ALL.to_vec());
    // Few places, so that packets meet at lines, and some far ones.
    let addr = prop_oneof![4 => 0_u32..600, 1 => 0_u32..20_000];
    (unit, addr, 0_u16..60, 0_u8..70).prop_map(|(unit, addr, bytes, rays)| {
        // Work on no bytes is for some rays.
        operation(unit, addr, bytes, if bytes == 0 { rays.max(1) } else { rays })
    })
}

fn any_programs() -> impl Strategy<Value = Programs> {
    let packet = prop::collection::vec(any_operation(), 0..12).prop_map(Program::from);
    let triangles = prop::sample::select(vec![0, 20]);
    (prop::collection::vec(packet, 0..12), triangles)
        .prop_map(|(packets, base)| Programs { packets, triangles: HostAddr(base) })
}

prop_compose! {
    fn any_l1()(
        line in prop::sample::select(vec![4, 8, 16, 12]),
        sets in prop::sample::select(vec![1, 2, 8]),
        ports in 1_u32..3,
        latency in 1_u32..4,
        mshrs in 1_u32..5,
    ) -> L1Config {
        L1Config { line, sets, ports, latency, mshrs }
    }
}

prop_compose! {
    fn any_sdram()(
        cycles_a_clock in 1_u32..5,
        beat_bytes in prop::sample::select(vec![4, 8, 16]),
        banks in prop::sample::select(vec![1, 2, 4]),
        row_bytes in prop::sample::select(vec![16, 64, 256]),
        cas in 0_u32..4,
        ras_to_cas in 0_u32..4,
        precharge in 0_u32..4,
        row_cycle in 0_u32..12,
        write_recovery in 0_u32..3,
        (refresh_interval, refresh) in prop_oneof![Just((0, 0)), (30_u32..90, 1_u32..9)],
    ) -> SdramConfig {
        SdramConfig {
            cycles_a_clock, beat_bytes, banks, row_bytes, cas, ras_to_cas, precharge, row_cycle,
            write_recovery, refresh_interval, refresh,
        }
    }
}

prop_compose! {
    fn any_cache()(
        line_bits in 4_u32..7,
        way_bits in 0_u32..3,
        set_bits in 0_u32..4,
        hash in prop::sample::select(vec![Hash::Low, Hash::AddUpper, Hash::AddUpperAll]),
        policy in prop::sample::select(vec![Policy::Lru, Policy::Fifo, Policy::Plru]),
    ) -> CacheConfig {
        let geometry = Geometry::new(Bytes(1 << (line_bits + way_bits + set_bits)), Bytes(1 << line_bits), 1 << way_bits);
        CacheConfig { geometry: geometry.expect("legal"), hash, policy }
    }
}

prop_compose! {
    fn any_chip()(
        (pipelines, threads) in (1_u32..4, 1_u32..5),
        units in prop::array::uniform4((1_u32..9, 0_u32..5)),
        l1 in prop::array::uniform4(any_l1()),
        (tag_latency, return_latency) in (0_u32..4, 0_u32..4),
        version in prop::sample::select(vec![Version::None, Version::A, Version::B]),
        cache in any_cache(),
        (granule, sets) in (prop::sample::select(vec![8, 16, 32]), prop::sample::select(vec![1, 2, 4])),
        sdram in any_sdram(),
        (setup, beat_bytes, cycles_a_beat) in (0_u32..40, 1_u32..9, 1_u32..17),
    ) -> ChipConfig {
        ChipConfig {
            pipelines,
            threads,
            units: units.map(|(rays_a_cycle, latency)| UnitConfig { rays_a_cycle, latency }),
            l1,
            tag_latency,
            return_latency,
            metadata_cache: MetadataCacheConfig { bytes: 4 * granule * sets, granule },
            sdram,
            pci: PciConfig { setup, beat_bytes, cycles_a_beat },
            ..ChipConfig::standard(version, cache)
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// To the cycle, in all that is counted.
    #[test]
    fn model_is_the_naive_stepping(
        config in any_chip(),
        programs in any_programs(),
        before in prop::collection::vec(any_programs(), 0..2),
    ) {
        let model = simulate(&before, &programs, &config).expect("a chip");
        prop_assert_eq!(&model, &naive_simulate(&before, &programs, &config));
        sums_hold(&model, &config);
    }
}
