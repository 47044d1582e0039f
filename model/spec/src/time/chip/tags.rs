//! The tags of the bus manager: where a line lies on the card, and which metadata that moves.

use super::loads::Load;
use crate::time::config::{ChipConfig, Version};
use crate::time::sdram::Direction;
use crate::time::standard::CHIP_CACHE_WAYS;
use crate::vm::{
    CachedMetadata, Directory, Geometry, HostAddr, LineAddr, Metadata, MetadataObserver, OnChip, Outcome,
    Policy, WriteBack,
};

/// Where a line lies on the card, and what had to be done to know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Located {
    /// The load that brings it to its place.
    pub(super) load: Load,
    /// Whether it is not there and has to be loaded.
    pub(super) missed: bool,
    /// Granules of metadata that move, in order.
    pub(super) metadata: Vec<(LineAddr, Direction)>,
}

/// The tags of a version of §3.
pub(super) trait Tags {
    /// Looks up the line of `addr`: one step of the directory (VM-6).
    fn locate(&mut self, addr: HostAddr) -> Located;
}

/// The tags of an empty cache, in the version that `config` names.
pub(super) fn tags(config: &ChipConfig) -> Box<dyn Tags> {
    match config.cache.geometry.ways() {
        1 => of_version::<1>(config),
        2 => of_version::<2>(config),
        4 => of_version::<4>(config),
        8 => of_version::<8>(config),
        _ => of_version::<16>(config),
    }
}

fn of_version<const WAYS: usize>(config: &ChipConfig) -> Box<dyn Tags> {
    match config.version {
        Version::None => Box::new(NoTags(config.cache.geometry)),
        Version::A => Box::new(Directory::<WAYS>::new(config.cache)),
        Version::B => match config.metadata_cache.granule {
            8 => version_b::<WAYS, 8>(config),
            16 => version_b::<WAYS, 16>(config),
            32 => version_b::<WAYS, 32>(config),
            64 => version_b::<WAYS, 64>(config),
            128 => version_b::<WAYS, 128>(config),
            256 => version_b::<WAYS, 256>(config),
            512 => version_b::<WAYS, 512>(config),
            1024 => version_b::<WAYS, 1024>(config),
            2048 => version_b::<WAYS, 2048>(config),
            _ => version_b::<WAYS, 4096>(config),
        },
    }
}

fn version_b<const WAYS: usize, const GRANULE: usize>(config: &ChipConfig) -> Box<dyn Tags> {
    let sets = config.metadata_cache.sets() as usize;
    let metadata = CachedMetadata::<WAYS, CHIP_CACHE_WAYS, GRANULE, Moves>::observed(
        &config.cache,
        sets,
        Policy::Lru,
        Moves::default(),
    );
    Box::new(Directory::over(config.cache, metadata))
}

/// Without virtual memory, bytes lie on the card at their host addresses (Assumed).
struct NoTags(Geometry);

impl Tags for NoTags {
    fn locate(&mut self, addr: HostAddr) -> Located {
        let line = self.0.line_of(addr);
        let load = Load { line, card: self.0.first_byte(line).0.into() };
        Located { load, missed: false, metadata: Vec::new() }
    }
}

/// Where a version keeps its metadata, and which of it the last look-up moved.
trait MetadataInTime<const WAYS: usize>: Metadata<WAYS> {
    fn take_moves(&mut self) -> Vec<(LineAddr, Direction)>;
}

impl<const WAYS: usize> MetadataInTime<WAYS> for OnChip<WAYS> {
    fn take_moves(&mut self) -> Vec<(LineAddr, Direction)> {
        Vec::new()
    }
}

impl<const WAYS: usize, const GRANULE: usize> MetadataInTime<WAYS>
    for CachedMetadata<WAYS, CHIP_CACHE_WAYS, GRANULE, Moves>
{
    fn take_moves(&mut self) -> Vec<(LineAddr, Direction)> {
        std::mem::take(&mut self.observer.0)
    }
}

impl<const WAYS: usize, M: MetadataInTime<WAYS>> Tags for Directory<WAYS, M> {
    fn locate(&mut self, addr: HostAddr) -> Located {
        let (config, geometry) = (self.config, self.config.geometry);
        let line = geometry.line_of(addr);
        let outcome = self.access(line);
        let card = geometry.card_addr(config.set_of(line), outcome.way());
        Located {
            load: Load { line, card: card.0.into() },
            missed: matches!(outcome, Outcome::Miss { .. }),
            metadata: self.metadata.take_moves(),
        }
    }
}

/// The granules that go through the metadata cache: each that is not in it is read, and the one that
/// it evicts is written back if it changed (VM-13, CH-17).
#[derive(Clone, Debug, Default)]
struct Moves(Vec<(LineAddr, Direction)>);

impl<Contents> MetadataObserver<Contents> for Moves {
    fn granule_used(&mut self, granule: LineAddr, outcome: Outcome, write_back: Option<WriteBack<Contents>>) {
        if let Outcome::Miss { .. } = outcome {
            self.0.push((granule, Direction::Read));
        }
        if let Some(write_back) = write_back {
            self.0.push((write_back.line, Direction::Write));
        }
    }

    /// Metadata that the chip wrote is never corrupt.
    fn corrupt(&mut self) {}
}
