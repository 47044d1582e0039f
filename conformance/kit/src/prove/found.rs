//! What a run finds of an implementation that does not show its state: which memories and registers hold the lines of a
//! set, their order, and a request that waits; and how they stand to the specification's state.
//!
//! What holds in all clocks of a simulation is a guess, no more: each relation is then an assertion of a proof by induction,
//! which drops those that do not hold (Flanagan and Leino, *Houdini, an annotation assistant for ESC/Java*, 2001).

use super::aiger::Graph;
use super::config::ProveConfig;
use super::harness;
use saarcor_model::vm::{CacheConfig, HostAddr, LineAddr};
use saarcor_random::Random;
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
/// Most bits, and most values, of parts that are related as a whole.
const MAX_BITS: usize = 40;
const MAX_VALUES: usize = 800;
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
    /// A wire.
    Wire(String),
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
    /// The parts of the state.
    pub parts: Vec<Shown>,
    /// The relations.
    pub relations: Vec<Relation>,
}

impl Found {
    /// What may show the state of an implementation: its memories of a word or more a set, and its registers.
    #[must_use]
    pub fn candidates(netlist: &Value, top: &str, cache: &CacheConfig) -> Self {
        let module = &netlist["modules"][top];
        let (sets, all_ways) = (cache.geometry.sets(), cache.geometry.ways());
        let arrays = arrays(module, sets);
        let mut parts: Vec<(Part, usize)> = Vec::new();
        for (name, array) in &arrays {
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
        for (name, bits) in registers(module) {
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
        Self { parts: parts.into_iter().enumerate().map(shown).collect(), ..Self::default() }
    }

    /// Drops relations by their numbers; those that consist of parts are taken apart. Whether there were any.
    pub fn drop(&mut self, numbers: &BTreeSet<usize>) -> bool {
        let relations = std::mem::take(&mut self.relations);
        let before = relations.len();
        for (n, relation) in relations.into_iter().enumerate() {
            if numbers.contains(&n) {
                let parts = relation.parts.into_iter();
                self.relations.extend(parts.map(|text| Relation { text, parts: Vec::new() }));
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

    /// Connects these inputs of the harness with what they stand for.
    pub fn connect(&self, netlist: &mut Value, top: &str, cache: &CacheConfig) {
        let module = &mut netlist["modules"][top];
        let set: Vec<Value> = module["netnames"]["witness"]["bits"].as_array().cloned().unwrap_or_default();
        let set = &set[..set.len().min(cache.geometry.set_bits() as usize)];
        let arrays = arrays(module, cache.geometry.sets());
        let wires = self.commit.iter().map(|commit| (COMMIT.to_owned(), Part::Wire(commit.wire.clone())));
        let parts = self.parts.iter().map(|shown| (shown.wire.clone(), shown.part.clone()));
        for (input, part) in wires.chain(parts) {
            let bits = module["netnames"][&input]["bits"].clone();
            let width = bits.as_array().map_or(0, Vec::len);
            let binary = |number: usize| format!("{number:032b}");
            let cell = match part {
                Part::Wire(name) => {
                    let wire = &module["netnames"][name]["bits"];
                    let own = wire.as_array().map_or(0, Vec::len);
                    json!({
                        "type": "$pos",
                        "parameters": { "A_SIGNED": binary(0), "A_WIDTH": binary(own), "Y_WIDTH": binary(width) },
                        "port_directions": { "A": "input", "Y": "output" },
                        "connections": { "A": wire, "Y": bits },
                    })
                }
                Part::Word { memory, way, ways, is_side_by_side } => {
                    let way_bits = ways.trailing_zeros() as usize;
                    let way = (0..way_bits).map(|bit| json!(if way >> bit & 1 == 1 { "1" } else { "0" }));
                    let set = set.iter().cloned();
                    let address: Vec<Value> =
                        if is_side_by_side { way.chain(set).collect() } else { set.chain(way).collect() };
                    match arrays.get(&memory).map(|array| &array.words) {
                        // It is not there at this size: the relations that it has are none.
                        None => json!({
                            "type": "$pos",
                            "parameters": { "A_SIGNED": binary(0), "A_WIDTH": binary(1), "Y_WIDTH": binary(width) },
                            "port_directions": { "A": "input", "Y": "output" },
                            "connections": { "A": ["0"], "Y": bits },
                        }),
                        Some(None) => json!({
                            "type": "$memrd",
                            "parameters": {
                                "MEMID": format!("\\{memory}"), "ABITS": binary(address.len()), "WIDTH": binary(width),
                                "CLK_ENABLE": binary(0), "CLK_POLARITY": binary(0), "TRANSPARENT": binary(0),
                            },
                            "port_directions": { "ADDR": "input", "CLK": "input", "EN": "input", "DATA": "output" },
                            "connections": { "ADDR": address, "CLK": ["x"], "EN": ["x"], "DATA": bits },
                        }),
                        Some(Some(words)) => {
                            // Words of a power of two bits, so that the address is a shift.
                            let padded = width.next_power_of_two();
                            let pad = |word: &Vec<Value>| {
                                let zeros =
                                    std::iter::repeat_n(json!("0"), padded.saturating_sub(word.len()));
                                word.iter().cloned().chain(zeros).collect::<Vec<_>>()
                            };
                            let all: Vec<Value> = words.iter().flat_map(pad).collect();
                            let zeros = std::iter::repeat_n(json!("0"), padded.trailing_zeros() as usize);
                            let shift: Vec<Value> = zeros.chain(address).collect();
                            json!({
                                "type": "$shiftx",
                                "parameters": {
                                    "A_SIGNED": binary(0), "B_SIGNED": binary(0), "A_WIDTH": binary(all.len()),
                                    "B_WIDTH": binary(shift.len()), "Y_WIDTH": binary(width),
                                },
                                "port_directions": { "A": "input", "B": "input", "Y": "output" },
                                "connections": { "A": all, "B": shift, "Y": bits },
                            })
                        }
                    }
                }
            };
            module["cells"][format!("${input}")] = cell;
            module["cells"][format!("${input}")]["attributes"] = json!({});
            // An output: else it would be a wire that may go.
            module["ports"][&input]["direction"] = json!("output");
        }
    }
}

/// Words with numbers: a memory, or registers.
struct Array {
    size: u64,
    width: usize,
    /// The bits of all words; none of a memory.
    words: Option<Vec<Vec<Value>>>,
}

/// The arrays of an implementation by their names: memories, registers with numbers behind their names, which Yosys makes of
/// memories that are cleared as a whole, and registers of some bits a set.
fn arrays(module: &Value, sets: u64) -> BTreeMap<String, Array> {
    let mut arrays = BTreeMap::new();
    for (name, memory) in module["memories"].as_object().into_iter().flatten() {
        let number = |key: &str| memory[key].as_u64().unwrap_or_default();
        if is_of_dut(name) && number("start_offset") == 0 {
            let array = Array { size: number("size"), width: number("width") as usize, words: None };
            arrays.insert(name.clone(), array);
        }
    }
    let mut families: BTreeMap<&str, BTreeMap<usize, Vec<Value>>> = BTreeMap::new();
    for (name, bits) in registers(module) {
        let numbered = name.strip_suffix(']').and_then(|name| name.rsplit_once('['));
        if let Some((array, number)) = numbered
            && let Ok(number) = number.parse()
        {
            families.entry(array).or_default().insert(number, bits.clone());
        } else if (bits.len() as u64).is_multiple_of(sets) && sets >= FEWEST_SETS {
            let width = bits.len() / sets as usize;
            let words = bits.chunks(width).map(<[Value]>::to_vec).collect();
            arrays.insert(name.to_owned(), Array { size: sets, width, words: Some(words) });
        }
    }
    for (name, words) in families {
        let words: Vec<Vec<Value>> = words.into_values().collect();
        let (size, width) = (words.len() as u64, words[0].len());
        arrays.entry(name.to_owned()).or_insert(Array { size, width, words: Some(words) });
    }
    arrays
}

/// The registers of an implementation that have names, with their bits.
fn registers(module: &Value) -> Vec<(&str, &Vec<Value>)> {
    let all = module["cells"].as_object().into_iter().flatten();
    let outputs: BTreeSet<String> = all
        .filter(|(_, cell)| cell["type"].as_str().is_some_and(|kind| kind.contains("dff")))
        .map(|(_, cell)| cell["connections"]["Q"].to_string())
        .collect();
    let wires = wires_of_dut(module).filter(|(_, bits)| outputs.contains(&bits.to_string()));
    wires.filter_map(|(name, bits)| Some((name, bits.as_array()?))).collect()
}

/// Makes wires outputs, so that a simulation shows them.
pub(super) fn show(netlist: &mut Value, top: &str, wires: &[(String, usize)]) {
    let module = &mut netlist["modules"][top];
    for (name, _) in wires {
        // What nobody reads may have gone.
        let bits = module["netnames"][name]["bits"].clone();
        if bits.is_array() {
            module["ports"][name] = json!({ "direction": "output", "bits": bits });
        }
    }
}

fn is_of_dut(name: &str) -> bool {
    name.starts_with("dut.")
}

/// The wires of the implementation that have names, with their bits.
fn wires_of_dut(module: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let all = module["netnames"].as_object().into_iter().flatten();
    all.map(|(name, wire)| (name.as_str(), &wire["bits"]))
        .filter(|(name, _)| is_of_dut(name) && !name.contains('$'))
}

/// What a simulation showed of wires: of each bit a word a clock, with a bit for each of 64 runs. The first clock is left
/// out.
pub(super) struct Samples(BTreeMap<(String, usize), Vec<u64>>);

impl Samples {
    /// Simulates an implementation beside a specification of one of its sets, in 64 runs of random requests to few lines
    /// of few sets, and notes the bits of wires.
    pub fn new(graph: &mut Graph, cache: &CacheConfig, wires: &[(String, usize)]) -> Self {
        let mut random = Random::new(0);
        let sets = cache.geometry.sets();
        let offset_bits = cache.geometry.line().0.trailing_zeros();
        let ways = cache.geometry.ways() as usize;
        // Of each run: its set, the lines that it asks for, most of them of that set, and how often it resets.
        let runs: Vec<(u32, Vec<u32>, u64)> = (0..64)
            .map(|_| {
                let set = random.below(sets) as u32;
                let mut lines = Vec::new();
                while lines.len() < ways + 3 {
                    let line = random.bits() as u32 >> offset_bits;
                    if cache.set_of(LineAddr(line)).0 == set {
                        lines.push(line);
                    }
                }
                lines.extend((0..3).map(|_| random.bits() as u32 >> offset_bits));
                (set, lines, random.pick(&[0, 1, 5]))
            })
            .collect();
        let inputs: Vec<(String, usize, usize)> =
            graph.inputs.iter().map(|((name, bit), index)| (name.clone(), *bit, *index)).collect();
        let bits: Vec<(String, usize)> =
            wires.iter().flat_map(|(name, width)| (0..*width).map(|bit| (name.clone(), bit))).collect();
        let mut samples: Vec<Vec<u64>> = vec![Vec::with_capacity(CLOCKS); bits.len()];
        let mut values = vec![0; graph.input_count()];
        for clock in 0..=CLOCKS {
            let mut address = [0_u64; 32];
            let mut reset = 0;
            for (run, (_, lines, resets)) in runs.iter().enumerate() {
                let host = HostAddr(
                    random.pick(lines) << offset_bits | random.bits() as u32 & ((1 << offset_bits) - 1),
                );
                for (bit, word) in address.iter_mut().enumerate() {
                    *word |= u64::from(host.0 >> bit & 1) << run;
                }
                reset |= u64::from(random.percent(*resets)) << run;
            }
            for (name, bit, index) in &inputs {
                values[*index] = match name.as_str() {
                    "clock" => 0,
                    "free_address" => address[*bit],
                    "free_witness" => {
                        runs.iter().enumerate().map(|(run, (set, ..))| u64::from(set >> bit & 1) << run).sum()
                    }
                    "free_reset" => reset,
                    "free_valid" | "free_ready" => random.bits() | random.bits(),
                    "free_forget" => random.bits() & random.bits() & random.bits(),
                    "free_planted" => 0,
                    _ => random.bits(),
                };
            }
            graph.settle(&values);
            for (place, sample) in bits.iter().zip(&mut samples) {
                if clock > 0 {
                    sample.push(graph.output(place).unwrap_or_default());
                }
            }
            graph.rise();
        }
        Self(bits.into_iter().zip(samples).collect())
    }

    fn of(&self, name: &str, bit: usize) -> &[u64] {
        self.0.get(&(name.to_owned(), bit)).map_or(&[], Vec::as_slice)
    }

    /// Where there is no reset: a reset may clear an implementation at once.
    fn counts(&self) -> Vec<u64> {
        self.of("reset", 0).iter().map(|reset| !reset).collect()
    }
}

/// The wires of the harness that a simulation notes, with their widths.
#[must_use]
pub(super) fn watched(config: &ProveConfig, cache: &CacheConfig) -> Vec<(String, usize)> {
    let ways = cache.geometry.ways() as usize;
    [
        ("reset", 1),
        ("accepted", 1),
        ("answered", 1),
        ("stalled", 1),
        ("resident", ways),
        ("order", harness::order_bits(cache)),
        ("lines", 32 * ways),
        ("count", 4),
        ("waits", 4),
        ("known", 4),
        ("waited", 8),
        ("waiting", 33),
        ("sum", cache.geometry.set_bits() as usize),
        ("mine", 1),
        ("queue", harness::ENTRY * config.outstanding as usize),
    ]
    .into_iter()
    .chain(answer_of_waiting(ways))
    .map(|(name, width)| (name.to_owned(), width))
    .collect()
}

/// The wires that say what is to be answered to the request that waits, with their widths.
fn answer_of_waiting(ways: usize) -> [(&'static str, usize); 7] {
    [("matches", ways), ("present", 1), ("hit", 1), ("evicts", 1), ("way", 4), ("evicted", 32), ("card", 32)]
}

/// The narrow wires of an implementation, which may say when a request changes the state.
#[must_use]
pub(super) fn commit_wires(netlist: &Value, top: &str) -> Vec<(String, usize)> {
    let mut seen = BTreeSet::new();
    wires_of_dut(&netlist["modules"][top])
        .filter(|(_, bits)| bits.as_array().is_some_and(|bits| (1..=CONTROL_WIDTH).contains(&bits.len())))
        .filter(|(_, bits)| seen.insert(bits.to_string()))
        .map(|(name, bits)| (name.to_owned(), bits.as_array().map_or(0, Vec::len)))
        .collect()
}

/// What may say when a request changes the state: in a simulation in which each request does so at once, each request is
/// followed by one clock in which a wire has that value before it is answered.
pub(super) fn commits(samples: &Samples, outstanding: u32, wires: &[(String, usize)]) -> Vec<Commit> {
    let mut seen = BTreeSet::new();
    let mut commits = Vec::new();
    // Wires of one bit first.
    for width in 1..=CONTROL_WIDTH {
        for (wire, _) in wires.iter().filter(|(_, own)| *own == width) {
            for value in (0..1_u64 << width).rev() {
                let bits = (0..width).map(|number| Bit { wire, number, samples: samples.of(wire, number) });
                let steps = steps(samples, outstanding, &has_value(&Vec::from_iter(bits), value));
                if steps.is_some_and(|steps| seen.insert(steps)) {
                    commits.push(Commit { wire: wire.clone(), width, value });
                }
            }
        }
    }
    commits
}

/// Where bits have a value together.
fn has_value(bits: &[Bit<'_>], value: u64) -> Vec<u64> {
    let differs = |clock: usize, n: usize| {
        let wanted = if value >> n & 1 == 1 { u64::MAX } else { 0 };
        bits[n].samples[clock] ^ wanted
    };
    let clocks = bits.first().map_or(0, |bit| bit.samples.len());
    (0..clocks).map(|clock| (0..bits.len()).fold(u64::MAX, |all, n| all & !differs(clock, n))).collect()
}

/// The clocks in which requests change the state, if a wire says so; none where it cannot be that.
fn steps(samples: &Samples, outstanding: u32, wire: &[u64]) -> Option<Vec<u64>> {
    let word = |name: &str, clock: usize| samples.of(name, 0).get(clock).copied().unwrap_or_default();
    let mut steps = vec![0; wire.len()];
    for run in 0..64 {
        let (mut waits, mut known) = (0, 0);
        for (clock, step) in steps.iter_mut().enumerate() {
            let is = |word: u64| word >> run & 1 == 1;
            if is(word("reset", clock)) {
                (waits, known) = (0, 0);
                continue;
            }
            if is(word("answered", clock)) {
                known = if known == 0 { return None } else { known - 1 };
            }
            if is(wire[clock]) && waits > 0 {
                (waits, known) = (waits - 1, known + 1);
                *step |= 1 << run;
            }
            waits += u32::from(is(word("accepted", clock)));
            // The harness keeps one request that waits.
            if waits > 1 || waits + known > outstanding {
                return None;
            }
        }
    }
    Some(steps)
}

/// How many bits of a set's lines, and of which are resident, can have relations.
pub(super) fn most_of_set(cache: &CacheConfig) -> usize {
    cache.geometry.ways() as usize * (1 + 32 - cache.geometry.line().0.trailing_zeros() as usize)
}

/// What held in a simulation: of what was found the parts that have relations, and how many bits of the set's lines and of
/// which are resident have one.
pub(super) fn relations(samples: &Samples, candidates: &Found, cache: &CacheConfig) -> (Found, usize) {
    let mut found = candidates.clone();
    let (classes, counts) = (classes(samples, candidates, cache), samples.counts());
    let words: Vec<&str> = candidates.parts.iter().map(|shown| shown.wire.as_str()).collect();
    let mut equal = Vec::new();
    // Of each word the bits that have no relation of their own; and of narrow registers all that are no answers.
    let mut others: Vec<Vec<Bit<'_>>> = Vec::new();
    let mut controls: Vec<Bit<'_>> = Vec::new();
    for (shown, wire) in candidates.parts.iter().zip(&words) {
        let is_word = matches!(shown.part, Part::Word { .. });
        let mut unrelated = Vec::new();
        for number in 0..shown.width {
            let bit = Bit { wire, number, samples: samples.of(wire, number) };
            if bit.is_constant() {
                continue;
            }
            let own: Vec<Equal<'_>> = classes.iter().filter_map(|class| class.equal(bit)).collect();
            let is_answer = own.iter().any(|equal| equal.guard == ANSWER);
            if is_word && own.is_empty() {
                unrelated.push(bit);
            } else if !is_word && !is_answer && shown.width <= CONTROL_WIDTH {
                controls.push(bit);
            }
            equal.extend(own);
        }
        others.push(unrelated);
    }
    let of_waiting = match candidates.commit {
        Some(_) => classes_of_waiting(samples, candidates, cache, &controls),
        None => Vec::new(),
    };
    let registers = candidates.parts.iter().filter(|shown| matches!(shown.part, Part::Wire(_)));
    for shown in registers {
        for number in 0..shown.width {
            let bit = Bit { wire: &shown.wire, number, samples: samples.of(&shown.wire, number) };
            // What always holds comes first.
            let mut own = of_waiting.iter().filter_map(|class| class.equal(bit)).peekable();
            let is_plain = own.peek().is_some_and(|first| first.guard == of_waiting[0].guard);
            equal.extend(own.take(if is_plain { 1 } else { usize::MAX }));
        }
    }
    // Words lie side by side, or apart: what explains more of the set is right.
    let of = |word: usize| equal.iter().filter(|equal| equal.part.wire == words[word]).count();
    let is_right = |word: usize| match &candidates.parts[word].part {
        Part::Word { memory, ways: 2.., is_side_by_side, .. } => {
            let total = |side_by_side: bool| -> usize {
                let alike = (0..words.len()).filter(|&other| {
                    matches!(&candidates.parts[other].part, Part::Word { memory: name, is_side_by_side, .. }
                        if name == memory && *is_side_by_side == side_by_side)
                });
                alike.map(of).sum()
            };
            let (own, other) = (total(*is_side_by_side), total(!is_side_by_side));
            own > other || own == other && *is_side_by_side
        }
        _ => true,
    };
    let right: Vec<bool> = (0..words.len()).map(is_right).collect();
    let is_of_right = |wire: &str| words.iter().zip(&right).all(|(word, right)| *word != wire || *right);
    equal.retain(|equal| is_of_right(equal.part.wire));
    let is_of_set = |equal: &&Equal<'_>| ["resident", "lines"].contains(&equal.own.wire);
    let of_set: BTreeSet<_> =
        equal.iter().filter(is_of_set).map(|equal| (equal.own.wire, equal.own.number)).collect();
    let of_set = of_set.len();
    // A register that holds the set of the request that waits has its width.
    let set_bits = cache.geometry.set_bits() as usize;
    for shown in &mut found.parts {
        let is_sum = |equal: &&Equal<'_>| equal.part.wire == shown.wire && equal.own.wire == "sum";
        shown.is_set = shown.width == set_bits && equal.iter().filter(is_sum).count() == set_bits;
    }
    let is_set = |wire: &str| found.parts.iter().any(|shown| shown.is_set && shown.wire == wire);
    let (sets, equal): (Vec<_>, Vec<_>) = equal.into_iter().partition(|equal| is_set(equal.part.wire));
    let mut relations = runs(equal);
    relations.extend(sets.iter().filter(|equal| equal.own.number == 0).map(|equal| Relation {
        text: format!("{}{} == sum[SET_BITS-1:0]", equal.guard, equal.part.wire),
        parts: Vec::new(),
    }));
    // The order, in whatever form; with all that is left, or a word at a time.
    let bits = |wire: &'static str, numbers: std::ops::Range<usize>| {
        numbers.map(move |number| Bit { wire, number, samples: samples.of(wire, number) })
    };
    let order: Vec<_> = bits("order", 0..harness::order_bits(cache)).collect();
    let unrelated: Vec<Vec<Bit<'_>>> = others
        .into_iter()
        .zip(&right)
        .filter(|(bits, right)| **right && !bits.is_empty())
        .map(|(bits, _)| bits)
        .collect();
    match group(&[unrelated.concat(), order.clone()].concat(), &counts) {
        Some(relation) => relations.push(relation),
        None => relations
            .extend(unrelated.into_iter().filter_map(|bits| group(&[bits, order.clone()].concat(), &counts))),
    }
    // What registers say of requests that wait and of answers.
    let own = bits("count", 0..2)
        .chain(bits("waits", 0..1))
        .chain(bits("waited", 0..7))
        .chain(bits("stalled", 0..1));
    controls.extend(own.filter(|bit| !bit.is_constant()));
    relations.extend(group(&controls, &counts));
    let is_used = |shown: &Shown| {
        let names = [format!("{}[", shown.wire), format!("{} ", shown.wire)];
        relations.iter().any(|relation| names.iter().any(|name| relation.text.contains(name)))
    };
    found.parts.retain(is_used);
    found.relations = relations;
    (found, of_set)
}

/// The guard of answers: the oldest request that changed the state reads a line of the set.
const ANSWER: &str = "known == 0 || !queue[MINE] || ";

/// A bit by its wire and number, and what a simulation showed of it.
#[derive(Clone, Copy)]
struct Bit<'a> {
    wire: &'a str,
    number: usize,
    samples: &'a [u64],
}

impl Bit<'_> {
    fn is_constant(&self) -> bool {
        self.samples.iter().all(|&word| word == 0) || self.samples.iter().all(|&word| word == u64::MAX)
    }
}

/// Bits of the specification that mean something under one condition.
struct Class<'a> {
    /// What stands before a relation under it, in Verilog.
    guard: String,
    /// Where it holds.
    holds: Vec<u64>,
    bits: Vec<Bit<'a>>,
}

/// A bit of a part that is a bit of the specification.
struct Equal<'a> {
    guard: &'a str,
    part: Bit<'a>,
    own: Bit<'a>,
    is_inverted: bool,
}

impl<'a> Class<'a> {
    /// The bit of the specification that a bit of a part is, or is the inverse of.
    fn equal(&'a self, part: Bit<'a>) -> Option<Equal<'a>> {
        // A bit that hardly changes where it means something says little.
        let changes = |bit: &Bit<'_>| {
            let (mut ones, mut zeros) = (0, 0);
            for (word, holds) in bit.samples.iter().zip(&self.holds) {
                ones += (word & holds).count_ones();
                zeros += (!word & holds).count_ones();
            }
            ones > 8 && zeros > 8
        };
        if !changes(&part) {
            return None;
        }
        let differs = |own: &Bit<'_>, mask: u64| {
            let mut all = part.samples.iter().zip(own.samples).zip(&self.holds);
            all.any(|((part, own), holds)| (part ^ own ^ mask) & holds != 0)
        };
        self.bits.iter().find_map(|own| {
            let is_inverted = if !differs(own, 0) {
                false
            } else if !differs(own, u64::MAX) {
                true
            } else {
                return None;
            };
            Some(Equal { guard: &self.guard, part, own: *own, is_inverted })
        })
    }
}

