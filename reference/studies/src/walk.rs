//! Step one of §4: a walk through the scene with the virtual memory and without first-level
//! caches; for each frame the working set, the collisions and the lines loaded.
//!
//! What a packet reads does not depend on the cache. So all cores trace packets on the whole scene
//! and record the addresses, and the cache sees the records in one defined order: packets in scan
//! order, frame after frame. Results are the same for any number of threads.

use crate::dispatch::{ForPackets, ForWays, with_packets, with_ways};
use crate::trace::TraceOptions;
use crate::world::World;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_fast::directory;
use saarcor_model::rays::{Frame, Pipeline, RayCounts};
use saarcor_model::vm::{
    Bytes, CacheConfig, Directory, HostAddr, LineAddr, Observed, Observer, Outcome, Unit, WholeScene,
};
use serde::Serialize;
use std::ops::{ControlFlow, Range};
use std::time::Instant;

/// Packets traced before the cache plays their reads: bounds the memory for records, and is enough work
/// for many cores.
const PACKETS_A_BATCH: u32 = 1024;

/// How a walk is made.
#[derive(Clone, Copy, Debug)]
pub struct WalkOptions {
    /// The virtual memory.
    pub cache: CacheConfig,
    /// Each frame begins with an empty cache.
    pub cold: bool,
    /// How the frames are traced.
    pub trace: TraceOptions,
}

/// Traffic and working set of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FrameRow {
    /// Number of the frame in the path.
    pub frame: u64,
    /// Rays from the camera.
    pub primary_rays: u64,
    /// Rays towards lights.
    pub shadow_rays: u64,
    /// Reflected and refracted rays.
    pub secondary_rays: u64,
    /// Lines touched, as often as they were: an item that straddles two lines is two accesses.
    pub accesses: u64,
    /// Accesses to resident lines.
    pub hits: u64,
    /// Accesses that loaded a line.
    pub misses: u64,
    /// Distinct lines touched.
    pub working_set_lines: u64,
    /// Bytes of the distinct lines touched.
    pub working_set_bytes: u64,
    /// Loads of a line that had been resident earlier in this frame.
    pub collisions: u64,
    /// Lines loaded from the host, each as often as it was.
    pub loaded_lines: u64,
    /// Bytes loaded from the host.
    pub loaded_bytes: u64,
}

/// Totals of a walk, and its time.
#[derive(Clone, Copy, Debug, Default)]
pub struct WalkTotals {
    /// Rays of all kinds.
    pub rays: u64,
    /// Accesses of the virtual memory.
    pub accesses: u64,
    /// Seconds of the whole walk.
    pub seconds: f64,
    /// Seconds during which the cache was simulated; tracing goes on at the same time.
    pub cache_seconds: f64,
}

/// A walk through some frames of a scene's path: an iterator over their rows.
pub struct Walk<'a> {
    world: &'a World,
    frames: Box<dyn Iterator<Item = usize> + 'a>,
    options: WalkOptions,
    caches: Vec<Box<dyn ObservedCache>>,
    totals: WalkTotals,
}

impl<'a> Walk<'a> {
    /// A walk through `frames` in their order. Nothing is traced before the first row is asked for.
    #[must_use]
    pub fn new(
        world: &'a World,
        frames: impl IntoIterator<Item = usize, IntoIter: 'a>,
        options: &WalkOptions,
    ) -> Self {
        Self::with_others(world, frames, options, &[])
    }

    /// The same with other virtual memories beside that of the options: each frame is traced once for all of them.
    ///
    /// # Panics
    /// If not all lines are equally long.
    #[must_use]
    pub fn with_others(
        world: &'a World,
        frames: impl IntoIterator<Item = usize, IntoIter: 'a>,
        options: &WalkOptions,
        others: &[CacheConfig],
    ) -> Self {
        let host = Bytes(world.image.bytes.len() as u64);
        let line = options.cache.geometry.line();
        assert!(others.iter().all(|other| other.geometry.line() == line), "lines are equally long");
        let all = std::iter::once(&options.cache).chain(others);
        Self {
            world,
            frames: Box::new(frames.into_iter()),
            options: *options,
            caches: all.map(|cache| observed_cache(*cache, host)).collect(),
            totals: WalkTotals::default(),
        }
    }

