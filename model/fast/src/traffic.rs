//! What a run of accesses costs, without saying of each what it did: twin of
//! [`Directory`] of version A and, with what goes through the metadata cache, of version B.
//!
//! Of LRU and FIFO caches of four ways the sets are rows of tags, in the order of replacement, and the metadata cache has rows
//! of granules: both move by the same kernel, two rows at a time, without branches. What an access changes of a set's metadata
//! stands in a table that the specification's step fills. Lines evicted and granules written back need no counting at all: they
//! are what came in and is not there any more. Any other cache takes the steps of [`directory`] and
//! [`version_b`](crate::version_b), one by one. Equal by the theorems of `saarcor-proofs`, `equal::traffic`.
//!
//! ```
//! use saarcor_fast::traffic::{MetadataCache, Traffic};
//! use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
//!
//! let geometry = Geometry::new(Bytes(8 << 20), Bytes(128), 4)?;
//! let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
//! let mut a = Traffic::of_version_a(cache);
//! a.access(&[7, 7, 7, 1 << 20, 7]);
//! assert_eq!((a.counters().accesses, a.counters().misses), (5, 2));
//!
//! let mut b = Traffic::of_version_b(cache, MetadataCache::STANDARD);
//! b.access(&[7, 7, 7, 1 << 20, 7]);
//! assert_eq!(b.counters(), a.counters());
//! assert_eq!(b.metadata().loads, 2); // one granule for each of the two sets
//! # Ok::<(), saarcor_model::vm::GeometryError>(())
//! ```

pub mod changes;
pub mod lanes;
pub mod rows;

use crate::directory;
use crate::version_b::MetadataDecisions;
use changes::{Change, Changes, SET_BYTES, Shape};
use lanes::Lanes;
use rows::{PLACES, Rows};
use saarcor_model::time::standard;
use saarcor_model::vm::{
    CacheConfig, Counters, Directory, Hash, LineAddr, Metadata, MetadataTraffic, OnChip, Policy,
};

/// Ways of the metadata cache (§4, Stated).
const META_WAYS: usize = standard::CHIP_CACHE_WAYS;
/// Ways of the caches that have rows.
const WAYS: u32 = 4;
/// Lines that go through one kernel before the next: as many as stay in the first-level cache of a processor beside the rows.
const BATCH: usize = 256;
/// Spare rows, for the second granule of a set that has one alone. Many, since an access waits for the one before in its row.
const SPARE: usize = 64;

/// The metadata cache of version B, of four ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MetadataCache {
    /// Sets of granules: a power of two.
    pub sets: usize,
    /// Bytes of a granule.
    pub granule_bytes: usize,
    /// Replacement of granules.
    pub policy: Policy,
}

impl MetadataCache {
    /// The paper's: 64 KB in four ways (§4, Stated), granules and policy as in `time::standard` (Assumed).
    pub const STANDARD: Self = Self {
        sets: standard::METADATA_CACHE_BYTES as usize / standard::GRANULE as usize / META_WAYS,
        granule_bytes: standard::GRANULE as usize,
        policy: Policy::Lru,
    };
}

/// A cache that counts what it does.
pub struct Traffic {
    /// Lines of the 32-bit address space.
    lines: u64,
    lanes: Lanes,
    cache: Box<dyn Cache>,
}

impl Traffic {
    /// An empty cache of version A.
    #[must_use]
    pub fn of_version_a(config: CacheConfig) -> Self {
        Self::with_lanes(config, None, Lanes::of_processor())
    }

    /// An empty cache of version B.
    ///
    /// # Panics
    /// If the sets of the metadata cache are no power of two, a granule has no bytes, or there are more than 2³² granules.
    #[must_use]
    pub fn of_version_b(config: CacheConfig, metadata: MetadataCache) -> Self {
        Self::with_lanes(config, Some(metadata), Lanes::of_processor())
    }

