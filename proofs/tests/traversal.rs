//! Traversal returns what the search over all triangles returns (KD-4), through any valid tree,
//! and reads of the tree what its rays meet (KD-3).
//!
//! Coordinates are small multiples of one half, so that in the triangle test nothing is rounded but
//! the reciprocal and the products with it: edges and vertices are hit exactly, and what differs is
//! traversal's fault.

mod support;

use glam::Vec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{TestCaseError, TestRunner};
use saarcor_model::host::{Aabb, Axis, HostImage, KdTree, Kernel, Node, Triangle};
use saarcor_model::rays::{Hits, Packet, Query, Ray, Traversal, widen};
use saarcor_model::vm::HostAddr;
use support::engine;
use support::rays::{across, agrees, along, lay_out, lay_out_for, observed};

/// Where a node cuts space.
#[derive(Clone, Copy, Debug)]
enum Plane {
    /// Through a corner of a triangle.
    Corner { triangle: usize, corner: usize },
    /// At a multiple of one half, which may be outside of everything.
    Half(i8),
    /// Anywhere.
    At(f32),
    /// Where the node above cuts, so that one cell is as thin as a plane.
    Again,
}

/// What becomes of a cell: a leaf, or two cells.
#[derive(Clone, Copy, Debug)]
struct Cut {
    leaf: bool,
    axis: Axis,
    plane: Plane,
}

fn cuts() -> impl Strategy<Value = Vec<Cut>> {
    let plane = prop_oneof![
        4 => (any::<usize>(), 0..3usize).prop_map(|(triangle, corner)| Plane::Corner { triangle, corner }),
        2 => (-12..=12i8).prop_map(Plane::Half),
        2 => (-5.0..5.0f32).prop_map(Plane::At),
        1 => Just(Plane::Again),
    ];
    let axis = (0..3usize).prop_map(|axis| Axis::ALL[axis]);
    let cut = (prop::bool::weighted(0.2), axis, plane);
    vec(cut.prop_map(|(leaf, axis, plane)| Cut { leaf, axis, plane }), 0..40)
}

/// Most inner nodes on a path of the trees built here.
const DEEPEST: usize = 12;

/// Builds a tree by cuts that know nothing of the scene, and gives each leaf the triangles whose
/// own boxes meet its cell.
struct Builder<'a> {
    triangles: &'a [Triangle],
    cuts: std::slice::Iter<'a, Cut>,
    tree: KdTree,
}

impl Builder<'_> {
    fn cell(&mut self, place: usize, inside: Vec<u32>, above: (Axis, f32), depth: usize) {
        let Some(Cut { leaf: false, axis, plane }) = self.cuts.next().filter(|_| depth < DEEPEST) else {
            let first = self.tree.refs.len() as u32;
            self.tree.nodes[place] = Node::Leaf { first, count: inside.len() as u32 };
            self.tree.refs.extend(inside);
            return;
        };
        let (axis, split) = match *plane {
            Plane::Corner { triangle, corner } => {
                (*axis, self.triangles[triangle % self.triangles.len()].corners[corner][*axis as usize])
            }
            Plane::Half(halves) => (*axis, f32::from(halves) / 2.0),
            Plane::At(split) => (*axis, split),
            Plane::Again => above,
        };
        let children = self.tree.nodes.len();
        self.tree.nodes[place] = Node::Inner { axis, split, children: children as u32 };
        self.tree.nodes.extend([Node::Leaf { first: 0, count: 0 }; 2]);
        let corners = |&id: &u32| self.triangles[id as usize].corners.map(|corner| corner[axis as usize]);
        let low = inside.iter().copied().filter(|id| corners(id).iter().any(|&x| x <= split)).collect();
        let high = inside.iter().copied().filter(|id| corners(id).iter().any(|&x| x >= split)).collect();
        self.cell(children, low, (axis, split), depth + 1);
        self.cell(children + 1, high, (axis, split), depth + 1);
    }
}

fn tree(triangles: &[Triangle], cuts: &[Cut]) -> KdTree {
    let bounds = Aabb::around(triangles.iter().flat_map(|triangle| triangle.corners));
    let nodes = vec![Node::Leaf { first: 0, count: 0 }];
    let mut builder =
        Builder { triangles, cuts: cuts.iter(), tree: KdTree { bounds, nodes, refs: Vec::new() } };
    builder.cell(0, (0..triangles.len() as u32).collect(), (Axis::X, 0.0), 0);
    builder.tree
}

