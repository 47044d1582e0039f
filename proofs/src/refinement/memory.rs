//! The virtual memory is flat memory; and what it holds lies where it says.
//!
//! **Two abstract machines**, seen at one arbitrary byte: what holds of it holds of all. [`Flat`] is host
//! memory alone. [`Card`] knows beside it whether the byte's line is resident, and in which place. Which line
//! makes room is for the policy to decide, so `Card` is asked with the place that the cache chose, and says
//! whether it was free to: a line that is not used may leave, but neither come nor move; a line that is used
//! is found where it was, or else comes to its own set.
//!
//! Every step keeps the card consistent with the host: reads, writes followed by the invalidation of what was
//! written, invalidations by themselves, and flushes.

use super::directory::Held;
use super::draw::{self, Around};
use super::machine::{Answer, Machine, Simulation, step_from_any};
use crate::draw::{self as parts, BYTES, WORDS};
use crate::source::{Holds, Source, Stop};
use crate::vm::virtual_memory::{Watched, watched_at};
use crate::{assume, cover, theorems};
use saarcor_model::vm::{
    CacheConfig, Directory, HostAddr, HostMemory, Memory, Outcome, SetIndex, Unit, VirtualMemory, Way,
};
use std::marker::PhantomData;

/// What a memory is asked.
#[derive(Clone, Copy, Debug)]
pub enum Ask {
    /// A byte is read, by an access that says whether it hit.
    ReadByte(HostAddr),
    /// Four bytes are read, in however many lines they lie.
    Read(HostAddr),
    /// The host writes one value to each byte of a range, and then says so.
    Write(HostAddr, u64, u8),
    /// The host says that it has written a range, and has not.
    Invalidate(HostAddr, u64),
    /// All lines are forgotten.
    Flush,
}

impl Ask {
    /// The bytes that a read has.
    fn bytes_read(self) -> (HostAddr, usize) {
        match self {
            Self::ReadByte(addr) => (addr, 1),
            Self::Read(addr) => (addr, 4),
            Self::Write(addr, ..) | Self::Invalidate(addr, _) => (addr, 0),
            Self::Flush => (HostAddr(0), 0),
        }
    }
}

/// What a memory answers: the bytes read, and how the access ended, where one alone was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Got {
    /// The bytes of a read; 0xff behind them.
    pub bytes: [u8; 4],
    /// The outcome of [`Ask::ReadByte`].
    pub outcome: Option<Outcome>,
}

/// Whether a range has the byte at `addr`.
fn has(addr: HostAddr, begin: HostAddr, len: u64) -> bool {
    addr >= begin && u64::from(addr.0 - begin.0) < len
}

/// Flat memory, seen at one byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flat {
    /// Which byte.
    pub addr: HostAddr,
    /// What it holds.
    pub byte: u8,
}

impl Machine for Flat {
    type Request = Ask;
    /// The bytes of a read, as far as they are known: the watched one, and those beyond the end.
    type Answer = [Option<u8>; 4];

    fn step(&mut self, ask: &Ask) -> [Option<u8>; 4] {
        if let Ask::Write(addr, len, byte) = *ask
            && has(self.addr, addr, len)
        {
            self.byte = byte;
        }
        let (addr, count) = ask.bytes_read();
        let mut known = [None; 4];
        for i in 0..4 {
            if i < count {
                known[i] = match addr.0.checked_add(i as u32) {
                    None => Some(0),
                    Some(at) => (at == self.addr.0).then_some(self.byte),
                };
            }
        }
        known
    }
}

/// Whether the bytes that were read are those that are known.
pub(super) fn bytes_agree(got: &Got, known: &[Option<u8>; 4]) -> bool {
    let mut agree = true;
    for i in 0..4 {
        agree &= known[i].is_none_or(|byte| byte == got.bytes[i]);
    }
    agree
}

/// Where a line lies on the card.
pub type Place = (SetIndex, Way);

/// Flat memory behind a card, seen at one byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Card {
    /// The cache.
    pub config: CacheConfig,
    /// The host's memory.
    pub flat: Flat,
    /// Where the byte's line lies, if it is resident.
    pub place: Option<Place>,
}

