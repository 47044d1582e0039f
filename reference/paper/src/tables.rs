//! The paper's figures as data: Schmittler, Leidinger, Slusallek, "A Virtual Memory Architecture
//! for Real-Time Ray Tracing Hardware" (2003).
//!
//! Table 1, Table 2 and the results stated in the text stand in `*.toml` beside the sources, as printed. All are
//! Stated; the tests hold them to the relations that they have among each other.

use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Bytes in the paper's MB (Derived: §3 calls 5 × 2²⁴ / 128 bytes "640 KB", so its units are
/// powers of two).
pub const MB: u64 = 1 << 20;

/// A number of bytes in [`MB`], as the paper prints them but with two digits.
#[must_use]
pub fn mb(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 / MB as f64)
}

/// A number of bytes in [`MB`].
#[must_use]
pub fn in_mb(bytes: u64) -> f64 {
    bytes as f64 / MB as f64
}

/// Half of the last digit of PCI in Table 2, in [`MB`]: what is less is printed as nothing.
pub const LEAST_PCI_MB: f64 = 0.005;
/// The same of Mem.
pub const LEAST_MEM_MB: f64 = 0.05;

/// A row of Table 1: a benchmark scene.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table1Row {
    /// Name; suffix `nl`: no lighting, `nt`: no textures, `8l`: eight lights.
    pub scene: String,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of lights.
    pub lights: u32,
    /// Geometry on hard disk, in [`MB`].
    pub geometry_mb: u64,
    /// Textures on hard disk, in [`MB`]; `None` where the scene has none.
    pub textures_mb: Option<u64>,
}

/// A row of Table 2: a hot spot, simulated cycle by cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table2Row {
    /// Name of the scene, as in Table 1.
    pub scene: String,
    /// The frame, as printed: a number or a letter.
    pub frame: String,
    /// With the virtual memory, metadata on the chip.
    pub version_a: VirtualRun,
    /// With the virtual memory, metadata in SDRAM behind a cache.
    pub version_b: VirtualRun,
    /// With the whole scene in on-board memory.
    pub no_vm: LocalRun,
}

/// What Table 2 says of a run with virtual memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VirtualRun {
    /// Frames a second.
    pub fps: f64,
    /// Transferred over PCI, in [`MB`] a frame.
    pub pci_mb: f64,
    /// Transferred between chip and on-board memory, in [`MB`] a frame.
    pub mem_mb: f64,
}

/// What Table 2 says of a run without virtual memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalRun {
    /// Frames a second.
    pub fps: f64,
    /// Transferred between chip and on-board memory, in [`MB`] a frame.
    pub mem_mb: f64,
}

/// The results that the text states outside the tables. The sizes and times that it states are those of
/// [`standard`](saarcor_model::time::standard).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stated {
    /// The examples of the metadata law (§3).
    pub metadata: Metadata,
}

/// The metadata law (§3).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metadata {
    /// The examples given.
    pub examples: Vec<MetadataExample>,
}

/// An example of the metadata law (§3).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MetadataExample {
    /// Size of the on-board memory.
    pub memory_bytes: u64,
    /// Size of a line.
    pub line_bytes: u64,
    /// Size of the metadata.
    pub metadata_bytes: u64,
    /// The metadata's part of the memory, as printed: truncated to one decimal.
    pub printed_percent: f64,
}

/// The rows of Table 1, in the order of the paper.
#[must_use]
pub fn table1() -> &'static [Table1Row] {
    static ROWS: LazyLock<Table<Table1Row>> =
        LazyLock::new(|| toml::from_str(include_str!("../table1.toml")).expect("a test reads it"));
    &ROWS.row
}

/// The rows of Table 2, in the order of the paper.
#[must_use]
pub fn table2() -> &'static [Table2Row] {
    static ROWS: LazyLock<Table<Table2Row>> =
        LazyLock::new(|| toml::from_str(include_str!("../table2.toml")).expect("a test reads it"));
    &ROWS.row
}

