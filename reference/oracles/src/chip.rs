//! The chip in time, written for obviousness: every cycle is taken, one after the other, and in
//! each all parts are asked, in the phases of the model's `SPEC.md` (CH-5), what they do.
//!
//! Threads, requests and lines are records in lists; nothing is kept that could be found by
//! looking. The memory chips go clock by clock and give the commands that they may.

use crate::cache::NaiveCache;
use crate::metadata::{GranuleEvent, NaiveTags};
use saarcor_model::time::standard::CHIP_CACHE_WAYS;
use saarcor_model::time::{
    CacheReport, ChipConfig, Direction, Operation, Programs, SdramConfig, Stall, TimingReport, Version,
};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, LineAddr, Outcome, Policy, Unit};
use std::collections::VecDeque;

/// What a thread is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Free,
    /// It asks for a look-up.
    Asks,
    /// The cache answers in that cycle.
    LooksUp {
        answer: u64,
    },
    /// All registers of the cache are taken.
    Parked,
    /// Its line is in flight.
    Waits,
    /// Its bytes are there.
    Ready,
    /// A unit works for it, and is done in that cycle.
    Works {
        done: u64,
    },
}

#[derive(Clone, Debug)]
struct Thread {
    state: State,
    program: VecDeque<Operation>,
    /// Lines of the operation at hand that have not come yet.
    lines: VecDeque<u64>,
}

/// A first-level line in flight.
#[derive(Clone, Debug)]
struct FirstLevelLine {
    line: u64,
    /// Places of the threads that wait.
    waiting: Vec<usize>,
    /// Numbers of its requests to the memory chips.
    reads: Vec<usize>,
    /// Parts that no request was made for yet.
    parts_left: usize,
}

struct FirstLevel {
    directory: NaiveCache,
    in_flight: Vec<FirstLevelLine>,
    parts: VecDeque<Part>,
    /// Places of the threads that wait for a register, in the order in which they came.
    parked: VecDeque<usize>,
    /// Pipeline, and thread of each pipeline, that was served last.
    last_pipeline: Option<usize>,
    last_thread: Vec<Option<usize>>,
    report: CacheReport,
}

#[derive(Clone, Copy, Debug)]
struct Part {
    cache: usize,
    first_level_line: u64,
    addr: u64,
    bytes: u64,
}

/// A part whose tag was looked up in cycle `asked`.
struct Tag {
    asked: u64,
    part: Part,
    line: u64,
    card: u64,
    loads: bool,
    metadata_reads: Vec<usize>,
}

/// A line that comes from the host.
struct HostLine {
    line: u64,
    card: u64,
    requested: bool,
}

/// The next of `members`, in their order, after `last`, round and round.
fn after(members: &[usize], last: Option<usize>) -> usize {
    let later = members.iter().find(|&&member| last.is_none_or(|last| member > last));
    *later.unwrap_or(&members[0])
}

struct NaiveChip<'a> {
    config: &'a ChipConfig,
    now: u64,
    triangles: u64,
    packets: VecDeque<&'a [Operation]>,
    last_pipeline: Option<usize>,
    threads: Vec<Thread>,
    /// For each unit: the thread served last, and the first cycle in which it is free.
    units: Vec<(Option<usize>, u64)>,
    first_level: Vec<FirstLevel>,
    last_cache: Option<usize>,
    directory: NaiveCache,
    /// Version B's tags, in the place of the directory.
    tags_of_b: Option<NaiveTags>,
    tags: VecDeque<Tag>,
    from_host: VecDeque<HostLine>,
    /// The transfer over the bus to the host ends in this cycle.
    bus: Option<u64>,
    waiting: VecDeque<(u64, Part, u64)>,
    memory: NaiveMemory,
    report: TimingReport,
}

