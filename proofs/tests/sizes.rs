//! The virtual memory at the sizes that people build: 16 384 to 131 072 sets, 320 KB to 2.5 MB of metadata, first-level
//! caches of 256 to 4096 sets, lines of up to 64 KB.
//!
//! Traffic is a sweep and then lines at random. The sweep uses, for each set, one line more than it has ways, so that each
//! way of each set is filled and each set evicts; its lines are spread over the whole address space, from the first line to
//! the last. So a counter, an index, a tag or an address that is cut off at some size shows.

use saarcor_fast::version_b::MetadataDecisions;
use saarcor_fast::{directory as fast, first_level as fast_first_level};
use saarcor_model::vm::{
    Bytes, CacheConfig, CachedMetadata, Corrupt, Directory, FIRST_LEVEL_WAYS, FirstLevel, FirstLevelCaches,
    Geometry, Hash, HostAddr, HostMemory, LineAddr, Memory, Metadata, MetadataObserver, Outcome, Policy, Set,
    SetIndex, Unit, VirtualMemory, WriteBack,
};
use saarcor_oracles::cache::NaiveCache;
use saarcor_oracles::metadata::{GranuleEvent, NaiveTags};

const MIB: u64 = 1 << 20;

/// Sets of the metadata cache of the paper's chip (§4): 64 KB, 4 ways, granules of [`GRANULE`] bytes.
const METADATA_SETS: usize = 1024;
const METADATA_WAYS: usize = 4;
const GRANULE: usize = 16;

/// First-level caches of the paper's chip (§4): sets of 4 lines, and bytes of a line, in the order of [`Unit::ALL`].
const FIRST_LEVEL: [(usize, u32); 4] = [(256, 64), (2048, 8), (4096, 4), (1024, 36)];

fn config(memory: u64, line: u64, ways: u32, hash: Hash, policy: Policy) -> CacheConfig {
    CacheConfig { geometry: Geometry::new(Bytes(memory), Bytes(line), ways).expect("legal"), hash, policy }
}

/// Numbers at random, the same in every run (Marsaglia 2003, xorshift).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}

/// Lines that reach every set of a cache so often that it evicts: of one block of `sets` lines after another, block by
/// block and line by line. The blocks are the first, the last and some between.
fn sweep(sets: u64, ways: u64, lines: u64) -> Vec<LineAddr> {
    let last = lines / sets - 1;
    let blocks = (ways + 1).min(last + 1);
    let block = |number: u64| if blocks == 1 { 0 } else { number * last / (blocks - 1) };
    (0..blocks)
        .flat_map(|number| (0..sets).map(move |set| LineAddr((block(number) * sets + set) as u32)))
        .collect()
}

/// As many of these lines at random, and lines close to them.
fn at_random(swept: &[LineAddr], count: usize, lines: u64, numbers: &mut Numbers) -> Vec<LineAddr> {
    let mut line = || {
        let near = u64::from(swept[numbers.below(swept.len() as u64) as usize].0);
        let far = if numbers.below(4) == 0 { numbers.below(lines) } else { 0 };
        LineAddr(((near + far) % lines) as u32)
    };
    (0..count).map(|_| line()).collect()
}

/// Lines of the address space.
fn lines_of(config: &CacheConfig) -> u64 {
    (1 << 32) / config.geometry.line().0
}

/// The sweep over a cache, and as many lines at random.
fn traffic(config: &CacheConfig) -> Vec<LineAddr> {
    let mut all = sweep(config.geometry.sets(), config.geometry.ways().into(), lines_of(config));
    let random = at_random(&all, (all.len() / 2).max(100), lines_of(config), &mut Numbers(2003));
    all.extend(random);
    all
}

/// Ranges of few lines, of many more than 2¹⁶, of more than any cache has, at both ends of the address space, beyond its
/// end, and empty.
fn ranges(config: &CacheConfig) -> Vec<(HostAddr, u64)> {
    let (line, held) = (config.geometry.line().0, config.geometry.lines());
    let top = |below: u64| HostAddr(((1 << 32) - below) as u32);
    let most = held * line - 1;
    vec![
        (HostAddr(7), 0),
        (HostAddr((line - 1) as u32), 2),
        (HostAddr(0), 3 * line),
        (top(2 * line), u64::MAX),
        (top(1), 1),
        // All lines of a block but the first, and nearly as many as there are in the cache.
        (HostAddr(line as u32), (config.geometry.sets() - 1).max(1) * line),
        (top(most.min(1 << 31)), most.min(1 << 31)),
        (HostAddr(1 << 31), 1 << 31),
    ]
}

