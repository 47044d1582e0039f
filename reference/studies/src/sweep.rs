//! Sweeps: one frame on many chips, one for each point of a grid.

use crate::error::{ParseError, StudyError};
use crate::simulate::TimingRow;
use crate::world::{Image, World};
use rayon::prelude::*;
use saarcor_fast::chip::simulate;
use saarcor_model::time::{ChipConfig, Programs, Version};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::str::FromStr;
use xxhash_rust::xxh3::{xxh3_64, xxh3_128};

/// What a sweep can vary, each with the values that it takes if none are named. (Lines of 32 bytes
/// are less than the standard lines of two first-level caches, and so make no chip by themselves.)
pub const AXES: [(&str, &str); 13] = [
    ("line", "64,128,256,512,1KiB,2KiB,4KiB"),
    ("ways", "1,2,4,8,16"),
    ("hash", "low,add-upper,add-upper-all"),
    ("memory", "4MiB,8MiB,16MiB,32MiB,64MiB"),
    ("policy", "lru,fifo,plru"),
    ("pci", "33x32,66x64"),
    ("threads", "1,2,4,8,16,32"),
    ("metadata-cache", "16KiB,32KiB,64KiB,128KiB,256KiB"),
    ("granule", "16,32,64,128"),
    ("triangle-cache", "144KiB,576KiB"),
    ("shading-line", "16,32,64"),
    ("banks", "2,4,8,16"),
    ("variant", "none,a,b"),
];

/// A parameter of the chip, and the values that it takes: `line` or `line=64,128`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Its values, as they are written.
    pub values: Vec<String>,
}

impl FromStr for Axis {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let (name, values) = text.split_once('=').unwrap_or((text, ""));
        let all = AXES.iter().find(|(known, _)| *known == name);
        let values = match (values, all) {
            ("", Some((_, all))) if !text.contains('=') => all,
            (values, _) => values,
        };
        let values: Vec<_> = values.split(',').map(str::to_owned).collect();
        for (i, value) in values.iter().enumerate() {
            if values[..i].contains(value) {
                return Err(ParseError::new(format!("{value} is there twice")));
            }
        }
        Ok(Self { name: name.to_owned(), values })
    }
}

/// One point of a grid: the value of each axis.
pub type Point = Vec<(String, String)>;

/// All points of the grid of some axes, the last of which changes first.
#[must_use]
pub fn grid(axes: &[Axis]) -> Vec<Point> {
    let mut points = vec![Vec::new()];
    for axis in axes {
        let with = |point: Point| {
            axis.values.iter().map(move |value| {
                let mut point = point.clone();
                point.push((axis.name.clone(), value.clone()));
                point
            })
        };
        points = points.into_iter().flat_map(with).collect();
    }
    points
}

/// A part of the points: those whose number leaves `index` over `parts`. Written `1/2`, `2/2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    parts: usize,
}

impl FromStr for Shard {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let right = || ParseError::new("write I/N for part I of N, 1/N to N/N");
        let (index, parts) = text.split_once('/').ok_or_else(right)?;
        let (index, parts): (usize, usize) = index.parse().ok().zip(parts.parse().ok()).ok_or_else(right)?;
        if index == 0 || index > parts {
            return Err(right());
        }
        Ok(Self { index: index - 1, parts })
    }
}

impl Shard {
    /// Whether the point of that number belongs to this part.
    #[must_use]
    pub fn has(self, point: usize) -> bool {
        point % self.parts == self.index
    }
}

/// Distinguishes the results of a sweep from those of another: a checksum of all that they depend on, the
/// scene's bytes and path as well as how it is simulated.
#[must_use]
pub fn identity(world: &World, scene: &str, how: &impl std::fmt::Debug) -> String {
    let Image { bytes, registers, .. } = &world.image;
    let all = format!("{scene:?} {how:?} {registers:?} {:?} {:032x}", world.path, xxh3_128(bytes));
    format!("{:016x}", xxh3_64(all.as_bytes()))
}

