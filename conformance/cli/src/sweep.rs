//! Sweeps: one frame on many chips, one for each point of a grid.
//!
//! Results are lines of JSON in the order of the grid's points, whatever order they were found in.
//! So a file of them says by itself how far it is, a sweep that was stopped goes on where it was,
//! and the parts of a grid that several machines worked on can be merged.

use crate::simulate::Row;
use crate::world::World;
use anyhow::{Context, Result, bail, ensure};
use rayon::prelude::*;
use saarcor_fast::chip::simulate;
use saarcor_model::host::HostImage;
use saarcor_model::time::{ChipConfig, Programs, Version};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use xxhash_rust::xxh3::{xxh3_64, xxh3_128};

/// What is varied, and the values that it takes: `line` or `line=64,128`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Its values, as they are written.
    pub values: Vec<String>,
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, values) = text.split_once('=').unwrap_or((text, ""));
        let all = crate::args::AXES.iter().find(|(known, _)| *known == name);
        let values = match (values, all) {
            ("", Some((_, all))) if !text.contains('=') => all,
            (values, _) => values,
        };
        let values: Vec<_> = values.split(',').map(str::to_owned).collect();
        for (i, value) in values.iter().enumerate() {
            if values[..i].contains(value) {
                return Err(format!("{value} is there twice"));
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
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let right = "write I/N for part I of N, 1/N to N/N";
        let (index, parts) = text.split_once('/').ok_or(right)?;
        let (index, parts): (usize, usize) = index.parse().ok().zip(parts.parse().ok()).ok_or(right)?;
        if index == 0 || index > parts {
            return Err(right.to_owned());
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

/// What tells the results of a sweep from those of another: a checksum of all that they depend on, the
/// scene's bytes and path as well as how it is simulated.
#[must_use]
pub fn identity(world: &World, scene: &str, how: &impl std::fmt::Debug) -> String {
    let HostImage { bytes, registers, .. } = &world.image;
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

impl Position {
    /// Of a line of results.
    fn of(line: &str) -> Result<Self> {
        serde_json::from_str(line).context("no result of a sweep")
    }
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
    pub row: Row,
}

/// What a frame takes on the chip of a point.
///
/// # Errors
/// If the configuration makes no chip.
pub fn result(
    (scene, frame, rays): (&str, usize, u64),
    (before, programs): (&[Programs], &Programs),
    (position, at): (Position, &Point),
    config: &ChipConfig,
) -> Result<PointRow> {
    let report = simulate(before, programs, config)?;
    let metadata_bytes = match config.version {
        Version::None => 0,
        Version::A | Version::B => config.cache.geometry.metadata().0,
    };
    let row = Row::new(scene, frame, rays, config, &report);
    Ok(PointRow { position, at: at.iter().cloned().collect(), metadata_bytes, row })
}

/// Lines of results that grow, in memory or in a file too.
pub struct Results {
    /// The lines.
    pub lines: Vec<String>,
    file: Option<(PathBuf, File)>,
}

impl Results {
    /// Those of the points at `expected`, as far as `file` has them. A line that was not written to
    /// its end is dropped.
    ///
    /// # Errors
    /// If the file cannot be read and written, or holds other results.
    pub fn open(file: Option<&Path>, expected: &[Position]) -> Result<Self> {
        let Some(path) = file else { return Ok(Self { lines: Vec::new(), file: None }) };
        let cannot = || format!("{}: cannot be written", path.display());
        // A device or a pipe has no end to go on at.
        let is_file = fs::metadata(path).map_or(true, |found| found.is_file());
        ensure!(is_file, "{}: no plain file; name one, or print with --json", path.display());
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(error).with_context(|| format!("{}: cannot be read", path.display())),
        };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let lines: Vec<_> = text[..whole].lines().map(str::to_owned).collect();
        for (i, line) in lines.iter().enumerate() {
            let position =
                Position::of(line).with_context(|| format!("{}: line {}", path.display(), i + 1))?;
            ensure!(
                expected.get(i) == Some(&position),
                "{}: line {}: result of another sweep; name a new file",
                path.display(),
                i + 1
            );
        }
        let file = File::options().create(true).append(true).open(path).with_context(cannot)?;
        file.set_len(whole as u64).with_context(cannot)?;
        Ok(Self { lines, file: Some((path.to_owned(), file)) })
    }

    /// Adds the results of the points that are left, `at_a_time` of them worked on together.
    ///
    /// # Errors
    /// Those of `result`, and if the file cannot be written.
    pub fn complete<T: Sync>(
        &mut self,
        points: &[T],
        at_a_time: usize,
        report: impl Fn(f64),
        result: impl Fn(&T) -> Result<PointRow> + Sync,
    ) -> Result<()> {
        for chunk in points[self.lines.len()..].chunks(at_a_time.max(1)) {
            report(self.lines.len() as f64 / points.len() as f64);
            let rows: Vec<_> = chunk.par_iter().map(&result).collect();
            for row in rows {
                let line = serde_json::to_string(&row?).context("result as JSON")?;
                if let Some((path, file)) = &mut self.file {
                    // What a full disk leaves of a line is dropped when the sweep goes on.
                    file.write_all(format!("{line}\n").as_bytes())
                        .with_context(|| format!("{}: cannot be written", path.display()))?;
                }
                self.lines.push(line);
            }
        }
        Ok(())
    }
}

/// The lines of several files as those of the whole grid, in its order.
///
/// # Errors
/// If they are not of one sweep, differ, or leave points out.
pub fn merged(files: &[(String, String)]) -> Result<Vec<String>> {
    let mut all: BTreeMap<usize, &str> = BTreeMap::new();
    let mut one: Option<Position> = None;
    for (name, text) in files {
        for (i, line) in text.lines().enumerate() {
            let position = Position::of(line).with_context(|| format!("{name}: line {}", i + 1))?;
            let first = one.get_or_insert_with(|| position.clone());
            ensure!(
                (&position.sweep, position.points) == (&first.sweep, first.points),
                "{name}: line {}: result of another sweep",
                i + 1
            );
            if all.insert(position.point, line).is_some_and(|other| other != line) {
                bail!("{name}: line {}: point {} has another result elsewhere", i + 1, position.point);
            }
        }
    }
    let points = one.context("no results in any of the files")?.points;
    if let Some(missing) = (0..points).find(|point| !all.contains_key(point)) {
        bail!("point {missing} of 0 to {} is in none of the files; finish its part first", points - 1);
    }
    Ok(all.into_values().map(str::to_owned).collect())
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

    #[test]
    fn merging_needs_all_of_one_sweep() {
        let line = |sweep, point| format!(r#"{{"sweep":"{sweep}","point":{point},"points":3}}"#);
        let file = |name: &str, lines: &[String]| (name.to_owned(), lines.join("\n"));
        let (a, b) = (file("a", &[line("x", 0), line("x", 2)]), file("b", &[line("x", 1)]));
        let whole = merged(&[b.clone(), a.clone()]).expect("whole");
        assert_eq!(whole, [line("x", 0), line("x", 1), line("x", 2)]);
        let said = |files: &[_]| merged(files).expect_err("refused").to_string();
        assert!(said(std::slice::from_ref(&a)).contains("point 1"));
        assert!(said(&[a, b, file("c", &[line("y", 1)])]).contains("another sweep"));
        assert!(said(&[]).contains("no results"));
    }
}
