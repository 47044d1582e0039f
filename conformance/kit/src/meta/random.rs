//! Random sessions of `saarcor-meta`, weighted to collide in the cache of lines and in that of
//! metadata.

use super::config::{self, GRANULES, MAX_META_SETS, META_WAYS, MetaConfig};
use crate::hex::push_request;
use saarcor_model::vm::ENTRY_BYTES;
use saarcor_random::Random;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// The configurations of the even seeds, in turn: the small geometry first, then others. Those of the odd seeds are drawn.
const CONFIGS: &[&str] = &[
    "line=16 lines=8 ways=4 hash=low policy=lru granule=16 meta-sets=1 meta-ways=2 faults=0",
    "line=16 lines=64 ways=4 hash=add-upper policy=lru granule=16 meta-sets=1 meta-ways=4 faults=0",
    "line=16 lines=8 ways=4 hash=low policy=fifo granule=16 meta-sets=1 meta-ways=2 faults=0",
    "line=16 lines=64 ways=4 hash=add-upper policy=lru granule=16 meta-sets=2 meta-ways=2 faults=1",
    "line=16 lines=8 ways=4 hash=low policy=plru granule=16 meta-sets=1 meta-ways=2 faults=0",
    "line=16 lines=64 ways=8 hash=low policy=plru granule=8 meta-sets=2 meta-ways=4 faults=1",
    "line=32 lines=32 ways=2 hash=add-upper-all policy=fifo granule=8 meta-sets=4 meta-ways=1 faults=1",
    "line=128 lines=65536 ways=4 hash=add-upper policy=lru granule=16 meta-sets=1024 meta-ways=4 faults=0",
    "line=64 lines=16 ways=1 hash=add-upper policy=lru granule=16 meta-sets=1 meta-ways=1 faults=0",
    "line=128 lines=1024 ways=4 hash=add-upper policy=lru granule=16 meta-sets=8 meta-ways=4 faults=1",
    "line=16 lines=32 ways=4 hash=low policy=plru granule=16 meta-sets=2 meta-ways=1 faults=1",
    "line=16 lines=128 ways=2 hash=add-upper policy=lru granule=8 meta-sets=2 meta-ways=2 faults=0",
];

/// The configuration of a seed.
#[must_use]
pub fn config_of(seed: u64) -> Cow<'static, str> {
    if seed.is_multiple_of(2) {
        return CONFIGS[(seed / 2 % CONFIGS.len() as u64) as usize].into();
    }
    // The requests are drawn from the seed itself.
    config::text(&drawn(&mut Random::new(!seed))).into()
}

/// Any cache of lines, and a metadata cache of any size up to one that holds all its metadata.
fn drawn(random: &mut Random) -> MetaConfig {
    let cache = crate::vm::config::of_seed(random);
    let (granule, ways) = (random.pick(GRANULES), random.pick(META_WAYS));
    let config = MetaConfig { cache, granule, sets: 1, ways, faults: random.percent(50) };
    let holds_all = config.bytes().div_ceil((granule * ways) as u64).next_power_of_two();
    let most = holds_all.min(MAX_META_SETS as u64).ilog2();
    let config = MetaConfig { sets: 1 << random.below(u64::from(most) + 1), ..config };
    MetaConfig { faults: config.faults && config.holds_a_set(), ..config }
}

/// Sets whose lines are used: over twice as many as the metadata cache has ways.
const TARGET_SETS: u64 = 10;

/// The requests of a seed, each with its newline.
///
/// # Panics
/// If `config` is none.
#[must_use]
pub fn requests(config: &str, seed: u64, count: usize) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let mut random = Random::new(seed);
    let pool = pool(&config, &mut random);
    let mut flipped = BTreeSet::new();
    let mut text = Vec::new();
    let (size, lines) = (config.cache.geometry.line().0, config.cache.geometry.lines());
    for _ in 0..count {
        let host = random.pick(&pool) * size + random.below(size);
        match random.below(1000) {
            // A range meets fewer lines than the card has.
            0..40 if lines > 1 => {
                let most = (lines - 1).min(3);
                let len = (1 + random.below(most * size - size + 1)).min((1 << 32) - host);
                push_request(&mut text, b'i', &[host, len]);
            }
            40..43 => {
                flipped.clear();
                text.extend_from_slice(b"flush\n");
            }
            43..70 if config.faults => {
                let byte = random.below(config.bytes());
                // Near the first: where the sets of the pool lie.
                let byte = if random.percent(75) { byte % (4 * ENTRY_BYTES as u64) } else { byte };
                let mask = random.pick(&[1, 2, 3, 5, 7, 0x10, 0x80, 0xe0]);
                if flipped.insert(byte / ENTRY_BYTES as u64) {
                    push_request(&mut text, b'x', &[byte, mask]);
                } else {
                    push_request(&mut text, b'r', &[host]);
                }
            }
            _ => push_request(&mut text, b'r', &[host]),
        }
    }
    text
}

/// Lines that collide: in neighbouring sets, which share granules, and in sets whose granules share a set of the
/// metadata cache; more in each set than it has ways.
fn pool(config: &MetaConfig, random: &mut Random) -> Vec<u64> {
    let geometry = config.cache.geometry;
    let (sets, ways) = (geometry.sets(), u64::from(geometry.ways()));
    let host_lines = (1 << 32) / geometry.line().0;
    // As many sets as have the bytes of all sets of the metadata cache, once.
    let around = (config.granule * config.sets / ENTRY_BYTES) as u64 / ways + 1;
    let mut pool = Vec::new();
    for place in 0..TARGET_SETS {
        let set = if place < 4 { place } else { place * around };
        for _ in 0..ways + 1 + random.below(ways) {
            let tag =
                if random.percent(10) { random.below(host_lines / sets) } else { random.below(2 * ways) };
            pool.push((set % sets + tag * sets) % host_lines);
        }
    }
    pool
}

#[cfg(test)]
mod tests {
    use super::super::Meta;
    use super::*;
    use crate::kind::Kind as _;

    #[test]
    fn sessions_are_legal_and_of_the_size_asked_for() {
        for seed in 0..200 {
            let session = Meta.random(seed, 300);
            Meta.check(&session).expect("legal");
            assert_eq!(session.requests().count(), 300, "{seed}");
        }
    }

    /// Half of the seeds have a configuration of their own, and among some hundreds of them is each size of the
    /// metadata cache.
    #[test]
    fn configurations_are_drawn_by_seed_over_all_powers_of_two() {
        let drawn: Vec<_> =
            (0..400).map(|number| config::parse(&config_of(2 * number + 1)).expect("legal")).collect();
        let values = |of: fn(&MetaConfig) -> usize| drawn.iter().map(of).collect::<BTreeSet<_>>();
        assert!(values(|config| config.sets).into_iter().eq((0..=14).map(|bit| 1 << bit)));
        assert!(values(|config| config.ways).into_iter().eq(META_WAYS.iter().copied()));
        assert!(values(|config| config.granule).into_iter().eq(GRANULES.iter().copied()));
        assert!(values(|config| config.cache.geometry.line().0 as usize).len() == 17);
        assert!(values(|config| usize::from(config.faults)).len() == 2);
        let evicts =
            |config: &&MetaConfig| config.bytes() > (config.granule * config.ways * config.sets) as u64;
        assert!(drawn.iter().filter(evicts).count() > drawn.len() / 2);
    }
}
