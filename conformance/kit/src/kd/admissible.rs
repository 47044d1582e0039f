//! Which walks are right.
//!
//! What is hit cuts off what lies behind it. With the distances of the implementation's own hits, which have a bound
//! ([`PossibleHit`]), more than one walk may be right: a child that was put off may be visited where the
//! nearest hit so far may lie behind the beginning of the child's interval, and may be left out where it may lie before it.
//! Everything else is decided by the plane distances of KD-3, which are the same in every implementation.

use super::scene_memory::LegalScene;
use super::truth::PossibleHit;
use super::walk::{Visit, children, in_bounds, reciprocals};
use saarcor_model::host::{LIST_ENTRY_BYTES, ListEntry, MAX_DEPTH, NodeRecord};
use saarcor_model::rays::{Ray, Stack};
use saarcor_model::vm::{HostAddr, Memory, Unit, WholeScene};

/// Where a walk goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrongRead {
    /// Place of the read among those of the walk.
    pub place: usize,
    /// What is right there: an address, or nothing where the walk has to end.
    pub right: Option<u32>,
}

/// Follows a walk of a ray that asks for the closest hit, by the addresses that it has read.
///
/// # Errors
/// The first read that no right walk has.
pub fn follow(memory: &[u8], scene: &LegalScene, ray: &Ray, touched: &[u32]) -> Result<(), WrongRead> {
    let mut memory = WholeScene(memory);
    let mut walk = Walk { touched, place: 0, nearest: [ray.t_max.into(); 2] };
    let reciprocals = reciprocals(scene, ray);
    let mut stack = Stack::<Visit, MAX_DEPTH>::new((HostAddr(0), (0.0, 0.0)));
    stack.begin((scene.registers.root, in_bounds(scene, ray, &reciprocals)));
    while let Some((mut addr, mut interval)) = stack.resume() {
        if !walk.visits(addr, interval) {
            continue;
        }
        let (list, count) = loop {
            walk.reads(addr)?;
            match NodeRecord::decode(memory.fetch(Unit::Traversal, addr)) {
                NodeRecord::Leaf { list, count } => break (list, count),
                NodeRecord::Inner { axis, split, below } => {
                    let (visited, below, above) = children(ray, &reciprocals, (axis, split, below), interval);
                    let next = if stack.descend(visited, &below, &above) { above } else { below };
                    (addr, interval) = next;
                }
            }
        };
        for entry in 0..count {
            let place = list.offset(entry * LIST_ENTRY_BYTES);
            walk.reads(place)?;
            let ListEntry { triangle, .. } = ListEntry::decode(memory.fetch(Unit::List, place));
            walk.reads(triangle)?;
            if let Ok(place) = scene.addresses.binary_search(&triangle.0) {
                let corners = &scene.corners[place];
                walk.tests(PossibleHit::new(&scene.registers, triangle.0, corners, ray));
            }
        }
    }
    match walk.touched.len() == walk.place {
        true => Ok(()),
        false => Err(WrongRead { place: walk.place, right: None }),
    }
}

/// A walk, as far as it was followed.
struct Walk<'a> {
    touched: &'a [u32],
    /// Reads that were followed.
    place: usize,
    /// Least and greatest distance that the nearest hit so far may have, or the end of the ray.
    nearest: [f64; 2],
}

