//! The walk of one ray through a tree, step by step, made of the model's own steps: what a person is
//! shown, and what is counted as coverage.

use super::scene_memory::LegalScene;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::{
    Axis, LIST_ENTRY_BYTES, ListEntry, MAX_DEPTH, NODE_BYTES, NodeRecord, TriangleRecord,
};
use saarcor_model::rays::{
    Children, Hits, IntersectionUnit, Intervals, Packet, Query, Ray, Stack, StoredTriangle, Traversal,
    is_downwards, max, min, reciprocal, visit, widen,
};
use saarcor_model::vm::{HostAddr, Memory, Observed, Observer, Unit, WholeScene};

/// Notes what is read, in order.
#[derive(Default)]
pub(super) struct Reads(pub(super) Vec<(Unit, u32)>);

impl Observer for Reads {
    fn read(&mut self, unit: Unit, addr: HostAddr, _bytes: usize) {
        self.0.push((unit, addr.0));
    }
}

/// What the model says of a ray: its hit, and what it reads.
#[must_use]
pub fn trace(memory: &[u8], scene: &LegalScene, ray: &Ray, query: Query) -> (Hits<1>, Vec<(Unit, u32)>) {
    let mut memory = Observed { memory: WholeScene(memory), observer: Reads::default() };
    let packet = Packet::new([Some(*ray)]);
    let hits =
        Traversal::with(FilteredIntersection::default()).run(&mut memory, &scene.registers, &packet, query);
    (hits, memory.observer.0)
}

/// One step of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The ray is in the cell of an inner node.
    Inner {
        /// Address of the node.
        addr: u32,
        /// Its axis.
        axis: Axis,
        /// Its plane.
        split: f32,
        /// Distances at which the ray enters and leaves the cell.
        interval: (f32, f32),
        /// The children that it goes to.
        visited: Children,
        /// Children on the stack after this step.
        put_off: usize,
    },
    /// The ray is in a leaf.
    Leaf {
        /// Address of the node.
        addr: u32,
        /// Triangles of its list.
        count: u32,
        /// Distances at which the ray enters and leaves the cell.
        interval: (f32, f32),
        /// Something was hit before.
        after_hit: bool,
    },
    /// A child from the stack lies behind the hit so far.
    Culled,
    /// The ray is tested against a triangle.
    Test {
        /// Address of the triangle.
        addr: u32,
        /// Whether it is what is hit now.
        taken: bool,
        /// Whether something else was hit before.
        replaces: bool,
    },
}

/// A node to visit, and the part of the ray in its cell.
pub(super) type Visit = (HostAddr, (f32, f32));

/// The steps of a ray that asks for the closest hit, until its end.
#[must_use]
pub fn steps(memory: &[u8], scene: &LegalScene, ray: &Ray) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut memory = WholeScene(memory);
    let packet = Packet::new([Some(*ray)]);
    let mut hits = Hits::none(&packet);
    let mut unit = FilteredIntersection::default();
    let reciprocals = reciprocals(scene, ray);
    let mut stack = Stack::<Visit, MAX_DEPTH>::new((HostAddr(0), (0.0, 0.0)));
    stack.begin((scene.registers.root, in_bounds(scene, ray, &reciprocals)));
    while let Some((mut addr, (enter, leave))) = stack.resume() {
        let (mut enter, mut leave) = (enter, min(hits.t[0], leave));
        if enter > leave {
            steps.push(Step::Culled);
            continue;
        }
        let (list, count) = loop {
            match NodeRecord::decode(memory.fetch(Unit::Traversal, addr)) {
                NodeRecord::Leaf { list, count } => break (list, count),
                NodeRecord::Inner { axis, split, below } => {
                    let interval = (enter, leave);
                    let (visited, below, above) = children(ray, &reciprocals, (axis, split, below), interval);
                    let next = if stack.descend(visited, &below, &above) { above } else { below };
                    steps.push(Step::Inner {
                        addr: addr.0,
                        axis,
                        split,
                        interval,
                        visited,
                        put_off: stack.len,
                    });
                    (addr, (enter, leave)) = next;
                }
            }
        };
        let after_hit = hits.is_hit(0);
        steps.push(Step::Leaf { addr: addr.0, count, interval: (enter, leave), after_hit });
        for entry in 0..count {
            let entry = memory.fetch(Unit::List, list.offset(entry * LIST_ENTRY_BYTES));
            let ListEntry { triangle, tag } = ListEntry::decode(entry);
            let before = hits.triangle[0];
            let record = TriangleRecord::decode(memory.fetch(Unit::Intersection, triangle), tag);
            let stored = StoredTriangle {
                addr: triangle,
                kernel: scene.registers.kernel,
                edges: scene.registers.edges,
                record,
            };
            let cell = Intervals { enter: [enter], leave: [leave] };
            unit.intersect(&stored, &packet, &cell, Query::Closest, &mut hits);
            let taken = hits.triangle[0] != before;
            steps.push(Step::Test { addr: triangle.0, taken, replaces: before != Hits::<1>::NOTHING });
        }
    }
    steps
}

