//! The host's memory as the driver has written it, and the scene that lies there.

use super::request::{END_OF_ADDRESSES, Request};
use crate::error::Error;
use crate::hex;
use crate::words::{Choices, Values};
use glam::Vec3;
use saarcor_model::host::{
    Aabb, Edges, Features, KdTree, Kernel, LIST_ENTRY_BYTES, ListEntry, NODE_BYTES, Node, NodeRecord,
    Registers, TRIANGLE_BYTES, Triangle,
};
use saarcor_model::vm::{HostAddr, HostMemory as _};
use std::collections::{BTreeMap, VecDeque};

/// The triangle tests that read the corners of a triangle, by their names.
pub const KERNELS: Choices<Kernel> = &[
    ("moller-trumbore", Kernel::MollerTrumbore),
    ("plucker", Kernel::Plucker),
    ("watertight", Kernel::Watertight),
    ("adaptive", Kernel::Adaptive),
];

/// Most nodes and most list entries of a tree (Assumed), so that a session takes little time.
const MAX_ITEMS: usize = 1 << 16;

/// The rules for edges and vertices that several triangles have, by their names.
pub const EDGES: Choices<Edges> = &[("shared", Edges::Shared), ("owned", Edges::Owned)];

/// The test and the rule for edges that a configuration `kernel=moller-trumbore edges=shared` names. Without `edges` they
/// are shared.
///
/// # Errors
/// The key that is wrong, and what would be right.
pub fn parse_config(config: &str) -> Result<(Kernel, Edges), Error> {
    let keys = &["kernel", "edges"];
    let values = Values::parse(config, keys)?.or(Values::parse("edges=shared", keys)?);
    Ok((values.named("kernel", KERNELS)?, values.named("edges", EDGES)?))
}

/// The host's memory, and the box around the scene: what requests change.
#[derive(Clone, Debug, Default)]
pub struct SceneMemory {
    /// From address 0 on; zero behind its end.
    pub memory: Vec<u8>,
    bounds: Option<Aabb>,
}

impl SceneMemory {
    /// What a request changes; rays change nothing. Returns whether it is one that changes something.
    pub fn change(&mut self, request: &Request<'_>) -> bool {
        match *request {
            Request::Write { host, digits } => {
                let mut bytes = Vec::with_capacity(digits.len() / 2);
                hex::extend_bytes(&mut bytes, digits);
                let start = host as usize;
                let end = (start + bytes.len()).min(END_OF_ADDRESSES as usize);
                if self.memory.len() < end {
                    self.memory.resize(end, 0);
                }
                self.memory[start..end].copy_from_slice(&bytes[..end - start]);
            }
            Request::Bounds(bounds) => self.bounds = Some(bounds),
            Request::Flush => *self = Self::default(),
            Request::Trace(..) => return false,
        }
        true
    }

    /// The scene that lies in memory.
    ///
    /// # Errors
    /// Why it is none that the driver may hand over (KD-2, HI-4), or not one in which a search over all
    /// triangles gives what a traversal does.
    pub fn scene(&self, (kernel, edges): (Kernel, Edges)) -> Result<LegalScene, Error> {
        let bounds = self.bounds.ok_or("a ray before the box, 'b X0 Y0 Z0 X1 Y1 Z1'")?;
        let mut reading = TreeReader { memory: &self.memory, refs: Vec::new(), triangles: BTreeMap::new() };
        let nodes = reading.nodes()?;
        // Triangles by their addresses, and lists by the places there.
        let places: BTreeMap<u32, u32> = reading.triangles.keys().copied().zip(0..).collect();
        let tree = KdTree { bounds, nodes, refs: reading.refs.iter().map(|addr| places[addr]).collect() };
        tree.check(places.len()).map_err(|fault| fault.to_string())?;
        let (addresses, corners): (Vec<u32>, Vec<[Vec3; 3]>) = reading.triangles.into_iter().unzip();
        for (corners, addr) in corners.iter().zip(&addresses) {
            let fits = |corner: &Vec3| corner.cmpge(bounds.min).all() && corner.cmple(bounds.max).all();
            if !corners.iter().all(fits) {
                return Err(
                    format!("the triangle at {addr:x} lies outside of the box, or is not finite").into()
                );
            }
            if (Triangle { corners: *corners, material: 0 }).is_degenerate() {
                return Err(format!("the triangle at {addr:x} has no area").into());
            }
        }
        let scene = LegalScene {
            registers: Registers { edges, ..registers(bounds, kernel) },
            tree,
            addresses,
            corners,
        };
        scene.check_lists()?;
        Ok(scene)
    }
}

/// The registers of the chip, of which traversal and intersection read the first three.
fn registers(bounds: Aabb, kernel: Kernel) -> Registers {
    let nothing = HostAddr(0);
    Registers {
        root: HostAddr(0),
        bounds,
        kernel,
        edges: Edges::Shared,
        triangles: nothing,
        shading: nothing,
        features: Features::default(),
        lights: Vec::new(),
    }
}

