//! How pictures are traced: their size, their packets and the order of these, and their bounces.

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

/// In which order the packets of a picture are handed out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PacketOrder {
    /// Tiles from left to right, then downwards (RG-2).
    #[default]
    Scan,
    /// Along Morton's curve (1966): tiles that follow one another are near in both directions.
    Morton,
}

impl PacketOrder {
    /// The numbers of the packets, in scan order, of a picture of `columns` × `rows` tiles.
    #[must_use]
    pub fn packets(self, (columns, rows): (u32, u32)) -> Vec<u32> {
        let mut packets: Vec<u32> = (0..columns * rows).collect();
        if self == Self::Morton {
            packets.sort_by_key(|packet| spread(packet % columns) | spread(packet / columns) << 1);
        }
        packets
    }
}

/// The bits of a number, each at twice its place.
fn spread(number: u32) -> u64 {
    (0..u32::BITS).fold(0, |sum, bit| sum | u64::from(number >> bit & 1) << (2 * bit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_order_keeps_neighbours_together() {
        let order = PacketOrder::Morton.packets((4, 3));
        assert_eq!(order, [0, 1, 4, 5, 2, 3, 6, 7, 8, 9, 10, 11]);
        assert_eq!(PacketOrder::Scan.packets((2, 2)), [0, 1, 2, 3]);
    }
}
