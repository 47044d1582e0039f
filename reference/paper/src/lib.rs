//! Schmittler, Leidinger, Slusallek, "A Virtual Memory Architecture for Real-Time Ray Tracing Hardware"
//! (2003): its tables as data, and their reproduction, ours beside theirs.
//!
//! ```
//! use saarcor_paper::tables::{table1, table2};
//!
//! let cruiser = table1().iter().find(|row| row.scene == "Cruiser").expect("a scene of Table 1");
//! assert_eq!(cruiser.triangles, 3_637_101);
//! // On the card, version B moves a third more than version A: its metadata.
//! let row = table2().iter().find(|row| row.scene == "Conference").expect("a hot spot");
//! assert!((1.31..1.35).contains(&(row.version_b.mem_mb / row.version_a.mem_mb)));
//! ```
//!
//! | module | subject |
//! |---|---|
//! | [`tables`] | the paper's tables and stated results, as printed |
//! | [`metadata`] | the examples of the metadata law (§3), computed |
//! | [`table1`] | the scenes, ours beside the paper's |
//! | [`figure3`] | working set and transfers, frame by frame |
//! | [`table2`] | hot spots on the chip, ours beside the paper's |
//! | [`fit`] | how far the relations of Table 2 lie from the paper's |
//! | [`sensitivity`] | how far each Assumed number moves these relations |
//! | [`alternatives`] | chips that differ in one respect: what a figure hangs on |
//! | [`claims`] | the paper's claims, whether they hold here, and why |
//! | [`reproduction`] | all of it in one run |

pub mod alternatives;
pub mod claims;
mod error;
pub mod figure3;
pub mod fit;
pub mod metadata;
pub mod reproduction;
mod sections;
pub mod sensitivity;
pub mod table1;
pub mod table2;
pub mod tables;

pub use error::ReproductionError;
pub use reproduction::Reproduction;
pub use tables::{MB, mb};
