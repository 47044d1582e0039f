//! Theorems of the kd-tree (KD-2): which trees the chip may be given.

use super::PLANES;
use crate::draw::{self, BYTES, ENDS, WORDS};
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::host::{Aabb, Axis, KdTree, Node, check_nodes};
use saarcor_model::rays::{Children, Stack};

/// Nodes of the trees: the least number at which inner nodes are siblings, parent and child, and
/// parent of siblings, and at which a pair of children can be shared whole, by half, or be beside
/// the end. Of what is before a node, `check_nodes` sees no more than one number a node.
const NODES: usize = 5;

/// A leaf without triangles.
const LEAF: Node = Node::Leaf { first: 0, count: 0 };

/// Inner nodes on a path: few, around 64, and around the 8 bits in which levels are counted.
static DEPTHS: [u32; 12] = [0, 1, 2, 3, 16, 32, 62, 63, 64, 65, 66, 90];

/// Bits of corners of a box: numbers in ascending order, infinities and NaN.
static CORNERS: [u32; 9] =
    [0xff80_0000, 0xff7f_ffff, 0x8000_0001, 0x8000_0000, 0, 1, 0x7f7f_ffff, 0x7f80_0000, 0x7fc0_0000];

/// Entries of lists, around 2^16.
static ENTRIES: [u32; 7] = [0, 1, 2, 0xfffe, 0xffff, 0x1_0000, 0x1_0001];

/// Five nodes, each a leaf or an inner node with children anywhere, in small scopes at some of
/// `places`.
fn nodes(s: &mut impl Source, places: &'static [u32]) -> [Node; NODES] {
    s.size("nodes", NODES);
    let mut nodes = [LEAF; NODES];
    for node in &mut nodes {
        if draw::flag(s, "is an inner node") {
            let children = s.value("children", 0..=u32::MAX, places);
            *node = Node::Inner { axis: Axis::X, split: 0.5, children };
        }
    }
    nodes
}

/// Whether node `parent` names node `child` as one of its two children.
fn is_parent(parent: Node, child: usize) -> bool {
    match parent {
        Node::Inner { children, .. } => children as usize == child || u64::from(children) + 1 == child as u64,
        Node::Leaf { .. } => false,
    }
}

/// The definition of KD-2, node by node: children that follow their parent inside the tree, and one
/// parent each. Of a tree, the greatest number of inner nodes on a path; of what is none, nothing.
fn depth_of_tree(nodes: &[Node; NODES]) -> Option<usize> {
    let mut is_tree = true;
    // Inner nodes from the root to each node, itself not included.
    let mut above = [0; NODES];
    for child in 0..NODES {
        let mut parents = 0;
        for parent in 0..NODES {
            if is_parent(nodes[parent], child) {
                is_tree &= parent < child;
                parents += 1;
                above[child] = above[parent] + 1;
            }
        }
        is_tree &= parents == usize::from(child > 0);
    }
    let mut depth = 0;
    for node in 0..NODES {
        if let Node::Inner { children, .. } = nodes[node] {
            is_tree &= u64::from(children) + 1 < NODES as u64;
        }
        depth = if above[node] > depth { above[node] } else { depth };
    }
    is_tree.then_some(depth)
}

