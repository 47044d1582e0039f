//! What each unit does in a cycle (CH-18).

use super::Chip;
use super::thread::{State, Thread};
use crate::time::report::Stall;

impl Chip<'_> {
    /// Counts the cycle for each unit: busy, stalled by the first cause that holds for any thread of its
    /// pipeline, or idle.
    pub(super) fn account(&mut self) {
        for place in 0..self.units.len() {
            let (pipeline, kind) = (place / 4, place % 4);
            let waiting = self.threads_of(pipeline).filter(|&thread| self.threads[thread].works_for(kind));
            let stalls: Vec<Stall> = waiting.filter_map(|thread| self.stall(&self.threads[thread])).collect();
            let first = Stall::ALL.into_iter().find(|stall| stalls.contains(stall));
            let report = &mut self.report.units[kind];
            match first {
                _ if self.units[place].free > self.now => report.busy += 1,
                Some(stall) => report.stalls[stall as usize] += 1,
                None => report.idle += 1,
            }
        }
    }

    /// What a thread waits for, if it waits for bytes.
    fn stall(&self, thread: &Thread) -> Option<Stall> {
        match thread.state {
            State::LooksUp { .. } => Some(Stall::LookUp),
            State::Asks => Some(Stall::Port),
            State::Queued => Some(Stall::Mshr),
            State::Waits => {
                let (cache, line) = (thread.program[0].unit as usize, thread.lines[0]);
                let mut parts = self.loads.waiting.iter().map(|(_, waiting)| waiting.part);
                let comes_from_host = parts.any(|part| (part.cache, part.line) == (cache, line));
                Some(if comes_from_host { Stall::Host } else { Stall::Memory })
            }
            State::Free | State::Ready | State::Works { .. } => None,
        }
    }
}
