//! What of the chip a scene needs: computed from the scene, so that what it does not need is neither
//! stored, nor read, nor computed.

use super::scene::{Material, Scene};
use glam::Vec3;

/// What of the chip a scene needs; nothing, unless something is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Features {
    /// Some triangle's material has an image texture.
    pub textures: bool,
    /// Some triangle's material has a bump map.
    pub bump_maps: bool,
    /// Textures and bump maps have coarser levels.
    pub mip_maps: bool,
    /// The number of lights: shadow rays a hit.
    pub lights: u32,
    /// The scene has normals at the corners of its triangles, so that shading interpolates them.
    pub smooth_normals: bool,
    /// Some triangle's material has a highlight, and there is a light to cause it.
    pub highlights: bool,
    /// Some triangle's material reflects.
    pub reflection: bool,
    /// Some triangle's material refracts.
    pub refraction: bool,
}

/// Computes what of the chip the scene needs, from its lights, its normals, and the materials that its
/// triangles use.
pub fn features(scene: &Scene) -> Features {
    let mut used = vec![false; scene.materials.len()];
    for triangle in &scene.triangles {
        used[triangle.material as usize] = true;
    }
    let any = |wants: fn(&Material) -> bool| {
        scene.materials.iter().zip(&used).any(|(material, used)| *used && wants(material))
    };
    let mapped = !scene.tex_coords.is_empty();
    let textures = mapped && any(|m| m.texture.is_some());
    let bump_maps = mapped && any(|m| m.bump.is_some() && m.bump_height != 0.0);
    Features {
        textures,
        bump_maps,
        mip_maps: scene.mip_maps && (textures || bump_maps),
        lights: scene.lights.len() as u32,
        smooth_normals: !scene.normals.is_empty(),
        highlights: !scene.lights.is_empty() && any(|m| m.specular != Vec3::ZERO),
        reflection: any(|m| m.reflection > 0.0),
        refraction: any(|m| m.refraction > 0.0),
    }
}

impl Features {
    /// Triangles have texture coordinates.
    pub fn mapped(self) -> bool {
        self.textures || self.bump_maps
    }
}
