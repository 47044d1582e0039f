//! Variants of the model, each of which breaks one requirement: chips whose virtual memory replaces or places lines by
//! another rule. With several threads the counts and the cycles alone do not tell such a fault from one in time.

use super::config::{self, Setting};
use super::oracle::ChipOracle;
use super::request::{Answer, Observes, Request};
use crate::kind::Oracle;
use crate::vm::config::{HASHES, POLICIES};

/// The requirements that a single variant has to break to give all of these answers to requests.
pub(super) fn explanations<'a>(
    setting: &Setting,
    observes: Observes,
    exchanges: impl Iterator<Item = (&'a [u8], &'a [u8])> + Clone,
) -> Vec<&'static str> {
    let policies = POLICIES.iter().map(|&(_, policy)| {
        let mut variant = setting.clone();
        variant.chip.cache.policy = policy;
        ("VM-6", variant)
    });
    let hashes = HASHES.iter().map(|&(_, hash)| {
        let mut variant = setting.clone();
        variant.chip.cache.hash = hash;
        ("VM-3", variant)
    });
    let others = policies.chain(hashes).filter(|(_, variant)| variant != setting);
    others
        .filter(|(_, variant)| answers(variant, observes, exchanges.clone()))
        .map(|(requirement, _)| requirement)
        .collect()
}

/// Whether a chip gives these answers to requests, as far as they are observed.
fn answers<'a>(
    setting: &Setting,
    observes: Observes,
    mut exchanges: impl Iterator<Item = (&'a [u8], &'a [u8])>,
) -> bool {
    let Ok(mut chip) = ChipOracle::new(Oracle::Model, &config::text(setting)) else { return false };
    exchanges.all(|(request, answer)| match Request::parse(request) {
        Ok(Request::Run) => {
            let own = Answer::of(&chip.play(&mut ()));
            Answer::parse(answer, observes).is_ok_and(|got| got == own.as_observed(observes))
        }
        Ok(other) => {
            chip.change(other);
            true
        }
        Err(_) => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chip::Chip;
    use crate::kind::Kind as _;

    /// A chip of several threads that answers as one with another policy breaks VM-6, and one that answers as no
    /// variant does breaks what its session says.
    #[test]
    fn answers_name_the_rule_that_gives_them() {
        let config = |policy: &str| format!("lines=4 ways=4 line=128 policy={policy}");
        // Four lines fill the memory, the first is used again past the first level, and a fifth evicts one.
        let text = "p n,0,8,1 n,80,8,1 n,100,8,1 n,180,8,1 s,0,8,1 n,200,8,1 l,0,8,1";
        let answer = |policy: &str| {
            let mut chip = Chip.oracle(Oracle::Model, &config(policy)).expect("a chip");
            let mut answer = Vec::new();
            for request in [text, "run"] {
                answer.clear();
                chip.answer(request.as_bytes(), &mut answer).expect("an answer");
            }
            answer
        };
        let explained = |answer: &[u8]| {
            let setting = config::parse(&config("lru")).expect("a chip");
            let exchanges = [(text.as_bytes(), &b"ok"[..]), (b"run", answer)];
            explanations(&setting, Observes::ALL, exchanges.into_iter())
        };
        assert_ne!(answer("fifo"), answer("lru"));
        assert!(explained(&answer("fifo")).contains(&"VM-6"));
        let late = answer("lru");
        assert!(explained(&[&b"c f"[..], &late[2..]].concat()).is_empty());
    }
}
