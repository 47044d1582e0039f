//! The configuration of `saarcor-chip`: the numbers of the chip by short names, each left out where
//! it is the standard chip's.

use crate::error::Error;
use crate::vm::config;
use crate::words::{Choices, Values, name_of};
use saarcor_model::time::standard::{self, CHIP_CACHE_WAYS};
use saarcor_model::time::{ChipConfig, Version};
use saarcor_model::vm::{CacheConfig, Geometry, Hash, HostAddr, Policy};
use std::sync::LazyLock;

/// Every key, in order.
const KEYS: &str = "pipelines threads \
    s-rate s-latency s-line s-sets s-ports s-look-up s-mshrs \
    n-rate n-latency n-line n-sets n-ports n-look-up n-mshrs \
    l-rate l-latency l-line l-sets l-ports l-look-up l-mshrs \
    t-rate t-latency t-line t-sets t-ports t-look-up t-mshrs \
    tag return version line lines ways hash policy granule meta-sets \
    clock beat banks row cl rcd rp ras rc rrd wr refresh rfc \
    pci-setup pci-beat pci-clock triangles tolerance";

/// The chip of a session that names nothing else (CH-2, CH-3, CH-17, SD-1 to SD-5, PC-1): every key with its value, in
/// order. It is the standard chip but for its policy and its granules: with LRU a hit writes metadata too, and with
/// granules of 16 bytes a set has two of them, so that more can go wrong.
pub static STANDARD: LazyLock<String> = LazyLock::new(|| {
    let geometry = Geometry::new(standard::MEMORY, standard::LINE, standard::WAYS).expect("the paper's");
    let cache = CacheConfig { geometry, hash: Hash::default(), policy: Policy::Lru };
    let mut chip = ChipConfig::standard(Version::A, cache);
    chip.metadata_cache.granule = 16;
    let mut setting =
        Setting { chip, meta_sets: chip.metadata_cache.sets(), triangles: HostAddr(0), tolerance: 0 };
    keys().map(|key| format!("{key}={}", setting.value(key))).collect::<Vec<_>>().join(" ")
});

/// Versions by their names.
const VERSIONS: Choices<Version> = &[("none", Version::None), ("a", Version::A), ("b", Version::B)];

/// Units by their letters, in the order of the model's ports.
pub const UNITS: [&str; 4] = ["s", "n", "l", "t"];

/// Largest number but an address (Assumed), so that a session has an end.
const MAX_NUMBER: u32 = 1 << 16;

/// Greatest tolerance in thousandths (Assumed): a timing that is off by more is none.
pub const MAX_TOLERANCE: u32 = 100;

/// What a session is about.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The chip.
    pub chip: ChipConfig,
    /// Sets of the metadata cache.
    meta_sets: u32,
    /// Where the lines of the triangle cache begin (L1-1).
    pub triangles: HostAddr,
    /// By how many thousandths counts may differ.
    pub tolerance: u32,
}

impl Setting {
    /// Whether what moves does not depend on when it does: a thread alone does one thing after the other.
    #[must_use]
    pub fn is_sequential(&self) -> bool {
        self.chip.pipelines * self.chip.threads == 1
    }

    /// The value of a key.
    fn value(&mut self, key: &str) -> String {
        if let Some(number) = self.number(key) {
            return number.to_string();
        }
        let cache = config::text(&self.chip.cache);
        let of_cache = words(&cache).find(|(known, _)| *known == key).map(|(_, value)| value.to_owned());
        of_cache.unwrap_or_else(|| name_of(VERSIONS, &self.chip.version).to_owned())
    }

