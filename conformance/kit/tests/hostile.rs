//! Hostile implementations: a verdict, and nothing left behind.
#![cfg(unix)]

use saarcor_kit::plan::{Options, PlannedSession, default_suite};
use saarcor_kit::process::Process;
use saarcor_kit::report::{ConformanceReport, ConformanceVerdict};
use saarcor_kit::run::run;
use saarcor_kit::vm::Vm;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(1);

/// Runs the default suite with a command line of which the report must be there in time.
fn report_on(command: &str) -> ConformanceReport {
    report_within(LIMIT, command)
}

fn report_within(time_limit: Duration, command: &str) -> ConformanceReport {
    let dut = Process::new(command.to_owned(), None, time_limit);
    let options = Options { quick: true, requests: 24, errors: 1, ..Options::default() };
    let planned = default_suite(&Vm, &options).expect("suites");
    run(command, &dut, &Vm, &planned, &options, &|_| ()).expect("it runs")
}

/// The requirement and the sentence of the one failure.
#[track_caller]
fn rejected(command: &str) -> (String, String) {
    let report = report_on(command);
    assert_eq!(report.verdict, ConformanceVerdict::DoesNotConform, "{command}");
    let failure = report.failures.into_iter().next().expect("a failure");
    (failure.requirement, failure.says)
}

const HELLO: &str = "read x; echo saarcor-vm 1; read x; echo ok observes=data,hit,card,evict; ";

#[test]
fn one_that_hangs() {
    for command in ["read x; sleep 1000", "while :; do :; done", &format!("{HELLO} sleep 1000")] {
        let report = report_on(command);
        // Those that run at the same time end with it, and no others begin.
        assert!(report.sessions <= rayon::current_num_threads() + 1 && report.stopped.is_some());
        let failure = &report.failures[0];
        assert!(
            failure.requirement == "P-8" && failure.says.contains("1 s"),
            "{command}: {}",
            failure.text()
        );
    }
}

#[test]
fn one_that_does_not_end_after_end() {
    let (requirement, says) = rejected(&format!("{HELLO} read x; echo end; exec sleep 1000"));
    assert!(requirement == "P-6" && says.contains("end"), "{says}");
}

#[test]
fn one_that_dies() {
    for (command, how) in [
        ("exit 3", "status 3"),
        ("kill -SEGV $$", "signal 11"),
        (&format!("{HELLO} printf 'm 0'; exit 0"), "in the middle"),
    ] {
        let (requirement, says) = rejected(command);
        assert!(requirement == "P-7" && says.contains(how), "{command}: {requirement} {says}");
    }
}

/// What starts nothing is no implementation; what was started once is one, whatever its status.
#[test]
fn one_that_is_not_there() {
    let dut = |command: &str| Process::new(command.to_owned(), None, LIMIT);
    let options = Options { quick: true, requests: 0, ..Options::default() };
    let planned = default_suite(&Vm, &options).expect("suites");
    for (command, why) in [
        ("no-such-program-at-all", "status 127"),
        ("./no-such-folder/program 2> /dev/null", "status 127"),
        ("/etc/passwd", "status 126"),
        ("/etc", "status 126"),
    ] {
        let error =
            run(command, &dut(command), &Vm, &planned, &options, &|_| ()).expect_err("nothing starts");
        let says = error.to_string();
        assert!(says.contains("cannot be started") && says.contains(why), "{command}: {says}");
    }
    let (requirement, says) = rejected("read x; echo saarcor-vm 1; exit 127");
    assert!(requirement == "P-7" && says.contains("status 127"), "{says}");
}

/// One that answers reads by `m`, and a line of the shell for each `flush`.
fn answering(flush: &str) -> String {
    format!(
        "while read x; do case $x in saarcor*) echo $x;; config*) echo ok observes=hit;; flush) {flush};; \
         w*|i*) echo ok;; r*) echo m - - -;; end) echo end; exit;; esac; done"
    )
}

/// Some sessions hang, and others fail: all are counted.
#[test]
fn one_that_hangs_in_some_sessions() {
    let session = |name: &str, requests: &str| {
        let config = "line=16 lines=8 ways=2 hash=low policy=lru";
        let session = saarcor_kit::session::Session::new(name, "saarcor-vm 1", config, requests.as_bytes());
        PlannedSession::Directed(Box::new(session))
    };
    let passes = |number: usize| session(&format!("passes {number}"), "r 0 1\n");
    let hangs = |number: usize| session(&format!("hangs {number}"), "flush\n");
    let fails = |number: usize| session(&format!("fails {number}"), "r 0 1\nr 0 1\n");
    let planned: Vec<_> = (0..8).map(passes).chain((0..3).map(hangs)).chain((0..30).map(fails)).collect();
    let dut = Process::new(answering("sleep 1000"), None, 4 * LIMIT);
    let options = Options { quick: true, errors: 100, ..Options::default() };
    let report = run("some", &dut, &Vm, &planned, &options, &|_| ()).expect("it runs");
    let requirements: Vec<_> = report.failures.iter().map(|failure| failure.requirement.as_str()).collect();
    assert_eq!(requirements, ["P-8", "VM-6"]);
    assert_eq!((report.sessions, report.errors, &report.stopped), (41, 33, &None));
}