/// Plays `programs` as the rules say: the judge of the model's `simulate`.
///
/// # Panics
/// If the configuration makes no chip.
#[must_use]
pub fn naive_simulate(before: &[Programs], programs: &Programs, config: &ChipConfig) -> TimingReport {
    config.check().expect("a configuration that makes a chip");
    let mut chip = NaiveChip::new(programs, config);
    for operation in before.iter().flat_map(Programs::in_order) {
        chip.warm(operation);
    }
    while !chip.step() {}
    chip.report
}

impl<'a> NaiveChip<'a> {
    fn new(programs: &'a Programs, config: &'a ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        let first_level = |port: usize| FirstLevel {
            directory: NaiveCache::new(four_ways(u64::from(config.l1[port].sets))),
            in_flight: Vec::new(),
            parts: VecDeque::new(),
            parked: VecDeque::new(),
            last_pipeline: None,
            last_thread: vec![None; pipelines],
            report: CacheReport::default(),
        };
        let thread = Thread { state: State::Free, program: VecDeque::new(), lines: VecDeque::new() };
        Self {
            config,
            now: 0,
            triangles: programs.triangles.0.into(),
            packets: programs.packets.iter().map(|packet| &**packet).collect(),
            last_pipeline: None,
            threads: vec![thread; pipelines * threads],
            units: vec![(None, 0); pipelines * 4],
            first_level: (0..4).map(first_level).collect(),
            last_cache: None,
            directory: NaiveCache::new(config.cache),
            tags_of_b: (config.version == Version::B).then(|| {
                let cached = config.metadata_cache;
                NaiveTags::new(config.cache, cached.granule as usize, cached.sets() as usize, CHIP_CACHE_WAYS)
            }),
            tags: VecDeque::new(),
            from_host: VecDeque::new(),
            bus: None,
            waiting: VecDeque::new(),
            memory: NaiveMemory::new(config.sdram),
            report: TimingReport::default(),
        }
    }

    fn pipeline_of(&self, thread: usize) -> usize {
        thread / self.config.threads as usize
    }

    fn lines_of(&self, operation: &Operation) -> VecDeque<u64> {
        let bytes = u64::from(self.config.l1[operation.unit as usize].line);
        let base = if operation.unit == Unit::Intersection { self.triangles } else { 0 };
        let first = u64::from(operation.addr.0).saturating_sub(base);
        let mut lines: VecDeque<u64> =
            (first..first + u64::from(operation.bytes)).map(|byte| byte / bytes).collect();
        lines.make_contiguous().sort_unstable();
        let mut distinct = VecDeque::new();
        for line in lines {
            if distinct.back() != Some(&line) {
                distinct.push_back(line);
            }
        }
        distinct
    }

    /// The parts of a first-level line, byte by byte (CH-12).
    fn parts_of(&self, cache: usize, first_level_line: u64) -> Vec<Part> {
        let base = if cache == Unit::Intersection as usize { self.triangles } else { 0 };
        let bytes = u64::from(self.config.l1[cache].line);
        let begin = base + first_level_line * bytes;
        let vm_line = |addr: u64| match self.config.version {
            Version::None => 0,
            _ => addr / self.config.cache.geometry.line().0,
        };
        let mut parts: Vec<Part> = Vec::new();
        for addr in (begin..begin + bytes).filter(|&addr| addr < 1 << 32) {
            match parts.last_mut() {
                Some(part) if vm_line(part.addr) == vm_line(addr) => part.bytes += 1,
                _ => parts.push(Part { cache, first_level_line, addr, bytes: 1 }),
            }
        }
        parts
    }

    /// CH-19.
    fn warm(&mut self, operation: &Operation) {
        let cache = operation.unit as usize;
        for line in self.lines_of(operation) {
            let outcome = self.first_level[cache].directory.access(LineAddr(line as u32));
            if let Outcome::Miss { .. } = outcome {
                for part in self.parts_of(cache, line) {
                    self.locate(part.addr);
                }
            }
        }
    }

