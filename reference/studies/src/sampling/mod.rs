//! Whole walks in time from a few of their frames: which frames run on the chip, and what the others take, with intervals.
//!
//! After MEGsim (Ortiz, Corbalán-Navarro, Aragón, González 2022): what is cheap to count tells frames apart, and few of them
//! are simulated. There the counts are those of a functional run of each frame, and the frames chosen stand for those like them.
//! Here tracing the rays costs three times as much as the chip, so the counts are those of small pictures
//! ([`counts`]); and the frames are drawn at random, one of each stretch of the walk ([`choice`]), so that the error can be
//! estimated too ([`prediction`]).
//!
//! | module | subject |
//! |---|---|
//! | [`fraction`] | the part that is drawn |
//! | [`counts`] | what is cheap to count of every frame |
//! | [`choice`] | which frames run on the chip |
//! | [`estimate`] | an estimate and its interval |
//! | [`prediction`] | what the other frames take |
//! | [`walk`] | a walk in time, estimated |
//! | [`accuracy`] | speed against error |

pub mod accuracy;
pub mod choice;
pub mod counts;
pub mod estimate;
pub mod fraction;
pub mod prediction;
pub mod walk;
