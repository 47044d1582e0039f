//! The surface area heuristic: the plane that is cheapest for a random ray through the cell.
//!
//! The candidates are the ends of the boxes around the triangles' parts, and the plane found is
//! exactly the cheapest of all of them. Large cells count the ends in bins first. The counts bound
//! the cost of the planes in a bin from both sides, so that only the few bins that can hold the
//! best plane need be sorted and swept.

use super::plane::Plane;
use super::reference::Reference;
use rayon::prelude::*;
use saarcor_model::host::{Aabb, Axis};

/// Parameters of the heuristic.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    /// Cost of passing an inner node.
    pub traversal: f64,
    /// Cost of testing a triangle.
    pub intersection: f64,
    /// Part of the cost that a cut is spared when it leaves one side empty.
    pub empty_bonus: f64,
}

/// Up to this many references, sorting all ends is faster than counting them first (measured).
const FEW: usize = 64;

/// Bins an axis (measured: 64 to 256 take the same time).
const BINS: usize = 128;

/// References that one thread counts in one go.
const CHUNK: usize = 1 << 15;

/// Relative room for the rounding of bin edges and costs where they serve as bounds. Bins and
/// costs are reckoned in f64 with less than 2^10 roundings.
const ROUNDING: f64 = 1e-9;

/// The plane of least cost; of equal ones the first by axis, then by coordinate. `None` when a
/// leaf costs no more. `ends` is working memory.
pub(super) fn surface_area(
    cell: &Aabb,
    references: &[Reference],
    costs: &Costs,
    ends: &mut Vec<End>,
) -> Option<Plane> {
    let mut best = Best { cost: costs.intersection * references.len() as f64, plane: None };
    let slabs = Axis::ALL.map(|axis| Slab::of(cell, axis, costs));
    if references.len() <= FEW {
        for slab in slabs.iter().filter(|slab| slab.min < slab.max) {
            End::collect(slab.axis, references, ends, |_| true);
            slab.sweep(ends, [0, references.len()], &mut best);
        }
        return best.plane;
    }

    let counts = count(&slabs, references);
    let axes = || slabs.iter().zip(&counts).filter(|(slab, _)| slab.min < slab.max);
    let bound = axes().map(|(slab, counts)| slab.upper_bound(counts)).fold(best.cost, f64::min);
    for (slab, counts) in axes() {
        let promising: [bool; BINS] = std::array::from_fn(|bin| {
            counts.any(bin) && slab.lower_bound(counts, bin) <= bound * (1.0 + ROUNDING)
        });
        if !promising.contains(&true) {
            continue;
        }
        End::collect(slab.axis, references, ends, |at| promising[slab.bin(at)]);
        for of_bin in ends.chunk_by(|a, b| slab.bin(a.at()) == slab.bin(b.at())) {
            let bin = slab.bin(of_bin[0].at());
            slab.sweep(of_bin, [counts.below[bin], counts.above[bin]], &mut best);
        }
    }
    best.plane
}

/// The cheapest plane so far.
struct Best {
    cost: f64,
    plane: Option<Plane>,
}

/// One end of a box on an axis: its coordinate as an integer of the same order, and in the two
/// lowest bits which end it is. Sorted by coordinate, then upper ends, flat boxes, lower ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct End(u64);

impl End {
    const UPPER: u64 = 0;
    const FLAT: u64 = 1;
    const LOWER: u64 = 2;
    const KINDS: [u64; 3] = [Self::UPPER, Self::FLAT, Self::LOWER];

    fn new(at: f32, kind: u64) -> Self {
        let bits = (at + 0.0).to_bits(); // -0 becomes 0, as the two are one plane
        let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
        Self(u64::from(ordered) << 2 | kind)
    }

    /// The sorted ends of all references at the coordinates that are `wanted`, into `ends`.
    fn collect(axis: Axis, references: &[Reference], ends: &mut Vec<Self>, wanted: impl Fn(f32) -> bool) {
        ends.clear();
        for Reference { bounds, .. } in references {
            let (min, max) = (bounds.min[axis as usize], bounds.max[axis as usize]);
            let flat = min == max;
            if wanted(min) {
                ends.push(Self::new(min, if flat { Self::FLAT } else { Self::LOWER }));
            }
            if !flat && wanted(max) {
                ends.push(Self::new(max, Self::UPPER));
            }
        }
        ends.sort_unstable();
    }

    fn at(self) -> f32 {
        let ordered = (self.0 >> 2) as u32;
        f32::from_bits(if ordered >> 31 == 1 { ordered ^ 1 << 31 } else { !ordered })
    }