    /// One cycle; whether all was done before it.
    fn step(&mut self) -> bool {
        self.memory.refresh_when_due(self.now);
        self.phase_1_units_and_caches_answer();
        self.phase_2_lines_from_memory();
        self.phase_3_line_from_host();
        self.phase_4_tags();
        self.phase_5_hand_out();
        if self.packets.is_empty() && self.threads.iter().all(|thread| thread.state == State::Free) {
            self.report.cycles = self.now;
            return true;
        }
        self.phase_6_units();
        self.phase_7_ports();
        self.phase_8_bus_manager();
        self.account();
        self.memory.clock(self.now);
        self.now += 1;
        false
    }

    fn phase_1_units_and_caches_answer(&mut self) {
        for place in 0..self.threads.len() {
            match self.threads[place].state {
                State::Works { done } if done == self.now => self.end(place),
                State::LooksUp { answer } if answer == self.now => self.answer(place),
                _ => {}
            }
        }
    }

    fn phase_2_lines_from_memory(&mut self) {
        for cache in 0..4 {
            let latency = u64::from(self.config.return_latency);
            let there = |line: &FirstLevelLine| {
                let arrives = |&read: &usize| {
                    self.memory.requests[read].end.is_some_and(|end| (end + latency) <= self.now)
                };
                line.parts_left == 0 && line.reads.iter().all(arrives)
            };
            let (arrived, others): (Vec<_>, Vec<_>) =
                self.first_level[cache].in_flight.iter().cloned().partition(there);
            self.first_level[cache].in_flight = others;
            for &place in arrived.iter().flat_map(|line| &line.waiting) {
                self.answer(place);
            }
            for _ in arrived {
                self.first_parked_asks_again(cache);
            }
        }
    }

    fn phase_3_line_from_host(&mut self) {
        if self.bus != Some(self.now) {
            return;
        }
        self.bus = None;
        let HostLine { line, card, .. } = self.from_host.pop_front().expect("the line that was asked for");
        let bytes = self.config.cache.geometry.line().0;
        let (_, moved) = self.memory.request(self.now, card, bytes, Direction::Write);
        self.report.vm_fill_bytes += moved;
        for (wanted, part, card) in std::mem::take(&mut self.waiting) {
            if wanted == line {
                self.read(part, card);
            } else {
                self.waiting.push_back((wanted, part, card));
            }
        }
    }

    fn phase_4_tags(&mut self) {
        while let Some(tag) = self.tags.front() {
            let latency =
                if self.config.version == Version::None { 0 } else { u64::from(self.config.tag_latency) };
            let known = tag.asked + latency <= self.now
                && tag
                    .metadata_reads
                    .iter()
                    .all(|&read| self.memory.requests[read].end.is_some_and(|end| end + latency <= self.now));
            if !known {
                break;
            }
            let Tag { part, line, card, loads, .. } = self.tags.pop_front().expect("it is there");
            match self.from_host.iter_mut().find(|host_line| host_line.line == line) {
                Some(host_line) => {
                    host_line.requested |= loads;
                    self.waiting.push_back((line, part, card));
                }
                None => self.read(part, card),
            }
        }
        if self.bus.is_none() && self.from_host.front().is_some_and(|line| line.requested) {
            let bytes = self.config.cache.geometry.line().0;
            let beats = bytes.div_ceil(self.config.pci.beat_bytes.into());
            let cycles = u64::from(self.config.pci.setup) + beats * u64::from(self.config.pci.cycles_a_beat);
            self.bus = Some(self.now + cycles);
            self.report.pci_bytes += bytes;
            self.report.pci_busy += cycles;
        }
    }

    fn phase_5_hand_out(&mut self) {
        let free: Vec<usize> =
            (0..self.threads.len()).filter(|&place| self.threads[place].state == State::Free).collect();
        if free.is_empty() || self.packets.is_empty() {
            return;
        }
        let pipelines: Vec<usize> = free.iter().map(|&place| self.pipeline_of(place)).collect();
        let pipeline = after(&pipelines, self.last_pipeline);
        self.last_pipeline = Some(pipeline);
        let place = free.into_iter().find(|&place| self.pipeline_of(place) == pipeline);
        let place = place.expect("a free thread of that pipeline");
        let program = self.packets.pop_front().expect("a packet");
        self.threads[place].program = program.iter().copied().collect();
        self.begin(place);
    }

