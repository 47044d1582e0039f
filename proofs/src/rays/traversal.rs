//! Theorems of the traversal unit (KD-3, KD-4): where a ray's interval goes at a node, and the
//! walk of a packet through the tree.
//!
//! What happens to an interval is decided by comparisons alone, and comparisons of floats see no
//! more than their order: small scopes are the floats that differ in it, that is both infinities
//! and NaN, both zeros, the largest and the least numbers, and neighbours around 1.

use crate::draw::{self, BYTES};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use glam::Vec3;
use saarcor_model::host::{Aabb, Axis, Edges, Features, Kernel, NodeRecord, Registers};
use saarcor_model::rays::{
    Children, Intervals, Packet, Query, Ray, Stack, Traversal, is_downwards, max, min, visit, widen,
};
use saarcor_model::vm::{HostAddr, Observed, Observer, Unit, WholeScene};

/// Floats by their bits, in ascending order; NaN is the last.
static FLOATS: [u32; 14] = [
    f32::NEG_INFINITY.to_bits(),
    f32::MIN.to_bits(),
    (-1.0_f32).to_bits(),
    0x8000_0001,
    (-0.0_f32).to_bits(),
    0.0_f32.to_bits(),
    0x0000_0001,
    1.0_f32.to_bits() - 1,
    1.0_f32.to_bits(),
    1.0_f32.to_bits() + 1,
    2.0_f32.to_bits(),
    f32::MAX.to_bits(),
    f32::INFINITY.to_bits(),
    f32::NAN.to_bits(),
];

/// A few of them, for theorems that draw several: a distance on either side of any of the others.
static FEW: [u32; 8] =
    [FLOATS[0], FLOATS[2], FLOATS[4], FLOATS[7], FLOATS[8], FLOATS[9], FLOATS[11], FLOATS[12]];

/// The first and the last float of each exponent, of either sign: between them rounding is alike.
static EXPONENTS: [u32; 1024] = {
    let mut floats = [0; 1024];
    let mut i = 0;
    while i < 1024 {
        let mantissa = if i % 2 == 0 { 0 } else { (1 << 23) - 1 };
        floats[i] = ((i as u32 >> 1) << 23) | mantissa;
        i += 1;
    }
    floats
};

/// Any float, by its bits: NaN, infinities and both zeros are some.
fn float(s: &mut impl Source, name: &'static str) -> f32 {
    f32::from_bits(s.value(name, 0..=u32::MAX, &FLOATS))
}

/// Any distances between which a plane is met, as `widen` gives them: in order, or both NaN.
fn plane(s: &mut impl Source) -> (f32, f32) {
    let (a, b) = (float(s, "bits of a distance of the plane"), float(s, "bits of another"));
    match (a <= b, b < a) {
        (true, _) => (a, b),
        (_, true) => (b, a),
        _ => (f32::NAN, f32::NAN),
    }
}

/// Any interval of a ray in a cell: two distances in any order, none of them NaN.
fn interval<S: Source>(s: &mut S) -> Result<(f32, f32), Stop> {
    let (enter, leave) = (float(s, "bits of enter"), float(s, "bits of leave"));
    assume!(!enter.is_nan() && !leave.is_nan());
    Ok((enter, leave))
}

/// Any interval of a ray that meets the cell.
fn meeting<S: Source>(s: &mut S) -> Result<(f32, f32), Stop> {
    let (enter, leave) = interval(s)?;
    Ok(if enter <= leave { (enter, leave) } else { (leave, enter) })
}

/// Whether a distance lies in an interval.
fn holds((enter, leave): (f32, f32), t: f32) -> bool {
    enter <= t && t <= leave
}

/// The two numbers have the same bits: NaN equals itself, and zeros differ.
fn same(a: (f32, f32), b: (f32, f32)) -> bool {
    a.0.to_bits() == b.0.to_bits() && a.1.to_bits() == b.1.to_bits()
}

/// The nodes that are read, in order.
#[derive(Default)]
struct NodesRead(Vec<u32>);

