//! Theorems, the engines that judge them, and what each showed.

use saarcor_proofs::engines::Judgement;
use saarcor_proofs::theorem::Theorem;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::{self, Write as _};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Instant;

/// What judges theorems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// All values, by the model checker Kani; needs `cargo kani`.
    Kani,
    /// Every value of a small scope.
    Exhaustive,
    /// Values at random, the same in every run.
    Random,
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Kani => "kani",
            Self::Exhaustive => "exhaustive",
            Self::Random => "random",
        })
    }
}

/// What an engine showed of a theorem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum EngineVerdict {
    /// It holds for all values.
    #[serde(rename = "proved")]
    Proved,
    /// It holds for the values that were tried.
    #[serde(rename = "held")]
    Held,
    /// It does not hold, or a case that it is about was never reached.
    #[serde(rename = "disproved")]
    Disproved,
    /// The engine is absent, or gave no answer.
    #[serde(rename = "not run")]
    NotRun,
    /// Kani cannot judge it; the theorem says why.
    #[serde(rename = "not for kani")]
    NotForKani,
}

impl fmt::Display for EngineVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Proved => "proved",
            Self::Held => "held",
            Self::Disproved => "DISPROVED",
            Self::NotRun => "not run",
            Self::NotForKani => "not for Kani",
        })
    }
}

/// A theorem as it is listed.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Listed {
    /// Its name.
    pub name: &'static str,
    /// The requirement of SPEC.md.
    pub requirement: &'static str,
    /// What holds, in English.
    pub says: &'static str,
    /// The unit of the model.
    pub unit: &'static str,
    /// The cases that have to be reached.
    pub covers: &'static [&'static str],
    /// The engines that can judge it.
    pub engines: &'static [Engine],
    /// Why Kani cannot, where it cannot.
    pub not_for_kani: Option<&'static str>,
}

impl From<&Theorem> for Listed {
    fn from(theorem: &Theorem) -> Self {
        const ALL: [Engine; 3] = [Engine::Exhaustive, Engine::Random, Engine::Kani];
        let Theorem { name, requirement, says, covers, not_for_kani, .. } = *theorem;
        let engines = if not_for_kani.is_none() { &ALL[..] } else { &ALL[..2] };
        Self { name, requirement, says, unit: theorem.unit(), covers, engines, not_for_kani }
    }
}

impl Listed {
    /// The line that shows it to a person.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { name, requirement, says, unit, not_for_kani, .. } = self;
        let why = not_for_kani.map_or_else(String::new, |why| format!(" (not for Kani: {why})"));
        format!("{requirement:<5} {says} [{unit}::{name}]{why}")
    }
}

/// A theorem and what an engine showed of it.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// The theorem.
    #[serde(flatten)]
    pub theorem: Listed,
    /// The engine.
    pub engine: Engine,
    /// What it showed.
    pub verdict: EngineVerdict,
    /// The values that it spoke of, or why it did not run.
    pub scope: String,
    /// Cases tried, vacuous ones included; none where values are symbols.
    pub cases: Option<u64>,
    /// Cases that the theorem does not speak of.
    pub vacuous: Option<u64>,
    /// How many of the covers were reached.
    pub covers_reached: usize,
    /// Time taken.
    pub seconds: f64,
    /// The case for which it does not hold.
    pub counterexample: Option<String>,
}

