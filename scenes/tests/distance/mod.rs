//! How near a point is to a scene's geometry, by trying every triangle.

use glam::Vec3;
use saarcor_model::host::{Scene, Triangle};

/// Distance from a point to the nearest point of the scene.
pub fn nearest(scene: &Scene, point: Vec3) -> f32 {
    scene.triangles.iter().map(|triangle| distance(point, triangle)).fold(f32::INFINITY, f32::min)
}

/// Distance from a point to the nearest point of a triangle.
fn distance(point: Vec3, triangle: &Triangle) -> f32 {
    let [a, b, c] = triangle.corners;
    let normal = (b - a).cross(c - a).normalize();
    let foot = point - normal * (point - a).dot(normal);
    let inside = |p: Vec3, q: Vec3| (q - p).cross(foot - p).dot(normal) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        return foot.distance(point);
    }
    let to_edge = |p: Vec3, q: Vec3| {
        let t = ((point - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
        point.distance(p.lerp(q, t))
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}
