//! Programs: what the functional run leaves for the timing run.
//!
//! What a packet of rays does and reads does not depend on when the bytes come. So the functional
//! run writes down the operations of each packet once, and the timing run ([`chip`](crate::time::chip))
//! plays them against any memory system.

use crate::vm::{HostAddr, Observer, Unit};
use std::sync::Arc;

/// One step of a packet: a unit reads, and works for some rays (CH-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operation {
    /// First byte that is read.
    pub addr: HostAddr,
    /// Bytes that are read; 0 where the unit works on what the chip holds already.
    pub bytes: u16,
    /// Rays that the unit works for once the bytes are there; 0 where they belong to the work of
    /// the operation before.
    pub rays: u8,
    /// The unit.
    pub unit: Unit,
}

/// The operations of a packet, in order. Shared: pictures may have packets in common.
pub type Program = Arc<[Operation]>;

/// The programs of a picture's packets.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Programs {
    /// Those of each packet, in the order in which packets are handed out (CH-4).
    pub packets: Vec<Program>,
    /// Address of the first triangle: where the lines of the triangle cache begin (L1-1), the same in all pictures of a scene.
    pub triangles: HostAddr,
}

impl Programs {
    /// Where the lines of a first-level cache begin (L1-1).
    pub fn first_level_base(&self, unit: Unit) -> HostAddr {
        if unit == Unit::Intersection { self.triangles } else { HostAddr(0) }
    }

    /// All operations, packet after packet.
    pub fn in_order(&self) -> impl Iterator<Item = &Operation> {
        self.packets.iter().flat_map(|program| program.iter())
    }
}

/// An observer that writes down the program of a packet.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    operations: Vec<Operation>,
    /// An operation that has begun and has read nothing yet.
    begun: Option<Operation>,
}

impl Recorder {
    /// The operations since the last call: the program of a packet.
    pub fn take(&mut self) -> Program {
        self.operations.extend(self.begun.take());
        let program = self.operations.as_slice().into();
        self.operations.clear();
        program
    }
}

impl Observer for Recorder {
    fn operation(&mut self, unit: Unit, rays: u32) {
        self.operations.extend(self.begun.take());
        self.begun = Some(Operation { addr: HostAddr(0), bytes: 0, rays: rays as u8, unit });
    }

    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: usize) {
        let rays = self.begun.take().map_or(0, |begun| begun.rays);
        self.operations.push(Operation { addr, bytes: bytes as u16, rays, unit });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_belong_to_the_operation_that_began() {
        let mut recorder = Recorder::default();
        recorder.operation(Unit::Shading, 64);
        recorder.operation(Unit::Traversal, 60);
        recorder.read(Unit::Traversal, HostAddr(8), 8);
        recorder.operation(Unit::Shading, 7);
        recorder.read(Unit::Shading, HostAddr(100), 20);
        recorder.read(Unit::Shading, HostAddr(4), 4);
        recorder.operation(Unit::Shading, 5);
        let operation = |unit, addr, bytes, rays| Operation { addr: HostAddr(addr), bytes, rays, unit };
        let expected = [
            operation(Unit::Shading, 0, 0, 64),
            operation(Unit::Traversal, 8, 8, 60),
            operation(Unit::Shading, 100, 20, 7),
            operation(Unit::Shading, 4, 4, 0),
            operation(Unit::Shading, 0, 0, 5),
        ];
        assert_eq!(*recorder.take(), expected);
        assert!(recorder.take().is_empty());
        assert!(size_of::<Operation>() <= 12);
    }
}
