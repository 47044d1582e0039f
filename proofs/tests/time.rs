//! The chip in time at the sizes that people build and beyond: 64 threads in each of 4 pipelines, 64 pipelines, 64
//! lines in flight, units that take hundreds of rays a cycle, latencies of a thousand cycles, more than 2^16
//! packets, requests and cycles. Runs keep every law of `saarcor_proofs::time::chip::laws`, and the twins take the
//! same time. All numbers are the same in every run.

use saarcor_fast::chip::{ChipObserver, Traffic, simulate_observed};
use saarcor_model::time::{
    Burst, Chip, ChipConfig, Command, Direction, L1Config, MetadataCacheConfig, Operation, Pci, PciConfig,
    Programs, Sdram, SdramConfig, Span, TimingReport, TransferId, UnitConfig, Version,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};
use saarcor_oracles::memory_protocol::{self, Checker, Rule, Timing};
use saarcor_proofs::time::chip::laws::{
    Account, Arrivals, HandOut, LookUps, Parts, Ports, Queue, Threads, Units, Waiting, run,
};
use std::collections::{BTreeSet, VecDeque};

/// Numbers that look random: Knuth's linear congruential generator (MMIX).
struct Numbers(u64);

impl Numbers {
    /// The next one, below `below`.
    fn below(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % below
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }
}

fn any_sdram(n: &mut Numbers) -> SdramConfig {
    let beat_bytes = n.of(&[1, 4, 8, 16]);
    let (precharge, refresh): (u32, u32) = (n.of(&[0, 1, 3, 20]), n.of(&[0, 1, 9, 40]));
    // Each of its commands takes a clock.
    let busy = precharge.max(1) + refresh.max(1);
    SdramConfig {
        cycles_a_clock: n.of(&[1, 2, 3, 4, 7]),
        beat_bytes,
        banks: n.of(&[1, 2, 4, 16, 32]),
        row_bytes: beat_bytes * n.of(&[1, 4, 16, 256]),
        cas: n.of(&[0, 1, 3, 12]),
        ras_to_cas: n.of(&[0, 1, 3, 11]),
        precharge,
        row_active: n.of(&[0, 4, 6, 20]),
        row_cycle: n.of(&[0, 5, 9, 60]),
        row_to_row: n.of(&[0, 1, 2, 5]),
        write_recovery: n.of(&[0, 1, 2, 17]),
        refresh_interval: n.of(&[0, busy + 30, busy + 1, 300, 2083]),
        refresh,
    }
}

fn any_l1(n: &mut Numbers) -> L1Config {
    L1Config {
        line: n.of(&[4, 8, 12, 16]),
        sets: n.of(&[1, 2, 16, 256]),
        ports: n.of(&[1, 1, 2, 3, 64]),
        latency: n.of(&[1, 2, 17, 300]),
        mshrs: n.of(&[1, 2, 4, 16, 17, 64]),
    }
}

fn any_chip(n: &mut Numbers, (pipelines, threads): (u32, u32)) -> ChipConfig {
    let (line_bits, way_bits, set_bits) = (4 + n.below(3), n.below(5), n.below(6));
    let geometry =
        Geometry::new(Bytes(1 << (line_bits + way_bits + set_bits)), Bytes(1 << line_bits), 1 << way_bits);
    let cache = CacheConfig {
        geometry: geometry.expect("legal"),
        hash: n.of(&[Hash::Low, Hash::AddUpper, Hash::AddUpperAll]),
        policy: n.of(&[Policy::Lru, Policy::Fifo, Policy::Plru]),
    };
    let granule = n.of(&[8, 16, 32, 64]);
    ChipConfig {
        pipelines,
        threads,
        units: [(); 4].map(|()| UnitConfig {
            rays_a_cycle: n.of(&[1, 4, 63, 64, 65, 200, 255, 256, 100_000]),
            latency: n.of(&[0, 1, 16, 255, 1024]),
        }),
        l1: [(); 4].map(|()| any_l1(n)),
        tag_latency: n.of(&[0, 1, 4, 300]),
        return_latency: n.of(&[0, 1, 4, 300]),
        metadata_cache: MetadataCacheConfig { bytes: 4 * granule * n.of(&[1, 2, 16]), granule },
        sdram: any_sdram(n),
        pci: PciConfig {
            setup: n.of(&[0, 1, 38]),
            beat_bytes: n.of(&[1, 3, 4, 8]),
            cycles_a_beat: n.of(&[1, 8]),
        },
        ..ChipConfig::standard(n.of(&[Version::None, Version::A, Version::B]), cache)
    }
}

