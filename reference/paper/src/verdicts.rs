//! The paper's claims, and whether they hold here.

use crate::figure3::Graph;
use crate::table2::{HotSpot, Shape, Variation};
use crate::tables::{self, mb};
use saarcor_studies::metadata::MetadataFacts;
use saarcor_studies::standard::{self, family};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Holds {
    /// Everywhere it was looked at.
    Holds,
    /// In some places.
    InPart,
    /// Nowhere.
    DoesNot,
}

impl Holds {
    /// From the findings in each place.
    fn of(places: impl IntoIterator<Item = bool>) -> Self {
        let (mut some, mut all) = (false, true);
        places.into_iter().for_each(|holds| (some, all) = (some | holds, all & holds));
        match (some, all) {
            (true, true) => Self::Holds,
            (true, false) => Self::InPart,
            (false, _) => Self::DoesNot,
        }
    }
}

impl fmt::Display for Holds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::InPart => "holds in part",
            Self::DoesNot => "does not hold here",
        })
    }
}

/// A claim of the paper, judged.
#[derive(Clone, Debug, Serialize)]
pub struct ClaimVerdict {
    /// The claim.
    pub claim: String,
    /// Whether it holds.
    pub verdict: Holds,
    /// The numbers that decide it, place by place.
    pub numbers: Vec<String>,
}

/// A range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    least: f64,
    most: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self { least: f64::INFINITY, most: f64::NEG_INFINITY }, |range, value| Self {
            least: range.least.min(value),
            most: range.most.max(value),
        })
    }

    /// Both ends moved outwards by a quarter of their distance from 1: values so near to the paper's rows
    /// count as the same.
    fn widened(self) -> Self {
        let quarter = |end: f64| (end - 1.0).abs() / 4.0;
        Self { least: self.least - quarter(self.least), most: self.most + quarter(self.most) }
    }

    fn has(self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} to {:.2}", self.least, self.most)
    }
}

/// The paper's scenes of one family, or the real scenes that stand for them.
pub(crate) fn families<'a>(
    spots: impl IntoIterator<Item = &'a HotSpot>,
) -> BTreeMap<String, Vec<&'a HotSpot>> {
    let mut families: BTreeMap<String, Vec<&HotSpot>> = BTreeMap::new();
    for spot in spots {
        let name = family(&spot.paper.scene);
        let name = if spot.real { format!("{name} (real scene)") } else { name.to_owned() };
        families.entry(name).or_default().push(spot);
    }
    families
}

/// Judges all claims: by the examples of §3, the walks, the hot spots, and their variations.
#[must_use]
pub fn judge(
    examples: &[MetadataFacts],
    graphs: &[Graph],
    spots: &[HotSpot],
    variations: &[Variation],
) -> Vec<ClaimVerdict> {
    vec![
        metadata(examples),
        memory(graphs),
        relation("Version A is hardly slower than no virtual memory (A / no VM)", spots, |s| s.speed_a),
        relation("Version B is a little slower than A (B / no VM)", spots, |s| s.speed_b),
        filled(spots),
        relation("Version B moves a third more than A at most (Mem B / Mem A)", spots, |s| s.memory_b),
        fast_bus(spots),
        best_line(variations),
        ways_and_hash(variations),
        linear(spots),
        local_memory(spots),
    ]
}

fn metadata(computed: &[MetadataFacts]) -> ClaimVerdict {
    let printed = &tables::stated().metadata.examples;
    let same = printed.iter().zip(computed).map(|(e, ours)| e.metadata_bytes == ours.metadata_bytes);
    let ours: Vec<_> = computed
        .iter()
        .map(|ours| format!("{} KB at {} B", ours.metadata_bytes >> 10, ours.line_bytes))
        .collect();
    ClaimVerdict {
        claim: "16 MB need 640 KB of metadata in lines of 128 B and 80 KB in lines of 1 KB (§3)".to_owned(),
        verdict: Holds::of(same),
        numbers: vec![ours.join(", ")],
    }
}

