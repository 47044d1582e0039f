//! The adaptive test's twin: `saarcor_fast::adaptive`.
//!
//! The twin decides most rays by a test in f64 with a bound of its error, the others in whole numbers of
//! 128 bits or in expansions of f64. Both keep the nearest triangle of each ray: states correspond if the
//! hits are the same.
//!
//! Small scope: corners and origins at few places each, in eight worlds of coordinates: small whole
//! numbers, thirds, numbers far from the origin, close to one another, denormal, huge, and of very
//! different magnitudes. Rays aim at a vertex, at an edge, at the inside or beside it. At random, any
//! coordinate may have any mantissa.

use crate::draw::{self, WORDS};
use crate::source::Source;
use crate::{check, check_eq, cover, theorems};
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle, FilteredIntersection};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{
    ExactHit, Hits, Intersection, IntersectionUnit, Intervals, Packet, Query, Ray, StoredTriangle,
};
use saarcor_model::vm::HostAddr;

/// A point.
type Point = [f32; 3];

/// What the places -1, 0, 1, 2 and 3 along an axis are as coordinates, in each world.
fn coordinate(world: u32, axis: usize, place: usize) -> f32 {
    let plain = [-1.0, 0.0, 1.0, 2.0, 3.0][place];
    match world {
        0 => plain,
        1 => plain / 3.0,
        2 => 4097.3 + plain,
        3 => 1.0 + plain * f32::EPSILON,
        4 => plain * 3.0e-44,
        5 => plain * 1.0e37,
        // Thin along an axis, and with gaps in one coordinate that f64 does not hold.
        6 => [1.0, 1.0e-25, 1.0][axis] * plain,
        _ => [-1.0, 1.0e-20, 1.0, 1.0 + f32::EPSILON, 1.0e20][place],
    }
}

