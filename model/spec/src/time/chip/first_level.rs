//! A first-level cache in time: its lines in flight, and who waits for what.

use super::Chip;
use super::thread::State;
use super::turn::Turn;
use crate::time::config::L1Config;
use crate::time::operation::Operation;
use crate::time::report::CacheReport;
use crate::time::sdram::TransferId;
use crate::time::standard::CHIP_CACHE_WAYS;
use crate::vm::{FirstLevel, HostAddr, LineAddr, Policy};
use std::collections::VecDeque;

/// What a look-up finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The line.
    Resident,
    /// The line in flight (CH-10).
    InFlight,
    /// Nothing: the line is to be fetched.
    Missing,
    /// Nothing, and no register is free (CH-11).
    NoRegister,
}

/// The part of a first-level line that lies in one line of the virtual memory (CH-12).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinePart {
    /// The first-level cache, by its place in [`Unit::ALL`](crate::vm::Unit::ALL).
    pub cache: usize,
    /// The first-level line.
    pub line: LineAddr,
    /// Address of the first byte.
    pub addr: HostAddr,
    /// Bytes of the part.
    pub bytes: u64,
}

/// A first-level line in flight (CH-10).
#[derive(Clone, Debug)]
pub struct LineInFlight {
    /// The line.
    pub line: LineAddr,
    /// Threads that wait for it.
    pub threads: Vec<usize>,
    /// Parts that are not read from the on-board memory yet.
    pub unread: usize,
    /// The reads of the others.
    pub reads: Vec<TransferId>,
}

/// A first-level cache of the chip in time, and what it is asked for (CH-8 to CH-11).
#[derive(Clone, Debug)]
pub struct FirstLevelInTime {
    /// Its sets.
    pub cache: FirstLevel<CHIP_CACHE_WAYS, ()>,
    /// Lines that can be in flight at a time: each takes a register.
    pub registers: usize,
    /// Lines in flight, in the order of their misses.
    pub in_flight: Vec<LineInFlight>,
    /// Parts that the bus manager has not taken yet, in the order of the misses.
    pub parts: VecDeque<LinePart>,
    /// Threads that wait for a register, the one that asks again next first.
    pub queue: VecDeque<usize>,
    /// Pipelines, and the threads of each, are served in turn.
    pipelines: Turn,
    threads: Vec<Turn>,
    /// What it did so far.
    pub report: CacheReport,
}

impl FirstLevelInTime {
    /// An empty cache, whose first line begins at `base`.
    pub fn new(base: HostAddr, config: L1Config, pipelines: usize) -> Self {
        Self {
            cache: FirstLevel::<_, ()>::new(base, config.line, config.sets as usize, Policy::Lru),
            registers: config.mshrs as usize,
            in_flight: Vec::new(),
            parts: VecDeque::new(),
            queue: VecDeque::new(),
            pipelines: Turn::default(),
            threads: vec![Turn::default(); pipelines],
            report: CacheReport::default(),
        }
    }

    /// The lines that an operation reads, in order.
    pub fn lines_of(&self, operation: &Operation) -> impl Iterator<Item = LineAddr> + use<> {
        let begin = operation.addr.max(self.cache.base);
        self.cache.lines_of(begin, operation.bytes.into()).map(|line| LineAddr(line as u32))
    }

    /// Of the threads that ask, the one whose turn it is (CH-8).
    pub fn in_turn(&mut self, asking: &[usize], threads: usize) -> usize {
        let pipelines: Vec<usize> = asking.iter().map(|thread| thread / threads).collect();
        let pipeline = self.pipelines.next(&pipelines);
        let own: Vec<usize> = asking.iter().copied().filter(|thread| thread / threads == pipeline).collect();
        self.threads[pipeline].next(&own)
    }

    /// Whether every register is taken by a line in flight.
    pub fn is_full(&self) -> bool {
        self.in_flight.len() == self.registers
    }

    /// The look-up of `line` by `thread`: a step of the line's set (CH-9), but where no register is
    /// free for a line that would need one (CH-11).
    pub fn look_up(&mut self, line: LineAddr, thread: usize) -> Answer {
        let is_full = self.is_full();
        let is_resident = self.cache.is_resident(line);
        let in_flight = self.in_flight.iter_mut().find(|other| other.line == line);
        if in_flight.is_none() && !is_resident && is_full {
            self.queue.push_back(thread);
            return Answer::NoRegister;
        }
        self.report.accesses += 1;
        self.cache.access(line, || ());
        match in_flight {
            Some(in_flight) => {
                self.report.merged += 1;
                in_flight.threads.push(thread);
                Answer::InFlight
            }
            None if is_resident => Answer::Resident,
            None => {
                self.report.misses += 1;
                Answer::Missing
            }
        }
    }

    /// A missed line takes a register, and its parts are asked for.
    pub fn fetch(&mut self, line: LineAddr, thread: usize, parts: Vec<LinePart>) {
        let (threads, unread) = (vec![thread], parts.len());
        self.in_flight.push(LineInFlight { line, threads, unread, reads: Vec::new() });
        self.parts.extend(parts);
    }

    /// A part of a line in flight is read from the on-board memory.
    pub fn part_is_read(&mut self, line: LineAddr, read: TransferId) {
        for in_flight in self.in_flight.iter_mut().filter(|other| other.line == line) {
            in_flight.unread -= 1;
            in_flight.reads.push(read);
        }
    }
}

impl Chip<'_> {
    /// CH-8.
    pub(super) fn phase_7_first_level_look_ups(&mut self) {
        for cache in 0..4 {
            for _ in 0..self.config.l1[cache].ports {
                let asks = |&thread: &usize| {
                    let thread = &self.threads[thread];
                    thread.state == State::Asks && thread.works_for(cache)
                };
                let asking: Vec<usize> = (0..self.threads.len()).filter(asks).collect();
                if asking.is_empty() {
                    break;
                }
                let thread = self.first_level[cache].in_turn(&asking, self.config.threads as usize);
                self.look_up(cache, thread);
                if !self.first_level[cache].is_full() {
                    self.first_of_queue_asks_again(cache);
                }
            }
        }
    }

    /// A thread's look-up (CH-9 to CH-12).
    fn look_up(&mut self, cache: usize, thread: usize) {
        let line = self.threads[thread].lines[0];
        self.threads[thread].state = match self.first_level[cache].look_up(line, thread) {
            Answer::NoRegister => State::Queued,
            Answer::InFlight => State::Waits,
            Answer::Resident => {
                State::LooksUp { answer: self.now + u64::from(self.config.l1[cache].latency) }
            }
            Answer::Missing => {
                let parts = self.parts_of(cache, line);
                self.first_level[cache].fetch(line, thread, parts);
                State::Waits
            }
        };
    }

    /// CH-11.
    pub(super) fn first_of_queue_asks_again(&mut self, cache: usize) {
        if let Some(thread) = self.first_level[cache].queue.pop_front() {
            self.threads[thread].state = State::Asks;
        }
    }
}
