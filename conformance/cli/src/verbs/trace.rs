//! `saarcor trace`.

use crate::args::{CacheArgs, SceneArgs, TraceArgs};
use crate::output::OutFile;
use crate::progress::Progress;
use anyhow::Result;
use clap::{Subcommand, ValueEnum};
use saarcor_model::vm::HostAddr;
use saarcor_studies::walk::{WalkOptions, record_frame};
use saarcor_studies::world::World;
use std::path::PathBuf;

/// Traces for other people's cache simulators
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Record(RecordArgs),
}

/// Writes the accesses of a frame to the virtual memory, a row an access
#[derive(Debug, clap::Args)]
struct RecordArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frame of the scene's path
    #[arg(long, value_name = "N")]
    frame: usize,
    /// Form of the rows
    #[arg(long, value_enum)]
    format: Format,
    /// The trace; '-' is stdout
    #[arg(short, long, value_name = "FILE", default_value = "-", hide_default_value = true)]
    out: PathBuf,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    cache: CacheArgs,
}

/// Form of a trace.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// Label 0 (a read) and the byte address in hex: `0 1a2b80`
    Din,
    /// The byte address in hex, under the header `address`: `0x1a2b80`
    Csv,
}

impl Format {
    fn header(self) -> Option<&'static str> {
        match self {
            Self::Din => None,
            Self::Csv => Some("address"),
        }
    }

    fn row(self, HostAddr(addr): HostAddr) -> String {
        match self {
            Self::Din => format!("0 {addr:x}"),
            Self::Csv => format!("{addr:#x}"),
        }
    }
}

impl Args {
    /// Does what was asked for.
    pub fn run(self, progress: &Progress) -> Result<()> {
        match self.verb {
            Verb::Record(args) => args.run(progress),
        }
    }
}

impl RecordArgs {
    fn run(self, progress: &Progress) -> Result<()> {
        let cache = self.cache.config(&self.scene.scene.text())?;
        let endings: &[&str] = match self.format {
            Format::Din => &[],
            Format::Csv => &["csv"],
        };
        let file = OutFile::check_or_stdout(&self.out)?.with_ending(endings)?;
        let world = World::open(&self.scene.options(Some(self.frame))?, progress)?;
        file.check_inputs(&world.files)?;
        let options = WalkOptions { cache, cold: true, trace: self.trace.options() };
        file.write(|out| self.record(&world, &options, &mut |row| Ok(writeln!(out, "{row}")?)))
    }

    fn record(
        &self,
        world: &World,
        options: &WalkOptions,
        line: &mut (dyn FnMut(&str) -> Result<()> + Send),
    ) -> Result<()> {
        self.format.header().map_or(Ok(()), &mut *line)?;
        record_frame(world, self.frame, options, &mut |addr| line(&self.format.row(addr)))?;
        Ok(())
    }
}
