//! Sessions of `saarcor-vm` about the sizes that people build.

use super::Vm;
use super::config;
use crate::hex::{push_request, push_write};
use crate::level::Level;
use crate::sizes::{Extent, SizedSession, repeated};
use saarcor_model::vm::{CacheConfig, LineAddr};
use saarcor_random::Random;

/// Lines have up to this power of two of bytes.
const LINE_BITS: u64 = 15;
/// Shapes of a plan: each length of a line with each policy.
const SHAPES: u64 = (LINE_BITS + 1) * config::POLICIES.len() as u64;

const ANY: (&str, Option<Level>, &str) = ("", None, "");
const STANDARD: &str = "line=128 lines=65536 ways=4 hash=add-upper policy=lru";
const SMALL: &str = "line=16 lines=64 ways=4 hash=add-upper policy=lru";

/// All, in order.
pub fn sessions(extent: &Extent) -> Vec<SizedSession> {
    let mut all = Vec::new();
    let writes = ("VM-9", Some(Level::Data), "Writes of all lengths, over all borders.");
    all.push(SizedSession::new(
        Vm,
        "sizes/writes",
        writes,
        "line=64 lines=4096 ways=4 hash=add-upper policy=lru",
        |_| writes_over_borders(),
    ));
    let lengths = ("VM-9", Some(Level::Data), "Writes of many lengths up to 200000 bytes.");
    all.push(SizedSession::new(Vm, "sizes/long-writes", lengths, STANDARD, |_| long_writes()));
    let next =
        ("VM-9", Some(Level::Data), "Bytes that were written are read, in whatever order lines are read.");
    all.push(SizedSession::new(Vm, "sizes/neighbours", next, SMALL, neighbours));
    for (name, config) in [
        ("sizes/ranges", STANDARD),
        ("sizes/ranges@ways=16", "line=64 lines=16384 ways=16 hash=add-upper policy=plru"),
        ("sizes/ranges@ways=1", "line=128 lines=8192 ways=1 hash=low policy=lru"),
    ] {
        let about = ("VM-8", None, "Ranges of all lengths, over all borders.");
        all.push(SizedSession::new(Vm, name, about, config, ranges).large());
    }
    for number in 0..SHAPES {
        let number = extent.seed.wrapping_mul(SHAPES).wrapping_add(number);
        all.push(shape(number));
    }
    let stale = ("VM-8", Some(Level::Data), "A flush leaves no line of 64 MB, wherever it lies.");
    let config = "line=128 lines=524288 ways=4 hash=add-upper policy=lru";
    all.push(SizedSession::new(Vm, "sizes/flush", stale, config, flush).large());
    for (memory, size) in [("8-mb", 8), ("32-mb", 32), ("64-mb", 64)] {
        for (policy, _) in config::POLICIES {
            let hash = if size == 32 { "add-upper-all" } else { "add-upper" };
            let config = format!("line=128 lines={} ways=4 hash={hash} policy={policy}", size << 13);
            let about = ("", None, "Every set and way of a memory of the paper's.");
            let name = format!("sizes/{memory}@policy={policy}");
            all.push(SizedSession::new(Vm, &name, about, &config, every_set).large());
        }
    }
    let requests = extent.long();
    let counted = |what, about, by: fn(&mut Vec<u8>, u64, u8)| {
        let made = move |config: &str| repeated(requests / 3, |count| counted(config, count, by));
        SizedSession::new(Vm, &format!("sizes/many-{what}"), about, SMALL, made).large()
    };
    all.push(counted("flushes", ("VM-8", None, "However many flushes there were."), |text, _, _| {
        text.extend_from_slice(b"flush\n");
    }));
    all.push(counted("ranges", ("VM-8", None, "However many ranges were invalidated."), |text, host, _| {
        push_request(text, b'i', &[host, 1]);
    }));
    all.push(counted("writes", ("VM-9", None, "However many writes there were."), |text, host, byte| {
        write(text, host, &[byte]);
        push_request(text, b'i', &[host, 1]);
    }));
    for (name, config) in [("sizes/long", STANDARD), ("sizes/long@lines=64", SMALL)] {
        let about = ("", None, "More requests than counters count.");
        let made = move |config: &str| repeated(requests, |count| long(config, 7, count));
        all.push(SizedSession::new(Vm, name, about, config, made).large());
    }
    all
}

