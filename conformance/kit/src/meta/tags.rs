//! The tags of version B as a Rust type: what an implementation in process provides, and the model's
//! and the naive reference's.

use super::config::{self, MetaConfig};
use super::request::{Observes, Request, push_moved};
use crate::error::Error;
use crate::hex;
use crate::implementation::Implementation;
use saarcor_model::vm::{
    CachedMetadata, Directory, HostAddr, LineAddr, MetadataObserver, Outcome, Policy, Set, WriteBack,
};
use saarcor_oracles::metadata::{GranuleEvent, NaiveTags};

/// An implementation of version B's tags, empty at first.
pub trait Tags: Send {
    /// The chip uses a line. Returns the outcome, and appends to `moved` what the metadata cache did.
    fn access(&mut self, line: LineAddr, moved: &mut Vec<GranuleEvent>) -> Outcome;

    /// Invalidates every line that the range meets, one after the other.
    fn invalidate(&mut self, host: HostAddr, len: u64, moved: &mut Vec<GranuleEvent>);

    /// Invalidates all lines.
    fn flush(&mut self);

    /// Flips bits of a byte of the metadata on the card.
    fn flip(&mut self, byte: usize, mask: u8);

    /// The set of a line, for a person; nothing where it cannot be seen.
    fn shown(&self, _line: LineAddr) -> Vec<String> {
        Vec::new()
    }
}

/// What the model's metadata cache did, granule by granule.
#[derive(Clone, Debug, Default)]
pub struct EventLog(Vec<GranuleEvent>);

impl<const GRANULE: usize> MetadataObserver<[u8; GRANULE]> for EventLog {
    fn granule_used(
        &mut self,
        granule: LineAddr,
        outcome: Outcome,
        write_back: Option<WriteBack<[u8; GRANULE]>>,
    ) {
        self.0.push(match outcome {
            Outcome::Hit { .. } => GranuleEvent::Found(granule.0),
            Outcome::Miss { .. } => GranuleEvent::Read(granule.0),
        });
        self.0.extend(write_back.map(|back| GranuleEvent::WrittenBack(back.line.0, back.contents.to_vec())));
    }

    fn corrupt(&mut self) {}
}

/// The model's directory of version B.
pub struct ModelTags<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize> {
    /// The directory.
    pub directory: Directory<WAYS, CachedMetadata<WAYS, META_WAYS, GRANULE, EventLog>>,
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize> ModelTags<WAYS, META_WAYS, GRANULE> {
    /// The tags of an empty cache.
    ///
    /// # Panics
    /// If the type is not that of the configuration.
    #[must_use]
    pub fn new(config: &MetaConfig) -> Self {
        let metadata = CachedMetadata::observed(&config.cache, config.sets, Policy::Lru, EventLog::default());
        Self { directory: Directory::over(config.cache, metadata) }
    }

    /// The set that a line belongs to; none where its metadata is corrupt.
    #[must_use]
    pub fn set_of(&self, line: LineAddr) -> Option<Set<WAYS>> {
        let entries = self.directory.metadata.entries(self.directory.config.set_of(line));
        Set::from_entries(entries, self.directory.config.policy).ok()
    }
}

impl<const WAYS: usize, const META_WAYS: usize, const GRANULE: usize> Tags
    for ModelTags<WAYS, META_WAYS, GRANULE>
{
    fn access(&mut self, line: LineAddr, moved: &mut Vec<GranuleEvent>) -> Outcome {
        let outcome = self.directory.access(line);
        moved.append(&mut self.directory.metadata.observer.0);
        outcome
    }

    fn invalidate(&mut self, host: HostAddr, len: u64, moved: &mut Vec<GranuleEvent>) {
        self.directory.invalidate(host, len);
        moved.append(&mut self.directory.metadata.observer.0);
    }

    fn flush(&mut self) {
        self.directory.flush();
    }

    fn flip(&mut self, byte: usize, mask: u8) {
        self.directory.metadata.card[byte] ^= mask;
    }

    fn shown(&self, line: LineAddr) -> Vec<String> {
        let set = self.directory.config.set_of(line).0;
        let mut rows = vec![format!("line {:x} belongs to set {set:x}", line.0)];
        match self.set_of(line) {
            None => rows.push("its metadata is corrupt: the set counts as empty".to_owned()),
            Some(set) => {
                for way in 0..WAYS {
                    let free = if set.resident[way] { "" } else { ", free" };
                    let (line, order) = (set.lines[way].0, set.order[way]);
                    rows.push(format!("way {way:x}: line {line:x}{free}; management bits {order:x}"));
                }
            }
        }
        for (number, cached) in self.directory.metadata.cache.iter().enumerate() {
            for way in (0..META_WAYS).filter(|&way| cached.set.resident[way]) {
                let changed = if cached.dirty[way] { ", changed" } else { "" };
                let granule = cached.set.lines[way].0;
                rows.push(format!(
                    "metadata cache, set {number:x}, way {way:x}: granule {granule:x}{changed}"
                ));
            }
        }
        // Of a large metadata cache a part: the set of lines comes first.
        rows.truncate(SHOWN_ROWS);
        rows
    }
}

/// Most rows that are shown.
const SHOWN_ROWS: usize = 40;

impl Tags for NaiveTags {
    fn access(&mut self, line: LineAddr, moved: &mut Vec<GranuleEvent>) -> Outcome {
        self.access(line, moved)
    }

