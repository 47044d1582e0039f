//! Speed against error of the triangle tests, in each number format, on cases that are hard.
//!
//! A *suite* is a generator of cases, one idea each; a case is a ray and the triangles that it is
//! tested against; a *contestant* is a kernel in a format. The exact judge says of each case what
//! is true of the very same f32 inputs, and each contestant is held to it and timed on it.

pub mod case;
pub mod contest;
pub mod exactly_one;
pub mod front;
pub mod measure;
pub mod replay;
pub mod scene;
pub mod suites;
