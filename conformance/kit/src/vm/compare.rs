//! Compares the answers of `saarcor-vm` with the model's.
//!
//! Nearly all answers are the model's, byte for byte. Only from the first that is not are requests and
//! answers compared word by word.

use super::cache::CacheAdapter;
use super::config;
use super::host::SparseHost;
use super::model;
use super::request::{Observes, ReadAnswer, Request};
use crate::comparison::{Comparison, Difference, Expected};
use crate::error::Error;
use crate::hex;
use crate::level::Level;
use crate::session::Session;
use saarcor_model::vm::{CacheConfig, HostAddr, HostMemory as _, LineAddr};
use std::collections::BTreeMap;

/// The comparison of one session.
pub struct VmComparison<'a> {
    session: &'a Session,
    config: CacheConfig,
    expected: Expected<CacheAdapter>,
    compared: usize,
    words: Option<WordComparison>,
}

impl<'a> VmComparison<'a> {
    /// Compares what `observes` lists.
    ///
    /// # Errors
    /// What is wrong with the list or the configuration.
    pub fn new(session: &'a Session, observes: &str) -> Result<Self, Error> {
        let config = config::parse(session.config())?;
        let mut model = CacheAdapter::new(session.config(), &model::make)?;
        model.observes = Observes::parse(observes)?;
        Ok(Self { session, config, expected: Expected::new(model), compared: 0, words: None })
    }
}

impl Comparison for VmComparison<'_> {
    fn observed(&self, level: Level) -> bool {
        let Observes { data, hit, card, .. } = self.expected.model.observes;
        match level {
            Level::Protocol => true,
            Level::Data => data,
            Level::Traffic => hit,
            // With the way of each miss, the victim is known too.
            Level::State => hit && card,
            _ => false,
        }
    }

    #[inline]
    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        let is_equal = self.expected.equals(request, answer)?;
        self.compared += 1;
        if self.words.is_none() && is_equal {
            return Ok(());
        }
        let words = self.words.get_or_insert_with(|| {
            let mut words = WordComparison::new(self.config, self.expected.model.observes);
            let before = self.session.requests().take(self.compared - 1);
            before.for_each(|request| words.follow(request));
            words
        });
        let compared = words.compare(request, self.expected.answer(), answer, found);
        words.follow(request);
        compared
    }

    fn expected(&self) -> &[u8] {
        self.expected.answer()
    }
}

/// What has happened to a line.
#[derive(Clone, Debug, Default)]
struct LineHistory {
    /// Invalidations, of any line, before it was read last.
    invalidations: u64,
    /// It has been invalidated since it was read last.
    invalidated: bool,
    /// It has been written since it was read last.
    written: bool,
    /// It has been read since it was invalidated.
    is_read: bool,
    /// The writes since the first of these reads. Few lines of many have any.
    writes: Option<Box<Writes>>,
}

/// What has been written to a line since it was read.
#[derive(Clone, Debug, Default)]
struct Writes {
    /// The first address of each write, and the bytes that were there before: together no longer than the session,
    /// however long the line is.
    overwritten: Vec<(u32, Vec<u8>)>,
    /// How many of them there were whenever the line was read again: what it held then a cache may still hold.
    reads: Vec<usize>,
}

impl LineHistory {
    fn is_invalidated(&mut self) {
        self.invalidated = true;
        self.is_read = false;
        self.writes = None;
    }

    fn is_read(&mut self) {
        self.is_read = true;
        let Some(Writes { overwritten, reads }) = self.writes.as_deref_mut() else { return };
        if reads.last() != Some(&overwritten.len()) {
            reads.push(overwritten.len());
        }
    }

    fn overwritten(&self) -> &[(u32, Vec<u8>)] {
        self.writes.as_ref().map_or(&[], |writes| &writes.overwritten)
    }

    /// How much of `overwritten` there was at each read, the last one first.
    fn reads(&self) -> impl Iterator<Item = usize> {
        let again = self.writes.iter().flat_map(|writes| writes.reads.iter().rev().copied());
        again.chain(self.is_read.then_some(0))
    }

