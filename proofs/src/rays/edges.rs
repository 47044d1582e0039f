//! Theorems of owned edges (IS-6): a closed surface is hit once wherever a ray crosses it.
//!
//! The judge knows no rule of ownership: it cuts a line by the planes of a tetrahedron's faces, in whole numbers.

use crate::draw::{self, WORDS};
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use glam::Vec3;
use saarcor_model::host::Edges;
use saarcor_model::rays::{ExactHit, Number, Ray, TriangleTest, WatertightTriangle};
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Whole coordinates.
type Point = [i64; 3];

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> i64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A point with coordinates from -2 to 6.
fn point(s: &mut impl Source, axes: [&'static [u32]; 3]) -> Point {
    let mut point = [0; 3];
    for axis in 0..3 {
        point[axis] = i64::from(s.value("coordinate + 2", 0..=8, axes[axis])) - 2;
    }
    point
}

/// What a line and a tetrahedron have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meets {
    Nothing,
    /// Points of its surface alone.
    Surface,
    Inside,
}

/// A face, and the distance of a point of the line over its plane, positive inside: `at + t · along`.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [Point; 3],
    at: i64,
    along: i64,
}

/// The faces of a tetrahedron, each opposite to the corner of its number.
fn faces(corners: [Point; 4], origin: Point, direction: Point) -> [Face; 4] {
    std::array::from_fn(|number| {
        let [p, q, r] = [1, 2, 3].map(|next| corners[(number + next) % 4]);
        let normal = cross(sub(q, p), sub(r, p));
        let inwards = dot(normal, sub(corners[number], p)).signum();
        let (at, along) = (inwards * dot(normal, sub(origin, p)), inwards * dot(normal, direction));
        Face { corners: [p, q, r], at, along }
    })
}

/// The line is cut by the planes of the faces one after the other (Cyrus and Beck 1978).
fn meets(faces: &[Face; 4]) -> Meets {
    let parallel = |face: &&Face| face.along == 0;
    let mut meets = Meets::Inside;
    for face in faces.iter().filter(parallel) {
        match face.at.signum() {
            1 => {}
            0 => meets = Meets::Surface,
            _ => return Meets::Nothing,
        }
    }
    // It enters at -at / along of the one face, and leaves at that of the other.
    for entered in faces.iter().filter(|face| face.along > 0) {
        for left in faces.iter().filter(|face| face.along < 0) {
            match (entered.at * left.along - left.at * entered.along).signum() {
                -1 => {}
                0 => meets = Meets::Surface,
                _ => return Meets::Nothing,
            }
        }
    }
    meets
}

/// The corners in one of their six orders.
fn turned([a, b, c]: [Point; 3], order: u32) -> [Vec3; 3] {
    let corners = [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]][order as usize % 6];
    corners.map(|corner| Vec3::from(corner.map(|x| x as f32)))
}

static ENDS: [u32; 2] = [1, 4];
static MIDDLE: [u32; 2] = [2, 3];

/// 2^24 is 0; around it, and around numbers whose products are rounded in f32.
static ACROSS: [[u32; 3]; 4] = [
    [1 << 24, (1 << 24) + 4097, (1 << 24) - 4099],
    [1 << 24, (1 << 24) + 4098, (1 << 24) - 4097],
    [(1 << 24) + 1, (1 << 24) - 4098, (1 << 24) + 4099],
    [(1 << 24) - 4097, (1 << 24) + 4097, 1 << 24],
];

/// Whole numbers, the bits of an f32, and so small that nothing overflows: a check for that would take Kani longer than the rest. A quotient is right
/// where the divisor is 1 or -1, and else 0: nobody asks for it.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Whole(i32);

macro_rules! whole {
    ($($operation:ident :: $function:ident, |$a:ident, $b:ident| $result:expr;)*) => {$(
        impl $operation for Whole {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                let ($a, $b) = (self.0, other.0);
                Self($result)
            }
        }
    )*};
}

whole! {
    Add::add, |a, b| a.wrapping_add(b);
    Sub::sub, |a, b| a.wrapping_sub(b);
    Mul::mul, |a, b| a.wrapping_mul(b);
    Div::div, |a, b| if b == 1 { a } else if b == -1 { a.wrapping_neg() } else { 0 };
}

impl Neg for Whole {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

impl Number for Whole {
    const ZERO: Self = Self(0);
    const ONE: Self = Self(1);

    fn from_f32(value: f32) -> Self {
        Self(value.to_bits() as i32)
    }

