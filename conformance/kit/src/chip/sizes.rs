//! Sessions of `saarcor-chip` about the sizes that people build: long packets and runs, many threads, banks and lines in
//! flight, and counters that overflow.

use super::Chip;
use super::config;
use super::request::{RAYS, Request};
use crate::sizes::{About, Extent, SizedSession};
use saarcor_model::time::Operation;
use saarcor_model::vm::{HostAddr, Unit};
use saarcor_random::Random;

/// Shapes of a plan.
const SHAPES: u64 = 24;
/// Requests of a plan with which a chip is taken for one that steps cycle by cycle in a slow language: its runs are of
/// 2¹⁸ cycles, where others are of 2²² and more.
const SLOW: usize = 100_000;

/// One thread, which does one thing after the other, without virtual memory.
const ALONE: &str = "pipelines=1 threads=1 version=none refresh=0";

/// All, in order.
pub fn sessions(extent: &Extent) -> Vec<SizedSession> {
    let is_slow = extent.requests < SLOW;
    let mut all = Vec::new();
    let mut add = |name: &str, about: About, config: &str, requests: Vec<Request>| {
        let text: String = requests.iter().map(|request| format!("{request}\n")).collect();
        all.push(SizedSession::new(Chip, name, about, config, move |_| text.clone().into_bytes()));
    };
    add("sizes/operations", ("CH-1", None, "Packets of up to 500 operations."), ALONE, operations());
    add(
        "sizes/pipelined-operations",
        ("CH-1", None, "Long packets side by side."),
        "pipelines=2 threads=3 version=none",
        operations(),
    );
    let slow_unit = "pipelines=1 threads=1 version=none refresh=0 s-latency=1024";
    let cycles = ("CH-20", None, "Runs of more than a million cycles.");
    add(
        "sizes/cycles",
        cycles,
        slow_unit,
        long_runs(if is_slow { &[1, 61, 241, 1000] } else { &[1, 61, 241, 1000, 4000] }),
    );
    for (pipelines, threads) in [(1, 9), (1, 16), (1, 33), (1, 64), (5, 2), (8, 8), (16, 1), (64, 1)] {
        let config = format!("pipelines={pipelines} threads={threads} version=none");
        let turns = ("CH-6", None, "Units of many threads take them in turn.");
        add(
            &format!("sizes/units@pipelines={pipelines},threads={threads}"),
            turns,
            &config,
            unit_turns(pipelines * threads),
        );
        let ports = ("CH-8", None, "Ports serve many pipelines and threads in turn.");
        add(
            &format!("sizes/ports@pipelines={pipelines},threads={threads}"),
            ports,
            &config,
            port_turns(pipelines * threads),
        );
    }
    for registers in [1, 15, 16, 17, 64] {
        let config = format!("pipelines=4 threads=16 version=none n-mshrs={registers} refresh=0");
        let about = ("CH-11", None, "Many lines in flight.");
        add(&format!("sizes/registers@n-mshrs={registers}"), about, &config, many_lines(96, 256));
    }
    let config =
        "pipelines=4 threads=16 version=a n-mshrs=64 pci-setup=1 pci-clock=1 refresh=0 s-latency=1024";
    add("sizes/loads", ("CH-14", None, "Hits behind many lines that come from the host."), config, loads());
    add(
        "sizes/warm-packets",
        ("CH-19", None, "Earlier pictures of many packets."),
        "pipelines=1 threads=1 version=a",
        warm(),
    );
    for banks in [1, 2, 4, 8, 16, 32, 64] {
        let config = format!("{ALONE} banks={banks}");
        add(
            &format!("sizes/banks@banks={banks}"),
            ("SD-2", None, "Rows lie in as many banks as there are."),
            &config,
            rows(banks),
        );
    }
    add("sizes/addresses", ("SD-2", None, "On-board addresses have all their bits."), ALONE, addresses());
    let large = "pipelines=1 threads=1 version=a lines=524288 refresh=0";
    add("sizes/addresses@lines=524288", ("SD-2", None, "The same with 64 MB of lines."), large, addresses());
    add(
        "sizes/refresh",
        ("SD-5", None, "However many refreshes there were."),
        "pipelines=1 threads=1 version=none s-latency=1000",
        refreshes(if is_slow { 150 } else { 2000 }),
    );
    let parts = if is_slow { 1 } else { 20 };
    let many = "pipelines=1 threads=1 refresh=0 pci-setup=0 pci-clock=1 tag=0 return=0 cl=0 rcd=0 rp=0 ras=0 rc=0 rrd=0";
    for (name, requirement, unit, config) in [
        ("look-ups", "CH-12", Unit::List, "version=a line=64"),
        ("bytes-from-memory", "SD-1", Unit::Shading, "version=none"),
        ("bytes-from-the-host", "PC-1", Unit::Shading, "version=a"),
        ("metadata", "CH-17", Unit::Shading, "version=b"),
    ] {
        let about = (requirement, None, "However many there are in a run.");
        let requests = long_reads(unit, if unit == Unit::List { parts.min(5) } else { parts });
        add(&format!("sizes/{name}"), about, &format!("{many} {config}"), requests);
    }
    for number in 0..SHAPES {
        let number = extent.seed.wrapping_mul(SHAPES).wrapping_add(number);
        let made = move |config: &str| shaped(config, number);
        let about = ("", None, "Chips of many sizes, packets of many operations.");
        all.push(SizedSession::new(Chip, &format!("shape/{number}"), about, &shape(number), made));
    }
    all
}

