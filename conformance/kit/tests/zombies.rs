//! What implementations leave behind does not gather while others are run.
#![cfg(target_os = "linux")]

use saarcor_kit::children::{adopt_strays, kill_strays};
use saarcor_kit::plan::{Options, default_suite};
use saarcor_kit::process::Process;
use saarcor_kit::run::run;
use saarcor_kit::vm::Vm;
use std::time::Duration;

/// The state and the command of each child of this process, by `/proc`.
fn children() -> Vec<String> {
    let processes = std::fs::read_dir("/proc").expect("Linux has it").flatten();
    let stats = processes.filter_map(|entry| std::fs::read_to_string(entry.path().join("stat")).ok());
    let mine = std::process::id().to_string();
    stats
        .filter(|stat| {
            let after = stat.rsplit(')').next().unwrap_or_default();
            after.split_ascii_whitespace().nth(1) == Some(&mine)
        })
        .collect()
}

// Alone in its file: it is about all children of the process.
#[test]
fn dead_children_are_reaped_while_others_run() {
    adopt_strays();
    // One that dies with its group, and two that leave it: one ends by itself.
    let command = "(sleep 1000 & setsid sleep 1000 & setsid true &) > /dev/null 2>&1; read x; exit 1";
    let dut = Process::new(command.to_owned(), None, Duration::from_secs(60));
    let options = Options { quick: true, requests: 0, errors: 100, ..Options::default() };
    let planned = default_suite(&Vm, &options).expect("suites");
    let report = run(command, &dut, &Vm, &planned, &options, &|_| ());
    let zombies = children().into_iter().filter(|stat| stat.contains(") Z ")).count();
    // Before anything can fail here: what has left its group would stay.
    kill_strays();
    let errors = report.expect("it runs").errors;
    assert!(errors >= 100, "{errors}");
    // Two of each session would be twice as many as there are errors. Those of the last may have ended a moment ago.
    assert!(zombies <= 32, "{zombies}");
    assert_eq!(children(), Vec::<String>::new());
}
