//! Runs Embree, in a Python environment that is made when it is first needed.

use crate::progress::Progress;
use anyhow::{Context, Result};
use glam::Vec3;
use saarcor_model::rays::Ray;
use saarcor_oracles::embree::{
    FLAGS, Hit, RAYS, REQUIREMENTS, SCRIPT, TRIANGLES, decode_answers, encode_rays, encode_triangles,
};
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where environments are kept, from the folder on in which the program runs.
pub const ENVIRONMENTS: &str = "target/embree";

/// Names the Python interpreter from which an environment is made.
const PYTHON: &str = "SAARCOR_PYTHON";

/// Embree is not there, or does not run: what needs it stays undecided.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Absent(String);

impl fmt::Display for Absent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Embree: {}", self.0)
    }
}

impl std::error::Error for Absent {}

/// What Embree answers to each ray: with its flag for robust intersection, and by default.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    /// With the flag.
    pub robust: Vec<Option<Hit>>,
    /// Without.
    pub fast: Vec<Option<Hit>>,
}

/// A Python that has Embree.
#[derive(Clone, Debug)]
pub struct Embree {
    python: PathBuf,
}

impl Embree {
    /// The environment under `folder` with the packages of [`REQUIREMENTS`], which is made if it is
    /// not there yet: it is named after them, and so a new version makes a new one. What fails leaves
    /// nothing behind.
    ///
    /// # Errors
    /// [`Absent`] if there is no Python, or it cannot get the packages.
    pub fn open(folder: &Path, progress: &Progress) -> Result<Self> {
        let environment = folder.join(REQUIREMENTS.trim().replace("==", "-").replace('\n', "-"));
        let python = interpreter(&environment);
        if !python.exists() {
            progress.during("Embree: its Python environment", |_| make(folder, &environment))?;
        }
        // Python resolves its environment from the path by which it is called.
        let python = std::path::absolute(&python).context("the folder in which the program runs")?;
        Ok(Self { python })
    }

    /// What Embree says that each ray hits first. Rays begin at distance 0.
    ///
    /// # Errors
    /// [`Absent`] if it does not run.
    pub fn intersect(&self, triangles: &[[Vec3; 3]], rays: &[Ray]) -> Result<Answers> {
        let folder = tempfile::tempdir().context("a folder for Embree's questions")?;
        let file = |name: &str| folder.path().join(name);
        let script = file("intersect.py");
        let questions = [(TRIANGLES, encode_triangles(triangles)), (RAYS, encode_rays(rays))]
            .map(|(name, bytes)| (file(name), bytes));
        for (path, bytes) in questions.iter().chain([&(script.clone(), SCRIPT.as_bytes().to_vec())]) {
            fs::write(path, bytes).with_context(|| format!("{}: cannot be written", path.display()))?;
        }
        run(Command::new(&self.python).arg("-I").arg(&script).arg(folder.path()), "its script failed")?;
        let answers = |name: &str| {
            let bytes = fs::read(file(name)).map_err(|error| Absent(format!("no answers: {error}")))?;
            let answers = decode_answers(&bytes, rays.len(), triangles.len());
            answers.ok_or_else(|| Absent(format!("its answers '{name}' are not one a ray")))
        };
        let [robust, fast] = FLAGS.map(answers);
        Ok(Answers { robust: robust?, fast: fast? })
    }
}

/// The Python of an environment.
fn interpreter(environment: &Path) -> PathBuf {
    environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// Makes `environment`, in `folder`.
fn make(folder: &Path, environment: &Path) -> Result<()> {
    let new_folders: Vec<_> = folder.ancestors().take_while(|folder| !folder.exists()).collect();
    let made = make_aside(folder, environment);
    if made.is_err() {
        // Only those that are empty go.
        new_folders.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
    Ok(made?)
}

/// Makes the environment beside its place and moves it there when it is whole: one that is there
/// has all its packages.
fn make_aside(folder: &Path, environment: &Path) -> Result<(), Absent> {
    let cannot = |error: io::Error| Absent(format!("{}: cannot be written: {error}", folder.display()));
    fs::create_dir_all(folder).map_err(cannot)?;
    let aside = tempfile::Builder::new().prefix(".making-").tempdir_in(folder).map_err(cannot)?;
    let requirements = aside.path().join("requirements.txt");
    fs::write(&requirements, REQUIREMENTS).map_err(cannot)?;
    let new = aside.path().join("environment");
    let base = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    run(Command::new(base).args(["-I", "-m", "venv"]).arg(&new), "Python makes no environment")?;
    // Wheels only: nothing is compiled. Without a network one more try is enough.
    let pip = ["-I", "-m", "pip", "--disable-pip-version-check", "--no-input", "--quiet", "install"];
    let options = ["--only-binary", ":all:", "--retries", "1", "--timeout", "15", "--requirement"];
    run(
        Command::new(interpreter(&new)).args(pip).args(options).arg(requirements),
        "its packages cannot be installed",
    )?;
    match fs::rename(&new, environment) {
        // Someone else was faster.
        Err(_) if interpreter(environment).exists() => Ok(()),
        moved => moved.map_err(cannot),
    }
}

/// Runs `command` to its end; what it says goes into the error.
fn run(command: &mut Command, what: &str) -> Result<(), Absent> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.stdin(Stdio::null()).output();
    let output = output
        .map_err(|error| Absent(format!("{program} does not start: {error} ({PYTHON} names a Python 3)")))?;
    if output.status.success() {
        return Ok(());
    }
    // Python's own tools say on standard output why they fail, if they say nothing on the other.
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let last = said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("it says nothing");
    Err(Absent(format!("{what}: {last}")))
}
