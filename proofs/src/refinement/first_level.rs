//! The first-level caches are flat memory, over whatever lies behind them: [`Flat`], at one arbitrary byte.
//!
//! A first-level cache is consistent if it holds the host's byte wherever it holds its line. One cache is
//! judged over flat memory itself, and the four of a chip over a virtual memory of either version: there a
//! host write reaches the virtual memory first, and the caches after it (L1-2).

use super::directory::Held;
use super::draw::{self, Around};
use super::machine::{Answer, Machine, Simulation, begin, step_from_any};
use super::memory::{Ask, Card, Flat, Got, Host, IsFlat, bytes_agree, consistent, state};
use crate::draw::{self as parts, BYTES, WORDS};
use crate::source::{Holds, Source, Stop};
use crate::vm::virtual_memory::{Watched, watched_at};
use crate::{assume, cover, theorems};
use saarcor_model::vm::{
    CacheConfig, CachedMetadata, DataSet, FirstLevel, FirstLevelCaches, HostAddr, LineAddr, Memory, OnChip,
    Policy, Unit, VirtualMemory, WholeScene,
};
use std::marker::PhantomData;

/// Bytes of a read through one cache. Kani's lines have two: a third line takes its solver minutes, and is a matter of
/// `l1_reads_are_made_of_its_lines`.
const READ: usize = if cfg!(kani) { 2 } else { 4 };

/// A first-level cache and the memory behind it.
#[derive(Clone, Debug)]
pub struct OneCache<const WAYS: usize, const LINE: usize, H> {
    /// The cache.
    pub cache: FirstLevel<WAYS, [u8; LINE]>,
    /// Flat memory.
    pub behind: WholeScene<H>,
}

impl<const WAYS: usize, const LINE: usize, H: Host> Machine for OneCache<WAYS, LINE, H> {
    type Request = Ask;
    type Answer = Got;

    fn step(&mut self, ask: &Ask) -> Got {
        let mut got = Got { bytes: [0xff; 4], outcome: None };
        match *ask {
            Ask::ReadByte(addr) => self.cache.read(&mut self.behind, Unit::List, addr, &mut got.bytes[..1]),
            Ask::Read(addr) => self.cache.read(&mut self.behind, Unit::List, addr, &mut got.bytes[..READ]),
            Ask::Write(addr, len, _) | Ask::Invalidate(addr, len) => {
                if let Ask::Write(.., byte) = *ask {
                    self.behind.0.write(addr, len, byte);
                }
                self.cache.invalidate(addr, len);
            }
            // There is nothing to flush: whoever flushes the virtual memory changes no byte.
            Ask::Flush => {}
        }
        got
    }
}

/// Line and offset of a byte; none before the cached region.
fn place<const WAYS: usize, const LINE: usize>(
    cache: &FirstLevel<WAYS, [u8; LINE]>,
    addr: HostAddr,
) -> Option<(LineAddr, usize)> {
    let place = addr.0.checked_sub(cache.base.0)?;
    Some((LineAddr(place / LINE as u32), place as usize % LINE))
}

/// Whether the byte is right wherever the cache holds it, and its set is legal.
fn right<const WAYS: usize, const LINE: usize>(cache: &FirstLevel<WAYS, [u8; LINE]>, flat: &Flat) -> bool {
    let Some((line, offset)) = place(cache, flat.addr) else { return true };
    let set = cache.sets[cache.set_of(line).0 as usize];
    let mut right = set.is_valid(cache.policy);
    for way in 0..WAYS {
        let there = set.set.resident[way] && set.set.lines[way] == line;
        right &= !set.dirty[way] && (!there || set.contents[way][offset] == flat.byte);
    }
    right
}

/// A first-level cache over flat memory is flat memory.
#[derive(Clone, Copy, Debug)]
pub struct OneIsFlat<const WAYS: usize, const LINE: usize, H>(PhantomData<H>);

impl<const WAYS: usize, const LINE: usize, H: Host> Simulation for OneIsFlat<WAYS, LINE, H> {
    type Concrete = OneCache<WAYS, LINE, H>;
    type Abstract = Flat;

