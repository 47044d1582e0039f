//! The cells of a netlist that hold an implementation's state, and how parts of it are shown to the harness.

use super::{COMMIT, FEWEST_SETS, Found, Part};
use saarcor_model::vm::CacheConfig;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

impl Found {
    /// Connects these inputs of the harness with what they stand for.
    pub fn connect(&self, netlist: &mut Value, top: &str, cache: &CacheConfig) {
        let module = &mut netlist["modules"][top];
        let arrays = arrays(module, cache.geometry.sets());
        let wires = self.commit.iter().map(|commit| (COMMIT.to_owned(), Part::Wire(commit.wire.clone())));
        let parts = self.parts.iter().map(|shown| (shown.wire.clone(), shown.part.clone()));
        for (input, part) in wires.chain(parts) {
            let bits = module["netnames"][&input]["bits"].clone();
            let wire = |name: &str| bits_of(&module["netnames"][name]["bits"]);
            // What is not there at this size is 0: the relations that it has are none.
            let word = |memory: &str, address: &dyn Fn(&Array) -> Vec<Value>| match arrays.get(memory) {
                Some(array) => array.word(memory, address(array), &bits),
                None => value(&[], &bits),
            };
            let mut cell = match &part {
                Part::Wire(name) => value(&wire(name), &bits),
                Part::Bytes { memory, layout } => word(memory, &|array| {
                    let above = (array.width / 8).trailing_zeros() as usize;
                    let bits = array.size.trailing_zeros() as usize;
                    wire(layout.wire()).into_iter().skip(above).take(bits).collect()
                }),
                Part::Word { memory, way, ways, is_side_by_side } => word(memory, &|_| {
                    let way_bits = ways.trailing_zeros();
                    let way = (0..way_bits).map(|bit| json!(if way >> bit & 1 == 1 { "1" } else { "0" }));
                    let set = wire("witness").into_iter().take(cache.geometry.set_bits() as usize);
                    if *is_side_by_side { way.chain(set).collect() } else { set.chain(way).collect() }
                }),
            };
            cell["attributes"] = json!({});
            module["cells"][format!("${input}")] = cell;
            // An output: else it would be a wire that may go.
            module["ports"][&input]["direction"] = json!("output");
        }
    }
}

fn bits_of(bits: &Value) -> Vec<Value> {
    bits.as_array().cloned().unwrap_or_default()
}

/// A number as a parameter of a cell.
pub(in crate::prove) fn binary(number: usize) -> String {
    format!("{number:032b}")
}

/// The cell whose output is a value, with zeros above it.
fn value(of: &[Value], output: &Value) -> Value {
    let zero = [json!("0")];
    let of = if of.is_empty() { &zero[..] } else { of };
    let width = bits_of(output).len();
    json!({
        "type": "$pos",
        "parameters": { "A_SIGNED": binary(0), "A_WIDTH": binary(of.len()), "Y_WIDTH": binary(width) },
        "port_directions": { "A": "input", "Y": "output" },
        "connections": { "A": of, "Y": output },
    })
}

/// Words with numbers: a memory, or registers.
pub(super) struct Array {
    pub size: u64,
    pub width: usize,
    /// The bits of all words; none of a memory.
    words: Option<Vec<Vec<Value>>>,
}

impl Array {
    /// The cell that reads a word.
    fn word(&self, memory: &str, address: Vec<Value>, output: &Value) -> Value {
        let width = bits_of(output).len();
        let Some(words) = &self.words else {
            return json!({
                "type": "$memrd",
                "parameters": {
                    "MEMID": format!("\\{memory}"), "ABITS": binary(address.len()), "WIDTH": binary(width),
                    "CLK_ENABLE": binary(0), "CLK_POLARITY": binary(0), "TRANSPARENT": binary(0),
                },
                "port_directions": { "ADDR": "input", "CLK": "input", "EN": "input", "DATA": "output" },
                "connections": { "ADDR": address, "CLK": ["x"], "EN": ["x"], "DATA": output },
            });
        };
        // Words of a power of two bits, so that the address is a shift.
        let padded = width.next_power_of_two();
        let zeros = |count: usize| std::iter::repeat_n(json!("0"), count);
        let pad = |word: &Vec<Value>| {
            word.iter().cloned().chain(zeros(padded.saturating_sub(word.len()))).collect::<Vec<_>>()
        };
        let all: Vec<Value> = words.iter().flat_map(pad).collect();
        let shift: Vec<Value> = zeros(padded.trailing_zeros() as usize).chain(address).collect();
        json!({
            "type": "$shiftx",
            "parameters": {
                "A_SIGNED": binary(0), "B_SIGNED": binary(0), "A_WIDTH": binary(all.len()),
                "B_WIDTH": binary(shift.len()), "Y_WIDTH": binary(width),
            },
            "port_directions": { "A": "input", "B": "input", "Y": "output" },
            "connections": { "A": all, "B": shift, "Y": output },
        })
    }
}

/// The arrays of an implementation by their names: memories, registers with numbers behind their names, which Yosys makes of
/// memories that are cleared as a whole, and registers of some bits a set.
pub(super) fn arrays(module: &Value, sets: u64) -> BTreeMap<String, Array> {
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
pub(super) fn registers(module: &Value) -> Vec<(&str, &Vec<Value>)> {
    let all = module["cells"].as_object().into_iter().flatten();
    let outputs: BTreeSet<String> = all
        .filter(|(_, cell)| cell["type"].as_str().is_some_and(|kind| kind.contains("dff")))
        .map(|(_, cell)| cell["connections"]["Q"].to_string())
        .collect();
    let wires = wires_of_dut(module).filter(|(_, bits)| outputs.contains(&bits.to_string()));
    wires.filter_map(|(name, bits)| Some((name, bits.as_array()?))).collect()
}

/// Makes wires outputs, so that a simulation shows them.
pub(in crate::prove) fn show(netlist: &mut Value, top: &str, wires: &[(String, usize)]) {
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
pub(super) fn wires_of_dut(module: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let all = module["netnames"].as_object().into_iter().flatten();
    all.map(|(name, wire)| (name.as_str(), &wire["bits"]))
        .filter(|(name, _)| is_of_dut(name) && !name.contains('$'))
}
