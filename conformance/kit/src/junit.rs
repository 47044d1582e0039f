//! The report as JUnit XML.
//!
//! It is valid by both schemas that CI systems' readers follow: `junit-10.xsd` of Jenkins' xUnit plugin,
//! and `JUnit.xsd` of Ant's tasks (Windy Road), which asks for more in each suite and for less at the root.

use crate::error::Error;
#[cfg(unix)]
use crate::prove::report::{ProofReport, ProofVerdict};
use crate::report::{ConformanceReport, ConformanceVerdict, Failure, Outcome, SessionOutcome};
use chrono::{DateTime, Utc};
use quick_junit::{NonSuccessKind, Property, Report as JunitReport, TestCase, TestCaseStatus, TestSuite};
use std::time::{Duration, SystemTime};

/// The suite of a run that cannot be judged.
const WHOLE: &str = "verdict";

impl ConformanceReport {
    /// The report as JUnit XML, of a run at that time: a suite for each requirement, with a case for each of its
    /// sessions, by its name, with its time; a session that was not judged is skipped, and so is one whose failure is
    /// waived. Where the verdict is incomplete, a suite with an error comes last.
    ///
    /// # Errors
    /// Never, but for a failure of the library that writes it.
    pub fn junit(&self, at: SystemTime) -> Result<String, Error> {
        let mut rows: Vec<(&str, Vec<TestCase>, f64)> = Vec::new();
        for outcome in &self.outcomes {
            let place = rows.iter().position(|(row, ..)| *row == outcome.row).unwrap_or_else(|| {
                rows.push((&outcome.row, Vec::new(), 0.0));
                rows.len() - 1
            });
            let (_, cases, seconds) = &mut rows[place];
            // The same session may have been asked for twice.
            let same = cases.iter().filter(|case| is_named(case.name.as_str(), &outcome.session)).count();
            let number = if same > 0 { format!(" ({})", same + 1) } else { String::new() };
            cases.push(self.case(outcome, &number));
            *seconds += outcome.seconds;
        }
        let heading = Heading { kind: &self.kind, dut: &self.dut, headline: &self.headline() };
        let mut suites: Vec<TestSuite> =
            rows.into_iter().map(|(row, cases, seconds)| heading.suite(row, cases, seconds)).collect();
        if self.verdict == ConformanceVerdict::Incomplete {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
            let why = self.stopped.as_deref().unwrap_or("no level above the protocol could be judged");
            status.set_type(ConformanceVerdict::Incomplete.text()).set_message(legal(why));
            suites.push(heading.suite(WHOLE, vec![TestCase::new(WHOLE, status)], 0.0));
        }
        heading.written(suites, at)
    }

    /// The case of a session.
    fn case(&self, outcome: &SessionOutcome, number: &str) -> TestCase {
        let name = legal(&format!("{}{number}", outcome.session));
        let status = match outcome.outcome {
            Outcome::Passed => TestCaseStatus::success(),
            Outcome::Failed => {
                let shrunk = self.failures.iter().find(|failure| failure.session == outcome.session);
                let level = shrunk.map_or("session", |failure| failure.level.name());
                let requirement = outcome.requirement.as_deref().unwrap_or_default();
                let text = shrunk.map_or_else(|| format!("config {}", outcome.config), Failure::text);
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_type(level).set_message(legal(&format!("{requirement}: {}", outcome.says)));
                status.set_description(legal(&text));
                status
            }
            Outcome::Waived | Outcome::NotSupported | Outcome::OutOfTime | Outcome::LeftOut => {
                TestCaseStatus::skipped()
            }
        };
        let mut case = TestCase::new(name, status);
        case.set_time(Duration::try_from_secs_f64(outcome.seconds).unwrap_or_default());
        case
    }
}

