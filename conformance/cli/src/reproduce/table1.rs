//! Table 1 (§4): the scenes, ours beside the paper's.

use crate::table::{Column, Table, mb};
use saarcor_oracles::paper::Table1Row;
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

/// Table 1: ours | the paper's.
#[must_use]
pub fn beside(rows: &[SceneRow]) -> Table {
    let numbers = ["triangles", "paper", "lights", "paper", "geometry MB", "paper", "textures MB", "paper"];
    let mut table = Table::new(std::iter::once(Column::text("scene")).chain(numbers.map(Column::number)));
    for row in rows {
        let textures = |mb: Option<String>| mb.unwrap_or_else(|| "–".to_owned());
        table.row([
            row.scene.clone(),
            row.triangles.to_string(),
            row.paper_triangles.to_string(),
            row.lights.to_string(),
            row.paper_lights.to_string(),
            mb(row.geometry_bytes),
            row.paper_geometry_mb.to_string(),
            textures((row.texture_bytes > 0).then(|| mb(row.texture_bytes))),
            textures(row.paper_textures_mb.map(|mb| mb.to_string())),
        ]);
    }
    table
}

/// Bytes a triangle, ours by region.
#[must_use]
pub fn bytes_a_triangle(rows: &[SceneRow]) -> Table {
    let regions = rows.first().map_or(&[][..], |row| &row.regions).iter().map(|region| region.region);
    let names = regions.chain(["geometry", "paper"]).map(Column::number);
    let mut table = Table::new(std::iter::once(Column::text("scene")).chain(names));
    for row in rows {
        let each = |bytes: f64| format!("{bytes:.1}");
        let paper = (row.paper_geometry_mb << 20) as f64 / row.paper_triangles as f64;
        let ours = row.geometry_bytes as f64 / row.triangles as f64;
        let cells = row.regions.iter().map(|region| region.bytes_a_triangle).chain([ours, paper]);
        table.row(std::iter::once(row.scene.clone()).chain(cells.map(each)));
    }
    table
}
