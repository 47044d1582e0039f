//! Virtual memories of any configurations that see the same reads (WK-1, WK-2), and what each does in a frame.
//!
//! Caches of equally long lines share what depends on nothing else: how often lines are touched, and which. LRU caches that
//! differ in their ways alone share their stacks ([`Stacks`]): one pass counts for all of them.

use crate::dispatch::{ForWays, with_ways};
use fixedbitset::FixedBitSet;
use rayon::prelude::*;
use saarcor_fast::directory;
use saarcor_fast::stacks::Stacks;
use saarcor_model::vm::{Bytes, CacheConfig, Directory, HostAddr, LineAddr, Outcome, Policy, SetIndex};

/// What a unit reads: so many bytes from an address on.
pub type Read = (HostAddr, u32);

/// Counts of a virtual memory in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameCounts {
    /// Lines touched, as often as they were.
    pub accesses: u64,
    /// Lines loaded.
    pub loaded: u64,
    /// Distinct lines touched.
    pub working_set: u64,
    /// Loads of lines that had been resident.
    pub collisions: u64,
}

/// Some virtual memories.
pub struct Caches {
    by_line: Vec<OfLine>,
    /// How many there are.
    count: usize,
}

impl Caches {
    /// Empty caches in front of `host` bytes of host memory.
    #[must_use]
    pub fn new(configs: &[CacheConfig], host: Bytes) -> Self {
        let mut by_line: Vec<OfLine> = Vec::new();
        for (index, &config) in configs.iter().enumerate() {
            let line = config.geometry.line();
            let place = by_line.iter().position(|other| other.config.geometry.line() == line);
            let place = place.unwrap_or_else(|| {
                by_line.push(OfLine::new(config, host));
                by_line.len() - 1
            });
            by_line[place].add(index, config);
        }
        Self { by_line, count: configs.len() }
    }

    /// Begins a frame, with empty caches if `cold`.
    pub fn begin_frame(&mut self, cold: bool) {
        for of_line in &mut self.by_line {
            of_line.touched.clear();
            (of_line.accesses, of_line.working_set) = (0, 0);
            of_line.played.iter_mut().for_each(|played| played.begin_frame(cold));
        }
    }

    /// Plays what units read, in this order.
    pub fn play(&mut self, reads: impl Iterator<Item = Read> + Clone + Sync) {
        self.by_line.par_iter_mut().for_each(|of_line| of_line.play(reads.clone()));
    }

    /// What each has done since the frame began, in the order of the configurations.
    #[must_use]
    pub fn counts(&self) -> Vec<FrameCounts> {
        let mut counts = vec![FrameCounts::default(); self.count];
        for OfLine { accesses, working_set, played, .. } in &self.by_line {
            let (accesses, working_set) = (*accesses, *working_set);
            for Loads { index, loaded, collisions } in played.iter().flat_map(|played| played.loads()) {
                counts[index] = FrameCounts { accesses, loaded, working_set, collisions };
            }
        }
        counts
    }
}

/// The use of a line.
#[derive(Clone, Copy, Debug)]
struct Use {
    line: LineAddr,
    /// It is the first one in this frame.
    is_first: bool,
}

/// All caches whose lines are equally long.
struct OfLine {
    /// One of them, which says which lines a read touches.
    config: CacheConfig,
    /// Lines of the host.
    lines: usize,
    /// Those that the frame has touched.
    touched: FixedBitSet,
    accesses: u64,
    working_set: u64,
    /// The uses that are being played.
    uses: Vec<Use>,
    played: Vec<Box<dyn Played>>,
}

impl OfLine {
    fn new(config: CacheConfig, host: Bytes) -> Self {
        let lines = host.0.div_ceil(config.geometry.line().0) as usize;
        Self {
            config,
            lines,
            touched: FixedBitSet::with_capacity(lines),
            accesses: 0,
            working_set: 0,
            uses: Vec::new(),
            played: Vec::new(),
        }
    }

