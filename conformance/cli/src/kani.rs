//! Kani: one compilation, and then the theorems side by side, on all cores.

use crate::prove::{EngineVerdict, Judged};
use saarcor_proofs::evidence::Evidence;
use saarcor_proofs::theorem::Theorem;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Where Kani works, from the root of the workspace on.
const TARGET: &str = "target/kani";
/// Where it leaves its answers there.
const ANSWERS: &str = "result_output_dir";
/// Most memory that a theorem may take, in KiB.
const MEMORY_KIB: u64 = 2 << 20;

/// Bounds of a run.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Seconds of CPU a theorem.
    pub cpu_seconds: u64,
    /// Seconds for all of them together, with the compilation.
    pub seconds: Option<u64>,
}

/// Kani's version, as evidence names it.
///
/// # Errors
/// Why it cannot be used here.
pub fn version() -> Result<String, String> {
    let output = Command::new("cargo").args(["kani", "--version"]).stderr(Stdio::null()).output();
    match output {
        Ok(output) if output.status.success() => {
            let said = String::from_utf8_lossy(&output.stdout);
            let version = said.split_whitespace().last().unwrap_or("of an unknown version");
            Ok(format!("Kani {version}"))
        }
        _ => Err("Kani is absent: 'cargo kani --version' fails".to_owned()),
    }
}

/// By Kani: all of the theorems; calls `done` with each, as soon as it is judged.
///
/// The proofs are those of the workspace of the evidence.
pub fn judge(
    theorems: &[&Theorem],
    evidence: &mut Evidence,
    limits: Limits,
    mut done: impl FnMut(&mut Evidence, &Theorem, &Judged),
) -> Vec<Judged> {
    let root = evidence.root().to_owned();
    let mut left: Vec<&Theorem> = theorems.to_vec();
    let mut judged = Vec::new();
    let mut keep = |theorem: &Theorem, result: &dyn Fn(&Evidence) -> Judged| {
        let result = result(evidence);
        done(evidence, theorem, &result);
        judged.push(result);
    };
    let until = limits.seconds.map(|seconds| Instant::now() + Duration::from_secs(seconds));
    let mut why = String::new();
    // Kani may end before it has judged all: it begins again with those that are left, as long as it judges some.
    loop {
        let for_kani: Vec<_> =
            left.iter().copied().filter(|theorem| theorem.not_for_kani.is_none()).collect();
        if for_kani.is_empty() {
            break;
        }
        let asked = left.len();
        why = run(&for_kani, &root, limits, until, &mut |harness, answer| {
            if let Some(at) = left.iter().position(|theorem| theorem.harness() == harness) {
                let theorem = left.remove(at);
                keep(theorem, &|evidence| answer.judged(theorem, evidence.kani_scope(theorem)));
            }
        });
        if left.len() == asked {
            break;
        }
    }
    for theorem in left {
        let (verdict, why) = match theorem.not_for_kani {
            Some(why) => (EngineVerdict::NotForKani, why),
            None => (EngineVerdict::NotRun, &*why),
        };
        keep(theorem, &|_| Judged::by_kani(theorem, verdict, why));
    }
    judged
}

/// `cargo kani` over these theorems, in a shell that bounds the time and memory of each process.
fn command(
    theorems: &[&Theorem],
    root: &Path,
    limits: Limits,
    cpu_seconds: Option<u64>,
    rest: &[&str],
) -> Command {
    let mut command = Command::new("sh");
    // Not every system can bound memory.
    let bound = cpu_seconds.map_or_else(String::new, |seconds| {
        format!("ulimit -t {seconds}; ulimit -v {MEMORY_KIB} 2>/dev/null; ")
    });
    command.args(["-c", &format!("{bound}exec \"$0\" \"$@\""), "cargo"]);
    command.args([
        "kani",
        "-p",
        "saarcor-proofs",
        "--exact",
        "--target-dir",
        TARGET,
        "-Z",
        "unstable-options",
    ]);
    for theorem in theorems {
        command.args(["--harness", &theorem.harness()]);
    }
    command.args(rest).current_dir(root);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    // Where it may have to be ended, a group of its own, so that the solvers end with it.
    #[cfg(unix)]
    if limits.seconds.is_some() {
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
    }
    command
}

/// Ends Kani and the solvers that it has started.
fn end(child: &mut Child) {
    #[cfg(unix)]
    let _ = Command::new("kill").args(["-9", "--", &format!("-{}", child.id())]).status();
    let _ = child.kill();
    let _ = child.wait();
}