    fn phase_6_units(&mut self) {
        for unit in 0..self.units.len() {
            let (pipeline, port) = (unit / 4, unit % 4);
            let wants = |place: &usize| {
                let thread = &self.threads[*place];
                thread.state == State::Ready && thread.program[0].unit as usize == port
            };
            let first = pipeline * self.config.threads as usize;
            let ready: Vec<usize> = (first..first + self.config.threads as usize).filter(wants).collect();
            let (last, free) = self.units[unit];
            if ready.is_empty() || free > self.now {
                continue;
            }
            let place = after(&ready, last);
            let rays = u64::from(self.threads[place].program[0].rays);
            let config = self.config.units[port];
            let busy = rays.div_ceil(config.rays_a_cycle.into()).max(1);
            self.units[unit] = (Some(place), self.now + busy);
            self.threads[place].state = State::Works { done: self.now + busy + u64::from(config.latency) };
            self.report.units[port].operations += 1;
            self.report.units[port].rays += rays;
        }
    }

    fn phase_7_ports(&mut self) {
        for cache in 0..4 {
            for _ in 0..self.config.l1[cache].ports {
                let asks = |place: &usize| {
                    let thread = &self.threads[*place];
                    thread.state == State::Asks && thread.program[0].unit as usize == cache
                };
                let asking: Vec<usize> = (0..self.threads.len()).filter(asks).collect();
                if asking.is_empty() {
                    break;
                }
                let pipelines: Vec<usize> = asking.iter().map(|&place| self.pipeline_of(place)).collect();
                let pipeline = after(&pipelines, self.first_level[cache].last_pipeline);
                self.first_level[cache].last_pipeline = Some(pipeline);
                let own: Vec<usize> =
                    asking.into_iter().filter(|&place| self.pipeline_of(place) == pipeline).collect();
                let place = after(&own, self.first_level[cache].last_thread[pipeline]);
                self.first_level[cache].last_thread[pipeline] = Some(place);
                self.look_up(cache, place);
                if self.first_level[cache].in_flight.len() < self.config.l1[cache].mshrs as usize {
                    self.first_parked_asks_again(cache);
                }
            }
        }
    }

    /// CH-11.
    fn first_parked_asks_again(&mut self, cache: usize) {
        if let Some(place) = self.first_level[cache].parked.pop_front() {
            self.threads[place].state = State::Asks;
        }
    }

    fn look_up(&mut self, cache: usize, place: usize) {
        let line = self.threads[place].lines[0];
        let address = LineAddr(line as u32);
        let config = self.config.l1[cache];
        let first_level = &mut self.first_level[cache];
        let in_flight = first_level.in_flight.iter().position(|other| other.line == line);
        let set = first_level.directory.set_of(address);
        let resident = first_level.directory.slots(set).contains(&Some(address));
        let full = first_level.in_flight.len() == config.mshrs as usize;
        if in_flight.is_none() && !resident && full {
            self.threads[place].state = State::Parked;
            first_level.parked.push_back(place);
            return;
        }
        first_level.report.accesses += 1;
        first_level.directory.access(address);
        if let Some(way) = in_flight {
            first_level.report.merged += 1;
            first_level.in_flight[way].waiting.push(place);
            self.threads[place].state = State::Waits;
        } else if resident {
            self.threads[place].state = State::LooksUp { answer: self.now + u64::from(config.latency) };
        } else {
            first_level.report.misses += 1;
            let parts = self.parts_of(cache, line);
            let (waiting, parts_left) = (vec![place], parts.len());
            let in_flight = FirstLevelLine { line, waiting, reads: Vec::new(), parts_left };
            self.first_level[cache].in_flight.push(in_flight);
            self.first_level[cache].parts.extend(parts);
            self.threads[place].state = State::Waits;
        }
    }

