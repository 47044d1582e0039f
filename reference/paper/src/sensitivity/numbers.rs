//! The Assumed numbers on which Table 2 hangs, and the values that the paper's text admits for each.

use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{ChipConfig, SdramConfig};
use saarcor_model::vm::{Hash, Policy, Unit};
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::world::WorldOptions;

/// An Assumed number of the specification.
#[derive(Clone, Copy, Debug)]
pub struct AssumedNumber {
    /// Its name.
    pub name: &'static str,
    /// The requirement that assumes it.
    pub id: &'static str,
    /// The value of the standard configuration.
    pub default: &'static str,
    /// What the paper says, by which the other values are admitted.
    pub text: &'static str,
    /// The other values.
    pub values: &'static [Value],
}

/// Another value of an Assumed number.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    /// As it is written.
    pub value: &'static str,
    pub(super) change: Change,
}

/// What a value changes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change {
    /// The chip.
    Chip(fn(&mut ChipConfig)),
    /// Whether the first-level caches hold nothing when the frame begins.
    ColdFirstLevel,
    /// Frames before that warm the caches.
    WarmUp(usize),
    /// How the frames are traced, and in which order packets are handed out.
    Trace(fn(&mut TraceOptions, &mut PacketOrder)),
    /// The scene's image, which has so many triangles.
    World(fn(&mut WorldOptions, u64)),
}

/// A value that changes the chip.
const fn chip(value: &'static str, change: fn(&mut ChipConfig)) -> Value {
    Value { value, change: Change::Chip(change) }
}

/// A value that changes the tree or the textures.
const fn world(value: &'static str, change: fn(&mut WorldOptions, u64)) -> Value {
    Value { value, change: Change::World(change) }
}

/// A value that changes how frames are traced.
const fn trace(value: &'static str, change: fn(&mut TraceOptions, &mut PacketOrder)) -> Value {
    Value { value, change: Change::Trace(change) }
}

const NO_WORD: &str = "the paper has no word on it";