fn memory(graphs: &[Graph]) -> ClaimVerdict {
    let peak = |graph: &Graph| graph.peak(|row| row.working_set_bytes).map_or(0, |row| row.working_set_bytes);
    let numbers = graphs
        .iter()
        .map(|graph| format!("{}: {} of {} MB", graph.name, mb(peak(graph)), graph.memory_bytes >> 20));
    ClaimVerdict {
        claim: "The memories of Table 2 hold the largest working set (§4)".to_owned(),
        verdict: Holds::of(graphs.iter().map(|graph| peak(graph) <= graph.memory_bytes)),
        numbers: numbers.collect(),
    }
}

/// Whether a relation within the rows lies in the paper's own range, family by family.
fn relation(claim: &str, spots: &[HotSpot], of: impl Fn(&Shape) -> f64) -> ClaimVerdict {
    let (mut places, mut numbers) = (Vec::new(), Vec::new());
    for (name, spots) in families(spots) {
        let paper = Range::of(spots.iter().map(|spot| of(&Shape::printed(&spot.paper))));
        let ours = || spots.iter().map(|spot| of(&Shape::ours(spot)));
        places.extend(ours().map(|value| paper.widened().has(value)));
        numbers.push(format!("{name} {} (paper {paper})", Range::of(ours())));
    }
    ClaimVerdict { claim: format!("{claim} (Table 2)"), verdict: Holds::of(places), numbers }
}

/// A claim on a number of each row, judged family by family.
fn of_rows<'a>(
    claim: &str,
    spots: impl IntoIterator<Item = &'a HotSpot>,
    number: impl Fn(&HotSpot) -> f64,
    holds: impl Fn(f64) -> bool,
) -> ClaimVerdict {
    let (mut places, mut numbers) = (Vec::new(), Vec::new());
    for (name, spots) in families(spots) {
        let ours = || spots.iter().map(|spot| number(spot));
        places.extend(ours().map(&holds));
        numbers.push(format!("{name} {}", Range::of(ours())));
    }
    ClaimVerdict { claim: claim.to_owned(), verdict: Holds::of(places), numbers }
}

/// Rows that load less than this are too small to show where the bytes go.
const WORTH_COUNTING_MB: f64 = 0.05;

fn filled(spots: &[HotSpot]) -> ClaimVerdict {
    let counts = |spot: &&HotSpot| spot.version_a.pci_bytes as f64 > WORTH_COUNTING_MB * tables::MB as f64;
    of_rows(
        "What is loaded reaches the on-board memory once: (Mem A - Mem no VM) / PCI is 1, within 10 % (Table 2)",
        spots.iter().filter(counts),
        |spot| Shape::ours(spot).filled,
        |filled| (filled - 1.0).abs() <= 0.1,
    )
}

fn fast_bus(spots: &[HotSpot]) -> ClaimVerdict {
    of_rows(
        "A bus four times as fast changes nothing: less than 2 % (§4)",
        spots,
        |spot| spot.version_a_fast_pci.fps / spot.version_a.fps,
        |gain| gain < 1.02,
    )
}

/// The variations by their scenes.
fn by_scene(variations: &[Variation]) -> BTreeMap<String, Vec<&Variation>> {
    let mut scenes: BTreeMap<String, Vec<&Variation>> = BTreeMap::new();
    for variation in variations {
        let name = format!("{} {}", variation.scene, variation.run.frame);
        scenes.entry(name).or_default().push(variation);
    }
    scenes
}

/// Whether a variation is one of the sizes of lines.
fn is_of_lines(variation: &Variation) -> bool {
    variation.ways == standard::WAYS && variation.hashed
}

fn best_line(variations: &[Variation]) -> ClaimVerdict {
    let (mut places, mut numbers) = (Vec::new(), Vec::new());
    for (scene, all) in by_scene(variations) {
        let lines = || all.iter().copied().filter(|variation| is_of_lines(variation));
        // Longer lines load more and need less metadata: the least product of both.
        let costs = |one: &&Variation| u128::from(one.run.pci_bytes) * u128::from(one.metadata_bytes);
        let (Some(both), Some(fewest), Some(fastest)) = (
            lines().min_by_key(costs),
            lines().min_by_key(|one| one.run.pci_bytes),
            lines().min_by_key(|one| one.run.cycles),
        ) else {
            continue;
        };
        places.push(both.line_bytes == standard::LINE.0);
        numbers.push(format!(
            "{scene}: least bytes loaded x metadata {}, least loaded {}, fastest {}",
            both.line_bytes, fewest.line_bytes, fastest.line_bytes
        ));
    }
    ClaimVerdict { claim: "Lines of 128 B are best (§3)".to_owned(), verdict: Holds::of(places), numbers }
}

