//! What must hold in every cycle of a run, phase by phase: each law looks at the chip after each phase and
//! keeps a book of its own. The theorems of this folder hold small chips to one law each; `tests/time.rs`
//! holds large ones to all.

use crate::source::Stop;
use saarcor_model::time::{
    CacheReport, Chip, ChipConfig, Operation, Programs, SdramConfig, Stall, State, TimingReport, Version,
};
use saarcor_model::vm::{HostAddr, LineAddr, Unit};
use std::collections::VecDeque;

/// What a law says against a run: nothing, or what is wrong.
pub type Verdict = Result<(), String>;

/// What must hold in a run.
pub trait Law {
    /// Looks at the chip after a phase (CH-5).
    ///
    /// # Errors
    /// What is wrong.
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict;

    /// Looks at the report of the whole run.
    ///
    /// # Errors
    /// What is wrong.
    fn reported(&mut self, _report: &TimingReport) -> Verdict {
        Ok(())
    }
}

/// Demands that something holds; the rest says what is wrong.
macro_rules! demand {
    ($holds:expr, $($wrong:tt)+) => {
        if !$holds {
            return Err(format!($($wrong)+));
        }
    };
}

/// Runs `programs`, and holds the run to `laws`, and to an end within the cycles of [`longest_run`].
///
/// # Errors
/// The first law that is broken: in which cycle, after which phase, and how.
pub fn run(
    config: &ChipConfig,
    before: &[Programs],
    programs: &Programs,
    laws: &mut [&mut dyn Law],
) -> Result<TimingReport, String> {
    let mut chip = Chip::new(before, programs, config).map_err(|error| error.to_string())?;
    let longest = longest_run(config, programs);
    let mut broken = None;
    let mut over = false;
    while !over {
        over = chip.cycle(|phase, chip| {
            for law in &mut *laws {
                if broken.is_none()
                    && let Err(wrong) = law.seen(phase, chip)
                {
                    broken = Some(format!("cycle {}, phase {phase}: {wrong}", chip.now));
                }
            }
        });
        if let Some(broken) = broken.take() {
            return Err(broken);
        }
        demand!(chip.now <= longest, "packets wait for ever: not over after {longest} cycles");
    }
    let report = chip.report();
    for law in laws {
        law.reported(&report)?;
    }
    Ok(report)
}

/// Holds the run of a theorem to a law.
///
/// # Errors
/// Where it is broken.
pub fn held(config: &ChipConfig, programs: &Programs, law: &mut dyn Law) -> Result<TimingReport, Stop> {
    run(config, &[], programs, &mut [law])
        .map_err(|wrong| Stop::Disproved(format!("{wrong}: {programs:?} on {config:?}")))
}

/// Cycles within which any run ends: those that it would take if each part of the chip waited for all others.
#[must_use]
pub fn longest_run(config: &ChipConfig, programs: &Programs) -> u64 {
    let SdramConfig { cycles_a_clock, beat_bytes, row_bytes, banks: _, .. } = config.sdram;
    let sdram = config.sdram;
    let opening = [sdram.ras_to_cas, sdram.precharge, sdram.row_active, sdram.row_cycle, sdram.row_to_row];
    let data = [sdram.cas, sdram.write_recovery];
    // A clock for each of its three commands, and one to come at.
    let a_job = opening.iter().chain(&data).map(|&clocks| u64::from(clocks)).sum::<u64>() + 4;
    let a_refresh = u64::from(sdram.precharge) + u64::from(sdram.refresh) + 2;
    // A transfer is a job a row, and one beat more than its bytes need.
    let transfer = |bytes: u64| {
        let jobs = bytes / u64::from(row_bytes) + 2;
        let clocks = jobs * a_job + bytes / u64::from(beat_bytes) + 2;
        let held_up = if sdram.refresh_interval == 0 { 1 } else { a_refresh + clocks };
        (clocks + a_refresh) * held_up * u64::from(cycles_a_clock)
    };
    let mut cycles = 16;
    let part = |bytes: u64| {
        let latency = 2 + u64::from(config.tag_latency);
        let vm_line = config.cache.geometry.line().0;
        let granule = u64::from(config.metadata_cache.granule);
        latency
            + transfer(bytes)
            + match config.version {
                Version::None => 0,
                Version::A => config.pci.cycles(vm_line) + transfer(vm_line),
                // The 5 bytes of each of 16 entries, and as many granules that they evict.
                Version::B => {
                    let granules = 2 * (5 * 16 / granule + 2);
                    config.pci.cycles(vm_line) + transfer(vm_line) + granules * transfer(granule)
                }
            }
    };
    for packet in &programs.packets {
        cycles += 2;
        for operation in packet.iter() {
            let (kind, l1) = (operation.unit as usize, config.l1[operation.unit as usize]);
            let lines = u64::from(operation.bytes) / u64::from(l1.line) + 2;
            let line = u64::from(l1.latency) + u64::from(config.return_latency) + 2;
            // At most two parts, as a line is no longer than one of the virtual memory.
            cycles += lines * (line + 2 * part(l1.line.into()));
            cycles += u64::from(operation.rays) + u64::from(config.units[kind].latency) + 2;
        }
    }
    cycles
}

