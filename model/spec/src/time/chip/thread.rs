//! A thread, which works on one packet at a time.

use crate::time::operation::Operation;
use crate::vm::LineAddr;
use std::collections::VecDeque;

/// What a thread is doing (CH-7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It has no packet.
    Free,
    /// It asks its first-level cache for a look-up.
    Asks,
    /// Its line is resident, and the cache is about to answer.
    LooksUp {
        /// The cycle in which it does.
        answer: u64,
    },
    /// It waits for a register of its first-level cache.
    Queued,
    /// It waits for a line in flight.
    Waits,
    /// Its bytes are there: it waits for its unit.
    Ready,
    /// Its unit works for it.
    Works {
        /// The cycle in which the operation ends.
        done: u64,
    },
}

/// A thread and its packet (§2, Stated).
#[derive(Clone, Debug)]
pub struct Thread<'a> {
    /// What it is doing.
    pub state: State,
    /// What is left of the packet's program; first the operation at hand.
    pub program: &'a [Operation],
    /// First-level lines of the operation at hand that have not come yet.
    pub lines: VecDeque<LineAddr>,
}

impl Thread<'_> {
    /// A thread without a packet.
    pub const FREE: Self = Self { state: State::Free, program: &[], lines: VecDeque::new() };

    /// Whether its operation at hand is one of the units of type `kind`.
    pub fn works_for(&self, kind: usize) -> bool {
        self.program.first().is_some_and(|operation| operation.unit as usize == kind)
    }
}
