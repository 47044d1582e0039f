//! Theorems of the intersection unit (IS-1 to IS-3): which hits it keeps, lane by lane, and what the tests say
//! where nothing, or hardly anything, is rounded.
//!
//! The judge is the exact test, `ExactHit`, which `tests/intersection.rs` holds to rational arithmetic.

use super::LANES;
use crate::draw::{self, WORDS};
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use glam::Vec3;
use saarcor_model::host::{Axis, Edges, Kernel};
use saarcor_model::rays::{
    Candidate, ExactHit, Hits, Intersection, IntersectionUnit, Intervals, Packet, Query, Ray, StoredTriangle,
    TriangleTest, Triple, WatertightTriangle, intersect, keep_nearest,
};
use saarcor_model::vm::HostAddr;

/// Rays of a packet of the standard configuration.
const RAYS: usize = 64;

/// Bits of distances: on either side of each other, equal, zeros, infinite and NaN.
static DISTANCES: [u32; 7] =
    [0x8000_0000, 0, 0x3f7f_ffff, 0x3f80_0000, 0x4000_0000, 0x7f80_0000, 0x7fc0_0000];

/// A test that finds what was drawn: one candidate for the witness, whose rays start at x = 1, and one for the
/// other rays.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    own: Candidate,
    other: Candidate,
}

impl TriangleTest<f32> for Drawn {
    type Ray = bool;

    fn new(_corners: &[Vec3; 3]) -> Self {
        let nothing = Candidate { t: 0.0, u: 0.0, v: 0.0, inside: false };
        Self { own: nothing, other: nothing }
    }

    fn ray(origin: Triple<f32>, _direction: Triple<f32>) -> bool {
        origin[0] == 1.0
    }

    fn intersect<const OWNED: bool>(&self, &own: &bool) -> Candidate {
        if own { self.own } else { self.other }
    }
}

fn distance(s: &mut impl Source, name: &'static str, small: &'static [u32]) -> f32 {
    f32::from_bits(s.value(name, 0..=u32::MAX, small))
}

/// The bits of what one lane hits.
fn bits<const N: usize>(hits: &Hits<N>, lane: usize) -> [u32; 4] {
    [hits.t[lane].to_bits(), hits.u[lane].to_bits(), hits.v[lane].to_bits(), hits.triangle[lane]]
}

