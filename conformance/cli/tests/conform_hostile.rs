//! Hostile implementations before the command line: a verdict in time, little memory, and no process
//! left, however the runner ends.
#![cfg(target_os = "linux")]

mod common;

use common::saarcor_with_signals;
use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Names a run in the environment of all that it starts.
const MARK: &str = "SAARCOR_TEST_MARK";
/// What the runner may take, of which it needs a tenth.
const MOST_KIB: u64 = 300 << 10;

/// A run with a marked implementation.
struct Run {
    child: Child,
    mark: String,
    began: Instant,
    _folder: tempfile::TempDir,
}

impl Run {
    /// One that has this command.
    fn start(command: &str, time_limit: u64) -> Self {
        Self::start_with(&format!("time_limit = {time_limit}\ncommand = '''{command}'''\n"))
    }

    /// One that has these lines in its `dut.toml`.
    fn start_with(lines: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let dut = format!("kind = \"saarcor-vm\"\n{lines}");
        fs::write(folder.path().join("dut.toml"), dut).expect("written");
        let mark = folder.path().display().to_string();
        let mut runner = saarcor_with_signals(&["conform", "run", &mark, "--json"]);
        runner.arg("--keep").arg(folder.path().join("kept")).env(MARK, &mark);
        runner.stdout(Stdio::piped()).stderr(Stdio::piped());
        Self { began: Instant::now(), child: runner.spawn().expect("it starts"), mark, _folder: folder }
    }

    /// Waits for the end, and says how much memory the runner took, how long, and what it printed.
    fn watch(self) -> (u64, Duration, serde_json::Value) {
        let Self { child, mark, began, _folder } = self;
        let status = format!("/proc/{}/status", child.id());
        // Beside what reads the report, which is longer than a pipe holds.
        let watch = std::thread::spawn(move || {
            let mut most = 0;
            while let Ok(text) = fs::read_to_string(&status) {
                let peak = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
                let peak = peak.and_then(|peak| peak.trim().split(' ').next()?.parse().ok());
                most = most.max(peak.unwrap_or(0));
                std::thread::sleep(Duration::from_millis(5));
            }
            most
        });
        let output = child.wait_with_output().expect("its output");
        let (took, most) = (began.elapsed(), watch.join().expect("it watches"));
        assert_eq!(marked(&mark), Vec::<String>::new());
        let report = serde_json::from_slice(&output.stdout);
        (most, took, report.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr))))
    }

    /// Waits until the implementation runs, and the runner has had time to note it: what is killed between two
    /// instructions of the runner is another matter.
    fn wait_for_implementation(&self) {
        let is_runner = |line: &String| line.contains("conform run");
        while marked(&self.mark).iter().all(is_runner) {
            assert!(self.began.elapsed() < Duration::from_secs(60), "it never starts");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(500));
    }
}

/// The command lines of the processes that have the mark.
fn marked(mark: &str) -> Vec<String> {
    let entry = format!("{MARK}={mark}").into_bytes();
    let processes = fs::read_dir("/proc").expect("Linux has it").flatten();
    let marked = processes.map(|process| process.path()).filter(|process| {
        let environment = fs::read(process.join("environ")).unwrap_or_default();
        environment.split(|&byte| byte == 0).any(|variable| variable == entry)
    });
    let line = |process: &Path| fs::read_to_string(process.join("cmdline")).unwrap_or_default();
    marked.map(|process| line(&process).replace('\0', " ")).collect()
}

/// A loop of the shell that answers reads by `read`, and all in the form of the protocol, after a pause.
fn answering(pause: &str, read: &str) -> String {
    format!(
        "while read x; do {pause}; case $x in r*) echo {read};; '#'*) ;; end) echo end; exit;; *) echo ok;; esac; done"
    )
}

