//! The texts of the requirements, as SPEC.md and PROTOCOL.md have them, and the sessions that are about each.

use crate::error::Error;
use crate::kinds::KINDS;
use crate::plan::RANDOM_REQUESTS;
use crate::session::Session;
use crate::sizes::Extent;
use std::collections::{BTreeMap, BTreeSet};

/// Requirements that no session is about, and why.
const WITHOUT_SESSION: [(&[&str], &str); 8] = [
    (&["P-2", "P-5", "P-7", "P-8"], "every session shows it"),
    (&["P-9"], "every session of a process that offers several shows it"),
    (
        &["VM-2"],
        "the granules that saarcor-meta asks for lie where metadata of this size does: sessions of VM-12 and VM-13",
    ),
    (&["L1-2"], "no kind answers with bytes from behind a first-level cache"),
    (
        &["FE-1", "HI-2", "HI-4", "HI-5", "HI-6", "SH-5"],
        "the driver's part: the kit is the driver, and writes memory as it has to be",
    ),
    (
        &["RG-1", "RG-3", "RG-4", "RG-5", "RG-6", "SH-1", "SH-2", "SH-3", "SH-4", "SH-6"],
        "no kind generates rays or shades them; its reads in time are operations of CH-1",
    ),
    (
        &["IS-4", "IS-5"],
        "an implementation may compute as it likes: what it rounds wrongly shows in its answers, in sessions of IS-1 and IS-3",
    ),
    (&["CH-18"], "no answer has the cycles of a unit"),
];

/// A requirement, and the sessions that are about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Covered {
    /// Such as `VM-6`.
    pub id: &'static str,
    /// The sessions, by their names; of a suite file its name alone.
    pub sessions: BTreeSet<String>,
    /// Why there is none.
    pub reason: Option<&'static str>,
}

/// All requirements, in the order of SPEC.md and PROTOCOL.md.
///
/// # Errors
/// If a suite cannot be read.
pub fn coverage() -> Result<Vec<Covered>, Error> {
    let mut sessions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut is_about = |requirement: &str, session: &str| {
        sessions.entry(requirement.to_owned()).or_default().insert(session.to_owned());
    };
    for kind in KINDS {
        for (name, text) in kind.suites() {
            for session in Session::parse(name, text)? {
                session.requirement.iter().for_each(|requirement| is_about(requirement, name));
            }
        }
        for sized in kind.sizes(&Extent { seed: 0, requests: RANDOM_REQUESTS }) {
            is_about(sized.requirement, &sized.name);
        }
    }
    let reason =
        |id: &str| WITHOUT_SESSION.iter().find(|(ids, _)| ids.contains(&id)).map(|(_, reason)| *reason);
    let of = |id: &'static str| Covered {
        id,
        sessions: sessions.remove(id).unwrap_or_default(),
        reason: reason(id),
    };
    Ok(ids().into_iter().map(of).collect())
}

/// The ids of all requirements, in the order of SPEC.md and PROTOCOL.md.
fn ids() -> Vec<&'static str> {
    let mut ids = Vec::new();
    for (id, _) in rows() {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    ids
}

/// What the requirement of an id such as `VM-6` demands; none where there is no such requirement.
#[must_use]
pub fn text(id: &str) -> Option<&'static str> {
    rows().find(|row| row.0 == id).map(|row| row.1)
}

/// The documents that have a row for each requirement.
const DOCUMENTS: [&str; 2] = [include_str!("../../../model/SPEC.md"), include_str!("../../PROTOCOL.md")];

/// The rows of all tables that begin with the id of a requirement: the id, and the text beside it.
fn rows() -> impl Iterator<Item = (&'static str, &'static str)> {
    let row = |line: &'static str| {
        let (id, rest) = line.strip_prefix("| ")?.split_once(" | ")?;
        let text = rest.split(" | ").next()?.trim_end_matches(['|', ' ']);
        is_id(id).then_some((id, text))
    };
    DOCUMENTS.iter().flat_map(|document| document.lines()).filter_map(row)
}

/// Whether this is the id of a requirement, such as `VM-6`: a capital, perhaps one character more, and a number.
fn is_id(id: &str) -> bool {
    let (unit, number) = id.split_once('-').unwrap_or_default();
    unit.starts_with(|letter: char| letter.is_ascii_uppercase())
        && unit.len() <= 2
        && !number.is_empty()
        && number.bytes().all(|digit| digit.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requirements_have_texts() {
        assert_eq!(text("P-3"), Some("A comment MUST have no answer."));
        assert!(text("VM-7").is_some_and(|text| text.ends_with("the free way of the lowest number.")));
        assert_eq!((text("VM-99"), text("random"), text("")), (None, None, None));
    }

    #[test]
    fn each_requirement_has_a_session_or_a_reason_why_not() {
        let coverage = coverage().expect("the suites");
        let ids: BTreeSet<_> = coverage.iter().map(|covered| covered.id).collect();
        assert!(
            ["VM-1", "CH-20", "PC-1", "L1-2", "FE-1", "P-9"].iter().all(|id| ids.contains(id)),
            "{ids:?}"
        );
        for Covered { id, sessions, reason } in &coverage {
            assert!(sessions.is_empty() == reason.is_some(), "{id}: {sessions:?}, {reason:?}");
        }
        for id in WITHOUT_SESSION.iter().flat_map(|(ids, _)| *ids) {
            assert!(ids.contains(id), "there is no {id}");
        }
    }
}
