//! The bus manager in time: parts of first-level lines, their tags, and lines from the host.

use super::first_level::{LineInFlight, LinePart};
use super::observer::{Cache, ChipObserver, Found, Traffic, bytes_of};
use super::tags::WhereOnCard;
use super::{Chip, round_robin};
use saarcor_model::time::{Direction, Load, LoadId, Span, Stall, Version};
use saarcor_model::vm::{HostAddr, LineAddr};
use std::ops::Range;

/// A part whose tag is known in cycle `ready`.
pub(super) struct PendingTag {
    pub(super) ready: u64,
    part: LinePart,
    card: u64,
    /// Whether its line was missed, and the load that brings it, if that was in flight.
    missed: bool,
    load: Option<LoadId>,
}

/// A load in flight, there in cycle `there`.
pub(super) struct LoadInFlight {
    load: Load,
    pub(super) there: u64,
    /// The packet that missed it.
    packet: u32,
}

impl<O: ChipObserver> Chip<'_, O> {
    /// Address and size of the parts of a first-level line: one for each line of the virtual memory
    /// that it meets, and one in all without (CH-12).
    pub(super) fn parts(&self, cache: usize, line: u32) -> impl Iterator<Item = (u32, u32)> + use<O> {
        let Range { start: mut addr, end } = self.l1[cache].cache.bytes_of(LineAddr(line));
        let vm_line = match self.config.version {
            Version::None => 1 << 32,
            Version::A | Version::B => self.config.cache.geometry.line().0,
        };
        std::iter::from_fn(move || {
            let here = end.min((addr / vm_line + 1) * vm_line).checked_sub(addr).filter(|&here| here > 0)?;
            let part = (addr as u32, here as u32);
            addr += here;
            Some(part)
        })
    }

    /// Phase 3: a line arrives from the host, is written to the card, and then read by the parts
    /// that wait for it, in their order (CH-15).
    pub(super) fn line_from_host(&mut self) {
        while self.loading.front().is_some_and(|loading| loading.there <= self.now)
            && let Some(LoadInFlight { load, packet, .. }) = self.loading.pop_front()
        {
            let bytes = self.config.cache.geometry.line().0;
            self.transfer(packet, Traffic::VmFill, load.card, bytes);
            self.observer.line_is_written(self.now, load);
            let arrived = LoadId(self.arrived);
            self.arrived += 1;
            let mut place = 0;
            while place < self.waiting.len() {
                if self.waiting[place].0 != arrived {
                    place += 1;
                    continue;
                }
                let (_, part, card) = self.waiting.remove(place);
                let way = self.in_flight(part);
                way.from_host -= 1;
                if way.from_host == 0 {
                    self.blame(part, Stall::Memory);
                }
                self.read_part(part, card);
            }
        }
    }

    /// Phase 4: tags are known, in the order of the look-ups (CH-13, CH-14).
    pub(super) fn tags_found(&mut self) {
        while self.tagged.front().is_some_and(|tagged| tagged.ready <= self.now)
            && let Some(PendingTag { part, card, missed, load, .. }) = self.tagged.pop_front()
        {
            let Some(load) = load.filter(|load| load.0 >= self.arrived) else {
                self.read_part(part, card);
                continue;
            };
            if missed {
                let bytes = self.config.cache.geometry.line().0;
                let span = self.pci.load(self.now, bytes);
                self.loading[(load.0 - self.arrived) as usize].there = span.end;
                *bytes_of(&mut self.report, Traffic::Pci) += bytes;
                self.report.pci_busy += span.end - span.begin;
                self.observer.transfer(part.packet, Traffic::Pci, span, bytes);
            }
            self.waiting.push((load, part, card));
            let way = self.in_flight(part);
            way.from_host += 1;
            if way.from_host == 1 {
                self.blame(part, Stall::Host);
            }
        }
    }

    /// Phase 8: the bus manager takes one part and looks up its tag (CH-12, CH-13).
    pub(super) fn look_up_tag(&mut self) {
        if self.missed == 0 {
            return;
        }
        self.last_cache = round_robin(self.missed, self.last_cache);
        let parts = &mut self.l1[self.last_cache as usize].parts;
        let Some(part) = parts.pop_front() else { return };
        if parts.is_empty() {
            self.missed &= !(1 << self.last_cache);
        }
        let mut moves = std::mem::take(&mut self.moves);
        let WhereOnCard { card, missed } = self.tags.locate(HostAddr(part.addr), &mut moves);
        let mut ready = self.now;
        // Metadata lie behind the lines (CH-17).
        let begin = self.config.cache.geometry.memory().0;
        let granule = u64::from(self.config.metadata_cache.granule);
        for step in moves.drain(..) {
            let addr = begin + u64::from(step.granule) * granule;
            match step.direction {
                Direction::Read => {
                    let span = self.transfer(part.packet, Traffic::MetadataRead, addr, granule);
                    ready = ready.max(span.end);
                }
                Direction::Write => {
                    self.transfer(part.packet, Traffic::MetadataWriteBack, addr, granule);
                }
            }
        }
        self.moves = moves;
        let line = self.config.cache.geometry.line_of(HostAddr(part.addr));
        if self.config.version != Version::None {
            ready += u64::from(self.config.tag_latency);
        }
        self.tags_known = self.tags_known.max(ready);
        let latest = if missed {
            let begin = card - u64::from(self.config.cache.geometry.offset_of(HostAddr(part.addr)));
            let load = Load { line, card: begin };
            self.loading.push_back(LoadInFlight { load, there: u64::MAX, packet: part.packet });
            Some(self.loading.len() - 1)
        } else {
            self.loading.iter().rposition(|loading| loading.load.line == line)
        };
        let load = latest.map(|place| LoadId(self.arrived + place as u64));
        let found = match (missed, load) {
            (true, _) => Found::Missing,
            (false, Some(_)) => Found::InFlight,
            (false, None) => Found::Resident,
        };
        self.report.l2.accesses += 1;
        self.report.l2.misses += u64::from(found == Found::Missing);
        self.report.l2.merged += u64::from(found == Found::InFlight);
        self.observer.look_up(part.packet, Cache::L2, found);
        // It is acted upon in a later cycle, however short the latency.
        let ready = self.tags_known.max(self.now + 1);
        self.tagged.push_back(PendingTag { ready, part, card, missed, load });
        self.arrival = self.arrival.min(ready);
    }

    /// Moves bytes between the chip and the on-board memory, for a packet.
    fn transfer(&mut self, packet: u32, traffic: Traffic, card: u64, bytes: u64) -> Span {
        let direction = match traffic {
            Traffic::VmFill | Traffic::MetadataWriteBack => Direction::Write,
            _ => Direction::Read,
        };
        self.observer.request(self.now, card, bytes, direction);
        self.observe_commands();
        let span = self.sdram.transfer(self.now, card, bytes, direction);
        let moved = self.config.sdram.moved(card, bytes);
        *bytes_of(&mut self.report, traffic) += moved;
        self.observer.transfer(packet, traffic, span, moved);
        span
    }

    /// The commands that the memory chips were given before this cycle.
    pub(super) fn observe_commands(&mut self) {
        while let Some((clock, command)) = self.sdram.take_command(self.now) {
            self.observer.command(clock, command);
        }
    }

    /// Reads a part of a first-level line; with the last one, the line returns (CH-16).
    fn read_part(&mut self, part: LinePart, card: u64) {
        self.observer.part_is_read(self.now, HostAddr(part.addr), part.bytes.into(), card);
        let span = self.transfer(part.packet, Traffic::L1Fill, card, part.bytes.into());
        let way = self.in_flight(part);
        way.parts -= 1;
        if way.parts == 0 {
            let there = span.end + u64::from(self.config.return_latency);
            self.returning.push_back((there, part.cache, part.register));
        }
    }

    pub(super) fn in_flight(&mut self, part: LinePart) -> &mut LineInFlight {
        &mut self.l1[usize::from(part.cache)].in_flight[usize::from(part.register)]
    }
}
