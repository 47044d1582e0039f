//! Packets in full, and packets of few rays in their place.

use super::plan::Plan;
use crate::simulate::record_part;
use crate::walk::{PacketSize, TraceOptions};
use crate::world::World;
use anyhow::{Result, bail};
use saarcor_model::program::{Operation, Programs};
use saarcor_model::rtp::RayCounts;
use std::ops::RangeInclusive;

/// Pixels along a side of those of which one has a ray in a packet of few rays.
pub const SHRINK: u32 = 4;

/// The same picture with a sixteenth of the pixels. A packet with few rays covers 2 × 2 tiles: that
/// is enough rays to be worth the work of a packet, and few enough to belong to one place.
///
/// # Errors
/// If packets are single rays, of which there are no fewer.
pub fn rough_options(options: &TraceOptions) -> Result<TraceOptions> {
    let packet = match options.packet {
        PacketSize::Rays64 => PacketSize::Rays16,
        PacketSize::Rays16 => PacketSize::Rays4,
        PacketSize::Rays4 => PacketSize::Rays1,
        PacketSize::Rays1 => bail!("--sample with --packet 1: sampling needs packets of 4, 16 or 64 rays"),
    };
    let (width, height) = options.resolution;
    let resolution = (width.div_ceil(SHRINK), height.div_ceil(SHRINK));
    Ok(TraceOptions { resolution, packet, ..*options })
}

/// Frames that follow one another, each packet of them in full or with few rays, in the order in which
/// packets are handed out.
#[derive(Clone, Debug)]
pub struct Frames {
    /// What the packets of each frame do.
    pub programs: Vec<Programs>,
    /// Where they stand.
    standings: Vec<Vec<Standing>>,
}

/// Where a packet of a frame stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// The place of its first tile in the order in which packets are handed out.
    place: u32,
    /// Its block.
    pub block: u32,
    /// Whether it is in full.
    pub in_full: bool,
    /// Its rays.
    pub rays: RayCounts,
}

/// A packet with where it stands.
type Packet = (Standing, Box<[Operation]>);

impl Frames {
    /// Frames with few rays; `rough` is what [`rough_options`] made.
    #[must_use]
    pub fn rough(world: &World, frames: RangeInclusive<usize>, rough: &TraceOptions, plan: &Plan) -> Self {
        let (columns, rows) = rough.tiles();
        let packets: Vec<u32> = (0..columns * rows).collect();
        let standing = |packet, rays| {
            let first = plan.covered_by(packet);
            Standing { place: plan.place_of(first), block: plan.block_of(first), in_full: false, rays }
        };
        let traced = |frame| -> Vec<Packet> {
            let traced = record_part(world, frame, rough, &packets).into_iter().zip(&packets);
            traced.map(|((program, rays), &packet)| (standing(packet, rays), program)).collect()
        };
        Self::of(world, frames.map(traced))
    }

    /// The packets of the sample in full, of the same frames.
    #[must_use]
    pub fn sample(world: &World, frames: RangeInclusive<usize>, options: &TraceOptions, plan: &Plan) -> Self {
        let sample = &plan.sample;
        let standing = |packet, rays| {
            let (place, block) = (plan.place_of(packet), plan.block_of(packet));
            Standing { place, block, in_full: true, rays }
        };
        let traced = |frame| -> Vec<Packet> {
            let traced = record_part(world, frame, options, sample).into_iter().zip(sample);
            traced.map(|((program, rays), &packet)| (standing(packet, rays), program)).collect()
        };
        Self::of(world, frames.map(traced))
    }

    /// These, with the packets of a sample in the place of those in the same blocks.
    #[must_use]
    pub fn with(self, sample: Self, world: &World, plan: &Plan) -> Self {
        let frames = self.programs.into_iter().zip(self.standings);
        let samples = sample.programs.into_iter().zip(sample.standings);
        Self::of(
            world,
            frames.zip(samples).map(|((rough, standings), (sample, in_full))| {
                let rough = standings.into_iter().zip(rough.packets);
                let left = rough.filter(|(standing, _)| plan.weight_of(standing.block).is_none());
                left.chain(in_full.into_iter().zip(sample.packets)).collect()
            }),
        )
    }

    fn of(world: &World, frames: impl Iterator<Item = Vec<Packet>>) -> Self {
        let triangles = world.image.registers.triangles;
        let (programs, standings) = frames
            .map(|mut packets| {
                packets.sort_by_key(|(standing, _)| standing.place);
                let (standings, packets): (Vec<_>, _) = packets.into_iter().unzip();
                (Programs { packets, triangles }, standings)
            })
            .unzip();
        Self { programs, standings }
    }

    /// What the packets of the last frame do, and where they stand.
    ///
    /// # Panics
    /// If there is no frame.
    #[must_use]
    pub fn last(&self) -> (&Programs, &[Standing]) {
        let last = self.programs.last().zip(self.standings.last());
        let (programs, standings) = last.expect("a frame is the last of its frames");
        (programs, standings)
    }

    /// The packets of the last frame, with where they stand.
    pub fn packets(&self) -> impl Iterator<Item = (&Standing, &[Operation])> {
        let (programs, standings) = self.last();
        standings.iter().zip(programs.packets.iter().map(|program| &program[..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::plan::COVERED;

    #[test]
    fn packets_with_few_rays_cover_the_picture() {
        for packet in [PacketSize::Rays4, PacketSize::Rays16, PacketSize::Rays64] {
            for resolution in [(1024, 768), (1, 1), (641, 479), (99, 7)] {
                let options = TraceOptions { resolution, packet, max_bounces: 0 };
                let (columns, rows) = options.tiles();
                let covering = (columns.div_ceil(COVERED), rows.div_ceil(COVERED));
                assert_eq!(rough_options(&options).expect("smaller").tiles(), covering);
            }
        }
        let single = TraceOptions { resolution: (8, 8), packet: PacketSize::Rays1, max_bounces: 0 };
        assert!(rough_options(&single).is_err());
    }
}
