//! How much memory a simulation may take.

use crate::size::Size;
use anyhow::{Result, ensure};
use saarcor_model::vm::{Bytes, CacheConfig, Set};

/// Bits that a walk keeps for each line of the host: whether the frame has touched it, whether it has evicted it, and whether
/// it is resident.
const HISTORY_BITS: u64 = 3;

/// Most memory that the state of a simulation may take.
const MAX_STATE: Bytes = Bytes(4 << 30);

/// Checks that a cache in front of `host` bytes of host memory can be simulated.
///
/// # Errors
/// If its state takes more memory than there should be.
pub fn check_state(config: CacheConfig, host: Bytes) -> Result<()> {
    let CacheConfig { geometry, .. } = config;
    let Bytes(state) = state(config, host);
    ensure!(
        state <= MAX_STATE.0,
        "memory of {} in lines of {}: simulating it takes {:.1} GiB, more than {:.0} GiB; take longer lines \
         or less memory",
        Size(geometry.memory()),
        Size(geometry.line()),
        gib(state),
        gib(MAX_STATE.0)
    );
    Ok(())
}

/// Checks that a walk can play all these caches in front of `host` bytes of host memory.
///
/// # Errors
/// If their states take more memory than there should be.
pub fn check_walk(configs: &[CacheConfig], host: Bytes) -> Result<()> {
    configs.iter().try_for_each(|config| check_state(*config, host))?;
    let all: u64 = configs.iter().map(|config| walked(*config, host).0).sum();
    ensure!(
        all <= MAX_STATE.0,
        "{} virtual memories: simulating them takes {:.1} GiB, more than {:.0} GiB; take fewer, longer lines or less memory",
        configs.len(),
        gib(all),
        gib(MAX_STATE.0)
    );
    Ok(())
}

/// Checks that, of many caches in front of `host` bytes, any `at_a_time` can be simulated together.
///
/// # Errors
/// If their states take more memory than there should be.
pub fn check_together(
    configs: impl Iterator<Item = CacheConfig>,
    at_a_time: usize,
    host: Bytes,
) -> Result<()> {
    let mut states: Vec<u64> = configs.map(|config| state(config, host).0).collect();
    states.sort_unstable_by(|a, b| b.cmp(a));
    let most: u64 = states.iter().take(at_a_time).sum();
    ensure!(
        most <= MAX_STATE.0,
        "the {at_a_time} largest of {} points together take {:.1} GiB, more than {:.0} GiB; take fewer --threads, \
         longer lines or less memory",
        states.len(),
        gib(most),
        gib(MAX_STATE.0)
    );
    Ok(())
}

fn gib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

/// Memory that the state of a simulation takes: that of a walk, and the lines that lie on the card.
fn state(config: CacheConfig, host: Bytes) -> Bytes {
    let line = config.geometry.line().0;
    let card = config.geometry.memory().0.min(host.0.next_multiple_of(line));
    Bytes(walked(config, host).0 + card)
}

/// Memory that a walk takes for a cache: the directory, and what it knows of each line of the host.
fn walked(config: CacheConfig, host: Bytes) -> Bytes {
    let directory = config.geometry.lines() * size_of::<Set<1>>() as u64;
    let lines = host.0.div_ceil(config.geometry.line().0);
    Bytes(directory + (lines * HISTORY_BITS).div_ceil(8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::time::standard::POLICY;
    use saarcor_model::vm::{Geometry, Hash};

    #[test]
    fn state_that_cannot_be_held_is_refused() {
        let config = |memory, line| CacheConfig {
            geometry: Geometry::new(Bytes(memory), Bytes(line), 4).expect("legal"),
            hash: Hash::default(),
            policy: POLICY,
        };
        assert!(check_state(config(64 << 20, 128), Bytes(1 << 30)).is_ok());
        assert!(check_state(config(1 << 32, 1), Bytes(0)).is_err());
        assert!(check_walk(&[config(1 << 29, 1)], Bytes(0)).is_ok());
        let error = check_walk(&[config(1 << 29, 1); 2], Bytes(0)).expect_err("8 GiB");
        assert!(
            error.to_string().starts_with("2 virtual memories: simulating them takes 8.0 GiB"),
            "{error}"
        );
    }
}
