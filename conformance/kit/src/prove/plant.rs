//! Faults that a run plants into the netlist of the implementation: what part of its state is never updated.

use super::found::binary;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// What the parts of the implementation are called in a netlist without hierarchy.
const PART: [&str; 2] = ["dut.", "$flatten\\dut."];
/// The wires that are judged.
const JUDGED: [&str; 7] =
    ["raw_hit", "raw_way", "raw_card", "raw_evicts", "dut_evicted", "answer_valid", "raw_data"];

/// The netlist of [`harness`](super::harness), as Yosys writes it in JSON before memories are mapped.
pub struct Plan<'a> {
    netlist: &'a Value,
    top: &'a str,
    cells: Vec<(&'a str, &'a Value)>,
    /// The cell that drives each bit.
    drivers: BTreeMap<u64, usize>,
    /// The cells that write each memory.
    writers: BTreeMap<&'a str, Vec<usize>>,
}

/// A part of the state: the cells that write it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name.
    pub name: String,
    cells: Vec<String>,
}

impl<'a> Plan<'a> {
    /// Looks at a netlist.
    #[must_use]
    pub fn new(netlist: &'a Value, top: &'a str) -> Self {
        let all = netlist["modules"][top]["cells"].as_object().into_iter().flatten();
        let cells: Vec<_> = all.map(|(name, cell)| (name.as_str(), cell)).collect();
        let mut drivers = BTreeMap::new();
        let mut writers: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (place, (_, cell)) in cells.iter().enumerate() {
            drivers.extend(ports(cell, true).flat_map(|(_, bits)| bits_of(bits)).map(|bit| (bit, place)));
            if is_write(cell) {
                writers.entry(memory_of(cell)).or_default().push(place);
            }
        }
        Self { netlist, top, cells, drivers, writers }
    }

    /// The cells that a judged output depends on, by their places.
    fn cone(&self) -> BTreeSet<usize> {
        let mut left: Vec<u64> = JUDGED.iter().flat_map(|name| bits_of(self.wire(name))).collect();
        let mut cone = BTreeSet::new();
        while let Some(bit) = left.pop() {
            let Some(&driver) = self.drivers.get(&bit) else { continue };
            let behind = self.writers.get(memory_of(self.cells[driver].1)).into_iter().flatten().copied();
            for place in behind.chain([driver]) {
                if cone.insert(place) {
                    left.extend(ports(self.cells[place].1, false).flat_map(|(_, bits)| bits_of(bits)));
                }
            }
        }
        cone
    }

    fn wire(&self, name: &str) -> &'a Value {
        &self.netlist["modules"][self.top]["netnames"][name]["bits"]
    }

    /// A judged output that has a bit which is never driven by anything but the value x.
    #[must_use]
    pub fn unknown(&self) -> Option<&'static str> {
        let is_x =
            |name: &str| self.wire(name).as_array().is_some_and(|bits| bits.iter().any(|bit| bit == "x"));
        JUDGED.into_iter().find(|name| is_x(name))
    }

    /// A register or a memory that does not change at the rising edge of the one clock, and what is wrong with it. Provers see
    /// no other clocks: to them each is that one.
    #[must_use]
    pub fn unclocked(&self) -> Option<String> {
        let clock = self.wire("clock");
        self.cells.iter().map(|(_, cell)| *cell).find_map(|cell| {
            let is = |parameter: &str| {
                cell["parameters"][parameter].as_str().is_some_and(|bits| bits.ends_with('1'))
            };
            let is_clocked = kind(cell).contains("dff") || kind(cell).starts_with("$mem") && is("CLK_ENABLE");
            let says = if kind(cell).contains("latch") || kind(cell) == "$sr" {
                "is a latch"
            } else if is_clocked && cell["connections"]["CLK"] != *clock {
                "has another clock"
            } else if is_clocked && !is("CLK_POLARITY") {
                "changes at the falling edge of the clock"
            } else {
                return None;
            };
            let name =
                if kind(cell).starts_with("$mem") { shown(memory_of(cell)) } else { self.name_of(cell) };
            Some(format!(
                "'{name}' {says}: there are proofs of registers that change at the rising edge of one clock"
            ))
        })
    }

    /// The parts of the state that judged outputs depend on: memories first.
    #[must_use]
    pub fn parts(&self) -> Vec<Part> {
        let mut memories: Vec<Part> = Vec::new();
        let mut registers = Vec::new();
        for place in self.cone() {
            let (cell_name, cell) = self.cells[place];
            if !PART.iter().any(|part| cell_name.starts_with(part)) {
                continue;
            }
            let cells = vec![cell_name.to_owned()];
            if is_write(cell) {
                // What is written at one place alone is a reset.
                if bits_of(&cell["connections"]["ADDR"]).next().is_none() {
                    continue;
                }
                let name = shown(memory_of(cell));
                match memories.iter_mut().find(|part| part.name == name) {
                    Some(part) => part.cells.extend(cells),
                    None => memories.push(Part { name, cells }),
                }
            } else if kind(cell).contains("dff") {
                registers.push(Part { name: self.name_of(cell), cells });
            }
        }
        memories.extend(registers);
        memories
    }

    /// The netlist in which bit `first + n` of the wire that plants faults lets part n keep what it holds.
    #[must_use]
    pub fn with_faults(&self, parts: &[Part], first: usize) -> Value {
        let mut netlist = self.netlist.clone();
        let module = &mut netlist["modules"][self.top];
        let planted: Vec<Value> = self.wire("planted").as_array().cloned().unwrap_or_default();
        // Each bit is one of a wire.
        let mut free = largest(&module["netnames"]) + 1;
        for (part, bit) in parts.iter().zip(planted.iter().skip(first)) {
            for name in &part.cells {
                let cell = &mut module["cells"][name];
                let port = if is_write(cell) { "EN" } else { "D" };
                let before = cell["connections"][port].clone();
                let width = before.as_array().map_or(0, Vec::len);
                let kept =
                    if is_write(cell) { json!(vec!["0"; width]) } else { cell["connections"]["Q"].clone() };
                let after: Vec<u64> = (free..).take(width).collect();
                free += width as u64;
                cell["connections"][port] = json!(after);
                module["cells"][format!("$planted{free}")] = json!({
                    "hide_name": 1,
                    "type": "$mux",
                    "parameters": { "WIDTH": binary(width) },
                    "attributes": {},
                    "port_directions": { "A": "input", "B": "input", "S": "input", "Y": "output" },
                    "connections": { "A": before, "B": kept, "S": [bit], "Y": after },
                });
            }
        }
        netlist
    }

    /// The name of a register: the shortest of the wires that are just its bits.
    fn name_of(&self, register: &Value) -> String {
        let wires = self.netlist["modules"][self.top]["netnames"].as_object().into_iter().flatten();
        let same = wires.filter(|(_, wire)| wire["bits"] == register["connections"]["Q"]);
        let name = same.map(|(name, _)| name).min_by_key(|name| (name.starts_with('$'), name.len()));
        shown(name.map_or("a register", String::as_str))
    }
}

