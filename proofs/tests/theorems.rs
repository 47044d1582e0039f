//! Every theorem, by the engines that run everywhere: a test a unit.

use saarcor_proofs::engines::{Exhaustive, Random, Report};
use saarcor_proofs::source::Theorem;
use saarcor_proofs::theorems;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

fn all_hold(unit: &str, failed_before: &AtomicBool, engine: impl Fn(&Theorem) -> Report) {
    // One failure is enough for whoever plants faults.
    let first_alone = std::env::var_os("SAARCOR_FIRST_FAILURE").is_some();
    let mut failed = Vec::new();
    for theorem in theorems().filter(|theorem| theorem.unit == unit) {
        if first_alone && failed_before.load(Ordering::Relaxed) {
            break;
        }
        let report = engine(theorem);
        println!("{:>10} cases, {:>9} vacuous  {}", report.cases, report.vacuous, theorem.name);
        if let Some(case) = report.counterexample {
            failed.push(format!("{} ({}): {}\n    {case}", theorem.name, theorem.requirement, theorem.says));
            failed_before.store(true, Ordering::Relaxed);
        }
    }
    assert!(failed.is_empty(), "{} theorems do not hold:\n{}", failed.len(), failed.join("\n"));
}

macro_rules! engine {
    ($name:ident, $judge:expr, $($unit:ident)+) => {
        mod $name {
            use super::*;

            /// Whether a theorem of any unit did not hold.
            static FAILED: AtomicBool = AtomicBool::new(false);

            $(#[test]
            fn $unit() {
                all_hold(stringify!($unit), &FAILED, $judge);
            })+

            #[test]
            fn every_unit_is_judged() {
                let units: BTreeSet<_> = theorems().map(|theorem| theorem.unit).collect();
                assert_eq!(units, BTreeSet::from([$(stringify!($unit)),+]));
            }
        }
    };
}

engine!(exhaustive, Exhaustive::judge, geometry metadata hash set vm data_set metadata_cache l1 kdtree traversal);
engine!(random, |theorem| Random::judge(theorem, 20_000), geometry metadata hash set vm data_set metadata_cache l1 kdtree traversal);

/// The sets that Kani and the exhaustive engine leave out.
#[test]
fn hold_for_wide_sets() {
    let mut failed = Vec::new();
    for &(name, covers, body) in saarcor_proofs::set::WIDE {
        if let Some(case) = Random::judge_body(covers, body, 5_000).counterexample {
            failed.push(format!("{name}: {case}"));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