    /// The number of a key.
    fn number(&mut self, key: &str) -> Option<&mut u32> {
        let chip = &mut self.chip;
        if let Some((unit, key)) = key.split_once('-')
            && let Some(place) = UNITS.iter().position(|letter| *letter == unit)
        {
            let (unit, l1) = (&mut chip.units[place], &mut chip.l1[place]);
            return Some(match key {
                "rate" => &mut unit.rays_a_cycle,
                "latency" => &mut unit.latency,
                "line" => &mut l1.line,
                "sets" => &mut l1.sets,
                "ports" => &mut l1.ports,
                "look-up" => &mut l1.latency,
                "mshrs" => &mut l1.mshrs,
                _ => return None,
            });
        }
        Some(match key {
            "pipelines" => &mut chip.pipelines,
            "threads" => &mut chip.threads,
            "tag" => &mut chip.tag_latency,
            "return" => &mut chip.return_latency,
            "granule" => &mut chip.metadata_cache.granule,
            "meta-sets" => &mut self.meta_sets,
            "clock" => &mut chip.sdram.cycles_a_clock,
            "beat" => &mut chip.sdram.beat_bytes,
            "banks" => &mut chip.sdram.banks,
            "row" => &mut chip.sdram.row_bytes,
            "cl" => &mut chip.sdram.cas,
            "rcd" => &mut chip.sdram.ras_to_cas,
            "rp" => &mut chip.sdram.precharge,
            "ras" => &mut chip.sdram.row_active,
            "rc" => &mut chip.sdram.row_cycle,
            "rrd" => &mut chip.sdram.row_to_row,
            "wr" => &mut chip.sdram.write_recovery,
            "refresh" => &mut chip.sdram.refresh_interval,
            "rfc" => &mut chip.sdram.refresh,
            "pci-setup" => &mut chip.pci.setup,
            "pci-beat" => &mut chip.pci.beat_bytes,
            "pci-clock" => &mut chip.pci.cycles_a_beat,
            "triangles" => &mut self.triangles.0,
            "tolerance" => &mut self.tolerance,
            _ => return None,
        })
    }
}

/// The words of a configuration as keys and values.
fn words(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split_ascii_whitespace().filter_map(|word| word.split_once('='))
}

/// The keys of a configuration.
pub fn keys() -> impl Iterator<Item = &'static str> {
    KEYS.split_ascii_whitespace()
}

/// What a configuration names.
///
/// # Errors
/// The key that is wrong, and what would be right.
pub fn parse(text: &str) -> Result<Setting, Error> {
    let keys: Vec<_> = keys().collect();
    let given = Values::parse(text, &keys)?;
    if let Some(key) = given.twice() {
        return Err(format!("{key} stands there twice").into());
    }
    let values = given.or(Values::parse(&STANDARD, &keys)?);
    let cache = config::cache_of(&values)?;
    let chip = ChipConfig::standard(values.named("version", VERSIONS)?, cache);
    let mut setting = Setting { chip, meta_sets: 0, triangles: HostAddr(0), tolerance: 0 };
    for key in keys {
        if let Some(number) = setting.number(key) {
            *number = values.number(key)?;
            let most = match key {
                "triangles" => u32::MAX,
                "tolerance" => MAX_TOLERANCE,
                _ => MAX_NUMBER,
            };
            if *number > most {
                return Err(format!("{key}={number}: it must be at most {most}").into());
            }
        }
    }
    let granules = setting.meta_sets.saturating_mul(CHIP_CACHE_WAYS as u32);
    setting.chip.metadata_cache.bytes = granules.saturating_mul(setting.chip.metadata_cache.granule);
    setting.chip.check().map_err(|error| error.to_string())?;
    Ok(setting)
}

/// The configuration that [`parse`] reads back.
#[must_use]
pub fn text(setting: &Setting) -> String {
    let mut setting = setting.clone();
    let word = |(key, standard): (&str, &str)| {
        let value = setting.value(key);
        (value != standard).then(|| format!("{key}={value}"))
    };
    one_at_least(words(&STANDARD).filter_map(word))
}

/// The words as a configuration, which names one key at least.
fn one_at_least(words: impl Iterator<Item = String>) -> String {
    let text = words.collect::<Vec<_>>().join(" ");
    if text.is_empty() { "version=a".to_owned() } else { text }
}

/// The configuration with another tolerance.
#[must_use]
pub fn with_tolerance(text: &str, tolerance: u32) -> String {
    let kept = text.split_ascii_whitespace().filter(|word| !word.starts_with("tolerance="));
    let tolerance = (tolerance > 0).then(|| format!("tolerance={tolerance}"));
    one_at_least(kept.map(str::to_owned).chain(tolerance))
}