fn classes<'a>(samples: &'a Samples, found: &Found, cache: &CacheConfig) -> Vec<Class<'a>> {
    let line_bits = 32 - cache.geometry.line().0.trailing_zeros() as usize;
    let bits = |wire: &'static str, numbers: std::ops::Range<usize>| -> Vec<Bit<'a>> {
        numbers.map(|number| Bit { wire, number, samples: samples.of(wire, number) }).collect()
    };
    let any = |wire: &'static str| -> Vec<u64> {
        let bits = bits(wire, 0..4);
        (0..CLOCKS).map(|clock| bits.iter().fold(0, |all, bit| all | bit.samples[clock])).collect()
    };
    let ways = cache.geometry.ways() as usize;
    let always = [
        bits("resident", 0..ways),
        bits("order", 0..harness::order_bits(cache)),
        bits("known", 0..2),
        bits("waits", 0..1),
    ];
    let mut classes = vec![Class { guard: String::new(), holds: samples.counts(), bits: always.concat() }];
    classes.extend((0..ways).map(|way| Class {
        guard: format!("!resident[{way}] || "),
        holds: samples.of("resident", way).to_vec(),
        bits: bits("lines", 32 * way..32 * way + line_bits),
    }));
    let is_answer =
        any("known").into_iter().zip(samples.of("queue", harness::MINE)).map(|(known, mine)| known & mine);
    classes.push(Class {
        guard: ANSWER.to_owned(),
        holds: is_answer.collect(),
        bits: bits("queue", 0..harness::MINE),
    });
    if found.commit.is_some() {
        let set_bits = cache.geometry.set_bits() as usize;
        let bits = [bits("waiting", 0..33), bits("sum", 0..set_bits)].concat();
        classes.push(Class { guard: "waits == 0 || ".to_owned(), holds: any("waits"), bits });
    }
    for class in &mut classes {
        class.holds.iter_mut().zip(samples.counts()).for_each(|(holds, counts)| *holds &= counts);
    }
    classes
}

