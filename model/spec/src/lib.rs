//! Executable specification of the SaarCOR ray tracing chip and its virtual memory (Schmittler,
//! Leidinger, Slusallek 2003).
//!
//! [`SPEC.md`](../SPEC.md) numbers the requirements (`VM-1` ...) that the code names. The modules in
//! the order in which to read them: [`vm`], [`host`], [`rays`], [`time`].
//!
//! The crate is pure: no input or output, no clock, no randomness, no global state.
//!
//! Fused multiply-add is not used: each `*` and `+` rounds by itself, so that results are the same
//! on every machine.

pub mod host;
pub mod rays;
pub mod time;
pub mod vm;