    /// Adds the cache of number `index`, to others whose stacks it can share if there are such.
    fn add(&mut self, index: usize, config: CacheConfig) {
        if config.policy != Policy::Lru {
            let cache = NewCache { index, config, lines: self.lines };
            return self.played.push(with_ways(config.geometry.ways(), cache));
        }
        if !self.played.iter_mut().any(|played| played.takes(index, config)) {
            self.played.push(Box::new(OnStacks::new(index, config)));
        }
    }

    fn play(&mut self, reads: impl Iterator<Item = Read>) {
        self.uses.clear();
        let mut last = None;
        for (addr, bytes) in reads {
            for line in self.config.lines_of(addr, bytes.into()) {
                self.accesses += 1;
                // The same line again hits and changes nothing, whatever the policy (a law of the set).
                if last == Some(line) {
                    continue;
                }
                last = Some(line);
                let is_first = !self.touched.put(line as usize);
                self.working_set += u64::from(is_first);
                self.uses.push(Use { line: LineAddr(line as u32), is_first });
            }
        }
        let Self { uses, played, .. } = self;
        played.par_iter_mut().for_each(|played| played.play(uses));
    }
}

/// What a cache loads in a frame.
struct Loads {
    /// Number of the cache.
    index: usize,
    loaded: u64,
    collisions: u64,
}

/// One cache, or several that are played together.
trait Played: Send {
    /// Begins a frame, with empty caches if `cold`.
    fn begin_frame(&mut self, cold: bool);
    /// Plays uses of lines, of which none is that of the line before.
    fn play(&mut self, uses: &[Use]);
    /// What each has loaded since the frame began.
    fn loads(&self) -> Vec<Loads>;
    /// Takes the cache of number `index`, if it can be played together with these.
    fn takes(&mut self, index: usize, config: CacheConfig) -> bool;
}

/// What is needed for a cache by itself.
struct NewCache {
    index: usize,
    config: CacheConfig,
    lines: usize,
}

impl ForWays for NewCache {
    type Output = Box<dyn Played>;

    fn run<const WAYS: usize>(self) -> Self::Output {
        let Self { index, config, lines } = self;
        Box::new(OneCache::<WAYS> {
            directory: Directory::new(config),
            resident: (config.policy == Policy::Fifo).then(|| FixedBitSet::with_capacity(lines)),
            evicted: FixedBitSet::with_capacity(lines),
            loads: Loads { index, loaded: 0, collisions: 0 },
        })
    }
}

/// One cache by itself.
struct OneCache<const WAYS: usize> {
    directory: Directory<WAYS>,
    /// With FIFO, the resident lines: to use one of them changes nothing.
    resident: Option<FixedBitSet>,
    /// The lines that the frame has evicted.
    evicted: FixedBitSet,
    loads: Loads,
}

impl<const WAYS: usize> Played for OneCache<WAYS> {
    fn begin_frame(&mut self, cold: bool) {
        self.evicted.clear();
        (self.loads.loaded, self.loads.collisions) = (0, 0);
        if cold {
            self.directory.flush();
            self.resident.iter_mut().for_each(FixedBitSet::clear);
        }
    }

    fn play(&mut self, uses: &[Use]) {
        for &Use { line, .. } in uses {
            if self.resident.as_ref().is_some_and(|resident| resident.contains(line.0 as usize)) {
                continue;
            }
            if let Outcome::Miss { evicted, .. } = directory::access(&mut self.directory, line) {
                self.loads.loaded += 1;
                // It lay in the cache at some time of this frame if it was evicted in it.
                self.loads.collisions += u64::from(self.evicted.contains(line.0 as usize));
                if let Some(evicted) = evicted {
                    self.evicted.insert(evicted.0 as usize);
                }
                if let Some(resident) = &mut self.resident {
                    resident.insert(line.0 as usize);
                    evicted.into_iter().for_each(|evicted| resident.remove(evicted.0 as usize));
                }
            }
        }
    }