    fn invalidate(&mut self, host: HostAddr, len: u64, moved: &mut Vec<GranuleEvent>) {
        self.invalidate(host, len, moved);
    }

    fn flush(&mut self) {
        self.flush();
    }

    fn flip(&mut self, byte: usize, mask: u8) {
        self.flip(byte, mask);
    }
}

/// Makes the tags of an empty cache; where they do not support a value, it fails with [`Error::Unsupported`] and the key.
pub type MakeTags = dyn Fn(&MetaConfig) -> Result<Box<dyn Tags>, Error> + Sync;

/// The model of a configuration.
///
/// # Errors
/// Never: the model supports all.
pub fn model(config: &MetaConfig) -> Result<Box<dyn Tags>, Error> {
    Ok(match config.cache.geometry.ways() {
        1 => model_of_ways::<1>(config),
        2 => model_of_ways::<2>(config),
        4 => model_of_ways::<4>(config),
        8 => model_of_ways::<8>(config),
        _ => model_of_ways::<16>(config),
    })
}

fn model_of_ways<const WAYS: usize>(config: &MetaConfig) -> Box<dyn Tags> {
    match (config.ways, config.granule) {
        (1, 8) => Box::new(ModelTags::<WAYS, 1, 8>::new(config)),
        (2, 8) => Box::new(ModelTags::<WAYS, 2, 8>::new(config)),
        (4, 8) => Box::new(ModelTags::<WAYS, 4, 8>::new(config)),
        (1, _) => Box::new(ModelTags::<WAYS, 1, 16>::new(config)),
        (2, _) => Box::new(ModelTags::<WAYS, 2, 16>::new(config)),
        (_, _) => Box::new(ModelTags::<WAYS, 4, 16>::new(config)),
    }
}

/// The naive reference of a configuration.
///
/// # Errors
/// Never: it supports all.
pub fn naive(config: &MetaConfig) -> Result<Box<dyn Tags>, Error> {
    Ok(Box::new(NaiveTags::new(config.cache, config.granule, config.sets, config.ways)))
}

/// Tags that speak `saarcor-meta`.
pub struct TagsAdapter {
    config: MetaConfig,
    tags: Box<dyn Tags>,
    /// What is shown of each answer.
    pub observes: Observes,
    moved: Vec<GranuleEvent>,
}

impl TagsAdapter {
    /// The tags of a configuration, which observe all.
    ///
    /// # Errors
    /// The key that is not supported.
    pub fn new(config: &str, make: &MakeTags) -> Result<Self, Error> {
        let config = config::parse(config)?;
        Ok(Self { config, tags: make(&config)?, observes: Observes::ALL, moved: Vec::new() })
    }

    /// The set of an address, for a person.
    #[must_use]
    pub fn shown(&self, host: u32) -> Vec<String> {
        self.tags.shown(self.config.cache.geometry.line_of(HostAddr(host)))
    }

    fn read(&mut self, host: HostAddr, answer: &mut Vec<u8>) {
        let geometry = self.config.cache.geometry;
        let line = geometry.line_of(host);
        let outcome = self.tags.access(line, &mut self.moved);
        let start = geometry.card_addr(self.config.cache.set_of(line), outcome.way());
        let Observes { hit, card, evict, .. } = self.observes;
        answer.extend_from_slice(match outcome {
            _ if !hit => b"- ",
            Outcome::Hit { .. } => b"h ",
            Outcome::Miss { .. } => b"m ",
        });
        push_seen(answer, Some(start.0 + geometry.offset_of(host)).filter(|_| card));
        if let Outcome::Miss { evicted, .. } = outcome {
            answer.push(b' ');
            push_seen(answer, evicted.filter(|_| evict).map(|line| geometry.first_byte(line).0));
        }
    }
}

/// Appends a number, or `-` for none.
fn push_seen(answer: &mut Vec<u8>, number: Option<u32>) {
    match number {
        Some(number) => hex::push_number(answer, u64::from(number)),
        None => answer.push(b'-'),
    }
}

impl Implementation for TagsAdapter {
    fn observes(&self) -> String {
        self.observes.to_string()
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let request = Request::parse(request)?;
        super::fits(&self.config, request)?;
        self.moved.clear();
        match request {
            Request::Read { host } => self.read(HostAddr(host), answer),
            Request::Invalidate { host, len } => {
                self.tags.invalidate(HostAddr(host), len, &mut self.moved);
                answer.extend_from_slice(b"ok");
            }
            Request::Flush => self.tags.flush(),
            Request::Flip { byte, mask } => self.tags.flip(byte as usize, mask),
        }
        match request {
            Request::Flush | Request::Flip { .. } => answer.extend_from_slice(b"ok"),
            Request::Read { .. } | Request::Invalidate { .. } if self.observes.meta => {
                answer.push(b' ');
                push_moved(answer, &self.moved, self.observes.bytes);
            }
            Request::Read { .. } | Request::Invalidate { .. } => answer.extend_from_slice(b" -"),
        }
        Ok(())
    }
}