fn halves(most: i8) -> impl Strategy<Value = f32> {
    (-most..=most).prop_map(|halves| f32::from(halves) / 2.0)
}

fn triangles() -> impl Strategy<Value = Vec<Triangle>> {
    let corner =
        || (-4..=4i8, -4..=4i8, -4..=4i8).prop_map(|(x, y, z)| Vec3::new(x.into(), y.into(), z.into()));
    let triangle = [corner(), corner(), corner()]
        .prop_map(|corners| Triangle { corners, material: 0 })
        .prop_filter("no ray hits a triangle without area", |triangle| !triangle.is_degenerate());
    vec(triangle, 2..=40)
}

/// Rays between points of the same grid, many of them along axes and in planes of the grid.
fn rays() -> impl Strategy<Value = Ray> {
    let component = || prop_oneof![1 => Just(-0.0), 1 => Just(0.0), 3 => (-3..=3i8).prop_map(f32::from)];
    let direction = (component(), component(), component())
        // A ray goes somewhere.
        .prop_map(|(x, y, z)| if (x, y, z) == (0.0, 0.0, 0.0) { Vec3::X } else { Vec3::new(x, y, z) });
    let origin = (halves(12), halves(12), halves(12)).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let t_min = prop_oneof![3 => Just(0.0), 1 => (0..8u8).prop_map(|eighths| f32::from(eighths) / 8.0)];
    let t_max =
        prop_oneof![2 => Just(f32::INFINITY), 1 => (0..16u8).prop_map(|halves| f32::from(halves) / 2.0)];
    (origin, direction, t_min, t_max).prop_map(|(origin, direction, t_min, t_max)| Ray {
        origin,
        direction,
        t_min,
        t_max,
    })
}

/// Packets, of which some lanes are empty.
fn packets<const N: usize>() -> impl Strategy<Value = [Option<Ray>; N]> {
    vec(prop::option::weighted(0.8, rays()), N)
        .prop_map(|rays| rays.try_into().expect("as many as asked for"))
}

/// The nodes that packets read, naively: by recursion, each ray's interval in f64, widened by
/// `slack` relative to the distance of each plane.
struct Naive<'a> {
    nodes: &'a [Node],
    rays: &'a [Option<Ray>],
    slack: f64,
    read: Vec<u32>,
}

/// Part of a ray, `enter ≤ t ≤ leave`.
type Interval = (f64, f64);

impl Naive<'_> {
    /// The parts of a ray before and behind a plane, near first; by its side where it is parallel.
    fn cut(&self, ray: &Ray, axis: usize, split: f32) -> (Interval, Interval) {
        let (origin, direction) = (f64::from(ray.origin[axis]), f64::from(ray.direction[axis]));
        let whole = (f64::NEG_INFINITY, f64::INFINITY);
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let split = f64::from(split);
        if direction == 0.0 {
            // Near is below for +0.0, above for −0.0.
            let near_is_below = direction.is_sign_positive();
            return match origin.total_cmp(&split) {
                _ if origin == split => (whole, whole),
                order if order.is_lt() == near_is_below => (whole, none),
                _ => (none, whole),
            };
        }
        let t = (split - origin) / direction;
        let slack = t.abs() * self.slack;
        ((f64::NEG_INFINITY, t + slack), (t - slack, f64::INFINITY))
    }

    fn walk_in(&mut self, bounds: Aabb) {
        let in_bounds = |ray: &Ray| {
            let mut part = (f64::from(ray.t_min), f64::from(ray.t_max));
            for axis in 0..3 {
                let (low, high) = (bounds.min[axis], bounds.max[axis]);
                let downwards = ray.direction[axis].is_sign_negative();
                let (first, last) = if downwards { (high, low) } else { (low, high) };
                part = meet(part, self.cut(ray, axis, first).1);
                part = meet(part, self.cut(ray, axis, last).0);
            }
            part
        };
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let parts = self.rays.iter().map(|ray| ray.as_ref().map_or(none, in_bounds)).collect();
        self.walk(0, parts);
    }

    fn walk(&mut self, node: u32, parts: Vec<Interval>) {
        let Some(first) = parts.iter().position(|(enter, leave)| enter <= leave) else { return };
        self.read.push(node);
        let Node::Inner { axis, split, children } = self.nodes[node as usize] else { return };
        let downwards = |ray: &Ray| ray.direction[axis as usize].is_sign_negative();
        let child = |above: bool| {
            let part = |(ray, &part): (&Option<Ray>, &Interval)| {
                let Some(ray) = ray else { return part };
                let (near, far) = self.cut(ray, axis as usize, split);
                meet(part, if downwards(ray) == above { near } else { far })
            };
            self.rays.iter().zip(&parts).map(part).collect::<Vec<_>>()
        };
        let (below, above) = (child(false), child(true));
        if self.rays[first].as_ref().is_some_and(downwards) {
            self.walk(children + 1, above);
            self.walk(children, below);
        } else {
            self.walk(children, below);
            self.walk(children + 1, above);
        }
    }
}