/// The pipeline of a thread.
fn pipeline(config: &ChipConfig, thread: usize) -> usize {
    thread / config.threads as usize
}

/// The lines of an operation, worked out from its bytes one by one.
fn lines_of(config: &ChipConfig, programs: &Programs, operation: &Operation) -> VecDeque<LineAddr> {
    let base = if operation.unit == Unit::Intersection { programs.triangles.0 } else { 0 };
    let line = u64::from(config.l1[operation.unit as usize].line);
    let begin = u64::from(operation.addr.0.max(base));
    let mut lines = VecDeque::new();
    for byte in begin..(begin + u64::from(operation.bytes)).min(1 << 32) {
        let number = LineAddr(((byte - u64::from(base)) / line) as u32);
        if lines.back() != Some(&number) {
            lines.push_back(number);
        }
    }
    lines
}

/// Nothing but that the run ends.
pub struct Nothing;

impl Law for Nothing {
    fn seen(&mut self, _phase: u32, _chip: &Chip) -> Verdict {
        Ok(())
    }
}

/// Packets are handed out in order, one a cycle while a thread is free, to the pipelines in turn, and there
/// to the free thread of the lowest number (CH-4).
pub struct HandOut<'a> {
    config: &'a ChipConfig,
    programs: &'a Programs,
    handed_out: usize,
    last: Option<usize>,
    free: Vec<bool>,
}

impl<'a> HandOut<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig, programs: &'a Programs) -> Self {
        Self { config, programs, handed_out: 0, last: None, free: Vec::new() }
    }

    /// The thread that gets the next packet.
    fn next(&self) -> Option<usize> {
        let pipelines = self.config.pipelines as usize;
        let first = self.last.map_or(0, |last| last + 1);
        let in_turn = (first..first + pipelines).map(|pipeline| pipeline % pipelines);
        let threads = self.config.threads as usize;
        in_turn
            .flat_map(|pipeline| pipeline * threads..(pipeline + 1) * threads)
            .find(|&thread| self.free[thread])
    }
}

impl Law for HandOut<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 4 {
            self.free.clear();
            self.free.extend(chip.threads.iter().map(|thread| thread.state == State::Free));
        }
        if phase != 5 {
            return Ok(());
        }
        let packet = self.programs.packets.get(self.handed_out);
        let next = packet.and_then(|packet| Some((self.next()?, packet)));
        for (number, thread) in chip.threads.iter().enumerate() {
            match next {
                Some((own, packet)) if own == number => {
                    let has_it = std::ptr::eq(thread.program, &**packet) && thread.state != State::Free;
                    let nothing = packet.is_empty() && thread.state == State::Free;
                    demand!(has_it || nothing, "packet {} is not thread {number}'s", self.handed_out);
                }
                _ => {
                    let still = (thread.state == State::Free) == self.free[number];
                    demand!(still, "thread {number} got a packet out of turn");
                }
            }
        }
        if let Some((thread, _)) = next {
            self.handed_out += 1;
            self.last = Some(pipeline(self.config, thread));
        }
        let left = self.programs.packets.len() - self.handed_out;
        demand!(chip.packets.len() == left, "{} packets are left, and not {left}", chip.packets.len());
        Ok(())
    }
}

