//! Children of this process: each leads a group of its own, and nothing of a group outlives its use or this
//! process, however either ends.

use crate::error::Error;
use rustix::io::retry_on_intr;
use rustix::process::{
    Pid, Signal, WaitId, WaitIdOptions, WaitOptions, kill_process_group, waitid, waitpgid,
};
#[cfg(target_os = "linux")]
use rustix::process::{kill_process, waitpid};
use signal_hook::consts::SIGCHLD;
use std::collections::BTreeSet;
use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
#[cfg(target_os = "linux")]
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::Duration;

/// Looks for members of a group that has been killed, and the time between two of them: what is not gone by then
/// is left to [`kill_strays`].
const REAP_LOOKS: usize = 100;
const REAP_POLL: Duration = Duration::from_millis(1);

/// What is wrong where a leader's end cannot be asked for.
const NO_END: &str = "whether the implementation has ended is not known";

/// Whether this process inherits what its children leave behind.
#[cfg(target_os = "linux")]
static ADOPTS: AtomicBool = AtomicBool::new(false);

/// Held for reading while a process is started, and for writing once no process may start any more.
static STARTING: RwLock<()> = RwLock::new(());

/// The groups that run, and what kills them if this process cannot.
static RUNNING: Mutex<Running> = Mutex::new(Running { groups: BTreeSet::new(), guard: None });

/// A process that leads a group. However it is dropped, the group is killed, and none of it stays a zombie.
#[derive(Debug)]
pub(crate) struct ProcessGroup {
    /// The first of the group.
    pub leader: Child,
    is_gone: bool,
}

impl ProcessGroup {
    /// Starts a command line by a shell, with the streams that `streams` gives it.
    pub fn start(
        command: &str,
        folder: Option<&Path>,
        streams: impl FnOnce(&mut Command),
    ) -> Result<Self, Error> {
        let mut shell = Command::new("sh");
        shell.args(["-c", command]).process_group(0);
        if let Some(folder) = folder {
            shell.current_dir(folder);
        }
        streams(&mut shell);
        keep_ends()?;
        let _may_start = STARTING.read();
        let leader = shell.spawn().map_err(Error::system(format!("'{command}' cannot be started")))?;
        let group = Self { leader, is_gone: false };
        Running::add(group.number());
        Ok(group)
    }

    fn number(&self) -> i32 {
        Pid::from_child(&self.leader).as_raw_nonzero().get()
    }

    /// How the leader has ended, if it has: an exit status or a signal. It stays a zombie, so that its group's
    /// number is not given to another.
    ///
    /// # Errors
    /// Where the system does not say whether it has ended.
    pub fn end(&self) -> Result<Option<LeaderEnd>, Error> {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
        let leader = WaitId::Pid(Pid::from_child(&self.leader));
        let Some(status) =
            retry_on_intr(|| waitid(leader.clone(), options)).map_err(Error::system(NO_END))?
        else {
            return Ok(None);
        };
        // Where this process is ended by a signal, so are its children: that says nothing about them.
        drop(STARTING.read());
        Ok(Some(LeaderEnd { status: status.exit_status(), signal: status.terminating_signal() }))
    }

    /// Kills the process with all of its group, and takes their ends.
    pub fn kill(&mut self) {
        if std::mem::replace(&mut self.is_gone, true) {
            return;
        }
        let group = Pid::from_child(&self.leader);
        // Each fails only where there is nothing left to kill. The leader may have left its group.
        let _ = kill_process_group(group, Signal::KILL);
        let _ = self.leader.kill();
        {
            // Once the ends of all are taken, the system may give the group's number to the next process: none is
            // started meanwhile, and the number is no longer in the list by then.
            let _none_is_started = STARTING.write();
            Running::remove(self.number());
            let _ = self.leader.wait();
            for _ in 0..REAP_LOOKS {
                match waitpgid(group, WaitOptions::NOHANG) {
                    Ok(Some(_)) => {}
                    Ok(None) => std::thread::sleep(REAP_POLL),
                    Err(_) => break,
                }
            }
        }
        #[cfg(target_os = "linux")]
        reap_strays();
    }
}

impl Drop for ProcessGroup {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Has the system keep how children end: it does not where this process was started with SIGCHLD ignored.
fn keep_ends() -> Result<(), Error> {
    static KEPT: Mutex<bool> = Mutex::new(false);
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if !*kept {
        // Any handler will do.
        signal_hook::flag::register(SIGCHLD, Arc::default()).map_err(Error::system(NO_END))?;
        *kept = true;
    }
    Ok(())
}

/// How a process has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LeaderEnd {
    /// Its status, where it exited.
    pub status: Option<i32>,
    /// The signal that ended it, where one did.
    pub signal: Option<i32>,
}

