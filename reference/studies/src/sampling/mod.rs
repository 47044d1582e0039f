//! Sampled simulation: walks and runs of the chip that work on a part of a picture's packets in
//! full, and say how far off their results may be.
//!
//! After SMARTS (Wunderlich, Wenisch, Falsafi, Hoe 2003): what is measured is a small sample, and
//! between its parts the caches are kept warm. SMARTS warms them with all that the program reads;
//! tracing all rays would take most of the time saved here. So the packets between the parts are
//! those of a smaller picture, with a sixteenth of the rays. What that leaves wrong is bounded by what
//! can be counted, and part of the intervals ([`estimate`], [`neighbours`]).
//!
//! | module | subject |
//! |---|---|
//! | [`plan`] | which packets are worked on in full |
//! | [`trace`] | packets in full and packets of few rays |
//! | [`estimate`] | totals and intervals |
//! | [`neighbours`] | what is not known of first-level caches |
//! | [`row`] | what is printed |
//! | [`simulate`] | a frame on the chip |
//! | [`walk`] | the frames of a walk |
//! | [`accuracy`] | speed against error of both |

pub mod accuracy;
pub mod estimate;
pub mod neighbours;
pub mod plan;
pub mod row;
pub mod simulate;
pub mod trace;
pub mod walk;
