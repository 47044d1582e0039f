//! `saarcor metadata`.

use crate::args::GeometryArgs;
use crate::metadata::table;
use crate::output::{Stdout, json_line};
use crate::size::Size;
use anyhow::Result;
use saarcor_model::vm::Bytes;
use saarcor_paper::metadata::examples;
use saarcor_studies::metadata::MetadataFacts;

/// The size of the cache's metadata, beside the paper's two examples
#[derive(Debug, clap::Args)]
pub struct Args {
    /// On-board memory
    // The memory of the paper's examples.
    #[arg(long, value_name = "SIZE", default_value_t = Size(Bytes(16 << 20)))]
    memory: Size,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// Prints the metadata as one JSON object
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Prints what was asked for.
    pub fn run(self) -> Result<()> {
        let asked = MetadataFacts::of(self.geometry.geometry(self.memory)?);
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &asked)?;
        } else {
            let others = examples().into_iter().filter(|example| *example != asked);
            let rows: Vec<_> = std::iter::once(asked).chain(others).collect();
            out.line(table(&rows))?;
            out.line("")?;
            out.line(format_args!(
                "metadata = {} bytes × memory / line (§3); the paper truncates its percentages",
                asked.entry_bytes
            ))?;
        }
        out.finish()
    }
}
