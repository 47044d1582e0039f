//! Materials and shading records in host memory (Assumed): what shading knows of a triangle.
//!
//! What a scene does not need ([`Features`]) is not stored, and reads as the value that has no effect.

use super::features::Features;
use super::texture::TextureRecord;
use crate::vm::HostAddr;
use glam::{Vec2, Vec3};

/// A material as the chip reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialRecord {
    /// Diffuse reflectance.
    pub diffuse: Vec3,
    /// Specular reflectance.
    pub specular: Vec3,
    /// Phong exponent.
    pub shininess: f32,
    /// Part of the light that arrives by the mirrored ray.
    pub reflection: f32,
    /// Part of the light that arrives by the refracted ray.
    pub refraction: f32,
    /// Index of refraction behind the surface.
    pub index_of_refraction: f32,
    /// Image texture.
    pub texture: Option<TextureRecord>,
    /// Bump map and the height, in texels, of its 1.0.
    pub bump: Option<(TextureRecord, f32)>,
}

/// What shading needs to know of a triangle, beside the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingRecord {
    /// Address of the material.
    pub material: HostAddr,
    /// Unit normal of the triangle's plane.
    pub normal: Vec3,
    /// Normals at the corners; all the plane's where the scene has no others.
    pub normals: [Vec3; 3],
    /// Texture coordinates at the corners.
    pub tex_coords: [Vec2; 3],
    /// Area of the triangle in texture coordinates for each unit of its area in space; 0 where the
    /// scene has no mip maps.
    pub texture_density: f32,
    /// Unit vector in the triangle's plane along which the first texture coordinate grows.
    pub tangent: Vec3,
}

impl Features {
    /// Most bytes that a material or a shading record has.
    pub const MAX_RECORD_BYTES: usize = 92;

    /// Bytes of a material in this scene.
    pub fn material_bytes(self) -> u32 {
        12 + 16 * u32::from(self.highlights)
            + 4 * u32::from(self.reflection)
            + 8 * u32::from(self.refraction)
            + 8 * u32::from(self.textures)
            + 12 * u32::from(self.bump_maps)
    }

    /// Bytes of a shading record in this scene.
    pub fn shading_record_bytes(self) -> u32 {
        16 + 36 * u32::from(self.smooth_normals)
            + 24 * u32::from(self.mapped())
            + 4 * u32::from(self.mip_maps)
            + 12 * u32::from(self.bump_maps)
    }
}

impl MaterialRecord {
    /// Reads a material of a scene that needs `features`.
    ///
    /// # Panics
    /// If there are fewer than [`Features::material_bytes`].
    pub fn decode(bytes: &[u8], features: Features) -> Self {
        let mut fields = Fields { rest: bytes };
        let diffuse = fields.vec3();
        let (specular, shininess) =
            if features.highlights { (fields.vec3(), fields.f32()) } else { (Vec3::ZERO, 1.0) };
        let reflection = if features.reflection { fields.f32() } else { 0.0 };
        let (refraction, index_of_refraction) =
            if features.refraction { (fields.f32(), fields.f32()) } else { (0.0, 1.0) };
        let texture = if features.textures { fields.texture() } else { None };
        let bump = if features.bump_maps { fields.texture().zip(Some(fields.f32())) } else { None };
        Self { diffuse, specular, shininess, reflection, refraction, index_of_refraction, texture, bump }
    }

    /// The bytes that [`MaterialRecord::decode`] reads.
    pub fn encode(&self, features: Features) -> Vec<u8> {
        let mut record = Record::default();
        record.vec3(self.diffuse);
        if features.highlights {
            record.vec3(self.specular);
            record.f32(self.shininess);
        }
        if features.reflection {
            record.f32(self.reflection);
        }
        if features.refraction {
            record.f32(self.refraction);
            record.f32(self.index_of_refraction);
        }
        if features.textures {
            record.texture(self.texture);
        }
        if features.bump_maps {
            record.texture(self.bump.map(|(map, _)| map));
            record.f32(self.bump.map_or(0.0, |(_, height)| height));
        }
        record.bytes
    }
}