    /// The rows of the next frame, one a virtual memory: that of the options first.
    ///
    /// # Panics
    /// If the path does not have the frame.
    pub fn next_of_each(&mut self) -> Option<Vec<FrameRow>> {
        let frame = self.frames.next()?;
        let (started, WalkOptions { cache: config, cold, trace }) = (Instant::now(), self.options);
        let (caches, mut cache_seconds) = (&mut self.caches, 0.0);
        caches.iter_mut().for_each(|cache| cache.begin_frame(cold));
        let traced = trace_frame(self.world, frame, &trace, config, &mut |addresses| {
            let started = Instant::now();
            caches.iter_mut().for_each(|cache| cache.play(addresses));
            cache_seconds += started.elapsed().as_secs_f64();
            ControlFlow::Continue(())
        });
        let rays = traced.continue_value().unwrap_or_default();
        let line = config.geometry.line();
        let rows: Vec<FrameRow> =
            self.caches.iter().map(|cache| row(frame, rays, cache.counts(), line)).collect();
        self.totals.rays += rays.total();
        self.totals.accesses += rows.iter().map(|row| row.accesses).sum::<u64>();
        self.totals.cache_seconds += cache_seconds;
        self.totals.seconds += started.elapsed().as_secs_f64();
        Some(rows)
    }

    /// The totals so far.
    #[must_use]
    pub fn totals(&self) -> WalkTotals {
        self.totals
    }
}

impl Iterator for Walk<'_> {
    type Item = FrameRow;

    /// The row of the next frame.
    ///
    /// # Panics
    /// If the path does not have the frame.
    fn next(&mut self) -> Option<FrameRow> {
        self.next_of_each()?.into_iter().next()
    }
}

/// Traces one frame and gives `each` the byte address of each access of the virtual memory, in
/// order. Of an item that straddles lines, the later addresses are those of the lines' beginnings.
///
/// # Errors
/// The first of `each`, after which nothing more is traced.
///
/// # Panics
/// If the path does not have the frame.
pub fn record_frame<E: Send>(
    world: &World,
    frame: usize,
    options: &WalkOptions,
    each: &mut (dyn FnMut(HostAddr) -> Result<(), E> + Send),
) -> Result<RayCounts, E> {
    let mut failed = None;
    let traced = trace_frame(world, frame, &options.trace, options.cache, &mut |addresses| {
        failed = addresses.iter().find_map(|&addr| each(HostAddr(addr)).err());
        if failed.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    match failed {
        Some(error) => Err(error),
        None => Ok(traced.continue_value().unwrap_or_default()),
    }
}

fn row(frame: usize, rays: RayCounts, counts: FrameCounts, line: Bytes) -> FrameRow {
    FrameRow {
        frame: frame as u64,
        primary_rays: rays.primary,
        shadow_rays: rays.shadow,
        secondary_rays: rays.secondary,
        accesses: counts.accesses,
        hits: counts.accesses - counts.loaded,
        misses: counts.loaded,
        working_set_lines: counts.working_set,
        working_set_bytes: counts.working_set * line.0,
        collisions: counts.collisions,
        loaded_lines: counts.loaded,
        loaded_bytes: counts.loaded * line.0,
    }
}

/// The accesses of the virtual memory that reading `bytes` at `addr` makes: the address itself, and
/// the beginning of each further line.
pub fn accesses(cache: CacheConfig, addr: HostAddr, bytes: u64) -> impl Iterator<Item = u32> {
    let lines = cache.lines_of(addr, bytes);
    let further = (lines.start + 1..lines.end).map(move |line| LineAddr(line as u32));
    std::iter::once(addr.0).chain(further.map(move |line| cache.geometry.first_byte(line).0))
}

/// Records which addresses the virtual memory would be asked for.
struct Addresses {
    cache: CacheConfig,
    recorded: Vec<u32>,
}

impl Observer for Addresses {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: usize) {
        self.recorded.extend(accesses(self.cache, addr, bytes as u64));
    }
}

/// Takes the addresses that one packet reads; a break ends the tracing.
type Consume<'a> = dyn FnMut(&[u32]) -> ControlFlow<()> + Send + 'a;

/// Traces a frame on all cores and hands the recorded addresses to `consume` in scan order, one
/// batch while the next is traced.
fn trace_frame(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    cache: CacheConfig,
    consume: &mut Consume<'_>,
) -> ControlFlow<(), RayCounts> {
    let (width, height) = options.resolution;
    let frame = Frame::new(&world.path[frame], width, height);
    let work = TraceFrame { world, frame, max_bounces: options.max_bounces, cache, consume };
    with_packets(options.packet, work)
}

struct TraceFrame<'a> {
    world: &'a World,
    frame: Frame,
    max_bounces: u32,
    cache: CacheConfig,
    consume: &'a mut Consume<'a>,
}

