//! Rays at edges and vertices: how many of the triangles around there the model hits where edges are owned, and how many Embree.
//!
//! Embree says what is hit first. So the triangles are parted into scenes in which no two of them touch, and Embree is asked in each
//! scene whether it hits the one of the patch.

use crate::accuracy::contest::{Contestant, Format};
use crate::accuracy::exactly_one::{Counts, counter};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::Ray;
use saarcor_oracles::embree::{Embree, EmbreeError, Hit};
use saarcor_oracles::exact::crossings::Crossings;
use saarcor_oracles::surfaces::{Case, Place, SurfaceSuite, case};
use serde::Serialize;

/// Most scenes: triangles at a vertex of more are left out.
const MOST_SCENES: usize = 24;

/// How often rays at edges and vertices whose triangles face them alike hit none of these, and how often two.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EdgesReport {
    /// Name of the scene.
    pub scene: String,
    /// Rays.
    pub rays: u64,
    /// Rays that were left out: at silhouettes, behind other triangles, or at vertices of too many triangles.
    pub left_out: u64,
    /// The model's adaptive test, with owned edges.
    pub model: Counts,
    /// Embree with its flag for robust intersection.
    pub embree_robust: Counts,
    /// Embree by default.
    pub embree_fast: Counts,
}

/// For each triangle its scene, none for those for which there is none.
fn scenes(place: &Place) -> Vec<Option<usize>> {
    let surface = &place.surface;
    let mut scenes: Vec<Option<usize>> = vec![None; surface.triangles.len()];
    for (number, corners) in surface.triangles.iter().enumerate() {
        let mut taken = [false; MOST_SCENES];
        for &other in corners.iter().flat_map(|&vertex| surface.around(vertex)) {
            if let Some(scene) = scenes[other as usize] {
                taken[scene] = true;
            }
        }
        scenes[number] = taken.iter().position(|taken| !taken);
    }
    scenes
}

/// Asks the model and Embree.
///
/// # Errors
/// If Embree does not answer.
pub fn hits_at_edges(
    place: &Place,
    rays: u64,
    seed: u64,
    embree: &Embree,
) -> Result<EdgesReport, EmbreeError> {
    let scenes = scenes(place);
    let surface = &place.surface;
    let places = std::slice::from_ref(place);
    let asked: Vec<Case> =
        (0..rays).filter_map(|number| case(SurfaceSuite::ExactlyOne, places, seed, number)).collect();
    let can_be_asked = |case: &&Case| {
        let mut taken: Vec<_> = case.triangles.iter().map(|&triangle| scenes[triangle as usize]).collect();
        taken.sort_unstable();
        let all = taken.len();
        taken.dedup();
        matches!(case.truth, Crossings::Exactly(_)) && taken.len() == all && !taken.contains(&None)
    };
    let cases: Vec<&Case> = asked.iter().filter(can_be_asked).collect();
    // Of each case, hits by either flag; none where another triangle is in front.
    let mut hits: Vec<[Option<u32>; 2]> = vec![[Some(0); 2]; cases.len()];
    for scene in 0..MOST_SCENES {
        let members: Vec<u32> = (0..surface.triangles.len() as u32)
            .filter(|&number| scenes[number as usize] == Some(scene))
            .collect();
        let in_scene = |case: &Case| {
            case.triangles.iter().copied().find(|&number| scenes[number as usize] == Some(scene))
        };
        let meant: Vec<(usize, u32)> =
            cases.iter().enumerate().filter_map(|(place, case)| Some((place, in_scene(case)?))).collect();
        if meant.is_empty() {
            continue;
        }
        let corners: Vec<_> = members.iter().map(|&number| surface.corners(number)).collect();
        let rays: Vec<Ray> = meant.iter().map(|&(place, _)| Ray { t_min: 0.0, ..cases[place].ray }).collect();
        let answers = embree.intersect(&corners, &rays)?;
        for (answers, flag) in [answers.robust, answers.fast].into_iter().zip(0..) {
            for (&(place, triangle), answer) in meant.iter().zip(answers) {
                let hit = answer.map(|Hit { triangle, .. }| members[triangle as usize]);
                let sum = &mut hits[place][flag];
                *sum = match hit {
                    None => *sum,
                    Some(hit) if hit == triangle => sum.map(|sum| sum + 1),
                    Some(_) => None,
                };
            }
        }
    }
    let adaptive = Contestant { kernel: Kernel::Adaptive, format: Format::F32 };
    let model = counter(adaptive, Edges::Owned, surface);
    let mut report = EdgesReport { scene: place.name.clone(), rays, ..EdgesReport::default() };
    for (case, hits) in cases.iter().zip(hits) {
        let [Some(robust), Some(fast)] = hits else { continue };
        report.model += Counts::of(case.truth, model(&case.ray, &case.triangles));
        report.embree_robust += Counts::of(case.truth, robust);
        report.embree_fast += Counts::of(case.truth, fast);
    }
    report.left_out = rays - report.model.cases;
    Ok(report)
}
