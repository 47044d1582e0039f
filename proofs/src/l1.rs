//! Theorems of the first-level caches, alone and in front of the virtual memory (L1-1, L1-2).
//!
//! **One witness**, as in [`crate::vm`], and **one step from any consistent state**: a cache of two
//! sets of two ways. Lines of three bytes, so that they are no power of two, as triangles are not.
//! What a set of such a cache does is what the sets of the virtual memory do: it is the same code
//! (`data_set_decides_like_the_set`).

use crate::data_set::data_set;
use crate::draw::{self, BYTES, WORDS};
use crate::source::{Source, Stop};
use crate::vm::{self, Watched};
use crate::{assume, check, check_eq, cover, shown, theorems};
use saarcor_model::data_set::DataSet;
use saarcor_model::l1::L1;
use saarcor_model::memory::{HostMemory, Memory, Port};
use saarcor_model::units::{HostAddr, LineAddr};

const WAYS: usize = 2;
const SETS: usize = 2;
const LINE: usize = 3;

/// The host's memory without a cache.
struct Below(Watched);

impl Memory for Below {
    fn read(&mut self, _port: Port, addr: HostAddr, bytes: &mut [u8]) {
        self.0.read(addr, bytes);
    }
}

/// Line and offset of the watched byte; none before the cached region.
fn place(l1: &L1<WAYS, LINE>, watched: &Watched) -> Option<(LineAddr, usize)> {
    let place = watched.addr.checked_sub(l1.base.0)? as usize;
    Some((LineAddr((place / LINE) as u32), place % LINE))
}

/// Where the watched byte lies in the cache, if it does.
fn cached(l1: &L1<WAYS, LINE>, watched: &Watched) -> Option<(usize, usize, usize)> {
    let (line, offset) = place(l1, watched)?;
    let set = line.0 as usize & (l1.sets.len() - 1);
    let way = l1.sets[set].set.way_of(line)?;
    Some((set, usize::from(way.0), offset))
}

/// Any first-level cache in any consistent state: the watched byte, if it is in it, is right.
///
/// Small scope: three lines a set, from address 0 or 1 on.
fn l1<S: Source, const SETS: usize>(s: &mut S, watched: Option<&Watched>) -> Result<L1<WAYS, LINE>, Stop> {
    let policy = draw::policy(s);
    let base = HostAddr(s.value("base", 0..=u32::MAX, &WORDS[..2]));
    let mut l1 = L1::new(base, SETS, policy);
    for index in 0..SETS {
        let mut set: DataSet<WAYS, LINE> = data_set::<S, WAYS, LINE>(s, policy)?;
        for way in 0..WAYS {
            // Any line of this set, by its upper bits.
            set.set.lines[way] = LineAddr(set.set.lines[way].0.wrapping_mul(SETS as u32) + index as u32);
            set.dirty[way] = false;
        }
        assume!(set.is_valid(policy));
        l1.sets[index] = set;
    }
    if let Some(watched) = watched
        && let Some((set, way, offset)) = cached(&l1, watched)
    {
        l1.sets[set].bytes[way][offset] = watched.byte;
    }
    Ok(l1)
}

/// Any watched byte. Small scope: bytes of lines 0 to 4.
fn watched(s: &mut impl Source) -> Watched {
    let mut watched = vm::watched(s);
    watched.addr = s.value("watched address", 0..=u32::MAX, &[0, 1, 3, 5, 7, 13]);
    watched
}

