//! An implementation as a child process: written to and read from at once, within a time limit, in
//! bounded memory, and gone afterwards with all that it started.

use crate::deadline::Deadline;
use crate::dut::{ConversationEnd, Dut, Timeout};
use crate::error::Error;
use crate::scoreboard::{Scoreboard, Stage};
use crate::session::Session;
use crate::vm::config::MAX_LINE_BYTES;
use memchr::memchr;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::RwLock;
use std::time::{Duration, Instant};

/// Bytes that are read and written at a time: what a pipe holds.
const BUFFER: usize = 1 << 16;
/// Longest answer: twice the longest line in hex digits.
const MAX_ANSWER: usize = 4 * MAX_LINE_BYTES;
/// Bytes of standard error that are kept: its end.
const STDERR_KEPT: usize = 4096;
/// Time to exit for a process that has closed its output too early: to learn its status.
const EXIT_GRACE: Duration = Duration::from_millis(100);
/// Time between two checks whether a conversation is stopped.
const STOP_POLL: Duration = Duration::from_millis(50);
/// Time between two checks of a process that is about to exit.
const EXIT_POLL: Duration = Duration::from_millis(1);

/// A command line that is started once for each session.
#[derive(Clone, Debug)]
pub struct Process {
    /// The command line, for a shell.
    pub command: String,
    /// The folder that it is started in; none for the present one.
    pub folder: Option<PathBuf>,
    /// Time that a session may take.
    pub time_limit: Duration,
}

impl Dut for Process {
    fn converse(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        let mut running = RunningProcess::start(self)?;
        let timeout = running.hold(session.text(), scoreboard, self.time_limit, deadline);
        running.kill();
        running.read_stderr();
        Ok(ConversationEnd { timeout, stderr: String::from_utf8_lossy(&running.stderr_tail).into_owned() })
    }

    fn time_limit(&self) -> Option<Duration> {
        Some(self.time_limit)
    }
}

/// The command for a shell, in a process group of its own.
pub(crate) fn shell(command: &str, folder: Option<&PathBuf>) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", command]).process_group(0);
    if let Some(folder) = folder {
        shell.current_dir(folder);
    }
    shell
}

/// Kills a process with all of its group, and takes its end.
pub(crate) fn kill_group(child: &mut Child) {
    // Both fail only where there is nothing left to kill.
    let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
    let _ = child.wait();
}

/// Lets this process inherit what implementations leave behind, so that [`kill_strays`] finds it.
pub fn adopt_strays() {
    #[cfg(target_os = "linux")]
    // Where it fails, strays are the system's, as they are elsewhere.
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
}

/// Held for reading while a process is started, and for writing once no process may start any more.
static STARTING: RwLock<()> = RwLock::new(());

/// Has all children killed before this process ends by a signal: they are in groups of their own, and
/// an interrupt at the terminal does not reach them.
///
/// # Errors
/// Where signals cannot be waited for.
pub fn kill_all_when_ended() -> Result<(), Error> {
    let mut signals =
        Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(Error::system("signals cannot be waited for"))?;
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let _none_is_started = STARTING.write();
            kill_strays();
            // Ends this process as the signal would have.
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
    Ok(())
}

/// Kills all processes that this one has inherited. For the end of a run: what else this process
/// has started is killed too.
pub fn kill_strays() {
    #[cfg(target_os = "linux")]
    while let Some(stray) = children().first() {
        let _ = rustix::process::kill_process(*stray, Signal::KILL);
        let _ = rustix::process::waitpid(Some(*stray), rustix::process::WaitOptions::empty());
    }
}

/// The children of this process.
#[cfg(target_os = "linux")]
fn children() -> Vec<Pid> {
    let parent = |stat: &str| stat.rsplit(')').next()?.split_ascii_whitespace().nth(1)?.parse::<i32>().ok();
    let mine = rustix::process::getpid().as_raw_nonzero().get();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = processes.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let children = numbers.filter(|number| {
        let stat = std::fs::read_to_string(format!("/proc/{number}/stat"));
        stat.is_ok_and(|stat| parent(&stat) == Some(mine))
    });
    children.filter_map(Pid::from_raw).collect()
}