    fn related(one: &Self::Concrete, flat: &Flat) -> bool {
        one.behind.0.byte(flat.addr) == flat.byte && right(&one.cache, flat)
    }

    fn asked(ask: &Ask, _: &Got, _: &Self::Concrete, _: &Flat) -> Ask {
        *ask
    }

    fn agree(got: &Got, known: &Answer<Flat>) -> bool {
        let mut of_read = [None; 4];
        of_read[..READ].copy_from_slice(&known[..READ]);
        bytes_agree(got, &of_read)
    }
}

/// What the caches of a chip are asked, by which unit.
pub type AskOfUnit = (Unit, Ask);

impl<H: Host, const WAYS: usize, M: Held<WAYS>> Machine for FirstLevelCaches<VirtualMemory<H, WAYS, M>> {
    type Request = AskOfUnit;
    type Answer = Got;

    fn step(&mut self, &(unit, ask): &AskOfUnit) -> Got {
        let mut got = Got { bytes: [0xff; 4], outcome: None };
        match ask {
            Ask::ReadByte(addr) => self.read(unit, addr, &mut got.bytes[..1]),
            Ask::Read(addr) => self.read(unit, addr, &mut got.bytes),
            Ask::Write(addr, len, byte) => {
                self.below.host.write(addr, len, byte);
                self.below.invalidate(addr, len);
                self.invalidate(addr, len);
            }
            Ask::Invalidate(addr, len) => {
                self.below.invalidate(addr, len);
                self.invalidate(addr, len);
            }
            Ask::Flush => self.below.flush(),
        }
        got
    }
}

/// The first-level caches of a chip over the virtual memory are flat memory.
#[derive(Clone, Copy, Debug)]
pub struct ChipIsFlat<H, const WAYS: usize, M>(PhantomData<(H, M)>);

impl<H: Host, const WAYS: usize, M: Held<WAYS>> Simulation for ChipIsFlat<H, WAYS, M> {
    type Concrete = FirstLevelCaches<VirtualMemory<H, WAYS, M>>;
    type Abstract = Flat;

    fn related(chip: &Self::Concrete, flat: &Flat) -> bool {
        chip.below.host.byte(flat.addr) == flat.byte
            && consistent(&chip.below, flat)
            && right(&chip.shading, flat)
            && right(&chip.nodes, flat)
            && right(&chip.lists, flat)
            && right(&chip.triangles, flat)
    }

    fn asked((_, ask): &AskOfUnit, _: &Got, _: &Self::Concrete, _: &Flat) -> Ask {
        *ask
    }

    fn agree(got: &Got, known: &Answer<Flat>) -> bool {
        bytes_agree(got, known)
    }
}

/// Any legal set at the place of the watched byte, in which the byte is right; all other sets are empty.
///
/// Small scope: the first way is as `first` says, free (0) or with the watched line (1).
fn fill<S: Source, const WAYS: usize, const LINE: usize>(
    s: &mut S,
    cache: &mut FirstLevel<WAYS, [u8; LINE]>,
    flat: &Flat,
    first: &'static [u8],
) -> Result<(), Stop> {
    let Some((line, offset)) = place(cache, flat.addr) else { return Ok(()) };
    let (policy, sets) = (cache.policy, cache.sets.len() as u32);
    let index = cache.set_of(line).0;
    let mut set = DataSet::empty(policy, [0; LINE]);
    for way in 0..WAYS {
        // The watched line, or another of this set.
        let small = if way == 0 { first } else { &BYTES[..1] };
        match s.value("way (free, the watched line, another)", 0..=2, small) {
            0 => {}
            1 => {
                (set.set.resident[way], set.set.lines[way]) = (true, line);
                set.contents[way][offset] = flat.byte;
            }
            _ => {
                let upper = s.value("upper bits of a line", 0..=u32::MAX, parts::words(way, 1));
                let other = LineAddr(upper.wrapping_mul(sets) + index);
                assume!(other != line);
                (set.set.resident[way], set.set.lines[way]) = (true, other);
            }
        }
    }
    if WAYS <= 2 {
        set.set.order = parts::order(s, policy);
    }
    assume!(set.is_valid(policy));
    cache.sets[index as usize] = set;
    Ok(())
}

