//! A frame on the chip, from a part of its packets.

use super::estimate::{Estimate, batches, loads, rate, total};
use super::neighbours::{Neighbours, Unknown, lines_of_blocks};
use super::plan::{Plan, SampleFraction};
use super::row::{Quantity, SampleRow};
use super::trace::{Standing, Traced, rough_options};
use crate::error::StudyError;
use crate::names::version_name;
use crate::simulate::{TimingRow, WarmUp, record, record_before};
use crate::trace::{PacketOrder, TraceOptions};
use crate::world::World;
use saarcor_fast::chip::{Cache, Caches, ChipObserver, Found, Traffic, simulate_from, simulate_part};
use saarcor_model::time::{CacheReport, ChipConfig, Operation, Span, UNIT_NAMES, Version};

/// A frame, what is done before it, and how it is sampled.
#[derive(Clone, Copy, Debug)]
pub struct SampledFrame {
    /// Number of the frame in the path.
    pub frame: usize,
    /// Frames before it that warm the caches.
    pub warm_up: WarmUp,
    /// How they are traced.
    pub trace: TraceOptions,
    /// In which order packets are handed out.
    pub order: PacketOrder,
    /// The part of the packets that is worked on in full.
    pub part: SampleFraction,
}

/// Simulates a part of a frame's packets, and estimates what the whole frame takes. `report` learns
/// the part that is done.
///
/// # Errors
/// If the configuration makes no chip, packets are single rays, or the part is too small.
pub fn simulate_sample(
    world: &World,
    sampled: &SampledFrame,
    config: &ChipConfig,
    report: &(dyn Fn(f64) + Sync),
) -> Result<SampleRow, StudyError> {
    let SampledFrame { frame, warm_up, trace, order, part } = *sampled;
    let plan = Plan::new(trace.tiles(), order, part, frame as u64)?;
    let of = vec![
        ("scene", world.name.clone().into()),
        ("frame", frame.into()),
        ("variant", version_name(config.version).into()),
    ];
    if plan.is_all() {
        let empty = Caches::empty(world.image.registers.triangles, config)?;
        let before = record_before(world, frame, warm_up.before(frame), &trace, order, report);
        let caches = before.fold(empty, |caches, picture| caches.then(&picture));
        let recording = record(world, frame, &trace, order);
        let run = simulate_from(caches, &recording.programs, &mut ());
        let row = TimingRow::new(&world.name, frame, recording.picture.rays.total(), config, &run);
        return Ok(SampleRow::new(of, part, &plan, counted(&row)));
    }
    let rough = rough_options(&trace)?;
    // Without virtual memory a picture finds next to nothing of the one before in its caches.
    let warm_up = if config.version == Version::None { 0 } else { warm_up.before(frame) };
    let few = |frame| Traced::rough(world, frame, &rough, &plan);
    let in_full = |rough: &Traced, frame| rough.with(Traced::sample(world, frame, &trace, &plan), &plan);
    let before: Vec<Traced> = (frame - warm_up..frame).map(few).collect();
    let rough = few(frame);
    report(0.2);

    let triangles = world.image.registers.triangles;
    let caches_after =
        |frames: &[Traced]| Caches::after(frames.iter().map(|frame| &frame.programs), triangles, config);
    let fine_before: Vec<Traced> =
        before.iter().zip(frame - warm_up..).map(|(few, frame)| in_full(few, frame)).collect();
    // What one thread does alone is done while packets are traced, and then beside the run in time.
    let (caches, fine) = rayon::join(|| caches_after(&fine_before), || in_full(&rough, frame));
    let caches = caches?;
    report(0.5);
    let (in_fine, (in_rough, neighbours)) = rayon::join(
        || Counts::of(&fine, caches, config, &plan),
        || {
            let in_rough = caches_after(&before).map(|caches| Counts::of(&rough, caches, config, &plan));
            let few = lines_of_blocks(&rough, config, &plan);
            (in_rough, Neighbours::of(few, &fine, config, &plan))
        },
    );
    let in_rough = in_rough?;
    let sample = Sample { plan: &plan, config, rough: in_rough, fine: in_fine, neighbours };
    Ok(SampleRow::new(of, part, &plan, sample.quantities()))
}

