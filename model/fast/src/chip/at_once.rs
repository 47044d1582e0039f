//! Packets that leave in the caches what they read, and take no time.

use super::tags::{Tags, WhereOnCard};
use super::{Cache, Chip, ChipObserver, Found, Traffic};
use crate::first_level;
use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{ChipConfig, ConfigError, Direction, Load, Operation, Programs, Span};
use saarcor_model::vm::{FirstLevel, HostAddr, LineAddr, Outcome};

/// The first-level caches and the virtual memory of a chip on which nothing is in work.
#[derive(Clone)]
pub struct Caches {
    pub(super) config: ChipConfig,
    pub(super) l1: [FirstLevel<CHIP_CACHE_WAYS, ()>; 4],
    pub(super) tags: Box<dyn Tags>,
}

impl Caches {
    /// Those of the chip `config`, empty, for a scene whose `triangles` begin there (L1-1).
    ///
    /// # Errors
    /// If the configuration makes no chip.
    pub fn empty(triangles: HostAddr, config: &ChipConfig) -> Result<Self, ConfigError> {
        config.check()?;
        let nothing = Programs { packets: Vec::new(), triangles };
        let Chip { l1, tags, .. } = Chip::new(&nothing, &[], config, &mut ());
        Ok(Self { config: *config, l1: l1.map(|l1| l1.cache), tags })
    }

    /// Those of the chip `config` after these pictures ([`Caches::then`]).
    ///
    /// # Errors
    /// If the configuration makes no chip.
    pub fn after<'a>(
        before: impl IntoIterator<Item = &'a Programs>,
        triangles: HostAddr,
        config: &ChipConfig,
    ) -> Result<Self, ConfigError> {
        Ok(before.into_iter().fold(Self::empty(triangles, config)?, Self::then))
    }

    /// What they hold after a picture whose packets are worked on one after the other, without time (CH-19).
    #[must_use]
    pub fn then(self, picture: &Programs) -> Self {
        self.then_observed(picture, &mut ())
    }

    /// [`Caches::then`]; `observer` sees what the picture writes to the card.
    #[must_use]
    pub fn then_observed(self, picture: &Programs, observer: &mut impl ChipObserver) -> Self {
        let config = self.config;
        let nothing = Programs { packets: Vec::new(), triangles: picture.triangles };
        let mut chip = Chip::new(&nothing, &[], &config, observer).with(self);
        picture.in_order().for_each(|operation| chip.read_at_once(operation, None));
        Self { config, l1: chip.l1.map(|l1| l1.cache), tags: chip.tags }
    }

    /// The chip's configuration.
    #[must_use]
    pub fn config(&self) -> &ChipConfig {
        &self.config
    }

    /// The same virtual memory behind first-level caches that hold nothing.
    #[must_use]
    pub fn with_cold_first_level(mut self) -> Self {
        self.l1.iter_mut().for_each(|l1| l1.invalidate(HostAddr(0), 1 << 32));
        self
    }
}

impl<O: ChipObserver> Chip<'_, O> {
    /// Reads what an operation reads, without time. The observer sees it if it is that of a packet.
    pub(super) fn read_at_once(&mut self, operation: &Operation, packet: Option<u32>) {
        if operation.bytes == 0 {
            return;
        }
        let cache = operation.unit as usize;
        let (first, last) = self.l1[cache].lines_of(operation);
        for line in first..=last {
            let outcome = first_level::access(&mut self.l1[cache].cache, LineAddr(line));
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
        let WhereOnCard { card, missed } = self.tags.locate(HostAddr(addr), &mut moves);
        if missed {
            let geometry = self.config.cache.geometry;
            let begin = card - u64::from(geometry.offset_of(HostAddr(addr)));
            let load = Load { line: geometry.line_of(HostAddr(addr)), card: begin };
            self.observer.line_is_written(self.now, load);
        }
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
