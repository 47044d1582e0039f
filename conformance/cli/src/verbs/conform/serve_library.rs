//! `saarcor conform serve-library`.

use crate::status::Status;
use anyhow::{Context, Result};
use saarcor_kit::shared_library;
use std::fs;
use std::path::PathBuf;

/// Holds one conversation with a shared library over standard input and output, as 'run' does
#[derive(Debug, clap::Args)]
pub(super) struct ServeLibraryArgs {
    /// A library with the functions of saarcor.h
    #[arg(value_name = "FILE")]
    library: PathBuf,
}

impl ServeLibraryArgs {
    /// Holds it.
    pub(super) fn run(self) -> Result<Status> {
        // A path without a folder would be looked for where the system keeps its libraries.
        let path = fs::canonicalize(&self.library)
            .with_context(|| format!("{}: cannot be read", self.library.display()))?;
        shared_library::serve(&path, std::io::stdin().lock(), std::io::stdout().lock())?;
        Ok(Status::Holds)
    }
}
