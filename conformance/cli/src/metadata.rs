//! The metadata law (§3) beside the paper's two examples.

use crate::size::Size;
use crate::table::{Column, Table};
use saarcor_model::time::standard;
use saarcor_model::vm::{Bytes, Geometry};
use saarcor_oracles::paper::{self, MetadataExample};
use saarcor_studies::metadata::MetadataFacts;

/// The paper's example of the same sizes.
fn example(facts: &MetadataFacts) -> Option<&'static MetadataExample> {
    let mut examples = paper::stated().metadata.examples.iter();
    examples.find(|e| (e.memory_bytes, e.line_bytes) == (facts.memory_bytes, facts.line_bytes))
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
            example(facts).map_or_else(|| "–".to_owned(), printed),
        ]);
    }
    table
}
