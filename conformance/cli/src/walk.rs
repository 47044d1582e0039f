//! Step one of §4: a walk through the scene with the virtual memory and without first-level
//! caches; for each frame the working set, the collisions and the lines loaded.
//!
//! What a packet reads does not depend on the cache. So all cores trace packets on the whole
//! scene and record the addresses, and the cache sees the records in one defined order: packets in scan
//! order, frame after frame. Results are the same for any number of threads.

use crate::world::World;
use anyhow::Result;
use rayon::prelude::*;
use saarcor_model::rays::{Frame, Pipeline, RayCounts};
use saarcor_model::vm::{
    Bytes, CacheConfig, Directory, HostAddr, LineAddr, Observed, Observer, Outcome, Unit, WholeScene,
};
use serde::Serialize;
use std::ops::Range;
use std::time::Instant;

/// Packets traced before the cache is shown what they read: bounds the memory for records, and is
/// enough work for many cores.
const PACKETS_A_BATCH: u32 = 1024;

/// Rays a packet: a square tile of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketSize {
    /// Single rays.
    Rays1,
    /// 2 × 2 pixels.
    Rays4,
    /// 4 × 4 pixels.
    Rays16,
    /// 8 × 8 pixels: the standard configuration.
    Rays64,
}

impl PacketSize {
    /// Pixels along a side of a packet's tile.
    #[must_use]
    pub fn side(self) -> u32 {
        match self {
            Self::Rays1 => 1,
            Self::Rays4 => 2,
            Self::Rays16 => 4,
            Self::Rays64 => 8,
        }
    }
}

/// How pictures are traced.
#[derive(Clone, Copy, Debug)]
pub struct TraceOptions {
    /// Pixels a row, and rows.
    pub resolution: (u32, u32),
    /// Rays a packet.
    pub packet: PacketSize,
    /// Reflections and refractions that may follow one another.
    pub max_bounces: u32,
}

impl TraceOptions {
    /// Tiles a row and rows of tiles.
    #[must_use]
    pub fn tiles(&self) -> (u32, u32) {
        let ((width, height), side) = (self.resolution, self.packet.side());
        (width.div_ceil(side), height.div_ceil(side))
    }
}

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

/// What one frame did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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

/// What a walk did in all, and how long it took.
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

/// Walks through `frames` of the scene's path, in their order, and tells `each` frame's row.
///
/// # Errors
/// Those of `each`.
pub fn walk(
    world: &World,
    frames: impl IntoIterator<Item = usize>,
    options: &WalkOptions,
    each: &mut dyn FnMut(&FrameRow) -> Result<()>,
) -> Result<WalkTotals> {
    let started = Instant::now();
    let mut totals = WalkTotals::default();
    let mut cache = observed_cache(options.cache, Bytes(world.image.bytes.len() as u64));
    for frame in frames {
        cache.begin_frame(options.cold);
        let mut cache_seconds = 0.0;
        let rays = trace_frame(world, frame, &options.trace, options.cache, &mut |addresses| {
            let started = Instant::now();
            cache.play(addresses);
            cache_seconds += started.elapsed().as_secs_f64();
            Ok(())
        })?;
        let row = row(frame, rays, cache.counts(), options.cache.geometry.line());
        totals.rays += rays.total();
        totals.accesses += row.accesses;
        totals.cache_seconds += cache_seconds;
        each(&row)?;
    }
    totals.seconds = started.elapsed().as_secs_f64();
    Ok(totals)
}

/// Traces one frame and tells `each` the byte address of each access of the virtual memory, in
/// order. Of an item that straddles lines, the later addresses are those of the lines' beginnings.
///
/// # Errors
/// Those of `each`.
pub fn record_frame(
    world: &World,
    frame: usize,
    options: &WalkOptions,
    each: &mut (dyn FnMut(HostAddr) -> Result<()> + Send),
) -> Result<RayCounts> {
    trace_frame(world, frame, &options.trace, options.cache, &mut |addresses| {
        addresses.iter().try_for_each(|&addr| each(HostAddr(addr)))
    })
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

/// Traces a frame on all cores and hands the recorded addresses to `consume` in scan order, one
/// batch while the next is traced.
fn trace_frame(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    cache: CacheConfig,
    consume: &mut (dyn FnMut(&[u32]) -> Result<()> + Send),
) -> Result<RayCounts> {
    match options.packet {
        PacketSize::Rays1 => trace_packets::<1>(world, frame, options, cache, consume),
        PacketSize::Rays4 => trace_packets::<4>(world, frame, options, cache, consume),
        PacketSize::Rays16 => trace_packets::<16>(world, frame, options, cache, consume),
        PacketSize::Rays64 => trace_packets::<64>(world, frame, options, cache, consume),
    }
}

fn trace_packets<const N: usize>(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    cache: CacheConfig,
    consume: &mut (dyn FnMut(&[u32]) -> Result<()> + Send),
) -> Result<RayCounts> {
    let (width, height) = options.resolution;
    let frame = Frame::new(&world.path[frame], width, height);
    let trace_batch = |packets: Range<u32>| -> Vec<(Vec<u32>, RayCounts)> {
        let trace = |pipeline: &mut Pipeline<N>, packet| {
            let observer = Addresses { cache, recorded: Vec::new() };
            let mut memory = Observed { memory: WholeScene(&world.image.bytes), observer };
            pipeline.render(&mut memory, &world.image.registers, &frame, packet);
            (memory.observer.recorded, std::mem::take(&mut pipeline.rays))
        };
        packets.into_par_iter().map_init(|| Pipeline::new(options.max_bounces), trace).collect()
    };
    let mut consume_batch = |batch: &[(Vec<u32>, RayCounts)]| -> Result<RayCounts> {
        let mut rays = RayCounts::default();
        for (addresses, traced) in batch {
            rays += *traced;
            consume(addresses)?;
        }
        Ok(rays)
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
    Ok(rays)
}

/// What the cache did in one frame.
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
    match config.geometry.ways() {
        1 => Box::new(History::<1>::new(config, host)),
        2 => Box::new(History::<2>::new(config, host)),
        4 => Box::new(History::<4>::new(config, host)),
        8 => Box::new(History::<8>::new(config, host)),
        _ => Box::new(History::<16>::new(config, host)),
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
    touched: u32,
    evicted: u32,
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
            self.counts.working_set += u64::from(history.touched != self.frame);
            history.touched = self.frame;
            if let Outcome::Miss { evicted, .. } = self.directory.access(line) {
                self.counts.loaded += 1;
                // It lay in the cache at some time of this frame if it was evicted in it.
                self.counts.collisions += u64::from(history.evicted == self.frame);
                if let Some(evicted) = evicted {
                    self.lines[evicted.0 as usize].evicted = self.frame;
                }
            }
        }
    }

    fn counts(&self) -> FrameCounts {
        self.counts
    }
}
