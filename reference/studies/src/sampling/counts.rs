//! What is cheap to count of every frame: what a functional run of a small picture counts.
//!
//! A picture with a sixty-fourth of the pixels (of small pictures with more of them), in packets of a quarter of the rays, so that a packet's rays
//! do not spread eight times as far. It is played to the chip's caches without time, after the small picture of the frame before.

use crate::error::StudyError;
use crate::frames::OnChip;
use crate::simulate::{Recording, record};
use crate::trace::{PacketSize, TraceOptions};
use rayon::prelude::*;
use saarcor_fast::chip::{Cache, Caches, ChipObserver, Found, Traffic, simulate_part};
use saarcor_model::time::{ChipConfig, Operation, Programs, Span};
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many times as many pixels along a side a picture has as its small one, and pixels that a small picture has at
/// least, where the picture has them (Assumed).
const SHRINK: u32 = 8;
const LEAST_PIXELS: u32 = 128 * 96;

/// Frames in a row that one core counts: each picture is traced once, but for the one before the first.
const A_RUN: usize = 16;

/// How the small picture is traced.
#[must_use]
pub fn small(options: &TraceOptions) -> TraceOptions {
    let packet = match options.packet {
        PacketSize::Rays64 => PacketSize::Rays16,
        PacketSize::Rays16 => PacketSize::Rays4,
        PacketSize::Rays4 | PacketSize::Rays1 => PacketSize::Rays1,
    };
    let (width, height) = options.resolution;
    let by = |shrink: u32| (width.div_ceil(shrink), height.div_ceil(shrink));
    let mut shrink = SHRINK;
    while shrink > 1 && by(shrink).0 * by(shrink).1 < LEAST_PIXELS {
        shrink /= 2;
    }
    TraceOptions { resolution: by(shrink), packet, ..*options }
}

/// What a functional run of a picture counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Rays of all kinds.
    rays: u64,
    /// Cycles in which the units are busy.
    work: [u64; 4],
    /// Look-ups of the first-level caches, and misses.
    accesses: [u64; 4],
    misses: [u64; 4],
    /// Requests to the virtual memory, and lines loaded.
    requests: u64,
    loads: u64,
    /// Bytes read for the first-level caches, and bytes of metadata.
    filled: u64,
    metadata: u64,
}

impl Counts {
    /// All counts.
    #[must_use]
    pub fn all(&self) -> Vec<f64> {
        let one = [self.rays, self.requests, self.loads, self.filled, self.metadata];
        let all = [&one[..], &self.work, &self.accesses, &self.misses].concat();
        all.into_iter().map(|count| count as f64).collect()
    }

    /// The counts most like the cycles, the bytes of the on-board memory and those over the bus: the work of the busiest unit,
    /// what the chip moves on board, and lines loaded.
    #[must_use]
    pub fn like(&self, config: &ChipConfig) -> [f64; 3] {
        let loaded = self.loads * config.cache.geometry.line().0;
        let busiest = self.work.into_iter().max().unwrap_or(0);
        [busiest, self.filled + self.metadata + loaded, self.loads].map(|count| count as f64)
    }

    fn of(picture: &Recording, caches: Caches) -> Self {
        let mut counts = Self { rays: picture.picture.rays.total(), ..Self::default() };
        let Programs { packets, .. } = &picture.programs;
        // What is read without rays belongs to the work before.
        let works = |operation: &&Operation| operation.rays > 0 || operation.bytes == 0;
        for operation in packets.iter().flat_map(|program| program.iter()).filter(works) {
            let unit = operation.unit as usize;
            counts.work[unit] += u64::from(caches.config().units[unit].cycles(operation.rays.into()));
        }
        let _ = simulate_part(caches, &picture.programs, &vec![false; packets.len()], &mut counts);
        counts
    }
}

impl ChipObserver for Counts {
    fn transfer(&mut self, _: u32, traffic: Traffic, _: Span, bytes: u64) {
        match traffic {
            Traffic::L1Fill => self.filled += bytes,
            Traffic::MetadataRead | Traffic::MetadataWriteBack => self.metadata += bytes,
            // A line for each miss of the virtual memory: counted there.
            Traffic::VmFill | Traffic::Pci => (),
        }
    }

    fn look_up(&mut self, _: u32, cache: Cache, found: Found) {
        let (looked_up, missed) = match cache {
            Cache::L1(unit) => (&mut self.accesses[unit], &mut self.misses[unit]),
            Cache::L2 => (&mut self.requests, &mut self.loads),
        };
        *looked_up += 1;
        *missed += u64::from(found == Found::Missing);
    }
}

/// Counts of the small pictures of some frames, which increase. `report` learns the part that is done.
///
/// # Errors
/// If the configuration makes no chip.
pub fn count(
    run: &OnChip<'_>,
    frames: &[usize],
    report: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Counts>, StudyError> {
    let OnChip { world, config, order, .. } = *run;
    let (options, done, all) = (small(&run.trace), AtomicUsize::new(0), frames.len());
    let of_run = |frames: &[usize]| -> Result<Vec<Counts>, StudyError> {
        let mut last: Option<(usize, Recording)> = None;
        let mut counts = Vec::with_capacity(frames.len());
        for &frame in frames {
            let mut caches = Caches::empty(world.image.registers.triangles, config)?;
            if frame > 0 && run.warm_up.before(frame) > 0 {
                let before = match last.take() {
                    Some((number, picture)) if number + 1 == frame => picture,
                    _ => record(world, frame - 1, &options, order),
                };
                caches = caches.then(&before.programs);
            }
            let picture = record(world, frame, &options, order);
            counts.push(Counts::of(&picture, caches));
            last = Some((frame, picture));
            report((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
        }
        Ok(counts)
    };
    let counts: Vec<Vec<Counts>> = frames.par_chunks(A_RUN).map(of_run).collect::<Result<_, _>>()?;
    Ok(counts.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_have_a_sixty_fourth_of_the_pixels_or_what_is_enough() {
        let of = |resolution| TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: 5 };
        let sizes = [(1024, 768), (512, 384), (300, 200), (100, 9)].map(|size| small(&of(size)).resolution);
        assert_eq!(sizes, [(128, 96), (128, 96), (150, 100), (100, 9)]);
        assert_eq!(small(&small(&small(&of((9, 9))))).packet, PacketSize::Rays1);
    }
}
