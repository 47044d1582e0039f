//! Chips that differ from the standard one in one respect: what a figure of the paper hangs on.

use saarcor_model::time::standard::{CHIP_CACHE_WAYS, FIRST_LEVEL_BYTES};
use saarcor_model::time::{ChipConfig, PciConfig, Version};
use saarcor_model::vm::{Bytes, Geometry, Hash, Policy, Unit};
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::standard::{self, family};

/// In what state the caches begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// As the frames before leave them: one, where nothing else is asked for.
    Warm,
    /// The same, but for empty first-level caches.
    ColdFirstLevel,
    /// Empty.
    Empty,
    /// As the ten frames before leave them.
    TenFrames,
}

impl Start {
    /// The frames before that warm the caches, where those of all other chips are `usual`.
    pub(crate) fn warm_up(self, usual: WarmUp) -> WarmUp {
        match self {
            Self::Warm | Self::ColdFirstLevel => usual,
            Self::Empty => WarmUp::frames(0),
            Self::TenFrames => WarmUp::frames(10),
        }
    }
}

/// A memory that is twice as fast in all that it does.
pub const FAST_MEMORY: &str = "a memory clock twice as fast";
/// The faster bus of §4.
pub const FAST_BUS: &str = "a bus of 64 bits at 66 MHz";
/// A frame that finds nothing in any cache, as after a cut of the camera, and the same with the faster bus.
pub const EMPTY: &str = "all caches empty when the frame begins";
/// See [`EMPTY`].
pub const EMPTY_AND_FAST_BUS: &str = "all caches empty, a bus of 64 bits at 66 MHz";
/// First-level caches that hold nothing when the frame begins.
pub const COLD_FIRST_LEVEL: &str = "first-level caches empty when the frame begins";
/// A replacement policy whose bits a hit changes.
pub const LRU: &str = "lru: a hit writes metadata";
/// Metadata in smaller pieces.
pub const GRANULE_16: &str = "granules of 16 B";
/// More banks.
pub const BANKS_8: &str = "8 banks";
/// Fewer threads.
pub const ONE_THREAD: &str = "1 thread a pipeline";
/// See [`ONE_THREAD`].
pub const EIGHT_THREADS: &str = "8 threads a pipeline";
/// First-level caches of one set of four items.
pub const NO_FIRST_LEVEL: &str = "first-level caches of 4 items";
/// A metadata cache of one set.
pub const SMALL_METADATA_CACHE: &str = "a metadata cache of 4 granules";
/// The triangle cache of the other scenes.
pub const SMALL_TRIANGLE_CACHE: &str = "a triangle cache of 144 KB";
/// Less on-board memory.
pub const HALF_MEMORY: &str = "half of the on-board memory";
/// See [`HALF_MEMORY`].
pub const EIGHTH_MEMORY: &str = "an eighth of the on-board memory";
/// A longer history, and sets that hold more.
pub const TEN_FRAMES: &str = "ten frames before, 16 ways";
/// A kd-tree that is cut off early.
pub const SHALLOW_TREE: &str = "a kd-tree of at most log2 N + 2 levels";

/// Values of Assumed numbers that the paper's text admits as well as the standard ones: all of Table 2 is run with them.
pub const ADMITTED: [&str; 4] = [LRU, GRANULE_16, BANKS_8, COLD_FIRST_LEVEL];