    /// An empty cache, of version B if it has a metadata cache, whose rows move by `lanes`.
    ///
    /// # Panics
    /// As [`Traffic::of_version_b`].
    #[must_use]
    pub fn with_lanes(config: CacheConfig, metadata: Option<MetadataCache>, lanes: Lanes) -> Self {
        let rows: Option<Box<dyn Cache>> = match metadata {
            None => RowsOfLines::new(config, lanes).map(|rows| Box::new(rows) as _),
            Some(metadata) => WithMetadata::new(config, metadata, lanes).map(|rows| Box::new(rows) as _),
        };
        let cache = rows.unwrap_or_else(|| by_steps(config, metadata));
        Self { lines: (1 << 32) / config.geometry.line().0, lanes, cache }
    }

    /// Uses lines, one after the other.
    ///
    /// # Panics
    /// If one of them lies beyond the 32-bit address space: its number is 2³² / bytes of a line, or more.
    pub fn access(&mut self, lines: &[u32]) {
        let lanes = self.lanes;
        for lines in lines.chunks(BATCH) {
            let last = lanes.run(|| lines.iter().fold(0, |last, line| last.max(*line)));
            assert!(
                u64::from(last) < self.lines,
                "line {last:#x}: lines of 32-bit addresses have numbers below {:#x}",
                self.lines
            );
            self.cache.access(lines);
        }
    }

    /// Forgets all lines; the counters keep their values.
    pub fn flush(&mut self) {
        self.cache.flush();
    }

    /// What has happened to lines so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.cache.counters()
    }

    /// What has gone through the metadata cache so far: nothing in version A.
    #[must_use]
    pub fn metadata(&self) -> MetadataTraffic {
        self.cache.metadata()
    }
}

/// A cache of any shape.
trait Cache: Send {
    /// Uses at most [`BATCH`] lines.
    fn access(&mut self, lines: &[u32]);
    fn flush(&mut self);
    fn counters(&self) -> Counters;
    fn metadata(&self) -> MetadataTraffic;
}

/// Version A in rows.
struct RowsOfLines {
    hash: Hash,
    set_bits: u32,
    rows: Rows<false>,
    lanes: Lanes,
    counters: Counters,
    /// Lines that flushes have forgotten.
    forgotten: u64,
    /// The line used last; any other before the first.
    last: u32,
    batch: Box<Batch>,
}

/// What the kernels of a batch of accesses hand on.
struct Batch {
    /// Lines, without those that repeat the one before. Eight at a time are written.
    lines: [u32; BATCH + 8],
    places: [u32; BATCH],
    tags: [u16; BATCH],
    found: [u8; BATCH / 2],
}

impl RowsOfLines {
    /// An empty cache; none if its lines or tags do not fit into rows.
    fn new(config: CacheConfig, lanes: Lanes) -> Option<Self> {
        let geometry = config.geometry;
        let (set_bits, line_bits) = (geometry.set_bits(), geometry.line().0.trailing_zeros());
        let tag_bits = 32_u32.saturating_sub(line_bits + set_bits);
        if geometry.ways() != WAYS || config.policy == Policy::Plru || tag_bits > 15 {
            return None;
        }
        Some(Self {
            hash: config.hash,
            set_bits,
            rows: Rows::new(1 << set_bits, config.policy),
            lanes,
            counters: Counters::default(),
            forgotten: 0,
            last: u32::MAX,
            batch: Box::new(Batch {
                lines: [0; BATCH + 8],
                places: [0; BATCH],
                tags: [0; BATCH],
                found: [0; BATCH / 2],
            }),
        })
    }