    /// Of no test that is asked.
    fn from_f64(_value: f64) -> Self {
        Self(0)
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn is_finite(self) -> bool {
        true
    }

    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        (a * b).0.cmp(&(c * d).0)
    }
}

static COORDINATES: [u32; 5] = [5, 7, 8, 9, 12];

theorems! {
    /// In whole numbers, a ray along an axis that passes between the ends of an edge hits by the watertight test exactly one of two triangles on
    /// either side of it, where edges are owned: also through the edge itself.
    #["IS-6", unwind 6, covers ["the first", "the second", "the first, through the edge", "the second, through the edge", "an edge along an axis"]]
    fn edge_between_whole_numbers_is_hit_from_one_side(s) {
        let mut ends = [[0; 2]; 2];
        for end in 0..2 {
            for axis in 0..2 {
                ends[end][axis] = s.value("coordinate of an end + 8", 0..=15, &COORDINATES) as i32 - 8;
            }
        }
        let [p, q] = ends;
        let apex = match s.value("direction of the first triangle", 0..=3, &WORDS[..4]) {
            0 => [0, 8],
            1 => [8, 0],
            2 => [-8, -4],
            _ => [4, -8],
        };
        let opposite = [-apex[0], -apex[1]];
        let side =
            |p: [i32; 2], q: [i32; 2]| p[0].wrapping_mul(q[1]).wrapping_sub(p[1].wrapping_mul(q[0]));
        let (through, after, before) = (side(p, q), side(q, apex), side(apex, p));
        // Between the ends, seen from either apex; both triangles are seen from the front.
        assume!(after > 0 && before > 0 && through.abs() < after + before);
        let whole = |number: i32| f32::from_bits(number as u32);
        let corner = |[x, y]: [i32; 2]| Vec3::new(whole(x), whole(y), whole(1));
        let ray = WatertightTriangle::<Whole>::ray([0.0; 3], [0.0, 0.0, whole(1)]);
        let hits = |a, b, c| {
            let test = WatertightTriangle::<Whole>::new(&[corner(a), corner(b), corner(c)]);
            test.intersect::<true>(&ray).inside
        };
        let (first, second) = (hits(p, q, apex), hits(q, p, opposite));
        cover!(s, "the first", first && through > 0);
        cover!(s, "the second", second && through < 0);
        cover!(s, "the first, through the edge", first && through == 0);
        cover!(s, "the second, through the edge", second && through == 0);
        cover!(s, "an edge along an axis", through == 0 && p[0] == q[0]);
        check!(first != second, "{p:?} to {q:?}, {apex:?}: {first}, {second}");
    }

    /// Where edges are owned, a line that meets the inside of a tetrahedron hits exactly one face where it enters and exactly
    /// one where it leaves, also at edges and vertices, and along planes of faces and edges; a line that meets nothing but the surface
    /// hits one of each, or none; in whatever order each face names its corners.
    #[
        "IS-6", not_for_kani "it is arithmetic on numbers of 1700 bits",
        covers ["inside", "enters at an edge", "enters at a vertex", "from a vertex on", "touches, and hits", "touches, and hits nothing", "along an edge", "in a plane", "nothing"]
    ]
    fn line_enters_a_tetrahedron_once(s) {
        let a = point(s, [&ENDS, &ENDS, &WORDS[2..3]]);
        let b = point(s, [&WORDS[5..6], &ENDS, &MIDDLE]);
        let c = point(s, [&ENDS, &MIDDLE, &WORDS[6..7]]);
        let d = point(s, [&MIDDLE, &WORDS[6..7], &ENDS]);
        let from = point(s, [&ENDS, &MIDDLE, &WORDS[..1]]);
        let corners = [a, b, c, d];
        assume!(dot(sub(b, a), cross(sub(c, a), sub(d, a))) != 0);
        let aim = s.value("aim (vertex, edge, along an edge, from edge to edge, from a vertex through the inside, from a vertex in a plane, inside, free)", 0..=7, &WORDS[..8]);
        // Twice the first point, and four times the way to the second.
        let (origin, direction) = match aim {
            0 => (from.map(|x| 2 * x), sub(a, from)),
            1 => (from.map(|x| 2 * x), sub(sub(a, from), sub(from, b))),
            2 => (sub(a, sub(b, a)).map(|x| 2 * x), sub(b, a)),
            3 => ([a[0] + b[0], a[1] + b[1], a[2] + b[2]], sub([c[0] + d[0], c[1] + d[1], c[2] + d[2]], [a[0] + b[0], a[1] + b[1], a[2] + b[2]])),
            4 => (a.map(|x| 2 * x), sub(sub(b, a), sub(sub(a, c), sub(d, a)))),
            5 => (a.map(|x| 2 * x), sub(sub(b, a), sub(c, b))),
            6 => (from.map(|x| 2 * x), sub(sub(sub(a, from), sub(from, b)), sub(sub(from, c), sub(d, from)))),
            _ => (from.map(|x| 2 * x), sub(d, b)),
        };
        assume!(direction != [0; 3]);
        let doubled = corners.map(|corner| corner.map(|x| 2 * x));
        let order = s.value("order of corners", 0..=5, &WORDS[..3]);
        let [start, way] = [origin, direction].map(|point| Vec3::from(point.map(|x| x as f32)));
        // The whole line.
        let ray = Ray { origin: start, direction: way, t_min: f32::NEG_INFINITY, t_max: f32::INFINITY };
        let faces = faces(doubled, origin, direction);
        let meets = meets(&faces);
        let (mut entered, mut left) = (0, 0);
        let (mut shared_entries, mut in_plane) = (0, 0);
        for (face, number) in faces.iter().zip(0..) {
            let corners = turned(face.corners, order + number);
            let hit = i32::from(ExactHit::new(&ray, &corners, Edges::Owned).is_some());
            let shared = i32::from(ExactHit::new(&ray, &corners, Edges::Shared).is_some());
            match face.along.signum() {
                1 => (entered, shared_entries) = (entered + hit, shared_entries + shared),
                -1 => left += hit,
                _ => {
                    in_plane += i32::from(face.at == 0);
                    check_eq!(hit, 0, "{ray:?}: in the plane of {corners:?}, or parallel to it");
                }
            }
        }
        cover!(s, "inside", meets == Meets::Inside);
        cover!(s, "enters at an edge", meets == Meets::Inside && shared_entries == 2);
        cover!(s, "enters at a vertex", meets == Meets::Inside && shared_entries == 3);
        cover!(s, "from a vertex on", meets == Meets::Inside && aim == 4);
        cover!(s, "touches, and hits", meets == Meets::Surface && entered == 1);
        cover!(s, "touches, and hits nothing", meets == Meets::Surface && entered == 0);
        cover!(s, "along an edge", in_plane == 2);
        cover!(s, "in a plane", in_plane == 1 && meets == Meets::Surface);
        cover!(s, "nothing", meets == Meets::Nothing);
        let right = match meets {
            Meets::Inside => entered == 1,
            Meets::Surface => entered <= 1,
            Meets::Nothing => entered == 0,
        };
        check!(right && entered == left, "{ray:?} meets {meets:?} of {doubled:?}: enters {entered} times, leaves {left} times");
    }