#[cfg(unix)]
impl ProofReport {
    /// The report as JUnit XML, of a run at that time: a suite of what was proved, one of what has to be reached, and one of the
    /// faults that were planted.
    ///
    /// # Errors
    /// Never, but for a failure of the library that writes it.
    pub fn junit(&self, at: SystemTime) -> Result<String, Error> {
        let headline = format!("{}: {}", self.dut, self.verdict.text());
        let heading = Heading { kind: &self.kind, dut: &self.dut, headline: &headline };
        let verdict = match self.verdict {
            ProofVerdict::Proved => TestCaseStatus::success(),
            ProofVerdict::Refuted => {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                let trace = self.trace.clone().unwrap_or_default();
                status.set_type(self.verdict.text()).set_message(legal(&trace.says));
                let requests = trace.requests.iter().map(|request| format!("\n{request}"));
                status.set_description(legal(&format!(
                    "config {}{}",
                    trace.config,
                    String::from_iter(requests)
                )));
                status
            }
            ProofVerdict::NotDecided => {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
                status.set_type(self.verdict.text()).set_message(legal(&self.reason));
                status
            }
        };
        let shown = |name: &str, is_shown: bool| {
            let status = if is_shown {
                TestCaseStatus::success()
            } else {
                TestCaseStatus::non_success(NonSuccessKind::Error)
            };
            TestCase::new(legal(name), status)
        };
        let seconds = self.stages.iter().map(|stage| stage.seconds).sum();
        let mut suites = vec![heading.suite("proof", vec![TestCase::new(WHOLE, verdict)], seconds)];
        let covers = self.covers.iter().map(|(name, clocks)| shown(name, clocks.is_some()));
        suites.push(heading.suite("reached", covers.collect(), 0.0));
        let planted = self.planted.iter().map(|fault| shown(&fault.says, fault.clocks.is_some()));
        suites.push(heading.suite("planted", planted.collect(), 0.0));
        suites.retain(|suite| suite.tests > 0);
        heading.written(suites, at)
    }
}

/// What every suite says of the run.
struct Heading<'a> {
    kind: &'a str,
    dut: &'a str,
    headline: &'a str,
}

impl Heading<'_> {
    /// A suite with all that a schema asks for.
    fn suite(&self, row: &str, cases: Vec<TestCase>, seconds: f64) -> TestSuite {
        let name = legal(&format!("{}.{row}", self.kind));
        let mut suite = TestSuite::new(name.as_str());
        suite.set_time(Duration::try_from_secs_f64(seconds).unwrap_or_default());
        suite.set_system_out("").set_system_err("");
        suite.add_property(Property::new("dut", legal(self.dut)));
        suite.add_property(Property::new("headline", legal(self.headline)));
        for mut case in cases {
            case.set_classname(name.as_str());
            let time = case.time.unwrap_or_default();
            suite.add_test_case(case.set_time(time).clone());
        }
        suite
    }

    /// The suites as a file.
    fn written(&self, suites: Vec<TestSuite>, at: SystemTime) -> Result<String, Error> {
        let at = DateTime::<Utc>::from(at).format("%Y-%m-%dT%H:%M:%S").to_string();
        let mut junit = JunitReport::new("");
        for (mut suite, number) in suites.into_iter().zip(0..) {
            for (name, value) in [
                ("package", self.kind),
                ("id", &number.to_string()),
                ("hostname", "localhost"),
                ("timestamp", &at),
            ] {
                suite.extra.insert(name.into(), value.into());
            }
            junit.add_test_suite(suite);
        }
        let text = junit.to_string()?;
        // The schemas agree in nothing that the root may have.
        let begin = text.find("<testsuites").ok_or("XML without a root element")?;
        let end = begin + text[begin..].find('>').ok_or("XML without the end of its root's tag")?;
        let close = if text[..end].ends_with('/') { "/" } else { "" };
        // Both have another name for this attribute, and ask for none.
        let suites = text[end..].replace(" disabled=\"0\"", "").replace(" disabled=\"", " skipped=\"");
        Ok(format!("{}<testsuites{close}{suites}", &text[..begin]))
    }
}

/// Whether a case has the name of a session, perhaps with a number behind it.
fn is_named(case: &str, session: &str) -> bool {
    let session = legal(session);
    case.strip_prefix(session.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("))
}

/// Text with the characters alone that XML 1.0 has; others as `\\u{1b}`.
fn legal(text: &str) -> String {
    let is_legal = |c: char| matches!(c, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..);
    let mut legal = String::with_capacity(text.len());
    for c in text.chars() {
        if is_legal(c) { legal.push(c) } else { legal.extend(c.escape_unicode()) }
    }
    legal
}
