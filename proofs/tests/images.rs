//! The image of any scene in host memory is what SPEC.md says: each item lies where its number says, reads back as it
//! was, and the driver stores nothing that the scene does not need (HI-1 to HI-6).

mod support;

use glam::{DVec3, Vec2, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use saarcor_model::host::{
    Aabb, Axis, HostImage, KdTree, Kernel, LayoutError, Light, ListEntry, Material, MaterialRecord, Node,
    NodeRecord, Scene, ShadingRecord, TexelFormat, Texture, TextureRecord, Triangle, TriangleRecord,
};
use saarcor_model::vm::{Bytes, HostAddr};
use support::engine;

fn number() -> impl Strategy<Value = f32> {
    (-8..=8i8).prop_map(|quarters| f32::from(quarters) / 4.0)
}

fn vector() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from)
}

fn texture(format: TexelFormat) -> impl Strategy<Value = Texture> {
    let side = || prop_oneof![Just(1_u32), 1..=9_u32];
    (side(), side(), any::<u8>()).prop_map(move |(width, height, seed)| Texture {
        width,
        height,
        format,
        texels: (0..width * height * format.texel_bytes()).map(|i| (i * 167) as u8 ^ seed).collect(),
    })
}

/// Textures 0 and 1 are images, 2 and 3 bump maps.
fn material() -> impl Strategy<Value = Material> {
    let part = || prop_oneof![2 => Just(0.0), 1 => Just(0.25)];
    let index = |range| prop::option::weighted(0.4, range);
    (
        vector(),
        prop_oneof![Just(Vec3::ZERO), vector()],
        part(),
        part(),
        index(0..2_u32),
        index(2..4_u32),
        part(),
    )
        .prop_map(|(diffuse, specular, reflection, refraction, texture, bump, bump_height)| Material {
            diffuse,
            specular,
            shininess: 7.0,
            reflection,
            refraction,
            index_of_refraction: 1.25,
            texture,
            bump,
            bump_height,
        })
}

fn scenes() -> impl Strategy<Value = Scene> {
    let triangle = ([vector(), vector(), vector()], 0..3_u32)
        .prop_map(|(corners, material)| Triangle { corners, material })
        .prop_filter("the tree builder leaves out triangles without area", |triangle| {
            !triangle.is_degenerate()
        });
    let images = [texture(TexelFormat::Rgba8), texture(TexelFormat::Rgba8)];
    let maps = [texture(TexelFormat::Height8), texture(TexelFormat::Height8)];
    let light = (vector(), prop_oneof![Just(0.125_f32), Just(0.75)])
        .prop_map(|(position, intensity)| Light { position, intensity });
    let flags = any::<[bool; 3]>();
    let coordinates = [
        [number(), number()].prop_map(Vec2::from),
        [number(), number()].prop_map(Vec2::from),
        [number(), number()].prop_map(Vec2::from),
    ];
    (
        vec((triangle, coordinates, [vector(), vector(), vector()]), 1..12),
        [material(), material(), material()],
        images,
        maps,
        vec(light, 0..4),
        flags,
    )
        .prop_map(|(triangles, materials, images, maps, lights, [mapped, smooth, mip_maps])| Scene {
            tex_coords: if mapped { triangles.iter().map(|it| it.1).collect() } else { Vec::new() },
            normals: if smooth { triangles.iter().map(|it| it.2).collect() } else { Vec::new() },
            triangles: triangles.into_iter().map(|it| it.0).collect(),
            materials: materials.to_vec(),
            textures: images.into_iter().chain(maps).collect(),
            lights,
            path: Vec::new(),
            mip_maps,
        })
}

