//! Grows the tree: cells are cut, by all threads where they are large, until they are leaves.

use super::SplitRule;
use super::plane::{Plane, spatial_median};
use super::reference::Reference;
use super::surface_area::{Costs, End, surface_area};
use saarcor_model::host::{Aabb, Axis, KdTree, Node, Triangle};
use std::sync::Mutex;

/// Cells of at most this many references are left to one thread.
const ONE_THREAD: usize = 1 << 12;

/// What an inner node is before its cell is known, and what an empty leaf is.
pub(super) const EMPTY_LEAF: Node = Node::Leaf { first: 0, count: 0 };

/// What all cells share.
pub(super) struct Builder<'a> {
    pub triangles: &'a [Triangle],
    pub rule: SplitRule,
    pub costs: Costs,
    pub max_leaf: usize,
    pub progress: Progress<'a>,
}

/// A cell to be cut.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub bounds: Aabb,
    pub limits: Limits,
}

/// What the subtree of a cell may use up.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Levels below the cell.
    pub depth: u32,
    /// References in all of its leaves.
    pub references: u64,
    /// The cell's part of the progress.
    pub progress: u64,
}

impl Cell {
    /// The cells below and above the plane, which hold that many references. What the parent may
    /// use is shared out in proportion to them.
    fn halves(&self, plane: &Plane, counts: [usize; 2]) -> [Self; 2] {
        let [below, above] = counts.map(|count| count as u64);
        let spare = self.limits.references - (below + above);
        let share =
            |of: u64| (u128::from(of) * u128::from(below) / u128::from((below + above).max(1))) as u64;
        let limits = |references, progress| Limits { depth: self.limits.depth - 1, references, progress };
        let (spare_below, progress_below) = (share(spare), share(self.limits.progress));
        let (bounds_below, bounds_above) = plane.halves(&self.bounds);
        [
            Self { bounds: bounds_below, limits: limits(below + spare_below, progress_below) },
            Self {
                bounds: bounds_above,
                limits: limits(above + (spare - spare_below), self.limits.progress - progress_below),
            },
        ]
    }
}

/// A finished part of the tree.
pub(super) enum Subtree {
    /// What one thread made: the root, and behind it all other nodes, with indices into the two.
    Grown { nodes: Vec<Node>, refs: Vec<u32> },
    /// A node whose children may be made by different threads.
    Cut { axis: Axis, split: f32, children: Box<[Subtree; 2]> },
}

impl Subtree {
    /// The number of nodes and references.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Grown { nodes, refs } => (nodes.len(), refs.len()),
            Self::Cut { children, .. } => {
                let [below, above] = [0, 1].map(|side| children[side].size());
                (1 + below.0 + above.0, below.1 + above.1)
            }
        }
    }

    /// Appends the subtree to `tree`, its root in the place of the node `root`.
    pub fn append_to(self, tree: &mut KdTree, root: usize) {
        match self {
            Self::Grown { nodes, refs } => {
                let (node_base, ref_base) = (index(tree.nodes.len()), index(tree.refs.len()));
                let mut nodes = nodes.into_iter().map(|node| match node {
                    Node::Inner { axis, split, children } => {
                        Node::Inner { axis, split, children: children - 1 + node_base }
                    }
                    Node::Leaf { count: 0, .. } => EMPTY_LEAF,
                    Node::Leaf { first, count } => Node::Leaf { first: first + ref_base, count },
                });
                tree.nodes[root] = nodes.next().expect("a subtree has a root");
                tree.nodes.extend(nodes);
                tree.refs.extend(refs);
            }
            Self::Cut { axis, split, children } => {
                let pair = tree.nodes.len();
                tree.nodes[root] = Node::Inner { axis, split, children: index(pair) };
                tree.nodes.extend([EMPTY_LEAF; 2]);
                let [below, above] = *children;
                below.append_to(tree, pair);
                above.append_to(tree, pair + 1);
            }
        }
    }
}

/// A position in the nodes or references as the tree stores it.
fn index(position: usize) -> u32 {
    u32::try_from(position).expect("a kd-tree has less than 2^32 nodes and references")
}

