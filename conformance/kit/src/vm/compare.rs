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
use saarcor_model::vm::{CacheConfig, HostAddr, HostMemory as _};
use std::collections::HashMap;

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
    /// It has been read.
    read: bool,
    /// It has been invalidated since it was read last.
    invalidated: bool,
    /// Something, if another line, has been invalidated since it was read last.
    others_invalidated: bool,
    /// What it held whenever it was read since it was invalidated: what a cache may still hold.
    held: Vec<Vec<u8>>,
}

/// Compares answers word by word, and follows the history of each line.
struct WordComparison {
    config: CacheConfig,
    observes: Observes,
    host: SparseHost,
    lines: HashMap<u32, LineHistory>,
    /// Whether hits have differed: from then on ways and victims have to differ.
    traffic_differs: bool,
}

impl WordComparison {
    fn new(config: CacheConfig, observes: Observes) -> Self {
        let (host, lines) = (SparseHost::default(), HashMap::new());
        Self { config, observes, host, lines, traffic_differs: false }
    }

    /// The line that holds an address, and what the host holds of it.
    fn line(&self, host: u32) -> (u32, Vec<u8>) {
        let geometry = self.config.geometry;
        let line = geometry.line_of(HostAddr(host));
        let mut bytes = vec![0; geometry.line().0 as usize];
        self.host.read(geometry.first_byte(line), &mut bytes);
        (line.0, bytes)
    }

    /// Takes note of a request.
    fn follow(&mut self, request: &[u8]) {
        match Request::parse(request) {
            Ok(Request::Write { host, digits }) => {
                self.host.write(host, &hex::bytes(digits).unwrap_or_default());
            }
            Ok(Request::Read { host, .. }) => {
                let (line, bytes) = self.line(host);
                let life = self.lines.entry(line).or_default();
                (life.read, life.invalidated, life.others_invalidated) = (true, false, false);
                if life.held.last() != Some(&bytes) {
                    life.held.push(bytes);
                }
            }
            Ok(Request::Invalidate { host, len }) => {
                let met = self.config.lines_of(HostAddr(host), len);
                for (line, life) in &mut self.lines {
                    life.others_invalidated = true;
                    if met.contains(&u64::from(*line)) {
                        life.invalidated = true;
                        life.held.clear();
                    }
                }
            }
            Ok(Request::Flush) => {
                for life in self.lines.values_mut() {
                    (life.invalidated, life.others_invalidated) = (true, true);
                    life.held.clear();
                }
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
        let (line, now) = self.line(host);
        let offset = self.config.geometry.offset_of(HostAddr(host)) as usize;
        let here = |bytes: &[u8]| bytes[offset..][..got.len()] == got[..];
        let before = self.lines.get(&line).map_or(&[][..], |life| &life.held);
        if here(&now) || before.iter().any(|bytes| here(bytes)) {
            return;
        }
        let says = if before.iter().all(|bytes| bytes[offset..] == now[offset..]) {
            "the bytes are not the host's".to_owned()
        } else {
            "the bytes are neither the host's, nor those that it had at an earlier read since the line was \
             last invalidated"
                .to_owned()
        };
        found(Difference { level: Level::Data, says, requirement: "VM-9" });
    }

    fn traffic(&self, host: u32, hits: bool) -> Difference {
        let line = self.config.geometry.line_of(HostAddr(host)).0;
        let life = self.lines.get(&line).cloned().unwrap_or_default();
        let (requirement, says) = match (hits, life) {
            (true, LineHistory { others_invalidated: true, .. }) => {
                ("VM-8", "a miss: the line is resident, and no invalidation since its last read met it")
            }
            (true, _) => ("VM-6", "a miss: the line is resident"),
            (false, LineHistory { read: false, .. }) => ("VM-4", "a hit: the line was never loaded"),
            (false, LineHistory { invalidated: true, .. }) => {
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
