//! The directed sessions, by their names and texts: one idea and one requirement each.
//!
//! They stand in an order in which what comes later builds on what came before: the first that fails
//! names the cause.

use crate::session::Session;

/// A suite file of `conformance/suites`.
macro_rules! suites {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../suites/", $name, ".txt")))),*]
    };
}

/// Rays of recorded frames, as sessions of `saarcor-kd`.
pub const KD_FRAMES: &[(&str, &str)] = suites!["kd/frame/pquake3-nt-150"];

/// Packets of recorded frames, as sessions of `saarcor-chip`.
pub const CHIP_FRAMES: &[(&str, &str)] = suites!["chip/frame/pquake3-nt-150"];

/// The sessions of recorded frames.
pub(crate) fn of_frames(frames: &[(&str, &str)]) -> impl Iterator<Item = Session> {
    let parsed = |(name, text): &(&str, &str)| Session::parse(name, text).expect("a suite of the kit");
    frames.iter().flat_map(parsed)
}

/// Suites of `saarcor-vm`.
pub const VM: &[(&str, &str)] = suites![
    "vm/hello-and-end",
    "vm/one-answer-a-request",
    "vm/comments",
    "vm/loaded-line-hits",
    "vm/line-is-one-access",
    "vm/memory-holds-its-lines",
    "vm/free-ways-in-order",
    "vm/tag-has-every-bit",
    "vm/line-of-one-byte",
    "vm/large-memory",
    "vm/offset-on-the-card",
    "vm/evicted-address",
    "vm/set-on-the-card",
    "vm/ways-on-the-card",
    "vm/hash-low",
    "vm/hash-adds-upper-bits",
    "vm/hash-drops-the-carry",
    "vm/hash-adds-all-upper-bits",
    "vm/hash-adds-once",
    "vm/hash-of-one-set",
    "vm/hash-spreads-strides",
    "vm/tag-with-the-hash",
    "vm/end-of-the-card",
    "vm/unwritten-is-zero",
    "vm/zero-after-others",
    "vm/bytes-are-the-hosts",
    "vm/load-moves-the-whole-line",
    "vm/long-lines",
    "vm/long-reads",
    "vm/lines-lie-apart",
    "vm/write-across-lines",
    "vm/long-write",
    "vm/evicted-line-is-loaded-anew",
    "vm/hit-while-resident",
    "vm/write-leaves-the-line",
    "vm/miss-after-eviction",
    "vm/lru-victim",
    "vm/lru-hit-makes-youngest",
    "vm/lru-all-orders",
    "vm/fifo-victim",
    "vm/fifo-hit-changes-nothing",
    "vm/plru-victim",
    "vm/plru-hit-turns-the-tree",
    "vm/plru-of-many-ways",
    "vm/write-makes-no-line-younger",
    "vm/sets-are-apart",
    "vm/invalidate-one-line",
    "vm/invalidate-by-any-byte",
    "vm/invalidate-both-ends",
    "vm/invalidate-another-line",
    "vm/look-up-before-a-free-way",
    "vm/invalidate-in-the-last-way",
    "vm/invalidate-many-lines",
    "vm/invalidate-as-many-lines-as-there-are",
    "vm/invalidate-thousands-of-lines",
    "vm/invalidate-long-ranges",
    "vm/invalidate-up-to-the-end",
    "vm/invalidate-all-addresses",
    "vm/flush",
    "vm/line-lies-where-it-was-loaded",
    "vm/free-way-after-invalidation",
    "vm/free-way-before-a-victim",
    "vm/line-in-a-free-way-is-youngest",
    "vm/plru-load-turns-the-tree",
    "vm/invalidate-keeps-the-order",
    "vm/write-and-invalidate",
    "vm/range-brings-new-bytes",
    "vm/flush-brings-new-bytes",
    "vm/write-without-invalidation",
    "vm/writes-within-a-line",
    "vm/last-byte-of-the-addresses",
];

/// Suites of `saarcor-hash`.
pub const HASH: &[(&str, &str)] = suites![
    "hash/hello-and-end",
    "hash/lower-bits",
    "hash/low-leaves-upper-bits-out",
    "hash/upper-bits-are-added",
    "hash/carry-is-dropped",
    "hash/added-once-or-all",
    "hash/top-bits",
    "hash/one-set",
    "hash/any-power-of-two",
];

