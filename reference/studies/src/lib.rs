//! What is measured of the SaarCOR model: options in, rows of data out.
//!
//! Nothing here prints, parses a command line or draws. A study that takes long reports its stages to a
//! [`Monitor`](monitor::Monitor).
//!
//! | module | subject |
//! |---|---|
//! | [`world`] | a scene made ready for the chip |
//! | [`summary`] | what a scene needs, and the bytes of its image |
//! | [`picture`] | a frame through any memory |
//! | [`walk`] | step one of §4: the traffic of a walk through a scene |
//! | [`simulate`] | step two of §4: a frame on the chip, cycle by cycle |
//! | [`sampling`] | both steps from a part of the packets, with intervals |
//! | [`sweep`] | one frame on many chips |
//! | [`metadata`] | the metadata law of §3 |
//! | [`accuracy`] | triangle tests and number formats: speed against error |
//! | [`crosscheck`] | the model, the exact judge and Embree, ray by ray |
//! | [`standard`] | the standard configuration |
//! | [`names`] | what kernels, versions and buses are called |
//! | [`monitor`] | how a study reports its stages |
//! | [`error`] | what can go wrong |

pub mod accuracy;
pub mod crosscheck;
pub mod error;
pub mod metadata;
pub mod monitor;
pub mod names;
pub mod picture;
pub mod sampling;
pub mod simulate;
pub mod standard;
pub mod summary;
pub mod sweep;
pub mod trace;
pub mod walk;
pub mod world;

pub use error::StudyError;
