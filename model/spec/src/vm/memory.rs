//! The memory interface of §2: how every unit reads, whatever lies behind.

use super::units::HostAddr;

/// The four types of functional units that read memory; §2 gives each type a first-level cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Materials, shading records, textures and bump maps, for the ray generation and shading unit.
    Shading,
    /// kd-tree nodes, for the traversal unit.
    Traversal,
    /// Lists of triangle addresses, for the list unit.
    List,
    /// Triangles, for the intersection unit.
    Intersection,
}

impl Unit {
    /// All ports, each at its own number.
    pub const ALL: [Self; 4] = [Self::Shading, Self::Traversal, Self::List, Self::Intersection];
}

/// What a unit reads from: flat memory, the virtual memory, or caches in front of either.
///
/// Transparency (VM-9) means that no unit can tell which: the bytes are the host's.
pub trait Memory {
    /// Reads `bytes.len()` bytes at `addr`. Bytes beyond the end of host memory are zero.
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]);

    /// A packet operation of the unit at `unit` begins, in which `rays` rays take part. What the
    /// unit reads before the next one begins belongs to it.
    ///
    /// Says what the work costs, and changes no bytes: only a [`Recorder`](crate::time::Recorder)
    /// listens, and nobody else counts the rays.
    #[inline]
    fn issue(&mut self, _unit: Unit, _rays: impl FnOnce() -> u32) {}

    /// Reads `N` bytes at `addr`.
    #[inline]
    fn fetch<const N: usize>(&mut self, unit: Unit, addr: HostAddr) -> [u8; N] {
        let mut bytes = [0; N];
        self.read(unit, addr, &mut bytes);
        bytes
    }
}

impl<M: Memory> Memory for &mut M {
    #[inline]
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        (**self).read(unit, addr, bytes);
    }

    #[inline]
    fn issue(&mut self, unit: Unit, rays: impl FnOnce() -> u32) {
        (**self).issue(unit, rays);
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
        fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
            HostMemory::read(&self.0, addr, bytes);
        }

        fn issue(&mut self, _unit: Unit, rays: impl FnOnce() -> u32) {
            self.1 += rays();
        }
    }

    fn a_unit(mut memory: impl Memory) -> [u8; 4] {
        memory.issue(Unit::Traversal, || 5);
        memory.fetch(Unit::Traversal, HostAddr(1))
    }

    #[test]
    fn reference_to_a_memory_does_what_it_does() {
        let mut memory = Flat(vec![1, 2, 3], 0);
        assert_eq!(a_unit(&mut memory), [2, 3, 0, 0]);
        assert_eq!(memory.1, 5);
    }
}
