//! The built-in `conference` against Table 1, and what makes it a room of its kind.

mod checks;
mod distance;

use checks::{assert_sound, build, fingerprint, image_bytes};
use distance::nearest;
use glam::Vec3;
use saarcor_model::host::{Triangle, features};

#[test]
fn has_the_numbers_of_table_1() {
    for (name, lights) in [("conference", 2), ("conference-nl", 0), ("conference-8l", 8)] {
        let scene = build(name);
        assert_eq!(scene.triangles.len(), 282_000, "{name}");
        assert_eq!(scene.lights.len(), lights, "{name}");
        assert_eq!(scene.path.len(), 402, "{name}: 400 frames and two stills");
        assert_eq!(image_bytes(&scene), 0, "{name}");
        assert_sound(&scene);
    }
}

#[test]
fn is_the_same_on_every_run() {
    assert_eq!(fingerprint(&build("conference")), fingerprint(&build("conference")));
}

#[test]
fn eight_lights_begin_with_the_two_and_are_as_bright_together() {
    let (two, eight) = (build("conference"), build("conference-8l"));
    assert_eq!(two.triangles, eight.triangles);
    for (one, other) in two.lights.iter().zip(&eight.lights) {
        assert_eq!(one.position, other.position);
    }
    for scene in [two, eight] {
        let sum: f32 = scene.lights.iter().map(|light| light.intensity).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    }
}

#[test]
fn has_a_small_mirror_and_neither_glass_nor_textures() {
    let scene = build("conference");
    let features = features(&scene);
    assert!(features.reflection && !features.refraction && !features.textures && !features.bump_maps);
    let mirrors = |triangle: &&Triangle| scene.materials[triangle.material as usize].reflection > 0.0;
    let area = |triangle: &Triangle| {
        let [a, b, c] = triangle.corners;
        f64::from((b - a).cross(c - a).length() / 2.0)
    };
    let part: f64 = scene.triangles.iter().filter(mirrors).map(area).sum();
    let whole: f64 = scene.triangles.iter().map(area).sum();
    assert!(part < 0.01 * whole, "{part} of {whole} square metres");
}

/// The longest edge over the height on it.
fn aspect(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    longest / (b - a).cross(c - a).length()
}

/// Of the triangles of Ward's room, as found without those that have no area, 19.5 % are slivers.
#[test]
fn is_dense_in_small_triangles_and_slivers() {
    let scene = build("conference");
    let slivers = scene.triangles.iter().filter(|triangle| aspect(triangle) > 10.0).count();
    let share = slivers as f64 / scene.triangles.len() as f64;
    assert!((0.15..0.35).contains(&share), "{share} slivers");
    let extent = |t: &Triangle| {
        let [a, b, c] = t.corners;
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    };
    let small = scene.triangles.iter().filter(|triangle| extent(triangle) < 0.03).count();
    assert!(2 * small > scene.triangles.len(), "{small} triangles fit in 3 cm");
}

#[test]
fn the_eye_keeps_its_distance_from_the_geometry() {
    let scene = build("conference");
    for (frame, camera) in scene.path.iter().enumerate().filter(|(frame, _)| frame % 20 == 0 || *frame >= 400)
    {
        let nearest = nearest(&scene, camera.eye);
        assert!(nearest > 0.3, "frame {frame}: {nearest} m at {}", camera.eye);
        assert!((1.0..2.3).contains(&camera.eye.y), "frame {frame}");
    }
}
