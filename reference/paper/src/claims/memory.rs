//! Claims of §2 and §3: metadata, lines, ways and hash, and the caches of the chip.

use super::{Cause, Claim, Evidence, Holds, NOTHING, cause, mean, ranges, ratio, times};
use crate::alternatives::{
    EIGHT_THREADS, LINES, NO_FIRST_LEVEL, ONE_THREAD, SMALL_METADATA_CACHE, lines, ways,
};
use crate::figure3::{Graph, SizeRow};
use crate::table2::{Alternative, HotSpot};
use crate::tables::{in_mb, mb, stated};
use saarcor_model::time::Version;
use saarcor_model::vm::Hash;
use saarcor_studies::simulate::TimingRow;
use saarcor_studies::standard;

/// A line may cost version A so much, on the geometric mean, against the best of each frame.
const WORTH: f64 = 1.02;

pub(super) fn claims(evidence: Evidence<'_>) -> Vec<Claim> {
    let (spots, graphs) = (evidence.spots, evidence.graphs);
    let law = (!evidence.examples.is_empty()).then(|| metadata(evidence));
    let of_lines = spots.iter().any(|spot| spot.with(&lines(1024), Version::A).is_some());
    let of_first = spots.iter().any(|spot| spot.with(ONE_THREAD, Version::A).is_some());
    law.into_iter()
        .chain(of_lines.then(|| best_line(spots, graphs)))
        .chain(of_lines.then(|| longer_lines(spots)))
        .chain(of_lines.then(|| ways_and_hash(spots, graphs)))
        .chain(of_first.then(|| threads_hide(spots)))
        .chain(of_first.then(|| few_threads(spots)))
        .chain(of_first.then(|| metadata_cache(spots)))
        .chain(of_first.then(|| two_levels(spots)))
        .collect()
}

fn metadata(evidence: Evidence<'_>) -> Claim {
    let printed = &stated().metadata.examples;
    let same = printed.iter().zip(evidence.examples).map(|(e, ours)| e.metadata_bytes == ours.metadata_bytes);
    let kb = |bytes: u64, line: u64| format!("{} KB at {line} B", bytes >> 10);
    let ours: Vec<_> = evidence.examples.iter().map(|e| kb(e.metadata_bytes, e.line_bytes)).collect();
    let paper: Vec<_> = printed.iter().map(|e| kb(e.metadata_bytes, e.line_bytes)).collect();
    let example = evidence.examples.first();
    Claim {
        id: "metadata-law",
        section: "§3",
        claim: "Metadata take 5 bytes a line: 16 MB need 640 KB in lines of 128 B, and 80 KB in lines of 1 KB.",
        paper: paper.join(", "),
        ours: ours.join(", "),
        verdict: Holds::of(same),
        cause: example.map(|e| Cause {
            setting: "4 bytes a line, the address without management bits".to_owned(),
            figure: "KB of metadata of 16 MB in lines of 128 B".to_owned(),
            standard: e.metadata_bytes as f64 / 1024.0,
            with_setting: (e.lines * 4) as f64 / 1024.0,
        }),
        numbers: Vec::new(),
        admitted: Vec::new(),
        open: "",
    }
}

/// What whole walks load with the standard size of on-board memory and what else `name` has a name for.
fn of_walks(graphs: &[Graph], name: &dyn Fn(&SizeRow) -> Option<String>) -> impl Iterator<Item = String> {
    graphs.iter().map(move |graph| {
        let loaded =
            graph.loaded(|row| if row.memory_bytes == graph.memory_bytes { name(row) } else { None });
        format!("walk of {}, MB loaded: {}", graph.name, loaded.join("; "))
    })
}

/// Frames whose lines were varied, with the run of each size of line in a version.
fn with_lines(spots: &[HotSpot], version: Version) -> Vec<(String, Vec<(u64, &TimingRow)>)> {
    let of_spot = |spot| -> Vec<(u64, &TimingRow)> {
        let with = |line| Some((line, HotSpot::with(spot, &lines(line), version)?));
        LINES.into_iter().filter_map(with).collect()
    };
    spots.iter().map(|spot| (spot.name(), of_spot(spot))).filter(|(_, runs)| !runs.is_empty()).collect()
}

