//! The engines that run everywhere: every value of a small scope, and values at random.

use crate::scope::Scope;
use crate::source::{Holds, Label, Source, Stop, Value};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::RangeInclusive;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

/// What an engine showed of a theorem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// Whether the theorem holds for all cases, and every cover was reached.
    pub holds: bool,
    /// Sizes and ranges of the values that were drawn.
    pub scope: String,
    /// Cases tried, vacuous ones included.
    pub cases: u64,
    /// Cases that the theorem does not speak of.
    pub vacuous: u64,
    /// How often each of the theorem's covers was reached.
    pub covers: Vec<u64>,
    /// The case for which the theorem does not hold, or what was never reached.
    pub counterexample: Option<String>,
}

/// What both engines note.
#[derive(Clone, Debug, Default)]
struct Notes {
    scope: Scope,
    covers: BTreeMap<&'static str, u64>,
    /// The values of the present case by name, while a counterexample is described.
    case: Option<String>,
}

impl Notes {
    fn cover(&mut self, label: &'static str, reached: bool) {
        if reached {
            *self.covers.entry(label).or_default() += 1;
        }
    }

    fn describe(&mut self, name: &str, value: impl std::fmt::Display) {
        if let Some(case) = &mut self.case {
            let comma = if case.is_empty() { "" } else { ", " };
            let _ = write!(case, "{comma}{name} = {value}");
        }
    }
}

fn judgement(
    labels: &[&'static str],
    [cases, vacuous]: [u64; 2],
    notes: &Notes,
    failed: Option<String>,
) -> Judgement {
    let covers: Vec<_> = labels.iter().map(|label| notes.covers.get(label).copied().unwrap_or(0)).collect();
    let unreached = labels.iter().zip(&covers).find(|(_, count)| **count == 0);
    let undeclared = notes.covers.keys().find(|label| !labels.contains(label));
    let counterexample = failed
        .or_else(|| unreached.map(|(label, _)| format!("never reached: {label}")))
        .or_else(|| undeclared.map(|label| format!("reached, but not declared: {label}")));
    let scope = notes.scope.text();
    Judgement { holds: counterexample.is_none(), scope, cases, vacuous, covers, counterexample }
}

thread_local! {
    /// Whether this thread judges a case: what panics then is said of the case, and not on standard error.
    static JUDGES: Cell<bool> = const { Cell::new(false) };
    /// Where the last such panic was.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Judges a case. Where the model panics, the theorem does not hold.
fn case<E>(body: fn(&mut E) -> Holds, engine: &mut E) -> Holds {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let loud = take_hook();
        set_hook(Box::new(move |panic| {
            if JUDGES.get() {
                PLACE.set(panic.location().map(|place| format!(", {place}")).unwrap_or_default());
            } else {
                loud(panic);
            }
        }));
    });
    JUDGES.set(true);
    let result = catch_unwind(AssertUnwindSafe(|| body(engine)));
    JUDGES.set(false);
    result.unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().map(String::as_str);
        let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or_default();
        Err(Stop::Disproved(format!("it panics: {said}{}", PLACE.take())))
    })
}

/// The exhaustive engine: an odometer whose digits are the values drawn, in their order.
#[derive(Clone, Debug, Default)]
pub struct Exhaustive {
    digits: Vec<Digit>,
    drawn: usize,
    notes: Notes,
}

#[derive(Clone, Copy, Debug)]
struct Digit {
    name: &'static str,
    at: usize,
    len: usize,
}

impl Source for Exhaustive {
    #[inline]
    fn value<T: Value>(&mut self, name: &'static str, full: RangeInclusive<T>, small: &'static [T]) -> T {
        if self.drawn == self.digits.len() {
            assert!(
                small.iter().all(|value| full.contains(value)),
                "{name}: the small scope is a part of the full"
            );
            self.digits.push(Digit { name, at: 0, len: small.len() });
            let nth = self.digits.iter().filter(|digit| digit.name == name).count();
            let ends = [*full.start(), *full.end()].map(Into::into);
            self.notes.scope.try_all(name, ends, small.iter().map(|&value| value.into()), nth);
        }
        let value = small[self.digits[self.drawn].at];
        self.drawn += 1;
        self.notes.describe(name, value);
        value
    }

    fn size(&mut self, name: &'static str, value: usize) {
        self.notes.scope.size(name, value as u64);
    }

    fn cover(&mut self, label: Label, reached: bool) {
        self.notes.cover(label.text, reached);
    }
}