/// The line of a set whose upper bits are these.
pub fn line_in(config: &CacheConfig, set: u64, upper: u64) -> u64 {
    let sets = config.geometry.sets();
    let line = upper * sets;
    let there = u64::from(config.set_of(LineAddr(line as u32)).0);
    line + (set + sets - there) % sets
}

/// How many upper bits lines can have.
pub fn uppers(config: &CacheConfig) -> u64 {
    END / config.geometry.line().0 / config.geometry.sets()
}

fn write(text: &mut Vec<u8>, host: u64, bytes: &[u8]) {
    push_write(text, host as u32, bytes);
}

fn bytes(random: &mut Random, count: u64) -> Vec<u8> {
    (0..count).map(|_| random.bits() as u8).collect()
}

/// Reads all bytes of a range, line by line.
fn read_range(text: &mut Vec<u8>, line: u64, begin: u64, end: u64) {
    let mut host = begin;
    while host < end {
        let next = end.min((host / line + 1) * line);
        push_request(text, b'r', &[host, next - host]);
        host = next;
    }
}

/// End of the addresses.
const END: u64 = 1 << 32;
/// Where addresses and counters of ranges end: lines, pages, 64 KB, 1 MB, 16 MB, 1, 2 and 3 GB.
const BORDERS: [u64; 10] =
    [0x40, 0x1000, 0x7000, 0x1_0000, 0x3_0000, 0x10_0000, 0x100_0000, 0x4000_0000, 0x8000_0000, 0xc000_0000];

fn writes_over_borders() -> Vec<u8> {
    let (mut random, mut text) = (Random::new(1), Vec::new());
    let mut put = |begin: u64, len: u64| {
        let (low, high) = (begin.saturating_sub(3), (begin + len + 3).min(END));
        write(&mut text, begin, &bytes(&mut random, len));
        push_request(&mut text, b'i', &[low, high - low]);
        read_range(&mut text, 64, low, high);
    };
    for len in (1..=40).chain([63, 64, 65, 100, 127, 128, 129, 255, 256, 257]) {
        for border in BORDERS {
            for before in
                (0..=len).filter(|before| len <= 18 || [0, 1, 2, len / 2, len - 1, len].contains(before))
            {
                put(border - before.min(border), len);
            }
        }
        put(END - len, len);
        put(0x1000 * len + 0x1001 - len % 2, len);
    }
    text
}

/// Most bytes of a write.
const LONGEST: u64 = 200_000;

fn long_writes() -> Vec<u8> {
    let (mut random, mut text) = (Random::new(2), Vec::new());
    let lengths = [
        1000, 2047, 4095, 4096, 4097, 10_000, 16_384, 32_767, 32_769, 65_535, 65_536, 65_537, 100_001,
        LONGEST,
    ];
    for (place, len) in (0..).zip(lengths) {
        let border = BORDERS[place % BORDERS.len()];
        for begin in [border - (len / 3).min(border), END - len, (1 << 24) * place as u64 + 5] {
            write(&mut text, begin, &bytes(&mut random, len));
            push_request(&mut text, b'i', &[begin, len]);
            let end = begin + len;
            let places = [
                begin,
                begin + len / 2,
                begin + (1 << 16).min(len - 1),
                begin + (1 << 15).min(len - 1),
                end - 1,
            ];
            for middle in places.into_iter().chain((0..20).map(|_| begin + random.below(len))) {
                read_range(&mut text, 128, middle.saturating_sub(64), (middle + 64).min(END));
            }
        }
    }
    text
}

/// Reads of a line and of its neighbours, between writes that begin before a line and end behind it.
fn neighbours(config: &str) -> Vec<u8> {
    let line = config::parse(config).map_or(16, |config| config.geometry.line().0);
    let (mut random, mut text) = (Random::new(3), Vec::new());
    for base in [0, 0x1_0000, 0x7fff_ff00, END - 16 * line] {
        for _ in 0..2000 {
            let at = |random: &mut Random| base + random.below(16) * line;
            let read = at(&mut random);
            push_request(&mut text, b'r', &[read, line]);
            let begin = at(&mut random) + random.below(line);
            let len = (1 + random.below(3 * line)).min(END - begin);
            write(&mut text, begin, &bytes(&mut random, len));
            if random.percent(70) {
                push_request(&mut text, b'i', &[begin, len]);
            }
            // Behind the line that was read, and behind those that were written.
            for host in [read + line, begin / line * line, (begin + len - 1) / line * line]
                .map(|host| host.min(END - line))
            {
                push_request(&mut text, b'r', &[host, line]);
            }
        }
    }
    text
}

