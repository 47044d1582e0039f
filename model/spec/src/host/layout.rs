//! The host image: the whole scene as bytes in host memory (§3: "the entire scene data is stored
//! in main memory").
//!
//! Every kd-node, list, triangle, shading record, material, texture and bump map has a host
//! address, and the chip's units read nothing else. What the driver writes into the chip itself,
//! before a frame, are the [`Registers`].
//!
//! | region | item | bytes | status |
//! |---|---|---:|---|
//! | nodes | kd-node | 8 | Assumed, after Wald et al. 2001 |
//! | lists | address of a triangle | 4 | Assumed: a host address |
//! | triangles | triangle | 36 | Derived: 144 KB of cache are 4096 of them |
//! | shading | material, shading record | by [`Features`] | Assumed |
//! | textures | texel | 4; 1 in bump maps | Assumed |
//!
//! All numbers are little-endian. Nodes lie in the order of [`KdTree::nodes`], triangles in the
//! order in which the lists first name them, texels as [`ImageRecord`] says (Assumed).

use super::scene::{self, Features, Image, Light, Material, Scene};
use super::texture::{IMAGE_ALIGNMENT, ImageRecord};
use super::tree::{Aabb, Axis, KdTree, KdTreeError, Node};
use crate::rays::Kernel;
use crate::vm::{Bytes, HostAddr};
use glam::{Vec2, Vec3};
use std::fmt;

/// Bytes of a kd-node.
pub const NODE_BYTES: u32 = 8;
/// Bytes of a list entry.
pub const LIST_ENTRY_BYTES: u32 = 4;
/// Bytes of a triangle.
pub const TRIANGLE_BYTES: u32 = 36;
/// Regions begin at multiples of this: a page of the host (Assumed).
pub const REGION_ALIGNMENT: u32 = 4096;

/// What the driver tells the chip beside the image's bytes (Assumed: §2 does not say how).
#[derive(Clone, Debug, PartialEq)]
pub struct Registers {
    /// Address of the root of the kd-tree.
    pub root: HostAddr,
    /// Box around the scene.
    pub bounds: Aabb,
    /// The triangle test, which decides what a triangle's 36 bytes mean.
    pub kernel: Kernel,
    /// Address of the first triangle.
    pub triangles: HostAddr,
    /// Address of the first triangle's shading record.
    pub shading: HostAddr,
    /// What the scene needs.
    pub features: Features,
    /// The lights. Their intensities add up to 1 at most.
    pub lights: Vec<Light>,
}

/// The parts of the image, in the order of their addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// kd-nodes.
    Nodes,
    /// Lists of triangle addresses.
    Lists,
    /// Triangles.
    Triangles,
    /// Materials, then a shading record a triangle.
    Shading,
    /// Image textures and bump maps.
    Textures,
}

impl Region {
    /// All regions in the order of their addresses.
    pub const ALL: [Self; 5] = [Self::Nodes, Self::Lists, Self::Triangles, Self::Shading, Self::Textures];
}

/// A scene in host memory.
#[derive(Clone, Debug)]
pub struct HostImage {
    /// The bytes from host address 0 on.
    pub bytes: Vec<u8>,
    /// What the chip is told beside them.
    pub registers: Registers,
    /// Bytes of each region of [`Region::ALL`], without the padding behind it.
    pub region_bytes: [Bytes; 5],
    /// Of the textures, bytes of the coarser levels of mip maps.
    pub mip_map_bytes: Bytes,
    /// Which of the scene's triangles each triangle of the image is.
    pub triangle_ids: Vec<u32>,
}

/// Why a scene cannot be laid out.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageError {
    /// The tree is not one that the chip may be given.
    Tree(KdTreeError),
    /// The image leaves the 32-bit host address space.
    TooLarge(Bytes),
    /// A texture has no texels, or more than 65536 a side.
    Texture {
        /// Index into [`Scene::images`].
        image: usize,
        /// Texels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tree(e) => e.fmt(f),
            Self::TooLarge(Bytes(n)) => {
                write!(f, "scene of {n} bytes: a host address has 32 bits, so at most {} bytes", 1_u64 << 32)
            }
            Self::Texture { image, width, height } => {
                write!(f, "image {image} has {width} x {height} texels: 1 to 65536 a side are possible")
            }
        }
    }
}

