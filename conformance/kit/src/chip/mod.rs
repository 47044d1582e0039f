//! `saarcor-chip`: packets' programs against caches, virtual memory, memory chips and bus, in cycles
//! and bytes.

mod compare;
pub mod config;
mod coverage;
mod random;
pub mod request;
mod served;
mod simpler;

use crate::kind::{Comparison, Coverage, Kind, Oracle};
use crate::level::Level;
use crate::serve::{Served, Unsupported};
use crate::session::Session;
use crate::suites;
use request::Request;
use saarcor_fast::chip::{ChipObserver, Traffic};
use saarcor_fast::sdram::Span;
use served::ChipServed;

/// The kind `saarcor-chip`.
#[derive(Clone, Copy, Debug)]
pub struct Chip;

impl Kind for Chip {
    fn name(&self) -> &'static str {
        "saarcor-chip"
    }

    fn hello(&self) -> &'static str {
        "saarcor-chip 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Traffic, Level::Timing]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::CHIP
    }

    fn random(&self, seed: u64, requests: usize) -> Session {
        let config = random::config_of(seed);
        let name = format!("{}/random/{seed}", self.prefix());
        Session::new(&name, self.hello(), &config, &random::requests(&config, seed, requests))
    }

    fn with_tolerance(&self, session: Session, tolerance: u32) -> Session {
        session.with_config(&config::with_tolerance(session.config(), tolerance))
    }

    fn check(&self, session: &Session) -> Result<(), String> {
        let setting = config::parse(session.config()).map_err(|wrong| format!("config: {wrong}"))?;
        for (request, number) in session.requests().zip(1..) {
            let wrong =
                |right: &str| format!("request {number}, '{}': {right}", String::from_utf8_lossy(request));
            Request::parse(request).and_then(|request| request.fits(&setting)).map_err(wrong)?;
        }
        Ok(())
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Served>, Unsupported> {
        Ok(Box::new(ChipServed::new(oracle, config)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        config::keys().collect()
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, String> {
        Ok(Box::new(compare::ChipComparison::new(session, observes)?))
    }

    fn simpler_configs(&self, config: &str) -> Vec<String> {
        config::simpler(config)
    }

    fn simpler_requests(&self, _session: &Session, request: &[u8]) -> Vec<String> {
        simpler::requests(request).iter().map(Request::to_string).collect()
    }

    /// One packet simplified, as long as one can be.
    fn simpler_sessions(&self, session: &Session) -> Vec<Session> {
        simpler::sessions(session)
    }

    /// What moves in the model, and when.
    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(mut model) = ChipServed::new(Oracle::Model, session.config()) else { return Vec::new() };
        if session.requests().nth(request) != Some(b"run") {
            return Vec::new();
        }
        session.requests().take(request).filter_map(|line| Request::parse(line).ok()).for_each(|request| {
            model.change(request);
        });
        let mut moved = Moved::default();
        let report = model.play(&mut moved);
        let more = moved.0.len().saturating_sub(SHOWN);
        moved.0.truncate(SHOWN);
        moved.0.extend((more > 0).then(|| format!("and {more} more")));
        moved.0.push(format!("the last packet ends in cycle {:x}", report.cycles));
        moved.0
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::<coverage::Reached>::default()
    }
}

/// Transfers that are shown of a run.
const SHOWN: usize = 32;

/// The transfers of a run, for a person.
#[derive(Default)]
struct Moved(Vec<String>);

impl ChipObserver for Moved {
    fn transfer(&mut self, _: u32, traffic: Traffic, span: Span, bytes: u64) {
        let what = match traffic {
            Traffic::L1Fill => "from the on-board memory to a first-level cache",
            Traffic::VmFill => "of a line written to the on-board memory",
            Traffic::MetadataRead => "of metadata read",
            Traffic::MetadataWriteBack => "of metadata written back",
            Traffic::Pci => "from the host, set-up included",
        };
        self.0.push(format!("cycles {:x} to {:x}: {bytes:x} bytes {what}", span.begin, span.end));
    }
}