fn same_sets<const WAYS: usize>(directory: &Directory<WAYS>, naive: &NaiveCache, after: &str) {
    for (index, set) in (0..).zip(directory.sets()) {
        let slots: Vec<_> = (0..WAYS).map(|way| set.resident[way].then_some(set.lines[way])).collect();
        assert_eq!(slots, naive.slots(index), "{:?}, {after}: set {index}", directory.config);
    }
    assert_eq!(directory.counters, naive.counters(), "{:?}, {after}", directory.config);
}

/// The specification, its twin and the naive cache do the same with all traffic, all ranges, and after a flush.
fn is_the_naive_cache<const WAYS: usize>(config: CacheConfig) {
    let mut directory = Directory::<WAYS>::new(config);
    let mut twin = directory.clone();
    let mut naive = NaiveCache::new(config);
    let lines = traffic(&config);
    let use_all =
        |directory: &mut Directory<WAYS>, twin: &mut Directory<WAYS>, naive: &mut NaiveCache, part: usize| {
            for &line in &lines[..lines.len() / part] {
                let expected = naive.access(line);
                assert_eq!(directory.access(line), expected, "{config:?}: {line:?}");
                assert_eq!(fast::access(twin, line), expected, "the twin, {config:?}: {line:?}");
            }
        };
    use_all(&mut directory, &mut twin, &mut naive, 1);
    same_sets(&directory, &naive, "after the sweep");
    let counters = directory.counters;
    assert!(counters.evictions >= config.geometry.sets() && counters.hits() > 0, "{config:?}: {counters:?}");
    for (addr, len) in ranges(&config) {
        directory.invalidate(addr, len);
        naive.invalidate(addr, len);
        same_sets(&directory, &naive, &format!("{len} bytes at {addr:?} invalidated"));
    }
    twin.clone_from(&directory);
    use_all(&mut directory, &mut twin, &mut naive, 3);
    same_sets(&directory, &naive, "used again");
    assert!(twin == directory, "{config:?}: the twin's state");
    let before = directory.counters.invalidated;
    directory.invalidate(HostAddr(0), 1 << 32);
    naive.invalidate(HostAddr(0), 1 << 32);
    same_sets(&directory, &naive, "all invalidated");
    assert!(directory.counters.invalidated > before);
    twin.clone_from(&directory);
    use_all(&mut directory, &mut twin, &mut naive, 3);
    directory.flush();
    naive.flush();
    same_sets(&directory, &naive, "flushed");
    assert!(directory.sets().iter().all(|set| *set == Set::empty(config.policy)), "{config:?}: flushed");
}

#[test]
fn standard_caches_are_the_naive_cache() {
    is_the_naive_cache::<4>(config(8 * MIB, 128, 4, Hash::AddUpperAll, Policy::Plru));
    is_the_naive_cache::<4>(config(16 * MIB, 128, 4, Hash::Low, Policy::Fifo));
    is_the_naive_cache::<4>(config(64 * MIB, 128, 4, Hash::AddUpper, Policy::Lru));
}

#[test]
fn wide_and_narrow_caches_are_the_naive_cache() {
    is_the_naive_cache::<16>(config(16 * MIB, 64, 16, Hash::AddUpper, Policy::Plru));
    is_the_naive_cache::<16>(config(2 * MIB, 64, 16, Hash::AddUpper, Policy::Lru));
    is_the_naive_cache::<8>(config(4 * MIB, 32, 8, Hash::AddUpperAll, Policy::Fifo));
    is_the_naive_cache::<2>(config(4 * MIB, 32, 2, Hash::AddUpper, Policy::Plru));
    is_the_naive_cache::<1>(config(1 << 18, 1, 1, Hash::AddUpperAll, Policy::Lru));
    is_the_naive_cache::<4>(config(8 * MIB, 1 << 16, 4, Hash::AddUpper, Policy::Lru));
}

