//! The kd-tree builder: what its trees promise, on awkward input.

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use saarcor_model::host::{Aabb, KdTree, Node, Triangle};
use saarcor_scenes::kdbuild::{BuildOptions, MAX_DEPTH, SplitRule, build};
use std::sync::Mutex;

const RULES: [SplitRule; 2] = [SplitRule::SurfaceArea, SplitRule::SpatialMedian];

/// Rounding of a point that is sampled on a triangle in f64, and of the builder's clipping,
/// relative to the greatest coordinate.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

fn triangle(corners: [[f32; 3]; 3]) -> Triangle {
    Triangle { corners: corners.map(Vec3::from_array), material: 0 }
}

fn options(rule: SplitRule) -> BuildOptions {
    BuildOptions { rule, ..BuildOptions::default() }
}

fn build_quietly(triangles: &[Triangle], options: &BuildOptions) -> KdTree {
    build(triangles, options, &|_| ())
}

fn is_usable(triangle: &Triangle) -> bool {
    triangle.corners.iter().all(|c| c.is_finite()) && !triangle.is_degenerate()
}

/// A leaf: its cell, its depth and the triangles that it lists.
struct Leaf<'a> {
    cell: Aabb,
    depth: u32,
    triangles: &'a [u32],
}

/// The leaves in order. Fails when the nodes are not in depth-first order with adjacent pairs, a
/// split does not lie inside its cell, or the references do not follow the leaves.
fn leaves(tree: &KdTree) -> Vec<Leaf<'_>> {
    let mut leaves = Vec::new();
    let (mut next_node, mut next_ref) = (1, 0);
    let mut stack = vec![(0usize, tree.bounds, 0)];
    while let Some((index, cell, depth)) = stack.pop() {
        match tree.nodes[index] {
            Node::Inner { axis, split, children } => {
                assert_eq!(children, next_node, "depth-first order");
                next_node += 2;
                let k = axis as usize;
                assert!(cell.min[k] < split && split < cell.max[k], "the split cuts the cell");
                let (mut below, mut above) = (cell, cell);
                below.max[k] = split;
                above.min[k] = split;
                stack.push((children as usize + 1, above, depth + 1));
                stack.push((children as usize, below, depth + 1));
            }
            Node::Leaf { first, count } => {
                assert_eq!(first, if count == 0 { 0 } else { next_ref }, "references in order");
                next_ref += count;
                let triangles = &tree.refs[first as usize..][..count as usize];
                assert!(triangles.is_sorted_by(|a, b| a < b), "ascending in a leaf");
                leaves.push(Leaf { cell, depth, triangles });
            }
        }
    }
    assert_eq!(next_node as usize, tree.nodes.len(), "every node is reached");
    assert_eq!(next_ref as usize, tree.refs.len(), "every reference belongs to a leaf");
    leaves
}