/// Of a run of all packets, what else is estimated.
fn counted(row: &TimingRow) -> Vec<Quantity> {
    let mut quantities = vec![
        Quantity::counted("cycles", row.cycles),
        Quantity::new("fps", Estimate::exact(row.fps)),
        Quantity::counted("rays", row.rays),
        Quantity::counted("pci_bytes", row.pci_bytes),
        Quantity::counted("mem_bytes", row.mem_bytes),
        Quantity::counted("mem_bytes_l1_fill", row.mem_bytes_l1_fill),
        Quantity::counted("mem_bytes_vm_fill", row.mem_bytes_vm_fill),
        Quantity::counted("mem_bytes_metadata", row.mem_bytes_metadata),
        Quantity::counted("l2_accesses", row.l2_accesses),
        Quantity::counted("l2_hits", row.l2_hits),
    ];
    for unit in UNIT_NAMES {
        quantities.push(Quantity::counted(format!("l1.{unit}.accesses"), row.l1[unit].accesses));
        quantities.push(Quantity::counted(format!("l1.{unit}.hits"), row.l1[unit].hits));
    }
    quantities
}

/// What the packets of a block did.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    rays: u64,
    /// Cycles in which the units were busy.
    work: [u64; 4],
    l1: [CacheReport; 4],
    l2: CacheReport,
    l1_fill_bytes: u64,
    metadata_bytes: u64,
}

/// What the packets of each block did, and when those in time began.
struct Counts {
    /// The block of each packet that counts. Where some are in full, only they do: the others stand
    /// for what is not known.
    counted: Vec<Option<u32>>,
    blocks: Vec<Share>,
    /// For each packet in time, when it began, and its work.
    begins: Vec<u64>,
    work: Vec<[u64; 4]>,
    cycles: u64,
    /// Cycles in which the bus to the host was taken.
    bus_cycles: u64,
}

impl Counts {
    /// Runs a frame in caches that those before it have warmed; packets in full in time, the others
    /// without.
    fn of(frame: &Traced, caches: Caches, config: &ChipConfig, plan: &Plan) -> Self {
        let in_time: Vec<bool> = frame.standings.iter().map(|standing| standing.in_full).collect();
        let some = in_time.contains(&true);
        let counts = |standing: &Standing| (standing.in_full == some).then_some(standing.block);
        let mut counts = Self {
            counted: frame.standings.iter().map(counts).collect(),
            blocks: vec![Share::default(); plan.blocks()],
            begins: Vec::new(),
            work: Vec::new(),
            cycles: 0,
            bus_cycles: 0,
        };
        for (standing, program) in frame.packets().filter(|(standing, _)| standing.in_full == some) {
            let share = &mut counts.blocks[standing.block as usize];
            let work = work(program, config);
            share.rays += standing.rays.total();
            (0..4).for_each(|unit| share.work[unit] += work[unit]);
            counts.work.push(work);
        }
        let report = simulate_part(caches, &frame.programs, &in_time, &mut counts);
        (counts.cycles, counts.bus_cycles) = (report.cycles, report.pci_busy);
        counts
    }

    fn share(&mut self, packet: u32) -> Option<&mut Share> {
        self.counted[packet as usize].map(|block| &mut self.blocks[block as usize])
    }

    fn map(&self, value: impl Fn(&Share) -> u64) -> Vec<f64> {
        self.blocks.iter().map(|share| value(share) as f64).collect()
    }
}

/// Cycles in which the units are busy with a packet.
fn work(program: &[Operation], config: &ChipConfig) -> [u64; 4] {
    let mut work = [0; 4];
    // What is read without rays belongs to the work before.
    for operation in program.iter().filter(|operation| operation.rays > 0 || operation.bytes == 0) {
        let unit = operation.unit as usize;
        work[unit] += u64::from(config.units[unit].cycles(operation.rays.into()));
    }
    work
}

