//! The traversal unit: a stack machine that leads packets through the kd-tree (§2).
//!
//! An interval of distances a ray says which part of the ray lies in the cell at hand. Bounds of
//! intervals are computed in f32 and widened by their rounding error, so that no cell is missed:
//! `t = (plane - origin) · (1 / direction)` takes three roundings, so that the true distance lies
//! within `t · (1 ± γ(3))`, γ(n) = n·u / (1 - n·u), u = 2⁻²⁴ (Higham 2002, §3.1; after Ize 2013).

use crate::image::{LIST_ENTRY_BYTES, NODE_BYTES, NodeRecord, Registers, TRIANGLE_BYTES};
use crate::intersection::Prepared;
use crate::kdtree::{Axis, MAX_DEPTH};
use crate::memory::{Memory, Port};
use crate::ray::{Hits, Packet, Query};
use crate::units::HostAddr;

/// Relative width by which a distance to a plane is widened to each side: 2 γ(3), the second γ(3)
/// for the rounding of the widening itself and for the distance that it is compared to.
const WIDENING: f32 = 6.0 * (f32::EPSILON / 2.0) / (1.0 - 3.0 * (f32::EPSILON / 2.0));

/// The parts of the rays that lie in a cell: `enter ≤ t ≤ leave`, closed, empty for a ray that
/// does not meet the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intervals<const N: usize> {
    /// Where each ray enters.
    pub enter: [f32; N],
    /// Where each ray leaves.
    pub leave: [f32; N],
}

impl<const N: usize> Intervals<N> {
    /// Whether any ray meets the cell.
    #[inline]
    fn any(&self) -> bool {
        let mut any = false;
        for lane in 0..N {
            any |= self.enter[lane] <= self.leave[lane];
        }
        any
    }

    /// Cuts off what lies behind the hits found so far.
    #[inline]
    fn clip(&mut self, hits: &Hits<N>) {
        for lane in 0..N {
            self.leave[lane] = min(hits.t[lane], self.leave[lane]);
        }
    }
}

/// The lesser; the second where the first is NaN. One instruction.
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater; the second where the first is NaN. One instruction.
#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Least and greatest distance at which a plane may be met, from the distance computed.
#[inline(always)]
fn widen(t: f32) -> (f32, f32) {
    let (a, b) = (t * (1.0 - WIDENING), t * (1.0 + WIDENING));
    (min(a, b), max(a, b))
}

/// The interval of one ray in the two children of a node (KD-3): below and above the plane at
/// distance `t` on a ray that comes from above where `downwards`.
///
/// By comparisons alone. NaN, the distance of a plane in which the ray lies, leaves the whole
/// interval to both children; an infinite distance, that of a plane to which the ray is parallel,
/// leaves it to the side on which the ray is.
#[inline(always)]
#[must_use]
pub fn visit(enter: f32, leave: f32, t: f32, downwards: bool) -> [(f32, f32); 2] {
    let (least, greatest) = widen(t);
    let near = (enter, min(greatest, leave));
    let far = (max(least, enter), leave);
    let (below, above) = if downwards { (far, near) } else { (near, far) };
    [below, above]
}

/// 1 / direction of each ray, for each axis.
type Reciprocals<const N: usize> = [[f32; N]; 3];

/// Whether a ray goes towards lower coordinates; −0.0, whose reciprocal is −∞, does.
#[inline(always)]
fn is_downwards(reciprocal: f32) -> bool {
    reciprocal < 0.0
}

/// A child put off.
#[derive(Clone, Copy, Debug)]
struct Entry<const N: usize> {
    node: HostAddr,
    intervals: Intervals<N>,
}

/// The traversal unit for packets of `N` rays, with its stack.
#[derive(Clone, Debug)]
pub struct Traversal<const N: usize> {
    stack: Vec<Entry<N>>,
}

impl<const N: usize> Default for Traversal<N> {
    fn default() -> Self {
        Self { stack: Vec::with_capacity(MAX_DEPTH) }
    }
}

impl<const N: usize> Traversal<N> {
    /// Leads `packet` through the tree and returns what its rays hit (KD-4).
    ///
    /// Each node is read once for all rays that meet its cell. Of two children, the packet goes
    /// first to the one that its first ray there meets first (Assumed); the result does not
    /// depend on it.
    pub fn run(
        &mut self,
        memory: &mut impl Memory,
        registers: &Registers,
        packet: &Packet<N>,
        query: Query,
    ) -> Hits<N> {
        let mut hits = Hits::none(packet);
        let reciprocal = packet.direction.map(|row| row.map(|d| 1.0 / d));
        self.stack.clear();
        self.stack
            .push(Entry { node: registers.root, intervals: clip_to_bounds(registers, packet, &reciprocal) });
        while let Some(Entry { mut node, mut intervals }) = self.stack.pop() {
            intervals.clip(&hits);
            if !intervals.any() {
                continue;
            }
            loop {
                match NodeRecord::decode(memory.fetch(Port::Node, node)) {
                    NodeRecord::Inner { axis, split, below } => {
                        node = self.descend(packet, &reciprocal, &mut intervals, axis, split, below);
                    }
                    NodeRecord::Leaf { list, count } => {
                        for entry in 0..count {
                            let entry = memory.fetch(Port::List, list.offset(entry * LIST_ENTRY_BYTES));
                            let entry = u32::from_le_bytes(entry);
                            let (addr, tag) = (entry & !3, entry & 3);
                            let bytes: [u8; TRIANGLE_BYTES as usize] =
                                memory.fetch(Port::Triangle, HostAddr(addr));
                            Prepared::decode(registers.kernel, tag, bytes).intersect_packet(
                                addr,
                                packet,
                                (&intervals.enter, &intervals.leave),
                                query,
                                &mut hits,
                            );
                        }
                        break;
                    }
                }
            }
        }
        hits
    }

