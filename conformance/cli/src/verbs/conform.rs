//! `saarcor conform`.

mod new;
#[cfg(unix)]
mod prove;
mod serve_library;

use self::new::NewArgs;
#[cfg(unix)]
use self::prove::ProveArgs;
use self::serve_library::ServeLibraryArgs;
use crate::conform::reports::ReportArgs;
use crate::conform::{hard, page, text};
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::Progress;
use crate::signals;
use crate::status::Status;
use anyhow::{Context, Error, Result, bail, ensure};
use clap::Subcommand;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use saarcor_kit::children;
use saarcor_kit::error::Error as KitError;
use saarcor_kit::kd::Kd;
use saarcor_kit::kind::Kind;
use saarcor_kit::kinds::{KINDS, kind_named};
use saarcor_kit::level::Level;
use saarcor_kit::plan::{
    ERRORS, LONG_REQUESTS, Options, PlannedSession, RANDOM_REQUESTS, default_suite, sessions_named,
    sessions_of_file,
};
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict, Outcome, SCHEMA_VERSION};
use saarcor_kit::requirements::{self, Covered};
use saarcor_kit::run::{kind_of, run};
use saarcor_kit::scoreboard::{CheckedAnswers, check_answers};
use saarcor_kit::session::Session;
use saarcor_kit::sizes::Extent;
use saarcor_kit::target::{Target, TargetOptions, shell_word as quoted};
use saarcor_kit::templates::faults;
use saarcor_kit::vm::{Vm, trace};
use saarcor_kit::waive::Waivers;
use saarcor_studies::accuracy::suites::SUITES;
use saarcor_studies::monitor::Monitor as _;
use saarcor_studies::names::nearest;
use serde::Serialize;
use std::borrow::Cow;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

/// Whether another implementation of the virtual memory is right, and if not, where
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Run(RunArgs),
    #[cfg(unix)]
    Prove(ProveArgs),
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
            #[cfg(unix)]
            Verb::Prove(args) => args.run(progress),
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
    dut: OsString,
    /// The kind, for a command line that speaks several [default: what dut.toml says, else the first it answers]
    #[arg(long, value_parser = PossibleValuesParser::new(KINDS.iter().map(|kind| kind.name())))]
    kind: Option<String>,
    /// The highest level to judge [default: all that the implementation observes]
    #[arg(long, value_parser = levels())]
    level: Option<Level>,
    /// Runs only this suite, random session or file; can be given several times
    #[arg(long, value_name = "SUITE")]
    suite: Vec<OsString>,
    /// Plays a trace of a frame, as 'trace record --format din' writes it; can be given several times
    #[arg(long, value_name = "FILE")]
    trace: Vec<PathBuf>,
    /// Runs the shared library that dut.toml names, and not its command
    #[arg(long)]
    library: bool,
    /// Stops after N sessions that fail
    #[arg(long, value_name = "N", default_value_t = ERRORS as u32, value_parser = clap::value_parser!(u32).range(1..))]
    errors: u32,
    /// First seed of the random sessions: the first takes this one, each other one the next
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Leaves out the sessions about the sizes that people build
    #[arg(long)]
    quick: bool,
    /// Takes so many requests that counters of 24 bits overflow
    #[arg(long, conflicts_with_all = ["quick", "requests"])]
    long: bool,
    /// Requests of the random sessions together [default: what dut.toml asks for, else 2000000]
    #[arg(long, value_name = "N")]
    requests: Option<u32>,
    /// Seconds that a session may take [default: what dut.toml says, else 10]
    #[arg(long, value_name = "S")]
    time_limit: Option<f64>,
    #[command(flatten)]
    report: ReportArgs,
    /// Runs only the sessions that failed in the last run that kept its sessions in the same folder
    #[arg(long)]
    only_failed: bool,
    /// Failures that are known: '[[waive]]' with 'session' or 'requirement', and 'reason'; they do not count
    #[arg(long, value_name = "FILE.toml")]
    waive: Option<PathBuf>,
    /// Prints each session, with its outcome and its configuration
    #[arg(long, conflicts_with = "json")]
    verbose: bool,
    /// Where the shortest sessions that fail are kept, and the names of all that do
    #[arg(long, value_name = "DIR", default_value = "target/conform")]
    keep: PathBuf,
}