impl std::error::Error for ImageError {}

impl HostImage {
    /// Lays `scene` out for a chip with the triangle test `kernel`.
    ///
    /// # Errors
    /// If the tree is not valid for the scene, or the image does not fit a 32-bit address space.
    pub fn build(scene: &Scene, tree: &KdTree, kernel: Kernel) -> Result<Self, ImageError> {
        tree.check(scene.triangles.len()).map_err(ImageError::Tree)?;
        let features = scene::features(scene);
        let (triangle_ids, places) = order_of_first_use(tree, scene.triangles.len());
        let used_images = used_images(scene, features)?;

        let region_bytes = [
            tree.nodes.len() as u64 * u64::from(NODE_BYTES),
            tree.refs.len() as u64 * u64::from(LIST_ENTRY_BYTES),
            triangle_ids.len() as u64 * u64::from(TRIANGLE_BYTES),
            scene.materials.len() as u64 * u64::from(features.material_bytes())
                + triangle_ids.len() as u64 * u64::from(features.shading_record_bytes()),
            used_images.iter().map(|&image| stored_bytes(&scene.images[image], features.mip_maps)).sum(),
        ];
        let finest: u64 = used_images.iter().map(|&image| stored_bytes(&scene.images[image], false)).sum();
        let mut starts = [0_u64; 6];
        for (region, &bytes) in region_bytes.iter().enumerate() {
            starts[region + 1] = (starts[region] + bytes).next_multiple_of(u64::from(REGION_ALIGNMENT));
        }
        if starts[5] > 1 << 32 {
            return Err(ImageError::TooLarge(Bytes(starts[5])));
        }
        let [nodes, lists, triangles, materials, textures, end] = starts.map(|start| start as u32);
        let shading = materials + scene.materials.len() as u32 * features.material_bytes();

        let mut out = Writer { bytes: Vec::with_capacity(starts[5] as usize) };
        for node in &tree.nodes {
            out.node(node, HostAddr(nodes), HostAddr(lists));
        }
        out.pad_to(lists);
        for &triangle in &tree.refs {
            let addr = triangles + places[triangle as usize] * TRIANGLE_BYTES;
            let tag = kernel.list_tag(&scene.triangles[triangle as usize].corners);
            out.bytes.extend_from_slice(&ListEntry { triangle: HostAddr(addr), tag }.encode());
        }
        out.pad_to(triangles);
        for &id in &triangle_ids {
            let corners = &scene.triangles[id as usize].corners;
            kernel.record(corners).iter().for_each(|&word| out.f32(word));
        }
        out.pad_to(materials);
        let mut image_addr = vec![HostAddr(0); scene.images.len()];
        let mut next = textures;
        for &image in &used_images {
            image_addr[image] = HostAddr(next);
            next += stored_bytes(&scene.images[image], features.mip_maps) as u32;
        }
        for material in &scene.materials {
            out.material(material, features, &scene.images, &image_addr);
        }
        for &id in &triangle_ids {
            let material = materials + scene.triangles[id as usize].material * features.material_bytes();
            out.shading_record(scene, id as usize, features, HostAddr(material));
        }
        out.pad_to(textures);
        for &image in &used_images {
            out.pad_to(image_addr[image].0);
            out.texels(&scene.images[image], features.mip_maps);
        }
        out.pad_to(end);

        let registers = Registers {
            root: HostAddr(nodes),
            bounds: tree.bounds,
            kernel,
            triangles: HostAddr(triangles),
            shading: HostAddr(shading),
            features,
            lights: exposed(&scene.lights),
        };
        let mip_map_bytes = Bytes(region_bytes[Region::Textures as usize] - finest);
        Ok(Self {
            bytes: out.bytes,
            registers,
            region_bytes: region_bytes.map(Bytes),
            mip_map_bytes,
            triangle_ids,
        })
    }