fn meet(a: Interval, b: Interval) -> Interval {
    (a.0.max(b.0), a.1.min(b.1))
}

/// What one packet reads of a tree without triangles; returns whether the naive walk says it to
/// the node.
fn reads_what_is_met<const N: usize>(
    traversal: &mut Traversal<N>,
    tree: &KdTree,
    image: &HostImage,
    rays: &[Option<Ray>; N],
) -> Result<bool, TestCaseError> {
    let mut memory = observed(image);
    let hits = traversal.run(&mut memory, &image.registers, &Packet::new(*rays), Query::Closest);
    prop_assert!((0..N).all(|lane| !hits.is_hit(lane)) && memory.observer.triangles == 0, "{:?}", hits);
    // Widening is 3.6e-7; between it and the distances in f64 the walk is free.
    let naive = |slack| {
        let mut naive = Naive { nodes: &tree.nodes, rays, slack, read: Vec::new() };
        naive.walk_in(tree.bounds);
        naive.read
    };
    let (least, most) = (naive(0.0), naive(2e-6));
    if least == most {
        prop_assert_eq!(&memory.observer.nodes, &least);
    }
    prop_assert!(
        least.iter().all(|node| memory.observer.nodes.contains(node)),
        "{:?} of {:?}",
        memory.observer.nodes,
        least
    );
    prop_assert!(
        memory.observer.nodes.iter().all(|node| most.contains(node)),
        "{:?} of {:?}",
        memory.observer.nodes,
        most
    );
    Ok(least == most)
}

/// Exponents by which coordinates and directions are multiplied: as they are, to distances among
/// the least f32, where the reciprocals are too, and to distances among the largest. The triangle
/// test stays as exact as it is.
fn scales() -> impl Strategy<Value = (i32, i32)> {
    prop_oneof![Just((0, 0)), Just((-24, 125)), Just((-18, 126)), Just((0, -126))]
}

/// A ray through the scene of which all coordinates were multiplied by 2 to the first exponent,
/// with a direction multiplied by 2 to the second. Components that are `slow` are an eighth.
fn scaled(ray: Ray, (coordinates, direction): (i32, i32), slow: [bool; 3]) -> Ray {
    let slow = Vec3::from_array(slow.map(|slow| if slow { 0.125 } else { 1.0 }));
    // In two steps, as the factor may be more than any f32.
    let t = |t: f32| {
        let exponent = coordinates - direction;
        t * 2.0_f32.powi(exponent / 2) * 2.0_f32.powi(exponent - exponent / 2)
    };
    Ray {
        origin: ray.origin * 2.0_f32.powi(coordinates),
        direction: ray.direction * slow * 2.0_f32.powi(direction),
        t_min: t(ray.t_min),
        t_max: t(ray.t_max),
    }
}

