//! Names of kernels, versions, buses and the like, on a command line and in rows.

use crate::trace::{PacketOrder, PacketSize};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::time::{PciConfig, Version};
use saarcor_scenes::kdbuild::SplitRule;

/// Values by their names.
pub type Names<T> = &'static [(&'static str, T)];

/// The triangle tests by their names.
pub const KERNELS: Names<Kernel> = &[
    ("moller-trumbore", Kernel::MollerTrumbore),
    ("wald", Kernel::Wald),
    ("plucker", Kernel::Plucker),
    ("watertight", Kernel::Watertight),
    ("adaptive", Kernel::Adaptive),
];

/// The rules for edges that several triangles have, by their names.
pub const EDGES: Names<Edges> = &[("shared", Edges::Shared), ("owned", Edges::Owned)];

/// How kd-trees are built, by name.
pub const TREES: Names<SplitRule> = &[("sah", SplitRule::SurfaceArea), ("median", SplitRule::SpatialMedian)];

/// Sizes of packets by their rays.
pub const PACKETS: Names<PacketSize> = &[
    ("1", PacketSize::Rays1),
    ("4", PacketSize::Rays4),
    ("16", PacketSize::Rays16),
    ("64", PacketSize::Rays64),
];

/// Versions of the virtual memory by their names.
pub const VERSIONS: Names<Version> = &[("none", Version::None), ("a", Version::A), ("b", Version::B)];

/// Orders in which packets are handed out, by name.
pub const ORDERS: Names<PacketOrder> = &[("scan", PacketOrder::Scan), ("morton", PacketOrder::Morton)];

/// Buses to the host by name: MHz x bits.
pub const BUSES: Names<PciConfig> =
    &[("33x32", PciConfig::BITS_32_AT_33_MHZ), ("66x64", PciConfig::BITS_64_AT_66_MHZ)];

/// Numbers of ways of a set.
pub const WAYS: Names<u32> = &[("1", 1), ("2", 2), ("4", 4), ("8", 8), ("16", 16)];

/// The name of one of `names`.
///
/// # Panics
/// If it has none.
#[must_use]
pub fn name_of<T: PartialEq>(names: Names<T>, value: &T) -> &'static str {
    names.iter().find(|(_, named)| named == value).expect("every value has its name").0
}

/// The name of a triangle test.
#[must_use]
pub fn kernel_name(kernel: Kernel) -> &'static str {
    name_of(KERNELS, &kernel)
}

/// The name of a version of the virtual memory.
#[must_use]
pub fn version_name(version: Version) -> &'static str {
    name_of(VERSIONS, &version)
}

/// The one of `known` that is most like `name`, if any is like it at all.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let nearest = known.into_iter().min_by_key(|known| edit_distance(name, known))?;
    (edit_distance(name, nearest) <= nearest.len() / 2).then_some(nearest)
}

/// Insertions, deletions and replacements of a letter that turn `a` into `b` (Levenshtein 1966).
fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.bytes().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
