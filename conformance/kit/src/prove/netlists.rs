//! Netlists of an implementation beside the specification of one of its sets, by Yosys.

use super::aiger::Graph;
use super::checker;
use super::config::ProveConfig;
use super::driver::Asked;
use super::found::{self, Found};
use super::harness::{self, FreeInput};
use super::plant::settle_writes;
use super::simulation::{Memories, Simulation};
use super::table::Table;
use super::tools::run;
use crate::error::Error;
use saarcor_model::vm::CacheConfig;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

/// Time that making netlists may take.
const LIMIT: Duration = Duration::from_secs(300);
/// Time that making one for a simulation may take.
const SIMULATION_LIMIT: Duration = Duration::from_secs(100);
/// The module of the harness.
pub(super) const TOP: &str = "saarcor_prove";
/// Warnings of Yosys that say nothing about the proof: all others are errors.
const HARMLESS: &[&str] = &["Replacing memory"];

/// What stands beside the implementation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Violations of claims, as outputs.
    Violations,
    /// What has to be reached, as outputs.
    Covers,
    /// A violation with each of the run's own faults, as outputs; so many of the faults are in the state.
    Planted { parts: usize },
    /// Claims as assertions, for a search or for an induction, and with a cold set in the place of the reset or with it.
    Assertions { of: Assertions, is_cold: bool },
}

/// What is asserted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Assertions {
    /// The claims.
    Claims,
    /// The claims, and the relations that were found.
    Found,
    /// These, and claims about the state that is shown.
    State,
}

/// Who reads a netlist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reader {
    /// ABC. All that has no value in the first clock is 0, or any value.
    Abc { begins_at_zero: bool },
    /// A solver.
    Solver,
}

/// The sources of an implementation, and what its netlists have beside it.
pub(super) struct Netlists<'a> {
    asked: &'a Asked<'a>,
    sources: Vec<PathBuf>,
    table: Table,
    /// Inputs that are not named: each has any value at each clock.
    pub free: Vec<FreeInput>,
}

impl<'a> Netlists<'a> {
    /// Finds the sources, and looks at the ports of the top module.
    pub fn open(asked: &'a Asked<'a>, cache: &CacheConfig) -> Result<Self, Error> {
        let table = Table::new(cache.geometry.ways(), cache.policy)?;
        let mut sources = Vec::new();
        for source in &asked.config.sources {
            let path = asked.folder.join(source);
            let path =
                path.canonicalize().map_err(Error::system(format!("{}: cannot be read", path.display())))?;
            sources.push(path);
        }
        let mut netlists = Self { asked, sources, table, free: Vec::new() };
        netlists.free = netlists.look_at_ports(cache)?;
        Ok(netlists)
    }

    fn config(&self) -> &ProveConfig {
        self.asked.config
    }

    /// Whether the sources have a form for proofs that begin with a cold set.
    pub fn knows_cold(&self) -> bool {
        let mut texts = self.sources.iter().map(fs::read_to_string);
        texts.any(|text| text.is_ok_and(|text| text.contains("SAARCOR_COLD")))
    }

    /// Looks at the ports of the top module: all that are named are there, as wide as they have to be. Gives the inputs that
    /// are not named.
    fn look_at_ports(&self, cache: &CacheConfig) -> Result<Vec<FreeInput>, Error> {
        let config = self.config();
        let mut script = self.read_sources(false);
        let parameters: String = config
            .parameters
            .iter()
            .map(|(name, value)| format!(" -set {name} {}", config.value(value, cache)))
            .collect();
        if !parameters.is_empty() {
            let _ = writeln!(script, "chparam{parameters} {}", config.top);
        }
        let _ = writeln!(script, "hierarchy -check -top {}\nproc\nwrite_json ports.json", config.top);
        self.yosys("ports", &script, LIMIT)?;
        let json = self.json("ports")?;
        let modules = json["modules"].as_object().into_iter().flatten();
        let top = modules.map(|(_, module)| module).find(|module| !module["attributes"]["top"].is_null());
        let Some(ports) = top.and_then(|module| module["ports"].as_object()) else {
            return Err(format!("module '{}' has no ports", config.top).into());
        };
        let named = config.ports(cache);
        for port in &named {
            let there = ports.get(&port.name).unwrap_or(&Value::Null);
            let direction = if port.is_input { "input" } else { "output" };
            let width = there["bits"].as_array().map_or(0, Vec::len);
            if there["direction"] != direction || width != port.width as usize {
                let is = if there.is_null() {
                    "there is none".to_owned()
                } else {
                    format!("it is an {} of {width}", there["direction"].as_str().unwrap_or_default())
                };
                return Err(format!(
                    "module '{}', port '{}': {is}; it has to be an {direction} of {} bits",
                    config.top, port.name, port.width
                )
                .into());
            }
        }
        let mut free = Vec::new();
        for (name, port) in ports {
            let width = port["bits"].as_array().map_or(0, Vec::len) as u32;
            if port["direction"] == "input" && !named.iter().any(|port| port.name == *name) {
                free.push((name.clone(), width));
            }
        }
        Ok(free)
    }

