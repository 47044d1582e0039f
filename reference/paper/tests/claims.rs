//! Verdicts follow from runs: where what a claim speaks of is changed, so is the verdict.

use saarcor_model::vm::{Bytes, Geometry};
use saarcor_paper::alternatives::{ADMITTED, BANKS_8, COLD_FIRST_LEVEL, GRANULE_16};
use saarcor_paper::claims::{Claim, Evidence, Holds, judge};
use saarcor_paper::table2::{How, STANDARD, Setting, StandIn, hot_spots};
use saarcor_studies::monitor::Silent;
use saarcor_studies::simulate::WarmUp;
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};

/// The level of a built-in scene, in which the camera rests after a cut: frames 1 and 2 are the same.
fn level() -> World {
    let mut world = World::open(&WorldOptions::new("pquake3-nlnt"), &Silent).expect("a built-in scene");
    world.path = [0, 150, 150].map(|frame| world.path[frame]).to_vec();
    world
}

/// A claim, of a frame of the level in the place of a scene of the paper.
fn claim(id: &str, of: &str, world: &World, frame: usize, setting: Setting<'_>) -> Claim {
    let trace = TraceOptions { resolution: (64, 48), packet: PacketSize::Rays64, max_bounces: 1 };
    let stand_in = StandIn { scene: "level", real: false, of: Some(of) };
    let how = How { setting, warm_up: WarmUp::ONE, trace: &trace };
    let spots = hot_spots(stand_in, world, &[frame], &how, &Silent).expect("chips");
    let claims = judge(Evidence { spots: &spots, ..Evidence::default() });
    claims.into_iter().find(|claim| claim.id == id).expect("the claim")
}

#[test]
fn cruiser_is_limited_by_a_memory_that_is_slow() {
    let world = level();
    let with_clock = |cycles: u32| {
        claim("limited-by-memory", "Cruiser", &world, 2, &|mut config| {
            // Caches that hold most of what so small a picture reads.
            config.l1.iter_mut().for_each(|cache| cache.sets = 1024);
            config.sdram.cycles_a_clock = cycles;
            config
        })
    };
    let slow = with_clock(20);
    assert_eq!(slow.verdict, Holds::Holds);
    let cause = slow.cause.expect("a run with a faster memory");
    assert!(cause.with_setting > 1.2 * cause.standard, "{cause}");
    assert_eq!(with_clock(2).verdict, Holds::DoesNot, "a memory ten times as fast");
}

#[test]
fn faster_bus_gains_after_a_cut() {
    let world = level();
    let after = |frame| claim("fast-bus", "pQuake3-nlnt", &world, frame, STANDARD);
    let rest = after(2);
    assert_eq!(rest.verdict, Holds::Holds);
    // Its cause is the same frame when nothing is on the card.
    let cause = rest.cause.expect("a run with empty caches");
    assert!(cause.standard < 1.02 && cause.with_setting > 1.1, "{cause}");
    assert_eq!(after(1).verdict, Holds::DoesNot);
}

#[test]
fn longest_line_is_best_where_nothing_is_loaded() {
    let world = level();
    let with_memory = |frame, bytes| {
        claim("best-line", "pQuake3", &world, frame, &|mut config| {
            config.cache.geometry = Geometry::new(Bytes(bytes), Bytes(128), 4).expect("a geometry");
            config
        })
    };
    let rest = with_memory(2, 8 << 20);
    assert_eq!(rest.verdict, Holds::DoesNot);
    assert!(rest.ours.starts_with("4096 B"), "without misses no line costs anything: {}", rest.ours);
    let collide = with_memory(1, 64 << 10);
    assert!(!collide.ours.starts_with("4096 B"), "{}", collide.ours);
}

#[test]
fn each_claim_has_figures_and_a_cause() {
    let world = level();
    let trace = TraceOptions { resolution: (64, 48), packet: PacketSize::Rays64, max_bounces: 1 };
    let how = How { setting: STANDARD, warm_up: WarmUp::ONE, trace: &trace };
    let of = |of| StandIn { scene: "level", real: false, of };
    for scene in [Some("Conference"), Some("Sodahall"), Some("pQuake3"), None] {
        let spots = hot_spots(of(scene), &world, &[1, 2], &how, &Silent).expect("chips");
        let claims = judge(Evidence { spots: &spots, ..Evidence::default() });
        let ids: Vec<_> = claims.iter().map(|claim| claim.id).collect();
        assert!(ids.len() >= 12, "{ids:?}");
        for (place, claim) in claims.iter().enumerate() {
            assert!(!ids[..place].contains(&claim.id), "{}", claim.id);
            assert!(!claim.ours.is_empty() && !claim.paper.is_empty(), "{}", claim.id);
            assert!(claim.cause.is_some(), "{} of {scene:?}", claim.id);
        }
    }
}

#[test]
fn claims_of_table_2_are_judged_with_other_admitted_values() {
    let claim = claim("b-little-slower", "pQuake3", &level(), 1, STANDARD);
    let settings: Vec<_> = claim.admitted.iter().map(|other| other.setting).collect();
    assert_eq!(settings, ADMITTED);
    let figure =
        |setting| claim.admitted.iter().find(|other| other.setting == setting).and_then(|other| other.figure);
    let standard = claim.cause.as_ref().expect("a cause").standard;
    // So small a picture looks up hardly any line twice, so that the policy changes nothing.
    for setting in [GRANULE_16, BANKS_8, COLD_FIRST_LEVEL] {
        assert!(figure(setting).is_some_and(|figure| (figure - standard).abs() > 1e-6), "{setting}");
    }
    assert!(claim.numbers.iter().any(|number| number.starts_with("over 4 admitted settings: B / no VM ")));
}