/// A unit takes a ready thread whenever it is free, is busy for the cycles in which the rays go in, and at
/// least one, and ends its latency after that. Of threads that are ready all the while, none is passed over
/// while another one is served twice (CH-6).
pub struct Units<'a> {
    config: &'a ChipConfig,
    /// The cycle from which on each unit is free.
    free: Vec<u64>,
    ready: Vec<bool>,
    /// For each ready thread, those that its unit took since it is.
    taken: Vec<Vec<usize>>,
}

impl<'a> Units<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        Self {
            config,
            free: vec![0; 4 * pipelines],
            ready: vec![false; pipelines * threads],
            taken: vec![Vec::new(); pipelines * threads],
        }
    }
}

impl Law for Units<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 5 {
            for (number, thread) in chip.threads.iter().enumerate() {
                let ready = thread.state == State::Ready;
                if ready && !self.ready[number] {
                    self.taken[number].clear();
                }
                self.ready[number] = ready;
            }
        }
        if phase != 6 {
            return Ok(());
        }
        for place in 0..4 * self.config.pipelines as usize {
            let (own, kind) = (place / 4, place % 4);
            let threads = self.config.threads as usize;
            let waiting = |number: &usize| self.ready[*number] && chip.threads[*number].works_for(kind);
            let waiting: Vec<usize> = (own * threads..(own + 1) * threads).filter(waiting).collect();
            let is_taken = |number: &usize| chip.threads[*number].state != State::Ready;
            let taken: Vec<usize> = waiting.iter().copied().filter(is_taken).collect();
            let is_free = self.free[place] <= chip.now;
            let expected = usize::from(is_free && !waiting.is_empty());
            demand!(
                taken.len() == expected,
                "unit {place}, free {is_free}: it took {taken:?} of {waiting:?}"
            );
            let Some(&thread) = taken.first() else { continue };
            let (rays, rate) = (chip.threads[thread].program[0].rays, self.config.units[kind].rays_a_cycle);
            let cycles = u64::from(rays).div_ceil(u64::from(rate));
            self.free[place] = chip.now + cycles.max(1);
            let done = self.free[place] + u64::from(self.config.units[kind].latency);
            let state = chip.threads[thread].state;
            demand!(
                state == State::Works { done },
                "{rays} rays, {rate} a cycle, done at {done}, but {state:?}"
            );
            for other in waiting.into_iter().filter(|&other| other != thread) {
                let twice = self.taken[other].contains(&thread);
                demand!(!twice, "unit {place} took thread {thread} twice while thread {other} was ready");
                self.taken[other].push(thread);
            }
            self.ready[thread] = false;
        }
        Ok(())
    }
}

/// A thread as the law of threads remembers it.
#[derive(Clone, Debug, PartialEq)]
struct Remembered<'a> {
    state: State,
    program: &'a [Operation],
    lines: VecDeque<LineAddr>,
}

/// A thread asks for the lines of its operations one after another. Each look-up that finds a line, resident
/// or not, is answered once, and no thread goes on without its answer. An operation ends once its bytes are
/// there and its rays are done; then the next one begins (CH-7). A resident line is answered after the
/// latency of the cache (CH-9).
pub struct Threads<'a> {
    config: &'a ChipConfig,
    programs: &'a Programs,
    before: Vec<Remembered<'a>>,
}

impl<'a> Threads<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig, programs: &'a Programs) -> Self {
        let free = Remembered { state: State::Free, program: &[], lines: VecDeque::new() };
        let before = vec![free; (config.pipelines * config.threads) as usize];
        Self { config, programs, before }
    }

    /// What a thread is that begins the first operation of `program`.
    fn begun<'p>(&self, program: &'p [Operation]) -> Remembered<'p> {
        let lines = program.first().map(|operation| lines_of(self.config, self.programs, operation));
        let state = match program.first() {
            None => State::Free,
            Some(operation) if operation.bytes == 0 => State::Ready,
            Some(_) => State::Asks,
        };
        Remembered { state, program, lines: lines.unwrap_or_default() }
    }

    /// What a thread becomes that gets the line for which it asked.
    fn answered<'p>(&self, thread: &Remembered<'p>) -> Remembered<'p> {
        let mut next = thread.clone();
        next.lines.pop_front();
        if !next.lines.is_empty() {
            next.state = State::Asks;
        } else if thread.program[0].rays > 0 {
            next.state = State::Ready;
        } else {
            return self.begun(&thread.program[1..]);
        }
        next
    }
}