/// The results that the text states outside the tables.
#[must_use]
pub fn stated() -> &'static Stated {
    static VALUES: LazyLock<Stated> =
        LazyLock::new(|| toml::from_str(include_str!("../stated.toml")).expect("a test reads it"));
    &VALUES
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table<T> {
    row: Vec<T>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::time::standard;
    use saarcor_model::vm::ENTRY_BYTES;
    use saarcor_studies::standard::family;

    fn rows_of(families: &'static [&str]) -> impl Iterator<Item = &'static Table2Row> {
        table2().iter().filter(move |row| families.contains(&family(&row.scene)))
    }

    /// Asserts that `ratio` of each row, rounded to two decimals, lies in `range`.
    fn all_within(
        rows: impl Iterator<Item = &'static Table2Row>,
        range: std::ops::RangeInclusive<f64>,
        ratio: impl Fn(&Table2Row) -> f64,
    ) {
        let mut rows = rows.peekable();
        assert!(rows.peek().is_some(), "no row to judge");
        for row in rows {
            let ratio = (100.0 * ratio(row)).round() / 100.0;
            assert!(range.contains(&ratio), "{}, {}: {ratio} is not in {range:?}", row.scene, row.frame);
        }
    }

    #[test]
    fn tables_are_complete() {
        assert_eq!((table1().len(), table2().len()), (9, 25));
        for scene in table1() {
            let hot_spots = table2().iter().filter(|row| row.scene == scene.scene).count();
            let expected = match family(&scene.scene) {
                "Conference" => 2,
                "Cruiser" => 4,
                _ => 3,
            };
            assert_eq!(hot_spots, expected, "{}", scene.scene);
            assert!(standard::MEMORY_OF.iter().any(|of| of.0 == family(&scene.scene)), "{}", scene.scene);
        }
        assert!(table2().iter().all(|row| table1().iter().any(|scene| scene.scene == row.scene)));
    }

    #[test]
    fn suffixes_say_what_a_scene_lacks() {
        for scene in table1() {
            let (family, suffix) = (family(&scene.scene), scene.scene.split_once('-').map_or("", |s| s.1));
            let textured = matches!(family, "pQuake3" | "Cruiser") && !suffix.contains("nt");
            assert_eq!(scene.textures_mb.is_some(), textured, "{}", scene.scene);
            let lit = family != "Sodahall" && !suffix.contains("nl");
            assert_eq!(scene.lights > 0, lit, "{}", scene.scene);
        }
    }

    #[test]
    fn one_family_has_one_geometry() {
        for a in table1() {
            for b in table1().iter().filter(|b| family(&b.scene) == family(&a.scene)) {
                assert_eq!((a.triangles, a.geometry_mb), (b.triangles, b.geometry_mb));
            }
        }
    }

    #[test]
    fn bytes_a_triangle() {
        let expected = [("pQuake3", 362.0), ("Conference", 327.0), ("Sodahall", 298.0), ("Cruiser", 156.0)];
        for scene in table1() {
            let bytes = (scene.geometry_mb * MB) as f64 / scene.triangles as f64;
            let (_, expected) = expected.iter().find(|e| e.0 == family(&scene.scene)).expect("family");
            assert_eq!(bytes.round(), *expected, "{}", scene.scene);
        }
    }

    #[test]
    fn metadata_law_gives_the_examples() {
        let metadata = &stated().metadata;
        assert_eq!(metadata.examples.len(), 2);
        for example in &metadata.examples {
            let bytes = ENTRY_BYTES as u64 * example.memory_bytes / example.line_bytes;
            assert_eq!(bytes, example.metadata_bytes);
            let percent = 100.0 * bytes as f64 / example.memory_bytes as f64;
            assert_eq!((percent * 10.0).trunc() / 10.0, example.printed_percent);
        }
    }

    /// One line each 550 clocks is the most that the bus can carry; the Cruiser comes nearest.
    #[test]
    fn pci_traffic_stays_below_the_bus() {
        let ceiling = (standard::LINE.0 * standard::CORE_HZ) as f64 / f64::from(standard::PCI_LINE_CYCLES);
        let bytes = |run: &VirtualRun| run.fps * run.pci_mb * MB as f64;
        let mut largest = (0.0, "");
        for row in table2() {
            for run in [&row.version_a, &row.version_b] {
                assert!(bytes(run) < ceiling, "{}, {}", row.scene, row.frame);
                if bytes(run) > largest.0 {
                    largest = (bytes(run), &row.frame);
                }
            }
        }
        assert_eq!(largest.1, "142");
    }

    /// Two Cruiser rows without virtual memory stop at 65 % of the SDRAM's peak, none goes beyond.
    #[test]
    fn memory_traffic_has_a_plateau() {
        let plateau = table2().iter().map(|row| row.no_vm.fps * row.no_vm.mem_mb).fold(0.0, f64::max);
        assert!((1380.0..1390.0).contains(&plateau), "{plateau}");
        let on_it: Vec<_> = rows_of(&["Cruiser"])
            .filter(|row| row.no_vm.fps * row.no_vm.mem_mb > 0.99 * plateau)
            .map(|row| row.frame.as_str())
            .collect();
        assert_eq!(on_it, ["142", "1625"]);
    }

    /// Each line that is loaded is written to the card once, so version A moves what the run
    /// without virtual memory moves, and the lines. Left over is up to 5 %, and the rounding of
    /// three printed numbers.
    #[test]
    fn version_a_writes_each_loaded_line_once() {
        for row in table2() {
            let sum = row.no_vm.mem_mb + row.version_a.pci_mb;
            let rounding = 0.05 + 0.05 + 0.005;
            let left_over = (row.version_a.mem_mb - sum).abs();
            assert!(
                left_over <= 0.05 * row.version_a.mem_mb + rounding,
                "{}, {}: {left_over}",
                row.scene,
                row.frame
            );
        }
    }

    /// Version B's metadata reads. Rows below 0.6 MB are printed too coarsely.
    #[test]
    fn version_b_moves_more() {
        let more = |row: &Table2Row| row.version_b.mem_mb / row.version_a.mem_mb;
        let printed_finely = |row: &&Table2Row| row.version_a.mem_mb >= 0.6;
        let textured = table2().iter().filter(|row| matches!(row.scene.as_str(), "pQuake3" | "pQuake3-nl"));
        all_within(rows_of(&["Conference"]), 1.32..=1.34, more);
        all_within(rows_of(&["Cruiser"]), 1.16..=1.21, more);
        all_within(textured, 1.10..=1.19, more);
        all_within(rows_of(&["Sodahall"]).filter(printed_finely), 1.20..=1.30, more);
    }

    /// How much speed the virtual memory costs.
    #[test]
    fn speed_with_virtual_memory() {
        let a = |row: &Table2Row| row.version_a.fps / row.no_vm.fps;
        let b = |row: &Table2Row| row.version_b.fps / row.no_vm.fps;
        all_within(rows_of(&["pQuake3", "Sodahall"]), 0.97..=1.00, a);
        all_within(rows_of(&["Conference"]), 0.95..=0.98, a);
        all_within(rows_of(&["Cruiser"]), 0.66..=0.82, a);
        all_within(rows_of(&["pQuake3", "Sodahall"]), 0.97..=1.00, b);
        all_within(rows_of(&["Conference"]), 0.88..=0.96, b);
        all_within(rows_of(&["Cruiser"]), 0.47..=0.69, b);
    }
}
