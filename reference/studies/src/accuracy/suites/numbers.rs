//! Numbers that are large, small, zero, or both at a time.

use super::{Suite, at, point, power_of_ten, ray, towards, triangle};
use crate::accuracy::case::Case;
use glam::Vec3;

/// The generic case moved by 10^3 to 10^7 along a random direction, so that coordinates keep a few
/// bits for the shape.
pub(super) const FAR: Suite = Suite {
    name: "far",
    idea: "10^3 to 10^7 away from the origin",
    closed: false,
    degenerate: false,
    generate: |random| {
        let offset = point(random) * power_of_ten(random, 3.0, 7.0);
        let spacing = offset.abs().max_element() * f32::EPSILON;
        // No smaller than a few hundred of the spacings of f32 there.
        let size = (spacing * 400.0).max(1.0);
        let corners = triangle(random).map(|corner| corner * size + offset);
        let (u, v) = (random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let origin = point(random) * size + offset;
        Case { ray: towards(random, origin, at(&corners, u, v)), triangles: vec![corners] }
    },
};

/// The generic case scaled by 10^-18 to 10^18, the direction by another such factor, and one corner
/// or the origin by a third.
pub(super) const SCALES: Suite = Suite {
    name: "scales",
    idea: "sizes from 10^-18 to 10^18, mixed",
    closed: false,
    degenerate: false,
    generate: |random| {
        let scale = power_of_ten(random, -18.0, 18.0);
        let mut corners = triangle(random).map(|corner| corner * scale);
        let mut origin = point(random) * scale;
        match random.range(0, 3) {
            0 => corners[2] *= power_of_ten(random, -3.0, 0.0),
            1 => origin *= power_of_ten(random, -3.0, 0.0),
            _ => {}
        }
        let (u, v) = (random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let direction = (at(&corners, u, v) - origin).normalize_or(Vec3::Z);
        let length = power_of_ten(random, -18.0, 18.0);
        Case { ray: ray(origin, direction * length), triangles: vec![corners] }
    },
};

/// A ray along an axis or in a plane of two axes, the other components 0.0 or -0.0, through a
/// triangle across it.
pub(super) const ZERO_COMPONENTS: Suite = Suite {
    name: "zero-components",
    idea: "directions with components 0.0 and -0.0",
    closed: false,
    degenerate: false,
    generate: |random| {
        let corners = triangle(random);
        let target = at(&corners, random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let zeros = random.range(1, 7);
        let mut direction = point(random);
        for axis in (0..3).filter(|axis| zeros & (1 << axis) != 0) {
            direction[axis] = if random.range(0, 2) == 0 { 0.0 } else { -0.0 };
        }
        Case { ray: ray(target - direction, direction), triangles: vec![corners] }
    },
};

/// The generic case with coordinates below 10^-38, which are denormal.
pub(super) const DENORMAL: Suite = Suite {
    name: "denormal",
    idea: "denormal coordinates",
    closed: false,
    degenerate: false,
    generate: |random| {
        let scale = power_of_ten(random, -43.0, -38.5);
        let corners = triangle(random).map(|corner| corner * scale);
        let (u, v) = (random.between(-0.25, 1.0), random.between(-0.25, 1.0));
        let origin = point(random) * scale;
        let target = at(&corners, u, v);
        let unit = random.range(0, 2) == 0;
        let aimed = towards(random, origin, target);
        let direction = if unit { (aimed.direction * 1e30).normalize_or(Vec3::Z) } else { aimed.direction };
        Case { ray: ray(origin, direction), triangles: vec![corners] }
    },
};
