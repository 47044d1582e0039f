//! The SaarCOR suite for a person: the command line `saarcor`, its arguments, tables and pages.
//!
//! Only this crate parses arguments, prints and draws. What it shows is computed by `saarcor-studies`,
//! `saarcor-kit` and `saarcor-proofs`.
//!
//! ```
//! use saarcor_cli::size::Size;
//! use saarcor_model::vm::Bytes;
//!
//! let size: Size = "8MiB".parse()?;
//! assert_eq!((size.0, size.to_string()), (Bytes(8 << 20), "8MiB".to_owned()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Read [`cli`] first, then a verb (`src/verbs`), then what the verb takes from the modules below.
//!
//! | module | subject |
//! |---|---|
//! | [`cli`] | the verbs, and how errors are shown |
//! | [`status`] | how a command ends |
//! | [`args`] | what arguments mean: ranges of frames, configurations |
//! | [`cache`] | where scenes are kept from run to run |
//! | [`size`] | sizes in bytes, as a user writes them |
//! | [`limits`] | how much memory a simulation may take |
//! | [`output`] | standard output and output files, whole or not at all |
//! | [`signals`] | what is done before a signal ends the process |
//! | [`progress`] | messages on standard error |
//! | [`table`] | tables as text and as HTML |
//! | [`plot`] | how graphs look |
//! | [`summary`] | the features that a scene needs, and the bytes of its image |
//! | [`sample`] | estimates from a sample |
//! | [`results`] | the results of a sweep in files |
//! | [`curve`] | the costs of a sweep as curves |
//! | [`front`] | the front of speed against error |
//! | [`metadata`] | the metadata law beside the paper's examples |
//! | [`conform`] | the report of a conformance run |
//! | [`prove`] | the theorems and how they are proved |
//! | [`kani`] | how Kani is run |
//! | [`reproduce`] | the paper's figures, ours beside theirs |

pub mod args;
pub mod cache;
pub mod cli;
pub mod conform;
pub mod curve;
pub mod front;
pub mod kani;
pub mod limits;
pub mod metadata;
pub mod output;
pub mod plot;
pub mod progress;
pub mod prove;
pub mod reproduce;
pub mod results;
pub mod sample;
pub mod signals;
pub mod size;
pub mod status;
pub mod summary;
pub mod surface;
pub mod table;
mod verbs;
