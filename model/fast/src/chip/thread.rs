//! A thread, which works on one packet at a time: how it gets one, and what it waits for.

use super::observer::ChipObserver;
use super::{Chip, round_robin};
use saarcor_model::time::{MAX_COUNT, Operation, Stall};
use saarcor_model::vm::Unit;

/// No thread, in a list of threads.
pub(super) const NONE: u32 = u32::MAX;

/// Thread `t` of pipeline `p` has the number `THREADS · p + t`: so numbers split by bits.
pub(super) const THREADS: u32 = MAX_COUNT.next_power_of_two();

/// The pipeline of a thread's number, and the thread in it.
#[inline]
fn split(number: u32) -> (u32, u32) {
    (number / THREADS, number % THREADS)
}

/// The place of a pipeline's unit among all units.
#[inline]
fn unit_of(pipeline: u32, port: Unit) -> usize {
    4 * pipeline as usize + port as usize
}

/// What an event means for a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// It waits for bytes, which an event brings.
    Reading,
    /// A unit works for it, and an event ends the operation.
    Working,
}

pub(super) struct Thread<'a> {
    /// Number of its packet, in the order in which packets are handed out.
    pub(super) packet: u32,
    /// What is still to do after the operation at hand.
    program: &'a [Operation],
    /// Of the operation at hand, the unit, its rays, and the first-level line that the thread waits
    /// for, and the last one.
    port: Unit,
    pub(super) rays: u8,
    pub(super) line: u32,
    last_line: u32,
    pub(super) stage: Stage,
    stall: Stall,
    /// The next thread that waits for the same line in flight.
    pub(super) next: u32,
}

impl Thread<'_> {
    /// A thread without a packet.
    pub(super) const FREE: Self = Self {
        packet: 0,
        program: &[],
        port: Unit::Shading,
        rays: 0,
        line: 0,
        last_line: 0,
        stage: Stage::Reading,
        stall: Stall::LookUp,
        next: NONE,
    };
}

impl<'a, O: ChipObserver> Chip<'a, O> {
    /// Phase 5: the ray generation controller hands out one packet (CH-4).
    pub(super) fn hand_out(&mut self) {
        if self.with_free == 0 {
            return;
        }
        let Some((packet, program)) = self.next_in_time() else { return };
        let pipeline = round_robin(self.with_free, self.last_pipeline);
        self.last_pipeline = pipeline;
        let free = &mut self.free[pipeline as usize];
        let thread = pipeline * THREADS + free.trailing_zeros();
        *free &= *free - 1;
        if *free == 0 {
            self.with_free &= !(1 << pipeline);
        }
        self.working += 1;
        self.observer.begin(packet, self.now);
        let thread_at_hand = &mut self.threads[thread as usize];
        (thread_at_hand.packet, thread_at_hand.program) = (packet, program);
        self.begin(thread);
    }

    /// The next packet that takes time, with its number. Those before it are done at once.
    fn next_in_time(&mut self) -> Option<(u32, &'a [Operation])> {
        loop {
            let program = self.packets.next()?;
            let packet = self.handed_out;
            self.handed_out += 1;
            if self.in_time[packet as usize] {
                return Some((packet, program));
            }
            program.iter().for_each(|operation| self.read_at_once(operation, Some(packet)));
        }
    }

    /// Begins the next operation, or ends the packet.
    pub(super) fn begin(&mut self, number: u32) {
        let (pipeline, bit) = split(number);
        let thread = &mut self.threads[number as usize];
        let Some((operation, rest)) = thread.program.split_first() else {
            self.free[pipeline as usize] |= 1 << bit;
            self.with_free |= 1 << pipeline;
            self.working -= 1;
            return;
        };
        (thread.program, thread.port, thread.rays) = (rest, operation.unit, operation.rays);
        if operation.bytes == 0 {
            self.ready(number);
            return;
        }
        let l1 = &mut self.l1[operation.unit as usize];
        (thread.line, thread.last_line) = l1.lines_of(operation);
        (thread.stage, thread.stall) = (Stage::Reading, Stall::Port);
        self.units[unit_of(pipeline, operation.unit)].wait(Stall::Port, self.now);
        l1.ask(pipeline, bit);
        self.asked |= 1 << operation.unit as u32;
    }

    /// A thread that waited asks for its line again.
    pub(super) fn ask(&mut self, number: u32) {
        self.wait(number, Stall::Port);
        let (pipeline, bit) = split(number);
        let cache = self.threads[number as usize].port as usize;
        self.l1[cache].ask(pipeline, bit);
        self.asked |= 1 << cache;
    }

    /// The line that a thread waits for is there (CH-7).
    #[inline]
    pub(super) fn answer(&mut self, number: u32) {
        let thread = &mut self.threads[number as usize];
        if thread.line < thread.last_line {
            thread.line += 1;
            self.ask(number);
            return;
        }
        self.units[unit_of(split(number).0, thread.port)].go_on(thread.stall, self.now);
        if thread.rays == 0 { self.begin(number) } else { self.ready(number) }
    }

    /// A thread has all that its unit needs.
    #[inline]
    fn ready(&mut self, number: u32) {
        let (pipeline, bit) = split(number);
        let place = unit_of(pipeline, self.threads[number as usize].port);
        let unit = &mut self.units[place];
        unit.ready |= 1 << bit;
        if unit.free <= self.now {
            self.attended.push(place as u32);
        } else if !std::mem::replace(&mut unit.called, true) {
            self.wheel.insert(unit.free, (self.threads.len() + place) as u32);
        }
    }

    /// A thread that waited now waits because of `stall`.
    #[inline]
    pub(super) fn wait(&mut self, number: u32, stall: Stall) {
        let thread = &mut self.threads[number as usize];
        let before = std::mem::replace(&mut thread.stall, stall);
        self.units[unit_of(split(number).0, thread.port)].wait_on(before, stall, self.now);
    }
}