impl Law for Threads<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        let now = chip.now;
        for (number, thread) in chip.threads.iter().enumerate() {
            let before = &self.before[number];
            let is_new = phase == 5 && before.state == State::Free && thread.state != State::Free;
            let same = thread.program.len() == before.program.len() && thread.lines == before.lines;
            let with = |state: State| Remembered { state, ..before.clone() };
            let expected = match (phase, before.state) {
                (1, State::Works { done }) if done <= now => self.begun(&before.program[1..]),
                (1, State::LooksUp { answer }) if answer <= now => self.answered(before),
                (2, State::Waits) if thread.state != State::Waits || !same => self.answered(before),
                (2, State::Queued) if thread.state == State::Asks => with(State::Asks),
                (5, _) if is_new => {
                    let packet =
                        self.programs.packets.iter().find(|packet| std::ptr::eq(thread.program, &***packet));
                    let Some(packet) = packet else { return Err(format!("thread {number} has no packet")) };
                    self.begun(packet)
                }
                (6, State::Ready) if matches!(thread.state, State::Works { .. }) => with(thread.state),
                (7, State::Asks | State::Queued) => {
                    let kind = before.program[0].unit as usize;
                    let answer = now + u64::from(self.config.l1[kind].latency);
                    match thread.state {
                        State::LooksUp { .. } => with(State::LooksUp { answer }),
                        State::Asks | State::Waits | State::Queued => with(thread.state),
                        _ => before.clone(),
                    }
                }
                _ => before.clone(),
            };
            let as_expected = thread.state == expected.state
                && std::ptr::eq(thread.program.as_ptr(), expected.program.as_ptr())
                && thread.program.len() == expected.program.len()
                && thread.lines == expected.lines;
            let nothing_left =
                thread.program.is_empty() && expected.program.is_empty() && thread.state == expected.state;
            demand!(
                as_expected || nothing_left,
                "thread {number} was {before:?} and is {thread:?}, not {expected:?}"
            );
            if expected != *before {
                let program = self.program(thread.program);
                self.before[number] = Remembered { state: expected.state, program, lines: expected.lines };
            }
        }
        Ok(())
    }

    /// Each operation that a unit has to do is done once.
    fn reported(&mut self, report: &TimingReport) -> Verdict {
        for unit in Unit::ALL {
            let all = self.programs.packets.iter().flat_map(|packet| packet.iter());
            let own = all
                .filter(|operation| operation.unit == unit && (operation.rays > 0 || operation.bytes == 0));
            let (operations, rays) =
                own.fold((0, 0), |(count, rays), own| (count + 1, rays + u64::from(own.rays)));
            let got = (report.units[unit as usize].operations, report.units[unit as usize].rays);
            demand!(
                got == (operations, rays),
                "{unit:?}: operations and rays {got:?}, not {:?}",
                (operations, rays)
            );
        }
        Ok(())
    }
}

impl<'a> Threads<'a> {
    /// The rest of a packet's program, as the law borrows it.
    fn program(&self, program: &[Operation]) -> &'a [Operation] {
        let holds =
            |packet: &&'a saarcor_model::time::Program| packet.as_ptr_range().contains(&program.as_ptr());
        match self.programs.packets.iter().find(holds) {
            Some(packet) => &packet[packet.len() - program.len()..],
            None => &[],
        }
    }
}

/// A first-level cache looks up at most as many lines a cycle as it has ports, and as many where so many ask.
/// Of pipelines of which threads ask all the while, none is passed over while another one is served twice, and
/// of threads of a pipeline neither (CH-8).
pub struct Ports<'a> {
    config: &'a ChipConfig,
    asking: Vec<bool>,
    accesses: [u64; 4],
    /// For each thread that asks, the threads of its pipeline that were served since it does, and the
    /// pipelines that were served since its own was, which asks.
    served: Vec<Vec<usize>>,
    pipelines: [Vec<Vec<usize>>; 4],
    /// Whether threads wait for a register of each cache.
    queued: [bool; 4],
}

