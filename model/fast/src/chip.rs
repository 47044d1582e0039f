//! The chip in time, from event to event. Twin of `saarcor_model::time::simulate`, whose reports these
//! are to the cycle.
//!
//! The phases of a cycle are those of the specification (CH-5). Cycles in which no phase has anything
//! to do are left out. Threads are bits of masks and members of linked lists, and what will happen in
//! later cycles stands in a wheel of events. Beyond the specification, a run may take only some packets
//! in time ([`simulate_part`]), and an observer may watch each transfer ([`ChipObserver`]).

mod at_once;
mod first_level;
mod observer;
mod tags;
mod unit;
mod wheel;

pub use at_once::Caches;
pub use observer::{Cache, ChipObserver, Found, Traffic};

use crate::pci::Pci;
use crate::sdram::Sdram;
use first_level::{FirstLevelState, LineInFlight, LinePart};
use observer::bytes_of;
use saarcor_model::time::{
    ChipConfig, ConfigError, Direction, Load, LoadId, MAX_COUNT, Operation, Program, Programs, Span, Stall,
    TimingReport, Version,
};
use saarcor_model::vm::{HostAddr, LineAddr, Outcome, Unit};
use std::collections::VecDeque;
use std::ops::Range;
use tags::{MetadataMove, Tags, WhereOnCard, tags};
use unit::UnitState;
use wheel::Wheel;

/// Plays `programs` on the chip. Its caches hold what the pictures `before` left there (CH-19);
/// without any, they are empty.
///
/// # Errors
/// If the configuration makes no chip.
pub fn simulate(
    before: &[Programs],
    programs: &Programs,
    config: &ChipConfig,
) -> Result<TimingReport, ConfigError> {
    simulate_observed(before, programs, config, &mut ())
}

/// [`simulate`], watched by `observer`: it sees a transfer as soon as its times are known.
///
/// # Errors
/// If the configuration makes no chip.
pub fn simulate_observed(
    before: &[Programs],
    programs: &Programs,
    config: &ChipConfig,
    observer: &mut impl ChipObserver,
) -> Result<TimingReport, ConfigError> {
    let empty = Caches::empty(programs.triangles, config)?;
    let caches = before.iter().fold(empty, |caches, picture| caches.then_observed(picture, observer));
    Ok(simulate_from(caches, programs, observer))
}

/// Plays all packets of `programs` on the chip of these `caches`, watched by `observer`.
#[must_use]
pub fn simulate_from(caches: Caches, programs: &Programs, observer: &mut impl ChipObserver) -> TimingReport {
    simulate_part(caches, programs, &vec![true; programs.packets.len()], observer)
}

/// Plays on the chip of these `caches` those packets whose place in `in_time` is true. The others take
/// no time and count in no report: when their turn to be handed out comes, they leave in the caches what
/// they read, and `observer` sees what they look up and move (sampled simulation).
///
/// # Panics
/// If `in_time` has not one place for each packet.
#[must_use]
pub fn simulate_part(
    caches: Caches,
    programs: &Programs,
    in_time: &[bool],
    observer: &mut impl ChipObserver,
) -> TimingReport {
    assert_eq!(in_time.len(), programs.packets.len(), "each packet is in time or not");
    let config = caches.config;
    Chip::new(programs, in_time, &config, observer).with(caches).run()
}

/// No thread, in a list of threads.
const NONE: u32 = u32::MAX;

/// Thread `t` of pipeline `p` has the number `THREADS · p + t`: so numbers split by bits.
const THREADS: u32 = MAX_COUNT.next_power_of_two();

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
enum Stage {
    /// It waits for bytes, which an event brings.
    Reading,
    /// A unit works for it, and an event ends the operation.
    Working,
}

struct Thread<'a> {
    /// Number of its packet, in the order in which packets are handed out.
    packet: u32,
    /// What is still to do after the operation at hand.
    program: &'a [Operation],
    /// Of the operation at hand, the unit, its rays, and the first-level line that the thread waits
    /// for, and the last one.
    port: Unit,
    rays: u8,
    line: u32,
    last_line: u32,
    stage: Stage,
    stall: Stall,
    /// The next thread that waits for the same line in flight.
    next: u32,
}