/// A point at some of the places along each axis, of which mantissas are drawn beside them.
fn point(s: &mut impl Source, world: u32, axes: [&'static [u32]; 3]) -> Point {
    let mut point = [0.0; 3];
    for axis in 0..3 {
        let place = s.value("place", 0..=4, axes[axis]) as usize;
        let ulps = s.value("units in the last place beside it", 0..=0x7f_ffff, &WORDS[..1]);
        let number = coordinate(world, axis, place);
        // Finite for all but the greatest numbers, for which NaN and infinity are a miss of both.
        point[axis] = f32::from_bits(number.to_bits().wrapping_add(ulps));
    }
    point
}

/// A ray from `origin` to a point of the triangle or beside it, which it meets at about distance 1.
fn aimed(s: &mut impl Source, origin: Point, [a, b, c]: [Point; 3]) -> Ray {
    let kind = s.value("aim (vertex, edge, inside, beside an edge, near a vertex)", 0..=4, &WORDS[..5]);
    let weights = match kind {
        0 => [1.0, 0.0, 0.0],
        1 => [0.5, 0.5, 0.0],
        2 => [0.5, 0.25, 0.25],
        3 => [0.625, 0.5, -0.125],
        _ => [1.0 - 3.0e-7, 1.0e-7, 2.0e-7],
    };
    let mut direction = [0.0; 3];
    for axis in 0..3 {
        let target = weights[0] * a[axis] + weights[1] * b[axis] + weights[2] * c[axis];
        direction[axis] = target - origin[axis];
    }
    Ray { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: f32::INFINITY }
}

/// Whether two numbers are at most one unit in the last place of an f32 apart, or both among the least.
fn are_near(found: f64, right: f64) -> bool {
    let unit = f64::from(f32::EPSILON) * right.abs() + f64::from(f32::from_bits(1));
    (found - right).abs() <= unit
}

/// Rays of a packet.
const RAYS: usize = 4;

/// What an intersection unit keeps of triangles at these addresses, one after the other, in cells of which each misses
/// one lane, or none.
fn kept(
    unit: &mut impl IntersectionUnit<RAYS>,
    (kernel, edges): (Kernel, Edges),
    packet: &Packet<RAYS>,
    query: Query,
    triangles: &[(u32, [Point; 3], usize)],
) -> Hits<RAYS> {
    let mut hits = Hits::none(packet);
    for &(addr, corners, missed) in triangles {
        let triangle = StoredTriangle::new(HostAddr(addr), kernel, edges, &corners.map(Into::into));
        let mut cell = Intervals::EVERYWHERE;
        if missed < RAYS {
            (cell.enter[missed], cell.leave[missed]) = (1.0, 0.0);
        }
        unit.intersect(&triangle, packet, &cell, query, &mut hits);
    }
    hits
}

static MINUS_ONE_AND_ONE: [u32; 2] = [0, 2];
static ZERO_AND_TWO: [u32; 2] = [1, 3];
static ZERO_AND_THREE: [u32; 2] = [1, 4];
static ONE_AND_TWO: [u32; 2] = [2, 3];

theorems! {
    /// The fast adaptive test hits a triangle exactly if the specified one does, at the same distance
    /// and weights to a unit in the last place of an f32.
    #[
        "IS-3", not_for_kani "it is arithmetic in floating point",
        covers ["hit", "missed", "at a vertex", "outside of the range", "no plane", "an edge of another"]
    ]
    fn adaptive_test_is_the_exact_one(s) {
        let world = s.value("world", 0..=7, &WORDS[..8]);
        let edges = draw::edges(s);
        let origin = point(s, world, [&ZERO_AND_THREE, &ZERO_AND_THREE, &ZERO_AND_THREE[..1]]);
        let a = point(s, world, [&MINUS_ONE_AND_ONE; 3]);
        let b = point(s, world, [&MINUS_ONE_AND_ONE, &MINUS_ONE_AND_ONE, &ONE_AND_TWO[..1]]);
        let c = point(s, world, [&ZERO_AND_TWO; 3]);
        let mut ray = aimed(s, origin, [a, b, c]);
        // A ray that ends, or begins, where it meets the triangle.
        match s.value("range (all, up to 1, from 1 on)", 0..=2, &WORDS[..3]) {
            0 => {}
            1 => ray.t_max = 1.0,
            _ => ray.t_min = 1.0,
        }
        let corners = [a, b, c].map(Into::into);
        let specified = ExactHit::new(&ray, &corners, edges).map(|hit| hit.point());
        let endless = ExactHit::new(&Ray { t_min: 0.0, t_max: f32::INFINITY, ..ray }, &corners, Edges::Shared);
        let triangle = AdaptiveTriangle::new(&corners);
        let found = triangle.intersect(edges, &AdaptiveRay::new(&ray)).map(|hit| [hit.t, hit.u, hit.v]);
        cover!(s, "hit", specified.is_some());
        cover!(s, "missed", endless.is_none());
        cover!(s, "at a vertex", specified.is_some_and(|[_, u, v]| u == 0.0 && v == 0.0));
        cover!(s, "outside of the range", endless.is_some() && specified.is_none());
        cover!(s, "an edge of another", endless.is_some() && specified.is_none() && edges == Edges::Owned && ray.t_min == 0.0 && ray.t_max > 1.0);
        cover!(s, "no plane", a == b || b == c || c == a);
        check_eq!(found.is_some(), specified.is_some(), "{ray:?} and {corners:?}, {edges:?}");
        if let (Some(found), Some(specified)) = (found, specified) {
            let near = are_near(found[0], specified[0]);
            check!(near, "{ray:?} and {corners:?}: at {}, not {}", found[0], specified[0]);
            for weight in 1..3 {
                // A weight is a part of 1.
                let near = (found[weight] - specified[weight]).abs() <= f64::from(f32::EPSILON);
                check!(near, "{ray:?} and {corners:?}: weights of {found:?}, not {specified:?}");
            }
        }
    }

    /// Of three triangles, each ray of a packet keeps in the fast intersection unit the one that it keeps in the
    /// specified unit, in whatever order they come, with whatever was hit before, and where the ray begins or ends
    /// at a hit: the nearer one, and at the same distance the one at the lower address, at the same distance and
    /// weights to a unit in the last place.
    #[
        "IS-2", not_for_kani "it is arithmetic in floating point",
        covers ["both hit", "at the same distance", "nearer by less than an f32", "one hit", "any hit", "cut off", "the third after a hit", "a ray of its own"]
    ]
    fn fast_intersection_unit_keeps_the_same_triangle(s) {
        let world = s.value("world", 0..=7, &WORDS[..8]);
        let edges = draw::edges(s);
        let origin = point(s, world, [&ZERO_AND_THREE, &ZERO_AND_THREE, &ZERO_AND_THREE[1..]]);
        // Two triangles that share a corner, and one that shares an edge with each of them.
        let a = point(s, world, [&WORDS[1..2], &WORDS[1..2], &MINUS_ONE_AND_ONE]);
        let b = point(s, world, [&ONE_AND_TWO[..1], &MINUS_ONE_AND_ONE[..1], &ZERO_AND_TWO]);
        let c = point(s, world, [&MINUS_ONE_AND_ONE, &ONE_AND_TWO[..1], &ZERO_AND_TWO[..1]]);
        let d = point(s, world, [&ONE_AND_TWO, &MINUS_ONE_AND_ONE, &ONE_AND_TWO]);
        let e = point(s, world, [&MINUS_ONE_AND_ONE[1..], &ONE_AND_TWO[..1], &ZERO_AND_TWO[..1]]);
        let ray = aimed(s, origin, [a, b, c]);
        let query = if s.value("query (closest, any)", 0..=1, &WORDS[..2]) == 0 { Query::Closest } else { Query::Any };
        let missed = s.value("lane that misses the first cell (4: none)", 0..=4, &WORDS[4..5]) as usize;
        let (first, second, third) = ((72, [a, b, c], missed), (36, [a, d, e], 4), (108, [c, d, b], 4));
        let exact = |corners: [Point; 3]| ExactHit::new(&ray, &corners.map(Into::into), edges);
        let (p, q, r) = (exact(first.1), exact(second.1), exact(third.1));
        // Rays of which one ends and one begins where the first hit may be, and one of its own.
        let at = p.map_or(1.0, |hit| hit.rounded()[0]);
        let (ends, begins) = (Ray { t_max: at, ..ray }, Ray { t_min: at, ..ray });
        let towards = Ray { direction: std::array::from_fn(|axis| e[axis] - origin[axis]).into(), ..ray };
        let rays = [ray, ends, begins, towards];
        let equal = p.zip(q).is_some_and(|(p, q)| p.order(&q).is_eq());
        let near = p.zip(q).is_some_and(|(p, q)| p.rounded()[0] == q.rounded()[0] && !p.order(&q).is_eq());
        cover!(s, "both hit", p.is_some() && q.is_some());
        cover!(s, "at the same distance", equal);
        cover!(s, "nearer by less than an f32", near);
        cover!(s, "one hit", p.is_some() != q.is_some());
        cover!(s, "any hit", query == Query::Any && p.is_some());
        let packet = Packet::new(rays.map(Some));
        for triangles in [[first, second, third], [third, second, first]] {
            let specified = kept(&mut Intersection::default(), (Kernel::Adaptive, edges), &packet, query, &triangles);
            let found = kept(&mut FilteredIntersection::default(), (Kernel::Adaptive, edges), &packet, query, &triangles);
            cover!(s, "cut off", specified.is_hit(0) && !specified.is_hit(1));
            cover!(s, "the third after a hit", specified.triangle[0] == 108 && p.is_some() && r.is_some());
            cover!(s, "a ray of its own", specified.is_hit(3) && specified.triangle[3] != specified.triangle[0]);
            check_eq!(found.triangle, specified.triangle, "{rays:?} and {triangles:?}, {query:?}");
            for lane in 0..RAYS {
                let (found, specified) = ([found.t[lane], found.u[lane], found.v[lane]], [specified.t[lane], specified.u[lane], specified.v[lane]]);
                let near = found[0] == specified[0] || are_near(found[0].into(), specified[0].into());
                check!(near, "{:?} and {triangles:?}, {query:?}: at {}, not {}", rays[lane], found[0], specified[0]);
                for weight in 1..3 {
                    // A weight is a part of 1, rounded once more.
                    let near = (found[weight] - specified[weight]).abs() <= 2.0 * f32::EPSILON;
                    check!(near, "{:?} and {triangles:?}: weights of {found:?}, not {specified:?}", rays[lane]);
                }
            }
        }
    }

    /// With Wald's test, whose axis is a constant in each loop of the twin, the fast intersection unit
    /// keeps the hits of the specified unit, bit for bit.
    #[
        "IS-3", not_for_kani "it is arithmetic in floating point",
        covers ["axis x", "axis y", "axis z", "hit", "missed"]
    ]
    fn wald_axis_by_axis_is_the_specified_test(s) {
        let world = s.value("world", 0..=7, &WORDS[..8]);
        let edges = draw::edges(s);
        let origin = point(s, world, [&ZERO_AND_THREE, &ZERO_AND_THREE, &ZERO_AND_THREE[..1]]);
        let a = point(s, world, [&MINUS_ONE_AND_ONE; 3]);
        let b = point(s, world, [&MINUS_ONE_AND_ONE, &MINUS_ONE_AND_ONE, &ONE_AND_TWO[..1]]);
        let c = point(s, world, [&ZERO_AND_TWO; 3]);
        let ray = aimed(s, origin, [a, b, c]);
        let triangles = [(72, [a, b, c], 4), (36, [c, b, a], 1), (108, [b, c, a], 2)];
        let axis = Kernel::Wald.record(&triangles[0].1.map(Into::into)).tag;
        let query = if s.value("query (closest, any)", 0..=1, &WORDS[..2]) == 0 { Query::Closest } else { Query::Any };
        // The ray, and such as begin, or end, at its hit, and one from the other side.
        let back = Ray { origin: ray.origin + ray.direction * 2.0, direction: -ray.direction, ..ray };
        let rays = [ray, Ray { t_min: 1.0, ..ray }, Ray { t_max: 1.0, ..ray }, back];
        let packet = Packet::new(rays.map(Some));
        let specified = kept(&mut Intersection::default(), (Kernel::Wald, edges), &packet, query, &triangles);
        let found = kept(&mut FilteredIntersection::default(), (Kernel::Wald, edges), &packet, query, &triangles);
        cover!(s, "axis x", axis == 0);
        cover!(s, "axis y", axis == 1);
        cover!(s, "axis z", axis == 2);
        cover!(s, "hit", specified.is_hit(0));
        cover!(s, "missed", !specified.is_hit(0));
        check_eq!(found, specified, "{rays:?} and {triangles:?}");
    }
}
