//! Whatever comes in, from a person or from an implementation, nothing panics, and what is accepted
//! is legal: mutated suites, configurations, answers and `dut.toml`.

use saarcor_kit::chip::Chip;
use saarcor_kit::deadline::Deadline;
use saarcor_kit::dut::{Dut, InProcess};
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::kinds::KINDS;
use saarcor_kit::level::Level;
use saarcor_kit::scoreboard::Scoreboard;
use saarcor_kit::scoreboard::check_answers;
use saarcor_kit::server::serve;
use saarcor_kit::session::Session;
use saarcor_kit::target::DutFile;
use saarcor_random::Random;

/// Mutations of each suite by default; `--ignored` takes several times as many.
const MUTATIONS: u64 = 200;

/// Some text with a few of its bytes replaced, left out, doubled or moved.
fn mutated(text: &[u8], random: &mut Random) -> Vec<u8> {
    let mut text = text.to_vec();
    for _ in 0..=random.below(4) {
        let place = random.below(text.len() as u64 + 1) as usize;
        let end = (place + random.below(8) as usize).min(text.len());
        match random.below(5) {
            0 => drop(text.drain(place..end)),
            1 => text.insert(place, random.bits() as u8),
            2 => text.insert(place, random.pick(b" \n#-=,:0f/")),
            3 => {
                let part = text[place..end].to_vec();
                let to = random.below(text.len() as u64 + 1) as usize;
                text.splice(to..to, part);
            }
            _ => text.truncate(if random.percent(5) { place } else { text.len() }),
        }
    }
    text
}

fn suites() -> impl Iterator<Item = (&'static dyn Kind, &'static str)> {
    KINDS.iter().flat_map(|kind| kind.suites().iter().map(|(_, text)| (*kind, *text)))
}

/// What the model answers to a session.
fn answers(session: &[u8]) -> Vec<u8> {
    let mut answers = Vec::new();
    let make = |kind: &dyn Kind, config: &str| kind.oracle(Oracle::Model, config);
    serve(&make, session, &mut answers).expect("memory can be written");
    answers
}

fn suites_and_answers(mutations: u64) {
    let mut random = Random::new(7);
    for (kind, suite) in suites() {
        // The chip has twice as many suites as others, and a run of it begins with caches of megabytes.
        let mutations = if kind.name() == Chip.name() { mutations.div_ceil(20) } else { mutations };
        for _ in 0..mutations {
            let text = mutated(suite.as_bytes(), &mut random);
            // The model as an implementation takes any text.
            answers(&text);
            let Ok(sessions) = Session::parse("fuzz", &String::from_utf8_lossy(&text)) else { continue };
            for session in sessions.iter().filter(|session| kind.check(session).is_ok()) {
                if session.hello() != kind.hello() {
                    continue;
                }
                let right = answers(&session.text());
                let checked = check_answers(kind, session, &right, Level::HIGHEST);
                assert_eq!(checked.findings, [], "{}", String::from_utf8_lossy(&session.text()));
                let wrong = mutated(&right, &mut random);
                for finding in check_answers(kind, session, &wrong, Level::HIGHEST).findings {
                    if let Some(request) = finding.request {
                        kind.state_before(session, request);
                    }
                }
                kind.simpler_configs(session.config());
                kind.simpler_sessions(session).for_each(drop);
                for request in session.requests() {
                    kind.simpler_requests(session, request).for_each(drop);
                }
                let mut scoreboard = Scoreboard::new(kind, session, Level::HIGHEST);
                Dut::converse(
                    &InProcess::oracle(Oracle::Naive),
                    session,
                    &mut scoreboard,
                    &Deadline::never(),
                )
                .expect("it runs");
                assert_eq!(scoreboard.findings(), []);
            }
        }
    }
}

fn dut_files(mutations: u64) {
    let mut random = Random::new(11);
    let file = b"kind = \"saarcor-vm\"\nneeds = [\"cc\"]\nbuild = \"cc\"\ncommand = \"./cache\"\ntime_limit = 1.5\nrequests = 10\n";
    for _ in 0..mutations {
        let text = mutated(file, &mut random);
        if let Ok(file) = DutFile::parse(&String::from_utf8_lossy(&text)) {
            assert!(file.time_limit > 0.0);
        }
    }
}

#[test]
fn mutated_text_never_panics() {
    suites_and_answers(MUTATIONS);
    dut_files(100 * MUTATIONS);
}

#[test]
#[ignore = "takes minutes"]
fn much_mutated_text_never_panics() {
    suites_and_answers(8 * MUTATIONS);
    dut_files(10_000 * MUTATIONS);
}