/// Configurations that are simpler by one step: one pipeline, one thread, no virtual memory, and what
/// the standard chip has.
#[must_use]
pub fn simpler(config: &str) -> Vec<String> {
    let Ok(setting) = parse(config) else { return Vec::new() };
    let mut steps = Vec::new();
    let mut change = |by: &dyn Fn(&mut Setting)| {
        let mut simpler = setting.clone();
        by(&mut simpler);
        steps.push(text(&simpler));
    };
    change(&|setting| (setting.chip.pipelines, setting.chip.threads) = (1, 1));
    change(&|setting| setting.chip.pipelines = 1);
    change(&|setting| setting.chip.threads = 1);
    change(&|setting| setting.chip.version = Version::None);
    if setting.chip.version == Version::B {
        change(&|setting| setting.chip.version = Version::A);
    }
    let now = text(&setting);
    let kept = |key: &str| ["pipelines", "threads", "version", "tolerance"].contains(&key);
    let all: Vec<_> = words(&now).filter(|(key, _)| !kept(key)).map(|(key, _)| key).collect();
    let without = |keys: &[&str]| {
        let words = words(&now).filter(|(key, _)| !keys.contains(key));
        one_at_least(words.map(|(key, value)| format!("{key}={value}")))
    };
    steps.push(without(&all));
    for half in all.chunks(all.len().div_ceil(2).max(1)) {
        steps.push(without(half));
    }
    steps.extend(all.iter().map(|key| without(&[key])));
    steps.retain(|simpler| *simpler != now);
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_is_the_models_but_for_policy_and_granules() {
        let setting = parse("").expect("a chip");
        let mut standard = ChipConfig::standard(Version::A, setting.chip.cache);
        standard.metadata_cache.granule = 16;
        assert_eq!((setting.chip, setting.chip.cache.policy), (standard, Policy::Lru));
        assert_eq!((text(&setting).as_str(), parse(&STANDARD).ok()), ("version=a", Some(setting)));
        assert!(
            include_str!("../../../PROTOCOL.md")
                .split_whitespace()
                .collect::<String>()
                .contains(&STANDARD.split_whitespace().collect::<String>())
        );
    }

    #[test]
    fn configurations_read_back() {
        for config in ["pipelines=1 threads=2", "version=b lines=16 meta-sets=1", "t-line=8 tolerance=20"] {
            assert_eq!(text(&parse(config).expect(config)), config);
        }
        assert_eq!(with_tolerance("threads=2 tolerance=5", 7), "threads=2 tolerance=7");
        assert_eq!(with_tolerance("threads=2 tolerance=5", 0), "threads=2");
    }

    #[test]
    fn wrong_configurations_are_refused() {
        for (config, says) in [
            ("thread=1", "the keys are pipelines"),
            ("threads=1 threads=2", "twice"),
            ("threads=x", "decimal"),
            ("threads=65", "1 to 64"),
            ("version=c", "none, a, b"),
            ("hash=xor", "add-upper"),
            ("s-sets=3", "power of two"),
            ("n-tag=3", "the keys are"),
            ("pci-setup=70000", "at most 65536"),
            ("tolerance=101", "at most 100"),
            ("line=32", "line of a first-level cache"),
            ("version=b granule=4096 meta-sets=65536", "metadata cache"),
        ] {
            let error = parse(config).expect_err(config).to_string();
            assert!(error.contains(says), "{config}: {error}");
        }
    }

    #[test]
    fn simpler_configurations_end() {
        let config = "pipelines=2 threads=3 version=b lines=16 ways=2 meta-sets=1 refresh=0 tolerance=5";
        let mut config = config.to_owned();
        while let Some(next) = simpler(&config).into_iter().find(|next| parse(next).is_ok()) {
            config = next;
        }
        assert_eq!(config, "pipelines=1 threads=1 version=none tolerance=5");
    }
}