    /// The scene's index of the triangle at `addr`.
    #[must_use]
    pub fn triangle_id(&self, addr: HostAddr) -> u32 {
        self.triangle_ids[self.registers.triangle_index(addr) as usize]
    }
}

impl Registers {
    /// Which triangle of the image lies at `addr`.
    #[must_use]
    pub fn triangle_index(&self, addr: HostAddr) -> u32 {
        (addr.0 - self.triangles.0) / TRIANGLE_BYTES
    }
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

/// Indices of the images that the scene's features need, ascending.
fn used_images(scene: &Scene, features: Features) -> Result<Vec<usize>, ImageError> {
    let mut used = vec![false; scene.images.len()];
    for triangle in &scene.triangles {
        let Material { texture, bump, .. } = scene.materials[triangle.material as usize];
        let texture = texture.filter(|_| features.textures);
        for image in texture.into_iter().chain(bump.filter(|_| features.bump_maps)) {
            used[image as usize] = true;
        }
    }
    let used: Vec<_> = (0..used.len()).filter(|&image| used[image]).collect();
    for &image in &used {
        let Image { width, height, .. } = scene.images[image];
        if !(1..=1 << 16).contains(&width) || !(1..=1 << 16).contains(&height) {
            return Err(ImageError::Texture { image, width, height });
        }
    }
    Ok(used)
}

/// Bytes of an image with the padding behind it, and with its coarser levels if `mip_maps`.
fn stored_bytes(image: &Image, mip_maps: bool) -> u64 {
    let record = ImageRecord { texels: HostAddr(0), width: image.width, height: image.height };
    let texels = record.texels_of_levels(if mip_maps { record.levels() } else { 1 });
    (texels * u64::from(image.format.texel_bytes())).next_multiple_of(IMAGE_ALIGNMENT.into())
}

/// A kd-node as the chip reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeRecord {
    /// Space is cut at `split` along `axis`.
    Inner {
        /// The axis that the split plane is perpendicular to.
        axis: Axis,
        /// Coordinate of the split plane.
        split: f32,
        /// Address of the child below the plane; the one above follows it.
        below: HostAddr,
    },
    /// A leaf with `count` triangle addresses from `list` on.
    Leaf {
        /// Address of the list.
        list: HostAddr,
        /// Entries of the list.
        count: u32,
    },
}

impl NodeRecord {
    /// Reads a node: the split plane or the count, then an address whose two lowest bits are the
    /// axis, or 3 for a leaf (KD-1, Assumed).
    #[inline]
    #[must_use]
    pub fn decode(bytes: [u8; NODE_BYTES as usize]) -> Self {
        let [first, second] = words(bytes);
        let addr = HostAddr(second & !3);
        let split = f32::from_bits(first);
        match second & 3 {
            0 => Self::Inner { axis: Axis::X, split, below: addr },
            1 => Self::Inner { axis: Axis::Y, split, below: addr },
            2 => Self::Inner { axis: Axis::Z, split, below: addr },
            _ => Self::Leaf { list: addr, count: first },
        }
    }

    /// The bytes that [`NodeRecord::decode`] reads. Addresses are multiples of 4.
    #[must_use]
    pub fn encode(self) -> [u8; NODE_BYTES as usize] {
        let (first, addr, tag) = match self {
            Self::Inner { axis, split, below } => (split.to_bits(), below.0, axis as u32),
            Self::Leaf { list, count } => (count, list.0, 3),
        };
        let ([a, b, c, d], [e, f, g, h]) = (first.to_le_bytes(), (addr | tag).to_le_bytes());
        [a, b, c, d, e, f, g, h]
    }
}

/// An entry of a leaf's list as the chip reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListEntry {
    /// Address of the triangle, a multiple of 4.
    pub triangle: HostAddr,
    /// What the triangle test needs beside the triangle's bytes: [`Kernel::list_tag`], 2 bits.
    pub tag: u32,
}

