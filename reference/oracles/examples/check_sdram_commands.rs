//! Are these commands ones that the data sheet of an SDRAM allows?
//!
//! `cargo run --release -p saarcor-oracles --example check_sdram_commands -- [NAME=CLOCKS ..] < FILE.csv`
//!
//! FILE is of the form that [`HEADER`](saarcor_oracles::memory_protocol::HEADER) says; it may have any
//! size. A NAME is a field of [`Timing`], PC133's by default; or `end`, the clock in which the run ended, by
//! default the last command's. Prints how many commands there are, and the violations. Ends with status 0
//! if there are none, 1 if there are some, 2 after bad input.

use saarcor_oracles::memory_protocol::{Checker, PC133, Rule, Timing, Violation, commands};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufRead, Write as _};
use std::process::ExitCode;

/// How many violations are printed in full.
const IN_FULL: u64 = 20;
/// More banks than any memory has.
const MOST_BANKS: u64 = 1 << 16;

/// The timing and the end of the run that the arguments name.
fn read_arguments(arguments: impl Iterator<Item = String>) -> Result<(Timing, Option<u64>), String> {
    let (mut timing, mut end) = (PC133, None);
    for argument in arguments {
        let Some((name, Ok(value))) = argument.split_once('=').map(|(name, value)| (name, value.parse()))
        else {
            return Err(format!("`{argument}` is not NAME=NUMBER, such as t_ras=6"));
        };
        let mut fields = timing.fields();
        if name == "end" {
            end = Some(value);
        } else if let Some((_, field)) = fields.iter_mut().find(|(known, _)| *known == name) {
            **field = value;
        } else {
            let known = fields.map(|(known, _)| known).join(", ");
            return Err(format!("`{name}` is none of {known}, end"));
        }
    }
    if timing.banks > MOST_BANKS {
        return Err(format!("{} banks are more than {MOST_BANKS}", timing.banks));
    }
    Ok((timing, end))
}

/// The report on a file of commands, and how many violations it names.
fn report(file: impl BufRead, timing: Timing, end: Option<u64>) -> Result<(String, u64), String> {
    let mut checker = Checker::new(timing);
    let (mut kinds, mut rules) = (BTreeMap::<&str, u64>::new(), BTreeMap::<Rule, u64>::new());
    let (mut lines, mut violations, mut last) = (String::new(), 0, 0);
    let mut note = |verdict: Result<(), Violation>| {
        if let Err(violation) = verdict {
            if violations < IN_FULL {
                _ = writeln!(lines, "{violation}");
            } else {
                *rules.entry(violation.rule).or_default() += 1;
            }
            violations += 1;
        }
    };
    for command in commands(file) {
        let (clock, command) = command.map_err(|error| error.to_string())?;
        *kinds.entry(command.name()).or_default() += 1;
        note(checker.check(clock, command));
        last = clock;
    }
    note(checker.finish(end.unwrap_or(last)));

    for (rule, count) in rules {
        _ = writeln!(lines, "{count} more of {}", rule.name());
    }
    let kinds = ["ACT", "RD", "WR", "PRE", "REF"].map(|kind| (kind, kinds.get(kind).unwrap_or(&0)));
    _ = writeln!(lines, "commands: {}", kinds.map(|(kind, count)| format!("{count} {kind}")).join(", "));
    _ = writeln!(lines, "violations: {violations}");
    Ok((lines, violations))
}

fn main() -> ExitCode {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    let judged =
        read_arguments(arguments).and_then(|(timing, end)| report(std::io::stdin().lock(), timing, end));
    match judged {
        Ok((lines, violations)) => {
            // Nobody reads a report whose reader is gone; the status stands.
            _ = std::io::stdout().write_all(lines.as_bytes());
            ExitCode::from(u8::from(violations > 0))
        }
        Err(error) => {
            _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(2)
        }
    }
}
