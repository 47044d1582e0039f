//! The metadata law (§3).

use saarcor_model::vm::{ENTRY_BYTES, Geometry};
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
}
