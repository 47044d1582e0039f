//! A unit of a pipeline: who wants it, and where its cycles went.

use super::{NOBODY, Stall, UnitReport};

/// Bits of a counter of threads in [`Unit::waiting`].
const COUNTER_BITS: u32 = 12;

/// [`Unit::waiting`] of no thread: the cause that follows the last [`Stall`] is idleness.
const IDLE: u64 = 1 << (Stall::ALL.len() as u32 * COUNTER_BITS);

/// One thread in [`Unit::waiting`].
#[inline]
fn waiter(stall: Stall) -> u64 {
    1 << (stall as u32 * COUNTER_BITS)
}

pub(super) struct Unit {
    /// Threads of the pipeline whose bytes are there, and the one served last.
    pub(super) ready: u64,
    pub(super) last: u32,
    /// First cycle in which it can take rays, and whether an event tells of it.
    pub(super) free: u64,
    pub(super) called: bool,
    /// Threads that wait for bytes for this unit: a counter a cause, and [`IDLE`].
    waiting: u64,
    /// The cycles before this one are accounted for: as busy in the report, the others by cause.
    since: u64,
    without_rays: [u64; Stall::ALL.len() + 1],
    pub(super) report: UnitReport,
}

impl Unit {
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
    pub(super) fn settle(&mut self, now: u64) {
        let free = self.free.clamp(self.since, now);
        self.report.busy += free - self.since;
        self.without_rays[(self.waiting.trailing_zeros() / COUNTER_BITS) as usize] += now - free;
        self.since = now;
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

    /// The report of all cycles before `now`.
    pub(super) fn reported(mut self, now: u64) -> UnitReport {
        self.settle(now);
        let [stalls @ .., idle] = self.without_rays;
        UnitReport { stalls, idle, ..self.report }
    }
}
