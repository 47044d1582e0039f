//! What a run finds of an implementation that does not show its state: which memories and registers hold the lines of a
//! set, their order, and a request that waits; and how they stand to the specification's state.
//!
//! What holds in all clocks of a simulation is a guess, no more: each relation is then an assertion of a proof by induction,
//! which drops those that do not hold (Flanagan and Leino, *Houdini, an annotation assistant for ESC/Java*, 2001).

mod cells;
mod commits;
mod relations;
mod samples;

pub(super) use cells::{binary, show};
pub(super) use commits::{commit_wires, commits};
pub(super) use relations::{most_of_set, relations};
pub(super) use samples::{Samples, watched};

use saarcor_model::vm::CacheConfig;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Clocks that are simulated.
const CLOCKS: usize = 1500;
/// The wire of the harness that shows when a request changes the state.
pub const COMMIT: &str = "found_commit";
/// Widest register that is looked at.
const MAX_WIDTH: usize = 128;
/// Sets from which on a register that has some bits for each may be so by more than chance.
const FEWEST_SETS: u64 = 8;
/// Widest register of those that may control others.
const CONTROL_WIDTH: usize = 4;

/// A part of an implementation's state that is shown to the harness.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// A word of a memory: that of the set, or one of the set's.
    Word {
        /// The memory.
        memory: String,
        /// The number of the word in the set, and how many there are.
        way: u32,
        /// How many words a set has.
        ways: u32,
        /// Whether the words of a set stand side by side.
        is_side_by_side: bool,
    },
    /// The word in which the byte lies that is looked at, of a memory of the bytes of lines.
    Bytes {
        /// The memory.
        memory: String,
        /// Where lines lie in it.
        layout: Layout,
    },
    /// A wire.
    Wire(String),
}

/// How a memory of the bytes of lines is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// The ways of a set side by side: by card addresses.
    Card,
    /// The sets of a way side by side.
    Apart,
    /// It has the lines of one way.
    Way(u32),
}

impl Layout {
    /// The wire of the harness that says where the byte lies in such a memory.
    fn wire(self) -> &'static str {
        match self {
            Self::Card => "byte_card",
            Self::Apart => "byte_apart",
            Self::Way(_) => "byte_in_way",
        }
    }
}

/// A part, and the wire of the harness that shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    /// The part.
    pub part: Part,
    /// The wire.
    pub wire: String,
    /// Its bits.
    pub width: usize,
    /// Whether it is the set of a request, and so has as many bits as there are for sets.
    pub is_set: bool,
}

/// A relation that may hold in each clock but the first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Relation {
    /// The condition, in Verilog.
    pub text: String,
    /// What it consists of, where it may be taken apart.
    pub parts: Vec<String>,
}

impl Relation {
    /// A relation that is not taken apart.
    fn whole(text: String) -> Self {
        Self { text, parts: Vec::new() }
    }
}

/// A value of a wire which says that the oldest request that waits changes the state in this clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Commit {
    /// The wire.
    pub wire: String,
    /// Its bits.
    pub width: usize,
    /// The value.
    pub value: u64,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// When a request changes the state; none where each does in the clock in which it is taken.
    pub commit: Option<Commit>,
    /// Whether the implementation has the bytes of lines.
    pub has_bytes: bool,
    /// The parts of the state.
    pub parts: Vec<Shown>,
    /// The relations.
    pub relations: Vec<Relation>,
}

impl Found {
    /// What may show the state of an implementation: its memories of a word or more a set, and its registers.
    #[must_use]
    pub fn candidates(netlist: &Value, top: &str, cache: &CacheConfig, has_bytes: bool) -> Self {
        let module = &netlist["modules"][top];
        let (sets, all_ways) = (cache.geometry.sets(), cache.geometry.ways());
        let arrays = cells::arrays(module, sets);
        let mut parts: Vec<(Part, usize)> = Vec::new();
        let bytes = cache.geometry.memory().0;
        for (name, array) in &arrays {
            let width = array.width as u64;
            if has_bytes && width.is_power_of_two() && width >= 8 {
                let part = |layout| (Part::Bytes { memory: name.clone(), layout }, array.width);
                let size = array.size * (width / 8);
                if size == bytes {
                    parts.extend([Layout::Card, Layout::Apart].map(part));
                } else if size * u64::from(all_ways) == bytes {
                    parts.extend((0..all_ways).map(Layout::Way).map(part));
                }
            }
            let ways = match array.size {
                size if size == sets => 1,
                size if size == sets * u64::from(all_ways) => all_ways,
                _ => continue,
            };
            for is_side_by_side in [true, false] {
                if ways == 1 && !is_side_by_side {
                    continue;
                }
                let word = |way| Part::Word { memory: name.clone(), way, ways, is_side_by_side };
                parts.extend((0..ways).map(|way| (word(way), array.width)));
            }
        }
        // Of wires that are the same register the shortest name stands for all.
        let mut names: BTreeMap<String, (&str, usize)> = BTreeMap::new();
        for (name, bits) in cells::registers(module) {
            let is_of_array = name.rsplit_once('[').is_some_and(|(array, _)| arrays.contains_key(array));
            if !is_of_array && bits.len() <= MAX_WIDTH {
                let best = names.entry(json!(bits).to_string()).or_insert((name, bits.len()));
                if name.len() < best.0.len() {
                    best.0 = name;
                }
            }
        }
        parts.extend(names.into_values().map(|(name, width)| (Part::Wire(name.to_owned()), width)));
        let shown = |(n, (part, width))| Shown { part, wire: format!("found_part{n}"), width, is_set: false };
        Self { has_bytes, parts: parts.into_iter().enumerate().map(shown).collect(), ..Self::default() }
    }

    /// Drops relations by their numbers; those that consist of parts are taken apart. Whether there were any.
    pub fn drop(&mut self, numbers: &BTreeSet<usize>) -> bool {
        let relations = std::mem::take(&mut self.relations);
        let before = relations.len();
        for (n, relation) in relations.into_iter().enumerate() {
            if numbers.contains(&n) {
                let parts = relation.parts.into_iter();
                self.relations.extend(parts.map(Relation::whole));
            } else {
                self.relations.push(relation);
            }
        }
        numbers.iter().any(|&number| number < before)
    }

    /// The inputs that the harness has for what was found: their names and widths.
    #[must_use]
    pub fn inputs(&self, cache: &CacheConfig) -> Vec<(String, usize)> {
        let width =
            |shown: &Shown| if shown.is_set { cache.geometry.set_bits() as usize } else { shown.width };
        let parts = self.parts.iter().map(|shown| (shown.wire.clone(), width(shown)));
        self.commit.iter().map(|commit| (COMMIT.to_owned(), commit.width)).chain(parts).collect()
    }

    /// The wires that say what is known of a line that is loaded, where the implementation has the bytes of lines.
    fn loads(&self) -> &'static [(&'static str, usize)] {
        if self.has_bytes { &samples::LOADS } else { &[] }
    }
}
