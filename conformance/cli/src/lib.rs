//! The SaarCOR suite for a person: the command line `saarcor` and what it is made of.
//!
//! Only this crate reads files, prints and measures time.
//!
//! | module | subject |
//! |---|---|
//! | [`cli`] | the verbs, exit statuses, and how errors are shown |
//! | [`args`] | what arguments mean: sizes, ranges of frames, configurations |
//! | [`limits`] | how much memory a simulation may take |
//! | [`standard`] | the standard configuration |
//! | [`output`] | standard output and output files, whole or not at all |
//! | [`progress`] | what is said on standard error |
//! | [`world`] | a scene made ready for the chip |
//! | [`render`] | pictures |
//! | [`walk`] | step one of §4: the traffic of a walk through a scene |
//! | [`simulate`] | step two of §4: a frame on the chip, cycle by cycle |
//! | [`sampling`] | both steps from a part of the packets, with intervals |
//! | [`sweep`] | one frame on many chips |
//! | [`curve`] | the costs of a sweep as curves |
//! | [`crosscheck`] | the model, the exact judge and Embree, ray by ray |
//! | [`embree`] | runs Embree |
//! | [`accuracy`] | triangle tests and number formats: speed against error |
//! | [`conform`] | what a conformance run found, for a person |
//! | [`metadata`] | the metadata law beside the paper's examples |
//! | [`summary`] | what a scene needs, and the bytes of its image |
//! | [`reproduce`] | the paper's figures, ours beside theirs |
//! | [`plot`] | how graphs look |
//! | [`table`] | tables as text and as HTML |

pub mod accuracy;
pub mod args;
pub mod cli;
pub mod conform;
pub mod crosscheck;
pub mod curve;
pub mod embree;
pub mod kept_worlds;
pub mod limits;
pub mod metadata;
mod names;
pub mod output;
pub mod plot;
pub mod progress;
pub mod prove;
pub mod render;
pub mod reproduce;
pub mod sampling;
pub mod simulate;
pub mod standard;
pub mod summary;
pub mod sweep;
pub mod table;
mod verbs;
pub mod walk;
pub mod world;
