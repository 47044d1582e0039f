//! The bus manager's tags in time: the decisions of the virtual memory, and the metadata that they
//! move, without the bytes.

use crate::directory;
use crate::version_b::MetadataDecisions;
use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{ChipConfig, Direction, Version};
use saarcor_model::vm::{
    Directory, HostAddr, LineAddr, Metadata, MetadataObserver, Outcome, Policy, WriteBack,
};

/// Where bytes lie on the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WhereOnCard {
    /// Address of the first of them.
    pub card: u64,
    /// Whether their line has to be loaded first.
    pub missed: bool,
}

/// A granule of metadata that moves between the chip and the on-board memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MetadataMove {
    /// Number of the granule.
    pub granule: u32,
    /// Which way.
    pub direction: Direction,
}

/// The tags of a version, whatever its number of ways.
pub trait Tags: Send {
    /// Finds the bytes at `addr`, which lie within one line; says in `moves` which metadata that
    /// moves, in order.
    fn locate(&mut self, addr: HostAddr, moves: &mut Vec<MetadataMove>) -> WhereOnCard;

    /// The same tags, once more.
    fn copied(&self) -> Box<dyn Tags>;
}

impl Clone for Box<dyn Tags> {
    fn clone(&self) -> Self {
        self.as_ref().copied()
    }
}

/// The tags that `config` asks for, of an empty cache.
#[must_use]
pub fn tags(config: &ChipConfig) -> Box<dyn Tags> {
    match config.cache.geometry.ways() {
        _ if config.version == Version::None => Box::new(NoTags),
        1 => of_ways::<1>(config),
        2 => of_ways::<2>(config),
        4 => of_ways::<4>(config),
        8 => of_ways::<8>(config),
        _ => of_ways::<16>(config),
    }
}

fn of_ways<const WAYS: usize>(config: &ChipConfig) -> Box<dyn Tags> {
    if config.version == Version::A {
        Box::new(Directory::<WAYS>::new(config.cache))
    } else {
        let metadata = MetadataDecisions::<WAYS, CHIP_CACHE_WAYS, _>::new(
            &config.cache,
            config.metadata_cache.sets() as usize,
            config.metadata_cache.granule as usize,
            Policy::Lru,
            MetadataMoves(Vec::new()),
        );
        Box::new(Directory::over(config.cache, metadata))
    }
}

/// Without virtual memory, bytes lie on the card where they lie in the host (Assumed).
#[derive(Clone)]
struct NoTags;

impl Tags for NoTags {
    fn locate(&mut self, addr: HostAddr, _: &mut Vec<MetadataMove>) -> WhereOnCard {
        WhereOnCard { card: addr.0.into(), missed: false }
    }

    fn copied(&self) -> Box<dyn Tags> {
        Box::new(self.clone())
    }
}

impl<const WAYS: usize> Tags for Directory<WAYS> {
    fn locate(&mut self, addr: HostAddr, _: &mut Vec<MetadataMove>) -> WhereOnCard {
        place(self, addr)
    }

    fn copied(&self) -> Box<dyn Tags> {
        Box::new(self.clone())
    }
}

/// The metadata that moves for an access, in order.
#[derive(Clone)]
struct MetadataMoves(Vec<MetadataMove>);

impl MetadataObserver<()> for MetadataMoves {
    fn granule_used(&mut self, granule: LineAddr, outcome: Outcome, write_back: Option<WriteBack<()>>) {
        if let Outcome::Miss { .. } = outcome {
            self.0.push(MetadataMove { granule: granule.0, direction: Direction::Read });
        }
        if let Some(write_back) = write_back {
            self.0.push(MetadataMove { granule: write_back.line.0, direction: Direction::Write });
        }
    }

    fn corrupt(&mut self) {}
}

impl<const WAYS: usize> Tags for Directory<WAYS, MetadataDecisions<WAYS, CHIP_CACHE_WAYS, MetadataMoves>> {
    fn locate(&mut self, addr: HostAddr, moves: &mut Vec<MetadataMove>) -> WhereOnCard {
        let place = place(self, addr);
        moves.append(&mut self.metadata.observer.0);
        place
    }

    fn copied(&self) -> Box<dyn Tags> {
        Box::new(self.clone())
    }
}

fn place<const WAYS: usize, M: Metadata<WAYS>>(
    directory: &mut Directory<WAYS, M>,
    addr: HostAddr,
) -> WhereOnCard {
    let config = directory.config;
    let line = config.geometry.line_of(addr);
    let outcome = directory::access(directory, line);
    let begin = config.geometry.card_addr(config.set_of(line), outcome.way());
    let card = u64::from(begin.0) + u64::from(config.geometry.offset_of(addr));
    WhereOnCard { card, missed: matches!(outcome, Outcome::Miss { .. }) }
}