    /// Uses at most [`BATCH`] lines. Returns how many rows were used for them: a line that repeats the one before is a hit that
    /// changes nothing.
    fn use_rows(&mut self, lines: &[u32]) -> usize {
        let Self { hash, set_bits, lanes, .. } = *self;
        let Batch { lines: distinct, places, tags, found } = &mut *self.batch;
        let (Some(&last), before) = (lines.last(), self.last) else { return 0 };
        // Lines that repeat are dropped where that pays.
        let repeated: u32 = lanes.run(|| lines.iter().zip(&lines[1..]).map(|(a, b)| u32::from(a == b)).sum());
        let distinct = if 8 * repeated as usize > lines.len() {
            let count = lanes.drop_repeated(lines, before, distinct);
            &distinct[..count]
        } else {
            lines
        };
        let used = distinct.len();
        lanes.run(|| places_and_tags(hash, set_bits, distinct, places, tags));
        let (pairs, one) = places[..used].as_chunks::<2>();
        let (tags, tag) = tags[..used].as_chunks::<2>();
        let pairs = pairs.iter().copied().zip(tags.iter().copied());
        let mut sums = self.rows.access(lanes, pairs, &mut found[..used / 2]);
        if let ([place], [tag]) = (one, tag) {
            found[used / 2] =
                rows::one::<false>(&mut self.rows.rows, self.rows.policy, *place, *tag, &mut sums);
        }
        self.last = last;
        self.counters.accesses += lines.len() as u64;
        self.counters.misses += used as u64 - sums.hits;
        used
    }

    /// Lines that are resident now.
    fn resident(&self) -> u64 {
        self.rows.rows.iter().flatten().filter(|word| **word != Rows::<false>::FREE).count() as u64
    }
}

/// The set of each line, and the tag that tells it from the others of its set: the bits above those of the set. No two lines
/// have both in common, whatever the hash, since each adds to the lower bits what the upper ones decide.
#[inline(always)]
fn places_and_tags(hash: Hash, set_bits: u32, lines: &[u32], places: &mut [u32], tags: &mut [u16]) {
    for ((&line, place), tag) in lines.iter().zip(places).zip(tags) {
        (*place, *tag) = (set_of(hash, set_bits, line), (line >> set_bits) as u16);
    }
}

/// [`Hash::set_of`], of which the compiler makes vectors but for [`Hash::AddUpperAll`].
#[inline(always)]
fn set_of(hash: Hash, set_bits: u32, line: u32) -> u32 {
    if hash == Hash::AddUpperAll {
        return hash.set_of(LineAddr(line), set_bits).0;
    }
    // Vectors do not divide by cases: of the standard hashes one adds nothing.
    let added = if hash == Hash::Low { 0 } else { line >> set_bits };
    line.wrapping_add(added) & ((1 << set_bits) - 1)
}

impl Cache for RowsOfLines {
    fn access(&mut self, lines: &[u32]) {
        self.use_rows(lines);
    }

    fn flush(&mut self) {
        self.forgotten += self.resident();
        self.rows.rows.fill([Rows::<false>::FREE; 4]);
        self.last = u32::MAX;
    }

    fn counters(&self) -> Counters {
        // What came in and is neither there nor forgotten was evicted.
        Counters { evictions: self.counters.misses - self.resident() - self.forgotten, ..self.counters }
    }

    fn metadata(&self) -> MetadataTraffic {
        MetadataTraffic::default()
    }
}

/// In units of 4 bytes a set's metadata take 5, and a granule a power of two.
const SET_UNITS: u32 = SET_BYTES as u32 / 4;

/// 1 if the metadata of a set lie in two granules of `4 << granule_bits` bytes, 0 if in one.
#[inline(always)]
fn straddles(set: u32, granule_bits: u32) -> u32 {
    let granule = 1 << granule_bits;
    u32::from(((SET_UNITS * set) & (granule - 1)) + SET_UNITS > granule)
}

/// Version B in rows.
struct WithMetadata {
    lines: RowsOfLines,
    changes: Changes,
    /// The number of each set's shape.
    shapes: Vec<u8>,
    granules: Rows<true>,
    /// Binary logarithms of the sets of the metadata cache, and of the bytes of a granule.
    meta_bits: u32,
    granule_bits: u32,
    traffic: MetadataTraffic,
    /// Granules that were marked dirty, and those of them that flushes have forgotten.
    marked: u64,
    forgotten: u64,
    batch: Box<Granules>,
}

/// The granules of a batch of accesses: two each, of which the second may be spare.
struct Granules {
    /// Place of the first, and in the upper half of the second.
    places: [u32; BATCH],
    /// Their keys in the same way.
    keys: [u32; BATCH],
}

