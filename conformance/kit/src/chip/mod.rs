//! `saarcor-chip`: packets' programs against caches, virtual memory, memory chips and bus, in cycles
//! and bytes.

mod compare;
pub mod config;
mod coverage;
mod oracle;
mod random;
pub mod request;
mod shrink;
mod sizes;
mod variants;

use crate::comparison::Comparison;
use crate::coverage::Coverage;
use crate::error::Error;
use crate::implementation::Implementation;
use crate::kind::{Candidates, Kind, Oracle};
use crate::level::Level;
use crate::session::Session;
use crate::sizes::{Extent, SizedSession};
use crate::suites;
use oracle::ChipOracle;
use request::{Observes, Request};
use saarcor_fast::chip::{ChipObserver, Traffic};
use saarcor_model::time::Span;
use std::borrow::Cow;

/// The kind `saarcor-chip`.
#[derive(Clone, Copy, Debug)]
pub struct Chip;

impl Kind for Chip {
    fn hello(&self) -> &'static str {
        "saarcor-chip 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Traffic, Level::Timing]
    }

    fn observable(&self) -> &'static [(&'static str, Level)] {
        &[
            ("cycles", Level::Timing),
            ("pci", Level::Traffic),
            ("mem", Level::Traffic),
            ("l1", Level::Traffic),
            ("l2", Level::Traffic),
        ]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::CHIP
    }

    fn random_config(&self, seed: u64) -> Cow<'static, str> {
        random::config_of(seed).into()
    }

    fn random_requests(&self, config: &str, seed: u64, count: usize) -> Vec<u8> {
        random::requests(config, seed, count)
    }

    fn sizes(&self, extent: &Extent) -> Vec<SizedSession> {
        sizes::sessions(extent)
    }

    /// At most so many operations of each packet: fewer packets would not meet.
    fn recorded(&self, requests: usize) -> Vec<Session> {
        let cut = |session: Session| {
            let mut longest = 0;
            let shorter = |line| {
                let request = Request::parse(line).expect("a request of the kit");
                let operations = request.operations();
                let first = &operations[..operations.len().min(requests)];
                longest = longest.max(first.len());
                request.with(first.to_vec()).text()
            };
            let lines: Vec<_> = session.requests().map(shorter).collect();
            let mut cut = session.with_requests(lines.iter().map(Vec::as_slice));
            cut.idea = format!(
                "Up to {longest} operations of each packet of a recorded frame, with caches cold and then warm."
            );
            cut
        };
        suites::of_frames(suites::CHIP_FRAMES).map(cut).collect()
    }

    fn with_tolerance(&self, session: Session, tolerance: u32) -> Session {
        session.with_config(&config::with_tolerance(session.config(), tolerance))
    }

    fn check(&self, session: &Session) -> Result<(), Error> {
        let setting = config::parse(session.config()).map_err(Error::in_config)?;
        session.check_requests(|request| Request::parse(request)?.fits(&setting))
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Implementation>, Error> {
        Ok(Box::new(ChipOracle::new(oracle, config)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        config::keys().collect()
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, Error> {
        Ok(Box::new(compare::ChipComparison::new(session, observes)?))
    }

    fn explanations(&self, session: &Session, observes: &str, answers: &[&[u8]]) -> Vec<&'static str> {
        match (config::parse(session.config()), Observes::parse(observes)) {
            (Ok(setting), Ok(observes)) => {
                let exchanges: Vec<_> = session.requests().zip(answers.iter().copied()).collect();
                variants::explanations(&setting, observes, exchanges.iter().copied())
            }
            _ => Vec::new(),
        }
    }

    fn simpler_configs(&self, config: &str) -> Vec<String> {
        config::simpler(config)
    }

    fn simpler_requests<'a>(&self, _session: &Session, request: &'a [u8]) -> Candidates<'a, String> {
        Box::new(shrink::requests(request).map(|simpler| simpler.to_string()))
    }

    /// One packet simplified, as long as one can be.
    fn simpler_sessions<'a>(&self, session: &'a Session) -> Candidates<'a, Session> {
        Box::new(shrink::sessions(session))
    }

    /// What moves in the model, and when.
    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(mut model) = ChipOracle::new(Oracle::Model, session.config()) else { return Vec::new() };
        if session.requests().nth(request) != Some(b"run") {
            return Vec::new();
        }
        session.requests().take(request).filter_map(|line| Request::parse(line).ok()).for_each(|request| {
            model.change(request);
        });
        let mut moved = TransferLog::default();
        let report = model.play(&mut moved);
        let TransferLog { mut rows, more } = moved;
        rows.extend((more > 0).then(|| format!("and {more} more")));
        rows.push(format!("the last packet ends in cycle {:x}", report.cycles));
        rows
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::<coverage::ChipCoverage>::default()
    }
}

/// Transfers that are shown of a run.
const SHOWN: usize = 32;

/// The transfers of a run, for a person.
#[derive(Default)]
struct TransferLog {
    /// The first of them.
    rows: Vec<String>,
    /// How many followed.
    more: usize,
}

impl ChipObserver for TransferLog {
    fn transfer(&mut self, _: u32, traffic: Traffic, span: Span, bytes: u64) {
        if self.rows.len() == SHOWN {
            self.more += 1;
            return;
        }
        let what = match traffic {
            Traffic::L1Fill => "from the on-board memory to a first-level cache",
            Traffic::VmFill => "of a line written to the on-board memory",
            Traffic::MetadataRead => "of metadata read",
            Traffic::MetadataWriteBack => "of metadata written back",
            Traffic::Pci => "from the host, set-up included",
        };
        self.rows.push(format!("cycles {:x} to {:x}: {bytes:x} bytes {what}", span.begin, span.end));
    }
}
