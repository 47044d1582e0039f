//! Exact volumes of a ray and a triangle in whole numbers of 128 bits: for coordinates that 40 bits
//! hold, as those of a scene mostly are, and with less work than expansions.
//!
//! Twin of [`saarcor_model::rays::ExactHit`], where there is such a grid.

use super::volumes::Signs;
use glam::Vec3;
use saarcor_model::rays::{Ray, Triple};
use std::cmp::Ordering;

/// Bits of a coordinate and of a component of the direction, without the sign: a difference of
/// coordinates then has 41, a product of two 82, a component of a cross product 83, a weight, three
/// of them times the direction, 125, and the sum of the weights, or the height, 127.
const BITS: i32 = 40;

/// Coordinates and direction of a ray, and of triangles, in units that make all of them whole.
pub(super) struct Grid {
    /// Units of a coordinate, a power of two.
    units: f64,
    /// Distance of the ray over `height / sum`.
    scale: f64,
    origin: Triple<i64>,
    direction: Triple<i64>,
}

/// The volumes of [`Volumes`](super::volumes::Volumes).
pub(super) struct WholeVolumes {
    weights: [i128; 3],
    sum: i128,
    height: i128,
    scale: f64,
}

/// The power of two times which numbers up to `largest` have [`BITS`]. `None` for NaN and infinity.
fn units(largest: f32) -> Option<f64> {
    if largest == 0.0 {
        return Some(1.0);
    }
    // The exponent of an f32, which an f64 holds with any mantissa.
    let exponent = (f64::from(largest).to_bits() >> 52) as i32 - 1023;
    largest.is_finite().then(|| f64::from_bits(((BITS - 1 - exponent + 1023) as u64) << 52))
}

/// The numbers in units, if all are whole.
fn whole(numbers: Vec3, units: f64) -> Option<Triple<i64>> {
    // By a power of two: exact.
    let scaled = numbers.as_dvec3() * units;
    let whole = scaled.as_i64vec3();
    (whole.as_dvec3() == scaled).then(|| whole.to_array())
}

impl Grid {
    /// The grid of the ray and these points, which include the corners of every triangle whose volumes
    /// are asked for later; `None` where [`BITS`] are not enough, or a number is NaN or infinite.
    pub(super) fn new<'a>(ray: &Ray, points: impl IntoIterator<Item = &'a Vec3>) -> Option<Self> {
        let largest = points.into_iter().fold(ray.origin.abs(), |largest, point| {
            // NaN stays: it is not less.
            Vec3::select(largest.cmplt(point.abs()), point.abs(), largest)
        });
        let coordinate = units(largest.max_element())?;
        let direction = units(ray.direction.abs().max_element())?;
        Some(Self {
            units: coordinate,
            scale: direction / coordinate,
            origin: whole(ray.origin, coordinate)?,
            direction: whole(ray.direction, direction)?,
        })
    }

    /// The volumes with a triangle; `None` where [`BITS`] are not enough.
    pub(super) fn volumes(&self, corners: &[Vec3; 3]) -> Option<WholeVolumes> {
        let from_origin = |corner: Vec3| -> Option<Triple<i64>> {
            let corner = whole(corner, self.units)?;
            Some(std::array::from_fn(|axis| corner[axis] - self.origin[axis]))
        };
        let [a, b, c] = [from_origin(corners[0])?, from_origin(corners[1])?, from_origin(corners[2])?];
        let b_c = cross(b, c);
        let weights =
            [dot(self.direction, b_c), dot(self.direction, cross(c, a)), dot(self.direction, cross(a, b))];
        let sum = weights.iter().sum();
        Some(WholeVolumes { weights, sum, height: dot(a, b_c), scale: self.scale })
    }
}

/// `a × b`.
fn cross(a: Triple<i64>, b: Triple<i64>) -> Triple<i128> {
    let product = |p: i64, q: i64| i128::from(p) * i128::from(q);
    std::array::from_fn(|axis| {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        product(a[p], b[q]) - product(a[q], b[p])
    })
}

/// `a · b`.
fn dot(a: Triple<i64>, b: Triple<i128>) -> i128 {
    (0..3).map(|axis| i128::from(a[axis]) * b[axis]).sum()
}

impl WholeVolumes {
    /// The signs of the weights and of their sum.
    pub(super) fn signs(&self) -> Signs {
        (self.weights.map(|weight| weight.cmp(&0)), self.sum.cmp(&0))
    }

    /// Distance, and weights of the second and the third corner. Numerator, divisor and quotient are
    /// each rounded once.
    pub(super) fn point(&self) -> [f64; 3] {
        let over_sum = |number: i128| number as f64 / self.sum as f64;
        [over_sum(self.height) * self.scale, over_sum(self.weights[1]), over_sum(self.weights[2])]
    }

    /// How the distance compares to `bound`; `None` where their difference is no more than
    /// `error`, that of [`WholeVolumes::point`], or `bound` is NaN.
    pub(super) fn distance_to(&self, bound: f32, error: f64) -> Option<Ordering> {
        let ([t, ..], bound) = (self.point(), f64::from(bound));
        // A rounded distance is 0 if and only if it is.
        (bound == 0.0 || (t - bound).abs() > error).then(|| t.partial_cmp(&bound)).flatten()
    }

