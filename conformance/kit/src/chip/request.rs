//! Requests and answers of `saarcor-chip`.

use super::config::{Setting, UNITS};
use crate::error::Error;
use crate::hex;
use crate::vm::request::END_OF_ADDRESSES;
use crate::words::observed_names;
use saarcor_model::time::standard::PACKET_RAYS;
use saarcor_model::time::{CacheReport, Operation, TimingReport};
use saarcor_model::vm::{HostAddr, Unit};
use std::fmt;

/// Rays of a packet (RG-2).
pub const RAYS: u8 = PACKET_RAYS as u8;

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// A packet of an earlier picture, which left its bytes in the caches.
    Before(Vec<Operation>),
    /// A packet.
    Packet(Vec<Operation>),
    /// The packets so far are played.
    Run,
    /// There are no packets.
    Flush,
}

impl Request {
    /// The request of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(line: &[u8]) -> Result<Self, Error> {
        let mut words = line.split(|&byte| byte == b' ');
        let name = words.next().unwrap_or_default();
        let right = "an operation is UNIT,ADDR,BYTES,RAYS: s, n, l or t and hex, with bytes or up to 40 rays";
        let operations =
            |words: &mut dyn Iterator<Item = &[u8]>| words.map(operation).collect::<Option<_>>().ok_or(right);
        let request = match name {
            b"b" => Self::Before(operations(&mut words)?),
            b"p" => Self::Packet(operations(&mut words)?),
            b"run" => Self::Run,
            b"flush" => Self::Flush,
            _ => return Err("the requests are b, p, run, flush, end".into()),
        };
        if words.next().is_some() { Err("too many words".into()) } else { Ok(request) }
    }

    /// The operations of a packet.
    #[must_use]
    pub fn operations(&self) -> &[Operation] {
        match self {
            Self::Before(operations) | Self::Packet(operations) => operations,
            Self::Run | Self::Flush => &[],
        }
    }

    /// The same request with other operations.
    #[must_use]
    pub fn with(&self, operations: Vec<Operation>) -> Self {
        match self {
            Self::Before(_) => Self::Before(operations),
            Self::Packet(_) => Self::Packet(operations),
            Self::Run => Self::Run,
            Self::Flush => Self::Flush,
        }
    }

    /// The line of text that [`Request::parse`] reads back.
    #[must_use]
    pub fn text(&self) -> Vec<u8> {
        self.to_string().into_bytes()
    }

    /// Whether the request is legal with this configuration; what would be right, where it is not.
    ///
    /// # Errors
    /// What would be right.
    pub fn fits(&self, setting: &Setting) -> Result<(), Error> {
        let before = |operation: &Operation| {
            operation.unit == Unit::Intersection && operation.bytes > 0 && operation.addr < setting.triangles
        };
        let wrong = self.operations().iter().any(before);
        if wrong { Err("triangles lie at the address 'triangles' or behind it".into()) } else { Ok(()) }
    }
}

fn operation(word: &[u8]) -> Option<Operation> {
    let mut parts = word.split(|&byte| byte == b',');
    let letter = parts.next()?;
    let unit = Unit::ALL[UNITS.iter().position(|unit| unit.as_bytes() == letter)?];
    let mut number = || hex::number(parts.next()?);
    let (addr, bytes, rays) = (number()?, number()?, number()?);
    let (bytes, rays) = (u16::try_from(bytes).ok()?, u8::try_from(rays).ok()?);
    let legal = addr.saturating_add(bytes.into()) <= END_OF_ADDRESSES
        && rays <= RAYS
        && (bytes > 0 || rays > 0)
        && parts.next().is_none();
    let addr = HostAddr(u32::try_from(addr).ok()?);
    legal.then_some(Operation { addr, bytes, rays, unit })
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Before(_) => "b",
            Self::Packet(_) => "p",
            Self::Run => "run",
            Self::Flush => "flush",
        })?;
        for Operation { addr, bytes, rays, unit } in self.operations() {
            write!(f, " {},{:x},{bytes:x},{rays:x}", UNITS[*unit as usize], addr.0)?;
        }
        Ok(())
    }
}

/// What an implementation observes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observes {
    /// Cycles.
    pub cycles: bool,
    /// Bytes from the host.
    pub pci: bool,
    /// Bytes of the on-board memory, by what they move for.
    pub mem: bool,
    /// Look-ups of the first-level caches.
    pub l1: bool,
    /// Look-ups of the virtual memory.
    pub l2: bool,
}

impl Observes {
    /// All.
    pub const ALL: Self = Self { cycles: true, pci: true, mem: true, l1: true, l2: true };

    /// What the list after `observes=` names.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(list: &str) -> Result<Self, Error> {
        let names = ["cycles", "pci", "mem", "l1", "l2"];
        let [cycles, pci, mem, l1, l2] = observed_names(names, list)?;
        Ok(Self { cycles, pci, mem, l1, l2 })
    }
}

/// What a run took, as far as it is observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Cycles.
    pub cycles: Option<u64>,
    /// Bytes from the host.
    pub pci: Option<u64>,
    /// Bytes to first-level caches, lines written, metadata read and written back.
    pub mem: Option<[u64; 4]>,
    /// Look-ups of the first-level caches.
    pub l1: Option<[CacheReport; 4]>,
    /// Look-ups of the virtual memory.
    pub l2: Option<CacheReport>,
}

