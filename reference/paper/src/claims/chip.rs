//! Claims of step two of §4 and of Table 2: speed and traffic on the chip.

use super::{Cause, Claim, Evidence, Holds, Range, cause, families, mean, ranges};
use crate::alternatives::{
    BANKS_8, COLD_FIRST_LEVEL, EMPTY, EMPTY_AND_FAST_BUS, FAST_BUS, FAST_MEMORY, GRANULE_16, LRU,
    SHALLOW_TREE, SMALL_TRIANGLE_CACHE, TEN_FRAMES,
};
use crate::table2::{HotSpot, Shape};
use crate::tables::{LEAST_MEM_MB, LEAST_PCI_MB, MB, Table2Row, in_mb, table2};
use saarcor_model::time::Version;
use saarcor_studies::simulate::TimingRow;
use std::collections::BTreeMap;

/// The unit that reads triangles.
const TRIANGLES: &str = "intersection";

pub(super) fn claims(evidence: Evidence<'_>) -> Vec<Claim> {
    let Evidence { spots, cuts, .. } = evidence;
    if spots.is_empty() {
        return Vec::new();
    }
    let cruiser = spots.iter().any(|spot| spot.family() == "Cruiser");
    let others = [fast_bus(spots, cuts), local_memory(spots)].into_iter();
    of_rows(spots).into_iter().chain(others).chain(cruiser.then(|| triangle_cache(spots))).collect()
}

/// Claims that are judged by nothing but the rows of Table 2: any chip can be put in the place of the standard one.
pub(super) fn of_rows(spots: &[HotSpot]) -> Vec<Claim> {
    let of_paper = spots.iter().any(|spot| spot.paper.is_some());
    let has = |family: &str| spots.iter().any(|spot| spot.family() == family);
    [a_hardly_slower(spots), b_little_slower(spots)]
        .into_iter()
        .chain(loaded_once(spots))
        .chain([mem_b_over_a(spots)])
        .chain(of_paper.then(|| frames_a_second(spots)))
        .chain(of_paper.then(|| loaded(spots)))
        .chain(of_paper.then(|| moved(spots)))
        .chain(has("Conference").then(|| linear(spots)))
        .chain(has("Cruiser").then(|| triangle_hits(spots)))
        .collect()
}

/// The paper's rows of the family of a hot spot; all, for a scene of the user's.
fn paper_rows(spot: &HotSpot) -> Vec<&'static Table2Row> {
    let family = saarcor_studies::standard::family;
    let of = |row: &&Table2Row| spot.paper.is_none() || family(&row.scene) == spot.family();
    table2().iter().filter(of).collect()
}

/// What is left open where a scene has no frame that follows another.
const NONE_FOLLOWS: &str = "No frame of the path follows another, so that nothing is known of warm caches.";

/// The hot spots before which there is a frame that warms the caches: only the first of a path has none.
fn following(spots: &[HotSpot]) -> Vec<HotSpot> {
    spots.iter().filter(|spot| spot.frame > 0).cloned().collect()
}

/// Whether a relation within the rows is as good as in the paper's own rows, family by family.
struct Relation {
    paper: String,
    ours: String,
    verdict: Holds,
    numbers: Vec<String>,
}

/// A relation, of which `is_good` says whether it is as good as the worse end of the paper's range.
fn relation(spots: &[HotSpot], of: impl Fn(&Shape) -> f64, is_good: impl Fn(f64, Range) -> bool) -> Relation {
    let (mut places, mut numbers) = (Vec::new(), Vec::new());
    for (name, spots) in families(spots) {
        let paper = Range::of(paper_rows(spots[0]).into_iter().map(|row| of(&Shape::printed(row))));
        let ours = || spots.iter().map(|spot| of(&Shape::ours(spot)));
        places.extend(ours().map(|value| is_good(value, paper.widened())));
        numbers.push(format!("{name} {} (paper {paper})", Range::of(ours())));
    }
    Relation {
        paper: Range::of(table2().iter().map(|row| of(&Shape::printed(row)))).to_string(),
        ours: Range::of(spots.iter().map(|spot| of(&Shape::ours(spot)))).to_string(),
        verdict: Holds::of(places),
        numbers,
    }
}

