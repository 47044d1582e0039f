//! Cases as small files, to be asked again.

use super::case::{Case, Found, Truth};
use super::contest::Contestant;
use super::measure::{AccuracyRow, Fault};
use super::suites::Suite;
use crate::error::StudyError;
use glam::Vec3;
use saarcor_model::host::Edges;
use saarcor_model::rays::Ray;
use serde::{Deserialize, Serialize};

/// A case with its explanation. A line of JSON; f32 are written so that they read back the same, and
/// an infinite end of the range is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The fault that it shows, and of which contestant.
    pub shows: String,
    origin: [f32; 3],
    direction: [f32; 3],
    t_min: f32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    t_max: Option<f32>,
    triangles: Vec<[[f32; 3]; 3]>,
}

impl Record {
    /// Of a case.
    #[must_use]
    pub fn new(shows: String, case: &Case) -> Self {
        let Case { ray, triangles } = case;
        Self {
            shows,
            origin: ray.origin.to_array(),
            direction: ray.direction.to_array(),
            t_min: ray.t_min,
            t_max: ray.t_max.is_finite().then_some(ray.t_max),
            triangles: triangles.iter().map(|corners| corners.map(Vec3::into)).collect(),
        }
    }

    /// The case again.
    #[must_use]
    pub fn case(&self) -> Case {
        let ray = Ray {
            origin: self.origin.into(),
            direction: self.direction.into(),
            t_min: self.t_min,
            t_max: self.t_max.unwrap_or(f32::INFINITY),
        };
        let triangles = self.triangles.iter().map(|corners| corners.map(Vec3::from)).collect();
        Case { ray, triangles }
    }
}

/// The cases that show the faults in `row` best: the first of each fault, and the largest error of the
/// distance.
#[must_use]
pub fn worst(row: &AccuracyRow, suite: &Suite, seed: u64) -> Vec<Record> {
    let record = |what: &str, number: u64| {
        let shows = format!("{} {}: {what}; {} {number} of seed {seed}", row.kernel, row.format, row.suite);
        Record::new(shows, &suite.case(seed, number))
    };
    let faults = Fault::ALL.into_iter().zip(row.worst.faults);
    let faults = faults.filter_map(|(fault, number)| Some(record(fault.name(), number?)));
    let distance =
        row.worst.distance.map(|number| record(&format!("t off by {:.3} ulp", row.t_ulp_max), number));
    faults.chain(distance).collect()
}

/// The records of a text, one a line.
///
/// # Errors
/// If a line is no record.
pub fn read(text: &str) -> Result<Vec<Record>, StudyError> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    let record =
        |(line, text)| serde_json::from_str(text).map_err(|source| StudyError::BadRecord { line, source });
    let records: Vec<Record> = lines.map(record).collect::<Result<_, _>>()?;
    if records.is_empty() { Err(StudyError::NoRecords) } else { Ok(records) }
}

/// A recorded case, asked again.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayedCase {
    /// The exact answer.
    pub truth: Truth,
    /// The answer of each contestant, and its fault.
    pub answers: Vec<(Contestant, Option<Found>, Option<Fault>)>,
}

/// Asks each contestant about a recorded case, by the rule for edges.
#[must_use]
pub fn replay(record: &Record, contestants: &[Contestant], edges: Edges) -> ReplayedCase {
    let case = record.case();
    let truth = Truth::of(&case, edges);
    let answer = |&contestant: &Contestant| {
        let found = contestant.run(std::slice::from_ref(&case), edges, 1).0[0];
        (contestant, found, Fault::of(found.as_ref(), &truth))
    };
    let answers = contestants.iter().map(answer).collect();
    ReplayedCase { truth, answers }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::suites::SUITES;

    #[test]
    fn cases_read_back_the_same() {
        for suite in &SUITES {
            let case = suite.case(5, 1);
            let line = serde_json::to_string(&Record::new("it".to_owned(), &case)).expect("numbers");
            assert_eq!(read(&line).expect("a case")[0].case(), case, "{}", suite.name);
        }
    }

    #[test]
    fn what_is_no_case_is_refused() {
        assert!(read("").is_err());
        assert!(read("\n{}").expect_err("no case").to_string().starts_with("line 2"));
    }
}
