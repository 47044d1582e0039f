//! Theorems of what of the chip a scene needs (HI-1).

use crate::draw::{self, WORDS};
use crate::source::Source;
use crate::{check_eq, cover, theorems};
use saarcor_model::host::{Features, Light, Material, Scene, Triangle, features};

/// A material with any of the features, or none.
fn material(s: &mut impl Source) -> Material {
    let axis = s.value("component of the highlight (none, x, y, z)", 0..=3, &WORDS[..4]) as usize;
    let mut specular = [0.0; 3];
    if axis > 0 {
        specular[axis - 1] = 0.5;
    }
    // Textures that there are, even the first.
    let texture = draw::flag(s, "texture").then_some(0);
    let bump = draw::flag(s, "bump map").then_some(0);
    let part = |flag: bool| if flag { 1.0e-6 } else { 0.0 };
    Material {
        specular: specular.into(),
        reflection: part(draw::flag(s, "reflects")),
        refraction: part(draw::flag(s, "refracts")),
        texture,
        bump,
        bump_height: if draw::flag(s, "is flat") { 0.0 } else { -0.5 },
        ..Material::default()
    }
}

theorems! {
    /// A scene needs exactly what the materials of its triangles have: a material that no triangle uses
    /// needs nothing, maps need texture coordinates, a bump map needs a height, a highlight needs a light,
    /// and mip maps need an image.
    #[
        "HI-1", not_for_kani "it allocates",
        covers ["everything", "nothing", "the unused material has more", "a map without coordinates", "highlight without light"]
    ]
    fn scene_needs_what_its_triangles_have(s) {
        let used = material(s);
        let unused = Material { texture: Some(0), bump: Some(0), bump_height: 1.0, reflection: 1.0, refraction: 1.0, specular: [1.0; 3].into(), ..used };
        let first = draw::flag(s, "the first material is used");
        let materials = if first { vec![used, unused] } else { vec![unused, used] };
        let triangle = Triangle { corners: [[0.0; 3].into(); 3], material: u32::from(!first) };
        let lights = s.value("lights", 0..=300, &WORDS[..3]);
        let (mapped, smooth) = (draw::flag(s, "texture coordinates"), draw::flag(s, "normals"));
        let scene = Scene {
            triangles: vec![triangle; 2],
            tex_coords: if mapped { vec![[[0.0; 2].into(); 3]; 2] } else { Vec::new() },
            normals: if smooth { vec![[[0.0; 3].into(); 3]; 2] } else { Vec::new() },
            materials,
            lights: vec![Light { position: [0.0; 3].into(), intensity: 1.0 }; lights as usize],
            mip_maps: draw::flag(s, "mip maps"),
            ..Scene::default()
        };
        let textures = mapped && used.texture.is_some();
        let bump_maps = mapped && used.bump.is_some() && used.bump_height != 0.0;
        let shines = used.specular.to_array() != [0.0; 3];
        let expected = Features {
            textures,
            bump_maps,
            mip_maps: scene.mip_maps && (textures || bump_maps),
            lights,
            smooth_normals: smooth,
            highlights: shines && lights > 0,
            reflection: used.reflection > 0.0,
            refraction: used.refraction > 0.0,
        };
        let everything = textures && bump_maps && expected.mip_maps && smooth && expected.highlights;
        cover!(s, "everything", everything && expected.reflection && expected.refraction);
        cover!(s, "nothing", !textures && !bump_maps && !smooth && lights == 0 && !expected.reflection && !expected.refraction);
        cover!(s, "the unused material has more", !expected.reflection);
        cover!(s, "a map without coordinates", !mapped && used.texture.is_some());
        cover!(s, "highlight without light", shines && lights == 0);
        check_eq!(features(&scene), expected, "{used:?} in a scene of {lights} lights");
        check_eq!(expected.mapped(), textures || bump_maps, "texture coordinates of {expected:?}");
        let nothing = Scene { triangles: Vec::new(), lights: Vec::new(), normals: Vec::new(), ..scene };
        let none = features(&nothing);
        check_eq!(none.material_bytes() + none.shading_record_bytes(), 12 + 16, "without triangles");
    }
}