fn operation(unit: Unit, addr: u32, bytes: u16, rays: u8) -> Operation {
    Operation { addr: HostAddr(addr), bytes, rays, unit }
}

/// A run of packets, after which there are none.
fn run(requests: &mut Vec<Request>) {
    requests.extend([Request::Run, Request::Flush]);
}

fn operations() -> Vec<Request> {
    let mut requests = Vec::new();
    for count in [1, 15, 16, 17, 31, 32, 33, 63, 64, 65, 127, 128, 129, 255, 256, 257, 500] {
        for packets in [1, 3] {
            let one = |number: u32| operation(Unit::ALL[number as usize % 4], 0, 0, 1 + (number % 7) as u8);
            requests.extend(
                (0..packets).map(|packet| Request::Packet((packet..count + packet).map(one).collect())),
            );
            run(&mut requests);
        }
    }
    requests
}

/// Runs of so many operations of a slow unit.
fn long_runs(counts: &[usize]) -> Vec<Request> {
    let mut requests = Vec::new();
    for &count in counts {
        requests.push(Request::Packet(vec![operation(Unit::Shading, 0, 0, RAYS); count]));
        run(&mut requests);
    }
    requests
}

/// Two packets for each thread, whose operations want the same unit at the same time.
fn unit_turns(threads: u32) -> Vec<Request> {
    let mut requests = Vec::new();
    for packet in 0..2 * threads + 3 {
        let operations =
            (0..4).map(|step| operation(Unit::Intersection, 0, 0, 1 + ((packet * 5 + step * 3) % 11) as u8));
        requests.push(Request::Packet(operations.collect()));
    }
    run(&mut requests);
    requests
}

/// Two packets for each thread, whose operations want lines that are there, at the same time.
fn port_turns(threads: u32) -> Vec<Request> {
    let mut requests = vec![Request::Before(vec![operation(Unit::Traversal, 0, 512, 0)])];
    for packet in 0..2 * threads + 3 {
        let read = |step: u32| {
            operation(
                Unit::Traversal,
                (packet * 5 + step * 3) % 40 * 8,
                8 + 8 * ((packet + step) % 3) as u16,
                0,
            )
        };
        let mut operations: Vec<_> = (0..5).map(read).collect();
        operations.insert((packet % 5) as usize, operation(Unit::List, 0, 0, 1 + (packet % 13) as u8));
        requests.push(Request::Packet(operations));
    }
    run(&mut requests);
    requests
}

