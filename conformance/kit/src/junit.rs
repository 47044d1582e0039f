//! The report as JUnit XML.
//!
//! It is valid by both schemas that CI systems' readers follow: `junit-10.xsd` of Jenkins' xUnit plugin,
//! and `JUnit.xsd` of Ant's tasks (Windy Road), which asks for more in each suite and for less at the root.

use crate::error::Error;
use crate::report::{ConformanceReport, ConformanceVerdict};
use chrono::{DateTime, Utc};
use quick_junit::{NonSuccessKind, Property, Report as JunitReport, TestCase, TestCaseStatus, TestSuite};
use std::time::{Duration, SystemTime};

/// The row of the sessions that are timed, by [`ConformanceReport::random_seconds`].
const TIMED: &str = "random";
/// The suite of a run that cannot be judged.
const WHOLE: &str = "verdict";

impl ConformanceReport {
    /// The report as JUnit XML, of a run at that time: a suite for each requirement, with a case for its
    /// sessions together, and one for each failure; where the verdict is incomplete, a suite with
    /// an error. Only the random sessions are timed.
    ///
    /// # Errors
    /// Never, but for a failure of the library that writes it.
    pub fn junit(&self, at: SystemTime) -> Result<String, Error> {
        let mut suites: Vec<TestSuite> = Vec::new();
        for row in &self.requirements {
            let seconds = if row.requirement == TIMED { self.random_seconds } else { 0.0 };
            let mut cases = Vec::new();
            let failures = self.failures.iter().filter(|failure| failure.row == row.requirement);
            for failure in failures {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_type(failure.level.name()).set_message(&failure.says);
                status.set_description(failure.text());
                cases.push(TestCase::new(failure.session.as_str(), status));
            }
            let rest = row.sessions.saturating_sub(cases.len());
            if rest > 0 {
                let failed = row.failed.saturating_sub(cases.len());
                let mut status = TestCaseStatus::success();
                if failed > 0 {
                    status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                    let says = format!("{failed} of {rest} further sessions fail");
                    status.set_type("sessions").set_message(says);
                }
                cases.push(TestCase::new(format!("{rest} sessions"), status));
            }
            suites.push(self.suite(&row.requirement, cases, seconds));
        }
        if self.verdict == ConformanceVerdict::Incomplete {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
            let why = self.stopped.as_deref().unwrap_or("no level above the protocol could be judged");
            status.set_type(ConformanceVerdict::Incomplete.text()).set_message(why);
            suites.push(self.suite(WHOLE, vec![TestCase::new(WHOLE, status)], 0.0));
        }
        let at = DateTime::<Utc>::from(at).format("%Y-%m-%dT%H:%M:%S").to_string();
        let mut junit = JunitReport::new("");
        for (mut suite, number) in suites.into_iter().zip(0..) {
            for (name, value) in [
                ("package", self.kind.as_str()),
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
        // This attribute is in neither.
        let suites = text[end..].replace(" disabled=\"0\"", "");
        Ok(format!("{}<testsuites{close}{suites}", &text[..begin]))
    }

    /// A suite with all that a schema asks for.
    fn suite(&self, row: &str, cases: Vec<TestCase>, seconds: f64) -> TestSuite {
        let name = format!("{}.{row}", self.kind);
        let time = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        let mut suite = TestSuite::new(name.as_str());
        suite.set_time(time).set_system_out("").set_system_err("");
        suite.add_property(Property::new("dut", self.dut.as_str()));
        suite.add_property(Property::new("headline", self.headline()));
        let time = time / u32::try_from(cases.len()).unwrap_or(1).max(1);
        for mut case in cases {
            case.set_classname(name.as_str()).set_time(time);
            suite.add_test_case(case);
        }
        suite
    }
}
