//! Embree (Wald et al., "Embree: a kernel framework for efficient CPU ray tracing", 2014) as a judge
//! that others wrote: the script that runs it, what goes in and comes out, and how far off its
//! distances may be.

mod runner;

pub use runner::{ENVIRONMENTS, Embree, EmbreeAnswers, EmbreeError};

use crate::exact::rational::{nearest_f64, solve};
use glam::{DVec3, Vec3};
use saarcor_model::rays::Ray;

/// The Python script. It reads [`TRIANGLES`] and [`RAYS`] in the folder that is its argument, and
/// writes a file for each of [`FLAGS`].
pub const SCRIPT: &str = include_str!("../../embree/intersect.py");

/// The packages that the script needs, with their versions, as pip reads them.
pub const REQUIREMENTS: &str = include_str!("../../embree/requirements.txt");

/// Name of the file of triangles.
pub const TRIANGLES: &str = "triangles";
/// Name of the file of rays.
pub const RAYS: &str = "rays";
/// Names of the files of answers: with Embree's flag for robust intersection, and by default.
pub const FLAGS: [&str; 2] = ["robust", "fast"];

/// Bytes of an answer.
const ANSWER_BYTES: usize = 16;
/// In place of a triangle, says that nothing is hit.
const NOTHING: u32 = u32::MAX;

/// A hit as Embree reports it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle's number.
    pub triangle: u32,
    /// Distance along the ray.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}

/// The content of the file of triangles, given by their corners.
#[must_use]
pub fn encode_triangles(triangles: &[[Vec3; 3]]) -> Vec<u8> {
    let numbers = triangles.iter().flatten().flat_map(|corner| corner.to_array());
    numbers.flat_map(f32::to_le_bytes).collect()
}

/// The content of the file of rays. All begin at distance 0: Embree's binding takes no other.
#[must_use]
pub fn encode_rays(rays: &[Ray]) -> Vec<u8> {
    let numbers = rays.iter().flat_map(|ray| {
        let ([a, b, c], [d, e, f]) = (ray.origin.to_array(), ray.direction.to_array());
        [a, b, c, d, e, f, ray.t_max]
    });
    numbers.flat_map(f32::to_le_bytes).collect()
}

/// The answers to `rays` rays: what each hits. `None` if these are not the bytes of so many answers
/// or name a triangle that is none of `triangles`.
#[must_use]
pub fn decode_answers(bytes: &[u8], rays: usize, triangles: usize) -> Option<Vec<Option<Hit>>> {
    let (answers, rest) = bytes.as_chunks::<ANSWER_BYTES>();
    if answers.len() != rays || !rest.is_empty() {
        return None;
    }
    let answer = |bytes: &[u8; ANSWER_BYTES]| {
        let words = bytes.as_chunks().0;
        let [triangle, t, u, v] = std::array::from_fn(|word| u32::from_le_bytes(words[word]));
        let [t, u, v] = [t, u, v].map(f32::from_bits);
        match triangle {
            NOTHING => Some(None),
            triangle if (triangle as usize) < triangles => Some(Some(Hit { triangle, t, u, v })),
            _ => None,
        }
    };
    answers.iter().map(answer).collect()
}

/// By how much the distance at which Embree reports a hit of a triangle may differ from the true
/// one, to either side; infinite where nothing can be said, as in a plane that the ray hardly meets.
/// `None` where ray and plane have no one point in common. (Derived from Embree's published tests.)
///
/// Both tests compute `t = A · n / (d · n)` with the corners counted from the origin and `n` the
/// product of two edges; one takes the edges before, one after the corners were moved to the origin,
/// and it chooses which two. An edge then has an error of 2u (|A| + |B| + |C|), u = 2⁻²⁴, at most.
/// With both edges, their product of two roundings, the third factor, its product and two additions,
/// either volume is off by at most γ(10) times the volume computed from absolute values, with
/// |A| + |B| + |C| in the place of an edge. The reciprocal is an estimate to 1.5 · 2⁻¹² with one
/// Newton step, which leaves the square of that, 2.25u, and three roundings; with the product that
/// follows, 7u of the distance. Fused operations only leave roundings out.
#[must_use]
pub fn distance_bound(ray: &Ray, corners: &[Vec3; 3]) -> Option<f64> {
    let unit = f64::from(f32::EPSILON) / 2.0;
    let gamma = 10.0 * unit / (1.0 - 10.0 * unit);
    let t = nearest_f64(&solve(ray, corners)?.t);
    let (origin, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
    let normal = (b - a).cross(c - a);
    let edge = a.abs() + b.abs() + c.abs();
    let size = 2.0 * DVec3::new(edge.y * edge.z, edge.z * edge.x, edge.x * edge.y);
    let (across, error) = (d.dot(normal).abs(), gamma * d.abs().dot(size));
    if across <= error {
        return Some(f64::INFINITY);
    }
    let of_volumes = (gamma * a.abs().dot(size) + t.abs() * error) / (across - error);
    Some(of_volumes + 7.0 * unit * (t.abs() + of_volumes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read() {
        let hit = Hit { triangle: 6, t: 1.5, u: 0.25, v: 0.5 };
        let word = |word: u32| word.to_le_bytes();
        let bytes =
            [word(6), word(1.5_f32.to_bits()), word(0.25_f32.to_bits()), word(0.5_f32.to_bits())].concat();
        let nothing = [[0xFF; 4], [0; 4], [0; 4], [0; 4]].concat();
        let both = [&bytes[..], &nothing[..]].concat();
        assert_eq!(decode_answers(&both, 2, 7), Some(vec![Some(hit), None]));
        assert_eq!(decode_answers(&both, 2, 6), None, "there is no triangle 6");
        assert_eq!(decode_answers(&both, 1, 7), None);
        assert_eq!(decode_answers(&both[..31], 2, 7), None);
    }

    #[test]
    fn questions_have_the_sizes_that_the_script_reads() {
        assert_eq!(encode_triangles(&[[Vec3::ZERO, Vec3::X, Vec3::Y]; 5]).len(), 5 * 36);
        let ray = Ray { origin: Vec3::X, direction: Vec3::Y, t_min: 0.0, t_max: 2.0 };
        let bytes = encode_rays(&[ray; 3]);
        assert_eq!(
            (bytes.len(), &bytes[..4], &bytes[24..28]),
            (84, &1.0_f32.to_le_bytes()[..], &2.0_f32.to_le_bytes()[..])
        );
    }

    #[test]
    fn bound_grows_with_the_distance_of_the_origin_and_the_angle() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let bound = |z: f32, slope: f32| {
            let ray = Ray {
                origin: Vec3::new(0.25, 0.25, z),
                direction: Vec3::new(slope, 0.0, -1.0),
                t_min: 0.0,
                t_max: f32::INFINITY,
            };
            distance_bound(&ray, &corners).expect("not parallel")
        };
        assert!(bound(1.0, 0.0) < 1e-5 && bound(1.0, 0.0) > 1e-7);
        assert!(bound(100.0, 0.0) > 100.0 * bound(1.0, 0.0));
        assert!(bound(1.0, 1e4) > 100.0 * bound(1.0, 0.0) && bound(1.0, 1e9) == f64::INFINITY);
        let within = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_min: 0.0, t_max: 1.0 };
        assert_eq!(distance_bound(&within, &corners), None);
    }
}