impl ShadingRecord {
    /// Reads a shading record of a scene that needs `features`.
    ///
    /// # Panics
    /// If there are fewer than [`Features::shading_record_bytes`].
    pub fn decode(bytes: &[u8], features: Features) -> Self {
        let mut fields = Fields { rest: bytes };
        let material = HostAddr(fields.u32());
        let normal = fields.vec3();
        let normals =
            if features.smooth_normals { std::array::from_fn(|_| fields.vec3()) } else { [normal; 3] };
        let tex_coords = if features.mapped() {
            std::array::from_fn(|_| Vec2::new(fields.f32(), fields.f32()))
        } else {
            [Vec2::ZERO; 3]
        };
        let texture_density = if features.mip_maps { fields.f32() } else { 0.0 };
        let tangent = if features.bump_maps { fields.vec3() } else { Vec3::ZERO };
        Self { material, normal, normals, tex_coords, texture_density, tangent }
    }

    /// The bytes that [`ShadingRecord::decode`] reads.
    pub fn encode(&self, features: Features) -> Vec<u8> {
        let mut record = Record::default();
        record.u32(self.material.0);
        record.vec3(self.normal);
        if features.smooth_normals {
            self.normals.into_iter().for_each(|normal| record.vec3(normal));
        }
        if features.mapped() {
            self.tex_coords.into_iter().flat_map(|uv| [uv.x, uv.y]).for_each(|v| record.f32(v));
        }
        if features.mip_maps {
            record.f32(self.texture_density);
        }
        if features.bump_maps {
            record.vec3(self.tangent);
        }
        record.bytes
    }
}

/// Reads the fields of a record one after the other.
struct Fields<'a> {
    rest: &'a [u8],
}

impl Fields<'_> {
    fn u32(&mut self) -> u32 {
        let (word, rest) =
            self.rest.split_first_chunk().expect("a record has all the fields of its features");
        self.rest = rest;
        u32::from_le_bytes(*word)
    }

    fn f32(&mut self) -> f32 {
        f32::from_bits(self.u32())
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.f32(), self.f32(), self.f32())
    }

    fn texture(&mut self) -> Option<TextureRecord> {
        let (texels, size) = (HostAddr(self.u32()), self.u32());
        // No texel lies at address 0: the root of the kd-tree does.
        let record = TextureRecord { texels, width: (size & 0xFFFF) + 1, height: (size >> 16) + 1 };
        (texels != HostAddr(0)).then_some(record)
    }
}

/// Writes the fields of a record one after the other.
#[derive(Default)]
struct Record {
    bytes: Vec<u8>,
}

impl Record {
    fn u32(&mut self, word: u32) {
        self.bytes.extend_from_slice(&word.to_le_bytes());
    }

    fn f32(&mut self, value: f32) {
        self.u32(value.to_bits());
    }

    fn vec3(&mut self, value: Vec3) {
        value.to_array().into_iter().for_each(|v| self.f32(v));
    }

    fn texture(&mut self, texture: Option<TextureRecord>) {
        let words = texture.map_or([0, 0], |TextureRecord { texels, width, height }| {
            [texels.0, (height - 1) << 16 | (width - 1)]
        });
        words.into_iter().for_each(|word| self.u32(word));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Features = Features {
        textures: true,
        bump_maps: true,
        mip_maps: true,
        lights: 1,
        smooth_normals: true,
        highlights: true,
        reflection: true,
        refraction: true,
    };

    #[test]
    fn records_fit_their_buffer() {
        let most = ALL.material_bytes().max(ALL.shading_record_bytes());
        assert_eq!(most as usize, Features::MAX_RECORD_BYTES);
    }

    #[test]
    fn records_read_as_written() {
        let texture = TextureRecord { texels: HostAddr(64), width: 1 << 16, height: 3 };
        let material = MaterialRecord {
            diffuse: Vec3::X,
            specular: Vec3::Y,
            shininess: 20.0,
            reflection: 0.25,
            refraction: 0.125,
            index_of_refraction: 1.5,
            texture: Some(texture),
            bump: Some((TextureRecord { width: 1, ..texture }, 3.0)),
        };
        let bytes = material.encode(ALL);
        assert_eq!(bytes.len(), ALL.material_bytes() as usize);
        assert_eq!(MaterialRecord::decode(&bytes, ALL), material);
        let record = ShadingRecord {
            material: HostAddr(4096),
            normal: Vec3::Z,
            normals: [Vec3::X, Vec3::Y, Vec3::Z],
            tex_coords: [Vec2::ZERO, Vec2::X, Vec2::Y],
            texture_density: 0.5,
            tangent: Vec3::X,
        };
        let bytes = record.encode(ALL);
        assert_eq!(bytes.len(), ALL.shading_record_bytes() as usize);
        assert_eq!(ShadingRecord::decode(&bytes, ALL), record);
    }
}