    /// How the distances compare of two triangles on the same grid.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        // Over sums without sign.
        let height = |it: &Self| it.height * it.sum.signum();
        let (a, b) = (height(self), height(other));
        let across = |height: i128, sum: i128| product(height.unsigned_abs(), sum.unsigned_abs());
        a.signum().cmp(&b.signum()).then_with(|| {
            let order = across(a, other.sum).cmp(&across(b, self.sum));
            if a.is_negative() { order.reverse() } else { order }
        })
    }
}

/// The product of two numbers, by its upper and its lower half.
fn product(a: u128, b: u128) -> (u128, u128) {
    let halves = |number: u128| (number >> 64, number & u128::from(u64::MAX));
    let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
    let (carried, lowest) = halves(a_low * b_low);
    // Neither sum overflows: (2^64 - 1)^2 + 2 (2^64 - 1) = 2^128 - 1.
    let (left_high, left_low) = halves(a_high * b_low + carried);
    let (right_high, middle) = halves(a_low * b_high + left_low);
    (a_high * b_high + left_high + right_high, (middle << 64) | lowest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_have_all_bits() {
        assert_eq!(product(u128::MAX, u128::MAX), (u128::MAX - 1, 1));
        assert_eq!(product(1 << 100, 3 << 60), (3 << 32, 0));
        assert_eq!(product(u128::from(u64::MAX), u128::from(u64::MAX)).1, u128::from(u64::MAX).pow(2));
    }

    /// At the ends of the range nothing overflows, as the checks of the tests' build would show.
    #[test]
    fn the_largest_numbers_have_room() {
        // 2 - 2^-23, and least where it leaves the grid: 2^-39 is a unit.
        let large = 2.0_f32.next_down();
        let ray = Ray {
            origin: Vec3::splat(-large),
            direction: Vec3::new(large, large, -large),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        for signs in 0..512_u32 {
            let sign = |at: usize| if signs & (1 << at) == 0 { large } else { -large };
            let corners = std::array::from_fn(|corner| {
                Vec3::from_array(std::array::from_fn(|axis| sign(3 * corner + axis)))
            });
            let grid = Grid::new(&ray, &corners).expect("on the grid");
            let volumes = grid.volumes(&corners).expect("on the grid");
            assert_eq!(volumes.order(&volumes), Ordering::Equal);
        }
    }

    /// On the plane x + y + 2^-21 z = 1, which the ray meets at 1 / (1 + 2^-60): in f64 that is 1.
    #[test]
    fn a_distance_that_rounds_to_the_bound_is_left_in_doubt() {
        let direction = Vec3::new(0.5, 0.5, 2.0_f32.powi(-39));
        let ray = Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: f32::INFINITY };
        let corners = [Vec3::X, Vec3::Y, Vec3::Z * 2.0_f32.powi(21)];
        let grid = Grid::new(&ray, &corners).expect("on the grid");
        let volumes = grid.volumes(&corners).expect("on the grid");
        assert_eq!((volumes.signs(), volumes.point()[0]), (([Ordering::Greater; 3], Ordering::Greater), 1.0));
        let error = 2.0 * f64::EPSILON;
        assert_eq!(volumes.distance_to(1.0, error), None);
        assert_eq!(volumes.distance_to(1.0_f32.next_down(), error), Some(Ordering::Greater));
        assert_eq!(volumes.distance_to(1.0_f32.next_up(), error), Some(Ordering::Less));
        assert_eq!(volumes.distance_to(0.0, error), Some(Ordering::Greater));
    }

    #[test]
    fn distances_are_in_order_on_both_sides_of_the_origin() {
        let at = |distance: f32| [Vec3::X, Vec3::Y, Vec3::NEG_ONE].map(|p| Vec3 { z: distance, ..p });
        let distances = [-3.0, -1.0, 0.0, 2.0, 5.0];
        let planes = distances.map(at);
        // From either side, so that sums have either sign.
        for direction in [Vec3::Z, Vec3::NEG_Z] {
            let ray = Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: f32::INFINITY };
            let grid = Grid::new(&ray, planes.as_flattened()).expect("on the grid");
            let volumes = planes.map(|corners| grid.volumes(&corners).expect("on the grid"));
            for (a, at_a) in volumes.iter().zip(distances) {
                for (b, at_b) in volumes.iter().zip(distances) {
                    let order = (at_a * direction.z).partial_cmp(&(at_b * direction.z));
                    assert_eq!(Some(a.order(b)), order, "{at_a} and {at_b} along {direction}");
                }
            }
        }
    }

    #[test]
    fn numbers_off_the_grid_are_detected() {
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, t_min: 0.0, t_max: 1.0 };
        let triangle = |least| [Vec3::new(1.0, least, 0.0), Vec3::X, Vec3::Y];
        let is_on_grid = |corners: [Vec3; 3]| {
            Grid::new(&ray, &corners).is_some_and(|grid| grid.volumes(&corners).is_some())
        };
        assert!(is_on_grid(triangle(2.0_f32.powi(1 - BITS))));
        assert!(!is_on_grid(triangle(2.0_f32.powi(-BITS))));
        assert!(!is_on_grid(triangle(f32::NAN)) && !is_on_grid(triangle(f32::INFINITY)));
    }
}
