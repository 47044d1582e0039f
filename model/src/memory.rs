//! The memory interface of §2: how every unit reads, whatever lies behind.

use crate::units::HostAddr;

/// The four types of functional units that read memory; §2 gives each type a first-level cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Port {
    /// Materials, shading records, textures and bump maps, for the ray generation and shading unit.
    Shading,
    /// kd-tree nodes, for the traversal unit.
    Node,
    /// Lists of triangle addresses, for the list unit.
    List,
    /// Triangles, for the intersection unit.
    Triangle,
}

impl Port {
    /// All ports, each at its own number.
    pub const ALL: [Self; 4] = [Self::Shading, Self::Node, Self::List, Self::Triangle];
}

/// What a unit reads from: flat memory, the virtual memory, or caches in front of either.
///
/// Transparency (VM-9) means that no unit can tell which: the bytes are the host's.
pub trait Memory {
    /// Reads `bytes.len()` bytes at `addr`. Bytes beyond the end of host memory are zero.
    fn read(&mut self, port: Port, addr: HostAddr, bytes: &mut [u8]);

    /// A packet operation of the unit at `port` begins, in which `rays` rays take part. What the
    /// unit reads before the next one begins belongs to it.
    ///
    /// Says what the work costs, and changes no bytes: only a [`Recorder`](crate::program::Recorder)
    /// listens, and nobody else counts the rays.
    #[inline]
    fn issue(&mut self, _port: Port, _rays: impl FnOnce() -> u32) {}

    /// Reads `N` bytes at `addr`.
    #[inline]
    fn fetch<const N: usize>(&mut self, port: Port, addr: HostAddr) -> [u8; N] {
        let mut bytes = [0; N];
        self.read(port, addr, &mut bytes);
        bytes
    }
}

impl<M: Memory> Memory for &mut M {
    #[inline]
    fn read(&mut self, port: Port, addr: HostAddr, bytes: &mut [u8]) {
        (**self).read(port, addr, bytes);
    }

    #[inline]
    fn issue(&mut self, port: Port, rays: impl FnOnce() -> u32) {
        (**self).issue(port, rays);
    }
}

/// The memory of the PC as the bus sees it.
pub trait HostMemory {
    /// Reads `bytes.len()` bytes at `addr`. Bytes beyond the end are zero.
    fn read(&self, addr: HostAddr, bytes: &mut [u8]);
}

impl<T: AsRef<[u8]>> HostMemory for T {
    #[inline]
    fn read(&self, addr: HostAddr, bytes: &mut [u8]) {
        let rest = self.as_ref().get(addr.0 as usize..).unwrap_or_default();
        if let Some(all) = rest.get(..bytes.len()) {
            bytes.copy_from_slice(all);
        } else {
            bytes[..rest.len()].copy_from_slice(rest);
            bytes[rest.len()..].fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flat memory, and the rays of all operations.
    struct Flat(Vec<u8>, u32);

    impl Memory for Flat {
        fn read(&mut self, _port: Port, addr: HostAddr, bytes: &mut [u8]) {
            HostMemory::read(&self.0, addr, bytes);
        }

        fn issue(&mut self, _port: Port, rays: impl FnOnce() -> u32) {
            self.1 += rays();
        }
    }

    fn unit(mut memory: impl Memory) -> [u8; 4] {
        memory.issue(Port::Node, || 5);
        memory.fetch(Port::Node, HostAddr(1))
    }

    #[test]
    fn reference_to_a_memory_does_what_it_does() {
        let mut memory = Flat(vec![1, 2, 3], 0);
        assert_eq!(unit(&mut memory), [2, 3, 0, 0]);
        assert_eq!(memory.1, 5);
    }
}
