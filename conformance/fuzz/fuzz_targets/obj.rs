//! An OBJ file and, after a line `# mtl`, the materials that it names as `m.mtl`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use glam::Vec3;
use saarcor_scenes::{LoadOptions, load_obj};
use std::fs;

const MTL: &str = "\n# mtl\n";

fuzz_target!(|input: &[u8]| {
    let input = String::from_utf8_lossy(input);
    let (obj, mtl) = input.split_once(MTL).unwrap_or((&input, ""));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.obj");
    fs::write(&path, obj).expect("written");
    fs::write(folder.path().join("m.mtl"), mtl).expect("written");
    let loaded = load_obj(&path, LoadOptions::default());
    if let Ok(loaded) = &loaded {
        let scene = &loaded.scene;
        for triangle in &scene.triangles {
            assert!(triangle.corners.iter().all(|corner| corner.is_finite()));
            assert!((triangle.material as usize) < scene.materials.len());
        }
        assert!(scene.tex_coords.iter().flatten().all(|uv| uv.is_finite()));
        assert!(scene.normals.iter().flatten().all(|normal| normal.is_finite()));
        for material in &scene.materials {
            assert!(material.reflection + material.refraction <= 1.0);
            assert!(material.specular.cmple(Vec3::ONE).all() && material.diffuse.cmpge(Vec3::ZERO).all());
        }
        assert!(loaded.warnings.iter().all(|warning| warning.to_string().lines().count() == 1));
    }
    // Whatever is assumed is refused where nothing is to be.
    let strict = load_obj(&path, LoadOptions { strict: true, ..LoadOptions::default() });
    assert_eq!(strict.is_ok(), loaded.is_ok_and(|loaded| loaded.warnings.is_empty()));
});