/// Several sessions a process: each is held, and one that depends on those before it is found.
#[test]
fn one_that_holds_several_sessions() {
    let folder = tempfile::tempdir().expect("a folder");
    let starts = folder.path().join("starts");
    let offer = |more: &str| {
        let hello = format!("echo saarcor-vm 1 sessions; {more}");
        let once = answering(":").replace("echo $x", &hello).replace("echo end; exit", "echo end");
        format!("echo >> {}; {once}", starts.display())
    };
    let limit = Duration::from_secs(60);
    let planned: Vec<_> = (0..40)
        .map(|number| {
            let config = "line=16 lines=8 ways=2 hash=low policy=lru";
            let name = format!("{number}");
            let session =
                saarcor_kit::session::Session::new(&name, "saarcor-vm 1", config, b"r 0 1\nr 40 1\n");
            PlannedSession::Directed(Box::new(session))
        })
        .collect();
    let report_on = |command: String| {
        let dut = Process::new(command, None, limit);
        run("several", &dut, &Vm, &planned, &Options::default(), &|_| ()).expect("it runs")
    };
    let report = report_on(offer(":"));
    assert_eq!((report.errors, report.sessions), (0, 40), "{:?}", report.failures);
    let started = std::fs::read_to_string(&starts).expect("a file").lines().count();
    assert!(started <= 2 * rayon::current_num_threads() + 2, "{started}");
    // The second session of a process hits what the first one read.
    let remembers =
        offer("n=$((n + 1))").replace("echo m - - -", "case $n in 1) echo m - - -;; *) echo h - -;; esac");
    let report = report_on(remembers);
    assert_eq!(report.failures[0].requirement, "P-9", "{}", report.failures[0].text());
    // And one that offers them, and ends.
    let ends = offer(":").replace("echo end;;", "echo end; exit;;");
    assert_eq!(report_on(ends).failures[0].requirement, "P-9");
}

#[test]
fn one_that_closes_its_output_and_lives() {
    let (requirement, _) = rejected("exec >&-; sleep 1000");
    assert_eq!(requirement, "P-7");
}

#[test]
fn one_that_answers_too_early() {
    let (requirement, says) = rejected("printf 'saarcor-vm 1\\nok observes=data\\nend\\n'; cat > /dev/null");
    // It depends on which is first: the kit's text or the answers. Then what follows is wrong.
    assert!(["P-4", "P-5"].contains(&requirement.as_str()), "{requirement} {says}");
}

#[test]
fn one_that_answers_too_much() {
    // None of these hangs: a limit that a busy machine does not reach.
    let limit = Duration::from_secs(60);
    for more in ["echo more", "printf more"] {
        let report = report_within(limit, &format!("{HELLO} read x; echo end; {more}"));
        assert_eq!(report.failures[0].requirement, "P-4", "{more}");
    }
}

#[test]
fn one_that_writes_garbage() {
    for command in ["head -c 100000 /dev/urandom", "yes", "cat /dev/zero", "yes | tr -d '\\n'"] {
        let (requirement, says) = rejected(command);
        assert!(
            ["P-1", "P-4", "P-5", "P-7"].contains(&requirement.as_str()),
            "{command}: {requirement} {says}"
        );
    }
}

#[test]
fn one_that_writes_to_stderr_without_end() {
    let report = report_on("yes complaint >&2");
    assert_eq!(report.verdict, ConformanceVerdict::DoesNotConform);
    let failure = &report.failures[0];
    assert!(
        failure.stderr.contains("complaint\n") && failure.stderr.len() <= 4096,
        "{}",
        failure.stderr.len()
    );
}

#[test]
fn one_that_answers_slowly_is_not_judged() {
    // An answer every 50 ms: never silent for half of the limit, and far from the end.
    let slow = format!(
        "{HELLO} while read x; do case $x in end) echo end; exit;; *) echo ok; sleep 0.05; esac; done"
    );
    let dut = Process::new(slow, None, LIMIT);
    let session = saarcor_kit::session::Session::new(
        "slow",
        "saarcor-vm 1",
        "line=16 lines=8 ways=2 hash=low policy=lru",
        "flush\n".repeat(1000).as_bytes(),
    );
    let planned = [PlannedSession::Directed(Box::new(session))];
    let report = run("slow", &dut, &Vm, &planned, &Options::default(), &|_| ()).expect("it runs");
    assert_eq!(report.verdict, ConformanceVerdict::Incomplete);
    assert!(report.stopped.is_some_and(|why| why.contains("time limit")));
}

/// The processes whose command line has a word that only this test knows.
#[cfg(target_os = "linux")]
fn alive(word: &str) -> usize {
    let processes = std::fs::read_dir("/proc").expect("Linux has it").flatten();
    let lines = processes.filter_map(|entry| std::fs::read(entry.path().join("cmdline")).ok());
    lines.filter(|line| String::from_utf8_lossy(line).contains(word)).count()
}

#[cfg(target_os = "linux")]
#[test]
fn no_process_of_its_group_is_left() {
    let word = "1000.0625";
    rejected(&format!("sleep {word} & sleep {word}; wait"));
    // A killed process takes a moment to be gone.
    let began = std::time::Instant::now();
    while alive(word) > 0 && began.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(alive(word), 0);
}
