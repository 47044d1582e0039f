//! Theorems of the chip in time: whole runs of small chips, cycle by cycle (CH-3 to CH-6, CH-12, CH-20).
//!
//! A run is held to a law of [`laws`] after each phase of each cycle. The exhaustive engine takes all programs
//! of a counted small scope; `tests/time.rs` holds large chips to all laws at once.

pub mod first_level;
pub mod laws;
mod scope;
pub mod stalls;
pub mod thread;
pub mod turn;

use crate::draw::{BYTES, flag};
use crate::{check_eq, cover, theorems};
use laws::{HandOut, LookUps, Nothing, Parts, Units, held};
use saarcor_model::time::{
    CacheReport, ChipConfig, L1Config, MetadataCacheConfig, Operation, PciConfig, Programs, SdramConfig,
    UnitConfig, Version, simulate,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, HostAddr, Policy, Unit};

/// A number of cycles. Small scope: 0, 1 and 3.
static FEW: [u32; 3] = [0, 1, 3];

theorems! {
    /// Packets are handed out in the order of their programs, one a cycle while a thread is free, to the pipelines
    /// in turn, and in a pipeline to the free thread of the lowest number.
    #["CH-4", not_for_kani "whole runs of a chip", covers ["several pipelines", "more packets than threads"]]
    fn packets_are_handed_out_in_turn(s) {
        let (config, programs) = scope::contended(s);
        held(&config, &programs, &mut HandOut::new(&config, &programs))?;
        cover!(s, "several pipelines", config.pipelines > 1);
        cover!(s, "more packets than threads", config.pipelines * config.threads < 4);
    }

    /// A free unit takes a ready thread at once, is busy while its rays go in, and ends the operation its latency
    /// after that; no thread that is ready is passed over while another one is taken twice.
    #["CH-6", not_for_kani "whole runs of a chip", covers ["several pipelines", "a unit that is never free"]]
    fn units_take_ready_threads_in_turn(s) {
        let (config, programs) = scope::contended(s);
        let report = held(&config, &programs, &mut Units::new(&config))?;
        cover!(s, "several pipelines", config.pipelines > 1);
        cover!(s, "a unit that is never free", report.units.iter().any(|unit| unit.busy == report.cycles - 2));
    }

    /// A missed line is asked for in parts, each within one line of the virtual memory, that make up the line. The
    /// bus manager takes one part a cycle, from the first-level caches in turn.
    #["CH-12", not_for_kani "whole runs of a chip", covers ["a line of two parts", "several caches"]]
    fn parts_are_taken_in_turn(s) {
        let (config, programs) = scope::small(s);
        let report = held(&config, &programs, &mut Parts::new(&config, &programs))?;
        let misses = report.l1.map(|l1| l1.misses);
        cover!(s, "a line of two parts", report.l2.accesses > misses.iter().sum());
        cover!(s, "several caches", misses.iter().filter(|&&misses| misses > 0).count() > 1);
    }

    /// Each part that the bus manager takes is one look-up of the directory; one that hits a line whose load is in flight then is
    /// merged, and no other.
    #["CH-14", not_for_kani "whole runs of a chip", covers ["missed", "merged", "hit"]]
    fn look_ups_of_lines_in_flight_are_merged(s) {
        let (config, programs) = scope::small(s);
        let report = held(&config, &programs, &mut LookUps::new(&config))?;
        let CacheReport { accesses, misses, merged, .. } = report.l2;
        cover!(s, "missed", misses > 0);
        cover!(s, "merged", merged > 0);
        cover!(s, "hit", accesses > misses + merged);
    }

    /// Whatever chip is accepted, every run ends, and within the cycles that it would take if all parts of the chip
    /// waited for each other: whenever a thread waits, something that it waits for goes on.
    #["CH-20", not_for_kani "whole runs of a chip", covers ["version A", "version B", "hardly any time between refreshes"]]
    fn every_run_ends(s) {
        let (mut config, programs) = scope::small(s);
        match s.value("extreme (none, refreshes, rows, tags, registers)", 0..=4_u8, &[0, 1, 2, 3, 4]) {
            1 => config.sdram.refresh_interval = config.sdram.precharge.max(1) + config.sdram.refresh.max(1) + 1,
            2 => (config.sdram.row_bytes, config.sdram.banks) = (config.sdram.beat_bytes, 1),
            3 => (config.tag_latency, config.return_latency) = (0, 0),
            4 => config.l1.iter_mut().for_each(|l1| (l1.mshrs, l1.sets, l1.ports) = (1, 1, 3)),
            _ => {}
        }
        cover!(s, "version A", config.version == Version::A);
        cover!(s, "version B", config.version == Version::B);
        let busy = config.sdram.precharge.max(1) + config.sdram.refresh.max(1);
        cover!(s, "hardly any time between refreshes", config.sdram.refresh_interval == busy + 1);
        held(&config, &programs, &mut Nothing)?;
    }

    /// Of a packet alone on the chip, each operation takes the latencies of what it uses, one after the other: tag,
    /// bus, memory, return, first-level cache and unit.
    #["CH-3", not_for_kani "whole runs of a chip", covers ["without virtual memory", "version A", "version B"]]
    fn latencies_of_an_operation_add_up(s) {
        let version = match s.value("version (none, A, B)", 0..=2, &BYTES[..3]) {
            0 => Version::None,
            1 => Version::A,
            _ => Version::B,
        };
        let mut config = alone(version);
        let few = |s: &mut S, name| s.value(name, 0..=4, &FEW);
        (config.tag_latency, config.return_latency) = (few(s, "tag latency"), few(s, "return latency"));
        let kind = Unit::Traversal as usize;
        config.units[kind].latency = few(s, "latency of the unit");
        // One of all is long.
        let long = s.value("a long latency", 0..=1024, &[0, 300]);
        match s.value("which (tag, return, unit, cache, set-up, CL)", 0..=5, &BYTES[..6]) {
            0 => config.tag_latency += long,
            1 => config.return_latency += long,
            2 => config.units[kind].latency = config.units[kind].latency.max(long),
            3 => config.l1[kind].latency = config.l1[kind].latency.max(long),
            4 => config.pci.setup += long,
            _ => config.sdram.cas += long,
        }
        config.units[kind].rays_a_cycle = s.value("rays a cycle", 1..=u32::MAX, &[1, 64]);
        let rays = s.value("rays", 1..=u8::MAX, &[1, 65]);
        let operation = Operation { addr: HostAddr(0), bytes: 4, rays, unit: Unit::Traversal };
        let programs = Programs { packets: vec![[operation, operation].into()], triangles: HostAddr(0) };
        cover!(s, "without virtual memory", version == Version::None);
        cover!(s, "version A", version == Version::A);
        cover!(s, "version B", version == Version::B);
        let work = cycles_of(rays, config.units[kind].rays_a_cycle) + u64::from(config.units[kind].latency);
        // Miss, work, hit, work.
        let cycles = missed(&config) + work + u64::from(config.l1[kind].latency) + work;
        let report = simulate(&[], &programs, &config);
        check_eq!(report.map(|report| report.cycles), Ok(cycles), "{rays} rays on {config:?}");
    }

    /// In version B a tag waits for the metadata that it reads, not for what is written back: a line comes from the host
    /// as early as if nothing had to be.
    #["CH-13", not_for_kani "whole runs of a chip", covers ["written back", "not written back"]]
    fn tag_waits_for_its_reads_alone(s) {
        let mut config = alone(Version::B);
        config.cache.geometry = Geometry::new(Bytes(4096), Bytes(16), 1).expect("legal");
        config.tag_latency = s.value("tag latency", 0..=40, &FEW);
        config.sdram.cycles_a_clock = s.value("core cycles a memory clock", 1..=16, &[1, 4]);
        // The metadata of each of these lines lie in a granule of their own, and the cache holds four.
        let full = flag(s, "metadata cache full of changes");
        let lines = [0, 2, 5, 7].into_iter().take(if full { 4 } else { 3 });
        let read = |line: u32, rays| Operation { addr: HostAddr(16 * line), bytes: 4, rays, unit: Unit::Traversal };
        let before = Programs { packets: vec![lines.map(|line| read(line, 0)).collect()], triangles: HostAddr(0) };
        let programs = Programs { packets: vec![[read(8, 1)].into()], triangles: HostAddr(0) };
        let kind = Unit::Traversal as usize;
        let work = cycles_of(1, config.units[kind].rays_a_cycle) + u64::from(config.units[kind].latency);
        let report = simulate(&[before], &programs, &config);
        let written_back = report.as_ref().map_or(0, |report| report.metadata_write_back_bytes);
        cover!(s, "written back", written_back > 0);
        cover!(s, "not written back", written_back == 0);
        check_eq!(report.map(|report| report.cycles), Ok(missed(&config) + work), "{written_back} bytes written back, {config:?}");
    }
}

