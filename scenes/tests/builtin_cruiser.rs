//! The built-in `cruiser` against Table 1.

mod checks;

use checks::{assert_sound, build, fingerprint, image_bytes};
use glam::Vec3;

#[test]
fn has_the_numbers_of_table_1_and_is_the_same_on_every_run() {
    let scene = build("cruiser");
    assert_eq!(scene.triangles.len(), 3_637_101);
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(image_bytes(&scene), 340 << 20);
    assert!(scene.path.len() >= 2200);
    assert_sound(&scene);
    assert_eq!(fingerprint(&scene), fingerprint(&build("cruiser")));
}

#[test]
fn without_textures_the_geometry_is_the_same() {
    let scene = build("cruiser-nlnt");
    assert_eq!(scene.triangles.len(), 3_637_101);
    assert!(scene.lights.is_empty() && scene.textures.is_empty() && scene.tex_coords.is_empty());
}

#[test]
fn half_of_the_triangles_stand_in_a_thousandth_of_the_space() {
    let scene = build("cruiser-nlnt");
    let (low, high) = scene
        .triangles
        .iter()
        .flat_map(|t| t.corners)
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), corner| {
            (low.min(corner), high.max(corner))
        });
    let hall = (Vec3::new(-45.0, 6.4, -8.0), Vec3::new(-15.0, 15.0, 8.0));
    let inside = |p: Vec3| p.cmpge(hall.0).all() && p.cmple(hall.1).all();
    let dense = scene.triangles.iter().filter(|t| t.corners.into_iter().all(inside)).count();
    assert!(2 * dense > scene.triangles.len(), "{dense} triangles in the machinery hall");
    let volume = |size: Vec3| f64::from(size.x) * f64::from(size.y) * f64::from(size.z);
    assert!(volume(hall.1 - hall.0) < volume(high - low) / 1000.0);
}