    fn kind(self) -> u64 {
        self.0 & 3
    }
}

/// How many references start below and end above each edge between bins.
#[derive(Clone)]
struct Counts {
    /// `below[b]` references start in a bin before `b`.
    below: [usize; BINS + 1],
    /// `above[b]` references end in bin `b` or later.
    above: [usize; BINS + 1],
}

impl Counts {
    /// Whether any reference starts or ends in the bin.
    fn any(&self, bin: usize) -> bool {
        self.below[bin] != self.below[bin + 1] || self.above[bin] != self.above[bin + 1]
    }
}

/// Counts the ends of the references in the bins of each axis.
fn count(slabs: &[Slab; 3], references: &[Reference]) -> [Counts; 3] {
    type Histogram = [[[u32; BINS]; 2]; 3];
    let histogram = |references: &[Reference]| {
        let mut bins: Histogram = [[[0; BINS]; 2]; 3];
        for reference in references {
            for (axis, (slab, [starts, ends])) in slabs.iter().zip(&mut bins).enumerate() {
                starts[slab.bin(reference.bounds.min[axis])] += 1;
                ends[slab.bin(reference.bounds.max[axis])] += 1;
            }
        }
        bins
    };
    let add = |mut sum: Histogram, other: Histogram| {
        let sums = sum.as_flattened_mut().as_flattened_mut();
        sums.iter_mut().zip(other.as_flattened().as_flattened()).for_each(|(a, b)| *a += b);
        sum
    };
    let bins = references.par_chunks(CHUNK).map(histogram).reduce_with(add).unwrap_or([[[0; BINS]; 2]; 3]);
    bins.map(|[starts, ends]| {
        let mut counts = Counts { below: [0; BINS + 1], above: [references.len(); BINS + 1] };
        for bin in 0..BINS {
            counts.below[bin + 1] = counts.below[bin] + starts[bin] as usize;
            counts.above[bin + 1] = counts.above[bin] - ends[bin] as usize;
        }
        counts
    })
}

/// A cell seen along an axis: what a plane across it costs.
struct Slab {
    axis: Axis,
    /// Where the cell begins.
    min: f64,
    /// Where it ends.
    max: f64,
    /// Surface of a half of no thickness, as a part of the cell's.
    flat: f64,
    /// What each unit of thickness adds to that.
    slope: f64,
    /// Bins in a unit of thickness.
    bins: f64,
    costs: Costs,
}

impl Slab {
    fn of(cell: &Aabb, axis: Axis, costs: &Costs) -> Self {
        let (min, max) = (cell.min.as_dvec3(), cell.max.as_dvec3());
        let extent = max - min;
        let [this, next, last] = [0, 1, 2].map(|step| (axis as usize + step) % 3);
        let flat = extent[next] * extent[last];
        let slope = extent[next] + extent[last];
        let surface = flat + slope * extent[this];
        Self {
            axis,
            min: min[this],
            max: max[this],
            flat: flat / surface,
            slope: slope / surface,
            bins: BINS as f64 / extent[this],
            costs: *costs,
        }
    }

    /// Expected cost of a ray through the cell when it is cut into halves of that thickness that
    /// hold that many references.
    fn cost(&self, thickness: [f64; 2], counts: [usize; 2]) -> f64 {
        let [below, above] =
            [0, 1].map(|half| (self.flat + self.slope * thickness[half]) * counts[half] as f64);
        let spared = if counts.contains(&0) { self.costs.empty_bonus } else { 0.0 };
        (self.costs.traversal + self.costs.intersection * (below + above)) * (1.0 - spared)
    }

    /// The bin of a coordinate: ascending with the coordinate, rounding included.
    fn bin(&self, at: f32) -> usize {
        (((f64::from(at) - self.min) * self.bins) as usize).min(BINS - 1)
    }

    /// The thickness below and above the edge before `bin`, moved by `room` bins outwards.
    fn thickness(&self, bin: usize, room: f64) -> [f64; 2] {
        [bin as f64 + room, (BINS - bin) as f64 + room].map(|bins| bins / self.bins)
    }

    /// A cost that no plane in the bin is below.
    fn lower_bound(&self, counts: &Counts, bin: usize) -> f64 {
        let [below, _] = self.thickness(bin, -ROUNDING);
        let [_, above] = self.thickness(bin + 1, -ROUNDING);
        self.cost([below, above], [counts.below[bin], counts.above[bin + 1]])
    }

