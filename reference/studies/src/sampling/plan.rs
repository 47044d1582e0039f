//! Which packets of a picture are worked on in full.
//!
//! The picture is cut into blocks of tiles. Along Morton's curve, on which blocks that
//! follow one another are near in both directions, they make strata of equal size; one block of
//! each is drawn at random. So each part of the picture is in the sample by its share: a spatially
//! balanced sample (Stevens and Olsen 2004, whose tessellation is this curve).
//!
//! Blocks and not single tiles, because neighbours read the same lines: what a tile inside a block
//! finds in a cache is there for the right reason.

use crate::error::{ParseError, StudyError};
use crate::trace::PacketOrder;
use saarcor_random::Random;
use std::fmt;
use std::str::FromStr;

/// Tiles of a block across and down (Assumed). Packets are handed out along rows and as many are in
/// work at a time as there are threads, so a block is wide, as what is in work at a time is; and low,
/// that a picture has many of them.
const BLOCK: (u32, u32) = (16, 2);

/// Tiles along a side of what a packet with few rays covers; blocks are a multiple of it.
pub const COVERED: u32 = 2;

/// Fewest blocks of a sample: from one nothing is learned of how blocks differ.
const LEAST_BLOCKS: u32 = 2;

/// The part of a picture's packets that is worked on in full, above 0 and at most 1: `1/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleFraction {
    numerator: u32,
    denominator: u32,
}

impl SampleFraction {
    /// `1 / denominator`.
    ///
    /// # Panics
    /// If `denominator` is 0.
    #[must_use]
    pub fn one_of(denominator: u32) -> Self {
        assert!(denominator > 0, "no part is divided by 0");
        Self { numerator: 1, denominator }
    }

    /// Whether the member at a place of a list is drawn: members at equal distances are, from the middle of the first.
    #[must_use]
    pub fn draws(self, place: usize) -> bool {
        let drawn = |before: usize| self.of(u32::try_from(before).unwrap_or(u32::MAX));
        drawn(place) < drawn(place + 1)
    }

    /// So many of `all`, rounded.
    fn of(self, all: u32) -> u32 {
        let (numerator, denominator) = (u64::from(self.numerator), u64::from(self.denominator));
        ((u64::from(all) * numerator + denominator / 2) / denominator) as u32
    }
}

impl FromStr for SampleFraction {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
            text.parse().ok().filter(|_| digits)
        };
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        match number(numerator).zip(number(denominator)) {
            Some((numerator, denominator)) if 0 < numerator && numerator <= denominator => {
                Ok(Self { numerator, denominator })
            }
            _ => Err(ParseError::new("write a fraction above 0 and at most 1, such as 1/8")),
        }
    }
}

impl fmt::Display for SampleFraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => f.write_str("1"),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

/// The blocks of a picture, and which of them are worked on in full.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Tiles a row.
    columns: u32,
    /// Place of each tile, in scan order, in the order in which packets are handed out.
    places: Vec<u32>,
    /// For each block, in scan order, its stratum if it was drawn.
    drawn: Vec<Option<u32>>,
    /// For each stratum, how many blocks of the picture the drawn one stands for.
    pub stands_for: Vec<u32>,
    /// The packets of the sample, in the order in which they are handed out.
    pub sample: Vec<u32>,
}

/// The error of a sample of too few of a picture's blocks: says what would be enough.
fn too_few_blocks(sample: SampleFraction, blocks: u32) -> StudyError {
    let enough = match blocks / LEAST_BLOCKS {
        0 | 1 => "this picture needs a sample of 1".to_owned(),
        least => format!("at least 1/{least} is enough"),
    };
    let why = format!(
        "fewer than {LEAST_BLOCKS} of the picture's {blocks} blocks of {} x {} packets, too few for an interval; {enough}",
        BLOCK.0, BLOCK.1
    );
    StudyError::SmallSample { sample: sample.to_string(), why }
}

impl Plan {
    /// Draws a `part` of a picture of `columns × rows` tiles; the same for the same `seed`.
    ///
    /// # Errors
    /// If the part is that of fewer than two blocks, and not the whole picture.
    pub fn new(
        tiles: (u32, u32),
        order: PacketOrder,
        part: SampleFraction,
        seed: u64,
    ) -> Result<Self, StudyError> {
        let (columns, rows) = tiles;
        let across = columns.div_ceil(BLOCK.0);
        let curve = PacketOrder::Morton.packets((across, rows.div_ceil(BLOCK.1)));
        let all = curve.len() as u32;
        let blocks = part.of(all);
        if blocks < LEAST_BLOCKS.min(all) {
            return Err(too_few_blocks(part, all));
        }
        let begin = |stratum: u32| (u64::from(stratum) * u64::from(all) / u64::from(blocks)) as u32;
        let mut drawn = vec![None; curve.len()];
        let mut stands_for = Vec::with_capacity(blocks as usize);
        for stratum in 0..blocks {
            let size = begin(stratum + 1) - begin(stratum);
            let block = begin(stratum) + below(size, seed, stratum);
            drawn[curve[block as usize] as usize] = Some(stratum);
            stands_for.push(size);
        }
        let packets = order.packets(tiles);
        let mut places = vec![0; packets.len()];
        (0..).zip(&packets).for_each(|(place, &packet)| places[packet as usize] = place);
        let mut plan = Self { columns, places, drawn, stands_for, sample: Vec::new() };
        plan.sample =
            packets.into_iter().filter(|&packet| plan.weight_of(plan.block_of(packet)).is_some()).collect();
        Ok(plan)
    }