/// A host whose memory has all 2³² bytes, no two neighbouring lines of which are alike, and ranges that were written since.
#[derive(Clone, Debug, Default)]
struct Host {
    written: Vec<(u64, u64)>,
}

impl Host {
    fn byte(&self, addr: u64) -> u8 {
        let writes = self.written.iter().filter(|(begin, end)| (*begin..*end).contains(&addr)).count();
        original(addr) ^ writes as u8
    }
}

fn original(addr: u64) -> u8 {
    (addr.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 48) as u8
}

impl HostMemory for Host {
    fn read(&self, addr: HostAddr, bytes: &mut [u8]) {
        let begin = u64::from(addr.0);
        for (addr, byte) in (begin..).zip(bytes.iter_mut()) {
            *byte = if addr < 1 << 32 { original(addr) } else { 0 };
        }
        let end = (begin + bytes.len() as u64).min(1 << 32);
        for (from, to) in &self.written {
            for addr in begin.max(*from)..end.min(*to) {
                bytes[(addr - begin) as usize] = self.byte(addr);
            }
        }
    }
}

/// Reads some bytes, and says where the first differs from the host's.
fn read_right(memory: &mut impl Memory, host: &Host, unit: Unit, addr: u64, len: usize) {
    let mut bytes = vec![0xa5; len];
    memory.read(unit, HostAddr(addr as u32), &mut bytes);
    for (at, byte) in (addr..).zip(bytes) {
        let expected = if at < 1 << 32 { host.byte(at) } else { 0 };
        assert_eq!(byte, expected, "byte {at:#x} of {len} read at {addr:#x} by {unit:?}");
    }
}

/// Reads of lines of the traffic: any offset, some across lines; the last across the end of the address space.
fn reads(config: &CacheConfig) -> Vec<(u64, usize)> {
    let (mut numbers, line_bytes) = (Numbers(17), config.geometry.line().0);
    let read = |line: LineAddr| {
        let addr = u64::from(line.0) * line_bytes + numbers.below(line_bytes);
        (addr, if numbers.below(16) == 0 { 1 + numbers.below(300) as usize } else { 4 })
    };
    let mut reads: Vec<_> = traffic(config).into_iter().map(read).collect();
    reads.push(((1 << 32) - 3, 8));
    reads
}

/// What is read is the host's, before and after the host writes ranges and invalidates them.
fn is_transparent<const WAYS: usize, M: Metadata<WAYS>>(directory: Directory<WAYS, M>) {
    let config = directory.config;
    let mut host = Host::default();
    let mut memory = VirtualMemory::new(directory, host.clone());
    let reads = reads(&config);
    for &(addr, len) in &reads {
        read_right(&mut memory, &host, Unit::Shading, addr, len);
    }
    for (addr, len) in ranges(&config) {
        host.written.push((addr.0.into(), u64::from(addr.0).saturating_add(len).min(1 << 32)));
        memory.host = host.clone();
        memory.invalidate(addr, len);
    }
    for &(addr, len) in reads.iter().rev() {
        read_right(&mut memory, &host, Unit::Shading, addr, len);
    }
    let counters = memory.directory.counters;
    assert!(counters.evictions > 0 && counters.hits() > 0 && counters.invalidated > 0, "{counters:?}");
}

#[test]
fn standard_virtual_memories_are_transparent() {
    is_transparent(Directory::<4>::new(config(8 * MIB, 128, 4, Hash::AddUpper, Policy::Lru)));
    is_transparent(Directory::<4>::new(config(32 * MIB, 128, 4, Hash::AddUpper, Policy::Lru)));
}

#[test]
fn virtual_memories_with_long_lines_are_transparent() {
    is_transparent(Directory::<4>::new(config(MIB, 1 << 16, 4, Hash::AddUpper, Policy::Lru)));
    is_transparent(Directory::<16>::new(config(4 * MIB, 1 << 14, 16, Hash::Low, Policy::Plru)));
    is_transparent(Directory::<1>::new(config(1 << 17, 1 << 17, 1, Hash::AddUpperAll, Policy::Fifo)));
}

