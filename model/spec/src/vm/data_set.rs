//! One set of a cache that holds the bytes of its lines: of a first-level cache, which is only
//! read, and of the metadata cache of version B, which is written too and writes back (§3, §4).

use super::set::{Outcome, Policy, Set};
use super::units::{LineAddr, Way};

/// One set with the bytes of its lines, `BYTES` a line.
///
/// The fields are public and [`DataSet::is_valid`] says which values are legal, so that a proof
/// can start from any legal state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataSet<const WAYS: usize, const BYTES: usize> {
    /// Which line lies in which way.
    pub set: Set<WAYS>,
    /// Whether the line in each way has been written to since it was loaded.
    pub dirty: [bool; WAYS],
    /// The bytes of the line in each way.
    pub bytes: [[u8; BYTES]; WAYS],
}

/// A line that has to be written to the memory behind, because its way is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteBack<const BYTES: usize> {
    /// The line.
    pub line: LineAddr,
    /// Its bytes.
    pub bytes: [u8; BYTES],
}

impl<const WAYS: usize, const BYTES: usize> DataSet<WAYS, BYTES> {
    /// A set without lines.
    #[must_use]
    pub fn empty(policy: Policy) -> Self {
        Self { set: Set::empty(policy), dirty: [false; WAYS], bytes: [[0; BYTES]; WAYS] }
    }

    /// The invariant: the set's own, and only resident lines are dirty.
    #[must_use]
    pub fn is_valid(&self, policy: Policy) -> bool {
        let mut valid = self.set.is_valid(policy);
        for way in 0..WAYS {
            valid &= self.set.resident[way] | !self.dirty[way];
        }
        valid
    }

    /// The step: uses `line`, whose bytes are `load`ed where it is not resident. A dirty line that
    /// is evicted is handed over to be written back; a clean one is dropped.
    ///
    /// `load` is called before the write-back: the memory behind still has the evicted line's
    /// old bytes, which are another line's.
    #[must_use]
    pub fn access(
        &self,
        line: LineAddr,
        policy: Policy,
        load: impl FnOnce() -> [u8; BYTES],
    ) -> (Self, Outcome, Option<WriteBack<BYTES>>) {
        let (set, outcome) = self.set.access(line, policy);
        let mut next = Self { set, ..*self };
        let mut write_back = None;
        if let Outcome::Miss { way, evicted } = outcome {
            let way = usize::from(way.0);
            if let (Some(line), true) = (evicted, self.dirty[way]) {
                write_back = Some(WriteBack { line, bytes: self.bytes[way] });
            }
            next.bytes[way] = load();
            next.dirty[way] = false;
        }
        (next, outcome, write_back)
    }

    /// Writes the bytes of the resident line in `way`.
    #[must_use]
    pub fn write(&self, way: Way, bytes: [u8; BYTES]) -> Self {
        let mut next = *self;
        next.bytes[usize::from(way.0)] = bytes;
        next.dirty[usize::from(way.0)] = true;
        next
    }

    /// Forgets `line`; what was written to it is lost.
    #[must_use]
    pub fn invalidate(&self, line: LineAddr) -> (Self, Option<Way>) {
        let (set, way) = self.set.invalidate(line);
        let mut next = Self { set, ..*self };
        if let Some(way) = way {
            next.dirty[usize::from(way.0)] = false;
        }
        (next, way)
    }
}
