//! Step two of §4: frames on the chip, exact to the cycle.
//!
//! [`record`] traces a frame once, on all cores; [`simulate`](saarcor_fast::chip::simulate) plays what was recorded on any number of chips; [`TimingRow`]
//! is the result of a run.

use crate::dispatch::{ForPackets, with_packets};
use crate::error::ParseError;
use crate::names::version_name;
use crate::picture::{Picture, put_pixels};
use crate::trace::{PacketOrder, TraceOptions};
use crate::world::World;
use glam::Vec3;
use image::RgbImage;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_fast::chip::ChipObserver;
use saarcor_model::rays::{Frame, Pipeline, RayCounts};
use saarcor_model::time::{
    Burst, CacheReport, ChipConfig, Command, Direction, Load, Program, Programs, Recorder, Stall,
    TimingReport, UNIT_NAMES, UnitReport,
};
use saarcor_model::vm::{HostAddr, Observed, WholeScene};
use saarcor_oracles::card::CardShadow;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Packets traced before their colours are put into the picture: bounds the memory for colours.
const PACKETS_A_BATCH: usize = 4096;

/// A traced frame: the programs of its packets, and the picture.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The programs of the packets.
    pub programs: Programs,
    /// The picture and its rays.
    pub picture: Picture,
}

/// Traces a frame of the world's path on all cores, for a chip that is handed packets in `order`.
///
/// # Panics
/// If the path does not have the frame.
#[must_use]
pub fn record(world: &World, frame: usize, options: &TraceOptions, order: PacketOrder) -> Recording {
    let (width, height) = options.resolution;
    let order = order.packets(options.tiles());
    let mut packets: Vec<Program> = Vec::with_capacity(order.len());
    let mut pixels = RgbImage::new(width, height);
    let mut rays = RayCounts::default();
    trace_packets(world, frame, options, &order, &mut |traced| {
        packets.push(traced.program);
        put_pixels(&mut pixels, traced.pixels);
        rays += traced.rays;
    });
    let programs = Programs { packets, triangles: world.image.registers.triangles };
    Recording { programs, picture: Picture { pixels, rays } }
}

/// How many frames before a frame warm the caches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WarmUp(usize);

impl WarmUp {
    /// The frame before.
    pub const ONE: Self = Self::frames(1);
    /// The whole path up to the frame.
    pub const WALK: Self = Self(usize::MAX);

    /// So many.
    #[must_use]
    pub const fn frames(number: usize) -> Self {
        Self(number)
    }

    /// So many of them are there before a frame of a path.
    #[must_use]
    pub fn before(self, frame: usize) -> usize {
        self.0.min(frame)
    }
}

impl FromStr for WarmUp {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        match text {
            "walk" => Ok(Self::WALK),
            number => number
                .parse()
                .map(Self)
                .map_err(|_| ParseError::new("write a number of frames, or walk for all frames before")),
        }
    }
}

impl fmt::Display for WarmUp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::WALK => f.write_str("walk"),
            Self(number) => write!(f, "{number}"),
        }
    }
}

impl Serialize for WarmUp {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The programs of the `warm_up` frames before a frame, as far as the path has them: each is traced when it is asked for.
/// `report` learns the part that is done.
pub fn record_before<'a>(
    world: &'a World,
    frame: usize,
    warm_up: usize,
    options: &'a TraceOptions,
    order: PacketOrder,
    report: &'a (dyn Fn(f64) + Sync),
) -> impl ExactSizeIterator<Item = Programs> + 'a {
    let first = frame - warm_up.min(frame);
    (first..frame).map(move |before| {
        report((before - first) as f64 / (frame - first) as f64);
        record(world, before, options, order).programs
    })
}

/// A packet, traced.
struct TracedPacket<'a> {
    program: Program,
    /// Where the colour of each of its rays belongs, if it is in the picture.
    pixels: &'a [(Option<(u32, u32)>, Vec3)],
    rays: RayCounts,
}

/// Traces packets on all cores, and gives them to `each` in their order.
fn trace_packets(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    packets: &[u32],
    each: &mut dyn FnMut(TracedPacket<'_>),
) {
    let (width, height) = options.resolution;
    let frame = Frame::new(&world.path[frame], width, height);
    let work = TracePackets { world, frame, max_bounces: options.max_bounces, packets, each };
    with_packets(options.packet, work);
}

struct TracePackets<'a> {
    world: &'a World,
    frame: Frame,
    max_bounces: u32,
    packets: &'a [u32],
    each: &'a mut dyn FnMut(TracedPacket<'_>),
}