/// Packets that each read lines of their own.
fn many_lines(packets: u32, apart: u32) -> Vec<Request> {
    let mut requests = Vec::new();
    for packet in 0..packets {
        let read = |step: u32| operation(Unit::Traversal, (packet * 2 + step) * apart, 4, 1);
        requests.push(Request::Packet((0..2).map(read).collect()));
    }
    run(&mut requests);
    requests
}

/// Parts of lines that are there, behind those of many that are not; what they are for takes longest.
fn loads() -> Vec<Request> {
    let mut requests = Vec::new();
    for misses in [4, 16, 17, 33, 50] {
        let hits = 12;
        requests.push(Request::Before(
            (0..hits).map(|hit| operation(Unit::Traversal, hit * 128, 8, 1)).collect(),
        ));
        let read = |addr: u32| operation(Unit::Traversal, addr, 8, 1);
        requests
            .extend((0..misses).map(|miss| Request::Packet(vec![read(0x10_0000 + miss * 4096 + miss * 8)])));
        let slow = [operation(Unit::Shading, 0, 0, 1); 3];
        let hit = |hit: u32| Request::Packet([read(hit * 128 + 64)].into_iter().chain(slow).collect());
        requests.extend((0..hits).map(hit));
        run(&mut requests);
    }
    requests
}

fn warm() -> Vec<Request> {
    let mut requests = Vec::new();
    for packets in [1, 15, 16, 17, 33, 65, 130, 257] {
        let read = |packet: u32| vec![operation(Unit::Shading, packet * 64, 4, 1)];
        requests.extend((0..packets).map(|packet| Request::Before(read(packet))));
        // Those that are there, and some that are not.
        requests.push(Request::Packet((0..packets + 2).rev().flat_map(read).collect()));
        run(&mut requests);
    }
    requests
}

/// Rows of neighbouring banks, of the first and the last, and of the same one, each read twice.
fn rows(banks: u32) -> Vec<Request> {
    let mut requests = Vec::new();
    let mut column = 0;
    for bank in 0..banks {
        for other in [bank + 1, bank + banks, bank + banks - 1, (bank + banks / 2) % banks, 0] {
            let mut read = |row: u32| {
                // Each read is of a line of its own.
                column = (column + 8) % 4096;
                operation(Unit::Traversal, row * 4096 + column, 4, 1)
            };
            requests.push(Request::Packet(vec![read(bank), read(other), read(bank), read(other)]));
        }
        run(&mut requests);
    }
    requests
}

/// Pairs of addresses that differ in one bit.
fn addresses() -> Vec<Request> {
    let mut requests = Vec::new();
    for bit in 12..32 {
        for base in [0, 0x12_3000] {
            let read = |addr: u32, step: u32| operation(Unit::Traversal, addr + 8 * step, 4, 1);
            let (low, high) = (base, base ^ 1 << bit);
            requests.push(Request::Packet(vec![read(low, 1), read(high, 2), read(low, 3), read(high, 4)]));
        }
        run(&mut requests);
    }
    requests
}

/// Reads of one row, between which a slow unit works.
fn refreshes(count: u32) -> Vec<Request> {
    let read =
        |step: u32| [operation(Unit::Traversal, step % 512 * 8, 4, 1), operation(Unit::Shading, 0, 0, 1)];
    let mut requests = vec![Request::Packet((0..count).flat_map(read).collect())];
    run(&mut requests);
    requests
}

/// Reads of 64 KB each, of which no byte is read twice.
fn long_reads(unit: Unit, count: u32) -> Vec<Request> {
    let mut requests = Vec::new();
    let read = |number: u32| operation(unit, number << 16, u16::MAX, 1);
    for packet in [vec![operation(unit, 0x4000_0000, 0x2ff0, 1)], (0..count).map(read).collect()] {
        requests.push(Request::Packet(packet));
        run(&mut requests);
    }
    requests
}

