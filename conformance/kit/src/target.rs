//! The implementation under test as a person names it: a folder with `dut.toml`, a command line, or one of the
//! oracles.

use crate::chip::Chip;
use crate::chip::config::MAX_TOLERANCE;
use crate::dut::{Dut, InProcess};
use crate::error::Error;
use crate::kind::{Kind, Oracle};
use crate::kinds::{KINDS, kind_named};
use crate::prove::config::ProveConfig;
use crate::vm::Vm;
use serde::Deserialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::time::Duration;

/// Seconds that a session may take where nothing is said (Assumed).
pub const TIME_LIMIT: f64 = 10.0;

/// Seconds to answer a hello, before a kind is assumed.
const PROBE_LIMIT: f64 = 1.0;

/// Seconds that a build may take where nothing is said (Assumed).
pub const BUILD_LIMIT: f64 = 300.0;

/// Longest time limits in seconds: an hour.
const MAX_TIME_LIMIT: f64 = 3600.0;

/// The file `dut.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DutFile {
    /// The kind, such as `saarcor-vm`.
    pub kind: String,
    /// Programs that building and running need.
    #[serde(default)]
    pub needs: Vec<String>,
    /// Command line that builds the implementation, in the folder of the file.
    pub build: Option<String>,
    /// Seconds that the build may take.
    #[serde(default = "default_build_limit")]
    pub build_limit: f64,
    /// Command line that starts it, in the same folder.
    pub command: Option<String>,
    /// Shared library in the same folder that offers the same as calls.
    pub library: Option<String>,
    /// Seconds that a session may take.
    #[serde(default = "default_time_limit")]
    pub time_limit: f64,
    /// Requests of the random part, for an implementation that is too slow for the usual number.
    pub requests: Option<usize>,
    /// By how many thousandths its timing may be off.
    #[serde(default)]
    pub tolerance: u32,
    /// What a proof has to know of an implementation in Verilog.
    pub prove: Option<ProveConfig>,
}

fn default_time_limit() -> f64 {
    TIME_LIMIT
}

fn default_build_limit() -> f64 {
    BUILD_LIMIT
}

impl DutFile {
    /// The `dut.toml` of a folder.
    ///
    /// # Errors
    /// Where it cannot be read, or is wrong.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let path = folder.join("dut.toml");
        let shown = path.display();
        let text = std::fs::read_to_string(&path)
            .map_err(Error::system(format!("{shown}: cannot be read; a folder is named that has one")))?;
        Self::parse(&text).map_err(|wrong| wrong.within(shown.to_string()))
    }

    /// The file's values.
    ///
    /// # Errors
    /// What is wrong, in which line, and what would be right.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let file: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            Error::Line { line, right: error.message().to_owned() }
        })?;
        if kind_named(&file.kind).is_none() {
            return Err(format!("kind = \"{}\": {}", file.kind, known_kinds()).into());
        }
        match (&file.command, &file.library) {
            (None, None) => {
                return Err("command is missing: the command line that starts the implementation".into());
            }
            (_, Some(_)) if file.kind != Vm.name() => {
                return Err(format!("library: there is one for {} only", Vm.name()).into());
            }
            _ => {}
        }
        match file.tolerance {
            0 => {}
            _ if file.kind != Chip.name() => {
                return Err(format!("tolerance: there is one for {} only", Chip.name()).into());
            }
            1..=MAX_TOLERANCE => {}
            more => return Err(format!("tolerance = {more}: at most {MAX_TOLERANCE} thousandths").into()),
        }
        if let Some(prove) = &file.prove {
            prove.check(&file.kind)?;
        }
        for (key, limit) in [("time_limit", file.time_limit), ("build_limit", file.build_limit)] {
            if !(0.001..=MAX_TIME_LIMIT).contains(&limit) {
                return Err(format!(
                    "{key} = {limit}: it is a number of seconds from 0.001 to {MAX_TIME_LIMIT}"
                )
                .into());
            }
        }
        Ok(file)
    }
}

