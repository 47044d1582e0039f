//! The protocol around an implementation in process: hello, configuration, requests, end.

use crate::error::Error;
use crate::implementation::Implementation;
use crate::kind::Kind;
use crate::kinds::kind_of_hello;
use std::io::{self, BufRead, BufReader, Read, Write};

/// Bytes that are read and written at a time.
const BUFFER: usize = 1 << 16;

/// Makes an implementation of a kind and a configuration; where it does not support a value, it fails with
/// [`Error::Unsupported`] and the key.
pub type MakeImplementation = dyn Fn(&dyn Kind, &str) -> Result<Box<dyn Implementation>, Error> + Sync;

/// The conversation as an implementation holds it: hello, configuration, requests, end.
pub struct Server<'a> {
    make: &'a MakeImplementation,
    kind: Option<&'static dyn Kind>,
    implementation: Option<Box<dyn Implementation>>,
}

impl<'a> Server<'a> {
    /// A conversation that has not begun.
    #[must_use]
    pub fn new(make: &'a MakeImplementation) -> Self {
        Self { make, kind: None, implementation: None }
    }

    /// Appends the answer to a line, with its newline; nothing to a comment. Returns whether more
    /// can follow.
    #[inline]
    pub fn answer(&mut self, line: &[u8], answer: &mut Vec<u8>) -> bool {
        if line.is_empty() || line[0] == b'#' {
            return true;
        }
        let more = line != b"end";
        let said = match (&mut self.implementation, self.kind) {
            _ if !more => {
                answer.extend_from_slice(b"end");
                Ok(())
            }
            (Some(implementation), _) => implementation.answer(line, answer),
            (None, None) => self.hello(line, answer),
            (None, Some(kind)) => self.configure(kind, line, answer),
        };
        if let Err(right) = said {
            let _ = write!(answer, "? {right}");
        }
        answer.push(b'\n');
        more
    }

    fn hello(&mut self, line: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        self.kind = Some(kind_of_hello(line).ok_or("no such kind or version")?);
        answer.extend_from_slice(line);
        Ok(())
    }

    fn configure(&mut self, kind: &dyn Kind, line: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let config = line.strip_prefix(b"config ").and_then(|config| std::str::from_utf8(config).ok());
        match (self.make)(kind, config.ok_or("write 'config KEY=VALUE ..'")?) {
            Ok(implementation) => {
                let _ = write!(answer, "ok observes={}", implementation.observes());
                self.implementation = Some(implementation);
            }
            Err(unsupported @ Error::Unsupported(_)) => {
                let _ = write!(answer, "{unsupported}");
            }
            // No value of it is supported.
            Err(wrong) => {
                let _ = write!(answer, "unsupported {wrong}");
            }
        }
        Ok(())
    }
}

/// Holds a conversation over streams, such as standard input and output.
///
/// # Errors
/// Where a stream fails.
pub fn serve(make: &MakeImplementation, input: impl Read, mut output: impl Write) -> io::Result<()> {
    let mut input = BufReader::with_capacity(BUFFER, input);
    let mut server = Server::new(make);
    let (mut line, mut answers) = (Vec::new(), Vec::new());
    let mut more = true;
    while more && input.read_until(b'\n', &mut line)? > 0 {
        more = server.answer(line.trim_ascii_end(), &mut answers);
        line.clear();
        // All answers so far are written before the server waits for more requests.
        if answers.len() >= BUFFER || !input.buffer().contains(&b'\n') {
            output.write_all(&answers)?;
            output.flush()?;
            answers.clear();
        }
    }
    output.write_all(&answers)?;
    output.flush()
}