/// What [`Card`] answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CardSays {
    /// The bytes of a read, as far as they are known.
    pub known: [Option<u8>; 4],
    /// Whether an access that was made alone hit, where it was to the line of the watched byte.
    pub hit: Option<bool>,
    /// Whether the line may lie in the chosen place now.
    pub allowed: bool,
}

impl Machine for Card {
    /// What is asked, and where the watched byte's line lies afterwards.
    type Request = (Ask, Option<Place>);
    type Answer = CardSays;

    fn step(&mut self, &(ask, now): &Self::Request) -> CardSays {
        let (before, geometry) = (self.place, self.config.geometry);
        let known = self.flat.step(&ask);
        let line = geometry.line_of(self.flat.addr);
        let (addr, count) = ask.bytes_read();
        // The line is used if its bytes and those read overlap.
        let first = u64::from(geometry.first_byte(line).0);
        let begin = u64::from(addr.0);
        let used = begin < first + geometry.line().0 && first < begin + count as u64;
        let own_set = now
            .is_none_or(|(set, way)| set == self.config.set_of(line) && u32::from(way.0) < geometry.ways());
        let (hit, allowed) = match ask {
            // An access alone: found where it was, or loaded.
            Ask::ReadByte(_) if used => {
                (Some(before.is_some()), now.is_some() && (before.is_none() || now == before))
            }
            // Several: it may have been evicted again, and loaded again.
            Ask::Read(_) if used => (None, true),
            Ask::ReadByte(_) | Ask::Read(_) => (None, now.is_none() || now == before),
            Ask::Write(addr, len, _) | Ask::Invalidate(addr, len) => {
                let (begin, end) = (u64::from(addr.0), u64::from(addr.0).saturating_add(len));
                let overlap = begin < end && begin < first + geometry.line().0 && first < end;
                (None, if overlap { now.is_none() } else { now == before })
            }
            Ask::Flush => (None, now.is_none()),
        };
        self.place = now;
        CardSays { known, hit, allowed: allowed && own_set }
    }
}

/// Host memory that can be written.
pub trait Host: HostMemory {
    /// Writes one value to each byte of a range.
    fn write(&mut self, addr: HostAddr, len: u64, byte: u8);

    /// The byte at an address.
    fn byte(&self, addr: HostAddr) -> u8 {
        let mut byte = [0];
        self.read(addr, &mut byte);
        byte[0]
    }
}

impl Host for Watched {
    fn write(&mut self, addr: HostAddr, len: u64, byte: u8) {
        if has(HostAddr(self.addr), addr, len) {
            self.byte = byte;
        }
    }

    fn byte(&self, addr: HostAddr) -> u8 {
        if addr.0 == self.addr { self.byte } else { self.other }
    }
}

impl Host for Vec<u8> {
    fn write(&mut self, addr: HostAddr, len: u64, byte: u8) {
        let begin = (addr.0 as usize).min(self.len());
        let end = u64::from(addr.0).saturating_add(len).min(self.len() as u64) as usize;
        self[begin..end.max(begin)].fill(byte);
    }
}

impl<H: Host, const WAYS: usize, M: Held<WAYS>> Machine for VirtualMemory<H, WAYS, M> {
    type Request = Ask;
    type Answer = Got;

    fn step(&mut self, ask: &Ask) -> Got {
        let mut got = Got { bytes: [0xff; 4], outcome: None };
        match *ask {
            Ask::ReadByte(addr) => got.outcome = Some(self.read_in_line(addr, &mut got.bytes[..1])),
            Ask::Read(addr) => self.read(Unit::Intersection, addr, &mut got.bytes),
            Ask::Write(addr, len, byte) => {
                self.host.write(addr, len, byte);
                self.invalidate(addr, len);
            }
            Ask::Invalidate(addr, len) => self.invalidate(addr, len),
            Ask::Flush => self.flush(),
        }
        got
    }
}