/// What is asked for beside the default.
struct Asked {
    /// Sessions that were named, with their kinds; none for all.
    named: Vec<(&'static dyn Kind, Vec<Session>)>,
    /// The names of the only ones that are run.
    only: Option<Vec<String>>,
    /// Failures that do not count.
    waivers: Waivers,
}

impl RunArgs {
    fn run(self, progress: &Progress) -> Result<Status> {
        if let Some(limit) = self.time_limit {
            ensure!(limit > 0.0 && limit <= 3600.0, "--time-limit {limit}: write seconds, up to 3600");
        }
        let mut inputs = vec![Path::new(&self.dut).join("dut.toml")];
        inputs.extend(self.suite.iter().map(PathBuf::from).chain(self.trace.iter().cloned()));
        let reports = self.report.files(&inputs)?;
        let extent = Extent { seed: self.seed, requests: self.random_requests(None) };
        let named = self.suite.iter().map(|name| named(name, &extent));
        let traces = self.trace.iter().map(|path| traced(path));
        let named = named.chain(traces).collect::<Result<Vec<_>>>()?;
        let program = std::env::current_exe().context("the path of this program")?;
        let waivers = self.waive.as_deref().map(waivers).transpose()?.unwrap_or_default();
        let only = if self.only_failed { Some(self.failed_last()?) } else { None };
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
            let _ = writeln!(
                std::io::stderr(),
                "saarcor: {}: needs {missing}, not found in the path",
                self.name()
            );
            return Ok(Status::Incomplete);
        }
        children::adopt_strays();
        signals::before_end(children::kill_all_for_good).context("signals cannot be waited for")?;
        let asked = Asked { named, only, waivers: waivers.clone() };
        let report = target.build().map_err(Into::into).and_then(|()| self.report(&target, asked, progress));
        children::kill_strays();
        let mut report = report.map_err(|error| self.explained(error))?;
        for (number, waiver) in waivers.unused(&report.outcomes) {
            let file = self.waive.as_deref().unwrap_or(Path::new("--waive")).display();
            progress.warn(&format!("{file}: entry {number} ({waiver}) matches no failure of this run"));
        }
        if let Err(error) = self.keep_minimal(&mut report) {
            // The verdict stands without them.
            let _ = writeln!(std::io::stderr(), "saarcor: sessions that fail are not kept: {error:#}");
        }
        reports.give(self.print(&report), |at| report.junit(at), || page::html(&report))?;
        Ok(match report.verdict {
            ConformanceVerdict::Conforms => Status::Holds,
            ConformanceVerdict::DoesNotConform => Status::Disproved,
            ConformanceVerdict::Incomplete => Status::Incomplete,
        })
    }

