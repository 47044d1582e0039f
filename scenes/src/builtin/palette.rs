//! The materials of a built-in scene and the images that they use.

use glam::{Vec2, Vec3};
use saarcor_model::host::{Material, Texture};

use super::mesh::Surface;
use super::texture::{Sample, color_and_height_images, color_image};

/// Diffuse reflectance of a surface whose colour its image gives.
const IMAGE_DIFFUSE: Vec3 = Vec3::splat(0.8);

/// Materials under construction. Without textures no pattern is evaluated.
#[derive(Clone, Debug)]
pub struct Palette {
    textured: bool,
    materials: Vec<Material>,
    textures: Vec<Texture>,
}

impl Palette {
    /// An empty palette, whose materials have images and bump maps only if `textured`.
    #[must_use]
    pub fn new(textured: bool) -> Self {
        Self { textured, materials: Vec::new(), textures: Vec::new() }
    }

    /// The materials and the textures.
    #[must_use]
    pub fn into_parts(self) -> (Vec<Material>, Vec<Texture>) {
        (self.materials, self.textures)
    }

    /// Adds a material without images; its tile is one unit.
    pub fn plain(&mut self, material: Material) -> Surface {
        self.materials.push(material);
        Surface { material: self.materials.len() as u32 - 1, tile: 1.0 }
    }

    /// Adds a material whose image of `size` texels a side shows `pattern` and covers `tile` world
    /// units. Untextured, the material's own diffuse colour remains.
    pub fn image(
        &mut self,
        mut material: Material,
        size: u32,
        tile: f32,
        pattern: impl Fn(Vec2) -> Sample + Sync,
    ) -> Surface {
        if self.textured {
            material.diffuse = IMAGE_DIFFUSE;
            material.texture = Some(self.textures.len() as u32);
            self.textures.push(color_image(size, pattern));
        }
        Surface { tile, ..self.plain(material) }
    }

    /// Adds a material like [`Palette::image`], with a bump map of the same pattern whose heights
    /// reach up to `bump_height` texels.
    pub fn relief(
        &mut self,
        mut material: Material,
        size: u32,
        tile: f32,
        bump_height: f32,
        pattern: impl Fn(Vec2) -> Sample + Sync,
    ) -> Surface {
        if self.textured {
            let next = self.textures.len() as u32;
            let (colors, heights) = color_and_height_images(size, pattern);
            material.diffuse = IMAGE_DIFFUSE;
            material.texture = Some(next);
            material.bump = Some(next + 1);
            material.bump_height = bump_height;
            self.textures.extend([colors, heights]);
        }
        Surface { tile, ..self.plain(material) }
    }
}

/// A matt material of a colour.
#[must_use]
pub fn matt(color: Vec3) -> Material {
    Material { diffuse: color, ..Material::default() }
}

/// A glossy material: `color` with a highlight.
#[must_use]
pub fn glossy(color: Vec3) -> Material {
    Material { diffuse: color, specular: Vec3::splat(0.3), shininess: 30.0, ..Material::default() }
}

/// A polished material that mirrors the part `reflection` of the light.
#[must_use]
pub fn mirror(color: Vec3, reflection: f32) -> Material {
    Material {
        diffuse: color,
        specular: Vec3::splat(reflection),
        shininess: 80.0,
        reflection,
        ..Material::default()
    }
}

/// Clear glass or water that lets the part `refraction` of the light through.
#[must_use]
pub fn glass(color: Vec3, refraction: f32, index_of_refraction: f32) -> Material {
    Material {
        diffuse: color,
        specular: Vec3::splat(0.1),
        shininess: 80.0,
        reflection: 0.1,
        refraction,
        index_of_refraction,
        ..Material::default()
    }
}