/// Packets that meet at few lines, or that are all over the host's memory.
fn any_programs(n: &mut Numbers, packets: u64, operations: u64) -> Programs {
    let places = n.of(&[40, 600, 20_000]);
    let mut operation = || {
        let bytes = n.of(&[0, 4, 4, 8, 20, 36]);
        let rays = n.below(256) as u8;
        let rays = if bytes == 0 { rays.max(1) } else { n.of(&[0, 1, rays]) };
        Operation { addr: HostAddr(n.below(places) as u32), bytes, rays, unit: n.of(&Unit::ALL) }
    };
    let mut packet = |number: u64| (0..operations - number % 3).map(|_| operation()).collect();
    Programs { packets: (0..packets).map(&mut packet).collect(), triangles: HostAddr(20) }
}

/// Holds a run to all laws, and its twin to its report.
#[track_caller]
fn keeps_every_law(config: &ChipConfig, before: &[Programs], programs: &Programs) -> TimingReport {
    let (mut hand_out, mut units) = (HandOut::new(config, programs), Units::new(config));
    let (mut threads, mut ports) = (Threads::new(config, programs), Ports::new(config));
    let (mut waiting, mut queue) = (Waiting::new(config), Queue::new(config));
    let (mut arrivals, mut account) = (Arrivals::new(config), Account::new(config));
    let (mut parts, mut look_ups) = (Parts::new(config, programs), LookUps::new(config));
    let report = run(
        config,
        before,
        programs,
        &mut [
            &mut hand_out,
            &mut units,
            &mut threads,
            &mut ports,
            &mut waiting,
            &mut queue,
            &mut arrivals,
            &mut account,
            &mut parts,
            &mut look_ups,
        ],
    )
    .unwrap_or_else(|wrong| panic!("{wrong}: {config:?}"));
    let fast = saarcor_fast::chip::simulate(before, programs, config).expect("a chip");
    assert_eq!(fast, report, "the twin on {config:?}");
    report
}

#[test]
fn chips_of_all_kinds_keep_every_law() {
    let mut n = Numbers(1);
    for _ in 0..60 {
        let size = n.of(&[(1, 1), (1, 7), (3, 2), (2, 5)]);
        let config = any_chip(&mut n, size);
        let before = [any_programs(&mut n, 3, 3)];
        let programs = any_programs(&mut n, 14, 5);
        keeps_every_law(&config, &before, &programs);
    }
}

#[test]
fn chips_of_many_threads_keep_every_law() {
    let mut n = Numbers(2);
    let mut queued = 0;
    for size in [(4, 64), (64, 1), (1, 64), (4, 16), (5, 33), (4, 17)] {
        for _ in 0..2 {
            let config = any_chip(&mut n, size);
            let programs = any_programs(&mut n, 2 * u64::from(size.0 * size.1), 3);
            let report = keeps_every_law(&config, &[], &programs);
            queued += report.units.iter().map(|unit| unit.stalls[2]).sum::<u64>();
        }
    }
    assert!(queued > 0, "no thread waited for a register");
}

/// Threads that were queued for one line are served by all ports in one cycle, once the line is there: each hit leaves a
/// register free for the next to ask again.
#[test]
fn every_port_serves_the_queue() {
    let geometry = Geometry::new(Bytes(1 << 14), Bytes(128), 4).expect("legal");
    let cache = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
    for ports in 1..=4 {
        let mut config = ChipConfig { pipelines: 1, threads: 8, ..ChipConfig::standard(Version::A, cache) };
        for l1 in &mut config.l1 {
            (l1.ports, l1.mshrs) = (ports, 1);
        }
        let packet = |packet: u32| {
            let addr = HostAddr(if packet == 0 { 0 } else { 1024 });
            [Operation { addr, bytes: 8, rays: 1, unit: Unit::Traversal }].into()
        };
        let programs = Programs { packets: (0..8).map(packet).collect(), triangles: HostAddr(0) };
        let report = keeps_every_law(&config, &[], &programs);
        assert_eq!((report.l1[1].misses, report.l1[1].accesses), (2, 8), "{ports} ports");
    }
}

