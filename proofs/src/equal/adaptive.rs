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

use crate::draw::WORDS;
use crate::source::Source;
use crate::{check, check_eq, cover, theorems};
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle, FilteredIntersection};
use saarcor_model::host::Kernel;
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

/// What an intersection unit finds first of triangles at these addresses, one after the other.
fn first_of(
    unit: &mut impl IntersectionUnit<1>,
    kernel: Kernel,
    ray: &Ray,
    query: Query,
    triangles: [(u32, [Point; 3]); 2],
) -> Hits<1> {
    let packet = Packet::new([Some(*ray)]);
    let mut hits = Hits::none(&packet);
    for (addr, corners) in triangles {
        let triangle = StoredTriangle::new(HostAddr(addr), kernel, &corners.map(Into::into));
        unit.intersect(&triangle, &packet, &Intervals::EVERYWHERE, query, &mut hits);
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
        covers ["hit", "missed", "at a vertex", "outside of the range", "no plane"]
    ]
    fn adaptive_test_is_the_exact_one(s) {
        let world = s.value("world", 0..=7, &WORDS[..8]);
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
        let specified = ExactHit::new(&ray, &corners).map(|hit| hit.point());
        let endless = ExactHit::new(&Ray { t_min: 0.0, t_max: f32::INFINITY, ..ray }, &corners);
        let triangle = AdaptiveTriangle::new(&corners);
        let found = triangle.intersect(&AdaptiveRay::new(&ray)).map(|hit| [hit.t, hit.u, hit.v]);
        cover!(s, "hit", specified.is_some());
        cover!(s, "missed", endless.is_none());
        cover!(s, "at a vertex", specified.is_some_and(|[_, u, v]| u == 0.0 && v == 0.0));
        cover!(s, "outside of the range", endless.is_some() && specified.is_none());
        cover!(s, "no plane", a == b || b == c || c == a);
        check_eq!(found.is_some(), specified.is_some(), "{ray:?} and {corners:?}");
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

    /// Of two triangles, the fast intersection unit keeps the one that the specified unit keeps,
    /// whichever it is given first: the nearer one, and at the same distance the one at the lower address.
    #[
        "IS-2", not_for_kani "it is arithmetic in floating point",
        covers ["both hit", "at the same distance", "nearer by less than an f32", "one hit", "any hit"]
    ]
    fn fast_intersection_unit_keeps_the_same_triangle(s) {
        let world = s.value("world", 0..=7, &WORDS[..8]);
        let origin = point(s, world, [&ZERO_AND_THREE, &ZERO_AND_THREE, &ZERO_AND_THREE[1..]]);
        // Two triangles that share a corner.
        let a = point(s, world, [&WORDS[1..2], &WORDS[1..2], &MINUS_ONE_AND_ONE]);
        let b = point(s, world, [&ONE_AND_TWO[..1], &MINUS_ONE_AND_ONE, &ZERO_AND_TWO]);
        let c = point(s, world, [&MINUS_ONE_AND_ONE, &ONE_AND_TWO[..1], &ZERO_AND_TWO[..1]]);
        let d = point(s, world, [&ONE_AND_TWO, &MINUS_ONE_AND_ONE, &ONE_AND_TWO]);
        let e = point(s, world, [&MINUS_ONE_AND_ONE, &ONE_AND_TWO[..1], &ZERO_AND_TWO[..1]]);
        let ray = aimed(s, origin, [a, b, c]);
        let query = if s.value("query (closest, any)", 0..=1, &WORDS[..2]) == 0 { Query::Closest } else { Query::Any };
        let (first, second) = ((72, [a, b, c]), (36, [a, d, e]));
        let exact = |corners: [Point; 3]| ExactHit::new(&ray, &corners.map(Into::into));
        let (p, q) = (exact(first.1), exact(second.1));
        let equal = p.zip(q).is_some_and(|(p, q)| p.order(&q).is_eq());
        let near = p.zip(q).is_some_and(|(p, q)| p.rounded()[0] == q.rounded()[0] && !p.order(&q).is_eq());
        cover!(s, "both hit", p.is_some() && q.is_some());
        cover!(s, "at the same distance", equal);
        cover!(s, "nearer by less than an f32", near);
        cover!(s, "one hit", p.is_some() != q.is_some());
        cover!(s, "any hit", query == Query::Any && p.is_some());
        for triangles in [[first, second], [second, first]] {
            let specified = first_of(&mut Intersection::default(), Kernel::Adaptive, &ray, query, triangles);
            let found = first_of(&mut FilteredIntersection::default(), Kernel::Adaptive, &ray, query, triangles);
            check_eq!(found.triangle, specified.triangle, "{ray:?} and {triangles:?}, {query:?}");
            let near = found.t == specified.t || are_near(found.t[0].into(), specified.t[0].into());
            check!(near, "{ray:?} and {triangles:?}, {query:?}: at {:?}, not {:?}", found.t, specified.t);
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
        let origin = point(s, world, [&ZERO_AND_THREE, &ZERO_AND_THREE, &ZERO_AND_THREE[..1]]);
        let a = point(s, world, [&MINUS_ONE_AND_ONE; 3]);
        let b = point(s, world, [&MINUS_ONE_AND_ONE, &MINUS_ONE_AND_ONE, &ONE_AND_TWO[..1]]);
        let c = point(s, world, [&ZERO_AND_TWO; 3]);
        let ray = aimed(s, origin, [a, b, c]);
        let triangles = [(72, [a, b, c]), (36, [c, b, a])];
        let axis = Kernel::Wald.record(&triangles[0].1.map(Into::into)).tag;
        let specified = first_of(&mut Intersection::default(), Kernel::Wald, &ray, Query::Closest, triangles);
        let found = first_of(&mut FilteredIntersection::default(), Kernel::Wald, &ray, Query::Closest, triangles);
        cover!(s, "axis x", axis == 0);
        cover!(s, "axis y", axis == 1);
        cover!(s, "axis z", axis == 2);
        cover!(s, "hit", specified.is_hit(0));
        cover!(s, "missed", !specified.is_hit(0));
        check_eq!(found, specified, "{ray:?} and {triangles:?}");
    }
}