/// Version B with a metadata cache like the chip's.
fn version_b<const WAYS: usize, O: MetadataObserver<[u8; GRANULE]>>(
    config: CacheConfig,
    observer: O,
) -> Directory<WAYS, CachedMetadata<WAYS, METADATA_WAYS, GRANULE, O>> {
    let metadata = CachedMetadata::observed(&config, METADATA_SETS, Policy::Lru, observer);
    Directory::over(config, metadata)
}

/// What moved since the last look: of each granule used its number, whether it was read, and the granule written back.
#[derive(Clone, Debug, Default)]
struct Moved(Vec<(u32, bool, Option<u32>)>, usize);

impl<Contents> MetadataObserver<Contents> for Moved {
    fn granule_used(&mut self, granule: LineAddr, outcome: Outcome, back: Option<WriteBack<Contents>>) {
        let read = matches!(outcome, Outcome::Miss { .. });
        self.0.push((granule.0, read, back.map(|back| back.line.0)));
    }

    fn corrupt(&mut self) {
        self.1 += 1;
    }
}

/// Version B, its twin and version A do the same with all traffic; both versions B move the same metadata.
fn b_is_a<const WAYS: usize>(config: CacheConfig) {
    let mut a = Directory::<WAYS>::new(config);
    let mut b = version_b::<WAYS, _>(config, Moved::default());
    let decisions = MetadataDecisions::<WAYS, METADATA_WAYS, _>::new(
        &config,
        METADATA_SETS,
        GRANULE,
        Policy::Lru,
        Moved::default(),
    );
    let mut twin = Directory::over(config, decisions);
    let mut written_back = 0;
    let lines = traffic(&config);
    for (number, &line) in lines.iter().enumerate() {
        let expected = a.access(line);
        assert_eq!(b.access(line), expected, "{config:?}: {line:?}");
        assert_eq!(fast::access(&mut twin, line), expected, "the twin, {config:?}: {line:?}");
        if number == lines.len() / 2 {
            let range = (HostAddr(1 << 31), 1 << 31);
            a.invalidate(range.0, range.1);
            b.invalidate(range.0, range.1);
            twin.invalidate(range.0, range.1);
        }
        if number == lines.len() / 4 * 3 {
            a.flush();
            b.flush();
            twin.flush();
        }
        assert_eq!(
            twin.metadata.observer.0, b.metadata.observer.0,
            "{config:?}: metadata moved for {line:?}"
        );
        written_back += b.metadata.observer.0.iter().filter(|moved| moved.2.is_some()).count();
        b.metadata.observer.0.clear();
        twin.metadata.observer.0.clear();
    }
    for (index, set) in (0..).map(SetIndex).zip(a.sets()) {
        assert_eq!(b.metadata.entries(index), set.to_entries(), "{config:?}: {index:?}");
    }
    assert_eq!((b.counters, twin.counters), (a.counters, a.counters), "{config:?}");
    assert!(b.metadata.observer.1 == 0 && written_back > 0, "{config:?}: corrupt, or nothing written back");
    assert!(
        b.metadata.cache.iter().all(|set| set.set.resident == [true; METADATA_WAYS]),
        "every granule of the cache is used"
    );
    let empty = Set::<WAYS>::empty(config.policy).to_entries();
    b.flush();
    for index in (0..a.sets().len() as u32).map(SetIndex) {
        assert_eq!(b.metadata.entries(index), empty, "{config:?}: {index:?} after a flush");
    }
}

#[test]
fn standard_version_b_is_version_a() {
    b_is_a::<4>(config(16 * MIB, 128, 4, Hash::AddUpper, Policy::Lru));
    b_is_a::<4>(config(64 * MIB, 128, 4, Hash::AddUpper, Policy::Plru));
    b_is_a::<16>(config(8 * MIB, 64, 16, Hash::AddUpperAll, Policy::Fifo));
}

#[test]
fn standard_version_b_is_transparent() {
    let config = config(8 * MIB, 128, 4, Hash::AddUpper, Policy::Lru);
    is_transparent(version_b::<4, _>(config, Moved::default()));
}

/// What moves between the chip and the on-board memory, with the bytes of each granule that is written back.
#[derive(Default)]
struct Events(Vec<GranuleEvent>);

