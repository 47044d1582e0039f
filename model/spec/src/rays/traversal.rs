//! The traversal unit: a stack machine that leads packets through the kd-tree (§2).
//!
//! An interval of distances a ray says which part of the ray lies in the cell at hand. Bounds of
//! intervals are computed in f32 and widened by their rounding error, so that no cell is missed:
//! `t = (plane - origin) · (1 / direction)` takes three roundings, so that the computed distance is
//! the true one times 1 ± γ(3), γ(n) = n·u / (1 - n·u), u = 2⁻²⁴, and up to 2⁻¹⁵⁰ more where the
//! product underflows (Higham 2002, §2.1 and §3.1; after Ize 2013). The difference cannot underflow,
//! and the reciprocal must not: where it would, [`reciprocal`] makes it NaN, for which no interval
//! is cut.

use super::intersection::Prepared;
use super::ray::{Hits, Packet, Query};
use crate::host::{Axis, LIST_ENTRY_BYTES, ListEntry, MAX_DEPTH, NODE_BYTES, NodeRecord, Registers};
use crate::vm::{HostAddr, Memory, Observed, Observer, Unit};

/// Relative width by which a distance to a plane is widened to each side: 2 γ(3). The first γ(3) is
/// the error of the distance. Of the second one u is for the rounding of the widening itself, and
/// 2u are left for the distance that it is compared to: a hit may be reported at up to 1 ± 2u times
/// its true distance, that is within one unit in the last place, and cuts off no hit that is nearer
/// or as near (KD-4).
const WIDENING: f32 = 6.0 * (f32::EPSILON / 2.0) / (1.0 - 3.0 * (f32::EPSILON / 2.0));

/// Absolute width, for distances among the least f32, where rounding is not relative: half of the
/// least f32 each for the rounding of the distance, of the widening, and of the distance of a hit
/// that it is compared to, and as much to spare. It changes no distance above 2⁻¹²³.
const UNDERFLOW: f32 = f32::from_bits(2);

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
    /// No ray meets the cell.
    const EMPTY: Self = Self { enter: [f32::INFINITY; N], leave: [f32::NEG_INFINITY; N] };

    /// Whether any ray meets the cell.
    #[inline]
    #[must_use]
    pub fn any(&self) -> bool {
        let mut any = false;
        for lane in 0..N {
            any |= self.enter[lane] <= self.leave[lane];
        }
        any
    }

    /// Number of rays that meet the cell.
    #[inline]
    #[must_use]
    pub fn count(&self) -> u32 {
        let mut count = 0;
        for lane in 0..N {
            count += u32::from(self.enter[lane] <= self.leave[lane]);
        }
        count
    }

    /// The first ray that meets the cell.
    #[inline]
    #[must_use]
    pub fn first(&self) -> Option<usize> {
        (0..N).find(|&lane| self.enter[lane] <= self.leave[lane])
    }

    /// Cuts off what lies behind the hits found so far, at the distances `t`.
    #[inline]
    pub fn clip(&mut self, t: &[f32; N]) {
        for (leave, &t) in self.leave.iter_mut().zip(t) {
            *leave = min(t, *leave);
        }
    }
}

/// The lesser; the second where neither is, as with NaN. One instruction.
#[inline(always)]
#[must_use]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater; the second where neither is, as with NaN. One instruction.
#[inline(always)]
#[must_use]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Least and greatest distance at which a plane may be met, from the distance computed (KD-3,
/// Derived). Both are NaN where that is, and infinite where that is.
#[inline(always)]
#[must_use]
pub fn widen(t: f32) -> (f32, f32) {
    let (a, b) = (t * (1.0 - WIDENING), t * (1.0 + WIDENING));
    (min(a, b) - UNDERFLOW, max(a, b) + UNDERFLOW)
}

/// The interval of one ray in the two children of a node (KD-3): below and above the plane that it
/// meets between the distances `least` and `greatest`. It comes from above where `downwards`.
///
/// By comparisons alone. NaN, the distance of a plane in which the ray lies, leaves the whole
/// interval to both children; an infinite distance, that of a plane to which the ray is parallel,
/// leaves it to the side on which the ray is.
#[inline(always)]
#[must_use]
pub fn visit(enter: f32, leave: f32, (least, greatest): (f32, f32), downwards: bool) -> [(f32, f32); 2] {
    let near = (enter, min(greatest, leave));
    let far = (max(least, enter), leave);
    let (below, above) = if downwards { (far, near) } else { (near, far) };
    [below, above]
}

