//! Sessions of `saarcor-meta` about the sizes that people build.

use super::Meta;
use super::config::{self, GRANULES, MAX_META_SETS, META_WAYS, MetaConfig};
use crate::hex::push_request;
use crate::sizes::{About, Extent, SizedSession, repeated};
use crate::vm::config::{HASHES, POLICIES, WAYS};
use crate::vm::sizes::{line_in, uppers};
use saarcor_model::vm::{Bytes, CacheConfig, ENTRY_BYTES, Geometry};
use saarcor_random::Random;

/// Shapes of a plan: each number of ways with each policy and granule, and each number of sets of the
/// metadata cache twice.
const SHAPES: u64 = WAYS.len() as u64 * POLICIES.len() as u64 * GRANULES.len() as u64;

const STANDARD: &str =
    "line=128 lines=65536 ways=4 hash=add-upper policy=lru granule=16 meta-sets=1024 meta-ways=4 faults=0";
const SMALL: &str =
    "line=16 lines=64 ways=4 hash=add-upper policy=lru granule=16 meta-sets=2 meta-ways=2 faults=0";
const SIXTEEN_WAYS: &str =
    "line=16 lines=256 ways=16 hash=add-upper policy=lru granule=16 meta-sets=4 meta-ways=2 faults=0";

/// All, in order.
pub fn sessions(extent: &Extent) -> Vec<SizedSession> {
    let seed = extent.seed;
    let new = |name: &str, about: About, config: &str, requests: fn(&MetaConfig, u64) -> Vec<u8>| {
        let made =
            move |config: &str| requests(&config::parse(config).expect("a configuration of the kit"), seed);
        SizedSession::new(Meta, name, about, config, made)
    };
    let whole = ("VM-13", None, "Every set and every granule of the standard chip's metadata.");
    let mut all = vec![new("sizes/every-granule", whole, STANDARD, every_granule)];
    let ranges = ("VM-8", None, "Ranges of many lengths.");
    all.push(new("sizes/ranges", ranges, STANDARD, self::ranges));
    all.push(new("sizes/ranges@lines=64", ranges, SMALL, self::ranges));
    let wide = ("VM-12", None, "The number of a way of sixteen takes all four management bits.");
    all.push(new("sizes/sixteen-ways", wide, SIXTEEN_WAYS, shaped));
    for number in 0..SHAPES {
        let number = seed.wrapping_mul(SHAPES).wrapping_add(number);
        let made =
            move |config: &str| shaped(&config::parse(config).expect("a configuration of the kit"), number);
        let about = ("VM-13", None, "Granules that collide, and a metadata cache of any size.");
        all.push(SizedSession::new(Meta, &format!("shape/{number}"), about, &shape(number), made));
    }
    let requests = extent.long();
    let about = ("", None, "More requests than counters count.");
    let long = move |config: &str| {
        let config = config::parse(config).expect("a configuration of the kit");
        repeated(requests, |count| long(&config, count))
    };
    all.push(SizedSession::new(Meta, "sizes/long", about, SMALL, long).large());
    all
}

/// Uses each line's set three times: a line, then this one again or another.
fn every_granule(config: &MetaConfig, seed: u64) -> Vec<u8> {
    let (mut random, mut text) = (Random::new(seed), Vec::new());
    let (line, sets) = (config.cache.geometry.line().0, config.cache.geometry.sets());
    for _ in 0..3 {
        for set in 0..sets {
            push_request(&mut text, b'r', &[line_in(&config.cache, set, random.below(2)) * line]);
        }
    }
    // Victims of sets all over the card.
    for set in (0..sets).step_by(37) {
        for _ in 0..2 * config.cache.geometry.ways() {
            push_request(&mut text, b'r', &[line_in(&config.cache, set, random.below(6)) * line]);
        }
    }
    text
}

/// Most lines of a range: what moves for them fits into an answer.
const LONGEST: u64 = 1100;

