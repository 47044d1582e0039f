//! Theorems of the memory interface (VM-9, VM-10): what a unit reads of the host's memory, with the
//! whole scene on the card, and under the eyes of an observer.

use crate::draw::{BYTES, WORDS};
use crate::source::Source;
use crate::{check_eq, cover, theorems};
use saarcor_model::vm::{HostAddr, HostMemory, Memory, Observed, Observer, Unit, WholeScene};

/// Addresses of a small memory and just behind it, and far behind it such whose lower bits are those of its bytes.
static ADDRS: [u32; 14] =
    [0, 1, 2, 3, 4, 5, 1 << 8, 1 << 16, 1 << 20, 1 << 24, 1 << 30, 1 << 31, u32::MAX - 1, u32::MAX];

/// A host memory of 0 to 4 bytes: the bytes, and how many of them there are.
fn host(s: &mut impl Source) -> ([u8; 4], usize) {
    let bytes = s.value("bytes of the host", 1..=u32::MAX, &[0x0403_0201]).to_le_bytes();
    (bytes, usize::from(s.value("size of the host's memory", 0..=4, &BYTES[..5])))
}

/// What an observer saw last, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seen {
    operations: u32,
    reads: u32,
    last: Option<(Unit, u32, usize)>,
}

impl Observer for Seen {
    fn operation(&mut self, unit: Unit, rays: u32) {
        self.operations += 1;
        self.last = Some((unit, rays, 0));
    }

    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: usize) {
        self.reads += 1;
        self.last = Some((unit, addr.0, bytes));
    }
}

theorems! {
    /// A byte of the host's memory is read as it is, and a byte beyond its end as zero.
    #["VM-10", unwind 6, covers ["inside", "the first beyond the end", "no memory", "far beyond"]]
    fn bytes_beyond_the_end_are_zero(s) {
        let (bytes, size) = host(s);
        let addr = s.value("address", 0..=u32::MAX, &ADDRS);
        let place = usize::from(s.value("place", 0..=2, &BYTES[..3]));
        let mut read = [0xff; 3];
        HostMemory::read(&&bytes[..size], HostAddr(addr), &mut read);
        let at = u64::from(addr) + place as u64;
        let expected = if at < size as u64 { bytes[at as usize] } else { 0 };
        cover!(s, "inside", at < size as u64);
        cover!(s, "the first beyond the end", at == size as u64 && place > 0);
        cover!(s, "no memory", size == 0);
        cover!(s, "far beyond", addr == u32::MAX);
        check_eq!(read[place], expected, "byte {place} of 3 at {addr} of {size} bytes");
    }

    /// Without virtual memory, every unit reads each byte at its host address.
    #["VM-9", unwind 6, covers ["shading", "intersection", "beyond the end"]]
    fn whole_scene_is_the_hosts_memory(s) {
        let (bytes, size) = host(s);
        let unit = unit(s);
        let addr = s.value("address", 0..=u32::MAX, &ADDRS);
        let mut expected = [0xff; 2];
        HostMemory::read(&&bytes[..size], HostAddr(addr), &mut expected);
        cover!(s, "shading", unit == Unit::Shading);
        cover!(s, "intersection", unit == Unit::Intersection);
        cover!(s, "beyond the end", u64::from(addr) >= size as u64);
        let mut scene = WholeScene(&bytes[..size]);
        check_eq!(scene.fetch::<2>(unit, HostAddr(addr)), expected, "2 bytes at {addr} of {size} bytes");
    }

    /// An observer changes no byte that is read, and sees each read and each operation once, with its
    /// unit, its address and its number of bytes or rays.
    #["CH-1", unwind 6, covers ["a fetch", "a read", "an operation"]]
    fn observer_sees_all_and_changes_nothing(s) {
        let (bytes, size) = host(s);
        let unit = unit(s);
        let addr = s.value("address", 0..=u32::MAX, &WORDS[..6]);
        let observer = Seen { operations: 0, reads: 0, last: None };
        let mut seen = Observed { memory: WholeScene(&bytes[..size]), observer };
        let expected = seen.memory.fetch::<2>(unit, HostAddr(addr));
        let kind = s.value("kind (fetch, read, operation)", 0..=2, &BYTES[..3]);
        let mut read = [0xff; 2];
        match kind {
            0 => read = seen.fetch(unit, HostAddr(addr)),
            1 => seen.read(unit, HostAddr(addr), &mut read),
            _ => seen.operation(unit, addr),
        }
        cover!(s, "a fetch", kind == 0);
        cover!(s, "a read", kind == 1);
        cover!(s, "an operation", kind == 2);
        let operations = u32::from(kind == 2);
        let last = Some((unit, addr, if kind == 2 { 0 } else { 2 }));
        check_eq!(seen.observer, Seen { operations, reads: 1 - operations, last }, "kind {kind} of {unit:?} at {addr}");
        if kind != 2 {
            check_eq!(read, expected, "kind {kind} of {unit:?} at {addr} of {size} bytes");
        }
    }
}

/// Any unit.
pub fn unit(s: &mut impl Source) -> Unit {
    let number = s.value("unit (shading, traversal, list, intersection)", 0..=3, &BYTES[..4]);
    Unit::ALL[usize::from(number)]
}
