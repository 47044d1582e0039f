//! The table of composition: for each public operation of the virtual memory, the theorems that show that it
//! does what the abstract machine does, and that its twin does what it does: `proofs/COMPOSITION.md`.
//!
//! Which operations there are is read from the source: [`operations`]. One that is added there and not here is
//! one of the [`gaps`], and so is a row whose operation or theorem is gone.

use std::collections::BTreeSet;
use std::fmt::Write as _;

/// An operation of the specification: its name, and the theorems that show its step.
pub type Operation = (&'static str, &'static [&'static str]);

/// An operation of a twin: its name, that of the specification, and the theorems that show them equal.
pub type Twin = (&'static str, &'static str, &'static [&'static str]);

/// The files of the specification, and of each the operations, in the order of the source.
pub const SPECIFICATION: &[(&str, &[Operation])] = &[
    (
        "model/spec/src/vm/set.rs",
        &[
            ("Outcome::way", &["accessed_line_is_resident"]),
            ("Set::empty", &["empty_set_is_legal", "runs_begin_with_empty_sets"]),
            ("Set::is_valid", &["invariant_rejects_illegal_sets"]),
            ("Set::way_of", &["hit_iff_resident", "line_is_in_one_way"]),
            (
                "Set::access",
                &["access_keeps_invariant", "hit_iff_resident", "other_lines_stay", "victim_is_the_oldest"],
            ),
            ("Set::invalidate", &["invalidation_keeps_invariant", "invalidation_forgets_one_line"]),
        ],
    ),
    (
        "model/spec/src/vm/entry.rs",
        &[
            ("Entry::encode", &["entry_decodes_to_itself", "encoding_is_unique"]),
            ("Entry::decode", &["entry_decodes_to_itself", "short_errors_are_detected"]),
            ("Set::to_entries", &["set_decodes_to_itself"]),
            ("Set::from_entries", &["set_decodes_to_itself", "illegal_sets_are_detected"]),
        ],
    ),
    (
        "model/spec/src/vm/directory.rs",
        &[
            ("CacheConfig::set_of", &["hash_names_a_set"]),
            ("CacheConfig::lines_of", &["lines_of_a_range_are_those_it_meets"]),
            ("Counters::count", &["counters_count_each_access"]),
            ("Counters::hits", &["counters_count_each_access"]),
            ("Directory::new", &["runs_begin_with_empty_sets"]),
            ("Directory::sets", &["access_is_the_step_of_its_set"]),
            ("Directory::over", &["runs_begin_with_empty_sets"]),
            (
                "Directory::access",
                &[
                    "access_is_the_step_of_its_set",
                    "directory_answers_from_what_it_loads",
                    "version_b_steps_as_version_a",
                ],
            ),
            (
                "Directory::invalidate",
                &[
                    "invalidation_forgets_exactly_the_range",
                    "directory_invalidates_what_it_loads",
                    "version_b_steps_as_version_a",
                ],
            ),
            (
                "Directory::flush",
                &["flush_forgets_all", "version_b_forgets_all", "version_b_steps_as_version_a"],
            ),
        ],
    ),
    (
        "model/spec/src/vm/version_a.rs",
        &[
            ("OnChip::new", &["runs_begin_with_empty_sets"]),
            ("OnChip::load", &["access_is_the_step_of_its_set"]),
            ("OnChip::store", &["access_is_the_step_of_its_set"]),
            ("OnChip::clear", &["flush_forgets_all"]),
        ],
    ),
    (
        "model/spec/src/vm/version_b.rs",
        &[
            ("MetadataTraffic::granule_used", &["metadata_traffic_counts_granules"]),
            ("MetadataTraffic::corrupt", &["corrupt_metadata_makes_an_empty_set"]),
            ("CachedMetadata::new", &["runs_begin_with_empty_sets"]),
            ("CachedMetadata::observed", &["runs_begin_with_empty_sets"]),
            ("CachedMetadata::location_of", &["metadata_lies_set_after_set"]),
            ("CachedMetadata::granule_of", &["granules_of_a_set_hold_its_metadata"]),
            ("CachedMetadata::on_card", &["granule_lies_at_its_number_on_the_card"]),
            ("CachedMetadata::entries", &["version_b_loads_what_it_holds"]),
            ("CachedMetadata::load", &["version_b_loads_what_it_holds", "version_b_steps_as_version_a"]),
            ("CachedMetadata::store", &["version_b_stores_one_set", "version_b_steps_as_version_a"]),
            ("CachedMetadata::clear", &["version_b_forgets_all", "version_b_steps_as_version_a"]),
        ],
    ),
    (
        "model/spec/src/vm/data_set.rs",
        &[
            ("DataSet::empty", &["runs_begin_as_flat_memory"]),
            ("DataSet::is_valid", &["invariant_rejects_dirty_free_ways"]),
            (
                "DataSet::access",
                &[
                    "data_set_keeps_invariant",
                    "data_set_decides_like_the_set",
                    "access_keeps_every_lines_bytes",
                ],
            ),
            ("DataSet::write", &["data_set_keeps_invariant", "write_changes_one_line"]),
            ("DataSet::invalidate", &["data_set_keeps_invariant", "invalidation_drops_one_lines_bytes"]),
        ],
    ),
    (
        "model/spec/src/vm/virtual_memory.rs",
        &[
            ("VirtualMemory::new", &["runs_begin_as_flat_memory"]),
            ("VirtualMemory::invalidate", &["host_writes_and_invalidation_keep_the_card_the_hosts"]),
            (
                "VirtualMemory::flush",
                &["host_writes_and_invalidation_keep_the_card_the_hosts", "flush_forgets_all"],
            ),
            (
                "VirtualMemory::read_in_line",
                &["reads_return_the_hosts_bytes", "miss_moves_one_line_and_hit_none"],
            ),
            ("VirtualMemory::read", &["reads_across_lines_return_the_hosts_bytes"]),
        ],
    ),
    (
        "model/spec/src/vm/first_level.rs",
        &[
            ("FirstLevel::lines_of", &["l1_lines_of_a_read_are_those_that_it_meets"]),
            ("FirstLevel::bytes_of", &["l1_lines_have_all_their_bytes"]),
            ("FirstLevel::set_of", &["l1_lines_are_what_lies_behind"]),
            ("FirstLevel::is_resident", &["l1_without_bytes_decides_like_the_one_with_bytes"]),
            (
                "FirstLevel::access",
                &["l1_lines_are_what_lies_behind", "l1_without_bytes_decides_like_the_one_with_bytes"],
            ),
            (
                "FirstLevel::invalidate",
                &[
                    "first_level_cache_steps_as_flat_memory",
                    "l1_invalidation_forgets_exactly_the_range",
                    "l1_without_bytes_decides_like_the_one_with_bytes",
                ],
            ),
            ("FirstLevel::new", &["runs_begin_as_flat_memory"]),
            ("FirstLevel::read", &["first_level_cache_steps_as_flat_memory"]),
            (
                "FirstLevel::line",
                &["first_level_cache_steps_as_flat_memory", "l1_lines_are_what_lies_behind"],
            ),
            ("FirstLevelCaches::new", &["runs_begin_as_flat_memory"]),
            ("FirstLevelCaches::invalidate", &["chip_steps_as_flat_memory"]),
            (
                "FirstLevelCaches::read",
                &["chip_steps_as_flat_memory", "units_read_through_caches_of_their_own"],
            ),
        ],
    ),
];

/// The files of the twins, and of each the operations, in the order of the source.
pub const TWINS: &[(&str, &[Twin])] = &[
    (
        "model/fast/src/directory.rs",
        &[
            ("way_of", "Set::way_of", &["fast_set_step_is_the_sets", "fast_search_compares_every_bit"]),
            ("way_if_youngest", "Set::access", &["youngest_line_needs_no_step"]),
            ("access_set", "Set::access", &["fast_set_step_is_the_sets"]),
            (
                "access",
                "Directory::access",
                &[
                    "fast_directory_step_is_the_directorys",
                    "fast_directory_meets_any_metadata_alike",
                    "fast_version_b_steps_alike",
                ],
            ),
        ],
    ),
    (
        "model/fast/src/version_b.rs",
        &[
            (
                "MetadataDecisions::new",
                "CachedMetadata::observed",
                &["twin_of_version_b_begins_as_the_specification"],
            ),
            (
                "MetadataDecisions::granules_of",
                "CachedMetadata::granule_of",
                &["fast_version_b_finds_the_same_granules"],
            ),
            (
                "MetadataDecisions::load",
                "CachedMetadata::load",
                &["fast_version_b_moves_the_same_granules", "fast_version_b_steps_alike"],
            ),
            (
                "MetadataDecisions::store",
                "CachedMetadata::store",
                &["fast_version_b_moves_the_same_granules", "fast_version_b_steps_alike"],
            ),
            (
                "MetadataDecisions::clear",
                "CachedMetadata::clear",
                &["fast_version_b_moves_the_same_granules", "fast_version_b_steps_alike"],
            ),
        ],
    ),
    (
        "model/fast/src/first_level.rs",
        &[
            ("first_and_last_line", "FirstLevel::lines_of", &["fast_first_level_reads_the_same_lines"]),
            ("is_resident", "FirstLevel::is_resident", &["fast_first_level_step_is_the_caches"]),
            ("access", "FirstLevel::access", &["fast_first_level_step_is_the_caches"]),
        ],
    ),
];

/// The public operations of a source file, in its order, each once: `Type::name` of each method that is public
/// or a trait's, `name` of each public function. Tests are not looked at.
#[must_use]
pub fn operations(source: &str) -> Vec<String> {
    let mut found = Vec::new();
    // The type of the block, and whether all of its functions are a trait's, and so public.
    let mut block = (String::new(), false);
    let mut header: Option<String> = None;
    for line in source.lines().take_while(|line| *line != "#[cfg(test)]") {
        if line == "}" {
            block = (String::new(), false);
        }
        if line.starts_with("impl") {
            header = Some(String::new());
        }
        if let Some(text) = &mut header {
            text.push_str(line.trim());
            text.push(' ');
            if line.ends_with('{') || line.ends_with("{}") {
                block = block_of(text);
                header = None;
            }
            continue;
        }
        let of_block = line.strip_prefix("    ").filter(|line| !line.starts_with(' ') && !block.0.is_empty());
        let name = match of_block {
            Some(line) => function(line, block.1).map(|name| format!("{}::{name}", block.0)),
            None => function(line, false).map(str::to_owned),
        };
        found.extend(name.filter(|name| !found.contains(name)).into_iter().collect::<Vec<_>>());
    }
    found
}

/// The name of the function that a line begins, if it is public or if `all` are.
fn function(line: &str, all: bool) -> Option<&str> {
    let (public, rest) = line.strip_prefix("pub ").map_or((false, line), |rest| (true, rest));
    let rest = ["const ", "unsafe ", "async "]
        .iter()
        .fold(rest, |rest, word| rest.strip_prefix(word).unwrap_or(rest));
    let name = rest.strip_prefix("fn ")?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
    (public || all).then_some(&name[..end])
}

/// The type that a block is of, and whether it is a trait's.
fn block_of(header: &str) -> (String, bool) {
    let mut depth = 0_i32;
    // Without what stands in angle brackets; an arrow closes none.
    let plain: String = header
        .replace("->", "")
        .chars()
        .filter(|c| {
            depth += i32::from(*c == '<');
            let outside = depth == 0;
            depth -= i32::from(*c == '>');
            outside
        })
        .collect();
    let plain = plain.trim_start_matches("impl").trim();
    let (of_trait, rest) = plain.split_once(" for ").map_or((false, plain), |(_, rest)| (true, rest));
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    (rest[..end].to_owned(), of_trait)
}

/// What is missing: operations of the source without a row, rows without their operation or without a theorem,
/// and theorems that do not exist. `file` is for the messages.
#[must_use]
pub fn gaps(file: &str, source: &str, rows: &[(&str, &[&str])], theorems: &BTreeSet<&str>) -> Vec<String> {
    let there = operations(source);
    let mut gaps = Vec::new();
    for operation in &there {
        if !rows.iter().any(|(name, _)| name == operation) {
            gaps.push(format!("{file}: no theorem is given for the step of {operation}"));
        }
    }
    for (name, by) in rows {
        if !there.iter().any(|operation| operation == name) {
            gaps.push(format!("{file} has no public operation {name}"));
        }
        if by.is_empty() {
            gaps.push(format!("{file}: {name} has no theorem"));
        }
        for theorem in by.iter().filter(|theorem| !theorems.contains(*theorem)) {
            gaps.push(format!("{file}: {name} names {theorem}, which is no theorem"));
        }
    }
    gaps
}

/// The page: all operations, and what shows their steps.
#[must_use]
pub fn page() -> String {
    let mut page = "# From one step to any run: which theorem speaks of which operation\n\n\
         Every public operation of the virtual memory, as the source has them; the theorems that show that its step is that of an \
         abstract machine;\nits twins in `model/fast`, and the theorems that show that they do the same. Where no twin is named, the \
         operation of the specification runs\nitself. [ARGUMENT.md](ARGUMENT.md) says what follows from them. This page is generated \
         from `src/refinement/table.rs`, and a test fails where\nan operation has no theorem.\n"
        .to_owned();
    for (file, rows) in SPECIFICATION {
        let _ = write!(
            page,
            "\n## [`{file}`](../{file})\n\n| operation | its step | twin | the twin does the same |\n|---|---|---|---|\n"
        );
        for (name, by) in *rows {
            let twins: Vec<_> = twins_of(name).collect();
            let names: Vec<_> =
                twins.iter().map(|(file, twin, _)| format!("[`{twin}`](../{file})")).collect();
            let mut equal: Vec<_> = twins.iter().flat_map(|(_, _, by)| by.iter().copied()).collect();
            equal.dedup();
            let _ =
                writeln!(page, "| `{name}` | {} | {} | {} |", linked(by), names.join(" · "), linked(&equal));
        }
    }
    page
}

/// The twins of an operation: file, name, and the theorems.
fn twins_of(operation: &str) -> impl Iterator<Item = (&'static str, &'static str, &'static [&'static str])> {
    let all = TWINS.iter().flat_map(|(file, rows)| rows.iter().map(move |row| (*file, row)));
    all.filter(move |(_, (_, of, _))| *of == operation).map(|(file, (name, _, by))| (file, *name, *by))
}

/// The names of theorems, each with a link to its file.
fn linked(names: &[&str]) -> String {
    let link = |name: &&str| {
        let file = crate::theorems().find(|theorem| theorem.name == *name).map_or("", |theorem| theorem.file);
        format!("[`{name}`](../{file})")
    };
    names.iter().map(link).collect::<Vec<_>>().join(" · ")
}