impl ForPackets for TraceFrame<'_> {
    type Output = ControlFlow<(), RayCounts>;

    fn run<const N: usize>(self) -> Self::Output {
        let Self { world, frame, max_bounces, cache, consume } = self;
        let trace_batch = |packets: Range<u32>| -> Vec<(Vec<u32>, RayCounts)> {
            let trace = |pipeline: &mut Pipeline<N, _>, packet| {
                let observer = Addresses { cache, recorded: Vec::new() };
                let mut memory = Observed { memory: WholeScene(&world.image.bytes), observer };
                pipeline.render(&mut memory, &world.image.registers, &frame, packet);
                (memory.observer.recorded, std::mem::take(&mut pipeline.rays))
            };
            packets
                .into_par_iter()
                .map_init(|| Pipeline::with(FilteredIntersection::default(), max_bounces), trace)
                .collect()
        };
        let mut consume_batch = |batch: &[(Vec<u32>, RayCounts)]| {
            let mut rays = RayCounts::default();
            for (addresses, traced) in batch {
                rays += *traced;
                consume(addresses)?;
            }
            ControlFlow::Continue(rays)
        };
        let packets = frame.packets::<N>();
        // As many rays a batch for any size of packet.
        let step = PACKETS_A_BATCH * (64 / N as u32);
        let mut rays = RayCounts::default();
        let mut batch = trace_batch(0..packets.min(step));
        let mut begin = step;
        while begin < packets {
            let next = begin..packets.min(begin + step);
            let (traced, consumed) = rayon::join(|| trace_batch(next), || consume_batch(&batch));
            rays += consumed?;
            batch = traced;
            begin += step;
        }
        rays += consume_batch(&batch)?;
        ControlFlow::Continue(rays)
    }
}

/// Counts of the cache in one frame.
#[derive(Clone, Copy, Debug, Default)]
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

/// A cache whose number of ways the caller need not know.
pub trait ObservedCache: Send {
    /// Begins a frame, with an empty cache if `cold`.
    fn begin_frame(&mut self, cold: bool);
    /// Accesses the lines at these addresses.
    fn play(&mut self, addresses: &[u32]);
    /// What happened since the frame began.
    fn counts(&self) -> FrameCounts;
}

/// An empty cache in front of `host` bytes of host memory.
#[must_use]
pub fn observed_cache(config: CacheConfig, host: Bytes) -> Box<dyn ObservedCache> {
    with_ways(config.geometry.ways(), NewCache { config, host })
}

struct NewCache {
    config: CacheConfig,
    host: Bytes,
}

impl ForWays for NewCache {
    type Output = Box<dyn ObservedCache>;

    fn run<const WAYS: usize>(self) -> Self::Output {
        Box::new(History::<WAYS>::new(self.config, self.host))
    }
}

/// A directory and, for each line of host memory, when it was last touched and evicted.
struct History<const WAYS: usize> {
    directory: Directory<WAYS>,
    /// Frames begun so far. Frame numbers below count from 1; 0 is never.
    frame: u32,
    lines: Vec<LineHistory>,
    counts: FrameCounts,
}

#[derive(Clone, Copy, Default)]
struct LineHistory {
    /// The frame in which the line was last touched.
    touched_in: u32,
    /// The frame in which it was last evicted.
    evicted_in: u32,
}

impl<const WAYS: usize> History<WAYS> {
    fn new(config: CacheConfig, host: Bytes) -> Self {
        let lines = host.0.div_ceil(config.geometry.line().0) as usize;
        Self {
            directory: Directory::new(config),
            frame: 0,
            lines: vec![LineHistory::default(); lines],
            counts: FrameCounts::default(),
        }
    }
}

impl<const WAYS: usize> ObservedCache for History<WAYS> {
    fn begin_frame(&mut self, cold: bool) {
        self.frame += 1;
        self.counts = FrameCounts::default();
        if cold {
            self.directory.flush();
        }
    }

    fn play(&mut self, addresses: &[u32]) {
        let geometry = self.directory.config.geometry;
        self.counts.accesses += addresses.len() as u64;
        let mut last = None;
        for &addr in addresses {
            let line = geometry.line_of(HostAddr(addr));
            // The same line again hits and changes nothing, whatever the policy (a law of the set).
            if last == Some(line) {
                continue;
            }
            last = Some(line);
            let history = &mut self.lines[line.0 as usize];
            self.counts.working_set += u64::from(history.touched_in != self.frame);
            history.touched_in = self.frame;
            if let Outcome::Miss { evicted, .. } = directory::access(&mut self.directory, line) {
                self.counts.loaded += 1;
                // It lay in the cache at some time of this frame if it was evicted in it.
                self.counts.collisions += u64::from(history.evicted_in == self.frame);
                if let Some(evicted) = evicted {
                    self.lines[evicted.0 as usize].evicted_in = self.frame;
                }
            }
        }
    }

    fn counts(&self) -> FrameCounts {
        self.counts
    }
}