impl WithMetadata {
    /// An empty cache; none if its lines, granules or tags do not fit into rows.
    fn new(config: CacheConfig, metadata: MetadataCache, lanes: Lanes) -> Option<Self> {
        let lines = RowsOfLines::new(config, lanes)?;
        let MetadataCache { sets, granule_bytes, policy } = metadata;
        let granules = (config.geometry.sets() as usize * SET_BYTES).div_ceil(granule_bytes.max(1));
        // Two granules at most, and these in different sets of the metadata cache.
        let fits = sets.is_power_of_two()
            && sets >= 2
            && sets + SPARE <= PLACES
            && granule_bytes.is_power_of_two()
            && granule_bytes >= 16
            && granules / sets < usize::from(Rows::<true>::FREE / 2)
            && lines.set_bits < 28
            && policy != Policy::Plru;
        if !fits {
            return None;
        }
        let mut rows = Rows::new(PLACES, policy);
        rows.rows[sets..sets + SPARE].iter_mut().for_each(|row| row[0] = 0);
        let mut new = Self {
            changes: Changes::new(config.policy),
            shapes: vec![0; 1 << lines.set_bits],
            lines,
            granules: rows,
            meta_bits: sets.ilog2(),
            granule_bits: granule_bytes.ilog2(),
            traffic: MetadataTraffic::default(),
            marked: 0,
            forgotten: 0,
            batch: Box::new(Granules { places: [0; BATCH], keys: [0; BATCH] }),
        };
        new.forget_shapes();
        Some(new)
    }

    /// All sets are empty.
    fn forget_shapes(&mut self) {
        let granule = 1 << self.granule_bits;
        for (set, shape) in self.shapes.iter_mut().enumerate() {
            let behind = granule - set * SET_BYTES % granule;
            *shape = Shape::empty(if behind < SET_BYTES { behind / 4 } else { 0 }).number();
        }
    }

    /// For the first `used` sets of the batch, the places and keys of their granules, where changed granules are marked. Returns
    /// how often sets straddle two granules, and how often a granule changes.
    #[inline(always)]
    fn find_granules(&mut self, used: usize) -> (u64, u64) {
        let (meta_bits, mask) = (self.meta_bits, (1_u32 << self.meta_bits) - 1);
        let granule_bits = self.granule_bits - 2;
        let Batch { places: sets, found, .. } = &*self.lines.batch;
        let Granules { places, keys } = &mut *self.batch;
        let (sets, keys) = (&sets[..used], &mut keys[..used]);
        let mut straddling = 0;
        for (n, ((&set, place), key)) in sets.iter().zip(places).zip(keys.iter_mut()).enumerate() {
            let granule = (SET_UNITS * set) >> granule_bits;
            let two = straddles(set, granule_bits);
            straddling += two;
            let (next, both) = (granule + 1, two.wrapping_neg());
            let spare = mask + 1 + n as u32 % SPARE as u32;
            *place = granule & mask | (next & mask & both | spare & !both) << 16;
            *key = granule >> meta_bits << 1 | (next >> meta_bits << 17) & both;
        }
        // Before the border, and in the upper half of the number behind it.
        let mut changed = 0;
        let mut mark = |set: u32, found: u8, key: &mut u32| {
            let shape = &mut self.shapes[set as usize];
            let Change { dirty, next } = self.changes.of(*shape, found);
            *shape = next;
            changed += dirty;
            *key |= dirty;
        };
        let ((pairs, one), (pairs_of_keys, key)) = (sets.as_chunks::<2>(), keys.as_chunks_mut::<2>());
        for (([a, b], [key_a, key_b]), found) in pairs.iter().zip(pairs_of_keys).zip(found) {
            mark(*a, *found, key_a);
            mark(*b, found >> 4, key_b);
        }
        if let ([set], [key]) = (one, key) {
            mark(*set, found[used / 2], key);
        }
        (straddling.into(), u64::from(changed & 0xffff) + u64::from(changed >> 16))
    }

