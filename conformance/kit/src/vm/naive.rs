//! The naive reference as an implementation: it judges the model, and so the judge.

use super::cache::{Access, Cache, Outcome};
use super::host::SparseHost;
use crate::error::Error;
use saarcor_model::vm::{CacheConfig, CardAddr, HostAddr, HostMemory as _, LineAddr, Outcome as SetOutcome};
use saarcor_oracles::cache::NaiveCache;
use std::collections::HashMap;

struct NaiveMemory {
    cache: NaiveCache,
    line_bytes: u64,
    ways: u64,
    host: SparseHost,
    /// Each line's bytes as they were when it was last loaded.
    copies: HashMap<LineAddr, Vec<u8>>,
}

/// The naive reference of a configuration.
///
/// # Errors
/// Never: it supports all.
pub fn make(config: &CacheConfig) -> Result<Box<dyn Cache>, Error> {
    Ok(Box::new(NaiveMemory {
        cache: NaiveCache::new(*config),
        line_bytes: config.geometry.line().0,
        ways: u64::from(config.geometry.ways()),
        host: SparseHost::default(),
        copies: HashMap::new(),
    }))
}

impl Cache for NaiveMemory {
    fn write(&mut self, host: HostAddr, bytes: &[u8]) {
        self.host.write(host.0, bytes);
    }

    fn read(&mut self, host: HostAddr, bytes: &mut [u8]) -> Access {
        let line = LineAddr((u64::from(host.0) / self.line_bytes) as u32);
        let offset = u64::from(host.0) % self.line_bytes;
        let outcome = self.cache.access(line);
        if let SetOutcome::Miss { .. } = outcome {
            let mut copy = vec![0; self.line_bytes as usize];
            self.host.read(HostAddr(host.0 - offset as u32), &mut copy);
            self.copies.insert(line, copy);
        }
        let offset_bytes = &self.copies[&line][offset as usize..];
        bytes.copy_from_slice(&offset_bytes[..bytes.len()]);
        let place = self.cache.set_of(line) * self.ways + u64::from(outcome.way().0);
        let first_byte = |line: LineAddr| HostAddr((u64::from(line.0) * self.line_bytes) as u32);
        Access {
            card: CardAddr((place * self.line_bytes + offset) as u32),
            outcome: match outcome {
                SetOutcome::Hit { .. } => Outcome::Hit,
                SetOutcome::Miss { evicted, .. } => Outcome::Miss(evicted.map(first_byte)),
            },
        }
    }

    fn invalidate(&mut self, host: HostAddr, len: u64) {
        self.cache.invalidate(host, len);
    }

    fn flush(&mut self) {
        self.cache.flush();
    }
}