impl Observer for NodesRead {
    fn read(&mut self, unit: Unit, addr: HostAddr, _bytes: usize) {
        if unit == Unit::Traversal {
            self.0.push(addr.0);
        }
    }
}

/// The nodes that a packet reads of a tree whose root, at 0, cuts the box in x at `split` into two empty leaves, that below at 8.
fn nodes_read<const N: usize>(bounds: Aabb, split: f32, rays: [Option<Ray>; N]) -> Vec<u32> {
    let leaf = NodeRecord::Leaf { list: HostAddr(64), count: 0 };
    let root = NodeRecord::Inner { axis: Axis::X, split, below: HostAddr(8) };
    let image: Vec<u8> = [root, leaf, leaf].into_iter().flat_map(NodeRecord::encode).collect();
    let registers = Registers {
        root: HostAddr(0),
        bounds,
        kernel: Kernel::MollerTrumbore,
        edges: Edges::Shared,
        triangles: HostAddr(64),
        shading: HostAddr(64),
        features: Features::default(),
        lights: Vec::new(),
    };
    let mut memory = Observed { memory: WholeScene(&image), observer: NodesRead::default() };
    Traversal::<N>::default().run(&mut memory, &registers, &Packet::new(rays), Query::Closest);
    memory.observer.0
}

/// Any visit of a node's children.
fn children(s: &mut impl Source) -> Children {
    match s.value("children (below, above, below first, above first)", 0..=3, &BYTES[..4]) {
        0 => Children::Below,
        1 => Children::Above,
        2 => Children::BelowFirst,
        _ => Children::AboveFirst,
    }
}

/// Inner nodes on a path of the trees that are walked as a whole.
const LEVELS: usize = 3;
/// Numbers of nodes of a full tree of that many levels of inner nodes: the root is 1, and the
/// children of `n` are `2n` and `2n + 1`.
const NODES: usize = 2 << LEVELS;
/// Children put off at most in the theorem of one step.
const ROOM: usize = 4;

/// A part of a walk: the leaves `first .. end` that the walk is led to, by their place in the
/// walk, below a node with at most `height` inner nodes on a path from it on, itself included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part {
    first: u8,
    end: u8,
    height: u8,
}

/// A part that no walk is led to.
const NO_PART: Part = Part { first: u8::MAX, end: 0, height: u8::MAX };

/// Whether the walk is before leaf `visited`, and the parts ahead of it are all leaves from there
/// to `end` in their order, with room for what they may put off.
fn is_before(stack: &Stack<Part, ROOM>, at: Part, visited: u8, end: u8) -> bool {
    let mut ordered = at.first == visited && at.first < at.end;
    let mut fits = stack.len <= ROOM && stack.len + usize::from(at.height) <= ROOM;
    // From the bottom of the stack up: each part ends where the one below it begins.
    let mut next = end;
    for place in 0..ROOM {
        if place < stack.len {
            let part = stack.put_off[place];
            ordered &= part.first < part.end && part.end == next;
            fits &= place + usize::from(part.height) <= ROOM;
            next = part.first;
        }
    }
    ordered && fits && at.end == next
}