fn a_hardly_slower(spots: &[HotSpot]) -> Claim {
    let spots = &following(spots)[..];
    let Relation { paper, ours, verdict, numbers } =
        relation(spots, |shape| shape.speed_a, |ours, paper| ours >= paper.least);
    let both = |spot: &HotSpot| {
        let with = spot.with(EMPTY, Version::A)?.fps / spot.no_vm.fps;
        Some((spot.version_a.fps / spot.no_vm.fps, with))
    };
    Claim {
        id: "a-hardly-slower",
        section: "§4, Table 2",
        claim: "Version A is hardly slower than no virtual memory: A / no VM is not less than in the slowest of the paper's rows, or by \
                a quarter of what that one loses at most.",
        paper,
        ours,
        verdict,
        cause: cause(EMPTY, "A / no VM", spots, both),
        numbers,
        admitted: Vec::new(),
        open: if spots.is_empty() { NONE_FOLLOWS } else { "" },
    }
}

fn b_little_slower(spots: &[HotSpot]) -> Claim {
    let spots = &following(spots)[..];
    let Relation { paper, ours, verdict, mut numbers } =
        relation(spots, |shape| shape.speed_b, |ours, paper| ours >= paper.least);
    let ours_b = |spot: &HotSpot| spot.version_b.fps / spot.no_vm.fps;
    let with = |setting: &'static str| {
        cause(setting, "B / no VM", spots, |spot| {
            let none = spot.with(setting, Version::None).unwrap_or(&spot.no_vm);
            Some((ours_b(spot), spot.with(setting, Version::B)?.fps / none.fps))
        })
    };
    let printed = mean(spots.iter().filter_map(|spot| Some(Shape::printed(spot.paper.as_ref()?).speed_b)));
    numbers.extend(printed.map(|printed| format!("geometric mean of the paper's rows: {printed:.3}")));
    let causes: Vec<Cause> = [LRU, GRANULE_16, BANKS_8].into_iter().filter_map(with).collect();
    numbers.extend(causes.iter().map(ToString::to_string));
    let most = |cause: &Cause| libm::log(cause.with_setting / cause.standard).abs();
    Claim {
        id: "b-little-slower",
        section: "§4, Table 2",
        claim: "Even version B hardly costs speed: B / no VM is not less than in the slowest of the paper's rows, or by a quarter of \
                what that one loses at most.",
        paper,
        ours,
        verdict,
        cause: causes.into_iter().max_by(|a, b| most(a).total_cmp(&most(b))),
        numbers,
        admitted: Vec::new(),
        open: if spots.is_empty() {
            NONE_FOLLOWS
        } else {
            "What the metadata cache reads at a time, and whether a hit writes metadata."
        },
    }
}

/// Rows that load less than this are too small to show where the bytes go.
const WORTH_COUNTING_MB: f64 = 0.05;

/// None where no row loads enough.
fn loaded_once(spots: &[HotSpot]) -> Option<Claim> {
    let counts = |spot: &&HotSpot| spot.version_a.pci_bytes as f64 > WORTH_COUNTING_MB * MB as f64;
    let filled = |spot: &HotSpot| Shape::ours(spot).filled;
    let both = |spot: &HotSpot| {
        let cold = |version| spot.with(COLD_FIRST_LEVEL, version);
        let (none, a) = (cold(Version::None)?, cold(Version::A)?);
        Some((filled(spot), (a.mem_bytes as f64 - none.mem_bytes as f64) / a.pci_bytes.max(1) as f64))
    };
    let paper = Range::of(
        table2().iter().filter(|row| row.version_a.pci_mb >= 0.5).map(|row| Shape::printed(row).filled),
    );
    let ours = || spots.iter().filter(counts);
    ours().next()?;
    Some(Claim {
        id: "loaded-once",
        section: "Table 2",
        claim: "What is loaded reaches the on-board memory once: (Mem A - Mem no VM) / PCI is 1, within 10 %.",
        paper: format!("{paper} in rows that load 0.5 MB or more"),
        ours: Range::of(ours().map(filled)).to_string(),
        verdict: Holds::of(ours().map(|spot| (filled(spot) - 1.0).abs() <= 0.1)),
        cause: cause(COLD_FIRST_LEVEL, "(Mem A - Mem no VM) / PCI", ours(), both),
        numbers: ranges(ours(), |spot| Some(filled(spot))),
        admitted: Vec::new(),
        open: "Packets meet in another order with virtual memory, so first-level caches load more or less. The paper prints one \
               decimal of Mem.",
    })
}

