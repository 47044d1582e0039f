//! Which triangles a ray may hit, without trying every one: a hierarchy of boxes (Rubin and Whitted
//! 1980).
//!
//! It decides nothing. A triangle is left out only if the ray surely misses its box, and all others
//! are for the caller's test to judge. It knows nothing of the model's kd-tree: another structure,
//! in f64, by division.

use glam::{DVec3, Vec3};
use saarcor_model::rays::Ray;

/// Relative error of a distance to a side of a box. Sides and origins are f32: their difference in
/// f64 has one rounding, the reciprocal of the direction and the product with it one each, so that
/// the error is at most γ(3) = 3u / (1 - 3u), u = 2⁻⁵³ (Higham 2002, §3.1). Nothing underflows or
/// overflows: f32 reach from 2⁻¹⁴⁹ to 2¹²⁸. The fourth u is for the rounding of the bound itself,
/// and four more for γ's denominator, which needs far less.
const ERROR: f64 = 8.0 * (f64::EPSILON / 2.0);

/// Up to this many triangles stay together in one box.
const LEAF: usize = 4;

/// A box with what it holds: `count` triangles of [`Bvh::order`] from `first` on, or, where `count`
/// is 0, the nodes `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: Vec3,
    max: Vec3,
    first: u32,
    count: u32,
}

/// A hierarchy of boxes around triangles.
///
/// ```
/// use glam::Vec3;
/// use saarcor_model::rays::Ray;
/// use saarcor_oracles::bvh::Bvh;
/// let at = |x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0), Vec3::new(x, 0.0, 1.0)];
/// let bvh = Bvh::new(&(0..100).map(|x| at(x as f32)).collect::<Vec<_>>());
/// let ray = Ray { origin: Vec3::new(41.5, 0.1, 0.1), direction: Vec3::X, t_min: 0.0, t_max: 2.0 };
/// let mut found: Vec<u32> = bvh.candidates(&ray, f64::INFINITY).collect();
/// found.sort();
/// assert!(found.contains(&42) && found.contains(&43) && found.len() < 10);
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Bvh {
    /// The hierarchy around `triangles`, given by their corners. Triangles with a corner that is
    /// not finite are left out: no ray hits them.
    ///
    /// # Panics
    /// If there are 2³¹ triangles or more.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        assert!(triangles.len() < 1 << 31, "triangles are counted in 31 bits");
        let is_finite = |&id: &u32| triangles[id as usize].iter().all(|corner| corner.is_finite());
        let order: Vec<u32> = (0..triangles.len() as u32).filter(is_finite).collect();
        let mut bvh = Self { nodes: Vec::new(), order };
        if !bvh.order.is_empty() {
            let end = bvh.order.len();
            bvh.nodes.push(bvh.around(triangles, 0, end));
            bvh.divide(triangles, 0);
        }
        bvh
    }

    /// One box around the triangles `first .. end` of the order.
    fn around(&self, triangles: &[[Vec3; 3]], first: usize, end: usize) -> Node {
        let corners = self.order[first..end].iter().flat_map(|&id| triangles[id as usize]);
        let (min, max) =
            corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
        Node { min, max, first: first as u32, count: (end - first) as u32 }
    }

    /// Divides a box into two of as many triangles, by the middles of the triangles' boxes on the
    /// axis on which they are spread most.
    fn divide(&mut self, triangles: &[[Vec3; 3]], node: usize) {
        let Node { first, count, .. } = self.nodes[node];
        let (first, count) = (first as usize, count as usize);
        if count <= LEAF {
            return;
        }
        // In f64, where the sum of two f32 does not overflow.
        let middle = |id: u32| {
            let [a, b, c] = triangles[id as usize].map(Vec3::as_dvec3);
            a.min(b).min(c) + a.max(b).max(c)
        };
        let within = &mut self.order[first..first + count];
        let (min, max) = within.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), &id| {
            (min.min(middle(id)), max.max(middle(id)))
        });
        let axis = (max - min).max_position();
        within.select_nth_unstable_by(count / 2, |&a, &b| {
            middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b))
        });
        let children = self.nodes.len();
        let half = first + count / 2;
        let (below, above) =
            (self.around(triangles, first, half), self.around(triangles, half, first + count));
        self.nodes.extend([below, above]);
        (self.nodes[node].first, self.nodes[node].count) = (children as u32, 0);
        self.divide(triangles, children);
        self.divide(triangles, children + 1);
    }

    /// All triangles whose boxes `ray` meets within its range, at a distance of `farthest` at most,
    /// and a few more, each once, in no order of distance: every triangle that it hits there is
    /// among them. A ray that is not finite meets any or none.
    pub fn candidates<'a>(&'a self, ray: &Ray, farthest: f64) -> impl Iterator<Item = u32> + use<'a> {
        let line = Line::new(ray, farthest);
        let mut open: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        std::iter::from_fn(move || {
            loop {
                let node = self.nodes[open.pop()? as usize];
                if !line.meets(&node) {
                    continue;
                }
                if node.count > 0 {
                    let first = node.first as usize;
                    return Some(&self.order[first..first + node.count as usize]);
                }
                open.extend([node.first + 1, node.first]);
            }
        })
        .flatten()
        .copied()
    }
}

