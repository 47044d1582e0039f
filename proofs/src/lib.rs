//! What holds of the SaarCOR model.
//!
//! The properties stand in `tests/`: `transparency.rs` holds the virtual memory to the oracles of
//! `saarcor-reference`, `laws.rs` holds each unit to the laws of its own. They are judged at
//! random, from fixed seeds; nothing here is proved for all inputs.