theorems! {
    /// A packet that walks a tree visits exactly the leaves to which its decisions lead, each once, the
    /// near ones before the far ones; the stack never holds more children than there are inner nodes
    /// above.
    #["KD-4", unwind 17, covers ["five leaves or more", "one leaf", "a full stack", "leaves of two levels"]]
    fn walk_visits_each_leaf_once_near_before_far(s) {
        // Every tree of up to three inner nodes on a path, and every decision at each of them. A
        // walk through deeper ones is made of the same steps, of which the next theorem speaks. A
        // child put off that is dropped later, since a hit lies before it, is a leaf here.
        s.size("inner nodes on a path", LEVELS);
        let mut inner = [false; NODES];
        let mut decisions = [Children::Below; NODES];
        // What is expected, from the root down: which nodes the packet is led to, and for each how
        // many leaves of a full tree lie before it in the order of the walk.
        let mut led_to = [false; NODES];
        let mut before = [0_u8; NODES];
        led_to[1] = true;
        for node in 1..NODES / 2 {
            // A node that the packet is not led to is not looked at.
            if led_to[node] && draw::flag(s, "is an inner node") {
                inner[node] = true;
                decisions[node] = children(s);
                let far = (NODES as u8 / 4) >> node.ilog2();
                let (below, above) = (2 * node, 2 * node + 1);
                led_to[below] = decisions[node] != Children::Above;
                led_to[above] = decisions[node] != Children::Below;
                let above_first = decisions[node] == Children::AboveFirst;
                before[below] = before[node] + if above_first { far } else { 0 };
                before[above] = before[node] + if above_first { 0 } else { far };
            }
        }
        let mut expected = [0_u8; NODES / 2];
        for node in 1..NODES {
            if led_to[node] && !inner[node] {
                expected[before[node] as usize] = node as u8;
            }
        }

        let mut stack = Stack::<u8, LEVELS>::new(0);
        stack.begin(1);
        let mut at = stack.resume();
        let mut visited = [0_u8; NODES / 2];
        let mut leaves = 0;
        let mut deepest = 0;
        // A walk is never at a node twice.
        for _ in 1..NODES {
            if let Some(node) = at {
                let level = node.ilog2() as usize;
                check!(stack.len <= level, "{} children put off at node {node}, {level} inner nodes above", stack.len);
                deepest = if stack.len > deepest { stack.len } else { deepest };
                at = if inner[usize::from(node)] {
                    let goes_above = stack.descend(decisions[usize::from(node)], &(2 * node), &(2 * node + 1));
                    Some(2 * node + u8::from(goes_above))
                } else {
                    check!(leaves < NODES / 2, "a ninth leaf: {node} after {visited:?}");
                    visited[leaves] = node;
                    leaves += 1;
                    stack.resume()
                };
            }
        }
        cover!(s, "five leaves or more", leaves >= 5);
        cover!(s, "one leaf", leaves == 1 && inner[1]);
        cover!(s, "a full stack", deepest == LEVELS);
        cover!(s, "leaves of two levels", leaves > 1 && visited[0].ilog2() != visited[leaves - 1].ilog2());
        check_eq!(at, None, "the walk goes on after {visited:?}; inner nodes {inner:?}, {decisions:?}");
        // The expected leaves without the gaps between them.
        let mut place = 0;
        for leaf in expected {
            if leaf != 0 {
                check!(place < leaves && visited[place] == leaf, "visited {visited:?}, expected {expected:?}; inner nodes {inner:?}, {decisions:?}");
                place += 1;
            }
        }
        check_eq!(leaves, place, "leaves visited: {visited:?}, expected {expected:?}; inner nodes {inner:?}, {decisions:?}");
    }

    /// However deep the tree: after a step down to a child, or on from a leaf, the stack still holds
    /// all leaves that are not yet visited, the near ones before the far ones, and has room for all
    /// that lies below.
    #["KD-4", unwind 6, covers ["step to one child", "step to both", "on from a leaf", "the last leaf", "a full stack"]]
    fn step_keeps_the_rest_of_the_walk(s) {
        // The induction step to the theorem before: leaves are numbered in the order of the walk,
        // and so the walk is right exactly if it comes to them one after another. What a step does
        // to a child put off depends on nothing but its place in the stack, of which the lowest,
        // the highest and those between are there with room for four.
        let len = s.value("children put off", 0..=ROOM as u8, &BYTES[..5]);
        let mut stack = Stack::<Part, ROOM>::new(NO_PART);
        stack.len = usize::from(len);
        let visited = s.value("leaves visited", 0..=100, &BYTES[..1]);
        let size = s.value("leaves below the node", 1..=10_u8, &BYTES[1..4]);
        let at = Part { first: visited, end: visited + size, height: s.value("height of the node", 0..=ROOM as u8, &BYTES[..4]) };
        assume!(len + at.height <= ROOM as u8);
        let mut end = at.end;
        for place in (0..ROOM).rev() {
            if place < stack.len {
                let first = end;
                end += s.value("leaves below a child put off", 1..=10_u8, &BYTES[1..3]);
                let height = s.value("height of a child put off", 0..=ROOM as u8, &BYTES[..4]);
                stack.put_off[place] = Part { first, end, height };
            }
        }
        assume!(is_before(&stack, at, visited, end));
        cover!(s, "a full stack", stack.len == ROOM);

        let was = stack;
        if at.height == 0 {
            // A leaf: the one that the walk is to come to.
            assume!(size == 1);
            cover!(s, "on from a leaf", true);
            match stack.resume() {
                Some(next) => {
                    check!(is_before(&stack, next, visited + 1, end), "on from {at:?} to {next:?}, {was:?} became {stack:?}");
                }
                None => {
                    cover!(s, "the last leaf", true);
                    check_eq!((visited + 1, was.len), (end, 0), "the walk ends after {at:?} with {was:?}");
                }
            }
        } else {
            let children = children(s);
            let far = s.value("leaves below the far child", 0..=10_u8, &BYTES[..3]);
            let height = at.height - 1;
            let near = Part { end: at.end.wrapping_sub(far), height, ..at };
            let far_part = Part { first: near.end, height, ..at };
            let (below, above) = match children {
                Children::Below => (near, NO_PART),
                Children::Above => (NO_PART, near),
                Children::BelowFirst => (near, far_part),
                Children::AboveFirst => (far_part, near),
            };
            let both = matches!(children, Children::BelowFirst | Children::AboveFirst);
            // Each child that the walk is led to has leaves that it is led to.
            assume!(far < size && both == (far > 0));
            cover!(s, "step to one child", !both);
            cover!(s, "step to both", both);
            let next = if stack.descend(children, &below, &above) { above } else { below };
            check!(is_before(&stack, next, visited, end), "{children:?} from {at:?} to {next:?}: {was:?} became {stack:?}");
        }
    }

    /// A packet visits a child exactly if one of its rays meets it; if it visits both, it begins on the
    /// side from which the deciding ray comes.
    #["KD-3", unwind 5, covers ["below", "above", "both, upwards", "both, downwards"]]
    fn children_visited_are_those_met(s) {
        let (below, above) = (draw::flag(s, "meets the one below"), draw::flag(s, "meets the one above"));
        let downwards = draw::flag(s, "downwards");
        // That a child is met is the theorem `no_part_of_a_ray_is_lost`.
        assume!(below || above);
        cover!(s, "below", below && !above);
        cover!(s, "above", above && !below);
        cover!(s, "both, upwards", below && above && !downwards);
        cover!(s, "both, downwards", below && above && downwards);
        let visited = Children::met(below, above, || downwards);
        check_eq!(visited != Children::Above, below, "below {below}, above {above}, downwards {downwards}: visits {visited:?}");
        check_eq!(visited != Children::Below, above, "below {below}, above {above}, downwards {downwards}: visits {visited:?}");
        if below && above {
            check_eq!(visited == Children::AboveFirst, downwards, "both, downwards {downwards}: visits {visited:?}");
        }
    }

    /// No part of a ray is lost at a node, whatever the distance of the split plane: each point of the
    /// ray in the cell lies in the child below, in the child above, or in both.
    #["KD-3", unwind 6, covers ["below alone", "above alone", "both", "NaN", "infinite"]]
    fn no_part_of_a_ray_is_lost(s) {
        let plane = plane(s);
        let cell = meeting(s)?;
        let (t, downwards) = (float(s, "bits of a distance"), draw::flag(s, "downwards"));
        assume!(holds(cell, t));
        let [below, above] = visit(cell.0, cell.1, plane, downwards);
        cover!(s, "below alone", holds(below, t) && !holds(above, t));
        cover!(s, "above alone", holds(above, t) && !holds(below, t));
        cover!(s, "both", holds(below, t) && holds(above, t));
        cover!(s, "NaN", plane.0.is_nan());
        cover!(s, "infinite", plane.0.is_infinite());
        check!(holds(below, t) || holds(above, t), "{t} of {cell:?} at the plane {plane:?}: below {below:?}, above {above:?}");
    }

    /// The near child has the ray from where it enters the cell to the greatest distance of the split
    /// plane or the end of the cell; the far child has it from the least distance of the plane or the
    /// beginning of the cell to where it leaves the cell.
    #["KD-3", unwind 4, covers ["the plane cuts the ray", "the plane lies behind", "the plane lies before"]]
    fn children_have_their_side_of_the_plane(s) {
        // Both ends are enough for all between, since no end is cut off by both of two numbers.
        let plane = plane(s);
        let cell = interval(s)?;
        let downwards = draw::flag(s, "downwards");
        let [below, above] = visit(cell.0, cell.1, plane, downwards);
        let (near, far) = if downwards { (above, below) } else { (below, above) };
        cover!(s, "the plane cuts the ray", cell.0 < plane.0 && plane.1 < cell.1);
        cover!(s, "the plane lies behind", cell.1 < plane.0);
        cover!(s, "the plane lies before", plane.1 < cell.0);
        check!(near.0 == cell.0 && (near.1 == plane.1 || near.1 == cell.1), "{cell:?} at the plane {plane:?}: near {near:?}");
        check!(far.1 == cell.1 && (far.0 == plane.0 || far.0 == cell.0), "{cell:?} at the plane {plane:?}: far {far:?}");
    }

    /// A child's interval lies within its parent's: the near child's ends no later than the greatest
    /// distance of the split plane, and the far child's begins no earlier than the least.
    #["KD-3", unwind 4, covers ["misses the far child", "misses the near child", "meets both"]]
    fn child_interval_lies_within_its_parents(s) {
        let plane = plane(s);
        let (enter, leave) = interval(s)?;
        let downwards = draw::flag(s, "downwards");
        assume!(!plane.0.is_nan());
        let [below, above] = visit(enter, leave, plane, downwards);
        let (near, far) = if downwards { (above, below) } else { (below, above) };
        let meets = |(enter, leave): (f32, f32)| enter <= leave;
        cover!(s, "misses the far child", meets(near) && !meets(far));
        cover!(s, "misses the near child", meets(far) && !meets(near));
        cover!(s, "meets both", meets(near) && meets(far));
        let near_fits = near.0 == enter && near.1 <= leave && near.1 <= plane.1;
        let far_fits = far.1 == leave && far.0 >= enter && far.0 >= plane.0;
        check!(near_fits, "near {near:?}: {enter} .. {leave} at the plane {plane:?}");
        check!(far_fits, "far {far:?}: {enter} .. {leave} at the plane {plane:?}");
    }

    /// A point of a ray that lies in the first child alone is nearer than one that lies in the other
    /// alone; the first child is the one above if the ray goes downwards, and else the one below.
    #["KD-4", unwind 3, covers ["upwards", "downwards"]]
    fn first_child_is_the_near_one(s) {
        let plane = plane(s);
        let cell = meeting(s)?;
        let a = f32::from_bits(s.value("bits of a distance", 0..=u32::MAX, &FEW));
        let b = f32::from_bits(s.value("bits of another distance", 0..=u32::MAX, &FEW));
        let downwards = draw::flag(s, "downwards");
        let [below, above] = visit(cell.0, cell.1, plane, downwards);
        let (first, other) = match Children::met(true, true, || downwards) {
            Children::AboveFirst => (above, below),
            _ => (below, above),
        };
        assume!(holds(first, a) && !holds(other, a) && holds(other, b) && !holds(first, b));
        cover!(s, "upwards", !downwards);
        cover!(s, "downwards", downwards);
        check!(a < b, "{a} in {first:?}, {b} in {other:?}: {cell:?} at the plane {plane:?}");
    }

    /// Of two children, a packet goes first to the one that the first of its rays in the cell meets first: lanes without a ray,
    /// and rays that miss the cell, decide nothing.
    #["KD-4", not_for_kani "it is a whole walk, with distances in floating point", covers ["lane 0 decides", "a lane behind a ray that misses", "a lane behind an empty one", "nobody", "upwards", "downwards"]]
    fn first_ray_in_the_cell_decides_the_order(s) {
        // Rays along x through the middle of the box, which its plane cuts, or past it.
        let mut rays = [None; 4];
        let mut decides = None;
        for lane in 0..4 {
            let kind = s.value("ray (none, up past, down past, up, down)", 0..=4, &BYTES[..5]);
            let (meets, downwards) = (kind >= 3, matches!(kind, 2 | 4));
            let y = if meets { 0.5 } else { 1.5 };
            let (x, towards) = if downwards { (3.0, -1.0) } else { (-1.0, 1.0) };
            if kind > 0 {
                let (origin, direction) = (Vec3::new(x, y, 0.5), Vec3::new(towards, 0.0, 0.0));
                rays[lane] = Some(Ray { origin, direction, t_min: 0.0, t_max: 8.0 });
            }
            if meets && decides.is_none() {
                decides = Some((lane, downwards));
                cover!(s, "lane 0 decides", lane == 0);
                cover!(s, "a lane behind a ray that misses", lane > 0 && rays[0].is_some());
                cover!(s, "a lane behind an empty one", lane > 0 && rays[0].is_none());
                cover!(s, "upwards", !downwards);
                cover!(s, "downwards", downwards);
            }
        }
        cover!(s, "nobody", decides.is_none());
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0) };
        let read = nodes_read(bounds, 1.0, rays);
        let expected: &[u32] = match decides {
            None => &[],
            Some((_, false)) => &[0, 8, 16],
            Some((_, true)) => &[0, 16, 8],
        };
        check_eq!(&read[..], expected, "nodes read for {rays:?}");
    }

    /// A ray whose distances along an axis have no bound goes to both children, and to the one below first: where the farther of
    /// the two sides of the box, whichever it is, lies so far away that its distance overflows. Else it goes to the
    /// other child only where it comes to the plane.
    #["KD-3", not_for_kani "it is a whole walk, with distances in floating point", covers ["above alone", "below alone", "both", "bounded, to both", "bounded, to one"]]
    fn ray_without_a_bound_goes_to_both_children(s) {
        let low = s.value("exponent of the side below, and 20", 0..=147_u8, &[20, 47, 120, 147]);
        let high = s.value("exponent of the side above, and 20", 0..=147_u8, &[20, 47, 120, 147]);
        let (low, high) = (i32::from(low) - 20, i32::from(high) - 20);
        let slow = i32::from(s.value("exponent of the reciprocal", 0..=126_u8, &[0, 1, 27, 28, 40, 100, 126]));
        let power = |exponent: i32| 2.0_f32.powi(exponent);
        // From within the box, towards the plane in the middle of its upper part.
        let direction = Vec3::new(power(-slow), 0.0, 1.0);
        let ray = Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: 0.5 };
        let bounds = Aabb { min: Vec3::new(-power(low), -1.0, -1.0), max: Vec3::new(power(high), 1.0, 1.0) };
        let read = nodes_read(bounds, power(high - 1), [Some(ray)]);
        let has_bound = |side: i32| side + slow < 128;
        let (below, above) = (has_bound(low), has_bound(high));
        let comes_to_the_plane = high - 1 + slow < 0;
        cover!(s, "above alone", below && !above);
        cover!(s, "below alone", !below && above && !comes_to_the_plane);
        cover!(s, "both", !below && !above);
        cover!(s, "bounded, to both", below && above && comes_to_the_plane);
        cover!(s, "bounded, to one", below && above && !comes_to_the_plane);
        let to_both = !(below && above) || comes_to_the_plane;
        let expected: &[u32] = if to_both { &[0, 8, 16] } else { &[0, 8] };
        check_eq!(&read[..], expected, "nodes read for {ray:?} in {bounds:?}");
    }

    /// A ray in the split plane, whose distance to it is NaN, keeps its whole interval in both
    /// children.
    #["KD-3", unwind 4, covers ["upwards", "downwards", "an empty interval"]]
    fn ray_in_the_plane_goes_to_both_children(s) {
        let (enter, leave) = (float(s, "bits of enter"), float(s, "bits of leave"));
        let downwards = draw::flag(s, "downwards");
        cover!(s, "upwards", !downwards);
        cover!(s, "downwards", downwards);
        cover!(s, "an empty interval", enter > leave);
        let [below, above] = visit(enter, leave, (f32::NAN, f32::NAN), downwards);
        let cell = (enter, leave);
        check!(same(below, cell) && same(above, cell), "{cell:?} at NaN, downwards {downwards}: below {below:?}, above {above:?}");
    }

    /// A ray parallel to the split plane, whose distance to it is infinite, keeps its whole interval in
    /// the child on its own side and does not meet the other child; it is below the plane if distance
    /// and direction have the same sign, and else above.
    #["KD-3", unwind 5, covers ["below, upwards", "below, downwards", "above, upwards", "above, downwards"]]
    fn parallel_ray_stays_on_its_side(s) {
        let cell = meeting(s)?;
        let (negative, downwards) = (draw::flag(s, "distance is negative"), draw::flag(s, "downwards"));
        // A ray that meets a cell is bounded by the box around the scene.
        assume!(cell.0.is_finite() && cell.1.is_finite());
        // (split - origin) / ±0: the plane is above the ray exactly if the signs are the same.
        let t = if negative { f32::NEG_INFINITY } else { f32::INFINITY };
        let is_below = negative == downwards;
        cover!(s, "below, upwards", is_below && !downwards);
        cover!(s, "below, downwards", is_below && downwards);
        cover!(s, "above, upwards", !is_below && !downwards);
        cover!(s, "above, downwards", !is_below && downwards);
        let [below, above] = visit(cell.0, cell.1, (t, t), downwards);
        let (own, other) = if is_below { (below, above) } else { (above, below) };
        check!(same(own, cell), "{cell:?} at {t}, downwards {downwards}: own side {own:?}");
        check!(other.0 > other.1, "{cell:?} at {t}, downwards {downwards}: other side {other:?}");
    }

    /// Widening a distance gives two distances in order; both are NaN if it is NaN, and both equal it
    /// if it is infinite.
    #["KD-3", unwind 6, covers ["positive", "negative", "zero", "NaN", "infinite"]]
    fn widened_distances_are_in_order(s) {
        // That they enclose the distance is more than a prover of bits can say of two products in
        // a minute: tests/traversal.rs tries the floats. Here is what the theorems above assume.
        let t = f32::from_bits(s.value("bits of a distance", 0..=u32::MAX, &EXPONENTS));
        cover!(s, "positive", t > 0.0);
        cover!(s, "negative", t < 0.0);
        cover!(s, "zero", t == 0.0);
        cover!(s, "NaN", t.is_nan());
        cover!(s, "infinite", t.is_infinite());
        let (least, greatest) = widen(t);
        check_eq!((least.is_nan(), greatest.is_nan()), (t.is_nan(), t.is_nan()), "{t}: {least} to {greatest}");
        check!(t.is_nan() || least <= greatest, "{t}: {least} to {greatest}");
        check!(!t.is_infinite() || (least == t && greatest == t), "{t}: {least} to {greatest}");
    }

    /// A ray goes downwards along an axis exactly if its direction has the sign of a negative
    /// number there, −0.0 included.
    #["KD-3", unwind 5, covers ["upwards", "downwards", "0.0", "-0.0"]]
    fn sign_of_the_direction_decides_what_is_downwards(s) {
        let direction = f32::from_bits(s.value("bits of the direction", 0..=u32::MAX, &EXPONENTS));
        assume!(direction.is_finite());
        let zero = direction == 0.0;
        cover!(s, "upwards", direction > 0.0);
        cover!(s, "downwards", direction < 0.0);
        cover!(s, "0.0", zero && direction.is_sign_positive());
        cover!(s, "-0.0", zero && direction.is_sign_negative());
        check_eq!(is_downwards(1.0 / direction), direction.is_sign_negative(), "direction {direction}");
    }

    /// `min` and `max` return the lesser and the greater of two numbers, and the second operand on NaN
    /// or equality.
    #["KD-3", unwind 6, covers ["the first is less", "the second is less", "equal", "the first is NaN", "the second is NaN"]]
    fn min_and_max_return_the_second_beside_nan(s) {
        let (a, b) = (float(s, "bits of the first"), float(s, "bits of the second"));
        cover!(s, "the first is less", a < b);
        cover!(s, "the second is less", b < a);
        cover!(s, "equal", a == b);
        cover!(s, "the first is NaN", a.is_nan() && !b.is_nan());
        cover!(s, "the second is NaN", b.is_nan() && !a.is_nan());
        let (least, greatest) = (min(a, b), max(a, b));
        let expected = (if a < b { a } else { b }, if b < a { a } else { b });
        check!(same((least, greatest), expected), "{a} and {b}: {least}, {greatest}");
        if !a.is_nan() && !b.is_nan() {
            check!(least <= a && least <= b && a <= greatest && b <= greatest, "{a} and {b}: {least}, {greatest}");
        }
    }

    /// A hit cuts off the part of its own ray that lies behind it, and nothing else; a hit at minus
    /// infinity, which stands for any hit, ends the ray.
    #["KD-4", unwind 4, covers ["before the hit", "behind the hit", "any hit"]]
    fn hits_cut_off_what_lies_behind(s) {
        // Two rays: the hit's own, and another.
        let (enter, leave) = interval(s)?;
        let (hit, t) = (float(s, "bits of the hit"), float(s, "bits of a distance"));
        assume!(!hit.is_nan());
        let mut cell = Intervals { enter: [enter, 0.0], leave: [leave, 1.0] };
        cell.clip(&[hit, f32::INFINITY]);
        let clipped = (cell.enter[0], cell.leave[0]);
        cover!(s, "before the hit", holds((enter, leave), t) && t <= hit);
        cover!(s, "behind the hit", holds((enter, leave), t) && t > hit);
        cover!(s, "any hit", hit == f32::NEG_INFINITY && enter <= leave);
        check_eq!(holds(clipped, t), holds((enter, leave), t) && t <= hit, "{t} of {enter} .. {leave} before {hit}: {clipped:?}");
        check!(same((cell.enter[1], cell.leave[1]), (0.0, 1.0)), "the other ray: {} .. {}", cell.enter[1], cell.leave[1]);
        if hit == f32::NEG_INFINITY && enter > hit {
            check!(clipped.0 > clipped.1, "{enter} .. {leave} after any hit: {clipped:?}");
        }
    }

    /// A packet meets a cell exactly if one of its rays does; the first of these rays decides the order
    /// of the children.
    #["KD-3", unwind 4, covers ["no ray", "the last ray alone", "NaN"]]
    fn packet_meets_what_one_of_its_rays_meets(s) {
        // Three rays: the first, the last, and one between.
        let (mut cell, mut met) = (Intervals { enter: [0.0; 3], leave: [0.0; 3] }, None);
        let mut nan = false;
        for ray in 0..3 {
            let (enter, leave) = (float(s, "bits of enter"), f32::from_bits(s.value("bits of leave", 0..=u32::MAX, &FLOATS[4..6])));
            (cell.enter[ray], cell.leave[ray]) = (enter, leave);
            nan |= enter.is_nan();
            if met.is_none() && enter <= leave {
                met = Some(ray);
            }
        }
        cover!(s, "no ray", met.is_none());
        cover!(s, "the last ray alone", met == Some(2));
        cover!(s, "NaN", nan);
        check_eq!(cell.any(), met.is_some(), "{cell:?}");
        check_eq!(cell.first(), met, "{cell:?}");
    }
}