impl<'a> Ports<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        let (pipelines, threads) = (config.pipelines as usize, config.threads as usize);
        Self {
            config,
            asking: vec![false; pipelines * threads],
            accesses: [0; 4],
            served: vec![Vec::new(); pipelines * threads],
            pipelines: [(); 4].map(|()| vec![Vec::new(); pipelines]),
            queued: [false; 4],
        }
    }

    fn of_cache(&mut self, cache: usize, chip: &Chip) -> Verdict {
        let threads = 0..chip.threads.len();
        let own = |&number: &usize| chip.threads[number].works_for(cache);
        let asked = |number: &usize| self.asking[*number];
        let still_asks = |number: &usize| chip.threads[*number].state == State::Asks;
        let pipeline = |number: usize| pipeline(self.config, number);
        // Those that asked before the phase.
        let served: Vec<usize> =
            threads.clone().filter(own).filter(asked).filter(|number| !still_asks(number)).collect();
        let passed: Vec<usize> = threads.clone().filter(own).filter(asked).filter(still_asks).collect();
        let joined =
            threads.filter(own).filter(asked).filter(|&number| chip.threads[number].state == State::Queued);
        let accesses = chip.first_level[cache].report.accesses;
        let looked_up = accesses - self.accesses[cache] + joined.count() as u64;
        self.accesses[cache] = accesses;
        let ports = u64::from(self.config.l1[cache].ports);
        demand!(looked_up <= ports, "{looked_up} look-ups through {ports} ports of cache {cache}");
        let idle = looked_up < ports && !passed.is_empty();
        // A thread that was in the queue, asked again and joined it once more is not counted.
        demand!(
            !idle || ports > 1 && !chip.first_level[cache].queue.is_empty(),
            "cache {cache} passes {passed:?} over"
        );
        // Which threads of the queue asked again between two ports is not to be seen.
        if ports > 1 && (self.queued[cache] || !chip.first_level[cache].queue.is_empty()) {
            self.pipelines[cache].iter_mut().for_each(Vec::clear);
            passed.iter().for_each(|&thread| self.served[thread].clear());
            return Ok(());
        }
        for &other in &passed {
            for &thread in served.iter().filter(|&&thread| pipeline(thread) == pipeline(other)) {
                let twice = self.served[other].contains(&thread);
                demand!(!twice, "cache {cache} served thread {thread} twice while thread {other} asked");
                self.served[other].push(thread);
            }
        }
        for own in 0..self.config.pipelines as usize {
            let is_own = |&&thread: &&usize| pipeline(thread) == own;
            let since = &mut self.pipelines[cache][own];
            if !passed.iter().any(|thread| is_own(&thread)) || served.iter().any(|thread| is_own(&thread)) {
                since.clear();
                continue;
            }
            for other in served.iter().map(|&thread| pipeline(thread)) {
                demand!(
                    !since.contains(&other),
                    "cache {cache} served pipeline {other} twice while {own} asked"
                );
                since.push(other);
            }
        }
        Ok(())
    }
}

impl Law for Ports<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 6 {
            self.queued = [0, 1, 2, 3].map(|cache: usize| !chip.first_level[cache].queue.is_empty());
            for (number, thread) in chip.threads.iter().enumerate() {
                let asks = thread.state == State::Asks;
                if asks && !self.asking[number] {
                    self.served[number].clear();
                }
                self.asking[number] = asks;
            }
        }
        if phase == 7 {
            for cache in 0..4 {
                self.of_cache(cache, chip)?;
            }
            for (number, thread) in chip.threads.iter().enumerate() {
                self.asking[number] &= thread.state == State::Asks;
            }
        }
        Ok(())
    }
}

/// No line is in flight twice, and no more lines than there are registers. Each thread that waits for a line
/// is among those of that line, once, and nobody else is; each that waits for a register is in the queue,
/// once (CH-10, CH-11). So none waits for what nobody answers.
pub struct Waiting<'a> {
    config: &'a ChipConfig,
}

impl<'a> Waiting<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config }
    }
}

