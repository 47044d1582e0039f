//! A first-level cache in time: who asks, which lines are in flight, and who waits for what.

use super::observer::{Cache, ChipObserver, Found};
use super::thread::{NONE, THREADS, Thread};
use super::{Chip, NOBODY, members, round_robin};
use crate::first_level::{access, first_and_last_line, is_resident};
use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{CacheReport, ChipConfig, Operation, Programs, Stall};
use saarcor_model::vm::{FirstLevel, LineAddr, Outcome, Policy, Unit};
use std::collections::VecDeque;

/// A first-level cache, the threads that ask it (a mask a pipeline), and its lines in flight.
pub(super) struct FirstLevelState {
    pub(super) cache: FirstLevel<CHIP_CACHE_WAYS, ()>,
    /// Pipelines with a thread that asks for a look-up, and the one served last.
    asking: u64,
    last: u32,
    /// The threads that ask, and the one served last, for each pipeline.
    threads: Vec<u64>,
    last_thread: Vec<u32>,
    /// Which registers are taken by lines in flight.
    taken: u64,
    pub(super) in_flight: Vec<LineInFlight>,
    /// A counting filter: lines in flight by their lowest bits.
    filter: [u8; BUCKETS],
    /// Threads that wait for a register, the one that waits longest first.
    pub(super) parked: VecDeque<u32>,
    /// Parts of missed lines that the bus manager has not taken yet.
    pub(super) parts: VecDeque<LinePart>,
    pub(super) report: CacheReport,
}

/// Buckets of the counting filter over the lines in flight: enough that of 16 lines in flight few
/// share a bucket with a line that is looked up.
const BUCKETS: usize = 256;

/// A first-level line in flight.
#[derive(Clone, Copy)]
pub(super) struct LineInFlight {
    line: u32,
    /// The first thread that waits.
    pub(super) waiter: u32,
    /// Parts that have not been read from the on-board memory, and of these, those that wait for
    /// the host.
    pub(super) parts: u32,
    pub(super) from_host: u32,
}

impl LineInFlight {
    fn new(line: u32) -> Self {
        Self { line, waiter: NONE, parts: 0, from_host: 0 }
    }
}

/// The part of a first-level line that lies in one line of the virtual memory.
#[derive(Clone, Copy)]
pub(super) struct LinePart {
    pub(super) addr: u32,
    pub(super) bytes: u32,
    /// The packet that missed the line.
    pub(super) packet: u32,
    pub(super) cache: u8,
    pub(super) register: u8,
}

impl FirstLevelState {
    pub(super) fn new(port: Unit, programs: &Programs, config: &ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        let l1 = config.l1[port as usize];
        Self {
            cache: FirstLevel::<CHIP_CACHE_WAYS, ()>::new(
                programs.first_level_base(port),
                l1.line,
                l1.sets as usize,
                Policy::Lru,
            ),
            asking: 0,
            last: NOBODY,
            threads: vec![0; pipelines],
            last_thread: vec![NOBODY; pipelines],
            taken: 0,
            in_flight: vec![LineInFlight::new(0); l1.mshrs as usize],
            filter: [0; BUCKETS],
            parked: VecDeque::with_capacity(pipelines * threads),
            parts: VecDeque::new(),
            report: CacheReport::default(),
        }
    }

    /// The first and the last line that an operation reads.
    #[inline]
    pub(super) fn lines_of(&self, operation: &Operation) -> (u32, u32) {
        first_and_last_line(self.cache.base, self.cache.line_bytes, operation.addr, operation.bytes)
    }

    /// A thread asks for a look-up.
    #[inline]
    pub(super) fn ask(&mut self, pipeline: u32, thread: u32) {
        self.threads[pipeline as usize] |= 1 << thread;
        self.asking |= 1 << pipeline;
    }

    /// Whether any thread asks.
    #[inline]
    pub(super) fn is_asked(&self) -> bool {
        self.asking != 0
    }

    /// The pipeline and its thread whose turn it is, of those that ask (CH-8).
    #[inline]
    pub(super) fn next_in_turn(&mut self) -> (u32, u32) {
        let pipeline = round_robin(self.asking, self.last);
        let asking = &mut self.threads[pipeline as usize];
        let thread = round_robin(*asking, self.last_thread[pipeline as usize]);
        *asking &= !(1 << thread);
        if *asking == 0 {
            self.asking &= !(1 << pipeline);
        }
        self.last = pipeline;
        self.last_thread[pipeline as usize] = thread;
        (pipeline, thread)
    }

    /// The register of `line`, if it is in flight.
    #[inline]
    pub(super) fn register_of(&self, line: u32) -> Option<usize> {
        if self.filter[line as usize % BUCKETS] == 0 {
            return None;
        }
        members(self.taken).find(|&register| self.in_flight[register].line == line)
    }