/// All threads miss, each another line: as many loads in flight as there are threads, and as many in the queue of
/// a cache of one register.
#[test]
fn more_than_a_hundred_loads_and_threads_in_a_queue() {
    let mut n = Numbers(3);
    for (version, mshrs) in [(Version::A, 64), (Version::B, 64), (Version::A, 1), (Version::None, 1)] {
        let geometry = Geometry::new(Bytes(1 << 20), Bytes(128), 4).expect("legal");
        let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
        let mut config = ChipConfig { pipelines: 4, threads: 32, ..ChipConfig::standard(version, cache) };
        config.l1.iter_mut().for_each(|l1| l1.mshrs = mshrs);
        config.pci = PciConfig { setup: 3, beat_bytes: 8, cycles_a_beat: 1 };
        let mut read = |unit| {
            let addr = HostAddr(128 * n.below(1 << 14) as u32);
            Operation { addr, bytes: 4, rays: 1, unit }
        };
        let packet = |number: usize| [read(Unit::ALL[number % 4]), read(Unit::ALL[number % 2])].into();
        let programs = Programs { packets: (0..140).map(packet).collect(), triangles: HostAddr(0) };
        keeps_every_law(&config, &[], &programs);
    }
}

/// More than 2^16 packets, cycles, operations and bytes.
#[test]
fn long_runs_take_the_same_time() {
    let mut n = Numbers(4);
    let geometry = Geometry::new(Bytes(1 << 20), Bytes(128), 4).expect("legal");
    let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
    let config = ChipConfig { pipelines: 2, threads: 3, ..ChipConfig::standard(Version::None, cache) };
    let packet = |_| {
        let unit = n.of(&[Unit::Traversal, Unit::List]);
        let bytes = if n.below(16) == 0 { 4 } else { 0 };
        [Operation { addr: HostAddr(8 * n.below(1 << 12) as u32), bytes, rays: 1, unit }].into()
    };
    let programs = Programs { packets: (0..70_000).map(packet).collect(), triangles: HostAddr(0) };
    let (mut hand_out, mut units) = (HandOut::new(&config, &programs), Units::new(&config));
    let report = run(&config, &[], &programs, &mut [&mut hand_out, &mut units]).expect("all laws hold");
    assert!(report.cycles > 1 << 16, "{} cycles", report.cycles);
    assert_eq!(report.units.iter().map(|unit| unit.operations).sum::<u64>(), 70_000);
    assert_eq!(saarcor_fast::chip::simulate(&[], &programs, &config), Ok(report));
}

/// Every transfer on a bus, in order.
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

/// In no window do more bytes move than one beat of `beat_bytes` each `cycles_a_beat`: windows that begin and end
/// with a transfer are the worst.
#[track_caller]
fn no_window_holds_more(transfers: &[(Span, u64)], beat_bytes: u32, cycles_a_beat: u32) {
    for (first, &(Span { begin, .. }, _)) in transfers.iter().enumerate() {
        let mut bytes = 0;
        for &(span, own) in &transfers[first..] {
            bytes += own;
            let beats = (span.end - begin) / u64::from(cycles_a_beat);
            let most = beats * u64::from(beat_bytes);
            assert!(bytes <= most, "{bytes} bytes from cycle {begin} to {}, {most} at most", span.end);
        }
    }
}

#[test]
fn no_window_of_a_bus_holds_more_than_its_clock_allows() {
    let mut n = Numbers(5);
    let mut moved = 0;
    for _ in 0..60 {
        let size = n.of(&[(1, 3), (2, 4), (3, 8)]);
        let config = any_chip(&mut n, size);
        let programs = any_programs(&mut n, 20, 5);
        let mut transfers = Transfers::default();
        simulate_observed(&[], &programs, &config, &mut transfers).expect("a chip");
        no_window_holds_more(&transfers.memory, config.sdram.beat_bytes, config.sdram.cycles_a_clock);
        no_window_holds_more(&transfers.pci, config.pci.beat_bytes, config.pci.cycles_a_beat);
        moved += transfers.pci.len();
        // The specification's are the same, as far as they are over with the last packet.
        let mut chip = Chip::new(&[], &programs, &config).expect("a chip");
        while !chip.cycle(|_, _| ()) {}
        for (number, &(span, _)) in transfers.memory.iter().enumerate() {
            let own = chip.sdram.span_of(TransferId(number));
            assert!(
                own.is_none() || own == Some(span),
                "transfer {number}: {own:?}, its twin {span:?}, {config:?}"
            );
        }
    }
    assert!(moved > 200, "{moved} transfers over the bus to the host");
}

/// Requests to memory chips, and when they come.
fn any_requests(
    n: &mut Numbers,
    count: usize,
    pauses: &[u64],
    places: u64,
) -> Vec<(u64, u64, u64, Direction)> {
    let mut now = 0;
    let mut request = || {
        now += n.of(pauses);
        let direction = n.of(&[Direction::Read, Direction::Write]);
        (now, n.below(places), n.of(&[1, 4, 16, 36, 128, 200]), direction)
    };
    (0..count).map(|_| request()).collect()
}

