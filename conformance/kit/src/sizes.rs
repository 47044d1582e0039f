//! Sessions about the sizes that people build: large memories, every set and way, long ranges, counters that overflow.
//!
//! They are long. So a plan keeps how each is made, and makes it when it is held.

use crate::kind::Kind;
use crate::level::Level;
use crate::session::{Requests, Session};
use std::fmt;
use std::sync::Arc;

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// The first seed.
    pub seed: u64,
    /// Requests of all random sessions together.
    pub requests: usize,
}

impl Extent {
    /// Requests of a session in which counters are to overflow: of 20 bits where nothing is said, and of as many as
    /// there are requests.
    #[must_use]
    pub fn long(&self) -> usize {
        self.requests / 40 * 23
    }
}

/// Most requests that are drawn for a session in which counters are to overflow: then they are repeated. No power of two,
/// so that counters are at another place each time.
const PERIOD: usize = 300_007;

/// About so many requests, repeated where they are many, of which `requests` makes as many as it is given.
pub(crate) fn repeated(count: usize, requests: impl FnOnce(usize) -> Vec<u8>) -> Requests {
    let times = count.div_ceil(PERIOD).max(1);
    Requests { first: Vec::new(), again: requests(count.div_ceil(times)), times }
}

/// A session that is made when it is held.
#[derive(Clone)]
pub struct SizedSession {
    /// Its name, such as `vm/sizes/ranges`.
    pub name: String,
    /// The requirement that it is about; empty where it is about all.
    pub requirement: &'static str,
    /// Its idea in a sentence.
    pub idea: &'static str,
    /// It takes much memory: no two such are held at a time.
    pub is_large: bool,
    make: Arc<dyn Fn(&str) -> Session + Send + Sync>,
}

impl fmt::Debug for SizedSession {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SizedSession").field("name", &self.name).finish_non_exhaustive()
    }
}

/// What a session is about: the requirement, and the level up to which it is judged; all where it has none.
pub type About = (&'static str, Option<Level>, &'static str);

impl SizedSession {
    /// A session of a kind, `about` a requirement where there is one, whose requests `requests` makes for `config`.
    #[must_use]
    pub fn new<K: Kind + Copy + Send + 'static, R: Into<Requests>>(
        kind: K,
        name: &str,
        (requirement, level, idea): About,
        config: &str,
        requests: impl Fn(&str) -> R + Send + Sync + 'static,
    ) -> Self {
        let (name, config) = (format!("{}/{name}", kind.prefix()), config.to_owned());
        let make = move |name: &str| {
            let mut session = Session::repeating(name, kind.hello(), &config, &requests(&config).into());
            session.requirement = (!requirement.is_empty()).then(|| requirement.to_owned());
            (session.level, session.idea) = (level, idea.to_owned());
            session
        };
        Self { name, requirement, idea, is_large: false, make: Arc::new(make) }
    }

    /// The same, held alone.
    #[must_use]
    pub fn large(self) -> Self {
        Self { is_large: true, ..self }
    }

    /// The session.
    #[must_use]
    pub fn session(&self) -> Session {
        (self.make)(&self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::KINDS;
    use std::collections::BTreeSet;

    #[test]
    fn sessions_about_sizes_are_legal_and_have_names_of_their_own() {
        for kind in KINDS {
            let mut names = BTreeSet::new();
            for (seed, requests) in [(0, 10_000), (3, 100_000)] {
                for sized in kind.sizes(&Extent { seed, requests }) {
                    kind.check(&sized.session()).expect(&sized.name);
                    assert!(names.insert((seed, sized.name.clone())), "{}", sized.name);
                }
            }
        }
    }
}