/// What registers may hold while a request of the set waits: what was read of the set, and what is to be answered; always,
/// or where a register that controls others has a value.
fn classes_of_waiting<'a>(
    samples: &'a Samples,
    found: &'a Found,
    cache: &CacheConfig,
    controls: &[Bit<'a>],
) -> Vec<Class<'a>> {
    let ways = cache.geometry.ways() as usize;
    let words = found.parts.iter().filter(|shown| matches!(shown.part, Part::Word { .. }));
    let bits = |wire: &'a str, width: usize| {
        (0..width).map(move |number| Bit { wire, number, samples: samples.of(wire, number) })
    };
    let all: Vec<Bit<'a>> = words
        .map(|shown| (shown.wire.as_str(), shown.width))
        .chain(answer_of_waiting(ways))
        .flat_map(|(wire, width)| bits(wire, width))
        .collect();
    let waits = samples.of("waits", 0).iter().zip(samples.of("mine", 0)).map(|(waits, mine)| waits & mine);
    let waits: Vec<u64> = waits.zip(samples.counts()).map(|(waits, counts)| waits & counts).collect();
    let guard = "waits == 0 || !mine || ";
    let mut classes = vec![Class { guard: guard.to_owned(), holds: waits.clone(), bits: all.clone() }];
    for bits in controls.chunk_by(|a, b| a.wire == b.wire) {
        let (wire, width) = (bits[0].wire, bits.len());
        let name: Vec<_> = bits.iter().rev().map(|bit| format!("{wire}[{}]", bit.number)).collect();
        for value in 0..1_u64 << width {
            let holds =
                has_value(bits, value).into_iter().zip(&waits).map(|(has, waits)| has & waits).collect();
            let guard = format!("{guard}{{{}}} != {width}'d{value} || ", name.join(", "));
            classes.push(Class { guard, holds, bits: all.clone() });
        }
    }
    classes
}

