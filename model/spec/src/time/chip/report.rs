//! What a run of the chip tells: cycles, bytes, and who waited for what.

use crate::time::sdram::{Direction, Span};

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

/// What bytes move for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traffic {
    /// From the on-board memory to a first-level cache.
    L1Fill,
    /// A line from the host, written to the on-board memory.
    VmFill,
    /// Metadata of version B, read.
    MetadataRead,
    /// Metadata of version B, written back.
    MetadataWriteBack,
    /// A line over the bus to the host.
    Pci,
}

/// A cache of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cache {
    /// The first-level cache of the unit of this place in
    /// [`Unit::ALL`](crate::vm::Unit::ALL).
    L1(usize),
    /// The on-board memory.
    L2,
}

/// What a look-up finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// The line is there.
    Resident,
    /// The line is in flight.
    InFlight,
    /// The line has to be fetched.
    Missing,
}

/// Is told what each packet of a run does: packets count in the order in which they are handed
/// out. Over all packets, what is told adds up to the [`Report`].
pub trait Observer {
    /// `bytes` move for `traffic` during `span`, because `packet` was the first to miss them.
    fn transfer(&mut self, packet: u32, traffic: Traffic, span: Span, bytes: u64) {
        let _ = (packet, traffic, span, bytes);
    }

    /// `packet` looks a line up.
    fn look_up(&mut self, packet: u32, cache: Cache, found: Found) {
        let _ = (packet, cache, found);
    }

    /// A thread begins `packet`.
    fn begin(&mut self, packet: u32, cycle: u64) {
        let _ = (packet, cycle);
    }

    /// Of the on-board memory, `bytes` at `card` are asked for in cycle `now`: the transfer follows.
    fn request(&mut self, now: u64, card: u64, bytes: u64, direction: Direction) {
        let _ = (now, card, bytes, direction);
    }
}

/// Nobody listens.
impl Observer for () {}

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
    #[must_use]
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
    #[must_use]
    pub fn hits(&self) -> u64 {
        self.accesses - self.merged - self.misses
    }
}

/// What a picture took.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Report {
    /// Core cycles from the first packet's begin to the last one's end.
    pub cycles: u64,
    /// The units, in the order of [`Unit::ALL`](crate::vm::Unit::ALL).
    pub units: [UnitReport; 4],
    /// Their first-level caches, in the same order.
    pub l1: [CacheReport; 4],
    /// The on-board memory as a cache; without virtual memory, requests that it served.
    pub l2: CacheReport,
    /// Bytes that moved on the bus of the on-board memory, whole beats, by [`Traffic`].
    pub l1_fill_bytes: u64,
    /// See [`Report::l1_fill_bytes`].
    pub vm_fill_bytes: u64,
    /// See [`Report::l1_fill_bytes`].
    pub metadata_read_bytes: u64,
    /// See [`Report::l1_fill_bytes`].
    pub metadata_write_back_bytes: u64,
    /// Bytes loaded from the host: a line for each miss of `l2`.
    pub pci_bytes: u64,
    /// Cycles in which the bus to the host was taken.
    pub pci_busy: u64,
}

impl Report {
    /// Bytes that moved on the bus of the on-board memory: Table 2's Mem.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.l1_fill_bytes + self.vm_fill_bytes + self.metadata_read_bytes + self.metadata_write_back_bytes
    }

    pub(super) fn moved(&mut self, traffic: Traffic) -> &mut u64 {
        match traffic {
            Traffic::L1Fill => &mut self.l1_fill_bytes,
            Traffic::VmFill => &mut self.vm_fill_bytes,
            Traffic::MetadataRead => &mut self.metadata_read_bytes,
            Traffic::MetadataWriteBack => &mut self.metadata_write_back_bytes,
            Traffic::Pci => &mut self.pci_bytes,
        }
    }
}