theorems! { "l1";
    /// Every byte read through a first-level cache is the one that lies behind it, also across its
    /// lines and before its region.
    // Four bytes meet up to three lines of three.
    #["L1-1", unwind 12, covers ["found", "loaded", "before the region", "in the second line"]]
    fn l1_reads_what_lies_behind(s) {
        let watched = watched(s);
        let mut l1 = l1::<S, SETS>(s, Some(&watched))?;
        let back = s.value("bytes before", 0..=3, &WORDS[..4]);
        assume!(watched.addr >= back && watched.addr - back <= u32::MAX - 4);
        let start = HostAddr(watched.addr - back);
        cover!(s, "found", cached(&l1, &watched).is_some());
        cover!(s, "loaded", start.0 >= l1.base.0 && cached(&l1, &watched).is_none());
        cover!(s, "before the region", watched.addr < l1.base.0);
        cover!(s, "in the second line", place(&l1, &watched).is_some_and(|(_, offset)| start.0 >= l1.base.0 && offset < back as usize));
        let state = shown!(l1.clone());
        let mut bytes = [0xff; 4];
        l1.read(&mut Below(watched.clone()), Port::Triangle, start, &mut bytes);
        check_eq!(bytes[back as usize], watched.byte, "byte {back} of 4 at {start:?} through {state:?}");
        if let Some((set, way, offset)) = cached(&l1, &watched) {
            check_eq!(l1.sets[set].bytes[way][offset], watched.byte, "in the cache, 4 bytes at {start:?} through {state:?}");
        }
    }

    /// Reading other bytes changes no byte that the cache holds.
    #["L1-1", unwind 12, covers ["kept", "pushed out"]]
    fn l1_keeps_other_bytes(s) {
        let watched = watched(s);
        let mut l1 = l1::<S, SETS>(s, Some(&watched))?;
        let was_cached = cached(&l1, &watched).is_some();
        assume!(was_cached);
        let addr = draw::addr(s, &[0, 2, 4, 9, 13, 16]);
        let state = shown!(l1.clone());
        l1.read(&mut Below(watched.clone()), Port::Node, addr, &mut [0]);
        cover!(s, "kept", cached(&l1, &watched).is_some());
        cover!(s, "pushed out", cached(&l1, &watched).is_none());
        if let Some((set, way, offset)) = cached(&l1, &watched) {
            check_eq!(l1.sets[set].bytes[way][offset], watched.byte, "byte {} after a read at {addr:?} of {state:?}", watched.addr);
        }
        for set in &l1.sets {
            check!(set.is_valid(l1.policy), "a read at {addr:?} of {state:?}: {l1:?}");
        }
    }

    /// A read counts each line that it meets once: as a hit if it was there, else as a miss.
    #["L1-1", unwind 12, covers ["hit", "miss"]]
    fn l1_counts_each_line(s) {
        let watched = watched(s);
        let mut l1 = l1::<S, SETS>(s, Some(&watched))?;
        assume!(watched.addr >= l1.base.0);
        let hit = cached(&l1, &watched).is_some();
        let state = shown!(l1.clone());
        cover!(s, "hit", hit);
        cover!(s, "miss", !hit);
        l1.read(&mut Below(watched.clone()), Port::List, HostAddr(watched.addr), &mut [0]);
        check_eq!((l1.hits, l1.misses), (u64::from(hit), u64::from(!hit)), "byte {} read from {state:?}", watched.addr);
    }

    /// An invalidation of a range forgets every line of the cache that meets it, and no other.
    #["L1-2", unwind 12, covers ["in the range", "beside it", "before the region"]]
    fn l1_invalidation_forgets_exactly_the_range(s) {
        let mut l1 = l1::<S, SETS>(s, None)?;
        let (addr, len) = (draw::addr(s, &[0, 1, 3, 5, 8]), s.value("bytes", 0..=u64::MAX, &[0, 1, 3, 4, u64::MAX]));
        let state = l1.clone();
        l1.invalidate(addr, len);
        cover!(s, "before the region", addr.0 < l1.base.0);
        let (start, end) = (u64::from(addr.0), u64::from(addr.0).saturating_add(len));
        for set in 0..SETS {
            for way in 0..WAYS {
                let (was, is) = (state.sets[set].set, l1.sets[set].set);
                let first = u64::from(l1.base.0) + u64::from(was.lines[way].0) * LINE as u64;
                let meets = start < end && first < end && start < first + LINE as u64;
                cover!(s, "in the range", was.resident[way] && meets);
                cover!(s, "beside it", was.resident[way] && !meets);
                check_eq!(is.resident[way], was.resident[way] && !meets, "{len} bytes at {addr:?} of {state:?}: set {set} way {way}");
                check_eq!((is.lines[way], is.order), (was.lines[way], was.order), "{len} bytes at {addr:?} of {state:?}: set {set}");
            }
        }
    }

    /// A first-level cache in front of the virtual memory is transparent: every byte read is the
    /// host's, also after the host has written and both levels have forgotten, the virtual memory
    /// first.
    #["L1-2", unwind 12, covers ["in both", "in the first level alone", "in the virtual memory alone", "written"]]
    fn l1_over_virtual_memory_is_transparent(s) {
        let mut memory = vm::memory(s, &WORDS[..2])?;
        let mut l1 = l1::<S, 1>(s, Some(&memory.host))?;
        let in_l1 = cached(&l1, &memory.host).is_some();
        let line = memory.directory.config.geometry.line_of(HostAddr(memory.host.addr));
        let set = memory.directory.config.set_of(line);
        let in_l2 = memory.directory.sets()[set.0 as usize].way_of(line).is_some();
        cover!(s, "in both", in_l1 && in_l2);
        cover!(s, "in the first level alone", in_l1 && !in_l2);
        cover!(s, "in the virtual memory alone", !in_l1 && in_l2);
        let write = draw::flag(s, "write");
        let addr = HostAddr(memory.host.addr);
        if write {
            cover!(s, "written", in_l1 && in_l2);
            memory.host.byte = s.value("byte written", 0..=u8::MAX, &BYTES[2..3]);
            memory.invalidate(addr, 1);
            l1.invalidate(addr, 1);
        }
        let state = shown!((l1.clone(), memory.clone()));
        let mut byte = [0xff];
        l1.read(&mut memory, Port::Shading, addr, &mut byte);
        check_eq!(byte[0], memory.host.byte, "{addr:?}, write: {write}, through {state:?}");
    }
}