#[test]
fn verdict_is_in_time_and_memory_bounded() {
    let hello = "read x; echo saarcor-vm 1; read x; echo ok observes=data,hit,card,evict";
    for (command, verdict) in [
        ("cat /dev/zero", "does-not-conform"),
        ("yes", "does-not-conform"),
        ("yes complaint >&2", "does-not-conform"),
        ("cat /dev/zero >&2", "does-not-conform"),
        ("sleep 1000 & sleep 1000", "does-not-conform"),
        ("setsid sleep 1000 & exit 1", "does-not-conform"),
        (&format!("{hello}; while :; do echo ok; done"), "does-not-conform"),
        (&format!("{hello}; while read x; do sleep 0.1; echo ok; done"), "does-not-conform"),
        // Slow, wrong, and in time in each of the short sessions: shrinking them has to end too.
        (&format!("{hello}; {}", answering("sleep 0.03", "h 0 - 00")), "does-not-conform"),
        (&format!("sleep 0.3; {hello}; {}", answering(":", "h 0 - 00")), "does-not-conform"),
        (
            &format!("{hello}; sleep 0.4; read x; echo ok; sleep 0.4; head -c 9 /dev/zero; sleep 1000"),
            "does-not-conform",
        ),
    ] {
        let (most, took, report) = Run::start(command, 1).watch();
        assert_eq!(report["verdict"], verdict, "{command}: {report}");
        assert!(most < MOST_KIB, "{command}: {most} KiB");
        println!("{took:?}, {most} KiB: {command}");
        let stderr = report["failures"][0]["stderr"].as_str().unwrap_or_default();
        assert!(!command.contains("complaint") || stderr.contains("complaint"), "{command}: {report}");
    }
}

#[test]
fn nothing_is_left_when_the_runner_is_ended() {
    let command = "command = 'setsid sleep 1000 & sleep 1000'\ntime_limit = 1000\n";
    let build = "build = 'setsid sleep 1000 & sleep 1000 & wait'\ncommand = 'true'\n";
    for (lines, signal, number) in
        [(command, "INT", 2), (command, "TERM", 15), (build, "INT", 2), (build, "HUP", 1)]
    {
        let mut run = Run::start_with(lines);
        run.wait_for_implementation();
        let kill = Command::new("kill").args(["-s", signal, &run.child.id().to_string()]).status();
        assert!(kill.expect("it starts").success());
        assert_eq!(run.child.wait().expect("a child").signal(), Some(number), "{lines}");
        assert_eq!(marked(&run.mark), Vec::<String>::new(), "{signal}");
    }
}

/// Then the runner can do nothing itself. What leaves its group is out of reach.
#[test]
fn nothing_is_left_when_the_runner_is_killed() {
    for lines in [
        "command = 'sleep 1000 & sleep 1000'\ntime_limit = 1000\n",
        "build = 'yes > /dev/null & yes'\ncommand = 'true'\n",
        "build = 'sleep 1000 & sleep 1000'\ncommand = 'true'\n",
    ] {
        let mut run = Run::start_with(lines);
        run.wait_for_implementation();
        run.child.kill().expect("it can be killed");
        run.child.wait().expect("a child");
        let began = Instant::now();
        while !marked(&run.mark).is_empty() {
            assert!(began.elapsed() < Duration::from_secs(60), "{lines}: {:?}", marked(&run.mark));
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Builds that write, or run, without end are bad input; nothing of what they write is kept.
#[test]
fn builds_are_ended() {
    for (build, says) in [
        ("yes", "writes more than 64 MiB"),
        ("cat /dev/zero >&2 & sleep 1000", "writes more than 64 MiB"),
        ("sleep 1000", "not done within 0.5 s, its build_limit"),
        ("setsid sleep 1000 & sleep 1000", "not done within 0.5 s, its build_limit"),
        ("echo wrong; exit 3", "ended with status 3: wrong"),
    ] {
        let limit = if says.contains("0.5 s") { 0.5 } else { 600.0 };
        let run =
            Run::start_with(&format!("build = '{build}'\nbuild_limit = {limit:.1}\ncommand = 'true'\n"));
        let (mark, output) = (run.mark.clone(), run.child.wait_with_output().expect("it ends"));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{build}: {stderr}");
        assert!(stderr.trim_end().ends_with(says) && stderr.lines().count() == 1, "{build}: {stderr}");
        assert_eq!(marked(&mark), Vec::<String>::new(), "{build}");
    }
}

#[test]
fn nothing_is_left_when_nobody_reads_the_report() {
    let mut run = Run::start("sleep 1000 & sleep 1000", 1);
    drop(run.child.stdout.take());
    run.child.wait().expect("a child");
    assert_eq!(marked(&run.mark), Vec::<String>::new());
}

/// Where it is started with SIGCHLD ignored, the system would not say how implementations end.
#[test]
fn ends_are_known_whatever_the_runner_inherits() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = "trap '' CHLD; exec \"$0\" conform run 'exit 3' --errors 1 --json --quiet";
    let mut runner = Command::new("sh");
    runner.args(["-c", script, env!("CARGO_BIN_EXE_saarcor")]).current_dir(folder.path());
    let output = runner.output().expect("it starts");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    assert_eq!(report["failures"][0]["says"], "the implementation ended with status 3");
}
