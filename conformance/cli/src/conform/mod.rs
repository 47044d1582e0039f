//! What a conformance run found, for a person: as text and as a page.

pub mod hard;
pub mod page;
pub mod text;
