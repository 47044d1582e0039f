//! The layout of a scene in host memory, which the driver makes (§3: "the entire scene data is stored
//! in main memory").
//!
//! Every kd-node, list, triangle, shading record, material, texture and bump map has a host
//! address, and the chip's units read nothing else. What the driver writes into the chip itself,
//! before a frame, are the [`Registers`].
//!
//! | region | item | bytes | status |
//! |---|---|---:|---|
//! | nodes | [`NodeRecord`] | 8 | Assumed, after Wald et al. 2001 |
//! | lists | [`ListEntry`] | 4 | Assumed: a host address |
//! | triangles | [`TriangleRecord`](super::TriangleRecord) | 36 | Derived: 144 KB of cache are 4096 of them |
//! | shading | [`MaterialRecord`], [`ShadingRecord`] | by [`Features`] | Assumed |
//! | textures | texel | 4; 1 in bump maps | Assumed |
//!
//! All numbers are little-endian. Nodes lie in the order of [`KdTree::nodes`], triangles in the
//! order in which the lists first name them, texels as [`TextureRecord`] says (Assumed).

use super::features::{Features, features};
use super::list::{LIST_ENTRY_BYTES, ListEntry};
use super::node::{NODE_BYTES, NodeRecord};
use super::records::{MaterialRecord, ShadingRecord};
use super::scene::{Light, Material, Scene, Texture};
use super::texture::{TEXTURE_ALIGNMENT, TextureRecord};
use super::tree::{Aabb, KdTree, KdTreeError};
use super::triangle::{Edges, Kernel, TRIANGLE_BYTES};
use crate::vm::{Bytes, HostAddr};
use glam::{Vec2, Vec3};
use thiserror::Error;

/// Regions begin at multiples of this: a page of the host (Assumed).
pub const REGION_ALIGNMENT: u32 = 4096;

/// What the driver writes into the chip beside the bytes in host memory (Assumed: §2 does not say
/// how).
#[derive(Clone, Debug, PartialEq)]
pub struct Registers {
    /// Address of the root of the kd-tree.
    pub root: HostAddr,
    /// Box around the scene.
    pub bounds: Aabb,
    /// The triangle test, which decides what a triangle's 36 bytes mean.
    pub kernel: Kernel,
    /// Whose edges and vertices are that several triangles have. The image does not depend on it.
    pub edges: Edges,
    /// Address of the first triangle.
    pub triangles: HostAddr,
    /// Address of the first triangle's shading record.
    pub shading: HostAddr,
    /// What the scene needs.
    pub features: Features,
    /// The lights. Their intensities add up to 1 at most.
    pub lights: Vec<Light>,
}

/// The image of a scene in host memory.
#[derive(Clone, Debug)]
pub struct HostImage {
    /// The bytes from host address 0 on.
    pub bytes: Vec<u8>,
    /// What the driver writes into the chip.
    pub registers: Registers,
    /// Bytes of each region, without the padding behind it, in the order of their addresses: nodes,
    /// lists, triangles, shading (materials, then a shading record a triangle), textures.
    pub region_bytes: [Bytes; 5],
    /// Of the textures, bytes of the coarser levels of mip maps.
    pub mip_map_bytes: Bytes,
    /// Which of the scene's triangles each triangle of the image is.
    pub triangle_ids: Vec<u32>,
}

