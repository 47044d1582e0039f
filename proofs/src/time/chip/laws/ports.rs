//! The law of the ports of a first-level cache: who is looked up when (CH-8).

use super::{Law, Verdict, pipeline};
use saarcor_model::time::{Chip, ChipConfig, State};

/// A first-level cache looks up at most as many lines a cycle as it has ports, and as many where so many ask.
/// Of pipelines of which threads ask all the while, none is passed over while another one is served twice, and
/// of threads of a pipeline neither (CH-8).
pub struct Ports<'a> {
    config: &'a ChipConfig,
    asking: Vec<bool>,
    accesses: [u64; 4],
    /// For each thread that asks, the threads of its pipeline that were served since it does, and the
    /// pipelines that were served since its own was, which asks.
    served: Vec<Vec<usize>>,
    pipelines: [Vec<Vec<usize>>; 4],
    /// Whether threads wait for a register of each cache.
    queued: [bool; 4],
}

impl<'a> Ports<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        Self {
            config,
            asking: vec![false; pipelines * threads],
            accesses: [0; 4],
            served: vec![Vec::new(); pipelines * threads],
            pipelines: [(); 4].map(|()| vec![Vec::new(); pipelines]),
            queued: [false; 4],
        }
    }

    fn of_cache(&mut self, cache: usize, chip: &Chip) -> Verdict {
        let threads = 0..chip.threads.len();
        let own = |&number: &usize| chip.threads[number].works_for(cache);
        let asked = |number: &usize| self.asking[*number];
        let still_asks = |number: &usize| chip.threads[*number].state == State::Asks;
        let pipeline = |number: usize| pipeline(self.config, number);
        // Those that asked before the phase.
        let served: Vec<usize> =
            threads.clone().filter(own).filter(asked).filter(|number| !still_asks(number)).collect();
        let passed: Vec<usize> = threads.clone().filter(own).filter(asked).filter(still_asks).collect();
        let joined =
            threads.filter(own).filter(asked).filter(|&number| chip.threads[number].state == State::Queued);
        let accesses = chip.first_level[cache].report.accesses;
        let looked_up = accesses - self.accesses[cache] + joined.count() as u64;
        self.accesses[cache] = accesses;
        let ports = u64::from(self.config.l1[cache].ports);
        demand!(looked_up <= ports, "{looked_up} look-ups through {ports} ports of cache {cache}");
        let idle = looked_up < ports && !passed.is_empty();
        // A thread that was in the queue, asked again and joined it once more is not counted.
        demand!(
            !idle || ports > 1 && !chip.first_level[cache].queue.is_empty(),
            "cache {cache} passes {passed:?} over"
        );
        // Which threads of the queue asked again between two ports is not to be seen.
        if ports > 1 && (self.queued[cache] || !chip.first_level[cache].queue.is_empty()) {
            self.pipelines[cache].iter_mut().for_each(Vec::clear);
            passed.iter().for_each(|&thread| self.served[thread].clear());
            return Ok(());
        }
        for &other in &passed {
            for &thread in served.iter().filter(|&&thread| pipeline(thread) == pipeline(other)) {
                let twice = self.served[other].contains(&thread);
                demand!(!twice, "cache {cache} served thread {thread} twice while thread {other} asked");
                self.served[other].push(thread);
            }
        }
        for own in 0..self.config.pipelines as usize {
            let is_own = |&&thread: &&usize| pipeline(thread) == own;
            let since = &mut self.pipelines[cache][own];
            if !passed.iter().any(|thread| is_own(&thread)) || served.iter().any(|thread| is_own(&thread)) {
                since.clear();
                continue;
            }
            for other in served.iter().map(|&thread| pipeline(thread)) {
                demand!(
                    !since.contains(&other),
                    "cache {cache} served pipeline {other} twice while {own} asked"
                );
                since.push(other);
            }
        }
        Ok(())
    }
}

impl Law for Ports<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 6 {
            self.queued = [0, 1, 2, 3].map(|cache: usize| !chip.first_level[cache].queue.is_empty());
            for (number, thread) in chip.threads.iter().enumerate() {
                let asks = thread.state == State::Asks;
                if asks && !self.asking[number] {
                    self.served[number].clear();
                }
                self.asking[number] = asks;
            }
        }
        if phase == 7 {
            for cache in 0..4 {
                self.of_cache(cache, chip)?;
            }
            for (number, thread) in chip.threads.iter().enumerate() {
                self.asking[number] &= thread.state == State::Asks;
            }
        }
        Ok(())
    }
}