/// Any request at an address; to Kani none of one byte, and no flush.
fn ask(s: &mut impl Source, addr: HostAddr) -> Ask {
    let (requests, small) = if cfg!(kani) { (1..=3, &BYTES[1..4]) } else { (0..=4, &BYTES[..5]) };
    match s.value("request (byte, bytes, write, invalidate, flush)", requests, small) {
        0 => Ask::ReadByte(addr),
        1 => Ask::Read(addr),
        2 => Ask::Write(addr, s.value("bytes", 0..=u64::MAX, &[1, u64::MAX]), 2),
        3 => Ask::Invalidate(addr, s.value("bytes", 0..=u64::MAX, &[2])),
        _ => Ask::Flush,
    }
}

/// The watched byte, bytes before it, and others.
fn addr(s: &mut impl Source, flat: &Flat) -> HostAddr {
    match s.value("at (the watched byte, before it, another)", 0..=2, &BYTES[..3]) {
        0 => flat.addr,
        1 => HostAddr(flat.addr.0.wrapping_sub(s.value("bytes before", 1..=3, &[1, 3]))),
        _ => parts::addr(s, &[70]),
    }
}

fn chip_begins<S: Source, M: Held<1>>(s: &mut S, config: CacheConfig, around: Around, metadata: M) -> Holds {
    let (memory, card) = state::<S, 1, M>(s, config, around, metadata)?;
    let memory = VirtualMemory::new(memory.directory, memory.host);
    begin::<IsFlat<Watched, 1, M>>(&memory, &Card { place: None, ..card })?;
    let chip = FirstLevelCaches::new([1, 2, 4, 8], config.policy, HostAddr(0), memory);
    begin::<ChipIsFlat<Watched, 1, M>>(&chip, &card.flat)
}

fn chip_step<S: Source, const WAYS: usize, M: Held<WAYS>>(
    s: &mut S,
    below: VirtualMemory<Watched, WAYS, M>,
    mut flat: Flat,
) -> Holds {
    let policy = below.directory.config.policy;
    // From address 1 on a line begins at the watched byte, and the byte before it is in another.
    let base = HostAddr(s.value("base of triangles", 0..=u32::MAX, &WORDS[..2]));
    let sets = 1 << s.value("log2 sets of a first-level cache", 0..=8, &WORDS[1..2]);
    let mut chip = FirstLevelCaches::new([sets; 4], policy, base, below);
    let unit = crate::vm::memory::unit(s);
    // The caches of the other units hold the line.
    let first = |of| if unit == of { &BYTES[..2] } else { &BYTES[1..2] };
    fill(s, &mut chip.shading, &flat, first(Unit::Shading))?;
    fill(s, &mut chip.nodes, &flat, first(Unit::Traversal))?;
    fill(s, &mut chip.lists, &flat, first(Unit::List))?;
    fill(s, &mut chip.triangles, &flat, first(Unit::Intersection))?;
    let addr = addr(s, &flat);
    let ask = ask(s, addr);
    let byte = flat.byte;
    step_from_any::<ChipIsFlat<Watched, WAYS, M>>(&mut chip, &mut flat, &(unit, ask))?;
    cover!(s, "read", matches!(ask, Ask::Read(_)));
    cover!(s, "written", flat.byte != byte);
    cover!(s, "flushed", matches!(ask, Ask::Flush));
    Ok(())
}