impl ForPackets for TracePackets<'_> {
    type Output = ();

    fn run<const N: usize>(self) {
        let Self { world, frame, max_bounces, packets, each } = self;
        let tools = || {
            let memory = Observed { memory: WholeScene(&world.image.bytes), observer: Recorder::default() };
            (Pipeline::with(FilteredIntersection::default(), max_bounces), memory)
        };
        let registers = &world.image.registers;
        for batch in packets.chunks(PACKETS_A_BATCH) {
            let trace =
                |(pipeline, memory): &mut (Pipeline<N, FilteredIntersection<N>>, Observed<_, Recorder>),
                 &packet: &u32| {
                    let colours = pipeline.render(memory, registers, &frame, packet);
                    (memory.observer.take(), colours, std::mem::take(&mut pipeline.rays))
                };
            let traced: Vec<_> = batch.par_iter().map_init(tools, trace).collect();
            for (&packet, (program, colours, rays)) in batch.iter().zip(traced) {
                let places = frame.pixels::<N>(packet);
                let pixels: [_; N] = std::array::from_fn(|ray| (places[ray], colours[ray]));
                each(TracedPacket { program, pixels: &pixels, rays });
            }
        }
    }
}

/// Watches a run of the chip: an observer for [`simulate_observed`](saarcor_fast::chip::simulate_observed).
#[derive(Default)]
pub struct Watch<'a, 'host> {
    /// A shadow of the card: each part that the chip reads from the card is compared with the bytes of the
    /// host. The shadow knows how many were compared, and the first that differs.
    pub shadow: Option<&'a mut CardShadow<'host>>,
    /// Gets each command of the memory chips, with its clock.
    pub commands: Option<&'a mut dyn FnMut(u64, Command)>,
}

impl ChipObserver for Watch<'_, '_> {
    fn line_is_written(&mut self, _: u64, load: Load) {
        if let Some(shadow) = &mut self.shadow {
            shadow.write(load);
        }
    }

    fn part_is_read(&mut self, now: u64, addr: HostAddr, bytes: u64, card: u64) {
        if let Some(shadow) = &mut self.shadow {
            shadow.read(now, addr, bytes, card);
        }
    }

    fn command(&mut self, clock: u64, command: Command) {
        if let Some(commands) = &mut self.commands {
            commands(clock, command);
        }
    }
}

/// A command of the memory chips as a line of CSV, behind
/// [`HEADER`](saarcor_oracles::memory_protocol::HEADER). Fields that it does not have are empty.
#[must_use]
pub fn command_line(clock: u64, command: Command) -> String {
    match command {
        Command::Open(bank, row) => format!("{clock},ACT,{bank},{row},,"),
        Command::Move(Burst { bank, row, column, beats, direction }) => {
            let name = if direction == Direction::Read { "RD" } else { "WR" };
            format!("{clock},{name},{bank},{row},{column},{beats}")
        }
        Command::Close(bank) => format!("{clock},PRE,{bank},,,"),
        Command::CloseAll => format!("{clock},PRE,all,,,"),
        Command::Refresh => format!("{clock},REF,all,,,"),
    }
}

/// Time and traffic of one frame on a chip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimingRow {
    /// As the user named it.
    pub scene: String,
    /// Number of the frame in the path.
    pub frame: usize,
    /// Version of the virtual memory: none, a or b.
    pub variant: &'static str,
    /// Core cycles.
    pub cycles: u64,
    /// Frames a second.
    pub fps: f64,
    /// Rays of all kinds.
    pub rays: u64,
    /// Core cycles a ray and pipeline.
    pub cycles_a_ray: f64,
    /// Bytes loaded from the host.
    pub pci_bytes: u64,
    /// Part of the cycles in which the bus to the host is taken.
    pub pci_use: f64,
    /// Bytes moved to and from the on-board memory, of which:
    pub mem_bytes: u64,
    /// Bytes read for the first-level caches.
    pub mem_bytes_l1_fill: u64,
    /// Bytes written that came from the host.
    pub mem_bytes_vm_fill: u64,
    /// Bytes of metadata, of which:
    pub mem_bytes_metadata: u64,
    /// Bytes read.
    pub mem_bytes_metadata_read: u64,
    /// Bytes written back.
    pub mem_bytes_metadata_write_back: u64,
    /// Part of the peak of the on-board memory.
    pub mem_use: f64,
    /// The first-level caches by unit.
    pub l1: BTreeMap<&'static str, CacheRow>,
    /// Requests to the virtual memory.
    pub l2_accesses: u64,
    /// Requests whose line was there or in flight.
    pub l2_hits: u64,
    /// Of these, requests whose line was in flight.
    pub l2_merged: u64,
    /// The units of all pipelines by type.
    pub units: BTreeMap<&'static str, UnitRow>,
}