/// A chip of one thread, whose memory has no refresh and banks enough that no row is closed.
fn alone(version: Version) -> ChipConfig {
    let geometry = Geometry::new(Bytes(64), Bytes(16), 1).expect("legal");
    let l1 = L1Config { line: 4, sets: 1, ports: 1, latency: 2, mshrs: 1 };
    ChipConfig {
        pipelines: 1,
        threads: 1,
        units: [UnitConfig { rays_a_cycle: 1, latency: 0 }; 4],
        l1: [l1; 4],
        metadata_cache: MetadataCacheConfig { bytes: 32, granule: 8 },
        pci: PciConfig { setup: 3, beat_bytes: 4, cycles_a_beat: 2 },
        sdram: SdramConfig { beat_bytes: 8, row_bytes: 64, refresh_interval: 0, ..SdramConfig::STANDARD },
        ..ChipConfig::standard(version, CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru })
    }
}

/// The cycle in which the first 4 bytes are there on a chip that is [`alone`], if they are asked for in cycle 0.
fn missed(config: &ChipConfig) -> u64 {
    let sdram = config.sdram;
    let [clock, cas, opening] = [sdram.cycles_a_clock, sdram.cas, sdram.ras_to_cas].map(u64::from);
    let tag = u64::from(config.tag_latency);
    // The chip acts on a tag in a later cycle than the one in which the part was taken.
    let acted = match config.version {
        Version::None => 1,
        Version::A => tag.max(1),
        // The set's 5 bytes of metadata lie in one granule, one beat, in a bank of its own.
        Version::B => (opening + cas + 1) * clock + tag,
    };
    let read = |clocks: u64| (clocks + 1) * clock + u64::from(config.return_latency);
    if config.version == Version::None {
        return read(acted.div_ceil(clock) + opening + cas);
    }
    // 16 bytes: 4 beats over the bus, 2 to the card. The read's command comes a clock after the write's, its
    // beat when the bus is free.
    let loaded = acted + u64::from(config.pci.setup) + 4 * u64::from(config.pci.cycles_a_beat);
    let written = loaded.div_ceil(clock) + opening;
    read((written + 2).max(written + 1 + cas))
}

/// Cycles in which rays go in, at so many a cycle.
fn cycles_of(rays: u8, rate: u32) -> u64 {
    let mut cycles = 1;
    while cycles * u64::from(rate) < u64::from(rays) {
        cycles += 1;
    }
    cycles
}
