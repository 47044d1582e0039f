//! The laws of lines in flight: who waits for them and for their registers, and when they arrive (CH-10, CH-11, CH-16).

use super::{Law, Verdict};
use saarcor_model::time::{Chip, ChipConfig, Span, State, TransferId};
use saarcor_model::vm::LineAddr;
use std::collections::VecDeque;

/// No line is in flight twice, and no more lines than there are registers. Each thread that waits for a line
/// is among those of that line, once, and nobody else is; each that waits for a register is in the queue,
/// once (CH-10, CH-11). So none waits for what nobody answers.
pub struct Waiting<'a> {
    config: &'a ChipConfig,
}

impl<'a> Waiting<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config }
    }
}

impl Law for Waiting<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if !matches!(phase, 2 | 7) {
            return Ok(());
        }
        for (cache, l1) in chip.first_level.iter().enumerate() {
            let registers = self.config.l1[cache].mshrs as usize;
            demand!(
                l1.in_flight.len() <= registers,
                "{} lines in flight, {registers} registers",
                l1.in_flight.len()
            );
            for (place, line) in l1.in_flight.iter().enumerate() {
                let twice = l1.in_flight[..place].iter().any(|other| other.line == line.line);
                demand!(!twice, "cache {cache} fetches line {:?} twice", line.line);
            }
            let (mut waits, mut queued) = (vec![0; chip.threads.len()], vec![0; chip.threads.len()]);
            for line in &l1.in_flight {
                for &number in &line.threads {
                    let asked = chip.threads[number].lines.front();
                    demand!(
                        asked == Some(&line.line),
                        "thread {number} waits for {:?}, and asked for {asked:?}",
                        line.line
                    );
                    waits[number] += 1;
                }
            }
            for &number in &l1.queue {
                queued[number] += 1;
            }
            for (number, thread) in chip.threads.iter().enumerate() {
                let is = |state| u32::from(thread.state == state && thread.works_for(cache));
                let (waits, queued) = (waits[number], queued[number]);
                let right = waits == is(State::Waits) && queued == is(State::Queued);
                demand!(
                    right,
                    "thread {number}, {:?}, waits for {waits} lines and {queued} registers",
                    thread.state
                );
            }
        }
        Ok(())
    }
}

/// A thread joins the queue only while all registers are taken, and for a line that is neither resident nor in
/// flight. The queue is served in its order, whenever a line arrives and after each look-up that leaves a
/// register free (CH-11).
pub struct Queue<'a> {
    config: &'a ChipConfig,
    queues: [VecDeque<usize>; 4],
    in_flight: [usize; 4],
    accesses: [u64; 4],
}

impl<'a> Queue<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config, queues: Default::default(), in_flight: [0; 4], accesses: [0; 4] }
    }
}

impl Law for Queue<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if !matches!(phase, 2 | 7) {
            return Ok(());
        }
        for (cache, l1) in chip.first_level.iter().enumerate() {
            let before = std::mem::replace(&mut self.queues[cache], l1.queue.clone());
            let stayed = before.iter().filter(|number| l1.queue.contains(number)).count();
            let left = before.len() - stayed;
            let in_order = before.iter().skip(left).eq(l1.queue.iter().take(stayed));
            let is_full = l1.in_flight.len() == self.config.l1[cache].mshrs as usize;
            let accesses =
                l1.report.accesses - std::mem::replace(&mut self.accesses[cache], l1.report.accesses);
            let arrived = self.in_flight[cache].saturating_sub(l1.in_flight.len());
            self.in_flight[cache] = l1.in_flight.len();
            // With several ports one may ask again and join once more.
            let once = phase == 2 || self.config.l1[cache].ports == 1;
            demand!(in_order || !once, "queue {before:?} of cache {cache} became {:?}", l1.queue);
            if phase == 2 {
                let served = left == arrived.min(before.len());
                demand!(served, "{arrived} lines arrived at cache {cache}, and {left} of {before:?} left");
                continue;
            }
            // If one is free in the end, each look-up has left one free.
            let asks = (accesses as usize).min(before.len());
            demand!(
                is_full || left == asks,
                "{accesses} look-ups leave a register of cache {cache} free, and {left} of {before:?} ask again"
            );
            for &number in l1.queue.iter().skip(stayed) {
                let line = chip.threads[number].lines[0];
                let in_flight = l1.in_flight.iter().any(|other| other.line == line);
                let waits_in_vain = is_full && !in_flight && (!l1.cache.is_resident(line) || !once);
                demand!(waits_in_vain, "thread {number} waits for a register for {line:?}, full {is_full}");
            }
        }
        Ok(())
    }
}

/// A line in flight arrives as soon as the return latency has passed since the last beat of its parts, and not
/// before (CH-16).
pub struct Arrivals<'a> {
    config: &'a ChipConfig,
    /// Lines in flight to each cache, and the reads of their parts, if all are read.
    in_flight: [Vec<(LineAddr, Option<Vec<TransferId>>)>; 4],
}

impl<'a> Arrivals<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config, in_flight: Default::default() }
    }
}

impl Law for Arrivals<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 2 {
            for (cache, lines) in self.in_flight.iter().enumerate() {
                for (line, reads) in lines {
                    let is_here = |reads: &Vec<_>| {
                        let here = |span: Span| chip.now >= span.end + u64::from(self.config.return_latency);
                        reads.iter().all(|&read| chip.sdram.span_of(read).is_some_and(here))
                    };
                    let due = reads.as_ref().is_some_and(is_here);
                    let arrived = chip.first_level[cache].in_flight.iter().all(|other| other.line != *line);
                    demand!(due == arrived, "{line:?} of cache {cache}: due {due}, arrived {arrived}");
                }
            }
        }
        if phase == 8 {
            for (cache, lines) in self.in_flight.iter_mut().enumerate() {
                lines.clear();
                lines.extend(
                    chip.first_level[cache]
                        .in_flight
                        .iter()
                        .map(|line| (line.line, (line.unread == 0).then(|| line.reads.clone()))),
                );
            }
        }
        Ok(())
    }
}