/// The times of memory chips, as data sheets name them.
fn timing_of(config: SdramConfig) -> Timing {
    Timing {
        banks: config.banks.into(),
        rows: u64::MAX,
        columns_a_row: u64::from(config.row_bytes / config.beat_bytes),
        cl: config.cas.into(),
        t_rcd: config.ras_to_cas.into(),
        t_rp: config.precharge.into(),
        t_ras: config.row_active.into(),
        t_rc: config.row_cycle.into(),
        t_rrd: config.row_to_row.into(),
        t_wr: config.write_recovery.into(),
        t_rfc: config.refresh.into(),
        t_refi: config.refresh_interval.into(),
        // SD-4: a burst moves all its beats.
        burst_cut: 0,
    }
}

/// A command, as data sheets name it.
fn named(command: Command) -> memory_protocol::Command {
    match command {
        Command::Open(bank, row) => memory_protocol::Command::Activate { bank: bank as u64, row },
        Command::Close(bank) => memory_protocol::Command::Precharge { bank: Some(bank as u64) },
        Command::CloseAll => memory_protocol::Command::Precharge { bank: None },
        Command::Refresh => memory_protocol::Command::Refresh,
        Command::Move(Burst { bank, row, column, beats, direction }) => {
            let burst = memory_protocol::Burst { bank: bank as u64, row: Some(row), column, beats };
            match direction {
                Direction::Read => memory_protocol::Command::Read(burst),
                Direction::Write => memory_protocol::Command::Write(burst),
            }
        }
    }
}

/// Holds commands to the data sheet. Refreshes may come late here: requests queue up for longer than on a chip.
#[track_caller]
fn keeps_the_data_sheet(config: SdramConfig, commands: &[(u64, Command)]) {
    let mut checker = Checker::new(timing_of(config));
    for &(clock, command) in commands {
        match checker.check(clock, named(command)) {
            Err(violation) if violation.rule != Rule::RefreshLate => panic!("{violation}, of {config:?}"),
            _ => {}
        }
    }
}

/// Memory chips that keep one time a clock too short are found, and for that time.
#[test]
fn each_time_that_is_a_clock_too_short_is_found() {
    // Openings and closings of PC133 take as long as its cycle of rows, which then never decides.
    let right = SdramConfig { row_cycle: 10, ..SdramConfig::STANDARD };
    type Shorten = fn(&mut SdramConfig);
    let shortened: [(Rule, Shorten); 9] = [
        (Rule::Cl, |config| config.cas -= 1),
        (Rule::Trcd, |config| config.ras_to_cas -= 1),
        (Rule::Trp, |config| config.precharge -= 1),
        (Rule::Tras, |config| config.row_active -= 1),
        (Rule::Trc, |config| config.row_cycle -= 1),
        (Rule::Trrd, |config| config.row_to_row -= 1),
        (Rule::Twr, |config| config.write_recovery -= 1),
        (Rule::Trfc, |config| config.refresh -= 1),
        (Rule::RefreshEarly, |config| config.refresh_interval -= 1),
    ];
    let mut n = Numbers(8);
    let requests = any_requests(&mut n, 20_000, &[0, 8, 200, 1000], 1 << 16);
    let rules_of = |config: SdramConfig| {
        let (mut sdram, mut checker) =
            (saarcor_fast::sdram::Sdram::new(config), Checker::new(timing_of(right)));
        let (mut found, mut spans) = (BTreeSet::new(), VecDeque::new());
        let last = requests.last().map_or(0, |request| request.0) + 100_000;
        let ends = requests.iter().map(Some).chain([None]);
        for request in ends {
            let now = request.map_or(last, |request| request.0);
            while let Some((clock, command)) = sdram.take_command(now) {
                found.extend(checker.check(clock, named(command)).err().map(|violation| violation.rule));
                // Of requests that stay in a row, one command moves the data.
                if let Command::Move(burst) = command
                    && let Some(Span { begin, end }) = spans.pop_front()
                {
                    let data = |direction| match direction {
                        Direction::Read => memory_protocol::Direction::Read,
                        Direction::Write => memory_protocol::Direction::Write,
                    };
                    let cycles = u64::from(config.cycles_a_clock);
                    let seen = checker.data(begin / cycles, end / cycles, data(burst.direction));
                    found.extend(seen.err().map(|violation| violation.rule));
                }
            }
            if let Some(&(_, addr, bytes, direction)) = request {
                spans.push_back(sdram.transfer(now, addr / 256 * 256, bytes, direction));
            }
        }
        found
    };
    assert_eq!(rules_of(right), BTreeSet::new());
    for (rule, shorten) in shortened {
        let mut config = right;
        shorten(&mut config);
        let found = rules_of(config);
        assert!(found.contains(&rule), "{rule:?}: {found:?}");
    }
}

