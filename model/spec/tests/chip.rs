//! The chip in time: cycles worked out by hand, and what is conserved.

mod support;

use saarcor_model::time::{
    CardAccess, Chip, ChipConfig, Operation, Programs, SdramConfig, TimingReport, Version, simulate,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};
use support::{operation, scattered, standard, sums_hold};

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

/// Nobody works, so the phases of units, first-level caches and bus manager have nothing to do.
#[test]
fn the_last_cycle_ends_with_its_fifth_phase() {
    let (config, programs) = (standard(Version::A), programs(&[&[operation(Unit::Traversal, 0, 8, 1)]]));
    let mut chip = Chip::new(&[], &programs, &config).expect("a chip");
    let mut phases = Vec::new();
    while !chip.cycle(|phase, _| phases.push(phase)) {
        assert_eq!(std::mem::take(&mut phases), [1, 2, 3, 4, 5, 6, 7, 8]);
    }
    assert_eq!(phases, [1, 2, 3, 4, 5]);
}

#[test]
fn first_level_caches_have_the_bytes_that_the_paper_states() {
    let config = standard(Version::None);
    assert_eq!([0, 1, 2, 3].map(|unit| config.l1_bytes(unit)), [64 << 10, 64 << 10, 64 << 10, 144 << 10]);
}

#[test]
fn frames_a_second_are_cycles_a_second_over_cycles_a_frame() {
    let config = standard(Version::None);
    assert_eq!([533_000_000, 53_300_000].map(|cycles| config.fps(cycles)), [1.0, 10.0]);
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
    let message = refused(&|config| config.l1[3].line = 0);
    assert_eq!(message, "line of a first-level cache of 0: it must be at least 1");
    assert!(refused(&|config| config.threads = 0).starts_with("number of threads a pipeline of 0"));
    assert!(refused(&|config| config.pipelines = 65).contains("1 to 64"));
    assert!(refused(&|config| config.units[1].rays_a_cycle = 0).contains("at least 1"));
    assert!(refused(&|config| config.l1[0].sets = 3).contains("power of two"));
    assert!(refused(&|config| config.l1[0].latency = 0).contains("1 to 1024"));
    assert!(refused(&|config| config.sdram.refresh_interval = 12).contains("more than the 12"));
    assert!(refused(&|config| config.sdram.beat_bytes = 256).contains("at least a beat"));
    assert!(refused(&|config| config.metadata_cache.bytes = 48).contains("power of two"));
    // Less than a set of four granules of 32 bytes.
    let message = refused(&|config| config.metadata_cache.bytes = 64);
    assert_eq!(message, "size of the metadata cache of 64: it must be a power of two, 128 to 67108864");
    assert!(refused(&|config| config.pci.beat_bytes = 0).contains("at least 1"));
    standard(Version::None).check().expect("a chip");
}

/// The worked table of SPEC.md (CH-13 to CH-15): lines that are evicted in flight, and a part that hits
/// before its line is loaded again.
#[test]
fn worked_table_is_what_the_chip_does() {
    let geometry = Geometry::new(Bytes(256), Bytes(64), 2).expect("legal");
    let cache = CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru };
    let config = ChipConfig { threads: 1, ..ChipConfig::standard(Version::A, cache) };
    let line = |addr| operation(Unit::Shading, addr, 64, 1);
    let before = [programs(&[&[line(0), line(0x80)]])];
    let packets = [
        operation(Unit::Traversal, 0, 8, 1),
        operation(Unit::List, 0x100, 4, 1),
        operation(Unit::Shading, 0x180, 4, 1),
        operation(Unit::Traversal, 8, 8, 1),
    ];
    let programs = programs(&packets.each_ref().map(std::slice::from_ref));
    let mut chip = Chip::new(&before, &programs, &config).expect("a chip");
    let (mut seen, mut l2, mut lines) = (0, chip.report.l2, [0; 2]);
    let mut rows = Vec::new();
    let mut row = |cycle: u64, phase: u32, what: Option<String>, lines: [u32; 2]| {
        let what = what.map(|what| format!("| {cycle} | {phase} | {what} | {}, {} |\n", lines[0], lines[1]));
        rows.extend(what);
    };
    loop {
        let has_ended = chip.cycle(|phase, chip| {
            for &access in &chip.card[seen..] {
                let what = match access {
                    CardAccess::Write(load) => {
                        lines[load.card as usize / 64] = load.line.0;
                        format!("line {} is written to place {}", load.line.0, load.card / 64)
                    }
                    CardAccess::Read { part, card } => {
                        format!("the part at {:x} is read at place {}", part.addr.0, card / 64)
                    }
                };
                // What the picture before left there was written before the first cycle.
                let is_before = chip.report.l2.accesses == 0;
                row(chip.now, phase, (!is_before).then_some(what), lines);
            }
            seen = chip.card.len();
            let taken = chip.report.l2;
            if taken.accesses > l2.accesses {
                let addr = packets[l2.accesses as usize].addr.0;
                let found = match taken.misses > l2.misses {
                    true => format!("misses, load {}", l2.misses),
                    false => "hits".to_owned(),
                };
                let what = format!("the part at {addr:x} is taken: line {} {found}", addr / 64);
                row(chip.now, phase, Some(what), lines);
                l2 = taken;
            }
        });
        if has_ended {
            break;
        }
    }
    row(chip.now, 5, Some("all packets have ended".to_owned()), lines);
    let spec = include_str!("../../SPEC.md");
    let (_, table) = spec.split_once("<!-- worked table -->\n").expect("its begin");
    let (table, _) = table.split_once("<!-- end of worked table -->").expect("its end");
    let head = "| cycle | phase | what happens | lines at places 0 and 1 |\n|---|---|---|---|\n";
    assert_eq!(table, format!("{head}{}", rows.concat()));
}
