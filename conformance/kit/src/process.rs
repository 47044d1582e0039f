//! An implementation as a child process: written to and read from at once, within a time limit, in
//! bounded memory, and gone afterwards with all that it started.

use crate::children::{LeaderEnd, ProcessGroup};
use crate::deadline::Deadline;
use crate::dut::{ConversationEnd, Dut, Timeout};
use crate::error::Error;
use crate::scoreboard::{Scoreboard, Stage};
use crate::session::Session;
use crate::vm::config::MAX_LINE_BYTES;
use memchr::memchr;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::process::{ChildStderr, ChildStdin, ChildStdout, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
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
/// Answers between two looks at the clock.
const ANSWERS_PER_LOOK: usize = 4;
/// Time between two checks of a process that is about to exit.
const EXIT_POLL: Duration = Duration::from_millis(1);

/// The part of their time that sessions have once one has hung.
const HURRIED: u32 = 4;

const AFTER_END: &str = "output after the answer to 'end'";

/// A command line that is started for a session, or for several where it offers that.
#[derive(Debug)]
pub struct Process {
    command: String,
    folder: Option<PathBuf>,
    time_limit: Duration,
    /// Whether it has answered anything: then it can be started, whatever status it ends with.
    has_answered: AtomicBool,
    /// Whether it offers several sessions a process.
    offers_sessions: AtomicBool,
    /// Whether sessions have only a [`HURRIED`] part of their time.
    is_hurried: AtomicBool,
    /// Processes that wait for their next session.
    idle: Mutex<Vec<RunningProcess>>,
}

impl Process {
    /// The command line, for a shell, in a folder, or in the present one; and the time that a session may take.
    #[must_use]
    pub fn new(command: String, folder: Option<PathBuf>, time_limit: Duration) -> Self {
        Self {
            command,
            folder,
            time_limit,
            has_answered: AtomicBool::new(false),
            offers_sessions: AtomicBool::new(false),
            is_hurried: AtomicBool::new(false),
            idle: Mutex::default(),
        }
    }

    fn idle(&self) -> MutexGuard<'_, Vec<RunningProcess>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Holds the conversation with a process; `is_last` where no other session is to follow in it.
    fn hold(
        &self,
        mut running: RunningProcess,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
        is_last: bool,
    ) -> Result<ConversationEnd, Error> {
        // Before the offer is known, the end of its input may be what it waits for.
        running.stays = !is_last && self.offers_sessions.load(Ordering::Relaxed);
        let is_hurried = self.is_hurried.load(Ordering::Relaxed);
        let limit = self.time_limit * session.patience;
        let limit = if is_hurried { self.time_limit / HURRIED } else { limit };
        let timeout = match running.hold(session, scoreboard, limit, deadline)? {
            // With all of its time it might have been quick enough.
            Some(Timeout::Slow) if is_hurried => Some(Timeout::Stopped),
            timeout => timeout,
        };
        self.offers_sessions.fetch_or(scoreboard.offers_sessions(), Ordering::Relaxed);
        if running.stays && scoreboard.stage() == Stage::Ended && timeout.is_none() {
            self.idle().push(running);
            return Ok(ConversationEnd::default());
        }
        // None where it has ended, and where it does not matter any more.
        let ended = running.group.end()?;
        running.group.kill();
        running.read_stderr();
        let stderr = String::from_utf8_lossy(&running.stderr_tail).into_owned();
        if running.has_answered {
            self.has_answered.store(true, Ordering::Relaxed);
        }
        match ended {
            Some(end) if end.is_not_started() && !self.has_answered.load(Ordering::Relaxed) => {
                let command = self.command.clone();
                Err(Error::NotStarted { command, why: format!("it {end}: {}", one_line(&stderr)) })
            }
            _ => Ok(ConversationEnd { timeout, stderr, is_used: false }),
        }
    }
}

/// Text as one line.
fn one_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<_>>().join(" | ")
}