/// Suites of `saarcor-meta`.
pub const META: &[(&str, &str)] = suites![
    "meta/hello-and-end",
    "meta/one-answer-a-request",
    "meta/hit-while-resident",
    "meta/ways-and-victims",
    "meta/one-way",
    "meta/granules-of-a-set",
    "meta/youngest-changes-nothing",
    "meta/invalidate-an-absent-line",
    "meta/changed-granules-alone",
    "meta/update-is-not-dropped",
    "meta/written-back-when-evicted",
    "meta/clean-granule-is-dropped",
    "meta/clean-after-a-write-back",
    "meta/oldest-granule-goes",
    "meta/granules-find-their-set",
    "meta/read-before-the-write-back",
    "meta/evicted-by-its-own-set",
    "meta/line-in-the-entry",
    "meta/management-bits-in-the-entry",
    "meta/check-bits-in-the-entry",
    "meta/behind-the-last-set",
    "meta/invalidation-changes-one-bit",
    "meta/invalidated-line-is-gone",
    "meta/free-way-is-no-victim",
    "meta/granules-of-a-range",
    "meta/flush-empties-the-card",
    "meta/flush-drops-what-was-written",
    "meta/flush-of-all-metadata",
    "meta/corrupt-set-is-empty",
    "meta/each-check-bit-counts",
    "meta/bits-flip",
    "meta/corrupt-free-way",
    "meta/corrupt-set-is-written-whole",
    "meta/neighbour-of-a-corrupt-set",
    "meta/error-under-a-cached-granule",
    "meta/error-in-any-way",
    "meta/errors-in-neighbouring-bits",
    "meta/range-in-one-set",
];

/// Suites of `saarcor-kd`.
pub const KD: &[(&str, &str)] = suites![
    "kd/hello-and-end",
    "kd/one-answer-a-request",
    "kd/comments",
    "kd/no-triangles",
    "kd/both-faces",
    "kd/corners-of-a-triangle",
    "kd/distance-in-lengths-of-the-direction",
    "kd/numbers-within-the-bound",
    "kd/inside-and-outside",
    "kd/small-triangle",
    "kd/edges-belong",
    "kd/corners-belong",
    "kd/ray-in-the-plane-of-a-triangle",
    "kd/behind-the-origin",
    "kd/long-write",
    "kd/range-begins-closed",
    "kd/range-ends-open",
    "kd/nearest-wins",
    "kd/tie-goes-to-the-lower-address",
    "kd/tie-by-the-whole-address",
    "kd/list-names-triangles",
    "kd/long-list",
    "kd/plane-across-x",
    "kd/plane-across-y",
    "kd/plane-across-z",
    "kd/children-anywhere",
    "kd/hit-beyond-the-cell",
    "kd/triangle-in-two-cells",
    "kd/empty-cells",
    "kd/any-hit",
    "kd/parallel-below",
    "kd/tiny-directions",
    "kd/ray-in-the-split-plane",
    "kd/parallel-to-the-box",
    "kd/near-child-first",
    "kd/minus-zero",
    "kd/far-away",
    "kd/outside-of-the-box",
    "kd/one-child",
    "kd/at-the-very-plane",
    "kd/widened-by-the-bound",
    "kd/no-bound-both-children",
    "kd/least-normal-reciprocal",
    "kd/hit-cuts-off",
    "kd/tested-in-each-cell",
    "kd/all-of-a-list",
    "kd/stack-of-64",
    "kd/scene-written-anew",
    "kd/scene-anywhere",
    "kd/scene-at-the-end",
    "kd/exact-order",
    "kd/edges-owned",
    "kd/exact-edges",
    "kd/no-hole-between-triangles",
    "kd/flush-clears-all",
    "kd/bytes-below-powers-of-two",
    "kd/second-box",
];

