//! The chip between events: what limits it, what an observer sees of it, and runs of a part of its
//! packets. That it is the specification's chip is for `saarcor-proofs` to show.

#[path = "../../spec/tests/support/mod.rs"]
mod support;

use saarcor_fast::chip::{
    Cache, Caches, ChipObserver, Found, Traffic, simulate, simulate_observed, simulate_part,
};
use saarcor_model::time::{
    CacheReport, ChipConfig, PciConfig, Program, Programs, Span, TimingReport, Version,
};
use saarcor_model::vm::{HostAddr, Unit};
use support::{numbers, operation, scattered, standard, sums_hold};

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

/// What packets do, summed up.
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

#[test]
fn cold_first_level_caches_lie_before_a_warm_virtual_memory() {
    let programs = scattered(90, 40, Unit::Intersection, 36);
    let config = standard(Version::A);
    let run = |caches: Caches| simulate_part(caches, &programs, &[true; 90], &mut ());
    let warm = || Caches::after([&programs], HostAddr(0), &config).expect("a chip");
    let (cold, empty) = (run(warm().with_cold_first_level()), run(empty(&config)));
    let missed = |report: &TimingReport| report.l1[Unit::Intersection as usize].misses;
    assert_eq!(missed(&cold), missed(&empty));
    assert!(missed(&run(warm())) < missed(&cold));
    assert_eq!(cold.l2.misses, 0);
    assert!(empty.l2.misses > 0);
}

/// With one thread the order of look-ups is that of the packets, in time or not; only what is in
/// flight differs, and a single thread has nothing in flight.
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

#[test]
fn units_without_work_are_idle() {
    let programs = scattered(8, 10, Unit::Traversal, 8);
    let config = standard(Version::A);
    let report = simulate(&[], &programs, &config).expect("a chip");
    let all = report.cycles * u64::from(config.pipelines);
    for unit in [Unit::Shading, Unit::List, Unit::Intersection] {
        let of_unit = report.units[unit as usize];
        assert_eq!((of_unit.idle, of_unit.busy, of_unit.stalled()), (all, 0, 0), "{unit:?}");
    }
    assert!(report.units[Unit::Traversal as usize].stalled() > 0);
}

/// A first-level cache counts its lines in flight by their lowest bits, which are the same here: those that have arrived
/// count no more.
#[test]
fn lines_that_are_alike_in_their_lowest_bits_come_and_go() {
    let line = |number: u32| operation(Unit::Traversal, 8 * 256 * number, 8, 1);
    let programs = Programs { packets: vec![(0..1000).map(line).collect()], triangles: HostAddr(0) };
    let report = simulate(&[], &programs, &standard(Version::None)).expect("a chip");
    assert_eq!(report.l1[Unit::Traversal as usize], CacheReport { accesses: 1000, merged: 0, misses: 1000 });
}

/// The whole chip without virtual memory meets the plateau of its memory chips.
#[test]
fn random_triangles_saturate_the_memory() {
    let config = standard(Version::None);
    let report = simulate(&[], &scattered(500, 100, Unit::Intersection, 36), &config).expect("a chip");
    let part = (report.memory_bytes() / 4) as f64 / report.cycles as f64;
    assert!((0.55..0.75).contains(&part), "{part} of the peak");
}
