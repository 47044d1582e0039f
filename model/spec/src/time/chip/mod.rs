//! The chip in time, cycle by cycle (CH-1 to CH-20).
//!
//! In each cycle all parts of the chip are asked, in the eight phases of CH-5, what they do. A phase
//! sees what earlier phases of the same cycle did.

mod bus_manager;
mod first_level;
mod loads;
mod stalls;
mod tags;
mod thread;
mod turn;

use super::config::{ChipConfig, ConfigError};
use super::operation::{Operation, Programs};
use super::pci::Pci;
use super::report::TimingReport;
use super::sdram::Sdram;
use crate::vm::{Outcome, Unit};
use bus_manager::PendingTag;
pub use bus_manager::PlacedPart;
pub use first_level::{Answer, FirstLevelInTime, LineInFlight, LinePart};
pub use loads::{CardAccess, Load, LoadId, Loads};
use std::collections::VecDeque;
use tags::{Tags, tags};
pub use thread::{State, Thread};
pub use turn::Turn;

/// Plays `programs` on the chip. Its caches hold what the pictures `before` left in them (CH-19);
/// without any, they are empty.
///
/// # Errors
/// If the configuration makes no chip.
pub fn simulate(
    before: &[Programs],
    programs: &Programs,
    config: &ChipConfig,
) -> Result<TimingReport, ConfigError> {
    let mut chip = Chip::new(before, programs, config)?;
    while !chip.cycle(|_, _| ()) {}
    Ok(chip.report())
}

/// A functional unit of a pipeline (CH-6).
#[derive(Clone, Copy, Debug, Default)]
pub struct FunctionalUnit {
    /// The threads of its pipeline, in turn.
    pub turn: Turn,
    /// First cycle in which it can take rays.
    pub free: u64,
}

/// A chip at work on a picture, which [`simulate`] runs to its end.
///
/// Threads and units have one number each: thread `t` of pipeline `p` is `p × threads + t`, and the unit
/// of type `u` in pipeline `p` is `4 p + u`. First-level caches have the numbers of their units' types.
pub struct Chip<'a> {
    config: &'a ChipConfig,
    /// The cycle at hand.
    pub now: u64,
    /// Packets that are not handed out yet.
    pub packets: VecDeque<&'a [Operation]>,
    /// Pipelines that get a packet, in turn.
    pipelines: Turn,
    /// The threads.
    pub threads: Vec<Thread<'a>>,
    /// The units of all pipelines.
    pub units: Vec<FunctionalUnit>,
    /// The first-level caches.
    pub first_level: [FirstLevelInTime; 4],
    /// First-level caches from which the bus manager takes a part, in turn.
    caches: Turn,
    tags: Box<dyn Tags>,
    /// Parts whose tags are looked up, in order.
    pending: VecDeque<PendingTag>,
    /// The loads from the host, and the parts that wait for them.
    pub loads: Loads<PlacedPart>,
    /// What was written to the lines on the card, and read from them, in the order of the memory chips.
    pub card: Vec<CardAccess>,
    /// The bus to the host.
    pub pci: Pci,
    /// The on-board memory.
    pub sdram: Sdram,
    /// What was counted so far, but for the cycles and the first-level caches.
    pub report: TimingReport,
}

