//! The programs that prove: Yosys, ABC and a solver, as they lie in the path.

use crate::children::ProcessGroup;
use crate::error::Error;
use crate::target::is_there;
use std::fs::File;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// The folder of an environment of Python in which a solver may be, beside the path.
pub const ENVIRONMENT: &str = "target/prove/bin";
/// Time between two looks at a program.
const POLL: Duration = Duration::from_millis(10);

/// Names of programs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tools {
    /// ABC.
    pub abc: &'static str,
    /// The solver, as `yosys-smtbmc -s` names it.
    pub solver: &'static str,
}

impl Tools {
    /// Those that are in the path, or in [`ENVIRONMENT`].
    ///
    /// # Errors
    /// What is missing.
    pub fn find() -> Result<Self, Vec<&'static str>> {
        let is_there = |program: &str| is_there(program) || Path::new(ENVIRONMENT).join(program).is_file();
        let first = |programs: &[(&str, &'static str)]| {
            programs.iter().find(|(program, _)| is_there(program)).map(|(_, name)| *name)
        };
        let abc = first(&[("yosys-abc", "yosys-abc"), ("berkeley-abc", "berkeley-abc")]);
        let solver = first(&[("yices-smt2", "yices"), ("z3", "z3"), ("boolector", "boolector")]);
        let mut missing: Vec<_> =
            ["yosys", "yosys-smtbmc"].into_iter().filter(|program| !is_there(program)).collect();
        missing.extend(abc.is_none().then_some("berkeley-abc"));
        missing.extend(solver.is_none().then_some("a solver (yices-smt2, z3 or boolector)"));
        match (abc, solver) {
            (Some(abc), Some(solver)) if missing.is_empty() => Ok(Self { abc, solver }),
            _ => Err(missing),
        }
    }
}

/// What a program did.
#[derive(Clone, Debug)]
pub(super) struct Ran {
    /// Whether it ended with status 0.
    pub succeeded: bool,
    /// Whether it was ended at its limit.
    pub timed_out: bool,
    /// What it wrote, errors too.
    pub text: String,
    /// Seconds that it took.
    pub seconds: f64,
}

/// Runs a command line in a folder, where what it writes is kept as `NAME.log`.
pub(super) fn run(command: &str, folder: &Path, name: &str, limit: Duration) -> Result<Ran, Error> {
    let log = folder.join(format!("{name}.log"));
    let cannot = || format!("{}: cannot be written", log.display());
    let file = File::create(&log).map_err(Error::system(cannot()))?;
    let errors = file.try_clone().map_err(Error::system(cannot()))?;
    let begin = Instant::now();
    let group = ProcessGroup::start(command, Some(folder), |command| {
        command.stdin(Stdio::null()).stdout(file).stderr(errors);
        let path = std::env::var_os("PATH").unwrap_or_default();
        let here = std::env::current_dir().map(|here| here.join(ENVIRONMENT)).into_iter();
        // A folder whose name cannot stand in the path is left out.
        if let Ok(path) = std::env::join_paths(std::env::split_paths(&path).chain(here)) {
            command.env("PATH", path);
        }
    })?;
    let end = loop {
        match group.end()? {
            Some(end) => break Some(end),
            None if begin.elapsed() >= limit => break None,
            None => std::thread::sleep(POLL),
        }
    };
    drop(group);
    let text = std::fs::read(&log).map_err(Error::system(format!("{}: cannot be read", log.display())))?;
    Ok(Ran {
        succeeded: end.is_some_and(|end| end.is_success()),
        timed_out: end.is_none(),
        text: String::from_utf8_lossy(&text).into_owned(),
        seconds: begin.elapsed().as_secs_f64(),
    })
}