/// Lines in and around each range are resident before it, and read again behind it.
fn ranges(config: &str) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let (line, lines) = (config.geometry.line().0, config.geometry.lines());
    let (mut random, mut text) = (Random::new(4), Vec::new());
    let mut lengths: Vec<u64> = (0..=lines.ilog2() + 2)
        .flat_map(|bit| [1 << bit, (1 << bit) + 1, (3 << bit) / 2])
        .map(|count: u64| count * line)
        .collect();
    lengths.extend(
        (0..32)
            .flat_map(|bit| [(1 << bit) - 1, 1 << bit, (1 << bit) + 1, 3 << bit])
            .filter(|len| (1..END).contains(len)),
    );
    lengths.extend([2, 3, 5, 7, 15, 31, 100, 255].map(|count| count << 16));
    for len in lengths {
        let half = len / 2;
        let borders = [0, 0x1_0000, 0x100_0000, 0x4000_0000, 0x8000_0000, 0xc000_0000, END];
        let around = random.pick(&borders);
        for begin in [
            random.below(END - len + 1),
            around.saturating_sub(half).min(END - len),
            (around.saturating_sub(line)).min(END - len) / line * line,
            0x8000_0000_u64.saturating_sub(half).min(END - len),
        ] {
            let (first, last) = (begin / line, (begin + len - 1) / line);
            let few = last - first + 1;
            let mut known =
                vec![first.saturating_sub(1), first, last, (last + 1).min(END / line - 1), first + few / 2];
            known.extend((0..12).map(|_| first + random.below(few)));
            known.extend((0..3).map(|_| random.below(END / line)));
            // Sixteen lines of one set, all in the range where it is long enough.
            known.extend((0..16).map(|way| first + (way * (few / 16).max(1)).min(few - 1)));
            known.iter().for_each(|line_| push_request(&mut text, b'r', &[line_ * line, 1]));
            push_request(&mut text, b'i', &[begin, len]);
            known.iter().for_each(|line_| push_request(&mut text, b'r', &[line_ * line, 1]));
        }
    }
    // Every way of some sets, all of which a range meets that is longer than the card, or half of it.
    for range in [lines / 2, lines - 1, lines, lines + 1, 4 * lines] {
        let all =
            || (0..4).flat_map(|set| (0..u64::from(config.geometry.ways())).map(move |upper| (set, upper)));
        let all = || all().map(|(set, upper)| line_in(&config, set, upper) * line);
        all().for_each(|host| push_request(&mut text, b'r', &[host, 1]));
        push_request(&mut text, b'i', &[0, range * line]);
        all().for_each(|host| push_request(&mut text, b'r', &[host, 1]));
    }
    text
}

/// The shape of a number: each length of a line with each policy, each number of ways with each policy; sets and hash
/// are drawn.
fn shape(number: u64) -> SizedSession {
    let mut random = Random::new(number);
    let (line_bits, policy) =
        (number % (LINE_BITS + 1), number / (LINE_BITS + 1) % config::POLICIES.len() as u64);
    let ways = config::WAYS;
    let ways = ways[((line_bits + policy + number / SHAPES) % ways.len() as u64) as usize];
    let (_, policy) = config::POLICIES[policy as usize];
    let config = config::text(&config::drawn(&mut random, line_bits, ways, policy));
    SizedSession::new(Vm, &format!("shape/{number}"), ANY, &config, move |config| shaped(config, number))
}

/// Bytes of a shape's lines that are read, about.
const SHAPE_BYTES: u64 = 1 << 19;