/// A ray and its range in f64.
struct Line {
    origin: DVec3,
    /// 1 / direction.
    reciprocal: DVec3,
    least: f64,
    greatest: f64,
}

impl Line {
    fn new(ray: &Ray, farthest: f64) -> Self {
        Self {
            origin: ray.origin.as_dvec3(),
            reciprocal: ray.direction.as_dvec3().recip(),
            least: f64::from(ray.t_min),
            greatest: f64::from(ray.t_max).min(farthest),
        }
    }

    /// Whether the ray may meet the box. Where it is parallel to two sides its distances to them
    /// are infinite, or NaN, which `max` and `min` pass over, if it lies in one of them.
    #[inline]
    fn meets(&self, node: &Node) -> bool {
        let a = (node.min.as_dvec3() - self.origin) * self.reciprocal;
        let b = (node.max.as_dvec3() - self.origin) * self.reciprocal;
        let (mut enter, mut leave) = (self.least, self.greatest);
        for axis in 0..3 {
            let (near, far) =
                if self.reciprocal[axis] < 0.0 { (b[axis], a[axis]) } else { (a[axis], b[axis]) };
            // Distances below 0 are widened to the wrong side, and lie before the range anyway.
            enter = enter.max(near * (1.0 - ERROR));
            leave = leave.min(far * (1.0 + ERROR));
        }
        enter <= leave
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::{closest, rational, solve};
    use proptest::prelude::*;
    use proptest::sample::Index;

    /// Coordinates of very different size, and coincident ones.
    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![
            (-3..=3i8).prop_map(f32::from),
            -1.0..1.0f32,
            (-1.0..1.0f32, -38..=38i32).prop_map(|(x, e)| (f64::from(x) * 10f64.powi(e)) as f32),
        ]
    }

    fn point() -> impl Strategy<Value = Vec3> {
        [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from_array)
    }

    /// Rays to a corner of one of `triangles`, of which the last coordinates may be the corner's
    /// own, so that the direction has zeros of either sign.
    fn ray(triangles: &[[Vec3; 3]], from: Vec3, at: Index, own: usize, sign: f32, t_max: f32) -> Ray {
        let corner = triangles[at.index(triangles.len())][own % 3];
        let origin =
            Vec3::from_array(std::array::from_fn(|axis| if axis < own { corner[axis] } else { from[axis] }));
        let direction = corner - origin;
        let direction = Vec3::select(direction.cmpeq(Vec3::ZERO), Vec3::splat(0.0 * sign), direction);
        Ray { origin, direction, t_min: 0.0, t_max }
    }

    proptest! {
        /// What is hit first among all triangles is hit first among the candidates, which are named
        /// once; also with no more than its own distance asked for.
        #[test]
        fn the_closest_hit_is_a_candidate(
            triangles in prop::collection::vec([point(), point(), point()], 1..60),
            rays in prop::collection::vec((point(), any::<Index>(), 0..4usize), 8),
            sign in prop_oneof![Just(1.0_f32), Just(-1.0)],
            t_max in prop_oneof![Just(f32::INFINITY), Just(1.0), Just(1.5)],
        ) {
            let bvh = Bvh::new(&triangles);
            for (from, at, own) in rays {
                let ray = ray(&triangles, from, at, own, sign, t_max);
                let among = |ids: &[u32]| closest(&ray, ids.iter().map(|&id| (id, triangles[id as usize])));
                let all: Vec<u32> = (0..triangles.len() as u32).collect();
                let expected = among(&all);
                let mut found: Vec<u32> = bvh.candidates(&ray, f64::INFINITY).collect();
                prop_assert_eq!(&among(&found), &expected, "{:?}", ray);
                found.sort_unstable();
                found.dedup();
                prop_assert_eq!(bvh.candidates(&ray, f64::INFINITY).count(), found.len());
                if let Some(hit) = &expected {
                    let first = triangles[hit.triangles[0].0 as usize];
                    let t = solve(&ray, &first).expect("hit").t;
                    let near: Vec<u32> = bvh.candidates(&ray, rational::nearest_f64(&t).next_up()).collect();
                    prop_assert_eq!(among(&near), expected, "{:?}", ray);
                }
            }
        }
    }

    #[test]
    fn what_is_far_from_the_ray_is_no_candidate() {
        let at = |x: f32| [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0), Vec3::new(x, 0.0, 1.0)];
        let bvh = Bvh::new(&(0..1000).map(|x| at(x as f32)).collect::<Vec<_>>());
        for direction in [Vec3::Y, -Vec3::Z, Vec3::new(1e-6, 1.0, 0.0)] {
            let ray = Ray { origin: Vec3::new(500.0, 0.5, 0.5), direction, t_min: 0.0, t_max: 9.0 };
            assert!(bvh.candidates(&ray, f64::INFINITY).all(|id| (490..510).contains(&id)));
        }
        assert_eq!(
            Bvh::new(&[])
                .candidates(&Ray { origin: Vec3::ZERO, direction: Vec3::X, t_min: 0.0, t_max: 1.0 }, 1.0)
                .count(),
            0
        );
    }
}
