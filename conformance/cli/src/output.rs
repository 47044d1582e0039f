//! Standard output and output files.

use anyhow::{Context, Error, Result, anyhow, bail};
use image::{ImageFormat, RgbImage};
use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufWriter, Cursor, Write};
use std::path::{Path, PathBuf};

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

/// A file to be written, at a place where that was found possible.
#[derive(Clone, Debug)]
pub struct OutFile {
    path: PathBuf,
}

impl OutFile {
    /// Checks that a file can be written at `path`, before the work that makes its content.
    ///
    /// # Errors
    /// If it cannot.
    pub fn check(path: &Path) -> Result<Self> {
        // A link is written through, not replaced.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if path.is_dir() {
            bail!("{}: is a folder; name a file", path.display());
        }
        let file = Self { path };
        if file.is_replaced() {
            file.temporary()?;
        }
        Ok(file)
    }

    /// Where the file is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file: all of it, or nothing.
    ///
    /// # Errors
    /// Those of `write`, and if the file cannot be written.
    pub fn write(&self, write: impl FnOnce(&mut (dyn Write + Send)) -> Result<()>) -> Result<()> {
        let cannot = || format!("{}: cannot be written", self.path.display());
        if !self.is_replaced() {
            let mut out = BufWriter::new(File::options().write(true).open(&self.path).with_context(cannot)?);
            write(&mut out).and_then(|()| Ok(out.flush()?)).with_context(cannot)?;
            return Ok(());
        }
        let mut out = BufWriter::new(self.temporary()?);
        write(&mut out).and_then(|()| Ok(out.flush()?)).with_context(cannot)?;
        let temporary = out.into_inner().map_err(io::IntoInnerError::into_error).with_context(cannot)?;
        temporary.persist(&self.path).with_context(cannot)?;
        Ok(())
    }

    /// Devices and pipes are written to; all else is replaced.
    fn is_replaced(&self) -> bool {
        fs::metadata(&self.path).map_or(true, |found| found.is_file())
    }

    fn temporary(&self) -> Result<tempfile::NamedTempFile> {
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".saarcor-");
        #[cfg(unix)]
        {
            // The permissions of an ordinary new file; the user's mask applies.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        builder.tempfile_in(folder).map_err(|error| {
            // The crate's message names the temporary file, which nobody asked for.
            let why = match error.kind() {
                io::ErrorKind::NotFound => "there is no such folder".to_owned(),
                kind => kind.to_string(),
            };
            anyhow!("{}: cannot be written: {why}", self.path.display())
        })
    }
}
