//! A proof from beginning to end: induction or PDR; else counterexamples; and what shows that a proof is not empty.

use super::config::{ProveConfig, with_sets};
use super::found::{self, Commit, Found, Samples};
use super::harness;
use super::netlists::{Assertions, Form, Netlists, Reader, TOP};
use super::plant::Plan;
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
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// Sets of the memory in which counterexamples are looked for, and of that which is proved with its reset.
const FEW_SETS: u64 = 2;
const RESET_SETS: u64 = 32;
/// Sets of a memory in which faults of larger ones are looked for before the stated size.
const FEWER_SETS: u64 = 8;
const BETWEEN_SETS: u64 = 1024;
/// Clocks that a search for counterexamples may reach.
const MOST_CLOCKS: u32 = 60;
/// Places at which the requests of a trace with stalls are made again.
const STALL_PLACES: usize = 12;
/// Parts of the state whose updates are dropped.
const MOST_PARTS: usize = 4;
/// Wires that are tried as what says when a request changes the state.
const MOST_COMMITS: usize = 4;
/// Faults of the run's own that have to be refuted at least.
const LEAST_PLANTED: usize = 3;
/// ABC searches from zeros: what it finds can be replayed.
const FROM_ZEROS: Reader = Reader::Abc { begins_at_zero: true };
/// What is proved, and what is searched for last, holds whatever is there at power-up.
const FROM_ANYTHING: Reader = Reader::Abc { begins_at_zero: false };

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

/// The name of the size that is proved with its reset.
const RESET: &str = "reset";

/// A size that is proved by induction.
#[derive(Clone, Copy)]
struct Size<'a> {
    /// The name of its netlists.
    name: &'static str,
    cache: &'a CacheConfig,
    /// Whether the set is assumed to be cold, in the place of the reset.
    is_cold: bool,
}

/// How an induction ends.
struct Induction {
    is_proved: bool,
    says: String,
    seconds: f64,
    /// The relations that were found and do not hold.
    failed: BTreeSet<usize>,
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
    // What is not used is not there.
    let config = ProveConfig {
        state: asked.config.state.clone().filter(|_| !asked.from_ports),
        ..asked.config.clone()
    };
    let asked = &Asked { config: &config, ..asked.clone() };
    let reduced = resized(asked.config, &cache, RESET_SETS);
    let few = resized(asked.config, &cache, FEW_SETS);
    let few = with_sets(&few, few.geometry.sets(), asked.config.short_line(&few));
    progress("Yosys reads the sources");
    let netlists = Netlists::open(asked, &few)?;
    let mut report = ProofReport::new(asked, &config::text(&cache), &tools);
    let free =
        netlists.free.iter().map(|(name, _)| format!("the input '{name}' has any value at each clock"));
    report.assumed.extend(free);
    let mut proof = Proof { asked, tools, netlists, report, progress };
    proof.run(&cache, &reduced, &few)?;
    Ok(proof.report)
}