    /// Blocks of the picture.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.drawn.len()
    }

    /// Packets of the picture.
    #[must_use]
    pub fn packets(&self) -> usize {
        self.places.len()
    }

    /// Whether the sample is the whole picture.
    #[must_use]
    pub fn is_all(&self) -> bool {
        self.drawn.iter().all(Option::is_some)
    }

    /// The block of a packet.
    #[must_use]
    pub fn block_of(&self, packet: u32) -> u32 {
        let (column, row) = (packet % self.columns, packet / self.columns);
        row / BLOCK.1 * self.columns.div_ceil(BLOCK.0) + column / BLOCK.0
    }

    /// Whether a block is in the sample, and then how many blocks it stands for.
    #[must_use]
    pub fn weight_of(&self, block: u32) -> Option<u32> {
        self.drawn[block as usize].map(|stratum| self.stands_for[stratum as usize])
    }

    /// When a packet is handed out.
    #[must_use]
    pub fn place_of(&self, packet: u32) -> u32 {
        self.places[packet as usize]
    }

    /// The first of the packets whose tiles a packet with few rays covers: those of a smaller picture
    /// have [`COVERED`] tiles along a side, a whole number of which makes a block.
    #[must_use]
    pub fn covered_by(&self, rough: u32) -> u32 {
        let across = self.columns.div_ceil(COVERED);
        rough / across * COVERED * self.columns + rough % across * COVERED
    }
}

/// A number below `bound`, for a stratum. That the numbers are not quite equally frequent does not show:
/// a picture has few blocks.
fn below(bound: u32, seed: u64, stratum: u32) -> u32 {
    let of_seed = Random::new(seed).bits();
    (Random::new(of_seed.wrapping_add(u64::from(stratum))).bits() % u64::from(bound)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_read_back_as_they_are_written() {
        for text in ["1/8", "3/4", "1/64", "1"] {
            assert_eq!(text.parse::<SampleFraction>().expect("a part").to_string(), text);
        }
        assert_eq!("1/8".parse(), Ok(SampleFraction::one_of(8)));
    }

    #[test]
    fn lists_are_drawn_from_evenly() {
        let drawn = |text: &str| -> Vec<usize> {
            let part: SampleFraction = text.parse().expect("a part");
            (0..12).filter(|&place| part.draws(place)).collect()
        };
        assert_eq!(drawn("1/4"), [1, 5, 9]);
        assert_eq!(drawn("2/3").len(), 8);
        assert_eq!(drawn("1").len(), 12);
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in
            ["0", "0/4", "2/1", "9/8", "1/0", "x", "", "1/", "/8", "1/8/2", "-1/8", "+1/8", "0.5", "1/ 8"]
        {
            assert!(
                text.parse::<SampleFraction>().is_err_and(|error| error.to_string().contains("1/8")),
                "{text}"
            );
        }
    }

    fn plan(tiles: (u32, u32), order: PacketOrder, part: &str, seed: u64) -> Plan {
        Plan::new(tiles, order, part.parse().expect("a part"), seed).expect("a plan")
    }

    #[test]
    fn each_stratum_gives_one_block_and_stands_for_its_size() {
        for (tiles, part) in [((128, 96), "1/8"), ((128, 96), "3/7"), ((125, 3), "1/10"), ((7, 7), "1/2")] {
            let plan = plan(tiles, PacketOrder::Scan, part, 5);
            assert_eq!(plan.stands_for.iter().sum::<u32>() as usize, plan.blocks());
            let mut strata: Vec<u32> = plan.drawn.iter().copied().flatten().collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..plan.stands_for.len() as u32).collect::<Vec<_>>());
        }
    }

    #[test]
    fn whole_picture_is_all_packets() {
        let plan = plan((20, 15), PacketOrder::Morton, "1", 0);
        assert!(plan.is_all());
        assert_eq!(plan.sample, PacketOrder::Morton.packets((20, 15)));
        assert!(plan.stands_for.iter().all(|&size| size == 1));
    }

    #[test]
    fn too_few_blocks_are_refused() {
        let refusal = |tiles, part: &str| {
            let plan = Plan::new(tiles, PacketOrder::Scan, part.parse().expect("a part"), 0);
            plan.expect_err("too few").to_string()
        };
        assert!(refusal((128, 96), "1/100000").contains("at least 1/192 is enough"));
        assert!(refusal((6, 6), "1/4").contains("a sample of 1"));
        assert!(plan((6, 6), PacketOrder::Scan, "1", 0).is_all());
    }

    #[test]
    fn every_tile_is_drawn_by_its_share() {
        let (tiles, seeds) = ((64, 24), 4000);
        let mut times = vec![0; 64 * 24];
        for seed in 0..seeds {
            let sample = plan(tiles, PacketOrder::Scan, "1/8", seed).sample;
            sample.iter().for_each(|&packet| times[packet as usize] += 1);
        }
        // A binomial's standard deviation is 21; five of them, for any of 48 blocks.
        assert!(times.iter().all(|&times| i32::abs_diff(times, 500) < 105), "{times:?}");
    }

    #[test]
    fn packets_with_few_rays_cover_tiles_of_one_block() {
        let plan = plan((125, 95), PacketOrder::Scan, "1/8", 0);
        let across = 125_u32.div_ceil(COVERED);
        for rough in 0..across * 95_u32.div_ceil(COVERED) {
            let first = plan.covered_by(rough);
            let (column, row) = (first % 125, first / 125);
            assert_eq!((column / COVERED, row / COVERED), (rough % across, rough / across));
            let last = (row + COVERED - 1).min(94) * 125 + (column + COVERED - 1).min(124);
            assert_eq!(plan.block_of(first), plan.block_of(last));
        }
    }
}