impl Answer {
    /// All of the model's report that an answer has.
    #[must_use]
    pub fn of(report: &TimingReport) -> Self {
        let mem = [
            report.l1_fill_bytes,
            report.vm_fill_bytes,
            report.metadata_read_bytes,
            report.metadata_write_back_bytes,
        ];
        Self {
            cycles: Some(report.cycles),
            pci: Some(report.pci_bytes),
            mem: Some(mem),
            l1: Some(report.l1),
            l2: Some(report.l2),
        }
    }

    /// The answer as far as it is observed.
    #[must_use]
    pub fn as_observed(&self, observes: Observes) -> Self {
        Self {
            cycles: self.cycles.filter(|_| observes.cycles),
            pci: self.pci.filter(|_| observes.pci),
            mem: self.mem.filter(|_| observes.mem),
            l1: self.l1.filter(|_| observes.l1),
            l2: self.l2.filter(|_| observes.l2),
        }
    }

    /// The answer of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(line: &[u8], observes: Observes) -> Result<Self, Error> {
        let words: Vec<&[u8]> = line.split(|&byte| byte == b' ').filter(|word| !word.is_empty()).collect();
        let [b"c", cycles, pci, mem, l1, l2] = words[..] else {
            return Err("'c CYCLES PCI MEM L1 L2' is right, with '-' for what is not observed".into());
        };
        let bytes = |word: &[u8]| numbers(word, b',', hex::number);
        let look_ups = |word: &[u8]| {
            let [accesses, merged, misses] = numbers(word, b'/', hex::number)?;
            Some(CacheReport { accesses, merged, misses })
        };
        Ok(Self {
            cycles: observed(observes.cycles, cycles, "CYCLES is a hex number", hex::number)?,
            pci: observed(observes.pci, pci, "PCI is a hex number", hex::number)?,
            mem: observed(observes.mem, mem, "MEM is FILL,LOAD,READ,BACK", bytes)?,
            l1: observed(observes.l1, l1, "L1 is four of LOOKUPS/MERGED/MISSES with ',' between", |word| {
                numbers(word, b',', look_ups)
            })?,
            l2: observed(observes.l2, l2, "L2 is LOOKUPS/MERGED/MISSES", look_ups)?,
        })
    }
}

/// So many values with `between` them.
fn numbers<T, const N: usize>(word: &[u8], between: u8, read: impl Fn(&[u8]) -> Option<T>) -> Option<[T; N]> {
    let values: Option<Vec<T>> = word.split(|&byte| byte == between).map(read).collect();
    values?.try_into().ok()
}

/// A word as far as it is observed.
fn observed<T>(
    is_observed: bool,
    word: &[u8],
    form: &str,
    read: impl Fn(&[u8]) -> Option<T>,
) -> Result<Option<T>, Error> {
    match is_observed {
        true => read(word).map(Some).ok_or_else(|| format!("{form}; it is observed").into()),
        false => Ok(None),
    }
}

/// Appends the answer that says all.
pub fn push_answer(out: &mut Vec<u8>, report: &TimingReport) {
    let numbers = |out: &mut Vec<u8>, between: u8, numbers: &[u64]| {
        for (place, number) in numbers.iter().enumerate() {
            if place > 0 {
                out.push(between);
            }
            hex::push_number(out, *number);
        }
    };
    let look_ups = |out: &mut Vec<u8>, cache: &CacheReport| {
        numbers(out, b'/', &[cache.accesses, cache.merged, cache.misses]);
    };
    let Answer { mem, .. } = Answer::of(report);
    out.extend_from_slice(b"c ");
    hex::push_number(out, report.cycles);
    out.push(b' ');
    hex::push_number(out, report.pci_bytes);
    out.push(b' ');
    numbers(out, b',', &mem.unwrap_or_default());
    for (place, cache) in report.l1.iter().enumerate() {
        out.push(if place == 0 { b' ' } else { b',' });
        look_ups(out, cache);
    }
    out.push(b' ');
    look_ups(out, &report.l2);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_read_back() {
        for text in ["b s,0,0,40", "p n,1f8,8,3 t,ffffffff,1,0", "p", "run", "flush"] {
            let request = Request::parse(text.as_bytes()).expect(text);
            assert_eq!(request.to_string(), text);
        }
        for text in [
            "",
            "q",
            "run 1",
            "p x,0,1,1",
            "p n,0,1",
            "p n,0,0,0",
            "p n,0,0,41",
            "p n,0,10000,1",
            "p n,0,1,1,1",
            "p n,ffffffff,2,1",
            "p  n,0,1,1",
        ] {
            assert!(Request::parse(text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn answers_are_read_as_far_as_observed() {
        let report =
            TimingReport { cycles: 0x2a, pci_bytes: 0x80, vm_fill_bytes: 0x80, ..TimingReport::default() };
        let mut text = Vec::new();
        push_answer(&mut text, &report);
        assert_eq!(String::from_utf8_lossy(&text), "c 2a 80 0,80,0,0 0/0/0,0/0/0,0/0/0,0/0/0 0/0/0");
        assert_eq!(Answer::parse(&text, Observes::ALL).ok(), Some(Answer::of(&report)));
        let cycles = Observes::parse("cycles").expect("a list");
        let none = Answer { cycles: Some(0x2a), pci: None, mem: None, l1: None, l2: None };
        assert_eq!(Answer::parse(b"c 2a - - - -", cycles).ok(), Some(none));
        for text in ["ok", "c 2a - - -", "c - - - - -", "c 0x2a - - - -", "c 2a 0 - - - 0"] {
            assert!(Answer::parse(text.as_bytes(), cycles).is_err(), "{text}");
        }
        assert!(Observes::parse("cycles,data").is_err());
    }
}
