//! The hard cases of `accuracy` as sessions of `saarcor-kd`.

use saarcor_kit::kd::Kd;
use saarcor_kit::kd::generated_scene::GeneratedScene;
use saarcor_kit::session::Session;
use saarcor_random::Random;
use saarcor_studies::accuracy::suites::{SUITES, Suite};

/// Cases of a session: each is a scene and two rays.
const CASES: u64 = 100;

/// What the names of these sessions begin with; the name of a suite follows.
pub const PREFIX: &str = "kd/hard/";

/// The tests that the cases are held with: the standard one, within its bound, and the exact one.
const CONFIGS: [&str; 2] = ["kernel=moller-trumbore", "kernel=adaptive"];

/// Each suite with each test.
#[must_use]
pub fn all(seed: u64) -> Vec<Session> {
    SUITES.iter().flat_map(|suite| of_suite(suite, seed)).collect()
}

/// The sessions of one suite, or one of them, by a name such as `kd/hard/vertex`; none where there is no
/// such suite.
#[must_use]
pub fn named(name: &str, seed: u64) -> Vec<Session> {
    let suite = name.strip_prefix(PREFIX).and_then(|rest| rest.split('@').next()).and_then(Suite::named);
    let sessions = suite.into_iter().flat_map(|suite| of_suite(suite, seed));
    sessions.filter(|session| session.name == name || !name.contains('@')).collect()
}

fn of_suite(suite: &Suite, seed: u64) -> Vec<Session> {
    let case = |number: u64| {
        let case = suite.case(seed, number);
        (GeneratedScene::new(&case.triangles, &mut Random::new(number)), case.ray)
    };
    let cases: Vec<_> = (0..CASES).map(case).collect();
    let session = |config: &str| {
        let name = format!("{PREFIX}{}@{config}", suite.name);
        let mut session = Kd.session_of_cases(&name, config, &cases);
        session.idea = format!("{}.", suite.idea);
        session
    };
    CONFIGS.map(session).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_kit::dut::InProcess;
    use saarcor_kit::kind::{Kind as _, Oracle};
    use saarcor_kit::plan::{Options, PlannedSession};
    use saarcor_kit::report::ConformanceVerdict;
    use saarcor_kit::run::run;

    /// Exact answers are right within every bound, and the model's are.
    #[test]
    fn hard_cases_are_legal_and_the_oracles_pass_them() {
        let sessions = all(3);
        for session in &sessions {
            Kd.check(session).expect(&session.name);
        }
        let planned: Vec<_> =
            sessions.into_iter().map(|session| PlannedSession::Directed(Box::new(session))).collect();
        for oracle in [Oracle::Model, Oracle::Naive] {
            let dut = InProcess::oracle(oracle);
            let report = run("oracle", &dut, &Kd, &planned, &Options::default(), &|_| ()).expect("it runs");
            let failures: Vec<_> = report.failures.iter().map(|failure| failure.text()).collect();
            assert_eq!(report.verdict, ConformanceVerdict::Conforms, "{oracle:?} {}", failures.join("\n"));
        }
    }
}
