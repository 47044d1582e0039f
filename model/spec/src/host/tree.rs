//! The kd-tree: what a valid one is (§2: a kd-tree whose leaves hold lists of triangle addresses,
//! Stated). How it is built is not the chip's concern.

use glam::Vec3;
use thiserror::Error;

/// Most inner nodes on a path from the root to a leaf: entries of the traversal unit's stack
/// (Assumed).
pub const MAX_DEPTH: usize = 64;

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Axis {
    /// The first coordinate.
    X = 0,
    /// The second coordinate.
    Y = 1,
    /// The third coordinate.
    Z = 2,
}

impl Axis {
    /// The axes in the order of the coordinates.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// The axis of the greatest of three magnitudes, of several the first.
    pub fn of_greatest<R: PartialOrd>([x, y, z]: [R; 3]) -> Self {
        if x >= y && x >= z {
            Self::X
        } else if y >= z {
            Self::Y
        } else {
            Self::Z
        }
    }
}

/// A closed box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The least box around `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The least box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

/// A node of a kd-tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Node {
    /// Space is cut at `split` along `axis`: the child below at index `children`, the one above at
    /// `children + 1`.
    Inner {
        /// The axis that the split plane is perpendicular to.
        axis: Axis,
        /// Coordinate of the split plane.
        split: f32,
        /// Index of the child below the plane; the one above follows it.
        children: u32,
    },
    /// The triangles `refs[first .. first + count]` meet this leaf's cell.
    Leaf {
        /// Index into [`KdTree::refs`].
        first: u32,
        /// Number of triangles.
        count: u32,
    },
}

/// A kd-tree over the triangles of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct KdTree {
    /// A box around all triangles.
    pub bounds: Aabb,
    /// The nodes; the root is the first.
    pub nodes: Vec<Node>,
    /// Triangle indices, leaf by leaf.
    pub refs: Vec<u32>,
}

/// What is wrong with a kd-tree.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum KdTreeError {
    /// There is no root.
    #[error("kd-tree without a root node")]
    NoNodes,
    /// The box is not finite, or its corners are in the wrong order.
    #[error("kd-tree in the box {} .. {}: it must be finite", .0.min, .0.max)]
    Bounds(Aabb),
    /// A split plane is not at a finite coordinate.
    #[error("kd-node {node}: the split plane must be finite")]
    Split {
        /// The node's index.
        node: u32,
    },
    /// Children lie outside of the tree, or before their parent.
    #[error("kd-node {node}: children at {children}: they must follow their parent inside the tree")]
    Children {
        /// The parent's index.
        node: u32,
        /// Index of its first child.
        children: u32,
    },
    /// A node is no child of any, or of more than one.
    #[error("kd-node {node}: each node but the root must have one parent")]
    Parents {
        /// The node's index.
        node: u32,
    },
    /// A leaf's list lies outside of [`KdTree::refs`].
    #[error("kd-leaf {node}: its list lies outside of the lists")]
    List {
        /// The leaf's index.
        node: u32,
    },
    /// A list names a triangle that the scene does not have.
    #[error("list entry {place}: the scene has no triangle {triangle}")]
    Triangle {
        /// Place in [`KdTree::refs`].
        place: u32,
        /// The triangle's index.
        triangle: u32,
    },
    /// An inner node has [`MAX_DEPTH`] inner nodes above it.
    #[error("kd-node {node}: deeper than {MAX_DEPTH}")]
    Depth {
        /// The node's index.
        node: u32,
    },
}

impl KdTree {
    /// Whether the chip may be given this tree over `triangles` triangles (KD-2): a traversal of
    /// it ends, stays inside it, and needs no more stack than there is.
    ///
    /// # Errors
    /// The first fault found.
    pub fn check(&self, triangles: usize) -> Result<(), KdTreeError> {
        let Aabb { min, max } = self.bounds;
        if !min.is_finite() || !max.is_finite() || !min.cmple(max).all() {
            return Err(KdTreeError::Bounds(self.bounds));
        }
        check_nodes(&self.nodes, self.refs.len(), MAX_DEPTH)?;
        match self.refs.iter().position(|&triangle| triangle as usize >= triangles) {
            Some(place) => Err(KdTreeError::Triangle { place: place as u32, triangle: self.refs[place] }),
            None => Ok(()),
        }
    }
}

