//! `saarcor-meta`: the tags of version B, whose metadata lies on the card behind a small cache.

mod compare;
pub mod config;
mod coverage;
mod random;
pub mod request;
mod sizes;
pub mod tags;

use crate::comparison::Comparison;
use crate::coverage::Coverage;
use crate::error::Error;
use crate::hex::push_request;
use crate::implementation::Implementation;
use crate::kind::{Candidates, Kind, Oracle};
use crate::level::Level;
use crate::session::Session;
use crate::sizes::{Extent, SizedSession};
use crate::suites;
use crate::vm::trace;
use config::MetaConfig;
use request::Request;
use saarcor_model::vm::{ENTRY_BYTES, HostAddr};
use std::borrow::Cow;
use std::collections::BTreeSet;
use tags::TagsAdapter;

/// The kind `saarcor-meta`.
#[derive(Clone, Copy, Debug)]
pub struct Meta;

/// Configurations that a recorded frame is played with: the standard one, whose metadata cache holds all that a small
/// frame needs, and ones that have too few lines, or too few granules.
const FRAME_CONFIGS: &[&str] = &[
    "line=128 lines=65536 ways=4 hash=add-upper policy=lru granule=16 meta-sets=1024 meta-ways=4 faults=0",
    "line=128 lines=512 ways=8 hash=add-upper policy=lru granule=8 meta-sets=32 meta-ways=2 faults=0",
    "line=64 lines=4096 ways=2 hash=add-upper-all policy=fifo granule=16 meta-sets=16 meta-ways=4 faults=0",
];

/// Whether a request is legal with this configuration; what would be right, where it is not.
fn fits(config: &MetaConfig, request: Request) -> Result<(), Error> {
    match request {
        Request::Invalidate { host, len } => {
            let lines = config.cache.lines_of(HostAddr(host), len);
            // How so many are best found is the implementation's affair, and so is what moves for it.
            let few = lines.end - lines.start < config.cache.geometry.lines();
            if few { Ok(()) } else { Err("a range meets fewer lines than the card has".into()) }
        }
        Request::Flip { .. } if !config.faults => Err("'x' is for faults=1".into()),
        Request::Flip { byte, .. } if u64::from(byte) >= config.bytes() => {
            Err("the metadata of all lines has 5 bytes a line".into())
        }
        _ => Ok(()),
    }
}

impl Kind for Meta {
    fn hello(&self) -> &'static str {
        "saarcor-meta 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Traffic, Level::State, Level::Metadata]
    }

    fn observable(&self) -> &'static [(&'static str, Level)] {
        &[
            ("hit", Level::Traffic),
            ("card", Level::State),
            ("evict", Level::State),
            ("meta", Level::Metadata),
            ("bytes", Level::Metadata),
        ]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::META
    }

    fn random_config(&self, seed: u64) -> Cow<'static, str> {
        random::config_of(seed)
    }

    fn random_requests(&self, config: &str, seed: u64, count: usize) -> Vec<u8> {
        random::requests(config, seed, count)
    }

    fn sizes(&self, extent: &Extent) -> Vec<SizedSession> {
        sizes::sessions(extent)
    }

    fn recorded(&self, requests: usize) -> Vec<Session> {
        trace::recorded(self, FRAME_CONFIGS, requests, |addresses, _| {
            let mut text = Vec::new();
            addresses.iter().for_each(|HostAddr(addr)| push_request(&mut text, b'r', &[(*addr).into()]));
            text
        })
    }

    fn check(&self, session: &Session) -> Result<(), Error> {
        let config = config::parse(session.config()).map_err(Error::in_config)?;
        let mut flipped = BTreeSet::new();
        session.check_requests(|request| {
            let request = Request::parse(request)?;
            fits(&config, request)?;
            match request {
                Request::Flush => flipped.clear(),
                // The check bits need not detect two errors of an entry (VM-12).
                Request::Flip { byte, .. } if !flipped.insert(byte as usize / ENTRY_BYTES) => {
                    return Err("an entry is flipped once until the next flush".into());
                }
                _ => {}
            }
            Ok(())
        })
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Implementation>, Error> {
        let make = match oracle {
            Oracle::Model => tags::model,
            Oracle::Naive => tags::naive,
        };
        Ok(Box::new(TagsAdapter::new(config, &make)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        config::keys().collect()
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, Error> {
        Ok(Box::new(compare::MetaComparison::new(session, observes)?))
    }

    fn simpler_configs(&self, config: &str) -> Vec<String> {
        let simpler = config::parse(config).map(|config| config::simpler(&config)).unwrap_or_default();
        simpler.iter().map(config::text).collect()
    }

    fn simpler_requests<'a>(&self, session: &Session, request: &'a [u8]) -> Candidates<'a, String> {
        let line = config::parse(session.config()).map_or(1, |config| config.cache.geometry.line().0);
        let down = |host: u32| (u64::from(host) / line * line) as u32;
        let simpler = match Request::parse(request) {
            Ok(Request::Read { host }) => vec![Request::Read { host: down(host) }],
            Ok(Request::Invalidate { host, .. }) => {
                vec![Request::Invalidate { host: down(host), len: 1 }, Request::Invalidate { host, len: 1 }]
            }
            Ok(Request::Flip { byte, .. }) => vec![Request::Flip { byte, mask: 1 }],
            Ok(Request::Flush) | Err(_) => Vec::new(),
        };
        let text = simpler.into_iter().map(|request| request.to_string());
        Box::new(text.filter(move |text| text.as_bytes() != request))
    }

    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(mut model) = TagsAdapter::new(session.config(), &tags::model) else { return Vec::new() };
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
