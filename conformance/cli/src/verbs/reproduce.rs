//! `saarcor reproduce`.

use crate::output::{Stdout, json_line};
use crate::progress::{Progress, Remaining};
use crate::reproduce::{Folder, print};
use anyhow::Result;
use saarcor_paper::reproduction::{Extent, Reproduction, ReproductionOptions};
use std::path::PathBuf;

/// The paper's figures, ours beside theirs: as tables, and as a page with graphs
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Small pictures, and few frames of the walks: for a first look
    #[arg(long)]
    quick: bool,
    /// All frames of the walks: hours instead of half an hour
    #[arg(long, conflicts_with = "quick")]
    all_frames: bool,
    /// Folder for the page, the graphs (SVG) and their data (CSV)
    #[arg(short, long, value_name = "DIR", default_value = "target/reproduce")]
    out: PathBuf,
    /// Folder with the real scenes: its oa_dm3 and conference stand in for pQuake3 and Conference too
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
        let extent = match (self.quick, self.all_frames) {
            (true, _) => Extent::Quick,
            (false, false) => Extent::Some,
            (false, true) => Extent::All,
        };
        let options = ReproductionOptions { extent, scenes: self.scenes };
        let remaining = Remaining::new();
        let reproduction =
            Reproduction::compute(&options, progress, &mut |part| remaining.say(part, progress))?;
        let page = folder.write(&reproduction)?;
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &reproduction)?;
        } else {
            print(&reproduction, &mut out)?;
        }
        progress.say(format_args!("written: {}", page.display()));
        out.finish()
    }
}
