//! The table `[prove]` of `dut.toml`: what a proof has to know of an implementation in Verilog.

use crate::error::Error;
use crate::kind::Kind as _;
use crate::meta::config::MetaConfig;
use crate::meta::{self, Meta};
use crate::vm::{Vm, config};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Most clocks to an answer, and most requests without one.
const MAX_LATENCY: u32 = 64;
const MAX_OUTSTANDING: u32 = 8;

/// The table `[prove]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProveConfig {
    /// The cache that is proved, as a configuration of the kind; it is proved as if its first five keys were all.
    pub config: String,
    /// The top module.
    pub top: String,
    /// The source files, in the folder of `dut.toml`.
    pub sources: Vec<String>,
    /// The clock, whose rising edge counts.
    pub clock: String,
    /// The reset, which forgets all lines; `!NAME` where it is active low.
    pub reset: String,
    /// Parameters of the top module: a number, or the size that each is.
    #[serde(default)]
    pub parameters: BTreeMap<String, Parameter>,
    /// Most clocks from a request to its answer, where no answer waits to be taken; 0: in the clock of the request.
    #[serde(default = "one")]
    pub latency: u32,
    /// Most requests that are taken and not answered.
    #[serde(default = "one")]
    pub outstanding: u32,
    /// Whether the implementation's own assertions are proved too, and help the induction; else they are left out.
    #[serde(default)]
    pub assertions: bool,
    /// Ports of a request.
    pub request: RequestPorts,
    /// Ports of an answer.
    pub answer: AnswerPorts,
    /// Ports of the bytes of lines, where the implementation has them.
    pub data: Option<DataPorts>,
    /// Ports that show the state of one set.
    pub state: Option<StatePorts>,
}

fn one() -> u32 {
    1
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum Parameter {
    /// A number.
    Number(u32),
    /// The size of that name: one of [`SIZES`].
    Size(String),
}

/// The sizes that a parameter may be.
pub const SIZES: [&str; 9] =
    ["line", "lines", "sets", "ways", "line_bits", "set_bits", "way_bits", "hash", "policy"];

/// Ports of a request.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestPorts {
    /// Input: there is a request.
    pub valid: String,
    /// Output: it is taken. None: always.
    pub ready: Option<String>,
    /// Input: host address, 32 bits.
    pub address: String,
    /// Input: the request invalidates the line.
    pub invalidate: Option<String>,
}

/// Ports of an answer.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnswerPorts {
    /// Output: there is an answer, to an invalidation as well.
    pub valid: String,
    /// Input: it is taken. None: always.
    pub ready: Option<String>,
    /// Output: the line was resident.
    pub hit: String,
    /// Output: its way.
    pub way: Option<String>,
    /// Output: where the byte lies, 32 bits.
    pub card: Option<String>,
    /// Output: a line is evicted; judged where the line was not resident.
    pub evicts: Option<String>,
    /// Output: its first host address, 32 bits.
    pub evicted: Option<String>,
}

/// Ports of the bytes of lines: what is answered, and how a line comes from the host. The implementation asks for one line at
/// a time, and then gets its bytes, those of the lowest addresses first.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataPorts {
    /// Output: the bytes at the address of the request, aligned to their number; with the answer to a read.
    pub answer: String,
    /// Their bits.
    #[serde(default = "byte")]
    pub answer_bits: u32,
    /// Output: a line is asked for.
    pub load: String,
    /// Input: the host hears that. None: always.
    pub load_ready: Option<String>,
    /// Output: a host address in the line, 32 bits.
    pub load_address: String,
    /// Input: there are bytes of that line.
    pub fill: String,
    /// Output: they are taken. None: always.
    pub fill_ready: Option<String>,
    /// Input: the bytes.
    pub fill_data: String,
    /// Their bits.
    #[serde(default = "byte")]
    pub fill_bits: u32,
}

fn byte() -> u32 {
    8
}

/// Ports that show the state of one set, for a proof by induction.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatePorts {
    /// Input: the set.
    pub set: String,
    /// Output: a bit a way, whether it is resident.
    pub resident: String,
    /// Output: the lines of the ways, way 0 in the lowest bits.
    pub tags: String,
    /// Output: for LRU and FIFO, how many lines were used (loaded) after that of each way.
    pub ages: Option<String>,
    /// Output: for PLRU, the bits of nodes 1, 2 ..
    pub tree: Option<String>,
    /// The request that is taken and has not changed the state yet, where there can be one. None: a request changes the
    /// state in the clock in which it is taken.
    pub waiting: Option<WaitingPorts>,
}

/// Ports that show a request which is taken and has not changed the state yet. Its answer stands at the outputs from the clock
/// on that follows its change, until it is taken.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaitingPorts {
    /// Output: there is one.
    pub valid: String,
    /// Output: its host address, 32 bits.
    pub address: String,
    /// Output: whether it invalidates.
    pub invalidate: Option<String>,
    /// Output: it changes the state in this clock.
    pub commit: String,
}