impl ListEntry {
    /// Reads an entry: an address whose two lowest bits are the tag (HI-3, Assumed).
    #[inline]
    #[must_use]
    pub fn decode(bytes: [u8; LIST_ENTRY_BYTES as usize]) -> Self {
        let entry = u32::from_le_bytes(bytes);
        Self { triangle: HostAddr(entry & !3), tag: entry & 3 }
    }

    /// The bytes that [`ListEntry::decode`] reads.
    #[must_use]
    pub fn encode(self) -> [u8; LIST_ENTRY_BYTES as usize] {
        (self.triangle.0 | self.tag).to_le_bytes()
    }
}

#[inline]
fn words(bytes: [u8; 8]) -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = bytes;
    [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
}

/// A material as the chip reads it. What the scene does not need is not stored, and reads as the
/// value that has no effect.
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
    pub texture: Option<ImageRecord>,
    /// Bump map and the height, in texels, of its 1.0.
    pub bump: Option<(ImageRecord, f32)>,
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
    /// Triangles have texture coordinates.
    #[must_use]
    pub fn mapped(self) -> bool {
        self.textures || self.bump_maps
    }

    /// Bytes of a material in this scene.
    #[must_use]
    pub fn material_bytes(self) -> u32 {
        12 + 16 * u32::from(self.highlights)
            + 4 * u32::from(self.reflection)
            + 8 * u32::from(self.refraction)
            + 8 * u32::from(self.textures)
            + 12 * u32::from(self.bump_maps)
    }

    /// Bytes of a shading record in this scene.
    #[must_use]
    pub fn shading_record_bytes(self) -> u32 {
        16 + 36 * u32::from(self.smooth_normals)
            + 24 * u32::from(self.mapped())
            + 4 * u32::from(self.mip_maps)
            + 12 * u32::from(self.bump_maps)
    }

    /// Most bytes that a material or a shading record has.
    pub const MAX_RECORD_BYTES: usize = 92;
}

impl MaterialRecord {
    /// Reads a material of a scene that needs `features`.
    #[must_use]
    pub fn decode(bytes: &[u8], features: Features) -> Self {
        let mut fields = Fields { rest: bytes };
        let diffuse = fields.vec3();
        let (specular, shininess) =
            if features.highlights { (fields.vec3(), fields.f32()) } else { (Vec3::ZERO, 1.0) };
        let reflection = if features.reflection { fields.f32() } else { 0.0 };
        let (refraction, index_of_refraction) =
            if features.refraction { (fields.f32(), fields.f32()) } else { (0.0, 1.0) };
        let texture = if features.textures { fields.image() } else { None };
        let bump = if features.bump_maps { fields.image().zip(Some(fields.f32())) } else { None };
        Self { diffuse, specular, shininess, reflection, refraction, index_of_refraction, texture, bump }
    }
}

impl ShadingRecord {
    /// Reads a shading record of a scene that needs `features`.
    #[must_use]
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

    fn image(&mut self) -> Option<ImageRecord> {
        let (texels, size) = (HostAddr(self.u32()), self.u32());
        // No texel lies at address 0: the root of the kd-tree does.
        let record = ImageRecord { texels, width: (size & 0xFFFF) + 1, height: (size >> 16) + 1 };
        (texels != HostAddr(0)).then_some(record)
    }
}