impl Dut for Process {
    fn converse(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        let idle = self.idle().pop();
        let is_used = idle.is_some();
        let running = idle.map_or_else(|| RunningProcess::start(self), Ok)?;
        let end = self.hold(running, session, scoreboard, deadline, false)?;
        Ok(ConversationEnd { is_used, ..end })
    }

    fn converse_alone(
        &self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        deadline: &Deadline,
    ) -> Result<ConversationEnd, Error> {
        self.hold(RunningProcess::start(self)?, session, scoreboard, deadline, true)
    }

    fn time_limit(&self) -> Option<Duration> {
        Some(self.time_limit)
    }

    fn hurry(&self) {
        self.is_hurried.store(true, Ordering::Relaxed);
    }

    fn finish(&self) {
        self.idle().clear();
    }
}

/// A process with its pipes.
#[derive(Debug)]
struct RunningProcess {
    group: ProcessGroup,
    stdin: Option<ChildStdin>,
    stdout: ChildStdout,
    stderr: Option<ChildStderr>,
    /// What came after the last newline, in front.
    answers: Vec<u8>,
    pending: usize,
    stderr_tail: Vec<u8>,
    /// Its input stays open behind the last request, for another session.
    stays: bool,
    /// It has answered something.
    has_answered: bool,
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
        let mut group = ProcessGroup::start(&process.command, process.folder.as_deref(), |command| {
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        })?;
        let leader = &mut group.leader;
        let (stdin, stdout, stderr) = (leader.stdin.take(), leader.stdout.take(), leader.stderr.take());
        let stdout = stdout.ok_or("standard output of the implementation")?;
        let running = Self {
            group,
            stdin,
            stdout,
            stderr,
            answers: vec![0; BUFFER],
            pending: 0,
            stderr_tail: Vec::new(),
            stays: false,
            has_answered: false,
        };
        nonblocking(&running.stdout)?;
        running.stdin.as_ref().map_or(Ok(()), nonblocking)?;
        running.stderr.as_ref().map_or(Ok(()), nonblocking)?;
        Ok(running)
    }

    /// Holds the conversation until the scoreboard has all answers, or nothing more can come.
    fn hold(
        &mut self,
        session: &Session,
        scoreboard: &mut Scoreboard<'_>,
        limit: Duration,
        deadline: &Deadline,
    ) -> Result<Option<Timeout>, Error> {
        let ends = Instant::now() + limit;
        let mut last_answer = Instant::now();
        let mut sent = 0;
        self.stderr_tail.clear();
        while !matches!(scoreboard.stage(), Stage::Broken | Stage::Unsupported) {
            match scoreboard.stage() {
                Stage::Hello => {}
                Stage::Ended if self.stays => {
                    if self.pending > 0 {
                        scoreboard.misbehaves("P-4", AFTER_END);
                    }
                    return Ok(None);
                }
                _ if self.stays && !scoreboard.offers_sessions() => {
                    // It has offered them before: now the end of its input is due.
                    self.stays = false;
                    self.stdin.take_if(|_| sent == session.len());
                }
                _ => {}
            }
            let left = ends.saturating_duration_since(Instant::now());
            if left.is_zero() {
                let silent = last_answer.elapsed() > limit / 2;
                return Ok(Some(if silent { self.hung(scoreboard, limit) } else { Timeout::Slow }));
            }
            if deadline.has_come() {
                return Ok(Some(Timeout::Stopped));
            }
            self.wait(left.min(deadline.left()).min(STOP_POLL), sent < session.len());
            // What the model takes for its own answers counts too.
            let is_over = || Instant::now() >= ends || deadline.has_come();
            match self.read_answers(scoreboard, sent, &is_over) {
                ReadOutcome::Answers => last_answer = Instant::now(),
                ReadOutcome::Nothing => {}
                ReadOutcome::EndOfFile => return self.ended(scoreboard, ends, deadline),
            }
            self.read_stderr();
            sent += self.write(session, sent);
        }
        Ok(None)
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

    /// Waits until something can be read, or written if there is more.
    fn wait(&self, left: Duration, is_more: bool) {
        let mut fds = vec![PollFd::new(&self.stdout, PollFlags::IN)];
        fds.extend(self.stderr.as_ref().map(|stderr| PollFd::new(stderr, PollFlags::IN)));
        fds.extend(self.stdin.as_ref().filter(|_| is_more).map(|stdin| PollFd::new(stdin, PollFlags::OUT)));
        let left = Timespec { tv_sec: left.as_secs() as i64, tv_nsec: i64::from(left.subsec_nanos()) };
        // Where it fails, the next look at the clock decides.
        let _ = poll(&mut fds, Some(&left));
    }

    /// Hands whole lines to the scoreboard; takes what one read gives, while there is time.
    fn read_answers(
        &mut self,
        scoreboard: &mut Scoreboard<'_>,
        sent: usize,
        is_over: &dyn Fn() -> bool,
    ) -> ReadOutcome {
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
        self.has_answered = true;
        let end = self.pending + read;
        let mut begin = 0;
        for number in 1.. {
            let Some(length) = memchr(b'\n', &self.answers[begin..end]) else { break };
            scoreboard.answer(&self.answers[begin..begin + length], sent);
            begin += length + 1;
            let broken = matches!(scoreboard.stage(), Stage::Broken | Stage::Unsupported);
            if broken || (number % ANSWERS_PER_LOOK == 0 && is_over()) {
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

    /// Sends from a place on what fits into the pipe, and closes it after the last byte where the process does not stay; says how
    /// much was sent.
    fn write(&mut self, session: &Session, at: usize) -> usize {
        let rest = session.part_at(at);
        let Some(stdin) = self.stdin.as_mut().filter(|_| !rest.is_empty()) else { return 0 };
        let sent = match stdin.write(&rest[..rest.len().min(BUFFER)]) {
            Ok(sent) => sent,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => return 0,
            // It reads no more. Its answers show whether it should have.
            Err(_) => {
                self.stdin = None;
                return 0;
            }
        };
        if at + sent == session.len() && !self.stays {
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
    ) -> Result<Option<Timeout>, Error> {
        // After the end it has all of its time to exit. Before, only how it exits is still of interest.
        let all_answered = scoreboard.stage() == Stage::Ended && self.pending == 0;
        let exit_by = if all_answered { exit_by } else { exit_by.min(Instant::now() + EXIT_GRACE) };
        let mut exit = self.group.end()?;
        while exit.is_none() && Instant::now() < exit_by {
            if deadline.has_come() {
                return Ok(Some(Timeout::Stopped));
            }
            std::thread::sleep(EXIT_POLL);
            self.read_stderr();
            exit = self.group.end()?;
        }
        let how = exit.map_or("closed its output".to_owned(), |exit| exit.to_string());
        if scoreboard.stage() != Stage::Ended {
            let more = if self.pending > 0 { ", in the middle of an answer" } else { "" };
            scoreboard.silent("P-7", &format!("the implementation {how}{more}"));
        } else if self.pending > 0 {
            scoreboard.misbehaves("P-4", AFTER_END);
        } else if exit.is_none() {
            scoreboard.misbehaves("P-6", "does not end within the time limit after 'end'");
            return Ok(Some(Timeout::Hung));
        } else if !exit.is_some_and(LeaderEnd::is_success) {
            scoreboard.misbehaves("P-6", &format!("the implementation {how} after 'end'"));
        }
        Ok(None)
    }
}

fn nonblocking(fd: &impl AsFd) -> Result<(), Error> {
    let what = "pipe to the implementation";
    let flags = fcntl_getfl(fd).map_err(Error::system(what))?;
    fcntl_setfl(fd, flags | OFlags::NONBLOCK).map_err(Error::system(what))
}
