//! A unit of a pipeline: who wants it, and where its cycles went.

use super::observer::ChipObserver;
use super::thread::{Stage, THREADS};
use super::{Chip, NOBODY, round_robin};
use saarcor_model::time::{MAX_COUNT, Stall, UnitReport};

/// Bits of a counter of threads in [`UnitState::waiting`].
const COUNTER_BITS: u32 = 8;
const _: () = assert!(MAX_COUNT < 1 << COUNTER_BITS);

/// [`UnitState::waiting`] of no thread: the cause that follows the last [`Stall`] is idleness.
const IDLE: u64 = 1 << (Stall::ALL.len() as u32 * COUNTER_BITS);

/// One thread in [`UnitState::waiting`].
#[inline]
fn waiter(stall: Stall) -> u64 {
    1 << (stall as u32 * COUNTER_BITS)
}

pub(super) struct UnitState {
    /// Threads of the pipeline whose bytes are there, and the one served last.
    pub(super) ready: u64,
    last: u32,
    /// First cycle in which it can take rays, and whether an event says so.
    pub(super) free: u64,
    pub(super) called: bool,
    /// Threads that wait for bytes for this unit: a counter a cause, and [`IDLE`].
    waiting: u64,
    /// Cycles in which no rays go in are accounted for before this one, by cause.
    since: u64,
    without_rays: [u64; Stall::ALL.len() + 1],
    report: UnitReport,
}

impl UnitState {
    pub(super) fn new() -> Self {
        Self {
            ready: 0,
            last: NOBODY,
            free: 0,
            called: false,
            waiting: IDLE,
            since: 0,
            without_rays: [0; Stall::ALL.len() + 1],
            report: UnitReport::default(),
        }
    }

    /// Accounts for the cycles before `now`, in which nothing changed (CH-18).
    #[inline]
    fn settle(&mut self, now: u64) {
        let from = self.since.max(self.free).min(now);
        self.without_rays[(self.waiting.trailing_zeros() / COUNTER_BITS) as usize] += now - from;
        self.since = now;
    }

    /// The ready thread whose turn it is, which is ready no more.
    #[inline]
    pub(super) fn next_in_turn(&mut self) -> u32 {
        self.last = round_robin(self.ready, self.last);
        self.ready &= !(1 << self.last);
        self.last
    }

    /// From `now` on, `rays` go in for so many cycles.
    #[inline]
    pub(super) fn take(&mut self, rays: u8, cycles: u32, now: u64) {
        self.settle(now);
        self.free = now + u64::from(cycles);
        self.report.busy += u64::from(cycles);
        self.report.operations += 1;
        self.report.rays += u64::from(rays);
    }

    /// One thread more waits because of `stall`.
    #[inline]
    pub(super) fn wait(&mut self, stall: Stall, now: u64) {
        self.settle(now);
        self.waiting += waiter(stall);
    }

    /// A thread that waited because of `before` now waits because of `stall`.
    #[inline]
    pub(super) fn wait_on(&mut self, before: Stall, stall: Stall, now: u64) {
        self.settle(now);
        self.waiting += waiter(stall);
        self.waiting -= waiter(before);
    }

    /// A thread that waited because of `stall` waits no more.
    #[inline]
    pub(super) fn go_on(&mut self, stall: Stall, now: u64) {
        self.settle(now);
        self.waiting -= waiter(stall);
    }

    /// The report of all cycles before `now`, when all rays have gone in.
    pub(super) fn reported(mut self, now: u64) -> UnitReport {
        self.settle(now);
        let [stalls @ .., idle] = self.without_rays;
        UnitReport { stalls, idle, ..self.report }
    }
}

impl<O: ChipObserver> Chip<'_, O> {
    /// Phase 6: units that are free take the next packet that is ready (CH-6).
    pub(super) fn start_units(&mut self) {
        for place in self.attended.drain(..) {
            let (port, pipeline) = (place as usize % 4, place / 4);
            let unit = &mut self.units[place as usize];
            if unit.free > self.now {
                continue;
            }
            let number = pipeline * THREADS + unit.next_in_turn();
            let thread = &mut self.threads[number as usize];
            thread.stage = Stage::Working;
            unit.take(thread.rays, self.cycles[port][usize::from(thread.rays)], self.now);
            if unit.ready != 0 {
                unit.called = true;
                self.wheel.insert(unit.free, self.threads.len() as u32 + place);
            }
            self.wheel.insert(unit.free + u64::from(self.config.units[port].latency), number);
        }
    }
}
