//! Scenes made for sessions: a tree over triangles, and the requests that write it to memory.

use super::request::push_bounds;
use super::scene_memory::LegalScene;
use crate::hex::push_write;
use glam::Vec3;
use saarcor_model::host::{
    Aabb, Axis, HostImage, KdTree, Kernel, Material, NODE_BYTES, Node, REGION_ALIGNMENT, Scene as ModelScene,
    TRIANGLE_BYTES, Triangle,
};
use saarcor_random::Random;
use std::ops::Range;

/// Triangles of a cell that is not cut.
const MAX_LEAF: usize = 2;
/// Greatest depth of a leaf: enough for some dozen triangles.
const MAX_DEPTH: u32 = 5;

/// A step to a simpler scene.
enum Step {
    /// All triangles in one leaf.
    OneLeaf,
    /// Without these triangles.
    Without(Range<usize>),
    /// A leaf in the place of this node.
    LeafAt(usize),
}

/// Triangles with a tree over them; none has no area (HI-4).
#[derive(Clone, Debug, PartialEq)]
pub struct GeneratedScene {
    /// The tree over `triangles`.
    pub tree: KdTree,
    /// Corners.
    pub triangles: Vec<[Vec3; 3]>,
}

impl GeneratedScene {
    /// Those of `triangles` that have an area, cut at random coordinates of the boxes around them. A
    /// triangle goes to each side to which its box reaches, and below a plane that it lies in.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]], random: &mut Random) -> Self {
        Self::with_leaves(triangles, (MAX_LEAF, MAX_DEPTH), random)
    }

    /// The same, with leaves of up to so many triangles, or that deep.
    #[must_use]
    pub fn with_leaves(triangles: &[[Vec3; 3]], most: (usize, u32), random: &mut Random) -> Self {
        let has_area = |corners: &&[Vec3; 3]| !Triangle { corners: **corners, material: 0 }.is_degenerate();
        let triangles: Vec<_> = triangles.iter().filter(has_area).copied().collect();
        let bounds = Aabb::around(triangles.iter().flatten().copied());
        let bounds = if triangles.is_empty() { Aabb { min: Vec3::ZERO, max: Vec3::ZERO } } else { bounds };
        let mut tree = KdTree { bounds, nodes: vec![Node::Leaf { first: 0, count: 0 }], refs: Vec::new() };
        let boxes: Vec<_> = triangles.iter().map(|corners| Aabb::around(*corners)).collect();
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        cut(&mut tree, (0, 0), most, &boxes, &all, random);
        Self { tree, triangles }
    }

    /// The triangles and the tree of a scene.
    #[must_use]
    pub fn of(scene: &LegalScene) -> Self {
        Self { tree: scene.tree.clone(), triangles: scene.corners.clone() }
    }

    /// The requests that write it to memory, laid out as HI-2 says: a line for the box, for each node, for all lists,
    /// and for each triangle.
    #[must_use]
    pub fn requests(&self) -> Vec<u8> {
        let mut text = Vec::new();
        push_bounds(&mut text, &self.tree.bounds);
        // A tree that is not legal is refused when a ray is traced.
        let Some(image) = self.host_image() else { return text };
        let [nodes, lists, triangles, ..] = image.region_bytes.map(|bytes| bytes.0 as usize);
        let mut region = |start: usize, bytes: usize, item: usize| {
            for place in (start..start + bytes).step_by(item.max(1)) {
                push_write(&mut text, place as u32, &image.bytes[place..place + item]);
            }
        };
        region(0, nodes, NODE_BYTES as usize);
        region(nodes.next_multiple_of(REGION_ALIGNMENT as usize), lists, lists);
        region(image.registers.triangles.0 as usize, triangles, TRIANGLE_BYTES as usize);
        text
    }

    /// The bytes of nodes, lists and triangles, from address 0 on; none where the tree is not legal.
    #[must_use]
    pub fn image(&self) -> Vec<u8> {
        let image = self.host_image();
        let end = |image: &HostImage| image.registers.triangles.0 as usize + image.region_bytes[2].0 as usize;
        image.map(|image| image.bytes[..end(&image)].to_vec()).unwrap_or_default()
    }

    fn host_image(&self) -> Option<HostImage> {
        let triangle = |corners: &[Vec3; 3]| Triangle { corners: *corners, material: 0 };
        let scene = ModelScene {
            triangles: self.triangles.iter().map(triangle).collect(),
            materials: vec![Material::default()],
            ..ModelScene::default()
        };
        // All kernels of this kind read corners.
        HostImage::build(&scene, &self.tree, Kernel::MollerTrumbore).ok()
    }

    /// Scenes that are simpler, the boldest first: one leaf, fewer triangles, fewer cells. Each is made when it
    /// is asked for.
    pub fn simpler(self) -> impl Iterator<Item = Self> {
        let (nodes, count) = (self.tree.nodes.len(), self.triangles.len());
        let one_leaf = (nodes > 1).then_some(Step::OneLeaf);
        let parts = std::iter::successors(Some(count.div_ceil(2)), |part| Some(part / 2));
        let parts = parts.take_while(|part| *part > 0);
        let fewer = parts.flat_map(move |part| {
            (0..count).step_by(part).map(move |begin| Step::Without(begin..(begin + part).min(count)))
        });
        let steps = one_leaf.into_iter().chain(fewer).chain((0..nodes).map(Step::LeafAt));
        steps.filter_map(move |step| match step {
            Step::OneLeaf => {
                let refs: Vec<u32> = (0..count as u32).collect();
                Some(self.with_tree(vec![Node::Leaf { first: 0, count: count as u32 }], refs))
            }
            Step::Without(gone) => Some(self.without(&gone)),
            Step::LeafAt(node) => {
                matches!(self.tree.nodes[node], Node::Inner { .. }).then(|| self.with_leaf_at(node))
            }
        })
    }

    fn with_tree(&self, nodes: Vec<Node>, refs: Vec<u32>) -> Self {
        let tree = KdTree { bounds: self.tree.bounds, nodes, refs };
        Self { tree, triangles: self.triangles.clone() }
    }

    /// Without some triangles; the cells stay.
    fn without(&self, gone: &Range<usize>) -> Self {
        let stays = |triangle: usize| !gone.contains(&triangle);
        let new_place = |triangle: u32| match triangle as usize {
            before if before < gone.start => triangle,
            _ => triangle - gone.len() as u32,
        };
        let mut refs = Vec::new();
        let nodes = self.tree.nodes.iter().map(|node| match *node {
            Node::Leaf { first, count } => {
                let list = &self.tree.refs[first as usize..(first + count) as usize];
                let first = refs.len() as u32;
                refs.extend(list.iter().filter(|&&triangle| stays(triangle as usize)).map(|&t| new_place(t)));
                Node::Leaf { first, count: refs.len() as u32 - first }
            }
            inner @ Node::Inner { .. } => inner,
        });
        let nodes = nodes.collect();
        let kept = (0..self.triangles.len()).filter(|&place| stays(place));
        let triangles = kept.map(|place| self.triangles[place]).collect();
        Self { tree: KdTree { bounds: self.tree.bounds, nodes, refs }, triangles }
    }

    /// With a leaf in the place of an inner node, of all that is listed below it.
    fn with_leaf_at(&self, leaf: usize) -> Self {
        let (mut nodes, mut refs) = (vec![self.tree.nodes[0]], Vec::new());
        // Places in the old tree and the new one.
        let mut open = vec![(0, 0)];
        while let Some((old, new)) = open.pop() {
            match self.tree.nodes[old] {
                Node::Inner { axis, split, children } if old != leaf => {
                    let below = nodes.len();
                    nodes[new] = Node::Inner { axis, split, children: below as u32 };
                    nodes.extend([nodes[0]; 2]);
                    open.extend([(children as usize, below), (children as usize + 1, below + 1)]);
                }
                _ => {
                    let first = refs.len();
                    self.list_below(old, &mut refs);
                    refs[first..].sort_unstable();
                    let mut listed = refs.split_off(first);
                    listed.dedup();
                    nodes[new] = Node::Leaf { first: first as u32, count: listed.len() as u32 };
                    refs.extend(listed);
                }
            }
        }
        self.with_tree(nodes, refs)
    }

    fn list_below(&self, node: usize, list: &mut Vec<u32>) {
        match self.tree.nodes[node] {
            Node::Leaf { first, count } => {
                list.extend(&self.tree.refs[first as usize..(first + count) as usize]);
            }
            Node::Inner { children, .. } => {
                self.list_below(children as usize, list);
                self.list_below(children as usize + 1, list);
            }
        }
    }
}

