//! What a run of the chip is counted by: cycles, bytes, and why units waited.

/// Why a unit that is not busy has nothing to work on while threads of its pipeline want it. The
/// first that holds for any of them counts (CH-18).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stall {
    /// The first-level cache is about to answer.
    LookUp,
    /// Others use the ports of the first-level cache.
    Port,
    /// As many lines are in flight as the first-level cache can wait for.
    Mshr,
    /// The on-board memory is about to answer.
    Memory,
    /// The host is about to.
    Host,
}

impl Stall {
    /// All of them, the first to count first.
    pub const ALL: [Self; 5] = [Self::LookUp, Self::Port, Self::Mshr, Self::Memory, Self::Host];
}

/// The cycles of all units of one type: `busy + stalls + idle` = cycles × pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct UnitReport {
    /// Cycles in which rays went in.
    pub busy: u64,
    /// Cycles in which threads wanted the unit and none had its bytes, by [`Stall::ALL`].
    pub stalls: [u64; 5],
    /// Cycles in which no thread wanted the unit.
    pub idle: u64,
    /// Packet operations.
    pub operations: u64,
    /// Rays that went in.
    pub rays: u64,
}

impl UnitReport {
    /// Cycles of stalls of all causes.
    pub fn stalled(&self) -> u64 {
        self.stalls.iter().sum()
    }
}

/// What a cache did: `accesses` = hits + merged + misses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CacheReport {
    /// Lines looked up.
    pub accesses: u64,
    /// Of these, lines that were in flight already.
    pub merged: u64,
    /// Of these, lines that had to be fetched.
    pub misses: u64,
}

impl CacheReport {
    /// Lines that were there.
    pub fn hits(&self) -> u64 {
        self.accesses - self.merged - self.misses
    }
}

/// What a picture took.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TimingReport {
    /// Core cycles from the first packet's begin to the last one's end.
    pub cycles: u64,
    /// The units, in the order of [`Unit::ALL`](crate::vm::Unit::ALL).
    pub units: [UnitReport; 4],
    /// Their first-level caches, in the same order.
    pub l1: [CacheReport; 4],
    /// The on-board memory as a cache; without virtual memory, requests that it served.
    pub l2: CacheReport,
    /// Bytes of first-level lines, read from the on-board memory: whole beats, as all bytes of its bus.
    pub l1_fill_bytes: u64,
    /// Bytes of lines from the host, written to the on-board memory.
    pub vm_fill_bytes: u64,
    /// Bytes of version B's metadata, read.
    pub metadata_read_bytes: u64,
    /// Bytes of version B's metadata, written back.
    pub metadata_write_back_bytes: u64,
    /// Bytes loaded from the host: a line for each miss of `l2`.
    pub pci_bytes: u64,
    /// Cycles in which the bus to the host was taken.
    pub pci_busy: u64,
}

impl TimingReport {
    /// Bytes that moved on the bus of the on-board memory: Table 2's Mem.
    pub fn memory_bytes(&self) -> u64 {
        self.l1_fill_bytes + self.vm_fill_bytes + self.metadata_read_bytes + self.metadata_write_back_bytes
    }
}
