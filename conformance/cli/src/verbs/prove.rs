//! `saarcor prove`.

use crate::kani::{self, Limits};
use crate::output::{Stdout, json_line};
use crate::progress::Progress;
use crate::prove::{Engine, EngineVerdict, Judged, Listed, ListedWithEvidence};
use crate::status::Status;
use anyhow::{Context as _, Result, bail};
use clap::ValueEnum as _;
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;
use rayon::prelude::*;
use saarcor_proofs::certificates::{Certificate, certificates};
use saarcor_proofs::evidence::{Evidence, Shown, State};
use saarcor_proofs::theorem::Theorem;
use saarcor_studies::names::nearest;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The theorems of the model, and what each engine shows of them
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A theorem, or a unit of the model [default: all]
    name: Option<String>,
    /// What judges: the engines without need of Kani by default. Gappa judges the certificates of rounding errors alone
    #[arg(long, value_parser = PossibleValuesParser::new(["kani", "exhaustive", "random", "gappa", "all"]).map(engines))]
    engine: Option<Engines>,
    /// Cases a theorem for the random engine
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,
    /// Lists the theorems, with what was shown of them before, and judges none
    #[arg(long, conflicts_with = "engine")]
    list: bool,
    /// Judges only theorems that the engine has not shown to hold, or not for the code as it is
    #[arg(long, conflicts_with = "list")]
    stale: bool,
    /// Writes what is shown into proofs/verdicts.toml: Kani's after each theorem
    #[arg(long, conflicts_with = "list")]
    record: bool,
    /// Seconds of CPU a theorem, for Kani
    #[arg(long, value_name = "SECONDS", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..))]
    timeout: u64,
    /// Seconds for all theorems together, for Kani; those that are left then are not run
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..))]
    limit_seconds: Option<u64>,
    /// Prints JSON lines: an object a theorem, or a theorem and engine
    #[arg(long)]
    json: bool,
}

/// The engines asked for by one name.
#[derive(Clone, Debug)]
struct Engines {
    /// Of theorems.
    of_theorems: Vec<Engine>,
    /// Whether certificates are judged, too.
    gappa: bool,
}

fn engines(name: String) -> Engines {
    match (&*name, Engine::from_str(&name, false)) {
        ("gappa", _) => Engines { of_theorems: Vec::new(), gappa: true },
        (_, Ok(engine)) => Engines { of_theorems: vec![engine], gappa: false },
        _ => Engines { of_theorems: Engine::value_variants().to_vec(), gappa: true },
    }
}

impl Args {
    /// Judges, and prints what was shown.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        let theorems = self.theorems()?;
        let mut out = Stdout::new();
        let mut evidence = match Evidence::read(&Evidence::workspace()) {
            Ok(evidence) => evidence,
            Err(error) if self.record || self.stale => {
                return Err(error).context("the evidence of the theorems");
            }
            Err(error) => {
                progress.say(format_args!("the evidence of the theorems cannot be read: {error}"));
                Evidence::none()
            }
        };
        if self.list {
            for theorem in &theorems {
                let listed = ListedWithEvidence::new(theorem, &evidence);
                if self.json {
                    json_line(&mut out, &listed)?;
                } else {
                    out.line(format_args!("{}", listed.text()))?;
                }
            }
            for certificate in self.certificates() {
                certify(certificate, self.json, &mut out)?;
            }
            return out.finish().map(|()| Status::Holds);
        }

        let without_kani = || Engines { of_theorems: vec![Engine::Exhaustive, Engine::Random], gappa: false };
        let Engines { of_theorems: engines, gappa } = self.engine.clone().unwrap_or_else(without_kani);
        if self.record && !cfg!(debug_assertions) && engines.iter().any(|engine| *engine != Engine::Kani) {
            bail!(
                "this build does not check for overflow, so what the engines exhaustive and random show by it is less than \
                 the tests show: record with 'cargo run -- prove', without --release (or Kani's alone: --engine kani)"
            );
        }
        let mut all = Vec::new();
        for &engine in &engines {
            let mut asked = theorems.clone();
            if self.stale {
                asked.retain(|theorem| match evidence.state(theorem, engine.name()) {
                    State::Stale | State::Missing => true,
                    // An answer that is wanting is asked for again.
                    State::Current => !evidence.of(theorem, engine.name()).is_some_and(Shown::holds),
                    State::NotForKani => false,
                });
                progress.say(format_args!(
                    "{engine}: the evidence of {} of {} theorems is stale or missing, or does not show that they hold",
                    asked.len(),
                    theorems.len()
                ));
            }
            let results = self.judge(engine, &asked, &mut evidence, progress)?;
            for judged in &results {
                if self.json {
                    json_line(&mut out, judged)?;
                } else {
                    let Listed { requirement, says, name, .. } = judged.theorem;
                    out.line(format_args!("{requirement:<5} {says} [{name}]\n{}", judged.text()))?;
                }
            }
            out.flush()?;
            all.extend(results);
        }
        // Where a certificate alone is named, Gappa is what can judge it.
        let gappa = gappa || theorems.is_empty();
        let mut certified = [0; 3];
        for certificate in self.certificates().filter(|_| gappa) {
            let verdict = certify(certificate, self.json, &mut out)?;
            certified[verdict as usize] += 1;
        }
        out.finish()?;

