//! The virtual memory as a Rust type: what an implementation in process provides.

use super::config;
use super::request::{Observes, Request};
use crate::error::Error;
use crate::hex;
use crate::implementation::Implementation;
use saarcor_model::vm::{CacheConfig, CardAddr, HostAddr};

/// What a read did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Where on the card the first byte lies.
    pub card: CardAddr,
    /// What it took.
    pub outcome: Outcome,
}

/// Whether a read found its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The line was resident.
    Hit,
    /// The line was loaded; the first address of the one evicted for it, if any was.
    Miss(Option<HostAddr>),
}

/// An implementation of the virtual memory with its host's memory, which is zero at first.
pub trait Cache: Send {
    /// The host writes its memory.
    fn write(&mut self, host: HostAddr, bytes: &[u8]);

    /// The chip reads bytes that lie within one line.
    fn read(&mut self, host: HostAddr, bytes: &mut [u8]) -> Access;

    /// Invalidates every line that the range meets.
    fn invalidate(&mut self, host: HostAddr, len: u64);

    /// Invalidates all lines.
    fn flush(&mut self);
}

/// Makes an empty cache; where it does not support a value, it fails with [`Error::Unsupported`] and the key.
pub type MakeCache = dyn Fn(&CacheConfig) -> Result<Box<dyn Cache>, Error> + Sync;

/// A cache that speaks `saarcor-vm`.
pub struct CacheAdapter {
    cache: Box<dyn Cache>,
    line_bytes: u64,
    /// What is shown of each answer.
    pub observes: Observes,
    bytes: Vec<u8>,
}

impl CacheAdapter {
    /// The cache of a configuration, which observes all.
    ///
    /// # Errors
    /// The key that is not supported.
    pub fn new(config: &str, make: &MakeCache) -> Result<Self, Error> {
        let config = config::parse(config)?;
        let line_bytes = config.geometry.line().0;
        Ok(Self { cache: make(&config)?, line_bytes, observes: Observes::ALL, bytes: Vec::new() })
    }

    fn read(&mut self, host: u32, len: u32, answer: &mut Vec<u8>) {
        self.bytes.resize(len as usize, 0);
        let Access { card, outcome } = self.cache.read(HostAddr(host), &mut self.bytes);
        let Observes { data, hit, card: card_seen, evict } = self.observes;
        let number = |answer: &mut Vec<u8>, number: Option<u32>| {
            answer.push(b' ');
            match number {
                Some(number) => hex::push_number(answer, u64::from(number)),
                None => answer.push(b'-'),
            }
        };
        answer.push(match outcome {
            _ if !hit => b'-',
            Outcome::Hit => b'h',
            Outcome::Miss(_) => b'm',
        });
        number(answer, card_seen.then_some(card.0));
        if let Outcome::Miss(evicted) = outcome {
            number(answer, evicted.filter(|_| evict).map(|evicted| evicted.0));
        }
        answer.push(b' ');
        if data {
            hex::push_bytes(answer, &self.bytes);
        } else {
            answer.push(b'-');
        }
    }
}

impl Implementation for CacheAdapter {
    fn observes(&self) -> String {
        self.observes.to_string()
    }

    #[inline]
    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let request = Request::parse(request)?;
        if !request.fits(self.line_bytes) {
            return Err("a read lies within one line".into());
        }
        match request {
            Request::Read { host, len } => self.read(host, len, answer),
            other => {
                play(&mut *self.cache, &other, &mut self.bytes);
                answer.extend_from_slice(b"ok");
            }
        }
        Ok(())
    }
}

/// Gives a request to a cache, and drops the answer.
pub fn play(cache: &mut dyn Cache, request: &Request<'_>, bytes: &mut Vec<u8>) {
    match *request {
        Request::Write { host, digits } => {
            bytes.clear();
            hex::extend_bytes(bytes, digits);
            cache.write(HostAddr(host), bytes);
        }
        Request::Read { host, len } => {
            bytes.resize(len as usize, 0);
            cache.read(HostAddr(host), bytes);
        }
        Request::Invalidate { host, len } => cache.invalidate(HostAddr(host), len),
        Request::Flush => cache.flush(),
    }
}
