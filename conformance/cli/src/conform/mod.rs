//! What a conformance run found, for a person: as text and as a page.

pub mod hard;
pub mod page;
#[cfg(unix)]
pub mod proof;
pub mod reports;
pub mod text;