impl Exhaustive {
    /// Tries every case of the body's small scope, up to the first that fails.
    #[must_use]
    pub fn judge(covers: &[&'static str], body: fn(&mut Self) -> Holds) -> Judgement {
        let mut engine = Self::default();
        let (mut cases, mut vacuous) = (0, 0);
        let failed = loop {
            engine.drawn = 0;
            cases += 1;
            match case(body, &mut engine) {
                Ok(()) => {}
                Err(Stop::Vacuous) => vacuous += 1,
                Err(Stop::Disproved(claim)) => {
                    engine.notes.case = Some(String::new());
                    engine.drawn = 0;
                    let _ = case(body, &mut engine);
                    break engine.notes.case.take().map(|case| format!("{claim} (where {case})"));
                }
            }
            if !engine.advance() {
                break None;
            }
        };
        judgement(covers, [cases, vacuous], &engine.notes, failed)
    }

    /// The next case; false after the last.
    fn advance(&mut self) -> bool {
        self.digits.truncate(self.drawn);
        while let Some(last) = self.digits.last_mut() {
            last.at += 1;
            if last.at < last.len {
                return true;
            }
            self.digits.pop();
        }
        false
    }
}

/// The random engine: a tape of random words, which proptest shortens and shrinks.
#[derive(Clone, Debug, Default)]
pub struct Random {
    tape: Vec<u64>,
    drawn: usize,
    notes: Notes,
}

/// Words on a tape; what is drawn beyond its end is the first small value.
const TAPE: usize = 160;

impl Source for Random {
    #[inline]
    fn value<T: Value>(&mut self, name: &'static str, full: RangeInclusive<T>, small: &'static [T]) -> T {
        let word = self.tape.get(self.drawn).copied().unwrap_or(0);
        self.drawn += 1;
        // Small values meet each other more often than values of the whole range do. The rest of
        // the word is taken for a fraction of the range, so that the value shrinks as the word does.
        let (kind, fraction) = (word >> 62, word << 2);
        let of = |span: u128| ((u128::from(fraction) * span) >> 64) as u64;
        let [low, high]: [u64; 2] = [*full.start(), *full.end()].map(Into::into);
        self.notes.scope.draw(name, [low, high]);
        let value = match kind {
            0..3 => small[of(small.len() as u128) as usize],
            _ => T::above(*full.start(), of(u128::from(high - low) + 1)),
        };
        self.notes.describe(name, value);
        value
    }

    fn size(&mut self, name: &'static str, value: usize) {
        self.notes.scope.size(name, value as u64);
    }

    fn cover(&mut self, label: Label, reached: bool) {
        self.notes.cover(label.text, reached);
    }
}

impl Random {
    /// Tries that many cases over the body's full scope, the same in every run; shrinks the first
    /// that fails.
    #[must_use]
    pub fn judge(covers: &[&'static str], body: fn(&mut Self) -> Holds, cases: u32) -> Judgement {
        let config = Config { cases, failure_persistence: None, ..Config::default() };
        let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
        let engine = RefCell::new((Self::default(), [0_u64; 2]));
        let result = TestRunner::new_with_rng(config, rng).run(&tapes(), |tape| {
            let (engine, [cases, vacuous]) = &mut *engine.borrow_mut();
            *cases += 1;
            match engine.play(body, tape) {
                Ok(()) => Ok(()),
                Err(Stop::Vacuous) => {
                    *vacuous += 1;
                    Ok(())
                }
                Err(Stop::Disproved(claim)) => Err(TestCaseError::fail(claim)),
            }
        });
        let (mut engine, counts) = engine.into_inner();
        let failed = match result {
            Ok(()) => None,
            Err(TestError::Fail(_, tape)) => {
                engine.notes.case = Some(String::new());
                let claim = match engine.play(body, tape) {
                    Err(Stop::Disproved(claim)) => claim,
                    _ => "does not fail again".to_owned(),
                };
                engine.notes.case.take().map(|case| format!("{claim} (where {case})"))
            }
            Err(TestError::Abort(reason)) => Some(reason.message().to_owned()),
        };
        judgement(covers, counts, &engine.notes, failed)
    }

    fn play(&mut self, body: fn(&mut Self) -> Holds, tape: Vec<u64>) -> Holds {
        (self.tape, self.drawn) = (tape, 0);
        self.notes.scope.begin();
        case(body, self)
    }
}

fn tapes() -> impl Strategy<Value = Vec<u64>> {
    proptest::collection::vec(any::<u64>(), TAPE)
}