impl Judged {
    /// What the theorem says, and below it what the engine showed, for a person.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { engine, verdict, scope, seconds, .. } = self;
        let mut text = format!("  {engine:<10} {verdict:<9}");
        if let (Some(cases), Some(vacuous)) = (self.cases, self.vacuous) {
            let _ = write!(text, " {cases} cases, {vacuous} vacuous;");
        }
        if !matches!(verdict, EngineVerdict::NotRun | EngineVerdict::NotForKani) {
            let covers = self.theorem.covers.len();
            let _ = write!(text, " {} of {covers} covers; {seconds:.2} s;", self.covers_reached);
        }
        let _ = write!(text, " {scope}");
        if let Some(case) = &self.counterexample {
            let _ = write!(text, "\n    {case}");
        }
        text
    }

    fn of(theorem: &Theorem, engine: Engine, judge: impl FnOnce() -> Judgement) -> Self {
        let start = Instant::now();
        let judgement = judge();
        Self {
            theorem: theorem.into(),
            engine,
            verdict: if judgement.holds { EngineVerdict::Held } else { EngineVerdict::Disproved },
            scope: judgement.scope,
            cases: Some(judgement.cases),
            vacuous: Some(judgement.vacuous),
            covers_reached: judgement.covers.iter().filter(|&&count| count > 0).count(),
            seconds: start.elapsed().as_secs_f64(),
            counterexample: judgement.counterexample,
        }
    }

    /// By every value of the theorem's small scope.
    #[must_use]
    pub fn exhaustive(theorem: &Theorem) -> Self {
        Self::of(theorem, Engine::Exhaustive, || theorem.judge_exhaustively())
    }

    /// By that many cases at random.
    #[must_use]
    pub fn random(theorem: &Theorem, cases: u32) -> Self {
        Self::of(theorem, Engine::Random, || theorem.judge_at_random(cases))
    }

    fn by_kani(theorem: &Theorem, verdict: EngineVerdict, scope: &str) -> Self {
        Self {
            theorem: theorem.into(),
            engine: Engine::Kani,
            verdict,
            scope: scope.to_owned(),
            cases: None,
            vacuous: None,
            covers_reached: 0,
            seconds: 0.0,
            counterexample: None,
        }
    }
}

/// By Kani: all of the theorems, one after another; calls `done` with each.
///
/// The proofs are those of the workspace that the command is started in.
pub fn by_kani(theorems: &[&Theorem], mut done: impl FnMut(&Judged)) -> Vec<Judged> {
    let mut left: Vec<&Theorem> = theorems.to_vec();
    let mut judged = Vec::new();
    let mut keep = |result: Judged| {
        done(&result);
        judged.push(result);
    };
    let why = run_kani(theorems, |name, result| {
        if let Some(at) = left.iter().position(|theorem| theorem.harness() == name) {
            keep(result(left.remove(at)));
        }
    });
    for theorem in left {
        keep(match theorem.not_for_kani {
            Some(why) => Judged::by_kani(theorem, EngineVerdict::NotForKani, why),
            None => Judged::by_kani(theorem, EngineVerdict::NotRun, &why),
        });
    }
    judged
}

/// Starts `cargo kani` and hands on what it says of each harness; returns why it said nothing of
/// those that are left.
fn run_kani(theorems: &[&Theorem], mut each: impl FnMut(&str, &dyn Fn(&Theorem) -> Judged)) -> String {
    if theorems.iter().all(|theorem| theorem.not_for_kani.is_some()) {
        return String::new();
    }
    let version = Command::new("cargo").args(["kani", "--version"]).stderr(Stdio::null()).output();
    if !version.is_ok_and(|version| version.status.success()) {
        return "Kani is absent: 'cargo kani --version' fails".to_owned();
    }
    let mut command = Command::new("cargo");
    command.args(["kani", "-p", "saarcor-proofs", "--exact"]);
    for theorem in theorems.iter().filter(|theorem| theorem.not_for_kani.is_none()) {
        command.args(["--harness", &theorem.harness()]);
    }
    let child = command.stdout(Stdio::piped()).stderr(Stdio::null()).stdin(Stdio::null()).spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(error) => return format!("'cargo kani' cannot be started: {error}"),
    };
    let mut answer = KaniAnswer::default();
    if let Some(stdout) = child.stdout.take() {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            if let Some((name, said)) = answer.read(&line) {
                each(&name, &|theorem| said.judged(theorem));
            }
        }
    }
    match child.wait() {
        Ok(status) => format!("Kani gave no answer ({status}); 'cargo kani -p saarcor-proofs' says why"),
        Err(error) => format!("Kani was lost: {error}"),
    }
}

/// What Kani has said of the harness that it works on.
#[derive(Clone, Debug, Default, PartialEq)]
struct KaniAnswer {
    harness: String,
    /// Status of the check that is described next.
    status: String,
    /// Labels of the covers that were reached. Kani may judge one cover at several places.
    covers: BTreeSet<String>,
    failed: Vec<String>,
    succeeded: Option<bool>,
}