impl Builder<'_> {
    /// Builds the subtree of a cell.
    pub fn build(&self, mut references: Vec<Reference>, cell: Cell) -> Subtree {
        if references.len() > ONE_THREAD
            && let Some(plane) = self.plane(&cell, &references, &mut Vec::new())
        {
            let mut below = Vec::with_capacity(plane.counts[0]);
            self.cut(&mut references, 0, &plane, &mut below);
            references.shrink_to_fit();
            let above = references;
            let [cell_below, cell_above] = cell.halves(&plane, [below.len(), above.len()]);
            let children = rayon::join(|| self.build(below, cell_below), || self.build(above, cell_above));
            return Subtree::Cut { axis: plane.axis, split: plane.at, children: Box::new(children.into()) };
        }
        let mut growth = Growth { references, ..Growth::default() };
        growth.nodes.push(EMPTY_LEAF);
        self.grow(&mut growth, 0, 0, cell);
        self.progress.add(cell.limits.progress);
        Subtree::Grown { nodes: growth.nodes, refs: growth.refs }
    }

    /// Chooses the plane that cuts a cell; `None` makes it a leaf.
    fn plane(&self, cell: &Cell, references: &[Reference], ends: &mut Vec<End>) -> Option<Plane> {
        if references.len() <= self.max_leaf || cell.limits.depth == 0 {
            return None;
        }
        let plane = match self.rule {
            SplitRule::SurfaceArea => surface_area(&cell.bounds, references, &self.costs, ends),
            SplitRule::SpatialMedian => {
                let boxes = references.iter().map(|reference| &reference.bounds);
                spatial_median(&cell.bounds, boxes)
            }
        }?;
        let affordable = plane.counts[0] as u64 + plane.counts[1] as u64 <= cell.limits.references;
        affordable.then_some(plane)
    }

    /// Cuts `references[start..]`: what is above stays there, what is below goes to `below`, both
    /// in their order.
    fn cut(&self, references: &mut Vec<Reference>, start: usize, plane: &Plane, below: &mut Vec<Reference>) {
        let mut end = start;
        for read in start..references.len() {
            let (part_below, part_above) = references[read].cut(plane, self.triangles);
            below.extend(part_below);
            if let Some(part) = part_above {
                references[end] = part;
                end += 1;
            }
        }
        references.truncate(end);
    }

    /// Grows the subtree of a cell whose references are the last ones of `growth`, from `start`
    /// on, with its root in the place of the node `root`; takes those references away.
    fn grow(&self, growth: &mut Growth, root: usize, start: usize, cell: Cell) {
        let Some(plane) = self.plane(&cell, &growth.references[start..], &mut growth.ends) else {
            let leaf = growth.references.drain(start..);
            if leaf.len() > 0 {
                let (first, count) = (index(growth.refs.len()), index(leaf.len()));
                growth.nodes[root] = Node::Leaf { first, count };
                growth.refs.extend(leaf.map(|reference| reference.triangle));
            }
            return;
        };
        self.cut(&mut growth.references, start, &plane, &mut growth.below);
        let middle = growth.references.len();
        let counts = [growth.below.len(), middle - start];
        growth.references.append(&mut growth.below);

        let children = growth.nodes.len();
        growth.nodes[root] = Node::Inner { axis: plane.axis, split: plane.at, children: index(children) };
        growth.nodes.extend([EMPTY_LEAF; 2]);
        let [cell_below, cell_above] = cell.halves(&plane, counts);
        self.grow(growth, children, middle, cell_below);
        self.grow(growth, children + 1, start, cell_above);
    }
}

/// A subtree that one thread grows, depth first.
#[derive(Default)]
struct Growth {
    nodes: Vec<Node>,
    refs: Vec<u32>,
    /// A stack of the references of the cells that wait: the next cell's are the last.
    references: Vec<Reference>,
    /// Working memory: the references below the plane, while a cell is cut.
    below: Vec<Reference>,
    /// Working memory of the surface area heuristic.
    ends: Vec<End>,
}

/// Reports to the caller how much is done.
pub(super) struct Progress<'a> {
    done: Mutex<u64>,
    report: &'a (dyn Fn(f64) + Sync),
}

impl<'a> Progress<'a> {
    /// All of the work. A power of two, so that the parts of the cells add up to exactly 1.
    pub const WHOLE: u64 = 1 << 40;

    pub fn new(report: &'a (dyn Fn(f64) + Sync)) -> Self {
        Self { done: Mutex::new(0), report }
    }

    /// Adds to what is done, and reports it. The lock keeps reports ascending.
    fn add(&self, part: u64) {
        let mut done = self.done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *done += part;
        (self.report)(*done as f64 / Self::WHOLE as f64);
    }
}
