//! What every built-in scene must hold.

use std::hash::{DefaultHasher, Hash, Hasher};

use glam::Vec3;
use saarcor_model::host::{Material, Scene, TexelFormat};
use saarcor_scenes::builtin::builtin;

/// Builds a scene that must exist.
pub fn build(name: &str) -> Scene {
    builtin(name).unwrap_or_else(|| panic!("{name} is no built-in scene"))
}

/// Asserts that the scene is one that a renderer can take as it is: sound triangles, indices in
/// range, nothing that is not used, unit cameras.
pub fn assert_sound(scene: &Scene) {
    for (i, triangle) in scene.triangles.iter().enumerate() {
        assert!(triangle.corners.iter().all(|c| c.is_finite()), "triangle {i} is not finite");
        assert!(!triangle.is_degenerate(), "triangle {i} has no area");
        assert!((triangle.material as usize) < scene.materials.len(), "triangle {i}: material");
    }
    assert_eq!(duplicates(scene), 0, "triangles that another one covers exactly");
    assert!(scene.normals.is_empty() || scene.normals.len() == scene.triangles.len());
    assert!(scene.tex_coords.is_empty() || scene.tex_coords.len() == scene.triangles.len());
    assert!(scene.tex_coords.iter().flatten().all(|t| t.is_finite()));
    assert_images_sound(scene);
    for (frame, camera) in scene.path.iter().enumerate() {
        assert!(camera.eye.is_finite(), "frame {frame}");
        assert!((camera.dir.length() - 1.0).abs() < 1e-5, "frame {frame}: {:?}", camera.dir);
        assert!((camera.up.length() - 1.0).abs() < 1e-5, "frame {frame}: {:?}", camera.up);
        assert!(camera.dir.dot(camera.up).abs() < 1e-5, "frame {frame}");
        assert!(camera.up.y > 0.0, "frame {frame} stands upside down");
    }
}

fn assert_images_sound(scene: &Scene) {
    let mut used_materials = vec![false; scene.materials.len()];
    for triangle in &scene.triangles {
        used_materials[triangle.material as usize] = true;
    }
    assert!(used_materials.iter().all(|&used| used), "unused materials: {used_materials:?}");
    let mut used = vec![false; scene.textures.len()];
    let mut expect = |image: Option<u32>, format: TexelFormat| {
        if let Some(image) = image {
            assert_eq!(scene.textures[image as usize].format, format);
            used[image as usize] = true;
        }
    };
    for Material { texture, bump, .. } in &scene.materials {
        expect(*texture, TexelFormat::Rgba8);
        expect(*bump, TexelFormat::Height8);
    }
    assert!(used.iter().all(|&used| used), "unused images: {used:?}");
    for image in &scene.textures {
        let texels = image.width as usize * image.height as usize;
        assert_eq!(image.texels.len(), texels * image.format.texel_bytes() as usize);
    }
    assert_eq!(scene.textures.is_empty(), scene.tex_coords.is_empty(), "images without coordinates");
}

/// The number of triangles whose three corners are, in some order, those of another one.
fn duplicates(scene: &Scene) -> usize {
    // Adding zero makes one of the two zeros.
    let bits = |corner: Vec3| corner.to_array().map(|x| (x + 0.0).to_bits());
    let mut keys: Vec<[[u32; 3]; 3]> = scene
        .triangles
        .iter()
        .map(|triangle| {
            let mut key = triangle.corners.map(bits);
            key.sort_unstable();
            key
        })
        .collect();
    keys.sort_unstable();
    keys.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

/// The bytes of all images.
pub fn image_bytes(scene: &Scene) -> usize {
    scene.textures.iter().map(|image| image.texels.len()).sum()
}

/// A hash of all that the scene is.
pub fn fingerprint(scene: &Scene) -> u64 {
    let mut hash = DefaultHasher::new();
    for triangle in &scene.triangles {
        triangle.corners.map(|c| c.to_array().map(f32::to_bits)).hash(&mut hash);
        triangle.material.hash(&mut hash);
    }
    for corners in &scene.tex_coords {
        corners.map(|t| t.to_array().map(f32::to_bits)).hash(&mut hash);
    }
    for image in &scene.textures {
        image.texels.hash(&mut hash);
    }
    format!("{:?} {:?} {:?}", scene.materials, scene.lights, scene.path).hash(&mut hash);
    hash.finish()
}
