//! `saarcor conform`.

use crate::conform::{hard, page, text};
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::Progress;
use crate::status::Status;
use anyhow::{Context, Result, bail, ensure};
use clap::Subcommand;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use saarcor_kit::kd::Kd;
use saarcor_kit::kind::Kind;
use saarcor_kit::kinds::{KINDS, kind_named};
use saarcor_kit::level::Level;
use saarcor_kit::plan::{ERRORS, Options, PlannedSession, RANDOM_REQUESTS, default_suite, sessions_named};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict};
use saarcor_kit::run::{kind_of, run};
use saarcor_kit::scoreboard::check_answers;
use saarcor_kit::session::Session;
use saarcor_kit::target::{Target, TargetOptions, shell_word as quoted};
use saarcor_kit::templates::{TEMPLATES, faults};
use saarcor_kit::vm::{Vm, trace};
use saarcor_kit::{children, shared_library};
use saarcor_studies::accuracy::suites::SUITES;
use saarcor_studies::names::nearest;
use std::fs;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Whether another implementation of the virtual memory is right, and if not, where
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Run(RunArgs),
    Generate(GenerateArgs),
    Check(CheckArgs),
    List(ListArgs),
    ServeLibrary(ServeLibraryArgs),
    New(NewArgs),
}

impl Args {
    /// Does what was asked for.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        match self.verb {
            Verb::Run(args) => args.run(progress),
            Verb::Generate(args) => args.run(),
            Verb::Check(args) => args.run(),
            Verb::List(args) => args.run(),
            Verb::ServeLibrary(args) => args.run(),
            Verb::New(args) => args.run(progress),
        }
    }
}

fn level(name: String) -> Level {
    Level::ALL.into_iter().find(|level| level.name() == name).expect("the parser lets only these names pass")
}

fn levels() -> impl clap::builder::TypedValueParser<Value = Level> {
    PossibleValuesParser::new(Level::ALL.map(Level::name)).map(level)
}

/// Runs the suites with an implementation, and says at which level it conforms
#[derive(Debug, clap::Args)]
struct RunArgs {
    /// A folder with dut.toml, a command line in quotes, or 'model' or 'naive'
    #[arg(value_name = "DUT")]
    dut: String,
    /// The kind, for a command line that speaks several [default: what dut.toml says, else the first it answers]
    #[arg(long, value_parser = PossibleValuesParser::new(KINDS.iter().map(|kind| kind.name())))]
    kind: Option<String>,
    /// The highest level to judge [default: all that the implementation observes]
    #[arg(long, value_parser = levels())]
    level: Option<Level>,
    /// Runs only this suite, random session or file; can be given several times
    #[arg(long, value_name = "SUITE")]
    suite: Vec<String>,
    /// Plays a trace of a frame, as 'trace record --format din' writes it; can be given several times
    #[arg(long, value_name = "FILE")]
    trace: Vec<PathBuf>,
    /// Runs the shared library that dut.toml names, and not its command
    #[arg(long)]
    library: bool,
    /// Stops after N sessions that fail
    #[arg(long, value_name = "N", default_value_t = ERRORS as u32, value_parser = clap::value_parser!(u32).range(1..))]
    errors: u32,
    /// First seed of the random sessions
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Requests of the random sessions together [default: what dut.toml asks for, else 2000000]
    #[arg(long, value_name = "N")]
    requests: Option<u32>,
    /// Seconds that a session may take [default: what dut.toml says, else 10]
    #[arg(long, value_name = "S")]
    time_limit: Option<f64>,
    /// Prints the report as one JSON object
    #[arg(long)]
    json: bool,
    /// Writes the report as JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Writes the report as an HTML page that needs no other file
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Where the shortest sessions that fail are kept
    #[arg(long, value_name = "DIR", default_value = "target/conform")]
    keep: PathBuf,
}

