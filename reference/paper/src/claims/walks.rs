//! Claims of step one of §4 and of Figure 3 and Table 1: working sets, memories and sizes.

use super::{Cause, Claim, Evidence, Holds, Range, cause, mean, ranges, ratio, times};
use crate::alternatives::{EIGHTH_MEMORY, HALF_MEMORY};
use crate::figure3::{Graph, SizeRow};
use crate::table1::SceneRow;
use crate::table2::HotSpot;
use crate::tables::{MB, in_mb, mb};
use saarcor_model::time::Version;
use saarcor_studies::standard;
use saarcor_studies::walk::FrameRow;

/// Bytes of a shading record that has all fields.
const WHOLE_SHADING_RECORD: f64 = 92.0;

pub(super) fn claims(evidence: Evidence<'_>) -> Vec<Claim> {
    let Evidence { scenes, graphs, spots, .. } = evidence;
    let walked = !graphs.is_empty();
    let with_less = spots.iter().any(|spot| spot.with(EIGHTH_MEMORY, Version::A).is_some());
    let sizes = (!scenes.is_empty()).then(|| bytes_a_triangle(scenes));
    sizes
        .into_iter()
        .chain(walked.then(|| memories(graphs, spots)))
        .chain(walked.then(|| eight_mb(graphs, spots)))
        .chain(with_less.then(|| too_little(spots)))
        .chain(walked.then(|| worst_case(graphs)))
        .collect()
}

fn bytes_a_triangle(scenes: &[SceneRow]) -> Claim {
    let ours = |row: &SceneRow| row.geometry_bytes as f64 / row.triangles.max(1) as f64;
    let paper = |row: &SceneRow| (row.paper_geometry_mb * MB) as f64 / row.paper_triangles as f64;
    let whole = |row: &SceneRow| {
        let shading = row.regions.iter().find(|region| region.region == "shading")?;
        Some(ours(row) - shading.bytes_a_triangle + WHOLE_SHADING_RECORD)
    };
    let numbers =
        scenes.iter().map(|row| format!("{}: {:.0} (paper {:.0})", row.scene, ours(row), paper(row)));
    let range = |of: &dyn Fn(&SceneRow) -> f64| {
        let range = Range::of(scenes.iter().map(of));
        format!("{:.0} to {:.0} bytes a triangle", range.least, range.most)
    };
    Claim {
        id: "bytes-a-triangle",
        section: "§4, Table 1",
        claim: "The size of the geometry on hard disk.",
        paper: range(&paper),
        ours: format!("{} in host memory: what the chip reads", range(&ours)),
        verdict: Holds::NotComparable,
        cause: mean(scenes.iter().map(ours)).zip(mean(scenes.iter().filter_map(whole))).map(
            |(standard, with_setting)| Cause {
                setting: format!("shading records with all {WHOLE_SHADING_RECORD:.0} bytes"),
                figure: "bytes a triangle".to_owned(),
                standard,
                with_setting,
            },
        ),
        numbers: numbers.collect(),
        admitted: Vec::new(),
        open: "What the files hold: they are as large with as without textures and lights.",
    }
}

fn peak(graph: &Graph) -> u64 {
    graph.peak(|row| row.working_set_bytes).map_or(0, |row| row.working_set_bytes)
}

/// Bytes loaded in version A with a part of the memory, beside those with all of it.
fn loaded(spot: &HotSpot, setting: &str) -> Option<(f64, f64)> {
    Some((in_mb(spot.version_a.pci_bytes), in_mb(spot.with(setting, Version::A)?.pci_bytes)))
}

fn memories(graphs: &[Graph], spots: &[HotSpot]) -> Claim {
    let numbers = graphs
        .iter()
        .map(|graph| format!("{}: {} of {} MB", graph.name, mb(peak(graph)), mb(graph.memory_bytes)))
        .chain(graphs.iter().map(|graph| {
            let of_memory = |row: &SizeRow| {
                let standard =
                    (row.line_bytes, row.ways, row.hash) == (standard::LINE.0, standard::WAYS, true);
                standard.then(|| format!("{} MiB", row.memory_bytes / MB))
            };
            format!("walk of {}, MB loaded with {}", graph.name, graph.loaded(of_memory).join("; "))
        }));
    Claim {
        id: "working-set-fits",
        section: "§4, Figure 3",
        claim: "The memories of Table 2 hold the working set: no frame of the walks touches more lines than they hold.",
        paper: "8 MB pQuake3 and Sodahall, 32 MB Conference, 64 MB Cruiser".to_owned(),
        ours: format!("largest: {} MB", mb(graphs.iter().map(peak).max().unwrap_or(0))),
        verdict: Holds::of(graphs.iter().map(|graph| peak(graph) <= graph.memory_bytes)),
        cause: cause(HALF_MEMORY, "MB loaded a frame, version A", spots, |spot| loaded(spot, HALF_MEMORY)),
        numbers: numbers.collect(),
        admitted: Vec::new(),
        open: "",
    }
}

