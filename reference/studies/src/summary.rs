//! The features that a scene needs of the chip, and the bytes of its image.

use crate::world::World;
use saarcor_model::host::Features;
use saarcor_model::vm::Bytes;
use serde::Serialize;

/// A name for each feature and whether a scene needs it.
#[must_use]
pub fn needs(features: Features) -> [(&'static str, bool); 8] {
    [
        ("textures", features.textures),
        ("bump maps", features.bump_maps),
        ("mip maps", features.mip_maps),
        ("shadow rays", features.lights > 0),
        ("smooth normals", features.smooth_normals),
        ("highlights", features.highlights),
        ("reflection", features.reflection),
        ("refraction", features.refraction),
    ]
}

/// Names of the regions of the image, in the order of their addresses.
pub const REGION_NAMES: [&str; 5] = ["nodes", "lists", "triangles", "shading", "textures"];

/// Facts about a scene in host memory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The scene.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// Of these, triangles without area, which the image does not hold.
    pub triangles_without_area: usize,
    /// Its lights.
    pub lights: u32,
    /// Frames of its path.
    pub frames: usize,
    /// Names of the features that it needs.
    pub needs: Vec<&'static str>,
    /// Bytes of the regions, in the order of [`REGION_NAMES`].
    pub regions: Vec<RegionBytes>,
    /// Of the textures, bytes of the coarser levels of mip maps.
    pub mip_map_bytes: u64,
    /// Bytes of the image, with the padding between regions.
    pub image_bytes: u64,
    /// Nodes of the kd-tree.
    pub nodes: usize,
    /// Leaves of the kd-tree.
    pub leaves: usize,
    /// Entries of the kd-tree's lists.
    pub references: usize,
    /// The features that it needs.
    #[serde(skip)]
    pub features: Features,
    /// Seconds that it took to load or generate the scene, to build its tree, to lay it out.
    #[serde(skip)]
    pub seconds: [f64; 3],
}

/// A region of the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegionBytes {
    /// Name of the region.
    pub region: &'static str,
    /// Its bytes.
    pub bytes: u64,
    /// The same for each of the scene's triangles.
    pub bytes_a_triangle: f64,
}

impl Summary {
    /// The summary of a scene.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let region = |(region, Bytes(bytes))| RegionBytes {
            region,
            bytes,
            bytes_a_triangle: bytes as f64 / world.triangles.max(1) as f64,
        };
        let needed = needs(world.features).into_iter().filter(|need| need.1);
        Self {
            scene: world.name.clone(),
            triangles: world.triangles,
            triangles_without_area: world.degenerate,
            lights: world.features.lights,
            frames: world.path.len(),
            needs: needed.map(|need| need.0).collect(),
            regions: REGION_NAMES.into_iter().zip(world.image.region_bytes).map(region).collect(),
            mip_map_bytes: world.image.mip_map_bytes.0,
            image_bytes: world.image.bytes.len() as u64,
            nodes: world.tree.nodes,
            leaves: world.tree.leaves,
            references: world.tree.refs,
            features: world.features,
            seconds: world.seconds,
        }
    }

    /// Bytes of all regions but the textures: what the paper calls geometry.
    #[must_use]
    pub fn geometry_bytes(&self) -> u64 {
        let [.., textures] = REGION_NAMES;
        self.regions.iter().filter(|region| region.region != textures).map(|region| region.bytes).sum()
    }

    /// Bytes of textures and bump maps at full resolution: what the paper calls textures (Assumed).
    #[must_use]
    pub fn texture_bytes(&self) -> u64 {
        let all: u64 = self.regions.iter().map(|region| region.bytes).sum();
        all - self.geometry_bytes() - self.mip_map_bytes
    }
}