    /// How many of the sets of `lines` straddle two granules.
    fn straddling(&self, lines: &[u32]) -> u64 {
        let RowsOfLines { hash, set_bits, lanes, .. } = self.lines;
        let granule_bits = self.granule_bits - 2;
        let straddles = |line: &u32| straddles(set_of(hash, set_bits, *line), granule_bits);
        let count: u32 = lanes.run(
            #[inline(always)]
            || lines.iter().map(straddles).sum(),
        );
        count.into()
    }

    /// Granules that are dirty now.
    fn dirty(&self) -> u64 {
        let words = self.granules.rows[..1 << self.meta_bits].iter().flatten();
        words.map(|word| u64::from(word & 1)).sum()
    }
}

impl Cache for WithMetadata {
    fn access(&mut self, lines: &[u32]) {
        let used = self.lines.use_rows(lines);
        let lanes = self.lines.lanes;
        let (mut straddling, changed) = lanes.run(|| self.find_granules(used));
        let Granules { places, keys } = &*self.batch;
        let halves = |both: &u32| [*both as u16, (*both >> 16) as u16];
        let pairs = places[..used].iter().map(halves).zip(keys.iter().map(halves));
        let sums = self.granules.access_granules(lanes, pairs);
        // A spare row has its word from the beginning: it always hits.
        self.traffic.loads += 2 * used as u64 - sums.hits;
        self.marked += sums.marked;
        if used < lines.len() {
            // An access that repeats its line uses the same granules again.
            straddling = self.straddling(lines);
        }
        self.traffic.accesses += lines.len() as u64 + straddling + changed;
    }

    fn flush(&mut self) {
        self.forgotten += self.dirty();
        self.granules.rows[..1 << self.meta_bits].fill([Rows::<true>::FREE; 4]);
        self.lines.flush();
        self.forget_shapes();
    }

    fn counters(&self) -> Counters {
        self.lines.counters()
    }

    fn metadata(&self) -> MetadataTraffic {
        // What became dirty and is neither there nor forgotten was written back.
        MetadataTraffic { write_backs: self.marked - self.dirty() - self.forgotten, ..self.traffic }
    }
}

/// A cache of any shape, a step an access; of version B with its metadata cache.
fn by_steps(config: CacheConfig, metadata: Option<MetadataCache>) -> Box<dyn Cache> {
    fn of<const WAYS: usize>(config: CacheConfig, metadata: Option<MetadataCache>) -> Box<dyn Cache> {
        let Some(MetadataCache { sets, granule_bytes, policy }) = metadata else {
            return Box::new(Directory::<WAYS>::new(config));
        };
        let none = MetadataTraffic::default();
        let metadata =
            MetadataDecisions::<WAYS, META_WAYS, _>::new(&config, sets, granule_bytes, policy, none);
        Box::new(Directory::over(config, metadata))
    }
    match config.geometry.ways() {
        1 => of::<1>(config, metadata),
        2 => of::<2>(config, metadata),
        4 => of::<4>(config, metadata),
        8 => of::<8>(config, metadata),
        _ => of::<16>(config, metadata),
    }
}

/// What metadata count of themselves.
trait Counted {
    fn traffic(&self) -> MetadataTraffic;
}

impl<const WAYS: usize> Counted for OnChip<WAYS> {
    fn traffic(&self) -> MetadataTraffic {
        MetadataTraffic::default()
    }
}

impl<const WAYS: usize> Counted for MetadataDecisions<WAYS, META_WAYS, MetadataTraffic> {
    fn traffic(&self) -> MetadataTraffic {
        self.observer
    }
}

impl<const WAYS: usize, M: Metadata<WAYS> + Counted + Send> Cache for Directory<WAYS, M> {
    fn access(&mut self, lines: &[u32]) {
        for &line in lines {
            directory::access(self, LineAddr(line));
        }
    }

    fn flush(&mut self) {
        Directory::flush(self);
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn metadata(&self) -> MetadataTraffic {
        self.metadata.traffic()
    }
}