impl Proof<'_> {
    fn run(&mut self, cache: &CacheConfig, reduced: &CacheConfig, few: &CacheConfig) -> Result<(), Error> {
        let by_induction = self.asked.config.state.is_some();
        let sizes = if by_induction { sizes(cache, reduced) } else { Vec::new() };
        let (claims, inductions) = std::thread::scope(|scope| {
            let few = scope.spawn(|| self.few(few));
            let mut inductions = Vec::new();
            for size in &sizes {
                let done = self.induction(size, Assertions::State, &mut Found::default());
                let goes_on = done.as_ref().is_ok_and(|done| done.is_proved);
                inductions.push(done);
                if !goes_on {
                    break;
                }
            }
            (few.join(), inductions)
        });
        let claims = claims.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        let mut proved = Vec::new();
        for (size, done) in sizes.iter().zip(inductions) {
            self.note(size, done?, &mut proved);
        }
        let mut is_proved = by_induction && proved.len() == sizes.len();
        if !is_proved {
            // Most faults show at once.
            if self.is_refuted_among_few(few, "few-claims", self.asked.limit / 40)? {
                return Ok(());
            }
            is_proved = self.prove_with_relations(cache, reduced, &mut proved)?;
        }
        if !is_proved {
            // A set can be cold where it is shown. A size between the others is one that test benches have.
            let between = resized(self.asked.config, cache, BETWEEN_SETS);
            let mut open = self::sizes(cache, reduced);
            open.push(Size { name: "between", cache: &between, is_cold: true });
            open.retain(|size| !proved.contains(&size.name) && (!size.is_cold || by_induction));
            open.sort_by_key(|size| size.cache.geometry.sets());
            open.dedup_by_key(|size| size.cache.geometry.sets());
            if self.is_refuted(few, &open)? {
                return Ok(());
            }
            self.netlists.map("few-any", &claims, FROM_ANYTHING)?;
            if by_induction || !self.prove_from_ports(few)? {
                // A trace that begins with zeros can be replayed; what only shows with other values comes last.
                self.is_refuted_among_few(few, "few-any", self.asked.limit / 4)?;
                return Ok(());
            }
        }
        self.show_covers(few)?;
        self.plant(few, &claims)?;
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

    /// Notes how an induction ended.
    fn note(&mut self, size: &Size<'_>, done: Induction, proved: &mut Vec<&'static str>) {
        let says = if size.is_cold { "with a cold set" } else { "with the reset" };
        let at = config::text(size.cache);
        if done.is_proved {
            proved.push(size.name);
        } else {
            self.report.reason = format!("{says}, {at}: {}", done.says);
        }
        if size.is_cold {
            let says = format!(
                "at {at}: the set is cold in the first clock, nothing is answered then, and there is no reset"
            );
            if !self.report.assumed.contains(&says) {
                self.report.assumed.push(says);
            }
        }
        self.stage(says, at, done.says, done.seconds);
    }

    /// Tries an induction with relations that the run finds itself, where what is shown is not enough: for all that is not
    /// `proved`, or, from the ports alone, for the reduced size.
    fn prove_with_relations(
        &mut self,
        cache: &CacheConfig,
        reduced: &CacheConfig,
        proved: &mut Vec<&'static str>,
    ) -> Result<bool, Error> {
        (self.progress)("A simulation shows how the state stands to the specification's");
        let fewer = resized(self.asked.config, cache, FEWER_SETS);
        let mut found = None;
        for size in [reduced, &fewer] {
            let begin = Instant::now();
            match self.find(size) {
                Ok(is_found) => found = is_found.map(|found| (found, size)),
                // A netlist that Yosys cannot make of that size in time says nothing against the implementation.
                Err(error) => {
                    let seconds = begin.elapsed().as_secs_f64();
                    self.stage("a simulation", config::text(size), error.to_string(), seconds);
                }
            }
            if found.is_some() {
                break;
            }
        }
        let Some((mut found, reduced)) = found else { return Ok(false) };
        let is_shown = self.asked.config.state.is_some();
        let of = if is_shown { Assertions::State } else { Assertions::Found };
        // The reset of a large memory is a write port a word: only sources that can leave it out are read at the stated size.
        let mut left = sizes(cache, reduced);
        left.retain(|size| (!size.is_cold || self.netlists.knows_cold()) && !proved.contains(&size.name));
        // What a reset leaves stands in the relations that hold with it, and is what a cold set is.
        left.reverse();
        for size in &left {
            let done = self.induction(size, of, &mut found)?;
            let is_proved = done.is_proved;
            self.note(size, done, proved);
            if !is_proved {
                break;
            }
        }
        let all = sizes(cache, reduced);
        let is_proved = all.iter().all(|size| proved.contains(&size.name));
        if !is_shown && !is_proved && proved.contains(&RESET) {
            let says = format!("what is proved is {}, and no other size", config::text(reduced));
            self.report.assumed.push(says);
            return Ok(true);
        }
        Ok(is_proved)
    }

    /// What a simulation shows of the state; none of a memory that is too large for one.
    fn find(&self, cache: &CacheConfig) -> Result<Option<Found>, Error> {
        if cache.geometry.sets() > RESET_SETS {
            return Ok(None);
        }
        let json = self.netlists.elaborate("found", cache, Form::Violations, &Found::default())?;
        let candidates = Found::candidates(&json, TOP, cache, self.asked.config.data.is_some());
        let watched = found::watched(self.asked.config, cache);
        let simulated = |json: &Value, wires: &[(String, usize)]| -> Result<Samples, Error> {
            let wires = [&watched[..], wires].concat();
            let mut graph = self.netlists.simulation("found", json, &wires)?;
            Ok(Samples::new(&mut graph, cache, &wires))
        };
        let related = |commit: Option<Commit>| -> Result<(Found, usize), Error> {
            let found = Found { commit, ..candidates.clone() };
            let json = self.netlists.elaborate("found", cache, Form::Violations, &found)?;
            let samples = simulated(&json, &found.inputs(cache))?;
            Ok(found::relations(&samples, &found, cache))
        };
        let mut best = related(None)?;
        let most = found::most_of_set(cache);
        if best.1 < most {
            let wires = found::commit_wires(&json, TOP);
            let samples = simulated(&json, &wires)?;
            let commits = found::commits(&samples, self.asked.config.outstanding, &wires);
            for commit in commits.into_iter().take(MOST_COMMITS) {
                let next = related(Some(commit))?;
                if next.1 > best.1 {
                    best = next;
                }
                if best.1 == most {
                    break;
                }
            }
        }
        Ok(Some(best.0))
    }

    /// The netlist of the claims with few sets.
    fn few(&self, few: &CacheConfig) -> Result<Value, Error> {
        let json = self.netlists.elaborate("few-claims", few, Form::Violations, &Found::default())?;
        let plan = Plan::new(&json, TOP);
        if let Some(says) = plan.unclocked() {
            return Err(says.into());
        }
        if let Some(wire) = plan.unknown() {
            let port = self.asked.config.port_of(few, wire);
            return Err(format!("port '{port}' has the value x: give it a value").into());
        }
        self.netlists.map("few-claims", &json, FROM_ZEROS)?;
        Ok(json)
    }

    fn stage(&mut self, name: &str, config: String, says: String, seconds: f64) {
        self.report.stages.push(Stage { name: name.to_owned(), config, says, seconds });
    }

    /// Runs ABC over a netlist.
    fn abc(&self, netlist: &str, command: &str, limit: Duration) -> Result<Ran, Error> {
        let script = format!("read_aiger {netlist}.aig; strash; {command}");
        let command = format!("{} -c {}", self.tools.abc, shell_word(&script));
        run(&command, self.asked.work, &format!("{netlist}-abc"), limit + Duration::from_secs(10))
    }

    /// Looks for a counterexample: first for a short time among few sets, then for faults of larger memories, which are found by
    /// few requests or not at all, in sizes that are `open`, and then among few sets again.
    fn is_refuted(&mut self, few: &CacheConfig, open: &[Size<'_>]) -> Result<bool, Error> {
        let limit = self.asked.limit;
        if self.is_refuted_among_few(few, "few-claims", limit / 8)? {
            return Ok(true);
        }
        for size in open {
            if self.is_refuted_at_size(size, limit / 4)? {
                return Ok(true);
            }
        }
        self.is_refuted_among_few(few, "few-claims", limit)
    }

    fn is_refuted_among_few(
        &mut self,
        few: &CacheConfig,
        netlist: &str,
        limit: Duration,
    ) -> Result<bool, Error> {
        (self.progress)("ABC looks for a counterexample");
        let search = format!("{}; write_cex -a {netlist}.aiw", bounded("bmc3", limit));
        let ran = self.abc(netlist, &search, limit)?;
        let at = config::text(few);
        if let Some((output, clocks)) = asserted(&ran.text).next() {
            let (claim, _, says) =
                harness::claims(self.asked.config).nth(output).copied().unwrap_or(("", "", "a claim"));
            self.netlists.waves("few-claims", netlist)?;
            self.refuted(few, claim, says, clocks, "trace.vcd")?;
            self.stage("counterexample", at, format!("refuted after {clocks} clocks"), ran.seconds);
            return Ok(true);
        }
        let reached = ran.text.lines().find_map(|line| line.split_once("No output asserted in"));
        let clocks = reached.and_then(|(_, rest)| numbers(rest).first().copied()).unwrap_or_default();
        self.report.reached = self.report.reached.max(clocks);
        self.stage("counterexample", at, format!("none in the first {clocks} clocks"), ran.seconds);
        Ok(false)
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
            "data" => ["raw_data", "dut_byte", "want_byte"],
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
        let stalls = self.asked.config.answer.ready.is_some();
        let again = if stalls { trace::offered(&vcd, clocks) } else { Vec::new() };
        let session = self.session(cache, &requests, &again)?;
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

    /// The session of these requests. A session does not say when answers wait: where they may, what was offered is offered
    /// again and again, after so many other requests that each stands at each place of a test bench that makes every second,
    /// third or fourth answer wait.
    fn session(
        &self,
        cache: &CacheConfig,
        requests: &[Request],
        again: &[Request],
    ) -> Result<Session, Error> {
        let is_meta = self.asked.kind == Meta.name();
        let line = |request: &Request| match request {
            Request::Reset => "flush\n".to_owned(),
            Request::Invalidate(address) => format!("i {address:x} 1\n"),
            Request::Read(address) if is_meta => format!("r {address:x}\n"),
            Request::Read(address) => format!("r {address:x} 1\n"),
        };
        let mut lines: String = requests.iter().map(line).collect();
        if !again.is_empty() {
            let answers = again.iter().filter(|request| **request != Request::Reset).count();
            let others = (STALL_PLACES + 1 - answers % STALL_PLACES) % STALL_PLACES;
            let again: String = again.iter().map(line).collect();
            lines += &(line(&Request::Read(0)).repeat(others) + "flush\n" + &again).repeat(STALL_PLACES);
        }
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
        let ran = self.abc(netlist, &bounded("bmc3 -a", limit), limit)?;
        let mut happens = vec![None; outputs];
        for (output, clocks) in asserted(&ran.text) {
            if let Some(place) = happens.get_mut(output) {
                *place = Some(clocks);
            }
        }
        Ok((happens, ran.seconds))
    }

    /// Each thing that has to happen can.
    fn show_covers(&mut self, few: &CacheConfig) -> Result<(), Error> {
        (self.progress)("ABC reaches what the claims are about");
        let json = self.netlists.elaborate("few-covers", few, Form::Covers, &Found::default())?;
        self.netlists.map("few-covers", &json, FROM_ZEROS)?;
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
        let json = self.netlists.elaborate("few-planted", few, Form::Planted { parts }, &Found::default())?;
        let plan = Plan::new(&json, TOP);
        let parts = limited(&plan);
        self.netlists.map("few-planted", &plan.with_faults(&parts, harness::FIRST_PART), FROM_ZEROS)?;
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

    /// Tries to prove a size by induction. Relations that were found and do not hold are dropped.
    fn induction(&self, size: &Size<'_>, of: Assertions, found: &mut Found) -> Result<Induction, Error> {
        let Size { name, cache, is_cold } = *size;
        (self.progress)(&format!("{}: induction", config::text(cache)));
        let netlist = format!("{name}-state");
        let mut seconds = 0.0;
        loop {
            let json = self.netlists.elaborate(&netlist, cache, Form::Assertions { of, is_cold }, found)?;
            self.netlists.map(&netlist, &json, Reader::Solver)?;
            let mut tried = self.induction_once(&netlist)?;
            seconds += tried.seconds;
            tried.seconds = seconds;
            let is_over = seconds > self.asked.limit.as_secs_f64();
            if tried.is_proved || is_over || !found.drop(&tried.failed) {
                let relations = found.relations.len();
                if tried.is_proved && relations > 0 {
                    let _ = write!(tried.says, ", with {relations} relations that were found");
                }
                return Ok(tried);
            }
        }
    }

    fn induction_once(&self, netlist: &str) -> Result<Induction, Error> {
        let (mut seconds, mut failed) = (0.0, BTreeSet::new());
        let mut is_shown = |name: &str, flags: &str| -> Result<Option<&'static str>, Error> {
            let ran = self.smtbmc(netlist, name, flags, self.asked.limit)?;
            seconds += ran.seconds;
            let places = ran.text.lines().filter_map(|line| line.split_once("Assert failed in"));
            let number = |word: &str| word.strip_prefix(harness::RELATION)?.parse::<usize>().ok();
            failed.extend(places.flat_map(|(_, place)| place.split_whitespace().filter_map(number)));
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
        Ok(Induction { is_proved, says, seconds, failed })
    }

    fn smtbmc(&self, netlist: &str, step: &str, flags: &str, limit: Duration) -> Result<Ran, Error> {
        let command = format!("yosys-smtbmc --noprogress -s {} {flags} {netlist}.smt2", self.tools.solver);
        run(&command, self.asked.work, &format!("{netlist}-{step}"), limit)
    }

    fn is_refuted_at_size(&mut self, size: &Size<'_>, limit: Duration) -> Result<bool, Error> {
        let Size { name, cache, is_cold } = *size;
        let at = config::text(cache);
        (self.progress)(&format!("{at}: a counterexample is looked for"));
        let netlist = format!("{name}-claims");
        let form = Form::Assertions { of: Assertions::Claims, is_cold };
        let json = self.netlists.elaborate(&netlist, cache, form, &Found::default())?;
        self.netlists.map(&netlist, &json, Reader::Solver)?;
        let search = format!("-t {MOST_CLOCKS} --dump-vcd {name}.vcd");
        let ran = self.smtbmc(&netlist, "search", &search, limit)?;
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
        let limit = self.asked.limit / 2;
        let ran = self.abc("few-any", &format!("orpos; pdr -T {}", limit.as_secs().max(1)), limit)?;
        let is_proved = ran.text.lines().any(|line| line.starts_with("Property proved"));
        let says = if is_proved {
            "proved by PDR"
        } else if asserted(&ran.text).next().is_some() {
            "not proved"
        } else {
            "not done in time"
        };
        let at = config::text(few);
        if is_proved {
            self.report.assumed.push(format!("what is proved is {at}, and no other size"));
        } else {
            self.report.reason = format!("from the ports alone, {at}: {says}");
        }
        self.stage("from the ports alone", at, says.to_owned(), ran.seconds);
        Ok(is_proved)
    }
}

/// The cache with at most that many sets, where their number can be chosen.
fn resized(config: &ProveConfig, cache: &CacheConfig, sets: u64) -> CacheConfig {
    let geometry = cache.geometry;
    if config.is_sized() { with_sets(cache, sets.min(geometry.sets()), geometry.line()) } else { *cache }
}

/// The sizes that are proved by induction, the quickest first.
fn sizes<'a>(cache: &'a CacheConfig, reduced: &'a CacheConfig) -> Vec<Size<'a>> {
    let reset = Size { name: RESET, cache: reduced, is_cold: false };
    let cold = Size { name: "cold", cache, is_cold: true };
    if reduced == cache { vec![reset] } else { vec![cold, reset] }
}

/// A search of ABC, within a time and so many clocks.
fn bounded(command: &str, limit: Duration) -> String {
    format!("{command} -T {} -F {MOST_CLOCKS}", limit.as_secs().max(1))
}

/// The outputs that ABC found to happen, each with the clocks after which it does.
fn asserted(text: &str) -> impl Iterator<Item = (usize, u32)> + '_ {
    text.lines().filter_map(|line| {
        let (before, after) = line.split_once("was asserted in frame")?;
        let output = numbers(before.rsplit("Output").next()?);
        Some((*output.first()? as usize, numbers(after).first()? + 1))
    })
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<u32> {
    text.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect()
}
