//! Theorems of materials and shading records as bytes (HI-5).
//!
//! All fields are moved as bits. In the small scope each field has bits of its own, so that two fields
//! that change places show.

use crate::draw::{self, WORDS};
use crate::source::Source;
use crate::{check, check_eq, cover, theorems};
use saarcor_model::host::{Features, MaterialRecord, ShadingRecord, TextureRecord};
use saarcor_model::vm::HostAddr;

/// Seeds of fields: few bits, all bits, and NaN.
static SEEDS: [u32; 4] = [1, 0x7fc0_0001, 0x9e37_79b9, u32::MAX];

/// Texels a side: the least, the greatest, and neighbours.
static SIDES: [u32; 4] = [1, 2, 0xffff, 0x1_0000];

/// Any features that have to do with records.
fn features(s: &mut impl Source) -> Features {
    Features {
        textures: draw::flag(s, "textures"),
        bump_maps: draw::flag(s, "bump maps"),
        mip_maps: draw::flag(s, "mip maps"),
        lights: s.value("lights", 0..=u32::MAX, &WORDS[..1]),
        smooth_normals: draw::flag(s, "smooth normals"),
        highlights: draw::flag(s, "highlights"),
        reflection: draw::flag(s, "reflection"),
        refraction: draw::flag(s, "refraction"),
    }
}

/// Words of fields, one after another, all different for most seeds.
struct Words(u32);

impl Words {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(0x0019_660d).wrapping_add(0x3c6e_f35f);
        self.0
    }

    fn float(&mut self) -> f32 {
        f32::from_bits(self.next())
    }

    fn three(&mut self) -> [f32; 3] {
        [self.float(), self.float(), self.float()]
    }
}

/// A texture anywhere but at address 0, where the root is; or none.
fn texture(s: &mut impl Source, words: &mut Words) -> Option<TextureRecord> {
    let (width, height) = (s.value("width", 1..=0x1_0000, &SIDES), s.value("height", 1..=0x1_0000, &SIDES));
    draw::flag(s, "has a texture").then(|| TextureRecord {
        texels: HostAddr(words.next() | 64),
        width,
        height,
    })
}

/// Address and sides as two words.
fn words_of(texture: Option<TextureRecord>) -> [u32; 2] {
    texture.map_or([0, 0], |it| [it.texels.0, (it.height - 1) * 0x1_0000 + (it.width - 1)])
}

