//! The harness itself: it fails what has to fail.

use saarcor_proofs::engines::Judgement;
use saarcor_proofs::source::{Holds, Label, Source};
use saarcor_proofs::theorem::Theorem;
use saarcor_proofs::{assume, check, cover};

/// A theorem of these covers and bodies.
macro_rules! theorem {
    ([$($cover:literal),*], $body:ident) => {
        Theorem {
            name: "test",
            module: "test",
            file: "test",
            requirement: "VM-1",
            says: "A test.",
            covers: &[$($cover),*],
            not_for_kani: None,
            exhaustive: $body,
            random: $body,
        }
    };
}

fn both(theorem: &Theorem) -> [Judgement; 2] {
    [theorem.judge_exhaustively(), theorem.judge_at_random(2_000)]
}

fn sum_is_small<S: Source>(s: &mut S) -> Holds {
    let a = s.value("a", 0..=u8::MAX, &[0, 1, 2]);
    let b = s.value("b", 0..=u8::MAX, &[0, 1, 2, 3]);
    cover!(s, "even", a % 2 == 0);
    check!(u16::from(a) + u16::from(b) <= 510, "{a} + {b}");
    Ok(())
}

#[test]
fn every_case_of_the_small_scope_is_tried_once() {
    let [exhaustive, random] = both(&theorem!(["even"], sum_is_small));
    assert!(exhaustive.holds && random.holds);
    assert_eq!((exhaustive.cases, exhaustive.vacuous, random.cases), (12, 0, 2_000));
    assert_eq!(exhaustive.covers, [8]);
    assert_eq!(exhaustive.scope, "a 0..=2 of 0..=255, b 0..=3 of 0..=255");
}

fn draws_depend_on_draws<S: Source>(s: &mut S) -> Holds {
    let count = s.value("count", 0..=3, &[0, 1, 2, 3_u8]);
    for _ in 0..count {
        s.value("bit", 0..=1, &[0, 1_u8]);
    }
    assume!(count > 0);
    cover!(s, "three", count == 3);
    Ok(())
}

#[test]
fn scopes_that_depend_on_values_are_tried_whole() {
    let [exhaustive, random] = both(&theorem!(["three"], draws_depend_on_draws));
    assert_eq!((exhaustive.cases, exhaustive.vacuous), (1 + 2 + 4 + 8, 1));
    assert!(exhaustive.holds && random.holds && random.vacuous > 0);
}

#[test]
fn unreached_cover_fails_a_true_theorem() {
    for judgement in both(&theorem!(["even", "odd and even"], sum_is_small)) {
        assert!(!judgement.holds);
        assert_eq!(judgement.counterexample.as_deref(), Some("never reached: odd and even"));
    }
}

#[test]
fn undeclared_cover_fails_a_true_theorem() {
    for judgement in both(&theorem!([], sum_is_small)) {
        assert_eq!(judgement.counterexample.as_deref(), Some("reached, but not declared: even"));
    }
}

fn never_speaks<S: Source>(s: &mut S) -> Holds {
    let a = s.value("a", 0..=u8::MAX, &[0, 1, 2]);
    assume!(u16::from(a) > 255);
    cover!(s, "spoken", true);
    check!(false, "never");
    Ok(())
}

#[test]
fn vacuous_theorem_fails() {
    for judgement in both(&theorem!(["spoken"], never_speaks)) {
        assert_eq!(judgement.cases, judgement.vacuous);
        assert!(!judgement.holds);
    }
}

fn all_are_below_a_hundred<S: Source>(s: &mut S) -> Holds {
    let unused = s.value("unused", 0..=u32::MAX, &[0, 7]);
    let a = s.value("a", 0..=u32::MAX, &[0, 50, 150]);
    cover!(s, "drawn", unused < 8);
    check!(a < 100, "{a} is no less than 100");
    Ok(())
}

#[test]
fn counterexample_is_described_and_shrunk() {
    let [exhaustive, random] = both(&theorem!(["drawn"], all_are_below_a_hundred));
    let case = exhaustive.counterexample.expect("disproved");
    assert_eq!(case, "150 is no less than 100 (where unused = 0, a = 150)");
    let case = random.counterexample.expect("disproved");
    assert_eq!(case, "150 is no less than 100 (where unused = 0, a = 150)");
}

#[test]
fn labels_differ() {
    assert!(Label::new("hit").is(Label::new("hit")) && !Label::new("hit").is(Label::new("miss")));
}

fn panics_at_three<S: Source>(s: &mut S) -> Holds {
    let a = s.value("a", 0..=u32::MAX, &[0, 1, 2, 3]);
    assert!(a < 3, "{a} is too large");
    cover!(s, "small", a < 3);
    Ok(())
}

#[test]
fn a_panic_of_the_model_disproves_a_theorem() {
    for judgement in both(&theorem!(["small"], panics_at_three)) {
        let said = judgement.counterexample.expect("a case for which it panics");
        assert!(said.starts_with("it panics: 3 is too large, proofs/tests/harness.rs:"), "{said}");
        assert!(said.ends_with(" (where a = 3)"), "{said}");
    }
}
