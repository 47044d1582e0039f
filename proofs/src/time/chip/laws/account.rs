//! The law by which cycles are counted (CH-18).

use super::{Law, Verdict};
use saarcor_model::time::{Chip, ChipConfig, Stall, State, TimingReport, Version};

/// In each cycle each unit is busy, stalled or idle: busy while rays go in, stalled by the first cause that
/// holds for a thread of its pipeline, idle else. Counts of all cycles add up to the report (CH-18).
pub struct Account<'a> {
    config: &'a ChipConfig,
    free: Vec<u64>,
    /// Of each unit: cycles that it was busy, stalled by each cause, and idle.
    units: Vec<[u64; 7]>,
}

impl<'a> Account<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        let units = 4 * config.pipelines as usize;
        Self { config, free: vec![0; units], units: vec![[0; 7]; units] }
    }
}

impl Law for Account<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase != 8 {
            return Ok(());
        }
        let threads = self.config.threads as usize;
        for (place, counts) in self.units.iter_mut().enumerate() {
            let own = &chip.threads[place / 4 * threads..(place / 4 + 1) * threads];
            let own = || own.iter().filter(|thread| thread.works_for(place % 4));
            // A unit takes one thread at a time: the one that it works for decides until when rays go in.
            let latency = u64::from(self.config.units[place % 4].latency);
            for thread in own() {
                if let State::Works { done } = thread.state {
                    self.free[place] = self.free[place].max(done - latency);
                }
            }
            let stalled = |of: fn(State) -> bool| own().any(|thread| of(thread.state));
            let cause = if self.free[place] > chip.now {
                0
            } else if stalled(|state| matches!(state, State::LooksUp { .. })) {
                1
            } else if stalled(|state| state == State::Asks) {
                2
            } else if stalled(|state| state == State::Queued) {
                3
            } else {
                // A line comes from the host while a part of it waits for a load.
                let from_host = own().filter(|thread| thread.state == State::Waits).map(|thread| {
                    let line = thread.lines[0];
                    let mut parts = chip.loads.waiting.iter().map(|(_, waiting)| waiting.part);
                    parts.any(|part| part.cache == place % 4 && part.line == line)
                });
                match from_host.min() {
                    Some(false) => 4,
                    Some(true) => 5,
                    None => 6,
                }
            };
            counts[cause] += 1;
        }
        Ok(())
    }

    fn reported(&mut self, report: &TimingReport) -> Verdict {
        for (kind, unit) in report.units.iter().enumerate() {
            let own = self.units.iter().skip(kind).step_by(4);
            let sum = own.fold([0; 7], |sum, unit| std::array::from_fn(|cause| sum[cause] + unit[cause]));
            let [look_up, port, register, memory, host] = unit.stalls;
            let got = [unit.busy, look_up, port, register, memory, host, unit.idle];
            demand!(got == sum, "units {kind}: {got:?}, not {sum:?}");
            let all = unit.busy + unit.stalled() + unit.idle;
            let cycles = report.cycles * u64::from(self.config.pipelines);
            demand!(all == cycles, "units {kind}: busy, stalled and idle for {all} of {cycles} cycles");
            let host = unit.stalls[Stall::Host as usize];
            let from_host = self.config.version != Version::None || host == 0;
            demand!(from_host, "units {kind} wait {host} cycles for a host that loads nothing");
        }
        Ok(())
    }
}