/// A process with its pipes. However it is dropped, its group is killed.
struct RunningProcess {
    child: Child,
    stdin: Option<ChildStdin>,
    stdout: ChildStdout,
    stderr: Option<ChildStderr>,
    /// What came after the last newline, in front.
    answers: Vec<u8>,
    pending: usize,
    stderr_tail: Vec<u8>,
}

/// What a read of standard output gave.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ReadOutcome {
    Nothing,
    Answers,
    EndOfFile,
}

impl RunningProcess {
    fn start(process: &Process) -> Result<Self, Error> {
        let mut command = shell(&process.command, process.folder.as_ref());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let _may_start = STARTING.read();
        let started = command.spawn();
        let mut child = started.map_err(Error::system(format!("'{}' cannot be started", process.command)))?;
        let (stdin, stdout, stderr) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let stdout = stdout.ok_or("standard output of the implementation")?;
        let running = Self {
            child,
            stdin,
            stdout,
            stderr,
            answers: vec![0; BUFFER],
            pending: 0,
            stderr_tail: Vec::new(),
        };
        nonblocking(&running.stdout)?;
        running.stdin.as_ref().map_or(Ok(()), nonblocking)?;
        running.stderr.as_ref().map_or(Ok(()), nonblocking)?;
        Ok(running)
    }

    /// Holds the conversation until the scoreboard has all answers, or nothing more can come.
    fn hold(
        &mut self,
        text: &[u8],
        scoreboard: &mut Scoreboard<'_>,
        limit: Duration,
        deadline: &Deadline,
    ) -> Option<Timeout> {
        let began = Instant::now();
        let mut last_answer = began;
        let mut sent = 0;
        while !matches!(scoreboard.stage(), Stage::Broken | Stage::Unsupported) {
            let left = limit.saturating_sub(began.elapsed());
            if left.is_zero() {
                let silent = last_answer.elapsed() > limit / 2;
                return Some(if silent { self.hung(scoreboard, limit) } else { Timeout::Slow });
            }
            if deadline.has_come() {
                return Some(Timeout::Stopped);
            }
            self.wait(left.min(deadline.left()).min(STOP_POLL));
            match self.read_answers(scoreboard, sent) {
                ReadOutcome::Answers => last_answer = Instant::now(),
                ReadOutcome::Nothing => {}
                ReadOutcome::EndOfFile => return self.ended(scoreboard, began + limit, deadline),
            }
            self.read_stderr();
            sent += self.write(&text[sent..]);
        }
        None
    }

    fn hung(&self, scoreboard: &mut Scoreboard<'_>, limit: Duration) -> Timeout {
        let limit = limit.as_secs_f64();
        if scoreboard.stage() == Stage::Ended {
            scoreboard
                .misbehaves("P-6", &format!("does not end within the time limit of {limit} s after 'end'"));
        } else {
            scoreboard.silent("P-8", &format!("no answer within the time limit of {limit} s"));
        }
        Timeout::Hung
    }

    /// Waits until something can be read or written.
    fn wait(&self, left: Duration) {
        let mut fds = vec![PollFd::new(&self.stdout, PollFlags::IN)];
        fds.extend(self.stderr.as_ref().map(|stderr| PollFd::new(stderr, PollFlags::IN)));
        fds.extend(self.stdin.as_ref().map(|stdin| PollFd::new(stdin, PollFlags::OUT)));
        let left = Timespec { tv_sec: left.as_secs() as i64, tv_nsec: i64::from(left.subsec_nanos()) };
        // Where it fails, the next look at the clock decides.
        let _ = poll(&mut fds, Some(&left));
    }

