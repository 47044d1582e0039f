//! Rays a packet and ways a set are constants of the model's types: here they are chosen, once.

use crate::trace::PacketSize;

/// Work on packets of `N` rays.
pub(crate) trait ForPackets {
    /// Its result.
    type Output;

    /// Does the work.
    fn run<const N: usize>(self) -> Self::Output;
}

/// Does `work` on packets of a size.
pub(crate) fn with_packets<W: ForPackets>(size: PacketSize, work: W) -> W::Output {
    match size {
        PacketSize::Rays1 => work.run::<1>(),
        PacketSize::Rays4 => work.run::<4>(),
        PacketSize::Rays16 => work.run::<16>(),
        PacketSize::Rays64 => work.run::<64>(),
    }
}

/// Work on sets of `WAYS` ways.
pub(crate) trait ForWays {
    /// Its result.
    type Output;

    /// Does the work.
    fn run<const WAYS: usize>(self) -> Self::Output;
}

/// Does `work` on sets of so many ways, of which there are 1, 2, 4, 8 or 16 (VM-2).
pub(crate) fn with_ways<W: ForWays>(ways: u32, work: W) -> W::Output {
    match ways {
        1 => work.run::<1>(),
        2 => work.run::<2>(),
        4 => work.run::<4>(),
        8 => work.run::<8>(),
        _ => work.run::<16>(),
    }
}
