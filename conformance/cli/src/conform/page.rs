//! The report as a page that needs no other file.

use super::text::{notes, tables};
use crate::table::escaped;
use saarcor_kit::report::{ConformanceReport, Failure};
use std::fmt::Write as _;

const STYLE: &str = concat!(include_str!("../page.css"), include_str!("page.css"));

/// The page.
#[must_use]
pub fn html(report: &ConformanceReport) -> String {
    let failures: String = report.failures.iter().map(section).collect();
    let mut sections = String::new();
    for (caption, table) in tables(report) {
        let _ = writeln!(sections, "<div class=\"scroll\">{}</div>", table.to_html(caption));
    }
    page(
        &format!("Conformance of {}", report.dut),
        report.verdict.text(),
        &report.headline(),
        &notes(report),
        &format!("{failures}{sections}"),
    )
}

/// A page with its verdict on top; what is below is HTML.
pub(super) fn page(title: &str, verdict: &str, headline: &str, notes: &[String], below: &str) -> String {
    let notes: Vec<_> = notes.iter().map(|note| escaped(note)).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>{0}</h1>\n<p class=\"verdict {}\">{}</p>\n<p>{}</p>\n{below}\
         </main>\n</body>\n</html>\n",
        escaped(title),
        verdict.replace(' ', "-"),
        escaped(headline),
        notes.join("<br>"),
    )
}

/// A failure: its shortest requests, with the answer that is wrong.
fn section(failure: &Failure) -> String {
    // The last that is asked is where it fails.
    let fails = failure.minimal.iter().rposition(|line| *line == failure.asked);
    let mut lines = String::new();
    for (place, line) in failure.minimal.iter().enumerate() {
        let (open, close) = if Some(place) == fails { ("<mark>", "</mark>") } else { ("", "") };
        let _ = writeln!(lines, "{open}{}{close}", escaped(line));
    }
    let part = |name: &str, rows: &str| match rows {
        "" => String::new(),
        rows => format!("<dt>{name}</dt><dd><pre>{}</pre></dd>\n", escaped(rows)),
    };
    format!(
        "<section>\n<h2>{} at level {}</h2>\n<p>{}</p>\n<blockquote>{}</blockquote>\n<p class=\"idea\">{} ({}; requests: {}, {})</p>\n\
         <pre>{lines}</pre>\n<dl>\n{}{}{}{}{}{}</dl>\n</section>\n",
        escaped(&failure.requirement),
        failure.level,
        escaped(&failure.says),
        escaped(&failure.demands),
        escaped(&failure.idea),
        escaped(&failure.session),
        failure.minimal_requests,
        escaped(&failure.shrunk()),
        part("asked", &failure.asked),
        part("expected", &failure.expected),
        got(failure),
        part("state before", &failure.state_before.join("\n")),
        part("stderr ends with", &failure.stderr),
        part("run again", failure.replay.as_deref().unwrap_or_default()),
    )
}

/// What came, with the parts marked that differ.
fn got(failure: &Failure) -> String {
    let got = if failure.got.is_empty() { "nothing" } else { &failure.got };
    let mut text = String::new();
    let mut at = 0;
    for part in failure.differences() {
        let _ = write!(text, "{}<mark>{}</mark>", escaped(&got[at..part.start]), escaped(&got[part.clone()]));
        at = part.end;
    }
    format!("<dt>got</dt><dd><pre>{text}{}</pre></dd>\n", escaped(&got[at..]))
}