fn mem_b_over_a(spots: &[HotSpot]) -> Claim {
    let Relation { paper, ours, verdict, numbers } =
        relation(spots, |shape| shape.memory_b, |ours, paper| ours <= paper.most);
    let both = |spot: &HotSpot| {
        let a = spot.version_a.mem_bytes.max(1) as f64;
        Some((spot.version_b.mem_bytes as f64 / a, spot.with(GRANULE_16, Version::B)?.mem_bytes as f64 / a))
    };
    Claim {
        id: "mem-b-over-a",
        section: "Table 2",
        claim: "Version B moves a third more than A at most: Mem B / Mem A is not more than the most of the paper's rows, or by a \
                quarter of what that one moves more at most.",
        paper,
        ours,
        verdict,
        cause: cause(GRANULE_16, "Mem B / Mem A", spots, both),
        numbers,
        admitted: Vec::new(),
        open: "What the metadata cache reads at a time.",
    }
}

fn fast_bus(spots: &[HotSpot], cuts: &[HotSpot]) -> Claim {
    let spots = &following(spots)[..];
    let gain = |spot: &HotSpot| Some(spot.with(FAST_BUS, Version::A)?.fps / spot.version_a.fps);
    let both = |spot: &HotSpot| {
        let empty = spot.with(EMPTY_AND_FAST_BUS, Version::A)?.fps / spot.with(EMPTY, Version::A)?.fps;
        Some((gain(spot)?, empty))
    };
    let mut numbers = ranges(spots, gain);
    numbers.extend(ranges(cuts, gain).into_iter().map(|range| format!("after a cut of the camera: {range}")));
    Claim {
        id: "fast-bus",
        section: "§4",
        claim: "A bus four times as fast gives essentially the same performance: it gains less than 2 % in frames that follow one \
                another.",
        paper: "essentially the same".to_owned(),
        ours: Range::of(spots.iter().filter_map(gain)).to_string(),
        verdict: Holds::of(spots.iter().filter_map(gain).map(|gain| gain < 1.02)),
        cause: cause(EMPTY, "gain of the faster bus", spots, both),
        numbers,
        admitted: Vec::new(),
        open: if spots.is_empty() { NONE_FOLLOWS } else { "" },
    }
}

/// Ours / the paper's, family by family: whether it is within a factor of two on the geometric mean.
fn factor(spots: &[HotSpot], of: impl Fn(&HotSpot, &Table2Row) -> f64) -> (String, Holds, Vec<String>) {
    let each = |spot: &HotSpot| Some(of(spot, spot.paper.as_ref()?));
    let means: Vec<(String, f64)> = families(spots)
        .into_iter()
        .filter_map(|(name, spots)| Some((name, mean(spots.into_iter().filter_map(each))?)))
        .collect();
    let all = mean(spots.iter().filter_map(each)).unwrap_or(f64::NAN);
    let numbers = means.iter().map(|(name, mean)| format!("{name} {mean:.2}")).collect();
    let within = means.iter().map(|(_, mean)| (0.5..=2.0).contains(mean));
    (format!("{all:.2} times the paper's, on the geometric mean"), Holds::of(within), numbers)
}

fn frames_a_second(spots: &[HotSpot]) -> Claim {
    let (ours, verdict, numbers) = factor(spots, |spot, paper| spot.no_vm.fps / paper.no_vm.fps);
    let paper = Range::of(table2().iter().map(|row| row.no_vm.fps));
    Claim {
        id: "frames-a-second",
        section: "Table 2",
        claim: "Frames a second without virtual memory: within a factor of two of the paper's, family by family.",
        paper: format!("{:.1} to {:.1}", paper.least, paper.most),
        ours,
        verdict,
        cause: cause(FAST_MEMORY, "frames a second without virtual memory", spots, |spot| {
            Some((spot.no_vm.fps, spot.with(FAST_MEMORY, Version::None)?.fps))
        }),
        numbers,
        admitted: Vec::new(),
        open: "The scenes, the size of the picture and the kd-tree are not the paper's.",
    }
}

