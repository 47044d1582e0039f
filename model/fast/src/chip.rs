//! The chip in time, from event to event. Twin of `saarcor_model::time::simulate`, whose reports these
//! are to the cycle.
//!
//! The phases of a cycle are those of the specification (CH-5). Cycles in which no phase has anything
//! to do are left out. Threads are bits of masks and members of linked lists, and what will happen in
//! later cycles stands in a wheel of events. Beyond the specification, a run may take only some packets
//! in time ([`simulate_part`]), and an observer may watch each transfer ([`ChipObserver`]).

mod at_once;
mod bus_manager;
mod first_level;
mod observer;
mod tags;
mod thread;
mod unit;
mod wheel;

pub use at_once::Caches;
pub use observer::{Cache, ChipObserver, Found, Traffic};

use crate::pci::Pci;
use crate::sdram::Sdram;
use bus_manager::{LoadInFlight, PendingTag};
use first_level::{FirstLevelState, LinePart};
use saarcor_model::time::{ChipConfig, ConfigError, LoadId, Program, Programs, TimingReport};
use saarcor_model::vm::Unit;
use std::collections::VecDeque;
use tags::{MetadataMove, Tags, tags};
use thread::{NONE, Stage, THREADS, Thread};
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
    /// By their place ([`thread::unit_of`]).
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
            threads: std::iter::repeat_with(|| Thread::FREE).take(numbers).collect(),
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
}