/// Equal bits that follow each other as one relation.
fn runs(equal: Vec<Equal<'_>>) -> Vec<Relation> {
    let mut runs: Vec<Vec<Equal<'_>>> = Vec::new();
    for next in equal {
        let follows = |last: &Equal<'_>| {
            (last.guard, last.part.wire, last.own.wire, last.is_inverted)
                == (next.guard, next.part.wire, next.own.wire, next.is_inverted)
                && (last.part.number + 1, last.own.number + 1) == (next.part.number, next.own.number)
        };
        match runs.iter_mut().find(|run| run.last().is_some_and(follows)) {
            Some(run) => run.push(next),
            None => runs.push(vec![next]),
        }
    }
    let text = |run: &[Equal<'_>]| {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return String::new() };
        let range =
            |first: &Bit<'_>, last: &Bit<'_>| format!("{}[{}:{}]", first.wire, last.number, first.number);
        let not = if first.is_inverted { "~" } else { "" };
        format!("{}{} == {not}{}", first.guard, range(&first.part, &last.part), range(&first.own, &last.own))
    };
    let relation = |run: Vec<Equal<'_>>| {
        let parts = if run.len() == 1 { Vec::new() } else { run.chunks(1).map(text).collect() };
        Relation { text: text(&run), parts }
    };
    runs.into_iter().map(relation).collect()
}