/// Whether `nodes` are a tree, the root first, over lists of `refs` entries together, with at most
/// `deepest` inner nodes on a path (KD-2).
///
/// Parents come before their children, so one pass meets every node after its parent, and no cycle
/// can be closed.
///
/// # Errors
/// The first fault found.
///
/// # Panics
/// If `deepest` is more than 254.
pub fn check_nodes(nodes: &[Node], refs: usize, deepest: usize) -> Result<(), KdTreeError> {
    if nodes.is_empty() {
        return Err(KdTreeError::NoNodes);
    }
    // The level of each node, from 1 at the root on; 0 where no parent was met yet.
    let mut levels = vec![0_u8; nodes.len()];
    levels[0] = 1;
    for (node, &record) in (0_u32..).zip(nodes) {
        let level = levels[node as usize];
        if level == 0 {
            return Err(KdTreeError::Parents { node });
        }
        match record {
            Node::Inner { split, children, .. } => {
                if !split.is_finite() {
                    return Err(KdTreeError::Split { node });
                }
                if usize::from(level) > deepest {
                    return Err(KdTreeError::Depth { node });
                }
                let first = children as usize;
                if children <= node || first >= nodes.len() - 1 {
                    return Err(KdTreeError::Children { node, children });
                }
                for child in [first, first + 1] {
                    if levels[child] != 0 {
                        return Err(KdTreeError::Parents { node: child as u32 });
                    }
                    levels[child] = level + 1;
                }
            }
            Node::Leaf { first, count } => {
                if u64::from(first) + u64::from(count) > refs as u64 {
                    return Err(KdTreeError::List { node });
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(nodes: Vec<Node>) -> KdTree {
        KdTree { bounds: Aabb { min: Vec3::ZERO, max: Vec3::ONE }, nodes, refs: vec![0, 1] }
    }

    fn inner(children: u32) -> Node {
        Node::Inner { axis: Axis::X, split: 0.5, children }
    }

    const LEAF: Node = Node::Leaf { first: 0, count: 2 };

    #[test]
    fn accepts_trees() {
        assert_eq!(tree(vec![LEAF]).check(2), Ok(()));
        assert_eq!(tree(vec![inner(1), inner(3), LEAF, LEAF, LEAF]).check(2), Ok(()));
    }

    #[test]
    fn rejects_what_is_no_tree() {
        let faults = [
            (tree(vec![]), KdTreeError::NoNodes),
            (tree(vec![inner(0), LEAF]), KdTreeError::Children { node: 0, children: 0 }),
            (tree(vec![inner(1), LEAF]), KdTreeError::Children { node: 0, children: 1 }),
            (tree(vec![inner(1), inner(2), LEAF, LEAF]), KdTreeError::Parents { node: 2 }),
            (tree(vec![inner(2), LEAF, LEAF, LEAF]), KdTreeError::Parents { node: 1 }),
            (tree(vec![Node::Leaf { first: 1, count: 2 }]), KdTreeError::List { node: 0 }),
            (
                tree(vec![Node::Inner { axis: Axis::Y, split: f32::NAN, children: 1 }, LEAF, LEAF]),
                KdTreeError::Split { node: 0 },
            ),
        ];
        for (tree, fault) in faults {
            assert_eq!(tree.check(2), Err(fault), "{tree:?}");
        }
        assert_eq!(tree(vec![LEAF]).check(1), Err(KdTreeError::Triangle { place: 1, triangle: 1 }));
    }

    #[test]
    fn rejects_boxes_that_are_none() {
        let in_box = |min, max| KdTree { bounds: Aabb { min, max }, ..tree(vec![LEAF]) };
        assert_eq!(in_box(Vec3::ZERO, Vec3::ZERO).check(2), Ok(()));
        let (low, high) = (Vec3::new(0.0, f32::NEG_INFINITY, 0.0), Vec3::new(1.0, 1.0, f32::INFINITY));
        for (min, max) in
            [(low, Vec3::ONE), (Vec3::ZERO, high), (Vec3::Y, Vec3::ONE - Vec3::Y), (Vec3::NAN, Vec3::ONE)]
        {
            assert!(matches!(in_box(min, max).check(2), Err(KdTreeError::Bounds(_))), "{min} {max}");
        }
    }

    #[test]
    fn faults_are_named() {
        let fault = tree(vec![inner(1), LEAF]).check(2).expect_err("no second child");
        assert_eq!(
            fault.to_string(),
            "kd-node 0: children at 1: they must follow their parent inside the tree"
        );
    }

    #[test]
    fn rejects_trees_deeper_than_the_stack() {
        let chain = |depth: u32| {
            // Each inner node is the second child of the one before.
            let deeper = (1..depth).flat_map(|level| [LEAF, inner(2 * level + 1)]);
            tree([inner(1)].into_iter().chain(deeper).chain([LEAF, LEAF]).collect())
        };
        assert_eq!(chain(MAX_DEPTH as u32).check(2), Ok(()));
        assert!(matches!(chain(MAX_DEPTH as u32 + 1).check(2), Err(KdTreeError::Depth { .. })));
    }
}