/// The kinds that there are, in a sentence.
fn known_kinds() -> String {
    let names: Vec<_> = KINDS.iter().map(|kind| kind.name()).collect();
    format!("the kinds are {}", names.join(", "))
}

/// How a target is run.
#[derive(Clone, Debug, Default)]
pub struct TargetOptions {
    /// Seconds that a session may take, in the place of those of `dut.toml`.
    pub time_limit: Option<f64>,
    /// Whether the library of `dut.toml` is run even where there is a command.
    pub takes_library: bool,
    /// Command line that serves the library whose path follows, in its folder.
    pub library_server: String,
}

/// A word as a shell takes it.
#[must_use]
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-=,@+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// An implementation to be run.
pub struct Target {
    /// Its kind, where it is known; else its hello says.
    pub kind: Option<&'static dyn Kind>,
    /// Programs that it needs and that are not there.
    pub missing: Vec<String>,
    /// Requests of the random part, where it asks for a number.
    pub requests: Option<usize>,
    /// By how many thousandths its timing may be off.
    pub tolerance: u32,
    /// The implementation.
    pub dut: Box<dyn Dut>,
    /// The same with a short time limit, to ask for its kind.
    pub probe: Box<dyn Dut>,
    /// The command line that builds it, the folder of that, and the seconds that it may take.
    build: Option<(String, PathBuf, f64)>,
    /// The shared library, where it is what is run.
    library: Option<PathBuf>,
}

impl Target {
    /// What `name` names: `model` or `naive`, a folder with `dut.toml`, or else a command line, which is text.
    ///
    /// # Errors
    /// Where `dut.toml` cannot be read, or is wrong.
    pub fn open(name: impl AsRef<OsStr>, how: &TargetOptions) -> Result<Self, Error> {
        let (folder, name) = (Path::new(&name), name.as_ref().to_string_lossy());
        let name = &*name;
        let oracle = match name {
            "model" => Some(Oracle::Model),
            "naive" => Some(Oracle::Naive),
            _ => None,
        };
        let target = |dut: Box<dyn Dut>, probe: Box<dyn Dut>| Self {
            kind: None,
            missing: Vec::new(),
            requests: None,
            tolerance: 0,
            dut,
            probe,
            build: None,
            library: None,
        };
        if let Some(oracle) = oracle {
            let dut = || Box::new(InProcess::oracle(oracle));
            if how.takes_library {
                return Err(Error::from("has no library").within(name));
            }
            return Ok(target(dut(), dut()));
        }
        if !folder.is_dir() {
            if folder.to_str().is_none() {
                return Err(Error::from("no folder, and a command line has to be UTF-8").within(name));
            }
            if name.trim().is_empty() {
                return Err("no implementation: name a folder with dut.toml, or a command line".into());
            }
            let limit = how.time_limit.unwrap_or(TIME_LIMIT);
            if how.takes_library {
                return Err(Error::from("a library is named by the dut.toml of a folder").within(name));
            }
            let process = |limit| process(name.to_owned(), None, limit);
            return Ok(target(process(limit)?, process(limit.min(PROBE_LIMIT))?));
        }
        let path = folder.join("dut.toml");
        let shown = path.display();
        let file = DutFile::read(folder)?;
        let limit = how.time_limit.unwrap_or(file.time_limit);
        let (command, library) = match (file.command, file.library) {
            (_, None) if how.takes_library => {
                return Err(Error::from("names no library").within(shown.to_string()));
            }
            (Some(command), _) if !how.takes_library => (command, None),
            (_, library) => {
                let library = library.unwrap_or_default();
                let command = format!("exec {} {}", how.library_server, shell_word(&library));
                (command, Some(folder.join(library)))
            }
        };
        Ok(Self {
            kind: kind_named(&file.kind),
            missing: file.needs.into_iter().filter(|program| !is_there(program)).collect(),
            requests: file.requests,
            tolerance: file.tolerance,
            dut: process(command.clone(), Some(folder.to_owned()), limit)?,
            probe: process(command, Some(folder.to_owned()), limit.min(PROBE_LIMIT))?,
            build: file.build.map(|build| (build, folder.to_owned(), file.build_limit)),
            library,
        })
    }

