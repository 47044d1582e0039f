//! A session: one conversation with an implementation, as the text that is sent to it.

use crate::error::Error;
use crate::level::Level;
use crate::script::Script;
use memchr::memchr;
use std::io::{self, Write};
use std::ops::Range;

/// Begins a line of a suite file that is about the session and not part of it.
const ABOUT: &str = "#:";
/// The line that ends a conversation.
const END: &[u8] = b"end\n";

/// One conversation: the hello, the configuration, requests, and the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Session {
    /// What it is called, such as `vm/free-way-lowest` or `vm/random/17`.
    pub name: String,
    /// The requirement that it is about; none where it is about all.
    pub requirement: Option<String>,
    /// The level up to which it is judged: what its requirement can be seen at. None: all.
    pub level: Option<Level>,
    /// Its idea in a sentence.
    pub idea: String,
    /// So many time limits it may take: one for each MiB of its text, where nothing else is said.
    pub patience: u32,
    /// The hello and the configuration, each a line.
    head: String,
    hello: Range<usize>,
    config: Range<usize>,
    body: Script,
}

/// Requests of a session, each a line with its newline: some first, then others so many times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Requests {
    /// Those that come first.
    pub first: Vec<u8>,
    /// Those that are repeated.
    pub again: Vec<u8>,
    /// How often they come.
    pub times: usize,
}

impl From<Vec<u8>> for Requests {
    fn from(first: Vec<u8>) -> Self {
        Self { first, ..Self::default() }
    }
}

impl Session {
    /// The session of these parts; requests are lines, each with its newline.
    #[must_use]
    pub fn new(name: &str, hello: &str, config: &str, requests: &[u8]) -> Self {
        let mut body = Script::with_capacity(requests.len());
        body.push(requests, 1);
        Self::made(name, hello, config, body)
    }

    /// The session of these parts, some of which are repeated, and in memory once.
    #[must_use]
    pub fn repeating(name: &str, hello: &str, config: &str, requests: &Requests) -> Self {
        let Requests { first, again, times } = requests;
        let mut body = Script::with_capacity(first.len() + again.len());
        body.push(first, 1);
        body.push(again, *times);
        Self::made(name, hello, config, body)
    }

    fn made(name: &str, hello: &str, config: &str, mut body: Script) -> Self {
        body.shrink_to_fit();
        let head = format!("{hello}\nconfig {config}\n");
        let config = head.len() - config.len() - 1..head.len() - 1;
        Self {
            name: name.to_owned(),
            requirement: None,
            level: None,
            idea: String::new(),
            patience: (body.len() >> 20).max(1) as u32,
            hello: 0..hello.len(),
            config,
            head,
            body,
        }
    }

    /// The sessions of a suite file: one for its configuration, and one for each line
    /// `#: also KEY=VALUE ..`, which replaces some of it. `#: REQUIREMENT LEVEL IDEA` says what it is about.
    ///
    /// # Errors
    /// The line where the text is no session: it lacks the hello, the configuration or the end.
    pub fn parse(name: &str, suite: &str) -> Result<Vec<Self>, Error> {
        let mut about = Vec::new();
        let mut also = Vec::new();
        let mut lines = suite.lines().zip(1..).peekable();
        while let Some((line, _)) = lines.next_if(|(line, _)| line.trim().is_empty() || line.starts_with('#'))
        {
            let Some(said) = line.strip_prefix(ABOUT).map(str::trim) else { continue };
            match said.strip_prefix("also ") {
                Some(changes) => also.push(changes),
                None => about.push(said),
            }
        }
        let wrong = |line, right: &str| Error::Line { line, right: right.to_owned() };
        let Some((hello, _)) = lines.next() else {
            return Err(wrong(
                suite.lines().count(),
                "no session; the first request is a hello, such as 'saarcor-vm 1'",
            ));
        };
        let (config, _) = lines
            .next()
            .and_then(|(line, number)| Some((line.strip_prefix("config ")?, number)))
            .filter(|(config, _)| !config.trim().is_empty())
            .ok_or_else(|| {
                wrong(about.len() + also.len() + 2, "'config KEY=VALUE ..' has to follow the hello")
            })?;
        let mut requests = String::new();
        let mut ended = false;
        for (line, number) in lines {
            if ended && !line.trim().is_empty() && !line.starts_with('#') {
                return Err(wrong(number, "nothing follows 'end'"));
            }
            ended |= line == "end";
            if !ended && !line.trim().is_empty() {
                requests.push_str(line);
                requests.push('\n');
            }
        }
        if !ended {
            return Err(wrong(suite.lines().count(), "the session lacks its 'end'"));
        }
        let about = about.join(" ");
        let (requirement, rest) = about.split_once(' ').unwrap_or((&about, ""));
        let (level, idea) = rest.split_once(' ').unwrap_or((rest, ""));
        let level = Level::ALL.into_iter().find(|known| known.name() == level);
        let idea = if level.is_some() { idea } else { rest };
        let session = |name: &str, config: &str| Self {
            requirement: (!requirement.is_empty()).then(|| requirement.to_owned()),
            level,
            idea: idea.to_owned(),
            ..Self::new(name, hello, config, requests.as_bytes())
        };
        let mut sessions = vec![session(name, config)];
        for changes in also {
            let config = changed(config, changes);
            sessions.push(session(&format!("{name}@{}", changes.replace(' ', ",")), &config));
        }
        Ok(sessions)
    }

