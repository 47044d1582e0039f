//! How pictures are traced: their size, packets and bounces.

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

/// Work that is written for packets of `N` rays.
pub(crate) trait ForPackets {
    /// What it gives.
    type Output;

    /// Does the work for packets of `N` rays.
    fn run<const N: usize>(self) -> Self::Output;
}

impl PacketSize {
    /// Does `work` for packets of this size.
    pub(crate) fn run<W: ForPackets>(self, work: W) -> W::Output {
        match self {
            Self::Rays1 => work.run::<1>(),
            Self::Rays4 => work.run::<4>(),
            Self::Rays16 => work.run::<16>(),
            Self::Rays64 => work.run::<64>(),
        }
    }
}
