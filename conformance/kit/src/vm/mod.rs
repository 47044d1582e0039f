//! `saarcor-vm`: the virtual memory, version A or any that answers as it does.

pub mod cache;
mod compare;
pub mod config;
pub mod coverage;
mod host;
pub mod model;
pub mod naive;
mod random;
pub mod request;
pub(crate) mod sizes;
pub mod trace;
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
use cache::CacheAdapter;
use request::{Observes, Request};
use saarcor_model::vm::{CacheConfig, HostAddr, Policy, Set};
use std::borrow::Cow;

/// The kind `saarcor-vm`.
#[derive(Clone, Copy, Debug)]
pub struct Vm;

impl Kind for Vm {
    fn hello(&self) -> &'static str {
        "saarcor-vm 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Data, Level::Traffic, Level::State]
    }

    fn observable(&self) -> &'static [(&'static str, Level)] {
        &[("data", Level::Data), ("hit", Level::Traffic), ("card", Level::State), ("evict", Level::State)]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::VM
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
        trace::recorded(self, trace::CONFIGS, requests, trace::requests)
    }

    fn check(&self, session: &Session) -> Result<(), Error> {
        let config = config::parse(session.config()).map_err(Error::in_config)?;
        let line = config.geometry.line().0;
        session.check_requests(|request| match Request::parse(request)?.fits(line) {
            true => Ok(()),
            false => Err(format!("a read lies within one line of {line} bytes").into()),
        })
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Implementation>, Error> {
        let make = match oracle {
            Oracle::Model => model::make,
            Oracle::Naive => naive::make,
        };
        Ok(Box::new(CacheAdapter::new(config, &make)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        config::KEYS.to_vec()
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, Error> {
        Ok(Box::new(compare::VmComparison::new(session, observes)?))
    }

    fn explanations(&self, session: &Session, observes: &str, answers: &[&[u8]]) -> Vec<&'static str> {
        match (config::parse(session.config()), Observes::parse(observes)) {
            (Ok(config), Ok(observes)) => {
                let exchanges: Vec<_> = session.requests().zip(answers.iter().copied()).collect();
                variants::explanations(config, observes, exchanges.iter().copied())
            }
            _ => Vec::new(),
        }
    }

    fn simpler_configs(&self, config: &str) -> Vec<String> {
        let simpler = config::parse(config).map(|config| config::simpler(&config)).unwrap_or_default();
        simpler.iter().map(config::text).collect()
    }

    fn simpler_requests<'a>(&self, session: &Session, request: &'a [u8]) -> Candidates<'a, String> {
        let line = config::parse(session.config()).map_or(1, |config| config.geometry.line().0);
        let down = |host: u32| (u64::from(host) / line * line) as u32;
        let simpler = match Request::parse(request) {
            Ok(Request::Read { host, .. }) => {
                vec![Request::Read { host: down(host), len: 1 }, Request::Read { host, len: 1 }]
            }
            Ok(Request::Write { host, digits }) => vec![
                Request::Write { host: down(host), digits: b"01" },
                Request::Write { host, digits: &digits[..2] },
            ],
            Ok(Request::Invalidate { host, .. }) => {
                vec![Request::Invalidate { host: down(host), len: 1 }, Request::Invalidate { host, len: 1 }]
            }
            Ok(Request::Flush) | Err(_) => Vec::new(),
        };
        let text = simpler.into_iter().map(|request| request.to_string());
        Box::new(text.filter(move |text| text.as_bytes() != request))
    }

    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(config) = config::parse(session.config()) else { return Vec::new() };
        let asked = session.requests().nth(request);
        let Some(Ok(Request::Read { host, .. })) = asked.map(Request::parse) else { return Vec::new() };
        let before = session.requests().take(request);
        match config.geometry.ways() {
            1 => shown::<1>(config, before, host),
            2 => shown::<2>(config, before, host),
            4 => shown::<4>(config, before, host),
            8 => shown::<8>(config, before, host),
            _ => shown::<16>(config, before, host),
        }
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::new(coverage::SmallGeometry::new())
    }
}

/// The set of `host` after some requests, way by way.
fn shown<'a, const WAYS: usize>(
    config: CacheConfig,
    before: impl Iterator<Item = &'a [u8]>,
    host: u32,
) -> Vec<String> {
    let mut cache = model::ModelCache::<WAYS>::new(config);
    let mut buffer = Vec::new();
    for request in before.filter_map(|request| Request::parse(request).ok()) {
        cache::play(&mut cache, &request, &mut buffer);
    }
    let set: &Set<WAYS> = cache.set_of(HostAddr(host));
    let line = config.geometry.line_of(HostAddr(host));
    let mut rows =
        vec![format!("line {:x} of address {host:x} belongs to set {:x}", line.0, config.set_of(line).0)];
    for way in 0..WAYS {
        rows.push(if set.resident[way] {
            let first_byte = config.geometry.first_byte(set.lines[way]);
            format!("way {way:x}: line {:x}, from address {:x} on", set.lines[way].0, first_byte.0)
        } else {
            format!("way {way:x}: free")
        });
    }
    let ways: Vec<_> = set.order.iter().map(|entry| format!("{entry:x}")).collect();
    rows.push(match config.policy {
        Policy::Lru => format!("ways from the one used last to the one used first: {}", ways.join(" ")),
        Policy::Fifo => format!("ways from the one loaded last to the one loaded first: {}", ways.join(" ")),
        Policy::Plru => format!("bits of the tree from the root on (1 points up): {}", ways[1..].join(" ")),
    });
    rows
}
