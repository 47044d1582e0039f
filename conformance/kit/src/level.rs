//! Levels of agreement.

use serde::Serialize;
use std::fmt;

/// How far an implementation agrees with the specification. Each level contains those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// The conversation itself: each request has its answer, in the form of PROTOCOL.md.
    Protocol,
    /// Every byte is right, whatever the replacement policy.
    Data,
    /// The same hits, misses and bytes moved.
    Traffic,
    /// The same way and the same victim.
    State,
    /// The same metadata moved, in version B.
    Metadata,
    /// Each ray hits the same triangle at the same distance, or one as good within the derived bound.
    Rays,
    /// The same nodes, list entries and triangles are read, in the same order.
    Traversal,
    /// The same cycles, or as many within a stated tolerance.
    Timing,
}

impl Level {
    /// All levels, the lowest first.
    pub const ALL: [Self; 8] = [
        Self::Protocol,
        Self::Data,
        Self::Traffic,
        Self::State,
        Self::Metadata,
        Self::Rays,
        Self::Traversal,
        Self::Timing,
    ];

    /// The highest.
    pub const HIGHEST: Self = Self::Timing;

    /// The level's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Protocol => "protocol",
            Self::Data => "data",
            Self::Traffic => "traffic",
            Self::State => "state",
            Self::Metadata => "metadata",
            Self::Rays => "rays",
            Self::Traversal => "traversal",
            Self::Timing => "timing",
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
