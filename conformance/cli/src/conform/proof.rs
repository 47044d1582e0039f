//! A proof of an implementation, for a person: as text and as a page.

use super::page::page;
use crate::table::{Column, Table, escaped};
use saarcor_kit::prove::report::ProofReport;
use std::fmt::Write as _;

/// What was done, what is reached, and what was planted, with their captions.
fn tables(report: &ProofReport) -> [(&'static str, Table); 3] {
    let clocks = |clocks: &Option<u32>| clocks.map_or("never".to_owned(), |clocks| clocks.to_string());
    let columns =
        [Column::text("step"), Column::text("result"), Column::number("seconds"), Column::text("cache")];
    let mut stages = Table::new(columns);
    for stage in &report.stages {
        let seconds = format!("{:.1}", stage.seconds);
        stages.row([stage.name.clone(), stage.says.clone(), seconds, stage.config.clone()]);
    }
    let mut covers = Table::new([Column::text("reached"), Column::number("after clocks")]);
    for (name, reached) in &report.covers {
        covers.row([name.clone(), clocks(reached)]);
    }
    let mut planted = Table::new([Column::text("fault planted"), Column::number("refuted after clocks")]);
    for fault in &report.planted {
        planted.row([fault.says.clone(), clocks(&fault.clocks)]);
    }
    [("Steps", stages), ("What has to happen", covers), ("Faults of the run's own", planted)]
}

/// The verdict in a sentence.
fn headline(report: &ProofReport) -> String {
    let reason = match (&report.trace, report.reason.as_str()) {
        (Some(trace), _) => format!(": {} after {} clocks", trace.says, trace.clocks),
        (None, "") => String::new(),
        (None, reason) => format!(": {reason}; no counterexample in {} clocks", report.reached),
    };
    format!("{}: {}{reason}", report.dut, report.verdict.text())
}

/// What is assumed, and what is not proved.
fn notes(report: &ProofReport) -> Vec<String> {
    let assumed = report.assumed.iter().map(|assumed| format!("assumed: {assumed}"));
    let not = report.not_claimed.iter().map(|not| format!("not proved: {not}"));
    let tools = format!("by Yosys, {} and {}", report.tools[0], report.tools[1]);
    [report.config.clone()].into_iter().chain(assumed).chain(not).chain([tools]).collect()
}

/// The report as text.
#[must_use]
pub fn text(report: &ProofReport) -> String {
    let mut text = format!("{}\n\n", headline(report));
    if let Some(trace) = &report.trace {
        let _ = writeln!(text, "{}", trace.config);
        for request in &trace.requests {
            let _ = writeln!(text, "  {request}");
        }
        for (name, at) in [("waves", &trace.waves), ("replay", &trace.replay)] {
            let _ = writeln!(text, "{name:<8}{}", at.as_deref().unwrap_or("-"));
        }
        text.push('\n');
    }
    for (_, table) in tables(report).into_iter().filter(|(_, table)| !table.is_empty()) {
        let _ = writeln!(text, "{table}\n");
    }
    for note in notes(report) {
        let _ = writeln!(text, "{note}");
    }
    text
}

/// The page.
#[must_use]
pub fn html(report: &ProofReport) -> String {
    let mut sections = String::new();
    if let Some(trace) = &report.trace {
        let _ = write!(
            sections,
            "<section>\n<h2>The shortest requests that refute it</h2>\n<p>{}</p>\n<pre>{}</pre>\n<dl>\n",
            escaped(&trace.config),
            escaped(&trace.requests.join("\n"))
        );
        for (name, at) in [("waves", &trace.waves), ("run again", &trace.replay)] {
            let at = escaped(at.as_deref().unwrap_or("-"));
            let _ = writeln!(sections, "<dt>{name}</dt><dd><pre>{at}</pre></dd>");
        }
        sections.push_str("</dl>\n</section>\n");
    }
    for (caption, table) in tables(report).into_iter().filter(|(_, table)| !table.is_empty()) {
        let _ = writeln!(sections, "<div class=\"scroll\">{}</div>", table.to_html(caption));
    }
    let title = format!("Proof of {}", report.dut);
    page(&title, report.verdict.text(), &headline(report), &notes(report), &sections)
}