impl MetadataObserver<[u8; GRANULE]> for Events {
    fn granule_used(&mut self, granule: LineAddr, outcome: Outcome, back: Option<WriteBack<[u8; GRANULE]>>) {
        let read = matches!(outcome, Outcome::Miss { .. });
        self.0.push(if read { GranuleEvent::Read(granule.0) } else { GranuleEvent::Found(granule.0) });
        self.0.extend(back.map(|back| GranuleEvent::WrittenBack(back.line.0, back.contents.to_vec())));
    }

    fn corrupt(&mut self) {}
}

/// Forgets the range of `len` bytes from the first byte of `line` on in both, which move the same metadata.
fn invalidate_alike<const WAYS: usize>(
    b: &mut Directory<WAYS, CachedMetadata<WAYS, METADATA_WAYS, GRANULE, Events>>,
    naive: &mut NaiveTags,
    line: LineAddr,
    len: u64,
) {
    let addr = HostAddr(line.0.wrapping_mul(b.config.geometry.line().0 as u32));
    let mut expected = Vec::new();
    b.invalidate(addr, len);
    naive.invalidate(addr, len, &mut expected);
    assert_eq!(b.metadata.observer.0, expected, "{:?}: {len} bytes at {addr:?}", b.config);
    b.metadata.observer.0.clear();
}

/// Version B moves what the naive tags move: while each set is used `blocks` times, then for lines at random, and for ranges
/// that are invalidated and a flush between.
fn metadata_is_the_naive_tags<const WAYS: usize>(
    config: CacheConfig,
    metadata_sets: usize,
    blocks: u64,
    count: usize,
) {
    let metadata = CachedMetadata::observed(&config, metadata_sets, Policy::Lru, Events::default());
    let mut b = Directory::<WAYS, CachedMetadata<WAYS, METADATA_WAYS, GRANULE, _>>::over(config, metadata);
    let mut naive = NaiveTags::new(config, GRANULE, metadata_sets, METADATA_WAYS);
    let swept = sweep(config.geometry.sets(), blocks - 1, lines_of(&config));
    let random = at_random(&swept, count, lines_of(&config), &mut Numbers(5));
    let mut expected = Vec::new();
    for (number, line) in swept.into_iter().chain(random).enumerate() {
        expected.clear();
        assert_eq!(b.access(line), naive.access(line, &mut expected), "{config:?}: {line:?}");
        assert_eq!(b.metadata.observer.0, expected, "{config:?}: {line:?}");
        b.metadata.observer.0.clear();
        if number % 1000 == 999 {
            invalidate_alike(&mut b, &mut naive, line, config.geometry.line().0 + 1);
        }
        if number + 1 == count {
            // One line less than the cache has, and as many.
            for lines in [config.geometry.lines() - 1, config.geometry.lines()] {
                invalidate_alike(&mut b, &mut naive, LineAddr(0), lines * config.geometry.line().0);
            }
        }
        if number == count {
            b.flush();
            naive.flush();
        }
    }
}

#[test]
fn standard_metadata_is_the_naive_tags() {
    let standard = config(16 * MIB, 128, 4, Hash::AddUpper, Policy::Lru);
    metadata_is_the_naive_tags::<4>(standard, METADATA_SETS, 1, 10_000);
}

/// Caches whose metadata ends within a granule.
#[test]
fn metadata_of_odd_sizes_is_the_naive_tags() {
    metadata_is_the_naive_tags::<1>(config(8, 1, 1, Hash::AddUpper, Policy::Fifo), 1, 5, 2000);
    metadata_is_the_naive_tags::<2>(config(2 * 128, 128, 2, Hash::Low, Policy::Lru), 1, 5, 2000);
    metadata_is_the_naive_tags::<4>(config(64, 16, 4, Hash::Low, Policy::Lru), 2, 9, 2000);
    metadata_is_the_naive_tags::<8>(config(8 << 10, 16, 8, Hash::AddUpperAll, Policy::Plru), 2, 17, 3000);
    metadata_is_the_naive_tags::<16>(config(1 << 14, 64, 16, Hash::AddUpper, Policy::Plru), 4, 33, 3000);
}

