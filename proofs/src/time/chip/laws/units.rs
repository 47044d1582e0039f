//! The law of the functional units (CH-6).

use super::{Law, Verdict};
use saarcor_model::time::{Chip, ChipConfig, State};

/// A unit takes a ready thread whenever it is free, is busy for the cycles in which the rays go in, and at
/// least one, and ends its latency after that. Of threads that are ready all the while, none is passed over
/// while another one is served twice (CH-6).
pub struct Units<'a> {
    config: &'a ChipConfig,
    /// The cycle from which on each unit is free.
    free: Vec<u64>,
    ready: Vec<bool>,
    /// For each ready thread, those that its unit took since it is.
    taken: Vec<Vec<usize>>,
}

impl<'a> Units<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        Self {
            config,
            free: vec![0; 4 * pipelines],
            ready: vec![false; pipelines * threads],
            taken: vec![Vec::new(); pipelines * threads],
        }
    }
}

impl Law for Units<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 5 {
            for (number, thread) in chip.threads.iter().enumerate() {
                let ready = thread.state == State::Ready;
                if ready && !self.ready[number] {
                    self.taken[number].clear();
                }
                self.ready[number] = ready;
            }
        }
        if phase != 6 {
            return Ok(());
        }
        for place in 0..4 * self.config.pipelines as usize {
            let (own, kind) = (place / 4, place % 4);
            let threads = self.config.threads as usize;
            let waiting = |number: &usize| self.ready[*number] && chip.threads[*number].works_for(kind);
            let waiting: Vec<usize> = (own * threads..(own + 1) * threads).filter(waiting).collect();
            let is_taken = |number: &usize| chip.threads[*number].state != State::Ready;
            let taken: Vec<usize> = waiting.iter().copied().filter(is_taken).collect();
            let is_free = self.free[place] <= chip.now;
            let expected = usize::from(is_free && !waiting.is_empty());
            demand!(
                taken.len() == expected,
                "unit {place}, free {is_free}: it took {taken:?} of {waiting:?}"
            );
            let Some(&thread) = taken.first() else { continue };
            let (rays, rate) = (chip.threads[thread].program[0].rays, self.config.units[kind].rays_a_cycle);
            let cycles = u64::from(rays).div_ceil(u64::from(rate));
            self.free[place] = chip.now + cycles.max(1);
            let done = self.free[place] + u64::from(self.config.units[kind].latency);
            let state = chip.threads[thread].state;
            demand!(
                state == State::Works { done },
                "{rays} rays, {rate} a cycle, done at {done}, but {state:?}"
            );
            for other in waiting.into_iter().filter(|&other| other != thread) {
                let twice = self.taken[other].contains(&thread);
                demand!(!twice, "unit {place} took thread {thread} twice while thread {other} was ready");
                self.taken[other].push(thread);
            }
            self.ready[thread] = false;
        }
        Ok(())
    }
}
