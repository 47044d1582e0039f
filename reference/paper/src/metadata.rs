//! The metadata law (§3): the paper's two examples.

use crate::tables::{MetadataExample, Stated, stated};
use saarcor_model::time::standard;
use saarcor_model::vm::{Bytes, Geometry};
use saarcor_studies::metadata::MetadataFacts;

/// The paper's examples, computed.
#[must_use]
pub fn examples() -> Vec<MetadataFacts> {
    let Stated { metadata } = stated();
    let shape =
        |e: &MetadataExample| Geometry::new(Bytes(e.memory_bytes), Bytes(e.line_bytes), standard::WAYS);
    metadata.examples.iter().filter_map(|e| shape(e).ok()).map(MetadataFacts::of).collect()
}

/// The paper's example of the same sizes.
#[must_use]
pub fn example_of(facts: &MetadataFacts) -> Option<&'static MetadataExample> {
    let mut examples = stated().metadata.examples.iter();
    examples.find(|e| (e.memory_bytes, e.line_bytes) == (facts.memory_bytes, facts.line_bytes))
}