    /// Where the byte at `addr` lies, whether its line was missed, and the metadata that moves.
    fn locate(&mut self, addr: u64) -> (u64, bool, Vec<(u64, Direction)>) {
        if self.config.version == Version::None {
            return (addr, false, Vec::new());
        }
        let line_bytes = self.config.cache.geometry.line().0;
        let line = LineAddr((addr / line_bytes) as u32);
        let set = self.directory.set_of(line);
        let mut moved = Vec::new();
        let outcome = match &mut self.tags_of_b {
            Some(tags) => tags.access(line, &mut moved),
            None => self.directory.access(line),
        };
        let slot = set * u64::from(self.config.cache.geometry.ways()) + u64::from(outcome.way().0);
        let moves = moved.into_iter().filter_map(|moved| match moved {
            GranuleEvent::Found(_) => None,
            GranuleEvent::Read(granule) => Some((granule.into(), Direction::Read)),
            GranuleEvent::WrittenBack(granule, _) => Some((granule.into(), Direction::Write)),
        });
        (slot * line_bytes + addr % line_bytes, matches!(outcome, Outcome::Miss { .. }), moves.collect())
    }

    fn phase_8_bus_manager(&mut self) {
        let asking: Vec<usize> = (0..4).filter(|&cache| !self.first_level[cache].parts.is_empty()).collect();
        if asking.is_empty() {
            return;
        }
        let cache = after(&asking, self.last_cache);
        self.last_cache = Some(cache);
        let part = self.first_level[cache].parts.pop_front().expect("a part");
        let (card, missed, moves) = self.locate(part.addr);
        let begin = self.config.cache.geometry.memory().0;
        let granule = u64::from(self.config.metadata_cache.granule);
        let mut metadata_reads = Vec::new();
        for (number, direction) in moves {
            let (request, moved) =
                self.memory.request(self.now, begin + number * granule, granule, direction);
            match direction {
                Direction::Read => {
                    metadata_reads.push(request);
                    self.report.metadata_read_bytes += moved;
                }
                Direction::Write => self.report.metadata_write_back_bytes += moved,
            }
        }
        let line_bytes = self.config.cache.geometry.line().0;
        let line = part.addr / line_bytes;
        let in_flight = self.from_host.iter().any(|other| other.line == line);
        let loads = missed && !in_flight;
        self.report.l2.accesses += 1;
        self.report.l2.merged += u64::from(in_flight);
        self.report.l2.misses += u64::from(loads);
        if loads {
            let card = card / line_bytes * line_bytes;
            self.from_host.push_back(HostLine { line, card, requested: false });
        }
        self.tags.push_back(Tag { asked: self.now, part, line, card, loads, metadata_reads });
    }

    fn read(&mut self, part: Part, card: u64) {
        let (request, moved) = self.memory.request(self.now, card, part.bytes, Direction::Read);
        self.report.l1_fill_bytes += moved;
        let in_flight = &mut self.first_level[part.cache].in_flight;
        let line = in_flight.iter_mut().find(|line| line.line == part.first_level_line);
        let line = line.expect("the line that the part is of");
        line.parts_left -= 1;
        line.reads.push(request);
    }

    fn begin(&mut self, place: usize) {
        let Some(operation) = self.threads[place].program.front().copied() else {
            self.threads[place].state = State::Free;
            return;
        };
        self.threads[place].lines = self.lines_of(&operation);
        self.threads[place].state = if operation.bytes == 0 { State::Ready } else { State::Asks };
    }

    fn answer(&mut self, place: usize) {
        let thread = &mut self.threads[place];
        thread.lines.pop_front();
        if !thread.lines.is_empty() {
            thread.state = State::Asks;
        } else if thread.program[0].rays == 0 {
            self.end(place);
        } else {
            thread.state = State::Ready;
        }
    }

