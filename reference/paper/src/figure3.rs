//! Figure 3 (§4): working set and transfers, frame by frame.

use crate::tables::mb;
use saarcor_model::time::standard::CORE_HZ;
use saarcor_model::time::{ChipConfig, PciConfig};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash};
use saarcor_studies::StudyError;
use saarcor_studies::frames::OnChip;
use saarcor_studies::hot_spots::{HotFrame, cuts, hot_spots};
use saarcor_studies::monitor::Monitor;
use saarcor_studies::sampling::walk::{ErrorBound, EstimatedWalk, Goal};
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::standard;
use saarcor_studies::trace::{PacketOrder, TraceOptions};
use saarcor_studies::walk::{FrameRow, Walk, WalkOptions};
use saarcor_studies::world::World;
use serde::Serialize;

/// A graph of Figure 3.
#[derive(Clone, Debug, Serialize)]
pub struct Graph {
    /// Name of the scene, without folders.
    pub name: String,
    /// Size of the on-board memory.
    pub memory_bytes: u64,
    /// Frames of the whole path.
    pub path_frames: usize,
    /// One frame in so many was walked through.
    pub step: usize,
    /// The frames that were walked through.
    pub frames: Vec<FrameRow>,
    /// The hot spots among them, one for each of the paper's of this scene.
    pub hot_spots: Vec<HotFrame>,
    /// The frames of the path before which the camera cuts.
    pub cuts: Vec<usize>,
    /// What the same walk loads with virtual memories of other sizes, and without the hash: played beside the first one.
    pub sizes: Vec<SizeRow>,
    /// Frames a second of the same frames, in version A; none before [`Graph::add_fps`].
    pub fps: Vec<FpsRow>,
}

/// Frames a second of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FpsRow {
    /// Number of the frame in the path.
    pub frame: usize,
    /// Whether it is estimated; others ran on the chip.
    pub estimated: bool,
    /// The number, and its interval of 95 %; none where it is not known from the frames that ran.
    pub fps: Option<f64>,
    /// See [`FpsRow::fps`].
    pub interval: Option<[f64; 2]>,
}

/// Frames run on the chip until the cycles of a walk are known to about so much to each side.
const FPS_ERROR: ErrorBound = ErrorBound::percent(5.0);

/// What a walk loads with a virtual memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SizeRow {
    /// The virtual memory.
    #[serde(skip)]
    pub config: CacheConfig,
    /// Size of the on-board memory.
    pub memory_bytes: u64,
    /// Bytes of a line.
    pub line_bytes: u64,
    /// Lines a set.
    pub ways: u32,
    /// Whether the upper bits of a line are added to the lower ones.
    pub hash: bool,
    /// Bytes that all frames load which were walked through.
    pub loaded_bytes: u64,
}

impl SizeRow {
    fn new(config: CacheConfig, rows: &[FrameRow]) -> Self {
        let CacheConfig { geometry, hash, .. } = config;
        Self {
            config,
            memory_bytes: geometry.memory().0,
            line_bytes: geometry.line().0,
            ways: geometry.ways(),
            hash: hash != Hash::Low,
            loaded_bytes: rows.iter().map(|row| row.loaded_bytes).sum(),
        }
    }
}

/// Virtual memories that differ from the standard one in their sizes: 1 to 64 MiB, of these with the standard line fewer ways
/// without the hash, too.
fn sizes(standard: CacheConfig) -> Vec<CacheConfig> {
    let hashed = [64, 128, 256]
        .into_iter()
        .flat_map(|line| [1, 2, 4, 8, 16].map(|ways| (line, ways, Hash::default())));
    let plain = [1, 2, standard::WAYS].map(|ways| (standard::LINE.0, ways, Hash::Low));
    let of_any_memory = |(line, ways, hash)| {
        let geometries =
            (20..=26).filter_map(move |bits| Geometry::new(Bytes(1 << bits), Bytes(line), ways).ok());
        geometries.map(move |geometry| CacheConfig { geometry, hash, policy: standard.policy })
    };
    hashed.chain(plain).flat_map(of_any_memory).collect()
}

impl Graph {
    /// Walks through each `step`th frame of the world's path, from frame 0 on, with this virtual memory, and finds
    /// `hot_spots` hot spots.
    #[must_use]
    pub fn new(
        name: &str,
        world: &World,
        options: &WalkOptions,
        step: usize,
        hot_spots: usize,
        monitor: &dyn Monitor,
    ) -> Self {
        Self::with_memories(name, world, options, &[], step, hot_spots, monitor).0
    }

