//! The configuration of `saarcor-vm`: `line=128 lines=65536 ways=4 hash=add-upper policy=lru`.

use crate::error::Error;
use crate::words::{Choices, Values, name_of};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
use saarcor_random::Random;

/// Most bytes of a line of a session (Assumed), so that answers have a longest.
pub const MAX_LINE_BYTES: usize = 1 << 16;

/// Hashes by their names.
pub const HASHES: Choices<Hash> =
    &[("low", Hash::Low), ("add-upper", Hash::AddUpper), ("add-upper-all", Hash::AddUpperAll)];

/// Policies by their names.
pub const POLICIES: Choices<Policy> = &[("lru", Policy::Lru), ("fifo", Policy::Fifo), ("plru", Policy::Plru)];

/// Most bytes of on-board memory of a session (Assumed: twice the paper's largest; the kit holds it
/// once for each session that runs).
pub const MAX_MEMORY: Bytes = Bytes(128 << 20);

/// Most lines of a session: the kit holds the metadata of each.
const MAX_LINES: u64 = 1 << 21;

/// Numbers of ways.
pub const WAYS: [u32; 5] = [1, 2, 4, 8, 16];

/// Most bytes of memory that is drawn, and most lines, as powers of two: more take too long to flush, again and again.
const DRAWN_MEMORY_BITS: u64 = 26;
const DRAWN_LINES_BITS: u64 = 18;

/// The keys of a configuration.
pub const KEYS: [&str; 5] = ["line", "lines", "ways", "hash", "policy"];

/// The cache that a configuration names.
///
/// # Errors
/// The key that is wrong, and what would be right.
pub fn parse(config: &str) -> Result<CacheConfig, Error> {
    cache_of(&Values::parse(config, &KEYS)?)
}

/// The cache that some of a configuration's values name.
pub(crate) fn cache_of(values: &Values<'_>) -> Result<CacheConfig, Error> {
    let (line, lines): (u64, u64) = (values.number("line")?, values.number("lines")?);
    let ways = u32::try_from(values.number::<u64>("ways")?).unwrap_or(u32::MAX);
    let memory = Bytes(line.saturating_mul(lines));
    let geometry = Geometry::new(memory, Bytes(line), ways).map_err(|error| error.to_string())?;
    if memory > MAX_MEMORY || lines > MAX_LINES || line > MAX_LINE_BYTES as u64 {
        return Err(format!(
            "{lines} lines of {line} bytes: at most {MAX_LINES} lines of {MAX_LINE_BYTES}, and {} bytes in all",
            MAX_MEMORY.0
        )
        .into());
    }
    let (hash, policy) = (values.named("hash", HASHES)?, values.named("policy", POLICIES)?);
    Ok(CacheConfig { geometry, hash, policy })
}

/// The configuration that [`parse`] reads back.
#[must_use]
pub fn text(config: &CacheConfig) -> String {
    let CacheConfig { geometry, hash, policy } = config;
    format!(
        "line={} lines={} ways={} hash={} policy={}",
        geometry.line().0,
        geometry.lines(),
        geometry.ways(),
        name_of(HASHES, hash),
        name_of(POLICIES, policy)
    )
}

/// A cache of lines of so many bytes, whose number of sets, any power of two, and whose hash are drawn.
#[must_use]
pub(crate) fn drawn(random: &mut Random, line_bits: u64, ways: u32, policy: Policy) -> CacheConfig {
    let most = DRAWN_LINES_BITS.min(DRAWN_MEMORY_BITS - line_bits);
    let set_bits = random.below(most + 1 - u64::from(ways.ilog2()));
    let memory = Bytes(u64::from(ways) << (line_bits + set_bits));
    let geometry = Geometry::new(memory, Bytes(1 << line_bits), ways).expect("powers of two");
    let (_, hash) = random.pick(HASHES);
    CacheConfig { geometry, hash, policy }
}

/// The cache of a seed: any of all that can be drawn.
#[must_use]
pub(crate) fn of_seed(random: &mut Random) -> CacheConfig {
    let line_bits = random.below(u64::from(MAX_LINE_BYTES.ilog2()) + 1);
    let (ways, (_, policy)) = (random.pick(&WAYS), random.pick(POLICIES));
    drawn(random, line_bits, ways, policy)
}

/// Configurations that are simpler by one step: fewer ways, fewer sets, shorter lines, `low`, `lru`.
#[must_use]
pub fn simpler(config: &CacheConfig) -> Vec<CacheConfig> {
    let CacheConfig { geometry, hash, policy } = *config;
    let (line, lines, ways) = (geometry.line().0, geometry.lines(), geometry.ways());
    let with = |line: u64, lines: u64, ways: u32, hash, policy| {
        let geometry = Geometry::new(Bytes(line * lines), Bytes(line), ways).ok()?;
        Some(CacheConfig { geometry, hash, policy })
    };
    // Bold steps first: where they do, the small ones are not needed.
    let mut steps = vec![with(line, u64::from(ways), ways, hash, policy)];
    steps.push(with(line, lines / u64::from(ways), 1, hash, policy));
    steps.push(with(line, lines / 2, ways / 2, hash, policy));
    steps.push(with(line, lines / 2, ways, hash, policy));
    if line > 16 {
        steps.push(with(16, lines, ways, hash, policy));
    }
    steps.push(with(line / 2, lines, ways, hash, policy));
    steps.push(with(line, lines, ways, Hash::Low, policy));
    steps.push(with(line, lines, ways, hash, Policy::Lru));
    steps.into_iter().flatten().filter(|simpler| simpler != config).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configurations_read_back() {
        let text = "line=128 lines=65536 ways=4 hash=add-upper policy=lru";
        let config = parse(text).expect("the paper's");
        assert_eq!((config.geometry.memory(), config.geometry.sets()), (Bytes(8 << 20), 16384));
        assert_eq!(super::text(&config), text);
        assert_eq!(parse("policy=lru ways=4 hash=add-upper lines=65536 line=128").ok(), Some(config));
    }

    #[test]
    fn wrong_configurations_are_refused() {
        let whole = "line=16 lines=8 ways=2 hash=low policy=lru";
        for (from, to, says) in [
            ("line=16", "line=24", "power of two"),
            ("lines=8", "lines=1", "smaller than one set"),
            ("ways=2", "ways=99999999999", "ways"),
            ("hash=low", "hash=upper", "add-upper-all"),
            ("policy=lru", "", "policy is missing"),
            ("policy=lru", "polcy=lru", "polcy"),
            ("lines=8", "lines=4294967296", "at most"),
            ("lines=8", "lines=x", "decimal"),
            ("line=16", "line", "KEY=VALUE"),
        ] {
            let error = parse(&whole.replace(from, to)).expect_err("none").to_string();
            assert!(error.contains(says), "{from} -> {to}: {error}");
        }
    }

    #[test]
    fn simpler_configurations_end() {
        let mut config =
            parse("line=128 lines=65536 ways=4 hash=add-upper policy=plru").expect("the paper's");
        while let Some(next) = simpler(&config).last() {
            config = *next;
        }
        assert_eq!(text(&config), "line=1 lines=1 ways=1 hash=low policy=lru");
    }
}
