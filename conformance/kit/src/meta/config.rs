//! The configuration of `saarcor-meta`: that of `saarcor-vm`, and
//! `granule=16 meta-sets=1024 meta-ways=4 faults=0`.

use crate::error::Error;
use crate::vm::config;
use crate::words::Values;
use saarcor_model::vm::{CacheConfig, ENTRY_BYTES};

/// Bytes of a granule that the kit's model is built for.
pub const GRANULES: &[usize] = &[8, 16];
/// Ways of the metadata cache that it is built for.
pub const META_WAYS: &[usize] = &[1, 2, 4];

/// Most sets of the metadata cache (Assumed: sixteen times the paper's).
pub const MAX_META_SETS: usize = 1 << 14;

/// The keys of a configuration.
pub fn keys() -> impl Iterator<Item = &'static str> {
    config::KEYS.into_iter().chain(["granule", "meta-sets", "meta-ways", "faults"])
}

/// What version B depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MetaConfig {
    /// The cache of lines.
    pub cache: CacheConfig,
    /// Bytes of a granule.
    pub granule: usize,
    /// Sets of the metadata cache.
    pub sets: usize,
    /// Its ways.
    pub ways: usize,
    /// Whether metadata on the card is made corrupt.
    pub faults: bool,
}

impl MetaConfig {
    /// Granules of one set of lines that belong to one set of the metadata cache, at most.
    #[must_use]
    pub fn granules_together(&self) -> usize {
        let set = self.cache.geometry.ways() as usize * ENTRY_BYTES;
        // A set begins at multiples of the largest power of two that divides both.
        let step = self.granule.min(1 << set.trailing_zeros());
        (self.granule - step + set).div_ceil(self.granule).div_ceil(self.sets)
    }

    /// Whether the metadata cache holds all granules of a set at once: then none is evicted while the set is read, and what
    /// was cached is what is decoded.
    #[must_use]
    pub fn holds_a_set(&self) -> bool {
        self.granules_together() <= self.ways
    }

    /// Bytes of all metadata.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.cache.geometry.lines() * ENTRY_BYTES as u64
    }
}

/// The version B that a configuration names.
///
/// # Errors
/// The key that is wrong, and what would be right.
pub fn parse(text: &str) -> Result<MetaConfig, Error> {
    let values = Values::parse(text, &keys().collect::<Vec<_>>())?;
    let cache = config::cache_of(&values)?;
    let one_of = |key: &str, all: &[usize]| -> Result<usize, Error> {
        let value = values.number(key)?;
        if all.contains(&value) {
            return Ok(value);
        }
        let all: Vec<_> = all.iter().map(usize::to_string).collect();
        Err(format!("{key}={value}: write one of {}", all.join(", ")).into())
    };
    let sets: usize = values.number("meta-sets")?;
    if !sets.is_power_of_two() || sets > MAX_META_SETS {
        return Err(format!("meta-sets={sets}: it must be a power of two up to {MAX_META_SETS}").into());
    }
    let (granule, ways) = (one_of("granule", GRANULES)?, one_of("meta-ways", META_WAYS)?);
    let config = MetaConfig { cache, granule, sets, ways, faults: one_of("faults", &[0, 1])? == 1 };
    if config.faults && !config.holds_a_set() {
        let granules = config.granules_together();
        return Err(format!(
            "faults=1: {granules} granules of a set share a set of the metadata cache, so meta-ways must be at least that; \
             it is {ways}"
        )
        .into());
    }
    Ok(config)
}

/// The configuration that [`parse`] reads back.
#[must_use]
pub fn text(config: &MetaConfig) -> String {
    let MetaConfig { cache, granule, sets, ways, faults } = config;
    let cache = config::text(cache);
    format!("{cache} granule={granule} meta-sets={sets} meta-ways={ways} faults={}", u8::from(*faults))
}

/// Configurations that are simpler by one step.
#[must_use]
pub fn simpler(config: &MetaConfig) -> Vec<MetaConfig> {
    let mut steps = vec![MetaConfig { sets: 1, ..*config }, MetaConfig { sets: 1, ways: 1, ..*config }];
    steps.extend(config::simpler(&config.cache).into_iter().map(|cache| MetaConfig { cache, ..*config }));
    steps.push(MetaConfig { sets: (config.sets / 2).max(1), ..*config });
    steps.push(MetaConfig { ways: (config.ways / 2).max(1), ..*config });
    steps.retain(|simpler| simpler != config && (!simpler.faults || simpler.holds_a_set()));
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANDARD: &str = "line=128 lines=65536 ways=4 hash=add-upper policy=lru granule=16 meta-sets=1024 \
                            meta-ways=4 faults=0";

    #[test]
    fn configurations_read_back() {
        let config = parse(STANDARD).expect("the paper's");
        assert_eq!(text(&config), STANDARD);
        assert_eq!((config.granule * config.sets * config.ways, config.bytes()), (64 << 10, 5 * 65536));
    }

    #[test]
    fn wrong_configurations_are_refused() {
        for (from, to, says) in [
            ("granule=16", "granule=24", "8, 16"),
            ("meta-sets=1024", "meta-sets=3", "power of two"),
            ("meta-ways=4", "meta-ways=8", "1, 2, 4"),
            (" ways=4", " ways=32", "1 to 16"),
            ("faults=0", "", "faults is missing"),
            ("faults=0", "fault=0", "fault"),
            ("line=128", "line=x", "decimal"),
            ("meta-sets=1024 meta-ways=4 faults=0", "meta-sets=1 meta-ways=1 faults=1", "at least"),
        ] {
            let error = parse(&STANDARD.replacen(from, to, 1)).expect_err("none").to_string();
            assert!(error.contains(says), "{from} -> {to}: {error}");
        }
    }

    #[test]
    fn simpler_configurations_end() {
        let mut config = parse(STANDARD).expect("the paper's");
        while let Some(next) = simpler(&config).last() {
            config = *next;
        }
        assert_eq!((config.sets, config.ways, config.cache.geometry.lines()), (1, 1, 1));
    }
}