impl LeaderEnd {
    /// Whether it ended as one that succeeds.
    pub fn is_success(self) -> bool {
        self.status == Some(0)
    }

    /// Whether a shell says so that it could not start what it was to: it was not there, or may not be executed.
    pub fn is_not_started(self) -> bool {
        matches!(self.status, Some(126 | 127))
    }
}

impl std::fmt::Display for LeaderEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.status, self.signal) {
            (Some(status), _) => write!(f, "ended with status {status}"),
            (None, Some(signal)) => write!(f, "was ended by signal {signal}"),
            (None, None) => f.write_str("ended"),
        }
    }
}

/// What the guard does: it keeps the last line, the groups that run, and kills them when no more lines can come.
const GUARD: &str = "trap '' INT TERM HUP; while read -r line; do groups=$line; done; \
                     for group in $groups; do kill -s KILL -- \"-$group\"; done";

/// The groups that run, and their guard.
struct Running {
    groups: BTreeSet<i32>,
    /// The input of a process that waits for its end, which is the end of this process: killed, for instance, where
    /// memory runs out.
    guard: Option<ChildStdin>,
}

impl Running {
    fn add(group: i32) {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.groups.insert(group);
        if !running.inform_guard() {
            // There is none yet, or it was killed with all children. Where none can be started, all else goes on.
            running.guard = start_guard();
            running.inform_guard();
        }
    }

    fn remove(group: i32) {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.groups.remove(&group);
        running.inform_guard();
    }

    /// Whether there is a guard that takes the groups.
    fn inform_guard(&mut self) -> bool {
        let mut line: String = self.groups.iter().map(|group| format!("{group} ")).collect();
        line.push('\n');
        self.guard.as_mut().is_some_and(|guard| guard.write_all(line.as_bytes()).is_ok())
    }
}

fn start_guard() -> Option<ChildStdin> {
    let mut guard = Command::new("sh");
    guard.args(["-c", GUARD]).process_group(0).env_clear();
    guard.envs(std::env::var_os("PATH").map(|path| ("PATH", path)));
    guard.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
    guard.spawn().ok()?.stdin
}

/// Lets this process inherit what implementations leave behind, so that [`kill_strays`] finds it. Then all children of
/// this process are the kit's: it takes the ends of those that it has not started too.
pub fn adopt_strays() {
    #[cfg(target_os = "linux")]
    // Where it fails, strays are the system's, as they are elsewhere.
    if rustix::process::set_child_subreaper(Some(rustix::process::getpid())).is_ok() {
        ADOPTS.store(true, Ordering::Relaxed);
    }
}

/// Takes the ends of inherited processes that have ended by themselves, so that a long run gathers no zombies.
#[cfg(target_os = "linux")]
fn reap_strays() {
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
    if !ADOPTS.load(Ordering::Relaxed) || !matches!(waitid(WaitId::All, options), Ok(Some(_))) {
        return;
    }
    // No process is started now, and those that were are in the list.
    let Ok(_none_is_started) = STARTING.try_write() else { return };
    let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    for stray in children().filter(|child| !running.groups.contains(&child.as_raw_nonzero().get())) {
        let _ = waitpid(Some(stray), WaitOptions::NOHANG);
    }
}

/// Kills all children, and lets none be started any more: for a process that ends by a signal. They are in groups of
/// their own, and an interrupt at the terminal does not reach them.
pub fn kill_all_for_good() {
    std::mem::forget(STARTING.write());
    kill_strays();
}

/// Kills all processes that this one has inherited. For the end of a run: what else this process
/// has started is killed too.
pub fn kill_strays() {
    #[cfg(target_os = "linux")]
    // One that may not be killed is not waited for either.
    while let Some(stray) = children().find(|stray| kill_process(*stray, Signal::KILL).is_ok()) {
        let _ = waitpid(Some(stray), WaitOptions::empty());
    }
}

/// The children of this process.
#[cfg(target_os = "linux")]
fn children() -> impl Iterator<Item = Pid> {
    let parent = |stat: &str| stat.rsplit(')').next()?.split_ascii_whitespace().nth(1)?.parse::<i32>().ok();
    let mine = rustix::process::getpid().as_raw_nonzero().get();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = processes.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let children = numbers.filter(move |number| {
        let stat = std::fs::read_to_string(format!("/proc/{number}/stat"));
        stat.is_ok_and(|stat| parent(&stat) == Some(mine))
    });
    children.filter_map(Pid::from_raw)
}
