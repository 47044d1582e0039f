//! Small chips of all kinds at random: the chip between events is the specification's to the cycle, and in
//! both each part that is read from the card has the bytes of the host.

use proptest::prelude::*;
use saarcor_fast::chip::{ChipObserver, simulate_observed};
use saarcor_model::time::{
    CardAccess, Chip, ChipConfig, Command, L1Config, Load, MAX_COUNT, MetadataCacheConfig, Operation,
    PciConfig, Program, Programs, SdramConfig, Stall, State, TimingReport, UNIT_NAMES, UnitConfig, Version,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};
use saarcor_oracles::card::CardShadow;

#[track_caller]
fn sums_hold(report: &TimingReport, config: &ChipConfig) {
    for (unit, name) in report.units.iter().zip(UNIT_NAMES) {
        let all = unit.busy + unit.stalled() + unit.idle;
        assert_eq!(all, report.cycles * u64::from(config.pipelines), "{name}");
    }
    assert_eq!(report.pci_bytes, report.l2.misses * config.cache.geometry.line().0);
}

/// Few places, so that packets meet at lines, and some far ones.
fn near() -> impl Strategy<Value = u32> + Clone {
    prop_oneof![4 => 0_u32..600, 1 => 0_u32..20_000]
}

/// Places on both sides of a power of two up to the end of the addresses too: numbers of lines differ in each of their
/// bits, and what is counted in fewer bits begins anew.
fn anywhere() -> impl Strategy<Value = u32> + Clone {
    let far = (10_u32..=32, 0_u32..300).prop_map(|(bit, behind)| {
        let border = 1_u64 << bit;
        u32::try_from(border - 100 + u64::from(behind)).unwrap_or(u32::MAX - behind)
    });
    prop_oneof![2 => near(), 1 => far]
}

fn any_operation(addr: impl Strategy<Value = u32>) -> impl Strategy<Value = Operation> {
    let unit = prop::sample::select(Unit::ALL.to_vec());
    (unit, addr, 0_u16..60, 0_u8..70).prop_map(|(unit, addr, bytes, rays)| {
        // Nothing lies beyond the last address.
        let bytes = u64::from(bytes).min((1 << 32) - u64::from(addr)) as u16;
        // Work on no bytes is for some rays.
        let rays = if bytes == 0 { rays.max(1) } else { rays };
        Operation { addr: HostAddr(addr), bytes, rays, unit }
    })
}

/// Programs whose operations have these addresses; triangles begin at 0, at 20, or there too.
/// Pictures of one scene: those before, and the one that is timed. Its triangles lie where they are said to, or behind.
fn any_pictures(
    addr: impl Strategy<Value = u32> + Clone,
) -> impl Strategy<Value = (Vec<Programs>, Programs)> {
    let triangles = prop_oneof![Just(0), Just(20), addr.clone()].prop_map(HostAddr);
    let packets = || prop::collection::vec(prop::collection::vec(any_operation(addr.clone()), 0..12), 0..12);
    (prop::collection::vec(packets(), 0..2), packets(), triangles).prop_map(|(before, timed, triangles)| {
        let programs = |mut packets: Vec<Vec<Operation>>| {
            for operation in packets.iter_mut().flatten() {
                if operation.unit == Unit::Intersection && operation.addr < triangles {
                    operation.addr = triangles;
                    operation.bytes = operation.bytes.min(1);
                    operation.rays = operation.rays.max(1);
                }
            }
            Programs { packets: packets.into_iter().map(Program::from).collect(), triangles }
        };
        (before.into_iter().map(programs).collect(), programs(timed))
    })
}

/// Keeps a shadow of the card, and the commands of the memory chips.
struct Watch<'a> {
    shadow: CardShadow<'a>,
    commands: Vec<(u64, Command)>,
}

impl ChipObserver for Watch<'_> {
    fn line_is_written(&mut self, _: u64, load: Load) {
        self.shadow.write(load);
    }

    fn part_is_read(&mut self, now: u64, addr: HostAddr, bytes: u64, card: u64) {
        self.shadow.read(now, addr, bytes, card);
    }

    fn command(&mut self, clock: u64, command: Command) {
        self.commands.push((clock, command));
    }
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
        (row_active, row_cycle, row_to_row) in (0_u32..9, 0_u32..12, 0_u32..5),
        write_recovery in 0_u32..3,
        (refresh_interval, refresh) in prop_oneof![Just((0, 0)), (30_u32..90, 1_u32..9)],
    ) -> SdramConfig {
        SdramConfig {
            cycles_a_clock, beat_bytes, banks, row_bytes, cas, ras_to_cas, precharge, row_active, row_cycle,
            row_to_row, write_recovery, refresh_interval, refresh,
        }
    }
}