/// One over the components of the direction, as the traversal unit takes them.
#[must_use]
pub fn reciprocals(scene: &LegalScene, ray: &Ray) -> [f32; 3] {
    let bounds = &scene.registers.bounds;
    std::array::from_fn(|axis| {
        let origin = ray.origin[axis];
        let reach = max((bounds.min[axis] - origin).abs(), (bounds.max[axis] - origin).abs());
        reciprocal(ray.direction[axis], reach)
    })
}

/// The children of an inner node, with the parts of the ray in their cells: which are visited, the one below the plane and
/// the one above.
pub(super) fn children(
    ray: &Ray,
    reciprocals: &[f32; 3],
    (axis, split, child): (Axis, f32, HostAddr),
    (enter, leave): (f32, f32),
) -> (Children, Visit, Visit) {
    let reciprocal = reciprocals[axis as usize];
    let distances = widen((split - ray.origin[axis as usize]) * reciprocal);
    let [below, above] = visit(enter, leave, distances, is_downwards(reciprocal));
    let met = [below, above].map(|(enter, leave)| enter <= leave);
    let visited = Children::met(met[0], met[1], || is_downwards(reciprocal));
    (visited, (child, below), (child.offset(NODE_BYTES), above))
}

/// The part of a ray in the box around the scene.
pub(super) fn in_bounds(scene: &LegalScene, ray: &Ray, reciprocals: &[f32; 3]) -> (f32, f32) {
    let bounds = &scene.registers.bounds;
    let (mut enter, mut leave) = (ray.t_min, ray.t_max);
    for (axis, &reciprocal) in reciprocals.iter().enumerate() {
        let (low, high, origin) = (bounds.min[axis], bounds.max[axis], ray.origin[axis]);
        let (near, far) = if is_downwards(reciprocal) { (high, low) } else { (low, high) };
        enter = max(widen((near - origin) * reciprocal).0, enter);
        leave = min(widen((far - origin) * reciprocal).1, leave);
    }
    (enter, leave)
}

impl Step {
    /// The step for a person.
    #[must_use]
    pub fn text(&self) -> String {
        let between = |(enter, leave): (f32, f32)| format!("t {enter} to {leave}");
        match *self {
            Self::Inner { addr, axis, split, interval, visited, .. } => {
                let axis = ["x", "y", "z"][axis as usize];
                let to = match visited {
                    Children::Below => "below",
                    Children::Above => "above",
                    Children::BelowFirst => "below, then above",
                    Children::AboveFirst => "above, then below",
                };
                format!("node {addr:x}, plane {axis} = {split}, {}: {to}", between(interval))
            }
            Self::Leaf { addr, count, interval, .. } => {
                format!("leaf {addr:x} of {count} triangles, {}", between(interval))
            }
            Self::Culled => "a cell put off lies behind the hit, or the box is missed".to_owned(),
            Self::Test { addr, taken, .. } => {
                format!("triangle {addr:x}: {}", if taken { "the closest hit by now" } else { "not taken" })
            }
        }
    }
}