fn eight_mb(graphs: &[Graph], spots: &[HotSpot]) -> Claim {
    let fits = |graph: &Graph| peak(graph) <= 8 * MB;
    let count = graphs.iter().filter(|graph| fits(graph)).count();
    Claim {
        id: "eight-mb-for-many",
        section: "§4",
        claim: "8 MB are sufficient for many scenes, 64 MB for extremely large ones: most walks fit 8 MB, and all 64 MB.",
        paper: "2 of 4 scenes with 8 MB".to_owned(),
        ours: format!("{count} of {} walks fit 8 MB", graphs.len()),
        verdict: Holds::of([2 * count >= graphs.len(), graphs.iter().all(|graph| peak(graph) <= 64 * MB)]),
        cause: cause(EIGHTH_MEMORY, "MB loaded a frame, version A", spots, |spot| {
            loaded(spot, EIGHTH_MEMORY)
        }),
        numbers: graphs.iter().map(|graph| format!("{}: {} MB", graph.name, mb(peak(graph)))).collect(),
        admitted: Vec::new(),
        open: "",
    }
}

fn too_little(spots: &[HotSpot]) -> Claim {
    // An eighth that holds all that the frame uses loads no more, and shows nothing.
    let judged = |spot: &HotSpot| loaded(spot, EIGHTH_MEMORY).filter(|(all, part)| all != part);
    let more = |spot: &HotSpot| judged(spot).and_then(|(all, part)| ratio(part, all));
    let slower = |spot: &HotSpot| Some(spot.with(EIGHTH_MEMORY, Version::A)?.fps / spot.version_a.fps);
    Claim {
        id: "too-little-memory",
        section: "§4",
        claim: "Where the working set does not fit, lines are loaded again, which costs time: with an eighth of the memory a frame \
                loads more. Frames that load the same are not judged: an eighth holds what they use.",
        paper: "no figure: penalties are unavoidable".to_owned(),
        ours: times(&ranges(spots, more), "the bytes"),
        verdict: Holds::of(spots.iter().filter_map(judged).map(|(all, part)| part > all)),
        cause: cause(EIGHTH_MEMORY, "frames a second of version A", spots, |spot| {
            Some((spot.version_a.fps, spot.with(EIGHTH_MEMORY, Version::A)?.fps))
        }),
        numbers: ranges(spots, slower).into_iter().map(|range| format!("speed: {range}")).collect(),
        admitted: Vec::new(),
        open: "",
    }
}

fn worst_case(graphs: &[Graph]) -> Claim {
    let median = |graph: &Graph, value: fn(&FrameRow) -> u64| {
        let mut values: Vec<u64> = graph.frames.iter().map(value).collect();
        values.sort_unstable();
        values.get(values.len() / 2).copied().unwrap_or(0) as f64
    };
    let hot = |graph: &Graph, value: fn(&FrameRow) -> u64| {
        let is_hot = |row: &&FrameRow| graph.hot_spots.iter().any(|spot| spot.frame as u64 == row.frame);
        let values: Vec<f64> = graph.frames.iter().filter(is_hot).map(|row| value(row) as f64).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let working_set: fn(&FrameRow) -> u64 = |row| row.working_set_bytes;
    // Where all frames are hot spots, or none touches anything, there is nothing to compare.
    let compared =
        graphs.iter().filter(|graph| graph.hot_spots.len() < graph.frames.len() && peak(graph) > 0);
    let all: Vec<(&str, (f64, f64))> = compared
        .map(|graph| (graph.name.as_str(), (hot(graph, working_set), median(graph, working_set))))
        .collect();
    let part = |(hot, median): (f64, f64)| median / hot;
    Claim {
        id: "hot-spots-are-worst",
        section: "§4",
        claim: "Results at hot spots are worst cases: the median frame of a walk touches less.",
        paper: "no figure: much better elsewhere".to_owned(),
        ours: format!("median / hot spots: {}", Range::of(all.iter().map(|(_, both)| part(*both)))),
        verdict: Holds::of(all.iter().map(|(_, both)| part(*both) < 1.0)),
        cause: mean(all.iter().map(|(_, both)| both.0)).zip(mean(all.iter().map(|(_, both)| both.1))).map(
            |(standard, with_setting)| Cause {
                setting: "the median frame in place of the hot spots".to_owned(),
                figure: "MB of the working set".to_owned(),
                standard: standard / MB as f64,
                with_setting: with_setting / MB as f64,
            },
        ),
        numbers: all.iter().map(|(name, both)| format!("{name}: {:.2}", part(*both))).collect(),
        admitted: Vec::new(),
        open: "",
    }
}