fn without_lists(mut tree: KdTree) -> KdTree {
    for node in &mut tree.nodes {
        if let Node::Leaf { first, count } = node {
            (*first, *count) = (0, 0);
        }
    }
    tree.refs.clear();
    tree
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn hits_are_those_of_the_search(
        triangles in triangles(),
        cuts in cuts(),
        alone in vec(packets::<1>(), 40),
        four in vec(packets::<4>(), 10),
        many in packets::<16>(),
        whole in packets::<64>(),
    ) {
        let image = lay_out(triangles.clone(), &tree(&triangles, &cuts));
        let (mut by_one, mut by_four) = (Traversal::default(), Traversal::default());
        for ray in &alone {
            agrees(&mut by_one, &triangles, &image, ray)?;
        }
        for rays in &four {
            agrees(&mut by_four, &triangles, &image, rays)?;
        }
        agrees(&mut Traversal::default(), &triangles, &image, &many)?;
        agrees(&mut Traversal::default(), &triangles, &image, &whole)?;
    }

    #[test]
    fn hits_at_the_least_and_the_largest_distances_are_those_of_the_search(
        triangles in triangles(),
        cuts in cuts(),
        rays in vec((rays(), any::<[bool; 3]>()), 40),
        scale in scales(),
    ) {
        let factor = 2.0_f32.powi(scale.0);
        let mut tree = tree(&triangles, &cuts);
        tree.bounds = Aabb { min: tree.bounds.min * factor, max: tree.bounds.max * factor };
        for node in &mut tree.nodes {
            if let Node::Inner { split, .. } = node {
                *split *= factor;
            }
        }
        let scaled_corners = |triangle: &Triangle| Triangle { corners: triangle.corners.map(|p| p * factor), ..*triangle };
        let triangles: Vec<Triangle> = triangles.iter().map(scaled_corners).collect();
        let image = lay_out(triangles.clone(), &tree);
        let mut traversal = Traversal::default();
        for (ray, slow) in rays {
            agrees(&mut traversal, &triangles, &image, &[Some(scaled(ray, scale, slow))])?;
        }
    }

    #[test]
    fn nodes_read_are_those_met(
        triangles in triangles(),
        cuts in cuts(),
        alone in vec(packets::<1>(), 20),
        four in vec(packets::<4>(), 10),
        whole in packets::<64>(),
    ) {
        let tree = without_lists(tree(&triangles, &cuts));
        let image = lay_out(triangles, &tree);
        let (mut by_one, mut by_four) = (Traversal::default(), Traversal::default());
        for ray in &alone {
            reads_what_is_met(&mut by_one, &tree, &image, ray)?;
        }
        for rays in &four {
            reads_what_is_met(&mut by_four, &tree, &image, rays)?;
        }
        reads_what_is_met(&mut Traversal::default(), &tree, &image, &whole)?;
        // Each operation has those rays that are in the cell: as many as go there alone.
        let mut memory = observed(&image);
        Traversal::default().run(&mut memory, &image.registers, &Packet::new(whole), Query::Closest);
        let mut visits = 0;
        for ray in whole {
            let mut memory = observed(&image);
            by_one.run(&mut memory, &image.registers, &Packet::new([ray]), Query::Closest);
            visits += memory.observer.nodes.len() as u64;
        }
        prop_assert_eq!(memory.observer.rays, visits, "rays of all operations of a packet");
    }

    #[test]
    fn rays_of_a_packet_hit_what_they_hit_alone(
        triangles in triangles(),
        cuts in cuts(),
        whole in packets::<64>(),
        kernel in 0..5_usize,
        any in any::<bool>(),
    ) {
        let image = lay_out_for(triangles.clone(), &tree(&triangles, &cuts), Kernel::ALL[kernel]);
        let query = if any { Query::Any } else { Query::Closest };
        let mut memory = observed(&image);
        let found: Hits<64> = Traversal::default().run(&mut memory, &image.registers, &Packet::new(whole), query);
        let mut traversal = Traversal::<1>::default();
        for (lane, ray) in whole.into_iter().enumerate() {
            let alone = traversal.run(&mut memory, &image.registers, &Packet::new([ray]), query);
            prop_assert_eq!(found.is_hit(lane), alone.is_hit(0), "lane {} of {:?}: {:?}", lane, Kernel::ALL[kernel], ray);
            if !any {
                let found = (found.t[lane], found.u[lane], found.v[lane], found.triangle[lane]);
                let alone = (alone.t[0], alone.u[0], alone.v[0], alone.triangle[0]);
                prop_assert_eq!(found, alone, "lane {} of {:?}: {:?}", lane, Kernel::ALL[kernel], ray);
            }
        }
    }
}