/// How much longer frames take with lines of each size than with the best of each frame: geometric means.
fn slowdowns(spots: &[HotSpot], version: Version) -> Vec<(u64, f64)> {
    let frames = with_lines(spots, version);
    let slowdown = |line: u64| {
        let of = frames.iter().filter_map(|(_, runs)| {
            let best = runs.iter().map(|(_, run)| run.cycles).min()?;
            let (_, run) = runs.iter().find(|(size, _)| *size == line)?;
            Some(run.cycles as f64 / best.max(1) as f64)
        });
        mean(of)
    };
    LINES.into_iter().filter_map(|line| Some((line, slowdown(line)?))).collect()
}

/// The longest line that is worth what it costs.
fn longest(slowdowns: &[(u64, f64)]) -> u64 {
    slowdowns.iter().filter(|(_, slowdown)| *slowdown <= WORTH).map(|(line, _)| *line).max().unwrap_or(0)
}

/// What lines of a size cost against the best of each frame, in percent.
fn cost(slowdowns: &[(u64, f64)], line: u64) -> Option<f64> {
    slowdowns.iter().find(|(size, _)| *size == line).map(|(_, slowdown)| (slowdown - 1.0) * 100.0)
}

fn best_line(spots: &[HotSpot], graphs: &[Graph]) -> Claim {
    let (a, b) = (slowdowns(spots, Version::A), slowdowns(spots, Version::B));
    let both: Vec<(u64, f64)> = a.iter().zip(&b).map(|((line, a), (_, b))| (*line, (a * b).sqrt())).collect();
    let least = |slowdowns: &[(u64, f64)]| {
        slowdowns.iter().min_by(|x, y| x.1.total_cmp(&y.1)).map_or(0, |(line, _)| *line)
    };
    let list = |name: &str, slowdowns: &[(u64, f64)]| {
        let each: Vec<_> =
            slowdowns.iter().map(|(line, slow)| format!("{line}: {:.1} %", (slow - 1.0) * 100.0)).collect();
        format!("slower than each frame's best line, {name}: {}", each.join(", "))
    };
    let standard = standard::LINE.0;
    Claim {
        id: "best-line",
        section: "§3",
        claim: "Lines of 128 B are best: they are the longest, with the least metadata, that cost version A less than 2 % on the \
                geometric mean.",
        paper: format!("{standard} B"),
        ours: format!("{} B; fastest on the mean of A and B: {} B", longest(&a), least(&both)),
        verdict: Holds::of([longest(&a) == standard]),
        cause: cost(&a, standard).zip(cost(&b, standard)).map(|(standard, with_setting)| Cause {
            setting: "version B in place of A".to_owned(),
            figure: "percent that 128 B cost against each frame's best line".to_owned(),
            standard,
            with_setting,
        }),
        numbers: [list("version A", &a), list("version B", &b), list("both alike", &both)]
            .into_iter()
            .chain(of_walks(graphs, &|row| {
                (row.hash && row.ways == standard::WAYS).then(|| format!("{} B", row.line_bytes))
            }))
            .collect(),
        admitted: Vec::new(),
        open: "The paper does not say by which cost 128 B are best. This shows that they can be, not that this was meant.",
    }
}

