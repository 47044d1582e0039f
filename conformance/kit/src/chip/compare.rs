//! Compares the answers of `saarcor-chip` with the model's.

use super::oracle::ChipOracle;
use super::request::{Answer, Observes, Request};
use crate::comparison::{Comparison, Difference, Expected};
use crate::error::Error;
use crate::kind::Oracle;
use crate::level::Level;
use crate::session::Session;
use saarcor_model::time::{CacheReport, UNIT_NAMES};

/// The comparison of one session.
pub struct ChipComparison {
    observes: Observes,
    expected: Expected<ChipOracle>,
}

/// What is counted: its name, the right number, the implementation's, and the requirement that says it.
type Count = (&'static str, u64, u64, &'static str);

impl ChipComparison {
    /// Compares what `observes` lists.
    ///
    /// # Errors
    /// What is wrong with the list or the configuration.
    pub fn new(session: &Session, observes: &str) -> Result<Self, Error> {
        let model = ChipOracle::new(Oracle::Model, session.config())?;
        Ok(Self { observes: Observes::parse(observes)?, expected: Expected::new(model) })
    }
}

/// What a cache counts.
fn counts(names: [&'static str; 3], right: &CacheReport, got: &CacheReport) -> [Count; 3] {
    [
        // Whether a line is looked up at all depends on the operation or the part.
        (names[0], right.accesses, got.accesses, "CH-7"),
        (names[1], right.misses, got.misses, "CH-9"),
        (names[2], right.merged, got.merged, "CH-10"),
    ]
}

/// What moved, in the order in which one follows from the other.
fn traffic(right: &Answer, got: &Answer) -> Vec<(String, Count)> {
    let mut all = Vec::new();
    for (unit, (right, got)) in right.l1.iter().flatten().zip(got.l1.iter().flatten()).enumerate() {
        let names = ["look-ups", "lines fetched", "look-ups of lines in flight"];
        let of = format!("first-level cache of {}: ", UNIT_NAMES[unit]);
        all.extend(counts(names, right, got).map(|count| (of.clone(), count)));
    }
    if let (Some(right), Some(got)) = (&right.l2, &got.l2) {
        let names = ["parts", "parts whose line is missed", "parts whose line is in flight"];
        all.extend(counts(names, right, got).map(|(name, right, got, requirement)| {
            let requirement = match requirement {
                "CH-7" => "CH-12",
                "CH-9" => "VM-6",
                _ => "CH-14",
            };
            (String::new(), (name, right, got, requirement))
        }));
    }
    if let (Some(right), Some(got)) = (right.pci, got.pci) {
        all.push((String::new(), ("bytes from the host", right, got, "VM-6")));
    }
    if let (Some(right), Some(got)) = (right.mem, got.mem) {
        let names = [
            ("bytes to first-level caches", "SD-1"),
            ("bytes of lines written", "CH-15"),
            ("bytes of metadata read", "CH-17"),
            ("bytes of metadata written back", "CH-17"),
        ];
        let counts = names.iter().zip(right.iter().zip(got));
        all.extend(counts.map(|((name, id), (right, got))| (String::new(), (*name, *right, got, *id))));
    }
    all
}

/// Whether two counts are within so many thousandths of the right one.
fn agree(right: u64, got: u64, tolerance: u32) -> bool {
    u128::from(right.abs_diff(got)) * 1000 <= u128::from(right) * u128::from(tolerance)
}

impl Comparison for ChipComparison {
    fn observed(&self, level: Level) -> bool {
        let Observes { cycles, pci, mem, .. } = self.observes;
        match level {
            Level::Protocol => true,
            Level::Traffic => pci && mem,
            Level::Timing => cycles,
            _ => false,
        }
    }

    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        if self.expected.equals(request, answer)? {
            return Ok(());
        }
        if Request::parse(request)? != Request::Run {
            return Err("'ok' is right".into());
        }
        let right = Answer::parse(self.expected.answer(), Observes::ALL)?;
        let got = Answer::parse(answer, self.observes)?;
        let setting = &self.expected.model.setting;
        // Where threads meet, what moves depends on when, and so it may be off where the cycles may.
        let tolerance = if setting.is_sequential() { 0 } else { setting.tolerance };
        let differs = |(_, (_, right, got, _)): &(String, Count)| !agree(*right, *got, tolerance);
        if let Some((of, (name, right, got, requirement))) =
            traffic(&right, &got).into_iter().find(|count| differs(count))
        {
            let says = format!("{of}{got} {name}; {right} is right");
            found(Difference { level: Level::Traffic, says, requirement });
        }
        if let (Some(right), Some(got)) = (right.cycles, got.cycles)
            && !agree(right, got, setting.tolerance)
        {
            let within = match setting.tolerance {
                0 => String::new(),
                tolerance => format!(", within {tolerance} thousandths"),
            };
            let says = format!("{got} cycles; {right} is right{within}");
            // Which of the rules of time is broken does not show.
            found(Difference { level: Level::Timing, says, requirement: "CH-20" });
        }
        Ok(())
    }

    fn expected(&self) -> &[u8] {
        self.expected.answer()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerance_is_of_the_right_number() {
        assert!(agree(1000, 1020, 20) && agree(1000, 980, 20));
        assert!(!agree(1000, 1021, 20) && !agree(1000, 979, 20) && !agree(0, 1, 100));
        assert!(agree(u64::MAX, u64::MAX, 0) && !agree(u64::MAX, u64::MAX - 1, 0));
    }

    /// The levels at which an answer differs that the model's was made into.
    fn levels(config: &str, wrong: &dyn Fn(Answer) -> String) -> Vec<Level> {
        let packet = b"p n,0,8,1 t,240,24,1";
        let session = Session::new("x", "saarcor-chip 1", config, b"");
        let mut comparison = ChipComparison::new(&session, "cycles,pci,mem,l1,l2").expect("a chip");
        comparison.compare(packet, b"ok", &mut |_| ()).expect("the form is right");
        let right = Answer::of(&comparison.expected.model.play(&mut ()));
        let mut levels = Vec::new();
        let mut found = |difference: Difference| levels.push(difference.level);
        comparison.compare(b"run", wrong(right).as_bytes(), &mut found).expect("the form is right");
        levels
    }

    #[test]
    fn tolerance_is_for_cycles_and_where_threads_meet_for_what_moves() {
        let answer =
            |cycles: u64, pci: u64| format!("c {cycles:x} {pci:x} 40,100,0,0 0/0/0,1/0/1,0/0/0,1/0/1 2/0/2");
        let right = |right: Answer| answer(right.cycles.expect("seen"), 0x100);
        let late = |right: Answer| answer(right.cycles.expect("seen") + 5, 0x100);
        let more = |right: Answer| answer(right.cycles.expect("seen"), 0x104);
        for (config, late_at, more_at) in [
            ("", vec![Level::Timing], vec![Level::Traffic]),
            ("tolerance=20", vec![], vec![]),
            ("pipelines=1 threads=1 tolerance=20", vec![], vec![Level::Traffic]),
        ] {
            assert_eq!(levels(config, &right), []);
            assert_eq!((levels(config, &late), levels(config, &more)), (late_at, more_at), "{config}");
        }
    }
}
