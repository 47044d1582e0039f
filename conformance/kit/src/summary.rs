//! The report on all sessions of a run.

use crate::coverage::CoverageCount;
use crate::deadline::Deadline;
use crate::dut::Timeout;
use crate::execution::{Run, SessionResult};
use crate::level::Level;
use crate::plan::PlannedSession;
use crate::report::{
    AdmittedAnswers, ConformanceReport, ConformanceVerdict, Failure, LevelResult, LevelVerdict, NotJudged,
    NotJudgedReason, Outcome, RequirementResult, SCHEMA_VERSION, SessionOutcome, UnsupportedKey,
};
use std::collections::BTreeSet;
use std::time::Duration;

/// Time to count what sessions exercise once a verdict is due.
const COVERAGE_TIME: Duration = Duration::from_millis(250);

/// What a report is made of.
pub(crate) struct Summary<'a> {
    /// The implementation, as it was named.
    pub name: &'a str,
    pub run: &'a Run<'a>,
    pub results: &'a [SessionResult],
}

impl Summary<'_> {
    /// The report. What sessions exercise is counted while there is time, where some fail.
    pub fn report(
        &self,
        failures: Vec<Failure>,
        stopped: Option<String>,
        random_seconds: f64,
    ) -> ConformanceReport {
        let levels = self.levels();
        let passed = |level: &&LevelResult| level.verdict == LevelVerdict::Passed;
        let highest = levels.iter().take_while(passed).map(|level| level.level).last();
        let errors = self.results.iter().filter(|result| result.fails()).count();
        let at_asked = levels.iter().find(|level| Some(level.level) == self.run.options.level);
        let slow = self.results.iter().any(|result| result.timeout == Some(Timeout::Slow));
        let judged = self.results.iter().any(|result| result.unsupported.is_none());
        let passed = at_asked.is_none_or(|level| level.verdict == LevelVerdict::Passed);
        // Where all that is asked for is the conversation, that is enough.
        let above = levels.iter().filter(|level| level.level > Level::Protocol);
        let more_is_asked = above.clone().any(|level| level.verdict != LevelVerdict::NotAsked);
        let enough = highest.is_some_and(|highest| highest > Level::Protocol || !more_is_asked);
        let decided = judged && !slow && passed && enough;
        let verdict = match (errors, decided) {
            (0, true) => ConformanceVerdict::Conforms,
            (0, false) => ConformanceVerdict::Incomplete,
            _ => ConformanceVerdict::DoesNotConform,
        };
        let random = || self.results.iter().filter(|result| result.random);
        ConformanceReport {
            schema_version: SCHEMA_VERSION,
            dut: self.name.to_owned(),
            kind: self.run.kind.name().to_owned(),
            protocol: self.run.kind.hello().to_owned(),
            seed: self.run.options.seed,
            verdict,
            highest,
            asked: self.run.options.level,
            tolerance: self.run.options.tolerance,
            not_judged: self.not_judged(&levels),
            levels,
            requirements: self.requirements(),
            failures,
            unsupported: self.unsupported(),
            coverage: self.coverage(errors > 0),
            admitted: self.admitted(),
            outcomes: self.outcomes(),
            sessions: self.results.len(),
            errors,
            waived: self.waived().count(),
            requests: self.results.iter().map(|result| result.answered as u64).sum(),
            random_requests: random().map(|result| result.answered as u64).sum(),
            random_seconds,
            stopped: stopped.or_else(|| {
                slow.then(|| {
                    "sessions reached the time limit: take fewer requests, or a longer limit".to_owned()
                })
            }),
        }
    }

    /// Sessions whose configuration is supported, which had the time to answer, and whose result counts.
    fn held(&self) -> impl Iterator<Item = &SessionResult> {
        let is_held = |result: &&SessionResult| {
            result.unsupported.is_none() && result.timeout.is_none() && result.waived.is_none()
        };
        self.results.iter().filter(is_held)
    }

    /// Answers that are right, though they are not the model's, by requirement.
    fn admitted(&self) -> Vec<AdmittedAnswers> {
        let mut rows: Vec<AdmittedAnswers> = Vec::new();
        for result in self.results {
            for admitted in &result.admitted {
                match rows.iter_mut().find(|row| row.requirement == admitted.requirement) {
                    Some(row) => row.answers += admitted.answers,
                    None => rows.push(AdmittedAnswers {
                        requirement: admitted.requirement.to_owned(),
                        answers: admitted.answers,
                        session: result.name.clone(),
                        asked: admitted.asked.clone(),
                        why: admitted.why.clone(),
                    }),
                }
            }
        }
        rows
    }

    fn waived(&self) -> impl Iterator<Item = &SessionResult> {
        self.results.iter().filter(|result| result.waived.is_some())
    }

    /// What became of each session of the plan.
    fn outcomes(&self) -> Vec<SessionOutcome> {
        let mut results = self.results.iter().peekable();
        let outcome = |(place, planned): (usize, &PlannedSession)| {
            let Some(result) = results.next_if(|result| result.place == place) else {
                return SessionOutcome {
                    session: planned.name(self.run.kind),
                    row: planned.row().to_owned(),
                    config: String::new(),
                    outcome: Outcome::LeftOut,
                    requests: 0,
                    seconds: 0.0,
                    requirement: None,
                    says: String::new(),
                };
            };
            let says = result.lowest().map_or_else(String::new, |finding| finding.says.clone());
            let (outcome, says) = match (&result.waived, &result.unsupported, result.timeout) {
                (Some(reason), ..) => (Outcome::Waived, format!("{says}; waived: {reason}")),
                (None, ..) if result.fails() => (Outcome::Failed, says),
                (None, Some(key), _) => (Outcome::NotSupported, format!("{key} is not supported")),
                (None, None, Some(_)) => (Outcome::OutOfTime, "too little time".to_owned()),
                (None, None, None) => (Outcome::Passed, says),
            };
            SessionOutcome {
                session: result.name.clone(),
                row: result.row.clone(),
                config: result.config.clone(),
                outcome,
                requests: result.answered,
                seconds: result.seconds,
                requirement: result.broken.clone(),
                says,
            }
        };
        self.run.planned.iter().enumerate().map(outcome).collect()
    }

    fn levels(&self) -> Vec<LevelResult> {
        let failing = self.results.iter().filter(|result| result.fails());
        let lowest_failed = failing.flat_map(|result| &result.findings).map(|finding| finding.level).min();
        let mut all_passed = true;
        let mut verdict = |&level: &Level| {
            let about = |result: &&SessionResult| result.level.is_none_or(|own| own >= level);
            let is_observed = |result: &&SessionResult| result.observed.contains(&level);
            let is_judged = |result: &SessionResult| level == Level::Protocol || result.answered > 0;
            let verdict =
                if level > self.run.options.highest() || !self.results.iter().any(|result| about(&result)) {
                    LevelVerdict::NotAsked
                } else if lowest_failed.is_some_and(|failed| failed <= level) {
                    LevelVerdict::Failed
                } else if !self.held().any(|result| is_observed(&result)) {
                    LevelVerdict::NotObserved
                } else if all_passed
                    && self.held().all(|result| is_observed(&result))
                    && self.held().filter(about).any(is_judged)
                {
                    LevelVerdict::Passed
                } else {
                    LevelVerdict::ObservedInPart
                };
            all_passed &= verdict == LevelVerdict::Passed;
            LevelResult { level, verdict }
        };
        self.run.kind.levels().iter().map(&mut verdict).collect()
    }

    /// What was not judged: levels, parts of answers at levels that were passed, configurations, and sessions.
    fn not_judged(&self, levels: &[LevelResult]) -> Vec<NotJudged> {
        let mut all = Vec::new();
        // A level is not judged either where one below it is not observed.
        let mut levels_below = Vec::new();
        // Where no configuration is supported, that says all.
        let is_held = self.held().next().is_some();
        for LevelResult { level, verdict } in levels {
            levels_below.push(*level);
            if is_held && matches!(verdict, LevelVerdict::NotObserved | LevelVerdict::ObservedInPart) {
                let lacks = |result: &SessionResult| {
                    levels_below.iter().any(|level| !result.observed.contains(level))
                };
                // Observed everywhere, but nothing was asked.
                let is_idle = !self.held().any(lacks);
                all.push(self.not_observed(level.name(), |result| is_idle || lacks(result)));
            }
        }
        for (name, of) in self.run.kind.observable() {
            let passed = LevelResult { level: *of, verdict: LevelVerdict::Passed };
            if levels.contains(&passed) && self.held().any(|result| result.unobserved.contains(name)) {
                all.push(self.not_observed(name, |result| result.unobserved.contains(name)));
            }
        }
        for row in self.unsupported() {
            let refuses = |result: &SessionResult| result.unsupported.as_deref() == Some(&row.key);
            let refused = self.results.iter().filter(|result| refuses(result));
            let values: BTreeSet<Value<'_>> =
                refused.map(|result| value_of(&result.config, &row.key)).collect();
            all.push(NotJudged {
                what: row.key.clone(),
                why: NotJudgedReason::NotSupported,
                sessions: row.sessions,
                of: self.results.len(),
                values: values.iter().map(|(_, value)| format!("{}={value}", row.key)).collect(),
            });
        }
        let slow = self.results.iter().filter(|result| result.timeout == Some(Timeout::Slow)).count();
        let left_out = self.run.planned.len() - self.results.len() + slow;
        if left_out > 0 {
            all.push(NotJudged {
                what: "sessions".to_owned(),
                why: NotJudgedReason::LeftOut,
                sessions: left_out,
                of: self.run.planned.len(),
                values: Vec::new(),
            });
        }
        let waived = self.waived().count();
        if waived > 0 {
            all.push(NotJudged {
                what: "sessions".to_owned(),
                why: NotJudgedReason::Waived,
                sessions: waived,
                of: self.run.planned.len(),
                values: Vec::new(),
            });
        }
        all
    }

    /// What is not observed in the sessions that lack it, and the values of a key that tell their configurations from
    /// those of all others, where there is one.
    fn not_observed(&self, what: &str, lacks: impl Fn(&SessionResult) -> bool) -> NotJudged {
        let values = |key: &str, lacking: bool| -> BTreeSet<Value<'_>> {
            let those = self.held().filter(|result| lacks(result) == lacking);
            those.map(|result| value_of(&result.config, key)).collect()
        };
        let keys = self.run.kind.keys();
        let telling = keys.iter().find_map(|key| {
            let (without, with) = (values(key, true), values(key, false));
            let values = without.iter().map(|(_, value)| format!("{key}={value}"));
            (!with.is_empty() && without.is_disjoint(&with)).then(|| values.collect())
        });
        NotJudged {
            what: what.to_owned(),
            why: NotJudgedReason::NotObserved,
            sessions: self.held().filter(|result| lacks(result)).count(),
            of: self.held().count(),
            values: telling.unwrap_or_default(),
        }
    }

    fn requirements(&self) -> Vec<RequirementResult> {
        let mut rows: Vec<RequirementResult> = Vec::new();
        for result in self.results.iter().filter(|result| result.unsupported.is_none()) {
            let place = rows.iter().position(|row| row.requirement == result.row).unwrap_or_else(|| {
                rows.push(RequirementResult { requirement: result.row.clone(), sessions: 0, failed: 0 });
                rows.len() - 1
            });
            rows[place].sessions += 1;
            rows[place].failed += usize::from(result.fails());
        }
        rows
    }

    fn unsupported(&self) -> Vec<UnsupportedKey> {
        let mut rows: Vec<UnsupportedKey> = Vec::new();
        for key in self.results.iter().filter_map(|result| result.unsupported.as_deref()) {
            match rows.iter_mut().find(|row| row.key == key) {
                Some(row) => row.sessions += 1,
                None => rows.push(UnsupportedKey { key: key.to_owned(), sessions: 1 }),
            }
        }
        rows.sort_unstable_by(|a, b| a.key.cmp(&b.key));
        rows
    }

    /// What the sessions exercise that ran to their ends; where a verdict is due, of those for which there is time.
    fn coverage(&self, is_due: bool) -> Vec<CoverageCount> {
        let mut coverage = self.run.kind.coverage();
        let deadline = Deadline::never();
        if is_due && self.run.dut.time_limit().is_some() {
            deadline.within(COVERAGE_TIME);
        }
        for result in self.results {
            if deadline.has_come() {
                break;
            }
            if result.findings.is_empty() && result.unsupported.is_none() && result.timeout.is_none() {
                coverage.add(&self.run.session(result.place));
            }
        }
        coverage.counts()
    }
}

/// A value of a key, with the number that it is, by which it is ordered.
type Value<'a> = (Option<u64>, &'a str);

/// The value of a key in a configuration; `default` where it is left out.
fn value_of<'a>(config: &'a str, key: &str) -> Value<'a> {
    let mut values = config.split_ascii_whitespace().filter_map(|word| word.split_once('='));
    let value = values.rfind(|(other, _)| *other == key).map_or("default", |(_, value)| value);
    (value.parse().ok(), value)
}
