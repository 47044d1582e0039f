//! The traversal unit: a stack machine that leads packets through the kd-tree (§2).

use super::intersection::{Intersection, IntersectionUnit, StoredTriangle};
use super::interval::{Intervals, is_downwards, max, min, reciprocal, visit, widen};
use super::ray::{Hits, Packet, Query};
use crate::host::{
    Axis, LIST_ENTRY_BYTES, ListEntry, MAX_DEPTH, NODE_BYTES, NodeRecord, Registers, TriangleRecord,
};
use crate::vm::{HostAddr, Memory, Observed, Observer, Unit};

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
    pub fn new(unused: T) -> Self {
        Self { put_off: [unused; DEPTH], len: 0 }
    }

    /// A walk begins at `root`, to which [`Stack::resume`] leads first.
    pub fn begin(&mut self, root: T) {
        self.len = 0;
        self.put_off(root);
    }

    /// One step at an inner node with the children `below` and `above`: puts one off if both are
    /// visited, and returns whether the one above is next.
    ///
    /// # Panics
    /// If more than `DEPTH` children are put off: no walk of a valid tree does (KD-2).
    pub fn descend(&mut self, visited: Children, below: &T, above: &T) -> bool {
        match visited {
            Children::Below => false,
            Children::Above => true,
            Children::BelowFirst => {
                self.put_off(*above);
                false
            }
            Children::AboveFirst => {
                self.put_off(*below);
                true
            }
        }
    }

    fn put_off(&mut self, child: T) {
        self.put_off[self.len] = child;
        self.len += 1;
    }

    /// Where to go on after a leaf: to the child put off last. None at the end of the walk.
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

/// What differences of coordinates are multiplied by to give distances, for each axis and ray.
type Reciprocals<const N: usize> = [[f32; N]; 3];

/// The traversal unit for packets of `N` rays, with its stack, and the intersection unit behind it.
#[derive(Clone, Debug)]
pub struct Traversal<const N: usize, I = Intersection<N>> {
    stack: Stack<Visit<N>, MAX_DEPTH>,
    /// The node at hand.
    at: Box<Visit<N>>,
    /// Its children below and above the plane.
    children: [Box<Visit<N>>; 2],
    intersection: I,
}

impl<const N: usize> Default for Traversal<N> {
    fn default() -> Self {
        Self::with(Intersection::default())
    }
}

impl<const N: usize, I: IntersectionUnit<N>> Traversal<N, I> {
    /// A traversal unit in front of another intersection unit than that of this specification.
    pub fn with(intersection: I) -> Self {
        let unused = Visit { node: HostAddr(0), intervals: Intervals::EMPTY };
        let (at, children) = (Box::new(unused), [Box::new(unused), Box::new(unused)]);
        Self { stack: Stack::new(unused), at, children, intersection }
    }

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
        while let Some(next) = self.stack.resume() {
            *self.at = next;
            self.at.intervals.clip(&hits.t);
            if !self.at.intervals.any() {
                continue;
            }
            let (list, count) = loop {
                memory.operation(Unit::Traversal, self.at.intervals.count());
                match NodeRecord::decode(memory.fetch(Unit::Traversal, self.at.node)) {
                    NodeRecord::Inner { axis, split, below } => {
                        self.descend(packet, &reciprocal, axis, split, below);
                    }
                    NodeRecord::Leaf { list, count } => break (list, count),
                }
            };
            for entry in 0..count {
                memory.operation(Unit::List, self.at.intervals.count());
                let entry = memory.fetch(Unit::List, list.offset(entry * LIST_ENTRY_BYTES));
                let ListEntry { triangle: addr, tag } = ListEntry::decode(entry);
                memory.operation(Unit::Intersection, self.at.intervals.count());
                let record = TriangleRecord::decode(memory.fetch(Unit::Intersection, addr), tag);
                let triangle =
                    StoredTriangle { addr, kernel: registers.kernel, edges: registers.edges, record };
                self.intersection.intersect(&triangle, packet, &self.at.intervals, query, &mut hits);
            }
        }
        hits
    }

    /// One step at an inner node: goes to the child that is next, and puts the other off if any ray
    /// meets it.
    fn descend(
        &mut self,
        packet: &Packet<N>,
        reciprocal: &Reciprocals<N>,
        axis: Axis,
        split: f32,
        below: HostAddr,
    ) {
        let axis = axis as usize;
        let (origin, reciprocal) = (&packet.origin[axis], &reciprocal[axis]);
        let Self { stack, at, children: [low, high], .. } = self;
        (low.node, high.node) = (below, below.offset(NODE_BYTES));
        let cell = &at.intervals;
        cut(cell, split, origin, reciprocal, &mut low.intervals, &mut high.intervals);
        let visited = Children::met(low.intervals.any(), high.intervals.any(), || {
            cell.first().is_some_and(|lane| is_downwards(reciprocal[lane]))
        });
        let next = if stack.descend(visited, low, high) { high } else { low };
        std::mem::swap(at, next);
    }
}

/// Cuts the parts of the rays in a `cell` by the plane at `split`: into those `below` and `above` it.
fn cut<const N: usize>(
    cell: &Intervals<N>,
    split: f32,
    origin: &[f32; N],
    reciprocal: &[f32; N],
    below: &mut Intervals<N>,
    above: &mut Intervals<N>,
) {
    for lane in 0..N {
        let t = widen((split - origin[lane]) * reciprocal[lane]);
        let [in_below, in_above] =
            visit(cell.enter[lane], cell.leave[lane], t, is_downwards(reciprocal[lane]));
        (below.enter[lane], below.leave[lane]) = in_below;
        (above.enter[lane], above.leave[lane]) = in_above;
    }
}

/// The reciprocals of the rays' directions, for planes in the box around the scene. The distance of a
/// plane outside of the box may overflow, but nothing lies there.
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
