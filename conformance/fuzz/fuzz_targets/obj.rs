//! An OBJ file and, after a line `# mtl`, the materials that it names as `m.mtl`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use saarcor_scenes::load_obj;
use std::fs;

const MTL: &str = "\n# mtl\n";

fuzz_target!(|input: &[u8]| {
    let input = String::from_utf8_lossy(input);
    let (obj, mtl) = input.split_once(MTL).unwrap_or((&input, ""));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.obj");
    fs::write(&path, obj).expect("written");
    fs::write(folder.path().join("m.mtl"), mtl).expect("written");
    if let Ok(scene) = load_obj(&path) {
        for triangle in &scene.triangles {
            assert!(triangle.corners.iter().all(|corner| corner.is_finite()));
            assert!((triangle.material as usize) < scene.materials.len());
        }
    }
});
