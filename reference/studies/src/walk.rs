//! Step one of §4: a walk through the scene with the virtual memory and without first-level
//! caches; for each frame the working set, the collisions and the lines loaded.
//!
//! What a packet reads does not depend on the cache. So all cores trace packets on the whole scene
//! and record the addresses, and the cache sees the records in one defined order: packets in scan
//! order, frame after frame. Results are the same for any number of threads.

use crate::caches::{Caches, FrameCounts, Read};
use crate::dispatch::{ForPackets, with_packets};
use crate::trace::TraceOptions;
use crate::world::World;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::rays::{Frame, Pipeline, RayCounts};
use saarcor_model::vm::{Bytes, CacheConfig, HostAddr, LineAddr, Observed, Observer, Unit, WholeScene};
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

impl FrameRow {
    /// The row of a frame with these rays, in whose virtual memory, of lines of `line` bytes, this happened.
    #[must_use]
    pub fn new(frame: u64, rays: RayCounts, counts: FrameCounts, line: Bytes) -> Self {
        Self {
            frame,
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
    /// The virtual memories: that of the options first.
    configs: Vec<CacheConfig>,
    caches: Caches,
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
    #[must_use]
    pub fn with_others(
        world: &'a World,
        frames: impl IntoIterator<Item = usize, IntoIter: 'a>,
        options: &WalkOptions,
        others: &[CacheConfig],
    ) -> Self {
        let host = Bytes(world.image.bytes.len() as u64);
        let configs: Vec<_> = std::iter::once(&options.cache).chain(others).copied().collect();
        Self {
            world,
            frames: Box::new(frames.into_iter()),
            options: *options,
            caches: Caches::new(&configs, host),
            configs,
            totals: WalkTotals::default(),
        }
    }

    /// The rows of the next frame, one a virtual memory: that of the options first.
    ///
    /// # Panics
    /// If the path does not have the frame.
    pub fn next_of_each(&mut self) -> Option<Vec<FrameRow>> {
        let frame = self.frames.next()?;
        let (started, WalkOptions { cold, trace, .. }) = (Instant::now(), self.options);
        let (caches, mut cache_seconds) = (&mut self.caches, 0.0);
        caches.begin_frame(cold);
        let traced = trace_frame(self.world, frame, &trace, &mut |packets| {
            let started = Instant::now();
            caches.play(packets.iter().flat_map(|packet| packet.reads.iter().copied()));
            cache_seconds += started.elapsed().as_secs_f64();
            ControlFlow::Continue(())
        });
        let rays = traced.continue_value().unwrap_or_default();
        let counts = self.caches.counts();
        let rows: Vec<FrameRow> = self
            .configs
            .iter()
            .zip(counts)
            .map(|(config, counts)| FrameRow::new(frame as u64, rays, counts, config.geometry.line()))
            .collect();
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
    let traced = trace_frame(world, frame, &options.trace, &mut |packets| {
        let reads = packets.iter().flat_map(|packet| &packet.reads);
        let mut addresses = reads.flat_map(|&(addr, bytes)| accesses(options.cache, addr, bytes.into()));
        failed = addresses.find_map(|addr| each(addr).err());
        if failed.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    match failed {
        Some(error) => Err(error),
        None => Ok(traced.continue_value().unwrap_or_default()),
    }
}

/// The accesses of the virtual memory that reading `bytes` at `addr` makes: the address itself, and
/// the beginning of each further line.
fn accesses(cache: CacheConfig, addr: HostAddr, bytes: u64) -> impl Iterator<Item = HostAddr> {
    let lines = cache.lines_of(addr, bytes);
    let further = (lines.start + 1..lines.end).map(move |line| LineAddr(line as u32));
    std::iter::once(addr).chain(further.map(move |line| cache.geometry.first_byte(line)))
}

/// Records what units read.
struct Reads(Vec<Read>);

impl Observer for Reads {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: usize) {
        self.0.push((addr, bytes as u32));
    }
}

/// What a packet reads, and its rays.
struct TracedPacket {
    reads: Vec<Read>,
    rays: RayCounts,
}

/// Takes traced packets; a break ends the tracing.
type Consume<'a> = dyn FnMut(&[TracedPacket]) -> ControlFlow<()> + Send + 'a;

/// Traces a frame on all cores and hands its packets to `consume` in scan order, one batch while the
/// next is traced.
fn trace_frame(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    consume: &mut Consume<'_>,
) -> ControlFlow<(), RayCounts> {
    let (width, height) = options.resolution;
    let frame = Frame::new(&world.path[frame], width, height);
    let work = TraceFrame { world, frame, max_bounces: options.max_bounces, consume };
    with_packets(options.packet, work)
}

struct TraceFrame<'a> {
    world: &'a World,
    frame: Frame,
    max_bounces: u32,
    consume: &'a mut Consume<'a>,
}

impl ForPackets for TraceFrame<'_> {
    type Output = ControlFlow<(), RayCounts>;

    fn run<const N: usize>(self) -> Self::Output {
        let Self { world, frame, max_bounces, consume } = self;
        let trace_batch = |packets: Range<u32>| -> Vec<TracedPacket> {
            // A packet reads about as much as the one before it: room for that is taken at once.
            let trace = |(pipeline, reads): &mut (Pipeline<N, _>, usize), packet| {
                let observer = Reads(Vec::with_capacity(*reads));
                let mut memory = Observed { memory: WholeScene(&world.image.bytes), observer };
                pipeline.render(&mut memory, &world.image.registers, &frame, packet);
                *reads = memory.observer.0.len();
                TracedPacket { reads: memory.observer.0, rays: std::mem::take(&mut pipeline.rays) }
            };
            packets
                .into_par_iter()
                .map_init(|| (Pipeline::with(FilteredIntersection::default(), max_bounces), 0), trace)
                .collect()
        };
        let mut consume_batch = |batch: &[TracedPacket]| {
            let mut rays = RayCounts::default();
            batch.iter().for_each(|packet| rays += packet.rays);
            consume(batch)?;
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