    /// Hands whole lines to the scoreboard; takes what one read gives.
    fn read_answers(&mut self, scoreboard: &mut Scoreboard<'_>, sent: usize) -> ReadOutcome {
        if self.pending == self.answers.len() {
            if self.answers.len() >= MAX_ANSWER {
                let says = format!("an answer of more than {MAX_ANSWER} bytes without a newline");
                scoreboard.silent("P-5", &says);
                return ReadOutcome::Answers;
            }
            self.answers.resize(2 * self.answers.len(), 0);
        }
        let read = match self.stdout.read(&mut self.answers[self.pending..]) {
            Ok(0) => return ReadOutcome::EndOfFile,
            Ok(read) => read,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                return ReadOutcome::Nothing;
            }
            Err(_) => return ReadOutcome::EndOfFile,
        };
        let end = self.pending + read;
        let mut begin = 0;
        while let Some(length) = memchr(b'\n', &self.answers[begin..end]) {
            scoreboard.answer(&self.answers[begin..begin + length], sent);
            begin += length + 1;
            if matches!(scoreboard.stage(), Stage::Broken | Stage::Unsupported) {
                break;
            }
        }
        self.answers.copy_within(begin..end, 0);
        self.pending = end - begin;
        if begin > 0 { ReadOutcome::Answers } else { ReadOutcome::Nothing }
    }

    /// Takes a part of standard error, and keeps its end.
    fn read_stderr(&mut self) {
        let Some(stderr) = &mut self.stderr else { return };
        let mut bytes = [0; STDERR_KEPT];
        match stderr.read(&mut bytes) {
            Ok(0) => self.stderr = None,
            Ok(read) => {
                self.stderr_tail.extend_from_slice(&bytes[..read]);
                let before = self.stderr_tail.len().saturating_sub(STDERR_KEPT);
                self.stderr_tail.drain(..before);
            }
            Err(_) => {}
        }
    }

    /// Sends what fits into the pipe, and closes it after the last byte; says how much was sent.
    fn write(&mut self, rest: &[u8]) -> usize {
        let Some(stdin) = &mut self.stdin else { return 0 };
        let sent = match stdin.write(&rest[..rest.len().min(BUFFER)]) {
            Ok(sent) => sent,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => return 0,
            // It reads no more. Its answers show whether it should have.
            Err(_) => {
                self.stdin = None;
                return 0;
            }
        };
        if sent == rest.len() {
            self.stdin = None;
        }
        sent
    }

    /// Standard output has ended: says so where answers lack, else waits for the exit.
    fn ended(
        &mut self,
        scoreboard: &mut Scoreboard<'_>,
        exit_by: Instant,
        deadline: &Deadline,
    ) -> Option<Timeout> {
        // After the end it has all of its time to exit. Before, only how it exits is still of interest.
        let all_answered = scoreboard.stage() == Stage::Ended && self.pending == 0;
        let exit_by = if all_answered { exit_by } else { exit_by.min(Instant::now() + EXIT_GRACE) };
        let mut exit = self.exit();
        while exit.is_none() && Instant::now() < exit_by {
            if deadline.has_come() {
                return Some(Timeout::Stopped);
            }
            std::thread::sleep(EXIT_POLL);
            self.read_stderr();
            exit = self.exit();
        }
        let how = exit.as_deref().unwrap_or("closed its output");
        if scoreboard.stage() != Stage::Ended {
            let more = if self.pending > 0 { ", in the middle of an answer" } else { "" };
            scoreboard.silent("P-7", &format!("the implementation {how}{more}"));
        } else if self.pending > 0 {
            scoreboard.misbehaves("P-4", "output after the answer to 'end'");
        } else if exit.is_none() {
            scoreboard.misbehaves("P-6", "does not end within the time limit after 'end'");
            return Some(Timeout::Hung);
        } else if how != SUCCESS {
            scoreboard.misbehaves("P-6", &format!("the implementation {how} after 'end'"));
        }
        None
    }

    /// How the process has ended, if it has. It stays a zombie, so that its group's number is not
    /// given to another.
    fn exit(&self) -> Option<String> {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
        let status = waitid(WaitId::Pid(Pid::from_child(&self.child)), options).ok()??;
        Some(match (status.exit_status(), status.terminating_signal()) {
            (Some(0), _) => SUCCESS.to_owned(),
            (Some(status), _) => format!("ended with status {status}"),
            (None, Some(signal)) => format!("was ended by signal {signal}"),
            (None, None) => "ended".to_owned(),
        })
    }

    /// Kills the process with all of its group, and takes its end.
    fn kill(&mut self) {
        kill_group(&mut self.child);
    }
}

const SUCCESS: &str = "ended with status 0";

impl Drop for RunningProcess {
    fn drop(&mut self) {
        self.kill();
    }
}

fn nonblocking(fd: &impl AsFd) -> Result<(), Error> {
    let what = "pipe to the implementation";
    let flags = fcntl_getfl(fd).map_err(Error::system(what))?;
    fcntl_setfl(fd, flags | OFlags::NONBLOCK).map_err(Error::system(what))
}