fn loaded(spots: &[HotSpot]) -> Claim {
    let loaded = |run: &TimingRow| in_mb(run.pci_bytes).max(LEAST_PCI_MB);
    let (ours, verdict, numbers) =
        factor(spots, |spot, paper| loaded(&spot.version_a) / paper.version_a.pci_mb);
    let paper = Range::of(table2().iter().map(|row| row.version_a.pci_mb));
    let sodahall = spots.iter().filter(|spot| spot.family() == "Sodahall");
    let with = |setting: &'static str| {
        move |spot: &HotSpot| Some((loaded(&spot.version_a), loaded(spot.with(setting, Version::A)?)))
    };
    Claim {
        id: "loaded-a-frame",
        section: "Table 2",
        claim: "MB that version A loads a frame: within a factor of two of the paper's, family by family.",
        paper: paper.to_string(),
        ours,
        verdict,
        cause: cause(TEN_FRAMES, "MB loaded a frame of Sodahall, version A", sodahall, with(TEN_FRAMES))
            .or_else(|| cause(EMPTY, "MB loaded a frame, version A", spots, with(EMPTY))),
        numbers,
        admitted: Vec::new(),
        open: "The path of the camera and how many frames were simulated before a hot spot.",
    }
}

fn moved(spots: &[HotSpot]) -> Claim {
    let moved = |run: &TimingRow| in_mb(run.mem_bytes).max(LEAST_MEM_MB);
    let (ours, verdict, numbers) = factor(spots, |spot, paper| moved(&spot.no_vm) / paper.no_vm.mem_mb);
    let paper = Range::of(table2().iter().map(|row| row.no_vm.mem_mb));
    Claim {
        id: "moved-a-frame",
        section: "Table 2",
        claim: "MB to and from the on-board memory a frame, without virtual memory: within a factor of two of the paper's, family by \
                family.",
        paper: paper.to_string(),
        ours,
        verdict,
        cause: cause(COLD_FIRST_LEVEL, "MB a frame without virtual memory / the paper's", spots, |spot| {
            let paper = spot.paper.as_ref()?.no_vm.mem_mb;
            Some((moved(&spot.no_vm) / paper, moved(spot.with(COLD_FIRST_LEVEL, Version::None)?) / paper))
        }),
        numbers,
        admitted: Vec::new(),
        open: "What the first-level caches hold when a hot spot begins; the kd-tree.",
    }
}

fn linear(spots: &[HotSpot]) -> Claim {
    let mut frames: BTreeMap<(bool, &str), Vec<&HotSpot>> = BTreeMap::new();
    for spot in spots.iter().filter(|spot| spot.family() == "Conference") {
        let frame = spot.paper.as_ref().map_or("", |paper| paper.frame.as_str());
        frames.entry((spot.real, frame)).or_default().push(spot);
    }
    let spread = |cycles: &[f64]| {
        let range = Range::of(cycles.iter().copied());
        range.most / range.least
    };
    let cycles =
        |spots: &[&HotSpot]| -> Vec<f64> { spots.iter().map(|spot| spot.no_vm.cycles_a_ray).collect() };
    let fast = |spots: &[&HotSpot]| -> Vec<f64> {
        let run = |spot: &&HotSpot| Some(spot.with(FAST_MEMORY, Version::None)?.cycles_a_ray);
        spots.iter().filter_map(run).collect()
    };
    let numbers = frames.iter().map(|((real, frame), spots)| {
        let cycles: Vec<_> = cycles(spots).iter().map(|cycles| format!("{cycles:.1}")).collect();
        let scene = if *real { "real " } else { "" };
        format!("{scene}{frame}: {}", cycles.join(", "))
    });
    let standard = mean(frames.values().map(|spots| spread(&cycles(spots))));
    Claim {
        id: "linear-in-rays",
        section: "§4",
        claim: "Speed is linear in rays of any kind: cycles a ray of Conference with 0, 2 and 8 lights within 15 %.",
        paper: "26.4 to 28.6 core cycles a ray and pipeline at frame a, if the picture has 1024 x 768 pixels"
            .to_owned(),
        ours: standard.map_or_else(String::new, |most| format!("most / least {most:.2}")),
        verdict: Holds::of(frames.values().map(|spots| spread(&cycles(spots)) < 1.15)),
        cause: standard.zip(mean(frames.values().map(|spots| spread(&fast(spots))))).map(
            |(standard, with_setting)| Cause {
                setting: FAST_MEMORY.to_owned(),
                figure: "most / least cycles a ray".to_owned(),
                standard,
                with_setting,
            },
        ),
        numbers: numbers.collect(),
        admitted: Vec::new(),
        open: "",
    }
}