/// Cuts the cell of `node`, which holds `triangles`, or makes it a leaf.
fn cut(
    tree: &mut KdTree,
    (node, depth): (usize, u32),
    (max_leaf, max_depth): (usize, u32),
    boxes: &[Aabb],
    triangles: &[u32],
    random: &mut Random,
) {
    if triangles.len() > max_leaf && depth < max_depth {
        let (axis, split) =
            if max_depth > MAX_DEPTH { middle(boxes, triangles) } else { anywhere(boxes, triangles, random) };
        let part = |keep: &dyn Fn(f32, f32) -> bool| -> Vec<u32> {
            let reaches = |&&triangle: &&u32| {
                let Aabb { min, max } = boxes[triangle as usize];
                keep(min[axis as usize], max[axis as usize])
            };
            triangles.iter().filter(reaches).copied().collect()
        };
        let below = part(&|min, max| min < split || max <= split);
        let above = part(&|_, max| max > split);
        // Triangles that lie on both sides of every plane are one leaf.
        if max_depth > MAX_DEPTH && below.len().max(above.len()) == triangles.len() {
            return leaf(tree, node, triangles);
        }
        let children = tree.nodes.len();
        tree.nodes[node] = Node::Inner { axis, split, children: children as u32 };
        tree.nodes.extend([Node::Leaf { first: 0, count: 0 }; 2]);
        cut(tree, (children, depth + 1), (max_leaf, max_depth), boxes, &below, random);
        cut(tree, (children + 1, depth + 1), (max_leaf, max_depth), boxes, &above, random);
    } else {
        leaf(tree, node, triangles);
    }
}

