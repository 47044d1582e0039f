//! Traversal at its limits: paths of 64 inner nodes, packets of 64 rays, lists of 65536 entries, addresses up to the
//! last (KD-2, KD-4, HI-3).

mod support;

use glam::Vec3;
use proptest::collection::vec;
use proptest::prelude::*;
use saarcor_model::host::{
    Aabb, Axis, KdTree, Kernel, ListEntry, MAX_DEPTH, Node, NodeRecord, Registers, Triangle,
};
use saarcor_model::rays::{Packet, Query, Ray, Traversal};
use saarcor_model::vm::{HostAddr, Memory, Observed, Unit};
use support::engine;
use support::rays::{Reads, across, agrees, along, lay_out, observed};

/// A path of `depth` inner nodes that cut the x axis at 0, 1, 2 and so on, in the order in which each is the end, from
/// below or from above, of what the ones before leave; each cell has the triangle in its middle.
fn path(depth: u32, from_below: &[bool]) -> (Vec<Triangle>, KdTree) {
    // Cell i lies between the planes i - 1 and i.
    let triangles: Vec<Triangle> = (0..=depth).map(|cell| across(cell as f32 - 0.5)).collect();
    let bounds = Aabb::around(triangles.iter().flat_map(|triangle| triangle.corners));
    let mut nodes = vec![Node::Leaf { first: 0, count: 0 }; 2 * depth as usize + 1];
    let (mut low, mut high, mut at) = (0, depth, 0);
    for level in 0..depth {
        let children = 2 * level + 1;
        let below = from_below[level as usize % from_below.len()];
        // The outermost cell is a leaf, the rest goes on.
        let (plane, cell, leaf, rest) = if below { (low, low, 0, 1) } else { (high - 1, high, 1, 0) };
        nodes[at] = Node::Inner { axis: Axis::X, split: plane as f32, children };
        nodes[(children + leaf) as usize] = Node::Leaf { first: cell, count: 1 };
        at = (children + rest) as usize;
        (low, high) = if below { (low + 1, high) } else { (low, high - 1) };
    }
    nodes[at] = Node::Leaf { first: low, count: 1 };
    (triangles, KdTree { bounds, nodes, refs: (0..=depth).collect() })
}

fn rays() -> impl Strategy<Value = Option<Ray>> {
    let place = -2..=66_i32;
    let direction = prop_oneof![Just(1.0_f32), Just(-1.0), Just(0.5), Just(-2.0)];
    // Beside the axis a ray passes above all triangles.
    let height = prop_oneof![5 => Just(0.0_f32), 1 => Just(8.5), 1 => Just(9.5)];
    let ray = (place, direction, height, 0..80_u8, 0..80_u8).prop_map(
        |(place, direction, height, t_min, t_max)| Ray {
            origin: Vec3::new(place as f32, 0.0, height),
            direction: Vec3::X * direction,
            t_min: if t_min < 60 { 0.0 } else { f32::from(t_min) - 60.0 },
            t_max: if t_max < 60 { f32::INFINITY } else { 3.0 * (f32::from(t_max) - 60.0) },
        },
    );
    prop::option::weighted(0.9, ray)
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn packets_of_64_find_what_the_search_finds_along_deep_paths(
        depth in prop_oneof![Just(MAX_DEPTH as u32), 1..=MAX_DEPTH as u32],
        from_below in vec(any::<bool>(), 1..9),
        rays in vec(rays(), 64),
    ) {
        let (triangles, tree) = path(depth, &from_below);
        let image = lay_out(triangles.clone(), &tree);
        let rays: [_; 64] = rays.try_into().expect("64 of them");
        agrees(&mut Traversal::default(), &triangles, &image, &rays)?;
    }
}

/// The stack has room for the deepest tree that a driver may hand over, put off at every node, by each ray of a packet.
#[test]
fn deepest_tree_is_walked() {
    let depth = MAX_DEPTH as u32;
    // All cells but the last one are empty, and each is put off before the one beyond it is visited.
    for (from_below, ray) in [(false, along(-1.5, 1.0)), (true, along(depth as f32 + 0.5, -1.0))] {
        let (triangles, mut tree) = path(depth, &[from_below]);
        let last = if from_below { 0 } else { depth };
        for node in &mut tree.nodes {
            if let Node::Leaf { first, count } = node {
                *count = u32::from(*first == last);
            }
        }
        let image = lay_out(triangles, &tree);
        let mut memory = observed(&image);
        let hits = Traversal::<64>::default().run(
            &mut memory,
            &image.registers,
            &Packet::new([Some(ray); 64]),
            Query::Closest,
        );
        assert!((0..64).all(|lane| hits.is_hit(lane) && hits.t[lane] == depth as f32 + 1.0), "{hits:?}");
        assert_eq!(memory.observer.nodes.len(), tree.nodes.len());
        assert_eq!(memory.observer.triangles, 1);
    }
}

