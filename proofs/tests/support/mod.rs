//! What the property tests share: reproducible engines, and arbitrary parts of a configuration.

#![allow(dead_code, reason = "each test file takes what it needs")]

pub mod rays;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saarcor_model::vm::{Hash, Policy};

/// The same cases in every run; `PROPTEST_CASES` asks for more of them.
pub fn engine() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(2003), failure_persistence: None, ..ProptestConfig::default() }
}

pub fn policies() -> impl Strategy<Value = Policy> {
    prop_oneof![Just(Policy::Lru), Just(Policy::Fifo), Just(Policy::Plru)]
}

pub fn hashes() -> impl Strategy<Value = Hash> {
    prop_oneof![Just(Hash::Low), Just(Hash::AddUpper), Just(Hash::AddUpperAll)]
}
