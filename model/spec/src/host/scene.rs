//! The scene as the application holds it, before the driver lays it out in host memory.
//!
//! §2 names what a surface can have: extended Phong shading, an image texture and a bump map, and
//! shadows, reflections and refractions by new rays (Stated). The parameters of each are Assumed
//! after the MTL format.

use glam::{Vec2, Vec3};

/// One triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners in world space, counter-clockwise seen from the front.
    pub corners: [Vec3; 3],
    /// Index into [`Scene::materials`].
    pub material: u32,
}

impl Triangle {
    /// True when the corners span no area, so that no ray can hit the triangle.
    ///
    /// Decided in f64, where the differences and products of f32 coordinates of similar
    /// magnitude are exact.
    pub fn is_degenerate(&self) -> bool {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        (b - a).cross(c - a) == glam::DVec3::ZERO
    }
}

/// The format of a [`Texture`]'s texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// Four bytes a texel: red, green, blue, alpha; display values, 255 is 1.0.
    Rgba8,
    /// One byte a texel: a height, 255 is 1.0.
    Height8,
}

impl TexelFormat {
    /// Bytes a texel.
    pub const fn texel_bytes(self) -> u32 {
        match self {
            Self::Rgba8 => 4,
            Self::Height8 => 1,
        }
    }
}

/// An image texture or a bump map. It tiles in both directions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Texels a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// What a texel is.
    pub format: TexelFormat,
    /// `width * height` texels, row by row from the top.
    pub texels: Vec<u8>,
}

/// How a surface looks: extended Phong (§2, Stated; the terms are Assumed, after MTL).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Diffuse reflectance, red, green and blue (MTL `Kd`).
    pub diffuse: Vec3,
    /// Specular reflectance, red, green and blue (MTL `Ks`).
    pub specular: Vec3,
    /// Phong exponent (MTL `Ns`).
    pub shininess: f32,
    /// Part of the light that arrives by the mirrored ray, 0 to 1.
    pub reflection: f32,
    /// Part of the light that arrives by the refracted ray, 0 to 1.
    pub refraction: f32,
    /// Index of refraction behind the surface (MTL `Ni`).
    pub index_of_refraction: f32,
    /// Image texture that multiplies `diffuse`: index into [`Scene::textures`], [`TexelFormat::Rgba8`].
    pub texture: Option<u32>,
    /// Bump map: index into [`Scene::textures`], [`TexelFormat::Height8`].
    pub bump: Option<u32>,
    /// Height, in texels, that the bump map's 1.0 stands for.
    pub bump_height: f32,
}

impl Default for Material {
    /// A matt surface of reflectance 0.8.
    fn default() -> Self {
        Self {
            diffuse: Vec3::splat(0.8),
            specular: Vec3::ZERO,
            shininess: 1.0,
            reflection: 0.0,
            refraction: 0.0,
            index_of_refraction: 1.0,
            texture: None,
            bump: None,
            bump_height: 0.0,
        }
    }
}

/// A point light without fall-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Position in world space.
    pub position: Vec3,
    /// A plain factor.
    pub intensity: f32,
}

/// A pinhole camera. The picture's right is `dir × up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Centre of projection.
    pub eye: Vec3,
    /// Unit vector into the picture.
    pub dir: Vec3,
    /// Unit vector at a right angle to `dir`.
    pub up: Vec3,
    /// The whole angle from the bottom to the top of the picture, in degrees.
    pub fov_y_deg: f32,
}

/// A scene and a walk through it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The triangles; none is allowed.
    pub triangles: Vec<Triangle>,
    /// Texture coordinates of each triangle's corners, v upwards; empty where the scene has none.
    pub tex_coords: Vec<[Vec2; 3]>,
    /// Normals at each triangle's corners; empty where the scene has none.
    pub normals: Vec<[Vec3; 3]>,
    /// The materials; every triangle's index lies inside.
    pub materials: Vec<Material>,
    /// Image textures and bump maps.
    pub textures: Vec<Texture>,
    /// The lights; none means that surfaces show their own colour (suffix `nl` of Table 1).
    pub lights: Vec<Light>,
    /// The camera path, a camera a frame.
    pub path: Vec<Camera>,
    /// Whether textures and bump maps are stored with the coarser levels of their mip maps.
    pub mip_maps: bool,
}