        let count = |verdict| all.iter().filter(|judged| judged.verdict == verdict).count();
        let (disproved, absent) =
            (count(EngineVerdict::Disproved), count(EngineVerdict::NotRun) + count(EngineVerdict::NoAnswer));
        progress.say(format_args!(
            "{} theorems: {} proved, {} held, {disproved} disproved, {absent} not run or without an answer{}",
            theorems.len(),
            count(EngineVerdict::Proved),
            count(EngineVerdict::Held),
            if engines.contains(&Engine::Kani) { "" } else { "; Kani not asked for (--engine kani)" },
        ));
        let [certified, refuted, not_run] = certified;
        if gappa {
            progress.say(format_args!(
                "{} certificates: {certified} proved, {refuted} disproved, {not_run} not run",
                certified + refuted + not_run
            ));
        }
        Ok(match (disproved + refuted, absent + not_run) {
            (0, 0) => Status::Holds,
            (0, _) => Status::Incomplete,
            _ => Status::Disproved,
        })
    }

    fn judge(
        &self,
        engine: Engine,
        theorems: &[&Theorem],
        evidence: &mut Evidence,
        progress: &Progress,
    ) -> Result<Vec<Judged>> {
        let done = AtomicUsize::new(0);
        let mut recorded = Ok(());
        let results = progress.during(&format!("by the engine {engine}"), |report| {
            let one_done = || {
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                report(done as f64 / theorems.len() as f64);
            };
            let each = |judge: &(dyn Fn(&Theorem) -> Judged + Sync)| {
                let judged = theorems.par_iter().map(|theorem| judge(theorem)).inspect(|_| one_done());
                judged.collect()
            };
            match engine {
                Engine::Exhaustive => each(&Judged::exhaustive),
                Engine::Random => each(&|theorem| Judged::random(theorem, self.cases)),
                Engine::Kani => {
                    let limits = Limits { cpu_seconds: self.timeout, seconds: self.limit_seconds };
                    let version = kani::version().unwrap_or_default();
                    kani::judge(theorems, evidence, limits, |evidence, theorem, judged| {
                        if self.record && recorded.is_ok() {
                            recorded = record(evidence, theorem, judged, &version);
                        }
                        one_done();
                    })
                }
            }
        });
        if self.record && engine != Engine::Kani {
            let version = concat!("saarcor ", env!("CARGO_PKG_VERSION"));
            for (theorem, judged) in theorems.iter().zip(&results) {
                keep(evidence, theorem, judged, version);
            }
            recorded = evidence.write();
        }
        recorded.context("proofs/verdicts.toml cannot be written")?;
        Ok(results)
    }

    /// The certificates asked for by their names or their requirements: all, without a name.
    fn certificates(&self) -> impl Iterator<Item = &'static Certificate> {
        let name = self.name.as_deref();
        let asked =
            move |it: &&Certificate| name.is_none_or(|name| it.name == name || it.requirement == name);
        certificates().iter().filter(asked)
    }

    fn theorems(&self) -> Result<Vec<&'static Theorem>> {
        let all: Vec<_> = saarcor_proofs::theorems().collect();
        let Some(name) = &self.name else { return Ok(all) };
        let chosen: Vec<_> = all.iter().copied().filter(|theorem| is_named(theorem, name)).collect();
        if chosen.is_empty() && self.certificates().next().is_none() {
            let names = all.iter().flat_map(|theorem| [theorem.name, theorem.unit()]);
            let hint =
                nearest(name, names).map_or_else(String::new, |known| format!(": did you mean '{known}'?"));
            bail!("no theorem and no unit '{name}'{hint} ('saarcor prove --list' lists all)");
        }
        Ok(chosen)
    }
}

/// What Gappa shows of a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
enum Certified {
    #[serde(rename = "proved")]
    Proved,
    #[serde(rename = "disproved")]
    Disproved,
    #[serde(rename = "not run")]
    NotRun,
}

/// Has Gappa judge a certificate, and prints it.
fn certify(certificate: &Certificate, json: bool, out: &mut Stdout) -> Result<Certified> {
    let verdict = match certificate.judge() {
        Some(true) => Certified::Proved,
        Some(false) => Certified::Disproved,
        None => Certified::NotRun,
    };
    let Certificate { name, requirement, says, file, step, least, slack, .. } = *certificate;
    let constant = (certificate.constant)();
    if json {
        let line = serde_json::json!({
            "engine": "gappa", "name": name, "requirement": requirement, "says": says, "file": file, "verdict": verdict,
            "constant": constant, "least": least, "step": step, "slack": slack,
        });
        json_line(out, &line)?;
    } else {
        let verdict = match verdict {
            Certified::Proved => "proved",
            Certified::Disproved => "DISPROVED",
            Certified::NotRun => "not run: there is no gappa",
        };
        out.line(format_args!(
            "{requirement:<5} {says} [{name}]\n  gappa       {verdict}, with {least} steps of {step}; {file} has {constant}"
        ))?;
    }
    Ok(verdict)
}

/// Whether `name` is the theorem's own, its unit's (`vm::set`, or `set` alone), or its group's
/// (`vm`).
fn is_named(theorem: &Theorem, name: &str) -> bool {
    let unit = theorem.unit();
    theorem.name == name || unit == name || unit.split("::").any(|part| part == name)
}

/// Keeps what was shown of a theorem for what it rests on.
fn keep(evidence: &mut Evidence, theorem: &Theorem, judged: &Judged, version: &str) {
    if let Some(shown) = judged.shown(version, evidence.rests_on(theorem, judged.engine.name())) {
        evidence.keep(theorem, judged.engine.name(), shown);
    }
}

/// The same, and writes all evidence: a run that is cut off has what it has.
fn record(evidence: &mut Evidence, theorem: &Theorem, judged: &Judged, version: &str) -> std::io::Result<()> {
    keep(evidence, theorem, judged, version);
    evidence.write()
}
