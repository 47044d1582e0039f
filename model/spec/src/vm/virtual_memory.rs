//! The virtual memory in the bus manager (§3): the on-board memory as a cache of host memory.

use super::directory::Directory;
use super::memory::{HostMemory, Memory, Unit};
use super::set::Outcome;
use super::units::HostAddr;
use super::version_a::{Metadata, OnChip};

/// The virtual memory: the on-board memory, its directory, and the bus to host memory.
///
/// The fields are public, so that a proof can start from any state. Whoever writes to `host` must
/// invalidate what was written.
#[derive(Clone, Debug)]
pub struct VirtualMemory<H, const WAYS: usize, M = OnChip<WAYS>> {
    /// Which line lies where.
    pub directory: Directory<WAYS, M>,
    /// The lines on the card, at their card addresses.
    pub card: Vec<u8>,
    /// The host's memory.
    pub host: H,
}

impl<H: HostMemory, const WAYS: usize, M: Metadata<WAYS>> VirtualMemory<H, WAYS, M> {
    /// An empty on-board memory, of which `directory` decides, in front of `host`.
    ///
    /// # Panics
    /// If the directory has counted an access: its lines would not be on the card.
    pub fn new(directory: Directory<WAYS, M>, host: H) -> Self {
        assert_eq!(directory.counters.accesses, 0, "an empty card needs an empty directory");
        let card = vec![0; directory.config.geometry.memory().0 as usize];
        Self { directory, card, host }
    }

    /// Forgets every line that `len` bytes at `addr` touch (VM-8).
    pub fn invalidate(&mut self, addr: HostAddr, len: u64) {
        self.directory.invalidate(addr, len);
    }

    /// Forgets all lines.
    pub fn flush(&mut self) {
        self.directory.flush();
    }

    /// Reads bytes that lie within one line. A miss loads the whole line from the host first.
    ///
    /// # Panics
    /// If the bytes do not lie within one line.
    pub fn read_in_line(&mut self, addr: HostAddr, bytes: &mut [u8]) -> Outcome {
        let config = self.directory.config;
        let geometry = config.geometry;
        let line = geometry.line_of(addr);
        let outcome = self.directory.access(line);
        let start = geometry.card_addr(config.set_of(line), outcome.way()).0 as usize;
        let line_on_card = &mut self.card[start..][..geometry.line().0 as usize];
        if let Outcome::Miss { .. } = outcome {
            self.host.read(geometry.first_byte(line), line_on_card);
        }
        bytes.copy_from_slice(&line_on_card[geometry.offset_of(addr) as usize..][..bytes.len()]);
        outcome
    }
}

impl<H: HostMemory, const WAYS: usize, M: Metadata<WAYS>> Memory for VirtualMemory<H, WAYS, M> {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        let geometry = self.directory.config.geometry;
        let (mut addr, mut rest) = (addr, bytes);
        while !rest.is_empty() {
            let (here, next) = geometry.split_at_line_end(addr, rest.len() as u64);
            let (now, later) = rest.split_at_mut(here as usize);
            self.read_in_line(addr, now);
            rest = later;
            let Some(next) = next else {
                // The address space ends: no memory has bytes beyond it.
                rest.fill(0);
                return;
            };
            addr = next;
        }
    }
}