    /// One step at an inner node: narrows `intervals` to the child that is next and returns its
    /// address; puts the other on the stack if any ray meets it.
    #[inline]
    fn descend(
        &mut self,
        packet: &Packet<N>,
        reciprocal: &Reciprocals<N>,
        intervals: &mut Intervals<N>,
        axis: Axis,
        split: f32,
        below: HostAddr,
    ) -> HostAddr {
        let axis = axis as usize;
        let (origin, reciprocal) = (&packet.origin[axis], &reciprocal[axis]);
        let mut low = *intervals;
        let mut high = *intervals;
        for lane in 0..N {
            let t = (split - origin[lane]) * reciprocal[lane];
            let [in_low, in_high] =
                visit(intervals.enter[lane], intervals.leave[lane], t, is_downwards(reciprocal[lane]));
            (low.enter[lane], low.leave[lane]) = in_low;
            (high.enter[lane], high.leave[lane]) = in_high;
        }
        let above = below.offset(NODE_BYTES);
        match (low.any(), high.any()) {
            (true, true) => {
                let first = (0..N).find(|&lane| intervals.enter[lane] <= intervals.leave[lane]).unwrap_or(0);
                let (near, far) = if is_downwards(reciprocal[first]) {
                    ((above, high), (below, low))
                } else {
                    ((below, low), (above, high))
                };
                self.stack.push(Entry { node: far.0, intervals: far.1 });
                *intervals = near.1;
                near.0
            }
            (true, false) => {
                *intervals = low;
                below
            }
            // Widened intervals overlap, so that a ray meets at least one child.
            (false, _) => {
                *intervals = high;
                above
            }
        }
    }
}

/// The parts of the rays in the box around the scene.
fn clip_to_bounds<const N: usize>(
    registers: &Registers,
    packet: &Packet<N>,
    reciprocal: &Reciprocals<N>,
) -> Intervals<N> {
    let mut intervals = Intervals { enter: packet.t_min, leave: packet.t_max };
    for axis in 0..3 {
        let (low, high) = (registers.bounds.min[axis], registers.bounds.max[axis]);
        for lane in 0..N {
            let reciprocal = reciprocal[axis][lane];
            let origin = packet.origin[axis][lane];
            let (near, far) = if is_downwards(reciprocal) { (high, low) } else { (low, high) };
            intervals.enter[lane] = max(widen((near - origin) * reciprocal).0, intervals.enter[lane]);
            intervals.leave[lane] = min(widen((far - origin) * reciprocal).1, intervals.leave[lane]);
        }
    }
    intervals
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_empty((enter, leave): (f32, f32)) -> bool {
        enter > leave
    }

    #[test]
    fn planes_split_the_interval() {
        let [below, above] = visit(1.0, 5.0, 3.0, false);
        assert!(below.0 == 1.0 && below.1 >= 3.0 && above.0 <= 3.0 && above.1 == 5.0);
        assert!(below.1 - above.0 < 1e-5);
        assert_eq!(visit(1.0, 5.0, 3.0, true), [above, below]);
        let [below, above] = visit(1.0, 5.0, 7.0, false);
        assert!(!is_empty(below) && is_empty(above));
        let [below, above] = visit(1.0, 5.0, -7.0, false);
        assert!(is_empty(below) && !is_empty(above));
    }

    #[test]
    fn parallel_rays_stay_on_their_side() {
        // (split - origin) / 0, from below and from above the plane.
        for (zero, downwards) in [(0.0_f32, false), (-0.0, true)] {
            let [below, above] = visit(0.0, 9.0, 1.0 / zero, downwards);
            assert!((!is_empty(below), is_empty(above)) == (true, true));
            let [below, above] = visit(0.0, 9.0, -1.0 / zero, downwards);
            assert!((is_empty(below), !is_empty(above)) == (true, true));
        }
    }

    #[test]
    fn rays_in_the_plane_go_to_both_sides() {
        assert_eq!(visit(0.0, 9.0, f32::NAN, false), [(0.0, 9.0); 2]);
        assert_eq!(visit(0.0, 9.0, f32::NAN, true), [(0.0, 9.0); 2]);
    }

    #[test]
    fn minus_zero_is_downwards() {
        assert!(is_downwards(1.0 / -0.0) && !is_downwards(1.0 / 0.0));
    }
}