/// Suites of `saarcor-chip`.
pub const CHIP: &[(&str, &str)] = suites![
    "chip/hello-and-end",
    "chip/one-answer-a-request",
    "chip/a-ray-without-bytes",
    "chip/partial-cycles-count-whole",
    "chip/whole-packet",
    "chip/one-operation-after-the-other",
    "chip/packets-in-order",
    "chip/units-are-pipelined",
    "chip/one-packet-a-cycle",
    "chip/nothing-to-do",
    "chip/units-of-each-pipeline",
    "chip/pipelines-in-turn",
    "chip/turn-goes-on",
    "chip/lowest-free-thread",
    "chip/units-in-turn",
    "chip/standard-rates",
    "chip/beats-of-a-line",
    "chip/line-is-fetched-whole",
    "chip/row-is-opened",
    "chip/next-clock",
    "chip/tag-without-virtual-memory",
    "chip/look-up",
    "chip/lines-one-after-the-other",
    "chip/open-row",
    "chip/rows-in-banks",
    "chip/another-row",
    "chip/row-cycle",
    "chip/row-stays-open",
    "chip/openings-apart",
    "chip/rows-in-order",
    "chip/rows-are-of-their-size",
    "chip/rows-share-banks",
    "chip/data-without-a-gap",
    "chip/one-command-a-clock",
    "chip/data-in-order",
    "chip/rows-open-ahead",
    "chip/over-two-rows",
    "chip/return",
    "chip/row-closes-after-its-reads",
    "chip/refresh",
    "chip/refresh-waits-for-what-came-before",
    "chip/refresh-without-a-row",
    "chip/refreshes-in-a-row",
    "chip/without-virtual-memory",
    "chip/first-level-lines",
    "chip/first-level-ways",
    "chip/first-level-sets",
    "chip/triangle-lines-from-the-first",
    "chip/first-level-of-each-unit",
    "chip/bytes-across-lines",
    "chip/bytes-without-rays",
    "chip/line-in-flight",
    "chip/all-waiting-threads-are-answered",
    "chip/evicted-in-flight",
    "chip/registers",
    "chip/no-register-no-look-up",
    "chip/registers-first-come",
    "chip/queue-goes-on",
    "chip/others-go-on",
    "chip/ports",
    "chip/ports-pipelines-in-turn",
    "chip/ports-threads-in-turn",
    "chip/hit-under-a-miss",
    "chip/part-a-cycle",
    "chip/line-is-written",
    "chip/tag",
    "chip/line-from-the-host",
    "chip/partial-beats-count-whole",
    "chip/one-transfer-at-a-time",
    "chip/parts-share-a-load",
    "chip/written-before-it-is-read",
    "chip/command-a-clock",
    "chip/row-closes-after-its-writes",
    "chip/parts-across-lines",
    "chip/end-of-the-addresses",
    "chip/arrives-with-its-last-part",
    "chip/part-a-cycle-of-a-line",
    "chip/parts-of-caches-in-turn",
    "chip/line-stays-on-the-card",
    "chip/line-is-loaded-once",
    "chip/evicted-while-it-is-loaded",
    "chip/hit-before-a-later-load",
    "chip/waits-for-the-latest-load",
    "chip/set-of-a-line",
    "chip/victim",
    "chip/lines-lie-in-their-ways",
    "chip/metadata-is-read",
    "chip/granules",
    "chip/ways-of-metadata",
    "chip/metadata-is-written-back",
    "chip/granule-stays-changed",
    "chip/metadata-unchanged",
    "chip/metadata-before-the-tag",
    "chip/tags-in-order",
    "chip/metadata-behind-the-lines",
    "chip/read-before-the-write-back",
    "chip/versions-agree",
    "chip/free-ways",
    "chip/warm-takes-no-time",
    "chip/warm-first-level",
    "chip/warm-virtual-memory",
    "chip/standard-latencies",
    "chip/run-again",
    "chip/phases",
    "chip/beats-that-hold-bytes",
    "chip/look-up-of-a-line-in-flight",
    "chip/tags-of-one-cycle",
    "chip/order-of-many-ways-is-metadata",
    "chip/ports-of-one-pipeline-of-many",
    "chip/rows-are-closed-ahead",
    "chip/row-cycle-before-a-refresh",
    "chip/refreshes-one-after-the-other",
    "chip/no-refresh-is-left-out",
];

#[cfg(test)]
mod tests {
    use super::{CHIP_FRAMES, KD_FRAMES};
    use crate::kinds::KINDS;
    use crate::session::Session;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_suite_is_listed_and_legal() {
        let mut listed: BTreeSet<_> =
            KD_FRAMES.iter().chain(CHIP_FRAMES).map(|(name, _)| format!("{name}.txt")).collect();
        for kind in KINDS {
            for (name, text) in kind.suites() {
                for session in Session::parse(name, text).expect("a suite") {
                    kind.check(&session).expect(&session.name);
                    assert!(session.requirement.is_some() && session.idea.ends_with('.'), "{name}");
                }
                listed.insert(format!("{name}.txt"));
            }
        }
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../suites"));
        let mut open = vec![folder.to_owned()];
        while let Some(path) = open.pop() {
            if path.is_dir() {
                let entries = std::fs::read_dir(path).expect("a folder");
                open.extend(entries.map(|entry| entry.expect("an entry").path()));
            } else {
                let name = path.strip_prefix(folder).expect("a file in it").display().to_string();
                assert!(listed.remove(&name), "{name} is not listed");
            }
        }
        assert!(listed.is_empty());
    }
}
