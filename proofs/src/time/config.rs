//! Theorems of the numbers of a chip (CH-2, CH-6, CH-17).

use crate::draw::{BYTES, ENDS, WORDS};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::time::{ChipConfig, MAX_COUNT, MetadataCacheConfig, UnitConfig, Version};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};

theorems! {
    /// A unit is busy with an operation for as few cycles as its rays need to go in, and for at least
    /// one.
    #["CH-6", unwind 4, covers ["no rays", "one cycle", "a last cycle that is not full"]]
    fn unit_is_busy_until_its_rays_are_in(s) {
        let rays = u32::from(s.value("rays", 0..=u8::MAX, &[0, 1, 2, 3, 4, 5, 63, 64, 65, 255]));
        let rays_a_cycle = s.value("rays a cycle", 1..=u32::MAX, &[1, 2, 3, 4, 64, 65, 255, 256, u32::MAX]);
        let cycles = UnitConfig { rays_a_cycle, latency: 0 }.cycles(rays);
        let taken = |cycles: u32| u64::from(cycles) * u64::from(rays_a_cycle);
        cover!(s, "no rays", rays == 0);
        cover!(s, "one cycle", rays > 0 && cycles == 1);
        cover!(s, "a last cycle that is not full", cycles > 1 && taken(cycles) > u64::from(rays));
        check!(cycles >= 1 && taken(cycles) >= u64::from(rays), "{rays} rays, {rays_a_cycle} a cycle: {cycles}");
        check!(cycles == 1 || taken(cycles - 1) < u64::from(rays), "{rays} rays, {rays_a_cycle} a cycle: {cycles}");
    }

    /// The sets of the metadata cache, with four ways of one granule each, make up the size asked for.
    #["CH-17", unwind 4, covers ["one set", "many sets"]]
    fn metadata_cache_has_the_size_asked_for(s) {
        let granule_bits = s.value("log2 granule", 3..=12, &WORDS[3..13]);
        let set_bits = s.value("log2 sets", 0..=12, &WORDS[..13]);
        let config = MetadataCacheConfig { bytes: 4 << (granule_bits + set_bits), granule: 1 << granule_bits };
        cover!(s, "one set", set_bits == 0);
        cover!(s, "many sets", set_bits > 0);
        check_eq!(config.sets(), 1 << set_bits, "sets of {config:?}");
    }

    /// A chip has 1 to 64 pipelines, threads a pipeline, and ports and lines in flight of each
    /// first-level cache: no other number is accepted.
    #["CH-2", not_for_kani "its errors are text", covers ["accepted", "none", "one too many"]]
    fn counts_of_a_chip_are_1_to_64(s) {
        let mut config = standard(Version::A);
        let count = s.value("count", 0..=u32::MAX, &[0, 1, 2, 63, 64, 65, 1 << 16, u32::MAX]);
        let cache = usize::from(s.value("first-level cache", 0..=3, &BYTES[..4]));
        match s.value("what (pipelines, threads, ports, lines in flight)", 0..=3, &BYTES[..4]) {
            0 => config.pipelines = count,
            1 => config.threads = count,
            2 => config.l1[cache].ports = count,
            _ => config.l1[cache].mshrs = count,
        }
        let legal = (1..=64).contains(&count);
        cover!(s, "accepted", legal);
        cover!(s, "none", count == 0);
        cover!(s, "one too many", count == MAX_COUNT + 1);
        check_eq!(config.check().is_ok(), legal, "{count}: {:?}", config.check());
    }

    /// A line of a first-level cache is accepted exactly if it has 1 to 65 536 bytes and, with virtual
    /// memory, is no longer than a line of that; its sets are a power of two up to 2^24.
    #["L1-1", not_for_kani "its errors are text", covers ["accepted", "longer than a line of the virtual memory", "no power of two"]]
    fn first_level_caches_that_are_accepted(s) {
        let version = match s.value("version (none, A, B)", 0..=2, &BYTES[..3]) {
            0 => Version::None,
            1 => Version::A,
            _ => Version::B,
        };
        let mut config = standard(version);
        let cache = usize::from(s.value("first-level cache", 0..=3, &BYTES[..4]));
        let line = s.value("bytes a line", 0..=u32::MAX, &[0, 1, 36, 127, 128, 129, 1 << 16, (1 << 16) + 1]);
        let sets = s.value("sets", 0..=u32::MAX, &[0, 1, 2, 3, 1 << 24, (1 << 24) + 1, 1 << 25]);
        (config.l1[cache].line, config.l1[cache].sets) = (line, sets);
        let most = if version == Version::None { 1 << 16 } else { 128 };
        let legal = (1..=most).contains(&line) && sets.is_power_of_two() && sets <= 1 << 24;
        cover!(s, "accepted", legal);
        cover!(s, "longer than a line of the virtual memory", version != Version::None && line > 128);
        cover!(s, "no power of two", sets == 3);
        check_eq!(config.check().is_ok(), legal, "lines of {line} bytes in {sets} sets, {version:?}: {:?}", config.check());
    }

    /// A refresh interval is accepted exactly if it is 0, for never, or longer than the refresh takes: tRP and tRFC,
    /// and a clock each at least.
    #["SD-5", not_for_kani "its errors are text", covers ["never", "just too short", "just long enough"]]
    fn refresh_leaves_time_for_work(s) {
        let mut config = standard(Version::None);
        let value = |s: &mut S, name| s.value(name, 0..=u32::MAX, &ENDS);
        let (interval, precharge, refresh) = (value(s, "interval"), value(s, "tRP"), value(s, "tRFC"));
        (config.sdram.refresh_interval, config.sdram.precharge, config.sdram.refresh) = (interval, precharge, refresh);
        let busy = u64::from(precharge.max(1)) + u64::from(refresh.max(1));
        // What does not fit 32 bits no interval is longer than.
        let legal = interval == 0 || u64::from(interval) > busy;
        assume!(busy <= u64::from(u32::MAX) || interval < u32::MAX);
        cover!(s, "never", interval == 0);
        cover!(s, "just too short", interval > 0 && u64::from(interval) == busy);
        cover!(s, "just long enough", u64::from(interval) == busy + 1);
        check_eq!(config.check().is_ok(), legal, "interval {interval}, busy {busy}: {:?}", config.check());
    }
}

/// The standard chip with 8 MB of on-board memory in lines of 128 bytes.
fn standard(version: Version) -> ChipConfig {
    let geometry = Geometry::new(Bytes(8 << 20), Bytes(128), 4);
    let cache = geometry.map(|geometry| CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru });
    ChipConfig::standard(version, cache.expect("the paper's sizes are legal"))
}