impl ChipObserver for Counts {
    fn transfer(&mut self, packet: u32, traffic: Traffic, _: Span, bytes: u64) {
        let Some(share) = self.share(packet) else { return };
        match traffic {
            Traffic::L1Fill => share.l1_fill_bytes += bytes,
            Traffic::MetadataRead | Traffic::MetadataWriteBack => share.metadata_bytes += bytes,
            // A line for each miss of the virtual memory: counted there.
            Traffic::VmFill | Traffic::Pci => (),
        }
    }

    fn look_up(&mut self, packet: u32, cache: Cache, found: Found) {
        let Some(share) = self.share(packet) else { return };
        let report = match cache {
            Cache::L1(unit) => &mut share.l1[unit],
            Cache::L2 => &mut share.l2,
        };
        report.accesses += 1;
        match found {
            Found::Resident => (),
            Found::InFlight => report.merged += 1,
            Found::Missing => report.misses += 1,
        }
    }

    fn begin(&mut self, _: u32, cycle: u64) {
        self.begins.push(cycle);
    }
}

/// Runs of a sample and of all packets with few rays.
struct Sample<'a> {
    plan: &'a Plan,
    config: &'a ChipConfig,
    /// All packets, with few rays.
    rough: Counts,
    /// The sample.
    fine: Counts,
    neighbours: Neighbours,
}

