//! A thread, which works on one packet at a time.

use crate::time::operation::Operation;
use crate::vm::LineAddr;
use std::collections::VecDeque;

/// What a thread is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// It has no packet.
    Free,
    /// It asks its first-level cache for a look-up.
    Asks,
    /// Its line is resident; the cache answers in cycle `answer`.
    LooksUp { answer: u64 },
    /// It waits for a register of its first-level cache.
    Queued,
    /// It waits for a line in flight.
    Waits,
    /// Its bytes are there: it waits for its unit.
    Ready,
    /// Its unit works for it, and is done in cycle `done`.
    Works { done: u64 },
}

/// A thread and its packet.
#[derive(Clone, Debug)]
pub(super) struct Thread<'a> {
    pub(super) state: State,
    /// What is left of the packet's program; first the operation at hand.
    pub(super) program: &'a [Operation],
    /// First-level lines of the operation at hand that have not come yet.
    pub(super) lines: VecDeque<LineAddr>,
}

impl Thread<'_> {
    /// A thread without a packet.
    pub(super) const FREE: Self = Self { state: State::Free, program: &[], lines: VecDeque::new() };

    /// Whether its operation at hand is one of the units of type `kind`.
    pub(super) fn works_for(&self, kind: usize) -> bool {
        self.program.first().is_some_and(|operation| operation.unit as usize == kind)
    }
}
