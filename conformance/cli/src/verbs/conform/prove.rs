//! `saarcor conform prove`.

use crate::args::choice;
use crate::conform::proof;
use crate::conform::reports::ReportArgs;
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::Progress;
use crate::signals;
use crate::size::Size;
use crate::status::Status;
use anyhow::{Context as _, Result, bail};
use saarcor_kit::children;
use saarcor_kit::prove::driver::{Asked, prove};
use saarcor_kit::prove::report::{ProofReport, ProofVerdict};
use saarcor_kit::prove::tools::{ENVIRONMENT, Tools};
use saarcor_kit::target::{DutFile, shell_word as quoted};
use saarcor_kit::vm::config::POLICIES;
use saarcor_model::vm::Policy;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Proves an implementation in Verilog, for requests without end, or shows the shortest requests that refute it
#[derive(Debug, clap::Args)]
pub struct ProveArgs {
    /// A folder with dut.toml, whose table [prove] names the ports
    #[arg(value_name = "DUT")]
    dut: PathBuf,
    /// Size of the memory [default: what dut.toml says]
    #[arg(long)]
    memory: Option<Size>,
    /// Replacement policy [default: what dut.toml says]
    #[arg(long, value_parser = choice(POLICIES))]
    policy: Option<Policy>,
    /// Proves it from its ports alone, although it shows its state
    #[arg(long)]
    from_ports: bool,
    /// Seconds that each search and each proof may take
    #[arg(long, value_name = "SECONDS", default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    limit_seconds: u64,
    #[command(flatten)]
    report: ReportArgs,
    /// Where the trace that refutes it is kept, as waves and as requests, and the netlists
    #[arg(long, value_name = "DIR", default_value = "target/conform")]
    keep: PathBuf,
}

impl ProveArgs {
    /// Proves, and prints the report.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        let file = self.dut.join("dut.toml");
        let reports = self.report.files(std::slice::from_ref(&file))?;
        let dut = DutFile::read(&self.dut)?;
        let Some(mut config) = dut.prove else {
            bail!("{}: has no table [prove], which names the ports of the implementation", file.display());
        };
        config.resize(&dut.kind, self.memory.map(|memory| memory.0), self.policy)?;
        let tools = match Tools::find() {
            Ok(tools) => tools,
            Err(missing) => {
                // An error that is no bad input; where standard error is closed, the status has to do.
                let _ = writeln!(
                    std::io::stderr(),
                    "saarcor: {}: not run: {} not found, neither in the path nor in {ENVIRONMENT}",
                    self.dut.display(),
                    missing.join(", ")
                );
                return Ok(Status::Incomplete);
            }
        };
        children::adopt_strays();
        signals::before_end(children::kill_all_for_good).context("signals cannot be waited for")?;
        let work = self.keep.join("prove");
        fs::create_dir_all(&work).with_context(|| format!("{}: cannot be made", work.display()))?;
        let name = self.dut.display().to_string();
        let asked = Asked {
            name: name.clone(),
            kind: &dut.kind,
            folder: &self.dut,
            config: &config,
            work: &work,
            limit: Duration::from_secs(self.limit_seconds),
            from_ports: self.from_ports,
        };
        let report = prove(&asked, tools, &|says| progress.say(format_args!("{says}")));
        children::kill_strays();
        let mut report = report.with_context(|| name.clone())?;
        self.keep_trace(&mut report)?;
        reports.give(self.print(&report), |at| report.junit(at), || proof::html(&report))?;
        Ok(match report.verdict {
            ProofVerdict::Proved => Status::Holds,
            ProofVerdict::Refuted => Status::Disproved,
            ProofVerdict::NotDecided => Status::Incomplete,
        })
    }

    fn print(&self, report: &ProofReport) -> Result<()> {
        let mut out = Stdout::new();
        if self.report.json {
            json_line(&mut out, report)?;
        } else {
            out.line(proof::text(report).trim_end())?;
        }
        out.finish()
    }

    /// Writes the trace that refutes it, as waves and as a session.
    fn keep_trace(&self, report: &mut ProofReport) -> Result<()> {
        let Some(trace) = &mut report.trace else { return Ok(()) };
        let path = |ending: &str| -> PathBuf { self.keep.join(format!("refuted.{ending}")) };
        let write = |path: &Path, bytes: &[u8]| -> Result<()> {
            OutFile::check(path)?.write(|out| Ok(out.write_all(bytes)?))
        };
        write(&path("vcd"), &trace.vcd)?;
        write(&path("txt"), &trace.suite)?;
        trace.waves = Some(path("vcd").display().to_string());
        trace.replay = Some(format!(
            "saarcor conform run {} --suite {}",
            quoted(&self.dut.display().to_string()),
            quoted(&path("txt").display().to_string())
        ));
        Ok(())
    }
}
