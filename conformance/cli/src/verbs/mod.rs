//! The verbs of the command line: arguments in, printed results out.

pub mod accuracy;
mod auto;
pub mod cache;
pub mod conform;
pub mod crosscheck;
mod frames;
pub mod metadata;
pub mod prove;
pub mod render;
pub mod reproduce;
pub mod scenes;
pub mod simulate;
mod simulator;
pub mod sweep;
pub mod trace;
pub mod walk;
