//! Which sessions are run: suites, recorded frames, and random sessions.

use crate::error::Error;
use crate::kind::Kind;
use crate::kinds::{KINDS, kind_of_hello};
use crate::level::Level;
use crate::session::Session;
use crate::sizes::{Extent, SizedSession};
use crate::waive::Waivers;
use std::path::Path;

/// Requests of all random sessions together (Assumed), where nothing is said.
pub const RANDOM_REQUESTS: usize = 2_000_000;
/// Requests of all random sessions together with which counters of 24 bits overflow.
pub const LONG_REQUESTS: usize = 32_000_000;
/// Sessions that fail before a run is stopped (Assumed), where nothing is said.
pub const ERRORS: usize = 20;
/// Least random sessions of the quick suite.
pub(crate) const QUICK_SESSIONS: usize = 24;
/// Most requests of a random session: enough to amortise its start and to overflow counters of 16 bits, and
/// few enough that many sessions fit into memory. Longer ones are those of [`Kind::sizes`].
const SESSION_REQUESTS: usize = 100_000;

/// What is run, and how far it is judged.
#[derive(Clone, Debug)]
pub struct Options {
    /// The highest level that is judged, and that has to be passed; none: all that is observed.
    pub level: Option<Level>,
    /// Sessions that fail before the run is stopped.
    pub errors: usize,
    /// First seed of the random sessions.
    pub seed: u64,
    /// Requests of all random sessions together.
    pub requests: usize,
    /// By how many thousandths a timing may be off.
    pub tolerance: u32,
    /// Failures that do not count.
    pub waivers: Waivers,
    /// Without the sessions about the sizes that people build.
    pub quick: bool,
    /// Whether a session that fails is shrunk to few requests.
    pub shrink: bool,
}

impl Options {
    /// How much is run.
    pub(crate) fn extent(&self) -> Extent {
        Extent { seed: self.seed, requests: self.requests }
    }

    /// The highest level that is judged.
    pub(crate) fn highest(&self) -> Level {
        self.level.unwrap_or(Level::HIGHEST)
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            level: None,
            errors: ERRORS,
            seed: 0,
            requests: RANDOM_REQUESTS,
            tolerance: 0,
            quick: false,
            shrink: true,
            waivers: Waivers::default(),
        }
    }
}

/// Rows of the report for sessions that are about no requirement.
const RANDOM: &str = "random";
const GIVEN: &str = "frames, files";
const SIZES: &str = "sizes";

/// A session to be run.
#[derive(Clone, Debug)]
pub enum PlannedSession {
    /// This one.
    Directed(Box<Session>),
    /// One about sizes.
    Sized(SizedSession),
    /// The random one of a seed.
    Random {
        /// The seed.
        seed: u64,
        /// Its requests.
        requests: usize,
    },
}

/// A recorded frame has at most this part of the requests of the random sessions: it takes no more of the time
/// than a few of them.
const FRAME_PART: usize = 20;

/// The default plan of a kind: the directed sessions, recorded frames, those about sizes, and random sessions. The
/// quick one has no sessions about sizes, and fewer random ones.
///
/// # Errors
/// Where a suite of the kit is no session: a fault of the kit.
pub fn default_suite(kind: &dyn Kind, options: &Options) -> Result<Vec<PlannedSession>, Error> {
    let mut planned = Vec::new();
    for (name, text) in kind.suites() {
        let sessions = Session::parse(name, text).map_err(|wrong| wrong.within(format!("suite {name}")))?;
        planned.extend(sessions.into_iter().map(|session| PlannedSession::Directed(Box::new(session))));
    }
    let recorded = kind.recorded(options.requests.div_ceil(FRAME_PART));
    planned.extend(recorded.into_iter().map(|session| PlannedSession::Directed(Box::new(session))));
    if !options.quick {
        planned.extend(kind.sizes(&options.extent()).into_iter().map(PlannedSession::Sized));
    }
    let least = if options.quick { QUICK_SESSIONS } else { kind.configurations() };
    planned.extend(random_sessions(options.seed, options.requests, least));
    Ok(planned)
}

/// At least so many random sessions from a seed on, of so many requests together.
pub fn random_sessions(seed: u64, requests: usize, least: usize) -> impl Iterator<Item = PlannedSession> {
    let sessions = if requests == 0 { 0 } else { requests.div_ceil(SESSION_REQUESTS).max(least) };
    (0..sessions as u64).map(move |number| PlannedSession::Random {
        seed: seed.wrapping_add(number),
        requests: requests.div_ceil(sessions),
    })
}

