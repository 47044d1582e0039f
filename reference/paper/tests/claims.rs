//! Verdicts follow from runs: where what a claim speaks of is changed, so is the verdict.

use saarcor_paper::table2::{HotSpotRuns, STANDARD, Setting, StandIn, hot_spots};
use saarcor_paper::verdicts::{Holds, judge};
use saarcor_studies::monitor::Silent;
use saarcor_studies::trace::{PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};

/// The level of a built-in scene, in which the camera rests after a cut: frames 1 and 2 are the same.
fn level() -> World {
    let mut world = World::open(&WorldOptions::new("pquake3-nlnt"), &Silent).expect("a built-in scene");
    world.path = [0, 150, 150].map(|frame| world.path[frame]).to_vec();
    world
}

/// The verdict on the claim that begins so, of a frame of the level in the place of a scene of the paper.
fn verdict(begin: &str, of: &str, world: &World, frame: usize, setting: Setting<'_>) -> Holds {
    let trace = TraceOptions { resolution: (64, 48), packet: PacketSize::Rays64, max_bounces: 1 };
    let stand_in = StandIn { scene: "level", real: false, of };
    let HotSpotRuns { spots, variations } =
        hot_spots(stand_in, world, &[frame], setting, &trace, &Silent).expect("chips");
    let verdicts = judge(&[], &[], &spots, &variations);
    verdicts.into_iter().find(|verdict| verdict.claim.starts_with(begin)).expect("the claim").verdict
}

#[test]
fn cruiser_is_limited_by_a_memory_that_is_slow() {
    let world = level();
    let with_clock = |cycles: u32| {
        verdict("The Cruiser is limited by the on-board memory", "Cruiser", &world, 2, &|mut config| {
            // Caches that hold most of what so small a picture reads.
            config.l1.iter_mut().for_each(|cache| cache.sets = 1024);
            config.sdram.cycles_a_clock = cycles;
            config
        })
    };
    assert_eq!(with_clock(20), Holds::Holds);
    assert_eq!(with_clock(2), Holds::DoesNot, "a memory ten times as fast");
}

#[test]
fn faster_bus_gains_after_a_cut() {
    let world = level();
    let after =
        |frame| verdict("A bus four times as fast changes nothing", "pQuake3-nlnt", &world, frame, STANDARD);
    assert_eq!(after(2), Holds::Holds);
    assert_eq!(after(1), Holds::DoesNot);
}