/// Where a result stands in its sweep: the fields with which each line begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Position {
    /// Checksum of the sweep.
    pub sweep: String,
    /// Number of the point.
    pub point: usize,
    /// Points of the whole grid.
    pub points: usize,
}

/// The result of a point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointRow {
    /// Where it stands.
    #[serde(flatten)]
    pub position: Position,
    /// The value of each axis.
    pub at: BTreeMap<String, String>,
    /// Metadata of all lines; none without virtual memory.
    pub metadata_bytes: u64,
    /// What the frame took.
    #[serde(flatten)]
    pub row: TimingRow,
}

/// A frame that was traced, to be simulated on the chip of each point.
#[derive(Clone, Debug)]
pub struct Sweep<'a> {
    /// The scene, as the user named it.
    pub scene: &'a str,
    /// Number of the frame in the path.
    pub frame: usize,
    /// Rays of the frame.
    pub rays: u64,
    /// The frames before, which warm the caches.
    pub before: &'a [Programs],
    /// The traced frame.
    pub programs: &'a Programs,
    /// Checksum of the sweep, as [`identity`] makes it.
    pub identity: &'a str,
    /// All points of the grid.
    pub points: &'a [Point],
    /// The chip of each point.
    pub configs: &'a [ChipConfig],
}

impl Sweep<'_> {
    /// Simulates the points of these numbers, all together: their rows in the same order.
    ///
    /// # Errors
    /// If a configuration makes no chip.
    pub fn rows(&self, points: &[usize]) -> Result<Vec<PointRow>, StudyError> {
        points.par_iter().map(|&point| self.row(point)).collect()
    }

    fn row(&self, point: usize) -> Result<PointRow, StudyError> {
        let config = &self.configs[point];
        let report = simulate(self.before, self.programs, config)?;
        let metadata_bytes = match config.version {
            Version::None => 0,
            Version::A | Version::B => config.cache.geometry.metadata().0,
        };
        let position = Position { sweep: self.identity.to_owned(), point, points: self.points.len() };
        let at = self.points[point].iter().cloned().collect();
        let row = TimingRow::new(self.scene, self.frame, self.rays, config, &report);
        Ok(PointRow { position, at, metadata_bytes, row })
    }
}

/// The costs of a point of one axis.
#[derive(Clone, Copy, Debug)]
pub struct PointCosts {
    /// The point: a size, or a number.
    pub size: u64,
    /// Bytes loaded from the host.
    pub loaded: u64,
    /// Bytes of metadata.
    pub metadata: u64,
}

impl PointCosts {
    /// The first of those whose product of both costs is least.
    #[must_use]
    pub fn best(costs: &[Self]) -> Option<&Self> {
        costs.iter().min_by_key(|costs| u128::from(costs.loaded) * u128::from(costs.metadata))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_is_a_product() {
        let axes = ["ways=1,2", "line=64,128,256"].map(|axis| axis.parse().expect("an axis"));
        let points = grid(&axes);
        assert_eq!(points.len(), 6);
        let text = |(name, value): &(String, String)| format!("{name}={value}");
        let all: Vec<_> = points.iter().map(|p| p.iter().map(text).collect::<Vec<_>>().join(" ")).collect();
        assert_eq!(all[..3], ["ways=1 line=64", "ways=1 line=128", "ways=1 line=256"]);
        assert_eq!(all[5], "ways=2 line=256");
        let all: Axis = "pci".parse().expect("an axis");
        assert_eq!(all.values, ["33x32", "66x64"]);
        assert!("ways=1,1".parse::<Axis>().is_err());
    }

    #[test]
    fn shards_are_a_partition() {
        for point in 0..10 {
            let shards = ["1/3", "2/3", "3/3"].map(|shard| shard.parse::<Shard>().expect("a shard"));
            assert_eq!(shards.iter().filter(|shard| shard.has(point)).count(), 1);
        }
        for text in ["", "1", "0/2", "3/2", "1/0", "a/b", "-1/2"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
