//! A proof from beginning to end: induction or PDR; else counterexamples; and what shows that a proof is not empty.

use super::config::{ProveConfig, with_sets};
use super::harness;
use super::netlists::{For, Netlist, Netlists, TOP};
use super::plant::{Plan, settle_writes};
use super::report::{Planted, ProofReport, ProofVerdict, Stage, Trace};
use super::tools::{Ran, Tools, run};
use super::trace::{self, Request};
use crate::error::Error;
use crate::kind::Kind as _;
use crate::meta::config::MetaConfig;
use crate::meta::{self, Meta};
use crate::session::Session;
use crate::target::shell_word;
use crate::vm::{Vm, config};
use saarcor_model::vm::CacheConfig;
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

/// Sets of the memory in which counterexamples are looked for, and of that which is proved with its reset.
const FEW_SETS: u64 = 2;
const RESET_SETS: u64 = 32;
/// Clocks that a search for counterexamples may reach.
const MOST_CLOCKS: u32 = 60;
/// Parts of the state whose updates are dropped.
const MOST_PARTS: usize = 4;
/// Faults of the run's own that have to be refuted at least.
const LEAST_PLANTED: usize = 3;

/// What is proved, and how long it may take.
#[derive(Clone, Debug)]
pub struct Asked<'a> {
    /// The implementation as it was named.
    pub name: String,
    /// The kind that `dut.toml` names.
    pub kind: &'a str,
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
    netlists: Netlists<'a>,
    report: ProofReport,
    progress: &'a (dyn Fn(&str) + Sync),
}

/// A size that is proved by induction.
#[derive(Clone, Copy)]
struct Size<'a> {
    /// The name of its netlists.
    name: &'static str,
    cache: &'a CacheConfig,
    /// Whether the set is assumed to be cold, in the place of the reset.
    is_cold: bool,
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

/// How an induction ends.
struct Induction {
    is_proved: bool,
    says: String,
    seconds: f64,
}