/// That bits together have one of the values that they had; none where these are too many to say much.
fn group(bits: &[Bit<'_>], counts: &[u64]) -> Option<Relation> {
    if bits.is_empty() || bits.len() > MAX_BITS {
        return None;
    }
    let mut values = BTreeSet::new();
    for (clock, counts) in counts.iter().enumerate() {
        for run in (0..64).filter(|run| counts >> run & 1 == 1) {
            let bit = |bit: &Bit<'_>| bit.samples[clock] >> run & 1;
            values.insert(bits.iter().rev().fold(0, |value, next| value << 1 | bit(next)));
            if values.len() > MAX_VALUES {
                return None;
            }
        }
    }
    if values.len() >= 1 << bits.len() {
        return None;
    }
    let names: Vec<_> = bits.iter().rev().map(|bit| format!("{}[{}]", bit.wire, bit.number)).collect();
    let all = format!("{{{}}}", names.join(", "));
    let is_one = values.iter().map(|value: &u64| format!("{all} == {}'h{value:x}", bits.len()));
    Some(Relation { text: is_one.collect::<Vec<_>>().join(" || "), parts: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(wires: &[(&str, &[u64])]) -> Samples {
        let mut all: BTreeMap<(String, usize), Vec<u64>> =
            wires.iter().map(|(name, words)| (((*name).to_owned(), 0), words.to_vec())).collect();
        all.entry(("reset".to_owned(), 0)).or_insert(vec![0; wires[0].1.len()]);
        Samples(all)
    }

    /// A request is taken in clock 0, changes the state in clock 1 and is answered in clock 2, in one run.
    #[test]
    fn a_request_changes_the_state_once_before_its_answer() {
        let of = |commit: &[u64]| {
            let samples =
                samples(&[("accepted", &[1, 0, 0, 0]), ("answered", &[0, 0, 1, 0]), ("commit", commit)]);
            commits(&samples, 1, &[("commit".to_owned(), 1)]).iter().any(|commit| commit.value == 1)
        };
        assert!(of(&[0, 1, 0, 0]));
        // With no request it may be set.
        assert!(of(&[1, 1, 0, 1]));
        assert!(!of(&[1, 0, 1, 0]) && !of(&[0, 0, 0, 1]));
    }

    #[test]
    fn equal_bits_that_follow_each_other_are_one_relation() {
        let samples = [0b0101, 0b0011];
        let bit = |wire, number| Bit { wire, number, samples: &samples };
        let equal = |part, own, is_inverted| Equal {
            guard: "",
            part: bit("found_part0", part),
            own: bit("resident", own),
            is_inverted,
        };
        let relations = runs(vec![equal(0, 2, false), equal(1, 3, false), equal(2, 4, true)]);
        let texts: Vec<_> = relations.iter().map(|relation| relation.text.as_str()).collect();
        assert_eq!(texts, ["found_part0[1:0] == resident[3:2]", "found_part0[2:2] == ~resident[4:4]"]);
        let mut found = Found { relations, ..Found::default() };
        assert!(found.drop(&BTreeSet::from([0])));
        assert_eq!(found.relations[0].text, "found_part0[0:0] == resident[2:2]");
        assert_eq!(found.relations.len(), 3);
        assert!(found.drop(&BTreeSet::from([0, 1])) && found.relations.len() == 1);
        assert!(!found.drop(&BTreeSet::from([7])));
    }

    #[test]
    fn bits_together_have_the_values_that_they_had_without_a_reset() {
        let (low, high) = ([0b0011], [0b0101]);
        let bits =
            [("order", &low), ("found_part0", &high)].map(|(wire, samples)| Bit { wire, number: 0, samples });
        let group = |counts| group(&bits, &[counts]).map(|relation| relation.text);
        let both = "{found_part0[0], order[0]} ==";
        assert_eq!(group(0b0011), Some(format!("{both} 2'h1 || {both} 2'h3")));
        // All values say nothing.
        assert_eq!(group(0b1111), None);
    }
}
