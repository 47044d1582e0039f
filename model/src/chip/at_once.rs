//! Packets that leave in the caches what they read, and take no time.

use super::{Cache, Chip, Found, Observer, Traffic};
use crate::program::{Operation, Programs};
use crate::sdram::{Direction, Span};
use crate::set::Outcome;
use crate::tags::Place;
use crate::units::{HostAddr, LineAddr};

impl<O: Observer> Chip<'_, O> {
    /// The caches after pictures whose packets are worked on one after the other (CH-19).
    pub(super) fn warm(&mut self, before: &[Programs]) {
        for operation in before.iter().flat_map(|programs| &programs.packets).flatten() {
            self.read_at_once(operation, None);
        }
    }

    /// Reads what an operation reads, without time. The observer is told if it is that of a packet.
    pub(super) fn read_at_once(&mut self, operation: &Operation, packet: Option<u32>) {
        if operation.bytes == 0 {
            return;
        }
        let cache = operation.port as usize;
        let (first, last) = self.l1[cache].lines_of(operation);
        for line in first..=last {
            let outcome = self.l1[cache].directory.access(LineAddr(line));
            let missed = matches!(outcome, Outcome::Miss { .. });
            if let Some(packet) = packet {
                let found = if missed { Found::Missing } else { Found::Resident };
                self.observer.look_up(packet, Cache::L1(cache), found);
            }
            if missed {
                for (addr, bytes) in self.parts(cache, line) {
                    self.locate_at_once(addr, bytes, packet);
                }
            }
        }
    }

    /// Looks up the tag of a part, and moves it and its metadata, without time.
    fn locate_at_once(&mut self, addr: u32, bytes: u32, packet: Option<u32>) {
        let mut moves = std::mem::take(&mut self.moves);
        let Place { card, missed } = self.tags.locate(HostAddr(addr), &mut moves);
        if let Some(packet) = packet {
            let (sdram, now) = (self.config.sdram, Span { begin: self.now, end: self.now });
            let found = if missed { Found::Missing } else { Found::Resident };
            self.observer.look_up(packet, Cache::L2, found);
            for step in &moves {
                let traffic = match step.direction {
                    Direction::Read => Traffic::MetadataRead,
                    Direction::Write => Traffic::MetadataWriteBack,
                };
                let granule = u64::from(self.config.metadata_cache.granule.max(sdram.beat_bytes));
                self.observer.transfer(packet, traffic, now, granule);
            }
            self.observer.transfer(packet, Traffic::L1Fill, now, sdram.moved(card, bytes.into()));
        }
        moves.clear();
        self.moves = moves;
    }
}