/// A point with whole coordinates.
fn point(s: &mut impl Source, axes: [&'static [u32]; 3]) -> Vec3 {
    let mut point = [0.0; 3];
    for axis in 0..3 {
        point[axis] = s.value("coordinate + 2", 0..=6, axes[axis]) as f32 - 2.0;
    }
    point.into()
}

static ENDS: [u32; 2] = [0, 4];
static EVEN: [u32; 3] = [0, 2, 4];

/// Of which numbers edge functions are made in the plane across a ray: around 2^12, where products are rounded, and
/// such small ones that products underflow.
static ACROSS: [f32; 9] = [0.0, 4097.0, 4098.0, 4099.0, -4097.0, -4098.0, -4099.0, 1.0e-25, -3.0e-25];

/// Some of them for each coordinate of three corners.
static SOME: [[u32; 4]; 6] =
    [[0, 1, 5, 7], [0, 2, 4, 8], [2, 6, 0, 8], [3, 5, 1, 7], [5, 1, 3, 0], [6, 2, 0, 4]];

/// Twice the area that two points span with the origin: its terms as rounded to f32, and in f64.
fn edge(p: [f32; 2], q: [f32; 2]) -> (f32, f64, f64) {
    let (left, right) = (f64::from(p[0]) * f64::from(q[1]), f64::from(p[1]) * f64::from(q[0]));
    (p[0] * q[1] - p[1] * q[0], left - right, left.abs().max(right.abs()))
}

/// The kernel of that number.
fn kernel(s: &mut impl Source) -> Kernel {
    Kernel::ALL[s.value("test", 0..=4, &WORDS[..5]) as usize]
}

theorems! {
    /// Of 64 rays each keeps a hit exactly if it meets the cell, the point is inside, not before t_min and before
    /// t_max, and nearer than its hit before, or as near and at a lower address; a shadow ray's hit lies at minus
    /// infinity; what is not kept changes nothing, in any lane.
    #[
        "IS-2", unwind 66,
        covers ["kept", "at t_min", "at t_max", "as near, at a lower address", "as near, at a higher address", "the last lane", "outside of the cell", "NaN"]
    ]
    fn nearest_hit_is_kept_lane_by_lane(s) {
        let lane = s.value("lane", 0..=63, &[5, 63_u32]) as usize;
        let found = Candidate {
            t: distance(s, "bits of t", &DISTANCES),
            u: distance(s, "bits of u", &DISTANCES[3..4]),
            v: distance(s, "bits of v", &DISTANCES[4..5]),
            inside: draw::flag(s, "inside"),
        };
        let before = distance(s, "bits of t before", &DISTANCES[2..]);
        let (t_min, t_max) = (distance(s, "bits of t_min", &DISTANCES[1..4]), distance(s, "bits of t_max", &DISTANCES[3..]));
        let (addr, addr_before) = (s.value("address", 0..=u32::MAX - 1, &[36, 0x8000_0000]), s.value("address before", 0..=u32::MAX, &[36, 72]));
        let meets = draw::flag(s, "meets the cell");
        let query = if draw::flag(s, "any hit") { Query::Any } else { Query::Closest };
        // The others are at 1 and find 2.
        let other = Candidate { t: 2.0, u: 0.5, v: 0.25, inside: true };
        let mut packet = Packet::<RAYS> { origin: [[0.0; RAYS]; 3], direction: [[0.0; RAYS]; 3], t_min: [0.0; RAYS], t_max: [9.0; RAYS] };
        let mut cell = Intervals::<RAYS>::EVERYWHERE;
        let mut hits = Hits::<RAYS> { t: [1.0; RAYS], u: [0.0; RAYS], v: [0.0; RAYS], triangle: [7; RAYS] };
        for at in 0..RAYS {
            if at == lane {
                packet.origin[0][at] = 1.0;
                (packet.t_min[at], packet.t_max[at]) = (t_min, t_max);
                (hits.t[at], hits.triangle[at]) = (before, addr_before);
                if !meets {
                    cell.leave[at] = f32::NEG_INFINITY;
                    cell.enter[at] = 0.0;
                }
            }
        }
        let was = bits(&hits, lane);
        keep_nearest(Drawn { own: found, other }, (HostAddr(addr), Edges::Shared), &packet, &cell, query, &mut hits);
        let starts = t_min <= found.t;
        let nearer = found.t < before || (found.t == before && addr < addr_before);
        let keeps = meets && found.inside && starts && found.t < t_max && nearer;
        let possible = meets && found.inside;
        cover!(s, "kept", keeps);
        cover!(s, "at t_min", keeps && found.t == t_min);
        cover!(s, "at t_max", possible && found.t == t_max && t_min < t_max && nearer);
        cover!(s, "as near, at a lower address", keeps && found.t == before);
        cover!(s, "as near, at a higher address", possible && found.t == before && starts && found.t < t_max && addr > addr_before);
        cover!(s, "the last lane", keeps && lane == 63);
        cover!(s, "outside of the cell", !meets && found.inside && nearer);
        cover!(s, "NaN", found.t.is_nan());
        let t = if query == Query::Any { f32::NEG_INFINITY } else { found.t };
        let expected = if keeps { [t.to_bits(), found.u.to_bits(), found.v.to_bits(), addr] } else { was };
        check_eq!(bits(&hits, lane), expected, "lane {lane}, {found:?} at {addr:#x}, before at {before} at {addr_before:#x}, {t_min} .. {t_max}");
        // Any other lane: all are judged by it.
        let seen = s.value("lane that is looked at", 0..=63, &LANES) as usize;
        if seen != lane {
            check_eq!(bits(&hits, seen), [1.0_f32.to_bits(), 0, 0, 7], "lane {seen}, which has a nearer hit");
        }
    }

    /// Each of 64 rays is tested as if it were alone, by every test and by either query, whatever the other rays are
    /// and whatever triangles came before.
    #[
        "IS-2", not_for_kani "it is arithmetic in floating point",
        covers ["hit first by both", "one hit", "any hit", "the last lane", "from lane 16 on"]
    ]
    fn rays_of_a_packet_are_tested_as_if_alone(s) {
        let edges = draw::edges(s);
        let (kernel, lane) = (kernel(s), s.value("lane", 0..=63, &[0, 17, 63_u32]) as usize);
        let query = if draw::flag(s, "any hit") { Query::Any } else { Query::Closest };
        let target = point(s, [&WORDS[1..4], &WORDS[1..3], &WORDS[..1]]);
        let origin = Vec3::new(0.0, 0.25, -4.0);
        let ray = |origin: Vec3, target: Vec3| Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY };
        let (own, other) = (ray(origin, target), ray(Vec3::new(0.5, -0.5, 6.0), Vec3::new(0.25, 0.0, 0.0)));
        // The others are few, since exact tests take long.
        let mut rays = [None; RAYS];
        for at in 0..RAYS {
            rays[at] = if at == lane { Some(own) } else { (at % 21 == 0).then_some(other) };
        }
        let packet = Packet::new(rays);
        let triangles = [(72, 0.0), (36, 0.5), (108, 0.5), (144, -0.75)].map(|(addr, z)| {
            let corners = [Vec3::new(-2.0, -1.0, z), Vec3::new(2.0, -1.0, z), Vec3::new(0.0, 1.5, 2.0 * z)];
            StoredTriangle::new(HostAddr(addr), kernel, edges, &corners)
        });
        let order = s.value("first triangle", 0..=3, &WORDS[..2]) as usize;
        let (mut unit, mut hits) = (Intersection::<RAYS>::default(), Hits::none(&packet));
        let alone = [own, other].map(|ray| Packet::new([Some(ray)]));
        let mut units = [Intersection::<1>::default(), Intersection::default()];
        let mut expected = [Hits::none(&alone[0]), Hits::none(&alone[1])];
        for step in 0..4 {
            let triangle = &triangles[(order + step) % 4];
            // The witness meets the cells of some of them.
            let mut cell = Intervals::<RAYS>::EVERYWHERE;
            let meets = draw::flag(s, "meets the cell");
            if !meets {
                (cell.enter[lane], cell.leave[lane]) = (1.0, 0.0);
            }
            let mine = if meets { Intervals::EVERYWHERE } else { Intervals::EMPTY };
            unit.intersect(triangle, &packet, &cell, query, &mut hits);
            units[0].intersect(triangle, &alone[0], &mine, query, &mut expected[0]);
            units[1].intersect(triangle, &alone[1], &Intervals::EVERYWHERE, query, &mut expected[1]);
        }
        let both = expected[0].is_hit(0) && expected[1].is_hit(0);
        cover!(s, "hit first by both", both && query == Query::Closest);
        cover!(s, "one hit", !expected[0].is_hit(0));
        cover!(s, "any hit", both && query == Query::Any);
        cover!(s, "the last lane", lane == 63 && both);
        cover!(s, "from lane 16 on", lane >= 16 && both);
        for at in 0..RAYS {
            let alone = &expected[usize::from(at != lane)];
            let expected = if rays[at].is_some() { bits(alone, 0) } else { bits(&Hits::none(&packet), at) };
            check_eq!(bits(&hits, at), expected, "{kernel:?}, lane {at}, witness {lane}: {own:?}");
        }
    }

    /// Where nothing is rounded but the last quotient, each test hits exactly what is hit exactly: rays in steps of
    /// whole numbers against triangles with whole corners, and by Möller and Trumbore's and by Wald's test those whose
    /// divisors are powers of two; edges and vertices belong to it, or to it or another by the rule of ownership; t_min belongs to it, t_max does not; distance and weights are the
    /// true ones to a unit in the last place.
    #[
        "IS-1", not_for_kani "it is arithmetic in floating point",
        covers ["inside", "on an edge", "at a vertex", "on an edge of another", "beside an edge", "at t_min", "at t_max", "in the plane", "without area", "from behind"]
    ]
    fn tests_are_exact_on_whole_numbers(s) {
        let kernel = kernel(s);
        let a = point(s, [&ENDS, &EVEN[1..2], &EVEN[1..]]);
        let b = point(s, [&EVEN, &ENDS, &EVEN[1..2]]);
        let c = point(s, [&EVEN[1..], &EVEN, &EVEN[1..2]]);
        let origin = point(s, [&WORDS[2..4], &WORDS[2..3], &ENDS[..1]]);
        let direction = point(s, [&WORDS[1..4], &WORDS[2..4], &ENDS[1..]]);
        let corners = [a, b, c];
        let normal = (b - a).cross(c - a);
        let across = normal.dot(direction);
        let power = |number: f32| number.abs().to_bits() & 0x7f_ffff == 0;
        let largest = normal.abs().max_element();
        let rounds = match kernel {
            Kernel::MollerTrumbore => !power(across),
            Kernel::Wald => !power(largest) || !power(across),
            // Along an axis, or by halves, nothing is sheared with rounding.
            Kernel::Watertight => !power(direction.abs().max_element()),
            Kernel::Plucker | Kernel::Adaptive => false,
        };
        assume!(!rounds);
        let (t_min, t_max) = match s.value("range (all, from 1 on, up to 1, up to 0.5)", 0..=3, &WORDS[..4]) {
            0 => (0.0, f32::INFINITY),
            1 => (1.0, f32::INFINITY),
            2 => (0.0, 1.0),
            _ => (0.0, 0.5),
        };
        let ray = Ray { origin, direction, t_min, t_max };
        let edges = draw::edges(s);
        // The watertight test counts axes from the one after the ray's.
        let first = match kernel {
            Kernel::Watertight => Axis::of_greatest(direction.abs().to_array()) as usize + 1,
            _ => 0,
        };
        let turned = |point: Vec3| Vec3::from([0, 1, 2].map(|axis| point[(first + axis) % 3]));
        let exactly = |ray: Ray, edges: Edges| {
            let ray = Ray { origin: turned(ray.origin), direction: turned(ray.direction), ..ray };
            ExactHit::new(&ray, &corners.map(turned), edges).map(|hit| hit.point())
        };
        let exact = exactly(ray, edges);
        let endless = exactly(Ray { t_min: 0.0, t_max: f32::INFINITY, ..ray }, Edges::Shared);
        let weights = endless.map(|[_, u, v]| [1.0 - u - v, u, v]);
        let zeros = weights.map(|weights| weights.into_iter().filter(|weight| *weight == 0.0).count());
        cover!(s, "inside", exact.is_some() && zeros == Some(0));
        cover!(s, "on an edge", exact.is_some() && zeros == Some(1));
        cover!(s, "at a vertex", exact.is_some() && zeros == Some(2));
        cover!(s, "on an edge of another", edges == Edges::Owned && exact.is_none() && zeros == Some(1) && exactly(ray, Edges::Shared).is_some());
        cover!(s, "beside an edge", endless.is_none() && across != 0.0);
        cover!(s, "at t_min", exact.is_some_and(|[t, ..]| t == 1.0 && t_min == 1.0));
        cover!(s, "at t_max", exact.is_none() && endless.is_some_and(|[t, ..]| t == 1.0 && t_max == 1.0));
        cover!(s, "in the plane", across == 0.0 && largest > 0.0);
        cover!(s, "without area", largest == 0.0);
        cover!(s, "from behind", exact.is_some() && across > 0.0);
        let found = intersect(kernel, edges, &corners, &ray);
        check_eq!(found.is_some(), exact.is_some(), "{kernel:?}, {edges:?}: {ray:?} and {corners:?}, exactly {exact:?}");
        if let (Some(found), Some(exact)) = (found, exact) {
            for (found, right) in [found.t, found.u, found.v].into_iter().zip(exact) {
                let near = (f64::from(found) - right).abs() <= f64::from(f32::EPSILON) * right.abs();
                check!(near, "{kernel:?}: {ray:?} and {corners:?}: {found}, not {right}");
            }
        }
    }

    /// The watertight test decides the side of an edge exactly, also where the edge function is exactly zero, so that
    /// the ray meets the edge, and where it is rounded to zero: a ray along an axis hits what is hit exactly.
    #[
        "IS-1", not_for_kani "it is arithmetic in floating point",
        covers ["exactly zero", "rounded to zero, positive", "rounded to zero, negative", "hit at an exact zero", "missed by what was rounded to zero"]
    ]
    fn watertight_test_decides_zeros_exactly(s) {
        let axis = s.value("axis of the ray", 0..=2, &WORDS[..3]) as usize;
        let backwards = draw::flag(s, "against the axis");
        let mut flat = [[0.0; 2]; 3];
        for (number, some) in flat.as_flattened_mut().iter_mut().zip(&SOME) {
            *number = ACROSS[s.value("coordinate across the ray", 0..=8, some) as usize];
        }
        let edges = [edge(flat[2], flat[1]), edge(flat[0], flat[2]), edge(flat[1], flat[0])];
        let (mut sum, mut largest) = (0.0_f64, 0.0_f64);
        for (_, exact, term) in edges {
            (sum, largest) = (sum + exact, largest.max(term));
        }
        // So that the sum of what is rounded has the sign of the sum, and is a normal number.
        assume!(sum.abs() > 1.0e-6 * largest && sum.abs() > 1.0e-30);
        let ahead = if backwards { -1.0 } else { 1.0 };
        let corners = flat.map(|[x, y]| {
            let mut corner = [ahead; 3];
            (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (x, y);
            corner
        });
        let mut direction = [0.0; 3];
        direction[axis] = ahead;
        let ray = Ray { origin: Vec3::ZERO, direction: direction.into(), t_min: 0.0, t_max: f32::INFINITY };
        let exact = ExactHit::new(&ray, &corners.map(Vec3::from), Edges::Shared).is_some();
        let found = WatertightTriangle::<f32>::new(&corners.map(Vec3::from)).intersect::<false>(&WatertightTriangle::<f32>::ray([0.0; 3], direction));
        let zero = edges.iter().any(|(_, exact, _)| *exact == 0.0);
        let rounded = |sign: f64| edges.iter().any(|(rounded, exact, _)| *rounded == 0.0 && exact * sign > 0.0);
        cover!(s, "exactly zero", zero);
        cover!(s, "rounded to zero, positive", rounded(1.0));
        cover!(s, "rounded to zero, negative", rounded(-1.0));
        cover!(s, "hit at an exact zero", zero && exact);
        cover!(s, "missed by what was rounded to zero", !exact && rounded(-sum));
        check_eq!(found.inside, exact, "{ray:?} and {corners:?}: {found:?}");
    }
}
