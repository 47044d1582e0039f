//! Every theorem, by the engines that run everywhere: a test a group and engine.

use saarcor_proofs::engines::{Judgement, Random};
use saarcor_proofs::evidence::{Evidence, State};
use saarcor_proofs::theorem::Theorem;
use saarcor_proofs::theorems;
use std::collections::BTreeSet;
use std::process::exit;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{LazyLock, Mutex};
use std::time::Duration;

static EVIDENCE: LazyLock<Mutex<Evidence>> =
    LazyLock::new(|| Mutex::new(Evidence::read(&Evidence::workspace()).expect("the evidence")));

/// The theorems of a group that are judged: all. Whoever plants faults may ask for less, and for the quick ones first: with
/// `SAARCOR_THEOREM=NAME,NAME` for those, with `SAARCOR_STALE=1` for those that rest on what was changed since the engine
/// has shown them.
fn asked(group: &str, engine: &str) -> Vec<&'static Theorem> {
    let mut asked: Vec<_> = theorems().filter(|theorem| group_of(theorem) == group).collect();
    if let Ok(names) = std::env::var("SAARCOR_THEOREM") {
        asked.retain(|theorem| names.split(',').any(|name| name == theorem.name));
    }
    if std::env::var_os("SAARCOR_STALE").is_some() {
        let evidence = EVIDENCE.lock().expect("the evidence");
        let seconds = |theorem: &Theorem| evidence.of(theorem, engine).map_or(0.0, |shown| shown.seconds);
        asked.retain(|theorem| evidence.state(theorem, engine) != State::Current);
        asked.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    }
    asked
}

fn all_hold(group: &str, name: &str, engine: impl Fn(&Theorem) -> Judgement) {
    // One failure is enough for whoever plants faults.
    let first_alone = std::env::var_os("SAARCOR_FIRST_FAILURE").is_some();
    let mut failed = Vec::new();
    for theorem in asked(group, name) {
        let judgement = if first_alone { in_time(theorem, name, &engine) } else { engine(theorem) };
        let Judgement { cases, vacuous, .. } = judgement;
        println!("{cases:>10} cases, {vacuous:>9} vacuous  {}", theorem.name);
        if let Some(case) = judgement.counterexample {
            failed.push(format!("{} ({}): {}\n    {case}", theorem.name, theorem.requirement, theorem.says));
            if first_alone {
                eprintln!("{}", failed[0]);
                exit(1);
            }
        }
    }
    assert!(failed.is_empty(), "{} theorems do not hold:\n{}", failed.len(), failed.join("\n"));
}

/// Ends the process where a theorem takes far longer than it did for the evidence: a loop that a fault keeps from
/// its end would take all the time that there is.
fn in_time(theorem: &Theorem, name: &str, engine: impl Fn(&Theorem) -> Judgement) -> Judgement {
    let shown = EVIDENCE.lock().expect("the evidence").of(theorem, name).map_or(0.0, |shown| shown.seconds);
    let limit = Duration::from_secs_f64(20.0 + 20.0 * shown);
    let (done, ended) = mpsc::channel::<()>();
    let said = format!("{}: {name} has no answer within {} s", theorem.name, limit.as_secs());
    std::thread::spawn(move || {
        if ended.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
            eprintln!("{said}");
            exit(1);
        }
    });
    let judgement = engine(theorem);
    drop(done);
    judgement
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

            $(#[test]
            fn $group() {
                all_hold(stringify!($group), stringify!($name), $judge);
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
