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
