//! Executable specification of the SaarCOR ray tracing chip and its virtual memory (Schmittler,
//! Leidinger, Slusallek 2003).
//!
//! `SPEC.md` beside this crate numbers the requirements (`VM-1` ...) that the code names. The
//! modules in the order in which to read them:
//!
//! * the virtual memory of §3: [`units`], [`geometry`], [`hash`](mod@hash), [`set`], [`memory`],
//!   [`vm`];
//! * what lies in host memory: [`scene`], [`kdtree`], [`image`];
//! * the units of a ray tracing pipeline, §2: [`ray`], [`raygen`], [`traversal`],
//!   [`intersection`], [`texture`], [`shading`], [`rtp`];
//! * the same chip in time: [`program`], what the functional run leaves for the timing run;
//!   [`sdram`], [`pci`], [`chip_config`], [`tags`], [`chip`].
//!
//! The crate is pure: no input or output, no clock, no randomness, no global state.
//!
//! Fused multiply-add is not used: each `*` and `+` rounds by itself, so that results are the same
//! on every machine.

pub mod chip;
pub mod chip_config;
pub mod data_set;
pub mod geometry;
pub mod hash;
pub mod image;
pub mod intersection;
pub mod kdtree;
pub mod l1;
pub mod memory;
pub mod metadata;
pub mod metadata_cache;
pub mod pci;
pub mod program;
pub mod ray;
pub mod raygen;
pub mod rtp;
pub mod scene;
pub mod sdram;
pub mod set;
pub mod shading;
pub mod tags;
pub mod texture;
pub mod traversal;
pub mod units;
pub mod vm;