    /// The same, and what the walk loads with other virtual memories, in their order.
    pub fn with_memories(
        name: &str,
        world: &World,
        options: &WalkOptions,
        others: &[CacheConfig],
        step: usize,
        count: usize,
        monitor: &dyn Monitor,
    ) -> (Self, Vec<MemoryRow>) {
        let path_frames = world.path.len();
        let chosen = (0..path_frames).step_by(step);
        let length = chosen.len();
        let sizes = sizes(options.cache);
        let played = [others, &sizes].concat();
        let mut walk = Walk::with_others(world, chosen, options, &played);
        let mut all: Vec<Vec<FrameRow>> = vec![Vec::new(); played.len() + 1];
        monitor.during(&format!("{name}: walk of {length} frames"), |report| {
            while let Some(rows) = walk.next_of_each() {
                all.iter_mut().zip(rows).for_each(|(all, row)| all.push(row));
                report(all[0].len() as f64 / length as f64);
            }
        });
        let frames = all.remove(0);
        let memories =
            others.iter().zip(&all).map(|(cache, rows)| MemoryRow::new(cache.geometry, rows)).collect();
        let graph = Self {
            name: name.to_owned(),
            memory_bytes: options.cache.geometry.memory().0,
            path_frames,
            step,
            hot_spots: hot_spots(&frames, &world.path, count),
            frames,
            cuts: cuts(&world.path).into_iter().collect(),
            sizes: sizes
                .iter()
                .zip(&all[others.len()..])
                .map(|(cache, rows)| SizeRow::new(*cache, rows))
                .collect(),
            fps: Vec::new(),
        };
        (graph, memories)
    }

    /// Adds frames a second on this chip, each frame after the one before it in the path: some frames run, the others are estimated.
    ///
    /// # Errors
    /// If the configuration makes no chip.
    pub fn add_fps(
        &mut self,
        world: &World,
        config: &ChipConfig,
        trace: TraceOptions,
        monitor: &dyn Monitor,
    ) -> Result<(), StudyError> {
        let (order, warm_up) = (PacketOrder::default(), WarmUp::ONE);
        let run = OnChip { world, config, trace, order, warm_up };
        let frames: Vec<usize> = self.frames.iter().map(|row| row.frame as usize).collect();
        let walk = EstimatedWalk::new(run, &frames, Goal::Error(FPS_ERROR), 0, monitor)?;
        let row = |(place, &frame): (usize, &usize)| {
            let fps = walk.of(place).into_iter().find(|(name, _)| *name == "fps");
            let fps = fps.map(|(_, fps)| fps).filter(|fps| fps.is_known());
            FpsRow {
                frame,
                estimated: !walk.simulated.contains_key(&place),
                fps: fps.map(|fps| fps.value),
                interval: fps.map(|fps| [fps.low, fps.high]),
            }
        };
        self.fps = frames.iter().enumerate().map(row).collect();
        Ok(())
    }

    /// MB that the walk loads with virtual memories of which something is asked, in the order of [`Graph::sizes`]: what is
    /// left of them by `name`, and the number.
    pub(crate) fn loaded(&self, name: impl Fn(&SizeRow) -> Option<String>) -> Vec<String> {
        let named = |row: &SizeRow| Some(format!("{}: {}", name(row)?, mb(row.loaded_bytes)));
        self.sizes.iter().filter_map(named).collect()
    }

    /// The first frame that has the most of something.
    #[must_use]
    pub fn peak(&self, value: fn(&FrameRow) -> u64) -> Option<&FrameRow> {
        self.frames.iter().rev().max_by_key(|row| value(row))
    }
}

/// What a walk loads with an on-board memory of some size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MemoryRow {
    /// Size of the on-board memory.
    pub memory_bytes: u64,
    /// Frames of the walk.
    pub frames: usize,
    /// Of these, frames whose working set is not larger than the memory.
    pub frames_that_fit: usize,
    /// Bytes loaded by the first frame, for which nothing is there yet.
    pub first_loaded_bytes: u64,
    /// Bytes loaded a frame, the first one left out; none of a single frame.
    pub loaded_bytes_a_frame: Option<f64>,
    /// The most that one of these loads.
    pub most_loaded_bytes: Option<u64>,
    /// Collisions a frame of these.
    pub collisions_a_frame: Option<f64>,
    /// Frames a second that the standard bus has room for, if each loads as much; none if they load nothing.
    pub bus_fps: Option<f64>,
}

impl MemoryRow {
    fn new(geometry: Geometry, rows: &[FrameRow]) -> Self {
        let later = &rows[rows.len().min(1)..];
        let a_frame = |value: fn(&FrameRow) -> u64| {
            let sum = later.iter().map(value).sum::<u64>() as f64;
            (!later.is_empty()).then(|| sum / later.len() as f64)
        };
        let bus = PciConfig::BITS_32_AT_33_MHZ;
        let cycles =
            a_frame(|row| row.loaded_lines).map(|lines| lines * bus.cycles(geometry.line().0) as f64);
        Self {
            memory_bytes: geometry.memory().0,
            frames: rows.len(),
            frames_that_fit: rows.iter().filter(|row| row.working_set_bytes <= geometry.memory().0).count(),
            first_loaded_bytes: rows.first().map_or(0, |row| row.loaded_bytes),
            loaded_bytes_a_frame: a_frame(|row| row.loaded_bytes),
            most_loaded_bytes: later.iter().map(|row| row.loaded_bytes).max(),
            collisions_a_frame: a_frame(|row| row.collisions),
            bus_fps: cycles.filter(|cycles| *cycles > 0.0).map(|cycles| CORE_HZ as f64 / cycles),
        }
    }
}