/// The largest number of a bit among wires.
pub(super) fn largest(wires: &Value) -> u64 {
    let wires = wires.as_object().into_iter().flatten();
    wires.flat_map(|(_, wire)| bits_of(&wire["bits"])).max().unwrap_or_default()
}

/// What is written to a memory in a clock in which it is not written becomes 0. Yosys leaves a value x there, at muxes that
/// it makes of processes, which would be thousands of free inputs of a search.
pub fn settle_writes(netlist: &mut Value, top: &str) {
    let Some(cells) = netlist["modules"][top]["cells"].as_object_mut() else { return };
    let mut drivers = BTreeMap::new();
    let mut left = Vec::new();
    for (name, cell) in &*cells {
        drivers.extend(ports(cell, true).flat_map(|(_, bits)| bits_of(bits)).map(|bit| (bit, name.clone())));
        if is_write(cell) {
            left.extend(
                ports(cell, false).filter(|(port, _)| *port != "CLK").flat_map(|(_, bits)| bits_of(bits)),
            );
        }
    }
    let mut seen = BTreeSet::new();
    while let Some(bit) = left.pop() {
        let Some(name) = drivers.get(&bit) else { continue };
        let cell = &mut cells[name];
        let is_mux = name.contains("$procmux") && ["$mux", "$pmux"].contains(&kind(cell));
        if !(is_mux || kind(cell) == "$and") || !seen.insert(name.clone()) {
            continue;
        }
        for port in ["A", "B"] {
            left.extend(bits_of(&cell["connections"][port]));
            let bits = cell["connections"][port].as_array_mut().into_iter().flatten();
            for bit in bits.filter(|bit| is_mux && *bit == "x") {
                *bit = json!("0");
            }
        }
    }
}

pub(super) fn kind(cell: &Value) -> &str {
    cell["type"].as_str().unwrap_or_default()
}

fn is_write(cell: &Value) -> bool {
    kind(cell).starts_with("$memwr")
}

/// The memory that a cell reads or writes; empty for other cells.
pub(super) fn memory_of(cell: &Value) -> &str {
    cell["parameters"]["MEMID"].as_str().unwrap_or_default()
}

fn bits_of(bits: &Value) -> impl Iterator<Item = u64> + '_ {
    bits.as_array().into_iter().flatten().filter_map(Value::as_u64)
}

/// The ports of a cell: outputs, or inputs.
fn ports(cell: &Value, is_output: bool) -> impl Iterator<Item = (&str, &Value)> {
    let all = cell["connections"].as_object().into_iter().flatten();
    all.map(|(port, bits)| (port.as_str(), bits))
        .filter(move |(port, _)| (cell["port_directions"][*port] == "output") == is_output)
}

/// A name as the sources have it.
fn shown(name: &str) -> String {
    name.trim_start_matches('\\').trim_start_matches("dut.").to_owned()
}