    fn end(&mut self, place: usize) {
        self.threads[place].program.pop_front();
        self.begin(place);
    }

    /// What each unit does in this cycle (CH-18).
    fn account(&mut self) {
        for unit in 0..self.units.len() {
            let (pipeline, port) = (unit / 4, unit % 4);
            let first = pipeline * self.config.threads as usize;
            let stalls: Vec<Stall> = (first..first + self.config.threads as usize)
                .filter_map(|place| {
                    let thread = &self.threads[place];
                    let operation = thread.program.front()?;
                    if operation.unit as usize != port {
                        return None;
                    }
                    match thread.state {
                        State::LooksUp { .. } => Some(Stall::LookUp),
                        State::Asks => Some(Stall::Port),
                        State::Parked => Some(Stall::Mshr),
                        State::Waits => {
                            let line = thread.lines[0];
                            let from_host = self
                                .waiting
                                .iter()
                                .any(|(_, part, _)| part.cache == port && part.first_level_line == line);
                            Some(if from_host { Stall::Host } else { Stall::Memory })
                        }
                        State::Free | State::Ready | State::Works { .. } => None,
                    }
                })
                .collect();
            let report = &mut self.report.units[port];
            let first_cause = Stall::ALL.into_iter().position(|stall| stalls.contains(&stall));
            match first_cause {
                _ if self.units[unit].1 > self.now => report.busy += 1,
                Some(cause) => report.stalls[cause] += 1,
                None => report.idle += 1,
            }
        }
        self.report.l1 = std::array::from_fn(|cache| self.first_level[cache].report);
    }
}

/// A cache of 4 ways and LRU, indexed by the lower bits, for lines that the caller numbers.
fn four_ways(sets: u64) -> CacheConfig {
    let lines = Bytes(sets * CHIP_CACHE_WAYS as u64);
    let geometry = Geometry::new(lines, Bytes(1), CHIP_CACHE_WAYS as u32).expect("a power of two of sets");
    CacheConfig { geometry, hash: Hash::Low, policy: Policy::Lru }
}

/// The memory chips, clock by clock.
struct NaiveMemory {
    config: SdramConfig,
    requests: Vec<Request>,
    /// Pieces whose read or write command is still to be given, and refreshes, in order.
    queue: VecDeque<Piece>,
    banks: Vec<NaiveBank>,
    next_refresh: u64,
    refreshes_until: u64,
    data_until: u64,
    last_command: Option<u64>,
}

struct Request {
    /// Core cycle after the last beat, once it is known.
    end: Option<u64>,
}

/// A part of a request in one row, or a refresh that is due at a clock.
enum Piece {
    Transfer { request: usize, bank: usize, row: u64, beats: u64, direction: Direction, is_last: bool },
    Refresh { due: u64 },
}

#[derive(Clone, Default)]
struct NaiveBank {
    open: Option<u64>,
    opened: Option<u64>,
    /// The bank is closed from this clock on.
    closed: u64,
    may_close: u64,
}

impl NaiveMemory {
    fn new(config: SdramConfig) -> Self {
        Self {
            config,
            requests: Vec::new(),
            queue: VecDeque::new(),
            banks: vec![NaiveBank::default(); config.banks as usize],
            next_refresh: config.refresh_interval.into(),
            refreshes_until: 0,
            data_until: 0,
            last_command: None,
        }
    }

