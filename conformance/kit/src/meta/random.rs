//! Random sessions of `saarcor-meta`, weighted to collide in the cache of lines and in that of
//! metadata.

use super::config::{self, MetaConfig};
use crate::hex::push_request;
use saarcor_model::vm::ENTRY_BYTES;
use saarcor_random::Random;
use std::collections::BTreeSet;

/// Configurations that seeds go through: the small geometry first, then others.
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
    "line=16 lines=32 ways=4 hash=low policy=plru granule=16 meta-sets=1 meta-ways=1 faults=1",
    "line=16 lines=128 ways=2 hash=add-upper policy=lru granule=8 meta-sets=2 meta-ways=2 faults=0",
];

/// The configuration of a seed.
#[must_use]
pub fn config_of(seed: u64) -> &'static str {
    CONFIGS[(seed % CONFIGS.len() as u64) as usize]
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
            0..40 => {
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
        for seed in 0..4 * CONFIGS.len() as u64 {
            let session = Meta.random(seed, 300);
            Meta.check(&session).expect("legal");
            assert_eq!(session.requests().count(), 300, "{seed}");
        }
    }
}
