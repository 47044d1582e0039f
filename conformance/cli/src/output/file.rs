//! Output files: whole or not at all, and never in the place of what they are made of.

use super::temporaries::{self, Temporary};
use super::{ClosedPipe, stdout_error};
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use std::fs::{self, File, Metadata};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// The name of standard output.
const STDOUT: &str = "-";

/// Links that are followed one after the other, as Linux has it.
const MOST_LINKS: usize = 40;

/// Endings that say what a file holds.
const KNOWN_ENDINGS: [&str; 36] = [
    "avif", "bmp", "bz2", "csv", "dds", "exr", "gif", "glb", "gltf", "gz", "hdr", "htm", "html", "ico",
    "jpeg", "jpg", "json", "jsonl", "mtl", "obj", "pbm", "pdf", "pgm", "ply", "png", "ppm", "qoi", "stl",
    "svg", "tga", "tif", "tiff", "webp", "xml", "xz", "zip",
];

/// A file to be written, at a place where that was found possible; or standard output.
#[derive(Clone, Debug)]
pub struct OutFile {
    /// Where the file is, behind all links; `-` is standard output where `is_stdout`.
    path: PathBuf,
    is_stdout: bool,
}

impl OutFile {
    /// Checks that a file can be written at `path`, before the work that makes its content.
    ///
    /// # Errors
    /// If it cannot, and if `path` is `-`, where standard output has other data.
    pub fn check(path: &Path) -> Result<Self> {
        if path == Path::new(STDOUT) {
            bail!("-: is standard output, which has other data here; name a file, such as ./-");
        }
        // A link is written through, not replaced, also one that leads to nothing yet.
        let path = behind_links(path)?;
        if path.is_dir() {
            bail!("{}: is a folder; name a file", path.display());
        }
        let file = Self { path, is_stdout: false };
        if file.is_replaced() {
            if file.path.exists() {
                // Replacing a file needs no permission to write to it.
                let opened = File::options().write(true).open(&file.path);
                opened.map_err(|error| {
                    anyhow!("{}: cannot be written: {}", file.path.display(), error.kind())
                })?;
            }
            file.temporary()?;
        }
        Ok(file)
    }

    /// [`OutFile::check`], but that `-` is standard output.
    ///
    /// # Errors
    /// If a file cannot be written there.
    pub fn check_or_stdout(path: &Path) -> Result<Self> {
        match path == Path::new(STDOUT) {
            true => Ok(Self { path: path.to_owned(), is_stdout: true }),
            false => Self::check(path),
        }
    }

    /// The file, whose name may end in one of `endings`, and in none that stands for another format.
    ///
    /// # Errors
    /// The endings, where it has another one.
    pub fn with_ending(self, endings: &[&str]) -> Result<Self> {
        let ending = self.path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let is_other = |ending: &str| KNOWN_ENDINGS.contains(&ending) && !endings.contains(&ending);
        if let Some(ending) = ending.filter(|ending| is_other(ending) && self.is_replaced()) {
            let right: Vec<_> = endings.iter().map(|ending| format!(".{ending}")).collect();
            let right =
                if right.is_empty() { "another ending, or none".to_owned() } else { right.join(", ") };
            bail!("{}: what is written is no .{ending} file; write {right}", self.path.display());
        }
        Ok(self)
    }

    /// Checks that the file is none of those that its content is made of, whatever their names.
    ///
    /// # Errors
    /// If it is one of them.
    pub fn check_inputs<P: AsRef<Path>>(&self, inputs: impl IntoIterator<Item = P>) -> Result<()> {
        if self.is_stdout { Ok(()) } else { check_inputs(&self.path, inputs) }
    }

    /// Where the file is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is standard output.
    #[must_use]
    pub fn is_stdout(&self) -> bool {
        self.is_stdout
    }