    /// What the bytes from `host` on, which are `now`, were at the reads since the line was invalidated, beside
    /// `got`, of the same length.
    ///
    /// The time it takes is that of the reads and of the bytes written between them, whatever the length.
    fn earlier(&self, host: u32, now: &[u8], got: &[u8]) -> Earlier {
        let (mut bytes, mut writes) = (now.to_vec(), self.overwritten().len());
        // How many bytes are not those of `got`, and not those of `now`.
        let mut not_got = bytes.iter().zip(got).filter(|(byte, got)| byte != got).count();
        let mut not_now = 0;
        let mut earlier = Earlier::Unchanged;
        for read in self.reads() {
            for (first, old) in self.overwritten()[read..writes].iter().rev() {
                for (addr, &old) in (u64::from(*first)..).zip(old) {
                    let place = addr.checked_sub(host.into()).map(|place| place as usize);
                    let Some(place) = place.filter(|place| *place < bytes.len()) else { continue };
                    let before = std::mem::replace(&mut bytes[place], old);
                    let (got, now) = (got[place], now[place]);
                    not_got = not_got + usize::from(old != got) - usize::from(before != got);
                    not_now = not_now + usize::from(old != now) - usize::from(before != now);
                }
            }
            writes = read;
            if not_got == 0 {
                return Earlier::Same;
            }
            if not_now > 0 {
                earlier = Earlier::Others;
            }
        }
        earlier
    }
}

/// What bytes were at earlier reads, beside those of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Earlier {
    /// At one of them those of the answer.
    Same,
    /// At one of them others than now, and never those of the answer.
    Others,
    /// The same as now at each, or there was none.
    Unchanged,
}

/// Compares answers word by word, and follows the history of each line.
struct WordComparison {
    config: CacheConfig,
    observes: Observes,
    host: SparseHost,
    /// The lines that have been read.
    lines: BTreeMap<u32, LineHistory>,
    /// Invalidations so far.
    invalidations: u64,
    /// Whether hits have differed: from then on ways and victims have to differ.
    traffic_differs: bool,
}

impl WordComparison {
    fn new(config: CacheConfig, observes: Observes) -> Self {
        let (host, lines) = (SparseHost::default(), BTreeMap::new());
        Self { config, observes, host, lines, invalidations: 0, traffic_differs: false }
    }

    /// What the host holds.
    fn bytes(&self, host: u32, len: usize) -> Vec<u8> {
        let mut bytes = vec![0; len];
        self.host.read(HostAddr(host), &mut bytes);
        bytes
    }

    /// The lines that have been read, of those that a range meets.
    fn met(&mut self, host: u32, len: u64) -> impl Iterator<Item = (&u32, &mut LineHistory)> {
        let met = self.config.lines_of(HostAddr(host), len);
        self.lines.range_mut(met.start as u32..=(met.end - 1) as u32)
    }

    /// Takes note of a request.
    fn follow(&mut self, request: &[u8]) {
        match Request::parse(request) {
            Ok(Request::Write { host, digits }) => {
                let written = hex::bytes(digits).unwrap_or_default();
                let old = self.bytes(host, written.len());
                let geometry = self.config.geometry;
                for (line, life) in self.met(host, written.len() as u64) {
                    let first = geometry.first_byte(LineAddr(*line)).0.max(host);
                    let from = (first - host) as usize;
                    let end = u64::from(geometry.first_byte(LineAddr(*line)).0) + geometry.line().0;
                    let to = ((end - u64::from(host)) as usize).min(old.len());
                    life.written = true;
                    if life.is_read {
                        let writes = life.writes.get_or_insert_default();
                        writes.overwritten.push((first, old[from..to].to_vec()));
                    }
                }
                self.host.write(host, &written);
            }
            Ok(Request::Read { host, .. }) => {
                let line = self.config.geometry.line_of(HostAddr(host));
                let life = self.lines.entry(line.0).or_default();
                (life.invalidations, life.invalidated, life.written) = (self.invalidations, false, false);
                life.is_read();
            }
            Ok(Request::Invalidate { host, len }) => {
                self.invalidations += 1;
                self.met(host, len).for_each(|(_, life)| life.is_invalidated());
            }
            Ok(Request::Flush) => {
                self.invalidations += 1;
                self.lines.values_mut().for_each(LineHistory::is_invalidated);
            }
            Err(_) => {}
        }
    }

