//! The error type of the kit.

use std::borrow::Cow;
use std::io;

/// What is wrong, where, and what would be right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Input is not in its form: a request, an answer, a key or its value. Says what is wrong, or what would
    /// be right.
    #[error("{0}")]
    Invalid(Cow<'static, str>),
    /// An implementation does not support the value of this key of a configuration.
    #[error("unsupported {0}")]
    Unsupported(String),
    /// The configuration of a session is not valid.
    #[error("config: {0}")]
    Config(Box<Error>),
    /// A request of a session is not legal.
    #[error("request {number}, '{request}': {wrong}")]
    Request {
        /// Its number, from 1 on.
        number: usize,
        /// Its text.
        request: String,
        /// What is wrong with it.
        wrong: Box<Error>,
    },
    /// A line of a file is wrong.
    #[error("line {line}: {right}")]
    Line {
        /// Its number, from 1 on; 0 where the file has none.
        line: usize,
        /// What is wrong, and what would be right.
        right: String,
    },
    /// Something is wrong in what a person named: a file, a folder, a suite.
    #[error("{name}: {wrong}")]
    In {
        /// Its name.
        name: String,
        /// What is wrong there.
        wrong: Box<Error>,
    },
    /// The operating system refuses something.
    #[error("{what}")]
    System {
        /// What cannot be done.
        what: String,
        /// Why.
        source: io::Error,
    },
    /// A file is no shared library with the functions of `saarcor.h`.
    #[cfg(unix)]
    #[error("{what}")]
    Library {
        /// The file, and what is wrong with it.
        what: String,
        /// What the loader says.
        source: libloading::Error,
    },
    /// The command that builds an implementation fails.
    #[error("build '{command}' in {folder}: {why}")]
    Build {
        /// The command line.
        command: String,
        /// The folder that it was started in.
        folder: String,
        /// How it ended, and the end of what it wrote.
        why: String,
    },
    /// The command line of an implementation starts nothing.
    #[error("'{command}' cannot be started: {why}")]
    NotStarted {
        /// The command line.
        command: String,
        /// How it ended, and what the shell says.
        why: String,
    },
    /// The report cannot be written as XML.
    #[error("the report as XML")]
    Junit(#[from] quick_junit::SerializeError),
}

impl Error {
    /// The error as one in something that has a name.
    #[must_use]
    pub fn within(self, name: impl Into<String>) -> Self {
        Self::In { name: name.into(), wrong: Box::new(self) }
    }

    /// The error as one of a session's configuration.
    #[must_use]
    pub fn in_config(self) -> Self {
        Self::Config(Box::new(self))
    }

    /// The error as one of the request of that number, from 1 on.
    #[must_use]
    pub fn in_request(self, number: usize, request: &[u8]) -> Self {
        let request = String::from_utf8_lossy(request).into_owned();
        Self::Request { number, request, wrong: Box::new(self) }
    }

    /// For `map_err`: says what the operating system refuses.
    pub(crate) fn system<E: Into<io::Error>>(what: impl Into<String>) -> impl FnOnce(E) -> Self {
        move |source| Self::System { what: what.into(), source: source.into() }
    }
}

impl From<&'static str> for Error {
    fn from(right: &'static str) -> Self {
        Self::Invalid(right.into())
    }
}

impl From<String> for Error {
    fn from(right: String) -> Self {
        Self::Invalid(right.into())
    }
}
