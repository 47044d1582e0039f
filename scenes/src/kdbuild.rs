//! Builds kd-trees by the surface area heuristic or the spatial median.
//!
//! The tree keeps one promise: **every point of every triangle lies in the closed cell of a leaf
//! that lists the triangle.** A triangle is passed to each side of a split plane on which it has
//! points off the plane; one that only touches the plane from one side stays on that side, and one
//! that lies in the plane goes to one side, which the split names. A traversal is therefore right
//! when it treats cells as closed, that is, when the interval of a ray in a cell is widened by the
//! rounding error of its ends.
//!
//! Splits are *perfect*: a triangle counts with the box around its part inside the cell, not with
//! the part of its box inside the cell, so that it never gets into a cell that it misses.

mod clip;
mod plane;
mod reference;
mod subtree;
mod surface_area;

use reference::Reference;
use saarcor_model::host::{Aabb, KdTree, Node, Triangle};
use subtree::{Builder, Cell, Limits, Progress};
use surface_area::Costs;

use glam::Vec3;
use rayon::prelude::*;

/// The greatest depth of a leaf: a stack traversal holds one entry a level, and the stack of the
/// chip's traversal unit has 64 (Assumed).
pub const MAX_DEPTH: u32 = 60;

/// How the split plane of a cell is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplitRule {
    /// The plane of least expected cost by the surface area heuristic, among all planes that bound
    /// the part of some triangle inside the cell (Wald and Havran, "On building fast kd-trees for
    /// ray tracing, and on doing that in O(N log N)", 2006). A cell is a leaf when no plane
    /// makes it cheaper.
    SurfaceArea,
    /// The middle of the cell's longest side: the simple rule of the paper's time (Assumed; §4
    /// says only that its tree was not the best).
    SpatialMedian,
}

/// What [`build`] is to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// How split planes are chosen.
    pub rule: SplitRule,
    /// A cell that at most this many triangles meet is a leaf.
    pub max_leaf: u32,
    /// Greatest depth of a leaf, the root's being 0, and never more than [`MAX_DEPTH`]. `None`
    /// leaves it to the rule: `1.2 log2 N + 2` for the spatial median (Havran, "Heuristic ray
    /// shooting algorithms", 2000); `1.3 log2 N + 8` for the surface area heuristic (Pharr and
    /// Humphreys, "Physically based rendering", 2004), which spares a fifth of the tree of scenes
    /// with many slivers, and changes the expected cost of a ray by less than 0.1 % (measured).
    pub max_depth: Option<u32>,
    /// Cost of passing an inner node, in the unit of `intersection_cost`.
    pub traversal_cost: f64,
    /// Cost of testing a triangle.
    pub intersection_cost: f64,
    /// Part of the cost, 0 to 1, that a cut is spared when it leaves one side empty.
    pub empty_bonus: f64,
    /// No more than this many references a triangle, on average over the tree (0 counts as 1).
    /// They are shared out to the cells in proportion to their triangles, and a cell is a leaf
    /// when cutting it would exceed its share.
    pub max_refs_per_triangle: u32,
}

impl Default for BuildOptions {
    /// The surface area heuristic, cutting no cell of two triangles (Havran's stop rule).
    ///
    /// The costs are Assumed. They were measured on scenes of 34 000 to 331 000 triangles as those
    /// behind which a greater tree no longer pays: with triangles four times as dear as nodes, the
    /// nodes grow by a half and the references by a quarter, and a ray saves some 3 % of its work.
    fn default() -> Self {
        Self {
            rule: SplitRule::SurfaceArea,
            max_leaf: 2,
            max_depth: None,
            traversal_cost: 1.0,
            intersection_cost: 1.5,
            empty_bonus: 0.1,
            max_refs_per_triangle: 16,
        }
    }
}

impl BuildOptions {
    /// The depth limit for a tree over `triangles` triangles.
    fn depth_limit(&self, triangles: usize) -> u32 {
        let levels = libm::log2(triangles.max(1) as f64);
        let of_rule = match self.rule {
            SplitRule::SurfaceArea => 1.3 * levels + 8.0,
            SplitRule::SpatialMedian => 1.2 * levels + 2.0,
        };
        self.max_depth.unwrap_or(of_rule as u32).min(MAX_DEPTH)
    }
}

/// Builds the kd-tree over `triangles`.
///
/// Triangles that no ray can hit ([`Triangle::is_degenerate`]) and triangles with a corner that is
/// not finite are left out. Without any other triangle the tree is one empty leaf in a box that is
/// the origin.
///
/// * `nodes` are in depth-first order: the pair of a node's children, then all below the first,
///   then all below the second; a subtree is one contiguous stretch behind its root's pair.
/// * `refs` follow in the order of the leaves, ascending within a leaf; an empty leaf has
///   `first = 0`.
/// * The tree is the same, bit for bit, for any number of threads.
/// * Its depth is bounded by [`BuildOptions::max_depth`], its references by
///   [`BuildOptions::max_refs_per_triangle`], and each cut strictly shrinks the cell, so that
///   building ends on any input.
///
/// `progress` is called with the finished fraction, ascending to 1, from any thread.
///
/// # Panics
///
/// When the tree would have 2^32 nodes or references, more than its indices can name.
#[must_use]
pub fn build(triangles: &[Triangle], options: &BuildOptions, progress: &(dyn Fn(f64) + Sync)) -> KdTree {
    let references: Vec<Reference> = triangles
        .par_iter()
        .enumerate()
        .filter_map(|(index, triangle)| Reference::of(index, triangle))
        .collect();
    let bounds = references
        .par_iter()
        .map(|reference| reference.bounds)
        .reduce_with(Aabb::union)
        .unwrap_or(Aabb { min: Vec3::ZERO, max: Vec3::ZERO });

    let builder = Builder {
        triangles,
        rule: options.rule,
        costs: Costs {
            traversal: options.traversal_cost,
            intersection: options.intersection_cost,
            empty_bonus: options.empty_bonus,
        },
        max_leaf: options.max_leaf as usize,
        progress: Progress::new(progress),
    };
    let limits = Limits {
        depth: options.depth_limit(references.len()),
        references: references.len() as u64 * u64::from(options.max_refs_per_triangle.max(1)),
        progress: Progress::WHOLE,
    };
    let root = builder.build(references, Cell { bounds, limits });

    let (nodes, refs) = root.size();
    let mut tree = KdTree { bounds, nodes: Vec::with_capacity(nodes), refs: Vec::with_capacity(refs) };
    tree.nodes.push(Node::Leaf { first: 0, count: 0 });
    root.append_to(&mut tree, 0);
    tree
}
