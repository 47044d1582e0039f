//! The built-in `pquake3` against Table 1, and its walk against its walls.

mod checks;
mod distance;

use checks::{assert_sound, build, fingerprint, image_bytes};
use distance::nearest;
use glam::Vec3;
use saarcor_model::host::Triangle;

const MIB: usize = 1 << 20;

#[test]
fn has_the_numbers_of_table_1() {
    for (name, lights, bytes) in
        [("pquake3", 1, 28 * MIB), ("pquake3-nl", 0, 28 * MIB), ("pquake3-nt", 1, 0), ("pquake3-nlnt", 0, 0)]
    {
        let scene = build(name);
        assert_eq!(scene.triangles.len(), 46_356, "{name}");
        assert_eq!(scene.lights.len(), lights, "{name}");
        assert_eq!(image_bytes(&scene), bytes, "{name}");
        assert!(scene.path.len() >= 1140, "{name}");
        assert_sound(&scene);
    }
}

#[test]
fn suffixes_change_only_what_they_name() {
    let (full, bare) = (build("pquake3"), build("pquake3-nlnt"));
    assert_eq!(full.triangles, bare.triangles);
    assert_eq!(full.path, bare.path);
    assert_eq!(full.materials, build("pquake3-nl").materials);
}

#[test]
fn is_the_same_on_every_run() {
    assert_eq!(fingerprint(&build("pquake3")), fingerprint(&build("pquake3")));
}

/// A player's radius: nothing may come nearer to the eye.
const CLEARANCE: f32 = 0.3;

#[test]
fn the_eye_keeps_its_distance_from_the_geometry() {
    let scene = build("pquake3-nlnt");
    for (frame, camera) in scene.path.iter().enumerate().step_by(10) {
        let nearest = nearest(&scene, camera.eye);
        assert!(nearest > CLEARANCE, "frame {frame}: {nearest} m at {}", camera.eye);
    }
}

#[test]
fn the_eye_stays_at_eye_height_over_a_floor() {
    let scene = build("pquake3-nlnt");
    for (frame, camera) in scene.path.iter().enumerate().step_by(10) {
        let floor = scene
            .triangles
            .iter()
            .filter_map(|triangle| drop_to(camera.eye, triangle))
            .fold(f32::INFINITY, f32::min);
        assert!((1.2..2.3).contains(&floor), "frame {frame}: floor {floor} m below {}", camera.eye);
    }
}

/// How far below a point a triangle lies, if it lies straight below.
fn drop_to(point: Vec3, triangle: &Triangle) -> Option<f32> {
    let [a, b, c] = triangle.corners.map(|corner| corner - point);
    let area = |p: Vec3, q: Vec3| p.x * q.z - p.z * q.x;
    let (u, v, w) = (area(b, c), area(c, a), area(a, b));
    let straight = u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0;
    let height = (u * a.y + v * b.y + w * c.y) / (u + v + w);
    (straight && height < 0.0).then_some(-height)
}