/// Sizes of lines that are compared.
pub const LINES: [u64; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

/// The setting of lines of other sizes.
#[must_use]
pub fn lines(bytes: u64) -> String {
    format!("lines of {bytes} B")
}

/// The setting of other ways and hashes.
#[must_use]
pub fn ways(ways: u32, hash: Hash) -> String {
    let hash = if hash == Hash::Low { "no hash" } else { "hash" };
    let number = if ways == 1 { "1 way".to_owned() } else { format!("{ways} ways") };
    format!("{number}, {hash}")
}

/// Whether a setting is one of lines, ways and hash.
#[must_use]
pub fn is_of_lines(setting: &str) -> bool {
    setting.starts_with("lines of ") || setting.contains(" way") && setting.ends_with("hash")
}

/// A chip in place of the standard one; none where the numbers make none.
type Change = Box<dyn Fn(ChipConfig) -> Option<ChipConfig> + Send + Sync>;

/// A chip on which a frame is simulated.
pub struct Plan {
    pub(crate) setting: String,
    pub(crate) versions: &'static [Version],
    pub(crate) start: Start,
    pub(crate) change: Change,
}

/// A plan whose change always makes a chip.
fn plan(
    setting: &str,
    versions: &'static [Version],
    start: Start,
    change: impl Fn(&mut ChipConfig) + Send + Sync + 'static,
) -> Plan {
    let change = Box::new(move |mut config: ChipConfig| {
        change(&mut config);
        config.check().is_ok().then_some(config)
    });
    Plan { setting: setting.to_owned(), versions, start, change }
}

/// A plan with another memory, other lines and ways.
fn geometry(
    setting: String,
    versions: &'static [Version],
    start: Start,
    of: impl Fn(Geometry) -> (u64, u64, u32) + Send + Sync + 'static,
    hash: Option<Hash>,
) -> Plan {
    let change = Box::new(move |mut config: ChipConfig| {
        let (memory, line, ways) = of(config.cache.geometry);
        config.cache.geometry = Geometry::new(Bytes(memory), Bytes(line), ways).ok()?;
        config.cache.hash = hash.unwrap_or(config.cache.hash);
        config.check().is_ok().then_some(config)
    });
    Plan { setting, versions, start, change }
}

const NONE: &[Version] = &[Version::None];
const A: &[Version] = &[Version::A];
const B: &[Version] = &[Version::B];
const A_AND_B: &[Version] = &[Version::A, Version::B];
const NONE_AND_A: &[Version] = &[Version::None, Version::A];
const ALL: &[Version] = &[Version::None, Version::A, Version::B];

/// The chips for the frame at `place` of a scene that stands in the place of the paper's scene `of`, if it does.
///
/// What costs one run is done for each frame; what tells of the chip more than of the frame, for the first one of each
/// scene; lines, ways and hash for the first of each family.
#[must_use]
pub fn of(of: Option<&str>, place: usize) -> Vec<Plan> {
    let mut plans = each();
    if of.is_some_and(|of| family(of) == "Cruiser") {
        plans.push(plan(SMALL_TRIANGLE_CACHE, NONE, Start::Warm, |chip| {
            let triangles = &mut chip.l1[Unit::Intersection as usize];
            let bytes = FIRST_LEVEL_BYTES[Unit::Intersection as usize];
            triangles.sets = bytes / triangles.line / CHIP_CACHE_WAYS as u32;
        }));
    }
    if of.is_some_and(|of| family(of) == "Sodahall") {
        let sixteen = |geometry: Geometry| (geometry.memory().0, geometry.line().0, 16);
        plans.push(geometry(TEN_FRAMES.to_owned(), A, Start::TenFrames, sixteen, None));
    }
    if place == 0 {
        plans.extend(first());
        if of.is_none_or(|of| family(of) == of) {
            plans.extend(lines_and_ways());
        }
    }
    plans
}

/// Most chips on which a frame of a scene of the user's is simulated: those of the three versions, and of all plans.
#[must_use]
pub fn most_chips() -> usize {
    3 + of(None, 0).iter().map(|plan| plan.versions.len()).sum::<usize>()
}

/// Chips for each frame.
fn each() -> Vec<Plan> {
    let fast_bus = |chip: &mut ChipConfig| chip.pci = PciConfig::BITS_64_AT_66_MHZ;
    vec![
        plan(FAST_MEMORY, NONE, Start::Warm, |chip| chip.sdram.cycles_a_clock /= 2),
        plan(FAST_BUS, A, Start::Warm, fast_bus),
        plan(EMPTY, A, Start::Empty, |_| ()),
        plan(EMPTY_AND_FAST_BUS, A, Start::Empty, fast_bus),
        plan(COLD_FIRST_LEVEL, ALL, Start::ColdFirstLevel, |_| ()),
        plan(LRU, A_AND_B, Start::Warm, |chip| chip.cache.policy = Policy::Lru),
        plan(GRANULE_16, B, Start::Warm, |chip| chip.metadata_cache.granule = 16),
        plan(BANKS_8, ALL, Start::Warm, |chip| chip.sdram.banks = 8),
    ]
}

/// Chips for the first frame of a scene.
fn first() -> Vec<Plan> {
    let memory = |setting: &str, divisor: u64| {
        let less =
            move |geometry: Geometry| (geometry.memory().0 / divisor, geometry.line().0, geometry.ways());
        geometry(setting.to_owned(), A, Start::Warm, less, None)
    };
    vec![
        plan(ONE_THREAD, NONE_AND_A, Start::Warm, |chip| chip.threads = 1),
        plan(EIGHT_THREADS, A, Start::Warm, |chip| chip.threads = 8),
        plan(NO_FIRST_LEVEL, A, Start::Warm, |chip| chip.l1.iter_mut().for_each(|l1| l1.sets = 1)),
        plan(SMALL_METADATA_CACHE, B, Start::Warm, |chip| {
            chip.metadata_cache.bytes = chip.metadata_cache.granule * CHIP_CACHE_WAYS as u32;
        }),
        memory(HALF_MEMORY, 2),
        memory(EIGHTH_MEMORY, 8),
    ]
}

/// Chips with other lines, and with fewer ways and without hash (§3).
fn lines_and_ways() -> Vec<Plan> {
    let line = |line: u64| {
        let with = move |geometry: Geometry| (geometry.memory().0, line, geometry.ways());
        geometry(lines(line), A_AND_B, Start::Warm, with, None)
    };
    let set = |number: u32, hash: Hash| {
        let with = move |geometry: Geometry| (geometry.memory().0, geometry.line().0, number);
        geometry(ways(number, hash), A, Start::Warm, with, Some(hash))
    };
    let sets = [1, 2, standard::WAYS].into_iter().flat_map(|ways| {
        let hashes = [Hash::Low, Hash::AddUpper].into_iter();
        hashes
            .filter(move |&hash| (ways, hash) != (standard::WAYS, Hash::default()))
            .map(move |hash| set(ways, hash))
    });
    LINES.into_iter().map(line).chain(sets).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_alternative_is_another_chip_or_begins_otherwise() {
        let plans = of(Some("Conference"), 0);
        for (place, plan) in plans.iter().enumerate() {
            assert!(plans[..place].iter().all(|other| other.setting != plan.setting), "{}", plan.setting);
            for version in plan.versions {
                let standard = standard::chip("Conference", *version).expect("a chip");
                let chip = (plan.change)(standard).expect("a chip");
                let same_lines = plan.setting == lines(standard::LINE.0);
                assert!(chip != standard || plan.start != Start::Warm || same_lines, "{}", plan.setting);
            }
        }
    }

    #[test]
    fn chips_that_cannot_be_are_left_out() {
        let mut small = standard::chip("", Version::A).expect("a chip");
        small.cache.geometry = Geometry::new(Bytes(8 << 10), Bytes(128), 4).expect("a geometry");
        let made = |plans: Vec<Plan>| plans.into_iter().filter(|plan| (plan.change)(small).is_some()).count();
        assert_eq!(made(lines_and_ways()), lines_and_ways().len() - 1, "4 lines of 4 KiB do not fit");
    }
}