/// All of them.
pub const NUMBERS: &[AssumedNumber] = &[
    AssumedNumber {
        name: "granule",
        id: "CH-17",
        default: "32 B",
        text: "§4: a 4-way set-associative cache of 64 KB for metadata; what it reads at a time is not named",
        values: &[
            chip("16 B", |chip| chip.metadata_cache.granule = 16),
            chip("64 B", |chip| chip.metadata_cache.granule = 64),
        ],
    },
    AssumedNumber {
        name: "policy",
        id: "VM-6",
        default: "fifo",
        text: "§3: several bits for managing purposes",
        values: &[
            chip("lru", |chip| chip.cache.policy = Policy::Lru),
            chip("plru", |chip| chip.cache.policy = Policy::Plru),
        ],
    },
    AssumedNumber {
        name: "hash",
        id: "VM-3",
        default: "add-upper",
        text: "§3: simply adding the upper bits of the memory address to the lower ones",
        values: &[chip("add-upper-all", |chip| chip.cache.hash = Hash::AddUpperAll)],
    },
    AssumedNumber {
        name: "banks",
        id: "SD-2",
        default: "4",
        text: "§2: several standard SDRAM chips; §4: a 128-bit wide memory",
        values: &[chip("8", |chip| chip.sdram.banks = 8), chip("16", |chip| chip.sdram.banks = 16)],
    },
    AssumedNumber {
        name: "row",
        id: "SD-2",
        default: "4 KiB",
        text: "§2: several standard SDRAM chips",
        values: &[
            chip("2 KiB", |chip| chip.sdram.row_bytes = 2 << 10),
            chip("16 KiB", |chip| chip.sdram.row_bytes = 16 << 10),
        ],
    },
    AssumedNumber {
        name: "memory-times",
        id: "SD-3",
        default: "PC133 3-3-3",
        text: "§4: SDRAM at 133 MHz",
        values: &[chip("PC133 2-2-2", |chip| {
            let SdramConfig { cas, ras_to_cas, precharge, row_cycle, .. } = &mut chip.sdram;
            (*cas, *ras_to_cas, *precharge, *row_cycle) = (2, 2, 2, 8);
        })],
    },
    AssumedNumber {
        name: "lines-in-flight",
        id: "CH-3",
        default: "16",
        text: NO_WORD,
        values: &[
            chip("4", |chip| chip.l1.iter_mut().for_each(|l1| l1.mshrs = 4)),
            chip("64", |chip| chip.l1.iter_mut().for_each(|l1| l1.mshrs = 64)),
        ],
    },
    AssumedNumber {
        name: "first-level-ports",
        id: "CH-3",
        default: "1",
        text: "§2: all units of a type share their cache",
        values: &[chip("4", |chip| chip.l1.iter_mut().for_each(|l1| l1.ports = 4))],
    },
    AssumedNumber {
        name: "first-level-latency",
        id: "CH-3",
        default: "2",
        text: "§4: even for first-level caches high latencies can be tolerated",
        values: &[
            chip("1", |chip| chip.l1.iter_mut().for_each(|l1| l1.latency = 1)),
            chip("8", |chip| chip.l1.iter_mut().for_each(|l1| l1.latency = 8)),
        ],
    },
    AssumedNumber {
        name: "shading-line",
        id: "L1-1",
        default: "64 B",
        text: "§3: single triangles and nodes are cached; of shading data nothing is said",
        values: &[chip("16 B", |chip| shading_line(chip, 16)), chip("128 B", |chip| shading_line(chip, 128))],
    },
    AssumedNumber {
        name: "tag-latency",
        id: "CH-3",
        default: "4",
        text: NO_WORD,
        values: &[chip("1", |chip| chip.tag_latency = 1), chip("16", |chip| chip.tag_latency = 16)],
    },
    AssumedNumber {
        name: "return-latency",
        id: "CH-3",
        default: "4",
        text: NO_WORD,
        values: &[chip("1", |chip| chip.return_latency = 1), chip("16", |chip| chip.return_latency = 16)],
    },
    AssumedNumber {
        name: "unit-latency",
        id: "CH-3",
        default: "8 to 16",
        text: NO_WORD,
        values: &[
            chip("half", |chip| chip.units.iter_mut().for_each(|unit| unit.latency /= 2)),
            chip("twice", |chip| chip.units.iter_mut().for_each(|unit| unit.latency *= 2)),
        ],
    },
    AssumedNumber {
        name: "traversal-rate",
        id: "CH-2",
        default: "4",
        text: "§4: roughly the hardware resources of a GPU of its time",
        values: &[
            chip("2", |chip| chip.units[Unit::Traversal as usize].rays_a_cycle = 2),
            chip("8", |chip| chip.units[Unit::Traversal as usize].rays_a_cycle = 8),
        ],
    },
    AssumedNumber {
        name: "shading-rate",
        id: "CH-2",
        default: "1",
        text: "§4: roughly the hardware resources of a GPU of its time",
        values: &[chip("4", |chip| chip.units[Unit::Shading as usize].rays_a_cycle = 4)],
    },
    AssumedNumber {
        name: "list-rate",
        id: "CH-2",
        default: "64",
        text: "§2: the list unit works on packets, as all units do",
        values: &[chip("4", |chip| chip.units[Unit::List as usize].rays_a_cycle = 4)],
    },
    AssumedNumber {
        name: "first-level-start",
        id: "CH-19",
        default: "warm",
        text: "§4: hot spots are simulated in detail; what is in the caches before is not said",
        values: &[Value { value: "cold", change: Change::ColdFirstLevel }],
    },
    AssumedNumber {
        name: "warm-up",
        id: "CH-19",
        default: "1 frame",
        text: "§4: a complete walk-through, of which hot spots are frames",
        values: &[Value { value: "10 frames", change: Change::WarmUp(10) }],
    },
    AssumedNumber {
        name: "order",
        id: "RG-2",
        default: "scan",
        text: NO_WORD,
        values: &[trace("morton", |_, order| *order = PacketOrder::Morton)],
    },
    AssumedNumber {
        name: "packet",
        id: "RG-2",
        default: "64",
        text: "§2: packets of rays instead of single rays; how many is not said",
        values: &[trace("16", |trace, _| trace.packet = PacketSize::Rays16)],
    },
    AssumedNumber {
        name: "picture",
        id: "RG-1",
        default: "1",
        text: "the paper names no size; the value is the part of each side",
        values: &[trace("5/8", |trace, _| {
            let (width, height) = trace.resolution;
            trace.resolution = (width * 5 / 8, height * 5 / 8);
        })],
    },
    AssumedNumber {
        name: "mip-maps",
        id: "SH-6",
        default: "yes",
        text: "§2: a standard image texture and a bump map; no filter is named",
        values: &[world("no", |world, _| world.no_mip_maps = true)],
    },
    AssumedNumber {
        name: "tree",
        id: "HI-4",
        default: "sah 1.5",
        text: "§4: an improved algorithm has not yet been implemented for the hardware simulations",
        values: &[
            world("sah 0.5", |world, _| world.tree.intersection_cost = 0.5),
            world("sah 1.5, log2 N + 2 levels", |world, triangles| {
                world.tree.max_depth = Some(libm::log2(triangles.max(1) as f64) as u32 + 2);
            }),
            world("sah 1.5, leaves of 16", |world, _| world.tree.max_leaf = 16),
        ],
    },
];

/// The first-level cache of shading data with lines of other sizes, and as many bytes.
fn shading_line(chip: &mut ChipConfig, line: u32) {
    let bytes = chip.l1_bytes(Unit::Shading as usize) as u32;
    let l1 = &mut chip.l1[Unit::Shading as usize];
    (l1.line, l1.sets) = (line, bytes / line / CHIP_CACHE_WAYS as u32);
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::time::Version;
    use saarcor_studies::standard;

    #[test]
    fn values_change_the_chip_and_leave_it_one() {
        for number in NUMBERS {
            for Value { value, change } in number.values {
                let Change::Chip(change) = change else { continue };
                let standard = standard::chip("cruiser", Version::B).expect("a chip");
                let mut chip = standard;
                change(&mut chip);
                assert!(chip != standard && chip.check().is_ok(), "{} of {value}", number.name);
                assert_eq!(chip.l1_bytes(0), standard.l1_bytes(0));
            }
        }
    }

    #[test]
    fn numbers_are_those_of_requirements() {
        let specification = include_str!("../../../../model/SPEC.md");
        for AssumedNumber { name, id, .. } in NUMBERS {
            assert!(specification.contains(&format!("\n| {id} | ")), "{name}: {id}");
        }
    }

    #[test]
    fn names_are_distinct() {
        for (place, number) in NUMBERS.iter().enumerate() {
            assert!(NUMBERS[..place].iter().all(|other| other.name != number.name));
            for (place, value) in number.values.iter().enumerate() {
                assert!(number.values[..place].iter().all(|other| other.value != value.value));
                assert_ne!(value.value, number.default);
            }
        }
    }
}
