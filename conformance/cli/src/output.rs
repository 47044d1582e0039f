//! Standard output and output files.

mod file;
pub mod temporaries;

pub use file::{OutFile, check_inputs, folder_of};

use anyhow::{Context, Error, Result};
use image::{ImageFormat, RgbImage};
use std::fmt;
use std::io::{self, BufWriter, Cursor, Write};

/// Standard output was closed by its reader, as `head` does. Not a failure.
#[derive(Clone, Copy, Debug)]
pub struct ClosedPipe;

impl fmt::Display for ClosedPipe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("standard output was closed")
    }
}

impl std::error::Error for ClosedPipe {}

/// Standard output. Its errors are [`ClosedPipe`] where the reader went away.
pub struct Stdout {
    out: BufWriter<io::Stdout>,
}

impl Stdout {
    /// The standard output of this process.
    #[must_use]
    pub fn new() -> Self {
        Self { out: BufWriter::new(io::stdout()) }
    }

    /// Writes a line.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn line(&mut self, line: impl fmt::Display) -> Result<()> {
        writeln!(self.out, "{line}").map_err(stdout_error)
    }

    /// Shows the reader all that was written.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        // Twice: the process keeps lines that are not complete in a buffer of its own.
        self.out.flush().and_then(|()| self.out.get_mut().flush()).map_err(stdout_error)
    }

    /// Writes the rest of the buffer. Without it, an error could go unseen.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.flush()
    }
}

impl Default for Stdout {
    fn default() -> Self {
        Self::new()
    }
}

fn stdout_error(error: io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => ClosedPipe.into(),
        _ => Error::new(error).context("standard output cannot be written"),
    }
}

/// Prints a value as one line of JSON.
///
/// # Errors
/// If it cannot be written.
pub fn json_line(out: &mut Stdout, value: &impl serde::Serialize) -> Result<()> {
    out.line(serde_json::to_string(value).context("result as JSON")?)
}

/// Writes a picture as PNG.
///
/// # Errors
/// If it cannot be written.
pub fn write_png(pixels: &RgbImage, out: &mut dyn Write) -> Result<()> {
    let mut png = Cursor::new(Vec::new());
    pixels.write_to(&mut png, ImageFormat::Png).context("picture as PNG")?;
    Ok(out.write_all(png.get_ref())?)
}