    /// A request in cycle `now`: its number, and the bytes that move.
    fn request(&mut self, now: u64, addr: u64, bytes: u64, direction: Direction) -> (usize, u64) {
        self.refresh_when_due(now);
        let (beat, row) = (u64::from(self.config.beat_bytes), u64::from(self.config.row_bytes));
        let beats: Vec<u64> = (addr / beat..=(addr + bytes - 1) / beat).collect();
        let request = self.requests.len();
        self.requests.push(Request { end: None });
        let mut pieces: Vec<(u64, u64)> = Vec::new();
        for beat_number in &beats {
            let row_number = beat_number * beat / row;
            match pieces.last_mut() {
                Some((other, beats)) if *other == row_number => *beats += 1,
                _ => pieces.push((row_number, 1)),
            }
        }
        let count = pieces.len();
        for (place, (row_number, beats)) in pieces.into_iter().enumerate() {
            let banks = u64::from(self.config.banks);
            let (bank, row) = ((row_number % banks) as usize, row_number / banks);
            let is_last = place + 1 == count;
            self.queue.push_back(Piece::Transfer { request, bank, row, beats, direction, is_last });
        }
        (request, beats.len() as u64 * beat)
    }

    /// Requests of a cycle count from the clock on that begins in it or after it.
    fn refresh_when_due(&mut self, now: u64) {
        let interval = u64::from(self.config.refresh_interval);
        while interval != 0 && self.next_refresh <= now.div_ceil(self.config.cycles_a_clock.into()) {
            self.queue.push_back(Piece::Refresh { due: self.next_refresh });
            self.next_refresh += interval;
        }
    }

    /// The clock that begins in cycle `now`, if any does.
    fn clock(&mut self, now: u64) {
        let cycles = u64::from(self.config.cycles_a_clock);
        let clock = now / cycles;
        if !now.is_multiple_of(cycles) || clock < self.refreshes_until {
            return;
        }
        if let Some(&Piece::Refresh { due }) = self.queue.front() {
            let quiet = self.banks.iter().all(|bank| clock >= bank.may_close);
            if clock >= due && clock >= self.data_until && quiet {
                self.queue.pop_front();
                self.refreshes_until =
                    clock + u64::from(self.config.precharge) + u64::from(self.config.refresh);
                for bank in &mut self.banks {
                    (bank.open, bank.closed, bank.may_close) =
                        (None, self.refreshes_until, self.refreshes_until);
                }
            }
            return;
        }
        self.open_rows(clock);
        self.give_command(clock);
    }

    /// The oldest piece of each bank has its row opened, once the other is closed.
    fn open_rows(&mut self, clock: u64) {
        let mut seen = Vec::new();
        for piece in &self.queue {
            let &Piece::Transfer { bank: number, row, .. } = piece else { break };
            if seen.contains(&number) {
                continue;
            }
            seen.push(number);
            let bank = &mut self.banks[number];
            if bank.open.is_some_and(|open| open != row) && clock >= bank.may_close {
                bank.open = None;
                bank.closed = clock + u64::from(self.config.precharge);
            }
            let cycle_over =
                bank.opened.is_none_or(|opened| clock >= opened + u64::from(self.config.row_cycle));
            if bank.open.is_none() && clock >= bank.closed && cycle_over {
                bank.open = Some(row);
                bank.opened = Some(clock);
            }
        }
    }

    /// The oldest piece gets its command, if its row is open and the bus will be free.
    fn give_command(&mut self, clock: u64) {
        let Some(&Piece::Transfer { request, bank, row, beats, direction, is_last }) = self.queue.front()
        else {
            return;
        };
        let bank = &mut self.banks[bank];
        let open = bank.open == Some(row)
            && bank.opened.is_some_and(|opened| clock >= opened + u64::from(self.config.ras_to_cas));
        let latency = if direction == Direction::Read { u64::from(self.config.cas) } else { 0 };
        let in_order = self.last_command.is_none_or(|last| clock > last);
        if !open || !in_order || clock + latency < self.data_until {
            return;
        }
        self.queue.pop_front();
        self.last_command = Some(clock);
        self.data_until = clock + latency + beats;
        let may_close = match direction {
            Direction::Read => clock + beats,
            Direction::Write => self.data_until + u64::from(self.config.write_recovery),
        };
        bank.may_close = bank.may_close.max(may_close);
        if is_last {
            self.requests[request].end = Some(self.data_until * u64::from(self.config.cycles_a_clock));
        }
    }
}
