//! The law by which packets are handed out (CH-4).

use super::{Law, Verdict, pipeline};
use saarcor_model::time::{Chip, ChipConfig, Programs, State};

/// Packets are handed out in order, one a cycle while a thread is free, to the pipelines in turn, and there
/// to the free thread of the lowest number (CH-4).
pub struct HandOut<'a> {
    config: &'a ChipConfig,
    programs: &'a Programs,
    handed_out: usize,
    last: Option<usize>,
    free: Vec<bool>,
}

impl<'a> HandOut<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig, programs: &'a Programs) -> Self {
        Self { config, programs, handed_out: 0, last: None, free: Vec::new() }
    }

    /// The thread that gets the next packet.
    fn next(&self) -> Option<usize> {
        let pipelines = self.config.pipelines as usize;
        let first = self.last.map_or(0, |last| last + 1);
        let in_turn = (first..first + pipelines).map(|pipeline| pipeline % pipelines);
        let threads = self.config.threads as usize;
        in_turn
            .flat_map(|pipeline| pipeline * threads..(pipeline + 1) * threads)
            .find(|&thread| self.free[thread])
    }
}

impl Law for HandOut<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 4 {
            self.free.clear();
            self.free.extend(chip.threads.iter().map(|thread| thread.state == State::Free));
        }
        if phase != 5 {
            return Ok(());
        }
        let packet = self.programs.packets.get(self.handed_out);
        let next = packet.and_then(|packet| Some((self.next()?, packet)));
        for (number, thread) in chip.threads.iter().enumerate() {
            match next {
                Some((own, packet)) if own == number => {
                    let has_it = std::ptr::eq(thread.program, &**packet) && thread.state != State::Free;
                    let nothing = packet.is_empty() && thread.state == State::Free;
                    demand!(has_it || nothing, "packet {} is not thread {number}'s", self.handed_out);
                }
                _ => {
                    let still = (thread.state == State::Free) == self.free[number];
                    demand!(still, "thread {number} got a packet out of turn");
                }
            }
        }
        if let Some((thread, _)) = next {
            self.handed_out += 1;
            self.last = Some(pipeline(self.config, thread));
        }
        let left = self.programs.packets.len() - self.handed_out;
        demand!(chip.packets.len() == left, "{} packets are left, and not {left}", chip.packets.len());
        Ok(())
    }
}
