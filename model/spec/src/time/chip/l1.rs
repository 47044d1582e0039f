//! A first-level cache in time: who asks, and which lines are in flight.

use super::{CacheReport, NOBODY, NONE, members, round_robin};
use crate::time::config::ChipConfig;
use crate::time::operation::{Operation, Programs};
use crate::time::standard::CHIP_CACHE_WAYS;
use crate::vm::{Directory, Unit};
use std::collections::VecDeque;

/// Threads are masks, one a pipeline.
pub(super) struct L1 {
    /// Address of its first line, and bytes a line.
    base: u32,
    line: u32,
    pub(super) directory: Directory<CHIP_CACHE_WAYS>,
    /// Pipelines with a thread that asks for a look-up, and the one served last.
    asking: u64,
    last: u32,
    /// The threads that ask, and the one served last, for each pipeline.
    threads: Vec<u64>,
    last_thread: Vec<u32>,
    /// Which registers are taken by lines in flight.
    taken: u64,
    pub(super) in_flight: Vec<InFlight>,
    /// How many lines in flight have these lowest bits.
    alike: [u8; ALIKE],
    /// Threads that wait for a register, the one that waits longest first.
    pub(super) parked: VecDeque<u32>,
    /// Parts of missed lines that the bus manager has not taken yet.
    pub(super) parts: VecDeque<Part>,
    pub(super) report: CacheReport,
}

/// Values of the lowest bits of a line that are told apart: enough that of 16 lines in flight
/// few are like another that is asked for.
const ALIKE: usize = 256;

/// A first-level line in flight.
#[derive(Clone, Copy)]
pub(super) struct InFlight {
    line: u32,
    /// The first thread that waits.
    pub(super) waiter: u32,
    /// Parts that have not been read from the on-board memory, and of these, those that wait for
    /// the host.
    pub(super) parts: u32,
    pub(super) from_host: u32,
}

impl InFlight {
    fn new(line: u32) -> Self {
        Self { line, waiter: NONE, parts: 0, from_host: 0 }
    }
}

/// The part of a first-level line that lies in one line of the virtual memory.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) addr: u32,
    pub(super) bytes: u32,
    /// The packet that missed the line.
    pub(super) packet: u32,
    pub(super) cache: u8,
    pub(super) register: u8,
}

impl L1 {
    pub(super) fn new(port: Unit, programs: &Programs, config: &ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        let l1 = config.l1[port as usize];
        Self {
            base: programs.l1_base(port),
            line: l1.line,
            directory: Directory::new(ChipConfig::chip_cache(l1.sets)),
            asking: 0,
            last: NOBODY,
            threads: vec![0; pipelines],
            last_thread: vec![NOBODY; pipelines],
            taken: 0,
            in_flight: vec![InFlight::new(0); l1.mshrs as usize],
            alike: [0; ALIKE],
            parked: VecDeque::with_capacity(pipelines * threads),
            parts: VecDeque::new(),
            report: CacheReport::default(),
        }
    }

    /// The first and the last line that an operation reads.
    #[inline]
    pub(super) fn lines_of(&self, operation: &Operation) -> (u32, u32) {
        operation.lines(self.base, self.line)
    }

    /// First address of a line, and the one behind it.
    pub(super) fn bytes_of(&self, line: u32) -> (u64, u64) {
        let begin = u64::from(self.base) + u64::from(line) * u64::from(self.line);
        (begin, begin + u64::from(self.line))
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
        if self.alike[line as usize % ALIKE] == 0 {
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
        self.alike[line as usize % ALIKE] += 1;
        self.in_flight[register] = InFlight::new(line);
        register
    }

    /// The line of `register` is there; the first thread that waits for it.
    pub(super) fn release(&mut self, register: usize) -> u32 {
        let InFlight { line, waiter, .. } = self.in_flight[register];
        self.taken &= !(1 << register);
        self.alike[line as usize % ALIKE] -= 1;
        waiter
    }
}
