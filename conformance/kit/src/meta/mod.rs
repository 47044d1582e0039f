//! `saarcor-meta`: the tags of version B, whose metadata lies on the card behind a small cache.

mod compare;
pub mod config;
mod coverage;
mod random;
pub mod request;
pub mod tags;

use crate::kind::{Comparison, Coverage, Kind, Oracle};
use crate::level::Level;
use crate::serve::{Served, Unsupported};
use crate::session::Session;
use crate::suites;
use config::MetaConfig;
use request::Request;
use saarcor_model::vm::{ENTRY_BYTES, HostAddr};
use std::collections::BTreeSet;
use tags::TagsServed;

/// The kind `saarcor-meta`.
#[derive(Clone, Copy, Debug)]
pub struct Meta;

/// Whether a request is legal with this configuration; what would be right, where it is not.
fn fits(config: &MetaConfig, request: Request) -> Result<(), &'static str> {
    match request {
        Request::Invalidate { host, len } => {
            let lines = config.cache.lines_of(HostAddr(host), len);
            // How so many are best found is the implementation's affair, and so is what moves for it.
            let few = lines.end - lines.start < config.cache.geometry.lines();
            few.then_some(()).ok_or("a range meets fewer lines than the card has")
        }
        Request::TurnOver { .. } if !config.faults => Err("'x' is for faults=1"),
        Request::TurnOver { byte, .. } if u64::from(byte) >= config.bytes() => {
            Err("the metadata of all lines has 5 bytes a line")
        }
        _ => Ok(()),
    }
}

impl Kind for Meta {
    fn name(&self) -> &'static str {
        "saarcor-meta"
    }

    fn hello(&self) -> &'static str {
        "saarcor-meta 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Traffic, Level::State, Level::Metadata]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::META
    }

    fn random(&self, seed: u64, requests: usize) -> Session {
        let config = random::config_of(seed);
        let name = format!("{}/random/{seed}", self.prefix());
        Session::new(&name, self.hello(), config, &random::requests(config, seed, requests))
    }

    fn check(&self, session: &Session) -> Result<(), String> {
        let config = config::parse(session.config()).map_err(|wrong| format!("config: {wrong}"))?;
        let mut turned = BTreeSet::new();
        for (request, number) in session.requests().zip(1..) {
            let wrong =
                |right: &str| format!("request {number}, '{}': {right}", String::from_utf8_lossy(request));
            let request = Request::parse(request).map_err(wrong)?;
            fits(&config, request).map_err(wrong)?;
            match request {
                Request::Flush => turned.clear(),
                // Two errors of an entry may not be told (VM-12).
                Request::TurnOver { byte, .. } if !turned.insert(byte as usize / ENTRY_BYTES) => {
                    return Err(wrong("an entry is flipped once until the next flush"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Served>, Unsupported> {
        let make = match oracle {
            Oracle::Model => tags::model,
            Oracle::Naive => tags::naive,
        };
        Ok(Box::new(TagsServed::new(config, &make)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        config::keys().collect()
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, String> {
        Ok(Box::new(compare::MetaComparison::new(session, observes)?))
    }

    fn simpler_configs(&self, config: &str) -> Vec<String> {
        let simpler = config::parse(config).map(|config| config::simpler(&config)).unwrap_or_default();
        simpler.iter().map(config::text).collect()
    }

    fn simpler_requests(&self, session: &Session, request: &[u8]) -> Vec<String> {
        let line = config::parse(session.config()).map_or(1, |config| config.cache.geometry.line().0);
        let down = |host: u32| (u64::from(host) / line * line) as u32;
        let simpler = match Request::parse(request) {
            Ok(Request::Read { host }) => vec![Request::Read { host: down(host) }],
            Ok(Request::Invalidate { host, .. }) => {
                vec![Request::Invalidate { host: down(host), len: 1 }, Request::Invalidate { host, len: 1 }]
            }
            Ok(Request::TurnOver { byte, .. }) => vec![Request::TurnOver { byte, mask: 1 }],
            Ok(Request::Flush) | Err(_) => Vec::new(),
        };
        let text = simpler.into_iter().map(|request| request.to_string());
        text.filter(|text| text.as_bytes() != request).collect()
    }

    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(mut model) = TagsServed::new(session.config(), &tags::model) else { return Vec::new() };
        let asked = session.requests().nth(request).map(Request::parse);
        let Some(Ok(Request::Read { host } | Request::Invalidate { host, .. })) = asked else {
            return Vec::new();
        };
        let mut answer = Vec::new();
        for before in session.requests().take(request) {
            answer.clear();
            // What is no request changes nothing.
            let _ = model.answer(before, &mut answer);
        }
        model.shown(host)
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::<coverage::SmallGeometry>::default()
    }
}
