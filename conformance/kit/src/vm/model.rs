//! The model as an implementation: what all others are compared with.

use super::cache::{Access, Cache, Outcome};
use super::host::SparseHost;
use crate::error::Error;
use saarcor_model::vm::{
    CacheConfig, CardAddr, Directory, HostAddr, LineAddr, Outcome as SetOutcome, Set, VirtualMemory,
};

/// The model's virtual memory with sets of `WAYS` lines.
#[derive(Clone, Debug)]
pub struct ModelCache<const WAYS: usize> {
    memory: VirtualMemory<SparseHost, WAYS>,
}

impl<const WAYS: usize> ModelCache<WAYS> {
    /// An empty cache.
    ///
    /// # Panics
    /// If `WAYS` is not the number of ways of the configuration.
    #[must_use]
    pub fn new(config: CacheConfig) -> Self {
        Self { memory: VirtualMemory::new(Directory::new(config), SparseHost::default()) }
    }

    /// The set of the line that holds `host`.
    #[must_use]
    pub fn set_of(&self, host: HostAddr) -> &Set<WAYS> {
        let config = &self.memory.directory.config;
        &self.memory.directory.sets()[config.set_of(config.geometry.line_of(host)).0 as usize]
    }

    /// All sets.
    #[must_use]
    pub fn sets(&self) -> &[Set<WAYS>] {
        self.memory.directory.sets()
    }
}

impl<const WAYS: usize> Cache for ModelCache<WAYS> {
    fn write(&mut self, host: HostAddr, bytes: &[u8]) {
        self.memory.host.write(host.0, bytes);
    }

    #[inline]
    fn read(&mut self, host: HostAddr, bytes: &mut [u8]) -> Access {
        let config = self.memory.directory.config;
        let line = config.geometry.line_of(host);
        let outcome = self.memory.read_in_line(host, bytes);
        let start = config.geometry.card_addr(config.set_of(line), outcome.way());
        let first_byte = |line: LineAddr| config.geometry.first_byte(line);
        Access {
            card: CardAddr(start.0 + config.geometry.offset_of(host)),
            outcome: match outcome {
                SetOutcome::Hit { .. } => Outcome::Hit,
                SetOutcome::Miss { evicted, .. } => Outcome::Miss(evicted.map(first_byte)),
            },
        }
    }

    fn invalidate(&mut self, host: HostAddr, len: u64) {
        self.memory.invalidate(host, len);
    }

    fn flush(&mut self) {
        self.memory.flush();
    }
}

/// The model of a configuration.
///
/// # Errors
/// Never: the model supports all.
pub fn make(config: &CacheConfig) -> Result<Box<dyn Cache>, Error> {
    Ok(match config.geometry.ways() {
        1 => Box::new(ModelCache::<1>::new(*config)),
        2 => Box::new(ModelCache::<2>::new(*config)),
        4 => Box::new(ModelCache::<4>::new(*config)),
        8 => Box::new(ModelCache::<8>::new(*config)),
        _ => Box::new(ModelCache::<16>::new(*config)),
    })
}
