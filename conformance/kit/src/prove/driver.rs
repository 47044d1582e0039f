//! A proof from beginning to end: netlists, counterexamples, faults of its own, covers, induction, PDR.

use super::checker;
use super::config::{ProveConfig, with_sets};
use super::harness::{self, FreeInput};
use super::report::{Planted, ProofReport, ProofVerdict, Stage, Trace};
use super::table::Table;
use super::tools::{Tools, run};
use super::trace;
use crate::error::Error;
use crate::kind::Kind as _;
use crate::session::Session;
use crate::target::shell_word;
use crate::vm::{Vm, config};
use saarcor_model::vm::CacheConfig;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Sets of the memory in which counterexamples are looked for, and of that which is proved with its reset.
const FEW_SETS: u64 = 2;
const RESET_SETS: u64 = 32;
/// Clocks that a search for counterexamples may reach.
const MOST_CLOCKS: u32 = 60;
/// Time that making netlists may take.
const NETLIST_LIMIT: Duration = Duration::from_secs(300);

/// Warnings of Yosys that say nothing about the proof: all others are errors.
const HARMLESS: &[&str] = &["Replacing memory"];

/// What is proved, and how long it may take.
#[derive(Clone, Debug)]
pub struct Asked<'a> {
    /// The implementation as it was named.
    pub name: String,
    /// The folder of `dut.toml`.
    pub folder: &'a Path,
    /// Its table `[prove]`.
    pub config: &'a ProveConfig,
    /// A folder for netlists and traces.
    pub work: &'a Path,
    /// Time that each search and each proof may take.
    pub limit: Duration,
    /// Whether it is proved from its ports alone, although its state is shown.
    pub from_ports: bool,
}

/// The steps of a proof.
struct Proof<'a> {
    asked: &'a Asked<'a>,
    tools: Tools,
    table: Table,
    sources: Vec<PathBuf>,
    free: Vec<FreeInput>,
    report: ProofReport,
}

/// A netlist: its name, the macros of the harness, and whether it is one for SMT.
struct Netlist<'a> {
    name: &'a str,
    macros: &'a [&'a str],
    for_smt: bool,
}

/// What ABC says of a netlist.
enum Found {
    /// No claim fails in so many clocks.
    Nothing(u32),
    /// A claim fails, the first after so many clocks.
    Failure { output: usize, clocks: u32 },
    /// No claim fails ever.
    Proved,
}

/// Proves an implementation, or refutes it.
///
/// # Errors
/// Where it cannot be judged: what is wrong with its sources or with `dut.toml`, and what would be right.
pub fn prove(asked: &Asked<'_>, tools: Tools) -> Result<ProofReport, Error> {
    let cache = asked.config.check()?;
    let table = Table::new(cache.geometry.ways(), cache.policy)?;
    let mut sources = Vec::new();
    for source in &asked.config.sources {
        let path = asked.folder.join(source);
        let path =
            path.canonicalize().map_err(Error::system(format!("{}: cannot be read", path.display())))?;
        sources.push(path);
    }
    let report = ProofReport::new(&asked.name, &config::text(&cache), &tools);
    let mut proof = Proof { asked, tools, table, sources, free: Vec::new(), report };
    proof.run(&cache)?;
    Ok(proof.report)
}

