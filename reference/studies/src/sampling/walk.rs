//! A walk, from a part of each frame's packets.

use super::estimate::{Estimate, distinct, loads, seldom, total};
use super::plan::{Plan, SampleFraction};
use super::row::{Quantity, SampleRow};
use super::trace::{Traced, rough_options};
use crate::caches::{Caches, FrameCounts};
use crate::error::StudyError;
use crate::trace::PacketOrder;
use crate::walk::{FrameRow, Walk, WalkOptions};
use crate::world::World;
use saarcor_model::host::Features;
use saarcor_model::rays::RayCounts;
use saarcor_model::vm::Bytes;
use std::ops::Range;

/// Walks through `frames` with a part of their packets, the same of each frame, and gives `each` the
/// frame's row.
///
/// # Errors
/// Those of `each`, and if packets are single rays or the part is too small.
pub fn walk_sample<E: From<StudyError>>(
    world: &World,
    frames: Range<usize>,
    options: &WalkOptions,
    part: SampleFraction,
    each: &mut dyn FnMut(&SampleRow) -> Result<(), E>,
) -> Result<(), E> {
    let trace = &options.trace;
    let plan = Plan::new(trace.tiles(), PacketOrder::Scan, part, frames.start as u64)?;
    let row = |frame: u64, quantities| SampleRow::new(vec![("frame", frame.into())], part, &plan, quantities);
    if plan.is_all() {
        let mut walk = Walk::new(world, frames, options);
        return walk.try_for_each(|counts| each(&row(counts.frame, counted(&counts))));
    }
    let rough_trace = rough_options(trace)?;
    let pixels = |(width, height): (u32, u32)| f64::from(width) * f64::from(height);
    let rays_each = match world.features {
        // No surface sends any.
        Features { reflection: false, refraction: false, .. } => 0.0,
        _ => pixels(trace.resolution) / pixels(rough_trace.resolution),
    };
    let host = Bytes(world.image.bytes.len() as u64);
    let new_cache = || Played(Caches::new(&[options.cache], host));
    let (mut rough_cache, mut cache) = (new_cache(), new_cache());
    for frame in frames {
        let rough = Traced::rough(world, frame, &rough_trace, &plan);
        let (rough_shares, sample) = rayon::join(
            || rough_cache.play(&rough, &plan, options.cold),
            || Traced::sample(world, frame, trace, &plan),
        );
        let fine = rough.with(sample, &plan);
        let fine_shares = cache.play(&fine, &plan, options.cold);
        let seen = cache.counts().working_set as f64;
        let sample = Sample { plan: &plan, fine: fine_shares, rough: rough_shares, seen, each: rays_each };
        each(&row(frame as u64, sample.quantities(options)))?;
    }
    Ok(())
}

/// Of a walk with all packets, what else is estimated.
fn counted(row: &FrameRow) -> Vec<Quantity> {
    let counts = [
        ("primary_rays", row.primary_rays),
        ("shadow_rays", row.shadow_rays),
        ("secondary_rays", row.secondary_rays),
        ("accesses", row.accesses),
        ("hits", row.hits),
        ("misses", row.misses),
        ("working_set_lines", row.working_set_lines),
        ("working_set_bytes", row.working_set_bytes),
        ("collisions", row.collisions),
        ("loaded_lines", row.loaded_lines),
        ("loaded_bytes", row.loaded_bytes),
    ];
    counts.map(|(name, count)| Quantity::counted(name, count)).into()
}

/// What the packets of a block did.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    rays: RayCounts,
    counts: FrameCounts,
}

/// A cache, played what packets read.
struct Played(Caches);

impl Played {
    /// What it has done since the frame began.
    fn counts(&self) -> FrameCounts {
        self.0.counts()[0]
    }

    /// What the packets of each block of a frame do in the cache. Where some are in full, only blocks
    /// of such say what they do.
    fn play(&mut self, frame: &Traced, plan: &Plan, cold: bool) -> Vec<Share> {
        self.0.begin_frame(cold);
        let mut shares = vec![Share::default(); plan.blocks()];
        let mut last = FrameCounts::default();
        for (standing, program) in frame.packets() {
            let operations = program.iter().filter(|operation| operation.bytes > 0);
            self.0.play(operations.map(|operation| (operation.addr, operation.bytes.into())));
            let now = self.counts();
            let before = std::mem::replace(&mut last, now);
            let Share { rays, counts } = &mut shares[standing.block as usize];
            *rays += standing.rays;
            counts.accesses += now.accesses - before.accesses;
            counts.loaded += now.loaded - before.loaded;
            counts.working_set += now.working_set - before.working_set;
            counts.collisions += now.collisions - before.collisions;
        }
        shares
    }
}

/// A frame of a sample.
struct Sample<'a> {
    plan: &'a Plan,
    /// The blocks of the sample in full; the others with few rays.
    fine: Vec<Share>,
    /// All blocks with few rays.
    rough: Vec<Share>,
    /// Distinct lines that were touched.
    seen: f64,
    /// Secondary rays of the picture for each of few rays.
    each: f64,
}

impl Sample<'_> {
    fn quantities(&self, options: &WalkOptions) -> Vec<Quantity> {
        let (width, height) = options.trace.resolution;
        let line = options.cache.geometry.line().0 as f64;
        let map = |shares: &[Share], of: fn(&Share) -> u64| -> Vec<f64> {
            shares.iter().map(|share| of(share) as f64).collect()
        };
        let both = |of| (map(&self.fine, of), map(&self.rough, of));
        let sum = |of| {
            let (fine, rough) = both(of);
            total(self.plan, &fine, &rough)
        };
        let loaded_by = |of| {
            let (fine, rough) = both(of);
            loads(self.plan, &fine, &rough)
        };
        let accesses = sum(|share| share.counts.accesses);
        let loaded = loaded_by(|share| share.counts.loaded);
        // A line is evicted by one that is loaded.
        let collisions = loaded_by(|share| share.counts.collisions);
        let collisions = Estimate { high: collisions.high.max(loaded.high), ..collisions };
        let (fine, rough) = both(|share| share.rays.secondary);
        let secondary = seldom(self.plan, &fine, &rough, self.each);
        let (fine, rough) = both(|share| share.counts.working_set);
        let working_set = distinct(self.plan, &fine, &rough, self.seen);
        let quantities = [
            ("primary_rays", Estimate::exact(f64::from(width) * f64::from(height))),
            ("shadow_rays", sum(|share| share.rays.shadow)),
            ("secondary_rays", secondary),
            ("accesses", accesses),
            ("hits", accesses.minus(loaded)),
            ("misses", loaded),
            ("working_set_lines", working_set),
            ("working_set_bytes", working_set.times(line)),
            ("collisions", collisions),
            ("loaded_lines", loaded),
            ("loaded_bytes", loaded.times(line)),
        ];
        quantities.map(|(name, estimate)| Quantity::new(name, estimate)).into()
    }
}
