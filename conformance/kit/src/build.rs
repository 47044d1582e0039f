//! Building an implementation: within a time limit, with bounded output, and with nothing left that runs.

use crate::children::ProcessGroup;
use crate::error::Error;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use std::io::{ErrorKind, PipeReader, Read as _};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Bytes that a build may write (Assumed): far more than a compiler's complaints about a large program.
const MOST_OUTPUT: usize = 64 << 20;
/// Bytes of the output that are kept: its end, which says why a build fails.
const KEPT: usize = 4096;
/// Lines of it that are shown.
const SHOWN_LINES: usize = 3;
/// Bytes that a pipe holds at most, as Linux limits it.
const MOST_IN_PIPE: usize = 1 << 20;
/// Time between two looks at a build that writes nothing.
const POLL: Duration = Duration::from_millis(5);

/// How an implementation is built.
#[derive(Clone, Debug)]
pub(crate) struct Build {
    /// The command line, for a shell.
    pub command: String,
    /// The folder that it is started in.
    pub folder: PathBuf,
    /// Time that it may take.
    pub time_limit: Duration,
}

/// What a build has written to its output and its errors, as both came.
struct Output {
    pipe: Option<PipeReader>,
    end: Vec<u8>,
    bytes: usize,
}

impl Build {
    /// Builds it.
    ///
    /// # Errors
    /// Where the build fails, with the end of its output; where it takes too long, or writes without end.
    pub fn run(&self) -> Result<(), Error> {
        let no_pipe = "pipe for the output of the build";
        let (reader, writer) = std::io::pipe().map_err(Error::system(no_pipe))?;
        let errors = writer.try_clone().map_err(Error::system(no_pipe))?;
        let flags = fcntl_getfl(&reader).map_err(Error::system(no_pipe))?;
        fcntl_setfl(&reader, flags | OFlags::NONBLOCK).map_err(Error::system(no_pipe))?;
        let mut output = Output { pipe: Some(reader), end: Vec::new(), bytes: 0 };
        let group = ProcessGroup::start(&self.command, Some(&self.folder), |command| {
            command.stdin(Stdio::null()).stdout(writer).stderr(errors);
        })?;
        let ends = Instant::now() + self.time_limit;
        loop {
            // The output of one that has ended is complete: what it left running may fill the pipe for ever.
            let end = group.end()?;
            output.read();
            if end.is_none() && output.bytes > MOST_OUTPUT {
                return Err(self.fails(format!("writes more than {} MiB", MOST_OUTPUT >> 20)));
            }
            match end {
                Some(end) if end.is_success() => return Ok(()),
                Some(end) => return Err(self.fails(format!("{end}: {}", output.last_lines()))),
                None if Instant::now() >= ends => {
                    let seconds = self.time_limit.as_secs_f64();
                    return Err(self.fails(format!("not done within {seconds} s, its build_limit")));
                }
                None => output.wait(),
            }
        }
    }

    fn fails(&self, why: String) -> Error {
        Error::Build { command: self.command.clone(), folder: self.folder.display().to_string(), why }
    }
}

impl Output {
    /// Takes what is in the pipe, and keeps its end.
    fn read(&mut self) {
        let mut bytes = [0; 1 << 16];
        let before = self.bytes;
        while let Some(pipe) = self.pipe.as_mut().filter(|_| self.bytes - before < MOST_IN_PIPE) {
            match pipe.read(&mut bytes) {
                Ok(0) => self.pipe = None,
                Ok(read) => {
                    self.bytes += read;
                    self.end.extend_from_slice(&bytes[..read]);
                    self.end.drain(..self.end.len().saturating_sub(KEPT));
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(_) => self.pipe = None,
            }
        }
    }

    /// Waits until something can be read, but not for long.
    fn wait(&self) {
        match &self.pipe {
            Some(pipe) => {
                let time = Timespec { tv_sec: 0, tv_nsec: i64::from(POLL.subsec_nanos()) };
                // Where it fails, the next look at the clock decides.
                let _ = poll(&mut [PollFd::new(pipe, PollFlags::IN)], Some(&time));
            }
            None => std::thread::sleep(POLL),
        }
    }

    fn last_lines(&self) -> String {
        let text = String::from_utf8_lossy(&self.end);
        let lines: Vec<_> = text.lines().collect();
        lines[lines.len().saturating_sub(SHOWN_LINES)..].join(" | ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Long enough for whatever ends, on a busy machine too.
    const AMPLE: Duration = Duration::from_secs(600);

    fn built(command: &str, time_limit: Duration) -> Result<(), String> {
        let folder = tempfile::tempdir().expect("a folder");
        let build = Build { command: command.to_owned(), folder: folder.path().to_owned(), time_limit };
        build.run().map_err(|error| error.to_string())
    }

    #[test]
    fn builds_end_with_few_words() {
        assert_eq!(built("echo compiles; sleep 1000 &", AMPLE), Ok(()));
        assert_eq!(built("yes & true", AMPLE), Ok(()));
        let says = built("seq 100000; echo wrong >&2; exit 3", AMPLE).expect_err("it fails");
        assert!(says.ends_with("ended with status 3: 99999 | 100000 | wrong"), "{says}");
    }

    #[test]
    fn builds_without_end_are_ended() {
        for command in
            ["sleep 1000", "sleep 1000 > /dev/null 2>&1", "while :; do echo more; sleep 0.01; done"]
        {
            let says = built(command, Duration::from_millis(500)).expect_err("it hangs");
            assert!(says.ends_with("not done within 0.5 s, its build_limit"), "{says}");
        }
        for command in ["yes", "cat /dev/zero >&2"] {
            let says = built(command, AMPLE).expect_err("it writes without end");
            assert!(says.ends_with("writes more than 64 MiB"), "{says}");
        }
    }
}