    /// Bytes of all that is sent.
    #[inline]
    #[must_use]
    pub fn len(&self) -> usize {
        self.head.len() + self.body.len() + END.len()
    }

    /// Always `false`: there are a hello and an end.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// What is sent from a place on, at least to the end of a line; nothing behind the last.
    #[inline]
    #[must_use]
    pub fn part_at(&self, place: usize) -> &[u8] {
        let (body, end) = (self.head.len(), self.head.len() + self.body.len());
        match place {
            place if place < body => &self.head.as_bytes()[place..],
            place if place < end => self.body.at(place - body),
            place => END.get(place - end..).unwrap_or_default(),
        }
    }

    /// All that is sent, at once: of a session in which much is repeated, far more than it has in memory.
    #[must_use]
    pub fn text(&self) -> Vec<u8> {
        let mut text = Vec::with_capacity(self.len());
        while text.len() < self.len() {
            text.extend_from_slice(self.part_at(text.len()));
        }
        text
    }

    /// The lines that are sent, without their newlines.
    pub fn lines(&self) -> impl Iterator<Item = &[u8]> {
        let head = self.head.lines().map(str::as_bytes);
        head.chain(self.body.lines()).chain(std::iter::once(END.trim_ascii_end()))
    }

    /// The session as a suite file, which [`Session::parse`] reads back.
    #[must_use]
    pub fn to_suite(&self) -> Vec<u8> {
        let mut suite = Vec::new();
        self.write_suite(&mut suite).expect("memory can be written");
        suite
    }

    /// Writes the session as a suite file, part by part.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write_suite(&self, out: &mut dyn Write) -> io::Result<()> {
        let requirement = self.requirement.as_deref().unwrap_or_default();
        let level = self.level.map_or("", Level::name);
        let about = [requirement, level, &self.idea].into_iter().filter(|word| !word.is_empty());
        match about.collect::<Vec<_>>().join(" ").as_str() {
            "" => {}
            about => writeln!(out, "{ABOUT} {about}")?,
        }
        self.write_text(out)
    }

    /// Writes all that is sent, part by part.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write_text(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut place = 0;
        while place < self.len() {
            let part = self.part_at(place);
            out.write_all(part)?;
            place += part.len();
        }
        Ok(())
    }

    /// The hello, which names the kind and the version.
    #[must_use]
    pub fn hello(&self) -> &str {
        &self.head[self.hello.clone()]
    }

    /// The configuration, without the word `config`.
    #[must_use]
    pub fn config(&self) -> &str {
        &self.head[self.config.clone()]
    }

    /// Where in the text the lines begin that follow the configuration.
    #[must_use]
    pub fn body_start(&self) -> usize {
        self.head.len()
    }

    /// The requests between the configuration and the end, without comments.
    pub fn requests(&self) -> impl Iterator<Item = &[u8]> {
        self.body.lines().filter(|line| is_asked(line))
    }

    /// Checks each request by itself.
    ///
    /// # Errors
    /// The first request that `check` refuses, and why.
    pub(crate) fn check_requests(
        &self,
        mut check: impl FnMut(&[u8]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for (request, number) in self.requests().zip(1..) {
            check(request).map_err(|wrong| wrong.in_request(number, request))?;
        }
        Ok(())
    }

    /// The request at or after place `at` of the text, and the place behind it; the last one is `end`.
    #[inline]
    #[must_use]
    pub fn request_at(&self, at: usize) -> Option<(&[u8], usize)> {
        let mut at = at;
        loop {
            let part = self.part_at(at);
            if part.is_empty() {
                return None;
            }
            let end = memchr(b'\n', part).unwrap_or(part.len());
            at += (end + 1).min(part.len());
            if is_asked(&part[..end]) {
                return Some((&part[..end], at));
            }
        }
    }

    /// The same session with other requests.
    #[must_use]
    pub fn with_requests<'a>(&self, requests: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut body = Script::with_capacity(self.body.len().min(MOST_AT_ONCE));
        body.push_with(1, |text| {
            for request in requests {
                text.extend_from_slice(request);
                text.push(b'\n');
            }
        });
        self.with(self.config(), body)
    }

    /// The same session with another request at a place, from 0 on.
    #[must_use]
    pub fn with_request(&self, place: usize, request: &[u8]) -> Self {
        let mut number = 0..;
        self.edited(b"", |line| Some(if number.next() == Some(place) { request } else { line }))
    }

    /// The same session with those of its requests whose places are in `kept`.
    #[must_use]
    pub fn with_those(&self, kept: impl Fn(usize) -> bool) -> Self {
        let mut number = 0..;
        self.edited(b"", |line| number.next().is_some_and(&kept).then_some(line))
    }

    /// The same session with other lines first, and then what `edit` makes of each of its requests. What is repeated
    /// stays so, as far as the same is made of it.
    pub(crate) fn edited<'a>(
        &'a self,
        first: &[u8],
        mut edit: impl FnMut(&'a [u8]) -> Option<&'a [u8]>,
    ) -> Self {
        let mut body = Script::with_capacity(first.len());
        body.push(first, 1);
        body.push_edited(&self.body, |line| if is_asked(line) { edit(line) } else { None });
        self.with(self.config(), body)
    }

    /// The same session with another configuration.
    #[must_use]
    pub fn with_config(&self, config: &str) -> Self {
        self.with(config, self.body.clone())
    }

    fn with(&self, config: &str, body: Script) -> Self {
        let (requirement, level, idea) = (self.requirement.clone(), self.level, self.idea.clone());
        let made = Self::made(&self.name, self.hello(), config, body);
        Self { requirement, level, idea, patience: self.patience.max(made.patience), ..made }
    }
}

