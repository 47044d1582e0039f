//! Theorems, the engines that judge them, and what each showed.

use saarcor_proofs::engines::Judgement;
use saarcor_proofs::evidence::{ENGINES, Evidence, Shown, State};
use saarcor_proofs::theorem::Theorem;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
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

impl Engine {
    /// Its name, in arguments and in evidence.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kani => "kani",
            Self::Exhaustive => "exhaustive",
            Self::Random => "random",
        }
    }
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
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
    /// The engine reached a limit before it had an answer.
    #[serde(rename = "no answer")]
    NoAnswer,
    /// The engine is absent, or was not asked in time.
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
            Self::NoAnswer => "no answer",
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

/// A theorem as it is listed, with what was shown of it before.
#[derive(Clone, Debug, Serialize)]
pub struct ListedWithEvidence {
    /// The theorem.
    #[serde(flatten)]
    pub theorem: Listed,
    /// What Kani draws of it, if Kani can judge it.
    pub kani_scope: Option<String>,
    /// By engine: what was shown, and whether it still holds for the code as it is.
    pub evidence: BTreeMap<&'static str, Known>,
}

/// What is known of a theorem by one engine.
#[derive(Clone, Debug, Serialize)]
pub struct Known {
    /// `current`, `stale`, `not run` or `not for Kani`.
    pub state: &'static str,
    /// What was shown, stale or not.
    #[serde(flatten)]
    pub shown: Option<Shown>,
}

impl ListedWithEvidence {
    /// What was shown of a theorem in a workspace.
    #[must_use]
    pub fn new(theorem: &Theorem, evidence: &Evidence) -> Self {
        let known = ENGINES.map(|engine| {
            let state = match evidence.state(theorem, engine) {
                State::Current => "current",
                State::Stale => "stale",
                State::Missing => "not run",
                State::NotForKani => "not for Kani",
            };
            (engine, Known { state, shown: evidence.of(theorem, engine).cloned() })
        });
        Self {
            theorem: theorem.into(),
            kani_scope: theorem.not_for_kani.is_none().then(|| evidence.kani_scope(theorem).to_owned()),
            evidence: BTreeMap::from(known),
        }
    }

    /// The line that shows it to a person.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = self.theorem.text();
        for engine in ENGINES {
            let Some(Known { state, shown }) = self.evidence.get(engine) else { continue };
            let _ = match shown {
                Some(Shown { verdict, version, .. }) if *state == "stale" => {
                    write!(text, "; {engine}: stale ({verdict} by {version})")
                }
                Some(Shown { verdict, version, .. }) => write!(text, "; {engine}: {verdict} by {version}"),
                None => write!(text, "; {engine}: {state}"),
            };
        }
        text
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
        if matches!(verdict, EngineVerdict::Proved | EngineVerdict::Held | EngineVerdict::Disproved) {
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

    /// By Kani, which has not judged any case of its own.
    #[must_use]
    pub fn by_kani(theorem: &Theorem, verdict: EngineVerdict, scope: &str) -> Self {
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

    /// What there is to record of it, for what the theorem rests on; nothing if the engine did not run.
    #[must_use]
    pub fn shown(&self, version: &str, shown_for: String) -> Option<Shown> {
        let verdict = match self.verdict {
            EngineVerdict::NotRun | EngineVerdict::NotForKani => return None,
            EngineVerdict::Disproved => "disproved",
            EngineVerdict::Proved => "proved",
            EngineVerdict::Held => "held",
            EngineVerdict::NoAnswer => "no answer",
        };
        Some(Shown {
            verdict: verdict.to_owned(),
            version: version.to_owned(),
            scope: self.scope.clone(),
            cases: self.cases,
            covers: [self.covers_reached, self.theorem.covers.len()],
            seconds: self.seconds,
            shown_for,
        })
    }
}