impl Proof<'_> {
    fn run(&mut self, cache: &CacheConfig) -> Result<(), Error> {
        let is_sized = self.asked.config.is_sized();
        let resized =
            |sets: u64| if is_sized { with_sets(cache, sets.min(cache.geometry.sets())) } else { *cache };
        let few = resized(FEW_SETS);
        self.ports(&few)?;
        let planted: Vec<_> = harness::planted(self.asked.config, &few).collect();
        let mut netlists = vec![
            Netlist { name: "claims", macros: &[], for_smt: false },
            Netlist { name: "covers", macros: &["SAARCOR_COVER"], for_smt: false },
        ];
        let macros: Vec<[&str; 1]> = planted.iter().map(|(name, _)| [*name]).collect();
        for (macros, (name, _)) in macros.iter().zip(&planted) {
            netlists.push(Netlist { name, macros, for_smt: false });
        }
        self.netlists("few", &few, 32, &netlists)?;
        if self.is_refuted(&few)? {
            return Ok(());
        }
        self.covers(&few)?;
        self.planted(&planted)?;
        let by_induction = self.asked.config.state.is_some() && !self.asked.from_ports;
        let is_proved = if by_induction {
            self.induction(cache, &resized(RESET_SETS))?
        } else {
            self.prove_from_ports(&few)?
        };
        let is_empty = self.report.covers.iter().any(|(_, reached)| reached.is_none())
            || self.report.planted.iter().any(|fault| fault.clocks.is_none());
        self.report.verdict =
            if is_proved && !is_empty { ProofVerdict::Proved } else { ProofVerdict::NotDecided };
        if is_empty {
            self.report.reason = "a fault of the run's own is not refuted, or something is never reached: what is proved may be empty".to_owned();
        }
        Ok(())
    }

    /// Looks at the ports of the top module: all that are named are there, as wide as they have to be; inputs that are
    /// not named are free.
    fn ports(&mut self, cache: &CacheConfig) -> Result<(), Error> {
        let config = self.asked.config;
        let mut script = self.read_sources(true);
        let parameters: String = config
            .parameters
            .iter()
            .map(|(name, value)| format!(" -set {name} {}", config.value(value, cache)))
            .collect();
        if !parameters.is_empty() {
            let _ = writeln!(script, "chparam{parameters} {}", config.top);
        }
        let _ = writeln!(script, "hierarchy -check -top {}\nproc\nwrite_json ports.json", config.top);
        self.yosys("ports", &script)?;
        let path = self.asked.work.join("ports.json");
        let text = fs::read_to_string(&path).map_err(Error::system("ports.json: cannot be read"))?;
        let json: serde_json::Value = serde_json::from_str(&text)
            .map_err(|error| Error::from(error.to_string()).within("ports.json"))?;
        let modules = json["modules"].as_object().into_iter().flatten();
        let top = modules.map(|(_, module)| module).find(|module| !module["attributes"]["top"].is_null());
        let Some(ports) = top.and_then(|module| module["ports"].as_object()) else {
            return Err(format!("module '{}' has no ports", config.top).into());
        };
        let named = config.ports(cache);
        for port in &named {
            let there = ports.get(&port.name).unwrap_or(&serde_json::Value::Null);
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
        for (name, port) in ports {
            let width = port["bits"].as_array().map_or(0, Vec::len) as u32;
            if port["direction"] == "input" && !named.iter().any(|port| port.name == *name) {
                self.free.push((name.clone(), width));
                self.report.assumed.push(format!("the input '{name}' has any value at each clock"));
            }
        }
        Ok(())
    }

    /// The commands that read the sources. What they assume or assert by themselves is taken away.
    fn read_sources(&self, has_reset: bool) -> String {
        let macros = if self.asked.config.state.is_some() { " -DSAARCOR_PROVE" } else { "" };
        let cold = if has_reset { "" } else { " -DSAARCOR_COLD" };
        let sources: Vec<_> = self.sources.iter().map(|path| format!("\"{}\"", path.display())).collect();
        format!("read_verilog -sv{macros}{cold} {}\nchformal -remove\n", sources.join(" "))
    }

    /// Makes netlists of the implementation beside the specification.
    fn netlists(
        &self,
        name: &str,
        cache: &CacheConfig,
        address_bits: u32,
        netlists: &[Netlist<'_>],
    ) -> Result<(), Error> {
        let is_cold = netlists.iter().any(|netlist| netlist.macros.contains(&"SAARCOR_COLD"));
        let set = format!("{name}-set.v");
        let prove = format!("{name}-prove.v");
        self.write(&set, &checker::verilog(cache, &self.table))?;
        self.write(&prove, &harness::verilog(self.asked.config, cache, address_bits, &self.free))?;
        let mut script = self.read_sources(!is_cold);
        script.push_str("design -save sources\n");
        for netlist in netlists {
            let macros: String = netlist.macros.iter().map(|macro_| format!(" -D{macro_}")).collect();
            let smt = if netlist.for_smt { " -DSAARCOR_SMT -DSAARCOR_STATE" } else { "" };
            let to = format!("{name}-{}", netlist.name);
            let _ = writeln!(
                script,
                "design -load sources\nread_verilog -sv -formal{macros}{smt} {set} {prove}\n\
                 hierarchy -check -top saarcor_prove\nproc\nflatten\nopt_clean\ncheck -assert\nsetundef -anyseq\n\
                 opt -keepdc -fast\n{}",
                if netlist.for_smt {
                    format!("memory_nordff\nasync2sync\ndffunmap\nopt_clean\nwrite_smt2 -wires {to}.smt2")
                } else {
                    format!(
                        "memory -nordff\nopt -fast\ntechmap\nopt -fast\nasync2sync\ndffunmap\nopt_clean\n\
                         abc -g AND -fast\nopt_clean\nsetundef -anyseq\n\
                         write_aiger -I -B -zinit -no-startoffset -map {to}.aim {to}.aig"
                    )
                }
            );
        }
        self.yosys(name, &script)
    }

    fn write(&self, name: &str, text: &str) -> Result<(), Error> {
        let path = self.asked.work.join(name);
        fs::write(&path, text).map_err(Error::system(format!("{}: cannot be written", path.display())))
    }

    /// Runs a script; what it warns of is an error.
    fn yosys(&self, name: &str, script: &str) -> Result<(), Error> {
        self.write(&format!("{name}.ys"), script)?;
        let ran = run(&format!("yosys -q -s {name}.ys"), self.asked.work, name, NETLIST_LIMIT)?;
        if ran.timed_out {
            return Err(format!("Yosys makes no netlist within {} s", NETLIST_LIMIT.as_secs()).into());
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

    /// A line of Yosys, with the names of sources as they were written.
    fn shown(&self, line: &str) -> String {
        let mut line = line.trim().to_owned();
        for (path, name) in self.sources.iter().zip(&self.asked.config.sources) {
            line = line.replace(&path.display().to_string(), name);
        }
        line
    }

    /// Runs ABC over a netlist.
    fn abc(&self, netlist: &str, command: &str) -> Result<(Found, f64), Error> {
        let script = format!("read_aiger {netlist}.aig; fold; strash; {command}; write_cex -a {netlist}.aiw");
        let command = format!("{} -c {}", self.tools.abc, shell_word(&script));
        let ran = run(
            &command,
            self.asked.work,
            &format!("{netlist}-abc"),
            self.asked.limit + Duration::from_secs(10),
        )?;
        let numbers = |line: &str| -> Vec<u32> {
            line.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect()
        };
        for line in ran.text.lines() {
            if let Some((before, after)) = line.split_once("was asserted in frame") {
                let output =
                    before.strip_prefix("Output ").map(numbers).and_then(|found| found.first().copied());
                let clocks = numbers(after).first().copied().unwrap_or_default();
                return Ok((
                    Found::Failure { output: output.unwrap_or_default() as usize, clocks: clocks + 1 },
                    ran.seconds,
                ));
            }
            if line.starts_with("Property proved") {
                return Ok((Found::Proved, ran.seconds));
            }
        }
        let reached = ran.text.lines().find_map(|line| line.split_once("No output asserted in"));
        let reached = reached.and_then(|(_, rest)| numbers(rest).first().copied());
        Ok((Found::Nothing(reached.unwrap_or_default()), ran.seconds))
    }

    fn search(&self) -> String {
        format!("bmc3 -T {} -F {MOST_CLOCKS}", (self.asked.limit.as_secs() / 4).max(1))
    }

    /// Looks for a counterexample among few sets.
    fn is_refuted(&mut self, few: &CacheConfig) -> Result<bool, Error> {
        let (found, seconds) = self.abc("few-claims", &self.search())?;
        let at = config::text(few);
        match found {
            Found::Failure { output, clocks } => {
                let claims: Vec<_> = harness::claims(self.asked.config).collect();
                let (claim, _, says) = claims.get(output).copied().copied().unwrap_or(("", "", "a claim"));
                let trace = self.trace(few, clocks)?;
                self.report.verdict = ProofVerdict::Refuted;
                self.report.stages.push(Stage {
                    name: "counterexample".to_owned(),
                    config: at,
                    says: format!("refuted after {clocks} clocks"),
                    seconds,
                });
                self.report.trace =
                    Some(Trace { claim: claim.to_owned(), says: says.to_owned(), clocks, ..trace });
                Ok(true)
            }
            Found::Nothing(clocks) => {
                self.report.reached = clocks;
                let says = format!("none in the first {clocks} clocks");
                self.report.stages.push(Stage {
                    name: "counterexample".to_owned(),
                    config: at,
                    says,
                    seconds,
                });
                Ok(false)
            }
            Found::Proved => Ok(false),
        }
    }

    /// The trace that ABC found, in the implementation's own signals and as requests.
    fn trace(&self, few: &CacheConfig, clocks: u32) -> Result<Trace, Error> {
        let read = |name: &str| {
            let path = self.asked.work.join(name);
            fs::read_to_string(&path).map_err(Error::system(format!("{}: cannot be read", path.display())))
        };
        // What a memory holds at first is left out: the simulation has no names for its words.
        let map = read("few-claims.aim")?;
        let map: Vec<_> = map.lines().filter(|line| !line.ends_with(']')).collect();
        self.write("trace.aim", &(map.join("\n") + "\n"))?;
        self.write("trace.aiw", &format!("1\nb0\n{}.\n", read("few-claims.aiw")?))?;
        let mut script = self.read_sources(true);
        script.push_str(
            "read_verilog -sv -formal few-set.v few-prove.v\nhierarchy -check -top saarcor_prove\nproc\nflatten\nopt_clean\n\
             sim -zinit -clock clock -r trace.aiw -map trace.aim -vcd trace.vcd\n",
        );
        self.write("trace.ys", &script)?;
        run("yosys -q -s trace.ys", self.asked.work, "trace", NETLIST_LIMIT)?;
        let vcd = read("trace.vcd")?;
        let requests = trace::requests(&vcd, clocks);
        let text: String = requests.iter().map(|request| format!("{request}\n")).collect();
        let session = Session::new("prove", Vm.hello(), &config::text(few), text.as_bytes());
        Ok(Trace { requests, suite: session.to_suite(), vcd: vcd.into_bytes(), ..Trace::default() })
    }

    /// Each thing that has to happen can.
    fn covers(&mut self, few: &CacheConfig) -> Result<(), Error> {
        let names = harness::covers(self.asked.config, few.geometry.ways());
        let limit = (self.asked.limit.as_secs() / 2).max(1);
        let script = format!("read_aiger few-covers.aig; fold; strash; bmc3 -a -T {limit} -F {MOST_CLOCKS}");
        let command = format!("{} -c {}", self.tools.abc, shell_word(&script));
        let ran = run(&command, self.asked.work, "covers-abc", self.asked.limit + Duration::from_secs(10))?;
        for (n, (name, _)) in names.into_iter().enumerate() {
            let reached = ran.text.lines().find_map(|line| {
                let (before, after) = line.split_once("was asserted in frame")?;
                let output = before.trim_start().strip_prefix("Output")?.split_whitespace().next()?;
                (output.parse() == Ok(n))
                    .then(|| after.trim().split(|c: char| !c.is_ascii_digit()).next()?.parse::<u32>().ok())?
            });
            self.report.covers.push((name, reached.map(|frame| frame + 1)));
        }
        Ok(())
    }

    /// Each fault that is planted is refuted.
    fn planted(&mut self, planted: &[&(&str, &str)]) -> Result<(), Error> {
        for (name, says) in planted {
            let (found, seconds) = self.abc(&format!("few-{name}"), &self.search())?;
            let clocks = match found {
                Found::Failure { clocks, .. } => Some(clocks),
                _ => None,
            };
            self.report.planted.push(Planted { says: (*says).to_owned(), clocks, seconds });
        }
        Ok(())
    }

    /// Whether it is proved by induction: with its reset at a reduced size, and with a cold set at the stated one.
    fn induction(&mut self, cache: &CacheConfig, reduced: &CacheConfig) -> Result<bool, Error> {
        let netlist = |macros| Netlist { name: "smt", macros, for_smt: true };
        self.netlists("reset", reduced, 32, &[netlist(&[])])?;
        let mut is_proved = self.by_induction("with the reset", "reset-smt", reduced)?;
        if reduced != cache {
            self.netlists("cold", cache, 32, &[netlist(&["SAARCOR_COLD"])])?;
            is_proved &= self.by_induction("a cold set", "cold-smt", cache)?;
            self.report.assumed.push(format!(
                "at {}: the set is cold in the first clock, nothing is answered then, and there is no reset",
                config::text(cache)
            ));
        }
        Ok(is_proved)
    }

    fn by_induction(&mut self, name: &str, netlist: &str, cache: &CacheConfig) -> Result<bool, Error> {
        let clocks = self.asked.config.latency + 1;
        let mut says = "proved by induction".to_owned();
        let mut seconds = 0.0;
        let mut is_proved = true;
        for (step, flags, fails) in [("base", "--presat", "the first clocks"), ("step", "-i", "the step")] {
            let command = format!(
                "yosys-smtbmc --noprogress -s {} {flags} -t {clocks} {netlist}.smt2",
                self.tools.solver
            );
            let ran = run(&command, self.asked.work, &format!("{netlist}-{step}"), self.asked.limit)?;
            seconds += ran.seconds;
            if !ran.text.contains("Status: PASSED") {
                is_proved = false;
                let end = if ran.timed_out { "not done in time" } else { "not proved" };
                says = format!("{fails} of the induction: {end}");
                self.report.reason = format!("{name}, {}: {says}", config::text(cache));
                break;
            }
        }
        self.report.stages.push(Stage { name: name.to_owned(), config: config::text(cache), says, seconds });
        Ok(is_proved)
    }

    /// Whether it is proved from its ports alone, by PDR.
    fn prove_from_ports(&mut self, few: &CacheConfig) -> Result<bool, Error> {
        let geometry = few.geometry;
        let lines_of_a_set = (2 * geometry.ways()).max(4).next_power_of_two().trailing_zeros();
        let address_bits =
            (geometry.line().0.trailing_zeros() + geometry.set_bits() + lines_of_a_set).min(32);
        self.netlists(
            "ports",
            few,
            address_bits,
            &[Netlist { name: "claims", macros: &[], for_smt: false }],
        )?;
        let (found, seconds) =
            self.abc("ports-claims", &format!("pdr -T {}", self.asked.limit.as_secs().max(1)))?;
        let size = format!("{}, addresses of {address_bits} bits", config::text(few));
        let (is_proved, says) = match found {
            Found::Proved => (true, "proved by PDR".to_owned()),
            Found::Failure { clocks, .. } => (false, format!("fails after {clocks} clocks")),
            Found::Nothing(_) => (false, "not done in time".to_owned()),
        };
        if !is_proved {
            self.report.reason = format!("from the ports alone: {says}");
        }
        self.report.assumed.push(format!("what is proved is {size}: no other size"));
        self.report.stages.push(Stage {
            name: "from the ports alone".to_owned(),
            config: size,
            says,
            seconds,
        });
        Ok(is_proved)
    }
}