fn bits(numbers: impl IntoIterator<Item = f32>) -> impl Iterator<Item = u32> {
    numbers.into_iter().map(f32::to_bits)
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

theorems! {
    /// A material has the words of those fields that the scene's features need, in the order in which they
    /// are stated, and as many bytes as it is said to have; it is read as it was written, and a field that
    /// is not stored reads as the value without effect.
    #["HI-5", not_for_kani "it allocates", covers ["every field", "no field but one", "a bump map alone", "65536 texels a side"]]
    fn material_is_read_as_written(s) {
        let features = features(s);
        let mut words = Words(s.value("seed", 0..=u32::MAX, &SEEDS));
        let (diffuse, specular, shininess) = (words.three(), words.three(), words.float());
        let (reflection, refraction, index) = (words.float(), words.float(), words.float());
        let image = texture(s, &mut words);
        let map = image.map(|it| TextureRecord { texels: HostAddr(words.next() | 64), width: it.height, height: it.width });
        let height = if map.is_some() { words.float() } else { 0.0 };
        let material = MaterialRecord {
            diffuse: diffuse.into(),
            specular: specular.into(),
            shininess,
            reflection,
            refraction,
            index_of_refraction: index,
            texture: image,
            bump: map.map(|map| (map, height)),
        };
        let Features { textures, bump_maps, highlights, .. } = features;
        cover!(s, "every field", highlights && features.reflection && features.refraction && textures && bump_maps);
        cover!(s, "no field but one", !highlights && !features.reflection && !features.refraction && !textures && !bump_maps);
        cover!(s, "a bump map alone", bump_maps && !textures && image.is_some());
        cover!(s, "65536 texels a side", image.is_some_and(|it| it.width == 0x1_0000 && it.height == 0x1_0000));
        let mut expected: Vec<u32> = bits(diffuse).collect();
        if highlights {
            expected.extend(bits(specular).chain(bits([shininess])));
        }
        if features.reflection {
            expected.push(reflection.to_bits());
        }
        if features.refraction {
            expected.extend(bits([refraction, index]));
        }
        if textures {
            expected.extend(words_of(image));
        }
        if bump_maps {
            expected.extend(words_of(map).into_iter().chain([height.to_bits()]));
        }
        let encoded = material.encode(features);
        check_eq!(encoded, bytes(&expected), "{material:?}, {features:?}");
        check_eq!(features.material_bytes() as usize, 4 * expected.len(), "{features:?}");
        check!(encoded.len() <= Features::MAX_RECORD_BYTES, "{features:?}");
        let read = MaterialRecord::decode(&encoded, features);
        let numbers = |it: &MaterialRecord| {
            let kept = [it.shininess, it.reflection, it.refraction, it.index_of_refraction];
            bits(it.diffuse.to_array()).chain(bits(it.specular.to_array())).chain(bits(kept)).collect::<Vec<_>>()
        };
        let bump = |it: &MaterialRecord| it.bump.map(|(map, height)| (map, height.to_bits()));
        let without = MaterialRecord {
            specular: if highlights { material.specular } else { [0.0; 3].into() },
            shininess: if highlights { shininess } else { 1.0 },
            reflection: if features.reflection { reflection } else { 0.0 },
            refraction: if features.refraction { refraction } else { 0.0 },
            index_of_refraction: if features.refraction { index } else { 1.0 },
            texture: image.filter(|_| textures),
            bump: material.bump.filter(|_| bump_maps),
            ..material
        };
        check_eq!(numbers(&read), numbers(&without), "{features:?}");
        check_eq!((read.texture, bump(&read)), (without.texture, bump(&without)), "{features:?}");
    }

    /// A shading record has the words of those fields that the scene's features need, in the order in which
    /// they are stated, and as many bytes as it is said to have; it is read as it was written, and a field
    /// that is not stored reads as zero, or as the plane's normal.
    #["HI-5", not_for_kani "it allocates", covers ["every field", "no field but two", "texture coordinates without a bump map"]]
    fn shading_record_is_read_as_written(s) {
        let features = features(s);
        let mut words = Words(s.value("seed", 0..=u32::MAX, &SEEDS));
        let (material, normal) = (words.next(), words.three());
        let normals = [words.three(), words.three(), words.three()];
        let tex_coords = [(); 3].map(|()| [words.float(), words.float()]);
        let (density, tangent) = (words.float(), words.three());
        let record = ShadingRecord {
            material: HostAddr(material),
            normal: normal.into(),
            normals: normals.map(Into::into),
            tex_coords: tex_coords.map(Into::into),
            texture_density: density,
            tangent: tangent.into(),
        };
        let Features { textures, bump_maps, mip_maps, smooth_normals, .. } = features;
        let mapped = textures || bump_maps;
        cover!(s, "every field", smooth_normals && mapped && mip_maps && bump_maps);
        cover!(s, "no field but two", !smooth_normals && !mapped && !mip_maps);
        cover!(s, "texture coordinates without a bump map", mapped && !bump_maps);
        let mut expected = vec![material];
        expected.extend(bits(normal));
        if smooth_normals {
            expected.extend(bits(normals.into_iter().flatten()));
        }
        if mapped {
            expected.extend(bits(tex_coords.into_iter().flatten()));
        }
        if mip_maps {
            expected.push(density.to_bits());
        }
        if bump_maps {
            expected.extend(bits(tangent));
        }
        let encoded = record.encode(features);
        check_eq!(encoded, bytes(&expected), "{record:?}, {features:?}");
        check_eq!(features.shading_record_bytes() as usize, 4 * expected.len(), "{features:?}");
        check!(encoded.len() <= Features::MAX_RECORD_BYTES, "{features:?}");
        let read = ShadingRecord::decode(&encoded, features);
        let fields = |it: &ShadingRecord| {
            let normals = it.normals.into_iter().flat_map(|normal| normal.to_array());
            let coordinates = it.tex_coords.into_iter().flat_map(|uv| uv.to_array());
            let numbers = bits(it.normal.to_array()).chain(bits(normals)).chain(bits(coordinates));
            numbers.chain(bits([it.texture_density])).chain(bits(it.tangent.to_array())).collect::<Vec<_>>()
        };
        let without = ShadingRecord {
            normals: if smooth_normals { record.normals } else { [record.normal; 3] },
            tex_coords: if mapped { record.tex_coords } else { [[0.0; 2].into(); 3] },
            texture_density: if mip_maps { density } else { 0.0 },
            tangent: if bump_maps { record.tangent } else { [0.0; 3].into() },
            ..record
        };
        check_eq!(read.material.0, material, "address of the material");
        check_eq!(fields(&read), fields(&without), "{features:?}");
    }
}
