//! Theorems of the loads in flight and the parts that wait for them (CH-14, CH-15).
//!
//! A legal state: a card, in which all that earlier loads brought lies; behind it the parts that were
//! taken since, in order, each a hit or a miss that has its line loaded; the chip has acted on the tags of
//! the first of them, and no load has arrived. The directory may be any: a miss takes any place.

use crate::draw::{BYTES, flag};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::time::{Load, LoadId, Loads};
use saarcor_model::vm::LineAddr;
use std::collections::VecDeque;

const PLACES: usize = 2;
const LINES: u8 = 3;
const PARTS: usize = 3;

/// What lies, or will lie, at each place.
type Places = [Option<LineAddr>; PLACES];

/// A part: its line and place, whether it missed, and the load that brings its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part {
    load: Load,
    missed: bool,
    id: Option<LoadId>,
}

#[derive(Clone, Debug)]
struct State {
    card: Places,
    directory: Places,
    loads: Loads<Part>,
    /// Parts whose tags the chip has not acted on.
    pending: VecDeque<Part>,
}

impl State {
    /// The number of the load in flight that is the last to write to a place.
    fn last_load_to(&self, card: u64) -> Option<LoadId> {
        let last = self.loads.in_flight.iter().rposition(|load| load.card == card);
        last.map(|place| LoadId(self.loads.arrived + place as u64))
    }

    /// The part that the directory makes of event `event`: a hit at a place, or a miss of a line, which
    /// takes a place. None if the line is resident, or if nothing is.
    fn part(&self, event: u8) -> Option<Part> {
        if event < PLACES as u8 {
            let load = Load { line: self.directory[usize::from(event)]?, card: event.into() };
            return Some(Part { load, missed: false, id: self.last_load_to(load.card) });
        }
        let (line, card) = ((event - PLACES as u8) % LINES, (event - PLACES as u8) / LINES);
        let line = LineAddr(line.into());
        let load = Load { line, card: card.into() };
        let id = LoadId(self.loads.arrived + self.loads.in_flight.len() as u64);
        (!self.directory.contains(&Some(line))).then_some(Part { load, missed: true, id: Some(id) })
    }

    /// The directory and the loads in flight behind a part.
    fn take(&mut self, part: Part) {
        if part.missed {
            self.directory[part.load.card as usize] = Some(part.load.line);
            self.loads.in_flight.push_back(part.load);
        }
        self.pending.push_back(part);
    }

    /// Whether the state is legal: replays what the directory did since the loads that have arrived.
    fn is_legal(&self) -> bool {
        let Self { card, directory, loads, pending } = self;
        let mut replayed = *card;
        let acted = loads.in_flight.len().saturating_sub(pending.iter().filter(|part| part.missed).count());
        let mut legal = true;
        // Of the loads whose tags were acted on, each has the part that missed, and perhaps others, waiting.
        for (n, load) in loads.in_flight.iter().take(acted).enumerate() {
            let id = LoadId(loads.arrived + n as u64);
            let mut own = loads.waiting.iter().filter(|(other, _)| *other == id).map(|(_, part)| part);
            legal &= own.clone().all(|part| part.load == *load) && own.any(|part| part.missed);
            legal &= !replayed.contains(&Some(load.line));
            replayed[load.card as usize] = Some(load.line);
        }
        let ids = loads.arrived..loads.arrived + acted as u64;
        legal &= loads.waiting.iter().all(|(id, _)| ids.contains(&id.0));
        let mut seen = acted;
        for part in pending {
            if part.missed {
                legal &= part.id == Some(LoadId(loads.arrived + seen as u64));
                legal &= loads.in_flight.get(seen) == Some(&part.load);
                legal &= !replayed.contains(&Some(part.load.line));
                replayed[part.load.card as usize] = Some(part.load.line);
                seen += 1;
            } else {
                let last = loads.in_flight.iter().take(seen).rposition(|load| load.card == part.load.card);
                let last = last.map(|n| LoadId(loads.arrived + n as u64));
                let has_arrived = part.id.is_none_or(|id| id.0 < loads.arrived);
                legal &= replayed[part.load.card as usize] == Some(part.load.line);
                legal &= if last.is_some() { part.id == last } else { has_arrived };
            }
        }
        legal && seen == loads.in_flight.len() && replayed == *directory
    }

    /// Whether a part finds its line on the card.
    fn finds(&self, part: Part) -> bool {
        self.card[part.load.card as usize] == Some(part.load.line)
    }

    /// The chip acts on the first tag: whether the part, if it is read, finds its line.
    fn act(&mut self) -> bool {
        let Some(part) = self.pending.pop_front() else { return true };
        self.loads.act(part.id, part).is_none_or(|part| self.finds(part))
    }

