//! One triangle, of any shape and from any angle.

use super::{Suite, at, point, power_of_ten, towards, triangle};
use crate::accuracy::case::Case;

/// Three random corners in a cube, a ray from the cube towards a random point of the plane, half of
/// them within the triangle.
pub(super) const GENERIC: Suite = Suite {
    name: "generic",
    idea: "a random triangle and a ray towards its plane",
    closed: false,
    degenerate: false,
    generate: |random| {
        let corners = triangle(random);
        let (u, v) = (random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let origin = point(random);
        Case { ray: towards(random, origin, at(&corners, u, v)), triangles: vec![corners] }
    },
};

/// A triangle whose height is 10^-1 to 10^-7 of its base; the ray is aimed near it, half of the
/// rays within it.
pub(super) const SLIVERS: Suite = Suite {
    name: "slivers",
    idea: "triangles 10 to 10^7 times as long as wide",
    closed: false,
    degenerate: false,
    generate: |random| {
        let [a, b, third] = triangle(random);
        let aspect = power_of_ten(random, -7.0, -1.0);
        let along = random.unit();
        let corners = [a, b, a.lerp(b, along) + (third - a) * aspect];
        let (u, v) = (random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let origin = point(random);
        Case { ray: towards(random, origin, at(&corners, u, v)), triangles: vec![corners] }
    },
};

/// A ray at 10^-1 to 10^-7 rad to the triangle's plane, towards a point of the plane, half of them
/// within the triangle.
pub(super) const GRAZING: Suite = Suite {
    name: "grazing",
    idea: "rays 0.1 to 10^-7 rad off the plane",
    closed: false,
    degenerate: false,
    generate: |random| {
        let corners = triangle(random);
        let (u, v) = (random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let target = at(&corners, u, v);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(glam::Vec3::Z);
        let along = (point(random).cross(normal)).normalize_or(glam::Vec3::X);
        let origin = target - along + normal * power_of_ten(random, -7.0, -1.0);
        Case { ray: towards(random, origin, target), triangles: vec![corners] }
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slivers_are_thin() {
        let thinnest = (0..1000).map(|number| {
            let [a, b, c] = SLIVERS.case(1, number).triangles[0];
            (b - a).cross(c - a).length() / (b - a).length_squared()
        });
        assert!(thinnest.fold(f32::INFINITY, f32::min) < 1e-6);
    }
}