impl RunArgs {
    fn run(self, progress: &Progress) -> Result<Status> {
        if let Some(limit) = self.time_limit {
            ensure!(limit > 0.0 && limit <= 3600.0, "--time-limit {limit}: write seconds, up to 3600");
        }
        let junit = self.junit.as_deref().map(OutFile::check).transpose()?;
        let html = self.html.as_deref().map(OutFile::check).transpose()?;
        let named = self.suite.iter().map(|name| named(name, self.random_requests(None)));
        let traces = self.trace.iter().map(|path| traced(path));
        let named = named.chain(traces).collect::<Result<Vec<_>>>()?;
        let program = std::env::current_exe().context("the path of this program")?;
        let target = Target::open(
            &self.dut,
            &TargetOptions {
                time_limit: self.time_limit,
                takes_library: self.library,
                library_server: format!("{} conform serve-library", quoted(&program.display().to_string())),
            },
        )?;
        if !target.missing.is_empty() {
            let missing = target.missing.join(", ");
            // An error that is no bad input; where standard error is closed, the status has to do.
            let _ =
                writeln!(std::io::stderr(), "saarcor: {}: needs {missing}, not found in the path", self.dut);
            return Ok(Status::Incomplete);
        }
        children::adopt_strays();
        children::kill_all_when_ended()?;
        let report = target.build().map_err(Into::into).and_then(|()| self.report(&target, named, progress));
        children::kill_strays();
        let mut report = report?;
        self.keep_minimal(&mut report)?;
        if let Some(file) = junit {
            let text = report.junit(SystemTime::now())?;
            file.write(|out| Ok(out.write_all(text.as_bytes())?))?;
        }
        if let Some(file) = html {
            let page = page::html(&report);
            file.write(|out| Ok(out.write_all(page.as_bytes())?))?;
        }
        let mut out = Stdout::new();
        if self.json {
            json_line(&mut out, &report)?;
        } else {
            out.line(text::text(&report).trim_end())?;
        }
        out.finish()?;
        Ok(match report.verdict {
            ConformanceVerdict::Conforms => Status::Holds,
            ConformanceVerdict::DoesNotConform => Status::Disproved,
            ConformanceVerdict::Incomplete => Status::Incomplete,
        })
    }

    fn random_requests(&self, target: Option<usize>) -> usize {
        self.requests.map(|requests| requests as usize).or(target).unwrap_or(RANDOM_REQUESTS)
    }