/// Points all over a triangle, corners and edges included.
fn samples(triangle: &Triangle) -> impl Iterator<Item = DVec3> {
    const STEPS: u32 = 9;
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    (0..=STEPS).flat_map(move |i| (0..=STEPS - i).map(move |j| (i, j))).map(move |(i, j)| {
        let (u, v) = (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
        a * (1.0 - u - v) + b * u + c * v
    })
}

/// Checks everything that the tree promises.
fn check(tree: &KdTree, triangles: &[Triangle], options: &BuildOptions) {
    let usable: Vec<&Triangle> = triangles.iter().filter(|t| is_usable(t)).collect();
    let bounds = if usable.is_empty() {
        Aabb { min: Vec3::ZERO, max: Vec3::ZERO }
    } else {
        Aabb::around(usable.iter().flat_map(|t| t.corners))
    };
    assert_eq!(tree.bounds, bounds);
    let budget = usable.len() as u64 * u64::from(options.max_refs_per_triangle.max(1));
    assert!(tree.refs.len() as u64 <= budget);

    let mut cells = vec![Vec::new(); triangles.len()];
    for leaf in leaves(tree) {
        assert!(leaf.depth <= options.max_depth.unwrap_or(MAX_DEPTH).min(MAX_DEPTH));
        for &index in leaf.triangles {
            cells[index as usize].push(leaf.cell);
        }
    }
    for (index, (triangle, cells)) in triangles.iter().zip(&cells).enumerate() {
        if !is_usable(triangle) {
            assert!(cells.is_empty(), "triangle {index} is left out");
            continue;
        }
        let room = triangle.corners.iter().fold(DVec3::ZERO, |m, c| m.max(c.as_dvec3().abs())) * ROUNDING;
        for point in samples(triangle) {
            let covered = cells.iter().any(|cell| {
                point.cmpge(cell.min.as_dvec3() - room).all() && point.cmple(cell.max.as_dvec3() + room).all()
            });
            assert!(covered, "triangle {index} is missing at {point}");
        }
    }
}

/// Distance along the ray to the triangle (Möller and Trumbore).
fn hit(triangle: &Triangle, origin: DVec3, direction: DVec3) -> Option<f64> {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let s = origin - a;
    let q = s.cross(ab);
    let (u, v) = (s.dot(p) / determinant, direction.dot(q) / determinant);
    let t = ac.dot(q) / determinant;
    (determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// Whether the ray meets the closed box, widened by far more than the rounding of the test.
fn meets(cell: &Aabb, origin: DVec3, direction: DVec3) -> bool {
    let size = (cell.max - cell.min).as_dvec3().max_element() + origin.abs().max_element();
    let room = DVec3::splat(size * 1e-12);
    let (min, max) = (cell.min.as_dvec3() - room, cell.max.as_dvec3() + room);
    let (a, b) = ((min - origin) / direction, (max - origin) / direction);
    a.min(b).max_element().max(0.0) <= a.max(b).min_element()
}

/// Distance to the nearest of the triangles.
fn nearest<'a>(
    triangles: impl Iterator<Item = &'a Triangle>,
    origin: DVec3,
    direction: DVec3,
) -> Option<f64> {
    triangles.filter_map(|t| hit(t, origin, direction)).min_by(f64::total_cmp)
}

/// Fails when a ray finds another hit through the leaves that it meets than among all triangles.
fn check_rays(tree: &KdTree, triangles: &[Triangle], rays: impl Iterator<Item = [DVec3; 2]>) {
    let leaves = leaves(tree);
    for [origin, target] in rays {
        let direction = target - origin;
        let met = leaves
            .iter()
            .filter(|leaf| meets(&leaf.cell, origin, direction))
            .flat_map(|leaf| leaf.triangles.iter().map(|&index| &triangles[index as usize]));
        let all = triangles.iter().filter(|t| is_usable(t));
        assert_eq!(nearest(met, origin, direction), nearest(all, origin, direction));
    }
}

/// A reproducible sequence of numbers from 0 to 1 (xorshift64).
fn numbers() -> impl FnMut() -> f32 {
    let mut state = 0x9E37_79B9_7F4A_7C15u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1u64 << 24) as f32
    }
}

fn random_point(number: &mut impl FnMut() -> f32) -> Vec3 {
    Vec3::new(number(), number(), number())
}

/// Triangles of all sizes in the unit cube.
fn soup(count: usize) -> Vec<Triangle> {
    let mut number = numbers();
    (0..count)
        .map(|_| {
            let centre = random_point(&mut number);
            let size = number().powi(6);
            let corners = [(); 3].map(|()| centre + size * (random_point(&mut number) - 0.5));
            Triangle { corners, material: 0 }
        })
        .collect()
}

/// A square of `side * side * 2` triangles at `height` across `axis`.
fn wall(side: u8, height: f32, axis: usize) -> Vec<Triangle> {
    let at = |x: u8, y: u8| {
        let mut p = [height; 3];
        p[(axis + 1) % 3] = f32::from(x);
        p[(axis + 2) % 3] = f32::from(y);
        p
    };
    (0..side)
        .flat_map(|x| (0..side).map(move |y| (x, y)))
        .flat_map(|(x, y)| {
            [
                triangle([at(x, y), at(x + 1, y), at(x, y + 1)]),
                triangle([at(x + 1, y + 1), at(x, y + 1), at(x + 1, y)]),
            ]
        })
        .collect()
}

#[test]
fn no_triangle_gives_one_empty_leaf_at_the_origin() {
    let flat = triangle([[1.0; 3], [2.0; 3], [3.0; 3]]);
    let infinite = triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    let unknown = triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]]);
    for rule in RULES {
        for triangles in [&[][..], &[flat, infinite, unknown]] {
            let tree = build_quietly(triangles, &options(rule));
            assert_eq!(tree.nodes, [Node::Leaf { first: 0, count: 0 }]);
            assert_eq!(tree.refs, []);
            assert_eq!(tree.bounds, Aabb { min: Vec3::ZERO, max: Vec3::ZERO });
        }
    }
}