impl KaniAnswer {
    /// Reads a line; the last of a harness gives its name and all that was said of it.
    fn read(&mut self, line: &str) -> Option<(String, KaniResult)> {
        let line = line.trim();
        if let Some(name) = line.strip_prefix("Checking harness ") {
            *self = Self { harness: name.trim_end_matches("...").to_owned(), ..Self::default() };
        } else if let Some(status) = line.strip_prefix("- Status: ") {
            status.clone_into(&mut self.status);
        } else if let Some(label) = line.strip_prefix("- Description: ") {
            if self.status == "SATISFIED" {
                self.covers.insert(label.trim_matches('"').to_owned());
            }
        } else if let Some(check) = line.strip_prefix("Failed Checks: ") {
            self.failed.push(check.to_owned());
        } else if let Some(result) = line.strip_prefix("VERIFICATION:- ") {
            self.succeeded = Some(result.starts_with("SUCCESSFUL"));
        } else if let Some(time) = line.strip_prefix("Verification Time: ") {
            let seconds = time.trim_end_matches('s').parse().unwrap_or(0.0);
            let Self { harness, covers, failed, succeeded, .. } = std::mem::take(self);
            return Some((harness, KaniResult { covers, failed, succeeded: succeeded?, seconds }));
        }
        None
    }
}

/// What Kani said of a harness.
#[derive(Clone, Debug, PartialEq)]
struct KaniResult {
    covers: BTreeSet<String>,
    failed: Vec<String>,
    succeeded: bool,
    seconds: f64,
}

impl KaniResult {
    fn judged(&self, theorem: &Theorem) -> Judged {
        let reached = theorem.covers.iter().filter(|&&label| self.covers.contains(label)).count();
        let all_reached = reached == theorem.covers.len();
        let holds = self.succeeded && all_reached;
        let verdict = if holds { EngineVerdict::Proved } else { EngineVerdict::Disproved };
        let why = match (self.failed.is_empty(), all_reached) {
            (false, _) => self.failed.join("; "),
            (true, false) => format!("{reached} of {} covers were reached", theorem.covers.len()),
            (true, true) => "Kani did not finish".to_owned(),
        };
        Judged {
            covers_reached: reached,
            seconds: self.seconds,
            counterexample: (!holds).then_some(why),
            ..Judged::by_kani(theorem, verdict, "all values")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What Kani 0.67 prints of a harness of two covers, of which it judges the first twice.
    fn judged(second_cover: &str, failed: &str, result: &str) -> Judged {
        let text = format!(
            "Checking harness hash::kani_proofs::hash_names_a_set...\n\nRESULTS:\n\
             Check 1: hash.assertion.1\n\t - Status: SUCCESS\n\t - Description: \"claim\"\n\
             Check 2: hash.cover.1\n\t - Status: UNREACHABLE\n\t - Description: \"COVER\"\n\
             Check 3: hash.cover.2\n\t - Status: SATISFIED\n\t - Description: \"COVER\"\n\
             Check 4: hash.cover.3\n\t - Status: {second_cover}\n\t - Description: \"OTHER\"\n\n\
             SUMMARY:\n ** 0 of 136 failed\n\n ** 2 of 3 cover properties satisfied\n\n{failed}\n\
             VERIFICATION:- {result}\nVerification Time: 3.3358977s\n"
        );
        let theorem =
            saarcor_proofs::theorems().find(|theorem| theorem.covers.len() == 2).expect("one of two");
        let text = text.replace("hash::kani_proofs::hash_names_a_set", &theorem.harness());
        let text = text.replace("COVER", theorem.covers[0]).replace("OTHER", theorem.covers[1]);
        let mut answer = KaniAnswer::default();
        let (name, said) = text.lines().find_map(|line| answer.read(line)).expect("a whole answer");
        assert_eq!(name, theorem.harness());
        said.judged(theorem)
    }

    #[test]
    fn kani_proves_with_all_covers_alone() {
        let proved = judged("SATISFIED", "", "SUCCESSFUL");
        assert_eq!((proved.verdict, proved.covers_reached), (EngineVerdict::Proved, 2));
        assert!((proved.seconds - 3.3).abs() < 0.1);
        assert_eq!(judged("UNSATISFIABLE", "", "SUCCESSFUL").verdict, EngineVerdict::Disproved);
        let failed = judged("SATISFIED", "Failed Checks: the theorem's claim", "FAILED");
        assert_eq!(failed.verdict, EngineVerdict::Disproved);
        assert_eq!(failed.counterexample.as_deref(), Some("the theorem's claim"));
    }
}