/// What differences of coordinates are multiplied by to give distances, for each axis and ray.
type Reciprocals<const N: usize> = [[f32; N]; 3];

/// 1 / `direction`, for distances to planes up to `reach` away: infinite where the ray is parallel
/// to them, and NaN, for which every ray goes to both children, where distances would be off by more
/// than their bound (KD-3, Derived).
///
/// That is where the reciprocal is less than the least normal f32, or a distance is greater than
/// the greatest f32: a ray with a component of 2⁻¹³⁰ has none that is an f32, but moves by 1/8 until
/// t = 2¹²⁷.
#[inline(always)]
#[must_use]
pub fn reciprocal(direction: f32, reach: f32) -> f32 {
    let reciprocal = 1.0 / direction;
    let exact = direction == 0.0;
    let bounded = (reciprocal.abs() >= f32::MIN_POSITIVE) & (reach * reciprocal.abs() < f32::INFINITY);
    if exact | bounded { reciprocal } else { f32::NAN }
}

/// Whether a ray goes towards lower coordinates, by the reciprocal of its direction; −0.0, whose
/// reciprocal is −∞, does.
#[inline(always)]
#[must_use]
pub fn is_downwards(reciprocal: f32) -> bool {
    reciprocal < 0.0
}

/// Which children of a node a packet visits, and which of two it visits first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Children {
    /// The child below the plane alone.
    Below,
    /// The child above the plane alone.
    Above,
    /// Both, the one below first.
    BelowFirst,
    /// Both, the one above first.
    AboveFirst,
}

impl Children {
    /// The children that any ray meets. Of two, the first is the one that a ray meets first which
    /// goes `downwards` or not (KD-4), which is asked for only then.
    ///
    /// Where none is met, it is the one above: widened intervals overlap, so that a packet that
    /// meets a cell meets at least one child.
    #[inline(always)]
    #[must_use]
    pub fn met(below: bool, above: bool, downwards: impl FnOnce() -> bool) -> Self {
        match (below, above) {
            (true, true) if downwards() => Self::AboveFirst,
            (true, true) => Self::BelowFirst,
            (true, false) => Self::Below,
            (false, _) => Self::Above,
        }
    }
}

/// The stack of the traversal unit: children to visit later, at most `DEPTH` of them.
///
/// A walk is at one node. At an inner node it steps down by [`Stack::descend`], after a leaf it
/// goes on by [`Stack::resume`]: so it visits each leaf that it is led to once, near before far.
/// An inner node puts off one child at most, so that a walk of a tree with up to `DEPTH` inner
/// nodes on a path needs no more room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stack<T, const DEPTH: usize> {
    /// The children put off, the last one last; what is behind the first `len` means nothing.
    pub put_off: [T; DEPTH],
    /// Number of children put off.
    pub len: usize,
}

impl<T: Copy, const DEPTH: usize> Stack<T, DEPTH> {
    /// Nothing is put off; `unused` fills the room.
    #[must_use]
    pub fn new(unused: T) -> Self {
        Self { put_off: [unused; DEPTH], len: 0 }
    }

    /// A walk begins at `root`, to which [`Stack::resume`] leads first.
    #[inline]
    pub fn begin(&mut self, root: T) {
        self.len = 0;
        self.put_off(root);
    }

    /// One step at an inner node with the children `below` and `above`: puts one off if both are
    /// visited, and returns whether the one above is next.
    ///
    /// # Panics
    /// If more than `DEPTH` children are put off: no walk of a valid tree does (KD-2).
    #[inline(always)]
    pub fn descend(&mut self, visited: Children, below: T, above: T) -> bool {
        match visited {
            Children::Below => false,
            Children::Above => true,
            Children::BelowFirst => {
                self.put_off(above);
                false
            }
            Children::AboveFirst => {
                self.put_off(below);
                true
            }
        }
    }

    #[inline]
    fn put_off(&mut self, child: T) {
        self.put_off[self.len] = child;
        self.len += 1;
    }

    /// Where to go on after a leaf: to the child put off last. None at the end of the walk.
    #[inline]
    pub fn resume(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        Some(self.put_off[self.len])
    }
}