    fn report(
        &self,
        target: &Target,
        named: Vec<(&'static dyn Kind, Vec<Session>)>,
        progress: &Progress,
    ) -> Result<ConformanceReport> {
        let dut = &*target.dut;
        let kind = match self.kind.as_deref().and_then(kind_named).or(target.kind) {
            Some(kind) => kind,
            // One that answers no hello fails at it, whatever the kind.
            None => kind_of(&*target.probe)?.unwrap_or(KINDS[0]),
        };
        if let Some(level) = self.level {
            let known: Vec<_> = kind.levels().iter().map(|level| level.name()).collect();
            ensure!(
                kind.levels().contains(&level),
                "--level {level}: those of {} are {}",
                kind.name(),
                known.join(", ")
            );
        }
        let options = Options {
            level: self.level,
            errors: self.errors as usize,
            seed: self.seed,
            requests: self.random_requests(target.requests),
            tolerance: target.tolerance,
        };
        let mut planned = Vec::new();
        for (of, sessions) in named {
            ensure!(
                of.name() == kind.name(),
                "a suite of {} for an implementation of {}",
                of.name(),
                kind.name()
            );
            planned.extend(sessions.into_iter().map(|session| PlannedSession::Directed(Box::new(session))));
        }
        if planned.is_empty() {
            planned = default_suite(kind, &options)?;
            if kind.name() == Kd.name() {
                let sessions = hard::all(self.seed).into_iter();
                planned.extend(sessions.map(|session| PlannedSession::Directed(Box::new(session))));
            }
        }
        let report = progress
            .during(&format!("{} sessions of {}", planned.len(), kind.name()), |report| {
                run(&self.dut, dut, kind, &planned, &options, report)
            })?;
        Ok(report)
    }

    /// Writes the shortest sessions that fail, and the commands that run them again.
    fn keep_minimal(&self, report: &mut ConformanceReport) -> Result<()> {
        for (failure, number) in report.failures.iter_mut().zip(1..) {
            fs::create_dir_all(&self.keep)
                .with_context(|| format!("{}: cannot be made", self.keep.display()))?;
            let name =
                format!("{number}-{}-{}.txt", failure.requirement, failure.session.replace(['/', '@'], "-"));
            let path = self
                .keep
                .join(name.replace(|c: char| !(c.is_ascii_alphanumeric() || "-._=,".contains(c)), "-"));
            OutFile::check(&path)?.write(|out| Ok(out.write_all(&failure.suite)?))?;
            failure.replay = Some(format!(
                "saarcor conform run {}{} --suite {}",
                quoted(&self.dut),
                if self.library { " --library" } else { "" },
                quoted(&path.display().to_string())
            ));
        }
        Ok(())
    }
}

/// The sessions of a suite's name, which may be mistyped.
fn named(name: &str, requests: usize) -> Result<(&'static dyn Kind, Vec<Session>)> {
    let hard = hard::named(name, 0);
    if !hard.is_empty() {
        return Ok((&Kd, hard));
    }
    if !Path::new(name).exists() {
        let known: Vec<&str> = KINDS.iter().flat_map(|kind| kind.suites()).map(|(name, _)| *name).collect();
        if let (Err(error), Some(near)) = (sessions_named(name, requests), nearest(name, known)) {
            bail!("{error}: did you mean '{near}'?");
        }
    }
    Ok(sessions_named(name, requests)?)
}

/// The sessions of a trace.
fn traced(path: &Path) -> Result<(&'static dyn Kind, Vec<Session>)> {
    let shown = path.display();
    let text = fs::read_to_string(path).with_context(|| format!("{shown}: cannot be read"))?;
    let addresses = trace::parse_din(&text).with_context(|| shown.to_string())?;
    ensure!(!addresses.is_empty(), "{shown}: has no reads");
    Ok((&Vm, trace::sessions(&shown.to_string(), Vm.hello(), &addresses, usize::MAX)))
}

/// Holds one conversation with a shared library over standard input and output, as 'run' does
#[derive(Debug, clap::Args)]
struct ServeLibraryArgs {
    /// A library with the functions of saarcor.h
    #[arg(value_name = "FILE")]
    library: PathBuf,
}

impl ServeLibraryArgs {
    fn run(self) -> Result<Status> {
        // A path without a folder would be looked for where the system keeps its libraries.
        let path = fs::canonicalize(&self.library)
            .with_context(|| format!("{}: cannot be read", self.library.display()))?;
        shared_library::serve(&path, std::io::stdin().lock(), std::io::stdout().lock())?;
        Ok(Status::Holds)
    }
}

/// Writes the requests of a suite, for an implementation to answer
#[derive(Debug, clap::Args)]
struct GenerateArgs {
    #[command(flatten)]
    suite: SuiteArgs,
}

#[derive(Debug, clap::Args)]
struct SuiteArgs {
    /// A suite or one of its sessions, a random session such as vm/random/17, or a file
    #[arg(value_name = "SUITE")]
    suite: String,
    /// Requests of a random session
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    requests: u32,
}

impl SuiteArgs {
    /// The first session of that name: a conversation has one configuration.
    fn session(&self) -> Result<(&'static dyn Kind, Session)> {
        let (kind, sessions) = named(&self.suite, self.requests as usize)?;
        let session = sessions.into_iter().next().context("a suite has a session")?;
        Ok((kind, session))
    }
}

impl GenerateArgs {
    fn run(self) -> Result<Status> {
        let (_, session) = self.suite.session()?;
        let mut out = Stdout::new();
        out.line(String::from_utf8_lossy(session.text()).trim_end())?;
        out.finish()?;
        Ok(Status::Holds)
    }
}

/// Compares the answers to the requests of a suite
#[derive(Debug, clap::Args)]
struct CheckArgs {
    #[command(flatten)]
    suite: SuiteArgs,
    /// The answers; '-' is stdin
    #[arg(value_name = "ANSWERS")]
    answers: PathBuf,
    /// The highest level to judge
    #[arg(long, value_parser = levels(), default_value = Level::HIGHEST.name())]
    level: Level,
    /// Prints the differences as lines of JSON
    #[arg(long)]
    json: bool,
}

impl CheckArgs {
    fn run(self) -> Result<Status> {
        let (kind, session) = self.suite.session()?;
        let mut answers = Vec::new();
        if self.answers == Path::new("-") {
            std::io::stdin().lock().read_to_end(&mut answers).context("standard input cannot be read")?;
        } else {
            answers = fs::read(&self.answers)
                .with_context(|| format!("{}: cannot be read", self.answers.display()))?;
        }
        let checked = check_answers(kind, &session, &answers, self.level);
        let mut out = Stdout::new();
        for finding in &checked.findings {
            if self.json {
                json_line(&mut out, finding)?;
            } else {
                out.line(text::finding(finding))?;
            }
        }
        if !self.json {
            out.line(text::checked(&checked, &session.name))?;
        }
        out.finish()?;
        Ok(match (checked.findings.is_empty(), &checked.unsupported) {
            (false, _) => Status::Disproved,
            (true, Some(_)) => Status::Incomplete,
            (true, None) => Status::Holds,
        })
    }
}

/// The suites, and what each is about
#[derive(Debug, clap::Args)]
struct ListArgs {
    /// Lists the faults that 'conform new --fault' plants, and the requirement that each breaks
    #[arg(long)]
    faults: bool,
}

impl ListArgs {
    fn run(self) -> Result<Status> {
        let mut out = Stdout::new();
        if self.faults {
            for fault in faults()? {
                out.line(format_args!("{:<6} {:<32} {}", fault.requirement, fault.name, fault.says))?;
            }
        } else {
            for kind in KINDS {
                for (name, text) in kind.suites() {
                    let sessions = Session::parse(name, text).with_context(|| format!("suite {name}"))?;
                    let Some(first) = sessions.first() else { continue };
                    let requirement = first.requirement.as_deref().unwrap_or_default();
                    out.line(format_args!("{requirement:<6} {name:<36} {}", first.idea))?;
                }
            }
            for suite in &SUITES {
                let name = format!("{}{}", hard::PREFIX, suite.name);
                out.line(format_args!("{:<6} {name:<36} {}.", "all", suite.idea))?;
            }
            for kind in KINDS {
                let name = format!("{}/random/SEED", kind.prefix());
                out.line(format_args!("{:<6} {name:<36} Random requests that collide.", "all"))?;
            }
        }
        out.finish()?;
        Ok(Status::Holds)
    }
}

/// Copies an implementation to begin with
#[derive(Debug, clap::Args)]
struct NewArgs {
    /// The language
    #[arg(value_parser = PossibleValuesParser::new(TEMPLATES.iter().map(|template| template.name)))]
    template: String,
    /// The folder, which must not be there yet
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Plants a fault into it, to see how it is found ('saarcor conform list --faults' names them)
    #[arg(long, value_name = "NAME")]
    fault: Option<String>,
}

impl NewArgs {
    fn run(self, progress: &Progress) -> Result<Status> {
        let template = TEMPLATES.iter().find(|template| template.name == self.template);
        let template = template.context("the parser lets only these names pass")?;
        let files = match &self.fault {
            None => template.files(),
            Some(name) => {
                let faults = faults()?;
                let fault = faults.iter().find(|fault| fault.name == *name).with_context(|| {
                    let near = nearest(name, faults.iter().map(|fault| fault.name.as_str()));
                    let hint = near.map_or_else(String::new, |near| format!(": did you mean '{near}'?"));
                    format!("no fault '{name}'{hint} ('saarcor conform list --faults' lists all)")
                })?;
                template.with_fault(fault)?
            }
        };
        let shown = self.folder.display();
        ensure!(!self.folder.exists(), "{shown}: is there already; name a new folder");
        let parent = match self.folder.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        // All or nothing: the folder takes its name when it is whole.
        let cannot = || format!("{shown}: cannot be written");
        let whole = tempfile::Builder::new().prefix(".saarcor-").tempdir_in(parent).with_context(cannot)?;
        for (name, text) in files {
            let path = whole.path().join(name);
            if let Some(folder) = path.parent() {
                fs::create_dir_all(folder).with_context(cannot)?;
            }
            let mut file = fs::File::create(path).with_context(cannot)?;
            file.write_all(text.as_bytes()).with_context(cannot)?;
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // What a folder has that is simply created, but for the user's mask, which is not known.
            fs::set_permissions(whole.path(), fs::Permissions::from_mode(0o755)).with_context(cannot)?;
        }
        fs::rename(whole.path(), &self.folder).with_context(cannot)?;
        let _ = whole.keep();
        progress.say(format_args!("{shown}: saarcor conform run {shown}"));
        Ok(Status::Holds)
    }
}
