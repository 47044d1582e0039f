//! Theorems of the virtual memory: the bytes that are read are the host's (VM-6, VM-8 to VM-10).
//!
//! **One witness.** One arbitrary byte of the host is watched, and one word remembers what it
//! holds; of the rest of the host nothing is known. What holds of an arbitrary byte holds of all.
//!
//! **One step from any consistent state** is one of flat memory: `refinement::memory`, whose theorems say that
//! reads, writes and invalidations answer and leave what it does. The card here is that of the theorems of the
//! [directory](super::directory).

use super::directory::{LINE, SETS, WAYS, addr, counters, directory};
use crate::draw::{self, BYTES, ENDS, WORDS};
use crate::source::{Source, Stop};
use crate::{check_eq, cover, shown, theorems};
use saarcor_model::vm::{
    CacheConfig, Directory, Hash, HostAddr, HostMemory, Outcome, Policy, VirtualMemory, Way,
};
use std::cell::Cell;

/// Host memory of which one byte is known, and what went over the bus.
#[derive(Clone, Debug)]
pub struct Watched {
    /// Address of the byte.
    pub addr: u32,
    /// The byte.
    pub byte: u8,
    /// What every other byte reads as.
    pub other: u8,
    /// Reads.
    pub reads: Cell<u32>,
    /// Bytes read.
    pub moved: Cell<usize>,
}

impl HostMemory for Watched {
    fn read(&self, addr: HostAddr, bytes: &mut [u8]) {
        self.reads.set(self.reads.get() + 1);
        self.moved.set(self.moved.get() + bytes.len());
        for i in 0..bytes.len() {
            bytes[i] = match addr.0.checked_add(i as u32) {
                Some(at) if at == self.addr => self.byte,
                Some(_) => self.other,
                // Beyond the end.
                None => 0,
            };
        }
    }
}

/// Any watched byte. Small scope: the bytes of lines 0, 1, 2 and 5.
pub fn watched(s: &mut impl Source) -> Watched {
    let addr = s.value("watched address", 0..=u32::MAX, &[0, 3, 4, 11]);
    watched_at(s, HostAddr(addr))
}

/// The watched byte of that address, with any value.
pub fn watched_at(s: &mut impl Source, addr: HostAddr) -> Watched {
    Watched {
        addr: addr.0,
        byte: s.value("watched byte", 0..=u8::MAX, &BYTES[1..2]),
        other: s.value("other bytes", 0..=u8::MAX, &BYTES[..1]),
        reads: Cell::new(0),
        moved: Cell::new(0),
    }
}

/// Where the watched byte lies on the card, if it does.
fn on_card<const WAYS: usize>(memory: &VirtualMemory<Watched, WAYS>) -> Option<usize> {
    let config = memory.directory.config;
    let addr = HostAddr(memory.host.addr);
    let (line, set) = (config.geometry.line_of(addr), config.set_of(config.geometry.line_of(addr)));
    let way: Way = memory.directory.sets()[set.0 as usize].way_of(line)?;
    Some(config.geometry.card_addr(set, way).0 as usize + config.geometry.offset_of(addr) as usize)
}

/// Any virtual memory in any consistent state: the watched byte, if it is on the card, is right
/// there. Small scope: the lines of `small`.
pub fn memory<S: Source, const WAYS: usize, const SETS: usize>(
    s: &mut S,
    small: &'static [u32],
) -> Result<VirtualMemory<Watched, WAYS>, Stop> {
    let directory = directory::<S, WAYS, SETS>(s, small)?;
    let host = watched(s);
    let bytes: [u8; 8] = s.value("bytes on the card", 0..=u64::MAX, &[0]).to_le_bytes();
    let mut memory = VirtualMemory { directory, card: bytes[..WAYS * SETS * LINE].to_vec(), host };
    if let Some(place) = on_card(&memory) {
        memory.card[place] = memory.host.byte;
    }
    Ok(memory)
}

theorems! {
    /// Each miss moves exactly one line over the bus, from its first byte on; a hit moves none.
    #["VM-6", unwind 5, covers ["hit", "miss"]]
    fn miss_moves_one_line_and_hit_none(s) {
        let mut memory = memory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        let addr = addr(s);
        let state = shown!(memory.clone());
        let mut byte = [0];
        let outcome = memory.read_in_line(addr, &mut byte);
        let expected = match outcome {
            Outcome::Hit { .. } => (0, 0),
            Outcome::Miss { .. } => (1, LINE),
        };
        cover!(s, "hit", expected.0 == 0);
        cover!(s, "miss", expected.0 == 1);
        check_eq!((memory.host.reads.get(), memory.host.moved.get()), expected, "reads and bytes of {addr:?} from {state:?}");
    }

    /// After a flush no line is resident and the sets are as in a new cache; the counters keep their
    /// values.
    #["VM-8", unwind 5, covers ["lines were resident"]]
    fn flush_forgets_all(s) {
        let mut memory = memory::<S, WAYS, SETS>(s, &WORDS[..6])?;
        memory.directory.counters = counters(s);
        let before = memory.directory.clone();
        cover!(s, "lines were resident", before.sets()[1].resident[1]);
        memory.flush();
        let new = Directory::<WAYS>::new(before.config);
        check_eq!(memory.directory.sets(), new.sets(), "flush of {before:?}");
        check_eq!(memory.directory.counters, before.counters, "counters after the flush of {before:?}");
    }

    /// In lines of any size up to 32 KB a byte read is the host's, when its line is loaded and when it is there already,
    /// wherever in the line it lies.
    #["VM-9", not_for_kani "lines of 32 KB are too long for it; offset and place on the card are theorems of the geometry", covers ["a line of 32 KB", "the last byte of a line", "the second way"]]
    fn bytes_lie_at_their_offsets_in_lines_of_any_size(s) {
        let line = s.value("log2 line", 0..=15, &WORDS[..16]);
        let geometry = draw::of_logarithms(1, line, s.value("log2 sets", 0..=1, &WORDS[..2]))?;
        let config = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
        let mut host = watched(s);
        host.addr = s.value("watched address", 0..=u32::MAX, &ENDS);
        let mut memory = VirtualMemory::new(Directory::<2>::new(config), host);
        if draw::flag(s, "another line first") {
            memory.read_in_line(draw::addr(s, &ENDS), &mut []);
        }
        let addr = HostAddr(memory.host.addr);
        for _ in 0..2 {
            let mut byte = [0xff];
            let outcome = memory.read_in_line(addr, &mut byte);
            cover!(s, "a line of 32 KB", line == 15);
            cover!(s, "the last byte of a line", line > 0 && u64::from(geometry.offset_of(addr)) == geometry.line().0 - 1);
            cover!(s, "the second way", outcome.way() == Way(1));
            check_eq!(byte[0], memory.host.byte, "{geometry:?}: {addr:?}, {outcome:?}");
        }
    }
}