prop_compose! {
    fn any_cache()(
        line_bits in 4_u32..7,
        way_bits in 0_u32..5,
        set_bits in 0_u32..3,
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
        // Tags that take long are acted upon when lines have been evicted and asked for again.
        (tag_latency, return_latency) in (0_u32..24, 0_u32..4),
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
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    /// To the cycle, in all that is counted.
    #[test]
    fn fast_chip_is_the_specifications(
        config in any_chip(),
        (before, programs) in any_pictures(anywhere()),
    ) {
        let fast = saarcor_fast::chip::simulate(&before, &programs, &config).expect("a chip");
        prop_assert_eq!(&fast, &saarcor_model::time::simulate(&before, &programs, &config).expect("a chip"));
        sums_hold(&fast, &config);
    }

    /// Through a memory of 1 to 64 lines, which packets evict in flight, each part that is read has the
    /// bytes of the host (VM-9), whatever happens when: in the chip between events and in the specification.
    /// Their memory chips get the same commands.
    #[test]
    fn parts_have_the_bytes_of_the_host(
        config in any_chip(),
        (before, programs) in any_pictures(near()),
    ) {
        let host: Vec<u8> = (0..20_000_u32).map(|addr| (addr ^ addr >> 7) as u8).collect();
        let mut fast = Watch { shadow: CardShadow::new(&host, &config), commands: Vec::new() };
        simulate_observed(&before, &programs, &config, &mut fast).expect("a chip");
        prop_assert!(fast.shadow.first.is_none(), "{}", fast.shadow.first.expect("a difference"));

        let mut shadow = CardShadow::new(&host, &config);
        let mut chip = Chip::new(&before, &programs, &config).expect("a chip");
        let mut seen = 0;
        let mut has_ended = false;
        while !has_ended {
            has_ended = chip.cycle(|_, chip| {
                for access in &chip.card[seen..] {
                    match *access {
                        CardAccess::Write(load) => shadow.write(load),
                        CardAccess::Read { part, card } => shadow.read(chip.now, part.addr, part.bytes, card),
                    }
                }
                seen = chip.card.len();
            });
        }
        prop_assert!(shadow.first.is_none(), "{}", shadow.first.expect("a difference"));
        prop_assert_eq!(&fast.commands, &chip.sdram.commands);
        let report = chip.report();
        prop_assert_eq!((fast.shadow.parts, shadow.parts), (report.l2.accesses, report.l2.accesses));
    }
}

/// Cards of 2 and 4 GiB: the metadata of the latter lie beyond the addresses of 32 bits.
fn any_large_chip() -> impl Strategy<Value = ChipConfig> {
    (any_chip(), 31_u32..=32, 12_u32..=13, 0_u32..=3).prop_map(|(chip, memory_bits, line_bits, way_bits)| {
        let (memory, line) = (Bytes(1 << memory_bits), Bytes(1 << line_bits));
        let geometry = Geometry::new(memory, line, 1 << way_bits).expect("legal");
        ChipConfig {
            cache: CacheConfig { geometry, ..chip.cache },
            pci: PciConfig { beat_bytes: 64, cycles_a_beat: 1, ..chip.pci },
            sdram: SdramConfig { beat_bytes: 16, cycles_a_clock: 1, ..chip.sdram },
            ..chip
        }
    })
}

/// Virtual memories of one to eight lines behind a slow bus: lines are evicted in flight and asked for again.
fn any_chip_that_evicts_in_flight() -> impl Strategy<Value = ChipConfig> {
    let version = prop::sample::select(vec![Version::A, Version::B]);
    (any_chip(), version, 0_u32..=1, 0_u32..=2, 0_u32..600).prop_map(
        |(chip, version, way_bits, set_bits, setup)| {
            let lines = 1 << (way_bits + set_bits);
            let geometry = Geometry::new(Bytes(16 * lines), Bytes(16), 1 << way_bits).expect("legal");
            ChipConfig {
                pipelines: 3,
                version,
                cache: CacheConfig { geometry, ..chip.cache },
                pci: PciConfig { setup, ..chip.pci },
                ..chip
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fast_chip_is_the_specifications_on_large_cards(
        config in any_large_chip(),
        (_, programs) in any_pictures(anywhere()),
    ) {
        let fast = saarcor_fast::chip::simulate(&[], &programs, &config).expect("a chip");
        prop_assert_eq!(fast, saarcor_model::time::simulate(&[], &programs, &config).expect("a chip"));
    }

}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fast_chip_is_the_specifications_where_lines_are_evicted_in_flight(
        config in any_chip_that_evicts_in_flight(),
        (_, programs) in any_pictures(0_u32..160),
    ) {
        let fast = saarcor_fast::chip::simulate(&[], &programs, &config).expect("a chip");
        prop_assert_eq!(fast, saarcor_model::time::simulate(&[], &programs, &config).expect("a chip"));
    }
}

/// Of each number of ways and of each granule there is a chip of its own in the specification, and of each number of ways
/// in its twin.
#[test]
fn chips_of_all_ways_and_granules_are_the_specifications() {
    // Lines of one set, more than it has ways, and lines of other sets, whose metadata lie in other granules.
    let line =
        |number: u32| Operation { addr: HostAddr(64 * number), bytes: 8, rays: 1, unit: Unit::Traversal };
    let lines = (0..40).map(|number| 64 * (number % 20)).chain((0..64).map(|number| 97 * number % 4096));
    let packets = vec![lines.map(line).collect::<Program>()];
    let programs = Programs { packets, triangles: HostAddr(0) };
    let fast_bus = PciConfig { setup: 0, beat_bytes: 64, cycles_a_beat: 1 };
    for ways in [1, 2, 4, 8, 16] {
        let geometry = Geometry::new(Bytes(64 * 64 * u64::from(ways)), Bytes(64), ways).expect("legal");
        let cache = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
        let config = |version| ChipConfig { pci: fast_bus, ..ChipConfig::standard(version, cache) };
        let granules = (3..=12).map(|bits| MetadataCacheConfig { bytes: 4 << bits, granule: 1 << bits });
        let version_b = granules.map(|metadata_cache| ChipConfig { metadata_cache, ..config(Version::B) });
        for config in [config(Version::None), config(Version::A)].into_iter().chain(version_b) {
            let fast = saarcor_fast::chip::simulate(&[], &programs, &config).expect("a chip");
            let specified = saarcor_model::time::simulate(&[], &programs, &config).expect("a chip");
            assert_eq!(fast, specified, "{ways} ways, {:?}, {:?}", config.version, config.metadata_cache);
            if config.version == Version::B {
                let granule = u64::from(config.metadata_cache.granule.max(config.sdram.beat_bytes));
                assert!(fast.metadata_read_bytes > 0 && fast.metadata_read_bytes.is_multiple_of(granule));
            }
        }
    }
}

/// As many threads as a pipeline can have wait for the same thing at once: a look-up, the memory, the host.
#[test]
fn threads_that_all_wait_for_one_cause_are_counted_alike() {
    let geometry = Geometry::new(Bytes(1 << 16), Bytes(64), 4).expect("legal");
    let cache = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
    let operation =
        |packet: u32| Operation { addr: HostAddr(packet * 64), bytes: 8, rays: 1, unit: Unit::Traversal };
    let packets = (0..MAX_COUNT).map(|packet| Program::from(vec![operation(packet)])).collect();
    let programs = Programs { packets, triangles: HostAddr(0) };
    for (version, latency, cause) in
        [(Version::A, 500, Stall::LookUp), (Version::None, 1, Stall::Memory), (Version::A, 1, Stall::Host)]
    {
        let mut config =
            ChipConfig { pipelines: 1, threads: MAX_COUNT, ..ChipConfig::standard(version, cache) };
        for l1 in &mut config.l1 {
            (l1.latency, l1.mshrs) = (latency, MAX_COUNT);
        }
        // Loads are served one after the other: no line is there before all packets wait.
        config.sdram.cas = 100;
        let all_wait = |chip: &Chip| {
            let waits = |state| match cause {
                Stall::LookUp => matches!(state, State::LooksUp { .. }),
                _ => state == State::Waits,
            };
            chip.threads.iter().all(|thread| waits(thread.state))
        };
        // What hits takes the latency of a look-up.
        let before = if cause == Stall::LookUp { std::slice::from_ref(&programs) } else { &[] };
        let mut chip = Chip::new(before, &programs, &config).expect("a chip");
        let mut seen = false;
        while !chip.cycle(|_, chip| seen |= all_wait(chip)) {}
        assert!(seen, "{cause:?}: all threads wait at once");
        let fast = saarcor_fast::chip::simulate(before, &programs, &config).expect("a chip");
        assert_eq!(fast, chip.report(), "{cause:?}");
    }
}
