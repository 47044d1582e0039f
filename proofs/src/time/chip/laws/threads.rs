//! The law of the threads: what each asks for, in which order, and what it waits for (CH-7, CH-9).

use super::{Law, Verdict};
use saarcor_model::time::{Chip, ChipConfig, Operation, Program, Programs, State, TimingReport};
use saarcor_model::vm::{LineAddr, Unit};
use std::collections::VecDeque;

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
        let holds = |packet: &&'a Program| packet.as_ptr_range().contains(&program.as_ptr());
        match self.programs.packets.iter().find(holds) {
            Some(packet) => &packet[packet.len() - program.len()..],
            None => &[],
        }
    }
}