fn first_level_step<S: Source, const WAYS: usize, const LINE: usize>(s: &mut S) -> Holds {
    s.size("ways", WAYS);
    s.size("bytes a line", LINE);
    s.size("bytes of a read", READ);
    let addr = parts::addr(s, &[0, 1, 4, u32::MAX]);
    let host = watched_at(s, addr);
    let mut flat = Flat { addr, byte: host.byte };
    let base = HostAddr(s.value("base", 0..=u32::MAX, &[0, 1, u32::MAX]));
    let sets = 1 << if cfg!(kani) { 0 } else { s.value("log2 sets", 0..=8, &WORDS[1..2]) };
    // A single way leaves a policy nothing to choose.
    let policy = if cfg!(kani) { Policy::Lru } else { parts::policy(s) };
    let mut cache = FirstLevel::<WAYS, [u8; LINE]>::new(base, sets, policy);
    fill(s, &mut cache, &flat, &BYTES[..2])?;
    let mut one = OneCache { cache, behind: WholeScene(host) };
    let from = if cfg!(kani) {
        parts::addr(s, &[0, 1, u32::MAX])
    } else if parts::flag(s, "at the end of the address space") {
        HostAddr(u32::MAX - s.value("bytes left", 0..=3, &WORDS[..2]))
    } else {
        self::addr(s, &flat)
    };
    let ask = ask(s, from);
    let byte = flat.byte;
    step_from_any::<OneIsFlat<WAYS, LINE, Watched>>(&mut one, &mut flat, &ask)?;
    if let Ask::Read(from) = ask {
        let beyond = place(&one.cache, addr).is_some_and(|(_, offset)| offset == 0);
        cover!(s, "in the second line", beyond && from >= base && addr.0.wrapping_sub(from.0) == 1);
        cover!(s, "before the region", from < base && addr >= from);
        cover!(s, "beyond the end", from.0 > u32::MAX - (READ as u32 - 1));
    }
    cover!(s, "written", flat.byte != byte);
    Ok(())
}

theorems! {
    /// From any consistent state a first-level cache over flat memory is flat memory: reads across lines,
    /// before the cached region and beyond the end of the address space, host writes with their invalidation,
    /// and invalidations answer and leave what flat memory does.
    // Kani takes lines of two bytes: over a division by three its solver sits for a minute.
    #["L1-1", unwind 6, covers ["in the second line", "before the region", "beyond the end", "written"]]
    fn first_level_cache_steps_as_flat_memory(s) {
        match if cfg!(kani) { 2 } else { s.value("bytes a line (3, 1)", 0..=1, &BYTES[..2]) } {
            #[cfg(not(kani))]
            0 => first_level_step::<S, 2, 3>(s)?,
            // Of these a read meets four.
            #[cfg(not(kani))]
            1 => first_level_step::<S, 2, 1>(s)?,
            _ => first_level_step::<S, 1, 2>(s)?,
        }
    }

    /// From any consistent state the four first-level caches of a chip over a virtual memory, of version A or
    /// B, are flat memory: whatever unit reads, whatever range the host writes, whatever is forgotten or
    /// flushed, the bytes are the host's.
    #["L1-2", not_for_kani "lines of 64 bytes take it too long", covers ["read", "written", "flushed"]]
    fn chip_steps_as_flat_memory(s) {
        let config = draw::config::<S, 1>(s)?;
        let around = draw::around(s, &config);
        if parts::flag(s, "version B") {
            let metadata = draw::version_b::<S, 1, 1, 4>(s, &config, around, 2)?;
            let (below, card) = state(s, config, around, metadata)?;
            chip_step(s, below, card.flat)?;
        } else {
            let metadata = draw::version_a::<S, 1>(s, &config, around)?;
            let (below, card) = state(s, config, around, metadata)?;
            chip_step(s, below, card.flat)?;
        }
    }

    /// New first-level caches and a new card, of version A or B, hold no line: every run begins as flat memory.
    #["VM-9", not_for_kani "lines of 64 bytes take it too long", covers ["version A", "version B"]]
    fn runs_begin_as_flat_memory(s) {
        let config = draw::config::<S, 1>(s)?;
        let around = draw::around(s, &config);
        if parts::flag(s, "version B") {
            cover!(s, "version B", true);
            chip_begins(s, config, around, CachedMetadata::<1, 1, 8>::new(&config, 2, Policy::Lru))?;
        } else {
            cover!(s, "version A", true);
            chip_begins(s, config, around, OnChip::new(config.geometry.sets(), config.policy))?;
        }
    }
}
