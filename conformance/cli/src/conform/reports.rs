//! How the report of a run or a proof is given: printed, as JUnit XML and as a page.

use crate::output::{ClosedPipe, OutFile};
use anyhow::Result;
use saarcor_kit::error::Error as KitError;
use std::path::PathBuf;
use std::time::SystemTime;

/// In which forms a report is given.
#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// Prints the report as one JSON object
    #[arg(long)]
    pub json: bool,
    /// Writes the report as JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Writes the report as an HTML page that needs no other file
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// The files of a report, which can be written.
#[derive(Debug)]
pub struct ReportFiles {
    junit: Option<OutFile>,
    html: Option<OutFile>,
}

impl ReportArgs {
    /// The files, none of which is one of the inputs.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn files(&self, inputs: &[PathBuf]) -> Result<ReportFiles> {
        let file = |path: &Option<PathBuf>, endings: &[&str]| -> Result<Option<OutFile>> {
            let file = path.as_deref().map(|path| OutFile::check(path)?.with_ending(endings)).transpose()?;
            file.iter().try_for_each(|file| file.check_inputs(inputs))?;
            Ok(file)
        };
        Ok(ReportFiles { junit: file(&self.junit, &["xml"])?, html: file(&self.html, &["html", "htm"])? })
    }
}

impl ReportFiles {
    /// Gives a report that has been printed, or not: the verdict is shown first, and nothing that cannot be written takes it
    /// away.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn give(
        self,
        printed: Result<()>,
        junit: impl FnOnce(SystemTime) -> Result<String, KitError>,
        html: impl FnOnce() -> String,
    ) -> Result<()> {
        printed.or_else(|error| if error.is::<ClosedPipe>() { Ok(()) } else { Err(error) })?;
        if let Some(file) = self.junit {
            let text = junit(SystemTime::now())?;
            file.write(|out| Ok(out.write_all(text.as_bytes())?))?;
        }
        if let Some(file) = self.html {
            let page = html();
            file.write(|out| Ok(out.write_all(page.as_bytes())?))?;
        }
        Ok(())
    }
}
