//! What the property tests share: reproducible engines and arbitrary caches.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saarcor_model::geometry::Geometry;
use saarcor_model::hash::Hash;
use saarcor_model::set::Policy;
use saarcor_model::units::Bytes;
use saarcor_model::vm::CacheConfig;
use std::ops::RangeInclusive;

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

/// Caches of 1 to 16 ways and lines of 1 to 4096 bytes, with the given binary logarithms of the
/// number of sets.
pub fn caches(set_bits: RangeInclusive<u32>) -> impl Strategy<Value = CacheConfig> {
    (0..=4u32, 0..=12u32, set_bits, hashes(), policies()).prop_map(|(ways, line, sets, hash, policy)| {
        let geometry = Geometry::new(Bytes(1 << (ways + line + sets)), Bytes(1 << line), 1 << ways)
            .expect("powers of two, and at least one set");
        CacheConfig { geometry, hash, policy }
    })
}

/// Calls a function that is generic over the number of ways: `with_ways!(4, f(a, b))` is
/// `f::<4>(a, b)`.
#[macro_export]
macro_rules! with_ways {
    ($ways:expr, $function:ident($($argument:expr),*)) => {
        match $ways {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            4 => $function::<4>($($argument),*),
            8 => $function::<8>($($argument),*),
            16 => $function::<16>($($argument),*),
            ways => unreachable!("no cache has {ways} ways"),
        }
    };
}
