//! What a request does to the lines × what it does to the granules, in a small geometry.

use super::config::{self, MetaConfig};
use super::request::Request;
use super::tags::{ModelTags, Tags as _};
use crate::coverage::{Coverage, CoverageCount};
use crate::session::Session;
use saarcor_model::vm::{HostAddr, LineAddr, Outcome};
use saarcor_oracles::metadata::GranuleEvent;
use std::collections::BTreeSet;

/// Ways of the small geometry, and granules that its metadata cache holds.
const WAYS: usize = 4;
const META_WAYS: usize = 2;
const GRANULE: usize = 16;
/// Its sets: two, that share a granule.
const SETS: u64 = 2;

/// What a request does to a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ToLine {
    Hits,
    FillsFreeWay,
    Evicts,
    Invalidates,
    FindsNothingToInvalidate,
}

/// What becomes of a granule that it asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ToGranule {
    IsFound,
    FillsFreeWay,
    EvictsClean,
    EvictsChanged,
}

/// Five times four, but that granules fill free ways only while no line is resident.
const CASES: usize = 5 * 4 - 3;

/// Coverage of two sets of four ways, whose metadata has three granules, of which two are cached.
#[derive(Clone, Debug, Default)]
pub struct SmallGeometry {
    reached: BTreeSet<(ToLine, ToGranule)>,
}

impl Coverage for SmallGeometry {
    fn add(&mut self, session: &Session) {
        let Ok(config) = config::parse(session.config()) else { return };
        let MetaConfig { cache, granule, sets, ways, faults } = config;
        let geometry = cache.geometry;
        let small = (geometry.ways() as usize, geometry.sets(), granule, sets, ways)
            == (WAYS, SETS, GRANULE, 1, META_WAYS);
        if !small || faults {
            return;
        }
        let mut tags = ModelTags::<WAYS, META_WAYS, GRANULE>::new(&config);
        let (mut moved, mut cached) = (Vec::new(), 0);
        for request in session.requests().filter_map(|request| Request::parse(request).ok()) {
            moved.clear();
            match request {
                Request::Read { host } => {
                    let to_line = match tags.access(geometry.line_of(HostAddr(host)), &mut moved) {
                        Outcome::Hit { .. } => ToLine::Hits,
                        Outcome::Miss { evicted: None, .. } => ToLine::FillsFreeWay,
                        Outcome::Miss { evicted: Some(_), .. } => ToLine::Evicts,
                    };
                    self.count(to_line, &moved, &mut cached);
                }
                Request::Invalidate { host, len } => {
                    for line in cache.lines_of(HostAddr(host), len) {
                        let line = LineAddr(line as u32);
                        let way = tags.set_of(line).and_then(|set| set.way_of(line));
                        let found = [ToLine::FindsNothingToInvalidate, ToLine::Invalidates];
                        moved.clear();
                        tags.invalidate(geometry.first_byte(line), 1, &mut moved);
                        self.count(found[usize::from(way.is_some())], &moved, &mut cached);
                    }
                }
                Request::Flush => {
                    tags.flush();
                    cached = 0;
                }
                Request::Flip { .. } => {}
            }
        }
    }

    fn counts(&self) -> Vec<CoverageCount> {
        vec![CoverageCount {
            what: "what a request does to its line × to a granule, with 2 of 3 granules cached".to_owned(),
            reached: self.reached.len(),
            all: CASES,
        }]
    }
}

impl SmallGeometry {
    /// Counts what moved, given how many granules were in the metadata cache.
    fn count(&mut self, to_line: ToLine, moved: &[GranuleEvent], cached: &mut usize) {
        for (place, granule) in moved.iter().enumerate() {
            let to_granule = match granule {
                GranuleEvent::Found(_) => ToGranule::IsFound,
                GranuleEvent::Read(_) if *cached < META_WAYS => {
                    *cached += 1;
                    ToGranule::FillsFreeWay
                }
                GranuleEvent::Read(_)
                    if matches!(moved.get(place + 1), Some(GranuleEvent::WrittenBack(..))) =>
                {
                    ToGranule::EvictsChanged
                }
                GranuleEvent::Read(_) => ToGranule::EvictsClean,
                GranuleEvent::WrittenBack(..) => continue,
            };
            self.reached.insert((to_line, to_granule));
        }
    }
}