fn longer_lines(spots: &[HotSpot]) -> Claim {
    let frames = with_lines(spots, Version::A);
    let of = |runs: &[(u64, &TimingRow)], line: u64| {
        runs.iter().find(|(size, _)| *size == line).map(|(_, run)| run.cycles as f64)
    };
    let slower: Vec<(String, f64)> = frames
        .iter()
        .filter_map(|(name, runs)| Some((name.clone(), of(runs, 1024)? / of(runs, standard::LINE.0)?)))
        .collect();
    let loaded = |spot: &HotSpot, line| Some(in_mb(spot.with(&lines(line), Version::A)?.pci_bytes));
    let both = |spot: &HotSpot| Some((loaded(spot, standard::LINE.0)?, loaded(spot, 1024)?));
    Claim {
        id: "longer-lines",
        section: "§3",
        claim: "Longer lines are likely to collide more and make a miss dearer: 1 KB are slower than 128 B.",
        paper: "no figure".to_owned(),
        ours: super::Range::of(slower.iter().map(|(_, slower)| *slower)).to_string(),
        verdict: Holds::of(slower.iter().map(|(_, slower)| *slower > 1.0)),
        cause: cause(&lines(1024), "MB loaded a frame, version A", spots, both),
        numbers: slower
            .iter()
            .map(|(name, slower)| format!("{name}: {slower:.3} times the cycles"))
            .collect(),
        admitted: Vec::new(),
        open: "",
    }
}

fn ways_and_hash(spots: &[HotSpot], graphs: &[Graph]) -> Claim {
    let is_set = |one: &&Alternative| one.run.variant == "a" && one.setting.ends_with("hash");
    let frames = || {
        spots.iter().filter_map(|spot| {
            let standard = spot.with(&lines(standard::LINE.0), Version::A)?;
            let others: Vec<_> = spot.alternatives.iter().filter(is_set).collect();
            Some((spot, standard, others))
        })
    };
    // Where all load the same, none works better.
    let least = |(_, standard, others): (_, &TimingRow, Vec<&Alternative>)| {
        let differ = others.iter().any(|other| standard.pci_bytes != other.run.pci_bytes);
        differ.then(|| others.iter().all(|other| standard.pci_bytes <= other.run.pci_bytes))
    };
    let numbers = frames().map(|(spot, standard, others)| {
        let each: Vec<_> =
            others.iter().map(|one| format!("{}: {}", one.setting, mb(one.run.pci_bytes))).collect();
        format!("{}, MB loaded: 4 ways, hash: {}; {}", spot.name(), mb(standard.pci_bytes), each.join("; "))
    });
    let plain = ways(1, Hash::Low);
    let bytes = |spot: &HotSpot, setting: &str| Some(in_mb(spot.with(setting, Version::A)?.pci_bytes));
    let both = |spot: &HotSpot| Some((bytes(spot, &lines(standard::LINE.0))?, bytes(spot, &plain)?));
    let cause = cause(&plain, "MB loaded a frame, version A", spots, both);
    Claim {
        id: "ways-and-hash",
        section: "§3",
        claim: "4 ways and the hash work extremely well: they load the least, against 1, 2 and 4 ways with and without the hash. \
                Frames that load the same with all of them are not judged.",
        paper: "no figure".to_owned(),
        ours: cause.as_ref().and_then(|cause| ratio(cause.with_setting, cause.standard)).map_or_else(
            || NOTHING.to_owned(),
            |more| format!("{more:.2} times as many bytes with one way and no hash"),
        ),
        verdict: Holds::of(frames().filter_map(least)),
        cause,
        numbers: numbers
            .chain(of_walks(graphs, &|row| {
                let compared = row.line_bytes == standard::LINE.0 && row.ways <= standard::WAYS;
                compared.then(|| ways(row.ways, row.config.hash))
            }))
            .collect(),
        admitted: Vec::new(),
        open: "How often the upper bits are added, and how many sets there are, the paper does not say.",
    }
}

/// Frames a second without virtual memory and in version A, with and without a setting.
fn fps(spot: &HotSpot, setting: &str) -> Option<(f64, f64)> {
    Some((spot.version_a.fps, spot.with(setting, Version::A)?.fps))
}