/// Wherever in 2.5 MB of metadata an error is, and in the metadata cache too, its set counts as empty and no other does.
#[test]
fn corruption_anywhere_empties_one_set() {
    let config = config(64 * MIB, 128, 4, Hash::AddUpper, Policy::Lru);
    let (mut a, mut b) = (Directory::<4>::new(config), version_b::<4, _>(config, Moved::default()));
    let sets = config.geometry.sets();
    for line in sweep(sets, 2, lines_of(&config)) {
        a.access(line);
        b.access(line);
    }
    let mut numbers = Numbers(11);
    let set_bytes = b.metadata.card.len() as u64 / sets;
    for round in 0..20_000 {
        // Sets from the first to the last, and any between; any byte, one to three bits of it.
        let set = if round % 2 == 0 { round * (sets - 1) / 19_998 } else { numbers.below(sets) };
        let byte = set * set_bytes + numbers.below(set_bytes);
        let error = [1, 2, 4, 8, 16, 32, 64, 128, 3, 6, 12, 0x18, 0x30, 0x60, 0xc0, 7, 0x1c, 0xe0]
            [numbers.below(18) as usize];
        let (index, granule) = (SetIndex(set as u32), (byte / GRANULE as u64) as u32);
        // Where the byte counts: in the metadata cache, or else on the card.
        let metadata = &mut b.metadata;
        let place = byte as usize % GRANULE;
        let cached = &mut metadata.cache[granule as usize % METADATA_SETS];
        match cached.set.way_of(LineAddr(granule)) {
            Some(way) => cached.contents[usize::from(way.0)][place] ^= error,
            None => metadata.card[byte as usize] ^= error,
        }
        assert_eq!(
            Set::<4>::from_entries(metadata.entries(index), config.policy),
            Err(Corrupt),
            "byte {byte}, bits {error:#x}"
        );
        a.metadata.sets[set as usize] = Set::empty(config.policy);
        // A line of that set: the upper bits are added to the lower.
        let block = numbers.below(200);
        let line = LineAddr((block * sets + (set + sets - block) % sets) as u32);
        assert_eq!(b.access(line), a.access(line), "set {set}, byte {byte}, bits {error:#x}: {line:?}");
        assert_eq!(b.metadata.observer.1, round as usize + 1, "sets detected to be corrupt");
        assert_eq!(
            b.metadata.entries(index),
            a.sets()[set as usize].to_entries(),
            "set {set}, byte {byte}, bits {error:#x}"
        );
    }
    for (index, set) in (0..).map(SetIndex).zip(a.sets()) {
        assert_eq!(b.metadata.entries(index), set.to_entries(), "{index:?}");
    }
}