    /// The implementation as it was named.
    fn name(&self) -> Cow<'_, str> {
        self.dut.to_string_lossy()
    }

    fn print(&self, report: &ConformanceReport) -> Result<()> {
        let mut out = Stdout::new();
        if self.report.json {
            json_line(&mut out, report)?;
        } else {
            out.line(text::text(report).trim_end())?;
            if self.verbose {
                out.line(format_args!("\n{}", text::sessions(report)))?;
            }
        }
        out.finish()
    }

    /// The error, with what may have been meant where nothing could be started.
    fn explained(&self, error: Error) -> Error {
        let is_not_started = matches!(error.downcast_ref(), Some(KitError::NotStarted { .. }));
        if !is_not_started || Path::new(&self.dut).is_dir() {
            return error;
        }
        let entries = fs::read_dir(".").into_iter().flatten().flatten();
        let folders = entries.filter(|entry| entry.path().join("dut.toml").is_file());
        let names: Vec<_> = folders.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        let near = nearest(&self.name(), names.iter().map(String::as_str));
        let near = near.map_or_else(String::new, |near| format!("; did you mean '{near}'?"));
        error.context(format!("{}: no folder, and no command line{near}", self.name()))
    }

    fn random_requests(&self, target: Option<usize>) -> usize {
        let asked =
            if self.long { Some(LONG_REQUESTS) } else { self.requests.map(|requests| requests as usize) };
        asked.or(target).unwrap_or(RANDOM_REQUESTS)
    }

    fn report(&self, target: &Target, asked: Asked, progress: &Progress) -> Result<ConformanceReport> {
        let Asked { named, only, waivers } = asked;
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
            waivers,
            quick: self.quick,
            shrink: true,
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
        if let Some(only) = only {
            planned.retain(|planned| only.contains(&planned.name(kind)));
            ensure!(
                !planned.is_empty(),
                "--only-failed: none of the {} sessions that failed is planned now; name the suites, the seed and \
                 the requests of the last run",
                only.len()
            );
        }
        let report = progress
            .during(&format!("{} sessions of {}", planned.len(), kind.name()), |report| {
                run(&self.name(), dut, kind, &planned, &options, report)
            })?;
        Ok(report)
    }

    /// The file with the names of the sessions that failed.
    fn list_of_failed(&self) -> PathBuf {
        self.keep.join("failed.txt")
    }

    /// The sessions that failed in the last run.
    fn failed_last(&self) -> Result<Vec<String>> {
        let path = self.list_of_failed();
        let shown = path.display();
        let text = fs::read_to_string(&path)
            .with_context(|| format!("--only-failed: {shown}: cannot be read; a run that fails writes it"))?;
        let names: Vec<_> = text.lines().map(str::to_owned).collect();
        ensure!(!names.is_empty(), "--only-failed: {shown}: no session failed in the last run");
        Ok(names)
    }

    /// Writes the shortest sessions that fail, the commands that run them again, and the names of all that fail.
    fn keep_minimal(&self, report: &mut ConformanceReport) -> Result<()> {
        let failed = report.outcomes.iter().filter(|outcome| outcome.outcome == Outcome::Failed);
        let failed: String = failed.map(|outcome| format!("{}\n", outcome.session)).collect();
        if !failed.is_empty() || self.list_of_failed().exists() {
            fs::create_dir_all(&self.keep)
                .with_context(|| format!("{}: cannot be made", self.keep.display()))?;
            OutFile::check(&self.list_of_failed())?.write(|out| Ok(out.write_all(failed.as_bytes())?))?;
        }
        for (failure, number) in report.failures.iter_mut().zip(1..) {
            let name =
                format!("{number}-{}-{}.txt", failure.requirement, failure.session.replace(['/', '@'], "-"));
            let path = self
                .keep
                .join(name.replace(|c: char| !(c.is_ascii_alphanumeric() || "-._=,".contains(c)), "-"));
            OutFile::check(&path)?.write(|out| Ok(failure.suite.write_suite(out)?))?;
            failure.replay = Some(format!(
                "saarcor conform run {}{} --suite {}",
                quoted(&self.name()),
                if self.library { " --library" } else { "" },
                quoted(&path.display().to_string())
            ));
        }
        Ok(())
    }
}

/// The sessions of a suite's name, which may be mistyped.
fn named(name: &OsStr, extent: &Extent) -> Result<(&'static dyn Kind, Vec<Session>)> {
    // What is no text is the path of a file.
    let Some(name) = name.to_str() else { return Ok(sessions_of_file(Path::new(name))?) };
    let hard = hard::named(name, extent.seed);
    if !hard.is_empty() {
        return Ok((&Kd, hard));
    }
    if !Path::new(name).exists() {
        let known: Vec<&str> = KINDS.iter().flat_map(|kind| kind.suites()).map(|(name, _)| *name).collect();
        if let (Err(error), Some(near)) = (sessions_named(name, extent), nearest(name, known)) {
            bail!("{error}: did you mean '{near}'?");
        }
    }
    Ok(sessions_named(name, extent)?)
}