impl Law for Waiting<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if !matches!(phase, 2 | 7) {
            return Ok(());
        }
        for (cache, l1) in chip.first_level.iter().enumerate() {
            let registers = self.config.l1[cache].mshrs as usize;
            demand!(
                l1.in_flight.len() <= registers,
                "{} lines in flight, {registers} registers",
                l1.in_flight.len()
            );
            for (place, line) in l1.in_flight.iter().enumerate() {
                let twice = l1.in_flight[..place].iter().any(|other| other.line == line.line);
                demand!(!twice, "cache {cache} fetches line {:?} twice", line.line);
            }
            let (mut waits, mut queued) = (vec![0; chip.threads.len()], vec![0; chip.threads.len()]);
            for line in &l1.in_flight {
                for &number in &line.threads {
                    let asked = chip.threads[number].lines.front();
                    demand!(
                        asked == Some(&line.line),
                        "thread {number} waits for {:?}, and asked for {asked:?}",
                        line.line
                    );
                    waits[number] += 1;
                }
            }
            for &number in &l1.queue {
                queued[number] += 1;
            }
            for (number, thread) in chip.threads.iter().enumerate() {
                let is = |state| u32::from(thread.state == state && thread.works_for(cache));
                let (waits, queued) = (waits[number], queued[number]);
                let right = waits == is(State::Waits) && queued == is(State::Queued);
                demand!(
                    right,
                    "thread {number}, {:?}, waits for {waits} lines and {queued} registers",
                    thread.state
                );
            }
        }
        Ok(())
    }
}

/// A thread joins the queue only while all registers are taken, and for a line that is neither resident nor in
/// flight. The queue is served in its order, whenever a line arrives and after each look-up that leaves a
/// register free (CH-11).
pub struct Queue<'a> {
    config: &'a ChipConfig,
    queues: [VecDeque<usize>; 4],
    in_flight: [usize; 4],
    accesses: [u64; 4],
}

impl<'a> Queue<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config, queues: Default::default(), in_flight: [0; 4], accesses: [0; 4] }
    }
}

impl Law for Queue<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if !matches!(phase, 2 | 7) {
            return Ok(());
        }
        for (cache, l1) in chip.first_level.iter().enumerate() {
            let before = std::mem::replace(&mut self.queues[cache], l1.queue.clone());
            let stayed = before.iter().filter(|number| l1.queue.contains(number)).count();
            let left = before.len() - stayed;
            let in_order = before.iter().skip(left).eq(l1.queue.iter().take(stayed));
            let is_full = l1.in_flight.len() == self.config.l1[cache].mshrs as usize;
            let accesses =
                l1.report.accesses - std::mem::replace(&mut self.accesses[cache], l1.report.accesses);
            let arrived = self.in_flight[cache].saturating_sub(l1.in_flight.len());
            self.in_flight[cache] = l1.in_flight.len();
            // With several ports one may ask again and join once more.
            let once = phase == 2 || self.config.l1[cache].ports == 1;
            demand!(in_order || !once, "queue {before:?} of cache {cache} became {:?}", l1.queue);
            if phase == 2 {
                let served = left == arrived.min(before.len());
                demand!(served, "{arrived} lines arrived at cache {cache}, and {left} of {before:?} left");
                continue;
            }
            // If one is free in the end, each look-up has left one free.
            let asks = (accesses as usize).min(before.len());
            demand!(
                is_full || left == asks,
                "{accesses} look-ups leave a register of cache {cache} free, and {left} of {before:?} ask again"
            );
            for &number in l1.queue.iter().skip(stayed) {
                let line = chip.threads[number].lines[0];
                let in_flight = l1.in_flight.iter().any(|other| other.line == line);
                let waits_in_vain = is_full && !in_flight && (!l1.cache.is_resident(line) || !once);
                demand!(waits_in_vain, "thread {number} waits for a register for {line:?}, full {is_full}");
            }
        }
        Ok(())
    }
}

/// A line in flight arrives as soon as the return latency has passed since the last beat of its parts, and not
/// before (CH-16).
pub struct Arrivals<'a> {
    config: &'a ChipConfig,
    /// Lines in flight to each cache, and the reads of their parts, if all are read.
    in_flight: [Vec<(LineAddr, Option<Vec<saarcor_model::time::TransferId>>)>; 4],
}

impl<'a> Arrivals<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config, in_flight: Default::default() }
    }
}