theorems! {
    /// A tree is accepted exactly if the children of each node follow it inside the tree, each node
    /// but the root has one parent, and no path has more inner nodes than the stack has room for.
    #["KD-2", unwind 7, covers ["accepted", "too deep", "two parents", "no parent", "outside", "before their parent"]]
    fn accepted_is_exactly_what_is_a_tree(s) {
        // Children may begin at each node, and those of the last place end outside.
        let nodes = nodes(s, &WORDS[..=NODES]);
        let deepest = usize::from(s.value("room of the stack", 0..=3, &BYTES[..4]));
        let depth = depth_of_tree(&nodes);
        let legal = depth.is_some_and(|depth| depth <= deepest);
        let result = check_nodes(&nodes, 0, deepest);
        let parents = |child: usize| {
            let mut parents = 0;
            for parent in nodes {
                parents += usize::from(is_parent(parent, child));
            }
            parents
        };
        cover!(s, "accepted", legal);
        cover!(s, "too deep", depth.is_some_and(|depth| depth > deepest));
        cover!(s, "two parents", parents(2) == 2);
        cover!(s, "no parent", parents(1) == 0);
        cover!(s, "outside", is_parent(nodes[0], NODES));
        cover!(s, "before their parent", is_parent(nodes[2], 1));
        check_eq!(result.is_ok(), legal, "{nodes:?}, stack of {deepest}: {result:?}");
    }

    /// Every traversal of an accepted tree ends: it visits each node at most once, and its stack never
    /// overflows.
    #["KD-2", unwind 6, covers ["all five nodes", "one child at each node", "both inner nodes on a path"]]
    fn traversal_of_an_accepted_tree_ends(s) {
        // Five nodes are a tree only if their pairs of children begin at 1 and at 3.
        let nodes = nodes(s, &[1, 3]);
        assume!(check_nodes(&nodes, 0, 2).is_ok());
        let mut stack = Stack::<u32, 2>::new(u32::MAX);
        stack.begin(0);
        let mut at = stack.resume();
        let mut met = [false; NODES];
        let (mut steps, mut both, mut chain) = (0, false, true);
        for _ in 0..NODES {
            if let Some(node) = at {
                check!((node as usize) < NODES, "node {node} of {nodes:?}");
                check!(!met[node as usize], "node {node} of {nodes:?} again");
                met[node as usize] = true;
                steps += 1;
                at = match nodes[node as usize] {
                    Node::Inner { children, .. } => {
                        let visited = match s.value("visited (below, above, both)", 0..=2, &BYTES[..3]) {
                            0 => Children::Below,
                            1 => Children::Above,
                            _ => Children::BelowFirst,
                        };
                        both |= visited == Children::BelowFirst;
                        Some(children + u32::from(stack.descend(visited, &children, &(children + 1))))
                    }
                    Node::Leaf { .. } => {
                        chain &= steps == 3;
                        stack.resume()
                    }
                };
            }
        }
        cover!(s, "all five nodes", steps == NODES);
        cover!(s, "one child at each node", !both);
        cover!(s, "both inner nodes on a path", chain && steps == 3);
        check_eq!(at, None, "the traversal of {nodes:?} goes on after {steps} steps");
    }

    /// A tree is accepted only if its split planes are finite.
    #["KD-2", unwind 4, covers ["finite", "infinite", "NaN"]]
    fn accepted_planes_are_finite(s) {
        // One inner node: each is looked at by itself.
        let split = f32::from_bits(s.value("bits of the split plane", 0..=u32::MAX, &PLANES));
        let axis = Axis::ALL[usize::from(s.value("axis", 0..=2, &BYTES[..3]))];
        cover!(s, "finite", split.is_finite());
        cover!(s, "infinite", split.is_infinite());
        cover!(s, "NaN", split.is_nan());
        let nodes = [Node::Inner { axis, split, children: 1 }, LEAF, LEAF];
        let result = check_nodes(&nodes, 0, 1);
        check_eq!(result.is_ok(), split.is_finite(), "plane at {split}: {result:?}");
    }

    /// A tree is accepted only if the list of each leaf lies within the lists of the scene, even if its
    /// end needs more than 32 bits.
    #["KD-2", unwind 5, covers ["up to the end", "beyond the end", "no entry", "beyond 32 bits"]]
    fn accepted_lists_lie_inside_the_lists(s) {
        // Two leaves of which either may be at fault: each is looked at by itself.
        let (first, count) = (s.value("first", 0..=u32::MAX, &ENDS), s.value("count", 0..=u32::MAX, &ENDS));
        let refs = s.value("entries of all lists", 0..=u32::MAX, &ENDS);
        let above = draw::flag(s, "is the leaf above");
        let end = u64::from(first) + u64::from(count);
        cover!(s, "up to the end", end == u64::from(refs) && count > 0);
        cover!(s, "beyond the end", end == u64::from(refs) + 1);
        cover!(s, "no entry", count == 0);
        cover!(s, "beyond 32 bits", end > u64::from(u32::MAX));
        let leaf = Node::Leaf { first, count };
        let (below, above) = if above { (LEAF, leaf) } else { (leaf, LEAF) };
        let nodes = [Node::Inner { axis: Axis::Y, split: 0.0, children: 1 }, below, above];
        let result = check_nodes(&nodes, refs as usize, 1);
        check_eq!(result.is_ok(), end <= u64::from(refs), "{leaf:?} of {refs} entries: {result:?}");
    }

    /// The chip may be given a tree with 64 inner nodes on a path, and no tree with 65, whichever child goes
    /// on at each node.
    #["KD-2", not_for_kani "a path of 64 nodes is too long a loop", covers ["64 inner nodes", "65 inner nodes", "more", "few"]]
    fn paths_have_up_to_64_inner_nodes(s) {
        let depth = s.value("inner nodes on the path", 0..=90, &DEPTHS);
        let turns = s.value("which child goes on", 0..=u64::MAX, &[0, u64::MAX, 0x9e37_79b9_7f4a_7c15]);
        cover!(s, "64 inner nodes", depth == 64);
        cover!(s, "65 inner nodes", depth == 65);
        cover!(s, "more", depth > 65);
        cover!(s, "few", depth < 60);
        let mut nodes = vec![LEAF; 2 * depth as usize + 1];
        let mut at = 0;
        for level in 0..depth {
            let children = 2 * level + 1;
            nodes[at] = Node::Inner { axis: Axis::Z, split: 0.0, children };
            at = (children + (turns >> (level % 64) & 1) as u32) as usize;
        }
        let bounds = Aabb { min: [0.0; 3].into(), max: [1.0; 3].into() };
        let result = KdTree { bounds, nodes, refs: Vec::new() }.check(0);
        check_eq!(result.is_ok(), depth <= 64, "{depth} inner nodes on a path: {result:?}");
    }

    /// The box around the scene is accepted exactly if all its coordinates are finite and none of the least
    /// corner is greater than that of the greatest, even by the least step.
    #["KD-2", not_for_kani "it allocates", covers ["accepted", "infinite", "NaN", "in the wrong order", "flat"]]
    fn accepted_boxes_are_finite_and_in_order(s) {
        let axis = s.value("axis", 0..=2, &BYTES[..3]) as usize;
        let (low, high) = (s.value("bits of the least", 0..=u32::MAX, &CORNERS), s.value("bits of the greatest", 0..=u32::MAX, &CORNERS));
        let (low, high) = (f32::from_bits(low), f32::from_bits(high));
        cover!(s, "accepted", low.is_finite() && low < high && high.is_finite());
        cover!(s, "infinite", low.is_infinite() || high.is_infinite());
        cover!(s, "NaN", low.is_nan() || high.is_nan());
        cover!(s, "in the wrong order", low > high);
        cover!(s, "flat", low == high);
        let (mut min, mut max) = ([0.0; 3], [1.0; 3]);
        (min[axis], max[axis]) = (low, high);
        let bounds = Aabb { min: min.into(), max: max.into() };
        let result = KdTree { bounds, nodes: vec![LEAF], refs: Vec::new() }.check(0);
        check_eq!(result.is_ok(), low.is_finite() && high.is_finite() && low <= high, "{bounds:?}: {result:?}");
    }

    /// A tree is accepted only if each entry of its lists, also the last and one that no leaf names, is a
    /// triangle of the scene.
    #["KD-2", not_for_kani "it allocates", covers ["no triangles", "the last triangle", "one behind the last", "the last entry"]]
    fn accepted_entries_are_triangles_of_the_scene(s) {
        let entries = s.value("entries", 0..=70_000, &ENTRIES);
        let triangles = s.value("triangles", 0..=u32::MAX, &ENDS);
        let at = s.value("an entry", 0..=70_000, &ENTRIES);
        let triangle = s.value("its triangle", 0..=u32::MAX, &ENDS);
        assume!(at < entries);
        cover!(s, "no triangles", triangles == 0);
        cover!(s, "the last triangle", triangles > 0 && triangle == triangles - 1);
        cover!(s, "one behind the last", triangle == triangles);
        cover!(s, "the last entry", at + 1 == entries && entries > 1);
        let mut refs = vec![0; entries as usize];
        refs[at as usize] = triangle;
        let bounds = Aabb { min: [0.0; 3].into(), max: [1.0; 3].into() };
        let result = KdTree { bounds, nodes: vec![LEAF], refs }.check(triangles as usize);
        // The other entries name triangle 0.
        let legal = triangle < triangles;
        check_eq!(result.is_ok(), legal, "entry {at} of {entries} is triangle {triangle} of {triangles}: {result:?}");
    }
}