impl<'a> Chip<'a> {
    /// The chip before the first cycle, its caches as in [`simulate`].
    ///
    /// # Errors
    /// If the configuration makes no chip.
    pub fn new(
        before: &[Programs],
        programs: &'a Programs,
        config: &'a ChipConfig,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        let mut chip = Self {
            config,
            now: 0,
            packets: programs.packets.iter().map(|packet| &**packet).collect(),
            pipelines: Turn::default(),
            threads: vec![Thread::FREE; pipelines * threads],
            units: vec![FunctionalUnit::default(); 4 * pipelines],
            first_level: Unit::ALL.map(|unit| {
                FirstLevelInTime::new(programs.first_level_base(unit), config.l1[unit as usize], pipelines)
            }),
            caches: Turn::default(),
            tags: tags(config),
            pending: VecDeque::new(),
            loads: Loads::default(),
            card: Vec::new(),
            pci: Pci::new(config.pci),
            sdram: Sdram::new(config.sdram),
            report: TimingReport::default(),
        };
        for operation in before.iter().flat_map(Programs::in_order) {
            chip.warm(operation);
        }
        Ok(chip)
    }

    /// What an operation of an earlier picture leaves in the caches (CH-19).
    fn warm(&mut self, operation: &Operation) {
        let cache = operation.unit as usize;
        for line in self.first_level[cache].lines_of(operation) {
            if let Outcome::Miss { .. } = self.first_level[cache].cache.access(line, || ()) {
                for part in self.parts_of(cache, line) {
                    let located = self.tags.locate(part.addr);
                    self.card.extend(located.missed.then_some(CardAccess::Write(located.load)));
                }
            }
        }
    }

    /// The phases of a cycle (CH-5).
    const PHASES: [fn(&mut Self); 8] = [
        Self::phase_1_units_and_caches_answer,
        Self::phase_2_lines_arrive_from_memory,
        Self::phase_3_a_line_arrives_from_the_host,
        Self::phase_4_tags_are_acted_upon,
        Self::phase_5_a_packet_is_handed_out,
        Self::phase_6_units_start,
        Self::phase_7_first_level_look_ups,
        Self::phase_8_the_bus_manager_takes_a_part,
    ];

    /// One cycle (CH-5); whether all packets ended in it or before (CH-20). After each of its phases `seen`
    /// gets the number of the phase and the chip.
    pub fn cycle(&mut self, mut seen: impl FnMut(u32, &Self)) -> bool {
        self.sdram.begin_cycle(self.now);
        for (number, phase) in (1..).zip(Self::PHASES) {
            phase(self);
            seen(number, self);
            let all_free = || self.threads.iter().all(|thread| thread.state == State::Free);
            if number == 5 && self.packets.is_empty() && all_free() {
                return true;
            }
        }
        self.account();
        self.sdram.end_cycle(self.now);
        self.now += 1;
        false
    }

    /// What a run of all cycles before [`now`](Self::now) took.
    pub fn report(mut self) -> TimingReport {
        self.report.cycles = self.now;
        self.report.l1 = self.first_level.map(|first_level| first_level.report);
        self.report
    }

    fn phase_1_units_and_caches_answer(&mut self) {
        for thread in 0..self.threads.len() {
            match self.threads[thread].state {
                State::Works { done } if done == self.now => self.end_operation(thread),
                State::LooksUp { answer } if answer == self.now => self.line_is_there(thread),
                _ => {}
            }
        }
    }

    /// CH-10, CH-11, CH-16.
    fn phase_2_lines_arrive_from_memory(&mut self) {
        for cache in 0..4 {
            let arrived = self.take_arrived_lines(cache);
            for &thread in arrived.iter().flat_map(|line| &line.threads) {
                self.line_is_there(thread);
            }
            for _ in arrived {
                self.first_of_queue_asks_again(cache);
            }
        }
    }

    /// CH-4.
    fn phase_5_a_packet_is_handed_out(&mut self) {
        let is_free = |&thread: &usize| self.threads[thread].state == State::Free;
        let free: Vec<usize> = (0..self.threads.len()).filter(is_free).collect();
        if self.packets.is_empty() || free.is_empty() {
            return;
        }
        let pipeline_of = |&thread: &usize| thread / self.config.threads as usize;
        let pipelines: Vec<usize> = free.iter().map(pipeline_of).collect();
        let pipeline = self.pipelines.next(&pipelines);
        let thread = free.into_iter().find(|thread| pipeline_of(thread) == pipeline);
        if let (Some(thread), Some(packet)) = (thread, self.packets.pop_front()) {
            self.threads[thread].program = packet;
            self.begin_operation(thread);
        }
    }

    /// CH-6.
    fn phase_6_units_start(&mut self) {
        for place in 0..self.units.len() {
            let (pipeline, kind) = (place / 4, place % 4);
            let is_ready = |&thread: &usize| {
                let thread = &self.threads[thread];
                thread.state == State::Ready && thread.works_for(kind)
            };
            let ready: Vec<usize> = self.threads_of(pipeline).filter(is_ready).collect();
            if ready.is_empty() || self.units[place].free > self.now {
                continue;
            }
            let thread = self.units[place].turn.next(&ready);
            let rays = self.threads[thread].program[0].rays;
            let unit = self.config.units[kind];
            self.units[place].free = self.now + u64::from(unit.cycles(rays.into()));
            let done = self.units[place].free + u64::from(unit.latency);
            self.threads[thread].state = State::Works { done };
            self.report.units[kind].operations += 1;
            self.report.units[kind].rays += u64::from(rays);
        }
    }

    /// The threads of a pipeline.
    fn threads_of(&self, pipeline: usize) -> std::ops::Range<usize> {
        let threads = self.config.threads as usize;
        pipeline * threads..(pipeline + 1) * threads
    }

    /// A thread begins its next operation, or is free (CH-7).
    fn begin_operation(&mut self, thread: usize) {
        let Some(operation) = self.threads[thread].program.first() else {
            self.threads[thread].state = State::Free;
            return;
        };
        self.threads[thread].lines = self.first_level[operation.unit as usize].lines_of(operation).collect();
        self.threads[thread].state = if operation.bytes == 0 { State::Ready } else { State::Asks };
    }

    /// The line that a thread asked for is there (CH-7).
    fn line_is_there(&mut self, number: usize) {
        let thread = &mut self.threads[number];
        thread.lines.pop_front();
        if !thread.lines.is_empty() {
            thread.state = State::Asks;
        } else if thread.program[0].rays > 0 {
            thread.state = State::Ready;
        } else {
            self.end_operation(number);
        }
    }

    /// A thread's operation ends, and the next one begins in the same cycle (CH-7).
    fn end_operation(&mut self, thread: usize) {
        self.threads[thread].program = &self.threads[thread].program[1..];
        self.begin_operation(thread);
    }
}
