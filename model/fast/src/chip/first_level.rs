//! A first-level cache in time: who asks, and which lines are in flight.

use super::{NOBODY, NONE, members, round_robin};
use crate::first_level::first_and_last_line;
use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{CacheReport, ChipConfig, Operation, Programs};
use saarcor_model::vm::{FirstLevel, Policy, Unit};
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