/// A part whose tag is known in cycle `ready`.
struct PendingTag {
    ready: u64,
    part: LinePart,
    card: u64,
    /// Whether its line was missed, and the load that brings it, if that was in flight.
    missed: bool,
    load: Option<LoadId>,
}

/// A load in flight, there in cycle `there`.
struct LoadInFlight {
    load: Load,
    there: u64,
    /// The packet that missed it.
    packet: u32,
}

/// The member of `mask` that follows `last`, round and round.
#[inline]
fn round_robin(mask: u64, last: u32) -> u32 {
    let above = mask & !(2_u64 << last).wrapping_sub(1);
    if above != 0 { above.trailing_zeros() } else { mask.trailing_zeros() }
}

/// The members of `mask`, from the lowest to the highest.
#[inline]
fn members(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (lowest < 64).then_some(lowest as usize)
    })
}

/// In place of the member served last, where none was: the next is the lowest.
const NOBODY: u32 = 63;

struct Chip<'a, O> {
    config: &'a ChipConfig,
    observer: &'a mut O,
    now: u64,
    /// Packets not yet begun, in order.
    packets: std::slice::Iter<'a, Program>,
    /// Which packets take time.
    in_time: &'a [bool],
    /// Packets handed out.
    handed_out: u32,
    /// Pipelines with a free thread, and the one that got a packet last.
    with_free: u64,
    last_pipeline: u32,
    /// The free threads of each pipeline.
    free: Vec<u64>,
    working: u32,
    /// By their number ([`THREADS`]).
    threads: Vec<Thread<'a>>,
    /// By their place ([`unit_of`]).
    units: Vec<UnitState>,
    /// For each unit, the cycles in which so many rays go in.
    cycles: [Box<[u32; 256]>; 4],
    /// Units that are free in this cycle and may have a thread to take; some more than once.
    attended: Vec<u32>,
    wheel: Wheel,
    l1: [FirstLevelState; 4],
    /// The first-level caches that threads ask, and those with parts of missed lines.
    asked: u64,
    missed: u64,
    /// First-level lines that have left the on-board memory: when they are there, and whose.
    returning: VecDeque<(u64, u8, u8)>,
    /// The first-level cache from which the bus manager took a part last.
    last_cache: u32,
    tags: Box<dyn Tags>,
    moves: Vec<MetadataMove>,
    tagged: VecDeque<PendingTag>,
    /// The latest cycle in `tagged` so far.
    tags_known: u64,
    /// Loads in flight, in the order in which they arrive, and how many have arrived.
    loading: VecDeque<LoadInFlight>,
    arrived: u64,
    /// Parts that wait for a load, and where they will lie on the card.
    waiting: Vec<(LoadId, LinePart, u64)>,
    sdram: Sdram,
    pci: Pci,
    /// No line arrives and no tag is known before this cycle.
    arrival: u64,
    report: TimingReport,
}

impl<'a, O: ChipObserver> Chip<'a, O> {
    fn new(programs: &'a Programs, in_time: &'a [bool], config: &'a ChipConfig, observer: &'a mut O) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        let numbers = pipelines * THREADS as usize;
        let thread = || Thread {
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
        let all = |count: usize| u64::MAX >> (64 - count);
        Self {
            config,
            observer,
            now: 0,
            packets: programs.packets.iter(),
            in_time,
            handed_out: 0,
            with_free: all(pipelines),
            last_pipeline: NOBODY,
            free: vec![all(threads); pipelines],
            working: 0,
            threads: std::iter::repeat_with(thread).take(numbers).collect(),
            units: std::iter::repeat_with(UnitState::new).take(4 * pipelines).collect(),
            cycles: config.units.map(|unit| Box::new(std::array::from_fn(|rays| unit.cycles(rays as u32)))),
            attended: Vec::new(),
            wheel: Wheel::new(numbers + 4 * pipelines),
            l1: Unit::ALL.map(|port| FirstLevelState::new(port, programs, config)),
            asked: 0,
            missed: 0,
            returning: VecDeque::new(),
            last_cache: NOBODY,
            tags: tags(config),
            moves: Vec::new(),
            tagged: VecDeque::new(),
            tags_known: 0,
            loading: VecDeque::new(),
            arrived: 0,
            waiting: Vec::new(),
            sdram: Sdram::new(config.sdram),
            pci: Pci::new(config.pci),
            arrival: u64::MAX,
            report: TimingReport::default(),
        }
    }