    /// The command that reads the sources.
    fn read_sources(&self, is_cold: bool) -> String {
        let macros = if self.config().state.is_some() { " -DSAARCOR_PROVE" } else { "" };
        let cold = if is_cold { " -DSAARCOR_COLD" } else { "" };
        let sources: Vec<_> = self.sources.iter().map(|path| format!("\"{}\"", path.display())).collect();
        format!("read_verilog -sv{macros}{cold} {}\n", sources.join(" "))
    }

    /// The commands that put the implementation and the specification together. What the implementation assumes is taken
    /// away, and what it asserts where that is not asked for; in the first clock it asserts nothing.
    fn put_together(keeps_assertions: bool) -> String {
        let of_dut = format!("* {TOP} %d");
        let formal = if keeps_assertions {
            format!("chformal -assume -live -fair -cover -remove {of_dut}\nchformal -assert -skip 1 {of_dut}")
        } else {
            format!("chformal -remove {of_dut}")
        };
        format!("hierarchy -check -top {TOP}\nproc\n{formal}\nflatten\nopt_clean\n")
    }

    /// The implementation beside the specification, before memories are mapped: `NAME.json`.
    pub fn elaborate(
        &self,
        name: &str,
        cache: &CacheConfig,
        form: Form,
        found: &Found,
    ) -> Result<Value, Error> {
        let (mut macros, mut parts) = (String::new(), 0);
        let (mut is_cold, mut keeps_assertions) = (false, false);
        match form {
            Form::Violations => {}
            Form::Covers => macros.push_str(" -DSAARCOR_COVER"),
            Form::Planted { parts: of_state } => {
                parts = of_state;
                macros.push_str(" -DSAARCOR_PLANTED");
            }
            Form::Assertions { of, is_cold: cold } => {
                (is_cold, keeps_assertions) = (cold, of != Assertions::Claims && self.config().assertions);
                macros.push_str(" -DSAARCOR_SMT");
                macros.push_str(match of {
                    Assertions::Claims => "",
                    Assertions::Found => " -DSAARCOR_INDUCTION",
                    Assertions::State => " -DSAARCOR_INDUCTION -DSAARCOR_STATE",
                });
                macros.push_str(if cold { " -DSAARCOR_COLD" } else { "" });
            }
        }
        self.write(&format!("{name}-set.v"), &checker::verilog(cache, &self.table))?;
        self.write(
            &format!("{name}-prove.v"),
            &harness::verilog(self.config(), cache, &self.free, parts, found),
        )?;
        let script = format!(
            "{}read_verilog -sv -formal{macros} {name}-set.v {name}-prove.v\n{}check -assert\nwrite_json {name}.json\n",
            self.read_sources(is_cold),
            Self::put_together(keeps_assertions)
        );
        self.yosys(name, &script, LIMIT)?;
        let mut json = self.json(name)?;
        settle_writes(&mut json, TOP);
        found.connect(&mut json, TOP, cache);
        Ok(json)
    }

    /// A simulation of an elaborated netlist, which shows wires.
    pub fn simulation(
        &self,
        name: &str,
        json: &Value,
        wires: &[(String, usize)],
    ) -> Result<Simulation, Error> {
        let mut json = json.clone();
        found::show(&mut json, TOP, wires);
        let memories = Memories::take_out(&mut json, TOP);
        self.map_within(name, &json, Reader::Abc { begins_at_zero: true }, SIMULATION_LIMIT)?;
        let path = self.asked.work.join(format!("{name}.aig"));
        let graph = fs::read(&path).map_err(Error::system(format!("{}: cannot be read", path.display())))?;
        let graph = Graph::parse(&graph, &self.read(&format!("{name}.aim"))?)
            .ok_or_else(|| format!("{}: no netlist of Yosys", path.display()))?;
        Ok(Simulation::new(graph, memories))
    }