    /// A cost that some plane does not exceed. The first and the last bin are left out, as their
    /// ends may lie in the cell's own faces.
    fn upper_bound(&self, counts: &Counts) -> f64 {
        (1..BINS - 1)
            .filter(|&bin| counts.any(bin))
            .map(|bin| {
                let [below, _] = self.thickness(bin + 1, ROUNDING);
                let [_, above] = self.thickness(bin, ROUNDING);
                self.cost([below, above], [counts.below[bin + 1], counts.above[bin]])
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Compares the planes through the sorted `ends`. Before the first, `below` references have
    /// started and `above` have not ended.
    fn sweep(&self, ends: &[End], [mut below, mut above]: [usize; 2], best: &mut Best) {
        for ends in ends.chunk_by(|a, b| a.at() == b.at()) {
            let at = ends[0].at();
            let [upper, flat, lower] =
                End::KINDS.map(|kind| ends.iter().filter(|end| end.kind() == kind).count());
            above -= upper + flat;
            let position = f64::from(at);
            if self.min < position && position < self.max {
                let thickness = [position - self.min, self.max - position];
                let mut compare = |flat_below, counts| {
                    let cost = self.cost(thickness, counts);
                    if cost < best.cost {
                        let plane = Plane { axis: self.axis, at, flat_below, counts };
                        *best = Best { cost, plane: Some(plane) };
                    }
                };
                compare(true, [below + flat, above]);
                if flat > 0 {
                    compare(false, [below, above + flat]);
                }
            }
            below += flat + lower;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    const COSTS: Costs = Costs { traversal: 1.0, intersection: 1.5, empty_bonus: 0.1 };

    /// The definition: each end of each box is a candidate, and references are counted one by one.
    fn naive(cell: &Aabb, references: &[Reference]) -> Option<Plane> {
        let mut best = Best { cost: COSTS.intersection * references.len() as f64, plane: None };
        for axis in Axis::ALL {
            let (k, slab) = (axis as usize, Slab::of(cell, axis, &COSTS));
            let mut ends: Vec<f32> =
                references.iter().flat_map(|r| [r.bounds.min[k], r.bounds.max[k]]).collect();
            ends.sort_by(f32::total_cmp);
            for at in ends.into_iter().filter(|at| cell.min[k] < *at && *at < cell.max[k]) {
                let thickness = [f64::from(at) - slab.min, slab.max - f64::from(at)];
                for flat_below in [true, false] {
                    let mut plane = Plane { axis, at, flat_below, counts: [0; 2] };
                    plane.counts = plane.count(references.iter().map(|reference| &reference.bounds));
                    let cost = slab.cost(thickness, plane.counts);
                    if cost < best.cost {
                        best = Best { cost, plane: Some(plane) };
                    }
                }
            }
        }
        best.plane
    }

    /// A coordinate on a coarse grid, so that ends coincide and boxes are flat, or anywhere, or
    /// among many in a single bin.
    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![(-4..=4i8).prop_map(f32::from), -4.0..4.0f32, 0.01..0.05f32]
    }

    fn references(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Reference>> {
        let point = || [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from_array);
        let one =
            [point(), point()].prop_map(|corners| Reference { triangle: 0, bounds: Aabb::around(corners) });
        prop::collection::vec(one, count)
    }

    proptest! {
        #[test]
        fn finds_the_cheapest_plane(
            references in prop_oneof![references(1..8), references(FEW + 1..4 * FEW)],
            scale in prop_oneof![Just(1.0f32), Just(1e-18), Just(1e18)],
        ) {
            let references: Vec<Reference> = references
                .into_iter()
                .map(|Reference { bounds, .. }| Reference {
                    triangle: 0,
                    bounds: Aabb { min: bounds.min * scale, max: bounds.max * scale },
                })
                .collect();
            let cell = references.iter().fold(Aabb::EMPTY, |cell, r| cell.union(r.bounds));
            prop_assume!(cell.min.cmplt(cell.max).any());
            prop_assert_eq!(
                surface_area(&cell, &references, &COSTS, &mut Vec::new()),
                naive(&cell, &references)
            );
        }

        #[test]
        fn ends_are_ordered_as_their_coordinates(a: f32, b: f32) {
            prop_assume!(!a.is_nan() && !b.is_nan());
            let (low, high) = (End::new(a, End::UPPER), End::new(b, End::UPPER));
            prop_assert_eq!(low.cmp(&high), a.partial_cmp(&b).expect("neither is NaN"));
            prop_assert_eq!(low.at(), a);
        }
    }
}