/// A chain of inner nodes, whose leaves have the entries between those numbers.
fn tree(entries: &[usize], cuts: &[usize], triangles: usize) -> KdTree {
    let refs: Vec<u32> = entries.iter().map(|entry| (entry % triangles) as u32).collect();
    let mut ends: Vec<usize> = cuts.iter().map(|cut| cut % (refs.len() + 1)).collect();
    ends.sort_unstable();
    ends.push(refs.len());
    let mut nodes = Vec::new();
    let mut first = 0;
    for (place, &end) in ends.iter().enumerate() {
        let leaf = Node::Leaf { first: first as u32, count: (end - first) as u32 };
        if place + 1 < ends.len() {
            let children = nodes.len() as u32 + 1;
            nodes.push(Node::Inner { axis: Axis::ALL[place % 3], split: place as f32, children });
        }
        nodes.push(leaf);
        first = end;
    }
    // Above each inner node's leaf lies the next inner node: pairs are (leaf, next).
    KdTree { bounds: Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE }, nodes, refs }
}

fn page(bytes: usize) -> usize {
    bytes.div_ceil(4096) * 4096
}

fn is_near(found: Vec3, expected: DVec3) -> bool {
    (found.as_dvec3() - expected).abs().max_element() < 1e-6
}

/// All that `image` holds, item by item.
fn image_is_the_scene(scene: &Scene, tree: &KdTree, kernel: Kernel) -> Result<(), TestCaseError> {
    let image =
        HostImage::build(scene, tree, kernel).map_err(|error| TestCaseError::fail(error.to_string()))?;
    let registers = &image.registers;
    let features = registers.features;
    let bytes = |start: usize, len: usize| &image.bytes[start..start + len];
    // Regions.
    let lists = page(8 * tree.nodes.len());
    let triangles = lists + page(4 * tree.refs.len());
    let mut order: Vec<u32> = Vec::new();
    for &entry in &tree.refs {
        if !order.contains(&entry) {
            order.push(entry);
        }
    }
    let materials = triangles + page(36 * order.len());
    let (material_bytes, record_bytes) =
        (features.material_bytes() as usize, features.shading_record_bytes() as usize);
    let records = materials + material_bytes * scene.materials.len();
    let textures = materials + page(material_bytes * scene.materials.len() + record_bytes * order.len());
    prop_assert_eq!(
        (registers.root.0 as usize, registers.triangles.0 as usize, registers.shading.0 as usize),
        (0, triangles, records)
    );
    prop_assert_eq!((&image.triangle_ids, registers.bounds, registers.kernel), (&order, tree.bounds, kernel));
    // Nodes and lists.
    for (number, node) in tree.nodes.iter().enumerate() {
        let expected = match *node {
            Node::Inner { axis, split, children } => {
                NodeRecord::Inner { axis, split, below: HostAddr(8 * children) }
            }
            Node::Leaf { first, count } => {
                NodeRecord::Leaf { list: HostAddr(lists as u32 + 4 * first), count }
            }
        };
        let found = NodeRecord::decode(bytes(8 * number, 8).try_into().expect("eight bytes"));
        prop_assert_eq!(found, expected, "node {}", number);
    }
    for (number, &triangle) in tree.refs.iter().enumerate() {
        let place = order.iter().position(|&id| id == triangle).expect("named") as u32;
        let tag = kernel.record(&scene.triangles[triangle as usize].corners).tag;
        let found = ListEntry::decode(bytes(lists + 4 * number, 4).try_into().expect("four bytes"));
        let addr = HostAddr(triangles as u32 + 36 * place);
        prop_assert_eq!(found, ListEntry { triangle: addr, tag }, "entry {}", number);
        prop_assert_eq!((image.triangle_id(addr), registers.triangle_index(addr)), (triangle, place));
    }
    // Where the textures lie, of which some triangle of the scene has need.
    let needs = |wanted: u32| {
        scene.triangles.iter().any(|triangle| {
            let material = scene.materials[triangle.material as usize];
            (features.textures && material.texture == Some(wanted))
                || (features.bump_maps && material.bump == Some(wanted))
        })
    };
    let mut stored = vec![None; scene.textures.len()];
    let (mut at, mut coarser) = (textures, 0);
    for (number, texture) in scene.textures.iter().enumerate().filter(|(number, _)| needs(*number as u32)) {
        prop_assert_eq!(at % 64, 0);
        let Texture { width, height, .. } = *texture;
        stored[number] = Some(TextureRecord { texels: HostAddr(at as u32), width, height });
        let mut level = Some(texture.clone());
        let (mut place, mut first) = (at, 0);
        while let Some(texels) = level {
            let len = texels.texels.len();
            let expected: Vec<u8> = texels.in_bands().flatten().copied().collect();
            prop_assert_eq!(bytes(place, len), &expected[..], "texture {}", number);
            place += len;
            first = if first == 0 { len } else { first };
            level = if features.mip_maps { texels.halved() } else { None };
        }
        coarser += (place - at).div_ceil(64) * 64 - first.div_ceil(64) * 64;
        at += (place - at).div_ceil(64) * 64;
    }
    let sizes = [
        8 * tree.nodes.len(),
        4 * tree.refs.len(),
        36 * order.len(),
        records - materials + record_bytes * order.len(),
        at - textures,
    ];
    prop_assert_eq!(image.region_bytes, sizes.map(|size| Bytes(size as u64)));
    prop_assert_eq!(image.mip_map_bytes, Bytes(coarser as u64));
    prop_assert_eq!(image.bytes.len(), textures + page(at - textures));
    // Materials.
    for (number, material) in scene.materials.iter().enumerate() {
        let found =
            MaterialRecord::decode(bytes(materials + material_bytes * number, material_bytes), features);
        let texture = |index: Option<u32>| index.and_then(|index| stored[index as usize]);
        prop_assert_eq!(found.diffuse, material.diffuse);
        prop_assert_eq!(found.specular, if features.highlights { material.specular } else { Vec3::ZERO });
        prop_assert_eq!(found.reflection, if features.reflection { material.reflection } else { 0.0 });
        prop_assert_eq!(found.refraction, if features.refraction { material.refraction } else { 0.0 });
        prop_assert_eq!(found.texture, if features.textures { texture(material.texture) } else { None });
        let bump = texture(material.bump).filter(|_| features.bump_maps);
        prop_assert_eq!(found.bump, bump.map(|map| (map, material.bump_height)));
    }
    // Triangles and their records.
    for (place, &id) in order.iter().enumerate() {
        let Triangle { corners, material } = scene.triangles[id as usize];
        let stored = kernel.record(&corners);
        let found = TriangleRecord::decode(
            bytes(triangles + 36 * place, 36).try_into().expect("36 bytes"),
            stored.tag,
        );
        prop_assert_eq!(found.words.map(f32::to_bits), stored.words.map(f32::to_bits));
        let record = ShadingRecord::decode(bytes(records + record_bytes * place, record_bytes), features);
        prop_assert_eq!(record.material.0 as usize, materials + material_bytes * material as usize);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        prop_assert!(is_near(record.normal, normal.normalize()), "normal {} of {:?}", record.normal, corners);
        let normals = if features.smooth_normals { scene.normals[id as usize] } else { [record.normal; 3] };
        prop_assert_eq!(record.normals, normals);
        let mapped = features.textures || features.bump_maps;
        let uv = if mapped { scene.tex_coords[id as usize] } else { [Vec2::ZERO; 3] };
        prop_assert_eq!(record.tex_coords, uv);
        let [ta, tb, tc] = uv.map(Vec2::as_dvec2);
        let area = (tb - ta).perp_dot(tc - ta);
        let density = if features.mip_maps { area.abs() / normal.length() } else { 0.0 };
        prop_assert!((f64::from(record.texture_density) - density).abs() <= 1e-6 * density);
        // The tangent is where the first coordinate grows: it has no part along the normal.
        let tangent = record.tangent.as_dvec3();
        if features.bump_maps && area != 0.0 {
            prop_assert!(
                (tangent.length() - 1.0).abs() < 1e-6 && tangent.dot(normal).abs() < 1e-5 * normal.length()
            );
            // Along it, v stays as it is and u grows: u and v are linear in the plane.
            let gradient = |weights: [f64; 2]| {
                ((c - a).cross(normal) * weights[0] - (b - a).cross(normal) * weights[1])
                    / normal.length_squared()
            };
            let grows = |second: f64, third: f64| gradient([second, third]).dot(tangent);
            prop_assert!(grows(tb.y - ta.y, tc.y - ta.y).abs() < 1e-5, "v along {}", tangent);
            prop_assert!(grows(tb.x - ta.x, tc.x - ta.x) > 0.0, "u along {}", tangent);
        } else if !features.bump_maps {
            prop_assert_eq!(record.tangent, Vec3::ZERO);
        }
    }
    // Lights, which together are at most 1.
    let sum: f32 = scene.lights.iter().map(|light| light.intensity).sum();
    for (found, light) in registers.lights.iter().zip(&scene.lights) {
        let intensity = if sum > 1.0 { light.intensity / sum } else { light.intensity };
        prop_assert_eq!((found.position, found.intensity), (light.position, intensity));
    }
    prop_assert_eq!(registers.lights.len(), scene.lights.len());
    Ok(())
}