    /// Writes the file: all of it, or nothing. Returns what `write` returns.
    ///
    /// # Errors
    /// Those of `write`, and if the file cannot be written.
    pub fn write<T>(&self, write: impl FnOnce(&mut (dyn Write + Send)) -> Result<T>) -> Result<T> {
        if self.is_stdout {
            let mut out = BufWriter::new(io::stdout());
            // Twice: the process keeps lines that are not complete in a buffer of its own.
            let flushed = |out: &mut BufWriter<io::Stdout>| out.flush().and_then(|()| out.get_mut().flush());
            let written = write(&mut out).and_then(|value| {
                flushed(&mut out).map_err(stdout_error)?;
                Ok(value)
            });
            return written.map_err(|error| match error {
                error if is_closed(&error) => ClosedPipe.into(),
                // Of the writer: what else may fail has its own words.
                error if error.is::<io::Error>() => error.context("standard output cannot be written"),
                error => error,
            });
        }
        let cannot = || format!("{}: cannot be written", self.path.display());
        if !self.is_replaced() {
            let mut out = BufWriter::new(File::options().write(true).open(&self.path).with_context(cannot)?);
            let value = write(&mut out).with_context(cannot)?;
            out.flush().with_context(cannot)?;
            return Ok(value);
        }
        let mut out = BufWriter::new(self.temporary()?);
        let value = write(&mut out).with_context(cannot)?;
        let temporary = out.into_inner().map_err(io::IntoInnerError::into_error).with_context(cannot)?;
        self.publish(temporary).with_context(cannot)?;
        Ok(value)
    }

    /// Gives what was written its place. A file that is replaced keeps its mode; one of several names, or of another
    /// owner, gets the new content under all of them.
    fn publish(&self, mut temporary: Temporary) -> Result<()> {
        // A signal waits for it.
        let _whole = temporaries::lock();
        let Ok(before) = fs::metadata(&self.path) else {
            return Ok(temporary.persist(&self.path).map(drop)?);
        };
        let now = temporary.as_file().metadata()?;
        let owner = |of: &Metadata| (of.uid(), of.gid());
        if before.nlink() == 1 && owner(&before) == owner(&now) {
            temporary.as_file().set_permissions(before.permissions())?;
            temporary.persist(&self.path)?;
        } else {
            let mut out = File::options().write(true).open(&self.path)?;
            io::Seek::rewind(temporary.as_file_mut())?;
            let bytes = io::copy(temporary.as_file_mut(), &mut out)?;
            out.set_len(bytes)?;
        }
        Ok(())
    }

    /// Devices and pipes are written to; all else is replaced.
    fn is_replaced(&self) -> bool {
        !self.is_stdout && fs::metadata(&self.path).map_or(true, |found| found.is_file())
    }

    fn temporary(&self) -> Result<Temporary> {
        temporaries::file_in(folder_of(&self.path)).map_err(|error| {
            // The crate's message names the temporary file, which nobody asked for.
            let why = match error.kind() {
                io::ErrorKind::NotFound => "there is no such folder".to_owned(),
                kind => kind.to_string(),
            };
            anyhow!("{}: cannot be written: {why}", self.path.display())
        })
    }
}

/// Checks that `path` leads to none of the files `inputs`, by whatever names.
///
/// # Errors
/// If it does.
pub fn check_inputs<P: AsRef<Path>>(path: &Path, inputs: impl IntoIterator<Item = P>) -> Result<()> {
    let identity = |path: &Path| {
        let found = fs::metadata(path).ok().filter(Metadata::is_file)?;
        Some((found.dev(), found.ino()))
    };
    let Some(own) = identity(path) else { return Ok(()) };
    let same = inputs.into_iter().find(|input| identity(input.as_ref()) == Some(own));
    same.map_or(Ok(()), |input| {
        let input = input.as_ref().display();
        bail!("{}: is an input ({input}), which would be lost; name another file", path.display())
    })
}

/// The folder that a file of this path lies in.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Where a path leads, behind all links.
fn behind_links(path: &Path) -> Result<PathBuf> {
    let mut behind = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&behind) else { return Ok(fs::canonicalize(&behind).unwrap_or(behind)) };
        behind = behind.parent().unwrap_or(Path::new("")).join(next);
    }
    ensure!(behind.exists(), "{}: the link leads to itself", path.display());
    Ok(behind)
}

/// Whether standard output was closed by its reader.
fn is_closed(error: &Error) -> bool {
    error.is::<ClosedPipe>()
        || error
            .chain()
            .filter_map(|cause| cause.downcast_ref::<io::Error>())
            .any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
