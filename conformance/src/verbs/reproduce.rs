//! `saarcor reproduce`.

use crate::output::{Stdout, json_line};
use crate::progress::Progress;
use crate::reproduce::{Folder, Options, Report};
use anyhow::Result;
use std::path::PathBuf;

/// The paper's figures, ours beside theirs: as tables, and as a page with graphs
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Smaller pictures and fewer frames: minutes instead of hours
    #[arg(long)]
    quick: bool,
    /// Folder for the page, the graphs (SVG) and their data (CSV)
    #[arg(short, long, value_name = "DIR", default_value = "target/reproduce")]
    out: PathBuf,
    /// Folder with the real scenes: walks through its level oa_dm3 too
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,
    /// Prints all figures as one JSON object
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Computes all figures, writes the page and prints the tables.
    pub fn run(self, progress: &Progress) -> Result<()> {
        let folder = Folder::create(&self.out)?;
        let report = Report::new(&Options { quick: self.quick, scenes: self.scenes }, progress)?;
        let page = folder.write(&report)?;
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &report)?;
        } else {
            report.print(&mut out)?;
        }
        progress.say(format_args!("written: {}", page.display()));
        out.finish()
    }
}
