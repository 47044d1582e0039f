//! The conformance kit: is an implementation of the SaarCOR virtual memory right, and if not, where?
//!
//! An implementation is a filter from requests to answers, lines of text as `PROTOCOL.md` has them.
//! The kit holds conversations with it, one for each [`session::Session`], compares each answer with the
//! model's, names the highest [`level::Level`] at which all agree, and shrinks what fails to the shortest
//! requests that still do.
//!
//! Judge an implementation in process, here a hash that leaves out the upper bits of a line:
//!
//! ```
//! use saarcor_kit::dut::InProcess;
//! use saarcor_kit::error::Error;
//! use saarcor_kit::hash::SetHash;
//! use saarcor_kit::implementation::Implementation;
//! use saarcor_kit::plan::{Options, default_suite};
//! use saarcor_kit::run::run;
//!
//! struct LowerBits;
//!
//! impl Implementation for LowerBits {
//!     fn observes(&self) -> String {
//!         "set".to_owned()
//!     }
//!
//!     fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
//!         let line = request.strip_prefix(b"s ").and_then(saarcor_kit::hex::number);
//!         saarcor_kit::hex::push_number(answer, line.ok_or("write 's LINE' in hex")? % 16);
//!         Ok(())
//!     }
//! }
//!
//! let dut = InProcess::new(Box::new(|_, config| match config {
//!     "sets=16 hash=add-upper" => Ok(Box::new(LowerBits)),
//!     _ => Err(Error::Unsupported("sets".to_owned())),
//! }));
//! let options = Options { quick: true, requests: 1000, ..Options::default() };
//! let planned = default_suite(&SetHash, &options)?;
//! let report = run("lower bits", &dut, &SetHash, &planned, &options, &|_| ())?;
//! assert_eq!(report.verdict.text(), "does not conform");
//! assert_eq!(report.failures[0].requirement, "VM-3");
//! # Ok::<(), Error>(())
//! ```
//!
//! | module | subject |
//! |---|---|
//! | [`level`] | levels of agreement |
//! | [`session`], [`suites`] | one conversation as text; the directed sessions |
//! | [`kind`], [`kinds`] | what is particular to a kind of implementation; all of them |
//! | [`vm`] | `saarcor-vm`: the virtual memory |
//! | [`hash`] | `saarcor-hash`: the set of a line |
//! | [`meta`] | `saarcor-meta`: the tags of version B |
//! | [`kd`] | `saarcor-kd`: traversal and intersection |
//! | [`chip`] | `saarcor-chip`: the chip in time |
//! | [`hex`] | numbers and bytes as text |
//! | [`implementation`], [`server`] | an implementation in Rust; the protocol around it |
//! | [`dut`], [`process`], [`shared_library`] | an implementation under test: in process, as a child process, as a library |
//! | [`children`] | processes that are started, and none of which is left |
//! | [`target`] | `dut.toml` and command lines |
//! | [`scoreboard`], [`comparison`] | compares answers with the model's, and keeps what differs |
//! | [`sizes`] | sessions about the sizes that people build |
//! | [`plan`], [`run`], [`deadline`] | which sessions are run; all of them, and the report; when they are stopped |
//! | [`shrink`] | delta debugging |
//! | [`coverage`] | what sessions exercise |
//! | [`report`] | what was found; its form for CI systems is in `junit` |
//! | [`requirements`] | the texts of the requirements |
//! | [`shown`] | lines as a person sees them |
//! | [`waive`] | failures that are known |
//! | [`prove`] | proofs of implementations in Verilog |
//! | [`templates`] | implementations to copy, and faults to plant into them |
//! | [`error`] | what is wrong with input, where, and what would be right |

#[cfg(unix)]
mod build;
#[cfg(unix)]
pub mod children;
pub mod chip;
pub mod comparison;
pub mod coverage;
pub mod deadline;
pub mod dut;
pub mod error;
mod execution;
pub mod hash;
pub mod hex;
pub mod implementation;
mod junit;
pub mod kd;
pub mod kind;
pub mod kinds;
pub mod level;
pub mod meta;
pub mod plan;
#[cfg(unix)]
pub mod process;
pub mod prove;
pub mod report;
pub mod requirements;
pub mod run;
pub mod scoreboard;
mod script;
pub mod server;
pub mod session;
#[cfg(unix)]
pub mod shared_library;
pub mod shown;
pub mod shrink;
pub mod sizes;
pub mod suites;
mod summary;
pub mod target;
pub mod templates;
pub mod vm;
pub mod waive;
mod words;
