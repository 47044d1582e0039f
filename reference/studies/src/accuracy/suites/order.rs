//! Distances that are nearly or exactly equal: to the ends of the range, and to each other.

use super::{Suite, at, point, towards, triangle};
use crate::accuracy::case::{Case, Truth};
use glam::Vec3;
use saarcor_model::host::Edges;
use saarcor_model::rays::Ray;

/// A range that begins or ends at the f32 nearest to the hit's distance, or at a neighbour of it.
pub(super) const RANGE_ENDS: Suite = Suite {
    name: "range-ends",
    idea: "hits at t_min and t_max",
    closed: false,
    degenerate: true,
    generate: |random| {
        let corners = triangle(random);
        let origin = point(random);
        let (u, v) = (random.between(0.1, 0.5), random.between(0.1, 0.5));
        let aimed = towards(random, origin, at(&corners, u, v));
        let mut case = Case { ray: aimed, triangles: vec![corners] };
        let t = Truth::of(&case, Edges::Shared).0.first().map_or(1.0, |found| found.t as f32);
        let end = [t, t.next_up(), t.next_down()][random.range(0, 3) as usize];
        case.ray = if random.range(0, 2) == 0 {
            Ray { t_min: end, ..case.ray }
        } else {
            Ray { t_max: end, ..case.ray }
        };
        case
    },
};

/// Two triangles of which the second is the first with coordinates moved to neighbouring f32: their
/// hits are an ulp apart or equal. The one that was moved comes first or second.
pub(super) const COPLANAR_PAIRS: Suite = Suite {
    name: "coplanar-pairs",
    idea: "two triangles an ulp apart",
    closed: false,
    degenerate: false,
    generate: |random| {
        let first = triangle(random);
        let second = first.map(|corner| {
            Vec3::from(corner.to_array().map(|x| match random.range(0, 3) {
                0 => x.next_up(),
                1 => x.next_down(),
                _ => x,
            }))
        });
        let (u, v) = (random.between(0.05, 0.5), random.between(0.05, 0.45));
        let origin = point(random);
        let mut triangles = vec![first, second];
        triangles.rotate_left(random.range(0, 2) as usize);
        Case { ray: towards(random, origin, at(&first, u, v)), triangles }
    },
};