impl Law for Arrivals<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 2 {
            for (cache, lines) in self.in_flight.iter().enumerate() {
                for (line, reads) in lines {
                    let is_here = |reads: &Vec<_>| {
                        let here = |span: saarcor_model::time::Span| {
                            chip.now >= span.end + u64::from(self.config.return_latency)
                        };
                        reads.iter().all(|&read| chip.sdram.span_of(read).is_some_and(here))
                    };
                    let due = reads.as_ref().is_some_and(is_here);
                    let arrived = chip.first_level[cache].in_flight.iter().all(|other| other.line != *line);
                    demand!(due == arrived, "{line:?} of cache {cache}: due {due}, arrived {arrived}");
                }
            }
        }
        if phase == 8 {
            for (cache, lines) in self.in_flight.iter_mut().enumerate() {
                lines.clear();
                lines.extend(
                    chip.first_level[cache]
                        .in_flight
                        .iter()
                        .map(|line| (line.line, (line.unread == 0).then(|| line.reads.clone()))),
                );
            }
        }
        Ok(())
    }
}

/// In each cycle each unit is busy, stalled or idle: busy while rays go in, stalled by the first cause that
/// holds for a thread of its pipeline, idle else. Counts of all cycles add up to the report (CH-18).
pub struct Account<'a> {
    config: &'a ChipConfig,
    free: Vec<u64>,
    /// Of each unit: cycles that it was busy, stalled by each cause, and idle.
    units: Vec<[u64; 7]>,
}

impl<'a> Account<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        let units = 4 * config.pipelines as usize;
        Self { config, free: vec![0; units], units: vec![[0; 7]; units] }
    }
}

impl Law for Account<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase != 8 {
            return Ok(());
        }
        let threads = self.config.threads as usize;
        for (place, counts) in self.units.iter_mut().enumerate() {
            let own = &chip.threads[place / 4 * threads..(place / 4 + 1) * threads];
            let own = || own.iter().filter(|thread| thread.works_for(place % 4));
            // A unit takes one thread at a time: the one that it works for decides until when rays go in.
            let latency = u64::from(self.config.units[place % 4].latency);
            for thread in own() {
                if let State::Works { done } = thread.state {
                    self.free[place] = self.free[place].max(done - latency);
                }
            }
            let stalled = |of: fn(State) -> bool| own().any(|thread| of(thread.state));
            let cause = if self.free[place] > chip.now {
                0
            } else if stalled(|state| matches!(state, State::LooksUp { .. })) {
                1
            } else if stalled(|state| state == State::Asks) {
                2
            } else if stalled(|state| state == State::Queued) {
                3
            } else {
                // A line comes from the host while a part of it waits for a load.
                let from_host = own().filter(|thread| thread.state == State::Waits).map(|thread| {
                    let line = thread.lines[0];
                    let mut parts = chip.loads.waiting.iter().map(|(_, waiting)| waiting.part);
                    parts.any(|part| part.cache == place % 4 && part.line == line)
                });
                match from_host.min() {
                    Some(false) => 4,
                    Some(true) => 5,
                    None => 6,
                }
            };
            counts[cause] += 1;
        }
        Ok(())
    }

    fn reported(&mut self, report: &TimingReport) -> Verdict {
        for (kind, unit) in report.units.iter().enumerate() {
            let own = self.units.iter().skip(kind).step_by(4);
            let sum = own.fold([0; 7], |sum, unit| std::array::from_fn(|cause| sum[cause] + unit[cause]));
            let [look_up, port, register, memory, host] = unit.stalls;
            let got = [unit.busy, look_up, port, register, memory, host, unit.idle];
            demand!(got == sum, "units {kind}: {got:?}, not {sum:?}");
            let all = unit.busy + unit.stalled() + unit.idle;
            let cycles = report.cycles * u64::from(self.config.pipelines);
            demand!(all == cycles, "units {kind}: busy, stalled and idle for {all} of {cycles} cycles");
            let host = unit.stalls[Stall::Host as usize];
            let from_host = self.config.version != Version::None || host == 0;
            demand!(from_host, "units {kind} wait {host} cycles for a host that loads nothing");
        }
        Ok(())
    }
}

/// Each part that is taken is one look-up of its line, which misses, or hits; it is merged if it hits a line that a
/// load is to bring when the part is taken (CH-14).
pub struct LookUps<'a> {
    config: &'a ChipConfig,
    /// The parts that each cache has, and the first of them.
    parts: [(usize, Option<HostAddr>); 4],
    /// Lines whose loads are in flight.
    loading: Vec<LineAddr>,
    /// Look-ups, misses and merged ones before.
    counts: [u64; 3],
}

impl<'a> LookUps<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config, parts: [(0, None); 4], loading: Vec::new(), counts: [0; 3] }
    }
}