/// Lines of each range are resident before it.
fn ranges(config: &MetaConfig, seed: u64) -> Vec<u8> {
    let (mut random, mut text) = (Random::new(seed), Vec::new());
    let geometry = config.cache.geometry;
    let (line, most) = (geometry.line().0, (geometry.lines() - 1).min(LONGEST));
    let lengths =
        (1..=100).chain([127, 128, 129, 255, 256, 257, 500, 511, 512, 513, 1000, 1023, 1024, 1025, LONGEST]);
    for count in lengths.filter(|count| *count <= most) {
        let first = random.below((1 << 32) / line - count);
        let known = [0, 1, 7, 15, 29, 30, 31, 32, 33, 62, 63, 64, 127, 255, 511, 1023];
        let known: Vec<u64> =
            known.into_iter().filter(|place| *place < count).chain([count / 2, count - 1, count]).collect();
        for again in [false, true] {
            if again {
                let len = (count - 1) * line + 1;
                push_request(&mut text, b'i', &[first * line + random.below(line), len - line.min(len) + 1]);
                push_request(&mut text, b'i', &[first * line, len]);
            }
            known.iter().for_each(|place| push_request(&mut text, b'r', &[(first + place) * line]));
        }
    }
    text
}

/// The configuration of a number: each number of ways with each policy and granule; what is left is drawn.
fn shape(number: u64) -> String {
    let mut random = Random::new(number);
    let place = |all: usize, step: u64| (number / step % all as u64) as usize;
    let ways = WAYS[place(WAYS.len(), 1)];
    let (_, policy) = POLICIES[place(POLICIES.len(), 5)];
    let granule = GRANULES[place(GRANULES.len(), 15)];
    let kinds = MAX_META_SETS.ilog2() as u64 + 1;
    let sets = 1_usize << ((number * 7 + number / kinds) % kinds);
    let meta_ways = random.pick(META_WAYS);
    // Twice as many granules as the cache holds, and some sets at least.
    let bytes = 2 * (granule * sets * meta_ways) as u64;
    let sets_of_lines = (bytes / (u64::from(ways) * ENTRY_BYTES as u64) + 4).next_power_of_two();
    let lines = sets_of_lines << random.below(2).min(u64::from(sets < 1 << 12)) << ways.ilog2();
    let most = (1_u64 << 26) / lines;
    let line = 1 << random.below(u64::from(most.ilog2().min(12)) + 1);
    let geometry = Geometry::new(Bytes(line * lines), Bytes(line), ways).expect("powers of two");
    let (_, hash) = random.pick(HASHES);
    let cache = CacheConfig { geometry, hash, policy };
    config::text(&MetaConfig { cache, granule, sets, ways: meta_ways, faults: false })
}

/// Requests of a shape.
const SHAPE_REQUESTS: usize = 3000;

/// Lines of sets whose granules meet in a few sets of the metadata cache, more than it has ways.
fn shaped(config: &MetaConfig, number: u64) -> Vec<u8> {
    let (mut random, mut text) = (Random::new(number), Vec::new());
    let geometry = config.cache.geometry;
    let (line, ways) = (geometry.line().0, u64::from(geometry.ways()));
    let (granules, sets) = (config.bytes() / config.granule as u64, config.sets as u64);
    let entry_set = |granule: u64| granule * config.granule as u64 / (ways * ENTRY_BYTES as u64);
    let mut chosen = vec![0, geometry.sets() - 1];
    for meta_set in [0, sets - 1, sets / 2, random.below(sets), random.below(sets)] {
        let there = granules.saturating_sub(meta_set).div_ceil(sets);
        for _ in 0..(config.ways as u64 + 2).min(there) {
            chosen.push(
                entry_set((meta_set + random.below(there) * sets).min(granules - 1)).min(geometry.sets() - 1),
            );
        }
    }
    for _ in 0..SHAPE_REQUESTS + 100 * ways as usize {
        let few = random.below(ways + ways.div_ceil(2) + 1);
        let upper = if random.percent(5) { random.below(uppers(&config.cache)) } else { few };
        let host = line_in(&config.cache, random.pick(&chosen), upper % uppers(&config.cache)) * line;
        match random.below(500) {
            0 => text.extend_from_slice(b"flush\n"),
            1..20 if geometry.lines() > 1 => push_request(&mut text, b'i', &[host, 1]),
            _ => push_request(&mut text, b'r', &[host + random.below(line)]),
        }
    }
    text
}

/// So many requests for lines that collide.
fn long(config: &MetaConfig, count: usize) -> Vec<u8> {
    let (mut random, mut text) = (Random::new(8), Vec::new());
    let geometry = config.cache.geometry;
    let (line, ways) = (geometry.line().0, u64::from(geometry.ways()));
    for _ in 0..count {
        let host = line_in(&config.cache, random.below(geometry.sets()), random.below(ways + 2)) * line;
        let name = if random.percent(2) { b'i' } else { b'r' };
        if name == b'i' {
            push_request(&mut text, name, &[host, 1])
        } else {
            push_request(&mut text, name, &[host])
        }
    }
    text
}