impl Walk<'_> {
    /// Whether a child that was put off is visited: as the walk has it, where the nearest hit leaves it open; then it
    /// says where that is.
    fn visits(&mut self, addr: HostAddr, (enter, leave): (f32, f32)) -> bool {
        let begins = f64::from(enter);
        if enter > leave || begins > self.nearest[1] {
            return false;
        }
        if begins <= self.nearest[0] {
            return true;
        }
        let is_visited = self.touched.get(self.place) == Some(&addr.0);
        if is_visited {
            self.nearest[0] = begins;
        } else {
            self.nearest[1] = begins.next_down();
        }
        is_visited
    }

    /// The walk has to read this next.
    fn reads(&mut self, HostAddr(addr): HostAddr) -> Result<(), WrongRead> {
        if self.touched.get(self.place) != Some(&addr) {
            return Err(WrongRead { place: self.place, right: Some(addr) });
        }
        self.place += 1;
        Ok(())
    }

    /// A triangle is tested.
    fn tests(&mut self, found: Option<PossibleHit>) {
        let Some(PossibleHit { t, hit, .. }) = found else { return };
        let [least, greatest] = &mut self.nearest;
        // A bound without end leaves every distance open, whatever the value.
        let from = t.value - t.error;
        *least = least.min(if from.is_nan() { f64::NEG_INFINITY } else { from });
        if hit {
            *greatest = greatest.min(t.value + t.error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kd::oracle::KdOracle;
    use crate::kd::random;
    use crate::kd::request::Request;
    use crate::kd::truth::Truth;
    use crate::kd::walk::{Reads, trace};
    use crate::kind::Oracle;
    use glam::Vec3;
    use saarcor_model::rays::{
        Candidate, EdgeTriangle, Hits, IntersectionUnit, Intervals, Packet, Query, StoredTriangle, Traversal,
        TriangleTest, Triple, keep_nearest,
    };
    use saarcor_model::vm::Observed;
    use saarcor_oracles::formats::Double;

    /// A Möller-Trumbore test in f64, whose answers are rounded once.
    #[derive(Clone, Copy)]
    struct InDouble(EdgeTriangle<Double>);

    impl TriangleTest<f32> for InDouble {
        type Ray = <EdgeTriangle<Double> as TriangleTest<Double>>::Ray;

        fn new(corners: &[Vec3; 3]) -> Self {
            Self(EdgeTriangle::new(corners))
        }

        fn ray(origin: Triple<f32>, direction: Triple<f32>) -> Self::Ray {
            <EdgeTriangle<Double> as TriangleTest<Double>>::ray(origin, direction)
        }

        fn intersect<const OWNED: bool>(&self, ray: &Self::Ray) -> Candidate {
            let Candidate { t, u, v, inside } = self.0.intersect::<OWNED>(ray);
            let [t, u, v] = [t, u, v].map(|number| number.0 as f32);
            Candidate { t, u, v, inside }
        }
    }

    impl IntersectionUnit<1> for InDouble {
        fn intersect(
            &mut self,
            triangle: &StoredTriangle,
            packet: &Packet<1>,
            cell: &Intervals<1>,
            query: Query,
            hits: &mut Hits<1>,
        ) {
            let words = triangle.record.words;
            let corners = [0, 3, 6].map(|at| Vec3::from_slice(&words[at..]));
            let test = <Self as TriangleTest<f32>>::new(&corners);
            keep_nearest(test, (triangle.addr, triangle.edges), packet, cell, query, hits);
        }
    }

    /// Hits nothing.
    #[derive(Clone, Copy)]
    struct NoHits;

    impl IntersectionUnit<1> for NoHits {
        fn intersect(
            &mut self,
            _: &StoredTriangle,
            _: &Packet<1>,
            _: &Intervals<1>,
            _: Query,
            _: &mut Hits<1>,
        ) {
        }
    }

    /// What a ray reads that asks this unit for the closest hit.
    fn walk<I: IntersectionUnit<1> + Copy>(
        unit: &I,
        memory: &[u8],
        scene: &LegalScene,
        ray: &Ray,
    ) -> Vec<u32> {
        let mut observed = Observed { memory: WholeScene(memory), observer: Reads::default() };
        let packet = Packet::new([Some(*ray)]);
        Traversal::with(*unit).run(&mut observed, &scene.registers, &packet, Query::Closest);
        observed.observer.0.into_iter().map(|(_, addr)| addr).collect()
    }

    /// The rays of random sessions, each in its scene.
    fn each_ray(seeds: u64, mut each: impl FnMut(&[u8], &LegalScene, &Ray)) {
        for seed in 0..seeds {
            let config = "kernel=moller-trumbore";
            let mut model = KdOracle::new(Oracle::Model, config).expect("a configuration");
            for line in
                random::requests(seed, 2000).split(|&byte| byte == b'\n').filter(|line| !line.is_empty())
            {
                match Request::parse(line).expect("a request") {
                    Request::Trace(Query::Closest, ray) => {
                        let (scene, memory) = model.scene().expect("a scene");
                        each(memory, scene, &ray);
                    }
                    request => model.change(&request),
                }
            }
        }
    }

    #[test]
    fn walk_by_hits_that_are_rounded_once_is_right() {
        let (mut walks, mut others) = (0, 0);
        each_ray(12, |memory, scene, ray| {
            let read = walk(&InDouble(EdgeTriangle::new(&[Vec3::ZERO; 3])), memory, scene, ray);
            assert_eq!(follow(memory, scene, ray, &read), Ok(()), "{ray:?} reads {read:x?}");
            let (_, of_model) = trace(memory, scene, ray, Query::Closest);
            walks += 1;
            others += usize::from(of_model.into_iter().map(|(_, addr)| addr).ne(read));
        });
        println!("{others} of {walks} walks are not the model's");
        assert!(others > 0, "no walk of {walks} was another one than the model's");
    }

    /// Where nothing is hit, one walk alone is right: one read less, one more, or two that are exchanged, are
    /// wrong, each at its place.
    #[test]
    fn wrong_reads_are_found_at_their_place() {
        let mut judged = 0;
        each_ray(4, |memory, scene, ray| {
            let (_, right) = trace(memory, scene, ray, Query::Closest);
            let right: Vec<u32> = right.into_iter().map(|(_, addr)| addr).collect();
            assert_eq!(follow(memory, scene, ray, &right), Ok(()), "{ray:?}");
            if Truth::new(scene, ray).check_any(true).is_ok() {
                return;
            }
            let wrong = |place: usize| Err(WrongRead { place, right: right.get(place).copied() });
            let more = [&right[..], &[0]].concat();
            assert_eq!(follow(memory, scene, ray, &more), wrong(right.len()), "{ray:?}");
            let Some((_, less)) = right.split_last() else { return };
            assert_eq!(follow(memory, scene, ray, less), wrong(less.len()), "{ray:?}");
            for at in 1..right.len() {
                let mut exchanged = right.clone();
                exchanged.swap(at - 1, at);
                assert_eq!(follow(memory, scene, ray, &exchanged), wrong(at - 1), "{ray:?}, {at}");
                judged += 1;
            }
        });
        assert!(judged > 1000, "{judged} walks");
    }

    /// The model's determinant is 0 in f32, so it has no distance and no hit; a test that rounds otherwise has both, and
    /// its hit cuts off the child behind it.
    #[test]
    fn walk_by_a_hit_that_the_model_has_no_distance_of_is_right() {
        let requests = [
            "b c0800000 c0800000 c0800000 40400000 40800000 40800000",
            "w 0 000040c00a000000",
            "w 8 0000000007100000",
            "w 10 0000004018000000",
            "w 18 0100000003100000",
            "w 20 0000000003100000",
            "w 1000 00200000",
            "w 2000 000040c0000000c00000803f0000803f00008040000000c00000004000000040000080bf",
        ];
        let mut model = KdOracle::new(Oracle::Model, "kernel=moller-trumbore").expect("a configuration");
        for line in requests {
            model.change(&Request::parse(line.as_bytes()).expect("a request"));
        }
        let line = b"c c0000000 3f800000 bf000000 3eaaaaab 0 0 0 7f800000";
        let Ok(Request::Trace(Query::Closest, ray)) = Request::parse(line) else { panic!("a ray") };
        let (scene, memory) = model.scene().expect("a scene");
        let with_hit = [0, 0x10, 0x18, 0x1000, 0x2000];
        assert_eq!(follow(memory, scene, &ray, &with_hit), Ok(()));
        let without = [&with_hit[..], &[0x20]].concat();
        assert_eq!(follow(memory, scene, &ray, &without), Ok(()));
    }

    /// Where something is certainly hit, a walk that no hit cuts off is wrong, but where a cell begins at the hit itself.
    #[test]
    fn walks_that_go_on_behind_a_hit_are_wrong() {
        let (mut walks, mut wrong) = (0, 0);
        each_ray(4, |memory, scene, ray| {
            let (_, right) = trace(memory, scene, ray, Query::Closest);
            let read = walk(&NoHits, memory, scene, ray);
            let is_hit = Truth::new(scene, ray).check_any(false).is_err();
            if is_hit && right.into_iter().map(|(_, addr)| addr).ne(read.iter().copied()) {
                walks += 1;
                wrong += usize::from(follow(memory, scene, ray, &read).is_err());
            }
        });
        println!("{wrong} of {walks} walks are wrong");
        assert!(walks > 100 && wrong * 20 > walks * 19, "{wrong} of {walks} walks are wrong");
    }
}