impl ProveConfig {
    /// The cache that is proved, where all values are legal.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    pub fn check(&self, kind: &str) -> Result<CacheConfig, Error> {
        let cache = if kind == Meta.name() {
            meta::config::parse(&self.config).map(|config| config.cache)
        } else if kind == Vm.name() {
            config::parse(&self.config)
        } else {
            return Err(format!("kind {kind}: there are proofs of {} and {}", Vm.name(), Meta.name()).into());
        };
        let cache = cache.map_err(|error| error.within("prove.config"))?;
        if cache.geometry.ways() > 8 {
            return Err(format!(
                "prove.config: {} ways: there are proofs for 1, 2, 4 and 8",
                cache.geometry.ways()
            )
            .into());
        }
        if self.sources.is_empty() {
            return Err("prove.sources: name the files of the implementation".into());
        }
        for (key, value, least, most) in
            [("latency", self.latency, 0, MAX_LATENCY), ("outstanding", self.outstanding, 1, MAX_OUTSTANDING)]
        {
            if value < least || value > most {
                return Err(format!("prove.{key} = {value}: it is a number from {least} to {most}").into());
            }
        }
        let line_bits = 8 * cache.geometry.line().0;
        let bits = self.data.iter().flat_map(|data| [("answer", data.answer_bits), ("fill", data.fill_bits)]);
        for (key, value) in bits {
            if !value.is_power_of_two() || value < 8 || u64::from(value) > line_bits {
                return Err(format!(
                    "prove.data.{key}_bits = {value}: it is a power of two from 8 to {line_bits}, the bits of a line"
                )
                .into());
            }
        }
        for (parameter, value) in &self.parameters {
            if let Parameter::Size(size) = value
                && !SIZES.contains(&size.as_str())
            {
                return Err(format!(
                    "prove.parameters.{parameter} = \"{size}\": a number, or one of {}",
                    SIZES.join(", ")
                )
                .into());
            }
        }
        let names = [&self.top, &self.clock].into_iter().chain(self.parameters.keys());
        let ports = self.ports(&cache);
        for name in names.map(String::as_str).chain(ports.iter().map(|port| port.name.as_str())) {
            let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            if !is_name {
                return Err(format!("prove: '{name}' is no name of Verilog").into());
            }
        }
        if self.answer.way.is_none() && self.answer.card.is_none() {
            return Err("prove.answer: names neither the way nor the card address of a line".into());
        }
        if let Some(state) = &self.state {
            let order = if cache.policy == Policy::Plru { &state.tree } else { &state.ages };
            if order.is_none() {
                return Err("prove.state: shows 'tree' with PLRU, and 'ages' with LRU and FIFO".into());
            }
            let invalidates =
                |request: &Option<String>| request.is_some() == self.request.invalidate.is_some();
            if !state.waiting.as_ref().is_none_or(|waiting| invalidates(&waiting.invalidate)) {
                return Err("prove.state.waiting: shows 'invalidate' where prove.request has it".into());
            }
        }
        Ok(cache)
    }

    /// Takes another memory and another policy.
    ///
    /// # Errors
    /// Where the implementation has no parameter for it, or the size makes no cache.
    pub fn resize(&mut self, kind: &str, memory: Option<Bytes>, policy: Option<Policy>) -> Result<(), Error> {
        let mut cache = self.check(kind)?;
        if let Some(memory) = memory {
            let geometry = cache.geometry;
            cache.geometry = Geometry::new(memory, geometry.line(), geometry.ways())
                .map_err(|error| Error::from(error.to_string()).within("--memory"))?;
            if !self.is_sized() && cache.geometry != geometry {
                return Err(
                    "--memory: no parameter of the implementation is a number of sets or lines".into()
                );
            }
        }
        if let Some(policy) = policy {
            let is_chosen = |value: &Parameter| *value == Parameter::Size("policy".to_owned());
            if !self.parameters.values().any(is_chosen) && policy != cache.policy {
                return Err("--policy: no parameter of the implementation is a policy".into());
            }
            cache.policy = policy;
        }
        self.config = if kind == Meta.name() {
            let config = meta::config::parse(&self.config)?;
            meta::config::text(&MetaConfig { cache, ..config })
        } else {
            config::text(&cache)
        };
        self.check(kind).map(|_| ())
    }

    /// Whether the number of sets can be chosen.
    #[must_use]
    pub fn is_sized(&self) -> bool {
        self.parameters.values().any(|value| {
            matches!(value, Parameter::Size(size) if ["lines", "sets", "set_bits"].contains(&size.as_str()))
        })
    }

    /// Bytes of the lines of a small cache. A line that comes from the host takes a clock for each part: two are enough.
    #[must_use]
    pub fn short_line(&self, cache: &CacheConfig) -> Bytes {
        let is_sized = |value: &Parameter| matches!(value, Parameter::Size(size) if ["line", "line_bits"].contains(&size.as_str()));
        let line = cache.geometry.line();
        match &self.data {
            Some(data) if self.parameters.values().any(is_sized) => {
                Bytes(line.0.min(u64::from(2 * data.fill_bits.max(data.answer_bits) / 8)))
            }
            _ => line,
        }
    }

    /// The value of a parameter for a cache.
    #[must_use]
    pub fn value(&self, parameter: &Parameter, cache: &CacheConfig) -> u64 {
        let geometry = cache.geometry;
        match parameter {
            Parameter::Number(number) => u64::from(*number),
            Parameter::Size(size) => match size.as_str() {
                "line" => geometry.line().0,
                "lines" => geometry.lines(),
                "sets" => geometry.sets(),
                "ways" => u64::from(geometry.ways()),
                "line_bits" => u64::from(geometry.line().0.trailing_zeros()),
                "set_bits" => u64::from(geometry.set_bits()),
                "way_bits" => u64::from(geometry.ways().trailing_zeros()),
                "policy" => match cache.policy {
                    Policy::Fifo => 0,
                    Policy::Plru => 1,
                    Policy::Lru => 2,
                },
                _ => match cache.hash {
                    Hash::Low => 0,
                    Hash::AddUpper => 1,
                    Hash::AddUpperAll => 2,
                },
            },
        }
    }

    /// The port that is bound to a wire.
    #[must_use]
    pub fn port_of(&self, cache: &CacheConfig, wire: &str) -> String {
        self.ports(cache).into_iter().find(|port| port.wire == wire).map_or(wire.to_owned(), |port| port.name)
    }

    /// The ports that are named, with their directions and widths.
    #[must_use]
    pub fn ports(&self, cache: &CacheConfig) -> Vec<Port> {
        let ways = cache.geometry.ways();
        let way_bits = ways.trailing_zeros().max(1);
        let tag_bits = 32 - cache.geometry.line().0.trailing_zeros();
        let port = |name: &str, is_input, wire, width| Port { name: name.to_owned(), is_input, wire, width };
        let mut ports = vec![
            port(&self.clock, true, "clock", 1),
            port(
                self.reset.trim_start_matches('!'),
                true,
                if self.reset.starts_with('!') { "!reset" } else { "reset" },
                1,
            ),
            port(&self.request.valid, true, "valid", 1),
            port(&self.request.address, true, "dut_address", 32),
            port(&self.answer.valid, false, "answer_valid", 1),
            port(&self.answer.hit, false, "raw_hit", 1),
        ];
        let mut optional = |name: &Option<String>, is_input, wire, width| {
            ports.extend(name.as_deref().map(|name| port(name, is_input, wire, width)));
        };
        optional(&self.request.ready, false, "ready", 1);
        optional(&self.request.invalidate, true, "dut_forget", 1);
        optional(&self.answer.ready, true, "answer_ready", 1);
        optional(&self.answer.way, false, "raw_way", way_bits);
        optional(&self.answer.card, false, "raw_card", 32);
        optional(&self.answer.evicts, false, "raw_evicts", 1);
        optional(&self.answer.evicted, false, "dut_evicted", 32);
        if let Some(data) = &self.data {
            optional(&Some(data.answer.clone()), false, "raw_data", data.answer_bits);
            optional(&Some(data.load.clone()), false, "load", 1);
            optional(&data.load_ready, true, "load_ready", 1);
            optional(&Some(data.load_address.clone()), false, "load_address", 32);
            optional(&Some(data.fill.clone()), true, "fill", 1);
            optional(&data.fill_ready, false, "fill_ready", 1);
            optional(&Some(data.fill_data.clone()), true, "fill_data", data.fill_bits);
        }
        if let Some(state) = &self.state {
            optional(&Some(state.set.clone()), true, "witness", 32);
            optional(&Some(state.resident.clone()), false, "shown_resident", ways);
            optional(&Some(state.tags.clone()), false, "shown_tags", ways * tag_bits);
            optional(&state.ages, false, "shown_ages", ways * way_bits);
            optional(&state.tree, false, "shown_tree", (ways - 1).max(1));
            if let Some(waiting) = &state.waiting {
                optional(&Some(waiting.valid.clone()), false, "shown_waiting", 1);
                optional(&Some(waiting.address.clone()), false, "shown_address", 32);
                optional(&waiting.invalidate, false, "shown_forget", 1);
                optional(&Some(waiting.commit.clone()), false, "shown_commit", 1);
            }
        }
        ports
    }
}

/// A port of the top module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Whether it is an input.
    pub is_input: bool,
    /// What it is bound to.
    pub wire: &'static str,
    /// Its bits.
    pub width: u32,
}

/// The cache with that many sets, of lines of so many bytes; its ways, hash and policy stay.
#[must_use]
pub fn with_sets(cache: &CacheConfig, sets: u64, line: Bytes) -> CacheConfig {
    let ways = cache.geometry.ways();
    let memory = Bytes(sets * line.0 * u64::from(ways));
    CacheConfig { geometry: Geometry::new(memory, line, ways).unwrap_or(cache.geometry), ..*cache }
}