/// Lines of sets that are far apart, each with all of its bytes; more in each set than it has ways.
fn shaped(config: &str, number: u64) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let (line, sets, ways) =
        (config.geometry.line().0, config.geometry.sets(), u64::from(config.geometry.ways()));
    let (mut random, mut text) = (Random::new(number), Vec::new());
    let middle = random.below(sets);
    let mut chosen: Vec<u64> = vec![0, sets - 1, middle, middle ^ (sets / 2)];
    chosen.extend((0..sets.ilog2()).map(|bit| middle ^ (1 << bit)));
    let line_of = |random: &mut Random| {
        let few = random.below(ways + ways.div_ceil(2) + 1);
        let upper = if random.percent(10) { random.below(uppers(&config)) } else { few };
        line_in(&config, random.pick(&chosen), upper % uppers(&config))
    };
    let whole = (SHAPE_BYTES / line).clamp(8, 400);
    for _ in 0..whole {
        let at = line_of(&mut random);
        let long = line.min(1 << 14);
        let from = random.pick(&[0, line - long]);
        write(&mut text, at * line + from, &bytes(&mut random, long));
        push_request(&mut text, b'i', &[at * line, 1]);
        push_request(&mut text, b'r', &[at * line, line]);
    }
    for _ in 0..4000 + 400 * ways {
        let at = line_of(&mut random) * line;
        match random.below(400) {
            0 => text.extend_from_slice(b"flush\n"),
            1..6 => push_request(&mut text, b'i', &[at, (1 + random.below(4 * line)).min(END - at)]),
            6..10 => write(&mut text, at + random.below(line), &[random.bits() as u8]),
            _ => push_request(&mut text, b'r', &[at + random.pick(&[0, line / 2, line - 1]), 1]),
        }
    }
    text
}

/// Lines of every set and way: loaded, used in another order in each set, evicted, flushed, and read again.
fn every_set(config: &str) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let (line, sets, ways) =
        (config.geometry.line().0, config.geometry.sets(), u64::from(config.geometry.ways()));
    let (mut random, mut text) = (Random::new(5), Vec::new());
    let bits = sets.ilog2();
    // One behind the other come sets whose numbers differ in the highest bits alone.
    let order = |place: u64| place.reverse_bits() >> (64 - bits);
    let host = |set: u64, upper: u64| line_in(&config, set, upper) * line;
    let read = |text: &mut Vec<u8>, host: u64| push_request(text, b'r', &[host, 1]);
    for upper in 0..ways {
        (0..sets).for_each(|place| read(&mut text, host(order(place), upper)));
    }
    for place in 0..sets {
        read(&mut text, host(order(place), random.below(ways)));
    }
    for place in 0..sets {
        read(&mut text, host(order(place), ways + random.below(2)));
    }
    text.extend_from_slice(b"flush\n");
    for place in 0..sets {
        read(&mut text, host(order(place), random.below(ways)));
    }
    text
}

/// Lines of sets and ways that are far apart have other bytes after a flush.
fn flush(config: &str) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let (line, sets, ways) =
        (config.geometry.line().0, config.geometry.sets(), u64::from(config.geometry.ways()));
    let mut text = Vec::new();
    for byte in 1..4 {
        for place in 0..512 {
            let set = place * (sets / 512) + place % (sets / 512);
            for upper in 0..ways {
                let host = line_in(&config, set, upper) * line;
                write(&mut text, host, &[byte, place as u8]);
                push_request(&mut text, b'r', &[host, 2]);
            }
        }
        text.extend_from_slice(b"flush\n");
    }
    text
}

/// What `by` appends for an address, then a read of it, so many times.
fn counted(config: &str, times: usize, by: fn(&mut Vec<u8>, u64, u8)) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let host = line_in(&config, 1, 1) * config.geometry.line().0;
    let mut text = Vec::new();
    for time in 0..times {
        by(&mut text, host, time as u8);
        push_request(&mut text, b'r', &[host, 1]);
    }
    text
}

/// So many requests for lines that collide, in a few sets far apart; what they evict is read again soon.
fn long(config: &str, seed: u64, count: usize) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let (line, sets, ways) =
        (config.geometry.line().0, config.geometry.sets(), u64::from(config.geometry.ways()));
    let (mut random, mut text) = (Random::new(seed), Vec::new());
    let chosen: Vec<u64> = (0..8).map(|_| random.below(sets)).collect();
    for made in 0..count {
        let host = line_in(&config, random.pick(&chosen), random.below(ways + 2)) * line;
        match random.below(50_000) {
            0 => text.extend_from_slice(b"flush\n"),
            1..100 => push_request(&mut text, b'i', &[host, 1]),
            // Each line is written to, and read with its own byte, now and then.
            100..1000 => write(&mut text, host, &[made as u8]),
            _ => push_request(&mut text, b'r', &[host, 1]),
        }
    }
    text
}
