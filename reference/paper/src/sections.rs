//! Which of our scenes stand in the rows of the paper's tables, and which frames of their paths are walked.

use crate::error::ReproductionError;
use crate::figure3::Graph;
use crate::reproduction::Extent;
use crate::table2;
use crate::tables::{self, Table1Row};
use saarcor_studies::monitor::Monitor;
use saarcor_studies::standard::{self, family};
use saarcor_studies::walk::WalkOptions;
use saarcor_studies::world::kept::KeptWorlds;
use saarcor_studies::world::{World, WorldOptions};
use std::path::Path;

/// A scene of the paper whose path is walked: one frame in so many, of the usual and of the quick
/// form. The paper's Figure 3 has the first and the last.
pub(crate) struct WalkedScene {
    of: &'static str,
    step: usize,
    quick_step: usize,
}

const WALKS: [WalkedScene; 4] = [
    WalkedScene { of: "pQuake3", step: 2, quick_step: 10 },
    WalkedScene { of: "Conference", step: 10, quick_step: 40 },
    WalkedScene { of: "Sodahall", step: 10, quick_step: 60 },
    WalkedScene { of: "Cruiser", step: 20, quick_step: 40 },
];

/// The real scenes, and the families of the paper's scenes for which they stand in.
const REAL_SCENES: [(&str, &str); 2] = [("oa_dm3", "pQuake3"), ("conference", "Conference")];

/// One of our scenes in the place of one of the paper's.
pub(crate) struct Section {
    /// Its place in the tables.
    pub place: usize,
    /// The paper's row.
    pub row: &'static Table1Row,
    /// Name of its graph's files.
    pub name: String,
    /// Whether it is a real scene.
    pub real: bool,
    /// How it is opened.
    pub options: WorldOptions,
}

impl Section {
    /// All sections: of the built-in scenes, then of those of `scenes`, with their worlds kept in `kept`. Of each family the walked one is the first, since
    /// the others take their hot spots from it.
    pub fn all(scenes: Option<&Path>, kept: Option<&KeptWorlds>) -> Result<Vec<Self>, ReproductionError> {
        let built_in = |(place, row): (usize, &'static Table1Row)| {
            let name = row.scene.to_lowercase();
            let options = WorldOptions { kept: kept.cloned(), ..WorldOptions::new(&name) };
            Self { place, row, options, name, real: false }
        };
        let mut sections: Vec<Self> = tables::table1().iter().enumerate().map(built_in).collect();
        for (scene, kind) in REAL_SCENES {
            let Some(scenes) = scenes else { break };
            let path = scenes.join(scene).join(scene).with_extension("obj");
            if !path.is_file() {
                return Err(ReproductionError::NoRealScene { folder: scenes.to_owned(), scene });
            }
            let file = path.to_str().ok_or_else(|| ReproductionError::NotText(path.clone()))?;
            let name = format!("real-{scene}");
            for row in tables::table1().iter().filter(|row| family(&row.scene) == kind) {
                let options = WorldOptions {
                    lights: Some(row.lights as usize),
                    no_textures: row.textures_mb.is_none(),
                    kept: kept.cloned(),
                    ..WorldOptions::new(file)
                };
                let place = sections.len();
                sections.push(Self { place, row, name: name.clone(), real: true, options });
            }
        }
        sections.sort_by_key(|section| !section.is_walked());
        Ok(sections)
    }

    /// The scenes that have its hot spots: those of its family, built-in or real.
    pub fn family(&self) -> (&'static str, bool) {
        (family(&self.row.scene), self.real)
    }

    /// Its walk, if its path is walked: the others of its family take their frames from it.
    fn walk(&self) -> Option<&'static WalkedScene> {
        WALKS.iter().find(|walk| walk.of == self.row.scene)
    }

    fn is_walked(&self) -> bool {
        self.walk().is_some()
    }

    /// Its walk with the standard virtual memory, if its path is walked.
    pub fn graph(
        &self,
        world: &World,
        extent: Extent,
        monitor: &dyn Monitor,
    ) -> Result<Option<Graph>, ReproductionError> {
        let Some(step) = self.step(extent) else { return Ok(None) };
        let cache = standard::cache(&self.row.scene)?;
        let options = WalkOptions { cache, cold: false, trace: extent.trace() };
        let count = table2::rows_of(&self.row.scene).count();
        Ok(Some(Graph::new(&self.name, world, &options, step, count, monitor)))
    }

    /// Whether it is the first of its family in the paper's tables: it shows what a cut of the camera costs.
    pub fn is_first(&self) -> bool {
        let mut rows = tables::table1().iter();
        rows.find(|row| family(&row.scene) == self.family().0).is_some_and(|row| row.scene == self.row.scene)
    }

    /// Which frames are walked, if any: one in so many.
    pub fn step(&self, extent: Extent) -> Option<usize> {
        let walk = self.walk()?;
        Some(match extent {
            Extent::Quick => walk.quick_step,
            Extent::Some => walk.step,
            Extent::All => 1,
        })
    }

    /// Roughly how many seconds it takes on two cores, for the estimate of the time left.
    pub fn seconds(&self, extent: Extent) -> f64 {
        let pixels = if extent == Extent::Quick { 1.0 / 16.0 } else { 1.0 };
        // A walk's frame took 1.4 s for the Cruiser; for the others 0.1 to 0.5 s a ray of a pixel.
        let frame = if self.row.scene == "Cruiser" { 1.4 } else { 0.4 * f64::from(1 + self.row.lights) };
        // Frames a second of a walk take some frames on the chip.
        let frames = self.step(extent).map_or(0.0, |step| 1000.0 / step as f64 + 60.0);
        let hot_spots = table2::rows_of(&self.row.scene).count();
        self.row.triangles as f64 * 1e-5 + pixels * frame * (frames + 12.0 * hot_spots as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::time::Version;
    use saarcor_model::vm::Unit;
    use saarcor_scenes::kdbuild::BuildOptions;

    /// What a scene has of its own is what the paper states: the memory, and the Cruiser's triangle cache.
    #[test]
    fn no_scene_has_a_setting_of_its_own() {
        let chip = |of| standard::chip(of, Version::B).expect("a chip");
        let one = chip("Conference");
        for section in Section::all(None, None).expect("built-in scenes") {
            let mut other = chip(&section.row.scene);
            assert_eq!(other.cache.geometry.memory(), standard::memory(&section.row.scene));
            let triangles = Unit::Intersection as usize;
            assert_eq!(other.l1[triangles] != one.l1[triangles], section.family().0 == "Cruiser");
            (other.cache.geometry, other.l1[triangles]) = (one.cache.geometry, one.l1[triangles]);
            assert_eq!(other, one, "{}", section.name);
            let WorldOptions { lights, no_textures, no_mip_maps, tree, .. } = section.options;
            assert_eq!(
                (lights, no_textures, no_mip_maps, tree),
                (None, false, false, BuildOptions::default())
            );
        }
    }

    /// Each family has one walk, and all its variants have the frames of that one.
    #[test]
    fn frames_come_from_the_walk_of_the_family() {
        let sections = Section::all(None, None).expect("built-in scenes");
        let walked: Vec<_> =
            sections.iter().filter(|section| section.is_walked()).map(Section::family).collect();
        assert_eq!(walked.len(), 4);
        for (place, section) in sections.iter().enumerate() {
            assert!(
                walked.contains(&section.family()) && (place >= 4 || section.is_walked()),
                "{}",
                section.name
            );
        }
    }
}
