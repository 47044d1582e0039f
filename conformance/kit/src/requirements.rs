//! The texts of the requirements, as SPEC.md and PROTOCOL.md have them.

/// The documents that have a row for each requirement.
const DOCUMENTS: [&str; 2] = [include_str!("../../../model/SPEC.md"), include_str!("../../PROTOCOL.md")];

/// What the requirement of an id such as `VM-6` demands; none where there is no such requirement.
#[must_use]
pub fn text(id: &str) -> Option<&'static str> {
    let row = |line: &'static str| {
        line.strip_prefix("| ")?.strip_prefix(id)?.strip_prefix(" | ")?.split(" | ").next()
    };
    let found = DOCUMENTS.iter().flat_map(|document| document.lines()).find_map(row);
    found.map(|text| text.trim_end_matches(['|', ' ']))
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
}