/// Sessions that a name stands for: a suite of the kit or one of its sessions, a random session
/// (`vm/random/17`), one about sizes of a plan of that extent, or the path of a suite file.
///
/// # Errors
/// Where there is no such suite or file, or it is no session.
pub fn sessions_named(name: &str, extent: &Extent) -> Result<(&'static dyn Kind, Vec<Session>), Error> {
    for kind in KINDS {
        if let Some(rest) = name.strip_prefix(&format!("{}/", kind.prefix())) {
            if let Some(seed) = rest.strip_prefix("random/").and_then(|seed| seed.parse().ok()) {
                return Ok((*kind, vec![kind.random(seed, extent.requests)]));
            }
            for (suite, text) in kind.suites() {
                let sessions =
                    Session::parse(suite, text).map_err(|wrong| wrong.within(format!("suite {suite}")))?;
                if *suite == name {
                    return Ok((*kind, sessions));
                }
                if let Some(session) = sessions.into_iter().find(|session| session.name == name) {
                    return Ok((*kind, vec![session]));
                }
            }
            if let Some(sized) = kind.sizes(extent).into_iter().find(|sized| sized.name == name) {
                return Ok((*kind, vec![sized.session()]));
            }
            let of_frame =
                |session: &Session| session.name == name || session.name.starts_with(&format!("{name}@"));
            let recorded: Vec<_> = kind.recorded(usize::MAX).into_iter().filter(of_frame).collect();
            if !recorded.is_empty() {
                return Ok((*kind, recorded));
            }
        }
    }
    sessions_of_file(Path::new(name))
}

/// The sessions of a suite file, whose path may be no text.
///
/// # Errors
/// Where it cannot be read, or is no session.
pub fn sessions_of_file(path: &Path) -> Result<(&'static dyn Kind, Vec<Session>), Error> {
    let name = &*path.to_string_lossy();
    let text = std::fs::read(path).map_err(Error::system(format!(
        "{name}: neither a suite ('saarcor conform list' shows all) nor a file that can be read"
    )))?;
    let text = String::from_utf8(text).map_err(|_| Error::from("no text").within(name))?;
    let sessions = Session::parse(name, &text).map_err(|wrong| wrong.within(name))?;
    let hello = sessions.first().map_or("", Session::hello);
    let kind = kind_of_hello(hello.as_bytes()).ok_or_else(|| {
        let known: Vec<_> = KINDS.iter().map(|kind| kind.hello()).collect();
        Error::from(format!("the hello '{hello}' is none of {}", known.join(", "))).within(name)
    })?;
    for session in &sessions {
        kind.check(session).map_err(|wrong| wrong.within(name))?;
    }
    Ok((kind, sessions))
}

impl PlannedSession {
    /// The session's name.
    #[must_use]
    pub fn name(&self, kind: &dyn Kind) -> String {
        match self {
            Self::Directed(session) => session.name.clone(),
            Self::Sized(sized) => sized.name.clone(),
            Self::Random { seed, .. } => kind.random_name(*seed),
        }
    }

    /// What 'saarcor conform run' is asked for to hold it again, as it was in a plan of that extent; none where that is
    /// its name alone, or a file's.
    pub(crate) fn again(&self, kind: &dyn Kind, extent: &Extent) -> Option<String> {
        let Extent { seed, requests } = extent;
        match self {
            Self::Directed(_) => None,
            Self::Sized(sized) => Some(format!("--suite {} --seed {seed} --requests {requests}", sized.name)),
            Self::Random { seed, requests } => {
                Some(format!("--suite {} --requests {requests}", kind.random_name(*seed)))
            }
        }
    }

    /// The row of the report that counts it: its requirement, `random`, `sizes`, or `frames, files`.
    #[must_use]
    pub fn row(&self) -> &str {
        match self {
            Self::Directed(session) => session.requirement.as_deref().unwrap_or(GIVEN),
            Self::Sized(sized) if sized.requirement.is_empty() => SIZES,
            Self::Sized(sized) => sized.requirement,
            Self::Random { .. } => RANDOM,
        }
    }

    /// The session, which is made where it is random.
    pub(crate) fn session(&self, kind: &dyn Kind, options: &Options) -> Session {
        let session = match self {
            Self::Directed(session) => (**session).clone(),
            Self::Sized(sized) => sized.session(),
            Self::Random { seed, requests } => kind.random(*seed, *requests),
        };
        if options.tolerance == 0 { session } else { kind.with_tolerance(session, options.tolerance) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a report names of a session that fails holds the same session again.
    #[test]
    fn sessions_are_held_again_by_what_is_named() {
        let options = Options { seed: 3, requests: 4000, ..Options::default() };
        for kind in KINDS {
            let mut seen = 0;
            for planned in default_suite(*kind, &options).expect("suites") {
                let Some(again) = planned.again(*kind, &options.extent()) else { continue };
                let words: Vec<_> = again.split(' ').collect();
                let value =
                    |key: &str| words.iter().position(|word| *word == key).map(|place| words[place + 1]);
                let number = |key: &str| value(key).map(|number| number.parse().expect("a number"));
                let extent = Extent {
                    seed: number("--seed").unwrap_or_default() as u64,
                    requests: number("--requests").expect("requests"),
                };
                // One in so many: each is looked for by its name among all.
                seen += 1;
                if seen % 7 == 0 {
                    let name = value("--suite").expect("a name");
                    let (_, found) = sessions_named(name, &extent).expect(name);
                    assert!(found == [planned.session(*kind, &options)], "{again}");
                }
            }
            assert!(seen > 40, "{}", kind.name());
        }
    }
}