    /// The chip, with what these caches hold.
    fn with(mut self, caches: Caches) -> Self {
        self.l1.iter_mut().zip(caches.l1).for_each(|(empty, l1)| empty.cache = l1);
        self.tags = caches.tags;
        self
    }

    /// Address and size of the parts of a first-level line: one for each line of the virtual memory
    /// that it meets, and one in all without (CH-12).
    fn parts(&self, cache: usize, line: u32) -> impl Iterator<Item = (u32, u32)> + use<O> {
        let Range { start: mut addr, end } = self.l1[cache].cache.bytes_of(LineAddr(line));
        let vm_line = match self.config.version {
            Version::None => 1 << 32,
            Version::A | Version::B => self.config.cache.geometry.line().0,
        };
        std::iter::from_fn(move || {
            let here = end.min((addr / vm_line + 1) * vm_line).checked_sub(addr).filter(|&here| here > 0)?;
            let part = (addr as u32, here as u32);
            addr += here;
            Some(part)
        })
    }

    fn run(mut self) -> TimingReport {
        loop {
            self.events();
            if self.arrival <= self.now {
                self.lines_from_memory();
                self.line_from_host();
                self.tags_found();
                self.arrival = self.next_arrival();
            }
            self.hand_out();
            if self.working == 0 && self.packets.len() == 0 {
                return self.reported();
            }
            self.start_units();
            self.look_up_lines();
            self.look_up_tag();
            self.now = self.upcoming();
        }
    }

    fn reported(mut self) -> TimingReport {
        self.report.cycles = self.now;
        self.sdram.refresh_until(self.now);
        self.observe_commands();
        for (place, unit) in self.units.into_iter().enumerate() {
            let (sum, one) = (&mut self.report.units[place % 4], unit.reported(self.now));
            sum.busy += one.busy;
            sum.idle += one.idle;
            sum.operations += one.operations;
            sum.rays += one.rays;
            sum.stalls.iter_mut().zip(one.stalls).for_each(|(sum, one)| *sum += one);
        }
        self.report.l1 = self.l1.map(|l1| l1.report);
        self.report
    }

    /// The next cycle in which there is something to do.
    #[inline]
    fn upcoming(&self) -> u64 {
        let next = self.now + 1;
        if (self.asked | self.missed) != 0 || (self.with_free != 0 && self.packets.len() != 0) {
            return next;
        }
        self.wheel.upcoming(next).unwrap_or(u64::MAX).min(self.arrival)
    }

    /// The next cycle in which a line arrives or a tag is known.
    fn next_arrival(&self) -> u64 {
        let tagged = self.tagged.front().map_or(u64::MAX, |tagged| tagged.ready);
        let returning = self.returning.front().map_or(u64::MAX, |&(there, ..)| there);
        let loading = self.loading.front().map_or(u64::MAX, |loading| loading.there);
        tagged.min(returning).min(loading)
    }

    /// Phase 1: units become free, operations end, and first-level caches answer.
    fn events(&mut self) {
        let mut number = self.wheel.take(self.now);
        while number != NONE {
            let next = self.wheel.next[number as usize];
            match (number as usize).checked_sub(self.threads.len()) {
                Some(unit) => {
                    self.units[unit].called = false;
                    self.attended.push(unit as u32);
                }
                None if self.threads[number as usize].stage == Stage::Working => self.begin(number),
                None => self.answer(number),
            }
            number = next;
        }
    }