/// The lines that a process says, up to its end or to that time; then whether it came to its end.
fn lines(child: &mut Child, until: Option<Instant>, mut each: impl FnMut(&str)) -> bool {
    let (sender, lines) = mpsc::channel();
    if let Some(stdout) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
    }
    loop {
        let left =
            until.map_or(Duration::from_secs(3600), |until| until.saturating_duration_since(Instant::now()));
        match lines.recv_timeout(left) {
            Ok(line) => each(&line),
            Err(RecvTimeoutError::Disconnected) => return true,
            Err(RecvTimeoutError::Timeout) if until.is_some() => {
                end(child);
                return false;
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

/// Starts `cargo kani` and hands on what it says of each harness; returns why it said nothing of those that
/// are left.
fn run(
    theorems: &[&Theorem],
    root: &Path,
    limits: Limits,
    until: Option<Instant>,
    each: &mut dyn FnMut(&str, &Answer),
) -> String {
    if let Err(why) = version() {
        return why;
    }
    let limit_reached = "not judged within the time for all theorems".to_owned();
    let no_answer = "Kani gave no answer; 'cargo kani -p saarcor-proofs' says why".to_owned();
    // Compiled apart, as the bounds of time and memory are each theorem's, and by the same options, or Kani compiles again.
    let compiled = command(theorems, root, limits, None, &["--only-codegen"]).spawn();
    let Ok(mut child) = compiled else { return no_answer };
    if !lines(&mut child, until, |_| {}) {
        return limit_reached;
    }
    if !child.wait().is_ok_and(|status| status.success()) {
        return no_answer;
    }
    let jobs = std::thread::available_parallelism().map_or(1, usize::from).to_string();
    let rest = ["--jobs", &jobs, "--output-format", "terse", "--output-into-files"];
    let Ok(mut child) = command(theorems, root, limits, Some(limits.cpu_seconds), &rest).spawn() else {
        return no_answer;
    };
    let mut said = Said::default();
    let ended = lines(&mut child, until, |line| {
        if let Some((harness, begin)) = said.read(line) {
            let text = fs::read_to_string(root.join(TARGET).join(ANSWERS).join(&harness));
            let answer = text.map(|text| Answer::read(&text)).unwrap_or_default();
            // Without an answer Kani does not say how long it has taken.
            let seconds = if answer.checked { answer.seconds } else { begin.elapsed().as_secs_f64() };
            each(&harness, &Answer { seconds, ..answer });
        }
    });
    let _ = child.wait();
    if ended { no_answer } else { limit_reached }
}

/// What Kani's threads work on, as it says it.
#[derive(Clone, Debug, Default)]
struct Said {
    harnesses: BTreeMap<String, (String, Instant)>,
    thread: String,
}

impl Said {
    /// Reads a line; the one with the verdict of a harness gives its name, and since when it was judged.
    fn read(&mut self, line: &str) -> Option<(String, Instant)> {
        let mut line = line.trim();
        if let Some((thread, rest)) = line.strip_prefix("Thread ").and_then(|line| line.split_once(':')) {
            thread.clone_into(&mut self.thread);
            line = rest.trim();
        }
        if let Some(harness) = line.strip_prefix("Checking harness ") {
            let harness = harness.trim_end_matches("...").to_owned();
            self.harnesses.insert(self.thread.clone(), (harness, Instant::now()));
        }
        line.starts_with("VERIFICATION:- ").then(|| self.harnesses.remove(&self.thread)).flatten()
    }
}

/// What Kani said of a harness.
#[derive(Clone, Debug, Default, PartialEq)]
struct Answer {
    /// Labels of the covers that were reached. Kani may judge one cover at several places.
    covers: BTreeSet<String>,
    failed: Vec<String>,
    /// Whether it judged anything: not if its solver was ended.
    checked: bool,
    succeeded: bool,
    seconds: f64,
}

impl Answer {
    /// Reads Kani's whole answer about a harness.
    fn read(text: &str) -> Self {
        let mut answer = Self::default();
        // Of the check that is described next.
        let mut status = "";
        for line in text.lines().map(str::trim) {
            if let Some(said) = line.strip_prefix("- Status: ") {
                status = said;
                answer.checked = true;
            } else if let Some(label) = line.strip_prefix("- Description: ") {
                if status == "SATISFIED" {
                    answer.covers.insert(label.trim_matches('"').to_owned());
                }
            } else if let Some(check) = line.strip_prefix("Failed Checks: ") {
                answer.failed.push(check.to_owned());
            } else if let Some(result) = line.strip_prefix("VERIFICATION:- ") {
                answer.succeeded = result.starts_with("SUCCESSFUL");
            } else if let Some(time) = line.strip_prefix("Verification Time: ") {
                answer.seconds = time.trim_end_matches('s').parse().unwrap_or(0.0);
            }
        }
        answer
    }

    fn judged(&self, theorem: &Theorem, scope: &str) -> Judged {
        let reached = theorem.covers.iter().filter(|&&label| self.covers.contains(label)).count();
        let all_reached = reached == theorem.covers.len();
        let (verdict, why) = match (self.checked, self.failed.is_empty(), all_reached) {
            (true, true, true) if self.succeeded => (EngineVerdict::Proved, None),
            (true, false, _) => (EngineVerdict::Disproved, Some(self.failed.join("; "))),
            (true, true, false) if self.succeeded => {
                let why = format!("{reached} of {} covers were reached", theorem.covers.len());
                (EngineVerdict::Disproved, Some(why))
            }
            _ => (EngineVerdict::NoAnswer, Some("Kani reached the limit of time or memory".to_owned())),
        };
        Judged {
            covers_reached: reached,
            seconds: self.seconds,
            counterexample: why,
            ..Judged::by_kani(theorem, verdict, scope)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn theorem() -> &'static Theorem {
        let of_two = |theorem: &&Theorem| theorem.covers.len() == 2 && theorem.not_for_kani.is_none();
        saarcor_proofs::theorems().find(of_two).expect("one of two covers")
    }

    /// What Kani 0.67 prints of a harness of two covers, of which it judges the first twice.
    fn judged(second_cover: &str, failed: &str, result: &str) -> Judged {
        let text = format!(
            "Thread 1:\n\nRESULTS:\n\
             Check 1: hash.assertion.1\n\t - Status: SUCCESS\n\t - Description: \"claim\"\n\
             Check 2: hash.cover.1\n\t - Status: UNREACHABLE\n\t - Description: \"COVER\"\n\
             Check 3: hash.cover.2\n\t - Status: SATISFIED\n\t - Description: \"COVER\"\n\
             Check 4: hash.cover.3\n\t - Status: {second_cover}\n\t - Description: \"OTHER\"\n\n\
             SUMMARY:\n ** 0 of 136 failed\n\n ** 2 of 3 cover properties satisfied\n\n{failed}\n\
             VERIFICATION:- {result}\nVerification Time: 3.3358977s\n"
        );
        let theorem = theorem();
        let text = text.replace("COVER", theorem.covers[0]).replace("OTHER", theorem.covers[1]);
        Answer::read(&text).judged(theorem, "all")
    }

    #[test]
    fn kani_proves_with_all_covers_alone() {
        let proved = judged("SATISFIED", "", "SUCCESSFUL");
        assert_eq!((proved.verdict, proved.covers_reached), (EngineVerdict::Proved, 2));
        assert!((proved.seconds - 3.3).abs() < 0.1);
        assert_eq!(judged("UNSATISFIABLE", "", "SUCCESSFUL").verdict, EngineVerdict::Disproved);
        let failed = judged("SATISFIED", "Failed Checks: the theorem's claim", "FAILED");
        assert_eq!(failed.verdict, EngineVerdict::Disproved);
        assert_eq!(failed.counterexample.as_deref(), Some("the theorem's claim"));
    }

    #[test]
    fn solver_that_was_ended_disproves_nothing() {
        let text = "Thread 1:\nCBMC failed\nVERIFICATION:- FAILED\n";
        assert_eq!(Answer::read(text).judged(theorem(), "all").verdict, EngineVerdict::NoAnswer);
    }

    #[test]
    fn threads_are_kept_apart() {
        let mut said = Said::default();
        let mut read = |line: &str| said.read(line).map(|(harness, _)| harness);
        assert_eq!(read("Thread 0: Checking harness a::b..."), None);
        assert_eq!(read("Thread 1: Checking harness c::d..."), None);
        assert_eq!(read("Thread 0: "), None);
        assert_eq!(read("VERIFICATION:- SUCCESSFUL"), Some("a::b".to_owned()));
        assert_eq!(read("Thread 1: "), None);
        assert_eq!(read("VERIFICATION:- FAILED"), Some("c::d".to_owned()));
    }
}
