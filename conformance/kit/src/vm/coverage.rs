//! Which sets × ways × outcomes × transitions of the policy sessions exercise, in a small geometry.

use super::cache::{Cache, play};
use super::config;
use super::model::ModelCache;
use super::request::{END_OF_ADDRESSES, Request};
use crate::coverage::{Coverage, CoverageCount};
use crate::session::Session;
use crate::words::name_of;
use saarcor_model::vm::{HostAddr, LineAddr, Outcome, Policy, Set};
use std::collections::BTreeSet;

/// Ways of the small geometry: the paper's.
const WAYS: usize = 4;
/// Its sets: more than one, so that they can be mixed up.
const SETS: u64 = 2;

/// What can happen to a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    Hit,
    FillsFreeWay,
    Evicts,
    IsInvalidated,
}

/// An event at a way, and the policy's bits before and after.
type Case = (usize, Event, [u8; WAYS], [u8; WAYS]);

/// A policy, all of its cases, and those that were reached, each in its set.
type OfPolicy = (Policy, BTreeSet<Case>, BTreeSet<(usize, Case)>);

/// Coverage of the cache of two sets of four ways, by policy.
pub struct SmallGeometry {
    policies: Vec<OfPolicy>,
}

impl SmallGeometry {
    /// Nothing is exercised yet.
    #[must_use]
    pub fn new() -> Self {
        let policies =
            config::POLICIES.iter().map(|&(_, policy)| (policy, all_cases(policy), BTreeSet::new()));
        Self { policies: policies.collect() }
    }
}

impl Default for SmallGeometry {
    fn default() -> Self {
        Self::new()
    }
}

impl Coverage for SmallGeometry {
    fn add(&mut self, session: &Session) {
        let Ok(config) = config::parse(session.config()) else { return };
        let geometry = config.geometry;
        if geometry.ways() as usize != WAYS || geometry.sets() != SETS {
            return;
        }
        let of_policy = self.policies.iter_mut().find(|(policy, ..)| *policy == config.policy);
        let Some((_, _, reached)) = of_policy else { return };
        let mut cache = ModelCache::<WAYS>::new(config);
        let mut bytes = Vec::new();
        for request in session.requests().filter_map(|request| Request::parse(request).ok()) {
            let before: Vec<Set<WAYS>> = cache.sets().to_vec();
            match request {
                Request::Read { host, .. } => {
                    let line = geometry.line_of(HostAddr(host));
                    let set = config.set_of(line).0 as usize;
                    reached.insert((set, access(&before[set], line, config.policy).0));
                }
                Request::Invalidate { host, len } => {
                    let lines = config.lines_of(HostAddr(host), len.min(END_OF_ADDRESSES));
                    for (index, set) in before.iter().enumerate() {
                        let met = (0..WAYS)
                            .filter(|&way| set.resident[way] && lines.contains(&u64::from(set.lines[way].0)));
                        reached.extend(
                            met.map(|way| (index, (way, Event::IsInvalidated, set.order, set.order))),
                        );
                    }
                }
                Request::Write { .. } | Request::Flush => {}
            }
            play(&mut cache as &mut dyn Cache, &request, &mut bytes);
        }
    }

    fn counts(&self) -> Vec<CoverageCount> {
        let row = |(policy, all, reached): &OfPolicy| CoverageCount {
            what: format!(
                "sets × ways × outcomes × transitions of {} with {SETS} sets of {WAYS} ways",
                name_of(config::POLICIES, policy)
            ),
            reached: reached.len(),
            all: all.len() * SETS as usize,
        };
        self.policies.iter().map(row).collect()
    }
}

/// The case that an access is, and the set after it.
fn access(set: &Set<WAYS>, line: LineAddr, policy: Policy) -> (Case, Set<WAYS>) {
    let (next, outcome) = set.access(line, policy);
    let event = match outcome {
        Outcome::Hit { .. } => Event::Hit,
        Outcome::Miss { evicted: None, .. } => Event::FillsFreeWay,
        Outcome::Miss { evicted: Some(_), .. } => Event::Evicts,
    };
    ((usize::from(outcome.way().0), event, set.order, next.order), next)
}

/// All cases that a set can come to, from the empty one on.
fn all_cases(policy: Policy) -> BTreeSet<Case> {
    let mut cases = BTreeSet::new();
    let mut known = BTreeSet::new();
    let mut open = vec![Set::<WAYS>::empty(policy)];
    while let Some(mut set) = open.pop() {
        // Which lines they are makes no difference: each way has one of its own, and one is elsewhere.
        set.lines = std::array::from_fn(|way| LineAddr(way as u32));
        if !known.insert((set.resident, set.order)) {
            continue;
        }
        for line in 0..=WAYS as u32 {
            let (case, next) = access(&set, LineAddr(line), policy);
            cases.insert(case);
            open.push(next);
            if let (next, Some(way)) = set.invalidate(LineAddr(line)) {
                cases.insert((usize::from(way.0), Event::IsInvalidated, set.order, set.order));
                open.push(next);
            }
        }
    }
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_are_counted_by_hand() {
        // LRU: 24 orders, each with a hit, an invalidation and the filling of each way, and a victim.
        assert_eq!(all_cases(Policy::Lru).len(), 24 * (4 + 4 + 4 + 1));
        assert_eq!(all_cases(Policy::Fifo).len(), 24 * (4 + 4 + 4 + 1));
        // The tree has 8 states; at each the same.
        assert_eq!(all_cases(Policy::Plru).len(), 8 * (4 + 4 + 4 + 1));
    }

    #[test]
    fn a_session_reaches_what_it_does() {
        let session = Session::new(
            "x",
            "saarcor-vm 1",
            "line=16 lines=8 ways=4 hash=low policy=lru",
            b"r 0 1\nr 0 1\ni 0 1\n",
        );
        let mut coverage = SmallGeometry::new();
        coverage.add(&session);
        let reached: Vec<_> = coverage.counts().iter().map(|row| row.reached).collect();
        assert_eq!(reached, [3, 0, 0]);
    }
}
