//! The built-in `sodahall` against Table 1, and its walk against its walls.

mod checks;
mod distance;

use std::collections::BTreeSet;

use checks::{assert_sound, build, fingerprint, image_bytes};
use distance::nearest;
use saarcor_model::host::features;

#[test]
fn has_the_numbers_of_table_1_and_is_the_same_on_every_run() {
    let scene = build("sodahall");
    assert_eq!(scene.triangles.len(), 1_510_322);
    assert!(scene.lights.is_empty());
    assert_eq!(scene.path.len(), 600);
    assert_eq!(image_bytes(&scene), 0);
    assert_sound(&scene);
    assert_eq!(fingerprint(&scene), fingerprint(&build("sodahall")));
}

#[test]
fn needs_nothing_but_primary_rays() {
    let features = features(&build("sodahall"));
    assert!(!features.reflection && !features.refraction && !features.textures && features.lights == 0);
}

#[test]
fn triangles_are_spread_over_seven_floors() {
    let scene = build("sodahall");
    let mut floors = [0_usize; 7];
    for triangle in &scene.triangles {
        let middle = triangle.corners.iter().map(|corner| corner.y).sum::<f32>() / 3.0;
        floors[((middle / 3.6).max(0.0) as usize).min(6)] += 1;
    }
    for (floor, count) in floors.into_iter().enumerate() {
        assert!(count > scene.triangles.len() / 9, "floor {floor} has {count} triangles");
    }
}

#[test]
fn the_eye_keeps_its_distance_from_the_geometry() {
    let scene = build("sodahall");
    for (frame, camera) in scene.path.iter().enumerate().filter(|(frame, _)| frame % 20 == 0 || *frame >= 600)
    {
        let nearest = nearest(&scene, camera.eye);
        assert!(nearest > 0.3, "frame {frame}: {nearest} m at {}", camera.eye);
    }
}

#[test]
fn the_walk_climbs_a_stair_without_leaps() {
    let scene = build("sodahall");
    let walk = &scene.path[..600];
    for pair in walk.windows(2) {
        assert!(pair[0].eye.distance(pair[1].eye) < 0.4);
        assert!(pair[0].dir.dot(pair[1].dir) > 0.8, "{} to {}", pair[0].dir, pair[1].dir);
    }
    let storeys: BTreeSet<u32> = walk.iter().map(|camera| (camera.eye.y / 3.6) as u32).collect();
    assert_eq!(storeys, BTreeSet::from([0, 1]));
}