/// Room that is taken at once for requests whose number is not known.
const MOST_AT_ONCE: usize = 1 << 20;

/// Whether a line has an answer: comments and empty lines have none.
fn is_asked(line: &[u8]) -> bool {
    !line.is_empty() && line[0] != b'#'
}

/// `config` with some of its values replaced.
fn changed(config: &str, changes: &str) -> String {
    let key = |word: &str| word.split('=').next().map(str::to_owned);
    let words = config
        .split_ascii_whitespace()
        .map(|word| changes.split_ascii_whitespace().find(|change| key(change) == key(word)).unwrap_or(word));
    words.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUITE: &str = "#: VM-3 state Upper bits\n#: are added.\n#: also policy=fifo ways=2\nsaarcor-vm 1\n\
                         config ways=4 policy=lru\nr 0 1\n# why\nflush\nend\n";

    #[test]
    fn suites_give_their_sessions() {
        let sessions = Session::parse("vm/x", SUITE).expect("a suite");
        let names: Vec<_> = sessions.iter().map(|session| session.name.as_str()).collect();
        assert_eq!(names, ["vm/x", "vm/x@policy=fifo,ways=2"]);
        assert_eq!(
            (sessions[0].requirement.as_deref(), sessions[0].level),
            (Some("VM-3"), Some(Level::State))
        );
        assert_eq!(sessions[0].idea, "Upper bits are added.");
        assert_eq!((sessions[0].hello(), sessions[1].config()), ("saarcor-vm 1", "ways=2 policy=fifo"));
        assert_eq!(sessions[0].requests().collect::<Vec<_>>(), [&b"r 0 1"[..], b"flush"]);
    }

    #[test]
    fn sessions_read_back() {
        let sessions = Session::parse("vm/x", SUITE).expect("a suite");
        let text = String::from_utf8(sessions[1].to_suite()).expect("text");
        assert_eq!(Session::parse(&sessions[1].name, &text).ok(), Some(vec![sessions[1].clone()]));
    }

    #[test]
    fn wrong_suite_files_are_refused() {
        for (text, line, says) in [
            ("", 0, "hello"),
            ("# only\n", 1, "hello"),
            ("saarcor-vm 1\nr 0 1\n", 2, "config"),
            ("saarcor-vm 1\nconfig \nr 0 1\nend\n", 2, "config"),
            ("saarcor-vm 1\nconfig a=1\nr 0 1\n", 3, "end"),
            ("saarcor-vm 1\nconfig a=1\nend\nr 0 1\n", 4, "nothing follows"),
        ] {
            let error = Session::parse("x", text).expect_err("none").to_string();
            assert!(error.starts_with(&format!("line {line}: ")) && error.contains(says), "{text}: {error}");
        }
    }

    #[test]
    fn parts_can_be_replaced() {
        let session = Session::new("x", "saarcor-vm 1", "a=1", b"flush\n");
        let other = session.with_config("b=2").with_requests([&b"r 0 1"[..], b"r 1 1"]);
        assert_eq!(other.text(), b"saarcor-vm 1\nconfig b=2\nr 0 1\nr 1 1\nend\n");
        assert_eq!(other.lines().last(), Some(&b"end"[..]));
        assert_eq!(other.request_at(other.body_start()), Some((&b"r 0 1"[..], other.body_start() + 6)));
    }
}