fn ways_and_hash(variations: &[Variation]) -> ClaimVerdict {
    let (mut places, mut numbers) = (Vec::new(), Vec::new());
    for (scene, all) in by_scene(variations) {
        let of_line = || all.iter().filter(|variation| variation.line_bytes == standard::LINE.0);
        let Some(standard) = of_line().find(|variation| is_of_lines(variation)) else { continue };
        places.extend(of_line().map(|other| standard.run.pci_bytes <= other.run.pci_bytes));
        let each = of_line().map(|one| {
            let hash = if one.hashed { "hashed" } else { "plain" };
            format!("{} {hash} {}", one.ways, mb(one.run.pci_bytes))
        });
        numbers.push(format!("{scene}, MB loaded by ways: {}", each.collect::<Vec<_>>().join(", ")));
    }
    ClaimVerdict {
        claim: "4 ways with the hash load the least, against 1, 2 and 4 ways with and without (§3)"
            .to_owned(),
        verdict: Holds::of(places),
        numbers,
    }
}

fn linear(spots: &[HotSpot]) -> ClaimVerdict {
    let mut frames: BTreeMap<(bool, &str), Vec<f64>> = BTreeMap::new();
    for spot in spots.iter().filter(|spot| family(&spot.paper.scene) == "Conference") {
        frames.entry((spot.real, &spot.paper.frame)).or_default().push(spot.no_vm.cycles_a_ray);
    }
    let (mut places, mut numbers) = (Vec::new(), Vec::new());
    for ((real, frame), cycles) in frames {
        let range = Range::of(cycles.iter().copied());
        places.push(range.most / range.least < 1.15);
        let cycles: Vec<_> = cycles.iter().map(|cycles| format!("{cycles:.1}")).collect();
        let scene = if real { "real " } else { "" };
        numbers.push(format!("{scene}{frame}: {}", cycles.join(", ")));
    }
    ClaimVerdict {
        claim:
            "Speed is linear in rays: cycles a ray of Conference with 0, 2 and 8 lights within 15 % (Table 2)"
                .to_owned(),
        verdict: Holds::of(places),
        numbers,
    }
}

fn local_memory(spots: &[HotSpot]) -> ClaimVerdict {
    // Requests fill the memory long before their bytes do: so the part of its peak does not tell.
    const GAIN: f64 = 1.2;
    let claim = "The Cruiser is limited by the on-board memory: without virtual memory, one that is twice as fast gains \
                 more than 20 % (§4)";
    let gain = |spot: &HotSpot| spot.no_vm_fast_memory.fps / spot.no_vm.fps;
    let is_limited = |gain: f64| gain > GAIN;
    let cruiser = spots.iter().filter(|spot| family(&spot.paper.scene) == "Cruiser");
    // The others are there to compare.
    let ClaimVerdict { verdict, .. } = of_rows(claim, cruiser, gain, is_limited);
    ClaimVerdict { verdict, ..of_rows(claim, spots, gain, is_limited) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_holds_everywhere_somewhere_or_nowhere() {
        assert_eq!(Holds::of([true, true]), Holds::Holds);
        assert_eq!(Holds::of([true, false]), Holds::InPart);
        assert_eq!(Holds::of([false]), Holds::DoesNot);
        assert_eq!(Holds::of([]), Holds::DoesNot, "of nothing, nothing is shown");
    }

    #[test]
    fn ranges_widen_away_from_one() {
        let widened = Range::of([0.88, 0.96].into_iter()).widened();
        assert!((widened.least - 0.85).abs() < 1e-12 && (widened.most - 0.97).abs() < 1e-12);
        let widened = Range::of([1.32, 1.2].into_iter()).widened();
        assert!((widened.least - 1.15).abs() < 1e-12 && (widened.most - 1.4).abs() < 1e-12);
    }
}
