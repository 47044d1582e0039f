//! The verbs, exit statuses, and how errors are shown.

use crate::output::{ClosedPipe, Stdout};
use crate::progress::Progress;
use crate::status::Status;
use crate::verbs::{
    accuracy, cache, conform, crosscheck, metadata, prove, render, reproduce, scenes, simulate, sweep, trace,
    walk,
};
use anyhow::{Context, Result};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use saarcor_oracles::embree::EmbreeError;
use saarcor_studies::StudyError;
use std::ffi::OsString;
use std::io::Write as _;
use std::process::ExitCode;

/// The arguments or the input are wrong, or output could not be written.
const BAD_INPUT: u8 = 2;

const EXIT_STATUSES: &str = "\
Data goes to stdout, everything else to stderr. Sizes are written 128, 64KiB, 8MiB or 1GiB; frames A..B \
begin with A and end before B.

Exit status:
  0  holds, or done
  1  disproved, or does not conform
  2  wrong usage or bad input
  3  incomplete: an engine is absent, or a limit was reached";

/// Bytes of stack of a thread: reflections and refractions recurse, with a packet of rays each.
const STACK_BYTES: usize = 64 << 20;

/// Reference model of the SaarCOR ray tracing chip and its virtual memory (Schmittler, Leidinger,
/// Slusallek 2003).
#[derive(Debug, Parser)]
#[command(name = "saarcor", version, after_help = EXIT_STATUSES, max_term_width = 100)]
struct Cli {
    /// Says nothing on stderr but warnings and errors.
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Threads to work with; the results do not depend on it [default: one a core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Metadata(metadata::Args),
    Scenes(scenes::Args),
    Render(render::Args),
    Walk(walk::Args),
    Simulate(simulate::Args),
    Sweep(sweep::Args),
    Merge(sweep::MergeArgs),
    Trace(trace::Args),
    Prove(prove::Args),
    Crosscheck(crosscheck::Args),
    Accuracy(accuracy::Args),
    Conform(conform::Args),
    Reproduce(reproduce::Args),
    Cache(cache::Args),
}

/// Does what the arguments ask for. The first argument is the program's name.
///
/// Every error is one line on standard error. A reader of standard output that goes away is not
/// an error: it has seen enough.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let done = match Cli::try_parse_from(args) {
        Ok(cli) => cli.run(),
        Err(usage) => answer(&usage).map(|()| Status::Holds),
    };
    match done {
        Err(error) if !error.is::<ClosedPipe>() => {
            let line = format!("saarcor: {error:#}").replace('\n', " ");
            // Where standard error is closed too, the status has to do.
            let _ = writeln!(std::io::stderr(), "{line}");
            ExitCode::from(if lacks_embree(&error) { Status::Incomplete as u8 } else { BAD_INPUT })
        }
        Ok(status) => ExitCode::from(status as u8),
        Err(_) => ExitCode::from(Status::Holds as u8),
    }
}

/// Whether the error is that Embree is not there, or does not run.
fn lacks_embree(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(EmbreeError::Absent(_)))
        || matches!(error.downcast_ref(), Some(StudyError::Embree(EmbreeError::Absent(_))))
}

impl Cli {
    fn run(self) -> Result<Status> {
        let progress = Progress::new(self.quiet);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, usize::from))
            .stack_size(STACK_BYTES)
            .build()
            .context("threads cannot be started")?;
        pool.install(|| {
            match self.verb {
                Verb::Metadata(args) => args.run(),
                Verb::Scenes(args) => args.run(&progress),
                Verb::Render(args) => args.run(&progress),
                Verb::Walk(args) => args.run(&progress),
                Verb::Simulate(args) => return args.run(&progress),
                Verb::Sweep(args) => args.run(&progress),
                Verb::Merge(args) => args.run(),
                Verb::Trace(args) => args.run(&progress),
                Verb::Prove(args) => return args.run(&progress),
                Verb::Crosscheck(args) => return args.run(&progress),
                Verb::Accuracy(args) => return args.run(&progress),
                Verb::Conform(args) => return args.run(&progress),
                Verb::Reproduce(args) => args.run(&progress),
                Verb::Cache(args) => return args.run(&progress),
            }
            .map(|()| Status::Holds)
        })
    }
}

/// Shows the help that was asked for, or makes one line of a usage error.
fn answer(usage: &clap::Error) -> Result<()> {
    match usage.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let mut out = Stdout::new();
            out.line(usage.render().to_string().trim_end())?;
            out.finish()
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let verbs = Cli::command();
            let verbs: Vec<_> = verbs.get_subcommands().map(clap::Command::get_name).collect();
            anyhow::bail!("a verb is missing: {}; 'saarcor --help' says more", verbs.join(", "))
        }
        _ => {
            let text = usage.render().to_string();
            let line = text.lines().map(str::trim).take_while(|line| !is_boilerplate(line));
            let line = line.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
            anyhow::bail!("{}", line.strip_prefix("error: ").unwrap_or(&line).replace(" tip:", ";"))
        }
    }
}

/// Whether a line of a usage error begins the part that is the same for all.
fn is_boilerplate(line: &str) -> bool {
    line.starts_with("Usage:") || line.starts_with("For more information")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_well_defined() {
        Cli::command().debug_assert();
    }
}