proptest! {
    #![proptest_config(engine())]

    #[test]
    fn image_of_any_scene_is_the_scene(
        scene in scenes(),
        entries in vec(any::<usize>(), 1..30),
        cuts in vec(any::<usize>(), 0..6),
        kernel in 0..5_usize,
    ) {
        let tree = tree(&entries, &cuts, scene.triangles.len());
        image_is_the_scene(&scene, &tree, Kernel::ALL[kernel])?;
    }
}

/// A scene of one triangle with an image of that size.
fn with_image(width: u32, height: u32) -> Scene {
    let texels = vec![7; (u64::from(width) * u64::from(height) * 4) as usize];
    let material = Material { texture: Some(0), ..Material::default() };
    Scene {
        triangles: vec![Triangle { corners: [Vec3::ZERO, Vec3::X, Vec3::Y], material: 0 }],
        tex_coords: vec![[Vec2::ZERO, Vec2::X, Vec2::Y]],
        materials: vec![material],
        textures: vec![Texture { width, height, format: TexelFormat::Rgba8, texels }],
        ..Scene::default()
    }
}

/// Images have 1 to 65536 texels a side; one of 65536 x 1 is read as it was written.
#[test]
fn images_have_up_to_65536_texels_a_side() {
    let tree = tree(&[0], &[], 1);
    for (width, height) in
        [(1, 1), (0x1_0000, 1), (1, 0x1_0000), (0, 1), (1, 0), (0x1_0001, 1), (1, 0x1_0001)]
    {
        let legal = width > 0 && height > 0 && width <= 0x1_0000 && height <= 0x1_0000;
        match HostImage::build(&with_image(width, height), &tree, Kernel::Wald) {
            Ok(image) => {
                assert!(legal, "{width} x {height} texels");
                let features = image.registers.features;
                let material = MaterialRecord::decode(&image.bytes[3 * 4096..], features);
                let texels = HostAddr(4 * 4096);
                assert_eq!(material.texture, Some(TextureRecord { texels, width, height }));
            }
            Err(error) => {
                assert!(!legal, "{width} x {height} texels: {error}");
                assert_eq!(error, LayoutError::Texture { texture: 0, width, height });
            }
        }
    }
}

/// Lists of 65536 entries and more are stored whole.
#[test]
fn long_lists_are_stored_whole() {
    for entries in [0xffff, 0x1_0000, 0x1_0001] {
        let named: Vec<usize> = (0..entries).map(|entry| usize::from(entry + 1 == entries)).collect();
        let mut scene = with_image(1, 1);
        scene.triangles.push(Triangle { corners: [Vec3::ZERO, Vec3::Y, Vec3::Z], material: 0 });
        scene.tex_coords.push([Vec2::ZERO; 3]);
        let tree = tree(&named, &[], 2);
        image_is_the_scene(&scene, &tree, Kernel::MollerTrumbore).expect("the scene");
    }
}
