//! The paper's figures, ours beside theirs, for a person to read: tables, graphs and a page.

mod bars;
mod page;
mod plot;
pub mod sensitivity;
mod tables;
mod tornado;

use crate::output::{OutFile, Stdout};
use anyhow::{Context, Result};
use saarcor_paper::Reproduction;
use saarcor_paper::claims::Claim;
use saarcor_paper::figure3::Graph;
use saarcor_studies::walk::FrameRow;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Prints the figures as tables, and why they differ.
///
/// # Errors
/// If they cannot be written.
pub fn print(reproduction: &Reproduction, out: &mut Stdout) -> Result<()> {
    for (caption, table) in tables::sections(reproduction).into_iter().flatten() {
        out.line(&caption)?;
        out.line("")?;
        out.line(table)?;
        out.line("")?;
    }
    out.line("What the paper claims")?;
    out.line("")?;
    for claim in &reproduction.claims {
        let Claim { section, claim, paper, ours, verdict, cause, numbers, open, .. } = claim;
        out.line(format_args!("{section}: {claim} {verdict}"))?;
        out.line(format_args!("    paper: {paper}"))?;
        out.line(format_args!("    ours: {ours}"))?;
        if let Some(cause) = cause {
            out.line(format_args!("    {cause}"))?;
        }
        for number in numbers {
            out.line(format_args!("    {number}"))?;
        }
        if !open.is_empty() {
            out.line(format_args!("    left open: {open}"))?;
        }
    }
    let differences = page::differences(reproduction);
    if !differences.is_empty() {
        out.line("")?;
        out.line("What differs, and why")?;
        out.line("")?;
    }
    for (what, why) in differences {
        out.line(format_args!("{what} {why}"))?;
    }
    Ok(())
}

/// Name and value of a column of the CSV file.
type CsvColumn = (&'static str, fn(&FrameRow) -> u64);

const CSV: [CsvColumn; 12] = [
    ("frame", |row| row.frame),
    ("primary_rays", |row| row.primary_rays),
    ("shadow_rays", |row| row.shadow_rays),
    ("secondary_rays", |row| row.secondary_rays),
    ("accesses", |row| row.accesses),
    ("hits", |row| row.hits),
    ("misses", |row| row.misses),
    ("working_set_lines", |row| row.working_set_lines),
    ("working_set_bytes", |row| row.working_set_bytes),
    ("collisions", |row| row.collisions),
    ("loaded_lines", |row| row.loaded_lines),
    ("loaded_bytes", |row| row.loaded_bytes),
];

/// The frames as comma-separated values, under a header. What is not known of frames a second is empty.
fn csv(graph: &Graph) -> String {
    let mut csv = CSV.map(|(name, _)| name).join(",") + ",fps,fps_low,fps_high,estimated";
    for (place, row) in graph.frames.iter().enumerate() {
        let _ = write!(csv, "\n{}", CSV.map(|(_, value)| value(row).to_string()).join(","));
        let in_time = graph.fps.get(place);
        let known = in_time.and_then(|row| Some([row.fps?, row.interval?[0], row.interval?[1]]));
        let known = known.map_or_else(|| ",,".to_owned(), |of| of.map(|of| format!("{of:.2}")).join(","));
        let _ = write!(csv, ",{known},{}", in_time.is_some_and(|row| row.estimated));
    }
    csv.push('\n');
    csv
}

/// The files of a reproduction, in one folder.
pub struct Folder {
    path: PathBuf,
    page: OutFile,
}

impl Folder {
    /// Makes the folder, and checks that it can be written to.
    ///
    /// # Errors
    /// If it cannot.
    pub fn create(path: &Path) -> Result<Self> {
        std::fs::create_dir_all(path)
            .with_context(|| format!("{}: the folder cannot be made", path.display()))?;
        for bars in bars::ALL {
            OutFile::check(&path.join(bars.file).with_extension("svg"))?;
        }
        Ok(Self { path: path.to_owned(), page: OutFile::check(&path.join("index.html"))? })
    }

    /// Writes a graph as SVG and CSV a figure, and the page with all of it.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, reproduction: &Reproduction) -> Result<PathBuf> {
        for graph in &reproduction.figure3 {
            let file = |kind| OutFile::check(&self.path.join(format!("{}.{kind}", plot::file(graph))));
            file("svg")?.write(|out| Ok(out.write_all(plot::svg(graph).as_bytes())?))?;
            file("csv")?.write(|out| Ok(out.write_all(csv(graph).as_bytes())?))?;
        }
        for bars in bars::ALL {
            let file = OutFile::check(&self.path.join(bars.file).with_extension("svg"))?;
            file.write(|out| Ok(out.write_all(bars.svg(&reproduction.table2).as_bytes())?))?;
        }
        // The page comes last: where it stands, the others do.
        self.page.write(|out| Ok(out.write_all(page::html(reproduction).as_bytes())?))?;
        Ok(self.path.join("index.html"))
    }
}
