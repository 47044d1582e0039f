//! Cases as small files, to be looked at again.

use super::case::{Case, Truth};
use super::contest::Contestant;
use super::measure::{Fault, Row};
use super::suites::Suite;
use crate::args::kernel_name;
use anyhow::{Context, Result, ensure};
use glam::Vec3;
use saarcor_model::rays::Ray;
use serde::{Deserialize, Serialize};

/// A case with what it shows. A line of JSON; f32 are written so that they read back the same, and
/// an infinite end of the range is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// What it shows of which contestant.
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

/// The cases that show best what is wrong in `row`: the first of each fault, and the largest error
/// of the distance.
#[must_use]
pub fn worst(row: &Row, suite: &Suite, seed: u64) -> Vec<Record> {
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

/// The cases of a file of records.
///
/// # Errors
/// If a line is no record.
pub fn read(text: &str) -> Result<Vec<Record>> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    let record = |(number, line)| {
        serde_json::from_str(line)
            .with_context(|| format!("line {number}: no case as 'accuracy --out' writes"))
    };
    let records: Vec<Record> = lines.map(record).collect::<Result<_>>()?;
    ensure!(!records.is_empty(), "no case: write a line of JSON a case, as 'accuracy --out' does");
    Ok(records)
}

/// What is true of a case, and what each contestant makes of it, a line each.
#[must_use]
pub fn lines(record: &Record, contestants: &[Contestant]) -> Vec<String> {
    let case = record.case();
    let truth = Truth::of(&case);
    let exact = truth.0.iter().map(|found| format!("triangle {} at {:e}", found.triangle, found.t));
    let exact: Vec<_> = exact.collect();
    let exact = if exact.is_empty() { "nothing".to_owned() } else { exact.join(", ") };
    let contestant = |contestant: &Contestant| {
        let found = contestant.run(std::slice::from_ref(&case), 1).0[0];
        let said = found
            .map_or("nothing".to_owned(), |found| format!("triangle {} at {:e}", found.triangle, found.t));
        let fault = Fault::of(found.as_ref(), &truth).map_or("", Fault::name);
        let name = format!("{} {}", kernel_name(contestant.kernel), contestant.format.name());
        format!("  {name:<22}{said:<34}{fault}").trim_end().to_owned()
    };
    let head = [record.shows.clone(), format!("  {:<22}{exact}", "exactly")];
    head.into_iter().chain(contestants.iter().map(contestant)).collect()
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
        assert!(format!("{:#}", read("\n{}").expect_err("no case")).starts_with("line 2"));
    }
}