/// Requests fill the memory long before their bytes do, so the part of its peak does not tell.
const LIMITED: f64 = 1.2;

fn local_memory(spots: &[HotSpot]) -> Claim {
    let gain = |spot: &HotSpot| Some(spot.with(FAST_MEMORY, Version::None)?.fps / spot.no_vm.fps);
    let has_cruiser = spots.iter().any(|spot| spot.family() == "Cruiser");
    // The other scenes are there to compare; a scene of the user's is judged as the Cruiser is.
    let judged = || spots.iter().filter(|spot| !has_cruiser || spot.family() == "Cruiser");
    let stalled = |spot: &HotSpot| Some(spot.no_vm.units[TRIANGLES].waits_for("memory"));
    let mut numbers = ranges(spots, gain);
    let stalls = ranges(judged(), stalled).into_iter();
    numbers.extend(
        stalls.map(|range| {
            format!("part of the time in which the intersection unit waits for memory: {range}")
        }),
    );
    Claim {
        id: "limited-by-memory",
        section: "§4",
        claim: if has_cruiser {
            "The Cruiser is limited by the bandwidth to on-board memory: without virtual memory, a memory twice as fast gains more \
             than 20 %."
        } else {
            "The scene is limited by the bandwidth to on-board memory, as the Cruiser is: without virtual memory, a memory twice as \
             fast gains more than 20 %."
        },
        paper: "limited; 65 % of the peak at frames 142 and 1625".to_owned(),
        ours: format!("gain {}", Range::of(judged().filter_map(gain))),
        verdict: Holds::of(judged().filter_map(gain).map(|gain| gain > LIMITED)),
        cause: cause(FAST_MEMORY, "frames a second without virtual memory", judged(), |spot| {
            Some((spot.no_vm.fps, spot.with(FAST_MEMORY, Version::None)?.fps))
        }),
        numbers,
        admitted: Vec::new(),
        open: "",
    }
}

fn triangle_cache(spots: &[HotSpot]) -> Claim {
    let both = |spot: &HotSpot| Some((spot.no_vm.fps, spot.with(SMALL_TRIANGLE_CACHE, Version::None)?.fps));
    let drop = |spot: &HotSpot| both(spot).map(|(large, small)| small / large);
    Claim {
        id: "cruiser-triangle-cache",
        section: "§4",
        claim: "The Cruiser needs a larger triangle cache: with 144 KB in place of 576 KB it loses more than 20 % of its speed.",
        paper: "a drastic drop, no figure".to_owned(),
        ours: ranges(spots, drop).join("; "),
        verdict: Holds::of(spots.iter().filter_map(drop).map(|drop| drop < 0.8)),
        cause: cause(SMALL_TRIANGLE_CACHE, "frames a second without virtual memory", spots, both),
        numbers: Vec::new(),
        admitted: Vec::new(),
        open: "",
    }
}

fn triangle_hits(spots: &[HotSpot]) -> Claim {
    let cruiser = || spots.iter().filter(|spot| spot.family() == "Cruiser");
    let rates = || cruiser().map(|spot| spot.no_vm.hit_rate(TRIANGLES));
    let worst = rates().fold(1.0, f64::min);
    Claim {
        id: "triangle-hit-rate",
        section: "§4",
        claim: "At one hot spot of the Cruiser the hit rate of the triangle cache goes down to 13 %: ours is below 25 %.",
        paper: "0.13 at frame 1625".to_owned(),
        ours: format!("{worst:.2} at least"),
        verdict: Holds::of([worst < 0.25]),
        cause: cause(SHALLOW_TREE, "hit rate of the triangle cache", cruiser(), |spot| {
            let shallow = spot.with(SHALLOW_TREE, Version::None)?;
            Some((spot.no_vm.hit_rate(TRIANGLES), shallow.hit_rate(TRIANGLES)))
        }),
        numbers: cruiser()
            .map(|spot| format!("{}: {:.2}", spot.name(), spot.no_vm.hit_rate(TRIANGLES)))
            .collect(),
        admitted: Vec::new(),
        open: "The ship and the paper's kd-tree, which was not the best (§4).",
    }
}
