//! Table 1 (§4): the scenes, ours beside the paper's.

use crate::tables::Table1Row;
use saarcor_studies::summary::{RegionBytes, Summary};
use saarcor_studies::world::World;
use serde::Serialize;

/// A scene of Table 1.
#[derive(Clone, Debug, Serialize)]
pub struct SceneRow {
    /// Name, as the paper prints it.
    pub scene: String,
    /// Our triangles.
    pub triangles: u64,
    /// The paper's triangles.
    pub paper_triangles: u64,
    /// Our lights.
    pub lights: u32,
    /// The paper's lights.
    pub paper_lights: u32,
    /// Bytes of our image but for the textures.
    pub geometry_bytes: u64,
    /// The paper's geometry on disk, in MB.
    pub paper_geometry_mb: u64,
    /// Bytes of our textures and bump maps, without the coarser levels of mip maps.
    pub texture_bytes: u64,
    /// The paper's textures on disk, in MB.
    pub paper_textures_mb: Option<u64>,
    /// Our image by regions.
    pub regions: Vec<RegionBytes>,
}

impl SceneRow {
    /// Our scene beside the paper's.
    #[must_use]
    pub fn new(paper: &Table1Row, world: &World) -> Self {
        let summary = Summary::of(world);
        let geometry_bytes = summary.geometry_bytes();
        Self {
            scene: paper.scene.clone(),
            triangles: world.triangles as u64,
            paper_triangles: paper.triangles,
            lights: summary.lights,
            paper_lights: paper.lights,
            geometry_bytes,
            paper_geometry_mb: paper.geometry_mb,
            texture_bytes: summary.texture_bytes(),
            paper_textures_mb: paper.textures_mb,
            regions: summary.regions,
        }
    }
}
