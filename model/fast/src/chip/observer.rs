//! What an observer of a run of the chip sees.

use saarcor_model::time::{Command, Direction, Load, Span, TimingReport};
use saarcor_model::vm::HostAddr;

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
    /// [`Unit::ALL`](saarcor_model::vm::Unit::ALL).
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

/// Watches what each packet of a run does: packets count in the order in which they are handed out.
/// Over all packets, what is observed adds up to the [`TimingReport`].
pub trait ChipObserver {
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

    /// The memory chips get a command in a memory clock. Commands come in the order of their clocks, but some
    /// cycles later than the chips get them; at the end of the run, all those of its cycles have come.
    fn command(&mut self, clock: u64, command: Command) {
        let _ = (clock, command);
    }

    /// In cycle `now` a line from the host is written to its place on the card. Pictures before the run
    /// write in cycle 0. Writes and reads come in the order in which the memory chips serve them.
    fn line_is_written(&mut self, now: u64, load: Load) {
        let _ = (now, load);
    }

    /// In cycle `now`, `bytes` are read from address `card` of the card on: those of the host from `addr`
    /// on. Packets that take no time are left out.
    fn part_is_read(&mut self, now: u64, addr: HostAddr, bytes: u64, card: u64) {
        let _ = (now, addr, bytes, card);
    }
}

/// Nobody watches.
impl ChipObserver for () {}

/// The bytes of a report that move for `traffic`.
pub(super) fn bytes_of(report: &mut TimingReport, traffic: Traffic) -> &mut u64 {
    match traffic {
        Traffic::L1Fill => &mut report.l1_fill_bytes,
        Traffic::VmFill => &mut report.vm_fill_bytes,
        Traffic::MetadataRead => &mut report.metadata_read_bytes,
        Traffic::MetadataWriteBack => &mut report.metadata_write_back_bytes,
        Traffic::Pci => &mut report.pci_bytes,
    }
}
