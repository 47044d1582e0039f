//! Every theorem, by the engines that run everywhere: a test a group and engine.

use saarcor_proofs::engines::{Judgement, Random};
use saarcor_proofs::theorem::Theorem;
use saarcor_proofs::theorems;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

fn all_hold(group: &str, failed_before: &AtomicBool, engine: impl Fn(&Theorem) -> Judgement) {
    // One failure, or the judgement of some theorems, is enough for whoever plants faults.
    let first_alone = std::env::var_os("SAARCOR_FIRST_FAILURE").is_some();
    let some = std::env::var("SAARCOR_THEOREM").ok();
    let mut failed = Vec::new();
    for theorem in theorems().filter(|theorem| group_of(theorem) == group) {
        if some.as_deref().is_some_and(|some| some.split(',').all(|name| name != theorem.name)) {
            continue;
        }
        if first_alone && failed_before.load(Ordering::Relaxed) {
            break;
        }
        let judgement = engine(theorem);
        let Judgement { cases, vacuous, .. } = judgement;
        println!("{cases:>10} cases, {vacuous:>9} vacuous  {}", theorem.name);
        if let Some(case) = judgement.counterexample {
            failed.push(format!("{} ({}): {}\n    {case}", theorem.name, theorem.requirement, theorem.says));
            failed_before.store(true, Ordering::Relaxed);
        }
    }
    assert!(failed.is_empty(), "{} theorems do not hold:\n{}", failed.len(), failed.join("\n"));
}

/// The folder of a theorem's file.
fn group_of(theorem: &Theorem) -> &'static str {
    let unit = theorem.unit();
    unit.split_once("::").map_or(unit, |(group, _)| group)
}

macro_rules! engine {
    ($name:ident, $judge:expr, $($group:ident)+) => {
        mod $name {
            use super::*;

            /// Whether a theorem of any group did not hold.
            static FAILED: AtomicBool = AtomicBool::new(false);

            $(#[test]
            fn $group() {
                all_hold(stringify!($group), &FAILED, $judge);
            })+

            #[test]
            fn every_group_is_judged() {
                let groups: BTreeSet<_> = theorems().map(group_of).collect();
                let judged = BTreeSet::from([$(stringify!($group)),+]);
                assert!(groups.is_subset(&judged), "{groups:?}, but judged are {judged:?}");
            }
        }
    };
}

engine!(exhaustive, Theorem::judge_exhaustively, vm refinement host rays time equal);
engine!(random, |theorem| theorem.judge_at_random(20_000), vm refinement host rays time equal);

/// The sets that Kani and the exhaustive engine leave out.
#[test]
fn hold_for_wide_sets() {
    let mut failed = Vec::new();
    for &(name, covers, body) in
        saarcor_proofs::vm::set::WIDE.iter().chain(saarcor_proofs::equal::directory::WIDE)
    {
        if let Some(case) = Random::judge(covers, body, 5_000).counterexample {
            failed.push(format!("{name}: {case}"));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
