//! A suite file and, after a line `answers`, the answers to it.
//!
//! The model takes any requests; a session that is legal is answered by it as is right, and whatever
//! else is answered is judged.
#![no_main]

use libfuzzer_sys::fuzz_target;
use saarcor_kit::kind::{Kind, Oracle};
use saarcor_kit::kinds::KINDS;
use saarcor_kit::level::Level;
use saarcor_kit::scoreboard::check_answers;
use saarcor_kit::server::serve;
use saarcor_kit::session::Session;

const ANSWERS: &str = "\nanswers\n";

fn of_model(requests: &[u8]) -> Vec<u8> {
    let mut answers = Vec::new();
    let make = |kind: &dyn Kind, config: &str| kind.oracle(Oracle::Model, config);
    serve(&make, requests, &mut answers).expect("memory can be written");
    answers
}

fuzz_target!(|input: &[u8]| {
    let input = String::from_utf8_lossy(input);
    let (suite, answers) = input.split_once(ANSWERS).unwrap_or((&input, ""));
    of_model(suite.as_bytes());
    for session in Session::parse("fuzz", suite).unwrap_or_default().iter().take(4) {
        let Some(kind) = KINDS.iter().find(|kind| kind.hello() == session.hello()) else { continue };
        if kind.check(session).is_err() {
            continue;
        }
        assert_eq!(check_answers(*kind, session, &of_model(&session.text()), Level::HIGHEST).findings, []);
        for finding in check_answers(*kind, session, answers.as_bytes(), Level::HIGHEST).findings {
            if let Some(request) = finding.request {
                kind.state_before(session, request);
            }
        }
        kind.simpler_configs(session.config());
        for request in session.requests() {
            kind.simpler_requests(session, request).for_each(drop);
        }
        kind.coverage().add(session);
        let read_back = String::from_utf8(session.to_suite()).expect("text");
        assert!(Session::parse("fuzz", &read_back).is_ok_and(|again| again[0].text() == session.text()));
    }
});
