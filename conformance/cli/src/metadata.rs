//! The metadata law (§3) beside the paper's two examples.

use crate::size::Size;
use crate::table::{Column, Table};
use saarcor_model::vm::Bytes;
use saarcor_paper::metadata::example_of;
use saarcor_paper::tables::MetadataExample;
use saarcor_studies::metadata::MetadataFacts;

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
            example_of(facts).map_or_else(|| "–".to_owned(), printed),
        ]);
    }
    table
}