/// Why a scene cannot be laid out.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LayoutError {
    /// The tree is not one that the chip may be given.
    #[error(transparent)]
    Tree(#[from] KdTreeError),
    /// The scene leaves the 32-bit host address space.
    #[error("scene of {} bytes: a host address has 32 bits, so at most {} bytes", .0.0, 1_u64 << 32)]
    TooLarge(Bytes),
    /// A texture has no texels, or more than 65536 a side.
    #[error("texture {texture} has {width} x {height} texels: 1 to 65536 a side are possible")]
    Texture {
        /// Index into [`Scene::textures`].
        texture: usize,
        /// Texels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
}

impl HostImage {
    /// Lays `scene` out for a chip with the triangle test `kernel`.
    ///
    /// # Errors
    /// If the tree is not valid for the scene, or the image does not fit a 32-bit address space.
    pub fn build(scene: &Scene, tree: &KdTree, kernel: Kernel) -> Result<Self, LayoutError> {
        tree.check(scene.triangles.len())?;
        let features = features(scene);
        let (triangle_ids, places) = order_of_first_use(tree, scene.triangles.len());
        let used_textures = used_textures(scene, features)?;
        let texture_bytes = |mip_maps: bool| -> u64 {
            used_textures.iter().map(|&texture| stored_bytes(&scene.textures[texture], mip_maps)).sum()
        };

        let region_bytes = [
            tree.nodes.len() as u64 * u64::from(NODE_BYTES),
            tree.refs.len() as u64 * u64::from(LIST_ENTRY_BYTES),
            triangle_ids.len() as u64 * u64::from(TRIANGLE_BYTES),
            scene.materials.len() as u64 * u64::from(features.material_bytes())
                + triangle_ids.len() as u64 * u64::from(features.shading_record_bytes()),
            texture_bytes(features.mip_maps),
        ]
        .map(Bytes);
        let starts = region_starts(region_bytes)?;
        let [nodes, lists, triangles, materials, texels, _] = starts.map(|start| start as u32);
        let shading = materials + scene.materials.len() as u32 * features.material_bytes();

        let mut bytes = Vec::with_capacity(starts[5] as usize);
        for node in &tree.nodes {
            bytes.extend(NodeRecord::new(node, HostAddr(nodes), HostAddr(lists)).encode());
        }
        bytes.resize(starts[1] as usize, 0);
        for &triangle in &tree.refs {
            let addr = HostAddr(triangles + places[triangle as usize] * TRIANGLE_BYTES);
            let tag = kernel.record(&scene.triangles[triangle as usize].corners).tag;
            bytes.extend(ListEntry { triangle: addr, tag }.encode());
        }
        bytes.resize(starts[2] as usize, 0);
        for &id in &triangle_ids {
            bytes.extend(kernel.record(&scene.triangles[id as usize].corners).encode());
        }
        bytes.resize(starts[3] as usize, 0);
        let records = texture_records(scene, features, &used_textures, HostAddr(texels));
        for material in &scene.materials {
            bytes.extend(material_record(material, &records).encode(features));
        }
        for &id in &triangle_ids {
            let material = materials + scene.triangles[id as usize].material * features.material_bytes();
            bytes.extend(shading_record(scene, id as usize, features, HostAddr(material)).encode(features));
        }
        bytes.resize(starts[4] as usize, 0);
        for &texture in &used_textures {
            bytes.resize(bytes.len().next_multiple_of(TEXTURE_ALIGNMENT as usize), 0);
            let texture = &scene.textures[texture];
            texture.in_bands().for_each(|texel| bytes.extend_from_slice(texel));
            if features.mip_maps {
                for level in std::iter::successors(texture.halved(), Texture::halved) {
                    level.in_bands().for_each(|texel| bytes.extend_from_slice(texel));
                }
            }
        }
        bytes.resize(starts[5] as usize, 0);

        let registers = Registers {
            root: HostAddr(nodes),
            bounds: tree.bounds,
            kernel,
            edges: Edges::default(),
            triangles: HostAddr(triangles),
            shading: HostAddr(shading),
            features,
            lights: exposed(&scene.lights),
        };
        Ok(Self {
            bytes,
            registers,
            region_bytes,
            mip_map_bytes: Bytes(texture_bytes(features.mip_maps) - texture_bytes(false)),
            triangle_ids,
        })
    }

    /// The scene's index of the triangle at `addr`.
    pub fn triangle_id(&self, addr: HostAddr) -> u32 {
        self.triangle_ids[self.registers.triangle_index(addr) as usize]
    }
}

impl Registers {
    /// Which triangle of the image lies at `addr`.
    pub fn triangle_index(&self, addr: HostAddr) -> u32 {
        (addr.0 - self.triangles.0) / TRIANGLE_BYTES
    }
}

/// Where regions of so many bytes begin, and where the last one ends with the padding behind it: each
/// at the first multiple of [`REGION_ALIGNMENT`] behind the one before (HI-2, Assumed).
///
/// # Errors
/// If they leave the 32-bit host address space.
pub fn region_starts(region_bytes: [Bytes; 5]) -> Result<[u64; 6], LayoutError> {
    let mut starts = [0; 6];
    for (region, bytes) in region_bytes.into_iter().enumerate() {
        starts[region + 1] = (starts[region] + bytes.0).next_multiple_of(REGION_ALIGNMENT.into());
    }
    if starts[5] > 1 << 32 {
        return Err(LayoutError::TooLarge(Bytes(starts[5])));
    }
    Ok(starts)
}

/// The lights with intensities that add up to 1 at most, so that no surface is brighter than its
/// colour by diffuse light (SH-5, Assumed: the exposure of the camera).
fn exposed(lights: &[Light]) -> Vec<Light> {
    let sum: f32 = lights.iter().map(|light| light.intensity).sum();
    let exposed = |light: &Light| Light { intensity: light.intensity / sum.max(1.0), ..*light };
    lights.iter().map(exposed).collect()
}

/// The triangles in the order in which the lists first name them, and the place of each in that
/// order. Neighbours in space then share lines (Assumed).
fn order_of_first_use(tree: &KdTree, triangles: usize) -> (Vec<u32>, Vec<u32>) {
    const UNUSED: u32 = u32::MAX;
    let mut places = vec![UNUSED; triangles];
    let mut order = Vec::new();
    for &triangle in &tree.refs {
        let place = &mut places[triangle as usize];
        if *place == UNUSED {
            *place = order.len() as u32;
            order.push(triangle);
        }
    }
    (order, places)
}

/// Indices of the textures that the scene's features need, ascending.
fn used_textures(scene: &Scene, features: Features) -> Result<Vec<usize>, LayoutError> {
    let mut used = vec![false; scene.textures.len()];
    for triangle in &scene.triangles {
        let Material { texture, bump, .. } = scene.materials[triangle.material as usize];
        let texture = texture.filter(|_| features.textures);
        for index in texture.into_iter().chain(bump.filter(|_| features.bump_maps)) {
            used[index as usize] = true;
        }
    }
    let used: Vec<_> = (0..used.len()).filter(|&texture| used[texture]).collect();
    for &texture in &used {
        let Texture { width, height, .. } = scene.textures[texture];
        if !(1..=1 << 16).contains(&width) || !(1..=1 << 16).contains(&height) {
            return Err(LayoutError::Texture { texture, width, height });
        }
    }
    Ok(used)
}

/// Bytes of a texture with the padding behind it, and with its coarser levels if `mip_maps`.
fn stored_bytes(texture: &Texture, mip_maps: bool) -> u64 {
    let record = TextureRecord { texels: HostAddr(0), width: texture.width, height: texture.height };
    let texels = record.texels_of_levels(if mip_maps { record.levels() } else { 1 });
    (texels * u64::from(texture.format.texel_bytes())).next_multiple_of(TEXTURE_ALIGNMENT.into())
}

/// Where each texture lies, of those that are stored, from the address `texels` on.
fn texture_records(
    scene: &Scene,
    features: Features,
    stored: &[usize],
    mut texels: HostAddr,
) -> Vec<Option<TextureRecord>> {
    let mut records = vec![None; scene.textures.len()];
    for &index in stored {
        let texture = &scene.textures[index];
        records[index] = Some(TextureRecord { texels, width: texture.width, height: texture.height });
        // The last one may end where the address space does.
        texels = HostAddr(texels.0.wrapping_add(stored_bytes(texture, features.mip_maps) as u32));
    }
    records
}

/// A material, whose textures lie where `textures` says.
fn material_record(material: &Material, textures: &[Option<TextureRecord>]) -> MaterialRecord {
    let record = |texture: Option<u32>| texture.and_then(|index| textures[index as usize]);
    MaterialRecord {
        diffuse: material.diffuse,
        specular: material.specular,
        shininess: material.shininess,
        reflection: material.reflection,
        refraction: material.refraction,
        index_of_refraction: material.index_of_refraction,
        texture: record(material.texture),
        bump: record(material.bump).map(|map| (map, material.bump_height)),
    }
}

/// What shading knows of a triangle. What the scene does not need is zero.
fn shading_record(scene: &Scene, id: usize, features: Features, material: HostAddr) -> ShadingRecord {
    let corners = scene.triangles[id].corners;
    let normal = plane_normal(&corners);
    let tex_coords = if features.mapped() { scene.tex_coords[id] } else { [Vec2::ZERO; 3] };
    ShadingRecord {
        material,
        normal,
        normals: if features.smooth_normals { scene.normals[id] } else { [normal; 3] },
        tex_coords,
        texture_density: texture_density(&corners, &tex_coords),
        tangent: tangent(&corners, &tex_coords),
    }
}

/// Unit normal of a triangle that is not degenerate, in f64: tiny triangles would underflow.
fn plane_normal(corners: &[Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// Area of a triangle in texture coordinates for each unit of its area in space.
fn texture_density(corners: &[Vec3; 3], uv: &[Vec2; 3]) -> f32 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let [ta, tb, tc] = uv.map(Vec2::as_dvec2);
    ((tb - ta).perp_dot(tc - ta).abs() / (b - a).cross(c - a).length()) as f32
}

/// Unit vector in the triangle's plane along which the first texture coordinate grows. Where the
/// texture coordinates span no area, it is one along which neither grows, or zero.
fn tangent(corners: &[Vec3; 3], uv: &[Vec2; 3]) -> Vec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let [ta, tb, tc] = uv.map(Vec2::as_dvec2);
    let (db, dc) = (tb - ta, tc - ta);
    let along = ((b - a) * dc.y - (c - a) * db.y) * db.perp_dot(dc).signum();
    along.normalize_or_zero().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::scene::{TexelFormat, Triangle};
    use crate::host::tree::{Axis, Node};

    /// Two triangles, one of them with every feature that a surface can have.
    fn scene() -> Scene {
        let plain = Material { diffuse: Vec3::new(0.1, 0.2, 0.3), ..Material::default() };
        let rich = Material {
            specular: Vec3::splat(0.5),
            shininess: 20.0,
            reflection: 0.25,
            refraction: 0.125,
            index_of_refraction: 1.5,
            texture: Some(2),
            bump: Some(0),
            bump_height: 3.0,
            ..plain
        };
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y];
        let texture = |width, height, format: TexelFormat| Texture {
            width,
            height,
            format,
            texels: (0..width * height * format.texel_bytes()).map(|i| i as u8).collect(),
        };
        Scene {
            triangles: vec![
                Triangle { corners, material: 0 },
                Triangle { corners: corners.map(|corner| corner + Vec3::Z), material: 1 },
            ],
            tex_coords: vec![[Vec2::ZERO, Vec2::X, Vec2::Y]; 2],
            normals: vec![[Vec3::X, Vec3::Y, Vec3::Z]; 2],
            materials: vec![plain, rich],
            textures: vec![
                texture(3, 2, TexelFormat::Height8),
                texture(9, 9, TexelFormat::Rgba8),
                texture(8, 7, TexelFormat::Rgba8),
            ],
            lights: vec![Light { position: Vec3::Z, intensity: 1.0 }],
            path: Vec::new(),
            mip_maps: true,
        }
    }

    /// Second triangle first: the image is to follow the lists.
    fn tree() -> KdTree {
        KdTree {
            bounds: Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0) },
            nodes: vec![
                Node::Inner { axis: Axis::Z, split: 0.5, children: 1 },
                Node::Leaf { first: 0, count: 2 },
                Node::Leaf { first: 2, count: 1 },
            ],
            refs: vec![1, 0, 1],
        }
    }

    fn bytes_at(image: &HostImage, addr: HostAddr, len: u32) -> &[u8] {
        &image.bytes[addr.0 as usize..][..len as usize]
    }

    fn word_at(image: &HostImage, addr: HostAddr) -> u32 {
        u32::from_le_bytes(bytes_at(image, addr, 4).try_into().expect("four bytes"))
    }

    #[test]
    fn what_is_written_reads_back() {
        let (scene, tree) = (scene(), tree());
        let image = HostImage::build(&scene, &tree, Kernel::MollerTrumbore).expect("valid");
        let Registers { root, triangles, shading, features, .. } = image.registers;
        let node = |addr: HostAddr| {
            NodeRecord::decode(bytes_at(&image, addr, NODE_BYTES).try_into().expect("eight bytes"))
        };
        let NodeRecord::Inner { axis: Axis::Z, split: 0.5, below } = node(root) else {
            panic!("{:?}", node(root));
        };
        let NodeRecord::Leaf { list, count: 2 } = node(below) else { panic!("{:?}", node(below)) };
        assert_eq!((word_at(&image, list), word_at(&image, list.offset(4))), (triangles.0, triangles.0 + 36));
        assert_eq!(image.triangle_ids, [1, 0]);
        // z of the first corner of the first triangle of the image: the scene's second.
        assert_eq!(word_at(&image, triangles.offset(8)), 1.0_f32.to_bits());

        let record =
            ShadingRecord::decode(bytes_at(&image, shading, features.shading_record_bytes()), features);
        assert_eq!((record.normal, record.tangent), (Vec3::Z, Vec3::X));
        assert_eq!((record.normals, record.tex_coords), (scene.normals[1], scene.tex_coords[1]));
        let material =
            MaterialRecord::decode(bytes_at(&image, record.material, features.material_bytes()), features);
        let rich = scene.materials[1];
        assert_eq!(
            (material.diffuse, material.specular, material.shininess),
            (rich.diffuse, rich.specular, 20.0)
        );
        assert_eq!(
            (material.reflection, material.refraction, material.index_of_refraction),
            (0.25, 0.125, 1.5)
        );
        let (texture, (bump, height)) = material.texture.zip(material.bump).expect("both");
        assert_eq!((texture.width, texture.height, bump.width, bump.height, height), (8, 7, 3, 2, 3.0));
        // The triangle's area is 1, and 1/2 in texture coordinates.
        assert_eq!(record.texture_density, 0.5);
        for (record, source) in [(texture, &scene.textures[2]), (bump, &scene.textures[0])] {
            let bytes = source.format.texel_bytes();
            let levels: Vec<_> = std::iter::successors(Some(source.clone()), Texture::halved).collect();
            assert_eq!((levels.len() as u32, record.texels.0 % TEXTURE_ALIGNMENT), (record.levels(), 0));
            for (level, source) in (0..).zip(&levels) {
                let record = record.level(level, source.format);
                for (number, texel) in (0..).zip(source.texels.chunks(bytes as usize)) {
                    let place = record.place(number % source.width, number / source.width);
                    assert_eq!(bytes_at(&image, record.texels.offset(place * bytes), bytes), texel);
                }
            }
        }
        // Heights: 6 bytes, with one coarser level 7. Colours: 224, with levels of 4 x 3, 2 x 1 and 1 x 1
        // texels 284. All begin at multiples of 64.
        assert_eq!((image.region_bytes[4], image.mip_map_bytes), (Bytes(64 + 320), Bytes(64)));
    }

    #[test]
    fn what_is_not_needed_is_not_stored() {
        let mut scene = scene();
        scene.triangles[1].material = 0;
        scene.normals.clear();
        let image = HostImage::build(&scene, &tree(), Kernel::Wald).expect("valid");
        let features = image.registers.features;
        assert_eq!((features.material_bytes(), features.shading_record_bytes()), (12, 16));
        assert_eq!(image.region_bytes[4], Bytes(0));
    }

    #[test]
    fn faults_of_the_driver_are_refused() {
        let mut tree = tree();
        tree.refs[0] = 2;
        let fault = HostImage::build(&scene(), &tree, Kernel::Wald).expect_err("no such triangle");
        assert_eq!(fault, LayoutError::Tree(KdTreeError::Triangle { place: 0, triangle: 2 }));
    }
}
