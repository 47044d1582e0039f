//! What a scene needs of the chip, and the bytes of its image.

use crate::table::{Column, Table, mb};
use crate::world::World;
use saarcor_model::host::{Features, Region};
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

/// The names of the features that a scene needs, or does not need.
#[must_use]
pub fn listed(features: Features, needed: bool) -> String {
    let names: Vec<_> =
        needs(features).into_iter().filter(|need| need.1 == needed).map(|need| need.0).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

/// Name of a region of the image.
#[must_use]
pub fn region_name(region: Region) -> &'static str {
    match region {
        Region::Nodes => "nodes",
        Region::Lists => "lists",
        Region::Triangles => "triangles",
        Region::Shading => "shading",
        Region::Textures => "textures",
    }
}

/// What is known of a scene in host memory.
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
    /// Names of what it needs of the chip.
    pub needs: Vec<&'static str>,
    /// Bytes of the regions of [`Region::ALL`].
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
    #[serde(skip)]
    features: Features,
    #[serde(skip)]
    seconds: [f64; 3],
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
        let region = |(region, bytes): (Region, saarcor_model::vm::Bytes)| RegionBytes {
            region: region_name(region),
            bytes: bytes.0,
            bytes_a_triangle: bytes.0 as f64 / world.triangles.max(1) as f64,
        };
        let needed = needs(world.features).into_iter().filter(|need| need.1);
        Self {
            scene: world.name.clone(),
            triangles: world.triangles,
            triangles_without_area: world.degenerate,
            lights: world.features.lights,
            frames: world.path.len(),
            needs: needed.map(|need| need.0).collect(),
            regions: Region::ALL.into_iter().zip(world.image.region_bytes).map(region).collect(),
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
        let textures = region_name(Region::Textures);
        self.regions.iter().filter(|region| region.region != textures).map(|region| region.bytes).sum()
    }

    /// Bytes of textures and bump maps at full resolution: what the paper calls textures (Assumed).
    #[must_use]
    pub fn texture_bytes(&self) -> u64 {
        let all: u64 = self.regions.iter().map(|region| region.bytes).sum();
        all - self.geometry_bytes() - self.mip_map_bytes
    }

    /// The facts in a few lines.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let plural = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
        let without_area = match self.triangles_without_area {
            0 => String::new(),
            n => format!(" ({n} without area)"),
        };
        vec![
            format!(
                "{}: {}{without_area}, {}, {}",
                self.scene,
                plural(self.triangles, "triangle"),
                plural(self.lights as usize, "light"),
                plural(self.frames, "frame")
            ),
            format!("needs: {}", listed(self.features, true)),
            format!("does not need: {}", listed(self.features, false)),
            format!(
                "kd-tree: {}, {} leaves, {:.2} references a triangle",
                plural(self.nodes, "node"),
                self.leaves,
                self.references as f64 / self.triangles.max(1) as f64
            ),
        ]
    }

    /// The bytes of the image by region on one line.
    #[must_use]
    pub fn image_line(&self) -> String {
        let regions: Vec<_> =
            self.regions.iter().map(|region| format!("{} {}", region.region, mb(region.bytes))).collect();
        format!("image: {} MB ({})", mb(self.image_bytes), regions.join(", "))
    }

    /// The bytes of the image by region.
    #[must_use]
    pub fn image_table(&self) -> Table {
        let mut table = Table::new([
            Column::text("region"),
            Column::number("bytes"),
            Column::number("MB"),
            Column::number("bytes a triangle"),
        ]);
        for region in &self.regions {
            table.row([
                region.region.to_owned(),
                region.bytes.to_string(),
                mb(region.bytes),
                format!("{:.1}", region.bytes_a_triangle),
            ]);
        }
        table
    }

    /// How long the scene took to make ready.
    #[must_use]
    pub fn seconds_line(&self) -> String {
        let [loaded, built, laid_out] = self.seconds;
        format!("seconds: {loaded:.2} scene, {built:.2} kd-tree, {laid_out:.2} image")
    }
}
