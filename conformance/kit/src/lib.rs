//! The conformance kit: is an implementation of the SaarCOR virtual memory right, and if not, where?
//!
//! An implementation is a filter from requests to answers, lines of text as `PROTOCOL.md` has them.
//! The kit holds [`session::Session`]s with it, compares each answer with the model's, names the
//! highest [`level::Level`] at which all agree, and shrinks what fails to the shortest requests that
//! still do.
//!
//! | module | subject |
//! |---|---|
//! | [`level`] | levels of agreement |
//! | [`session`] | one conversation as text |
//! | [`suites`] | the directed sessions |
//! | [`kind`] | what is particular to a kind of implementation |
//! | [`vm`] | `saarcor-vm`: the virtual memory |
//! | [`kd`] | `saarcor-kd`: traversal and intersection |
//! | [`hash`] | `saarcor-hash`: the set of a line |
//! | [`meta`] | `saarcor-meta`: the tags of version B |
//! | [`chip`] | `saarcor-chip`: the chip in time |
//! | [`hex`] | numbers as text |
//! | [`serve`] | an implementation in Rust, and the protocol around it |
//! | [`judge`] | the judge of one conversation |
//! | [`check`] | answers from a file |
//! | [`library`] | an implementation as a shared library |
//! | [`dut`], [`child`] | an implementation under test: in process, or a child process |
//! | [`stop`] | when conversations are given up |
//! | [`target`] | `dut.toml` and command lines |
//! | [`run`] | all sessions, and the report |
//! | [`shrink`] | delta debugging |
//! | [`report`] | what was found; its form for CI systems is in `junit` |
//! | [`templates`] | implementations to copy, and faults to plant into them |

pub mod check;
#[cfg(unix)]
pub mod child;
pub mod chip;
pub mod dut;
mod gather;
pub mod hash;
pub mod hex;
pub mod judge;
mod junit;
pub mod kd;
pub mod kind;
pub mod level;
#[cfg(unix)]
pub mod library;
pub mod meta;
pub mod report;
pub mod run;
pub mod serve;
pub mod session;
pub mod shrink;
pub mod stop;
pub mod suites;
pub mod target;
pub mod templates;
pub mod vm;

/// All kinds, in the order in which an implementation is asked for them.
pub const KINDS: &[&dyn kind::Kind] = &[&vm::Vm, &hash::SetHash, &meta::Meta, &kd::Kd, &chip::Chip];

/// The kind of that name.
#[must_use]
pub fn kind_named(name: &str) -> Option<&'static dyn kind::Kind> {
    KINDS.iter().copied().find(|kind| kind.name() == name)
}

/// Most bytes of a line (Assumed), so that answers have a longest.
pub const MAX_LINE_BYTES: usize = 1 << 16;