#[test]
fn one_triangle_gives_one_leaf() {
    let triangles = [triangle([[1.0, 2.0, 3.0], [5.0, 2.0, 3.0], [1.0, 4.0, 7.0]])];
    for rule in RULES {
        let tree = build_quietly(&triangles, &options(rule));
        assert_eq!(tree.nodes, [Node::Leaf { first: 0, count: 1 }]);
        check(&tree, &triangles, &options(rule));
    }
}

#[test]
fn coincident_triangles_end() {
    let triangles = vec![triangle([[0.0, 0.0, 0.0], [3.0, 1.0, 0.5], [1.0, 2.0, 4.0]]); 5000];
    for rule in RULES {
        for max_depth in [None, Some(MAX_DEPTH)] {
            let options = BuildOptions { max_depth, ..options(rule) };
            check(&build_quietly(&triangles, &options), &triangles, &options);
        }
    }
}

#[test]
fn coplanar_triangles_are_separated() {
    for axis in 0..3 {
        let triangles = wall(16, 2.5, axis);
        for rule in RULES {
            let tree = build_quietly(&triangles, &options(rule));
            check(&tree, &triangles, &options(rule));
            assert!(leaves(&tree).iter().all(|leaf| leaf.triangles.len() <= 8));
        }
    }
}

#[test]
fn triangles_in_the_split_plane_are_kept_once() {
    // The wall in the middle lies in the plane that both rules choose first or soon.
    for axis in 0..3 {
        let triangles = [wall(8, 0.0, axis), wall(8, 4.0, axis), wall(8, 8.0, axis)].concat();
        for rule in RULES {
            let tree = build_quietly(&triangles, &options(rule));
            check(&tree, &triangles, &options(rule));
            let middle = (128..256).map(|i| tree.refs.iter().filter(|r| **r == i).count());
            let worst = middle.max().expect("the middle wall has triangles");
            assert!(worst <= 4, "a triangle of the wall is listed {worst} times");
        }
    }
}

#[test]
fn huge_ranges_end() {
    let mut number = numbers();
    let triangles: Vec<Triangle> = (0..600)
        .map(|i| {
            let scale = 10f32.powi(i % 37 - 18);
            let corners = [(); 3].map(|()| scale * (random_point(&mut number) - 0.5));
            Triangle { corners, material: 0 }
        })
        .chain([triangle([[f32::MAX, 0.0, 0.0], [f32::MIN, 0.0, 0.0], [0.0, f32::MAX, 1e-40]])])
        .collect();
    for rule in RULES {
        for max_depth in [None, Some(u32::MAX)] {
            let options = BuildOptions { max_depth, ..options(rule) };
            check(&build_quietly(&triangles, &options), &triangles, &options);
        }
    }
}

#[test]
fn unusual_costs_end() {
    let triangles = soup(300);
    for cost in [0.0, -1.0, 1e300, f64::INFINITY, f64::NAN] {
        let options = BuildOptions {
            traversal_cost: cost,
            empty_bonus: cost,
            max_leaf: 0,
            max_refs_per_triangle: 0,
            ..BuildOptions::default()
        };
        check(&build_quietly(&triangles, &options), &triangles, &options);
    }
}

#[test]
fn limits_hold() {
    let triangles = soup(2000);
    for rule in RULES {
        for max_depth in [0, 1, 7] {
            let options = BuildOptions { max_depth: Some(max_depth), ..options(rule) };
            check(&build_quietly(&triangles, &options), &triangles, &options);
        }
        let few = BuildOptions { max_refs_per_triangle: 1, max_leaf: 0, ..options(rule) };
        check(&build_quietly(&triangles, &few), &triangles, &few);
    }
}

#[test]
fn surface_area_is_cheaper_than_spatial_median() {
    let triangles = [wall(12, 0.0, 2), soup(3000)].concat();
    let expected_tests = |rule| {
        let tree = build_quietly(&triangles, &options(rule));
        let surface = |cell: &Aabb| {
            let e = (cell.max - cell.min).as_dvec3();
            e.x * e.y + e.y * e.z + e.z * e.x
        };
        leaves(&tree).iter().map(|leaf| surface(&leaf.cell) * leaf.triangles.len() as f64).sum::<f64>()
            / surface(&tree.bounds)
    };
    let [heuristic, median] = RULES.map(expected_tests);
    assert!(heuristic < 0.8 * median, "{heuristic} triangles a ray, {median} by the median");
}

#[test]
fn any_number_of_threads_builds_the_same_tree() {
    let triangles = soup(30_000);
    for rule in RULES {
        let [one, two, five] = [1, 2, 5].map(|threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads can be started")
                .install(|| build_quietly(&triangles, &options(rule)))
        });
        assert_eq!(one, two);
        assert_eq!(one, five);
        check(&one, &triangles, &options(rule));
    }
}

