//! The report on all sessions of a run.

use crate::coverage::CoverageCount;
use crate::dut::Timeout;
use crate::execution::{Run, SessionResult};
use crate::level::Level;
use crate::report::{
    ConformanceReport, ConformanceVerdict, Failure, LevelResult, LevelVerdict, RequirementResult,
    SCHEMA_VERSION, UnsupportedKey,
};

/// What a report is made of.
pub(crate) struct Summary<'a> {
    /// The implementation, as it was named.
    pub name: &'a str,
    pub run: &'a Run<'a>,
    pub results: &'a [SessionResult],
}

impl Summary<'_> {
    pub fn report(
        &self,
        failures: Vec<Failure>,
        stopped: Option<String>,
        random_seconds: f64,
    ) -> ConformanceReport {
        let levels = self.levels();
        let passed = |level: &&LevelResult| level.verdict == LevelVerdict::Passed;
        let before_failed = levels.iter().take_while(|level| level.verdict != LevelVerdict::Failed);
        let highest = before_failed.filter(passed).map(|level| level.level).last();
        let errors = self.results.iter().filter(|result| !result.findings.is_empty()).count();
        let at_asked = levels.iter().find(|level| Some(level.level) == self.run.options.level);
        let slow = self.results.iter().any(|result| result.timeout == Some(Timeout::Slow));
        let judged = self.results.iter().any(|result| result.unsupported.is_none());
        let passed = at_asked.is_none_or(|level| level.verdict == LevelVerdict::Passed);
        let decided = judged && !slow && passed;
        let decided = decided && highest.is_some_and(|highest| highest > Level::Protocol);
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
            verdict,
            highest,
            asked: self.run.options.level,
            tolerance: self.run.options.tolerance,
            levels,
            requirements: self.requirements(),
            failures,
            unsupported: self.unsupported(),
            coverage: self.coverage(),
            sessions: self.results.len(),
            errors,
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

    fn levels(&self) -> Vec<LevelResult> {
        let lowest_failed =
            self.results.iter().flat_map(|result| &result.findings).map(|finding| finding.level).min();
        let verdict = |&level: &Level| {
            let verdict = if level > self.run.options.highest() {
                LevelVerdict::NotAsked
            } else if lowest_failed.is_some_and(|failed| failed <= level) {
                LevelVerdict::Failed
            } else if self
                .results
                .iter()
                .any(|result| result.observed.contains(&level) && result.unsupported.is_none())
            {
                LevelVerdict::Passed
            } else {
                LevelVerdict::NotObserved
            };
            LevelResult { level, verdict }
        };
        self.run.kind.levels().iter().map(verdict).collect()
    }

    fn requirements(&self) -> Vec<RequirementResult> {
        let mut rows: Vec<RequirementResult> = Vec::new();
        for result in self.results.iter().filter(|result| result.unsupported.is_none()) {
            let place = rows.iter().position(|row| row.requirement == result.row).unwrap_or_else(|| {
                rows.push(RequirementResult { requirement: result.row.clone(), sessions: 0, failed: 0 });
                rows.len() - 1
            });
            rows[place].sessions += 1;
            rows[place].failed += usize::from(!result.findings.is_empty());
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

    /// What the sessions exercise that ran to their ends.
    fn coverage(&self) -> Vec<CoverageCount> {
        let mut coverage = self.run.kind.coverage();
        for result in self.results {
            if result.findings.is_empty() && result.unsupported.is_none() && result.timeout.is_none() {
                coverage.add(&self.run.session(result.place));
            }
        }
        coverage.counts()
    }
}