/// Where the line of a byte lies, if it is resident.
pub(super) fn place<H, const WAYS: usize, M: Held<WAYS>>(
    memory: &VirtualMemory<H, WAYS, M>,
    addr: HostAddr,
) -> Option<Place> {
    let config = memory.directory.config;
    let line = config.geometry.line_of(addr);
    let set = config.set_of(line);
    Some((set, memory.directory.metadata.held(set)?.way_of(line)?))
}

/// Whether the byte on the card, if it lies there, is the one given; and the set of its line is held.
pub(super) fn consistent<H, const WAYS: usize, M: Held<WAYS>>(
    memory: &VirtualMemory<H, WAYS, M>,
    flat: &Flat,
) -> bool {
    let config = memory.directory.config;
    let set = config.set_of(config.geometry.line_of(flat.addr));
    memory.directory.metadata.held(set).is_some()
        && place(memory, flat.addr).is_none_or(|(set, way)| {
            let begin = config.geometry.card_addr(set, way).0 as usize;
            memory.card[begin + config.geometry.offset_of(flat.addr) as usize] == flat.byte
        })
}

/// The virtual memory over metadata `M` is [`Card`] at the watched byte.
#[derive(Clone, Copy, Debug)]
pub struct IsFlat<H, const WAYS: usize, M>(PhantomData<(H, M)>);

impl<H: Host, const WAYS: usize, M: Held<WAYS>> Simulation for IsFlat<H, WAYS, M> {
    type Concrete = VirtualMemory<H, WAYS, M>;
    type Abstract = Card;

    fn related(memory: &Self::Concrete, card: &Card) -> bool {
        memory.directory.config == card.config
            && memory.host.byte(card.flat.addr) == card.flat.byte
            && consistent(memory, &card.flat)
            && place(memory, card.flat.addr) == card.place
    }

    fn asked(ask: &Ask, _: &Got, after: &Self::Concrete, card: &Card) -> (Ask, Option<Place>) {
        (*ask, place(after, card.flat.addr))
    }

    fn agree(got: &Got, says: &Answer<Card>) -> bool {
        let hit = got.outcome.map(|outcome| matches!(outcome, Outcome::Hit { .. }));
        says.allowed && bytes_agree(got, &says.known) && (says.hit.is_none() || says.hit == hit)
    }
}

/// Any virtual memory over that metadata in any state that is consistent, and the abstract machine's state
/// for it. The watched byte lies in the watched set.
pub(super) fn state<S: Source, const WAYS: usize, M: Held<WAYS>>(
    s: &mut S,
    config: CacheConfig,
    around: Around,
    metadata: M,
) -> Result<(VirtualMemory<Watched, WAYS, M>, Card), Stop> {
    let addr = if cfg!(kani) { parts::addr(s, &[]) } else { draw::addr_in(s, &config, around.own) };
    assume!(config.set_of(config.geometry.line_of(addr)) == around.own);
    let host = watched_at(s, addr);
    let flat = Flat { addr, byte: host.byte };
    let card = vec![0; config.geometry.memory().0 as usize];
    let mut memory = VirtualMemory { directory: Directory::over(config, metadata), card, host };
    let place = place(&memory, addr);
    if let Some((set, way)) = place {
        let begin = config.geometry.card_addr(set, way).0 as usize;
        memory.card[begin + config.geometry.offset_of(addr) as usize] = flat.byte;
    }
    Ok((memory, Card { config, flat, place }))
}

/// Judges a body for a virtual memory of version A, of two ways, and one of version B. Kani, of version A:
/// the virtual memory knows its metadata by the trait alone.
macro_rules! any_version {
    ($source:expr, $body:ident) => {{
        let b = !cfg!(kani) && parts::flag($source, "version B");
        if b {
            let config = draw::config::<S, 1>($source)?;
            let around = draw::around($source, &config);
            let metadata = draw::version_b::<S, 1, 1, 4>($source, &config, around, 2)?;
            let (memory, card) = state($source, config, around, metadata)?;
            $body($source, memory, card, around)?
        } else {
            const WAYS: usize = 2;
            let config = draw::config::<S, WAYS>($source)?;
            let around = draw::around($source, &config);
            let metadata = draw::version_a::<S, WAYS>($source, &config, around)?;
            let (memory, card) = state($source, config, around, metadata)?;
            $body($source, memory, card, around)?
        }
    }};
}