    fn compare(
        &mut self,
        request: &[u8],
        expected: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        if expected == answer {
            return Ok(());
        }
        let Ok(Request::Read { host, len }) = Request::parse(request) else {
            return Err("'ok' is right".into());
        };
        let right = ReadAnswer::parse(expected, len, self.observes)?;
        let got = ReadAnswer::parse(answer, len, self.observes)?;
        if let (Some(digits), true) = (got.data, got.data != right.data) {
            self.compare_data(host, digits, found);
        }
        if self.traffic_differs {
            return Ok(());
        }
        if got.hit != right.hit {
            self.traffic_differs = true;
            found(self.traffic(host, right.hit == Some(true)));
        } else {
            self.compare_state(host, &right, &got, found);
        }
        Ok(())
    }

    fn compare_data(&self, host: u32, digits: &[u8], found: &mut dyn FnMut(Difference)) {
        let got = hex::bytes(digits).unwrap_or_default();
        let now = self.bytes(host, got.len());
        if got == now {
            return;
        }
        let line = self.config.geometry.line_of(HostAddr(host)).0;
        let earlier = self.lines.get(&line).map_or(Earlier::Unchanged, |life| life.earlier(host, &now, &got));
        let says = match earlier {
            Earlier::Same => return,
            Earlier::Others => {
                "the bytes are neither the host's, nor those that it had at an earlier read since the line was \
                 last invalidated"
            }
            Earlier::Unchanged => "the bytes are not the host's",
        };
        found(Difference { level: Level::Data, says: says.to_owned(), requirement: "VM-9" });
    }

    fn traffic(&self, host: u32, hits: bool) -> Difference {
        let life = self.lines.get(&self.config.geometry.line_of(HostAddr(host)).0);
        let (requirement, says) = match (hits, life) {
            (true, Some(life)) if life.written => {
                ("VM-6", "a miss: the line is resident, and a write of the host invalidates nothing")
            }
            (true, Some(life)) if life.invalidations < self.invalidations => {
                ("VM-8", "a miss: the line is resident, and no invalidation since its last read met it")
            }
            (true, _) => ("VM-6", "a miss: the line is resident"),
            (false, None) => ("VM-4", "a hit: the line was never loaded"),
            (false, Some(LineHistory { invalidated: true, .. })) => {
                ("VM-8", "a hit: the line was invalidated since its last read")
            }
            (false, _) => ("VM-6", "a hit: the line was evicted since its last read"),
        };
        Difference { level: Level::Traffic, says: says.to_owned(), requirement }
    }