fn threads_hide(spots: &[HotSpot]) -> Claim {
    let speedup = |spot: &HotSpot| fps(spot, ONE_THREAD).map(|(all, one)| all / one);
    Claim {
        id: "threads-hide-latency",
        section: "§2, §4",
        claim: "Several threads hide the latencies of SDRAM and of the bus: 16 threads a pipeline are more than twice as fast as one.",
        paper: "16 threads; works very well".to_owned(),
        ours: ranges(spots, speedup).join("; "),
        verdict: Holds::of(spots.iter().filter_map(speedup).map(|speedup| speedup > 2.0)),
        cause: cause(ONE_THREAD, "frames a second of version A", spots, |spot| fps(spot, ONE_THREAD)),
        numbers: ranges(spots, |spot| {
            Some(spot.with(ONE_THREAD, Version::A)?.fps / spot.with(ONE_THREAD, Version::None)?.fps)
        })
        .into_iter()
        .map(|range| format!("A / no VM with one thread: {range}"))
        .collect(),
        admitted: Vec::new(),
        open: "",
    }
}

fn few_threads(spots: &[HotSpot]) -> Claim {
    let part = |spot: &HotSpot| fps(spot, EIGHT_THREADS).map(|(all, eight)| eight / all);
    Claim {
        id: "few-threads-suffice",
        section: "§2",
        claim: "Even a small number of threads suffices: 8 a pipeline cost less than 5 % of the speed of 16.",
        paper: "no figure; 16 are used".to_owned(),
        ours: ranges(spots, part).join("; "),
        verdict: Holds::of(spots.iter().filter_map(part).map(|part| part > 0.95)),
        cause: cause(EIGHT_THREADS, "frames a second of version A", spots, |spot| fps(spot, EIGHT_THREADS)),
        numbers: Vec::new(),
        admitted: Vec::new(),
        open: "How many are a small number.",
    }
}

fn metadata_cache(spots: &[HotSpot]) -> Claim {
    let bytes = |spot: &HotSpot| {
        let small = spot.with(SMALL_METADATA_CACHE, Version::B)?;
        Some((in_mb(spot.version_b.mem_bytes_metadata), in_mb(small.mem_bytes_metadata)))
    };
    let more = |spot: &HotSpot| bytes(spot).and_then(|(standard, small)| ratio(small, standard));
    Claim {
        id: "metadata-cache",
        section: "§3",
        claim: "The small metadata cache saves latency and bandwidth: one of a single set moves more than twice the metadata.",
        paper: "no figure; a few KB, §4 takes 64 KB".to_owned(),
        ours: times(&ranges(spots, more), "the bytes"),
        verdict: Holds::of(spots.iter().filter_map(more).map(|more| more > 2.0)),
        cause: cause(SMALL_METADATA_CACHE, "MB of metadata a frame", spots, bytes),
        numbers: ranges(spots, |spot| {
            Some(spot.with(SMALL_METADATA_CACHE, Version::B)?.fps / spot.version_b.fps)
        })
        .into_iter()
        .map(|range| format!("speed with it: {range}"))
        .collect(),
        admitted: Vec::new(),
        open: "",
    }
}

fn two_levels(spots: &[HotSpot]) -> Claim {
    let bytes = |spot: &HotSpot| {
        Some((in_mb(spot.version_a.mem_bytes), in_mb(spot.with(NO_FIRST_LEVEL, Version::A)?.mem_bytes)))
    };
    let more = |spot: &HotSpot| bytes(spot).and_then(|(both, one)| ratio(one, both));
    Claim {
        id: "two-levels",
        section: "§4",
        claim: "Two levels of caches save external bandwidth: without the first, more than twice as many bytes move to and from the \
                on-board memory.",
        paper: "no figure".to_owned(),
        ours: times(&ranges(spots, more), "the bytes"),
        verdict: Holds::of(spots.iter().filter_map(more).map(|more| more > 2.0)),
        cause: cause(NO_FIRST_LEVEL, "MB to and from the on-board memory a frame", spots, bytes),
        numbers: Vec::new(),
        admitted: Vec::new(),
        open: "",
    }
}
