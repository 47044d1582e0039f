//! The bus manager in time: parts of first-level lines, their tags, and lines from the host.

use super::Chip;
use super::first_level::{LineInFlight, LinePart};
use super::loads::{CardAccess, Load, LoadId};
use super::tags::Located;
use crate::time::config::Version;
use crate::time::sdram::{Direction, TransferId};
use crate::vm::{HostAddr, LineAddr};

/// A part whose tag is looked up.
#[derive(Clone, Debug)]
pub(super) struct PendingTag {
    /// The cycle in which the bus manager took the part.
    asked: u64,
    part: PlacedPart,
    /// Whether its line was missed, and the load that brings it, if that was in flight.
    missed: bool,
    load: Option<LoadId>,
    metadata_reads: Vec<TransferId>,
}

/// A part, and the load that brings its line to its place.
#[derive(Clone, Copy, Debug)]
pub struct PlacedPart {
    /// The part.
    pub part: LinePart,
    place: Load,
}

impl Chip<'_> {
    /// The parts of a first-level line (CH-12).
    pub(super) fn parts_of(&self, cache: usize, line: LineAddr) -> Vec<LinePart> {
        let all = self.first_level[cache].cache.bytes_of(line);
        let part = |begin: u64, end: u64| {
            let (addr, bytes) = (HostAddr(begin as u32), end - begin);
            LinePart { cache, line, addr, bytes }
        };
        if self.config.version == Version::None {
            return vec![part(all.start, all.end)];
        }
        let bytes = self.config.cache.geometry.line().0;
        let lines = self.config.cache.lines_of(HostAddr(all.start as u32), all.end - all.start);
        lines.map(|line| part(all.start.max(line * bytes), all.end.min((line + 1) * bytes))).collect()
    }

    /// Takes those lines of a first-level cache out of flight whose parts have all arrived (CH-16).
    pub(super) fn take_arrived_lines(&mut self, cache: usize) -> Vec<LineInFlight> {
        let latency = u64::from(self.config.return_latency);
        let has_arrived = |line: &LineInFlight| {
            line.unread == 0 && line.reads.iter().all(|&read| self.sdram.is_over(read, latency, self.now))
        };
        let in_flight = std::mem::take(&mut self.first_level[cache].in_flight);
        let (arrived, others) = in_flight.into_iter().partition(has_arrived);
        self.first_level[cache].in_flight = others;
        arrived
    }

    /// A line from the host is written to the card, and then read by the parts that wait for it (CH-15).
    pub(super) fn phase_3_a_line_arrives_from_the_host(&mut self) {
        if !self.pci.has_arrived(self.now) {
            return;
        }
        let Some((load, parts)) = self.loads.arrive() else { return };
        let bytes = self.config.cache.geometry.line().0;
        self.report.vm_fill_bytes += self.config.sdram.moved(load.card, bytes);
        self.sdram.request(self.now, load.card, bytes, Direction::Write);
        self.card.push(CardAccess::Write(load));
        for (_, part) in parts {
            self.read(part);
        }
    }

    /// Tags that are known are acted upon, in the order of the parts (CH-13, CH-14).
    pub(super) fn phase_4_tags_are_acted_upon(&mut self) {
        while self.pending.front().is_some_and(|tag| self.is_known(tag))
            && let Some(tag) = self.pending.pop_front()
        {
            if tag.missed {
                self.pci.request(self.config.cache.geometry.line().0);
            }
            if let Some(part) = self.loads.act(tag.load, tag.part) {
                self.read(part);
            }
        }
        if let Some(transfer) = self.pci.start(self.now) {
            self.report.pci_bytes += self.config.cache.geometry.line().0;
            self.report.pci_busy += transfer.end - transfer.begin;
        }
    }

    /// Whether a tag has come, a latency after the look-up and after its metadata (CH-13).
    fn is_known(&self, tag: &PendingTag) -> bool {
        let latency = match self.config.version {
            Version::None => 0,
            Version::A | Version::B => u64::from(self.config.tag_latency),
        };
        let is_over = |&read: &TransferId| self.sdram.is_over(read, latency, self.now);
        tag.asked + latency <= self.now && tag.metadata_reads.iter().all(is_over)
    }

    /// The bus manager takes a part from the first-level caches in turn (CH-12), and looks its tag up
    /// (CH-13, CH-17).
    pub(super) fn phase_8_the_bus_manager_takes_a_part(&mut self) {
        let asking: Vec<usize> = (0..4).filter(|&cache| !self.first_level[cache].parts.is_empty()).collect();
        if asking.is_empty() {
            return;
        }
        let cache = self.caches.next(&asking);
        let Some(part) = self.first_level[cache].parts.pop_front() else { return };
        let Located { load: place, missed, metadata } = self.tags.locate(part.addr);
        let metadata_reads = self.move_metadata(&metadata);
        let load = self.loads.request(place, missed);
        self.report.l2.accesses += 1;
        self.report.l2.merged += u64::from(!missed && load.is_some());
        self.report.l2.misses += u64::from(missed);
        let part = PlacedPart { part, place };
        self.pending.push_back(PendingTag { asked: self.now, part, missed, load, metadata_reads });
    }

    /// Moves granules of metadata, which lie behind the lines (CH-17); the reads among these transfers.
    fn move_metadata(&mut self, metadata: &[(LineAddr, Direction)]) -> Vec<TransferId> {
        let begin = self.config.cache.geometry.memory().0;
        let bytes = u64::from(self.config.metadata_cache.granule);
        let mut reads = Vec::new();
        for &(granule, direction) in metadata {
            let addr = begin + u64::from(granule.0) * bytes;
            let transfer = self.sdram.request(self.now, addr, bytes, direction);
            let moved = self.config.sdram.moved(addr, bytes);
            match direction {
                Direction::Read => {
                    reads.push(transfer);
                    self.report.metadata_read_bytes += moved;
                }
                Direction::Write => self.report.metadata_write_back_bytes += moved,
            }
        }
        reads
    }

    /// Reads a part of a first-level line from the on-board memory.
    fn read(&mut self, PlacedPart { part, place }: PlacedPart) {
        let card = place.card + u64::from(self.config.cache.geometry.offset_of(part.addr));
        self.card.push(CardAccess::Read { part, card });
        self.report.l1_fill_bytes += self.config.sdram.moved(card, part.bytes);
        let read = self.sdram.request(self.now, card, part.bytes, Direction::Read);
        self.first_level[part.cache].part_is_read(part.line, read);
    }
}