    fn compare_state(
        &self,
        host: u32,
        right: &ReadAnswer<'_>,
        got: &ReadAnswer<'_>,
        found: &mut dyn FnMut(Difference),
    ) {
        let geometry = self.config.geometry;
        let mut differs = |requirement, says| found(Difference { level: Level::State, says, requirement });
        if let (Some(right_card), Some(card)) = (right.card, got.card) {
            let (line, ways) = (geometry.line().0, u64::from(geometry.ways()));
            let place = |card: u64| (card / line / ways, card / line % ways, card % line);
            let ((set, way, offset), (right_set, right_way, right_offset)) = (place(card), place(right_card));
            if card >= geometry.memory().0 {
                let memory = geometry.memory().0;
                return differs(
                    "VM-11",
                    format!("address {card:x} is beyond the memory of {memory:x} bytes"),
                );
            }
            if offset != right_offset {
                return differs("VM-11", format!("offset {offset:x} in the line; {right_offset:x} is right"));
            }
            if set != right_set {
                return differs("VM-3", format!("set {set:x}; {right_set:x} is right"));
            }
            if way != right_way {
                let (requirement, why) = match (right.hit, right.evicted) {
                    (Some(true), _) => ("VM-5", "where the line was loaded"),
                    (_, None) if self.observes.evict => ("VM-7", "the free way of the lowest number"),
                    _ => ("VM-6", "the victim's, or a free one"),
                };
                return differs(requirement, format!("way {way:x}; {right_way:x} is right: {why}"));
            }
        }
        if got.evicted != right.evicted {
            let shown = |evicted: Option<u64>| evicted.map_or("none".to_owned(), |host| format!("{host:x}"));
            let requirement = if right.evicted.is_none() { "VM-7" } else { "VM-6" };
            let (got, right) = (shown(got.evicted), shown(right.evicted));
            differs(requirement, format!("line {got} evicted of {host:x}'s set; {right} is right"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A comparison of lines of 8 bytes that has followed some requests.
    fn after(requests: &[&str]) -> WordComparison {
        let config = config::parse("line=8 lines=2 ways=2 hash=low policy=lru").expect("a configuration");
        let mut words = WordComparison::new(config, Observes::ALL);
        requests.iter().for_each(|request| words.follow(request.as_bytes()));
        words
    }

    #[test]
    fn old_bytes_are_right_until_the_line_is_invalidated() {
        let is_wrong = |words: &WordComparison, host, digits: &str| {
            let mut wrong = false;
            words.compare_data(host, digits.as_bytes(), &mut |_| wrong = true);
            wrong
        };
        let mut requests = vec!["w 6 010203", "r 7 1", "w 5 0a0b0c0d", "w 0 ff", "r 0 1", "w 7 0e"];
        let words = after(&requests);
        // Byte 7 was 2, 0c and 0e; byte 6 was 1, 0b and 0b.
        for (digits, wrong) in
            [("0102", false), ("0b0c", false), ("0b0e", false), ("010c", true), ("010e", true)]
        {
            assert_eq!(is_wrong(&words, 6, digits), wrong, "{digits}");
        }
        // The next line was not read.
        assert!(is_wrong(&words, 8, "03") && !is_wrong(&words, 8, "0d"));
        requests.push("i 4 1");
        assert!(is_wrong(&after(&requests), 6, "0b0c") && !is_wrong(&after(&requests), 6, "0b0e"));
        requests.push("r 0 1");
        assert!(!is_wrong(&after(&requests), 6, "0b0e"));
    }

    #[test]
    fn misses_and_hits_name_their_causes() {
        let cause = |requests: &[&str], hits| after(requests).traffic(0, hits).requirement;
        assert_eq!((cause(&["r 0 1"], true), cause(&["r 0 1", "i 8 1"], true)), ("VM-6", "VM-8"));
        assert_eq!((cause(&["r 8 1"], false), cause(&["r 0 1", "flush"], false)), ("VM-4", "VM-8"));
        assert_eq!(cause(&["r 0 1", "flush", "r 0 1"], false), "VM-6");
        assert_eq!(cause(&["r 0 1", "w 7 0102", "i 8 1"], true), "VM-6");
    }

    /// Long lines that are read again and again, and written in between.
    #[test]
    fn histories_take_no_more_than_what_was_written() {
        let config = config::parse("line=65536 lines=2 ways=2 hash=low policy=lru").expect("a configuration");
        let mut words = WordComparison::new(config, Observes::ALL);
        for number in 0..10_000 {
            words.follow(b"r 0 1");
            words.follow(format!("w {number:x} 01").as_bytes());
        }
        let life = &words.lines[&0];
        assert_eq!((life.reads().count(), life.overwritten().len()), (10_000, 10_000));
        assert!(life.overwritten().iter().all(|(_, old)| old.len() == 1));
    }
}
