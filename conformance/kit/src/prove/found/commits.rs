//! When a request changes the state of an implementation, as a simulation shows it.

use super::samples::{Samples, has_value};
use super::{CONTROL_WIDTH, Commit, cells};
use serde_json::Value;
use std::collections::BTreeSet;

/// The narrow wires of an implementation, which may say when a request changes the state.
#[must_use]
pub(in crate::prove) fn commit_wires(netlist: &Value, top: &str) -> Vec<(String, usize)> {
    let mut seen = BTreeSet::new();
    cells::wires_of_dut(&netlist["modules"][top])
        .filter(|(_, bits)| bits.as_array().is_some_and(|bits| (1..=CONTROL_WIDTH).contains(&bits.len())))
        .filter(|(_, bits)| seen.insert(bits.to_string()))
        .map(|(name, bits)| (name.to_owned(), bits.as_array().map_or(0, Vec::len)))
        .collect()
}

/// What may say when a request changes the state: in a simulation in which each request does so at once, each request is
/// followed by one clock in which a wire has that value before it is answered.
pub(in crate::prove) fn commits(
    samples: &Samples,
    outstanding: u32,
    wires: &[(String, usize)],
) -> Vec<Commit> {
    let mut seen = BTreeSet::new();
    let mut commits = Vec::new();
    // Wires of one bit first.
    for width in 1..=CONTROL_WIDTH {
        for (wire, _) in wires.iter().filter(|(_, own)| *own == width) {
            for value in (0..1_u64 << width).rev() {
                let steps = steps(samples, outstanding, &has_value(&samples.bits(wire, 0..width), value));
                if steps.is_some_and(|steps| seen.insert(steps)) {
                    commits.push(Commit { wire: wire.clone(), width, value });
                }
            }
        }
    }
    commits
}

/// The clocks in which requests change the state, if a wire says so; none where it cannot be that.
fn steps(samples: &Samples, outstanding: u32, wire: &[u64]) -> Option<Vec<u64>> {
    let word = |name: &str, clock: usize| samples.of(name, 0).get(clock).copied().unwrap_or_default();
    let mut steps = vec![0; wire.len()];
    for run in 0..64 {
        let (mut waits, mut known) = (0, 0);
        for (clock, step) in steps.iter_mut().enumerate() {
            let is = |word: u64| word >> run & 1 == 1;
            if is(word("reset", clock)) {
                (waits, known) = (0, 0);
                continue;
            }
            if is(word("answered", clock)) {
                known = if known == 0 { return None } else { known - 1 };
            }
            if is(wire[clock]) && waits > 0 {
                (waits, known) = (waits - 1, known + 1);
                *step |= 1 << run;
            }
            waits += u32::from(is(word("accepted", clock)));
            // The harness keeps one request that waits.
            if waits > 1 || waits + known > outstanding {
                return None;
            }
        }
    }
    Some(steps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn samples(wires: &[(&str, &[u64])]) -> Samples {
        let mut all: BTreeMap<(String, usize), Vec<u64>> =
            wires.iter().map(|(name, words)| (((*name).to_owned(), 0), words.to_vec())).collect();
        all.entry(("reset".to_owned(), 0)).or_insert(vec![0; wires[0].1.len()]);
        Samples(all)
    }

    /// A request is taken in clock 0, changes the state in clock 1 and is answered in clock 2, in one run.
    #[test]
    fn a_request_changes_the_state_once_before_its_answer() {
        let of = |commit: &[u64]| {
            let samples =
                samples(&[("accepted", &[1, 0, 0, 0]), ("answered", &[0, 0, 1, 0]), ("commit", commit)]);
            commits(&samples, 1, &[("commit".to_owned(), 1)]).iter().any(|commit| commit.value == 1)
        };
        assert!(of(&[0, 1, 0, 0]));
        // With no request it may be set.
        assert!(of(&[1, 1, 0, 1]));
        assert!(!of(&[1, 0, 1, 0]) && !of(&[0, 0, 0, 1]));
    }
}