    /// Where edges are owned, a ray along an axis hits by the watertight test none or exactly two of the four faces of any
    /// tetrahedron that is not seen from an edge of a face but exactly: however its coordinates round.
    #[
        "IS-6", not_for_kani "it is arithmetic in floating point",
        covers ["two", "none", "at an edge", "at a vertex", "two at an edge", "seen from an edge"]
    ]
    fn watertight_test_hits_two_faces_or_none(s) {
        let axis = s.value("axis of the ray", 0..=2, &WORDS[..2]) as usize;
        let backwards = draw::flag(s, "against the axis");
        let mut flat = [[0; 2]; 4];
        for (corner, some) in flat.iter_mut().zip(&ACROSS) {
            for at in corner {
                *at = i64::from(s.value("2^24 + coordinate across the ray", 0..=1 << 25, some)) - (1 << 24);
            }
        }
        let side = |p: [i64; 2], q: [i64; 2]| p[0] * q[1] - p[1] * q[0];
        let mut direction = [0.0; 3];
        direction[axis] = if backwards { -1.0 } else { 1.0 };
        let ray = WatertightTriangle::<f32>::ray([0.0; 3], direction);
        let order = s.value("order of corners", 0..=2, &WORDS[..1]) as usize;
        let (mut hits, mut shared, mut seen_from_edge) = (0, 0, false);
        for face in 0..4 {
            let corners = [1, 2, 3].map(|next| flat[(face + next) % 4]);
            let [p, q, r] = [0, 1, 2].map(|corner| corners[(corner + order) % 3]);
            let sides = [side(q, r), side(r, p), side(p, q)];
            let area = sides[0] + sides[1] + sides[2];
            // Or else what the edge functions are rounded to may be 0 all three.
            let largest = [p, q, r].as_flattened().iter().fold(0, |largest, x| x.abs().max(largest));
            assume!(area == 0 || area.abs() > (largest * largest) >> 20);
            seen_from_edge |= area == 0;
            let corners = [p, q, r].map(|[x, y]| {
                let mut corner = [direction[axis]; 3];
                (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (x as f32, y as f32);
                Vec3::from(corner)
            });
            let test = WatertightTriangle::<f32>::new(&corners);
            hits += i32::from(test.intersect::<true>(&ray).inside);
            shared += i32::from(test.intersect::<false>(&ray).inside);
        }
        cover!(s, "two", hits == 2);
        cover!(s, "none", hits == 0);
        cover!(s, "at an edge", shared == 3 || shared == 4);
        cover!(s, "at a vertex", flat.contains(&[0, 0]));
        cover!(s, "two at an edge", hits == 2 && shared > 2);
        cover!(s, "seen from an edge", seen_from_edge && hits == 2);
        check!(hits == 0 || hits == 2, "{flat:?} along axis {axis}, order {order}: {hits} hits, {shared} with shared edges");
    }
}
