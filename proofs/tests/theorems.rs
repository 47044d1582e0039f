//! Every theorem, by the engines that run everywhere.

use saarcor_proofs::engines::{Exhaustive, Random, Report};
use saarcor_proofs::source::Theorem;
use saarcor_proofs::theorems;

fn all_hold(engine: impl Fn(&Theorem) -> Report) {
    let mut failed = Vec::new();
    for theorem in theorems() {
        let report = engine(theorem);
        println!("{:>10} cases, {:>9} vacuous  {}", report.cases, report.vacuous, theorem.name);
        if let Some(case) = report.counterexample {
            failed.push(format!("{} ({}): {}\n    {case}", theorem.name, theorem.requirement, theorem.says));
            // One is enough for whoever plants faults.
            if std::env::var_os("SAARCOR_FIRST_FAILURE").is_some() {
                break;
            }
        }
    }
    assert!(failed.is_empty(), "{} theorems do not hold:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn hold_in_their_small_scopes() {
    all_hold(Exhaustive::judge);
}

#[test]
fn hold_at_random() {
    all_hold(|theorem| Random::judge(theorem, 20_000));
}

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
