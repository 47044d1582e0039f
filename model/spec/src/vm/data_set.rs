//! One set of a cache on the chip: of a first-level cache, which is only read, and of the metadata
//! cache of version B, which is also written and writes back (§3, §4).

use super::set::{Outcome, Policy, Set};
use super::units::{LineAddr, Way};

/// One set with the contents of its lines.
///
/// `Line` is what is kept of a line: its bytes, `[u8; N]`, or `()` where only the decisions matter.
/// The fields are public and [`DataSet::is_valid`] says which values are legal, so that a proof
/// can start from any legal state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataSet<const WAYS: usize, Line> {
    /// Which line lies in which way.
    pub set: Set<WAYS>,
    /// Whether the line in each way has been written to since it was loaded.
    pub dirty: [bool; WAYS],
    /// The contents of the line in each way.
    pub contents: [Line; WAYS],
}

/// A dirty line that is evicted: it has to be written to the memory behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteBack<Line> {
    /// The line.
    pub line: LineAddr,
    /// Its contents.
    pub contents: Line,
}

impl<const WAYS: usize, Line: Copy> DataSet<WAYS, Line> {
    /// A set without lines, whose ways all hold `contents`, which nobody reads.
    #[must_use]
    pub fn empty(policy: Policy, contents: Line) -> Self {
        Self { set: Set::empty(policy), dirty: [false; WAYS], contents: [contents; WAYS] }
    }

    /// The invariant: the set's own, and only resident lines are dirty.
    #[must_use]
    pub fn is_valid(&self, policy: Policy) -> bool {
        let mut valid = self.set.is_valid(policy);
        for way in 0..WAYS {
            valid &= self.set.resident[way] || !self.dirty[way];
        }
        valid
    }

    /// The step: uses `line`, whose contents are `load`ed if it is not resident. A dirty line that
    /// is evicted is returned to be written back; a clean one is dropped.
    ///
    /// `load` runs before the write-back. That is safe: it reads `line`, never the evicted line.
    #[must_use]
    pub fn access(
        &self,
        line: LineAddr,
        policy: Policy,
        load: impl FnOnce() -> Line,
    ) -> (Self, Outcome, Option<WriteBack<Line>>) {
        let (set, outcome) = self.set.access(line, policy);
        let mut next = Self { set, ..*self };
        let mut write_back = None;
        if let Outcome::Miss { way, evicted } = outcome {
            let way = usize::from(way.0);
            if let (Some(line), true) = (evicted, self.dirty[way]) {
                write_back = Some(WriteBack { line, contents: self.contents[way] });
            }
            next.contents[way] = load();
            next.dirty[way] = false;
        }
        (next, outcome, write_back)
    }

    /// Replaces the contents of the resident line in `way`.
    #[must_use]
    pub fn write(&self, way: Way, contents: Line) -> Self {
        let mut next = *self;
        next.contents[usize::from(way.0)] = contents;
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