    /// Whether every register is taken.
    #[inline]
    pub(super) fn is_full(&self) -> bool {
        self.taken.count_ones() as usize == self.in_flight.len()
    }

    /// `line` is in flight from now on; the register that it takes, the free one of the lowest
    /// number.
    pub(super) fn take(&mut self, line: u32) -> usize {
        let register = (!self.taken).trailing_zeros() as usize;
        self.taken |= 1 << register;
        self.filter[line as usize % BUCKETS] += 1;
        self.in_flight[register] = LineInFlight::new(line);
        register
    }

    /// The line of `register` is there; the first thread that waits for it.
    pub(super) fn release(&mut self, register: usize) -> u32 {
        let LineInFlight { line, waiter, .. } = self.in_flight[register];
        self.taken &= !(1 << register);
        self.filter[line as usize % BUCKETS] -= 1;
        waiter
    }
}

impl<O: ChipObserver> Chip<'_, O> {
    /// Phase 2: lines arrive at first-level caches.
    pub(super) fn lines_from_memory(&mut self) {
        while let Some(&(there, cache, register)) = self.returning.front()
            && there <= self.now
        {
            self.returning.pop_front();
            let mut thread = self.l1[usize::from(cache)].release(usize::from(register));
            while thread != NONE {
                let next = self.threads[thread as usize].next;
                self.answer(thread);
                thread = next;
            }
            self.ask_again(usize::from(cache));
        }
    }

    /// Phase 7: the ports of the first-level caches (CH-8).
    pub(super) fn look_up_lines(&mut self) {
        for cache in members(self.asked) {
            let mut ports = self.config.l1[cache].ports;
            while ports > 0 && self.l1[cache].is_asked() {
                let (pipeline, thread) = self.l1[cache].next_in_turn();
                self.look_up(cache, pipeline * THREADS + thread);
                self.ask_again(cache);
                ports -= 1;
            }
            if !self.l1[cache].is_asked() {
                self.asked &= !(1 << cache);
            }
        }
    }

    /// The thread that waits longest for a register asks again, if one is free (CH-11).
    #[inline]
    fn ask_again(&mut self, cache: usize) {
        let l1 = &mut self.l1[cache];
        if !l1.parked.is_empty()
            && !l1.is_full()
            && let Some(thread) = l1.parked.pop_front()
        {
            self.ask(thread);
        }
    }

    /// A thread's look-up (CH-9 to CH-11).
    #[inline]
    fn look_up(&mut self, cache: usize, number: u32) {
        let l1 = &mut self.l1[cache];
        let Thread { line, packet, .. } = self.threads[number as usize];
        let in_flight = l1.register_of(line);
        if in_flight.is_none() && l1.is_full() && !is_resident(&l1.cache, LineAddr(line)) {
            l1.parked.push_back(number);
            self.wait(number, Stall::Mshr);
            return;
        }
        let outcome = access(&mut l1.cache, LineAddr(line));
        l1.report.accesses += 1;
        let register = match (in_flight, outcome) {
            (Some(register), _) => {
                l1.report.merged += 1;
                self.observer.look_up(packet, Cache::L1(cache), Found::InFlight);
                register
            }
            (None, Outcome::Hit { .. }) => {
                self.observer.look_up(packet, Cache::L1(cache), Found::Resident);
                self.wheel.insert(self.now + u64::from(self.config.l1[cache].latency), number);
                self.wait(number, Stall::LookUp);
                return;
            }
            (None, Outcome::Miss { .. }) => {
                l1.report.misses += 1;
                self.observer.look_up(packet, Cache::L1(cache), Found::Missing);
                let register = l1.take(line);
                for (addr, bytes) in self.parts(cache, line) {
                    let part = LinePart { addr, bytes, packet, cache: cache as u8, register: register as u8 };
                    self.l1[cache].parts.push_back(part);
                    self.l1[cache].in_flight[register].parts += 1;
                }
                self.missed |= 1 << cache;
                register
            }
        };
        let way = &mut self.l1[cache].in_flight[register];
        self.threads[number as usize].next = std::mem::replace(&mut way.waiter, number);
        let stall = if way.from_host == 0 { Stall::Memory } else { Stall::Host };
        self.wait(number, stall);
    }

    /// The threads that wait for a first-level line now wait because of `stall`.
    pub(super) fn blame(&mut self, part: LinePart, stall: Stall) {
        let mut thread = self.in_flight(part).waiter;
        while thread != NONE {
            self.wait(thread, stall);
            thread = self.threads[thread as usize].next;
        }
    }
}
