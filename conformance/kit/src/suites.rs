//! The directed sessions, by their names and texts: one idea and one requirement each.
//!
//! They stand in an order in which what comes later builds on what came before: the first that fails
//! names the cause.

/// A suite file of `conformance/suites`.
macro_rules! suites {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../suites/", $name, ".txt")))),*]
    };
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
    "vm/pushed-out-line-is-loaded-anew",
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
    "vm/write-is-no-use",
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
    "vm/young-in-a-free-way",
    "vm/plru-load-turns-the-tree",
    "vm/invalidate-keeps-the-order",
    "vm/write-and-invalidate",
    "vm/range-brings-new-bytes",
    "vm/flush-brings-new-bytes",
    "vm/write-without-invalidation",
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
    "meta/changed-granules-alone",
    "meta/update-is-not-dropped",
    "meta/written-back-when-pushed-out",
    "meta/clean-granule-is-dropped",
    "meta/clean-after-a-write-back",
    "meta/oldest-granule-goes",
    "meta/granules-find-their-set",
    "meta/read-before-the-write-back",
    "meta/pushed-out-by-its-own-set",
    "meta/line-in-the-entry",
    "meta/management-bits-in-the-entry",
    "meta/check-bits-in-the-entry",
    "meta/invalidation-changes-one-bit",
    "meta/invalidate-an-absent-line",
    "meta/invalidated-line-is-gone",
    "meta/free-way-is-no-victim",
    "meta/granules-of-a-range",
    "meta/flush-empties-the-card",
    "meta/flush-drops-what-was-written",
    "meta/corrupt-set-is-empty",
    "meta/each-check-bit-counts",
    "meta/corrupt-free-way",
    "meta/corrupt-set-is-written-whole",
    "meta/neighbour-of-a-corrupt-set",
    "meta/error-under-a-cached-granule",
];

/// Suites of `saarcor-kd`.
pub const KD: &[(&str, &str)] = suites![
    "kd/hello-and-end",
    "kd/one-answer-a-request",
    "kd/comments",
    "kd/no-triangles",
    "kd/corners-of-a-triangle",
    "kd/distance-counts-directions",
    "kd/both-faces",
    "kd/inside-and-outside",
    "kd/edges-belong",
    "kd/corners-belong",
    "kd/ray-in-the-plane-of-a-triangle",
    "kd/behind-the-origin",
    "kd/range-begins-closed",
    "kd/range-ends-open",
    "kd/nearest-wins",
    "kd/tie-goes-to-the-lower-address",
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
    "kd/ray-in-the-split-plane",
    "kd/parallel-to-the-box",
    "kd/near-child-first",
    "kd/minus-zero",
    "kd/outside-of-the-box",
    "kd/one-child",
    "kd/at-the-very-plane",
    "kd/widened-by-the-bound",
    "kd/no-bound-both-children",
    "kd/hit-cuts-off",
    "kd/all-of-a-list",
    "kd/stack-of-64",
    "kd/scene-written-anew",
    "kd/scene-anywhere",
    "kd/scene-at-the-end",
    "kd/exact-order",
    "kd/exact-edges",
    "kd/no-hole-between-triangles",
];

/// Suites of `saarcor-chip`.
pub const CHIP: &[(&str, &str)] = suites![
    "chip/hello-and-end",
    "chip/one-answer-a-request",
    "chip/a-ray-without-bytes",
    "chip/begun-cycles",
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
    "chip/rows-are-of-their-size",
    "chip/rows-share-banks",
    "chip/data-without-a-gap",
    "chip/data-in-order",
    "chip/rows-open-ahead",
    "chip/over-two-rows",
    "chip/return",
    "chip/row-closes-after-its-reads",
    "chip/refresh",
    "chip/refresh-waits-for-what-came-before",
    "chip/without-virtual-memory",
    "chip/first-level-lines",
    "chip/first-level-ways",
    "chip/first-level-sets",
    "chip/triangle-lines-from-the-first",
    "chip/first-level-of-each-unit",
    "chip/bytes-across-lines",
    "chip/bytes-without-rays",
    "chip/line-on-its-way",
    "chip/all-who-wait-are-answered",
    "chip/pushed-out-on-its-way",
    "chip/registers",
    "chip/no-register-no-look-up",
    "chip/registers-first-come",
    "chip/others-go-on",
    "chip/ports",
    "chip/ports-pipelines-in-turn",
    "chip/ports-threads-in-turn",
    "chip/hit-under-a-miss",
    "chip/part-a-cycle",
    "chip/line-is-written",
    "chip/tag",
    "chip/line-from-the-host",
    "chip/begun-beats",
    "chip/one-transfer-at-a-time",
    "chip/written-before-it-is-read",
    "chip/command-a-clock",
    "chip/row-closes-after-its-writes",
    "chip/parts-across-lines",
    "chip/arrives-with-its-last-part",
    "chip/parts-of-caches-in-turn",
    "chip/line-stays-on-the-card",
    "chip/line-is-loaded-once",
    "chip/pushed-out-while-it-is-loaded",
    "chip/set-of-a-line",
    "chip/victim",
    "chip/lines-lie-in-their-ways",
    "chip/metadata-is-read",
    "chip/granules",
    "chip/ways-of-metadata",
    "chip/metadata-is-written-back",
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
];

#[cfg(test)]
mod tests {
    use crate::KINDS;
    use crate::session::Session;
    use std::collections::BTreeSet;

    #[test]
    fn every_suite_is_listed_and_legal() {
        let mut listed = BTreeSet::new();
        for kind in KINDS {
            for (name, text) in kind.suites() {
                for session in Session::parse(name, text).expect("a suite") {
                    assert_eq!(kind.check(&session), Ok(()), "{}", session.name);
                    assert!(session.requirement.is_some() && session.idea.ends_with('.'), "{name}");
                }
                listed.insert(format!("{name}.txt"));
            }
        }
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../suites");
        for kind in std::fs::read_dir(folder).expect("the suites") {
            let kind = kind.expect("a folder");
            for file in std::fs::read_dir(kind.path()).expect("a folder") {
                let name =
                    format!("{}/{}", kind.file_name().display(), file.expect("a file").file_name().display());
                assert!(listed.remove(&name), "{name} is not listed");
            }
        }
        assert!(listed.is_empty());
    }
}
