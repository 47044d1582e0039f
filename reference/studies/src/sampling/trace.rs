//! Packets in full, and packets of few rays in their place.

use super::plan::Plan;
use crate::error::StudyError;
use crate::simulate::record_part;
use crate::trace::{PacketSize, TraceOptions};
use crate::world::World;
use saarcor_model::rays::RayCounts;
use saarcor_model::time::{Operation, Program, Programs};
use saarcor_model::vm::HostAddr;

/// Pixels along a side of those of which one has a ray in a packet of few rays.
pub const SHRINK: u32 = 4;

/// The same picture with a sixteenth of the pixels. A packet with few rays covers 2 × 2 tiles: that
/// is enough rays to be worth the work of a packet, and few enough to belong to one place.
///
/// # Errors
/// If packets are single rays, of which there are no fewer.
pub fn rough_options(options: &TraceOptions) -> Result<TraceOptions, StudyError> {
    let packet = match options.packet {
        PacketSize::Rays64 => PacketSize::Rays16,
        PacketSize::Rays16 => PacketSize::Rays4,
        PacketSize::Rays4 => PacketSize::Rays1,
        PacketSize::Rays1 => return Err(StudyError::SingleRays),
    };
    let (width, height) = options.resolution;
    let resolution = (width.div_ceil(SHRINK), height.div_ceil(SHRINK));
    Ok(TraceOptions { resolution, packet, ..*options })
}

/// A frame, each packet of it in full or with few rays, in the order in which packets are handed out.
#[derive(Clone, Debug)]
pub struct Traced {
    /// What the packets do.
    pub programs: Programs,
    /// Where they stand.
    pub standings: Vec<Standing>,
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

impl Traced {
    /// A frame with few rays; `rough` is what [`rough_options`] made.
    #[must_use]
    pub fn rough(world: &World, frame: usize, rough: &TraceOptions, plan: &Plan) -> Self {
        let (columns, rows) = rough.tiles();
        let packets: Vec<u32> = (0..columns * rows).collect();
        Self::new(world, frame, rough, &packets, |packet, rays| {
            let first = plan.covered_by(packet);
            Standing { place: plan.place_of(first), block: plan.block_of(first), in_full: false, rays }
        })
    }

    /// The packets of the sample in full.
    #[must_use]
    pub fn sample(world: &World, frame: usize, options: &TraceOptions, plan: &Plan) -> Self {
        Self::new(world, frame, options, &plan.sample, |packet, rays| {
            let (place, block) = (plan.place_of(packet), plan.block_of(packet));
            Standing { place, block, in_full: true, rays }
        })
    }

    fn new(
        world: &World,
        frame: usize,
        options: &TraceOptions,
        packets: &[u32],
        standing: impl Fn(u32, RayCounts) -> Standing,
    ) -> Self {
        let traced = record_part(world, frame, options, packets).into_iter().zip(packets);
        let traced = traced.map(|((program, rays), &packet)| (standing(packet, rays), program));
        Self::in_order(traced.collect(), world.image.registers.triangles)
    }

    /// This frame with the packets of a sample in the place of those in the same blocks.
    #[must_use]
    pub fn with(&self, sample: Self, plan: &Plan) -> Self {
        let rough = self.standings.iter().copied().zip(self.programs.packets.iter().cloned());
        let left = rough.filter(|(standing, _)| plan.weight_of(standing.block).is_none());
        let in_full = sample.standings.into_iter().zip(sample.programs.packets);
        Self::in_order(left.chain(in_full).collect(), self.programs.triangles)
    }

    fn in_order(mut packets: Vec<(Standing, Program)>, triangles: HostAddr) -> Self {
        packets.sort_by_key(|(standing, _)| standing.place);
        let (standings, packets) = packets.into_iter().unzip();
        Self { programs: Programs { packets, triangles }, standings }
    }

    /// The packets, with where they stand.
    pub fn packets(&self) -> impl Iterator<Item = (&Standing, &[Operation])> {
        self.standings.iter().zip(self.programs.packets.iter().map(|program| &program[..]))
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