/// The failures that are known.
fn waivers(path: &Path) -> Result<Waivers> {
    let shown = path.display();
    let text = fs::read_to_string(path).with_context(|| format!("{shown}: cannot be read"))?;
    Waivers::parse(&text).with_context(|| shown.to_string())
}

/// The sessions of a trace.
fn traced(path: &Path) -> Result<(&'static dyn Kind, Vec<Session>)> {
    let shown = path.display();
    let text = fs::read_to_string(path).with_context(|| format!("{shown}: cannot be read"))?;
    let addresses = trace::parse_din(&text).with_context(|| shown.to_string())?;
    ensure!(!addresses.is_empty(), "{shown}: has no reads");
    Ok((&Vm, trace::sessions(&shown.to_string(), Vm.hello(), &addresses, usize::MAX)))
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
    suite: OsString,
    /// Requests of a random session [default: 10000], or of all random sessions of the run that has one about sizes
    /// [default: 2000000]
    #[arg(long, value_name = "N")]
    requests: Option<u32>,
    /// First seed of the run that has the session, where it is about sizes
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

impl SuiteArgs {
    /// The first session of that name: a conversation has one configuration.
    fn session(&self) -> Result<(&'static dyn Kind, Session)> {
        let is_random = self.suite.to_str().is_some_and(|suite| suite.contains("/random/"));
        let default = if is_random { 10_000 } else { RANDOM_REQUESTS };
        let requests = self.requests.map_or(default, |requests| requests as usize);
        let (kind, sessions) = named(&self.suite, &Extent { seed: self.seed, requests })?;
        let session = sessions.into_iter().next().context("a suite has a session")?;
        Ok((kind, session))
    }
}

impl GenerateArgs {
    fn run(self) -> Result<Status> {
        let (_, session) = self.suite.session()?;
        let mut out = Stdout::new();
        for line in session.lines() {
            out.line(String::from_utf8_lossy(line))?;
        }
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
    /// Prints what the answers come to as a line of JSON, and a line for each difference
    #[arg(long)]
    json: bool,
}

/// What the answers to a suite come to: the first line of `--json`.
#[derive(Debug, Serialize)]
struct CheckedRow<'a> {
    schema_version: u32,
    protocol: &'a str,
    session: &'a str,
    config: &'a str,
    answered: usize,
    differences: usize,
    highest: Option<Level>,
    not_judged: &'a [Level],
    unsupported: Option<&'a str>,
}

impl<'a> CheckedRow<'a> {
    fn new(kind: &'static dyn Kind, session: &'a Session, checked: &'a CheckedAnswers) -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            protocol: kind.hello(),
            session: &session.name,
            config: session.config(),
            answered: checked.answered,
            differences: checked.findings.len(),
            highest: checked.highest,
            not_judged: &checked.not_judged,
            unsupported: checked.unsupported.as_deref(),
        }
    }
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
        if self.json {
            json_line(&mut out, &CheckedRow::new(kind, &session, &checked))?;
        }
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
    /// Lists the requirements, and for each the sessions that are about it, or why there are none
    #[arg(long, conflicts_with = "faults")]
    coverage: bool,
}

impl ListArgs {
    fn run(self) -> Result<Status> {
        let mut out = Stdout::new();
        if self.faults {
            for fault in faults()? {
                out.line(format_args!("{:<6} {:<32} {}", fault.requirement, fault.name, fault.says))?;
            }
        } else if self.coverage {
            for Covered { id, sessions, reason } in requirements::coverage()? {
                let names = Vec::from_iter(sessions).join(" ");
                out.line(format_args!(
                    "{id:<6} {}",
                    reason.map_or(names, |reason| format!("none: {reason}"))
                ))?;
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
            for sized in
                KINDS.iter().flat_map(|kind| kind.sizes(&Extent { seed: 0, requests: RANDOM_REQUESTS }))
            {
                if !sized.name.contains("/shape/") {
                    out.line(format_args!("{:<6} {:<36} {}", sized.requirement, sized.name, sized.idea))?;
                }
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
