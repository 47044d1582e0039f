//! The memory interface of §2: how every unit reads, whatever lies behind, and who watches it.

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
    /// All units, each at its own number.
    pub const ALL: [Self; 4] = [Self::Shading, Self::Traversal, Self::List, Self::Intersection];
}

/// What a unit reads from: the whole scene, the virtual memory, or caches in front of either.
///
/// Transparency (VM-9) means that the bytes are the host's, whatever lies between.
pub trait Memory {
    /// Reads `bytes.len()` bytes at `addr`. Bytes beyond the end of host memory are zero.
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]);

    /// Reads `N` bytes at `addr`.
    fn fetch<const N: usize>(&mut self, unit: Unit, addr: HostAddr) -> [u8; N]
    where
        Self: Sized,
    {
        let mut bytes = [0; N];
        self.read(unit, addr, &mut bytes);
        bytes
    }
}

impl<M: Memory + ?Sized> Memory for &mut M {
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        (**self).read(unit, addr, bytes);
    }
}

/// The memory of the PC as the bus sees it.
pub trait HostMemory {
    /// Reads `bytes.len()` bytes at `addr`. Bytes beyond the end are zero.
    fn read(&self, addr: HostAddr, bytes: &mut [u8]);
}

impl<T: AsRef<[u8]>> HostMemory for T {
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

/// The memory of a chip without virtual memory: the whole scene lies in on-board memory, each byte
/// at its host address (§3: what the chip had before).
#[derive(Clone, Copy, Debug)]
pub struct WholeScene<H>(pub H);

impl<H: HostMemory> Memory for WholeScene<H> {
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        self.0.read(addr, bytes);
    }
}

/// What watches the units at work: a recorder, a counter, a debugger. It changes nothing.
///
/// An operation is what a unit does for a packet at once. What the unit reads before the next
/// operation begins belongs to it.
pub trait Observer {
    /// An operation of `unit` begins, in which `rays` rays take part.
    fn operation(&mut self, _unit: Unit, _rays: u32) {}

    /// `unit` reads `bytes` bytes at `addr`.
    fn read(&mut self, _unit: Unit, _addr: HostAddr, _bytes: usize) {}
}

/// Nobody watches.
impl Observer for () {}

impl<O: Observer + ?Sized> Observer for &mut O {
    fn operation(&mut self, unit: Unit, rays: u32) {
        (**self).operation(unit, rays);
    }

    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: usize) {
        (**self).read(unit, addr, bytes);
    }
}

/// What the units work on: a memory, and an observer of what they do with it.
#[derive(Clone, Copy, Debug)]
pub struct Observed<M, O = ()> {
    /// Where the bytes come from.
    pub memory: M,
    /// Who watches.
    pub observer: O,
}

impl<M: Memory> Observed<M> {
    /// A memory that nobody watches.
    pub fn by_nobody(memory: M) -> Self {
        Self { memory, observer: () }
    }
}

impl<M: Memory, O: Observer> Observed<M, O> {
    /// An operation of `unit` begins, in which `rays` rays take part.
    pub fn operation(&mut self, unit: Unit, rays: u32) {
        self.observer.operation(unit, rays);
    }

    /// Reads `bytes.len()` bytes at `addr`.
    pub fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        self.observer.read(unit, addr, bytes.len());
        self.memory.read(unit, addr, bytes);
    }

    /// Reads `N` bytes at `addr`.
    pub fn fetch<const N: usize>(&mut self, unit: Unit, addr: HostAddr) -> [u8; N] {
        self.observer.read(unit, addr, N);
        self.memory.fetch(unit, addr)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes down all it sees.
    #[derive(Default)]
    struct Log(Vec<(Unit, u32, usize)>);

    impl Observer for Log {
        fn operation(&mut self, unit: Unit, rays: u32) {
            self.0.push((unit, rays, 0));
        }

        fn read(&mut self, unit: Unit, addr: HostAddr, bytes: usize) {
            self.0.push((unit, addr.0, bytes));
        }
    }

    fn a_unit<M: Memory, O: Observer>(memory: &mut Observed<M, O>) -> [u8; 4] {
        memory.operation(Unit::Traversal, 5);
        memory.fetch(Unit::Traversal, HostAddr(1))
    }

    #[test]
    fn bytes_beyond_the_end_are_zero() {
        assert_eq!(a_unit(&mut Observed::by_nobody(WholeScene([1, 2, 3]))), [2, 3, 0, 0]);
        assert_eq!(a_unit(&mut Observed::by_nobody(WholeScene([]))), [0; 4]);
    }

    #[test]
    fn an_observer_sees_what_the_units_do() {
        let (mut scene, mut log) = (WholeScene(vec![1, 2, 3]), Log::default());
        // Behind references that hide the types, too.
        let (memory, observer): (&mut dyn Memory, &mut dyn Observer) = (&mut scene, &mut log);
        assert_eq!(a_unit(&mut Observed { memory, observer }), [2, 3, 0, 0]);
        assert_eq!(log.0, [(Unit::Traversal, 5, 0), (Unit::Traversal, 1, 4)]);
    }
}
