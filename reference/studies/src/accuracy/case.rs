//! A ray against a few triangles, and the exact answer.

use glam::Vec3;
use saarcor_model::host::Edges;
use saarcor_model::rays::Ray;
use saarcor_oracles::exact::rational::nearest_f64;
use saarcor_oracles::exact::{closest, is_owned_hit, solve};

/// A ray and the triangles that it is tested against.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The ray with its range.
    pub ray: Ray,
    /// Corners; a triangle is known by its place here, which stands for its address.
    pub triangles: Vec<[Vec3; 3]>,
}

/// A hit, in the numbers of the judge or of a contestant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The triangle's place.
    pub triangle: u32,
    /// Distance along the ray.
    pub t: f64,
    /// Barycentric weights of the second and the third corner.
    pub weights: [f64; 2],
}

/// The first hit of a ray, exactly; the numbers are the nearest f64. Several triangles, if they are
/// hit at the very same distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth(pub Vec<Found>);

impl Truth {
    /// The exact answer to a case, by the rule for edges and vertices.
    #[must_use]
    pub fn of(case: &Case, edges: Edges) -> Self {
        let has =
            |(_, corners): &(u32, [Vec3; 3])| edges == Edges::Shared || is_owned_hit(&case.ray, corners);
        let numbered = (0..).zip(case.triangles.iter().copied()).filter(has);
        let Some(first) = closest(&case.ray, numbered) else { return Self(Vec::new()) };
        let found = first.triangles.into_iter().filter_map(|(triangle, _)| {
            let point = solve(&case.ray, &case.triangles[triangle as usize])?;
            let [t, u, v] = [point.t, point.u, point.v].map(|number| nearest_f64(&number));
            Some(Found { triangle, t, weights: [u, v] })
        });
        Self(found.collect())
    }

    /// The hit of this triangle, if it is one of those that are hit first.
    #[must_use]
    pub fn of_triangle(&self, triangle: u32) -> Option<&Found> {
        self.0.iter().find(|found| found.triangle == triangle)
    }
}

/// The distance of neighbouring f32 where `t` is.
#[must_use]
pub fn ulp(t: f64) -> f64 {
    let below = t.abs().max(f64::from(f32::MIN_POSITIVE));
    // The power of two below, and 23 bits down.
    f64::from_bits(below.to_bits() & (0x7FF << 52)) * f64::from(f32::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulp_is_the_distance_of_neighbours() {
        for t in [1.0_f32, 1.5, 3.0e-38, 1.0e-44, 0.0, 12_345.678, f32::MAX.next_down()] {
            assert_eq!(ulp(f64::from(t)), f64::from(t.next_up()) - f64::from(t), "{t:e}");
        }
    }
}