/// A node to visit, and the parts of the rays in its cell.
#[derive(Clone, Copy, Debug)]
struct Visit<const N: usize> {
    node: HostAddr,
    intervals: Intervals<N>,
}

/// The traversal unit for packets of `N` rays, with its stack.
#[derive(Clone, Debug)]
pub struct Traversal<const N: usize> {
    stack: Stack<Visit<N>, MAX_DEPTH>,
}

impl<const N: usize> Default for Traversal<N> {
    fn default() -> Self {
        Self { stack: Stack::new(Visit { node: HostAddr(0), intervals: Intervals::EMPTY }) }
    }
}

impl<const N: usize> Traversal<N> {
    /// Leads `packet` through the tree and returns what its rays hit (KD-4).
    ///
    /// Each node is read once for all rays that meet its cell. Of two children, the packet goes
    /// first to the one that its first ray there meets first (Assumed); the result does not
    /// depend on it.
    ///
    /// # Panics
    /// If the tree in memory is deeper than [`MAX_DEPTH`]: no valid one is (KD-2).
    pub fn run(
        &mut self,
        memory: &mut Observed<impl Memory, impl Observer>,
        registers: &Registers,
        packet: &Packet<N>,
        query: Query,
    ) -> Hits<N> {
        let mut hits = Hits::none(packet);
        let reciprocal = reciprocals(registers, packet);
        let intervals = clip_to_bounds(registers, packet, &reciprocal);
        self.stack.begin(Visit { node: registers.root, intervals });
        while let Some(mut at) = self.stack.resume() {
            at.intervals.clip(&hits.t);
            if !at.intervals.any() {
                continue;
            }
            let (list, count) = loop {
                memory.operation(Unit::Traversal, at.intervals.count());
                match NodeRecord::decode(memory.fetch(Unit::Traversal, at.node)) {
                    NodeRecord::Inner { axis, split, below } => {
                        self.descend(packet, &reciprocal, &mut at, axis, split, below);
                    }
                    NodeRecord::Leaf { list, count } => break (list, count),
                }
            };
            for entry in 0..count {
                memory.operation(Unit::List, at.intervals.count());
                let entry = memory.fetch(Unit::List, list.offset(entry * LIST_ENTRY_BYTES));
                let ListEntry { triangle, tag } = ListEntry::decode(entry);
                memory.operation(Unit::Intersection, at.intervals.count());
                Prepared::decode(registers.kernel, tag, memory.fetch(Unit::Intersection, triangle))
                    .intersect_packet(
                        triangle.0,
                        packet,
                        (&at.intervals.enter, &at.intervals.leave),
                        query,
                        &mut hits,
                    );
            }
        }
        hits
    }

    /// One step at an inner node: goes `at` the child that is next, and puts the other off if any
    /// ray meets it.
    #[inline]
    fn descend(
        &mut self,
        packet: &Packet<N>,
        reciprocal: &Reciprocals<N>,
        at: &mut Visit<N>,
        axis: Axis,
        split: f32,
        below: HostAddr,
    ) {
        let axis = axis as usize;
        let (origin, reciprocal) = (&packet.origin[axis], &reciprocal[axis]);
        let cell = &at.intervals;
        let mut low = Visit { node: below, intervals: *cell };
        let mut high = Visit { node: below.offset(NODE_BYTES), intervals: *cell };
        for lane in 0..N {
            let t = widen((split - origin[lane]) * reciprocal[lane]);
            let [in_low, in_high] =
                visit(cell.enter[lane], cell.leave[lane], t, is_downwards(reciprocal[lane]));
            (low.intervals.enter[lane], low.intervals.leave[lane]) = in_low;
            (high.intervals.enter[lane], high.intervals.leave[lane]) = in_high;
        }
        let visited = Children::met(low.intervals.any(), high.intervals.any(), || {
            cell.first().is_some_and(|lane| is_downwards(reciprocal[lane]))
        });
        *at = if self.stack.descend(visited, low, high) { high } else { low };
    }
}

