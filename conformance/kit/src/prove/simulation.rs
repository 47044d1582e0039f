//! A simulation of a netlist: its logic as an and-inverter graph, its memories beside it as arrays.

use super::aiger::{Graph, Place};
use super::found::binary;
use super::plant::{kind, largest, memory_of};
use serde_json::{Value, json};

/// An input that is 0. All that memories are read and written with is changed where it is not, or Yosys would leave out
/// what is constant.
pub(super) const ZERO: &str = "memory_zero";
/// Times that reads are repeated whose addresses are themselves read.
const MOST_READS: usize = 4;

/// The memories that were taken out of a netlist, with the ports that read and write them.
#[derive(Debug, Default)]
pub(super) struct Memories {
    sizes: Vec<(usize, usize)>,
    reads: Vec<Port>,
    /// Of two that write the same word in a clock the later counts.
    writes: Vec<Port>,
}

/// A port of a memory.
#[derive(Debug)]
struct Port {
    memory: usize,
    address: Vec<Place>,
    data: Vec<Place>,
    /// Of a port that writes: which bits it writes.
    enable: Vec<Place>,
}

impl Memories {
    /// Takes the memories out of a netlist: what reads them becomes an input, and what they are read and written with an
    /// output. A memory that has values at first stays.
    pub fn take_out(netlist: &mut Value, top: &str) -> Self {
        let module = &mut netlist["modules"][top];
        let all: Vec<(String, Value)> = module["cells"]
            .as_object()
            .into_iter()
            .flatten()
            .map(|(name, cell)| (name.clone(), cell.clone()))
            .collect();
        let is_set = |name: &str| {
            all.iter().any(|(_, cell)| kind(cell).starts_with("$meminit") && memory_of(cell) == name)
        };
        let mut memories = Self::default();
        let zero = largest(&module["netnames"]) + 1;
        let mut free = zero + 1;
        add_port(module, ZERO, "input", &json!([zero]));
        let names: Vec<String> = module["memories"]
            .as_object()
            .into_iter()
            .flatten()
            .map(|(name, _)| format!("\\{name}"))
            .collect();
        for name in names.into_iter().filter(|name| !is_set(name)) {
            let of = &module["memories"][&name[1..]];
            let number = |key: &str| of[key].as_u64().unwrap_or_default() as usize;
            if number("start_offset") != 0 {
                continue;
            }
            let memory = memories.sizes.len();
            memories.sizes.push((number("size"), number("width")));
            let mut ports: Vec<_> = all.iter().filter(|(_, cell)| memory_of(cell) == name).collect();
            ports.sort_by_key(|(_, cell)| {
                cell["parameters"]["PORTID"]
                    .as_str()
                    .map_or(0, |bits| u64::from_str_radix(bits, 2).unwrap_or_default())
            });
            for (n, (cell_name, cell)) in ports.into_iter().enumerate() {
                let mut wires = |port: &str, direction: &str| -> Vec<Place> {
                    let mut bits = cell["connections"][port].clone();
                    let name = format!("memory{memory}_port{n}_{port}");
                    let width = bits.as_array().map_or(0, Vec::len);
                    if direction == "output" {
                        let shown: Vec<u64> = (free..).take(width).collect();
                        free += width as u64;
                        module["cells"][format!("${name}")] = json!({
                            "type": "$xor",
                            "parameters": {
                                "A_SIGNED": binary(0), "B_SIGNED": binary(0),
                                "A_WIDTH": binary(width), "B_WIDTH": binary(width), "Y_WIDTH": binary(width),
                            },
                            "attributes": {},
                            "port_directions": { "A": "input", "B": "input", "Y": "output" },
                            "connections": { "A": bits, "B": vec![zero; width], "Y": shown },
                        });
                        bits = json!(shown);
                    }
                    add_port(module, &name, direction, &bits);
                    (0..width).map(|bit| (name.clone(), bit)).collect()
                };
                let is_read = kind(cell).starts_with("$memrd");
                let data = wires("DATA", if is_read { "input" } else { "output" });
                let address = wires("ADDR", "output");
                let enable = if is_read { Vec::new() } else { wires("EN", "output") };
                let port = Port { memory, address, data, enable };
                if is_read { &mut memories.reads } else { &mut memories.writes }.push(port);
                if let Some(cells) = module["cells"].as_object_mut() {
                    cells.remove(cell_name);
                }
            }
            if let Some(all) = module["memories"].as_object_mut() {
                all.remove(&name[1..]);
            }
        }
        memories
    }
}

/// Adds a port to a module.
fn add_port(module: &mut Value, name: &str, direction: &str, bits: &Value) {
    module["ports"][name] = json!({ "direction": direction, "bits": bits });
    module["netnames"][name] = json!({ "hide_name": 0, "bits": bits, "attributes": {} });
}

/// A netlist that runs: 64 runs at once, a bit of a word each.
pub(super) struct Simulation {
    /// Its logic.
    pub graph: Graph,
    ports: Memories,
    /// Of each memory the words, of each word its bits.
    memories: Vec<Vec<Vec<u64>>>,
}

impl Simulation {
    /// Begins with zeros.
    pub fn new(graph: Graph, ports: Memories) -> Self {
        let memories = ports.sizes.iter().map(|&(size, width)| vec![vec![0; width]; size]).collect();
        Self { graph, ports, memories }
    }

    /// Takes the inputs of a clock. What memories are read for is among them.
    pub fn settle(&mut self, inputs: &mut [u64]) {
        for _ in 0..MOST_READS {
            self.graph.settle(inputs);
            let mut changed = false;
            for port in &self.ports.reads {
                let words = &self.memories[port.memory];
                let mut data = vec![0; port.data.len()];
                for run in 0..64 {
                    if let Some(word) = words.get(address(&self.graph, port, run)) {
                        data.iter_mut().zip(word).for_each(|(all, bits)| *all |= bits & (1 << run));
                    }
                }
                for (place, data) in port.data.iter().zip(data) {
                    if let Some(&input) = self.graph.inputs.get(place) {
                        changed |= std::mem::replace(&mut inputs[input], data) != data;
                    }
                }
            }
            if !changed {
                break;
            }
        }
    }

    /// Goes on to the next clock.
    pub fn rise(&mut self) {
        for port in &self.ports.writes {
            let bits = |places: &[Place]| -> Vec<u64> {
                places.iter().map(|place| self.graph.output(place).unwrap_or_default()).collect()
            };
            let enable = bits(&port.enable);
            let any = enable.iter().fold(0, |any, bits| any | bits);
            if any == 0 {
                continue;
            }
            let data = bits(&port.data);
            for run in (0..64).filter(|run| any >> run & 1 == 1) {
                if let Some(word) = self.memories[port.memory].get_mut(address(&self.graph, port, run)) {
                    for ((bits, data), enable) in word.iter_mut().zip(&data).zip(&enable) {
                        let mask = enable & (1 << run);
                        *bits = *bits & !mask | data & mask;
                    }
                }
            }
        }
        self.graph.rise();
    }
}

/// The address of a port in one of the runs.
fn address(graph: &Graph, port: &Port, run: usize) -> usize {
    let bit = |place: &Place| (graph.output(place).unwrap_or_default() >> run & 1) as usize;
    port.address.iter().rev().fold(0, |address, place| address << 1 | bit(place))
}