#[test]
fn progress_ascends_to_one() {
    for count in [0, 1, 30_000] {
        let reports = Mutex::new(Vec::new());
        let report = |fraction| reports.lock().expect("no report panics").push(fraction);
        let triangles = soup(count);
        let tree = build(&triangles, &BuildOptions::default(), &report);
        check(&tree, &triangles, &BuildOptions::default());
        let reports = reports.into_inner().expect("no report panics");
        assert!(reports.is_sorted() && reports[0] >= 0.0);
        assert_eq!(reports.last(), Some(&1.0));
        assert!(count < 30_000 || reports.len() > 4);
    }
}

#[test]
fn rays_lose_no_hit() {
    let mut number = numbers();
    let mut triangles = soup(1500);
    let scaled = |mut t: Triangle| {
        t.corners = t.corners.map(|c| c / 8.0);
        t
    };
    triangles.extend((0..3).flat_map(|axis| wall(8, 4.0, axis)).map(scaled));
    let rays: Vec<[DVec3; 2]> =
        (0..400).map(|_| [(); 2].map(|()| (random_point(&mut number) * 3.0 - 1.0).as_dvec3())).collect();
    for rule in RULES {
        let tree = build_quietly(&triangles, &options(rule));
        check_rays(&tree, &triangles, rays.iter().copied());
    }
}

/// The number some steps of the format away.
fn neighbour(x: f32, ulps: i32) -> f32 {
    let step = if ulps < 0 { f32::next_down } else { f32::next_up };
    (0..ulps.abs()).fold(x, |x, _| step(x))
}

/// Coordinates that coincide, that nearly coincide, that lie anywhere, of very different magnitude, and that are no
/// finite numbers.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => (-3..=3i8).prop_map(f32::from),
        4 => (-3..=3i8, -2..=2i32).prop_map(|(x, ulps)| neighbour(f32::from(x), ulps)),
        8 => -3.0..3.0f32,
        2 => (-1.0..1.0f32, -18..=18i32).prop_map(|(x, exponent)| x * 10f32.powi(exponent)),
        1 => prop_oneof![Just(-0.0), Just(f32::NAN), Just(f32::INFINITY), Just(f32::MIN)],
    ]
}

fn triangles(count: usize) -> impl Strategy<Value = Vec<Triangle>> {
    let point = || [coordinate(), coordinate(), coordinate()];
    let one = [point(), point(), point()].prop_map(triangle);
    // A few of them many times over.
    (prop::collection::vec(one, 0..count), 1..4usize).prop_map(|(some, times)| some.repeat(times))
}

fn any_options() -> impl Strategy<Value = BuildOptions> {
    (
        prop_oneof![Just(SplitRule::SurfaceArea), Just(SplitRule::SpatialMedian)],
        0..4u32,
        prop::option::of(0..70u32),
        0.1..8.0f64,
        0.0..1.0f64,
        0..24u32,
    )
        .prop_map(|(rule, max_leaf, max_depth, intersection_cost, empty_bonus, refs)| BuildOptions {
            rule,
            max_leaf,
            max_depth,
            traversal_cost: 1.0,
            intersection_cost,
            empty_bonus,
            max_refs_per_triangle: refs,
        })
}

proptest! {
    #[test]
    fn any_triangles_give_a_valid_tree(triangles in triangles(80), options in any_options()) {
        check(&build_quietly(&triangles, &options), &triangles, &options);
    }

    #[test]
    fn any_triangles_lose_no_hit(
        triangles in triangles(40),
        options in any_options(),
        ends in prop::collection::vec([[-4.0..4.0f64, -4.0..4.0, -4.0..4.0],
                                       [-4.0..4.0f64, -4.0..4.0, -4.0..4.0]], 16),
    ) {
        // Intersection is rounded, so that a hit beside a triangle of extreme shape need not lie
        // in any of its cells.
        let moderate = |t: &Triangle| {
            t.corners.iter().flat_map(Vec3::to_array).all(|x| (1e-3..1e3).contains(&x.abs()) || x == 0.0)
        };
        let triangles: Vec<Triangle> = triangles.into_iter().filter(moderate).collect();
        let tree = build_quietly(&triangles, &options);
        let rays = ends.into_iter().map(|ray| ray.map(DVec3::from_array));
        check_rays(&tree, &triangles, rays);
    }
}