/// Holds the memory chips and their twin to the same times and commands, these to the data sheet, and the times to
/// the order of the requests.
#[track_caller]
fn memory_takes_the_same_time(config: SdramConfig, requests: &[(u64, u64, u64, Direction)]) {
    let (mut sdram, mut fast) = (Sdram::new(config), saarcor_fast::sdram::Sdram::new(config));
    let (mut now, mut spans, mut commands) = (0, Vec::new(), Vec::new());
    sdram.begin_cycle(0);
    for &(at, addr, bytes, direction) in requests {
        while now < at {
            sdram.end_cycle(now);
            now += 1;
            sdram.begin_cycle(now);
        }
        let transfer = sdram.request(now, addr, bytes, direction);
        let moved = config.moved(addr, bytes);
        commands.extend(std::iter::from_fn(|| fast.take_command(now)));
        spans.push((transfer, fast.transfer(now, addr, bytes, direction), moved));
    }
    let last = spans.last().map_or(0, |(_, span, _)| span.end);
    while now <= last {
        sdram.end_cycle(now);
        now += 1;
        sdram.begin_cycle(now);
    }
    fast.refresh_until(now);
    commands.extend(std::iter::from_fn(|| fast.take_command(now)));
    assert!(commands == sdram.commands, "other commands, of {config:?}: {commands:?}, {:?}", sdram.commands);
    keeps_the_data_sheet(config, &commands);
    let mut bus_free = 0;
    let cycles = u64::from(config.cycles_a_clock);
    for (number, &(transfer, span, moved)) in spans.iter().enumerate() {
        let request = requests[number];
        assert_eq!(sdram.span_of(transfer), Some(span), "transfer {number}, {request:?}, of {config:?}");
        let beats = moved / u64::from(config.beat_bytes);
        let fits = span.begin >= bus_free.max(request.0) && span.end >= span.begin + beats * cycles;
        assert!(fits, "transfer {number}, {request:?}, {span:?}, of {config:?}");
        bus_free = span.end;
    }
}

#[test]
fn memory_chips_of_all_kinds_take_the_same_time() {
    let mut n = Numbers(6);
    for _ in 0..100 {
        let config = any_sdram(&mut n);
        let pauses = n.of(&[&[0, 1, 30][..], &[0, 3, 100, 9000], &[0]]);
        let places = n.of(&[300, 10_000, 1 << 32]);
        let requests = any_requests(&mut n, 150, pauses, places);
        memory_takes_the_same_time(config, &requests);
    }
}

/// More than 2^16 requests and refreshes, and more than 2^20 clocks.
#[test]
fn memory_takes_the_same_time_for_long() {
    let mut n = Numbers(7);
    let requests = any_requests(&mut n, 70_000, &[0, 8, 60, 100], 1 << 32);
    memory_takes_the_same_time(SdramConfig { refresh_interval: 40, ..SdramConfig::STANDARD }, &requests);
}

/// More than 2^16 transfers, of which more than a thousand wait.
#[test]
fn bus_takes_the_same_time_for_long() {
    let mut n = Numbers(8);
    let config = PciConfig { setup: 3, beat_bytes: 4, cycles_a_beat: 1 };
    let mut fast = saarcor_fast::pci::Pci::new(config);
    let mut slow = Pci::new(config);
    let (mut expected, mut spans, mut asked, mut cycle) = (Vec::new(), Vec::new(), 0_u64, 0);
    while asked < 70_000 || spans.len() < expected.len() {
        slow.has_arrived(cycle);
        if cycle % 20_000 == 0 {
            for _ in 0..2_000.min(70_000 - asked) {
                let bytes = 1 + n.below(32);
                expected.push((fast.load(cycle, bytes), bytes));
                slow.request(bytes);
                asked += 1;
            }
        }
        spans.extend(slow.start(cycle));
        cycle += 1;
    }
    let of_twin: Vec<_> = expected.iter().map(|(span, _)| *span).collect();
    assert!(of_twin == spans, "the twin's transfers differ");
    let mut free = 0;
    for (span, bytes) in expected {
        assert!(
            span.begin >= free && span.end - span.begin == 3 + bytes.div_ceil(4),
            "{bytes} bytes: {span:?}"
        );
        free = span.end;
    }
}