    fn loads(&self) -> Vec<Loads> {
        vec![Loads { ..self.loads }]
    }

    fn takes(&mut self, _: usize, _: CacheConfig) -> bool {
        false
    }
}

/// LRU caches of one number of sets.
struct OnStacks {
    stacks: Stacks,
    /// Number and ways of each.
    caches: Vec<(usize, usize)>,
    /// The stacks as they were when the frame began, of the sets that it has changed.
    before: Stacks,
    changed: FixedBitSet,
    /// Loads of caches of so many ways are the sum of those from there on.
    depths: Vec<u64>,
    /// Collisions of caches of so many ways are the sum of these up to there.
    collisions: Vec<i64>,
}

impl OnStacks {
    fn new(index: usize, config: CacheConfig) -> Self {
        let CacheConfig { geometry, hash, .. } = config;
        let ways = geometry.ways() as usize;
        let stacks = Stacks::new(hash, geometry.set_bits(), ways as u8);
        Self {
            changed: FixedBitSet::with_capacity(stacks.held.len()),
            before: stacks.clone(),
            depths: vec![0; ways + 1],
            collisions: vec![0; ways + 2],
            caches: vec![(index, ways)],
            stacks,
        }
    }

    /// Keeps the stack of a set as it is.
    fn keep(&mut self, set: SetIndex) {
        let (held, begin) = (self.stacks.stack(set).len(), set.0 as usize * self.stacks.depth);
        self.before.lines[begin..begin + held].copy_from_slice(self.stacks.stack(set));
        self.before.held[set.0 as usize] = held as u8;
    }

    /// How far down on its stack `line` lay when the frame began; none if it was not there.
    fn depth_before(&self, set: SetIndex, line: LineAddr) -> Option<usize> {
        let stacks = if self.changed.contains(set.0 as usize) { &self.before } else { &self.stacks };
        stacks.stack(set).iter().position(|other| *other == line)
    }
}

impl Played for OnStacks {
    fn begin_frame(&mut self, cold: bool) {
        if cold {
            self.stacks.flush();
        }
        self.changed.clear();
        self.depths.fill(0);
        self.collisions.fill(0);
    }

    fn play(&mut self, uses: &[Use]) {
        for &Use { line, is_first } in uses {
            if self.stacks.is_on_top(line) {
                continue;
            }
            let set = self.stacks.set_of(line);
            // A line that the frame has touched has been resident in any cache; another, where it lay when the frame began.
            let resident_from = if is_first { self.depth_before(set, line) } else { Some(0) };
            if !self.changed.put(set.0 as usize) {
                self.keep(set);
            }
            let misses_up_to = self.stacks.access(line).unwrap_or(self.stacks.depth);
            self.depths[misses_up_to] += 1;
            if let Some(from) = resident_from {
                self.collisions[from + 1] += 1;
                self.collisions[misses_up_to + 1] -= 1;
            }
        }
    }

    fn loads(&self) -> Vec<Loads> {
        let loads = |&(index, ways): &(usize, usize)| Loads {
            index,
            loaded: self.depths[ways..].iter().sum(),
            collisions: self.collisions[..=ways].iter().sum::<i64>() as u64,
        };
        self.caches.iter().map(loads).collect()
    }

    fn takes(&mut self, index: usize, config: CacheConfig) -> bool {
        let ways = config.geometry.ways() as usize;
        let is_alike = config.policy == Policy::Lru
            && (config.hash, config.geometry.set_bits()) == (self.stacks.hash, self.stacks.set_bits);
        if is_alike {
            if ways > self.stacks.depth {
                *self = Self { caches: std::mem::take(&mut self.caches), ..Self::new(index, config) };
            }
            self.caches.push((index, ways));
        }
        is_alike
    }
}