/// The configuration of a number.
fn shape(number: u64) -> String {
    let mut random = Random::new(number);
    let mut words: Vec<String> = Vec::new();
    let mut word = |key: &str, value: u64| words.push(format!("{key}={value}"));
    let (pipelines, threads) =
        random.pick(&[(1, 64), (2, 32), (4, 16), (5, 9), (8, 8), (12, 3), (16, 2), (33, 1), (64, 1)]);
    word("pipelines", pipelines);
    word("threads", threads);
    for unit in config::UNITS {
        word(&format!("{unit}-rate"), 1 << random.below(7));
        word(&format!("{unit}-latency"), random.below(40));
        word(&format!("{unit}-line"), random.pick(&[8, 16, 32, 48, 64]));
        word(&format!("{unit}-sets"), 1 << random.below(13));
        word(&format!("{unit}-ports"), random.pick(&[1, 1, 2, 4]));
        word(&format!("{unit}-look-up"), 1 + random.below(8));
        word(&format!("{unit}-mshrs"), random.pick(&[1, 8, 16, 17, 40, 64]));
    }
    let ways = 1 << random.below(5);
    let line_bits = 6 + random.below(5);
    word("line", 1 << line_bits);
    word("lines", ways << random.below(26 - line_bits - 3));
    word("ways", ways);
    word("granule", random.pick(&[8, 16]));
    word("meta-sets", 1 << random.below(13));
    word("clock", 1 + random.below(5));
    word("beat", 1 << (2 + random.below(4)));
    word("banks", 1 << random.below(7));
    word("row", 1 << (8 + random.below(7)));
    for key in ["cl", "rcd", "rp"] {
        word(key, random.below(6));
    }
    word("ras", random.below(14));
    word("rc", random.below(20));
    word("rrd", random.below(6));
    word("wr", random.below(5));
    word("refresh", random.pick(&[0, 500, 2083, 6000]));
    word("rfc", 1 + random.below(12));
    word("pci-setup", random.below(20));
    word("pci-beat", random.pick(&[16, 64]));
    word("pci-clock", 1 + random.below(2));
    word("triangles", random.pick(&[0, 36, 0x12_3450]));
    let version = random.pick(&["none", "a", "b"]);
    let hash = random.pick(&["low", "add-upper", "add-upper-all"]);
    let policy = random.pick(&["lru", "fifo", "plru"]);
    format!("{} version={version} hash={hash} policy={policy}", words.join(" "))
}

/// Packets of up to hundreds of operations, some of them at the same places.
fn shaped(text: &str, number: u64) -> Vec<u8> {
    let setting = config::parse(text).expect("a configuration of the kit");
    let mut random = Random::new(number);
    let mut requests = Vec::new();
    let places: Vec<u32> = (0..12).map(|_| random.bits() as u32 >> random.below(16) & !0xfff).collect();
    let threads = setting.chip.pipelines * setting.chip.threads;
    for packets in [4, threads + 3] {
        for packet in 0..packets + 6 {
            let count = match random.below(12) {
                0 if packets == 4 => 64 + random.below(100),
                _ => random.below(6),
            };
            let one = |random: &mut Random| {
                let unit = random.pick(&Unit::ALL);
                let near = random.pick(&places) & 0x7fff_ffff;
                let addr = near + random.below(64) as u32 * random.pick(&[4, 36, 64]);
                let addr = if unit == Unit::Intersection { addr + setting.triangles.0 } else { addr };
                operation(unit, addr, random.pick(&[0, 4, 8, 36, 64]), 1 + random.below(RAYS.into()) as u8)
            };
            let operations = (0..count).map(|_| one(&mut random)).collect();
            requests.push(if packet < 6 { Request::Before(operations) } else { Request::Packet(operations) });
        }
        run(&mut requests);
    }
    requests.iter().map(|request| format!("{request}\n")).collect::<String>().into_bytes()
}
