//! Proofs of implementations in Verilog, for requests without end.
//!
//! | module | subject |
//! |---|---|
//! | [`table`] | the step of one set as a table |
//! | [`checker`] | the table in Verilog: one set, any of them |
//! | [`config`] | the table `[prove]` of `dut.toml` |
//! | [`harness`] | the implementation beside the checker, and what is claimed |
//! | [`found`] | the state of an implementation that does not show it |
//! | `aiger` | netlists as and-inverter graphs |
//! | `simulation` | these with their memories |
//! | `netlists` | their netlists, by Yosys |
//! | [`plant`] | faults of the run's own, which have to be refuted |
//! | [`tools`] | Yosys, ABC and a solver |
//! | [`driver`] | a proof from beginning to end |
//! | [`report`] | what it found |

mod aiger;
pub mod checker;
pub mod config;
#[cfg(unix)]
pub mod driver;
pub mod found;
pub mod harness;
#[cfg(unix)]
mod netlists;
pub mod plant;
#[cfg(unix)]
pub mod report;
mod simulation;
pub mod table;
#[cfg(unix)]
pub mod tools;
#[cfg(unix)]
mod trace;
