//! The bus manager's tags in time: the decisions of the virtual memory, and the metadata that they
//! move, without the bytes.

use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{ChipConfig, Direction, Version};
use saarcor_model::vm::{
    DataSet, Directory, ENTRY_BYTES, Hash, HostAddr, LineAddr, Metadata, OnChip, Outcome, Policy, Set,
    SetIndex,
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
        Box::new(Directory::over(config.cache, MovingMetadata::<WAYS>::new(config)))
    }
}

/// Without virtual memory, bytes lie on the card where they lie in the host (Assumed).
struct NoTags;

impl Tags for NoTags {
    fn locate(&mut self, addr: HostAddr, _: &mut Vec<MetadataMove>) -> WhereOnCard {
        WhereOnCard { card: addr.0.into(), missed: false }
    }
}

impl<const WAYS: usize> Tags for Directory<WAYS> {
    fn locate(&mut self, addr: HostAddr, _: &mut Vec<MetadataMove>) -> WhereOnCard {
        place(self, addr)
    }
}

impl<const WAYS: usize> Tags for Directory<WAYS, MovingMetadata<WAYS>> {
    fn locate(&mut self, addr: HostAddr, moves: &mut Vec<MetadataMove>) -> WhereOnCard {
        let place = place(self, addr);
        moves.append(&mut self.metadata.moves);
        place
    }
}

fn place<const WAYS: usize, M: Metadata<WAYS>>(
    directory: &mut Directory<WAYS, M>,
    addr: HostAddr,
) -> WhereOnCard {
    let config = directory.config;
    let line = config.geometry.line_of(addr);
    let outcome = directory.access(line);
    let begin = config.geometry.card_addr(config.set_of(line), outcome.way());
    let card = u64::from(begin.0) + u64::from(config.geometry.offset_of(addr));
    WhereOnCard { card, missed: matches!(outcome, Outcome::Miss { .. }) }
}

/// The metadata of version B, which lists what moves. Twin of `saarcor_model::vm::CachedMetadata`: it
/// keeps no bytes (VM-13).
#[derive(Clone, Debug)]
pub struct MovingMetadata<const WAYS: usize> {
    sets: OnChip<WAYS>,
    /// Which granules the metadata cache holds, and which of them have changed.
    cache: Vec<DataSet<CHIP_CACHE_WAYS, ()>>,
    granule: usize,
    moves: Vec<MetadataMove>,
}

impl<const WAYS: usize> MovingMetadata<WAYS> {
    /// Bytes of metadata a set of lines.
    const SET_BYTES: usize = WAYS * ENTRY_BYTES;

    /// The metadata of an empty cache of lines, behind an empty metadata cache.
    #[must_use]
    pub fn new(config: &ChipConfig) -> Self {
        let cache = vec![DataSet::empty(Policy::Lru, ()); config.metadata_cache.sets() as usize];
        let granule = config.metadata_cache.granule as usize;
        Self {
            sets: OnChip::new(config.cache.geometry.sets(), config.cache.policy),
            cache,
            granule,
            moves: Vec::new(),
        }
    }

    /// The bytes of metadata of the set `index`, as a range of all metadata, granule by granule.
    fn granules(&self, index: SetIndex) -> impl Iterator<Item = (u32, std::ops::Range<usize>)> + use<WAYS> {
        let (begin, granule) = (index.0 as usize * Self::SET_BYTES, self.granule);
        let end = begin + Self::SET_BYTES;
        (begin / granule..=(end - 1) / granule).map(move |number| {
            let here = begin.max(number * granule)..end.min((number + 1) * granule);
            (number as u32, here.start - begin..here.end - begin)
        })
    }

    fn use_granule(&mut self, granule: u32, change: bool) {
        let index = Hash::Low.set_of(LineAddr(granule), self.cache.len().ilog2());
        let cached = &mut self.cache[index.0 as usize];
        let (next, outcome, write_back) = cached.access(LineAddr(granule), Policy::Lru, || ());
        *cached = if change { next.write(outcome.way(), ()) } else { next };
        if let Outcome::Miss { .. } = outcome {
            self.moves.push(MetadataMove { granule, direction: Direction::Read });
        }
        if let Some(write_back) = write_back {
            self.moves.push(MetadataMove { granule: write_back.line.0, direction: Direction::Write });
        }
    }
}

impl<const WAYS: usize> Metadata<WAYS> for MovingMetadata<WAYS> {
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        for (granule, _) in self.granules(index) {
            self.use_granule(granule, false);
        }
        self.sets.load(index)
    }

    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        let (old, new) = (self.sets.load(index).to_entries(), set.to_entries());
        for (granule, here) in self.granules(index) {
            if old.as_flattened()[here.clone()] != new.as_flattened()[here] {
                self.use_granule(granule, true);
            }
        }
        self.sets.store(index, set);
    }

    fn clear(&mut self) {
        self.sets.clear();
        self.cache.fill(DataSet::empty(Policy::Lru, ()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::time::MetadataCacheConfig;
    use saarcor_model::vm::Bytes;
    use saarcor_model::vm::CacheConfig;
    use saarcor_model::vm::CachedMetadata;
    use saarcor_model::vm::Geometry;

    fn moves_as_version_b<const WAYS: usize, const GRANULE: usize>(policy: Policy) {
        let geometry = Geometry::new(Bytes(64 << 10), Bytes(32), WAYS as u32).expect("legal");
        let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy };
        let sets = 4;
        let metadata_cache =
            MetadataCacheConfig { bytes: (sets * CHIP_CACHE_WAYS * GRANULE) as u32, granule: GRANULE as u32 };
        let config = ChipConfig { metadata_cache, ..ChipConfig::standard(Version::B, cache) };
        let mut timed = tags(&config);
        let with_bytes = CachedMetadata::<WAYS, CHIP_CACHE_WAYS, GRANULE>::new(&cache, sets, Policy::Lru);
        let mut with_bytes = Directory::<WAYS, _>::over(cache, with_bytes);
        let mut state = 7_u32;
        let (mut moves, mut reads, mut writes) = (Vec::new(), 0, 0);
        for _ in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let addr = HostAddr(((state >> 8) % (96 << 10)) & !((state & 7) << 12));
            assert_eq!(timed.locate(addr, &mut moves), place(&mut with_bytes, addr));
            for moved in moves.drain(..) {
                *(if moved.direction == Direction::Read { &mut reads } else { &mut writes }) += 1;
            }
            let traffic = with_bytes.metadata.observer;
            assert_eq!((reads, writes), (traffic.loads, traffic.write_backs));
        }
        assert!(with_bytes.metadata.observer.write_backs > 0);
    }

    #[test]
    fn metadata_moves_as_with_bytes() {
        moves_as_version_b::<4, 16>(Policy::Lru);
        moves_as_version_b::<4, 32>(Policy::Plru);
        moves_as_version_b::<2, 8>(Policy::Fifo);
        moves_as_version_b::<16, 64>(Policy::Lru);
    }
}