/// A first-level cache, its twin and a naive cache of its lines do the same, over all sets, for regions at both ends of
/// the address space.
fn first_level_is_the_naive_cache(sets: usize, line_bytes: u32, base: u32, policy: Policy) {
    let mut cache = FirstLevel::<FIRST_LEVEL_WAYS, ()>::new(HostAddr(base), line_bytes, sets, policy);
    let mut twin = cache.clone();
    // In units of lines.
    let numbers = config((sets * FIRST_LEVEL_WAYS) as u64, 1, FIRST_LEVEL_WAYS as u32, Hash::Low, policy);
    let mut naive = NaiveCache::new(numbers);
    let (line_bytes, base) = (u64::from(line_bytes), u64::from(base));
    let lines = ((1 << 32) - base).div_ceil(line_bytes);
    let name = format!("{sets} sets of lines of {line_bytes} bytes from {base:#x}, {policy:?}");
    let swept = sweep(sets as u64, FIRST_LEVEL_WAYS as u64, lines / sets as u64 * sets as u64);
    let random = at_random(&swept, swept.len(), lines, &mut Numbers(line_bytes));
    let part = |from: u64, to: u64| (base + from * line_bytes, (to - from) * line_bytes);
    let mut ranges = vec![
        (base, 0),
        (base, 1),
        part(0, 2),
        part(1, sets as u64 * 9 / 10),
        part(lines / 2, lines),
        (0, 1 << 32),
        (0, u64::MAX),
    ];
    for (number, line) in swept.into_iter().chain(random).enumerate() {
        let resident = naive.slots(u64::from(line.0) % sets as u64).contains(&Some(line));
        assert_eq!(cache.is_resident(line), resident, "{name}: {line:?}");
        assert_eq!(fast_first_level::is_resident(&cache, line), resident, "the twin, {name}: {line:?}");
        let expected = naive.access(line);
        assert_eq!(cache.access(line, || ()), expected, "{name}: {line:?}");
        assert_eq!(fast_first_level::access(&mut twin, line), expected, "the twin, {name}: {line:?}");
        if number > sets * 5 && number % (sets / 2) == 0 && ranges.len() > 1 || number + 1 == sets * 10 {
            let Some((addr, len)) = (if ranges.len() > 1 { Some(ranges.remove(0)) } else { ranges.pop() })
            else {
                break;
            };
            let addr = HostAddr(addr as u32);
            cache.invalidate(addr, len);
            twin.invalidate(addr, len);
            let begin = u64::from(addr.0).max(base) - base;
            let end = u64::from(addr.0).saturating_add(len).min(1 << 32).saturating_sub(base);
            let first = begin / line_bytes;
            naive.invalidate(HostAddr(first as u32), end.div_ceil(line_bytes).max(first) - first);
            assert_eq!(cache.counters, naive.counters(), "{name}: {len} bytes at {addr:?} invalidated");
        }
    }
    assert!(cache == twin, "{name}: the twin's state");
    for (index, set) in (0..).zip(&cache.sets) {
        let slots: Vec<_> =
            (0..FIRST_LEVEL_WAYS).map(|way| set.set.resident[way].then_some(set.set.lines[way])).collect();
        assert_eq!(slots, naive.slots(index), "{name}: set {index}");
    }
    let counters = cache.counters;
    assert!(
        counters.evictions > 0 && counters.hits() > 0 && counters.invalidated >= sets as u64,
        "{name}: {counters:?}"
    );
}

#[test]
fn standard_first_level_caches_are_the_naive_cache() {
    for (sets, line_bytes) in FIRST_LEVEL {
        first_level_is_the_naive_cache(sets, line_bytes, 0, Policy::Lru);
        first_level_is_the_naive_cache(sets, line_bytes, 0x1234_5670, Policy::Plru);
        first_level_is_the_naive_cache(sets, line_bytes, 0xff00_0004, Policy::Fifo);
    }
}

/// Each unit reads the host's bytes through a first-level cache like the chip's and the virtual memory behind it, before
/// and after the host writes.
#[test]
fn standard_hierarchy_is_transparent() {
    let triangles = 0x4000_0004;
    let config = config(8 * MIB, 128, 4, Hash::AddUpper, Policy::Lru);
    let mut host = Host::default();
    let below = VirtualMemory::new(version_b::<4, _>(config, Moved::default()), host.clone());
    let mut caches =
        FirstLevelCaches::new(FIRST_LEVEL.map(|(sets, _)| sets), Policy::Lru, HostAddr(triangles), below);
    let mut numbers = Numbers(3);
    let mut reads = Vec::new();
    for (unit, (sets, line_bytes)) in Unit::ALL.into_iter().zip(FIRST_LEVEL) {
        let (base, line_bytes) =
            (if unit == Unit::Intersection { triangles.into() } else { 0 }, u64::from(line_bytes));
        let lines = ((1 << 32) - base) / line_bytes;
        for line in sweep(sets as u64, 4, lines / sets as u64 * sets as u64) {
            let offset = if numbers.below(8) == 0 { numbers.below(line_bytes) } else { 0 };
            let addr = base + u64::from(line.0) * line_bytes + offset;
            reads.push((unit, addr, if numbers.below(64) == 0 { 200 } else { line_bytes as usize }));
        }
    }
    for &(unit, addr, len) in &reads {
        read_right(&mut caches, &host, unit, addr, len);
    }
    for (begin, end) in
        [(0, 1 << 30), ((1 << 32) - 70, 1 << 32), (3 << 29, 7 << 29), (triangles.into(), 1 << 32)]
    {
        host.written.push((begin, end));
        caches.below.host = host.clone();
        caches.below.invalidate(HostAddr(begin as u32), end - begin);
        caches.invalidate(HostAddr(begin as u32), end - begin);
    }
    for &(unit, addr, len) in reads.iter().rev() {
        read_right(&mut caches, &host, unit, addr, len);
    }
}