impl Law for LookUps<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        let parts = [0, 1, 2, 3].map(|cache: usize| &chip.first_level[cache].parts);
        if phase == 7 {
            self.parts = parts.map(|parts| (parts.len(), parts.front().map(|part| part.addr)));
            self.loading = chip.loads.in_flight.iter().map(|load| load.line).collect();
        }
        if phase == 8 {
            let CacheReport { accesses, misses, merged, .. } = chip.report.l2;
            let counts = [accesses, misses, merged];
            let before = std::mem::replace(&mut self.counts, counts);
            let [looked_up, missed, merged] = [0, 1, 2].map(|count: usize| counts[count] - before[count]);
            let taken = (0..4).filter(|&cache| parts[cache].len() < self.parts[cache].0);
            let line = taken.filter_map(|cache| self.parts[cache].1).next();
            let line = line.map(|addr| self.config.cache.geometry.line_of(addr));
            let comes = line.is_some_and(|line| self.loading.contains(&line));
            let right = looked_up == u64::from(line.is_some())
                && missed <= looked_up
                && merged == u64::from(comes && missed == 0);
            demand!(
                right,
                "{line:?}: {looked_up} looked up, {missed} missed, {merged} merged, while {:?} are loaded",
                self.loading
            );
        }
        Ok(())
    }
}

/// The parts of a missed line are its bytes, in order, each part within one line of the virtual memory. The
/// bus manager takes one a cycle while there is one, from the first-level caches in turn, and from each in
/// order (CH-12).
pub struct Parts<'a> {
    config: &'a ChipConfig,
    programs: &'a Programs,
    /// Parts that each cache still has, and the lines that are in flight to it.
    parts: [usize; 4],
    lines: [Vec<LineAddr>; 4],
    last: Option<usize>,
}

impl<'a> Parts<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig, programs: &'a Programs) -> Self {
        Self { config, programs, parts: [0; 4], lines: Default::default(), last: None }
    }
}

impl Law for Parts<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 6 {
            for cache in 0..4 {
                self.lines[cache].clear();
                self.lines[cache].extend(chip.first_level[cache].in_flight.iter().map(|line| line.line));
            }
        }
        if phase == 7 {
            for cache in 0..4 {
                let l1 = &chip.first_level[cache];
                let base = if cache == Unit::Intersection as usize { self.programs.triangles.0 } else { 0 };
                let bytes = u64::from(self.config.l1[cache].line);
                let mut new = l1.parts.iter().skip(self.parts[cache]);
                for line in l1.in_flight.iter().filter(|line| !self.lines[cache].contains(&line.line)) {
                    let begin = u64::from(base) + u64::from(line.line.0) * bytes;
                    let end = (begin + bytes).min(1 << 32);
                    let mut at = begin;
                    let mut count = 0;
                    while at < end {
                        let Some(part) = new.next() else {
                            return Err(format!("{line:?} lacks a part from {at} on"));
                        };
                        let last = at + part.bytes - 1;
                        let vm_line = self.config.cache.geometry.line().0;
                        let within = self.config.version == Version::None || at / vm_line == last / vm_line;
                        let longest = self.config.version != Version::None || last + 1 == end;
                        let right =
                            part.line == line.line && part.cache == cache && u64::from(part.addr.0) == at;
                        let full = last + 1 == end || (last + 1) % vm_line == 0;
                        demand!(
                            right && within && longest && full,
                            "{part:?} of {line:?} from {at} to {end}"
                        );
                        (at, count) = (last + 1, count + 1);
                    }
                    demand!(count == line.unread && at == end, "{count} parts of {line:?}");
                }
                demand!(new.next().is_none(), "cache {cache} asks for parts that it did not miss");
                self.parts[cache] = l1.parts.len();
            }
        }
        if phase == 8 {
            let first = self.last.map_or(0, |last| last + 1);
            let next = (first..first + 4).map(|cache| cache % 4).find(|&cache| self.parts[cache] > 0);
            for cache in 0..4 {
                let taken = self.parts[cache] - chip.first_level[cache].parts.len();
                let expected = usize::from(next == Some(cache));
                demand!(
                    taken == expected,
                    "{taken} parts of cache {cache} are taken, the turn is {next:?}'s"
                );
                self.parts[cache] -= taken;
            }
            self.last = next.or(self.last);
        }
        Ok(())
    }
}