/// The strategies above reach what they are for: hits and misses, and walks that are known to the
/// node.
#[test]
fn strategies_reach_what_they_are_for() {
    let mut runner = TestRunner::new(engine());
    let strategy = (triangles(), cuts(), vec(packets::<4>(), 10));
    let (mut hits, mut exact, mut inner) = (0, 0, 0);
    for _ in 0..engine().cases {
        let (triangles, cuts, packets) = strategy.new_tree(&mut runner).expect("a case").current();
        let tree = tree(&triangles, &cuts);
        inner += tree.nodes.len() / 2;
        let image = lay_out(triangles.clone(), &tree);
        let mut traversal = Traversal::default();
        for rays in &packets {
            hits += agrees(&mut traversal, &triangles, &image, rays).expect("as the search");
        }
        let tree = without_lists(tree);
        let image = lay_out(triangles, &tree);
        for rays in &packets {
            exact += usize::from(reads_what_is_met(&mut traversal, &tree, &image, rays).expect("as met"));
        }
    }
    let (cases, packets) = (engine().cases as usize, engine().cases as usize * 10);
    println!("{hits} hits of {} rays, {exact} of {packets} walks exact, {inner} inner nodes", packets * 4);
    assert!(hits * 10 > packets * 4 && exact * 4 > packets && inner > cases * 4);
}

/// The distance of a plane lies between the two to which it is widened, for every float of four
/// powers of two: the least numbers, around which products are rounded to the same places, two
/// that stand for all between, and the largest, whose products overflow.
#[test]
fn widening_encloses_the_distance() {
    for exponent in [0, 1, 127, 254_u32] {
        for bits in exponent << 23..(exponent + 1) << 23 {
            let t = f32::from_bits(bits);
            let (least, greatest) = widen(t);
            assert!(least <= t && t <= greatest, "{t}: {least} to {greatest}");
            assert_eq!(widen(-t), (-greatest, -least), "{t}");
        }
    }
}

/// From an origin so far from one end of the scene that their difference is no f32, though the distance is one: no
/// interval is cut along that axis.
#[test]
fn a_plane_whose_difference_overflows_hides_nothing() {
    for towards in [1.0, -1.0] {
        let (from, near, plane, far) = (-2.0e38, -1.0e38, 2.0e38, 3.0e38);
        // The near triangle is beside the ray.
        let mut beside = across(near * towards);
        beside.corners = beside.corners.map(|corner| corner + Vec3::Y * 100.0);
        let triangles = vec![beside, across(far * towards)];
        let bounds = Aabb::around(triangles.iter().flat_map(|triangle| triangle.corners));
        let leaf = |triangle| Node::Leaf { first: triangle, count: 1 };
        let [below, above] = if towards > 0.0 { [leaf(0), leaf(1)] } else { [leaf(1), leaf(0)] };
        let nodes = vec![Node::Inner { axis: Axis::X, split: plane * towards, children: 1 }, below, above];
        let image = lay_out_for(triangles, &KdTree { bounds, nodes, refs: vec![0, 1] }, Kernel::Adaptive);
        let ray = Ray { t_max: f32::MAX, ..along(from * towards, 2.0 * towards) };
        let packet = Packet::new([Some(ray)]);
        let hits =
            Traversal::<1>::default().run(&mut observed(&image), &image.registers, &packet, Query::Closest);
        assert!(hits.is_hit(0), "{ray:?}");
        assert_eq!((image.triangle_id(HostAddr(hits.triangle[0])), hits.t[0]), (1, 2.5e38));
    }
}

/// What lies behind a hit is not read, from either side, by either query.
#[test]
fn cells_behind_a_hit_are_not_read() {
    let triangles = vec![across(0.0), across(3.0)];
    let bounds = Aabb::around(triangles.iter().flat_map(|triangle| triangle.corners));
    let nodes = vec![
        Node::Inner { axis: Axis::X, split: 1.0, children: 1 },
        Node::Leaf { first: 0, count: 1 },
        Node::Leaf { first: 1, count: 1 },
    ];
    let image = lay_out(triangles, &KdTree { bounds, nodes, refs: vec![0, 1] });
    for query in [Query::Closest, Query::Any] {
        for (ray, nodes) in [(along(-1.0, 1.0), [0, 1]), (along(5.0, -1.0), [0, 2])] {
            let mut memory = observed(&image);
            let hits = Traversal::<1>::default().run(
                &mut memory,
                &image.registers,
                &Packet::new([Some(ray)]),
                query,
            );
            assert!(hits.is_hit(0));
            assert_eq!(
                (memory.observer.nodes, memory.observer.triangles),
                (nodes.to_vec(), 1),
                "{query:?} {ray:?}"
            );
        }
    }
}