/// Reads a tree from memory.
struct TreeReader<'a> {
    memory: &'a [u8],
    /// Addresses of triangles, leaf by leaf.
    refs: Vec<u32>,
    triangles: BTreeMap<u32, [Vec3; 3]>,
}

impl TreeReader<'_> {
    fn fetch<const N: usize>(&self, addr: u32, what: &str) -> Result<[u8; N], Error> {
        if u64::from(addr) + N as u64 > END_OF_ADDRESSES {
            return Err(format!("the {what} at {addr:x} lies behind the last address").into());
        }
        let mut bytes = [0; N];
        self.memory.read(HostAddr(addr), &mut bytes);
        Ok(bytes)
    }

    /// The nodes level by level, so that children follow their parents, and one another.
    fn nodes(&mut self) -> Result<Vec<Node>, Error> {
        let mut nodes = Vec::new();
        let mut open = VecDeque::from([0_u32]);
        // Nodes that have their number: those before, and those that wait.
        let mut numbered = 1;
        while let Some(addr) = open.pop_front() {
            nodes.push(match NodeRecord::decode(self.fetch(addr, "node")?) {
                NodeRecord::Inner { axis, split, below } => {
                    let children = numbered;
                    numbered += 2;
                    if numbered as usize > MAX_ITEMS {
                        return Err(
                            format!("over {MAX_ITEMS} nodes: a node is its own child, or too many").into()
                        );
                    }
                    open.extend([below.0, below.0.saturating_add(NODE_BYTES)]);
                    Node::Inner { axis, split, children }
                }
                NodeRecord::Leaf { list, count } => {
                    let first = self.refs.len();
                    if first + count as usize > MAX_ITEMS {
                        return Err(format!("over {MAX_ITEMS} list entries").into());
                    }
                    for place in 0..count {
                        self.entry(list.0.saturating_add(place * LIST_ENTRY_BYTES))?;
                    }
                    Node::Leaf { first: first as u32, count }
                }
            });
        }
        Ok(nodes)
    }

    fn entry(&mut self, addr: u32) -> Result<(), Error> {
        let ListEntry { triangle, tag } = ListEntry::decode(self.fetch(addr, "list entry")?);
        if tag != 0 {
            return Err(format!("the list entry at {addr:x} is no multiple of 4").into());
        }
        let bytes: [u8; TRIANGLE_BYTES as usize] = self.fetch(triangle.0, "triangle")?;
        let mut words = bytes.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word));
        let mut coordinate = || words.next().unwrap_or_default();
        let corners = std::array::from_fn(|_| Vec3::new(coordinate(), coordinate(), coordinate()));
        self.refs.push(triangle.0);
        self.triangles.insert(triangle.0, corners);
        Ok(())
    }
}

/// A scene that is legal.
#[derive(Clone, Debug)]
pub struct LegalScene {
    /// The registers that the driver sets.
    pub registers: Registers,
    /// The tree over `corners`.
    pub tree: KdTree,
    /// Addresses of the triangles, ascending.
    pub addresses: Vec<u32>,
    /// Their corners.
    pub corners: Vec<[Vec3; 3]>,
}

impl LegalScene {
    /// Whether each triangle is in the lists below every plane below which the box around it reaches,
    /// and above every plane above which it reaches, and on one side at least of a plane that it lies
    /// in. Then all of a triangle is in the closed cells of the leaves that list it.
    fn check_lists(&self) -> Result<(), Error> {
        let lists = self.lists();
        let root = 0;
        for (triangle, corners) in (0..).zip(&self.corners) {
            let around = Aabb::around(*corners);
            if !self.is_listed(&lists, root, triangle, &around) {
                let addr = self.addresses[triangle as usize];
                return Err(format!(
                    "the triangle at {addr:x} is not in the list of every cell that its box meets"
                )
                .into());
            }
        }
        Ok(())
    }

    /// The list of each leaf, by nodes.
    fn lists(&self) -> Vec<&[u32]> {
        let list = |node: &Node| match *node {
            Node::Inner { .. } => &[][..],
            Node::Leaf { first, count } => &self.tree.refs[first as usize..(first + count) as usize],
        };
        self.tree.nodes.iter().map(list).collect()
    }

    fn is_listed(&self, lists: &[&[u32]], node: usize, triangle: u32, around: &Aabb) -> bool {
        match self.tree.nodes[node] {
            Node::Leaf { .. } => lists[node].contains(&triangle),
            Node::Inner { axis, split, children } => {
                let (low, high) = (around.min[axis as usize], around.max[axis as usize]);
                let child = |child| self.is_listed(lists, children as usize + child, triangle, around);
                match (low < split, high > split) {
                    (true, true) => child(0) && child(1),
                    (true, false) => child(0),
                    (false, true) => child(1),
                    (false, false) => child(0) || child(1),
                }
            }
        }
    }
}
