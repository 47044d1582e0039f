//! An implementation in process, and the protocol around it.

use crate::KINDS;
use crate::kind::Kind;
use std::fmt;
use std::io::{self, BufRead, BufReader, Read, Write};

/// Bytes that are read and written at a time.
const BUFFER: usize = 1 << 16;

/// A value of the configuration that an implementation does not support, by its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsupported(pub String);

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unsupported {}", self.0)
    }
}

/// A configured implementation: requests in, answers out, both lines without their newlines.
pub trait Served: Send {
    /// The list after `observes=`.
    fn observes(&self) -> String;

    /// Appends the answer to a request.
    ///
    /// # Errors
    /// What would be right, where the line is no request.
    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), &'static str>;
}

/// Makes a configured implementation of a kind.
pub type MakeServed = dyn Fn(&dyn Kind, &str) -> Result<Box<dyn Served>, Unsupported> + Sync;

/// The conversation as an implementation holds it: hello, configuration, requests, end.
pub struct Server<'a> {
    make: &'a MakeServed,
    kind: Option<&'static dyn Kind>,
    served: Option<Box<dyn Served>>,
}

impl<'a> Server<'a> {
    /// A conversation that has not begun.
    #[must_use]
    pub fn new(make: &'a MakeServed) -> Self {
        Self { make, kind: None, served: None }
    }

    /// Appends the answer to a line, with its newline; nothing to a comment. Returns whether more
    /// can follow.
    #[inline]
    pub fn answer(&mut self, line: &[u8], answer: &mut Vec<u8>) -> bool {
        if line.is_empty() || line[0] == b'#' {
            return true;
        }
        let more = line != b"end";
        let said = match (&mut self.served, self.kind) {
            _ if !more => {
                answer.extend_from_slice(b"end");
                Ok(())
            }
            (Some(served), _) => served.answer(line, answer),
            (None, None) => self.hello(line, answer),
            (None, Some(kind)) => self.configure(kind, line, answer),
        };
        if let Err(right) = said {
            answer.extend_from_slice(b"? ");
            answer.extend_from_slice(right.as_bytes());
        }
        answer.push(b'\n');
        more
    }

    fn hello(&mut self, line: &[u8], answer: &mut Vec<u8>) -> Result<(), &'static str> {
        let kind = KINDS.iter().find(|kind| kind.hello().as_bytes() == line);
        self.kind = Some(*kind.ok_or("no such kind or version")?);
        answer.extend_from_slice(line);
        Ok(())
    }

    fn configure(&mut self, kind: &dyn Kind, line: &[u8], answer: &mut Vec<u8>) -> Result<(), &'static str> {
        let config = line.strip_prefix(b"config ").and_then(|config| std::str::from_utf8(config).ok());
        match (self.make)(kind, config.ok_or("write 'config KEY=VALUE ..'")?) {
            Ok(served) => {
                let _ = write!(answer, "ok observes={}", served.observes());
                self.served = Some(served);
            }
            Err(unsupported) => {
                let _ = write!(answer, "{unsupported}");
            }
        }
        Ok(())
    }
}

/// Holds a conversation over streams, such as standard input and output.
///
/// # Errors
/// Where a stream fails.
pub fn serve(make: &MakeServed, input: impl Read, mut output: impl Write) -> io::Result<()> {
    let mut input = BufReader::with_capacity(BUFFER, input);
    let mut server = Server::new(make);
    let (mut line, mut answers) = (Vec::new(), Vec::new());
    let mut more = true;
    while more && input.read_until(b'\n', &mut line)? > 0 {
        more = server.answer(line.trim_ascii_end(), &mut answers);
        line.clear();
        // What was asked for is answered before more is waited for.
        if answers.len() >= BUFFER || !input.buffer().contains(&b'\n') {
            output.write_all(&answers)?;
            output.flush()?;
            answers.clear();
        }
    }
    output.write_all(&answers)?;
    output.flush()
}