    /// Makes the netlist `to` that somebody reads of an elaborated one, which may have been edited.
    pub fn map(&self, to: &str, json: &Value, reader: Reader) -> Result<(), Error> {
        self.map_within(to, json, reader, LIMIT)
    }

    fn map_within(&self, to: &str, json: &Value, reader: Reader, limit: Duration) -> Result<(), Error> {
        self.write(&format!("{to}-map.json"), &json.to_string())?;
        self.yosys(&format!("{to}-map"), &format!("read_json {to}-map.json\n{}\n", mapped(reader, to)), limit)
    }

    /// Writes the waves of a trace that ABC found, `NETLIST.aiw`, of what was elaborated as `NAME`.
    pub fn waves(&self, name: &str, netlist: &str) -> Result<(), Error> {
        // What a memory holds at first is left out: the simulation has no names for its words.
        let map = self.read(&format!("{netlist}.aim"))?;
        let map: Vec<_> = map.lines().filter(|line| !line.ends_with(']')).collect();
        self.write("trace.aim", &(map.join("\n") + "\n"))?;
        self.write("trace.aiw", &format!("1\nb0\n{}.\n", self.read(&format!("{netlist}.aiw"))?))?;
        let mut script = self.read_sources(false);
        let _ = writeln!(
            script,
            "read_verilog -sv -formal {name}-set.v {name}-prove.v\n{}sim -zinit -clock clock -r trace.aiw -map trace.aim -vcd trace.vcd",
            Self::put_together(false)
        );
        self.write("trace.ys", &script)?;
        run("yosys -q -s trace.ys", self.asked.work, "trace", LIMIT)?;
        Ok(())
    }

    /// A netlist that Yosys wrote as JSON.
    fn json(&self, name: &str) -> Result<Value, Error> {
        let name = format!("{name}.json");
        serde_json::from_str(&self.read(&name)?).map_err(|error| Error::from(error.to_string()).within(name))
    }

    pub fn read(&self, name: &str) -> Result<String, Error> {
        let path = self.asked.work.join(name);
        fs::read_to_string(&path).map_err(Error::system(format!("{}: cannot be read", path.display())))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), Error> {
        let path = self.asked.work.join(name);
        fs::write(&path, text).map_err(Error::system(format!("{}: cannot be written", path.display())))
    }

    /// Runs a script; what it warns of is an error.
    fn yosys(&self, name: &str, script: &str, limit: Duration) -> Result<(), Error> {
        self.write(&format!("{name}.ys"), script)?;
        let ran = run(&format!("yosys -q -s {name}.ys"), self.asked.work, name, limit)?;
        if ran.timed_out {
            return Err(format!("Yosys makes no netlist within {} s", limit.as_secs()).into());
        }
        let wrong = ran.text.lines().find(|line| line.contains("ERROR: "));
        let wrong =
            wrong.filter(|line| !line.contains("Found ") || !line.contains("problems in 'check -assert'"));
        let warning = ran.text.lines().find(|line| {
            line.contains("Warning: ") && !HARMLESS.iter().any(|harmless| line.contains(harmless))
        });
        match wrong.or(warning) {
            Some(line) => Err(format!("Yosys: {}", self.shown(line)).into()),
            None if ran.succeeded => Ok(()),
            None => {
                Err(format!("Yosys fails: {}", self.shown(ran.text.lines().last().unwrap_or_default()))
                    .into())
            }
        }
    }

    /// A text of Yosys, with the names of sources as they were written.
    fn shown(&self, text: &str) -> String {
        let mut text = text.trim().to_owned();
        for (path, name) in self.sources.iter().zip(&self.asked.config.sources) {
            text = text.replace(&path.display().to_string(), name);
        }
        text
    }
}

/// The commands that map a netlist for its reader, and write it. A value x becomes any value at each clock.
fn mapped(reader: Reader, to: &str) -> String {
    let (memories, zeros, written) = match reader {
        Reader::Abc { begins_at_zero } => (
            "memory -nordff\nopt -fast\ntechmap\nopt -fast\nasync2sync\ndffunmap\nopt_clean\nabc -g AND -fast",
            if begins_at_zero { "setundef -zero -init\n" } else { "" },
            format!("write_aiger -I -zinit -no-startoffset -map {to}.aim {to}.aig"),
        ),
        Reader::Solver => ("memory_nordff\nasync2sync\ndffunmap", "", format!("write_smt2 -wires {to}.smt2")),
    };
    format!("setundef -anyseq\nopt -keepdc -fast\n{memories}\nopt_clean\nsetundef -anyseq\n{zeros}{written}")
}
