//! The metadata law (§3) beside the paper's two examples.

use crate::args::Size;
use crate::table::{Column, Table};
use saarcor_model::time::standard;
use saarcor_model::vm::{Bytes, ENTRY_BYTES, Geometry};
use saarcor_oracles::paper::{self, MetadataExample};
use serde::Serialize;

/// The metadata of a cache.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MetadataFacts {
    /// Size of the on-board memory.
    pub memory_bytes: u64,
    /// Size of a line.
    pub line_bytes: u64,
    /// Lines a set.
    pub ways: u32,
    /// Lines that the memory holds.
    pub lines: u64,
    /// Number of sets.
    pub sets: u64,
    /// Metadata a line.
    pub entry_bytes: u64,
    /// Metadata of all lines.
    pub metadata_bytes: u64,
    /// The metadata's part of the memory.
    pub metadata_percent: f64,
}

impl MetadataFacts {
    /// The metadata of a cache of this shape.
    #[must_use]
    pub fn of(geometry: Geometry) -> Self {
        let (memory, metadata) = (geometry.memory().0, geometry.metadata().0);
        Self {
            memory_bytes: memory,
            line_bytes: geometry.line().0,
            ways: geometry.ways(),
            lines: geometry.lines(),
            sets: geometry.sets(),
            entry_bytes: ENTRY_BYTES as u64,
            metadata_bytes: metadata,
            metadata_percent: 100.0 * metadata as f64 / memory as f64,
        }
    }

    fn example(&self) -> Option<&'static MetadataExample> {
        let mut examples = paper::stated().metadata.examples.iter();
        examples.find(|e| (e.memory_bytes, e.line_bytes) == (self.memory_bytes, self.line_bytes))
    }
}

/// The paper's examples, computed.
#[must_use]
pub fn examples() -> Vec<MetadataFacts> {
    let paper::Stated { metadata } = paper::stated();
    let shape =
        |e: &MetadataExample| Geometry::new(Bytes(e.memory_bytes), Bytes(e.line_bytes), standard::WAYS);
    metadata.examples.iter().filter_map(|e| shape(e).ok()).map(MetadataFacts::of).collect()
}

/// Ours beside the paper's, where the paper has it.
#[must_use]
pub fn table(rows: &[MetadataFacts]) -> Table {
    let numbers = ["memory", "line", "ways", "lines", "sets", "metadata", "of the memory", "the paper (§3)"];
    let mut table = Table::new(numbers.map(Column::number));
    for facts in rows {
        let printed = |e: &MetadataExample| format!("{} KB, {} %", e.metadata_bytes >> 10, e.printed_percent);
        table.row([
            Size(Bytes(facts.memory_bytes)).to_string(),
            Size(Bytes(facts.line_bytes)).to_string(),
            facts.ways.to_string(),
            facts.lines.to_string(),
            facts.sets.to_string(),
            Size(Bytes(facts.metadata_bytes)).to_string(),
            format!("{:.3} %", facts.metadata_percent),
            facts.example().map_or_else(|| "–".to_owned(), printed),
        ]);
    }
    table
}