/// Writes the image from its first byte to its last: the inverse of the `decode` functions.
struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn u32(&mut self, word: u32) {
        self.bytes.extend_from_slice(&word.to_le_bytes());
    }

    fn f32(&mut self, value: f32) {
        self.u32(value.to_bits());
    }

    fn vec3(&mut self, value: Vec3) {
        value.to_array().into_iter().for_each(|v| self.f32(v));
    }

    /// The texels of an image, and of the coarser levels where the scene has mip maps.
    fn texels(&mut self, image: &Image, mip_maps: bool) {
        image.in_bands().for_each(|texel| self.bytes.extend_from_slice(texel));
        let coarser = std::iter::successors(image.halved().filter(|_| mip_maps), Image::halved);
        for level in coarser {
            level.in_bands().for_each(|texel| self.bytes.extend_from_slice(texel));
        }
    }

    fn pad_to(&mut self, addr: u32) {
        // 2³² wraps to 0: the image then ends with the address space.
        let end = if addr == 0 && !self.bytes.is_empty() { 1 << 32 } else { addr as usize };
        self.bytes.resize(end, 0);
    }

    fn node(&mut self, node: &Node, nodes: HostAddr, lists: HostAddr) {
        let record = match *node {
            Node::Inner { axis, split, children } => {
                NodeRecord::Inner { axis, split, below: nodes.offset(children * NODE_BYTES) }
            }
            Node::Leaf { first, count } => {
                NodeRecord::Leaf { list: lists.offset(first * LIST_ENTRY_BYTES), count }
            }
        };
        self.bytes.extend_from_slice(&record.encode());
    }

    fn image(&mut self, image: Option<u32>, images: &[Image], addr: &[HostAddr]) {
        match image {
            Some(image) => {
                let Image { width, height, .. } = images[image as usize];
                self.u32(addr[image as usize].0);
                self.u32((height - 1) << 16 | (width - 1));
            }
            None => [0, 0].into_iter().for_each(|word| self.u32(word)),
        }
    }

    fn material(&mut self, material: &Material, features: Features, images: &[Image], addr: &[HostAddr]) {
        self.vec3(material.diffuse);
        if features.highlights {
            self.vec3(material.specular);
            self.f32(material.shininess);
        }
        if features.reflection {
            self.f32(material.reflection);
        }
        if features.refraction {
            self.f32(material.refraction);
            self.f32(material.index_of_refraction);
        }
        if features.textures {
            self.image(material.texture, images, addr);
        }
        if features.bump_maps {
            self.image(material.bump, images, addr);
            self.f32(material.bump_height);
        }
    }

    fn shading_record(&mut self, scene: &Scene, id: usize, features: Features, material: HostAddr) {
        let corners = scene.triangles[id].corners;
        self.u32(material.0);
        self.vec3(plane_normal(&corners));
        if features.smooth_normals {
            scene.normals[id].into_iter().for_each(|normal| self.vec3(normal));
        }
        if features.mapped() {
            scene.tex_coords[id].into_iter().flat_map(|uv| [uv.x, uv.y]).for_each(|v| self.f32(v));
        }
        if features.mip_maps {
            self.f32(texture_density(&corners, &scene.tex_coords[id]));
        }
        if features.bump_maps {
            self.vec3(tangent(&corners, &scene.tex_coords[id]));
        }
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

/// Unit vector in the triangle's plane along which the first texture coordinate grows; zero where
/// the texture coordinates span no area.
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
        let image = |width, height, format: TexelFormat| Image {
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
            images: vec![
                image(3, 2, TexelFormat::Height8),
                image(9, 9, TexelFormat::Rgba8),
                image(8, 7, TexelFormat::Rgba8),
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
        for (record, source) in [(texture, &scene.images[2]), (bump, &scene.images[0])] {
            let bytes = source.format.texel_bytes();
            let levels: Vec<_> = std::iter::successors(Some(source.clone()), Image::halved).collect();
            assert_eq!((levels.len() as u32, record.texels.0 % IMAGE_ALIGNMENT), (record.levels(), 0));
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
    fn records_fit_their_buffer() {
        let all = Features {
            textures: true,
            bump_maps: true,
            mip_maps: true,
            lights: 1,
            smooth_normals: true,
            highlights: true,
            reflection: true,
            refraction: true,
        };
        let most = all.material_bytes().max(all.shading_record_bytes());
        assert_eq!(most as usize, Features::MAX_RECORD_BYTES);
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
        assert_eq!(fault, ImageError::Tree(KdTreeError::Triangle { place: 0, triangle: 2 }));
    }
}