impl Sample<'_> {
    fn quantities(&self) -> Vec<Quantity> {
        let Self { plan, config, rough, fine, .. } = self;
        let sum = |of: &dyn Fn(&Share) -> u64| total(plan, &fine.map(of), &rough.map(of));
        let virtual_memory = config.version != Version::None;
        let l2_misses = match virtual_memory {
            false => Estimate::exact(0.0),
            true => {
                let misses = |share: &Share| share.l2.misses;
                let loads = loads(plan, &fine.map(misses), &rough.map(misses));
                loads.widened(0.0, loads.high * (self.neighbours.crowding() - 1.0))
            }
        };
        let bytes: [f64; 4] = config.l1.map(|l1| f64::from(l1.line.max(config.sdram.beat_bytes)));
        let misses: [Vec<f64>; 4] = std::array::from_fn(|unit| fine.map(|share| share.l1[unit].misses));
        let unknown = self.neighbours.unknown(plan, &misses);
        let fill_rough: Vec<f64> = rough
            .blocks
            .iter()
            .map(|share| share.l1.iter().zip(bytes).map(|(l1, bytes)| l1.misses as f64 * bytes).sum())
            .collect();
        let l1_fill = total(plan, &fine.map(|share| share.l1_fill_bytes), &fill_rough);
        let l1_fill = Unknown::sum(&unknown, bytes).widen(l1_fill);
        let l2_accesses = Unknown::sum(&unknown, [1.0; 4]).widen(sum(&|share| share.l2.accesses));
        let metadata =
            total(plan, &fine.map(|share| share.metadata_bytes), &rough.map(|share| share.l2.accesses));
        let metadata =
            Unknown::sum(&unknown, [1.0; 4]).widen(metadata).widened(self.metadata_of(l2_misses), 0.0);
        let pci_bytes = l2_misses.times(config.cache.geometry.line().0 as f64);
        let cycles = self.with_loads(self.cycles(), l2_misses);
        let mut quantities = vec![
            Quantity::new("cycles", cycles),
            Quantity::new("fps", cycles.falling(|cycles| config.core_hz as f64 / cycles.max(1.0))),
            Quantity::new("rays", sum(&|share| share.rays)),
            Quantity::new("pci_bytes", pci_bytes),
            Quantity::new("mem_bytes", l1_fill.plus(metadata).plus(pci_bytes)),
            Quantity::new("mem_bytes_l1_fill", l1_fill),
            Quantity::new("mem_bytes_vm_fill", pci_bytes),
            Quantity::new("mem_bytes_metadata", metadata),
            Quantity::new("l2_accesses", l2_accesses),
            Quantity::new("l2_hits", l2_accesses.minus(l2_misses)),
        ];
        for (unit, name) in UNIT_NAMES.into_iter().enumerate() {
            let accesses = sum(&|share| share.l1[unit].accesses);
            let missed = unknown[unit].widen(sum(&|share| share.l1[unit].misses + share.l1[unit].merged));
            let hits = accesses.minus(missed);
            quantities.push(Quantity::new(format!("l1.{name}.accesses"), accesses));
            quantities.push(Quantity::new(format!("l1.{name}.hits"), hits));
        }
        quantities
    }

    /// Lines that the picture would load if it loaded as the sample does.
    fn loads_as_sampled(&self) -> f64 {
        let misses = self.fine.map(|share| share.l2.misses);
        let weights = (0..).map(|block| f64::from(self.plan.weight_of(block).unwrap_or(0)));
        misses.iter().zip(weights).map(|(misses, weight)| misses * weight).sum()
    }

    /// Bytes of metadata that the sample may have moved too many, because it loaded more lines than
    /// there are to load: for a line, at most the granule of its entry is read and another written back.
    fn metadata_of(&self, l2_misses: Estimate) -> f64 {
        let granule = self.config.metadata_cache.granule.max(self.config.sdram.beat_bytes);
        (self.loads_as_sampled() - l2_misses.low).max(0.0) * 2.0 * f64::from(granule)
    }

    /// Cycles of a picture that may load fewer or more lines than it would as the sample does. A load
    /// holds the chip up for its time on the bus at most; and no unit is faster than its work.
    fn with_loads(&self, cycles: Estimate, l2_misses: Estimate) -> Estimate {
        let Self { config, fine, .. } = self;
        let bus = fine.bus_cycles as f64 / fine.map(|share| share.l2.misses).iter().sum::<f64>().max(1.0);
        let sampled = self.loads_as_sampled();
        let [fewer, more] =
            [sampled - l2_misses.low, l2_misses.high - sampled].map(|loads| loads.max(0.0) * bus);
        let least = self.busiest().low / f64::from(config.pipelines);
        let widened = cycles.widened(fewer, more);
        Estimate { low: widened.low.max(least).min(cycles.low), ..widened }
    }

    /// The unit that has the most work.
    fn busiest_unit(&self) -> usize {
        let sum = |unit: usize| self.rough.blocks.iter().map(|share| share.work[unit]).sum::<u64>();
        (0..UNIT_NAMES.len()).max_by_key(|&unit| sum(unit)).unwrap_or(0)
    }

    /// Its work.
    fn busiest(&self) -> Estimate {
        let unit = self.busiest_unit();
        let of_unit = |share: &Share| share.work[unit];
        total(self.plan, &self.fine.map(of_unit), &self.rough.map(of_unit))
    }

    /// The work of the unit that has the most, times the cycles that pass for each bit of it while all
    /// threads are busy; and what the end of a run takes longer, when threads have nothing more to do:
    /// that is the same however many packets a run has, and at least nothing.
    fn cycles(&self) -> Estimate {
        let Self { config, fine, .. } = self;
        let (busiest, work) = (self.busiest_unit(), self.busiest());
        let in_sample: Vec<f64> = fine.work.iter().map(|work| work[busiest] as f64).collect();
        let (all, cycles) = (in_sample.iter().sum::<f64>(), fine.cycles as f64);
        let threads = (config.pipelines * config.threads) as usize;
        let begins = &fine.begins;
        // When a packet begins, about as many packets as there are threads before it, one has ended.
        let batches = batches(begins.len().saturating_sub(threads + 1), threads).map(|batch| {
            let passed = begins[batch.end + threads] - begins[batch.start + threads];
            (passed as f64, in_sample[batch].iter().sum())
        });
        let least = 1.0 / f64::from(config.pipelines);
        match rate(&batches.collect::<Vec<_>>()) {
            Some(rate) => {
                let end = (cycles - rate.estimate * all).max(0.0);
                work.product(rate).plus(Estimate { estimate: end, low: 0.0, high: end })
            }
            // Too few packets to keep the threads busy: between no thread ever waiting, and as slow
            // as here.
            None => {
                let (low, high) = (work.low * least, work.high * cycles / all.max(1.0));
                Estimate { estimate: (low * high).sqrt(), low, high }
            }
        }
    }
}
