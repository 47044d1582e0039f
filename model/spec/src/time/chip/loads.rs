//! Loads of lines from the host, and the parts that wait for them (CH-14, CH-15).

use super::first_level::LinePart;
use crate::vm::LineAddr;
use std::collections::VecDeque;

/// A line of the host that is loaded, and the address on the card from which on it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Load {
    /// The line.
    pub line: LineAddr,
    /// The place that the directory gave it.
    pub card: u64,
}

/// An access to a line on the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardAccess {
    /// A line from the host is written to its place.
    Write(Load),
    /// A part is read.
    Read {
        /// The part.
        part: LinePart,
        /// Address of its first byte on the card.
        card: u64,
    },
}

/// Number of a load. Loads count in the order of the parts that miss; in this order the bus carries them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoadId(pub u64);

/// The loads in flight, from the miss to the arrival, and the parts that wait for them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loads<Part> {
    /// The loads in flight, in order.
    pub in_flight: VecDeque<Load>,
    /// Number of the first of them: so many have arrived.
    pub arrived: u64,
    /// The parts that wait, in the order of their tags, and the load that each waits for.
    pub waiting: Vec<(LoadId, Part)>,
}

impl<Part> Default for Loads<Part> {
    /// No line was missed yet.
    fn default() -> Self {
        Self { in_flight: VecDeque::new(), arrived: 0, waiting: Vec::new() }
    }
}

impl<Part> Loads<Part> {
    /// The directory places a part's line, which is missed or resident. A missed line is loaded to its
    /// place, whatever is in flight; the load that brings a resident line is its latest, if that is in
    /// flight. The load that brings the part's line.
    pub fn request(&mut self, load: Load, missed: bool) -> Option<LoadId> {
        if missed {
            self.in_flight.push_back(load);
        }
        let latest = self.in_flight.iter().rposition(|other| other.line == load.line);
        latest.map(|place| LoadId(self.arrived + place as u64))
    }

    /// The tag of a part is acted upon. While the `load` that brings its line is in flight, the part waits
    /// for it; else it is given back, to be read at once.
    pub fn act(&mut self, load: Option<LoadId>, part: Part) -> Option<Part> {
        let Some(load) = load.filter(|load| load.0 >= self.arrived) else { return Some(part) };
        self.waiting.push((load, part));
        None
    }

    /// The first load in flight arrives: its line is written to the card, and then the parts that waited
    /// for it are read, in this order.
    pub fn arrive(&mut self) -> Option<(Load, Vec<(LoadId, Part)>)> {
        let load = self.in_flight.pop_front()?;
        self.arrived += 1;
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        let (parts, others) = waiting.partition(|(id, _)| id.0 < self.arrived);
        self.waiting = others;
        Some((load, parts))
    }
}
