//! Rays at edges and vertices hit exactly one triangle by the adaptive test where edges are owned (IS-6), and rays from surfaces
//! begin off them (RG-3).

use saarcor_model::host::{Edges, Kernel};
use saarcor_oracles::surfaces::{Place, SurfaceSuite};
use saarcor_studies::accuracy::contest::{Contestant, Format};
use saarcor_studies::accuracy::exactly_one::{ExactlyOneOptions, ExactlyOneRow, exactly_one};
use saarcor_studies::accuracy::suites::offset_rows;

fn row(suite: SurfaceSuite, places: &[Place], kernel: Kernel, edges: Edges, cases: u64) -> ExactlyOneRow {
    let options = ExactlyOneOptions { seed: 5, cases, edges };
    let contestants = [Contestant { kernel, format: Format::F32 }];
    let rows = exactly_one(suite, places, &contestants, options, &|_| ());
    for row in rows.iter().filter(|row| row.is_exact()) {
        assert_eq!(row.others, 0, "{row:?}");
        assert!(row.looked >= cases.min(10_000) / 8, "{row:?}");
    }
    // The specification comes behind its twin, which is asked all.
    assert_eq!(rows.len(), 1 + usize::from(kernel == Kernel::Adaptive));
    for specified in &rows[1..] {
        assert!(specified.counts.cases > 0 && specified.looked == rows[0].looked, "{specified:?}");
        assert!(edges == Edges::Shared || specified.counts.wrong() == 0, "{specified:?}");
    }
    rows.into_iter().next().expect("a row")
}

/// On closed meshes of all sizes and places: no surface of the suite is spared.
#[test]
fn closed_meshes_are_hit_once() {
    let suite = SurfaceSuite::ExactlyOne;
    let places = suite.places();
    let owned = row(suite, &places, Kernel::Adaptive, Edges::Owned, 70_000);
    assert_eq!((owned.counts.cases, owned.counts.wrong(), owned.undecided), (70_000, 0, 0), "{owned:?}");
    let shared = row(suite, &places, Kernel::Adaptive, Edges::Shared, 70_000);
    for (owned, shared) in owned.places.iter().zip(&shared.places) {
        assert!(owned.counts.silhouette > 50, "{owned:?}");
        assert!(shared.counts.two > 200 && shared.counts.none == 0, "{shared:?}");
    }
    // Most rays meet an edge or a vertex exactly.
    let decided = shared.counts.cases - shared.counts.silhouette;
    assert!(shared.counts.two * 2 > decided, "{shared:?}");
    let watertight = row(suite, &places, Kernel::Watertight, Edges::Owned, 70_000);
    let plucker = row(suite, &places, Kernel::Plucker, Edges::Owned, 70_000);
    assert!(watertight.counts.wrong() * 20 < plucker.counts.wrong(), "{watertight:?}, {plucker:?}");
}

/// As in Vulkan's tests of watertightness, and as its specification expects: one ray that hits nothing fails, and so does one that
/// hits two.
#[test]
fn fans_and_grids_are_hit_once() {
    let suite = SurfaceSuite::Watertightness;
    let places = suite.places();
    for place in &places {
        let place = std::slice::from_ref(place);
        for kernel in [Kernel::Adaptive, Kernel::Watertight] {
            let row = row(suite, place, kernel, Edges::Owned, 2048);
            assert_eq!((row.counts.wrong(), row.undecided), (0, 0), "{}: {:?}", place[0].name, row.counts);
        }
    }
}

fn silhouettes_are_hit_evenly(places: &[Place], rays: u64) {
    let row = row(SurfaceSuite::Silhouettes, places, Kernel::Adaptive, Edges::Owned, rays);
    assert_eq!((row.counts.silhouette + row.undecided, row.counts.wrong()), (rays, 0), "{row:?}");
    assert!(row.counts.silhouette * 10 > rays * 8, "{row:?}");
}

#[test]
fn silhouettes_are_hit_an_even_number_of_times_more() {
    silhouettes_are_hit_evenly(&SurfaceSuite::ExactlyOne.places(), 7000);
}

#[test]
#[ignore = "makes three meshes of 10^6 triangles: half a minute"]
fn silhouettes_of_a_million_triangles_are_hit_an_even_number_of_times_more() {
    let places = SurfaceSuite::Silhouettes.places();
    assert!(places.iter().all(|place| place.surface.triangles.len() >= 990_000));
    silhouettes_are_hit_evenly(&places, 30_000);
}

/// With distances within 2u, as those of the adaptive test, no ray hits the surface that it leaves: by the certificate
/// `offset_of_rays_from_surfaces`.
#[test]
fn rays_begin_off_the_surface_that_they_leave() {
    for row in offset_rows(3, 4000) {
        let faults = row.faults;
        let (own, thin) = (faults.self_hits, row.kernel != "adaptive");
        assert!(own == 0 || thin && own * 1000 < faults.rays, "{row:?}");
        assert!(faults.self_hits_without * 4 > faults.rays, "{row:?}");
        // The offset may be higher than a wall is where the ray would meet it.
        assert!(faults.gaps == 0 || row.slope < 0.05 && faults.gaps * 500 < faults.rays, "{row:?}");
    }
}