/// Proves an implementation, or refutes it; `progress` hears what is done.
///
/// # Errors
/// Where it cannot be judged: what is wrong with its sources or with `dut.toml`, and what would be right.
pub fn prove(
    asked: &Asked<'_>,
    tools: Tools,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<ProofReport, Error> {
    let cache = asked.config.check(asked.kind)?;
    let is_sized = asked.config.is_sized();
    let resized =
        |sets: u64| if is_sized { with_sets(&cache, sets.min(cache.geometry.sets())) } else { cache };
    let (few, reduced) = (resized(FEW_SETS), resized(RESET_SETS));
    progress("Yosys reads the sources");
    let netlists = Netlists::open(asked, &few)?;
    let mut report = ProofReport::new(&asked.name, asked.kind, &config::text(&cache), &tools);
    let free =
        netlists.free.iter().map(|(name, _)| format!("the input '{name}' has any value at each clock"));
    report.assumed.extend(free);
    let mut proof = Proof { asked, tools, netlists, report, progress };
    proof.run(&cache, &reduced, &few)?;
    Ok(proof.report)
}

impl Proof<'_> {
    fn run(&mut self, cache: &CacheConfig, reduced: &CacheConfig, few: &CacheConfig) -> Result<(), Error> {
        let by_induction = self.asked.config.state.is_some() && !self.asked.from_ports;
        let sizes = if by_induction { sizes(cache, reduced) } else { Vec::new() };
        let (few_claims, inductions) = std::thread::scope(|scope| {
            let few = scope.spawn(|| self.few(few));
            let mut inductions = Vec::new();
            for size in &sizes {
                let done = self.induction(size);
                let goes_on = done.as_ref().is_ok_and(|done| done.is_proved);
                inductions.push(done);
                if !goes_on {
                    break;
                }
            }
            (few.join(), inductions)
        });
        let few_claims = few_claims.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        let mut is_proved = by_induction;
        for (size, done) in sizes.iter().zip(inductions) {
            let done = done?;
            is_proved &= done.is_proved;
            let says = if size.is_cold { "with a cold set" } else { "with the reset" };
            let at = config::text(size.cache);
            if !done.is_proved {
                self.report.reason = format!("{says}, {at}: {}", done.says);
            }
            if size.is_cold {
                self.report.assumed.push(format!(
                    "at {at}: the set is cold in the first clock, nothing is answered then, and there is no reset"
                ));
            }
            self.stage(says, at, done.says, done.seconds);
        }
        if !is_proved {
            self.netlists.map("few-any", &few_claims, For::Abc { begins_at_zero: false })?;
        }
        if !by_induction {
            is_proved = self.prove_from_ports(few)?;
        }
        if !is_proved && self.is_refuted(cache, reduced, few)? {
            return Ok(());
        }
        if !is_proved {
            return Ok(());
        }
        self.show_covers(few)?;
        self.plant(few, &few_claims)?;
        let unreached = self.report.covers.iter().find(|(_, clocks)| clocks.is_none());
        let not_refuted = self.report.planted.iter().find(|fault| fault.clocks.is_none());
        let planted = self.report.planted.len();
        self.report.reason = if let Some((name, _)) = unreached {
            format!("the proof may be empty: {name} is never reached")
        } else if let Some(fault) = not_refuted {
            format!("the proof may be empty: with a fault planted ({}) nothing fails", fault.says)
        } else if planted < LEAST_PLANTED {
            format!("the proof may be empty: only {planted} faults of {LEAST_PLANTED} could be planted")
        } else {
            self.report.verdict = ProofVerdict::Proved;
            String::new()
        };
        Ok(())
    }

    /// The netlist of the claims with few sets.
    fn few(&self, few: &CacheConfig) -> Result<Value, Error> {
        let claims = Netlist { name: "claims", choice: None, used_by: For::Abc { begins_at_zero: true } };
        self.netlists.make("few", few, 32, 0, &[claims])?;
        let json = self.netlists.json("few-claims")?;
        let plan = Plan::new(&json, TOP);
        if let Some(says) = plan.unclocked() {
            return Err(says.into());
        }
        if let Some(wire) = plan.unknown() {
            let port = self.asked.config.port_of(few, wire);
            return Err(format!("port '{port}' has the value x: give it a value").into());
        }
        Ok(json)
    }

    fn stage(&mut self, name: &str, config: String, says: String, seconds: f64) {
        self.report.stages.push(Stage { name: name.to_owned(), config, says, seconds });
    }

    /// Runs ABC over a netlist.
    fn abc(&self, netlist: &str, command: &str, limit: Duration) -> Result<(Found, f64), Error> {
        let script = format!("read_aiger {netlist}.aig; strash; {command}; write_cex -a {netlist}.aiw");
        let command = format!("{} -c {}", self.tools.abc, shell_word(&script));
        let limit = limit + Duration::from_secs(10);
        let ran = run(&command, self.asked.work, &format!("{netlist}-abc"), limit)?;
        for line in ran.text.lines() {
            if let Some((before, after)) = line.split_once("was asserted in frame") {
                let output = before.rsplit("Output").next().map(numbers).unwrap_or_default();
                let clocks = numbers(after).first().copied().unwrap_or_default();
                let output = output.first().copied().unwrap_or_default() as usize;
                return Ok((Found::Failure { output, clocks: clocks + 1 }, ran.seconds));
            }
            if line.starts_with("Property proved") {
                return Ok((Found::Proved, ran.seconds));
            }
        }
        let reached = ran.text.lines().find_map(|line| line.split_once("No output asserted in"));
        let reached = reached.and_then(|(_, rest)| numbers(rest).first().copied());
        Ok((Found::Nothing(reached.unwrap_or_default()), ran.seconds))
    }

    /// A search for a failure by ABC.
    fn search(&self, netlist: &str, limit: Duration) -> Result<(Found, f64), Error> {
        self.abc(netlist, &format!("bmc3 -T {} -F {MOST_CLOCKS}", limit.as_secs().max(1)), limit)
    }

    /// Looks for a counterexample: first for a short time among few sets, then for faults of larger memories, which are found by
    /// few requests or not at all, and then among few sets again.
    fn is_refuted(
        &mut self,
        cache: &CacheConfig,
        reduced: &CacheConfig,
        few: &CacheConfig,
    ) -> Result<bool, Error> {
        let limit = self.asked.limit;
        if self.is_refuted_among_few(few, "few-claims", limit / 8)? {
            return Ok(true);
        }
        // A set can be cold where it is shown.
        let is_shown = self.asked.config.state.is_some();
        for size in sizes(cache, reduced).iter().rev().filter(|size| !size.is_cold || is_shown) {
            if self.is_refuted_at_size(size, limit / 4)? {
                return Ok(true);
            }
        }
        // A trace that begins with zeros can be replayed; what only shows with other values comes last.
        Ok(self.is_refuted_among_few(few, "few-claims", limit)?
            || self.is_refuted_among_few(few, "few-any", limit / 4)?)
    }

    fn is_refuted_among_few(
        &mut self,
        few: &CacheConfig,
        netlist: &str,
        limit: Duration,
    ) -> Result<bool, Error> {
        (self.progress)("ABC looks for a counterexample");
        let (found, seconds) = self.search(netlist, limit)?;
        let at = config::text(few);
        match found {
            Found::Failure { output, clocks } => {
                let (claim, _, says) =
                    harness::claims(self.asked.config).nth(output).copied().unwrap_or(("", "", "a claim"));
                self.netlists.waves("few", netlist)?;
                self.refuted(few, claim, says, clocks, "trace.vcd")?;
                self.stage("counterexample", at, format!("refuted after {clocks} clocks"), seconds);
                Ok(true)
            }
            Found::Nothing(clocks) => {
                self.report.reached = self.report.reached.max(clocks);
                self.stage("counterexample", at, format!("none in the first {clocks} clocks"), seconds);
                Ok(false)
            }
            Found::Proved => Ok(false),
        }
    }

    /// Notes a trace.
    fn refuted(
        &mut self,
        cache: &CacheConfig,
        claim: &str,
        says: &str,
        clocks: u32,
        waves: &str,
    ) -> Result<(), Error> {
        let vcd = self.netlists.read(waves)?;
        let wires = match claim {
            "hit" => ["raw_hit", "dut_hit", "want_hit"],
            "way" => ["raw_way", "dut_way", "want_way"],
            "card" => ["raw_card", "dut_card", "want_card"],
            "evicts" => ["raw_evicts", "dut_evicts", "want_evicts"],
            "evicted" => ["dut_evicted", "dut_evicted", "want_evicted"],
            _ => ["answer_valid"; 3],
        };
        let [shown, got, wanted] = trace::values(&vcd, clocks, &wires);
        if shown.is_some_and(|bits| bits.contains('x')) {
            let port = self.asked.config.port_of(cache, wires[0]);
            return Err(format!("port '{port}' has a value x after {clocks} clocks: give it a value").into());
        }
        let hex = |bits: Option<String>| bits.and_then(|bits| u64::from_str_radix(&bits, 2).ok());
        let says = match (hex(got), hex(wanted)) {
            (Some(got), Some(wanted)) if got != wanted => format!("{says}: {got:x}; {wanted:x} is right"),
            _ => says.to_owned(),
        };
        // The request of the last clock is judged where it is answered in its clock.
        let judged = if self.asked.config.latency == 0 { clocks } else { clocks - 1 };
        let requests = trace::requests(&vcd, judged);
        let session = self.session(cache, &requests)?;
        self.report.verdict = ProofVerdict::Refuted;
        self.report.reason.clear();
        self.report.trace = Some(Trace {
            claim: claim.to_owned(),
            says,
            config: config::text(cache),
            clocks,
            requests: requests.iter().map(Request::text).collect(),
            suite: session.to_suite(),
            vcd: vcd.into_bytes(),
            waves: None,
            replay: None,
        });
        Ok(())
    }

    /// The session of these requests.
    fn session(&self, cache: &CacheConfig, requests: &[Request]) -> Result<Session, Error> {
        let is_meta = self.asked.kind == Meta.name();
        let lines: String = requests
            .iter()
            .map(|request| match request {
                Request::Reset => "flush\n".to_owned(),
                Request::Invalidate(address) => format!("i {address:x} 1\n"),
                Request::Read(address) if is_meta => format!("r {address:x}\n"),
                Request::Read(address) => format!("r {address:x} 1\n"),
            })
            .collect();
        let (hello, config) = if is_meta {
            let meta = meta::config::parse(&self.asked.config.config)?;
            (Meta.hello(), meta::config::text(&MetaConfig { cache: *cache, ..meta }))
        } else {
            (Vm.hello(), config::text(cache))
        };
        Ok(Session::new("prove", hello, &config, lines.as_bytes()))
    }

    /// After how many clocks each output of a netlist happens; none where it does not within the time.
    fn happens(&self, netlist: &str, outputs: usize) -> Result<(Vec<Option<u32>>, f64), Error> {
        let limit = self.asked.limit;
        let script = format!(
            "read_aiger {netlist}.aig; strash; bmc3 -a -T {} -F {MOST_CLOCKS}",
            limit.as_secs().max(1)
        );
        let command = format!("{} -c {}", self.tools.abc, shell_word(&script));
        let ran = run(&command, self.asked.work, &format!("{netlist}-abc"), limit + Duration::from_secs(10))?;
        let mut clocks = vec![None; outputs];
        for line in ran.text.lines() {
            let Some((before, after)) = line.split_once("was asserted in frame") else { continue };
            let output = before.rsplit("Output").next().map(numbers).unwrap_or_default();
            let place = output.first().and_then(|&output| clocks.get_mut(output as usize));
            if let (Some(place), Some(frame)) = (place, numbers(after).first()) {
                *place = Some(frame + 1);
            }
        }
        Ok((clocks, ran.seconds))
    }

    /// Each thing that has to happen can.
    fn show_covers(&mut self, few: &CacheConfig) -> Result<(), Error> {
        (self.progress)("ABC reaches what the claims are about");
        let covers = Netlist {
            name: "covers",
            choice: Some("SAARCOR_COVER"),
            used_by: For::Abc { begins_at_zero: true },
        };
        self.netlists.make("few", few, 32, 0, &[covers])?;
        let names = harness::covers(self.asked.config, few.geometry.ways());
        let (clocks, seconds) = self.happens("few-covers", names.len())?;
        let reached = clocks.iter().flatten().count();
        let says = format!("{reached} of {} things reached", names.len());
        self.stage("covers", config::text(few), says, seconds);
        self.report.covers = names.into_iter().map(|(name, _)| name).zip(clocks).collect();
        Ok(())
    }

    /// Looks whether each fault of the run's own is refuted.
    fn plant(&mut self, few: &CacheConfig, claims: &Value) -> Result<(), Error> {
        (self.progress)("ABC refutes faults of the run's own");
        let limited = |plan: &Plan<'_>| Vec::from_iter(plan.parts().into_iter().take(MOST_PARTS));
        let parts = limited(&Plan::new(claims, TOP)).len();
        let planted = Netlist { name: "planted", choice: Some("SAARCOR_PLANTED"), used_by: For::Edit };
        self.netlists.make("few", few, 32, parts, &[planted])?;
        let json = self.netlists.json("few-planted")?;
        let plan = Plan::new(&json, TOP);
        let parts = limited(&plan);
        let mut edited = plan.with_faults(&parts, harness::FIRST_PART);
        settle_writes(&mut edited, TOP);
        self.netlists.map("few-planted", &edited, For::Abc { begins_at_zero: true })?;
        let at_ports = harness::planted(self.asked.config, few).into_iter().map(|(_, says)| says.to_owned());
        let in_state = parts.iter().map(|part| format!("'{}' is never updated", part.name));
        let faults: Vec<_> = at_ports.chain(in_state).collect();
        let (clocks, seconds) = self.happens("few-planted", faults.len())?;
        let refuted = clocks.iter().flatten().count();
        let says = format!("{refuted} of {} refuted", faults.len());
        self.stage("faults of the run's own", config::text(few), says, seconds);
        self.report.planted =
            faults.into_iter().zip(clocks).map(|(says, clocks)| Planted { says, clocks }).collect();
        Ok(())
    }

    /// Tries to prove a size by induction.
    fn induction(&self, size: &Size<'_>) -> Result<Induction, Error> {
        let Size { name, cache, is_cold } = *size;
        (self.progress)(&format!("{}: induction", config::text(cache)));
        let used_by = For::Solver { has_state: true, is_cold };
        self.netlists.make(name, cache, 32, 0, &[Netlist { name: "state", choice: None, used_by }])?;
        let netlist = format!("{name}-state");
        let mut seconds = 0.0;
        let mut is_shown = |name: &str, flags: &str| -> Result<Option<&'static str>, Error> {
            let ran = self.smtbmc(&netlist, name, flags, self.asked.limit)?;
            seconds += ran.seconds;
            Ok(match (ran.text.contains("Status: PASSED"), ran.timed_out) {
                (true, _) => None,
                (false, true) => Some("not done in time"),
                (false, false) => Some("not proved"),
            })
        };
        // One clock is enough where the state that is shown is all; more are needed where an answer takes more.
        let latency = self.asked.config.latency + 1;
        let mut is_proved = false;
        let mut says = String::new();
        for clocks in [1, latency] {
            let base = is_shown("base", &format!("--presat -t {clocks}"))?;
            let step = if base.is_none() { is_shown("step", &format!("-i -t {clocks}"))? } else { None };
            (is_proved, says) = match (base, step) {
                (None, None) => (true, "proved by induction".to_owned()),
                (Some(end), _) => (false, format!("the first clocks of the induction: {end}")),
                (None, Some(end)) => (false, format!("the step of the induction: {end}")),
            };
            if is_proved || base.is_some() || clocks == latency {
                break;
            }
        }
        Ok(Induction { is_proved, says, seconds })
    }

    fn smtbmc(&self, netlist: &str, step: &str, flags: &str, limit: Duration) -> Result<Ran, Error> {
        let command = format!("yosys-smtbmc --noprogress -s {} {flags} {netlist}.smt2", self.tools.solver);
        run(&command, self.asked.work, &format!("{netlist}-{step}"), limit)
    }

    fn is_refuted_at_size(&mut self, size: &Size<'_>, limit: Duration) -> Result<bool, Error> {
        let Size { name, cache, is_cold } = *size;
        let at = config::text(cache);
        if self.report.stages.iter().any(|stage| stage.config == at && stage.says.starts_with("proved")) {
            return Ok(false);
        }
        (self.progress)(&format!("{at}: a counterexample is looked for"));
        let used_by = For::Solver { has_state: false, is_cold };
        self.netlists.make(name, cache, 32, 0, &[Netlist { name: "claims", choice: None, used_by }])?;
        let search = format!("-t {MOST_CLOCKS} --dump-vcd {name}.vcd");
        let ran = self.smtbmc(&format!("{name}-claims"), "search", &search, limit)?;
        let step = ran.text.lines().filter_map(|line| line.split_once("in step ")).next_back();
        let clocks = step.map_or(0, |(_, rest)| numbers(rest).first().copied().unwrap_or_default()) + 1;
        let failed = ran.text.lines().find_map(|line| line.split_once("Assert failed in"));
        if let Some((_, place)) = failed {
            let is_named =
                |claim: &str| place.split_whitespace().any(|word| word == format!("claim_{claim}"));
            let mut all = harness::claims(self.asked.config);
            let (claim, _, says) =
                all.find(|(claim, ..)| is_named(claim)).copied().unwrap_or(("", "", "a claim"));
            self.refuted(cache, claim, says, clocks, &format!("{name}.vcd"))?;
            self.stage("counterexample", at, format!("refuted after {clocks} clocks"), ran.seconds);
            return Ok(true);
        }
        self.stage("counterexample", at, format!("none in the first {} clocks", clocks - 1), ran.seconds);
        Ok(false)
    }

    /// Whether it is proved from its ports alone, by PDR.
    fn prove_from_ports(&mut self, few: &CacheConfig) -> Result<bool, Error> {
        (self.progress)("ABC proves it from its ports");
        let limit = self.asked.limit;
        let (found, seconds) =
            self.abc("few-any", &format!("orpos; pdr -T {}", limit.as_secs().max(1)), limit)?;
        let (is_proved, says) = match found {
            Found::Proved => (true, "proved by PDR".to_owned()),
            Found::Failure { .. } => (false, "not proved".to_owned()),
            Found::Nothing(_) => (false, "not done in time".to_owned()),
        };
        let at = config::text(few);
        if !is_proved {
            self.report.reason = format!("from the ports alone, {at}: {says}");
        }
        self.report.assumed.push(format!("what is proved is {at}, and no other size"));
        self.stage("from the ports alone", at, says, seconds);
        Ok(is_proved)
    }
}

/// The sizes that are proved by induction, the quickest first.
fn sizes<'a>(cache: &'a CacheConfig, reduced: &'a CacheConfig) -> Vec<Size<'a>> {
    let reset = Size { name: "reset", cache: reduced, is_cold: false };
    let cold = Size { name: "cold", cache, is_cold: true };
    if reduced == cache { vec![reset] } else { vec![cold, reset] }
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<u32> {
    text.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect()
}