    /// Phase 2: lines arrive at first-level caches.
    fn lines_from_memory(&mut self) {
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

    /// Phase 3: a line arrives from the host, is written to the card, and then read by the parts
    /// that wait for it, in their order (CH-15).
    fn line_from_host(&mut self) {
        while self.loading.front().is_some_and(|loading| loading.there <= self.now)
            && let Some(LoadInFlight { load, packet, .. }) = self.loading.pop_front()
        {
            let bytes = self.config.cache.geometry.line().0;
            self.transfer(packet, Traffic::VmFill, load.card, bytes);
            self.observer.line_is_written(self.now, load);
            let arrived = LoadId(self.arrived);
            self.arrived += 1;
            let mut place = 0;
            while place < self.waiting.len() {
                if self.waiting[place].0 != arrived {
                    place += 1;
                    continue;
                }
                let (_, part, card) = self.waiting.remove(place);
                let way = self.in_flight(part);
                way.from_host -= 1;
                if way.from_host == 0 {
                    self.blame(part, Stall::Memory);
                }
                self.read_part(part, card);
            }
        }
    }

    /// Phase 4: tags are known, in the order of the look-ups (CH-13, CH-14).
    fn tags_found(&mut self) {
        while self.tagged.front().is_some_and(|tagged| tagged.ready <= self.now)
            && let Some(PendingTag { part, card, missed, load, .. }) = self.tagged.pop_front()
        {
            let Some(load) = load.filter(|load| load.0 >= self.arrived) else {
                self.read_part(part, card);
                continue;
            };
            if missed {
                let bytes = self.config.cache.geometry.line().0;
                let span = self.pci.load(self.now, bytes);
                self.loading[(load.0 - self.arrived) as usize].there = span.end;
                *bytes_of(&mut self.report, Traffic::Pci) += bytes;
                self.report.pci_busy += span.end - span.begin;
                self.observer.transfer(part.packet, Traffic::Pci, span, bytes);
            }
            self.waiting.push((load, part, card));
            let way = self.in_flight(part);
            way.from_host += 1;
            if way.from_host == 1 {
                self.blame(part, Stall::Host);
            }
        }
    }

    /// Phase 5: the ray generation controller hands out one packet (CH-4).
    fn hand_out(&mut self) {
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

    /// Phase 6: units that are free take the next packet that is ready (CH-6).
    fn start_units(&mut self) {
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

    /// Phase 7: the ports of the first-level caches (CH-8).
    fn look_up_lines(&mut self) {
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
        if in_flight.is_none() && l1.is_full() && !crate::first_level::is_resident(&l1.cache, LineAddr(line))
        {
            l1.parked.push_back(number);
            self.wait(number, Stall::Mshr);
            return;
        }
        let outcome = crate::first_level::access(&mut l1.cache, LineAddr(line));
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

    /// Phase 8: the bus manager takes one part and looks up its tag (CH-12, CH-13).
    fn look_up_tag(&mut self) {
        if self.missed == 0 {
            return;
        }
        self.last_cache = round_robin(self.missed, self.last_cache);
        let parts = &mut self.l1[self.last_cache as usize].parts;
        let Some(part) = parts.pop_front() else { return };
        if parts.is_empty() {
            self.missed &= !(1 << self.last_cache);
        }
        let mut moves = std::mem::take(&mut self.moves);
        let WhereOnCard { card, missed } = self.tags.locate(HostAddr(part.addr), &mut moves);
        let mut ready = self.now;
        let MetadataPlace { begin, granule } = MetadataPlace::of(self.config);
        for step in moves.drain(..) {
            let addr = begin + u64::from(step.granule) * granule;
            match step.direction {
                Direction::Read => {
                    let span = self.transfer(part.packet, Traffic::MetadataRead, addr, granule);
                    ready = ready.max(span.end);
                }
                Direction::Write => {
                    self.transfer(part.packet, Traffic::MetadataWriteBack, addr, granule);
                }
            }
        }
        self.moves = moves;
        let line = self.config.cache.geometry.line_of(HostAddr(part.addr));
        if self.config.version != Version::None {
            ready += u64::from(self.config.tag_latency);
        }
        self.tags_known = self.tags_known.max(ready);
        let latest = if missed {
            let begin = card - u64::from(self.config.cache.geometry.offset_of(HostAddr(part.addr)));
            let load = Load { line, card: begin };
            self.loading.push_back(LoadInFlight { load, there: u64::MAX, packet: part.packet });
            Some(self.loading.len() - 1)
        } else {
            self.loading.iter().rposition(|loading| loading.load.line == line)
        };
        let load = latest.map(|place| LoadId(self.arrived + place as u64));
        let found = match (missed, load) {
            (true, _) => Found::Missing,
            (false, Some(_)) => Found::InFlight,
            (false, None) => Found::Resident,
        };
        self.report.l2.accesses += 1;
        self.report.l2.misses += u64::from(found == Found::Missing);
        self.report.l2.merged += u64::from(found == Found::InFlight);
        self.observer.look_up(part.packet, Cache::L2, found);
        // It is acted upon in a later cycle, however short the latency.
        let ready = self.tags_known.max(self.now + 1);
        self.tagged.push_back(PendingTag { ready, part, card, missed, load });
        self.arrival = self.arrival.min(ready);
    }

    /// Moves bytes between the chip and the on-board memory, for a packet.
    fn transfer(&mut self, packet: u32, traffic: Traffic, card: u64, bytes: u64) -> Span {
        let direction = match traffic {
            Traffic::VmFill | Traffic::MetadataWriteBack => Direction::Write,
            _ => Direction::Read,
        };
        self.observer.request(self.now, card, bytes, direction);
        self.observe_commands();
        let span = self.sdram.transfer(self.now, card, bytes, direction);
        let moved = self.config.sdram.moved(card, bytes);
        *bytes_of(&mut self.report, traffic) += moved;
        self.observer.transfer(packet, traffic, span, moved);
        span
    }

    /// The commands that the memory chips were given before this cycle.
    fn observe_commands(&mut self) {
        while let Some((clock, command)) = self.sdram.take_command(self.now) {
            self.observer.command(clock, command);
        }
    }

    /// Reads a part of a first-level line; with the last one, the line returns (CH-16).
    fn read_part(&mut self, part: LinePart, card: u64) {
        self.observer.part_is_read(self.now, HostAddr(part.addr), part.bytes.into(), card);
        let span = self.transfer(part.packet, Traffic::L1Fill, card, part.bytes.into());
        let way = self.in_flight(part);
        way.parts -= 1;
        if way.parts == 0 {
            let there = span.end + u64::from(self.config.return_latency);
            self.returning.push_back((there, part.cache, part.register));
        }
    }

    fn in_flight(&mut self, part: LinePart) -> &mut LineInFlight {
        &mut self.l1[usize::from(part.cache)].in_flight[usize::from(part.register)]
    }

    /// The threads that wait for a first-level line now wait because of `stall`.
    fn blame(&mut self, part: LinePart, stall: Stall) {
        let mut thread = self.in_flight(part).waiter;
        while thread != NONE {
            self.wait(thread, stall);
            thread = self.threads[thread as usize].next;
        }
    }

    /// Begins the next operation, or ends the packet.
    fn begin(&mut self, number: u32) {
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
    fn ask(&mut self, number: u32) {
        self.wait(number, Stall::Port);
        let (pipeline, bit) = split(number);
        let cache = self.threads[number as usize].port as usize;
        self.l1[cache].ask(pipeline, bit);
        self.asked |= 1 << cache;
    }

    /// The line that a thread waits for is there (CH-7).
    #[inline]
    fn answer(&mut self, number: u32) {
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
    fn wait(&mut self, number: u32, stall: Stall) {
        let thread = &mut self.threads[number as usize];
        let before = std::mem::replace(&mut thread.stall, stall);
        self.units[unit_of(split(number).0, thread.port)].wait_on(before, stall, self.now);
    }
}

/// Where version B's metadata lie on the card: behind the lines (CH-17).
struct MetadataPlace {
    begin: u64,
    granule: u64,
}

impl MetadataPlace {
    fn of(config: &ChipConfig) -> Self {
        Self { begin: config.cache.geometry.memory().0, granule: config.metadata_cache.granule.into() }
    }
}