/// The reciprocals of the rays' directions, for planes in the box around the scene. Planes outside
/// of it may be met at greater distances than there are, but nothing lies behind them.
fn reciprocals<const N: usize>(registers: &Registers, packet: &Packet<N>) -> Reciprocals<N> {
    std::array::from_fn(|axis| {
        let (low, high) = (registers.bounds.min[axis], registers.bounds.max[axis]);
        std::array::from_fn(|lane| {
            let origin = packet.origin[axis][lane];
            let reach = max((low - origin).abs(), (high - origin).abs());
            reciprocal(packet.direction[axis][lane], reach)
        })
    })
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
    fn rays_that_meet_the_cell_are_counted() {
        // Inside, in one point, not at all, and inside once more.
        let intervals = Intervals { enter: [0.0, 2.0, 3.0, 1.0], leave: [1.0, 2.0, 1.0, 4.0] };
        assert_eq!((intervals.count(), intervals.any(), intervals.first()), (3, true, Some(0)));
        assert_eq!((Intervals::<4>::EMPTY.count(), Intervals::<4>::EMPTY.any()), (0, false));
    }

    #[test]
    fn planes_split_the_interval() {
        let [below, above] = visit(1.0, 5.0, widen(3.0), false);
        assert!(below.0 == 1.0 && below.1 >= 3.0 && above.0 <= 3.0 && above.1 == 5.0);
        assert!(below.1 - above.0 < 1e-5);
        assert_eq!(visit(1.0, 5.0, widen(3.0), true), [above, below]);
        let [below, above] = visit(1.0, 5.0, widen(7.0), false);
        assert!(!is_empty(below) && is_empty(above));
        let [below, above] = visit(1.0, 5.0, widen(-7.0), false);
        assert!(is_empty(below) && !is_empty(above));
    }

    #[test]
    fn parallel_rays_stay_on_their_side() {
        // (split - origin) / 0, from below and from above the plane.
        for (zero, downwards) in [(0.0_f32, false), (-0.0, true)] {
            let [below, above] = visit(0.0, 9.0, widen(1.0 / zero), downwards);
            assert!((!is_empty(below), is_empty(above)) == (true, true));
            let [below, above] = visit(0.0, 9.0, widen(-1.0 / zero), downwards);
            assert!((is_empty(below), !is_empty(above)) == (true, true));
        }
    }

    #[test]
    fn rays_in_the_plane_go_to_both_sides() {
        assert_eq!(visit(0.0, 9.0, widen(f32::NAN), false), [(0.0, 9.0); 2]);
        assert_eq!(visit(0.0, 9.0, widen(f32::NAN), true), [(0.0, 9.0); 2]);
    }

    #[test]
    fn planes_are_widened_by_their_rounding_error() {
        let unit = 2.0_f64.powi(-24);
        let gamma = 3.0 * unit / (1.0 - 3.0 * unit);
        assert_eq!(WIDENING, (2.0 * gamma) as f32);
        assert_eq!(widen(2.0), (2.0 * (1.0 - WIDENING), 2.0 * (1.0 + WIDENING)));
        assert_eq!(widen(-2.0), (-2.0 * (1.0 + WIDENING), -2.0 * (1.0 - WIDENING)));
        // Among the least numbers by two of them.
        assert_eq!(widen(f32::from_bits(9)), (f32::from_bits(7), f32::from_bits(11)));
        assert_eq!(widen(0.0), (-f32::from_bits(2), f32::from_bits(2)));
    }

    #[test]
    fn distances_that_would_not_be_bounded_are_nan() {
        let least = 2.0_f32.powi(-130);
        assert!(reciprocal(least, 1.0).is_nan() && reciprocal(-least, 0.0).is_nan());
        assert!(reciprocal(2.0_f32.powi(127), 1.0).is_nan());
        assert!(reciprocal(2.0_f32.powi(-120), 2.0_f32.powi(8)).is_nan());
        assert!(reciprocal(1.0, f32::INFINITY).is_nan() && reciprocal(f32::NAN, 1.0).is_nan());
        assert_eq!(reciprocal(2.0_f32.powi(-120), 2.0_f32.powi(7)), 2.0_f32.powi(120));
        assert_eq!((reciprocal(0.0, 0.0), reciprocal(-0.0, 9.0)), (f32::INFINITY, f32::NEG_INFINITY));
        assert_eq!((reciprocal(4.0, 1.0), reciprocal(-4.0, 1.0)), (0.25, -0.25));
    }

    #[test]
    fn minus_zero_is_downwards() {
        assert!(is_downwards(1.0 / -0.0) && !is_downwards(1.0 / 0.0));
        assert!(!is_downwards(1.0 / f32::INFINITY));
    }
}