/// Every entry of a list is read, in lists of any length, and the nearest of them is what counts.
#[test]
fn every_entry_of_a_list_counts() {
    let triangles = vec![across(5.0), across(3.0)];
    let bounds = Aabb::around(triangles.iter().flat_map(|triangle| triangle.corners));
    for count in [0_u32, 1, 2, 255, 256, 257, 0xffff, 0x1_0000, 0x1_0001, 70_000] {
        for nearer in [0, count / 2, count.saturating_sub(1)] {
            let mut refs = vec![0; count as usize];
            if count > 0 {
                refs[nearer as usize] = 1;
            }
            let tree = KdTree { bounds, nodes: vec![Node::Leaf { first: 0, count }], refs };
            let image = lay_out(triangles.clone(), &tree);
            let mut memory = observed(&image);
            let packet =
                Packet::new([Some(along(0.0, 1.0)), None, Some(along(4.0, 1.0)), Some(along(4.0, -1.0))]);
            let hits = Traversal::<4>::default().run(&mut memory, &image.registers, &packet, Query::Closest);
            let alone = count == 1;
            let expected = match count {
                0 => [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::INFINITY],
                _ if alone => [3.0, f32::NEG_INFINITY, f32::INFINITY, 1.0],
                _ => [3.0, f32::NEG_INFINITY, 1.0, 1.0],
            };
            assert_eq!(hits.t, expected, "{count} entries, the nearer triangle is entry {nearer}");
            assert_eq!(
                (memory.observer.entries, memory.observer.triangles),
                (count as usize, count as usize)
            );
        }
    }
}

/// Memory with a root, its two leaves with lists, and triangles, at addresses of their own.
struct Scattered {
    root: u32,
    children: u32,
    lists: [u32; 2],
    triangles: [u32; 2],
}

impl Scattered {
    fn bytes(&self, unit: Unit, addr: u32) -> Vec<u8> {
        let leaf = |side: usize| NodeRecord::Leaf { list: HostAddr(self.lists[side]), count: 1 };
        let inner = NodeRecord::Inner { axis: Axis::X, split: 1.0, below: HostAddr(self.children) };
        match unit {
            Unit::Traversal if addr == self.root => inner.encode().to_vec(),
            Unit::Traversal if addr == self.children => leaf(0).encode().to_vec(),
            Unit::Traversal if addr == self.children + 8 => leaf(1).encode().to_vec(),
            Unit::List | Unit::Intersection => {
                let items = if unit == Unit::List { self.lists } else { self.triangles };
                let side =
                    items.iter().position(|&item| item == addr).expect("an item is read where it begins");
                let entry = ListEntry { triangle: HostAddr(self.triangles[side]), tag: 0 };
                let triangle = Kernel::MollerTrumbore.record(&across(2.0 * side as f32).corners);
                if unit == Unit::List { entry.encode().to_vec() } else { triangle.encode().to_vec() }
            }
            _ => panic!("{unit:?} reads at {addr:#x}"),
        }
    }
}

impl Memory for Scattered {
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.bytes(unit, addr.0));
    }
}

/// Nodes, lists and triangles are found wherever they lie, up to the last address.
#[test]
fn items_are_found_at_any_address() {
    let image = lay_out(
        vec![across(0.0)],
        &KdTree {
            bounds: Aabb { min: Vec3::splat(-9.0), max: Vec3::splat(9.0) },
            nodes: vec![Node::Leaf { first: 0, count: 1 }],
            refs: vec![0],
        },
    );
    // The last items of their kinds that there is room for, and around bits 15, 16, 20 and 31.
    for base in [0x7fe0, 0xffe0, 0xf_ffe0, 0x0fff_ffe0, 0x7fff_ffe0, 0xffff_ff00_u32] {
        for shift in [0, 4, 8, 16, 32] {
            let at = base + shift;
            let root = at & !7;
            let memory = Scattered {
                root,
                children: root + 16,
                lists: [at + 40, at + 44],
                triangles: [at + 48, at + 48 + 36],
            };
            let registers = Registers {
                root: HostAddr(root),
                triangles: HostAddr(memory.triangles[0]),
                ..image.registers.clone()
            };
            let triangles = memory.triangles;
            let mut memory = Observed { memory, observer: Reads::default() };
            let packet = Packet::new([
                Some(along(-1.0, 1.0)),
                Some(along(3.0, -1.0)),
                Some(along(1.5, 1.0)),
                Some(along(-1.0, -1.0)),
            ]);
            let hits = Traversal::<4>::default().run(&mut memory, &registers, &packet, Query::Closest);
            assert_eq!(&hits.triangle[..3], &[triangles[0], triangles[1], triangles[1]], "at {at:#x}");
            assert!(!hits.is_hit(3));
        }
    }
}