fn read_byte<S: Source, const WAYS: usize, M: Held<WAYS>>(
    s: &mut S,
    mut memory: VirtualMemory<Watched, WAYS, M>,
    mut card: Card,
    around: Around,
) -> Holds {
    let was = card.place;
    let addr = draw::addr(s, &card.config, around);
    step_from_any::<IsFlat<Watched, WAYS, M>>(&mut memory, &mut card, &Ask::ReadByte(addr))?;
    let watched = addr == card.flat.addr;
    cover!(s, "read from the card", watched && was.is_some());
    cover!(s, "read from the host", watched && was.is_none());
    cover!(s, "evicted", was.is_some() && card.place.is_none());
    Ok(())
}

fn read_four<S: Source, const WAYS: usize, M: Held<WAYS>>(
    s: &mut S,
    mut memory: VirtualMemory<Watched, WAYS, M>,
    mut card: Card,
    around: Around,
) -> Holds {
    // From three bytes before, or from any other address.
    let back = s.value("bytes before", 0..=3, &WORDS[..4]);
    let addr = match s.value("from (the watched byte, another, the end)", 0..=2, &BYTES[..3]) {
        0 => HostAddr(card.flat.addr.0.wrapping_sub(back)),
        1 => draw::addr(s, &card.config, around),
        _ => HostAddr(u32::MAX - back),
    };
    step_from_any::<IsFlat<Watched, WAYS, M>>(&mut memory, &mut card, &Ask::Read(addr))?;
    let line = card.config.geometry.line_of(card.flat.addr);
    let inside = has(card.flat.addr, addr, 4);
    cover!(s, "in the second line", inside && card.config.geometry.line_of(addr) != line);
    cover!(s, "beyond the end", addr.0 > u32::MAX - 3);
    Ok(())
}

fn forget<S: Source, const WAYS: usize, M: Held<WAYS>>(
    s: &mut S,
    mut memory: VirtualMemory<Watched, WAYS, M>,
    mut card: Card,
    around: Around,
) -> Holds {
    let (was, byte) = (card.place, card.flat.byte);
    let kind = s.value("request (write, invalidate, flush)", 0..=2, &BYTES[..3]);
    let ask = match kind {
        0 => {
            let (addr, len) = (draw::addr(s, &card.config, around), draw::len(s));
            Ask::Write(addr, len, s.value("byte written", 0..=u8::MAX, &BYTES[2..3]))
        }
        1 => Ask::Invalidate(draw::addr(s, &card.config, around), draw::len(s)),
        _ => Ask::Flush,
    };
    step_from_any::<IsFlat<Watched, WAYS, M>>(&mut memory, &mut card, &ask)?;
    cover!(s, "written while on the card", was.is_some() && card.flat.byte != byte);
    cover!(s, "written while not", was.is_none() && card.flat.byte != byte);
    cover!(s, "stays", kind == 0 && card.place.is_some());
    cover!(s, "flushed", kind == 2 && was.is_some());
    Ok(())
}

theorems! {
    /// In any consistent state a byte read is the host's, whether its line is on the card or not; the access
    /// hits exactly if it is, and whatever line is loaded and evicted, the state is consistent again.
    #["VM-9", unwind 5, covers ["read from the card", "read from the host", "evicted"]]
    fn reads_return_the_hosts_bytes(s) {
        any_version!(s, read_byte);
    }

    /// A read that straddles lines returns the host's byte at each place, and zero beyond the end of the
    /// address space, and leaves a consistent state.
    #["VM-10", unwind 5, covers ["in the second line", "beyond the end"]]
    fn reads_across_lines_return_the_hosts_bytes(s) {
        any_version!(s, read_four);
    }

    /// After the host has written a range and invalidated it, after an invalidation alone and after a flush,
    /// no line of the range is on the card, all others lie where they lay, and the card is consistent with the
    /// host.
    #["VM-9", unwind 5, covers ["written while on the card", "written while not", "stays", "flushed"]]
    fn host_writes_and_invalidation_keep_the_card_the_hosts(s) {
        any_version!(s, forget);
    }
}
