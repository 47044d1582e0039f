//! Runs Embree, in a Python environment that is made when it is first needed.

use super::{
    FLAGS, Hit, RAYS, REQUIREMENTS, SCRIPT, TRIANGLES, decode_answers, encode_rays, encode_triangles,
};
use glam::Vec3;
use saarcor_model::rays::Ray;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where environments are kept, from the folder on in which the program runs.
pub const ENVIRONMENTS: &str = "target/embree";

/// Names the Python interpreter from which an environment is made.
const PYTHON: &str = "SAARCOR_PYTHON";

/// Why Embree gives no answers.
#[derive(Debug, thiserror::Error)]
pub enum EmbreeError {
    /// Embree is not there, or does not run: what needs it stays undecided.
    #[error("Embree: {0}")]
    Absent(String),
    /// The folder in which the program runs is not known.
    #[error("the folder in which the program runs")]
    CurrentFolder(#[source] io::Error),
    /// The questions to Embree have no folder.
    #[error("a folder for Embree's questions")]
    Folder(#[source] io::Error),
    /// The questions to Embree cannot be written.
    #[error("{}: cannot be written", path.display())]
    Questions {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// What Embree answers to each ray: with its flag for robust intersection, and by default.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbreeAnswers {
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
    /// The environment under `folder` with the packages of [`REQUIREMENTS`], if there is one. It is
    /// named after them, and so a new version needs a new one.
    ///
    /// # Errors
    /// If the folder in which the program runs is not known.
    pub fn find(folder: &Path) -> Result<Option<Self>, EmbreeError> {
        let python = interpreter(&environment(folder));
        if !python.exists() {
            return Ok(None);
        }
        // Python resolves its environment from the path by which it is called.
        let python = std::path::absolute(&python).map_err(EmbreeError::CurrentFolder)?;
        Ok(Some(Self { python }))
    }

    /// Makes the environment that [`Embree::find`] looks for. What fails leaves nothing behind.
    ///
    /// # Errors
    /// [`EmbreeError::Absent`] if there is no Python, or it cannot get the packages.
    pub fn make(folder: &Path) -> Result<Self, EmbreeError> {
        make(folder, &environment(folder))?;
        let absent = || EmbreeError::Absent("its environment has no Python".to_owned());
        Self::find(folder)?.ok_or_else(absent)
    }

    /// What Embree says that each ray hits first. Rays begin at distance 0.
    ///
    /// # Errors
    /// [`EmbreeError::Absent`] if it does not run.
    pub fn intersect(&self, triangles: &[[Vec3; 3]], rays: &[Ray]) -> Result<EmbreeAnswers, EmbreeError> {
        let folder = tempfile::Builder::new().prefix(&temporary_prefix()).tempdir();
        let folder = folder.map_err(EmbreeError::Folder)?;
        let file = |name: &str| folder.path().join(name);
        let script = file("intersect.py");
        let questions = [(TRIANGLES, encode_triangles(triangles)), (RAYS, encode_rays(rays))]
            .map(|(name, bytes)| (file(name), bytes));
        for (path, bytes) in questions.iter().chain([&(script.clone(), SCRIPT.as_bytes().to_vec())]) {
            let failed = |source| EmbreeError::Questions { path: path.clone(), source };
            fs::write(path, bytes).map_err(failed)?;
        }
        run(Command::new(&self.python).arg("-I").arg(&script).arg(folder.path()), "its script failed")?;
        let answers = |name: &str| {
            let bytes =
                fs::read(file(name)).map_err(|error| EmbreeError::Absent(format!("no answers: {error}")))?;
            let answers = decode_answers(&bytes, rays.len(), triangles.len());
            answers.ok_or_else(|| EmbreeError::Absent(format!("its answers '{name}' are not one a ray")))
        };
        let [robust, fast] = FLAGS.map(answers);
        Ok(EmbreeAnswers { robust: robust?, fast: fast? })
    }
}

/// What the names of temporary folders begin with, those of the system and those beside the environment: by it the command line
/// removes them where a signal ends the process.
fn temporary_prefix() -> String {
    format!(".saarcor-{}-", std::process::id())
}

/// The environment with the packages of [`REQUIREMENTS`].
fn environment(folder: &Path) -> PathBuf {
    folder.join(REQUIREMENTS.trim().replace("==", "-").replace('\n', "-"))
}

/// The Python of an environment.
fn interpreter(environment: &Path) -> PathBuf {
    environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// Makes `environment`, in `folder`.
fn make(folder: &Path, environment: &Path) -> Result<(), EmbreeError> {
    let new_folders: Vec<_> = folder.ancestors().take_while(|folder| !folder.exists()).collect();
    let made = make_aside(folder, environment);
    if made.is_err() {
        // Only those that are empty go.
        new_folders.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
    made
}

/// Makes the environment beside its place and moves it there when it is whole: one that is there
/// has all its packages.
fn make_aside(folder: &Path, environment: &Path) -> Result<(), EmbreeError> {
    let cannot =
        |error: io::Error| EmbreeError::Absent(format!("{}: cannot be written: {error}", folder.display()));
    fs::create_dir_all(folder).map_err(cannot)?;
    let aside = tempfile::Builder::new().prefix(&temporary_prefix()).tempdir_in(folder).map_err(cannot)?;
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
fn run(command: &mut Command, what: &str) -> Result<(), EmbreeError> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|error| {
        EmbreeError::Absent(format!("{program} does not start: {error} ({PYTHON} names a Python 3)"))
    })?;
    if output.status.success() {
        return Ok(());
    }
    // Python's own tools say on standard output why they fail, if they say nothing on the other.
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let last = said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("it says nothing");
    Err(EmbreeError::Absent(format!("{what}: {last}")))
}
