//! What a proof found.

use super::driver::Asked;
use super::tools::Tools;
use crate::kind::Kind as _;
use crate::meta::Meta;
use crate::report::SCHEMA_VERSION;
use serde::Serialize;

/// The verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProofVerdict {
    /// All claims hold, for requests without end.
    Proved,
    /// One does not.
    Refuted,
    /// Neither was shown.
    NotDecided,
}

impl ProofVerdict {
    /// The verdict in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Refuted => "refuted",
            Self::NotDecided => "not decided",
        }
    }
}

/// A step of a proof.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// What it is.
    pub name: String,
    /// The cache.
    pub config: String,
    /// What it came to.
    pub says: String,
    /// Seconds that it took.
    pub seconds: f64,
}

/// A fault that the run planted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Planted {
    /// What it does.
    pub says: String,
    /// The clocks after which it is refuted; none where it is not.
    pub clocks: Option<u32>,
}

/// The shortest trace that refutes a claim.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Trace {
    /// The claim that fails.
    pub claim: String,
    /// What is wrong.
    pub says: String,
    /// The cache, which may be smaller than the one that is asked for.
    pub config: String,
    /// Clocks, the first being one of reset.
    pub clocks: u32,
    /// Its requests in words.
    pub requests: Vec<String>,
    /// Where its waves are kept.
    pub waves: Option<String>,
    /// The command that replays its requests.
    pub replay: Option<String>,
    /// The session of these requests.
    #[serde(skip)]
    pub suite: Vec<u8>,
    /// The waves, as a VCD.
    #[serde(skip)]
    pub vcd: Vec<u8>,
}

/// What a proof found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProofReport {
    /// The version of this form.
    pub schema_version: u32,
    /// The implementation.
    pub dut: String,
    /// Its kind.
    pub kind: String,
    /// The cache that it is to be.
    pub config: String,
    /// The verdict.
    pub verdict: ProofVerdict,
    /// Why it is not decided; empty where it is.
    pub reason: String,
    /// The clocks in which no counterexample was found.
    pub reached: u32,
    /// The steps.
    pub stages: Vec<Stage>,
    /// What has to be reached, and after how many clocks it is; none where it is not.
    pub covers: Vec<(String, Option<u32>)>,
    /// Faults of the run's own.
    pub planted: Vec<Planted>,
    /// What is assumed.
    pub assumed: Vec<String>,
    /// What is not claimed.
    pub not_claimed: Vec<&'static str>,
    /// The programs: ABC and the solver.
    pub tools: [&'static str; 2],
    /// The trace that refutes it.
    pub trace: Option<Trace>,
}

impl ProofReport {
    pub(super) fn new(asked: &Asked<'_>, config: &str, tools: &Tools) -> Self {
        let mut not_claimed = vec!["that a request is taken at all, where the implementation says when"];
        if asked.config.data.is_none() {
            not_claimed.push("the bytes of a line: the place of the line stands for them");
        }
        if asked.kind == Meta.name() {
            not_claimed.push("what goes through the metadata cache, and what is on the card");
        }
        Self {
            schema_version: SCHEMA_VERSION,
            dut: asked.name.clone(),
            kind: asked.kind.to_owned(),
            config: config.to_owned(),
            verdict: ProofVerdict::NotDecided,
            reason: String::new(),
            reached: 0,
            stages: Vec::new(),
            covers: Vec::new(),
            planted: Vec::new(),
            assumed: vec!["the clock rises once a step, and registers change then".to_owned()],
            not_claimed,
            tools: [tools.abc, tools.solver],
            trace: None,
        }
    }
}