fn leaf(tree: &mut KdTree, node: usize, triangles: &[u32]) {
    tree.nodes[node] = Node::Leaf { first: tree.refs.len() as u32, count: triangles.len() as u32 };
    tree.refs.extend(triangles);
}

/// A plane at an end or the middle of some triangle.
fn anywhere(boxes: &[Aabb], triangles: &[u32], random: &mut Random) -> (Axis, f32) {
    let axis = random.pick(&Axis::ALL);
    let around = &boxes[random.pick(triangles) as usize];
    (axis, random.pick(&[around.min, around.max, around.min.midpoint(around.max)])[axis as usize])
}

/// The plane that has as many triangles below it as above, across the axis on which they are spread the most.
fn middle(boxes: &[Aabb], triangles: &[u32]) -> (Axis, f32) {
    let ends =
        |axis: Axis| triangles.iter().map(move |&triangle| boxes[triangle as usize].max[axis as usize]);
    let spread = |axis: Axis| ends(axis).fold(f32::MIN, f32::max) - ends(axis).fold(f32::MAX, f32::min);
    let axis = Axis::ALL.into_iter().max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(Axis::X);
    let mut sorted: Vec<f32> = ends(axis).collect();
    let half = (sorted.len() - 1) / 2;
    let (_, split, _) = sorted.select_nth_unstable_by(half, f32::total_cmp);
    (axis, *split)
}
