//! The standard configuration of a scene, from the numbers of [`saarcor_model::time::standard`].

use crate::error::StudyError;
use saarcor_model::rays::Pipeline;
use saarcor_model::time::standard::{self, CHIP_CACHE_WAYS};
use saarcor_model::time::{ChipConfig, Version};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Unit};

pub use saarcor_model::time::standard::{LINE, MEMORY_OF, POLICY, RESOLUTION, WAYS};

/// Reflections and refractions that may follow one another.
pub const MAX_BOUNCES: u32 = Pipeline::<1>::STANDARD_BOUNCES;

/// The name of a scene without its suffixes: `pQuake3` of `pQuake3-nlnt`.
#[must_use]
pub fn family(scene: &str) -> &str {
    scene.split_once('-').map_or(scene, |(family, _suffixes)| family)
}

/// On-board memory for a scene: for a built-in scene that of Table 2's caption.
#[must_use]
pub fn memory(scene: &str) -> Bytes {
    let family = family(scene);
    let stated = standard::MEMORY_OF.iter().find(|(name, _)| name.eq_ignore_ascii_case(family));
    stated.map_or(standard::MEMORY, |(_, memory)| *memory)
}

/// The triangle cache for a scene: the larger one for the Cruiser (§4, Stated).
#[must_use]
pub fn triangle_cache(scene: &str) -> Bytes {
    let bytes = if family(scene).eq_ignore_ascii_case("cruiser") {
        standard::CRUISER_TRIANGLE_CACHE_BYTES
    } else {
        standard::FIRST_LEVEL_BYTES[Unit::Intersection as usize]
    };
    Bytes(bytes.into())
}

/// The standard virtual memory for a scene.
///
/// # Errors
/// If the standard sizes do not make a cache.
pub fn cache(scene: &str) -> Result<CacheConfig, StudyError> {
    let geometry = Geometry::new(memory(scene), LINE, WAYS)?;
    Ok(CacheConfig { geometry, hash: Hash::default(), policy: standard::POLICY })
}

/// The standard chip for a scene.
///
/// # Errors
/// If the standard sizes make none.
pub fn chip(scene: &str, version: Version) -> Result<ChipConfig, StudyError> {
    let mut config = ChipConfig::standard(version, cache(scene)?);
    let triangles = &mut config.l1[Unit::Intersection as usize];
    triangles.sets = triangle_cache(scene).0 as u32 / triangles.line / CHIP_CACHE_WAYS as u32;
    config.check()?;
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_scenes_have_the_memory_of_table_2() {
        let mib = |scene| memory(scene).0 >> 20;
        assert_eq!(["pquake3-nl", "sodahall", "conference-8l", "cruiser"].map(mib), [8, 8, 32, 64]);
        assert_eq!(mib("folder/level.obj"), 8);
    }

    #[test]
    fn only_the_cruiser_has_the_larger_triangle_cache() {
        let kib = |scene| {
            let chip = chip(scene, Version::B).expect("a chip");
            chip.l1_bytes(Unit::Intersection as usize) >> 10
        };
        assert_eq!(["pquake3", "sodahall", "conference", "cruiser"].map(kib), [144, 144, 144, 576]);
    }
}