/// Look-ups of a cache. All that are neither hits nor merged are misses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CacheRow {
    /// Lines looked up.
    pub accesses: u64,
    /// Lines that were there.
    pub hits: u64,
    /// Lines that were in flight.
    pub merged: u64,
}

/// The cycles of the units of one type: `busy + stalled + idle` = cycles × pipelines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnitRow {
    /// Rays went in.
    pub busy: u64,
    /// Threads wanted the unit, and had not their bytes.
    pub stalled: u64,
    /// No thread wanted the unit.
    pub idle: u64,
    /// The stalled cycles by cause.
    pub stalls: BTreeMap<&'static str, u64>,
    /// Packet operations.
    pub operations: u64,
    /// Rays that went in.
    pub rays: u64,
}

/// Name of a cause of stalls.
#[must_use]
pub fn stall_name(stall: Stall) -> &'static str {
    match stall {
        Stall::LookUp => "look_up",
        Stall::Port => "port",
        Stall::Mshr => "mshr",
        Stall::Memory => "memory",
        Stall::Host => "host",
    }
}

impl From<CacheReport> for CacheRow {
    fn from(cache: CacheReport) -> Self {
        Self { accesses: cache.accesses, hits: cache.hits(), merged: cache.merged }
    }
}

impl From<UnitReport> for UnitRow {
    fn from(unit: UnitReport) -> Self {
        Self {
            busy: unit.busy,
            stalled: unit.stalled(),
            idle: unit.idle,
            stalls: Stall::ALL.map(stall_name).into_iter().zip(unit.stalls).collect(),
            operations: unit.operations,
            rays: unit.rays,
        }
    }
}

impl UnitRow {
    /// Part of the cycles in which threads wait for this cause.
    ///
    /// # Panics
    /// If there is no cause of this name.
    #[must_use]
    pub fn waits_for(&self, cause: &str) -> f64 {
        self.stalls[cause] as f64 / (self.busy + self.stalled + self.idle).max(1) as f64
    }
}

impl TimingRow {
    /// Part of the look-ups of a unit's first-level cache that hit.
    ///
    /// # Panics
    /// If there is no unit of this name.
    #[must_use]
    pub fn hit_rate(&self, unit: &str) -> f64 {
        let CacheRow { accesses, hits, .. } = self.l1[unit];
        hits as f64 / accesses.max(1) as f64
    }

    /// The row of a frame of a scene, with so many rays, from the report of a run.
    #[must_use]
    pub fn new(scene: &str, frame: usize, rays: u64, config: &ChipConfig, report: &TimingReport) -> Self {
        let cycles = report.cycles.max(1) as f64;
        let sdram = config.sdram;
        let beats = report.memory_bytes() / u64::from(sdram.beat_bytes);
        Self {
            scene: scene.to_owned(),
            frame,
            variant: version_name(config.version),
            cycles: report.cycles,
            fps: config.fps(report.cycles),
            rays,
            cycles_a_ray: report.cycles as f64 * f64::from(config.pipelines) / rays.max(1) as f64,
            pci_bytes: report.pci_bytes,
            pci_use: report.pci_busy as f64 / cycles,
            mem_bytes: report.memory_bytes(),
            mem_bytes_l1_fill: report.l1_fill_bytes,
            mem_bytes_vm_fill: report.vm_fill_bytes,
            mem_bytes_metadata: report.metadata_read_bytes + report.metadata_write_back_bytes,
            mem_bytes_metadata_read: report.metadata_read_bytes,
            mem_bytes_metadata_write_back: report.metadata_write_back_bytes,
            mem_use: (beats * u64::from(sdram.cycles_a_clock)) as f64 / cycles,
            l1: UNIT_NAMES.into_iter().zip(report.l1.map(CacheRow::from)).collect(),
            l2_accesses: report.l2.accesses,
            l2_hits: report.l2.accesses - report.l2.misses,
            l2_merged: report.l2.merged,
            units: UNIT_NAMES.into_iter().zip(report.units.map(UnitRow::from)).collect(),
        }
    }
}
