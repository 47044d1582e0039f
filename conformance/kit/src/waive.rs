//! Failures that are known, and do not count: each with its reason.

use crate::error::Error;
use crate::report::{Outcome, SessionOutcome};
use serde::Deserialize;
use std::fmt;

/// A failure that is known.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Waiver {
    /// The session that fails; none for each.
    pub session: Option<String>,
    /// The requirement that is broken; none for each.
    pub requirement: Option<String>,
    /// Why it does not count.
    pub reason: String,
}

impl fmt::Display for Waiver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let session = self.session.as_ref().map(|session| format!("session {session}"));
        let requirement = self.requirement.as_ref().map(|requirement| format!("requirement {requirement}"));
        let parts: Vec<_> = session.into_iter().chain(requirement).collect();
        f.write_str(&parts.join(", "))
    }
}

/// The failures of a file that are known.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Waivers {
    /// The file's entries, `[[waive]]` each.
    #[serde(default)]
    pub waive: Vec<Waiver>,
}

impl Waivers {
    /// The entries of a file.
    ///
    /// # Errors
    /// What is wrong, in which line or entry, and what would be right.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let file: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            Error::Line { line, right: error.message().to_owned() }
        })?;
        for (waiver, number) in file.waive.iter().zip(1..) {
            if waiver.session.is_none() && waiver.requirement.is_none() {
                return Err(format!("entry {number}: name a session, a requirement, or both").into());
            }
            if waiver.reason.trim().is_empty() {
                return Err(format!("entry {number}: the reason is empty").into());
            }
        }
        Ok(file)
    }

    /// The entries, with their numbers from 1 on, by which none of these sessions is waived.
    pub fn unused<'a>(&'a self, outcomes: &[SessionOutcome]) -> impl Iterator<Item = (usize, &'a Waiver)> {
        let waived = outcomes.iter().filter(|outcome| outcome.outcome == Outcome::Waived);
        let used = waived
            .filter_map(|outcome| self.find(&outcome.session, outcome.requirement.as_deref()?))
            .cloned()
            .collect::<Vec<_>>();
        (1..).zip(&self.waive).filter(move |(_, waiver)| !used.contains(waiver))
    }

    /// The first entry that is about the failure of a session for a requirement.
    #[must_use]
    pub fn find(&self, session: &str, requirement: &str) -> Option<&Waiver> {
        let is = |asked: &Option<String>, name: &str| asked.as_ref().is_none_or(|asked| asked == name);
        self.waive.iter().find(|waiver| is(&waiver.session, session) && is(&waiver.requirement, requirement))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_need_a_place_and_a_reason() {
        let text = "[[waive]]\nsession = 'vm/flush'\nreason = 'known'\n[[waive]]\nrequirement = 'VM-6'\nreason = 'old'\n";
        let waivers = Waivers::parse(text).expect("right");
        let reason = |session, requirement| waivers.find(session, requirement).map(|waiver| &*waiver.reason);
        assert_eq!(
            (reason("vm/flush", "VM-8"), reason("x", "VM-6"), reason("x", "VM-8")),
            (Some("known"), Some("old"), None)
        );
        for (text, says) in [
            ("[[waive]]\nreason = 'x'\n", "entry 1: name a session"),
            ("[[waive]]\nsession = 'x'\nreason = ' '\n", "entry 1: the reason"),
            ("[[waive]]\nsession = 'x'\n", "line 1"),
            ("[[waive]]\nsesion = 'x'\nreason = 'x'\n", "line 2"),
        ] {
            let error = Waivers::parse(text).expect_err("wrong").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
