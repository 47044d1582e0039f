//! Proofs of implementations in Verilog, for requests without end.
//!
//! | module | subject |
//! |---|---|
//! | [`table`] | the step of one set as a table |
//! | [`checker`] | the table in Verilog: one set, any of them |

pub mod checker;
pub mod table;
