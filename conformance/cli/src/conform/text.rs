//! The report as text.

use crate::table::{Column, Table};
use saarcor_kit::report::{ConformanceReport, Outcome};
use saarcor_kit::scoreboard::{CheckedAnswers, Finding};
use saarcor_kit::shown::{differences, marks};
use std::fmt::Write as _;

/// The levels, the requirements and the coverage as tables, with their captions.
#[must_use]
pub fn tables(report: &ConformanceReport) -> [(&'static str, Table); 3] {
    let mut levels = Table::new([Column::text("level"), Column::text("verdict")]);
    for row in &report.levels {
        levels.row([row.level.to_string(), row.verdict.text().to_owned()]);
    }
    let columns = [Column::text("requirement"), Column::number("sessions"), Column::number("failed")];
    let mut requirements = Table::new(columns);
    for row in &report.requirements {
        requirements.row([row.requirement.clone(), row.sessions.to_string(), row.failed.to_string()]);
    }
    let mut coverage = Table::new([Column::text("exercised"), Column::number("cases"), Column::number("of")]);
    for row in &report.coverage {
        coverage.row([row.what.clone(), row.reached.to_string(), row.all.to_string()]);
    }
    [("Levels", levels), ("Requirements", requirements), ("Coverage of the small geometry", coverage)]
}

/// What was held, in sentences.
#[must_use]
pub fn notes(report: &ConformanceReport) -> Vec<String> {
    let mut notes = vec![format!("{} sessions, {} requests", report.sessions, report.requests)];
    if report.random_seconds > 0.0 && report.random_requests > 0 {
        let rate = report.random_requests as f64 / report.random_seconds / 1e6;
        notes.push(format!(
            "{} requests of random sessions, {rate:.2} million a second",
            report.random_requests
        ));
    }
    let randoms = report.outcomes.iter().filter(|outcome| outcome.session.contains("/random/")).count();
    if randoms > 0 {
        let last = report.seed.wrapping_add(randoms as u64 - 1);
        notes.push(format!("seeds of the random sessions: {} to {last}", report.seed));
    }
    for outcome in report.outcomes.iter().filter(|outcome| outcome.outcome == Outcome::Waived) {
        notes.push(format!("waived: {}: {}", outcome.session, outcome.says));
    }
    for row in &report.admitted {
        notes.push(format!(
            "{} answers are right though not the model's, by {}; the first, '{}' in {}: {}",
            row.answers, row.requirement, row.asked, row.session, row.why
        ));
    }
    if report.tolerance > 0 {
        notes.push(format!("timing is judged within {} thousandths", report.tolerance));
    }
    for row in &report.unsupported {
        notes.push(format!("not supported: {} ({} sessions)", row.key, row.sessions));
    }
    notes.extend(report.stopped.iter().map(|why| format!("stopped: {why}")));
    notes
}

/// Each session with its outcome and its configuration.
#[must_use]
pub fn sessions(report: &ConformanceReport) -> Table {
    let mut table = Table::new([
        Column::text("session"),
        Column::text("outcome"),
        Column::number("requests"),
        Column::number("seconds"),
        Column::text("configuration"),
    ]);
    for outcome in &report.outcomes {
        table.row([
            outcome.session.clone(),
            outcome.outcome.text().to_owned(),
            outcome.requests.to_string(),
            format!("{:.3}", outcome.seconds),
            outcome.config.clone(),
        ]);
    }
    table
}

/// The report as text.
#[must_use]
pub fn text(report: &ConformanceReport) -> String {
    let mut text = format!("{}\n\n", report.headline());
    for (_, table) in tables(report) {
        let _ = writeln!(text, "{table}\n");
    }
    for failure in &report.failures {
        let _ = writeln!(text, "{}", failure.text());
    }
    for note in notes(report) {
        let _ = writeln!(text, "{note}");
    }
    text
}

/// A difference in lines.
#[must_use]
pub fn finding(finding: &Finding) -> String {
    let Finding { level, requirement, request, asked, expected, got, says } = finding;
    let place = request.map_or_else(String::new, |request| format!("request {}, ", request + 1));
    let marks = marks(got, &differences(expected, got));
    let marks = marks.map_or_else(String::new, |marks| format!("\n            {marks}"));
    format!(
        "{requirement} at level {level}: {place}'{asked}': {says}\n  expected  {expected}\n  got       {got}{marks}"
    )
}

/// What answers come to, in a sentence.
#[must_use]
pub fn checked(checked: &CheckedAnswers, session: &str) -> String {
    let CheckedAnswers { answered, highest, not_judged, unsupported, .. } = checked;
    let not_judged: Vec<_> = not_judged.iter().map(|level| level.name()).collect();
    let rest = if not_judged.is_empty() {
        String::new()
    } else {
        format!("; not judged: {}", not_judged.join(", "))
    };
    match (unsupported, highest) {
        (Some(key), _) => format!("{session}: {key} is not supported"),
        (None, Some(level)) => format!("{session}: {answered} answers agree up to level {level}{rest}"),
        (None, None) => format!("{session}: {answered} answers agree at no level{rest}"),
    }
}