    /// Builds the implementation, where `dut.toml` says how.
    ///
    /// # Errors
    /// Where the build fails, with the end of its output; where it takes too long, or writes without end; where the
    /// library is not there behind it.
    #[cfg(unix)]
    pub fn build(&self) -> Result<(), Error> {
        if let Some((command, folder, limit)) = &self.build {
            let time_limit = duration(*limit)?;
            crate::build::Build { command: command.clone(), folder: folder.clone(), time_limit }.run()?;
        }
        match &self.library {
            Some(library) if !library.is_file() => {
                Err(Error::from("the library of dut.toml is not there").within(library.display().to_string()))
            }
            _ => Ok(()),
        }
    }

    /// Builds the implementation, where `dut.toml` says how.
    ///
    /// # Errors
    /// Always, where something is to be built: only Unix is supported.
    #[cfg(not(unix))]
    pub fn build(&self) -> Result<(), Error> {
        if self.build.is_some() { Err("builds are run on Unix only".into()) } else { Ok(()) }
    }
}

#[cfg(unix)]
fn process(command: String, folder: Option<PathBuf>, limit: f64) -> Result<Box<dyn Dut>, Error> {
    Ok(Box::new(crate::process::Process::new(command, folder, duration(limit)?)))
}

#[cfg(unix)]
fn duration(seconds: f64) -> Result<Duration, Error> {
    Duration::try_from_secs_f64(seconds).map_err(|error| format!("time limit: {error}").into())
}

#[cfg(not(unix))]
fn process(_: String, _: Option<PathBuf>, _: f64) -> Result<Box<dyn Dut>, Error> {
    Err("implementations are started as processes on Unix only".into())
}

/// Whether a program is in the path, or is a path itself, and may be executed.
pub(crate) fn is_there(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .any(|file| file.is_file() && is_executable(&file))
}

#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    rustix::fs::access(file, rustix::fs::Access::EXEC_OK).is_ok()
}

#[cfg(not(unix))]
fn is_executable(_: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read() {
        let text = "kind = \"saarcor-vm\"\ncommand = \"./cache\"\nneeds = [\"cc\"]\nbuild = \"cc -o cache cache.c\"\n";
        let file = DutFile::parse(text).expect("right");
        assert_eq!((file.time_limit, file.requests, file.needs), (TIME_LIMIT, None, vec!["cc".to_owned()]));
    }

    #[test]
    fn wrong_files_are_refused() {
        let whole = "kind = \"saarcor-vm\"\ncommand = \"./cache\"\ntime_limit = 1\n";
        for (from, to, says) in [
            ("saarcor-vm", "saarcor", "saarcor-vm"),
            ("command =", "comand =", "line 2"),
            ("= 1", "= -1", "seconds"),
            ("= 1", "= nan", "seconds"),
            ("= 1", "= 'a", "line 3"),
            ("time_limit = 1", "build_limit = 1e9", "build_limit = 1000000000: it is"),
            ("command", "#", "command"),
            ("command = ", "kind = 'saarcor-hash'\nlibrary = ", "duplicate"),
            ("command = \"./cache\"", "", "command is missing"),
            ("command =", "tolerance = 5\ncommand =", "saarcor-chip only"),
            ("-vm\"\n", "-chip\"\ntolerance = 101\n", "at most 100"),
        ] {
            let error = DutFile::parse(&whole.replace(from, to)).expect_err("wrong").to_string();
            assert!(error.contains(says), "{from} -> {to}: {error}");
        }
    }

    #[test]
    fn programs_are_looked_for() {
        assert!(is_there("sh") && !is_there("no-such-program"));
        // It is there, and may not be executed.
        assert!(!is_there("/etc/passwd"));
    }
}