    /// The first load arrives: whether the parts that are read find their lines.
    fn arrive(&mut self) -> bool {
        let Some((load, parts)) = self.loads.arrive() else { return true };
        self.card[load.card as usize] = Some(load.line);
        parts.iter().all(|&(_, part)| self.finds(part))
    }
}

/// Hits at each place, misses of each line at each place.
const EVENTS: u8 = PLACES as u8 * (1 + LINES);

fn state<S: Source>(s: &mut S) -> Result<State, Stop> {
    let mut card = [None; PLACES];
    for place in &mut card {
        let line = s.value("line on the card (3: none)", 0..=LINES, &BYTES[..4]);
        *place = (line < LINES).then_some(LineAddr(line.into()));
    }
    assume!(card[0].is_none() || card[0] != card[1]);
    let arrived = flag(s, "loads have arrived");
    let loads = Loads { in_flight: VecDeque::new(), arrived: arrived.into(), waiting: Vec::new() };
    let mut state = State { card, directory: card, loads, pending: VecDeque::new() };
    let parts = usize::from(s.value("parts", 0..=PARTS as u8, &BYTES[..PARTS + 1]));
    let acted = usize::from(s.value("parts acted upon", 0..=PARTS as u8, &BYTES[..PARTS + 1]));
    assume!(acted <= parts);
    for number in 0..parts {
        let event = s.value("hit or miss", 0..=EVENTS - 1, &BYTES[..EVENTS as usize]);
        let Some(mut part) = state.part(event) else { return Err(Stop::Vacuous) };
        if part.id.is_none() && arrived {
            // Its load has arrived since it was taken.
            part.id = Some(LoadId(0));
        }
        state.take(part);
        let waits = part.id.is_some_and(|id| id.0 >= state.loads.arrived);
        if number < acted
            && let Some(part) = state.pending.pop_back()
            && waits
            && let Some(id) = part.id
        {
            state.loads.waiting.push((id, part));
        }
    }
    Ok(state)
}

theorems! {
    /// Each part finds its line on the card when it is read, at once or when its load arrives: no place is read before it is filled or after it is overwritten, whatever the order of tags and loads.
    #["CH-15", not_for_kani "queues of any length, which are allocated", covers ["a part is read at once", "a part waits", "a load arrives and is read", "a line in flight to two places", "a place to which two loads go"]]
    fn parts_read_their_lines_from_the_card(s) {
        let before = state(s)?;
        let mut after = before.clone();
        let loads = &before.loads.in_flight;
        let twice = |same: fn(&Load, &Load) -> bool| loads.iter().enumerate().any(|(n, load)| loads.iter().skip(n + 1).any(|other| same(load, other)));
        cover!(s, "a line in flight to two places", twice(|load, other| load.line == other.line && load.card != other.card));
        cover!(s, "a place to which two loads go", twice(|load, other| load.card == other.card));
        if flag(s, "a load arrives, not a tag") {
            // The bus carries a load after the chip has acted on its tag.
            let id = LoadId(before.loads.arrived);
            assume!(before.loads.waiting.iter().any(|&(other, part)| other == id && part.missed));
            check!(after.arrive(), "{before:?}: a part that waited reads another line");
            cover!(s, "a load arrives and is read", true);
        } else {
            assume!(!before.pending.is_empty());
            check!(after.act(), "{before:?}: the first part reads another line at once");
            let waits = after.loads.waiting.len() > before.loads.waiting.len();
            cover!(s, "a part is read at once", !waits);
            cover!(s, "a part waits", waits);
        }
        check!(after.is_legal(), "{before:?}: illegal {after:?}");
    }

    /// A part whose line is missed has it loaded, once and to its place, also while the line is in flight to another place; a part that hits has nothing loaded, and its load is the one that is the last to write to its place, if that is in flight.
    #["CH-14", not_for_kani "queues of any length, which are allocated", covers ["a miss of a line in flight", "a hit in flight", "a hit that is there"]]
    fn each_miss_is_a_load_and_each_hit_knows_its_load(s) {
        let before = state(s)?;
        let event = s.value("hit or miss", 0..=EVENTS - 1, &BYTES[..EVENTS as usize]);
        let Some(part) = before.part(event) else { return Err(Stop::Vacuous) };
        let mut after = before.clone();
        let id = after.loads.request(part.load, part.missed);
        check_eq!(id, part.id, "{before:?} takes {part:?}");
        let mut expected = before.clone();
        expected.take(part);
        check_eq!(after.loads, expected.loads, "{before:?} takes {part:?}");
        check!(expected.is_legal(), "{before:?} takes {part:?}: illegal {expected:?}");
        let is_in_flight = before.loads.in_flight.iter().any(|load| load.line == part.load.line);
        cover!(s, "a miss of a line in flight", part.missed && is_in_flight);
        cover!(s, "a hit in flight", !part.missed && is_in_flight);
        cover!(s, "a hit that is there", !part.missed && !is_in_flight);
    }
}
